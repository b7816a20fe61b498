"""A course with two students and made-up verdicts, and the marks in its gradebook."""

import shutil
import sqlite3

from grader.classroom.submissions import find_submissions
from grader.course import paths
from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.judging.verdict import JUDGED, ExerciseResult, Verdict
from grader.lms import gradebook
from grader.lms.results_reader import class_results

GROUND = find_lesson("06_filter_ground")
DISTANCE = find_lesson("07_filter_by_distance")
STREAM = find_lesson("12_streaming_obstacles")
STAGE = GROUND.stage
# Points of each exercise by student and lesson.
EARNED = {
    "ada": {GROUND: (3.25, 8.5), DISTANCE: (11.75, 2.0, 4.5)},
    "bob": {DISTANCE: (19.5, 0.0, 1.25)},
}


def submit(course, student, lesson, text=""):
    path = course.submitted / student / lesson.stage / f"{lesson.name}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(fill_in(lesson, {}) + text, "utf-8")


def verdict_on(course, submission, earned, **more):
    exercises = tuple(
        ExerciseResult(exercise.name, score, exercise.points, ())
        for exercise, score in zip(submission.lesson.machine_graded, earned, strict=True)
    )
    fields = {
        "status": "".join(JUDGED),  # equal but not identical, as in verdicts from files
        "key": f"of {submission.student} {earned}",
        "fingerprint": submission.read(course).fingerprint(),
    } | more
    return Verdict(
        lesson=submission.lesson.name,
        student=submission.student,
        score=sum(earned),
        max_score=sum(exercise.max_score for exercise in exercises),
        exercises=exercises,
        problems=(),
        seconds=0.0,
        **fields,
    )


def verdicts(course, earned=EARNED, **more):
    """Return (submission, verdict) for each submission that has points in `earned`."""
    return [
        (
            submission,
            verdict_on(course, submission, earned[submission.student][submission.lesson], **more),
        )
        for submission in find_submissions(course)
        if submission.lesson in earned.get(submission.student, {})
    ]


def ignore_progress(done, total, what):
    """Accept progress reports, and show nothing."""


def make_course(root):
    """Return a course with two released lessons of a stage and submissions of two students."""
    course = Course(root)
    (course.released / STAGE).mkdir(parents=True)
    for lesson in (GROUND, DISTANCE):
        shutil.copy(lesson.released, course.released / STAGE)
    for student, lessons in EARNED.items():
        for lesson in lessons:
            submit(course, student, lesson)
    paths._folder.cache_clear()
    return course


def marks(course):
    """Return the points and the maximum of each graded cell by student and cell."""
    with gradebook.open_gradebook(course) as book:
        return {
            (submission.student.id, grade.name): (grade.auto_score, grade.max_score)
            for assignment in book.assignments
            for submission in assignment.submissions
            for notebook in submission.notebooks
            for grade in notebook.grades
        }


def penalties(course):
    """Return the late penalty of each student who has one."""
    stages = class_results(course).stages
    return {stage.student: stage.penalty for stage in stages if stage.penalty}


def inode(course, student="ada"):
    """Return the inode of a student's folder of copies, which changes when copies are rewritten."""
    return (course.autograded / student / STAGE).stat().st_ino


LATE_PLUGIN = """
c = get_config()
c.AssignLatePenalties.plugin_class = "grader.lms.late.PercentPerDay"
c.PercentPerDay.percent = 10
"""


def set_due(course, hour):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate=f"2026-03-01 {hour}:00:00")


def gradebook_rows(course):
    """Return the content of the gradebook without row numbers."""
    base = sqlite3.connect(course.root / "gradebook.db")
    query = """
        select student.id, assignment.name, notebook.name, base_cell.name, grade.auto_score,
            grade.manual_score, grade.needs_manual_grade, grade_cells.max_score,
            submitted_assignment.timestamp, submitted_notebook.late_submission_penalty
        from grade join base_cell on grade.cell_id = base_cell.id
        join grade_cells on grade_cells.id = base_cell.id
        join submitted_notebook on grade.notebook_id = submitted_notebook.id
        join notebook on submitted_notebook.notebook_id = notebook.id
        join submitted_assignment on submitted_notebook.assignment_id = submitted_assignment.id
        join assignment on submitted_assignment.assignment_id = assignment.id
        join student on submitted_assignment.student_id = student.id order by 1, 2, 3, 4"""
    found = base.execute(query).fetchall()
    comments = base.execute(
        """select student_id, base_cell.name, auto_comment from comment
        join base_cell on comment.cell_id = base_cell.id
        join submitted_notebook on comment.notebook_id = submitted_notebook.id
        join submitted_assignment on submitted_notebook.assignment_id = submitted_assignment.id
        order by 1, 2"""
    ).fetchall()
    cells = base.execute(
        "select name, cell_type, locked, source, checksum from source_cell order by name"
    ).fetchall()
    base.close()
    return found, comments, cells
