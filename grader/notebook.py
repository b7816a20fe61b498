"""Read a notebook that somebody handed in."""

import json
from dataclasses import dataclass

LARGEST_FILE = 64 * 2**20


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
        if path.stat().st_size > LARGEST_FILE:
            raise UnreadableNotebook(
                f"{path.name} is larger than {LARGEST_FILE // 2**20} MB. Clear its outputs "
                "(in JupyterLab: Edit, Clear Outputs of All Cells), save, and hand it in again.")
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise UnreadableNotebook(f"{path.name} cannot be opened: {error.strerror}.") from None
    except UnicodeDecodeError:
        raise UnreadableNotebook(f"{path.name} is not a notebook: it is not text. Save it again "
                                 "in Jupyter and hand in the .ipynb file.") from None
    if not text.strip():
        raise UnreadableNotebook(f"{path.name} is empty. Save the notebook again in Jupyter and "
                                 "hand it in.")
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableNotebook(f"{path.name} is not a notebook: it is not valid JSON. It may "
                                 "have been cut off while it was uploaded; hand it in again."
                                 ) from None
    try:
        return Notebook(tuple(_code_cells(content)), _lesson_name(content))
    except (AttributeError, KeyError, TypeError):
        raise UnreadableNotebook(f"{path.name} is JSON but not a notebook: it has no cells. Hand "
                                 "in the .ipynb file that Jupyter saves.") from None


def _code_cells(content):
    cells = content["cells"] if "cells" in content else \
        [cell for sheet in content["worksheets"] for cell in sheet["cells"]]
    for cell in cells:
        if cell["cell_type"] == "code":
            source = cell["source"] if "source" in cell else cell["input"]
            yield source if isinstance(source, str) else "".join(map(str, source))


def _lesson_name(content):
    return str(content.get("metadata", {}).get("lidar_obstacle_lab", {}).get("lesson", ""))
