"""Run a notebook of the course from the first cell to the last, in a separate kernel."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nbformat import NotebookNode

LONGEST_CELL = 300  # seconds, on a machine with other work


class NotebookStopped(Exception):
    """A notebook did not run to the end; `str()` is the sentence to show."""


def run_notebook(notebook: NotebookNode, folder: Path, *, checks_may_fail: bool = False) -> None:
    """Run a notebook as if it were in a folder, and add its outputs to it.

    Parameters
    ----------
    notebook : nbformat.NotebookNode
    folder : pathlib.Path
    checks_may_fail : bool
        Whether calls of ``check`` may raise, as in a notebook without answers.

    Raises
    ------
    NotebookStopped
        If a cell raises, takes more than `LONGEST_CELL` seconds, or ends Python.
    """
    import nbclient

    client = nbclient.NotebookClient(
        notebook,
        timeout=LONGEST_CELL,
        resources={"metadata": {"path": str(folder)}},
        store_widget_state=False,
        force_raise_errors=not checks_may_fail,  # ignore the tags that allow a cell to raise
        extra_arguments=["--log-level=ERROR"],  # messages of kernels would break a progress bar
    )
    client.comm_open_handlers.clear()  # so that the output of a widget stays in its cell
    try:
        client.execute()
    except nbclient.exceptions.CellExecutionError:
        pass  # the outputs of the cell are more informative
    except nbclient.exceptions.CellTimeoutError:
        raise NotebookStopped(
            f"a cell took more than {LONGEST_CELL} seconds. Is the machine busy? Run the same "
            "command again."
        ) from None
    except nbclient.exceptions.DeadKernelError:
        raise NotebookStopped(
            "Python ended unexpectedly. Is there enough memory? Run the same command again."
        ) from None
    if error := _first_error(notebook.cells, checks_may_fail):
        raise NotebookStopped(error)


def _first_error(cells: Sequence[NotebookNode], checks_may_fail: bool) -> str:
    for cell in cells:
        if checks_may_fail and cell.source.startswith("check("):
            continue
        for output in cell.get("outputs", ()):
            if output.output_type == "error":
                lines = (line for line in cell.source.splitlines() if not line.startswith("#"))
                return (
                    f"the cell that begins with `{next(lines, '').strip()}` raises "
                    f"{output.ename}: {output.evalue.rstrip('.')}."
                )
    return ""
