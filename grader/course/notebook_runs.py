"""Run a notebook of the course from the first cell to the last, in a separate kernel."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nbclient import NotebookClient
    from nbformat import NotebookNode

MAX_CELL_SECONDS = 300  # enough even on a busy machine


class NotebookStopped(Exception):
    """A notebook did not run to the end; `str()` is the sentence to show."""


def run_notebook(notebook: NotebookNode, folder: Path, *, checks_may_fail: bool = False) -> None:
    """Run a notebook in a folder, and store the outputs in the notebook.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
    folder : pathlib.Path
        The working directory of the kernel.
    checks_may_fail : bool
        Whether calls to ``check`` may raise, as they do in a notebook without answers.

    Raises
    ------
    NotebookStopped
        If a cell raises, takes more than `MAX_CELL_SECONDS` seconds, or crashes the kernel.
    """
    import nbclient

    client = nbclient.NotebookClient(
        notebook,
        timeout=MAX_CELL_SECONDS,
        resources={"metadata": {"path": str(folder)}},
        store_widget_state=False,
        force_raise_errors=not checks_may_fail,  # even in cells tagged raises-exception
        extra_arguments=["--log-level=ERROR"],  # log lines would break a progress bar
    )
    client.comm_open_handlers.clear()  # so that a widget's output stays in its cell
    try:
        execute(client)
    except nbclient.exceptions.CellExecutionError:
        pass  # `_first_error` finds the error in the outputs of the cell
    except nbclient.exceptions.CellTimeoutError:
        raise NotebookStopped(
            f"a cell took more than {MAX_CELL_SECONDS} seconds. Is the machine busy? Run the same "
            "command again."
        ) from None
    except nbclient.exceptions.DeadKernelError:
        raise NotebookStopped(
            "Python ended unexpectedly. Is there enough memory? Run the same command again."
        ) from None
    if error := _first_error(notebook.cells, checks_may_fail):
        raise NotebookStopped(error)


def execute(client: NotebookClient) -> None:
    """Run all cells of a client's notebook; try once more if the kernel does not start.

    Jupyter chooses the ports before the kernel opens them, so another program may take one.
    """
    from nbclient.exceptions import DeadKernelError

    try:
        client.execute()
    except DeadKernelError:  # it died later, while it ran a cell
        raise
    except RuntimeError:
        client.execute()


def _first_error(cells: Sequence[NotebookNode], checks_may_fail: bool) -> str:
    for cell in cells:
        if checks_may_fail and cell.source.startswith("check("):
            continue
        for output in cell.get("outputs", ()):
            if output.output_type == "error":
                lines = (line for line in cell.source.splitlines() if not line.startswith("#"))
                # Python 3.13 has a private name for the SyntaxError of a cell that ends too early.
                error = output.ename.replace("_IncompleteInputError", "SyntaxError")
                return (
                    f"the cell that begins with `{next(lines, '').strip()}` raises "
                    f"{error}: {output.evalue.rstrip('.')}."
                )
    return ""
