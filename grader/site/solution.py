"""Convert executed solutions to notebooks to publish, without sliders and questions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_output

from grader.site.widget_states import ANSWER_TYPE, POSITION_TYPE, QUESTION_TYPE
from utils.predictions import as_html_and_text


def as_notebook(solved_run: bytes) -> bytes:
    """Convert the outputs of a solved notebook, so that any notebook viewer can show them.

    Parameters
    ----------
    solved_run : bytes
        Executed notebook, from `grader.site.runs.solved_runs`.
    """
    notebook = nbformat.reads(solved_run.decode(), as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.outputs = list(_outputs(cell.outputs))
    return (nbformat.writes(notebook) + "\n").encode()


def _outputs(outputs: Iterable[NotebookNode]) -> Iterator[NotebookNode]:
    positions = 0  # the first is the lesson's own; later ones are left out
    for output in outputs:
        data = output.get("data", {})
        positions += POSITION_TYPE in data
        if ANSWER_TYPE in data:
            about = data[ANSWER_TYPE]
            html, text = as_html_and_text(
                about["question"], {"Answer": about["answer"]}, about["why"]
            )
            yield new_output("display_data", data={"text/html": html, "text/plain": text})
        elif positions < 2 and POSITION_TYPE not in data and QUESTION_TYPE not in data:
            yield output
