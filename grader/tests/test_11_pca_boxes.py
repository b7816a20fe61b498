"""Hidden tests of lesson 11. Titles and hints are shown to students; the code is not."""

import functools

import numpy as np
import pytest

from grader.judging import samples
from grader.judging.marks import hidden, visible_checks
from utils.checks.boxes import LOOSE, as_cluster_boxes, assert_turned_boxes
from utils.checks.lesson_11 import as_axes, assert_axes
from utils.checks.vocabulary import CheckFailed


@visible_checks("principal_axes", "get_oriented_boxes")
def test_visible(student, check):
    check.run(getattr(student, check.exercise))


# ---- oracles ----


def axes_by_svd(points):
    """The right axes, in columns, by the singular vectors of the points themselves."""
    xyz = np.asarray(points, dtype=float)[:, :3]
    return np.linalg.svd(xyz - xyz.mean(axis=0), full_matrices=False)[2].T


def smallest_area(points):
    """Area of the smallest rectangle around points seen from above, trying every half degree."""
    angles = np.radians(np.arange(0, 90, 0.5))
    along = np.column_stack([np.cos(angles), np.sin(angles)])
    across = np.column_stack([-np.sin(angles), np.cos(angles)])
    xy = np.asarray(points, dtype=float)[:, :2].T
    return float((np.ptp(along @ xy, axis=1) * np.ptp(across @ xy, axis=1)).min())


def area_along(points, direction):
    """Area of the rectangle around points seen from above, one side along a direction."""
    along = np.asarray(direction)[:2] / np.linalg.norm(direction[:2])
    turned = points[:, :2] @ np.array([along, [-along[1], along[0]]]).T
    return float(np.prod(np.ptp(turned, axis=0)))


# ---- clusters ----


def turn_in_space(rng):
    """A random rotation matrix, by the QR decomposition of a random matrix."""
    matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    matrix[:, 2] *= np.sign(np.linalg.det(matrix))
    return matrix


def block(rng, sides, n=400):
    """n random points of a solid block around the origin; its sides differ clearly."""
    return rng.uniform(-0.5, 0.5, (n, 3)) * sides


def turn_about_z(points, angle):
    cosine, sine = np.cos(angle), np.sin(angle)
    turned = points.copy()
    turned[:, 0] = cosine * points[:, 0] - sine * points[:, 1]
    turned[:, 1] = sine * points[:, 0] + cosine * points[:, 1]
    return turned


@functools.lru_cache(maxsize=64)
def scanned_cars(seed):
    """Clusters (n, 4) of vehicles as a scanner sees them, each turned as diagonally as it gets.

    Where a scanner sees two sides, sensible boxes differ: principal axes lean towards the
    corner, the smallest rectangle does not. Kept are clusters on which such methods agree well
    within `LOOSE`, while a box along x and y is far beyond it.
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
        loosest = max(turned, key=lambda one: np.prod(np.ptp(one[:, :2], axis=0)))
        if np.prod(np.ptp(loosest[:, :2], axis=0)) > 1.15 * LOOSE * small:
            cars.append(loosest)
    return tuple(cars)


def diagonal_blocks(rng, headings, n=300):
    """Solid blocks of car size along a street, each with its own heading; (cloud, labels)."""
    clusters = [
        turn_about_z(block(rng, [4.4, 1.8, 1.5], n), np.radians(heading))
        + [10.0 * row - 20, rng.uniform(-6, 6), -0.7]
        for row, heading in enumerate(headings)
    ]
    return np.vstack(clusters), np.repeat(np.arange(1, len(headings) + 1), n)


# ---- principal_axes ----


@hidden(
    "principal_axes",
    weight=4,
    title="Right for blocks turned in any way in space",
    hint="Centre, covariance, eigenvectors by decreasing variance, determinant.",
)
def test_any_turn(student, seed):
    rng = np.random.default_rng(seed)
    for _ in range(8):
        points = block(rng, [4.4, 1.8, 0.7]) @ turn_in_space(rng).T + rng.uniform(-20, 20, 3)
        assert_axes(student.principal_axes(points.copy()), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=3,
    title="Right for vehicles as a scanner sees them",
    hint="Nothing about one shape may stand in the function.",
)
def test_scanned(student, seed):
    checked = 0
    for points in scanned_cars(seed) + scanned_cars(seed + 1):
        spread = np.linalg.svd(points[:, :3] - points[:, :3].mean(axis=0), compute_uv=False)
        if (spread[1:] > 0.85 * spread[:-1]).any() or checked == 6:
            continue  # two directions of nearly equal spread: neither is the right one
        checked += 1
        assert_axes(student.principal_axes(points.copy()), axes_by_svd(points))
    points = block(np.random.default_rng(seed), [1.0, 2.6, 0.4])
    assert_axes(student.principal_axes(points.copy()), axes_by_svd(points))


@hidden(
    "principal_axes",
    weight=2,
    title="Turns with the points, and only with them",
    hint="Neither order, place nor size of the cluster changes its axes.",
)
def test_equivariance(student, seed):
    rng = np.random.default_rng(seed)
    points = block(rng, [4.4, 1.8, 0.7])
    right, turn = axes_by_svd(points), turn_in_space(rng)
    assert_axes(student.principal_axes(points @ turn.T), turn @ right)
    assert_axes(student.principal_axes(rng.permutation(points)), right)
    assert_axes(student.principal_axes(1000 * points), right)
    assert_axes(student.principal_axes(0.01 * points + [9.0, -5.0, 1.0]), right)


@hidden(
    "principal_axes",
    weight=2,
    title="Right for few points, points on a line and on a plane",
    hint="The covariance matrix is 3 x 3 for any number of points; np.cov and the short form "
    "of the SVD are not always.",
)
def test_few_points(student, seed):
    rng = np.random.default_rng(seed)
    turn = turn_in_space(rng)
    triangle = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 1.0, 0.0]]) @ turn.T
    normal = as_axes(student.principal_axes(triangle + 3.0))[:, 2]
    if abs(normal @ turn[:, 2]) < 0.999:
        raise CheckFailed("For points on a plane the third axis is the normal of the plane.")
    line = np.outer(rng.uniform(-2, 2, 30), turn[:, 0]) + [4.0, 1.0, 0.0]
    for points in (line, line[:2]):
        first = as_axes(student.principal_axes(points.copy()))[:, 0]
        if abs(first @ turn[:, 0]) < 0.999:
            raise CheckFailed("For points on a line the first axis is the direction of the line.")
    for points in (line[:1], np.repeat(line[:1], 4, axis=0), np.empty((0, 3))):
        as_axes(student.principal_axes(points.copy()))


@hidden(
    "principal_axes",
    weight=1,
    title="Right for single precision and four columns",
    hint="Only the first three columns are coordinates.",
)
def test_forms_of_points(student, seed):
    rng = np.random.default_rng(seed)
    points = block(rng, [4.4, 1.8, 0.7]) @ turn_in_space(rng).T + [12.0, 3.0, 0.0]
    bright = np.column_stack([points, rng.uniform(0, 50, len(points))])
    right = axes_by_svd(points)
    assert_axes(student.principal_axes(points.astype(np.float32)), right)
    assert_axes(student.principal_axes(bright.astype(np.float32)), right)
    assert_axes(student.principal_axes(np.asfortranarray(bright)), right)


# ---- get_oriented_boxes ----


@hidden(
    "get_oriented_boxes",
    weight=5,
    title="Snug around blocks at any heading",
    hint="A yaw in degrees, of the wrong sign or of the wrong axis gives a box that is too "
    "large, or leaves points outside.",
)
@pytest.mark.parametrize("first", [12, 27])
def test_any_heading(student, seed, first):
    rng = np.random.default_rng(seed)
    cloud, labels = diagonal_blocks(rng, np.arange(first, 180, 34) + rng.uniform(0, 6))
    areas = [smallest_area(cloud[labels == label]) for label in range(1, labels.max() + 1)]
    assert_turned_boxes(
        student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels, areas
    )


@hidden(
    "get_oriented_boxes",
    weight=4,
    title="Right for diagonal vehicles as a scanner sees them",
    hint="The points of a real car do not lie evenly around its middle: take minimum and "
    "maximum along each side, in the turned frame.",
)
def test_scanned_vehicles(student, seed):
    cars = [car for step in range(3) for car in scanned_cars(seed + step)][:6]
    cars.append(turn_about_z(block(np.random.default_rng(seed), [4.4, 1.8, 1.5]), 0.7))
    cloud = np.vstack([car[:, :3] for car in cars])
    labels = np.repeat(np.arange(1, len(cars) + 1), [len(car) for car in cars])
    assert_turned_boxes(
        student.get_oriented_boxes(cloud.copy(), labels.copy()),
        cloud,
        labels,
        [smallest_area(car) for car in cars],
    )


@hidden(
    "get_oriented_boxes",
    weight=3,
    title="Contains every point of a street you have not seen",
    hint="Poles, people, hedges and walls have headings, too, if only by chance; the box must "
    "hold all of their points whatever it is.",
)
def test_fresh_street(student, seed):
    cloud = samples.obstacles_of_street(seed, 1500)
    labels = samples.cluster_labels(cloud, 0.8)
    labels = np.where(np.bincount(labels)[labels] < 4, 0, labels)
    car, one = diagonal_blocks(np.random.default_rng(seed), [40.0])
    cloud = np.vstack([cloud[:, :3], car + [0.0, 0.0, 30.0]])
    labels = np.concatenate([labels, one + labels.max()])
    clusters = [cloud[labels == label] for label in np.unique(labels[labels > 0])]
    # Only for the block do all sensible boxes agree on the size.
    areas = [np.inf] * (len(clusters) - 1) + [smallest_area(car)]
    assert_turned_boxes(
        student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels, areas
    )


@hidden(
    "get_oriented_boxes",
    weight=2,
    title="Right for round clusters and few points",
    hint="Where no direction is special any heading will do, as long as all points are inside.",
)
def test_round_and_few(student, seed):
    rng = np.random.default_rng(seed)
    place = rng.uniform(-9, 9, 3)
    car, _ = diagonal_blocks(rng, [55.0])
    ring = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    clusters = [
        car,
        place + rng.normal(0, 0.3, (60, 3)),
        place + np.column_stack([np.cos(ring), np.sin(ring), 0 * ring]),
        place[None],
        place + rng.normal(0, 1, (2, 3)),
        np.repeat(place[None], 5, axis=0),
        place + np.outer(np.linspace(0, 3, 9), [0.6, -0.8, 0.1]),
        place + np.outer(np.linspace(0, 3, 9), [0.0, 0.0, 1.0]),
        place + np.outer(np.linspace(0, 3, 9), [0.0, 1.0, 0.0]),
    ]
    cloud = np.vstack(clusters)
    labels = np.repeat(np.arange(len(clusters)) * 3 + 2, [len(points) for points in clusters])
    areas = [smallest_area(car)] + [np.inf] * (len(clusters) - 1)
    assert_turned_boxes(
        student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels, areas
    )


@hidden(
    "get_oriented_boxes",
    weight=2,
    title="Right for any numbering, four columns and single precision",
    hint="Only rows of a label above 0 count, and of them only x, y and z.",
)
def test_forms(student, seed):
    rng = np.random.default_rng(seed)
    cloud, labels = diagonal_blocks(rng, [35.0, 65.0, 140.0])
    areas = np.array([smallest_area(cloud[labels == label]) for label in (1, 2, 3)])
    names = np.array([0, 40, 7, 400])
    noise = np.column_stack([rng.uniform(-30, 30, (50, 3)), np.zeros(50)])
    noise[::7, 0] = np.nan
    bright = np.vstack([np.column_stack([cloud, rng.uniform(0, 1, len(cloud))]), noise])
    renamed = np.concatenate([names[labels], np.zeros(50, dtype=int)])
    order = rng.permutation(len(bright))
    bright, renamed = bright[order], renamed[order]
    for form in (bright, bright.astype(np.float32), np.asfortranarray(bright[:, :3])):
        assert_turned_boxes(
            student.get_oriented_boxes(form.copy(), renamed.copy()), form, renamed, areas[[1, 0, 2]]
        )


@hidden(
    "get_oriented_boxes",
    weight=1,
    title="Right for many clusters, and for none",
    hint="No cluster gives an array of shape (0, 8, 3).",
)
def test_many_and_none(student, seed):
    rng = np.random.default_rng(seed)
    car, _ = diagonal_blocks(rng, [50.0])
    cloud = np.vstack([car, rng.uniform(-30, 30, (300, 3))])
    labels = np.concatenate([np.ones(len(car), dtype=int), rng.integers(2, 100, 300)])
    areas = [smallest_area(car)] + [np.inf] * (len(np.unique(labels)) - 1)
    assert_turned_boxes(
        student.get_oriented_boxes(cloud.copy(), labels.copy()), cloud, labels, areas
    )
    none = np.zeros(len(cloud), dtype=int)
    as_cluster_boxes(student.get_oriented_boxes(cloud.copy(), none.copy()), none)
