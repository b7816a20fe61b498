"""Reproducible zip files: the same content always gives the same bytes."""

import io
import stat
import zipfile
from collections.abc import Collection, Mapping

EARLIEST_DATE = (1980, 1, 1, 0, 0, 0)  # the earliest date that a zip file can store


def make_zip(files: Mapping[str, bytes], programs: Collection[str] = ()) -> bytes:
    """Return the bytes of a zip file with the given files.

    Parameters
    ----------
    files : mapping of str to bytes
        Content by path in the zip file, with ``/`` as the separator.
    programs : collection of str
        Paths of the files to make executable.

    Returns
    -------
    bytes
        The same bytes on every machine. Names are sorted, and times and modes are fixed.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, EARLIEST_DATE)
            entry.create_system = 3  # Unix; otherwise unzip ignores the modes
            entry.external_attr = (stat.S_IFREG | (0o755 if name in programs else 0o644)) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, files[name])
    return buffer.getvalue()
