"""PCD files written by hand, with layouts that the format allows and some that it does not."""

import os
import struct
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.prerequisites import RECORDINGS
from utils.clouds import CloudFileError, lzf, read_cloud
from utils.clouds.pcd import decode_pcd, encode_pcd
from utils.clouds.pcd_header import ENCODINGS

REAL = Path(os.environ.get("REAL_CLOUDS", "/nowhere"))
POINTS = [(1.5, -2.25, 0.125, 0.5), (-30.0, 4.0, -1.75, 0.0), (np.nan, 0.0, 0.0, 1.0)]


def header(points=3, encoding="binary", fields="x y z intensity", size="4 4 4 4", kind="F F F F",
         count="1 1 1 1", width=None, height=1, **lines):  # fmt: skip
    """Return the header of a PCD file; keywords replace lines, or remove them if None."""
    entries = {
        "VERSION": "0.7",
        "FIELDS": fields,
        "SIZE": size,
        "TYPE": kind,
        "COUNT": count,
        "WIDTH": points if width is None else width,
        "HEIGHT": height,
        "VIEWPOINT": "0 0 0 1 0 0 0",
        "POINTS": points,
        "DATA": encoding,
    } | lines
    text = "".join(f"{key} {value}\n" for key, value in entries.items() if value is not None)
    return b"# .PCD v0.7 - Point Cloud Data file format\n" + text.encode()


def records(layout="<4f", points=POINTS):
    return b"".join(struct.pack(layout, *point) for point in points)


def literal_stream(data: bytes) -> bytes:
    """Return an LZF stream that consists only of literal runs."""
    runs = [data[start : start + 32] for start in range(0, len(data), 32)]
    return b"".join(bytes([len(run) - 1]) + run for run in runs)


def compressed_body(raw: bytes) -> bytes:
    packed = literal_stream(raw)
    return struct.pack("<II", len(packed), len(raw)) + packed


def error_message(data: bytes) -> str:
    with pytest.raises(CloudFileError) as caught:
        decode_pcd(data, "a.pcd")
    assert str(caught.value).startswith("a.pcd")
    return str(caught.value)


def test_binary_files_are_read():
    cloud = decode_pcd(header() + records())
    np.testing.assert_array_equal(cloud, POINTS)
    assert cloud.dtype == np.float32 and cloud.flags.writeable


def test_ascii_files_are_read():
    rows = b"1.5 -2.25 0.125 0.5\n-30 4 -1.75 0\r\nnan 0 0 1\n\n"
    np.testing.assert_array_equal(decode_pcd(header(encoding="ascii") + rows), POINTS)


def test_compressed_files_are_read():
    by_field = np.array(POINTS, "<f4").T.tobytes()
    data = header(encoding="binary_compressed") + compressed_body(by_field)
    np.testing.assert_array_equal(decode_pcd(data), POINTS)


@pytest.mark.parametrize("encoding", ["binary", "ascii", "binary_compressed"])
def test_any_field_layout_is_read(encoding):
    layout = {
        "fields": "rgb z _ intensity normal x y",
        "size": "4 8 1 2 4 4 8",
        "kind": "U F U U F F F",
        "count": "1 1 3 1 2 1 1",
        "encoding": encoding,
    }
    rows = [(7, z, 9, 9, 9, int(i * 2), 5.0, 6.0, x, y) for x, y, z, i in POINTS]
    body = {
        "binary": records("<Id3BH2ffd", rows),
        "ascii": b"".join(" ".join(map(str, row)).encode() + b"\n" for row in rows),
        "binary_compressed": compressed_body(
            b"".join(
                b"".join(struct.pack("<" + kind, *row[first:last]) for row in rows)
                for kind, first, last in [
                    ("I", 0, 1),
                    ("d", 1, 2),
                    ("3B", 2, 5),
                    ("H", 5, 6),
                    ("2f", 6, 8),
                    ("f", 8, 9),
                    ("d", 9, 10),
                ]
            )
        ),
    }[encoding]
    cloud = decode_pcd(header(**layout) + body)
    assert cloud.dtype == np.float64
    np.testing.assert_array_equal(cloud, np.array(POINTS) * [1, 1, 1, 2])


def test_integers_without_intensity_and_old_field_names_are_read():
    data = header(fields=None, COLUMNS=None, size="2 2 2", kind="I I I", count=None)
    data = data.replace(b"SIZE", b"FIELDS X Y Z\nSIZE") + struct.pack("<9h", *range(-4, 5))
    np.testing.assert_array_equal(decode_pcd(data), np.arange(-4, 5).reshape(3, 3))


@pytest.mark.parametrize(
    "counts",
    [{"POINTS": None}, {"WIDTH": None, "HEIGHT": None}, {"POINTS": 5}, {"WIDTH": 7},
     {"WIDTH": 1, "HEIGHT": 3}, {"HEIGHT": None}],
)  # fmt: skip
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_the_body_decides_if_counts_in_the_header_disagree(counts, encoding):
    cloud = np.array(POINTS, np.float32)
    body = encode_pcd(cloud, encoding).split(f"DATA {encoding}\n".encode(), 1)[1]
    np.testing.assert_array_equal(decode_pcd(header(encoding=encoding, **counts) + body), POINTS)


def test_padding_after_the_points_is_ignored():
    np.testing.assert_array_equal(decode_pcd(header() + records() + bytes(3906)), POINTS)
    np.testing.assert_array_equal(decode_pcd(header() + records() + b"\n"), POINTS)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("shape", [(0, 3), (0, 4), (1, 3), (500, 4)])
def test_written_files_are_read_back(encoding, dtype, shape):
    cloud = np.random.default_rng(2).normal(scale=20, size=shape).astype(dtype)
    decoded = decode_pcd(encode_pcd(cloud, encoding))
    assert decoded.dtype == dtype and decoded.shape == shape
    np.testing.assert_array_equal(decoded, cloud)


def test_writing_refuses_an_unknown_encoding():
    with pytest.raises(ValueError, match="binary_compressed"):
        encode_pcd(np.zeros((1, 3)), "zip")


@pytest.mark.parametrize(
    ("data", "parts"),
    [
        (b"", ["header", "FIELDS"]),
        (bytes(range(256)) * 40, ["header", "FIELDS"]),
        (b"1 2 3\n4 5 6\n", ["header", "FIELDS"]),
        (header(encoding="binary_lz4"), ["line 11", "'binary_lz4'", "binary_compressed"]),
        (header(fields="x y intensity w"), ["line 3", "field 'z'"]),
        (header(width="nan"), ["line 7", "WIDTH 'nan'", "whole number"]),
        (header(points=-3), ["line 10", "POINTS '-3'"]),
        (header(POINTS="3 3"), ["POINTS '3 3'", "1 whole number"]),
        (header(POINTS="9" * 5000), ["whole number"]),
        (header(size="4 4 4"), ["line 4", "4 whole numbers"]),
        (header(size="4 4 4 3"), ["line 5", "TYPE"]),
        (header(kind="F F F"), ["line 5", "TYPE"]),
        (header(kind="F F F Q"), ["line 5", "TYPE"]),
        (header(count="2 1 1 1"), ["line 6", "COUNT"]),
        (header(POINTS=None, WIDTH=None), ["POINTS and WIDTH are missing"]),
        (header() + records()[:-1], ["byte", "3 points of 16 bytes", "47 bytes follow"]),
        (header(points=2) + records(), ["2 points", "48 bytes follow"]),
        (header() + b"1.5 -2.25 0.125 0.5\n" * 3, ["line 12", "the text '1.5 -2.25", "DATA ascii"]),
        (header(points=10**12) + records(), ["1000000000000 points"]),
        (header(points=10**12, encoding="ascii") + b"1 2 3 4\n", ["1000000000000 points, but"]),
        (header(count=f"1 1 1 {10**12}") + records(), ["4000000000012 bytes"]),
        (header(encoding="ascii") + b"1 2 3 4\n1 2 3\n1 2 3 4\n", ["line 13", "'1 2 3'", "4 num"]),
        (header(encoding="ascii") + b"1 2 3 4\n1 2 3 x\n1 2 3 4\n", ["line 13", "'1 2 3 x'"]),
        (header(encoding="ascii") + b"1 2 3 4\n", ["announces 3", "1 lines"]),
        (header(encoding="ascii") + records(), ["line"]),
        (header(encoding="binary_compressed") + b"\1\0", ["2 bytes follow"]),
        (header(encoding="binary_compressed") + struct.pack("<II", 99, 48) + bytes(9),
         ["99 compressed bytes", "9 follow"]),
        (header(encoding="binary_compressed") + struct.pack("<II", 9, 47) + bytes(9),
         ["3 points", "decompress to 47"]),
        (header(encoding="binary_compressed") + struct.pack("<II", 9, 48) + bytes(9), ["damaged"]),
        (header(encoding="binary_compressed") + struct.pack("<II", 3, 48) + b"\x20\x09\x00",
         ["damaged", "before the beginning"]),
        (header(points=2**28 - 1, encoding="binary_compressed")
         + struct.pack("<II", 9, 2**32 - 16) + bytes(9), ["decompress to 4294967280"]),
    ],
)  # fmt: skip
def test_errors_name_the_line_or_the_sizes(data, parts):
    tracemalloc.start()
    message = error_message(data)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    for part in parts:
        assert part in message
    assert peak < 2e6


class TestLzf:
    @pytest.mark.parametrize(
        ("packed", "raw"),
        [
            (b"", b""),
            (b"\x02abc", b"abc"),
            (b"\x02abc\x20\x02", b"abcabc"),  # a copy of the last three bytes
            (b"\x00a\xe0\xff\x00", b"a" * 265),  # the longest reference, which overlaps itself
            (b"\x01ab\x80\x01", b"abababab"),
        ],
    )
    def test_streams_written_by_hand_are_decompressed(self, packed, raw):
        assert lzf.decompress(packed, len(raw)) == raw

    @pytest.mark.parametrize("packed", [b"\x02ab", b"\x20", b"\xe0\x01", b"\x20\x00", b"\x00a"])
    def test_damaged_streams_raise_an_error(self, packed):
        with pytest.raises(ValueError):
            lzf.decompress(packed, 3)

    @given(st.lists(st.sampled_from([b"abc", b"a", b"\0" * 40, bytes(range(60))]), max_size=60))
    def test_decompressing_reverses_compressing(self, pieces):
        raw = b"".join(pieces)
        packed = lzf.compress(raw)
        assert lzf.decompress(packed, len(raw)) == raw
        assert len(packed) <= len(raw) * 33 // 32 + 1

    def test_repetition_compresses_well_but_not_over_long_distances(self):
        block = bytes(np.random.default_rng(0).integers(0, 256, 9000, dtype=np.uint8))
        assert len(lzf.compress(bytes(100_000))) < 1500
        assert lzf.decompress(lzf.compress(block * 2), 18_000) == block * 2
        assert len(lzf.compress(block[:8000] * 2)) < 8600


@pytest.mark.slow
@pytest.mark.skipif(not REAL.is_dir(), reason=RECORDINGS)
def test_real_frames_survive_every_encoding():
    cloud = read_cloud(REAL / "data_1" / "0000000005.pcd")
    for encoding in ENCODINGS:
        np.testing.assert_array_equal(decode_pcd(encode_pcd(cloud, encoding)), cloud)


@pytest.mark.parametrize(
    ("head", "body"),
    [
        (header().replace(b"FIELDS", b"COLUMNS"), records()),
        (header(SIZE=None, TYPE=None, COUNT=None), records()),
        (header(TYPE=None), records()),
        (header(encoding="BINARY"), records()),
        (b"\xef\xbb\xbf" + header(), records()),
        (header(), records() + b"made by me"),
        (header(fields="x y z _ intensity", size="4 4 4 1 4", kind="F F F U F", count="1 1 1 0 1"),
         records()),
    ],
)  # fmt: skip
def test_unusual_files_are_read_as_in_pcl(head, body):
    np.testing.assert_array_equal(decode_pcd(head + body), decode_pcd(header() + records()))


@pytest.mark.parametrize(
    ("lines", "advice"),
    [
        (b"1,5 2,5 3,5 4\n", "decimal points instead of commas"),
        (b"1 2 3 -nan(ind)\n", "write nan for a missing value"),
        (b"1 2 1.#QNAN 4\n", "write nan for a missing value"),
        (b"1 2 3 4\n1 2 3 car\n", "Correct or delete the line"),
        (b"# made by me\n1 2 3 4\n", "Correct or delete the line"),
        (b"1 2 3 4 5\n1 2 3 4\n", "or FIELDS and COUNT in the header"),
        (b"1 2 3 4\n1 2 3\n", "copied completely"),
    ],
)
def test_the_advice_about_a_faulty_line_fits_its_cause(lines, advice):
    assert advice in error_message(header(encoding="ascii") + lines)
