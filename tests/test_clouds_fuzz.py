"""A reader returns a cloud or raises CloudFileError, whatever bytes a file contains.

The inputs are random bytes, and small files of every format that were truncated, overwritten,
repeated or filled with extreme numbers. A reader must not warn, raise other exceptions, or use more
memory than the size of the file justifies.
"""

import io
import struct
import tracemalloc
import warnings

import laspy
import numpy as np
import plyfile
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore

from utils.clouds import CloudFileError
from utils.clouds.kitti import decode_kitti
from utils.clouds.libraries import decode_las, decode_ply
from utils.clouds.npz import decode_npy, decode_npz, encode_npy, encode_npz
from utils.clouds.pcd import decode_pcd, encode_pcd
from utils.clouds.pcd_header import ENCODINGS
from utils.clouds.text import decode_text, encode_text
from utils.recordings import (
    read_bag,
    read_calibration,
    read_object_labels,
    read_tracking_labels,
    read_tracklets,
)

CLOUD = np.random.default_rng(0).normal(scale=9, size=(12, 4)).astype(np.float32)
CLOUD[3:6] = 0  # zeros, which LZF and deflate can compress
EXTREME = [
    *(struct.pack(kind, value) for kind in ("<I", ">I") for value in (0, 1, 2**31, 2**32 - 1)),
    *(struct.pack("<Q", value) for value in (10**12, 2**62, 2**64 - 1)),
    *(b"0", b"-1", b"nan", b"1e999", b"1000000000000", b"9" * 400, b"\n", b"\0", b",,", b"\xff"),
]


def stored_bytes(**arrays) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def ply_bytes(text: bool) -> bytes:
    vertices = np.zeros(len(CLOUD), [(name, "<f4") for name in ("x", "y", "z", "intensity")])
    for column, name in enumerate(vertices.dtype.names):
        vertices[name] = CLOUD[:, column]
    buffer = io.BytesIO()
    element = plyfile.PlyElement.describe(vertices, "vertex")
    plyfile.PlyData([element], text=text, byte_order="=" if text else "<").write(buffer)
    return buffer.getvalue()


def las_bytes() -> bytes:
    las = laspy.LasData(laspy.LasHeader(point_format=0))
    las.x, las.y, las.z = CLOUD[:, :3].T
    buffer = io.BytesIO()
    las.write(buffer)
    return buffer.getvalue()


READERS = {
    "text": (decode_text, [encode_text(CLOUD), encode_text(CLOUD[:, :3], ","), b"x y z\n1 2 3\n"]),
    "kitti": (decode_kitti, [CLOUD.tobytes(), np.tile(abs(CLOUD), (3, 1)).tobytes()]),
    "pcd": (decode_pcd, [encode_pcd(CLOUD, encoding) for encoding in ENCODINGS]),
    "npz": (decode_npz, [encode_npz(CLOUD), stored_bytes(cloud=CLOUD.astype(float), other=CLOUD)]),
    "npy": (decode_npy, [encode_npy(CLOUD)]),
    "ply": (decode_ply, [ply_bytes(text=True), ply_bytes(text=False)]),
    "las": (decode_las, [las_bytes()]),
}


@st.composite
def damaged_file(draw, files):
    """Draw a file with damage in a few places, or random bytes."""
    data = bytearray(draw(st.sampled_from(files) | st.binary(max_size=200)))
    for _ in range(draw(st.integers(0, 4))):
        first = draw(st.integers(0, len(data)))
        last = min(len(data), first + draw(st.integers(0, 40)))
        piece = draw(st.sampled_from(EXTREME) | st.binary(max_size=8))
        match draw(st.sampled_from(["overwrite", "insert", "delete", "repeat", "cut"])):
            case "overwrite":
                data[first : first + len(piece)] = piece
            case "insert":
                data[first:first] = piece
            case "delete":
                del data[first:last]
            case "repeat":
                data[first:first] = data[first:last] * draw(st.integers(1, 50))
            case "cut":
                del data[first:]
    return bytes(data)


@pytest.fixture(scope="module", autouse=True)
def import_everything(tmp_path_factory):
    """Read intact files first, so that memory for late imports is not attributed to a reader."""
    for decode, files in READERS.values():
        for data in files:
            decode(data, "whole")
    folder = tmp_path_factory.mktemp("whole")
    contents = {
        "calibration": CALIBRATION,
        "object": LABEL,
        "tracking": b"0 1 " + LABEL,
        "tracklets": TRACKLETS,
    }
    for name, data in contents.items():
        (folder / name).write_bytes(data)
    calibration = read_calibration(folder / "calibration")
    read_object_labels(folder / "object", calibration)
    read_tracking_labels(folder / "tracking", calibration)
    read_tracklets(folder / "tracklets")


def check(read, size: int):
    """Call a reader on a file of `size` bytes; return its cloud, or None if it refuses the file."""
    tracemalloc.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            # An earlier test of a lesson may have left a file open.
            warnings.simplefilter("ignore", ResourceWarning)
            result = read()
    except CloudFileError as error:
        result = None
        assert str(error) and len(str(error)) < 1000
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak < 600_000 + 100 * size
    return result


def check_bytes(reader: str, data: bytes) -> None:
    decode = READERS[reader][0]
    cloud = check(lambda: decode(data, "fuzz"), len(data))
    if cloud is not None:
        assert cloud.ndim == 2 and cloud.shape[1] in (3, 4)
        assert cloud.dtype in (np.float32, np.float64) and cloud.flags.writeable


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_files_with_any_content_are_read_or_refused(reader):
    @settings(max_examples=250, deadline=None)
    @given(damaged_file(READERS[reader][1]))
    def property_holds(data):
        check_bytes(reader, data)

    property_holds()


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_many_files_with_any_content_are_read_or_refused(reader):
    @settings(max_examples=1_500, deadline=None, suppress_health_check=list(HealthCheck))
    @given(damaged_file(READERS[reader][1]))
    def property_holds(data):
        check_bytes(reader, data)

    property_holds()


def changed_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Truncate a file, or change one to three bytes or numbers in its first 400 bytes."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        start = int(rng.integers(min(len(data), 400)))
        piece = EXTREME[rng.integers(len(EXTREME))] if rng.random() < 0.5 else rng.bytes(1)
        changed[start : start + len(piece)] = piece
    return bytes(changed[: rng.integers(len(data))] if rng.random() < 0.2 else changed)


@pytest.mark.proof
@pytest.mark.parametrize("reader", READERS)
def test_a_hundred_thousand_changed_headers_are_read_or_refused(reader):
    decode, files = READERS[reader]
    rng = np.random.default_rng(1)
    outcomes = {True: 0, False: 0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for number in range(100_000):
            data = changed_bytes(files[number % len(files)], rng)
            try:
                outcomes[decode(data, "fuzz").shape[1] in (3, 4)] += 1
            except CloudFileError as error:
                outcomes[len(str(error)) < 1000] += 1
    assert outcomes == {True: 100_000, False: 0}


@pytest.mark.parametrize("data", [b"\x0b,", b"1 2 3\n\x0c;\n", "\u2003,".encode()])
def test_the_error_about_an_empty_field_names_the_column(data):
    with pytest.raises(CloudFileError, match="found nothing in column 1, expected a number"):
        decode_text(data)


@pytest.mark.parametrize("reader", READERS)
def test_truncated_files_are_read_or_refused(reader):
    for data in READERS[reader][1]:
        for length in range(0, len(data), 1 + len(data) // 300):
            check_bytes(reader, data[:length])


WORDS = [*"013\n ,;#", "-1", "nan", "inf", "1e9", "abc", "x y z", "DATA ascii\n", "FIELDS x y z\n",
         "SIZE 4 4 4\n", "TYPE F F F\n", "WIDTH 3\n", "POINTS 1\n"]  # fmt: skip


@settings(max_examples=300, deadline=None)
@given(st.lists(st.sampled_from(WORDS), max_size=30))
@example(["\x0b,"])  # numpy.loadtxt treated this as an empty file and warned
@example(["1", "\n", "\n", "0", "0", "0"])  # an empty line follows the number of points
def test_texts_of_likely_words_are_read_or_refused(words):
    data = " ".join(words).encode()
    check_bytes("text", data)
    check_bytes("pcd", data)


CALIBRATION = b"""P2: 700 0 600 45 0 700 180 -0.3 0 0 1 0.005
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0 0 0 -1 -0.08 1 0 0 -0.27
"""
LABEL = b"Car 0.00 0 1.9 500 150 600 250 1.5 1.6 4.0 -2.0 1.65 9.73 -1.57\n"
TRACKLETS = b"""<boost_serialization><tracklets><count>1</count><item><objectType>Car</objectType>
<h>1.5</h><w>1.6</w><l>4</l><first_frame>1</first_frame><poses><count>1</count>
<item><tx>5.0</tx><ty>1</ty><tz>-1.7</tz><rz>0.25</rz></item></poses></item></tracklets>
</boost_serialization>"""


@settings(max_examples=250, deadline=None, suppress_health_check=list(HealthCheck))
@given(data=damaged_file([CALIBRATION, LABEL * 2, b"0 1 " + LABEL, TRACKLETS]))
def test_labels_and_calibration_with_any_content_are_read_or_refused(tmp_path_factory, data):
    folder = tmp_path_factory.getbasetemp()
    (folder / "good.txt").write_bytes(CALIBRATION)
    calibration = read_calibration(folder / "good.txt")
    path = folder / "fuzz.txt"
    path.write_bytes(data)
    check(lambda: read_calibration(path), len(data))
    check(lambda: read_object_labels(path, calibration), len(data))
    check(lambda: read_tracking_labels(path, calibration), len(data))
    check(lambda: read_tracklets(path), len(data))


def recording(folder, kind: str) -> bytes:
    """Return the bytes of a recording of two clouds, as a ROS 1 bag, SQLite or MCAP file."""
    ros1 = kind == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.LATEST)
    cloud, field, header, time = (
        store.types[name]
        for name in (
            "sensor_msgs/msg/PointCloud2",
            "sensor_msgs/msg/PointField",
            "std_msgs/msg/Header",
            "builtin_interfaces/msg/Time",
        )
    )
    if ros1:
        writer = Writer1(folder / "seed.bag")
    else:
        plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
        writer = Writer2(folder / "seed", version=9, storage_plugin=plugin)
    with writer:
        topic = writer.add_connection("/points", cloud.__msgtype__, typestore=store)
        for moment in (1, 2):
            message = cloud(
                header=header(stamp=time(0, 0), frame_id="", **({"seq": 0} if ros1 else {})),
                height=1,
                width=len(CLOUD),
                fields=[field(name, 4 * place, 7, 1) for place, name in enumerate("xyzi")],
                is_bigendian=False,
                point_step=16,
                row_step=16 * len(CLOUD),
                data=np.frombuffer(CLOUD.tobytes(), np.uint8),
                is_dense=True,
            )
            pack = store.serialize_ros1 if ros1 else store.serialize_cdr
            writer.write(topic, moment, pack(message, cloud.__msgtype__))
    return next(folder.rglob(f"seed*.{kind}")).read_bytes()


def fuzz_recordings(folder, kind: str, examples: int) -> None:
    path = folder / f"fuzz.{kind}"

    def read():
        clouds = list(read_bag(path))
        assert all(cloud.ndim == 2 and cloud.shape[1] in (3, 4) for cloud in clouds)
        return clouds

    seed = recording(folder, kind)
    path.write_bytes(seed)
    assert len(read()) == 2  # also imports rosbags, before memory is measured

    @settings(max_examples=examples, deadline=None, suppress_health_check=list(HealthCheck))
    @given(damaged_file([seed]))
    def property_holds(data):
        path.write_bytes(data)
        check(read, len(data))

    property_holds()


@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
def test_recordings_with_any_content_are_read_or_refused(tmp_path, kind):
    fuzz_recordings(tmp_path, kind, examples=60)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["bag", "db3", "mcap"])
def test_many_recordings_with_any_content_are_read_or_refused(tmp_path, kind):
    fuzz_recordings(tmp_path, kind, examples=600)
