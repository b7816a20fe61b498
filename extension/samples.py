"""Clouds and right answers for the hidden tests.

Fresh scenes are drawn from the course's secret seed. Right answers come from brute force and from
libraries that students may not use, never from the reference solution. Scenes and answers are
cached, because judging a class of two hundred needs each of them two hundred times.
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
    """Return n random points of the course's cloud within 25 m of the scanner, read-only."""
    cloud = course_cloud()
    rng = np.random.default_rng(seed)
    rows = np.flatnonzero(np.hypot(cloud[:, 0], cloud[:, 1]) < 25)
    return frozen(cloud[rng.choice(rows, n, replace=False)])


@functools.lru_cache(maxsize=64)
def fresh_street(seed: int) -> np.ndarray:
    """Return a scan of a street that students have not seen, read-only, shape (n, 4)."""
    from utils.scenes import random_street

    return frozen(random_street(seed).cloud)


@functools.lru_cache(maxsize=256)
def obstacles_of_street(seed: int, n: int) -> np.ndarray:
    """Return at most n random points within 20 m, above the road of a fresh street, read-only."""
    cloud = fresh_street(seed)
    near = np.hypot(cloud[:, 0], cloud[:, 1]) < 20
    rows = np.flatnonzero(near & (cloud[:, 2] > -1.0))
    rng = np.random.default_rng(seed + 1)
    return frozen(cloud[rng.choice(rows, min(n, len(rows)), replace=False)])


@cached_by_content
def cluster_labels(cloud: np.ndarray, threshold: float) -> np.ndarray:
    """Return correct labels for `euclidean_clustering`, computed with scikit-learn, shape (n,)."""
    from sklearn.cluster import DBSCAN

    if not len(cloud):
        return np.empty(0, dtype=int)
    # With min_samples=1, every point is a core point, so DBSCAN does single-linkage clustering.
    # DBSCAN joins pairs exactly at the radius and the exercise does not, so `remove_ties` removes
    # such pairs.
    clustering = DBSCAN(eps=float(threshold), min_samples=1)
    return clustering.fit_predict(cloud[:, :3].astype(float)) + 1


@cached_by_content
def remove_ties(cloud: np.ndarray, threshold: float, margin: float = 1e-3) -> np.ndarray:
    """Return a cloud with no pair of points whose distance is within `margin` of `threshold`.

    Whether a pair exactly at the threshold counts depends on ``<`` or ``<=`` and on rounding.
    Neither should decide whether an answer is right. All lengths are in metres.
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
