"""The choice of a format by suffix, the binary formats, and the messages about bad files.

The tests build files byte by byte, independently of the writers that they test.
"""

import io
import os
import pickle
import struct
import subprocess
import sys
import tracemalloc
import zipfile
from pathlib import Path

import laspy
import numpy as np
import plyfile
import pytest

from grader.course.paths import PROJECT
from tests.prerequisites import RECORDINGS
from utils.clouds import SUFFIXES, CloudFileError, read_cloud, write_cloud
from utils.clouds.formats import WRITABLE_SUFFIXES
from utils.clouds.kitti import decode_kitti
from utils.clouds.libraries import decode_las, decode_ply
from utils.clouds.npz import decode_npz

REAL = Path(os.environ.get("REAL_CLOUDS", "/nowhere"))
POINTS = [(1.5, -2.25, 0.125, 0.5), (-30.0, 4.0, -1.75, 0.0), (0.0, 0.0, 0.0, 1.0)]


def message_of(call, *arguments):
    """Return the message of the CloudFileError that `call` must raise."""
    with pytest.raises(CloudFileError) as caught:
        call(*arguments)
    return str(caught.value)


@pytest.mark.parametrize("suffix", WRITABLE_SUFFIXES)
@pytest.mark.parametrize("columns", [3, 4])
@pytest.mark.parametrize("rows", [0, 1, 200])
def test_every_format_keeps_the_numbers(tmp_path, suffix, columns, rows):
    cloud = np.random.default_rng(1).normal(size=(rows, columns)).astype(np.float32)
    cloud[:, 3:] = abs(cloud[:, 3:])  # an intensity
    before = cloud.copy()
    write_cloud(str(tmp_path / f"cloud{suffix}"), cloud)
    again = read_cloud(str(tmp_path / f"cloud{suffix}"))
    np.testing.assert_array_equal(cloud, before)
    np.testing.assert_array_equal(again[:, :columns].astype(np.float32), cloud)
    assert again.shape[1] == (4 if suffix == ".bin" else columns)
    assert again.flags.writeable and again.flags.c_contiguous
    assert [path.name for path in tmp_path.iterdir()] == [f"cloud{suffix}"]


@pytest.mark.parametrize("suffix", [".pcd", ".npz", ".npy", ".txt"])
def test_double_precision_is_kept_if_the_format_allows_it(tmp_path, suffix):
    cloud = np.array([[1 / 3, 2 / 3, 1e-12], [np.nan, np.inf, -0.0]])
    write_cloud(tmp_path / f"cloud{suffix}", cloud)
    np.testing.assert_array_equal(read_cloud(tmp_path / f"cloud{suffix}"), cloud)


def test_only_lists_and_arrays_of_numbers_can_be_written(tmp_path):
    write_cloud(tmp_path / "a.txt", [[1, 2, 3]])
    assert (tmp_path / "a.txt").read_text() == "1.0 2.0 3.0\n"
    assert "shape (3,)" in message_of(write_cloud, tmp_path / "b.txt", [1, 2, 3])
    assert "(2, 5)" in message_of(write_cloud, tmp_path / "b.txt", np.zeros((2, 5)))
    assert "array of numbers" in message_of(write_cloud, tmp_path / "b.txt", [["x", "y", "z"]])
    assert "cannot be written" in message_of(
        write_cloud, tmp_path / "none" / "b.txt", np.zeros((1, 3))
    )
    assert not (tmp_path / "b.txt").exists()


def test_the_error_about_a_missing_file_names_folders_and_existing_files(tmp_path):
    (tmp_path / "street.pcd").touch()
    (tmp_path / "notes.md").touch()
    message = message_of(read_cloud, tmp_path / "cloud.txt")
    assert "cloud.txt" in message and str(tmp_path) in message
    assert "street.pcd" in message and "notes.md" not in message
    assert "no cloud files there" in message_of(read_cloud, tmp_path / "none" / "cloud.txt")


def test_errors_explain_folders_unknown_suffixes_and_strange_names(tmp_path):
    assert "read_sequence" in message_of(read_cloud, tmp_path)
    message = message_of(read_cloud, tmp_path / "cloud.e57")
    assert ".e57" in message and ".pcd" in message
    message = message_of(write_cloud, tmp_path / "cloud.ply", np.zeros((1, 3)))
    assert ".ply files can only be read" in message and ".pcd" in message
    assert "no suffix" in message_of(read_cloud, "cloud")
    assert "cannot be opened" in message_of(read_cloud, "a\0b.txt")
    assert "cannot be opened" in message_of(read_cloud, "a" * 5000 + ".txt")


def test_errors_survive_a_process_pool():
    error = pickle.loads(pickle.dumps(CloudFileError("street.txt: cut off.")))
    assert isinstance(error, ValueError) and str(error) == "street.txt: cut off."


def test_importing_clouds_loads_no_heavy_packages():
    code = "import sys, utils.clouds, utils.datasets; print(*sys.modules)"
    modules = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {
        "scipy",
        "pooch",
        "rosbags",
        "matplotlib",
        "rich",
        "requests",
        "laspy",
        "plyfile",
    } & set(modules)


OTHER_CONTENTS = {
    b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 9\n": "Git LFS pointer",
    b"\n<!DOCTYPE html>\n<html>\n": "web page",
    b"\xef\xbb\xbf<?xml version='1.0'?>": "web page or XML",
    b"\x1f\x8b\x08\x00\x00\x00\x00\x00": "gzip",
    b"CCB2\x00\x01\x00\x00": "CloudCompare",
    b"\x93NUMPY\x01\x00": "NumPy array",
    b"# .PCD v0.7 - Point Cloud Data file format\n": "PCD file",
    b"ply\nformat ascii 1.0\n": "PLY file",
    b"LASF\x00\x00": "LAS file",
    b"PK\x03\x04\x14\x00": "zip archive",
}


@pytest.mark.parametrize("content", OTHER_CONTENTS)
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_of_another_kind_is_recognised(tmp_path, suffix, content):
    (tmp_path / f"street{suffix}").write_bytes(content)
    message = message_of(read_cloud, tmp_path / f"street{suffix}")
    own = {
        ".npy": "NumPy",
        ".pcd": "PCD",
        ".ply": "PLY",
        ".las": "LAS",
        ".laz": "LAS",
        ".npz": "zip",
    }
    if not OTHER_CONTENTS[content].startswith(own.get(suffix, "none")):
        assert OTHER_CONTENTS[content] in message


class TestLibraries:
    """PLY and LAS files, written by the libraries that also read them."""

    points = np.random.default_rng(2).normal(scale=20, size=(40, 4)).round(2)

    @pytest.mark.parametrize("text", [False, True])
    @pytest.mark.parametrize("intensity", ["intensity", "scalar_Intensity", "reflectance"])
    def test_ply_files_are_read_by_the_names_of_their_properties(self, tmp_path, text, intensity):
        kinds = [("red", "u1"), ("z", "f8"), ("y", "f4"), ("x", "f4"), (intensity, "f4")]
        vertices = np.zeros(len(self.points), kinds)
        for column, name in enumerate(("x", "y", "z", intensity)):
            vertices[name] = self.points[:, column]
        faces = np.array([([0, 1, 2],)], dtype=[("vertex_indices", "i4", (3,))])
        elements = [
            plyfile.PlyElement.describe(vertices, "vertex"),
            plyfile.PlyElement.describe(faces, "face"),
        ]
        plyfile.PlyData(elements, text=text).write(str(tmp_path / "a.ply"))
        cloud = read_cloud(tmp_path / "a.ply")
        assert cloud.dtype == np.float64
        np.testing.assert_allclose(cloud, self.points, atol=1e-5)

    def test_las_files_are_read_and_the_error_about_laz_files_suggests_a_fix(self, tmp_path):
        header = laspy.LasHeader(point_format=3)
        header.scales = (0.001,) * 3
        las = laspy.LasData(header)
        las.x, las.y, las.z = self.points[:, :3].T
        las.intensity = np.arange(len(self.points))
        las.write(str(tmp_path / "a.las"))
        cloud = read_cloud(tmp_path / "a.las")
        np.testing.assert_allclose(cloud[:, :3], self.points[:, :3], atol=1e-6)
        np.testing.assert_array_equal(cloud[:, 3], np.arange(len(self.points)))
        data = bytearray((tmp_path / "a.las").read_bytes())
        data[104] |= 0x80  # the flag of compressed points
        (tmp_path / "a.laz").write_bytes(data)
        assert "pdal translate" in message_of(read_cloud, tmp_path / "a.laz")

    @pytest.mark.parametrize(
        ("data", "parts"),
        [
            (b"ply\nformat ascii 1.0\nelement vertex 999999999999\nend_header\n", ["999999999999"]),
            (
                b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n1\n",
                ["intact"],
            ),
            (
                b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                ["'y'"],
            ),
        ],
    )
    def test_errors_explain_unsuitable_ply_files(self, data, parts):
        message = message_of(decode_ply, data, "a.ply")
        for part in ("a.ply", *parts):
            assert part in message

    @pytest.mark.parametrize(
        ("decode", "module", "package"),
        [(decode_ply, "plyfile", "'plyfile'"), (decode_las, "laspy", "'laspy'")],
    )
    def test_the_error_names_a_missing_library(self, monkeypatch, decode, module, package):
        monkeypatch.setitem(sys.modules, module, None)
        assert f"pip install {package}" in message_of(decode, b"")


class TestKitti:
    scan = np.loadtxt(PROJECT / "data" / "cloud.txt", max_rows=30_000)[::30]

    def test_files_of_nuscenes_are_recognised(self):
        beams = np.arange(len(self.scan)) % 32
        data = np.column_stack([self.scan[:, :3], 255 * self.scan[:, 3], beams]).astype("<f4")
        read = decode_kitti(data.tobytes(), "LIDAR_TOP.pcd.bin")
        np.testing.assert_array_equal(read, data[:, :4])
        np.testing.assert_array_equal(decode_kitti(data.tobytes(), "000000.bin"), data[:, :4])

    @pytest.mark.parametrize(
        ("kind", "columns", "parts"),
        [
            ("<f4", 3, ["3 columns of float32", "'<f4'", "reshape(-1, 3)"]),
            ("<f4", 6, ["6 columns of float32", "reshape(-1, 6)"]),
            ("<f8", 4, ["4 columns of float64", "'<f8'"]),
            ("<f8", 3, ["3 columns of float64"]),
            (">f4", 4, ["4 columns of float32 in big-endian order", "'>f4'"]),
        ],
    )
    def test_the_error_about_other_records_guesses_their_type(self, kind, columns, parts):
        extra = np.random.default_rng(0).random((len(self.scan), 2))
        data = np.column_stack([self.scan, extra])[:, :columns].astype(kind)
        message = message_of(decode_kitti, data.tobytes(), "a.bin")
        for part in ("a.bin", "not a KITTI scan", *parts):
            assert part in message

    @pytest.mark.parametrize("factor", [1e9, 1e-15])
    def test_absurd_coordinates_are_not_read_as_points(self, factor):
        data = (self.scan * [factor, factor, factor, 1]).astype("<f4").tobytes()
        assert "not a KITTI scan" in message_of(decode_kitti, data, "a.bin")

    def test_label_files_are_not_read_as_points(self):
        labels = np.random.default_rng(0).integers(1, 30, 4000).astype("<u4")
        assert "not a KITTI scan" in message_of(decode_kitti, labels.tobytes(), "a.bin")

    def test_records_are_read(self):
        data = b"".join(struct.pack("<4f", *point) for point in POINTS)
        np.testing.assert_array_equal(decode_kitti(data), POINTS)
        assert decode_kitti(data).dtype == np.float32
        assert decode_kitti(b"").shape == (0, 4)

    def test_the_error_about_a_truncated_file_names_the_byte(self):
        message = message_of(decode_kitti, bytes(16 * 3 + 5), "a.bin")
        assert "a.bin, byte 48" in message and "5 bytes" in message and "3 points" in message

    def test_text_in_a_binary_file_is_recognised(self):
        assert "the text '1.0 2.0" in message_of(decode_kitti, b"1.0 2.0 3.0 0.5\n" * 8)


class TestNpz:
    @staticmethod
    def archive(name="cloud", value=None, raw=None, method=zipfile.ZIP_DEFLATED):
        """Return an .npz archive with one array, or with the bytes `raw` instead."""
        if raw is None:
            stream = io.BytesIO()
            np.lib.format.write_array(stream, np.asarray(value), allow_pickle=True)
            raw = stream.getvalue()
        buffer = io.BytesIO()
        with zipfile.ZipFile(buffer, "w", method) as file:
            file.writestr(f"{name}.npy", raw)
        return buffer.getvalue()

    @staticmethod
    def header(shape, descr="<f8"):
        text = f"{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}"
        text += " " * (-(len(text) + 11) % 64) + "\n"
        return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()

    @pytest.mark.parametrize("kind", ["<f4", "<f8", ">f8", "<f2", "<i4", "u1"])
    def test_all_number_types_are_read(self, kind):
        values = np.arange(12).reshape(3, 4).astype(kind)
        cloud = decode_npz(self.archive(value=values))
        np.testing.assert_array_equal(cloud, np.arange(12).reshape(3, 4))
        assert cloud.dtype == (np.float32 if kind == "<f4" else np.float64)

    def test_columns_are_found_by_name_and_other_arrays_are_ignored(self):
        values = np.asfortranarray(np.arange(12.0).reshape(4, 3))
        np.testing.assert_array_equal(decode_npz(self.archive(value=values)), values)
        buffer = io.BytesIO()
        np.savez(buffer, truth=np.arange(4), cloud=values)
        np.testing.assert_array_equal(decode_npz(buffer.getvalue()), values)

    def test_errors_explain_unsuitable_content(self):
        zeros = np.zeros((2, 3))
        np.testing.assert_array_equal(decode_npz(self.archive("points", zeros)), zeros)
        two = io.BytesIO()
        np.savez(two, before=zeros, after=zeros, colours=np.zeros((2, 2)))
        message = message_of(decode_npz, two.getvalue())
        assert "'before', 'after'" in message and "colours" not in message
        flat = self.archive("points", np.zeros(6))
        assert "contains 'points', expected an array 'cloud'" in message_of(decode_npz, flat)
        assert "expected numbers" in message_of(decode_npz, self.archive(value=[["a", "b", "c"]]))
        assert "expected numbers" in message_of(decode_npz, self.archive(value=[[None] * 3]))
        assert "shape (3,)" in message_of(decode_npz, self.archive(value=np.zeros(3)))
        assert "(2, 5)" in message_of(decode_npz, self.archive(value=np.zeros((2, 5))))
        assert "intact .npz" in message_of(decode_npz, b"1 2 3\n")
        too_new = bytearray(self.archive(value=np.zeros((1, 3))))
        too_new[too_new.index(b"PK\1\2") + 6] = 255  # the version of ZIP needed to unpack
        assert "intact .npz" in message_of(decode_npz, bytes(too_new))
        assert "damaged" in message_of(decode_npz, self.archive(raw=b"no array"))

    def test_a_pickle_is_never_loaded(self):
        class Bomb:
            def __reduce__(self):
                return (pytest.fail, ("the pickle was loaded",))

        raw = np.array([[Bomb()] * 3], dtype=object)
        assert "expected numbers" in message_of(decode_npz, self.archive(value=raw))

    def test_damaged_archives_are_refused(self):
        data = self.archive(value=np.random.default_rng(0).normal(size=(500, 4)))
        for broken in (data[:-40], data[: len(data) // 2], data[100:]):
            message_of(decode_npz, broken)
        flipped = bytearray(data)
        flipped[2000] ^= 255
        assert "damaged" in message_of(decode_npz, bytes(flipped))

    @pytest.mark.parametrize("shape", [(10**12, 4), (-1, 4), (2**62, 3), (10**30, 4), (True, 3)])
    def test_archives_that_claim_a_huge_size_are_refused(self, shape):
        raw = self.header(shape) + bytes(96)
        assert peak_memory(message_of, decode_npz, self.archive(raw=raw)) < 5e6

    def test_a_zip_bomb_of_zeros_is_not_unpacked(self):
        zeros = bytes(200_000_000)
        data = self.archive(raw=self.header((200_000_000 // 32, 4)) + zeros)
        del zeros
        assert len(data) < 400_000
        assert peak_memory(message_of, decode_npz, data) < 5e6

    def test_a_nested_header_does_not_exhaust_the_parser(self):
        raw = self.header("(" * 9000 + ")" * 9000)
        assert "damaged" in message_of(decode_npz, self.archive(raw=raw))


def peak_memory(call, *arguments) -> int:
    """Call a function and return its peak memory in bytes."""
    tracemalloc.start()
    try:
        call(*arguments)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.skipif(not REAL.is_dir(), reason=RECORDINGS)
def test_real_recordings_are_read():
    first = read_cloud(REAL / "data_1" / "0000000000.pcd")
    assert first.shape == (119_978, 4) and first.dtype == np.float32
    np.testing.assert_allclose(first[0], [52.301, 7.3, 1.995, 0.12], atol=1e-6)
    assert (first[:, :3] == 0).all(axis=1).sum() == 1  # the one invalid return of each frame
    assert read_cloud(REAL / "simpleHighway.pcd").shape == (976, 3)
    frame = read_cloud(REAL / "kitti_000008.bin")
    assert frame.shape == (os.path.getsize(REAL / "kitti_000008.bin") // 16, 4)
    assert np.isfinite(frame).all() and frame[:, 3].min() >= 0 and frame[:, 3].max() <= 1
