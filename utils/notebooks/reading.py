"""Turn the bytes of a notebook file into its cells.

Editors, browsers and disks damage notebooks in many ways. Each step below repairs one kind of
damage, and returns a sentence about it if something may be missing.

The file is untrusted, and this module may run in the sandbox. It therefore uses only the standard
library and only patterns that do not backtrack.
"""

from __future__ import annotations

import codecs
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field

# Each bracket becomes an object of about a hundred bytes, so a small file could fill the memory.
MOST_BRACKETS = 2_000_000
MOST_CELLS = 20_000
_TEXT_IN_JSON = re.compile(r'"(?:[^"\\]|\\.)*+"', re.DOTALL)
_BETWEEN = re.compile(r"[\s,]*")
_LESSON_IN_JSON = re.compile(r'"lidar_obstacle_lab"\s*:\s*\{\s*"lesson"\s*:\s*"(\w{1,60})"')


class UnreadableNotebook(Exception):
    """The file is not a notebook; `str()` is the message to show."""


@dataclass(frozen=True)
class Cell:
    """One cell of a notebook.

    Attributes
    ----------
    kind : {"code", "markdown", "raw"}
    source : str
    grade_id : str
        ID of the cell in nbgrader; empty if it has none.
    attachments : dict
        Attached pictures as stored in the file; untrusted and not validated.
    """

    kind: str
    source: str
    grade_id: str = ""
    attachments: dict = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Notebook:
    """The cells of a notebook, and its metadata.

    Attributes
    ----------
    cells : tuple of Cell
    lesson_name : str
        Name of the released lesson from the metadata; empty if the metadata lacks it.
    repairs : tuple of str
        One sentence for each fault of the file and its repair.
    """

    cells: tuple[Cell, ...]
    lesson_name: str = ""
    repairs: tuple[str, ...] = ()

    @property
    def code(self) -> tuple[str, ...]:
        """Source of each code cell, in order."""
        return tuple(cell.source for cell in self.cells if cell.kind == "code")


@dataclass
class _Draft:
    """The contents of a file so far, which the steps fill in."""

    name: str
    data: bytes
    text: str = ""
    content: object = None
    old: bool = False
    found: list = field(default_factory=list)
    cells: tuple[Cell, ...] = ()
    lesson_name: str = ""


def decode_notebook(data: bytes, name: str) -> Notebook:
    """Read the cells from the bytes of a notebook file.

    Parameters
    ----------
    data : bytes
        JSON of nbformat 3 or later.
    name : str
        File name to show in messages.

    Raises
    ------
    UnreadableNotebook
        The file is not a notebook, or is too large to read.
    """
    draft = _Draft(name, data)
    sentences = [step(draft) for step in STEPS]
    return Notebook(draft.cells, draft.lesson_name, tuple(filter(None, sentences)))


def _decode(draft: _Draft) -> str:
    """Decode bytes as UTF-8, or as one of the encodings that Windows programs save."""
    data = draft.data
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding, sentence = "utf-16", ""
    elif data.removeprefix(codecs.BOM_UTF8).lstrip().startswith(b"{"):
        encoding, sentence = "utf-8-sig", ""
        try:
            data.decode(encoding)
        except UnicodeDecodeError:
            encoding, sentence = (
                "latin-1",
                f"{draft.name} is not encoded in UTF-8, so letters with accents may be wrong. "
                "Save it again in Jupyter.",
            )
    else:
        encoding, sentence = "utf-8-sig", ""
    try:
        draft.text = data.decode(encoding)
    except UnicodeDecodeError:
        raise UnreadableNotebook(
            f"{draft.name} is not a notebook, because it is not text. Save the notebook again in "
            "Jupyter and submit the .ipynb file."
        ) from None
    if not draft.text.strip(" \t\r\n\0"):
        raise UnreadableNotebook(
            f"{draft.name} is empty. Save the notebook again in Jupyter and submit it."
        )
    return sentence


def _count_brackets(draft: _Draft) -> str:
    """Refuse a file whose parsed content would fill the memory."""
    text = draft.text
    if text.count("[") + text.count("{") > MOST_BRACKETS:
        text = _TEXT_IN_JSON.sub("", text)  # brackets inside strings do not become objects
        if text.count("[") + text.count("{") > MOST_BRACKETS:
            raise UnreadableNotebook(
                f"{draft.name} contains more than {MOST_BRACKETS:,} lists and entries, most of "
                "them in its outputs. Clear its outputs (in JupyterLab: Edit, Clear Outputs of "
                "All Cells), save, and submit it again."
            )
    return ""


def _parse(draft: _Draft) -> str:
    """Parse JSON; ignore text after its end, and keep the complete cells of a damaged file."""
    text = draft.text.lstrip(" \t\r\n\0")
    try:
        draft.content, end = json.JSONDecoder().raw_decode(text)
    except (ValueError, RecursionError):
        draft.content = _whole_cells(text)
        if not draft.content["cells"]:
            raise UnreadableNotebook(
                f"{draft.name} is not a notebook, because it is not valid JSON. The upload may "
                "have been cut off. Submit the file again."
            ) from None
        return (
            f"{draft.name} is damaged or cut off after {len(draft.content['cells'])} of its "
            "cells. Only these cells were read. Save it again in Jupyter and submit it "
            "again."
        )
    if text[end:].strip(" \t\r\n\0"):
        return (
            f"{draft.name} contains something after the end of the notebook, such as a second "
            "copy. Only the notebook was read. Save it again in Jupyter and submit it again."
        )
    return ""


def _whole_cells(text: str) -> dict:
    """Return a notebook with the cells that are complete before the file breaks off."""
    begin = re.search(r'"cells"\s*:\s*\[', text)
    cells, place = [], begin.end() if begin else len(text)
    decoder = json.JSONDecoder()
    while True:
        try:
            cell, place = decoder.raw_decode(text, _BETWEEN.match(text, place).end())
        except (ValueError, RecursionError):
            break
        if not isinstance(cell, dict):
            break
        cells.append(cell)
    lesson = _LESSON_IN_JSON.search(text)
    metadata = {"lidar_obstacle_lab": {"lesson": lesson[1]}} if lesson else {}
    return {"cells": cells, "metadata": metadata}


def _find_cells(draft: _Draft) -> str:
    """Find the list of cells in the place that the notebook's format prescribes.

    A file may contain lists for nbformat 3 and 4; Jupyter shows only those of the declared format.
    """
    content = draft.content if isinstance(draft.content, dict) else {}
    number = content.get("nbformat")
    old = number < 4 if type(number) is int else "cells" not in content
    sheets = _as_list(content.get("worksheets")) if old else [content]
    lists = [sheet.get("cells") for sheet in sheets if isinstance(sheet, dict)]
    if not any(isinstance(cells, list) for cells in lists):
        raise UnreadableNotebook(
            f"{draft.name} is JSON but not a notebook, because it has no cells. Submit the .ipynb "
            "file that Jupyter saves."
        )
    draft.old = old
    draft.found = [cell for cells in lists for cell in _as_list(cells)]
    course = _as_dict(_as_dict(content.get("metadata")).get("lidar_obstacle_lab"))
    name = course.get("lesson")
    draft.lesson_name = name if isinstance(name, str) else ""
    return ""


def _read_cells(draft: _Draft) -> str:
    """Read each cell, even if some of its entries are missing."""
    if len(draft.found) > MOST_CELLS:
        raise UnreadableNotebook(
            f"{draft.name} has {len(draft.found):,} cells; more than {MOST_CELLS:,} are not "
            "read. Submit the notebook in which you worked."
        )
    cells = [cell for cell in draft.found if isinstance(cell, dict)]
    draft.cells = tuple(_cell(cell, draft.old) for cell in cells)
    odd = len(draft.found) - len(cells)
    if odd:
        cells, were = ("entry", "was") if odd == 1 else ("entries", "were")
        return f"{odd} {cells} of {draft.name} could not be read and {were} left out."
    return ""


# The steps from bytes to cells. Each returns a sentence about its repair if the student may have
# lost work.
STEPS: tuple[Callable[[_Draft], str], ...] = (
    _decode,
    _count_brackets,
    _parse,
    _find_cells,
    _read_cells,
)


def _cell(cell: dict, old: bool) -> Cell:
    kind = cell.get("cell_type")
    if kind not in ("code", "markdown", "raw"):
        # nbformat 3 also has the types "heading" and "html". A cell without a type counts as code
        # if it has an input or outputs.
        runs = kind is None and ("outputs" in cell or "input" in cell)
        kind = "code" if runs else "raw" if kind == "html" else "markdown"
    places = ("input", "source") if old and kind == "code" else ("source", "input")
    grading = _as_dict(_as_dict(cell.get("metadata")).get("nbgrader"))
    grade_id = grading.get("grade_id")
    return Cell(
        kind,
        next((_text(cell[place]) for place in places if place in cell), ""),
        grade_id if isinstance(grade_id, str) else "",
        _as_dict(cell.get("attachments")),
    )


def _text(source: object) -> str:
    lines = [source] if isinstance(source, str) else _as_list(source)
    return "".join(line for line in lines if isinstance(line, str))


def _as_list(value: object) -> list:
    return value if isinstance(value, list) else []


def _as_dict(value: object) -> dict:
    return value if isinstance(value, dict) else {}
