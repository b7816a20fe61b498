"""Read a notebook that somebody handed in."""

import errno
import json
import os
import stat
from dataclasses import dataclass

LARGEST_FILE = 64 * 2**20
# Each bracket becomes an object of a hundred bytes, so a small file could fill the memory.
MOST_BRACKETS = 2_000_000
# O_NONBLOCK: opening a pipe must not wait for whoever writes to it. Windows has neither.
_NOT_THROUGH_LINKS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


class UnreadableNotebook(Exception):
    """The file is not a notebook; `str()` is the sentence to show."""


@dataclass(frozen=True)
class Notebook:
    """The code of a notebook, and what it says about itself.

    Attributes
    ----------
    cells : tuple of str
        Source of each code cell.
    lesson_name : str
        Name of the lesson that it was released as; empty where it does not say.
    """

    cells: tuple
    lesson_name: str


def read_notebook(path):
    """Read a notebook without trusting it.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    Notebook

    Raises
    ------
    UnreadableNotebook
    """
    try:
        text = read_file(path).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UnreadableNotebook(
            f"{path.name} is not a notebook: it is not text. Save it again "
            "in Jupyter and hand in the .ipynb file."
        ) from None
    if not text.strip():
        raise UnreadableNotebook(
            f"{path.name} is empty. Save the notebook again in Jupyter and hand it in."
        )
    try:
        if text.count("[") + text.count("{") > MOST_BRACKETS:
            raise ValueError
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableNotebook(
            f"{path.name} is not a notebook: it is not valid JSON. It may "
            "have been cut off while it was uploaded; hand it in again."
        ) from None
    try:
        return Notebook(tuple(_code_cells(content)), _lesson_name(content))
    except (AttributeError, KeyError, RecursionError, TypeError):
        raise UnreadableNotebook(
            f"{path.name} is JSON but not a notebook: it has no cells. Hand "
            "in the .ipynb file that Jupyter saves."
        ) from None


def read_file(path):
    """Bytes of a file that somebody handed in.

    Parameters
    ----------
    path : pathlib.Path

    Returns
    -------
    bytes

    Raises
    ------
    UnreadableNotebook
        If it is too large, or no file of its own: a link could lead to somebody else's work,
        and a pipe or a device never ends.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | _NOT_THROUGH_LINKS)
        with open(descriptor, "rb") as file:
            status = os.fstat(descriptor)
            if not stat.S_ISREG(status.st_mode):
                raise UnreadableNotebook(
                    f"{path.name} is not an ordinary file. Hand in the .ipynb file itself."
                )
            if status.st_size > LARGEST_FILE:
                raise UnreadableNotebook(
                    f"{path.name} is larger than {LARGEST_FILE // 2**20} MB. Clear its outputs "
                    "(in JupyterLab: Edit, Clear Outputs of All Cells), save, and hand it in "
                    "again."
                )
            return file.read(LARGEST_FILE)
    except OSError as error:
        reason = "it is a link to another file" if error.errno == errno.ELOOP else error.strerror
        raise UnreadableNotebook(f"{path.name} cannot be opened: {reason}.") from None


def _code_cells(content):
    cells = (
        content["cells"]
        if "cells" in content
        else [cell for sheet in content["worksheets"] for cell in sheet["cells"]]
    )
    for cell in cells:
        if cell["cell_type"] == "code":
            source = cell["source"] if "source" in cell else cell["input"]
            yield source if isinstance(source, str) else "".join(source)


def _lesson_name(content):
    name = content.get("metadata", {}).get("lidar_obstacle_lab", {}).get("lesson", "")
    return name if isinstance(name, str) else ""
