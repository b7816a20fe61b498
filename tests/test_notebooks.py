"""Every solved notebook runs to its end, and so does every untouched one.

A student's notebook is the same up to its first stub: see test_build.py. From there on it lives
on answers that the course lends; they are those that the solved notebook gives.
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
    now = named(json.loads(recorded_answers.stored_bytes(lesson, tmp_path / "answers.json")))
    stored = named(json.loads(recorded_answers.path_of(lesson).read_text("utf-8")))
    again = f"Run: python -m grader.course.recorded_answers {lesson.number}"
    assert now.keys() == stored.keys(), again
    for name, answer in now.items():
        assert alike(answer, stored[name]), f"{name} has changed. {again}"


def test_untouched_notebook_runs_to_its_end(lesson):
    notebook = run(nbformat.read(lesson.released, as_version=4), lesson.released.parent)
    assert errors_beside_checks(notebook) == []
    assert written(notebook, "stderr") == ""
    code = [cell for cell in notebook.cells if cell.cell_type == "code" and cell.source.strip()]
    assert all(cell.execution_count for cell in code)


def named(stored):
    """Answers by kind, function and call."""
    return {
        (kind, name, key): answer["answer"]
        for kind, functions in stored.items()
        for name, answers in functions.items()
        for key, answer in answers.items()
    }


def alike(one, other):
    """Whether two stored answers are the same but for the last digits."""
    if isinstance(one, dict) and "shape" in one:
        first, second = decode(one, (), {}), decode(other, (), {})
        return first.shape == second.shape and np.allclose(first, second, atol=0.02, equal_nan=True)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(alike(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(alike, one, other))
    if isinstance(one, float):
        # NumPy sorts what is equal one way with one kind of processor and another way with the
        # next. The trees are as right, and a search in them looks at a few nodes more or less.
        return bool(np.isclose(one, other, rtol=0.05, equal_nan=True))
    return one == other
