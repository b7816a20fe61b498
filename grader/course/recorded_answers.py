"""Record the answers of a solved notebook: ``python -m grader.course.recorded_answers 06``.

Students who have not written a function yet go on with these answers; see `utils.lent`.
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import PROJECT

if TYPE_CHECKING:
    from nbformat import NotebookNode

ANSWERS_FOLDER = PROJECT / "utils" / "lent"
LARGEST = 45_000  # bytes


class UnstorableAnswers(Exception):
    """The answers of a lesson cannot be stored; `str()` is the sentence to show."""


def record(lesson: Lesson) -> bytes:
    """Run the solved notebook of a lesson, and record the answers of its functions.

    Returns
    -------
    bytes
        New content of the file `answers_path`.

    Raises
    ------
    UnstorableAnswers
        If a cell fails, an answer cannot be stored, or the file would be too large.
    """
    import nbclient
    import nbformat

    notebook = nbformat.read(lesson.solved, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "answers.json"
        add_recorder(notebook, lesson, path)
        client = nbclient.NotebookClient(
            notebook,
            timeout=120,
            resources={"metadata": {"path": str(lesson.released.parent)}},
            force_raise_errors=True,
        )
        client.comm_open_handlers.clear()
        try:
            client.execute()
        except nbclient.exceptions.CellExecutionError as error:
            raise UnstorableAnswers(f"{lesson.name}: {str(error)[-2000:]}") from None
        return stored_bytes(lesson, path)


def add_recorder(notebook: NotebookNode, lesson: Lesson, path: Path) -> None:
    """Add a cell to a solved notebook that records the answers of its functions.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        Changed in place.
    lesson : Lesson
    path : pathlib.Path
        File to write.
    """
    import nbformat

    names = [exercise.name for exercise in lesson.machine_graded]
    source = (
        "from utils.lent import record_answers\n"
        f"record_answers({names}, {list(lesson.header.lent)}, {str(path)!r})"
    )
    setup = next(
        number
        for number, cell in enumerate(notebook.cells)
        if "setup" in cell.metadata.get("tags", ())
    )
    notebook.cells.insert(setup + 1, nbformat.v4.new_code_cell(source))


def stored_bytes(lesson: Lesson, path: Path) -> bytes:
    """Return the recorded answers in the form in which they are stored.

    Parameters
    ----------
    lesson : Lesson
    path : pathlib.Path
        The path that `listen` got.

    Raises
    ------
    UnstorableAnswers
        As in `record`.
    """
    recorded = json.loads(path.read_text("utf-8"))
    if faults := recorded.pop("faults"):
        raise UnstorableAnswers(f"{lesson.name}: {faults[0]}")
    text = json.dumps(recorded, indent=0, sort_keys=True, separators=(",", ":")) + "\n"
    if len(text) > LARGEST:
        sizes = {
            name: len(json.dumps(answers))
            for functions in recorded.values()
            for name, answers in functions.items()
        }
        raise UnstorableAnswers(
            f"{lesson.name}: {len(text):,} bytes, and {LARGEST:,} may be stored. Name a function "
            f"of the notebook that sums them up in the header, `lent: [...]`. Bytes now: {sizes}"
        )
    return text.encode()


def answers_path(lesson: Lesson) -> Path:
    """Return the file of a lesson's stored answers."""
    return ANSWERS_FOLDER / f"lesson_{lesson.number}.json"


def main(numbers: Sequence[str]) -> None:
    """Record the lessons with these numbers, or all."""
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
