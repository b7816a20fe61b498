"""The one error of the cloud readers, and files opened so that it explains what went wrong."""

import os
import tempfile
from collections.abc import Container, Iterable
from pathlib import Path

SHOWN_NAMES = 8  # file names listed in a message before it says "and 14 more"


class CloudFileError(ValueError):
    """A file cannot be read or written as a point cloud.

    The message is a sentence for the person who meets it: which file, where in it, what was
    found, what was expected and what to do next. No reader raises anything else.
    """


def file_error(
    name: str | os.PathLike, place: str, problem: str, advice: str = ""
) -> CloudFileError:
    """Put an error together: ``"cloud.txt, line 7: found 'abc' ... Correct the line."``.

    Parameters
    ----------
    name : str or path
        The file; only its last part is shown.
    place : str
        Line or byte where reading stopped, for instance ``"line 7"``; may be empty.
    problem, advice : str
        What was found and expected; what to do next.
    """
    where = f"{Path(name).name}, {place}" if place else Path(name).name
    return CloudFileError(f"{where}: {problem}.{' ' + advice if advice else ''}")


def excerpt(text: object, length: int = 40) -> str:
    """Quote at most `length` characters of what a file holds, on one line."""
    text = str(text)
    return repr(text if len(text) <= length else text[:length] + "…")


def listing(names: Iterable[str]) -> str:
    """Write names as ``a, b, c``, cut after a few."""
    names = list(names)
    more = len(names) - SHOWN_NAMES
    return ", ".join(names[:SHOWN_NAMES]) + (f" and {more} more" if more > 0 else "")


def missing_file(
    name: str | os.PathLike, folders: Iterable[str | os.PathLike], suffixes: Container[str]
) -> CloudFileError:
    """Say which folders were looked in and which cloud files are there."""
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
        else "There is no cloud file there; check the spelling of the folder.",
    )


def read_bytes(path: Path, suffixes: Container[str] = ()) -> bytes:
    """Read a whole file; a missing or locked one raises `CloudFileError`."""
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise missing_file(path.name, [path.parent], suffixes) from None
    except IsADirectoryError:
        raise file_error(
            path, "", "this is a folder, expected a file", "Use read_sequence for a folder."
        ) from None
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        raise file_error(path, "", f"the file cannot be opened ({error})") from None


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file whole or not at all: to a temporary name first, then renamed.

    A reader, or a second process writing the same file, never meets half of it.
    """
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
    """Read the process's file mode mask (the system can only tell it by setting it)."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
