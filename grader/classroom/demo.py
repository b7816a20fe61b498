"""A sample class with right answers, typical mistakes, and submissions that break graders."""

import itertools
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import Lesson, all_lessons
from grader.course.paths import PROJECT, Course

DEMO_FOLDER = PROJECT / "demo"
STAGE = "stage3_obstacles"  # the default stage
NAMES = (
    "ada",
    "bruno",
    "chioma",
    "dmitri",
    "elif",
    "farid",
    "greta",
    "hiro",
    "ines",
    "jonas",
    "kavya",
    "liam",
    "mei",
    "noor",
    "olga",
    "pedro",
    "quynh",
    "rosa",
    "sven",
    "tariq",
    "uma",
    "vera",
    "wanjiru",
    "xenia",
    "yusuf",
    "zoe",
)

CONFIGURATION = """\
# This is a complete nbgrader course: try `nbgrader formgrader` or `nbgrader generate_feedback`.
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, {project!r})

from grader.course.nbgrader_settings import configure  # noqa: E402

configure(get_config(), HERE)  # noqa: F821
"""

# Code that tries to cheat or to do damage instead of solving the exercise.
HOSTILE_CODE = """\
import os, sys, gc

def {name}(*arguments, **keywords):
    for path in ("solutions", "gradebook.db", ".course_seed"):
        try:
            print(os.listdir(path) if os.path.isdir(path) else open(path).read())
        except OSError:
            pass
    for number in range(3, 64):
        try:
            os.write(number, b"give me full marks")
        except OSError:
            pass
    os._exit(0)
"""


@dataclass(frozen=True)
class SampleStudent:
    """A sample student: a name, and a notebook for each lesson."""

    name: str
    notebooks: dict


def make_class(count: int, hostile: bool, stages: Sequence[str] = (STAGE,)) -> Course:
    """Create ``demo/`` with the submissions of a class.

    Parameters
    ----------
    count : int
        Number of students.
    hostile : bool
        Whether one student attacks the grader; must be False without a sandbox.
    stages : sequence of str
        Stages that every student submits.
    """
    course = Course(DEMO_FOLDER)
    shutil.rmtree(course.root, ignore_errors=True)
    for folder, stage in itertools.product(("solutions", "notebooks"), stages):
        shutil.copytree(
            PROJECT / folder / stage,
            course.root / folder / stage,
            ignore=lambda folder, names: [name for name in names if not name.endswith(".ipynb")],
        )
    (course.root / "nbgrader_config.py").write_text(
        CONFIGURATION.format(project=str(PROJECT)), "utf-8"
    )
    for student in sample_students(count, hostile, stages):
        for lesson, text in student.notebooks.items():
            path = course.submitted / student.name / lesson.stage / f"{lesson.name}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, "utf-8")
    return course


def sample_students(count: int, hostile: bool, stages: Sequence[str]) -> Iterator[SampleStudent]:
    """Yield `count` students: mostly ordinary ones, and a few special cases."""
    names = (
        name if turn == 0 else f"{name}{turn + 1}" for turn in itertools.count() for name in NAMES
    )
    lessons = [lesson for lesson in all_lessons() if lesson.stage in stages]
    special_students = [
        SampleStudent("not_started", {lesson: fill_in(lesson, {}) for lesson in lessons}),
        SampleStudent(
            "cut_off_file",
            {lesson: fill_in(lesson, right_answers(lesson))[:20_000] for lesson in lessons},
        ),
    ]
    if hostile:
        special_students.append(
            SampleStudent(
                "attacker",
                {
                    lesson: fill_in(
                        lesson,
                        {
                            exercise.name: HOSTILE_CODE.format(name=exercise.name)
                            for exercise in lesson.machine_graded
                        },
                    )
                    for lesson in lessons
                },
            )
        )
    # Every fourth student is a special case until all are used, so small classes include some.
    students = (
        SampleStudent(
            next(names),
            {lesson: fill_in(lesson, sample_answers(lesson, number)) for lesson in lessons},
        )
        for number in itertools.count()
    )
    for position in range(count):
        yield special_students.pop(0) if position % 4 == 3 and special_students else next(students)


def sample_answers(lesson: Lesson, number: int) -> dict[str, str]:
    """Return one student's answers, which are wrong for every third student."""
    chosen = {}
    for exercise in lesson.machine_graded:
        right = number % 3 != 2
        pool = [variant for variant in answers_to(exercise.name) if variant.right == right]
        chosen[exercise.name] = pool[(number // 3 if not right else number) % len(pool)].source
    return chosen


def right_answers(lesson: Lesson) -> dict[str, str]:
    """Return a right answer to every exercise."""
    return {
        exercise.name: next(answer.source for answer in answers_to(exercise.name) if answer.right)
        for exercise in lesson.machine_graded
    }
