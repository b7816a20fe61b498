"""Every notebook runs: the solved one to its end, the student's to its first stub."""

import contextlib

import nbclient
import nbformat
import pytest

from tests.colab import why_not

pytestmark = [pytest.mark.slow, pytest.mark.skipif(
    not why_not(), reason="test_colab.py runs them all, with Colab's versions")]

LONGEST_RUN = 120  # seconds; the aim is 30, on a machine with nothing else to do


def run(path, folder):
    """Execute a notebook as if it lay in `folder`, up to its first error."""
    notebook = nbformat.read(path, as_version=4)
    client = nbclient.NotebookClient(notebook, timeout=LONGEST_RUN, resources={
        "metadata": {"path": str(folder)}})
    # While nbclient answers widgets it may sleep through the kernel's reply to a cell
    # (github.com/jupyter/nbclient/issues/312). Without, what a widget shows stays in its cell.
    client.comm_open_handlers.clear()
    with contextlib.suppress(nbclient.exceptions.CellExecutionError):
        client.execute()
    return notebook


def errors_of(notebook):
    """(cell number, name of the exception) of each cell that failed."""
    return [(number, output.ename) for number, cell in enumerate(notebook.cells)
            if cell.cell_type == "code" for output in cell.outputs
            if output.output_type == "error"]


def test_solved_notebook_runs_to_its_end(lesson):
    notebook = run(lesson.solved, lesson.released.parent)
    assert errors_of(notebook) == []
    noise = [output.text for cell in notebook.cells if cell.cell_type == "code"
             for output in cell.outputs if output.get("name") == "stderr"]
    assert noise == []
    pictures = [output for cell in notebook.cells if cell.cell_type == "code"
                for output in cell.outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 5
    assert all(len(picture.data["image/png"]) < 400_000 for picture in pictures)


def test_student_notebook_runs_to_its_first_stub(lesson):
    notebook = run(lesson.released, lesson.released.parent)
    stub = next(number for number, cell in enumerate(notebook.cells)
                if cell.metadata.get("nbgrader", {}).get("solution"))
    errors = errors_of(notebook)
    assert errors
    # Defining a stub is no error; calling it is. What comes before runs clean.
    assert errors[0][0] > stub
    assert errors[0][1] == "NotImplementedError"
