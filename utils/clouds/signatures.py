"""Recognise what a file contains by its first bytes, whatever its suffix says."""

from typing import NamedTuple

from utils.clouds.errors import PRINTABLE, excerpt, file_error

LFS_POINTER = b"version https://git-lfs"


class Signature(NamedTuple):
    """First bytes of a kind of file, and the next step for a user who expected a cloud."""

    start: bytes
    kind: str
    advice: str
    suffixes: tuple[str, ...] = ()  # suffixes for which this kind is expected


SIGNATURES = (
    Signature(
        LFS_POINTER,
        "a Git LFS pointer instead of the file itself",
        "Run git lfs pull in its repository, or download the raw file.",
    ),
    Signature(b"\x93NUMPY", "a NumPy array", "Give the file the suffix .npy.", (".npy",)),
    Signature(
        b"PK\x03\x04", "a zip archive", "Unpack it, or save a spreadsheet as CSV.", (".npz",)
    ),
    Signature(b"\x1f\x8b", "data compressed with gzip", "Unpack the file first."),
    Signature(b"\x28\xb5\x2f\xfd", "data compressed with zstd", "Unpack the file first."),
    Signature(b"# .PCD", "a PCD file", "Give the file the suffix .pcd.", (".pcd",)),
    Signature(b"ply\n", "a PLY file", "Give the file the suffix .ply.", (".ply",)),
    Signature(b"ply\r", "a PLY file", "Give the file the suffix .ply.", (".ply",)),
    Signature(b"LASF", "a LAS file", "Give the file the suffix .las.", (".las", ".laz")),
    Signature(b"CCB2", "CloudCompare's own format", "Save the cloud as PCD in CloudCompare."),
    Signature(b"ASTM-E57", "an E57 file", "Save the cloud as PCD, PLY or LAS."),
    Signature(b"#ROSBAG V", "a ROS 1 recording", "Give it the suffix .bag.", (".bag",)),
    Signature(b"\x89MCAP", "a ROS 2 recording", "Give it the suffix .mcap.", (".mcap",)),
    Signature(
        b"SQLite format 3", "a database", "Give a ROS 2 recording the suffix .db3.", (".db3",)
    ),
)


def refuse_other_content(data: bytes, name: str, suffix: str) -> None:
    """Raise an error if the first bytes show that a file is not what its suffix promises.

    Parameters
    ----------
    data : bytes
        The beginning of the file, or all of it.
    name : str
        The file name to show in the message.
    suffix : str
        The suffix in lower case, for instance ``".bin"``.

    Raises
    ------
    CloudFileError
        The file is a web page, a Git LFS pointer, or a known format with another suffix.
    """
    for signature in SIGNATURES:
        if data.startswith(signature.start) and suffix not in signature.suffixes:
            raise file_error(
                name, "", f"found {signature.kind}, expected a {suffix} file", signature.advice
            )
    start = data[:512].removeprefix(b"\xef\xbb\xbf").lstrip()
    if start[:1] == b"<" and PRINTABLE.issuperset(start[:64]):
        line = start.splitlines()[0].decode("latin-1")
        raise file_error(
            name,
            "line 1",
            f"found {excerpt(line)}, a web page or XML, expected a {suffix} file",
            "Download the raw file instead.",
        )
