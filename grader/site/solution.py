"""Executed solutions as notebooks to publish, with fixed sliders and without guesses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_output

from grader.site.widget_states import ANSWER, POSITION, QUESTION
from utils.predictions import as_html_and_text


def as_notebook(ran: bytes) -> bytes:
    """Return a solved notebook whose outputs can be shown by any notebook viewer.

    Parameters
    ----------
    ran : bytes
        Executed notebook, from `grader.site.runs.solved_runs`.
    """
    notebook = nbformat.reads(ran.decode(), as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = list(_outputs(cell.outputs))
    return (nbformat.writes(notebook) + "\n").encode()


def _outputs(outputs: Iterable[NotebookNode]) -> Iterator[NotebookNode]:
    positions = 0  # the lesson's own position comes first
    for output in outputs:
        data = output.get("data", {})
        positions += POSITION in data
        if ANSWER in data:
            about = data[ANSWER]
            html, text = as_html_and_text(
                about["question"], {"Answer": about["answer"]}, about["why"]
            )
            yield new_output("display_data", data={"text/html": html, "text/plain": text})
        elif positions < 2 and POSITION not in data and QUESTION not in data:
            yield output
