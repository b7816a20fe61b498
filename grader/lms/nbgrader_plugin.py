"""The judge inside nbgrader, for those who use nbgrader's own commands.

`CopyExporter` reads a submission as the judge does. `Judge` stands where nbgrader would execute
a notebook. `SaveGrades` keeps what a person graded. `python -m grader grade` does the same without
nbgrader's converters, in `grader.lms.gradebook_writer`.
"""

from pathlib import Path

from nbconvert.exporters import NotebookExporter
from nbformat import NotebookNode
from nbgrader.api import Gradebook
from nbgrader.preprocessors import NbGraderPreprocessor, SaveAutoGrades
from nbgrader.utils import determine_grade
from traitlets import Enum, Integer

from grader.classroom.grade import current_verdict
from grader.classroom.submissions import Submission
from grader.course import earlier_lessons
from grader.course.deadlines import Deadlines, read_deadlines
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.seed import course_seed
from grader.intake.submission import read_handed_in
from grader.judging.verdict import JUDGED
from grader.lms.answers import fingerprints, read_known, regrade, write_known
from grader.lms.autograded import copy_apart, judged_copy
from grader.lms.dates import enter_due_dates, extend
from grader.lms.submission_times import known_time
from grader.sandbox import AUTO, SANDBOXES, choose_sandbox


class ClearEarlier(NbGraderPreprocessor):
    """Take the functions of earlier lessons out of the cell into which students paste theirs."""

    def preprocess_cell(
        self, cell: NotebookNode, resources: dict, cell_index: int
    ) -> tuple[NotebookNode, dict]:
        """Empty a cell that is tagged so."""
        if earlier_lessons.TAG in cell.metadata.get("tags", ()):
            cell.source = earlier_lessons.emptied(cell.source)
        return cell, resources


class Judge(NbGraderPreprocessor):
    """Judge the submission; its copy gets the scores and messages under the graded cells."""

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
        """Build the copy of what was judged, in place of what nbgrader has read of the file.

        Parameters
        ----------
        nb : nbformat.NotebookNode
        resources : dict
            nbgrader's: which student, assignment and notebook this is.
        """
        about = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        lesson = find_lesson(about["notebook"])
        path = course.submitted / about["student"] / about["assignment"] / f"{lesson.name}.ipynb"
        submission = Submission(about["student"], lesson, path)
        verdict = current_verdict(
            course, submission, course_seed(course, self.seed), choose_sandbox(self.sandbox)
        )
        if verdict.status != JUDGED:  # no mark is better than a wrong one
            raise RuntimeError(verdict.problems[0])
        handed_in = submission.read_again(course, verdict.fingerprint)
        copy, complaint = judged_copy(handed_in, lesson, verdict)
        if complaint:
            self.log.warning(complaint)
        return copy, resources


class SaveGrades(SaveAutoGrades):
    """Save scores as nbgrader does, but leave alone what a person has graded and still stands."""

    def preprocess(self, nb: NotebookNode, resources: dict) -> tuple[NotebookNode, dict]:
        """Save the scores of a notebook; see nbgrader."""
        about = resources["nbgrader"]
        course = Course(Path(self.parent.parent.coursedir.root))
        _enter_dates(course, about)
        known = read_known(course, about["student"], about["assignment"])
        now = fingerprints(nb)
        before = known.get(about["notebook"], {})
        self.unchanged = {name for name in now if before.get(name) == now[name]}
        nb, resources = super().preprocess(nb, resources)
        known[about["notebook"]] = now
        write_known(course, about["student"], about["assignment"], known)
        return nb, resources

    def _add_score(self, cell: NotebookNode, resources: dict) -> None:
        name = cell.metadata.nbgrader["grade_id"]
        grade = self.gradebook.find_grade(
            name, self.notebook_id, self.assignment_id, self.student_id
        )
        score, _ = determine_grade(cell, self.log)
        regrade(grade, score, name in self.unchanged)
        self.gradebook.db.commit()


def _enter_dates(course: Course, about: dict) -> None:
    """Let nbgrader know when a student's work came and is due, before it takes points off."""
    deadlines = read_deadlines(course) or Deadlines({})
    with Gradebook(about["db_url"]) as book:
        enter_due_dates(course, book, deadlines)
        submission = book.find_submission(about["assignment"], about["student"])
        place = course.submitted / about["student"] / about["assignment"]
        submission.timestamp = known_time([place])
        extend(course, submission, deadlines)
        book.db.commit()


class CopyExporter(NotebookExporter):
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
        copy, _ = copy_apart(read_handed_in(path), lesson)
        resources = {"metadata": {"name": path.stem, "path": str(path.parent)}, **(resources or {})}
        return self.from_notebook_node(copy, resources=resources, **options)
