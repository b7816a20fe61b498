"""Plugins that run the judge inside nbgrader, for courses that use nbgrader's own commands.

`CopyExporter` reads a submission in the same way as the judge. `Judge` replaces nbgrader's
execution of a notebook. `SaveGrades` keeps marks given by a person, and `LatePenalties` counts days
late on the clock. `python -m grader grade` uses `grader.lms.gradebook_writer` instead of these
plugins.
"""

from pathlib import Path

from nbconvert.exporters import NotebookExporter
from nbformat import NotebookNode
from nbgrader.api import Gradebook
from nbgrader.preprocessors import AssignLatePenalties, NbGraderPreprocessor, SaveAutoGrades
from nbgrader.utils import determine_grade
from traitlets import Enum, Integer

from grader.classroom.grade import current_verdict
from grader.classroom.submissions import Submission
from grader.course import earlier_lessons
from grader.course.deadlines import Deadlines
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.seed import course_seed
from grader.intake.submission import read_submitted_files
from grader.judging.verdict import JUDGED
from grader.lms.answer_fingerprints import (
    fingerprints,
    read_fingerprints,
    regrade,
    write_fingerprints,
)
from grader.lms.autograded_copy import build_copy_in_process, build_judged_copy
from grader.lms.autograded_folder import remove_web_pages
from grader.lms.gradebook_dates import enter_due_dates, set_extension
from grader.lms.penalties import penalty_of
from grader.lms.submission_times import lesson_times, naive_submission_time
from grader.sandbox import AUTO, SANDBOXES, choose_sandbox


class ClearEarlierFunctions(NbGraderPreprocessor):
    """Removes functions of earlier lessons from the cell into which students paste them."""

    def preprocess_cell(
        self, cell: NotebookNode, resources: dict, cell_index: int
    ) -> tuple[NotebookNode, dict]:
        """Remove the solution from a cell with the tag for earlier lessons."""
        if earlier_lessons.TAG in cell.metadata.get("tags", ()):
            cell.source = earlier_lessons.remove_solution(cell.source)
        return cell, resources


class Judge(NbGraderPreprocessor):
    """Judges a submission, and writes scores and messages below the graded cells of its copy."""

    seed = Integer(
        None,
        allow_none=True,
        help="Seed of the hidden scenes; by default the course's secret seed in .course_seed.",
    ).tag(config=True)
    sandbox = Enum(
        (AUTO, *SANDBOXES),
        AUTO,
        help="Where student code runs; see `python -m grader grade --help`.",
    ).tag(config=True)

    def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
        """Build the autograded copy, which replaces the notebook that nbgrader has read.

        Parameters
        ----------
        nb : nbformat.NotebookNode
        resources : dict
            nbgrader's resources, which name the student, the assignment and the notebook.
        """
        names = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        remove_web_pages(course.autograded / names["student"] / names["assignment"])
        submission = _submission(course, names)
        verdict = current_verdict(
            course, submission, course_seed(course, self.seed), choose_sandbox(self.sandbox)
        )
        if verdict.status != JUDGED:  # a missing mark is better than a wrong one
            raise RuntimeError(verdict.reason)
        submitted_files = submission.read_again(course, verdict.fingerprint)
        copy, complaint = build_judged_copy(submitted_files, submission.lesson, verdict)
        if complaint:
            self.log.warning(complaint)
        return copy, resources


class SaveGrades(SaveAutoGrades):
    """Saves scores like nbgrader, but keeps marks given by a person while they are valid."""

    def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
        """Save the scores of a notebook; see nbgrader."""
        names = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        _enter_dates(course, names)
        answers = read_fingerprints(course, names["student"], names["assignment"])
        now = fingerprints(nb)
        before = answers.get(names["notebook"], {})
        self.unchanged = {name for name in now if before.get(name) == now[name]}
        nb, resources = super().preprocess(nb, resources)
        answers[names["notebook"]] = now
        write_fingerprints(course, names["student"], names["assignment"], answers)
        return nb, resources

    def _add_score(self, cell: NotebookNode, resources: dict) -> None:
        name = cell.metadata.nbgrader["grade_id"]
        grade = self.gradebook.find_grade(
            name, self.notebook_id, self.assignment_id, self.student_id
        )
        score, _ = determine_grade(cell, self.log)
        regrade(grade, score, name in self.unchanged)
        self.gradebook.db.commit()


def _enter_dates(course: Course, names: dict) -> None:
    """Enter a student's submission time and due date before nbgrader computes penalties."""
    deadlines = _deadlines(course)
    with Gradebook(names["db_url"]) as book:
        enter_due_dates(course, book, deadlines)
        submission = book.find_submission(names["assignment"], names["student"])
        folder = course.submitted / names["student"] / names["assignment"]
        submission.timestamp = naive_submission_time([folder])
        set_extension(course, submission, deadlines)
        book.db.commit()


class LatePenalties(AssignLatePenalties):
    """Assigns late penalties like nbgrader, but counts days late on the course's clock."""

    def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
        """Assign the penalty of a notebook; see nbgrader."""
        names = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        deadlines = _deadlines(course)
        times = lesson_times([_submission(course, names)], deadlines)
        self.init_plugin()
        with Gradebook(names["db_url"]) as book:
            submission = book.find_submission(names["assignment"], names["student"])
            notebook = book.find_submission_notebook(
                names["notebook"], names["assignment"], names["student"]
            )
            notebook.late_submission_penalty = penalty_of(
                submission, notebook, self, deadlines, times
            )
            book.db.commit()
        return nb, resources


def _submission(course: Course, names: dict) -> Submission:
    """Return the submission that nbgrader is grading; nbgrader accepts only one file name."""
    lesson = find_lesson(names["notebook"])
    path = course.submitted / names["student"] / names["assignment"] / f"{lesson.name}.ipynb"
    return Submission(names["student"], lesson, path)


def _deadlines(course: Course) -> Deadlines:
    return read_deadlines(course) or Deadlines({})


class CopyExporter(NotebookExporter):
    """Reads a submission like the judge; an unreadable file becomes a notebook without answers.

    nbgrader rejects a student's whole submission if one of its files is damaged. The judge gives a
    verdict on such a file, so nbgrader only needs a notebook to which the verdict can be added.
    """

    def from_filename(
        self, filename: str, resources: dict | None = None, **options: object
    ) -> tuple[NotebookNode, dict]:
        """Convert a notebook file; see nbconvert."""
        path = Path(filename)
        lesson = find_lesson(path.stem)
        copy, _ = build_copy_in_process(read_submitted_files(path), lesson)
        resources = {"metadata": {"name": path.stem, "path": str(path.parent)}, **(resources or {})}
        return self.from_notebook_node(copy, resources=resources, **options)
