"""Enter verdicts into nbgrader's gradebook, by nbgrader's own converters.

One process writes: nbgrader's database is SQLite by default.
"""

import contextlib
import json
from collections.abc import Callable, Iterable, Sequence

from nbgrader.api import Gradebook, MissingEntry
from nbgrader.converters import Autograde, GenerateAssignment
from nbgrader.coursedir import CourseDirectory
from traitlets.config import Config

from grader.classroom.submissions import Submission
from grader.course.nbgrader_settings import configure, converter
from grader.course.paths import Course
from grader.judging.verdict import JUDGED, Verdict
from grader.lms.results import ClassResults, NotebookResult
from grader.sandbox import Sandbox


class GradebookTrouble(Exception):
    """nbgrader could not enter something; `str()` is the sentence to show."""


def open_gradebook(course: Course) -> Gradebook:
    """Open nbgrader's gradebook of a course, made where there is none; a context manager."""
    directory = CourseDirectory(config=configure(Config(), course.root))
    return Gradebook(directory.db_url, directory.course_id)


def register(course: Course, stages: Iterable[str]) -> None:
    """Make sure that the gradebook knows the stages, with the points of their cells.

    Parameters
    ----------
    course : grader.course.paths.Course
    stages : iterable of str
    """
    for stage in stages:
        with open_gradebook(course) as gradebook, contextlib.suppress(MissingEntry):
            gradebook.find_assignment(stage)
            continue
        converter(GenerateAssignment, course.root, stage).start()


def enter(
    course: Course,
    judged: Sequence[tuple[Submission, Verdict]],
    seed: int,
    sandbox: Sandbox,
    progress: Callable[[int, int, object], None],
) -> None:
    """Enter the scores of a class.

    Parameters
    ----------
    course : grader.course.paths.Course
    judged : list of (Submission, Verdict)
    seed : int
    sandbox : grader.sandbox.Sandbox
    progress : callable
        Called with (done, total, submission) after each student's stage.

    Raises
    ------
    GradebookTrouble
        After everybody else has been entered.
    """
    keys, failed = {}, []
    for submission, verdict in judged:
        group = keys.setdefault((submission.student, submission.lesson.stage), {})
        group[submission.lesson.name] = verdict.key
    for submission, verdict in judged:
        if verdict.status != JUDGED:  # no mark is better than a wrong one
            keys.pop((submission.student, submission.lesson.stage), None)
            failed.append(
                f"{submission.student}, {submission.lesson.stage}: not entered, because the judge "
                f"failed on {submission.lesson.name}; see {submission.verdict_path(course)}"
            )
    register(course, dict.fromkeys(stage for _, stage in keys))
    for done, ((student, stage), wanted) in enumerate(keys.items(), start=1):
        if not is_entered(course, student, stage, wanted):
            autograde = converter(
                Autograde, course.root, stage, Judge={"seed": seed, "sandbox": sandbox.name}
            )
            autograde.coursedir.student_id = student
            try:
                autograde.start()
            except Exception as error:  # nbgrader raises many things; one student must not
                failed.append(f"{student}, {stage}: {error}")  # stop the others
        progress(done, len(keys), student)
    if failed:
        raise GradebookTrouble(
            "Some submissions were not entered into the gradebook. Where nbgrader could not, "
            "`nbgrader autograde` on them says why:\n" + "\n".join(failed)
        )


def is_entered(course: Course, student: str, stage: str, wanted: dict[str, str]) -> bool:
    """True if the autograded notebooks carry exactly these verdicts.

    Parameters
    ----------
    wanted : dict of str to str
        Key of the verdict by name of the lesson.
    """
    for lesson_name, key in wanted.items():
        path = course.root / "autograded" / student / stage / f"{lesson_name}.ipynb"
        try:
            entered = json.loads(path.read_text("utf-8"))["metadata"]["verdict_key"]
        except (OSError, ValueError, KeyError):
            return False
        if entered != key:
            return False
    return True


def class_results(course: Course) -> ClassResults:
    """Read the gradebook of a course."""
    with open_gradebook(course) as gradebook:
        submissions = [
            submission
            for assignment in gradebook.assignments
            for submission in assignment.submissions
        ]
        notebooks = [
            NotebookResult(
                submission.student.id,
                submission.assignment.name,
                notebook.name,
                notebook.score,
                notebook.max_score,
                notebook.needs_manual_grade,
            )
            for submission in submissions
            for notebook in submission.notebooks
        ]
        penalties = {
            (submission.student.id, submission.assignment.name): submission.late_submission_penalty
            for submission in submissions
            if submission.late_submission_penalty
        }
    notebooks.sort(key=lambda result: (result.student, result.lesson))
    return ClassResults(tuple(notebooks), penalties)
