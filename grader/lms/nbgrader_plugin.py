"""The judge inside nbgrader.

`Judge` stands where nbgrader would execute a notebook: it puts the judge's scores into the
graded cells, in the form that nbgrader itself reads, so that its gradebook, Formgrader, late
penalties, hand grading, feedback and export go on as ever. `MendingExporter` lets nbgrader
read submissions that it would otherwise give up on.
"""

import json
from html import escape
from pathlib import Path

import nbformat
from nbconvert.exporters import NotebookExporter
from nbformat import NotebookNode
from nbgrader.preprocessors import NbGraderPreprocessor
from nbgrader.utils import is_grade, is_solution
from traitlets import Enum, Integer

from grader.classroom.grade import current_verdict
from grader.classroom.submissions import Submission
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.seed import course_seed
from grader.intake.notebook import read_notebook
from grader.judging.verdict import JUDGED, ExerciseResult, Verdict
from grader.sandbox import AUTO, SANDBOXES, choose_sandbox
from utils.notebooks.reading import UnreadableNotebook


class Judge(NbGraderPreprocessor):
    """Judge the submission and write its scores and messages under the graded cells."""

    seed = Integer(
        None,
        allow_none=True,
        help="Seed of the hidden scenes; by default the course's own secret, in .course_seed.",
    ).tag(config=True)
    sandbox = Enum(
        (AUTO, *SANDBOXES),
        AUTO,
        help="Where student code runs; see `python -m grader grade --help`.",
    ).tag(config=True)

    def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
        """Replace the outputs of all cells by what the judge says.

        Parameters
        ----------
        nb : nbformat.NotebookNode
        resources : dict
            nbgrader's: which student, assignment and notebook this is.

        Returns
        -------
        (nbformat.NotebookNode, dict)
        """
        about = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        lesson = find_lesson(about["notebook"])
        path = course.submitted / about["student"] / about["assignment"] / f"{lesson.name}.ipynb"
        verdict = current_verdict(
            course,
            Submission(about["student"], lesson, path),
            course_seed(course, self.seed),
            choose_sandbox(self.sandbox),
        )
        if verdict.status != JUDGED:  # no mark is better than a wrong one
            raise RuntimeError(verdict.problems[0])
        write_into(nb, verdict)
        return nb, resources


class MendingExporter(NotebookExporter):
    """Reads a submission as the judge does; an unreadable one as a notebook without answers.

    nbgrader drops a student's whole submission when one file in it is damaged. The judge gives
    such a file its verdict, so nbgrader only needs something to write that verdict into.
    """

    def from_filename(
        self, filename: str, resources: dict | None = None, **options: object
    ) -> tuple[NotebookNode, dict]:
        """Convert a notebook file; see nbconvert."""
        path = Path(filename)
        lesson = find_lesson(path.stem)
        released = nbformat.reads(lesson.released.read_text("utf-8"), as_version=4)
        try:
            read_notebook(path)
            notebook = nbformat.read(path, as_version=4)
            nbformat.validate(notebook)
        except (
            UnreadableNotebook,
            nbformat.ValidationError,
            AttributeError,
            KeyError,
            TypeError,
            ValueError,
        ):
            notebook = released
        restore_metadata(notebook, released)
        resources = {"metadata": {"name": path.stem, "path": str(path.parent)}, **(resources or {})}
        return self.from_notebook_node(notebook, resources=resources, **options)


def restore_metadata(notebook: NotebookNode, released: NotebookNode) -> None:
    """Give nbgrader's cells the metadata they were released with, whatever became of it."""
    original = {
        cell.metadata.nbgrader.grade_id: cell.metadata.nbgrader
        for cell in released.cells
        if "nbgrader" in cell.metadata
    }
    for cell in notebook.cells:
        grade_id = cell.metadata.get("nbgrader", {}).get("grade_id")
        if grade_id in original:
            cell.metadata.nbgrader = original[grade_id]
        else:
            cell.metadata.pop("nbgrader", None)


def write_into(notebook: NotebookNode, verdict: Verdict) -> None:
    """Write a verdict under the graded cells of a notebook, in place of all outputs."""
    results = {exercise.name: exercise for exercise in verdict.exercises}
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        cell.outputs, cell.execution_count = [], None
        if is_grade(cell) and not is_solution(cell):
            cell.execution_count = 1
            cell.outputs = [
                score_output(results[cell.metadata.nbgrader["grade_id"].removeprefix("test_")])
            ]
    if verdict.problems:
        # A block of HTML, in which nobody's Markdown is at work.
        listed = "".join(f"<li>{escape(sentence)}</li>" for sentence in verdict.problems)
        notebook.cells.insert(
            0,
            nbformat.v4.new_markdown_cell(
                f"<div><b>About this notebook</b><ul>{listed}</ul></div>"
            ),
        )
    notebook.metadata["verdict_key"] = verdict.key


def score_output(exercise: ExerciseResult) -> NotebookNode:
    """An output from which nbgrader reads the score and people read the reasons.

    Parameters
    ----------
    exercise : grader.judging.verdict.ExerciseResult

    Returns
    -------
    nbformat.NotebookNode
    """
    rows = "".join(
        f"<tr><td style='text-align:left;vertical-align:top;white-space:nowrap'>"
        f"{'✓ passed' if test.passed else '✗ failed'}</td>"
        f"<td style='text-align:left'><b>{escape(test.title)}</b>"
        f"{''.join(f'<br>{escape(line)}' for line in test.message.splitlines())}</td>"
        f"<td style='vertical-align:top'>{test.score:g} / {test.max_score:g}</td></tr>"
        for test in exercise.tests
    )
    return nbformat.v4.new_output(
        "execute_result",
        execution_count=1,
        data={
            "text/plain": json.dumps(exercise.score),
            "text/html": f"<p><b>{escape(exercise.name)}: {exercise.score:g} of "
            f"{exercise.max_score:g} points</b></p><table>{rows}</table>",
        },
    )
