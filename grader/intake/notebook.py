"""Read submitted files, which are untrusted."""

import errno
import os
import stat
from pathlib import Path

from utils.notebooks.reading import Notebook, UnreadableNotebook, decode_notebook

MAX_FILE_BYTES = 64 * 2**20
# O_NONBLOCK, because opening a pipe would otherwise wait for a writer. Windows lacks both flags.
_OPEN_FLAGS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


def read_notebook(path: Path) -> Notebook:
    """Read an untrusted notebook.

    Raises
    ------
    UnreadableNotebook
        If the file cannot be read, or is not a notebook.
    """
    return decode_notebook(read_file(path), path.name)


def read_file(path: Path) -> bytes:
    """Read the bytes of a submitted file.

    Raises
    ------
    UnreadableNotebook
        If the file cannot be opened, is too large, or is not an ordinary file. A link could lead
        to another student's work, and a pipe or a device could be endless.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | _OPEN_FLAGS)
        with open(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode):
                raise UnreadableNotebook(
                    f"{path.name} is not an ordinary file. Submit the .ipynb file itself."
                )
            if status.st_size > MAX_FILE_BYTES:
                raise UnreadableNotebook(
                    f"{path.name} is larger than {MAX_FILE_BYTES // 2**20} MB. Clear its outputs "
                    "(in JupyterLab: Edit, Clear Outputs of All Cells), save, and submit it again."
                )
            return file.read(MAX_FILE_BYTES)
    except OSError as error:
        reason = "it is a link to another file" if error.errno == errno.ELOOP else error.strerror
        raise UnreadableNotebook(f"{path.name} cannot be opened: {reason}.") from None
