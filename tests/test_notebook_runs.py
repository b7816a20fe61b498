"""Running the course's notebooks, and naming the cell that stops one."""

import socket

import nbformat
import pytest
from jupyter_client.provisioning.local_provisioner import LocalPortCache

from grader.course.notebook_runs import NotebookStopped, run_notebook


def notebook_of(*sources):
    """Return a notebook with these code cells; as in a lesson, only checks may raise exceptions."""
    cells = [nbformat.v4.new_code_cell(source) for source in sources]
    for cell in cells:
        cell.metadata["tags"] = ["raises-exception"] * ("check" in cell.source)
    return nbformat.v4.new_notebook(cells=cells)


CHECK = "def check(right):\n    assert right, 'one check fails.'"


def test_a_notebook_runs_in_its_folder_and_gets_outputs(tmp_path):
    (tmp_path / "here.txt").write_text("found")
    notebook = notebook_of("print(open('here.txt').read())")
    run_notebook(notebook, tmp_path)
    assert notebook.cells[0].outputs[0].text == "found\n"


def test_the_kernel_starts_again_if_another_program_took_its_port(tmp_path, monkeypatch):
    choose_port = LocalPortCache.find_available_port
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        listener.listen()
        taken = [listener.getsockname()[1]]
        monkeypatch.setattr(
            LocalPortCache,
            "find_available_port",
            lambda cache, ip: taken.pop() if taken else choose_port(cache, ip),
        )
        notebook = notebook_of("print(6 * 7)")
        run_notebook(notebook, tmp_path)
    assert not taken and notebook.cells[0].outputs[0].text == "42\n"


def test_the_cell_that_stops_a_notebook_is_named(tmp_path):
    notebook = notebook_of("size = 3", "# Draw it.\ndraw(size)\nprint()", "print(1)")
    with pytest.raises(NotebookStopped, match=r"begins with `draw\(size\)` raises NameError: name"):
        run_notebook(notebook, tmp_path)
    with pytest.raises(NotebookStopped, match="raises SyntaxError"):
        run_notebook(notebook_of("size = (3"), tmp_path)


def test_a_failing_check_stops_only_a_solved_notebook(tmp_path):
    cells = CHECK, "check(False)", "after = 1"
    run_notebook(notebook_of(*cells), tmp_path, checks_may_fail=True)
    with pytest.raises(NotebookStopped, match="AssertionError: one check fails\\.$"):
        run_notebook(notebook_of(*cells), tmp_path)
    with pytest.raises(NotebookStopped, match="`picture` raises NameError"):
        run_notebook(notebook_of(*cells, "picture"), tmp_path, checks_may_fail=True)


def test_a_notebook_that_ends_python_or_never_ends_is_reported(tmp_path, monkeypatch):
    with pytest.raises(NotebookStopped, match="Python ended unexpectedly"):
        run_notebook(notebook_of("import os; os._exit(1)"), tmp_path)
    monkeypatch.setattr("grader.course.notebook_runs.MAX_CELL_SECONDS", 1)
    with pytest.raises(NotebookStopped, match="a cell took more than 1 seconds"):
        run_notebook(notebook_of("while True: pass"), tmp_path)
