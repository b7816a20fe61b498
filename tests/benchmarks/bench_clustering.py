"""Exact clustering of a full scan: the lessons' solutions against other libraries.

All cluster the same cloud in the same run, in turn, so that a busy machine slows all of them
alike; ratios compare the times of one round. Peers that are not installed are left out, with a
word. To install them beside the project, and not into it:

    .venv/bin/pip install --target /tmp/peers dbscan open3d
    PEERS=/tmp/peers make bench
"""

import os
import sys
import time
import tracemalloc

import numpy as np

from grader.course.lessons import load_reference
from utils import load_cloud

RADIUS = 0.5
ROUNDS = int(os.environ.get("ROUNDS", 9))
# A slow peer has one round at least, and no more than this many seconds.
PATIENCE = 20.0


LESSON = load_reference("10_accelerated_clustering", "clustering_at_full_speed")


def ours(cloud):
    """Labels by the fast version of lesson 10."""
    return LESSON.clustering_at_full_speed(cloud, RADIUS)


def taught(cloud):
    """Labels by the plan that lesson 10 teaches."""
    return LESSON.euclidean_clustering_accelerated(cloud, RADIUS)


def all_pairs(cloud):
    """Labels by SciPy: a list of all pairs, and the pieces of their graph."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(cloud).query_pairs(RADIUS, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(cloud), len(cloud)))
    return connected_components(graph, directed=False)[1]


def scikit_learn(cloud):
    """Labels by scikit-learn's DBSCAN."""
    from sklearn.cluster import DBSCAN

    return DBSCAN(eps=RADIUS, min_samples=1).fit_predict(cloud)


def dbscan_of_pypi(cloud):
    """Labels by the parallel DBSCAN of Wang, Gu and Shun (2020)."""
    from dbscan import DBSCAN

    return DBSCAN(cloud, eps=RADIUS, min_samples=1)[0]


def open3d(cloud):
    """Labels by Open3D's DBSCAN."""
    import open3d

    shell = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud))
    return np.asarray(shell.cluster_dbscan(RADIUS, 1))


WAYS = {
    "lesson 10, fast": ours,
    "lesson 10, taught": taught,
    "dbscan (PyPI)": dbscan_of_pypi,
    "Open3D": open3d,
    "scikit-learn": scikit_learn,
    "SciPy, all pairs": all_pairs,
}


def available(cloud):
    """The ways that work here, after one call each to import and to warm up; their labels."""
    labels = {}
    for name, way in WAYS.items():
        try:
            labels[name] = way(cloud)
        except ImportError as error:
            print(f"{name:>18}: left out, {error}")
    return labels


def measure(names, cloud):
    """Seconds of each way, round by round; shape (ROUNDS,) each, NaN where left out."""
    seconds = {name: np.full(ROUNDS, np.nan) for name in names}
    for number in range(ROUNDS):
        for name in names:
            if np.nansum(seconds[name]) < PATIENCE:
                begin = time.perf_counter()
                WAYS[name](cloud)
                seconds[name][number] = time.perf_counter() - begin
    return seconds


def peak_memory(way, cloud):
    """Bytes that Python and NumPy held at most, beyond the cloud; libraries in C++ hide theirs."""
    tracemalloc.start()
    way(cloud)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


def same_partition(labels, others):
    """Whether two labellings group the points alike."""
    pairs = np.unique(np.stack([labels, others]), axis=1).shape[1]
    return pairs == len(np.unique(labels)) == len(np.unique(others))


def compare(title, cloud):
    """Measure on one cloud and print a table."""
    print(f"\n{title}: {len(cloud):,} points, radius {RADIUS} m, {ROUNDS} rounds")
    labels = available(cloud)
    exact = all_pairs(cloud)
    seconds = measure(labels, cloud)
    mine = seconds["lesson 10, fast"]
    for name in labels:
        median, ratio = np.nanmedian(seconds[name]), np.nanmedian(seconds[name] / mine)
        remark = "" if same_partition(labels[name], exact) else "  NOT the exact partition"
        print(
            f"{name:>18}: {1000 * median:9.1f} ms  {ratio:7.2f} x  "
            f"{peak_memory(WAYS[name], cloud) / 1e6:7.1f} MB{remark}"
        )


def traps():
    """Clouds that break careless short cuts; name and points."""
    rng = np.random.default_rng(0)
    heap = rng.uniform(0, 0.2, (60_000, 3))
    yield "two dense heaps, apart", np.vstack([heap, heap[:, [1, 2, 0]] + [0.71, 0, 0]])
    yield "two dense heaps, joined", np.vstack([heap, heap[:, [1, 2, 0]] + [0.69, 0, 0]])
    ball = rng.normal(size=(60_000, 3))
    ball *= 0.3 * rng.uniform(0, 1, (60_000, 1)) ** (1 / 3) / np.linalg.norm(ball, axis=1)[:, None]
    yield "two dense balls, askew", np.vstack([ball, ball + [0.9, 0.4, 0.3]])
    yield "evenly filled space", rng.uniform(0, 14.5, (120_000, 3))
    yield "a million dense points", rng.uniform(0, 10, (1_000_000, 3))


def main():
    """Measure and print."""
    if os.environ.get("PEERS"):
        sys.path.append(os.environ["PEERS"])  # last, so that the project's own libraries win
    cloud = np.ascontiguousarray(load_cloud("cloud.txt")[:, :3])
    compare("full scan", cloud)
    compare("without the road", np.ascontiguousarray(cloud[cloud[:, 2] > -1.2]))
    print("\nlesson 10, fast, on difficult clouds")
    for name, points in traps():
        begin = time.perf_counter()
        count = ours(points).max()
        seconds = time.perf_counter() - begin
        print(
            f"{name:>26}: {1000 * seconds:7.1f} ms, {peak_memory(ours, points) / 1e6:6.1f} MB, "
            f"{count:,} clusters of {len(points):,} points"
        )


if __name__ == "__main__":
    main()
