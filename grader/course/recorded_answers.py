"""Record the answers of a solved notebook: ``python -m grader.course.recorded_answers 06``.

Students who have not written a function yet can continue with these answers; see `utils.lent`.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from grader.course.lessons import Lesson, all_lessons
from grader.course.notebook_runs import NotebookStopped, run_notebook
from grader.course.paths import PROJECT
from utils.lent.encoding import decode

if TYPE_CHECKING:
    from nbformat import NotebookNode

ANSWERS_FOLDER = PROJECT / "utils" / "lent"
MAX_FILE_BYTES = 45_000


class UnstorableAnswers(Exception):
    """The answers of a lesson cannot be stored; `str()` is the sentence to show."""


def record(lesson: Lesson) -> bytes:
    """Run the solved notebook of a lesson, and record the answers of its functions.

    Returns
    -------
    bytes
        Content for the file at `answers_path`.

    Raises
    ------
    UnstorableAnswers
        If a cell fails, an answer cannot be stored, or the file would be too large.
    """
    import nbformat

    notebook = nbformat.read(lesson.solved, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "answers.json"
        add_recorder(notebook, lesson, path)
        try:
            run_notebook(notebook, lesson.released.parent)
        except NotebookStopped as reason:
            raise UnstorableAnswers(
                f"{lesson.name}: the solved notebook does not run to the end: {reason}"
            ) from None
        return stored_bytes(lesson, path)


def add_recorder(notebook: NotebookNode, lesson: Lesson, path: Path) -> None:
    """Insert a cell into a solved notebook that records the answers of its functions.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        Changed in place.
    lesson : Lesson
    path : pathlib.Path
        File that the cell writes.
    """
    import nbformat

    names = [exercise.name for exercise in lesson.machine_graded]
    source = (
        "from utils.lent import record_answers\n"
        f"record_answers({names}, {list(lesson.header.lent)}, {str(path)!r})"
    )
    setup_index = next(
        number
        for number, cell in enumerate(notebook.cells)
        if "setup" in cell.metadata.get("tags", ())
    )
    notebook.cells.insert(setup_index + 1, nbformat.v4.new_code_cell(source))


def stored_bytes(lesson: Lesson, path: Path) -> bytes:
    """Return the recorded answers in the format of the stored file.

    Parameters
    ----------
    lesson : Lesson
    path : pathlib.Path
        The file that the recorder wrote; see `add_recorder`.

    Raises
    ------
    UnstorableAnswers
        If an answer cannot be stored, or the file would be too large.
    """
    recorded = json.loads(path.read_text("utf-8"))
    if faults := recorded.pop("faults"):
        raise UnstorableAnswers(f"{lesson.name}: {faults[0]}")
    text = json.dumps(recorded, indent=0, sort_keys=True, separators=(",", ":")) + "\n"
    if len(text) > MAX_FILE_BYTES:
        sizes = {
            name: len(json.dumps(answers))
            for functions in recorded.values()
            for name, answers in functions.items()
        }
        raise UnstorableAnswers(
            f"{lesson.name}: the answers take up {len(text):,} bytes, but at most "
            f"{MAX_FILE_BYTES:,} may be stored. In a cell of its own, write a function that makes "
            "the calls with large answers and returns a small result. Call it in a later cell, and "
            f"list it under `lent:` in the header. Bytes per function: {sizes}"
        )
    return text.encode()


def answers_path(lesson: Lesson) -> Path:
    """Return the path of a lesson's stored answers."""
    return ANSWERS_FOLDER / f"lesson_{lesson.number}.json"


def changed_answers(stored: bytes, recorded: bytes) -> list[str]:
    """Compare the stored answers of a lesson with newly recorded ones.

    Parameters
    ----------
    stored, recorded : bytes
        An earlier result of `record`, and a new one.

    Returns
    -------
    list of str
        Names of the functions whose calls or answers differ by more than rounding errors.
    """
    before, now = _answers_by_call(stored), _answers_by_call(recorded)
    different = before.keys() ^ now.keys() | {
        call for call in before.keys() & now.keys() if not _nearly_equal(before[call], now[call])
    }
    return sorted({name for _, name, _ in different})


def _answers_by_call(stored: bytes) -> dict[tuple[str, str, str], object]:
    return {
        (call_kind, name, key): answer["answer"]
        for call_kind, functions in json.loads(stored).items()
        for name, answers in functions.items()
        for key, answer in answers.items()
    }


def _nearly_equal(first: object, second: object) -> bool:
    if type(first) is not type(second):
        return False
    if isinstance(first, dict) and first.keys() != second.keys():
        return False
    if isinstance(first, dict) and "shape" in first:
        first, second = decode(first, (), {}), decode(second, (), {})
        return first.shape == second.shape and np.allclose(first, second, atol=0.02, equal_nan=True)
    if isinstance(first, dict):
        return all(_nearly_equal(first[key], second[key]) for key in first)
    if isinstance(first, list):
        return len(first) == len(second) and all(map(_nearly_equal, first, second))
    if isinstance(first, float):
        # The order of equal values after NumPy sorts them depends on the processor. Another order
        # gives another valid tree, in which a search may visit more or fewer nodes.
        return bool(np.isclose(first, second, rtol=0.05, equal_nan=True))
    return first == second


def main(numbers: Sequence[str]) -> None:
    """Record the answers of the numbered lessons; without numbers, of all lessons."""
    for lesson in all_lessons():
        if numbers and lesson.number not in numbers:
            continue
        content = record(lesson)
        answers_path(lesson).write_bytes(content)
        print(f"{answers_path(lesson).relative_to(PROJECT)}: {len(content):,} bytes")


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except UnstorableAnswers as fault:
        sys.exit(str(fault))
