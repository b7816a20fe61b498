"""Implementations of clustering and box detection, from the lessons and from other libraries.

The other libraries, and Numba for lesson 13, are in their own environment:

    python -m venv .bench/peers
    .bench/peers/bin/pip install -r tests/benchmarks/requirements.txt -r requirements-compiled.txt
    PEERS=$(echo .bench/peers/lib/python3*/site-packages) make bench

PCL is a C++ library. Debian's `libpcl-dev`, `g++` and `pkg-config` build `pcl_peer` from
`pcl_peer.cpp`, unless PCL_PEER is the path of a finished program.
"""

from __future__ import annotations

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
    # Last, so that the project's own libraries take precedence.
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


def pcl(cloud: np.ndarray) -> PclPeer:
    """Cluster with PCL's EuclideanClusterExtraction."""
    return PclPeer("cluster", cloud)


@_as_implementation
def detect(cloud: np.ndarray) -> np.ndarray:
    """Detect boxes with lesson 12."""
    return load_reference("12_streaming_obstacles").detect_obstacles(cloud)


@_as_implementation
def detect_by_numba(cloud: np.ndarray) -> np.ndarray:
    """Detect boxes with lesson 13: the smallest rectangles around clusters."""
    return _compiled("detect_compiled")(cloud)


def detect_by_pcl(cloud: np.ndarray) -> PclPeer:
    """Detect boxes with the same steps in PCL: the smallest rectangles around clusters."""
    return PclPeer("detect", cloud)


CLUSTERING: dict[str, Implementation] = {
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


class PclPeer:
    """A running `pcl_peer` program, which does its work once per call.

    Parameters
    ----------
    work : {"cluster", "detect"}
    cloud : ndarray, shape (n, 3)

    Raises
    ------
    tests.benchmarks.racing.MissingProgram
        If the program does not exist and cannot be built.
    """

    def __init__(self, work: str, cloud: np.ndarray) -> None:
        self._folder = tempfile.TemporaryDirectory()
        points, self._answer = Path(self._folder.name, "points"), Path(self._folder.name, "answer")
        points.write_bytes(cloud.astype("<f4").tobytes())
        self._work, self._count = work, len(cloud)
        self._program = subprocess.Popen(
            [pcl_program(), work, points, str(RADIUS), self._answer],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.process = self._program.pid

    def __call__(self) -> np.ndarray:
        """Return the points' labels, or zeros whose number is that of the detected boxes."""
        try:
            self._program.stdin.write("\n")
            self._program.stdin.flush()
        except BrokenPipeError:
            raise MissingProgram("pcl_peer does not run; it says why above") from None
        if not self._program.stdout.readline():
            raise MissingProgram("pcl_peer does not run; it says why above")
        if self._work == "detect":
            return np.zeros(int(self._answer.read_text()))
        return np.fromfile(self._answer, "<i4")

    def __del__(self) -> None:
        if hasattr(self, "_program"):
            self._program.kill()
            self._program.communicate()


@functools.cache
def pcl_program() -> str:
    """Return the path of `pcl_peer`, and build it if necessary."""
    if os.environ.get("PCL_PEER"):
        return os.environ["PCL_PEER"]
    if not shutil.which("pkg-config") or not shutil.which("g++"):
        raise MissingProgram("no g++ and pkg-config")
    libraries = [f"pcl_{name}" for name in PCL_LIBRARIES]
    flags = subprocess.run(
        ["pkg-config", "--cflags", "--libs", *libraries], capture_output=True, text=True
    )
    if flags.returncode:
        raise MissingProgram("no libpcl-dev")
    program = Path(tempfile.gettempdir(), f"pcl_peer-{os.getuid()}")
    if not program.exists() or program.stat().st_mtime < PCL_SOURCE.stat().st_mtime:
        command = ["g++", "-std=c++17", "-O3", "-DNDEBUG", PCL_SOURCE, "-o", program]
        subprocess.run([*command, *flags.stdout.split()], check=True)
    return str(program)
