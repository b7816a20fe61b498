"""The only exception that cloud readers raise, and functions that build and raise it."""

import os
import tempfile
from collections.abc import Container, Iterable
from pathlib import Path

PRINTABLE = frozenset(b"\t\n\r" + bytes(range(32, 127)))  # the bytes of plain text
SHOWN_NAMES = 8  # file names listed in a message before "and 14 more"


class CloudFileError(ValueError):
    """A file cannot be read or written as a point cloud.

    The message gives the file, the place in it, the value found, the value expected and the next
    step for the user. The readers raise no other exception for a bad file.
    """


def file_error(
    name: str | os.PathLike, place: str, problem: str, advice: str = ""
) -> CloudFileError:
    """Build an error such as ``"cloud.txt, line 7: found 'abc' ... Correct the line."``.

    Parameters
    ----------
    name : str or path
        The file; the message shows only the last part of its path.
    place : str
        Line or byte where reading stopped, for instance ``"line 7"``; may be empty.
    problem, advice : str
        The value found and the value expected, and the next step for the user.
    """
    where = f"{Path(name).name}, {place}" if place else Path(name).name
    return CloudFileError(f"{where}: {problem}.{' ' + advice if advice else ''}")


def excerpt(text: object, length: int = 40) -> str:
    """Quote at most `length` characters of a file's content on one line."""
    text = str(text)
    return repr(text if len(text) <= length else text[:length] + "…")


def listing(names: Iterable[str]) -> str:
    """Join names as ``a, b, c``; after `SHOWN_NAMES` names, count the rest."""
    names = list(names)
    more = len(names) - SHOWN_NAMES
    return ", ".join(names[:SHOWN_NAMES]) + (f" and {more} more" if more > 0 else "")


def missing_file_error(
    name: str | os.PathLike, folders: Iterable[str | os.PathLike], suffixes: Container[str]
) -> CloudFileError:
    """Build an error that names the folders searched and the cloud files in them."""
    searched = dict.fromkeys((Path(folder) / name).parent.absolute() for folder in folders)
    there = sorted(
        entry.name
        for folder in searched
        if folder.is_dir()
        for entry in folder.iterdir()
        if entry.suffix.lower() in suffixes and not entry.name.startswith(".")
    )
    return file_error(
        name,
        "",
        f"no such file in {' or '.join(map(str, searched))}",
        f"The cloud files there are: {listing(there)}."
        if there
        else "There are no cloud files there. Check the name of the folder.",
    )


def read_bytes(path: Path, suffixes: Container[str] = ()) -> bytes:
    """Read a whole file; a missing or locked file raises `CloudFileError`."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise missing_file_error(path.name, [path.parent], suffixes) from None
    except IsADirectoryError:
        raise file_error(
            path, "", "found a folder, expected a file", "Use read_sequence for a folder."
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise file_error(path, "", f"the file cannot be opened ({error})") from None


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file atomically, so that no other process ever reads half of it."""
    temporary = None
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".", delete=False) as file:
            temporary = file.name
            file.write(data)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, path)
    except (OSError, ValueError) as error:
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        raise file_error(path, "", f"the file cannot be written ({error})") from None


def _umask() -> int:
    """Return the process's umask, which can be read only by setting it."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
