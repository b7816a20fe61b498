"""Every notebook runs: the solved one to its end, the student's to its first stub."""

import nbformat
import pytest

from tests.colab import why_not
from tests.running import assert_stopped_at_a_stub, errors_of, outputs_of, run, written

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


@pytest.mark.skipif(not why_not(), reason="test_colab.py runs them, with Colab's versions")
def test_student_notebook_runs_to_its_first_stub(lesson):
    notebook = run(nbformat.read(lesson.released, as_version=4), lesson.released.parent)
    assert_stopped_at_a_stub(notebook)
