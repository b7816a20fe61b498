"""Implementations of clustering and box detection, from the lessons and from other libraries.

The other libraries, and Numba for lesson 13, are in their own environment:

    python -m venv .bench/peers
    .bench/peers/bin/pip install -r tests/benchmarks/requirements.txt -r requirements-compiled.txt
    PEERS=$(echo .bench/peers/lib/python3*/site-packages) make bench

PCL is a C++ library. Debian's `libpcl-dev`, `g++` and `pkg-config` build a library from
`pcl_peer.cpp`, which Python calls.
"""

from __future__ import annotations

import ctypes
import functools
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from grader.course.lessons import load_reference
from tests.benchmarks.racing import Implementation, MissingProgram

RADIUS = 0.5
PCL_SOURCE = Path(__file__).with_name("pcl_peer.cpp")
PCL_LIBRARIES = ("segmentation", "filters", "sample_consensus", "search", "kdtree", "common")

if os.environ.get("PEERS"):
    # At the end of the path, so that the project's own libraries take precedence.
    sys.path.append(os.environ["PEERS"])


def _as_implementation(function: Callable[[np.ndarray], np.ndarray]) -> Implementation:
    """Convert a function of a cloud to an `Implementation`."""

    @functools.wraps(function)
    def implementation(cloud: np.ndarray) -> Callable[[], np.ndarray]:
        return functools.partial(function, cloud)

    return implementation


def _compiled(name: str) -> Callable[[np.ndarray], np.ndarray]:
    import numba  # noqa: F401  raises if missing; the lesson would take hundreds of times as long

    return getattr(load_reference("13_compiled_loops", name), name)


@_as_implementation
def taught(cloud: np.ndarray) -> np.ndarray:
    """Cluster in the way that lesson 10 teaches."""
    lesson = load_reference("10_accelerated_clustering")
    return lesson.euclidean_clustering_accelerated(cloud, RADIUS)


@_as_implementation
def full_speed(cloud: np.ndarray) -> np.ndarray:
    """Cluster with the fast version of lesson 10."""
    lesson = load_reference("10_accelerated_clustering", "clustering_at_full_speed")
    return lesson.clustering_at_full_speed(cloud, RADIUS)


@_as_implementation
def by_numba(cloud: np.ndarray) -> np.ndarray:
    """Cluster with the compiled version of lesson 13."""
    return _compiled("cluster_compiled")(cloud, RADIUS)


@_as_implementation
def by_numba_threads(cloud: np.ndarray) -> np.ndarray:
    """Cluster with the compiled version of lesson 13, on all processors."""
    return _compiled("cluster_in_parallel")(cloud, RADIUS)


@_as_implementation
def all_pairs(cloud: np.ndarray) -> np.ndarray:
    """Cluster with SciPy: the connected components of the graph of all close pairs."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(cloud).query_pairs(RADIUS, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(len(cloud), len(cloud)))
    return connected_components(graph, directed=False)[1]


@_as_implementation
def scikit_learn(cloud: np.ndarray) -> np.ndarray:
    """Cluster with scikit-learn's DBSCAN."""
    from sklearn.cluster import DBSCAN

    return DBSCAN(eps=RADIUS, min_samples=1).fit_predict(cloud)


@_as_implementation
def dbscan(cloud: np.ndarray) -> np.ndarray:
    """Cluster with the parallel DBSCAN of Wang, Gu and Shun (2020)."""
    from dbscan import DBSCAN

    return DBSCAN(cloud, eps=RADIUS, min_samples=1)[0]


@_as_implementation
def open3d(cloud: np.ndarray) -> np.ndarray:
    """Cluster with Open3D's DBSCAN."""
    import open3d

    shell = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud))
    return np.asarray(shell.cluster_dbscan(RADIUS, 1))


def pcl(cloud: np.ndarray) -> Callable[[], np.ndarray]:
    """Cluster with PCL's EuclideanClusterExtraction."""
    peer, points = _load_into_pcl(cloud)
    labels = np.empty(len(cloud), dtype=np.int32)

    def work() -> np.ndarray:
        peer.label_clusters(points, RADIUS, labels)
        return labels

    return work


@_as_implementation
def detect(cloud: np.ndarray) -> np.ndarray:
    """Detect boxes with lesson 12."""
    return load_reference("12_streaming_obstacles").detect_obstacles(cloud)


@_as_implementation
def detect_by_numba(cloud: np.ndarray) -> np.ndarray:
    """Detect boxes with lesson 13: the smallest rectangles around clusters."""
    return _compiled("detect_compiled")(cloud)


def detect_by_pcl(cloud: np.ndarray) -> Callable[[], np.ndarray]:
    """Detect boxes with the same steps in PCL: the smallest rectangles around clusters.

    The answer is only an array of zeros, one for each box.
    """
    peer, points = _load_into_pcl(cloud)
    return lambda: np.zeros(peer.count_boxes(points, RADIUS))


CLUSTERING: dict[str, Implementation] = {
    "ours, Numba on all processors": by_numba_threads,
    "ours, Numba": by_numba,
    "ours, full speed": full_speed,
    "ours, taught": taught,
    "dbscan (PyPI)": dbscan,
    "PCL": pcl,
    "Open3D": open3d,
    "scikit-learn": scikit_learn,
    "SciPy, all pairs": all_pairs,
}
DETECTORS: dict[str, Implementation] = {
    "ours, Numba": detect_by_numba,
    "ours": detect,
    "PCL": detect_by_pcl,
}


def _load_into_pcl(cloud: np.ndarray) -> tuple[ctypes.CDLL, int]:
    peer = pcl_peer()
    return peer, peer.load_cloud(cloud.astype(np.float32, order="C"), len(cloud))


@functools.cache
def pcl_peer() -> ctypes.CDLL:
    """Return the library built from `pcl_peer.cpp`, and build it if necessary."""
    library = Path(tempfile.gettempdir(), f"pcl_peer-{os.getuid()}.so")
    if not library.exists() or library.stat().st_mtime < PCL_SOURCE.stat().st_mtime:
        build_pcl_peer(library)
    peer = ctypes.CDLL(str(library))
    points, radius = ctypes.c_void_p, ctypes.c_double
    peer.load_cloud.argtypes = (np.ctypeslib.ndpointer(np.float32, flags="C"), ctypes.c_long)
    peer.load_cloud.restype = points
    peer.label_clusters.argtypes = (points, radius, np.ctypeslib.ndpointer(np.int32, flags="C"))
    peer.label_clusters.restype = None
    peer.count_boxes.argtypes = (points, radius)
    peer.count_boxes.restype = ctypes.c_long
    return peer


def build_pcl_peer(library: Path) -> None:
    """Compile `pcl_peer.cpp`; raise `MissingProgram` without a compiler or PCL."""
    if not shutil.which("pkg-config") or not shutil.which("g++"):
        raise MissingProgram("no g++ and pkg-config")
    needed = [f"pcl_{name}" for name in PCL_LIBRARIES]
    flags = subprocess.run(
        ["pkg-config", "--cflags", "--libs", *needed], capture_output=True, text=True
    )
    if flags.returncode:
        raise MissingProgram("no libpcl-dev")
    options = ["-std=c++17", "-O3", "-DNDEBUG", "-shared", "-fPIC"]
    command = ["g++", *options, PCL_SOURCE, "-o", library, *flags.stdout.split()]
    subprocess.run(command, check=True)
