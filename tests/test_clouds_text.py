"""Clouds as text: all common notations are read, and errors explain why a file is not a cloud."""

import time

import numpy as np
import pytest

from utils.clouds import CloudFileError, read_cloud, write_cloud
from utils.clouds.text import decode_text, encode_text

THREE = [[1.0, 2.0, 3.0], [-4.0, 5.5, 6e-3]]
FOUR = [[1.0, 2.0, 3.0, 0.25], [-4.0, 5.5, 6e-3, 1.0]]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 2 3\n-4 5.5 6e-3\n", THREE),
        ("1 2 3 0.25\n-4 5.5 6e-3 1", FOUR),
        ("1,2,3\n-4,5.5,6e-3\n", THREE),
        ("1, 2, 3,\n-4 , 5.5, 6e-3,\n", THREE),
        ("1;2;3\n-4;5.5;6e-3\n", THREE),
        ("\t1\t2\t 3 \n\n  \n-4\t5.5\t6e-3\n\n", THREE),
        ("1 2 3\r\n-4 5.5 6e-3\r\n", THREE),
        ("1 2 3\r-4 5.5 6e-3\r", THREE),
        ("\ufeff1 2 3\n-4 5.5 6e-3\n", THREE),
        ("x y z intensity\n1 2 3 0.25\n-4 5.5 6e-3 1\n", FOUR),
        ("x,y,z\n1,2,3\n-4,5.5,6e-3\n", THREE),
        ('"x","y","z"\n"1","2","3"\n"-4","5.5","6e-3"\n', THREE),
        ("My scan 2024\nin Köln\n1 2 3\n-4 5.5 6e-3\n", THREE),
        ("# x y z\n1 2 3 # first\n# between\n-4 5.5 6e-3\n", THREE),
        ("//X Y Z Scalar_field\n1 2 3 0.25\n-4 5.5 6e-3 1\n", FOUR),
        ("% Matlab\n1 2 3\n-4 5.5 6e-3\n", THREE),
        ("//X Y Z\n2\n1 2 3\n-4 5.5 6e-3\n", THREE),
        ("VERSION 0.7\nFIELDS x y z\nDATA ascii\n1 2 3\n-4 5.5 6e-3\n", THREE),
        # Columns are found by their names.
        (",x,y,z\n0,1,2,3\n1,-4,5.5,6e-3\n", THREE),
        ("intensity x y z\n0.25 1 2 3\n1 -4 5.5 6e-3\n", FOUR),
        ("x [m];y [m];z [m];intensity\n1;2;3;0.25\n-4;5.5;6e-3;1\n", FOUR),
        ("X(m),Y(m),Z(m),I\n1,2,3,0.25\n-4,5.5,6e-3,1\n", FOUR),
        ("x,y,z,t\n1,2,3,1.7e9\n-4,5.5,6e-3,1.7e9\n", THREE),
        ("x,y,z,label\n1,2,3,car\n-4,5.5,6e-3,tree\n", THREE),
        ("x y z ring\n1 2 3 31\n-4 5.5 6e-3 30\n", THREE),
        ("r g b x y z\n9 9 9 1 2 3\n8 8 8 -4 5.5 6e-3\n", THREE),
        ("x,y,z,ring,intensity\n1,2,3,,0.25\n-4,5.5,6e-3,7,1\n", FOUR),
        ('"Points_m_XYZ:0","Points_m_XYZ:1","Points_m_XYZ:2","t"\n1,2,3,9\n-4,5.5,6e-3,9\n', THREE),
        # A remark above the columns, and headers of column numbers as pandas writes them
        ("# my cloud: x y z\n1 2 3\n-4 5.5 6e-3\n", THREE),
        ("0,1,2\n1.0,2.0,3.0\n-4,5.5,6e-3\n", THREE),
        (",0,1,2,3\n0,1.0,2.0,3.0,0.25\n1,-4,5.5,6e-3,1\n", FOUR),
        ("0 1 2\n3 4 5\n", [[0, 1, 2], [3, 4, 5]]),
        # Three columns of whole numbers are not an index column.
        ("0 1 2 3\n1 4 5 6\n2 7 8 9\n", [[0, 1, 2, 3], [1, 4, 5, 6], [2, 7, 8, 9]]),
        # .pts: the number of points, then x y z intensity red green blue
        ("2\n1 2 3 0.25 9 9 9\n-4 5.5 6e-3 1 8 8 8\n", FOUR),
        ("2\n1 2 3 9 9 9\n-4 5.5 6e-3 8 8 8\n", THREE),
    ],
)
def test_common_notations_are_read(text, expected):
    cloud = decode_text(text.encode())
    assert cloud.dtype == np.float64
    np.testing.assert_array_equal(cloud, expected)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "latin-1"])
def test_common_encodings_are_read(encoding):
    np.testing.assert_array_equal(decode_text("Höhe\n1 2 3\n-4 5.5 6e-3".encode(encoding)), THREE)


def test_missing_and_infinite_values_are_kept():
    cloud = decode_text(b"nan 1 2\n3 inf -inf\nNaN -nan 0\n")
    np.testing.assert_array_equal(cloud, [[np.nan, 1, 2], [3, np.inf, -np.inf], [np.nan] * 2 + [0]])


@pytest.mark.parametrize(
    ("text", "shape"),
    [("# x y z\n", (0, 3)), ("x,y,z,intensity\n\n", (0, 4)), ("0\n# nothing\n", (0, 4))],
)
def test_an_empty_cloud_needs_a_header(text, shape):
    assert decode_text(text.encode()).shape == shape


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("", ["street.txt", "no points", "x y z"]),
        ("\n \n# made by me\n", ["no points"]),
        ("1 2 3\n4 5 6\n7 abc 9\n", ["line 3", "'abc'", "column 2", "a number"]),
        ("x y z\n\n1 2 3\n\n4 5\n", ["line 5", "2 numbers", "expected 3", "cut off"]),
        ("1 2 3\n4 5 6 7\n", ["line 2", "4 numbers", "expected 3"]),
        ("1,2,3\n4,,6\n", ["line 2", "found nothing", "column 2", "nan"]),
        ("1,,2,3\n4,,5,6\n", ["line 1", "found nothing", "column 2"]),
        (",1,2,3\n,4,5,6\n", ["line 1", "found nothing", "column 1"]),
        ("1 2 3 4 5\n", ["line 1", "5 columns", "three or four", "intensity"]),
        ("1 2\n", ["line 1", "2 columns", "three or four"]),
        ("1\n2\n3\n", ["line 2", "1 column,"]),
        ("1,5;2,5;3,5\n", ["line 1", "decimal commas"]),
        ("1.O 2 3\n", ["line 1", "'1.O'"]),
        ("1_0 2 3\n", ["line 1", "'1_0'"]),
        ("0,1.5,2,3\n1,4,5,6\n2,7,8,9\n", ["line 1", "numbers the lines", "index column"]),
        ("3\n\n0 1.5 2 3\n1 4 5 6\n2 7 8 9\n", ["numbers the lines", "index column"]),
        ("x y z\n0 1.5 2 3\n1 4 5 6\n2 7 8 9\n", ["line 2", "numbers the lines"]),
        (
            "# mine\n1 2 3 1700000000.5\n4 5 6 1700000000.6\n",
            ["line 2", "1700000000.5 in column 4"],
        ),
        ("1 2 3 4278190080\n4 5 6 nan\n7 8 9 4278190335\n", ["line 1", "colours", "header line"]),
        ("z y x\n1 2 3 4\n", ["line 1", "3 columns 'z y x'", "4 numbers"]),
        ("lon,lat,alt\n13.4,52.5,34\n", ["line 1", "'lon lat alt'", "lat and lon are in degrees"]),
        ("Latitude Longitude height\n\n1 2 3\n", ["latitude and longitude", "x, y and z"]),
        ("1 2 3 4 5 6\n", ["line 1", "6 columns", "header line"]),
        ("12\t3\t-1,5\n", ["line 1", "decimal commas"]),
        ("1,37 -2,302 -4,59\n", ["line 1", "decimal commas"]),
        ("1,234.5\t2.0\t3.0\n", ["line 1", "decimal commas"]),
        ("[[1.5 2 3]\n [4 5 6]]\n", ["its first line is '[[1.5 2 3]'", "np.savetxt"]),
        ("v 1.5 2 3\nv 4 5 6\nf 1 2 3\n", ["no points", "its first line is 'v 1.5 2 3'"]),
        ("3\n1 2 3\n4 5 6\n", ["line 1", "the line announces 3 points, but 2 follow"]),
        ("1000000000000\n1 2 3\n", ["announces 1000000000000 points"]),
        ("1 2 3\n\0\0\0\n", ["binary", "text"]),
    ],
)
def test_errors_name_the_line(text, parts):
    with pytest.raises(CloudFileError) as caught:
        decode_text(text.encode(), "street.txt")
    message = str(caught.value)
    assert message.startswith("street.txt")
    for part in parts:
        assert part in message


@pytest.mark.parametrize("suffix", [".txt", ".csv", ".xyz", ".TXT"])
@pytest.mark.parametrize("columns", [3, 4])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("rows", [0, 1, 50])
def test_written_clouds_are_read_back_exactly(tmp_path, rng, suffix, columns, dtype, rows):
    cloud = rng.normal(scale=30, size=(rows, columns)).astype(dtype)
    write_cloud(tmp_path / f"cloud{suffix}", cloud)
    read = read_cloud(tmp_path / f"cloud{suffix}")
    assert read.shape == cloud.shape
    np.testing.assert_array_equal(read.astype(dtype), cloud)


def test_three_decimals_round_to_millimetres():
    text = encode_text(np.array([[1.23456, -2, 3e-9, 0.5]]), decimals=3)
    assert text == b"1.235 -2.000 0.000 0.500\n"


def test_a_full_scan_is_read_quickly(tmp_path, rng):
    cloud = rng.normal(scale=30, size=(120_000, 4)).round(3)
    (tmp_path / "cloud.txt").write_bytes(encode_text(cloud, decimals=3))
    started = time.process_time()
    read = read_cloud(tmp_path / "cloud.txt")
    assert time.process_time() - started < 10  # usually 0.1 s; with a loop over lines, a minute
    np.testing.assert_array_equal(read, cloud)


@pytest.fixture
def rng():
    return np.random.default_rng(3)
