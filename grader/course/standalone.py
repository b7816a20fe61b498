"""Standalone notebooks, which need no other file, for e-mail, USB sticks, Colab and Kaggle."""

from __future__ import annotations

import base64
import functools
import hashlib
import io
import json
import lzma
import re
import tarfile
from collections.abc import Iterable
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.course.build import CELL_KEYS_FILE, COMMON_CELLS, HIDDEN_METADATA, find_leaks
from grader.course.extension import extension_constant
from grader.course.lessons import Lesson, all_lessons, every_lesson
from grader.course.paths import PROJECT

SETUP_CELL = PROJECT / "solutions" / "standalone_cell.py"
# The first line of the setup cell identifies this cell in a submission.
TITLE = SETUP_CELL.read_text("utf-8").partition("\n")[0]
BADGE_TEXT = (
    "*This notebook does not need any other file. Upload it to Colab or Kaggle, or open it in VS "
    "Code or JupyterLab with NumPy, SciPy and matplotlib installed.*"
)
OTHER_STAGE = re.compile(r"\]\(\.\./stage\w+/(?=\w+\.ipynb\))")
MAX_NOTEBOOK_BYTES = 490_000


class ReleaseError(Exception):
    """A file cannot be released; `str()` is the sentence to show."""


def write_standalone(folder: Path, stages: Iterable[str] = ()) -> list[Path]:
    """Write the students' notebooks as standalone notebooks.

    Parameters
    ----------
    folder : pathlib.Path
        Created if it does not exist.
    stages : iterable of str, optional
        Stages to write. Default: all.

    Raises
    ------
    ReleaseError
        If a notebook would be too large, or would reveal a solution.
    """
    written = []
    for lesson in all_lessons():
        if stages and lesson.stage not in stages:
            continue
        text = make_standalone(lesson.released.read_bytes())
        check_no_leaks(lesson, text)
        if len(text) > MAX_NOTEBOOK_BYTES:
            raise ReleaseError(
                f"{lesson.name} was not written, because it would have {len(text)} bytes, more "
                f"than the limit of {MAX_NOTEBOOK_BYTES}."
            )
        path = folder / f"{lesson.name}.ipynb"
        write_atomically(text, path)
        written.append(path)
    return written


def check_no_leaks(lesson: Lesson, notebook: bytes) -> None:
    """Raise `ReleaseError` if a student's notebook contains a line of the solution."""
    others = [other.released.read_bytes() for other in all_lessons() if other != lesson]
    leaked_lines = find_leaks(lesson.solved.read_bytes(), notebook, others)
    if leaked_lines:
        raise ReleaseError(
            f"{lesson.name} was not written, because it reveals a line of the solution: "
            f"{leaked_lines[0]!r}."
        )


def make_standalone(notebook: bytes) -> bytes:
    """Return a notebook whose setup cell contains the tools of the course.

    Parameters
    ----------
    notebook : bytes
        A student notebook that `grader.course.build` wrote.

    Returns
    -------
    bytes
        Always the same for the same course.
    """
    content = json.loads(notebook)
    course_metadata = content["metadata"]["lidar_obstacle_lab"]
    for cell in content["cells"]:
        tags = COMMON_CELLS.keys() & set(cell["metadata"].get("tags", ()))
        if "setup" in tags:
            cell["source"] = setup_cell(course_metadata["lesson"]).splitlines(keepends=True)
            cell["metadata"] |= HIDDEN_METADATA
        elif "badge" in tags:
            cell["source"] = [BADGE_TEXT]
        elif cell["cell_type"] == "markdown":
            # Links to other stages need no folder, because all standalone notebooks are in one.
            cell["source"] = [OTHER_STAGE.sub("](", line) for line in cell["source"]]
    course_metadata["standalone"] = True
    return (json.dumps(content, indent=1, ensure_ascii=False, sort_keys=True) + "\n").encode()


@functools.cache
def setup_cell(lesson: str) -> str:
    """Return the source of the cell that unpacks the tools in a standalone notebook."""
    data = packed_tools(lesson)
    return (
        SETUP_CELL.read_text("utf-8")
        .strip()
        .replace("PACKED", base64.b85encode(data).decode())
        .replace("DIGEST", hashlib.sha256(data).hexdigest())
        .replace("NUMBER", lesson[:2])
    )


def packed_tools(lesson: str) -> bytes:
    """Return a reproducible, compressed archive of ``utils`` for one lesson."""
    other_lessons = {f"lesson_{other.number}" for other in every_lesson() if other.name != lesson}
    own_lesson = next(candidate for candidate in every_lesson() if candidate.name == lesson)
    text = own_lesson.released.read_text("utf-8")
    left_out = [
        folder for folder, name in extension_constant("OPTIONAL_PACKAGES") if name not in text
    ]
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for path in sorted((PROJECT / "utils").rglob("*")):
            name = path.relative_to(PROJECT)
            is_of_other_lesson = other_lessons & {name.stem, *name.parts}
            if (
                path.suffix not in (".py", ".html", ".js", ".json")
                or is_of_other_lesson
                or not path.is_file()
            ):
                continue
            if any(name.is_relative_to(folder) for folder in left_out):
                continue
            entry = tarfile.TarInfo(name.as_posix())
            content = path.read_bytes()
            if path == CELL_KEYS_FILE:
                keys = json.loads(content)
                content = json.dumps({own_lesson.number: keys.get(own_lesson.number, [])}).encode()
            entry.size, entry.mode = len(content), 0o644
            archive.addfile(entry, io.BytesIO(content))
    # Text is not aligned, so pb, which is for numbers of several bytes, is 0.
    compression = {"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME, "pb": 0}
    return lzma.compress(buffer.getvalue(), filters=[compression])


def is_setup_cell(source: str, lesson: str) -> bool:
    """Return whether a submitted cell is exactly the setup cell of a standalone notebook."""
    return source.startswith(TITLE) and source.strip() == setup_cell(lesson)
