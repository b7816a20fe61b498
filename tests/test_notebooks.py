"""All solved and all untouched notebooks run to the end.

test_build.py shows that both are the same up to the first stub. After it, an untouched notebook
uses stored answers, which must agree with the answers in the solved notebook.
"""

import nbformat
import pytest

from grader.course import recorded_answers
from tests.notebook_runs import errors_of, errors_outside_checks, outputs_of, printed_text, run

pytestmark = pytest.mark.slow


def test_a_solved_notebook_runs_and_agrees_with_the_stored_answers(lesson, tmp_path):
    notebook = nbformat.read(lesson.solved, as_version=4)
    recorded_answers.add_recorder(notebook, lesson, tmp_path / "answers.json")
    run(notebook, lesson.released.parent)
    assert errors_of(notebook) == []
    assert printed_text(notebook, "stderr") == ""
    pictures = [
        output.data["image/png"]
        for _, output in outputs_of(notebook)
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 5
    assert all(len(picture) < 400_000 for picture in pictures)
    recorded = recorded_answers.stored_bytes(lesson, tmp_path / "answers.json")
    stored = recorded_answers.answers_path(lesson).read_bytes()
    changed = recorded_answers.changed_answers(stored, recorded)
    assert changed == [], f"Run: python -m grader.course.recorded_answers {lesson.number}"


def test_an_untouched_notebook_runs_to_the_end(lesson):
    notebook = run(nbformat.read(lesson.released, as_version=4), lesson.released.parent)
    assert errors_outside_checks(notebook) == []
    assert printed_text(notebook, "stderr") == ""
    code = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.source.strip()]
    assert all(cell.execution_count for cell in code)
