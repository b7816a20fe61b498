"""A class of three students with right answers, who are judged in this process."""

from grader.classroom import grade
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from tests.executors import InlineExecutor

SEED = 20_170_405
LESSON = find_lesson("06_filter_ground")
RIGHT = {
    exercise: next(variant.source for variant in answers_to(exercise) if variant.right)
    for exercise in ("filter_ground", "voxel_grid")
}


def class_of_three(root):
    """Return a course in which three students submit right answers."""
    course = Course(root)
    for student in ("ada", "poison", "zoe"):
        path = course.submitted / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in(LESSON, RIGHT), "utf-8")
    return course


def grade_class(
    course, sandbox, open_executor=InlineExecutor, workers=1, progress=lambda *news: None
):
    """Grade the course; return the verdict of each student."""
    judged = grade.judge_class(course, (), SEED, sandbox, open_executor, workers, progress)
    return {submission.student: verdict for submission, verdict in judged}
