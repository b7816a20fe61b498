"""The scanner agrees with exact formulas, with marching along rays, and with statistics."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from utils.simulator import (
    CLASSES,
    Sensor,
    hdl64,
    highway_sensor,
    layers,
    ray_directions,
    scan,
    scanner,
    vlp16,
)
from utils.simulator.ground import Ground
from utils.simulator.pose import Pose
from utils.simulator.shapes import Material, box, cylinder, sphere
from utils.simulator.world import Obstacle, World

EXACT = Sensor(
    elevations=layers(24, 10.0, -25.0),
    azimuth_step=math.radians(1.0),
    range_noise=0.0,
    minimum_range=0.1,
)


ORIGIN = Pose()


def obstacle(*solids, kind="car", identity=1, pose=ORIGIN, speed=0.0, turn_rate=0.0):
    return Obstacle(kind, (1.0, 1.0, 1.0), solids, pose, identity, speed, turn_rate)


def random_solids(rng, count):
    """Return random boxes, frusta, cylinders and balls around the sensor, near and far."""
    solids = []
    for _ in range(count):
        centre = (*rng.uniform(-15, 15, 2), rng.uniform(-1, 3))
        length, width, height = rng.uniform(0.2, 5, 3)
        kind = rng.integers(4)
        if kind == 0:
            solid = box(length, width, height, centre)
        elif kind == 1:
            solid = box(length, width, height, centre, taper=(length / 3, length / 5, width / 4))
        elif kind == 2:
            solid = cylinder(width / 2, height, centre)
        else:
            solid = sphere(height / 2, centre)
        solids.append(solid.moved(Pose(0.0, 0.0, 0.0, rng.uniform(-4, 4))))
    return solids


def contains(solid, points):
    """Return whether each point (..., 3) is inside a solid, according to the solid's definition."""
    if hasattr(solid, "normals"):
        return np.all(points @ solid.normals.T <= solid.offsets, axis=-1)
    if hasattr(solid, "base"):
        aside = np.hypot(points[..., 0] - solid.base[0], points[..., 1] - solid.base[1])
        above = points[..., 2] - solid.base[2]
        return (aside <= solid.radius) & (above >= 0) & (above <= solid.height)
    return np.linalg.norm(points - solid.centre, axis=-1) <= solid.radius


# ---- solids --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_the_entry_of_a_ray_into_a_solid_agrees_with_marching(seed):
    rng = np.random.default_rng(seed)
    (solid,) = random_solids(rng, 1)
    aims = rng.normal(size=(150, 3)) * 2
    aims[:100] = rng.uniform(-1, 1, (100, 3)) + np.mean(sample_points(solid), axis=0)
    rays = (aims / np.linalg.norm(aims, axis=1, keepdims=True)).T
    step = 0.004
    steps = np.arange(0, 30, step)
    inside = contains(solid, rays.T[:, None] * steps[None, :, None])
    enter, leave, cosine = solid.crossings(rays)
    hit = (leave >= enter) & (leave > 0)
    # Marching may miss a part thinner than a step, but it never reports a hit in empty space.
    assert not np.any(inside.any(axis=1) & ~hit)
    assert np.all((leave - np.maximum(enter, 0))[hit & ~inside.any(axis=1)] <= step + 1e-9)
    outside = inside.any(axis=1) & (enter > 0)
    assert outside.sum() > 5 or enter[hit].max(initial=-1) <= 0
    assert_allclose(enter[outside], steps[inside.argmax(axis=1)][outside], atol=step + 1e-9)
    assert np.all((cosine[outside] >= 0) & (cosine[outside] <= 1 + 1e-12))


def sample_points(solid):
    if hasattr(solid, "corners"):
        return solid.corners
    if hasattr(solid, "base"):
        return solid.base[None] + (0, 0, solid.height / 2)
    return solid.centre[None]


def test_a_ray_hits_a_wall_straight_ahead_at_its_distance():
    wall = box(1.0, 20.0, 20.0, (10.5, 0.0, 0.0))
    slant = math.radians(30)
    rays = np.array([[1.0, 0.0, 0.0], [math.cos(slant), math.sin(slant), 0.0]]).T
    enter, _, cosine = wall.crossings(rays)
    assert_allclose(enter, [10.0, 10.0 / math.cos(slant)])
    assert_allclose(cosine, [1.0, math.cos(slant)])


def test_hits_on_a_ball_and_a_post_agree_with_geometry():
    ray = np.array([[1.0], [0.0], [0.0]])
    enter, leave, cosine = sphere(2.0, (10.0, 1.0, 0.0)).crossings(ray)
    assert_allclose([enter[0], leave[0]], [10 - math.sqrt(3), 10 + math.sqrt(3)])
    assert_allclose(cosine, math.sqrt(3) / 2)
    enter, _, cosine = cylinder(2.0, 4.0, (10.0, 1.0, -2.0)).crossings(ray)
    assert_allclose([enter[0], cosine[0]], [10 - math.sqrt(3), math.sqrt(3) / 2])


def test_a_ray_from_above_hits_the_lid_of_a_post():
    ray = np.array([[math.sqrt(0.5)], [0.0], [-math.sqrt(0.5)]])
    enter, _, cosine = cylinder(1.0, 1.0, (3.0, 0.0, -4.0)).crossings(ray)
    assert_allclose([enter[0], cosine[0]], [3 * math.sqrt(2), math.sqrt(0.5)])


@pytest.mark.parametrize(
    "solid",
    [
        box(2, 2, 2, (5, 0, 2)),
        cylinder(1, 2, (5, 0, 1)),
        box(2, 2, 2, (5, 3, 0)),
    ],
)
def test_a_ray_parallel_to_a_face_and_outside_misses(solid):
    for ray in ([1.0, 0.0, 0.0], [1.0, -0.0, -0.0]):
        enter, leave, _ = solid.crossings(np.array(ray).reshape(3, 1))
        assert enter[0] > leave[0]


def test_poses_can_be_inverted_and_composed():
    pose, points = Pose(1.0, -2.0, 3.0, 0.7), np.random.default_rng(1).normal(size=(5, 3))
    assert_allclose(pose.inverse().apply(pose.apply(points)), points)
    other = Pose(-4.0, 0.5, 1.0, 2.5)
    assert_allclose(pose.then(other).apply(points), pose.apply(other.apply(points)))


# ---- ground --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_rays_hit_the_ground_where_they_first_go_below_it(seed):
    rng = np.random.default_rng(seed)
    ground = Ground(
        Pose(*rng.uniform(-3, 3, 2), 0.0, rng.uniform(-4, 4)),
        slope=rng.uniform(-0.05, 0.05),
        width=rng.uniform(6, 12),
        crown=rng.uniform(0, 0.04),
        kerb=rng.uniform(0, 0.2),
        pavement_slope=rng.uniform(0, 0.03),
    )
    height = float(ground.height(0, 0)) + 1.7
    rays = ray_directions(EXACT)[:, 8:, ::15].reshape(3, -1)
    step = 0.01
    steps = np.arange(0, 25, step)
    points = rays.T[:, None] * steps[None, :, None] + (0, 0, height)
    below = points[..., 2] <= ground.height(points[..., 0], points[..., 1])
    distance, cosine = ground.crossings(rays, (0.0, 0.0, height))
    dives = below.any(axis=1)
    assert dives.sum() > 50
    assert np.all(distance[~dives] > 24.9)
    assert_allclose(distance[dives], steps[below.argmax(axis=1)][dives], atol=step + 1e-9)
    assert np.all((cosine >= 0) & (cosine <= 1))


def test_the_distance_of_flat_ground_is_height_over_sine():
    rays = ray_directions(EXACT)
    distance, cosine = Ground().crossings(rays, (0.0, 0.0, 1.7))
    down = rays[2] < 0
    assert_allclose(distance[down], 1.7 / -rays[2][down])
    assert_allclose(cosine[down], -rays[2][down])
    assert np.all(np.isinf(distance[~down]))


def test_the_ground_under_a_vehicle_has_height_zero():
    ground = Ground(
        Pose(1, 2, 3, 0.4), slope=0.03, width=8, crown=0.02, kerb=0.1, pavement_slope=0.01
    )
    vehicle = Pose(5.0, 1.0, 0.0, -0.8)
    seen = ground.seen_from(vehicle)
    assert_allclose(seen.height(0.0, 0.0), 0.0, atol=1e-12)
    points = np.random.default_rng(0).uniform(-20, 20, (50, 3))
    outer = vehicle.apply(points)
    rise = ground.height(outer[:, 0], outer[:, 1]) - ground.height(vehicle.x, vehicle.y)
    assert_allclose(seen.height(points[:, 0], points[:, 1]), rise, atol=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 0.4])
def test_brightness_of_a_kerb_depends_on_the_angle_of_the_ray(yaw):
    road = Ground(pose=Pose(0.0, 0.0, 0.0, yaw), width=7.0, kerb=0.5)
    normal = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    target = 3.5 * normal + 6.0 * along + [0.0, 0.0, 0.25]  # halfway up the kerb's face
    eye = np.array([0.0, 0.0, 1.7])
    ray = (target - eye) / np.linalg.norm(target - eye)
    distance, cosine = road.crossings(ray[:, None], tuple(eye))
    assert distance[0] == pytest.approx(np.linalg.norm(target - eye))
    assert cosine[0] == pytest.approx(abs(ray @ normal))


# ---- the scan ------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_trying_only_the_rays_that_may_hit_changes_nothing(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    obstacles = tuple(
        obstacle(solid, identity=i) for i, solid in enumerate(random_solids(rng, 25), start=1)
    )
    world = World(Ground(slope=0.02), obstacles)
    quick = scan(world, EXACT, seed)
    whole = (slice(None), slice(None))
    monkeypatch.setattr(scanner, "_blocks", lambda solid, sensor: [whole])
    slow = scan(world, EXACT, seed)
    assert len(np.unique(quick.objects)) > 8
    for name in ("cloud", "classes", "objects", "beams", "times"):
        assert_array_equal(getattr(quick, name), getattr(slow, name))


def test_the_nearest_of_two_walls_is_seen():
    far = obstacle(box(1, 40, 6, (12.5, 0, 3)), kind="wall", identity=7)
    near = obstacle(box(1, 2, 6, (6.5, 0, 3)), kind="truck", identity=9)
    for order in ((far, near), (near, far)):
        swept = scan(World(Ground(), order), EXACT, 0)
        x, y = swept.cloud[swept.objects == 9, :2].T
        assert_allclose(x, 6.0, atol=2e-6)
        assert np.all(np.abs(y) <= 1.0 + 1e-6)
        shadow = np.abs(swept.cloud[:, 1]) < (1 / 7 - 1e-6) * swept.cloud[:, 0]
        shadow &= (swept.cloud[:, 0] > 7) & (swept.cloud[:, 2] > -1.7)
        assert not shadow.any()
        assert_allclose(swept.cloud[swept.objects == 7, 0], 12.0, atol=2e-6)


def test_every_return_of_an_exact_scan_is_on_its_ray_and_a_surface():
    world = World(Ground(), (obstacle(box(4, 2, 2, (8, 1, 1))),))
    swept = scan(world, EXACT, 0)
    rays = ray_directions(EXACT)
    firings = np.rint(swept.times * EXACT.rotation_rate * EXACT.firings).astype(int)
    ranges = np.linalg.norm(swept.cloud[:, :3], axis=1)
    along = rays[:, swept.beams, firings].T * ranges[:, None]
    assert_allclose(swept.cloud[:, :3], along, atol=2e-6)
    ground = swept.classes == CLASSES.index("ground")
    assert_allclose(swept.cloud[ground, 2], -1.73, atol=2e-6)
    assert_array_equal(swept.objects[ground], 0)
    keys = swept.beams.astype(int) * EXACT.firings + firings
    assert np.all(np.diff(keys) > 0), "beam by beam, in the order of azimuths"
    assert swept.times.min() >= 0 and swept.times.max() < 1 / EXACT.rotation_rate


def test_a_scan_without_ground_and_obstacles_in_range_is_empty():
    sensor = replace(EXACT, elevations=(0.1, 0.2))
    swept = scan(World(), sensor, 0)
    assert swept.cloud.shape == (0, 4)
    assert len(swept.classes) == len(swept.objects) == len(swept.beams) == len(swept.times) == 0


@pytest.mark.parametrize("elevation", [0.0, -0.1])
def test_a_sensor_may_have_a_single_beam_and_firing(elevation):
    sensor = replace(EXACT, elevations=(elevation,), azimuth_step=2 * math.pi)
    swept = scan(World(Ground(), (obstacle(box(1, 4, 4, (5.5, 0, 2))),)), sensor, 0)
    assert swept.objects.tolist() == [1]
    assert_allclose(swept.cloud[0, :3], [5.0, 0.0, 5 * math.tan(elevation)], atol=1e-6)


def test_an_obstacle_around_the_sensor_is_not_seen_from_inside():
    solids = (box(6, 6, 6), sphere(5, (0, 0, 1.73)), cylinder(4, 9, (0, 0, -1)))
    swept = scan(World(Ground(), (obstacle(*solids),)), EXACT, 0)
    assert not swept.objects.any()
    assert len(swept.cloud) > 1000


def test_an_object_below_the_minimum_range_hides_others_and_is_not_reported():
    sensor = replace(EXACT, minimum_range=3.0)
    world = World(
        Ground(),
        (
            obstacle(box(0.1, 9, 9, (2.0, 0, 0)), identity=1),
            obstacle(box(0.1, 9, 9, (8.0, 0, 0)), identity=2),
        ),
    )
    swept = scan(world, sensor, 0)
    ahead = np.abs(swept.cloud[:, 1]) < 0.2 * swept.cloud[:, 0]
    assert not ahead.any()


def test_nothing_is_reported_beyond_the_maximum_range():
    swept = scan(World(), replace(EXACT, maximum_range=20.0), 0)
    ranges = np.linalg.norm(swept.cloud[:, :3], axis=1)
    assert 18 < ranges.max() <= 20.0


def test_range_noise_is_gaussian_along_the_ray():
    noisy = replace(EXACT, range_noise=0.03)
    exact, measured = scan(World(), EXACT, 5), scan(World(), noisy, 5)
    errors = measured.cloud[:, :3] - exact.cloud[:, :3]
    rays = exact.cloud[:, :3] / np.linalg.norm(exact.cloud[:, :3], axis=1, keepdims=True)
    along = np.sum(errors * rays, axis=1)
    assert np.linalg.norm(errors - along[:, None] * rays, axis=1).max() < 1e-5
    assert abs(along.mean()) < 0.002
    assert abs(along.std() - 0.03) < 0.001
    assert abs(np.mean(np.abs(along) < 0.03) - 0.683) < 0.02


def test_the_stated_share_of_echoes_is_lost():
    whole = len(scan(World(), EXACT, 1).cloud)
    share = len(scan(World(), replace(EXACT, dropout=0.3), 1).cloud) / whole
    assert abs(share - 0.7) < 0.02


def share_seen(distance, material, weakest_signal):
    """Return the share of rays that a wall perpendicular to the beam returns."""
    sensor = replace(EXACT, azimuth_step=math.radians(0.2), elevations=layers(40, 1.0, -1.0))

    def returns(material, weakest_signal):
        wall = obstacle(box(1, 8, 4, (distance + 0.5, 0, 2), material), kind="wall")
        tuned = replace(sensor, weakest_signal=weakest_signal)
        return np.count_nonzero(scan(World(Ground(), (wall,)), tuned, 0).objects)

    return returns(material, weakest_signal) / returns(Material(), 0.0)


def test_glass_loses_the_stated_share_of_echoes():
    assert abs(share_seen(10, Material(0.4, loss=0.6), 0.0) - 0.4) < 0.05


def test_weak_echoes_are_lost():
    # A wall of reflectivity 0.4 returns a signal of 1.6 from 50 m, if perpendicular to the beam.
    assert abs(share_seen(50, Material(0.4), 1.6) - (1 - math.exp(-1))) < 0.05
    dark, far, near = (
        share_seen(distance, Material(reflectivity), 1.6)
        for distance, reflectivity in ((50, 0.1), (50, 0.4), (20, 0.4))
    )
    assert dark < far < near


def test_the_road_fades_at_grazing_incidence():
    lossless = replace(hdl64(), dropout=0.0, weakest_signal=0.0)
    fading = replace(lossless, weakest_signal=hdl64().weakest_signal)
    bins = [0, 20, 60, 80]
    seen, there = (
        np.histogram(np.hypot(*scan(World(), sensor, 0).cloud.T[:2]), bins)[0]
        for sensor in (fading, lossless)
    )
    assert seen[0] > 0.999 * there[0]
    assert seen[2] < 0.4 * there[2]


def test_rays_end_inside_foliage_at_random_depths_or_pass():
    bush = obstacle(box(2, 6, 6, (9, 0, 0), Material(0.3, depth=0.5)), kind="foliage", identity=1)
    wall = obstacle(box(1, 60, 60, (20.5, 0, 0)), kind="wall", identity=2)
    sensor = replace(EXACT, elevations=layers(60, 1.0, -1.0))
    swept = scan(World(Ground(), (bush, wall)), sensor, 0)
    aimed = np.abs(swept.cloud[:, 1]) < 0.25 * swept.cloud[:, 0]
    bushed, walled = aimed & (swept.objects == 1), aimed & (swept.objects == 2)
    depths = swept.cloud[bushed, 0] - 8
    assert depths.min() >= 0 and depths.max() <= 2
    through = walled.sum() / (walled.sum() + bushed.sum())
    assert abs(through - math.exp(-2 / 0.5)) < 0.01
    # The expected depth is the mean of a truncated exponential distribution.
    expected = 0.5 - 2 * math.exp(-4) / (1 - math.exp(-4))
    assert abs(depths.mean() - expected) < 0.03


def test_intensity_follows_material_and_incidence():
    def brightness(material, yaw):
        wall = obstacle(box(0.5, 6, 6, (0, 0, 0), material), pose=Pose(8, 0, 0, yaw))
        swept = scan(World(Ground(), (wall,)), EXACT, 0)
        return swept.cloud[swept.objects == 1, 3].mean()

    assert brightness(Material(0.8), 0.0) > 1.5 * brightness(Material(0.4), 0.0)
    assert brightness(Material(0.4), 1.0) < 0.9 * brightness(Material(0.4), 0.0)
    swept = scan(World(), EXACT, 0)
    assert swept.cloud[:, 3].min() >= 0 and swept.cloud[:, 3].max() <= 1


def test_invalid_returns_are_at_the_origin_and_belong_to_no_object():
    swept = scan(World(), hdl64(), 3)
    blank = swept.classes == CLASSES.index("invalid")
    assert blank.sum() == hdl64().invalid_returns
    assert_array_equal(swept.cloud[blank], 0.0)
    assert not swept.objects[blank].any()
    assert np.all(np.linalg.norm(swept.cloud[~blank, :3], axis=1) >= hdl64().minimum_range - 1e-5)


def test_equal_seeds_give_the_same_bytes_and_different_seeds_do_not():
    world = World(Ground(), (obstacle(box(4, 2, 2, (8, 1, 1))),))
    first, again, other = (scan(world, hdl64(), seed) for seed in (4, 4, 5))
    assert first.cloud.tobytes() == again.cloud.tobytes()
    assert first.cloud.tobytes() != other.cloud.tobytes()


def test_the_presets_are_the_published_sensors():
    highway, city = highway_sensor(), hdl64()
    assert len(highway.elevations) * highway.firings == 1024
    assert_allclose(np.degrees(highway.elevations[0]), -30)
    assert_allclose(np.degrees(np.diff(highway.elevations)), 3.25)
    assert highway.origin == (0.0, 0.0, 2.6)
    assert (highway.minimum_range, highway.maximum_range) == (5.0, 50.0)
    assert len(city.elevations) == 64 and city.firings == 2000
    assert_allclose(np.degrees([max(city.elevations), min(city.elevations)]), [2.0, -24.8])
    assert city.origin[2] == 1.73 and city.rotation_rate == 10.0
    small = vlp16()
    assert_allclose(np.degrees(small.elevations), range(-15, 16, 2))
    assert small.firings == 1800 and small.maximum_range == 100.0


def test_a_level_road_has_no_returns_below_the_lowest_beam():
    returns = scan(World(Ground()), replace(vlp16(), invalid_returns=0), 1).cloud
    distances = np.hypot(returns[:, 0], returns[:, 1])
    assert_allclose(distances.min(), 1.73 / math.tan(math.radians(15)), atol=0.15)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"elevations": ()}, "at least one beam"),
        ({"azimuth_step": 0.0}, "azimuth step"),
        ({"azimuth_step": math.nan}, "azimuth step"),
        ({"minimum_range": 90.0}, "minimum range"),
    ],
)
def test_a_sensor_without_rays_is_refused(change, words):
    with pytest.raises(ValueError, match=words):
        replace(EXACT, **change)


def test_an_obstacle_drives_along_a_circle():
    start = obstacle(pose=Pose(2.0, 3.0, 0.0, 0.5), speed=4.0, turn_rate=0.8)
    radius = 4.0 / 0.8
    centre = np.array([2.0 - radius * math.sin(0.5), 3.0 + radius * math.cos(0.5)])
    for time in (0.0, 0.3, 2.0, 5.0):
        pose = start.at(time).pose
        assert_allclose(np.hypot(*(np.array([pose.x, pose.y]) - centre)), radius)
        assert_allclose(pose.yaw, 0.5 + 0.8 * time)
    straight = obstacle(pose=Pose(0, 0, 0, math.pi / 2), speed=2.0).at(3.0).pose
    assert_allclose([straight.x, straight.y], [0, 6], atol=1e-12)


def test_a_world_seen_from_a_moving_vehicle_is_the_same_world():
    world = World(Ground(slope=0.03), (obstacle(pose=Pose(10, 2, 0, 1.0), speed=3.0),))
    vehicle = Pose(4.0, -1.0, 0.0, 0.6)
    seen = world.seen_from(vehicle, 2.0)
    moved = world.obstacles[0].at(2.0)
    base = seen.base(seen.obstacles[0])
    lift = Pose(vehicle.x, vehicle.y, float(world.ground.height(vehicle.x, vehicle.y)), 0.6)
    back = lift.then(base)
    expected = world.base(moved)
    assert_allclose(
        [back.x, back.y, back.z, back.yaw], [expected.x, expected.y, expected.z, expected.yaw]
    )
