"""Write the feedback on a lesson as a notebook.

Canvas gives a feedback file the name of the submitted file, which is a notebook. An HTML page with
that name could not be opened. Notebook viewers show HTML, but not style sheets or MathML, so
formulas stay in source form.
"""

from __future__ import annotations

import nbformat

from grader.lms.feedback import Feedback, LessonFeedback, SanitizedText
from grader.lms.feedback_page import render_template

INTRODUCTION = "This notebook contains your feedback. The notebook that you submitted is unchanged."


def feedback_notebook(feedback: Feedback, lesson: LessonFeedback) -> bytes:
    """Build the feedback notebook for one lesson, with the sentences about the whole stage."""
    head = render_template("notebook.html", feedback=feedback, lesson=lesson, sentence=INTRODUCTION)
    cells = [_html(head)]
    for exercise in lesson.exercises:
        cells.append(_html(render_template("exercise.html", exercise=exercise)))
        cells += [_markdown(exercise.answer)] if exercise.answer else []
        cells += [_html("<b>Comment</b>"), _markdown(exercise.comment)] if exercise.comment else []
    for number, cell in enumerate(cells):
        cell.id = f"feedback-{number}"
    notebook = nbformat.v4.new_notebook(cells=cells)
    return (nbformat.writes(notebook) + "\n").encode()


def _html(text: str) -> nbformat.NotebookNode:
    """Build a cell that is one HTML block in Markdown; an empty line would end the block."""
    block = "\n".join(line for line in text.splitlines() if line.strip())
    # Text between two dollar signs would be read as a formula.
    return nbformat.v4.new_markdown_cell(f"<div>\n{block}\n</div>".replace("$", "&#36;"))


def _markdown(text: SanitizedText) -> nbformat.NotebookNode:
    fields = {"attachments": text.attachments} if text.attachments else {}
    return nbformat.v4.new_markdown_cell(text.markdown, **fields)
