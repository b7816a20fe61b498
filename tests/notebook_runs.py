"""Run notebooks and read what came of it."""

import contextlib
from pathlib import Path

import nbclient

LONGEST_CELL = 120  # seconds; a whole notebook should take 30


def run(notebook, folder, **settings):
    """Execute a notebook as if it lay in `folder`, up to its first error.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
        Gets the outputs.
    folder : pathlib.Path
    **settings : dict
        For nbclient, such as `kernel_name`.

    Returns
    -------
    nbformat.NotebookNode
        The same.
    """
    client = nbclient.NotebookClient(
        notebook, timeout=LONGEST_CELL, resources={"metadata": {"path": str(folder)}}, **settings
    )
    # While nbclient answers widgets it may sleep through the kernel's reply to a cell
    # (github.com/jupyter/nbclient/issues/312). Without, what a widget shows stays in its cell.
    client.comm_open_handlers.clear()
    with contextlib.suppress(nbclient.exceptions.CellExecutionError):
        client.execute()
    return notebook


def outputs_of(notebook):
    """(cell number, output) of everything that the cells gave."""
    return [
        (number, output)
        for number, cell in enumerate(notebook.cells)
        for output in cell.get("outputs", ())
    ]


def errors_of(notebook):
    """(cell number, "name of the exception: its message") of the cell that failed, if any."""
    return [
        (number, f"{output.ename}: {output.evalue}")
        for number, output in outputs_of(notebook)
        if output.output_type == "error"
    ]


def errors_beside_checks(notebook):
    """As `errors_of`, without those of the cells that check: they may fail, and nothing stops."""
    return [
        (number, error)
        for number, error in errors_of(notebook)
        if not notebook.cells[number].source.startswith("check(")
    ]


def written(notebook, stream):
    """All that was written to "stdout" or "stderr"."""
    return "".join(
        output.text for _, output in outputs_of(notebook) if output.get("name") == stream
    )


def children():
    """Numbers of the processes that this one has started, dead ones that nobody waited for too."""
    tasks = Path("/proc/self/task").glob("*/children")
    return {int(number) for task in tasks for number in task.read_text().split()}
