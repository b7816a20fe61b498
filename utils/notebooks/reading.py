"""Turn the bytes of a notebook file into its cells.

Editors, browsers and disks damage notebooks in many ways. Each step below repairs one kind of
damage, and returns a sentence about it if something may be missing.

The file is untrusted, and this module may run in the sandbox. It therefore uses only the standard
library and only patterns that do not backtrack.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from utils.notebooks import damaged_json
from utils.notebooks.file_formats import (
    UnreadableNotebook,
    is_lfs_pointer,
    notebook_text,
    replace_surrogates,
)

__all__ = [
    "Cell",
    "Notebook",
    "UnreadableNotebook",
    "decode_notebook",
    "id_of_text",
    "is_lfs_pointer",
]

# Each bracket becomes an object of about a hundred bytes, so a small file could fill the memory.
MAX_BRACKETS = 2_000_000
MAX_CELLS = 20_000
_TEXT_IN_JSON = re.compile(damaged_json.STRING, re.DOTALL)


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
    id : str
        The cell's ID in the file; editors change it or leave it out.
    """

    kind: str
    source: str
    grade_id: str = ""
    attachments: dict = field(default_factory=dict, hash=False)
    id: str = field(default="", compare=False)

    @property
    def has_id_of_text(self) -> bool:
        """Whether the text of the cell is unchanged since the release that it came from."""
        return self.id.partition("-")[0] == id_of_text(self.source)


@dataclass(frozen=True)
class Notebook:
    """The cells of a notebook, and its metadata.

    Attributes
    ----------
    cells : tuple of Cell
    lesson_name : str
        Name of the released lesson from the metadata; empty if the metadata lacks it.
    repairs : tuple of str
        One sentence for each fault of the file and its repair. If there is one, a part of the
        student's work may be missing from `cells`.
    python : tuple of int
        The version of Python that ran the notebook, such as (3, 12); empty if it is unknown.
    """

    cells: tuple[Cell, ...]
    lesson_name: str = ""
    repairs: tuple[str, ...] = ()
    python: tuple[int, ...] = ()

    @property
    def code(self) -> tuple[str, ...]:
        """Source of each code cell, in order."""
        return tuple(cell.source for cell in self.cells if cell.kind == "code")


@dataclass
class _NotebookDraft:
    """The contents of a file so far, which the steps fill in."""

    name: str
    data: bytes
    text: str = ""
    content: object = None
    old: bool = False
    found: list = field(default_factory=list)
    cells: tuple[Cell, ...] = ()
    lesson_name: str = ""
    python: tuple[int, ...] = ()


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
    draft = _NotebookDraft(name, data)
    sentences = [step(draft) for step in STEPS]
    repairs = tuple(filter(None, sentences))
    return Notebook(draft.cells, draft.lesson_name, repairs, draft.python)


def _read_text(draft: _NotebookDraft) -> str:
    """Unpack and decode the bytes."""
    draft.text, sentence = notebook_text(draft.data, draft.name)
    return sentence


def _count_brackets(draft: _NotebookDraft) -> str:
    """Refuse a file whose parsed content would fill the memory."""
    text = draft.text
    if text.count("[") + text.count("{") > MAX_BRACKETS:
        text = _TEXT_IN_JSON.sub("", text)  # brackets inside strings do not become objects
        if text.count("[") + text.count("{") > MAX_BRACKETS:
            raise UnreadableNotebook(
                f"{draft.name} contains more than {MAX_BRACKETS:,} lists and entries, most of "
                "them in its outputs. Clear its outputs (in JupyterLab: Edit, Clear Outputs of "
                "All Cells), save, and submit it again."
            )
    return ""


def _parse(draft: _NotebookDraft) -> str:
    """Parse JSON; ignore text after its end, and keep the complete cells of a damaged file."""
    text = draft.text.lstrip(" \t\r\n\0")
    draft.content, sentence, is_whole = damaged_json.parse(text, draft.name)
    if isinstance(draft.content, str):  # the notebook was encoded twice
        draft.text = draft.content
        return " ".join(filter(None, (sentence, _count_brackets(draft), _parse(draft))))
    if is_whole:
        return sentence
    if not draft.content["cells"]:
        raise UnreadableNotebook(
            f"{draft.name} is not a notebook, because it is not valid JSON. The upload may "
            "have been cut off. Submit the file again."
        )
    cut_off = (
        f"{draft.name} is damaged or cut off after {len(draft.content['cells'])} of its "
        "cells. Only these cells were read. Save it again in Jupyter and submit it "
        "again."
    )
    return " ".join(filter(None, (sentence, cut_off)))


def _find_cells(draft: _NotebookDraft) -> str:
    """Find the list of cells in the place that the notebook's format prescribes.

    A file may contain lists for nbformat 3 and 4; Jupyter shows only those of the declared format.
    """
    content = _without_wrapper(draft.content)
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
    metadata = _as_dict(content.get("metadata"))
    draft.lesson_name = _as_text(_as_dict(metadata.get("lidar_obstacle_lab")).get("lesson"))
    version = _as_text(_as_dict(metadata.get("language_info")).get("version"))
    numbers = re.match(r"(\d{1,3})\.(\d{1,3})(?!\d)", version, re.ASCII)
    draft.python = (int(numbers[1]), int(numbers[2])) if numbers else ()
    return ""


def _without_wrapper(content: object) -> dict:
    """Return the notebook in a reply of Jupyter's server, or around a bare list of cells."""
    if isinstance(content, list) and any("cell_type" in _as_dict(cell) for cell in content):
        return {"cells": content}
    content = _as_dict(content)
    inner = _as_dict(content.get("content"))
    return inner if "cells" in inner and "cells" not in content else content


def _read_cells(draft: _NotebookDraft) -> str:
    """Read each cell, even if some of its entries are missing."""
    if len(draft.found) > MAX_CELLS:
        raise UnreadableNotebook(
            f"{draft.name} has {len(draft.found):,} cells; more than {MAX_CELLS:,} are not "
            "read. Submit the notebook in which you worked."
        )
    cells = [cell for cell in draft.found if isinstance(cell, dict)]
    draft.cells = tuple(_cell(cell, draft.old) for cell in cells)
    odd = len(draft.found) - len(cells)
    if odd:
        cells, were = ("entry", "was") if odd == 1 else ("entries", "were")
        return f"{odd} {cells} of {draft.name} could not be read and {were} left out."
    return ""


def _choose_sides(draft: _NotebookDraft) -> str:
    """Keep one side of each merge conflict in a code cell, where some tools leave them."""
    cells, sentence = [], ""
    for cell in draft.cells:
        sides = damaged_json.sides_of_conflicts(cell.source, draft.name)
        if sides and cell.kind == "code":
            sentence = sides[0].sentence
            cell = replace(cell, source=sides[0].text)
        cells.append(cell)
    draft.cells = tuple(cells)
    return sentence


# The steps from bytes to cells. Each returns a sentence about its repair if the student may have
# lost work.
STEPS: tuple[Callable[[_NotebookDraft], str], ...] = (
    _read_text,
    _count_brackets,
    _parse,
    _find_cells,
    _read_cells,
    _choose_sides,
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
    return Cell(
        kind,
        next((_source(cell[place]) for place in places if place in cell), ""),
        _as_text(grading.get("grade_id")),
        _as_dict(cell.get("attachments")),
        _as_text(cell.get("id")),
    )


def id_of_text(text: str) -> str:
    """Return the ID that a cell with this text has in a released notebook."""
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _source(source: object) -> str:
    lines = [source] if isinstance(source, str) else _as_list(source)
    return _as_text("".join(line for line in lines if isinstance(line, str)))


def _as_text(value: object) -> str:
    return replace_surrogates(value) if isinstance(value, str) else ""


def _as_list(value: object) -> list:
    return value if isinstance(value, list) else []


def _as_dict(value: object) -> dict:
    return value if isinstance(value, dict) else {}
