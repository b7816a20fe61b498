"""Cheap answers, which do not try to solve the task, to any exercise and to each exercise."""

import math

import numpy as np

from utils.checks.lesson_12.match_boxes import cubes

SEED = 7
LARGEST_SHARE = 0.1  # fraction of an exercise's points that a cheap answer may earn


def length(value):
    return len(value) if np.ndim(value) else 1


def new_rng():
    return np.random.default_rng(0)


GENERAL_ANSWERS = {
    "None": lambda first, *others: None,
    "an empty list": lambda first, *others: [],
    "0": lambda first, *others: 0,
    "1": lambda first, *others: 1,
    "NaN": lambda first, *others: math.nan,
    "zeros": lambda first, *others: np.zeros(length(first)),
    "ones": lambda first, *others: np.ones(length(first)),
    "NaNs": lambda first, *others: np.full(length(first), np.nan),
    "numbers from 1": lambda first, *others: 1 + np.arange(length(first)),
    "row numbers": lambda first, *others: np.arange(length(first)),
    "all True": lambda first, *others: np.ones(length(first), dtype=bool),
    "random numbers": lambda first, *others: new_rng().random(length(first)),
    "random whole numbers": lambda first, *others: new_rng().integers(1, 9, length(first)),
    "random choice of rows": lambda first, *others: first[new_rng().random(len(first)) < 0.5],
    "the first argument": lambda first, *others: first,
    "the last argument": lambda *arguments: arguments[-1],
    "both arguments": lambda *arguments: arguments[:2],
    "zeros of the same shape": lambda first, *others: np.zeros(np.shape(first)),
    "the first argument without rows": lambda first, *others: first[:0],
    "the first row": lambda first, *others: first[0],
    "only the first row": lambda first, *others: first[:1],
    "the last row": lambda first, *others: first[-1],
    "only the last row": lambda first, *others: first[-1:],
    "every second row": lambda first, *others: first[::2],
    "the rows in reverse order": lambda first, *others: first[::-1],
    "the mean": lambda first, *others: np.mean(first, axis=0),
    "the mean as the only row": lambda first, *others: np.mean(first, axis=0, keepdims=True),
    "the sum of every row": lambda first, *others: np.sum(first, axis=1),
    "the first column": lambda first, *others: np.abs(first[:, 0]),
}


def plane_of(points, rows):
    """Return the plane through three of the points, and the distances of all points from it."""
    p, q, r = (points[row, :3].astype(float) for row in rows)
    normal = np.cross(q - p, r - p)
    plane = np.append(normal, -normal @ p) / np.linalg.norm(normal)
    return plane, plane_distances(points, plane)


def plane_distances(points, plane):
    return np.abs(np.asarray(points)[:, :3] @ plane[:3] + plane[3])


def fixed_rows(*rows):
    def ransac_plane(points, max_iterations, distance_tolerance, rng):
        plane, gaps = plane_of(points, [int(row * (len(points) - 1)) for row in rows])
        return plane, gaps <= distance_tolerance

    return ransac_plane


def fixed_plane(*plane):
    def ransac_plane(points, max_iterations, distance_tolerance, rng):
        return np.array(plane), plane_distances(points, np.array(plane)) <= distance_tolerance

    return ransac_plane


def level_plane(points, max_iterations, distance_tolerance, rng):
    plane = np.array([0.0, 0.0, 1.0, -np.median(points[:, 2])])
    return plane, plane_distances(points, plane) <= distance_tolerance


def line_of(points, rows, tolerance):
    p, q = points[rows[0]].astype(float), points[rows[1]].astype(float)
    (dx, dy), far = q - p, math.dist(p, q)
    line = np.array([-dy, dx, dy * p[0] - dx * p[1]]) / far
    return line, np.abs(points @ line[:2] + line[2]) <= tolerance


def fixed_ends(first, last):
    def ransac_line(points, max_iterations, distance_tolerance, rng):
        rows = [int(row * (len(points) - 1)) for row in (first, last)]
        return line_of(points, rows, distance_tolerance)

    return ransac_line


def fixed_line(*line):
    def ransac_line(points, max_iterations, distance_tolerance, rng):
        return np.array(line), np.abs(points @ line[:2] + line[2]) <= distance_tolerance

    return ransac_line


def nothing_found(points, max_iterations, distance_tolerance, rng):
    return None, np.zeros(len(points), dtype=bool)


def cuboid(x, y, z, sides, degrees):
    """Return the corners, (8, 3), of a rotated box with its centre at (x, y, z)."""
    turn = np.radians(degrees)
    along = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    box = cubes([[0.0, 0.0, 0.0]])[0] * sides
    box[:, :2] = box[:, :2] @ along
    return box + [x, y, z]


def cars_at(x, y, *degrees, sides=(4.2, 1.8, 1.5)):
    signs = ((1, 1), (1, -1), (-1, 1), (-1, -1))
    boxes = [
        cuboid(i * x, j * y, -0.9, sides, turn) for (i, j), turn in zip(signs, degrees, strict=True)
    ]
    return lambda cloud: np.array(boxes)


def fixed_boxes_with_returns(boxes):
    """Return a detector that returns those of the given boxes that have many points nearby."""

    def detect_obstacles(cloud):
        middles = boxes(cloud).mean(axis=1)[:, None]
        near = np.linalg.norm(cloud[None, :, :3] - middles, axis=2) < 2.5
        above = cloud[:, 2] > -1.2
        return boxes(cloud)[(near & above).sum(axis=1) > 50]

    return detect_obstacles


PARKED = {
    f"four {name} boxes at ({x:g}, {y:g})": cars_at(x, y, *degrees, sides=sides)
    for name, sides, degrees in (
        ("diagonal", (4.2, 1.8, 1.5), (45, 45, 45, 45)),
        ("mixed", (4.2, 1.8, 1.5), (40, 50, 45, -45)),
        ("crossed", (4.2, 1.8, 1.5), (45, -45, -45, 45)),
        ("round", (3.6, 3.6, 1.6), (0, 0, 0, 0)),
    )
    for x, y in ((6.6, 2.85), (7.0, 3.5), (5.5, 3.0))
}


def box_of_the_rows(cloud, labels=None):
    if not len(cloud):
        return np.empty((0, 8, 3))
    middle = (cloud[:, :3].min(axis=0) + cloud[:, :3].max(axis=0)) / 2
    return cuboid(*middle, np.ptp(cloud[:, :3], axis=0), 0)[None]


def count_of(labels):
    return len(np.unique(labels[labels > 0]))


def box_at_mean(cloud, labels):
    """Return a box of the size of a car at the mean of each cluster."""
    present = np.unique(labels[labels > 0])
    middles = [cloud[labels == label, :3].mean(axis=0) for label in present]
    return np.array([cuboid(*middle, (4.2, 1.8, 1.4), 35) for middle in middles])


BOXES = {
    "boxes of zeros": lambda cloud, labels: np.zeros((count_of(labels), 8, 3)),
    "boxes of ones": lambda cloud, labels: np.ones((count_of(labels), 8, 3)),
    "random boxes": lambda cloud, labels: new_rng().random((count_of(labels), 8, 3)),
    "unit boxes": lambda cloud, labels: cubes(np.zeros((count_of(labels), 3))),
    "huge boxes": lambda cloud, labels: cubes(np.zeros((count_of(labels), 3)), 200.0),
    "no boxes": lambda cloud, labels: np.empty((0, 8, 3)),
    "the box of all rows, for every label": lambda cloud, labels: np.repeat(
        box_of_the_rows(cloud), count_of(labels), axis=0
    ),
    "eight rows of the cloud for every label": lambda cloud, labels: np.resize(
        cloud[:, :3], (count_of(labels), 8, 3)
    ),
}


def insert_as_root(tree, point, index):
    tree.root = type(tree).node(point, index)


def insert_into_chain(side):
    def insert(tree, point, index):
        if tree.root is None:
            return insert_as_root(tree, point, index)
        node = tree.root
        while getattr(node, side) is not None:
            node = getattr(node, side)
        setattr(node, side, type(tree).node(point, index))

    return insert


def change_own_point(tree, point, index):
    point[:] = [1e9] * len(point)


def nodes_of(tree):
    nodes = [tree.root] if tree.root is not None else []
    for node in nodes:
        nodes += [child for child in (node.left, node.right) if child is not None]
    return nodes


def every_index(tree, target, tolerance):
    return [node.index for node in nodes_of(tree)]


def index_of_the_root(tree, target, tolerance):
    return [tree.root.index] if tree.root is not None else []


CHEAP_ANSWERS = {
    "horizontal_distance": {
        "the norm of whole rows": lambda cloud: np.linalg.norm(cloud, axis=1),
        "the norm in space": lambda cloud: np.linalg.norm(cloud[:, :3], axis=1),
        "the sum of x and y": lambda cloud: np.abs(cloud[:, :2]).sum(axis=1),
        "the larger of x and y": lambda cloud: np.abs(cloud[:, :2]).max(axis=1),
    },
    "drop_invalid": {},
    "line_through": {
        "the x axis": lambda p, q: (0.0, 1.0, 0.0),
        "a level line through p": lambda p, q: (0.0, 1.0, -p[1]),
        "an upright line through p": lambda p, q: (1.0, 0.0, -p[0]),
    },
    "point_line_distance": {
        "distance to the sensor": lambda points, line: np.linalg.norm(points, axis=1),
        "distance to the x axis": lambda points, line: np.abs(points[:, 1]),
        "|c| for all": lambda points, line: np.full(len(points), abs(line[2])),
    },
    "ransac_line": {
        "nothing found": nothing_found,
        "first and last row": fixed_ends(0, 1),
        "first and middle row": fixed_ends(0, 0.5),
        "middle and last row": fixed_ends(0.5, 1),
        "two inner rows": fixed_ends(0.3, 0.7),
        "the x axis": fixed_line(0.0, 1.0, 0.0),
        "the y axis": fixed_line(1.0, 0.0, 0.0),
        "a line and all True": lambda points, *rest: ((0, 1, 0), np.ones(len(points), bool)),
        "a line without inliers": lambda points, *rest: ((0, 1, 1e6), np.zeros(len(points), bool)),
    },
    "plane_through": {
        "the level plane at 0": lambda p, q, r: (0.0, 0.0, 1.0, 0.0),
        "the level plane through p": lambda p, q, r: (0.0, 0.0, 1.0, -p[2]),
        "the road": lambda p, q, r: (0.0, 0.0, 1.0, 1.7),
        "the same points": lambda p, q, r: (
            [x.__setitem__(slice(None), 0) for x in (p, q, r)] and (0.0, 0.0, 1.0, 0.0)
        ),
    },
    "point_plane_distance": {
        "the height": lambda points, plane: np.abs(points[:, 2]),
        "height over the road": lambda points, plane: np.abs(points[:, 2] + 1.73),
        "distance to the sensor": lambda points, plane: np.linalg.norm(points[:, :3], axis=1),
        "|d| for all": lambda points, plane: np.full(len(points), abs(plane[3])),
    },
    "ransac_plane": {
        "nothing found": nothing_found,
        "rows 0, n/2 and -1": fixed_rows(0, 0.5, 1),
        "the first three rows": fixed_rows(0, 0.03, 0.06),
        "three inner rows": fixed_rows(0.2, 0.5, 0.8),
        "three last rows": fixed_rows(1, 0.9, 0.8),
        "the level plane at the median of z": level_plane,
        "the road": fixed_plane(0.0, 0.0, 1.0, 1.73),
        "the plane at 0": fixed_plane(0.0, 0.0, 1.0, 0.0),
        "the lesson's slope": fixed_plane(-0.28, 0.0, 0.96, 1.5),
        "a plane and all True": lambda points, *rest: (
            (0, 0, 1, 0),
            np.ones(len(points), dtype=bool),
        ),
    },
    "fit_plane": {
        "the level plane at 0": lambda points: (0.0, 0.0, 1.0, 0.0),
        "the level plane at the mean of z": lambda points: (0, 0, 1, -np.mean(points[:, 2])),
        "the road": lambda points: (0.0, 0.0, 1.0, 1.73),
        "through three rows": lambda points: plane_of(points, (0, len(points) // 2, -1))[0],
    },
    "iterations_needed": {
        "17": lambda *arguments: 17,
        "19": lambda *arguments: 19,
        "100": lambda *arguments: 100,
        "1000": lambda *arguments: 1000,
        "never": lambda *arguments: math.inf,
    },
    "insert": {
        "nothing": lambda tree, point, index: None,
        "always the root": insert_as_root,
        "always left": insert_into_chain("left"),
        "always right": insert_into_chain("right"),
        "changes its point": change_own_point,
    },
    "search": {
        "everything": every_index,
        "the root": index_of_the_root,
        "number 0": lambda tree, target, tolerance: [0],
        "nothing, after an insert that changes points": lambda tree, target, tolerance: [],
    },
    "median_order": {
        "sorted by x": lambda points: np.argsort(points[:, 0]),
        "backwards": lambda points: np.arange(len(points))[::-1],
        "shuffled": lambda points: new_rng().permutation(len(points)),
    },
    "euclidean_clustering": {
        "split by the sign of x": lambda cloud, threshold=0.5: 1 + (cloud[:, 0] > 4),
        "two halves": lambda cloud, threshold=0.5: 1 + 2 * np.arange(len(cloud)) // len(cloud),
    },
    "filter_ground": {
        "a fixed share": lambda cloud, ground_level=-1.2: cloud[: len(cloud) // 2],
    },
    "voxel_grid": {
        "every second row": lambda cloud, voxel_size=0.2: cloud[::2],
        "rounded rows": lambda cloud, voxel_size=0.2: np.unique(np.round(cloud, 1), axis=0),
    },
    "filter_by_distance": {},
    "crop_region": {},
    "remove_ego_returns": {},
    "get_bounding_boxes": BOXES,
    "filter_clusters": {
        "all noise": lambda cluster_labels, min_num_points=100: np.zeros(
            len(cluster_labels), dtype=int
        ),
        "only cluster 1": lambda cluster_labels, min_num_points=100: np.where(
            cluster_labels == 1, 1, 0
        ),
    },
    "euclidean_clustering_accelerated": {
        "split by the sign of x": lambda cloud, threshold=0.5: 1 + (cloud[:, 0] > 4),
        "two halves": lambda cloud, threshold=0.5: 1 + 2 * np.arange(len(cloud)) // len(cloud),
    },
    "principal_axes": {
        "the axes of the scan": lambda points: np.eye(3),
        "the same axes in another order": lambda points: np.eye(3)[:, [1, 2, 0]],
        "x along the mean": lambda points: np.linalg.qr(
            np.column_stack([points[:, :3].mean(axis=0), np.eye(3)[:, :2]])
        )[0],
        "a fixed turn": lambda points: cuboid(0, 0, 0, 1, 35)[[0, 1, 3]],
    },
    "get_oriented_boxes": {**BOXES, "fixed boxes at the means": box_at_mean},
    "detect_obstacles": {
        "no boxes": lambda cloud: np.empty((0, 8, 3)),
        "the box of all rows": box_of_the_rows,
        "one fixed box": lambda cloud: cuboid(6.6, 2.85, -0.9, (4.2, 1.8, 1.5), 45)[None],
        **PARKED,
    },
    "match_boxes": {
        "all new": lambda previous, current, max_distance: np.full(len(current), -1),
        "box k is box k": lambda previous, current, max_distance: np.where(
            np.arange(len(current)) < len(previous), np.arange(len(current)), -1
        ),
        "always the first": lambda previous, current, max_distance: np.zeros(len(current), int),
    },
}


def nothing(*arguments):
    return None
