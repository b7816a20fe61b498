"""Zip files that are the same bytes for the same content: whoever packs twice can compare."""

import io
import stat
import zipfile
from collections.abc import Collection, Mapping

EARLIEST = (1980, 1, 1, 0, 0, 0)  # that a zip can say


def zipped(files: Mapping[str, bytes], programs: Collection[str] = ()) -> bytes:
    """Bytes of a zip with these files.

    Parameters
    ----------
    files : mapping of str to bytes
        By name, with ``/`` between folders.
    programs : collection of str
        Names of those that can be executed.

    Returns
    -------
    bytes
        Names in order, one time for all, modes as said, whatever machine packs them.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, EARLIEST)
            entry.create_system = 3  # Unix, where modes mean something
            entry.external_attr = (stat.S_IFREG | (0o755 if name in programs else 0o644)) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, files[name])
    return buffer.getvalue()
