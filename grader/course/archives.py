"""Reproducible zip files: the same content always gives the same bytes."""

import io
import stat
import zipfile
from collections.abc import Collection, Mapping

EARLIEST = (1980, 1, 1, 0, 0, 0)  # the earliest time that a zip can store


def make_zip(files: Mapping[str, bytes], programs: Collection[str] = ()) -> bytes:
    """Return the bytes of a zip file.

    Parameters
    ----------
    files : mapping of str to bytes
        Content by name, with ``/`` between folders.
    programs : collection of str
        Names of the files that can be executed.

    Returns
    -------
    bytes
        The same bytes on every machine. Names are sorted, and times and modes are fixed.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.create_system = 3  # Unix, so that the modes are used
            entry.external_attr = (stat.S_IFREG | (0o755 if name in programs else 0o644)) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, files[name])
    return buffer.getvalue()
