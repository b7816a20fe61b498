"""Every solved notebook runs to its end.

A student's notebook is the same up to its first stub: see test_build.py.
"""

import nbformat
import pytest

from tests.running import errors_of, outputs_of, run, written

pytestmark = pytest.mark.slow


def test_solved_notebook_runs_to_its_end(lesson):
    notebook = run(nbformat.read(lesson.solved, as_version=4), lesson.released.parent)
    assert errors_of(notebook) == []
    assert written(notebook, "stderr") == ""
    pictures = [
        output.data["image/png"]
        for _, output in outputs_of(notebook)
        if "image/png" in output.get("data", {})
    ]
    assert len(pictures) >= 5
    assert all(len(picture) < 400_000 for picture in pictures)
