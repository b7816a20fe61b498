"""The course's readers and other libraries read the same points from every file that both read.

The files are all those that the other tests of the readers read, those that Open3D and pypcd4
write, and recorded scans.
"""

import itertools
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import laspy
import numpy as np
import plyfile
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from grader.course.paths import PROJECT
from tests.prerequisites import LIBRARIES, RECORDINGS
from utils.clouds import read_cloud
from utils.recordings import read_bag
from utils.recordings.messages import LIVOX, POINT_CLOUD

pytestmark = pytest.mark.proof
REAL = Path(os.environ.get("REAL_CLOUDS", "/nowhere"))
OTHER_TESTS = [
    f"tests/test_clouds_{name}.py"
    for name in ("formats", "kitti", "messages", "pcd", "rosbag", "sequence", "text")
]
INTENSITIES = ("intensity", "intensities", "i", "reflectance")
# Open3D returns memory that it did not fill if the header of a PCD file contradicts itself or says
# DATA BINARY. In a PLY file, it reads x, y and z with one type, even if their types differ.
MISREAD_BY_OPEN3D = re.compile(
    rb"WIDTH 3\n(.*\n){1,3}POINTS 5\n|DATA BINARY|property double z\n(.*\n)*property float x\n"
)


def with_open3d(path: Path) -> np.ndarray:
    if MISREAD_BY_OPEN3D.search(path.read_bytes()):
        raise ValueError("known to be read wrongly")
    import open3d

    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    points = open3d.t.io.read_point_cloud(str(path)).point
    names = ["positions", *[name for name in INTENSITIES if name in points]]
    return np.column_stack([points[name].numpy() for name in names])


def with_pypcd4(path: Path) -> np.ndarray:
    import pypcd4

    return points_of(pypcd4.PointCloud.from_path(path))


def points_of(cloud: Any) -> np.ndarray:
    """Return the points of a cloud of pypcd4."""
    return cloud.numpy(["x", "y", "z", *[name for name in INTENSITIES if name in cloud.fields]])


def with_plyfile(path: Path) -> np.ndarray:
    vertices = plyfile.PlyData.read(str(path))["vertex"].data
    return np.column_stack([vertices[name] for name in ("x", "y", "z")])


def with_laspy(path: Path) -> np.ndarray:
    las = laspy.read(path)
    return np.column_stack([las.x, las.y, las.z, las.intensity])


def with_numpy(path: Path) -> np.ndarray:
    if path.suffix == ".bin":
        values = np.fromfile(path, "<f4")
        if len(values) % 20 == 0:
            raise ValueError("may have the 4 columns of KITTI or the 5 of nuScenes")
        return values.reshape(-1, 4)
    if path.suffix == ".npy":
        return np.load(path)
    if path.suffix == ".npz":
        return np.load(path)["cloud"]
    return np.loadtxt(path, ndmin=2, delimiter="," if path.suffix == ".csv" else None)


class Library(NamedTuple):
    """A library, the formats that it reads, and the fewest files that must be compared."""

    read: Callable[[Path], np.ndarray]
    suffixes: tuple[str, ...]
    fewest: int


READERS = {
    "open3d": Library(with_open3d, (".pcd", ".ply", ".xyz", ".pts"), 80),
    "pypcd4": Library(with_pypcd4, (".pcd",), 40),
    "plyfile": Library(with_plyfile, (".ply",), 10),
    "laspy": Library(with_laspy, (".las",), 1),
    "numpy": Library(
        with_numpy, (".bin", ".npy", ".npz", ".txt", ".xyz", ".csv", ".asc", ".pts"), 70
    ),
}


@pytest.fixture(scope="module")
def examples(tmp_path_factory) -> list[Path]:
    """Return all example files, after writing them."""
    for package in ("mcap_ros2", "open3d", "pypcd4"):
        pytest.importorskip(package, reason=LIBRARIES)
    folder = tmp_path_factory.mktemp("clouds")
    options = ["-n", "0", "-m", "", "-p", "no:cacheprovider", "-p", "tests.recorded_clouds"]
    options += ["-o", "faulthandler_timeout=7200"]
    # If one of these tests fails, the files that the tests read are compared all the same.
    subprocess.run(
        [sys.executable, "-m", "pytest", "-q", *options, *OTHER_TESTS],
        cwd=PROJECT,
        env=os.environ | {"FOLDER_OF_CLOUDS": str(folder)},
    )
    write_with_open3d(folder)
    write_with_pypcd4(folder)
    return [*sorted(folder.iterdir()), PROJECT / "data" / "cloud.txt", *sorted(REAL.rglob("*.*"))]


def random_points() -> np.ndarray:
    points = np.random.default_rng(3).normal(scale=20, size=(50, 4)).astype(np.float32)
    points[:, 3] = abs(points[:, 3])
    return points


def write_with_open3d(folder: Path) -> None:
    import open3d

    tensor = open3d.core.Tensor
    for suffix, kind, is_text, is_compressed in itertools.product(
        ("pcd", "ply", "xyz", "pts"), (np.float32, np.float64), (False, True), (False, True)
    ):
        points = random_points().astype(kind)
        cloud = open3d.t.geometry.PointCloud(tensor(points[:, :3]))
        cloud.point["intensity"] = tensor(points[:, 3:])
        name = f"open3d_{points.dtype}_{is_text:d}{is_compressed:d}.{suffix}"
        open3d.t.io.write_point_cloud(
            str(folder / name), cloud, write_ascii=is_text, compressed=is_compressed
        )


def write_with_pypcd4(folder: Path) -> None:
    import pypcd4

    for encoding in pypcd4.Encoding:
        cloud = pypcd4.PointCloud.from_xyzi_points(random_points())
        cloud.save(folder / f"pypcd4_{encoding.value}.pcd", encoding=encoding)


def assert_same_points(ours: np.ndarray, theirs: np.ndarray, name: str) -> None:
    """Compare all columns that both readers return, as float32 if one of them returns it."""
    columns = min(ours.shape[1], theirs.shape[1])
    precision = min(ours.dtype, theirs.dtype, key=lambda kind: kind.itemsize)
    with np.errstate(over="ignore"):
        pair = [cloud[:, :columns].astype(precision) for cloud in (ours, theirs)]
    np.testing.assert_array_equal(*pair, err_msg=name)


@pytest.mark.filterwarnings("ignore:loadtxt")
@pytest.mark.parametrize("library", READERS)
def test_clouds_have_the_same_points_as_in_other_libraries(examples, library):
    read, suffixes, fewest = READERS[library]
    compared = 0
    for path in examples:
        if path.suffix.lower() not in suffixes:
            continue
        try:
            ours = read_cloud(path)
            theirs = read(path)
        except Exception:  # one of the two does not read the file
            continue
        if len(theirs) and theirs.shape[1] >= 3:  # otherwise the library found no points
            assert_same_points(ours, theirs, path.name)
            compared += 1
    print(f"{library}: {compared} files")
    assert compared >= fewest


def messages_of_rosbags(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield the topic and content of each message with points."""
    kinds = (POINT_CLOUD, *LIVOX)
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, _, data in reader.messages():
            if connection.msgtype in kinds:
                yield connection.topic, reader.deserialize(data, connection.msgtype)


def messages_of_mcap(path: Path) -> Iterator[tuple[str, Any]]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for schema, channel, _, message in reader.iter_decoded_messages():
            if schema.name in (POINT_CLOUD, *LIVOX):
                yield channel.topic, message


def points_of_message(message: Any) -> np.ndarray:
    import pypcd4

    if hasattr(message, "points"):  # of Livox
        points = [(point.x, point.y, point.z, point.reflectivity) for point in message.points]
        return np.array(points, np.float32).reshape(-1, 4)
    return points_of(pypcd4.PointCloud.from_msg(message))


@pytest.mark.parametrize(
    ("messages", "suffixes", "fewest"),
    [(messages_of_rosbags, (".bag", ".db3", ".mcap"), 50), (messages_of_mcap, (".mcap",), 12)],
)
def test_recordings_have_the_same_points_as_in_other_libraries(
    examples, messages, suffixes, fewest
):
    compared = 0
    for path in examples:
        if path.suffix not in suffixes:
            continue
        places = Counter()
        try:
            for topic, message in messages(path):
                ours = read_bag(path, topic)[places[topic]]
                places[topic] += 1
                assert_same_points(ours, points_of_message(message), f"{path.name} {places}")
                compared += 1
        except AssertionError:
            raise
        except Exception:  # a message that one of the two does not read; the rest is not compared
            continue
    print(f"{messages.__name__}: {compared} messages")
    assert compared >= fewest


@pytest.mark.skipif(not REAL.is_dir(), reason=RECORDINGS)
def test_recorded_scans_are_among_the_examples(examples):
    assert {".pcd", ".bin"} <= {path.suffix for path in examples if path.is_relative_to(REAL)}
