"""Run notebooks and read their outputs."""

import contextlib
from pathlib import Path

import nbclient

from grader.course.notebook_runs import execute

LONGEST_CELL = 120  # seconds; a whole notebook usually takes about 30


def run(notebook, folder, **settings):
    """Execute a notebook as if it were in `folder`, up to its first error.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        Notebook to run; the outputs are added to it.
    folder : pathlib.Path
    **settings : dict
        Settings of nbclient, such as `kernel_name`.

    Returns
    -------
    nbformat.NotebookNode
        The same notebook.
    """
    client = nbclient.NotebookClient(
        notebook, timeout=LONGEST_CELL, resources={"metadata": {"path": str(folder)}}, **settings
    )
    # While nbclient handles widgets, it may miss the kernel's reply to a cell
    # (github.com/jupyter/nbclient/issues/312). Without handlers, widget output stays in its cell.
    client.comm_open_handlers.clear()
    with contextlib.suppress(nbclient.exceptions.CellExecutionError):
        execute(client)
    return notebook


def outputs_of(notebook):
    """Return all outputs, as (cell number, output)."""
    return [
        (number, output)
        for number, cell in enumerate(notebook.cells)
        for output in cell.get("outputs", ())
    ]


def errors_of(notebook):
    """Return the errors, as (cell number, "name of the exception: its message")."""
    return [
        (number, f"{output.ename}: {output.evalue}")
        for number, output in outputs_of(notebook)
        if output.output_type == "error"
    ]


def errors_outside_checks(notebook):
    """Return the errors in cells other than checks; only checks may fail."""
    return [
        (number, error)
        for number, error in errors_of(notebook)
        if not notebook.cells[number].source.startswith("check(")
    ]


def printed_text(notebook, stream):
    """Return all text written to "stdout" or "stderr"."""
    return "".join(
        output.text for _, output in outputs_of(notebook) if output.get("name") == stream
    )


def child_processes():
    """Return the IDs of this process's children, including zombies."""
    tasks = Path("/proc/self/task").glob("*/children")
    return {int(number) for task in tasks for number in task.read_text().split()}
