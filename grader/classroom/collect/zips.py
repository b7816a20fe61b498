"""Read untrusted zips: check the declared sizes, and never use a name in a zip as a path.

The roster and the lessons of the course determine where a file is written. Without a roster, the
name of a student's folder comes from the archive, without special characters. A module keeps its
name, which must be an identifier.
"""

from __future__ import annotations

import contextlib
import lzma
import stat
import struct
import unicodedata
import zipfile
import zlib
from collections.abc import Callable
from datetime import datetime
from typing import IO

from grader.classroom.collect.models import ArchiveEntry, UnreadableFile
from grader.intake.notebook import MAX_FILE_BYTES
from grader.intake.submission import PACKAGE_FOLDERS

MAX_FILES = 200_000
MAX_FILES_PER_STUDENT = 5_000
MAX_BYTES_PER_STUDENT = 96 * 2**20  # of notebooks and modules
# A notebook full of zeros shrinks to 1/150 of its size, and a zip bomb to 1/1000.
MAX_COMPRESSION = 300
_SMALL_FILE = 2**20
_DAMAGE_ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    lzma.LZMAError,
    struct.error,
    EOFError,
    OSError,
    ValueError,
    NotImplementedError,  # a compression method that Python does not support
    RuntimeError,  # the zip has a password
)
_IGNORED_FOLDERS = ("__MACOSX", "__pycache__", *PACKAGE_FOLDERS)
# Windows writes names in the code page of the system's language, and zips do not name it.
_CODE_PAGES = (
    *("cp850", "cp1252", "cp852", "cp1250", "cp866", "cp1251", "cp737", "cp857"),
    *("cp932", "gbk", "cp949", "cp950"),
)


def clean_path(name: str) -> tuple[str, ...]:
    """Return the folders and the name of a file, without drive letters, roots, ``..`` or NUL."""
    text = unicodedata.normalize("NFC", name.replace("\\", "/").replace("\0", ""))
    parts = [part for part in text.split("/") if part.strip(". ")]
    if parts and len(parts[0]) == 2 and parts[0].endswith(":"):
        del parts[0]
    return tuple(parts)


def is_hidden(path: tuple[str, ...]) -> bool:
    """Return whether a path is hidden or in a folder that a program creates."""
    return any(part.startswith(".") or part in _IGNORED_FOLDERS for part in path)


def open_zip(file: IO[bytes] | str, limit: int) -> list[tuple[tuple[str, ...], ArchiveEntry]]:
    """Return the files in a zip, each with its original path.

    Raises
    ------
    UnreadableFile
    """
    try:
        archive = zipfile.ZipFile(file)
    except _DAMAGE_ERRORS as error:
        raise UnreadableFile(f"cannot be opened as a zip: {_error_reason(error)}") from None
    # `ZipInfo.is_dir` fails for empty names.
    infos = [info for info in archive.infolist() if not info.filename.endswith("/")]
    if len(infos) > limit:
        raise UnreadableFile(f"contains {len(infos):,} files, more than the limit of {limit:,}")
    return [
        (path, ArchiveEntry(path, _time_saved(info), _reader(archive, info)))
        for info in infos
        if (path := clean_path(_name(info)))
    ]


def _name(info: zipfile.ZipInfo) -> str:
    """Return the name of a file; Canvas and macOS write UTF-8 without declaring it."""
    if info.flag_bits & 0x800:
        return info.filename
    try:
        return info.filename.encode("cp437").decode("utf-8")
    except UnicodeError:
        return info.filename


def names_in_other_code_pages(name: str) -> tuple[str, ...]:
    """Return the possible readings of a name whose encoding the zip does not declare."""
    try:
        data = b"" if name.isascii() else name.encode("cp437")
    except UnicodeEncodeError:  # the encoding was declared
        return ()
    names = []
    for page in _CODE_PAGES:
        with contextlib.suppress(UnicodeDecodeError):
            names.append(data.decode(page))
    return tuple(name for name in dict.fromkeys(names) if name)


def _time_saved(info: zipfile.ZipInfo) -> datetime:
    try:
        return datetime(*info.date_time)
    except ValueError:
        return datetime(1980, 1, 1)


def _reader(archive: zipfile.ZipFile, info: zipfile.ZipInfo) -> Callable[[], bytes]:
    def read() -> bytes:
        _check_entry(info)
        try:
            with archive.open(info) as file:
                return file.read(MAX_FILE_BYTES)
        except _DAMAGE_ERRORS as error:
            raise UnreadableFile(f"cannot be unpacked: {_error_reason(error)}") from None

    return read


def _check_entry(info: zipfile.ZipInfo) -> None:
    """Reject links, passwords and large declared sizes. Unpacking never exceeds a declared size."""
    if stat.S_ISLNK(info.external_attr >> 16):
        raise UnreadableFile("is a link to another file. Ask for the file itself")
    if info.flag_bits & 0x1:
        raise UnreadableFile("has a password. Ask for the file without a password")
    if info.file_size > MAX_FILE_BYTES:
        raise UnreadableFile(
            f"is larger than {MAX_FILE_BYTES // 2**20} MB. Ask for the notebook without outputs"
        )
    if info.file_size > max(_SMALL_FILE, MAX_COMPRESSION * info.compress_size):
        raise UnreadableFile(
            f"unpacks to {info.file_size / max(1, info.compress_size):,.0f} times its size, "
            "like a zip bomb. Ask for the notebook without outputs"
        )


def _error_reason(error: Exception) -> str:
    return str(error).rstrip(".") or type(error).__name__
