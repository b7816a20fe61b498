"""Hidden tests of lesson 11. Students see the titles and hints but not the code.

Each test covers one property. Unless a test is about these things, points are centred, clusters
are aligned with the axes and labelled from 1 without gaps, and clouds have neither noise nor
intensities.
"""

import functools

import numpy as np

from extension import samples
from grader.judging.hidden_tests import cached_by_content, hidden
from utils.checks import CheckFailed
from utils.checks.assertions import frozen, precondition
from utils.checks.boxes import (
    LOOSE,
    as_cluster_boxes,
    assert_contains_points,
    assert_heights,
    assert_snug,
    assert_upright,
)
from utils.checks.lesson_11 import (
    assert_axes,
    assert_directions,
    assert_orthonormal,
    assert_right_handed,
    assert_sorted_by_spread,
    require_directions,
    require_straight_boxes,
)

# ---- oracles ----


def axes_by_svd(points):
    """Compute the right axes, in columns, as singular vectors of the points."""
    xyz = np.asarray(points, dtype=float)[:, :3]
    return np.linalg.svd(xyz - xyz.mean(axis=0), full_matrices=False)[2].T


@cached_by_content
def smallest_area(points):
    """Return the area of the smallest rectangle around points, seen from above."""
    angles = np.radians(np.arange(0, 90, 0.5))
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    across = np.column_stack([-np.sin(angles), np.cos(angles)])
    xy = np.asarray(points, dtype=float)[:, :2].T
    return (np.ptp(along @ xy, axis=1) * np.ptp(across @ xy, axis=1)).min()


def area_along(points, direction):
    """Return the area of the rectangle around points along a direction, seen from above."""
    along = np.asarray(direction)[:2] / np.linalg.norm(direction[:2])
    turned = points[:, :2] @ np.array([along, [-along[1], along[0]]]).T
    return float(np.prod(np.ptp(turned, axis=0)))


# ---- clusters ----


def random_rotation(rng):
    """Return a random rotation matrix, using the QR decomposition of a random matrix."""
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix[:, 2] *= np.sign(np.linalg.det(matrix))
    return matrix


def random_block(rng, sides, n=400):
    """Return `n` random points in a block around the origin, with sides of the given lengths."""
    return rng.uniform(-0.5, 0.5, (n, 3)) * sides


def turn_about_z(points, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = points.copy()
    turned[:, 0] = cosine * points[:, 0] - sine * points[:, 1]
    turned[:, 1] = sine * points[:, 0] + cosine * points[:, 1]
    return turned


@functools.lru_cache(maxsize=64)
def scanned_cars(seed):
    """Return clusters (n, 4) of scanned vehicles, each turned to be as diagonal as possible.

    If a scanner sees two sides of a vehicle, sensible methods give different boxes. Principal axes
    lean towards the corner, but the smallest rectangle does not. The function keeps only clusters
    for which the areas of such boxes agree well within `LOOSE`, while a box along x and y is far
    too large.
    """
    from scipy.spatial import ConvexHull

    from utils.scenes import random_street

    frame = random_street(seed)
    cars = []
    for box in frame.boxes:
        if box.kind not in ("car", "truck") or box.returns < 150:
            continue
        rows = np.flatnonzero(frame.scan.objects == box.identity)
        points = frame.cloud[rows[:: max(1, len(rows) // 250)]]
        points = points[points[:, 2] > box.centre[2] - box.size[2] / 2 + 0.3]
        if len(points) < 80:
            continue
        middle = points[:, :2].mean(axis=0)
        small = smallest_area(points)
        xy = points[:, :2] - middle
        flat = np.linalg.svd(xy, full_matrices=False)[2][0]
        solid = axes_by_svd(points)[:, 0]
        thinned = np.unique(np.floor(xy / 0.2), axis=0)
        even = np.linalg.svd(thinned - thinned.mean(axis=0), full_matrices=False)[2][0]
        hull = xy[ConvexHull(xy).vertices]
        rim = np.linalg.svd(hull - hull.mean(axis=0), full_matrices=False)[2][0]
        if max(area_along(points, d) for d in (flat, solid, even, rim)) > 0.93 * LOOSE * small:
            continue
        turned = [
            turn_about_z(points - [*middle, 0, 0], np.radians(angle)) + [*middle, 0, 0]
            for angle in range(0, 180, 5)
        ]
        loosest = max(turned, key=lambda cluster: np.prod(np.ptp(cluster[:, :2], axis=0)))
        if np.prod(np.ptp(loosest[:, :2], axis=0)) > 1.15 * LOOSE * small:
            cars.append(loosest)
    return tuple(cars)


def blocks_along_the_street(rng, headings, n=200):
    """Return the cloud and labels of blocks the size of a car, with headings in degrees."""
    clusters = [
        turn_about_z(random_block(rng, [4.4, 1.8, 1.5], n), np.radians(heading))
        + [10.0 * row - 20, rng.uniform(-6, 6), -0.7]
        for row, heading in enumerate(headings)
    ]
    return np.vstack(clusters), np.repeat(np.arange(1, len(headings) + 1), n)


def straight_blocks(rng, count=4):
    """Return the cloud and labels of symmetric blocks, whose axes are exactly along x and y."""
    half, labels = blocks_along_the_street(rng, [0.0] * count, 60)
    mirrored = half.copy()
    for label in range(1, count + 1):
        points = half[labels == label]
        mirrored[labels == label, 1] = points[:, 1].min() + points[:, 1].max() - points[:, 1]
    return np.vstack([half, mirrored]), np.tile(labels, 2)


def centre(points):
    return points[:, :3] - points[:, :3].mean(axis=0)


def blocks_in_space(rng, count=6):
    """Yield centred blocks, each with a random rotation in space."""
    for _ in range(count):
        yield centre(random_block(rng, [4.4, 1.8, 0.7]) @ random_rotation(rng).T)


# ---- principal_axes ----


def require_axes(student, points):
    """Raise `NotYet` unless the answer's axes of centred points are right."""
    with precondition("the axes of randomly rotated blocks are right"):
        assert_directions(student.principal_axes(points.copy()), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=4,
    title="Finds the axes of randomly rotated blocks",
    hint="Centre the points, compute their covariance matrix, and take its eigenvectors.",
)
def test_random_rotations(student, seed):
    for points in blocks_in_space(np.random.default_rng(seed), 8):
        assert_directions(student.principal_axes(points.copy()), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=7,
    title="Sorts the axes of rotated blocks from the largest spread to the smallest",
    hint="Return the eigenvector of the largest variance as the first column.",
)
def test_order(student, seed):
    require_directions(student.principal_axes)
    for points in blocks_in_space(np.random.default_rng(seed)):
        require_axes(student, points)
        assert_sorted_by_spread(student.principal_axes(points.copy()), points)


@hidden(
    "principal_axes",
    weight=10,
    title="Returns right-handed axes for rotated blocks",
    hint="If np.linalg.det(axes) is negative, flip the sign of one column.",
)
def test_handedness(student, seed):
    require_directions(student.principal_axes)
    for points in blocks_in_space(np.random.default_rng(seed), 12):
        assert_right_handed(student.principal_axes(points.copy()))


@hidden(
    "principal_axes",
    weight=26,
    title="Returns the right axes for scanned vehicles, whose points have intensities",
    hint="Centre the first three columns, return the eigenvectors as columns, and put the largest "
    "spread first.",
)
def test_axes_of_scanned_vehicles(student, seed):
    checked = 0
    for car in scanned_cars(seed) + scanned_cars(seed + 1):
        points = car[:, :3]
        spread = np.linalg.svd(centre(points), compute_uv=False)
        if (spread[1:] > 0.85 * spread[:-1]).any() or checked == 6:
            continue  # with nearly equal spreads, the order of two axes is uncertain
        checked += 1
        assert_axes(student.principal_axes(car.copy()), axes_by_svd(points))
    points = next(blocks_in_space(np.random.default_rng(seed))) + [9.0, -5.0, 2.0]
    assert_axes(student.principal_axes(points.copy()), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=7,
    title="Returns the right axes for blocks in places you have not seen",
    hint="Subtract points.mean(axis=0), the mean over the rows, from the points.",
)
def test_position(student, seed):
    rng = np.random.default_rng(seed)
    for points in blocks_in_space(rng):
        require_axes(student, points)
        away = points + rng.uniform(10, 20, 3) * rng.choice([-1, 1], 3)
        assert_directions(student.principal_axes(away), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=2,
    title="Does not depend on the order of the points or the size of the cluster",
    hint="Do not assume a certain order of the points or a certain length of the cluster.",
)
def test_order_and_size(student, seed):
    rng = np.random.default_rng(seed)
    points = next(blocks_in_space(rng))
    right = axes_by_svd(points)
    require_axes(student, points)
    for variant in (rng.permutation(points), 1000 * points, 0.01 * points):
        answer = student.principal_axes(variant.copy())
        assert_directions(answer, right)
        assert_orthonormal(answer)


@hidden(
    "principal_axes",
    weight=2,
    title="Works on a few points, on points on a line and on points on a plane",
    hint="Compute q.T @ q, which is 3 x 3 for any number of centred points q. The results of "
    "np.cov and of the SVD with full_matrices=False may have another shape or contain NaN.",
)
def test_few_points(student, seed):
    require_directions(student.principal_axes)
    rng = np.random.default_rng(seed)
    turn = random_rotation(rng)
    triangle = centre(np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 1.0, 0.0]]) @ turn.T)
    assert_directions(student.principal_axes(triangle.copy()), axes_by_svd(triangle)[:, :2])
    line = centre(np.outer(rng.uniform(-2, 2, 30), turn[:, 0]))
    for points in (line, centre(line[:2])):
        assert_directions(student.principal_axes(points.copy()), turn[:, :1])
    for points in (triangle, line, line[:2], line[:1], np.repeat(line[:1], 4, axis=0), line[:0]):
        assert_orthonormal(student.principal_axes(points.copy()))
    away = rng.uniform(3, 9, 3) * [-1, 1, -1]
    try:
        assert_directions(student.principal_axes(triangle + away), axes_by_svd(triangle)[:, :2])
    except CheckFailed:
        return  # another test covers answers that do not centre the points
    assert_directions(student.principal_axes(centre(line[:2]) + away), turn[:, :1])


@hidden(
    "principal_axes",
    weight=2,
    title="Ignores large and negative intensities",
    hint="Use only the coordinates, the first three columns.",
)
def test_points_with_intensity(student, seed):
    rng = np.random.default_rng(seed)
    points = next(blocks_in_space(rng))
    require_axes(student, points)
    bright = np.column_stack([points, rng.uniform(-50, 50, len(points))])
    assert_directions(student.principal_axes(bright), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=1,
    title="Works on float32 arrays",
    hint="Do not test for a type, because the same code works for every type of number.",
)
def test_array_types_of_points(student, seed):
    points = next(blocks_in_space(np.random.default_rng(seed)))
    right = axes_by_svd(points)
    require_axes(student, points)
    assert_directions(student.principal_axes(points.astype(np.float32)), right)


# ---- get_oriented_boxes ----


@hidden(
    "get_oriented_boxes",
    weight=16,
    title="Fits boxes tightly around blocks at any heading",
    hint="Call turned(points, -yaw) for the points and turned(corners, yaw) for the corners, with "
    "the yaw in radians.",
)
def test_any_heading(student, seed):
    rng = np.random.default_rng(seed)
    for first in (12, 27):
        cloud, labels = blocks_along_the_street(rng, np.arange(first, 180, 34) + rng.uniform(0, 6))
        areas = [smallest_area(cloud[labels == label]) for label in range(1, labels.max() + 1)]
        assert_contained_and_tight(student, cloud, labels, areas)


def assert_contained_and_tight(student, cloud, labels, areas):
    """Compare the answer's boxes with the points, seen from above, and return the boxes."""
    answer = student.get_oriented_boxes(cloud.copy(), labels.copy())
    assert_contains_points(answer, cloud, labels)
    assert_snug(answer, cloud, labels, areas)
    return answer


@hidden(
    "get_oriented_boxes",
    weight=8,
    title="Fits boxes tightly around scanned vehicles at an angle to the x axis",
    hint="Turn the points by minus yaw, and take their minimum and maximum. The points of a real "
    "car are not spread evenly around its centre.",
)
def test_scanned_vehicles(student, seed):
    cars = [car[:, :3] for step in range(3) for car in scanned_cars(seed + step)][:6]
    # At 20°, unlike at 45°, a heading with the wrong sign gives a clearly different box.
    cars.append(turn_about_z(random_block(np.random.default_rng(seed), [4.4, 1.8, 1.5]), 0.35))
    labels = np.repeat(np.arange(1, len(cars) + 1), [len(car) for car in cars])
    areas = [smallest_area(car) for car in cars]
    assert_contained_and_tight(student, np.vstack(cars), labels, areas)


@hidden(
    "get_oriented_boxes",
    weight=8,
    title="Fits boxes tightly around objects that are taller than they are long",
    hint="Compute the yaw from x and y alone, because the longest direction in space may be "
    "vertical.",
)
def test_tall_objects(student, seed):
    rng = np.random.default_rng(seed)
    clusters, areas = [], []
    for row, heading in enumerate(np.arange(5, 180, 30) + rng.uniform(0, 8)):
        sides = [rng.uniform(0.6, 1.5), rng.uniform(0.15, 0.25), rng.uniform(2.5, 3.5)]
        upright = np.array(list(np.ndindex(4, 4, 4))) / 3 - 0.5
        leaning = upright * sides
        # The lean is not along the heading, and too small to change the heading seen from above.
        leaning[:, :2] += 0.02 * leaning[:, 2:] * rng.choice([-1, 1], 2)
        points = turn_about_z(leaning, np.radians(heading))
        clusters.append(points + [4.0 * row - 10, rng.uniform(-6, 6), 0.3])
        areas.append(smallest_area(points))
    cloud = np.vstack(clusters)
    labels = np.repeat(np.arange(1, len(clusters) + 1), 64)
    assert_heights(assert_contained_and_tight(student, cloud, labels, areas), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=5,
    title="Returns boxes that contain every point of the clusters on a new street",
    hint="Take the minimum and maximum of all points of a cluster, even if a pole or a hedge has "
    "no clear heading.",
)
def test_fresh_street(student, seed):
    cloud, labels = street_clusters(seed)
    car, label = blocks_along_the_street(np.random.default_rng(seed), [25.0])
    cloud = np.vstack([cloud, car + [0.0, 0.0, 30.0]])
    labels = np.concatenate([labels, label + labels.max()])
    # Sensible methods agree on the size of the box only for the block, so only its area is checked.
    areas = [np.inf] * (labels.max() - 1) + [smallest_area(car)]
    assert_heights(assert_contained_and_tight(student, cloud, labels, areas), cloud, labels)


@functools.lru_cache(maxsize=64)
def street_clusters(seed):
    """Return obstacle points (n, 3) of a street, sorted by label, and their labels from 1."""
    cloud = samples.obstacles_of_street(seed, 1500)[:, :3]
    labels = samples.cluster_labels(cloud, 0.8)
    kept = np.flatnonzero(np.bincount(labels)[labels] >= 4)
    _, labels = np.unique(labels[kept], return_inverse=True)
    order = np.argsort(labels, kind="stable")
    return frozen((cloud[kept][order], labels[order] + 1))


@hidden(
    "get_oriented_boxes",
    weight=2,
    title="Returns upright boxes that extend from the lowest to the highest point",
    hint="Turn about z only. The floor is at the smallest z and the roof at the largest.",
)
def test_upright(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    cloud, labels = street_clusters(seed)
    answer = student.get_oriented_boxes(cloud.copy(), labels.copy())
    assert_upright(answer, cloud, labels)
    assert_heights(answer, cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=2,
    title="Works on round clusters and on clusters of a few points",
    hint="Put all points inside the box. For a round cluster, any heading is right.",
)
def test_round_and_few(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    rng = np.random.default_rng(seed)
    place = rng.uniform(-9, 9, 3)
    ring = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    clusters = [
        place + np.column_stack([np.cos(ring), np.sin(ring), 0 * ring]),
        place[None],
        np.repeat(place[None], 5, axis=0),
        place + np.outer(np.linspace(0, 3, 9), [0.0, 0.0, 1.0]),
        place + np.outer(np.linspace(0, 3, 9), [0.0, 1.0, 0.0]),
    ]
    labels = np.repeat(np.arange(len(clusters)) + 1, [len(points) for points in clusters])
    cloud = np.vstack(clusters)
    assert_contains_points(student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Works when labels have large gaps",
    hint="Loop over np.unique(cluster_labels[cluster_labels > 0]), and return one box for each "
    "label.",
)
def test_gaps_in_labels(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    cloud, labels = straight_blocks(np.random.default_rng(seed))
    labels = np.array([0, 7, 40, 41, 400])[labels]
    assert_contains_points(student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Sorts the boxes by label, whichever label comes first in the cloud",
    hint="Return the boxes in ascending order of their labels, not in the order in which the "
    "labels first occur.",
)
def test_order_of_labels(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    rng = np.random.default_rng(seed)
    cloud, labels = straight_blocks(rng)
    labels = np.append(0, np.roll(np.arange(1, 5), rng.integers(1, 4)))[labels]
    assert_contains_points(student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=7,
    title="Ignores many noise points, even if they contain NaN",
    hint="Use only rows with a label above 0. All other rows may contain NaN.",
)
def test_noise(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    rng = np.random.default_rng(seed)
    cloud, labels = straight_blocks(rng)
    noise = rng.uniform(-30, 30, (40, 3))
    noise[::7, 0] = np.nan
    cloud, labels = np.vstack([noise[:20], cloud, noise[20:]]), np.pad(labels, 20)
    assert_contains_points(student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Ignores large and negative intensities",
    hint="Use only the coordinates, the first three columns.",
)
def test_intensity(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    rng = np.random.default_rng(seed)
    cloud, labels = straight_blocks(rng)
    bright = np.column_stack([cloud, rng.uniform(-50, 50, len(cloud))])
    assert_contains_points(student.get_oriented_boxes(bright.copy(), labels.copy()), bright, labels)


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Works on float32 arrays",
    hint="Do not test for a type, because the same code works for every type of number.",
)
def test_array_types(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    cloud, labels = straight_blocks(np.random.default_rng(seed))
    cloud = cloud.astype(np.float32)
    boxes = student.get_oriented_boxes(cloud.copy(), labels.copy())
    assert_contains_points(boxes, cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Works with many clusters",
    hint="Return one box for each label, however many labels there are.",
)
def test_many_clusters(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    cloud, labels = straight_blocks(np.random.default_rng(seed), 40)
    assert_contains_points(student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels)


@hidden(
    "get_oriented_boxes",
    weight=2,
    title="Returns an empty array if there are no clusters",
    hint="If there are no clusters, return np.empty((0, 8, 3)).",
)
def test_no_clusters(student, seed):
    require_straight_boxes(student.get_oriented_boxes)
    cloud = np.random.default_rng(seed).uniform(-30, 30, (300, 3))
    none = np.zeros(len(cloud), dtype=int)
    as_cluster_boxes(student.get_oriented_boxes(cloud.copy(), none.copy()), none)
