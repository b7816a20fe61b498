"""What turns the bytes of a notebook file into its code.

The file may be a stranger's, and this may run in the sandbox: standard library only.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass

# Each bracket becomes an object of a hundred bytes, so a small file could fill the memory.
MOST_BRACKETS = 2_000_000


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

    cells: tuple[str, ...]
    lesson_name: str


def decode_notebook(data: bytes, name: str) -> Notebook:
    """Find the code in the bytes of a notebook file.

    Parameters
    ----------
    data : bytes
        JSON in UTF-8, with or without byte order mark, of nbformat 3 or later.
    name : str
        What sentences call the file.

    Returns
    -------
    Notebook

    Raises
    ------
    UnreadableNotebook
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UnreadableNotebook(
            f"{name} is not a notebook: it is not text. Save it again "
            "in Jupyter and hand in the .ipynb file."
        ) from None
    if not text.strip():
        raise UnreadableNotebook(
            f"{name} is empty. Save the notebook again in Jupyter and hand it in."
        )
    try:
        if text.count("[") + text.count("{") > MOST_BRACKETS:
            raise ValueError
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise UnreadableNotebook(
            f"{name} is not a notebook: it is not valid JSON. It may "
            "have been cut off while it was uploaded; hand it in again."
        ) from None
    try:
        return Notebook(tuple(_code_cells(content)), _lesson_name(content))
    except (AttributeError, KeyError, RecursionError, TypeError):
        raise UnreadableNotebook(
            f"{name} is JSON but not a notebook: it has no cells. Hand "
            "in the .ipynb file that Jupyter saves."
        ) from None


def _code_cells(content: dict) -> Iterator[str]:
    # A file may hold both; a person with Jupyter sees those of its own format alone.
    old = content["nbformat"] < 4 if "nbformat" in content else "cells" not in content
    sheets = content["worksheets"] if old else [content]
    for cell in (cell for sheet in sheets for cell in sheet["cells"]):
        if cell["cell_type"] == "code":
            source = cell["input" if old else "source"]
            yield source if isinstance(source, str) else "".join(source)


def _lesson_name(content: dict) -> str:
    name = content.get("metadata", {}).get("lidar_obstacle_lab", {}).get("lesson", "")
    return name if isinstance(name, str) else ""
