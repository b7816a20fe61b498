"""Every solved notebook runs to its end, and so does every untouched one.

test_build.py shows that both are the same up to the first stub. From there on, an untouched
notebook uses stored answers, which must agree with the answers of the solved notebook.
"""

import json

import nbformat
import numpy as np
import pytest

from grader.course import recorded_answers
from tests.notebook_runs import errors_beside_checks, errors_of, outputs_of, run, written
from utils.lent.encoding import decode

pytestmark = pytest.mark.slow


def test_solved_notebook_runs_to_its_end_and_gives_what_is_lent(lesson, tmp_path):
    notebook = nbformat.read(lesson.solved, as_version=4)
    recorded_answers.add_recorder(notebook, lesson, tmp_path / "answers.json")
    run(notebook, lesson.released.parent)
    assert errors_of(notebook) == []
    assert written(notebook, "stderr") == ""
    pictures = [
        output.data["image/png"]
        for _, output in outputs_of(notebook)
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 5
    assert all(len(picture) < 400_000 for picture in pictures)
    computed = by_call(json.loads(recorded_answers.stored_bytes(lesson, tmp_path / "answers.json")))
    stored = by_call(json.loads(recorded_answers.answers_path(lesson).read_text("utf-8")))
    command = f"Run: python -m grader.course.recorded_answers {lesson.number}"
    assert computed.keys() == stored.keys(), command
    for name, answer in computed.items():
        assert nearly_equal(answer, stored[name]), f"{name} has changed. {command}"


def test_untouched_notebook_runs_to_its_end(lesson):
    notebook = run(nbformat.read(lesson.released, as_version=4), lesson.released.parent)
    assert errors_beside_checks(notebook) == []
    assert written(notebook, "stderr") == ""
    code = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.source.strip()]
    assert all(cell.execution_count for cell in code)


def by_call(stored):
    """Return the stored answers by kind, function and call."""
    return {
        (kind, name, key): answer["answer"]
        for kind, functions in stored.items()
        for name, answers in functions.items()
        for key, answer in answers.items()
    }


def nearly_equal(first, second):
    """Return whether two stored answers are equal except for their last digits."""
    if isinstance(first, dict) and "shape" in first:
        first, second = decode(first, (), {}), decode(second, (), {})
        return first.shape == second.shape and np.allclose(first, second, atol=0.02, equal_nan=True)
    if isinstance(first, dict):
        return first.keys() == second.keys() and all(
            nearly_equal(first[k], second[k]) for k in first
        )
    if isinstance(first, list):
        return len(first) == len(second) and all(map(nearly_equal, first, second))
    if isinstance(first, float):
        # The order in which NumPy sorts equal values depends on the kind of processor. Trees in
        # another order are also right, but a search in them visits a few more or fewer nodes.
        return bool(np.isclose(first, second, rtol=0.05, equal_nan=True))
    return first == second
