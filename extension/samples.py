"""Clouds and right answers for the hidden tests.

Fresh scenes are drawn from the course's secret seed. Right answers come from plain brute force
and from libraries that students may not use, never from the reference solution. Both are cached,
because a class of two hundred uses the same ones two hundred times.
"""

import functools

import numpy as np

from grader.course.paths import PROJECT
from grader.judging.hidden_tests import cached_by_content
from utils.checks.assertions import frozen
from utils.clouds import read_cloud


@functools.cache
def course_cloud() -> np.ndarray:
    """Return ``data/cloud.txt``, read-only."""
    return frozen(read_cloud(PROJECT / "data" / "cloud.txt"))


@functools.lru_cache(maxsize=256)
def patch_of_course_cloud(seed: int, n: int) -> np.ndarray:
    """Return n random rows of the course's cloud within 25 m, read-only."""
    cloud = course_cloud()
    rng = np.random.default_rng(seed)
    rows = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 25)
    return frozen(cloud[rng.choice(rows, n, replace=False)])


@functools.lru_cache(maxsize=64)
def fresh_street(seed: int) -> np.ndarray:
    """Return a scan of an unknown street: one full turn, read-only, shape (n, 4)."""
    from utils.scenes import random_street

    return frozen(random_street(seed).cloud)


@functools.lru_cache(maxsize=256)
def obstacles_of_street(seed: int, n: int) -> np.ndarray:
    """Return at most n points above the road of a fresh street within 20 m, read-only."""
    cloud = fresh_street(seed)
    near = np.hypot(cloud[:, 0], cloud[:, 1]) < 20
    rows = np.flatnonzero(near & (cloud[:, 2] > -1.0))
    rng = np.random.default_rng(seed + 1)
    return frozen(cloud[rng.choice(rows, min(n, len(rows)), replace=False)])


@cached_by_content
def cluster_labels(cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Return right labels for `euclidean_clustering`, by scikit-learn; shape (n,)."""
    from sklearn.cluster import DBSCAN

    if not len(cloud):
        return np.empty(0, dtype=int)
    # With min_samples=1 every point is a core point, and DBSCAN is single linkage. It includes the
    # radius and the exercise excludes it, so `without_ties` removes distances close to the radius.
    clusters = DBSCAN(eps=float(threshold), min_samples=1)
    return clusters.fit_predict(cloud[:, :3].astype(float)) + 1


@cached_by_content
def without_ties(cloud: np.ndarray, threshold: float, margin: float = 1e-3) -> np.ndarray:
    """Return rows of a cloud so that no two are within `margin` metres of the threshold distance.

    Whether a pair exactly at the threshold counts depends on ``<`` or ``<=`` and on rounding;
    neither says whether an algorithm is right.
    """
    from scipy.spatial import cKDTree

    tree = cKDTree(cloud[:, :3])
    outer = tree.query_pairs(threshold + margin, output_type="ndarray")
    distance = np.linalg.norm(cloud[outer[:, 0], :3] - cloud[outer[:, 1], :3], axis=1)
    doubtful = outer[distance > threshold - margin]
    return frozen(np.delete(cloud, np.unique(doubtful[:, 1]), axis=0))


@cached_by_content
def voxel_centroids(cloud: np.ndarray, voxel_size: float) -> np.ndarray:
    """Return the right answer for `voxel_grid`, shape (m, columns), computed in plain Python."""
    cells = {}
    for row in np.asarray(cloud, dtype=float).tolist():
        cells.setdefault(tuple(int(x // voxel_size) for x in row[:3]), []).append(row)
    return np.array(
        [[sum(column) / len(rows) for column in zip(*rows, strict=True)] for rows in cells.values()]
    ).reshape(-1, cloud.shape[1])
