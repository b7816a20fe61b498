"""The registry of stages, lessons, exercises and points, read from the lessons themselves.

The name of a lesson's folder, the header of its source, and the nbgrader metadata of its cells
register the lesson. There is no other list of lessons.
"""

import ast
import functools
import json
import re
import types
from dataclasses import dataclass
from pathlib import Path

from grader.course import earlier_lessons
from grader.course.header import LessonHeader, read_header
from grader.course.paths import PROJECT, Course
from utils.notebooks import slicing

# Folder of the optional lessons in ``solutions/``.
OPTIONAL_FOLDER = "optional"


@dataclass(frozen=True)
class Exercise:
    """A graded function or written answer.

    Attributes
    ----------
    name : str
        Name of the function, or of the written answer.
    points : float
    cell : str
        nbgrader's ``grade_id`` of the cell that carries the points.
    by_hand : bool
        Whether a person grades it.
    """

    name: str
    points: float
    cell: str
    by_hand: bool


@dataclass(frozen=True)
class Lesson:
    """One notebook of the course."""

    name: str
    stage: str

    @property
    def number(self) -> str:
        """The number of the lesson in the course, as two digits."""
        return self.name[:2]

    @property
    def folder(self) -> Path:
        """Folder of the lesson in ``solutions/``, which students must not see."""
        return PROJECT / "solutions" / self.stage / self.name

    @property
    def source(self) -> Path:
        """Path of the lesson's source."""
        return self.folder / "lesson.py"

    @property
    def text(self) -> str:
        """Text of the source, including the code of functions from earlier lessons."""
        return earlier_lessons.insert_functions(self.source.read_text("utf-8"))

    @property
    def released(self) -> Path:
        """Path of the student's notebook."""
        return PROJECT / "notebooks" / self.stage / f"{self.name}.ipynb"

    @property
    def solved(self) -> Path:
        """Path of the instructor's notebook."""
        return self.folder.with_name(f"{self.name}.ipynb")

    @property
    def tests(self) -> Path:
        """Path of the hidden tests."""
        return self.folder / "hidden_tests.py"

    @functools.cached_property
    def header(self) -> LessonHeader:
        """Settings in the header of the source."""
        return read_header(self.source)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the graded functions, and of functions and classes that the lesson provides."""
        return (*(exercise.name for exercise in self.machine_graded), *self.header.given)

    def source_of(self, names: tuple[str, ...]) -> str:
        """Return the source of some functions in the student's notebook, with the code they need.

        The source does not contain exercises, because students write these functions.
        """
        own = {exercise.name for exercise in self.machine_graded}
        cells = json.loads(self.released.read_text("utf-8"))["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        statements, _ = slicing.parse_notebook(code)
        needed = [
            statement
            for statement in slicing.slice_for(names, statements)
            if not statement.binds & own
        ]
        return "\n".join(ast.unparse(statement.node) for statement in needed)

    @property
    def machine_graded(self) -> tuple[Exercise, ...]:
        """Exercises that the judge grades. A person grades the others."""
        return tuple(exercise for exercise in self.exercises if not exercise.by_hand)

    @functools.cached_property
    def steps(self) -> tuple[str, ...]:
        """Functions without points that a student writes in preparation for an exercise."""
        graded = {exercise.name for exercise in self.exercises}
        steps = []
        for cell in json.loads(self.released.read_text("utf-8"))["cells"]:
            grading = cell["metadata"].get("nbgrader", {})
            if grading.get("solution") and grading["grade_id"] not in graded:
                steps.append(grading["grade_id"])
        return tuple(steps)

    @functools.cached_property
    def exercises(self) -> tuple[Exercise, ...]:
        """All exercises, in the order of the notebook."""
        exercises = []
        for cell in json.loads(self.released.read_text("utf-8"))["cells"]:
            grading = cell["metadata"].get("nbgrader", {})
            if grading.get("grade"):
                name = grading["grade_id"].removeprefix("test_")
                points, by_hand = float(grading["points"]), bool(grading.get("solution"))
                exercises.append(Exercise(name, points, grading["grade_id"], by_hand))
        return tuple(exercises)


@functools.cache
def all_lessons() -> tuple[Lesson, ...]:
    """Return all lessons that belong to a stage, in the order of the course."""
    return _lessons_in("stage*")


@functools.cache
def optional_lessons() -> tuple[Lesson, ...]:
    """Return the optional lessons, which have no stage and no points and are not submitted."""
    return _lessons_in(OPTIONAL_FOLDER)


def _lessons_in(stage: str) -> tuple[Lesson, ...]:
    sources = sorted((PROJECT / "solutions").glob(f"{stage}/[0-9][0-9]_*/lesson.py"))
    return tuple(Lesson(source.parent.name, source.parents[1].name) for source in sources)


def every_lesson() -> tuple[Lesson, ...]:
    """Return the lessons of all stages, followed by the optional lessons."""
    return all_lessons() + optional_lessons()


def registry_faults() -> list[str]:
    """Find sources that are ignored, and lessons that share a number or an exercise.

    Returns
    -------
    list of str
        What is wrong and how to fix it, for each fault.
    """
    lessons, faults = every_lesson(), []
    known_sources = {lesson.source for lesson in lessons}
    for source in sorted((PROJECT / "solutions").rglob("*.py")):
        if source.name == "lesson.py" and source not in known_sources:
            faults.append(
                f"{source.relative_to(PROJECT)} is ignored. Move it to "
                "solutions/STAGE/NN_NAME/lesson.py. STAGE must begin with stage, or be "
                f"{OPTIONAL_FOLDER}."
            )
        elif re.fullmatch(r"\d\d_\w+", source.stem) and source.parent != PROJECT / "solutions":
            faults.append(
                f"{source.relative_to(PROJECT)} is ignored. Move it to "
                f"{source.relative_to(PROJECT).with_suffix('') / 'lesson.py'}."
            )
    by_number: dict[str, Lesson] = {}
    by_exercise: dict[str, Lesson] = {}
    for lesson in lessons:
        if (first_lesson := by_number.setdefault(lesson.number, lesson)) != lesson:
            faults.append(
                f"{first_lesson.name} and {lesson.name} have the same number. Renumber one of "
                f"them and its checks in utils/checks/lesson_{lesson.number}."
            )
        for name in re.findall(r'"grade": true, "grade_id": "test_(\w+)"', lesson.text):
            if (first_lesson := by_exercise.setdefault(name, lesson)) != lesson:
                faults.append(
                    f"{first_lesson.name} and {lesson.name} both have an exercise {name}. "
                    "Rename one of the two."
                )
    return faults


def stages() -> tuple[str, ...]:
    """Return the names of the stages, in order."""
    return tuple(dict.fromkeys(lesson.stage for lesson in all_lessons()))


def released_lessons(course: Course, stage: str) -> list[Lesson]:
    """Return the lessons of a stage in the course's release; without a release, all of them."""
    released = course.released / stage
    return [
        lesson
        for lesson in all_lessons()
        if lesson.stage == stage
        and (not released.is_dir() or (released / f"{lesson.name}.ipynb").is_file())
    ]


def find_lesson(text: str) -> Lesson | None:
    """Return the lesson whose name a text contains, or None.

    The text may be a file name that a browser or editor has changed, such as "Copy of
    06_filter_ground (1).ipynb".
    """
    for lesson in all_lessons():
        if re.search(rf"(?<![0-9]){re.escape(lesson.name)}(?![a-z_])", text):
            return lesson
    return None


def lesson_of(exercise_name: str) -> Lesson:
    """Return the lesson that contains an exercise.

    Raises
    ------
    LookupError
        If no lesson contains the exercise.
    """
    for lesson in all_lessons():
        if exercise_name in (exercise.name for exercise in lesson.exercises):
            return lesson
    raise LookupError(f"No lesson has the exercise {exercise_name!r}.")


@functools.cache
def load_reference(lesson_name: str, *additional_names: str) -> types.SimpleNamespace:
    """Return the reference functions of a lesson, as attributes of a namespace.

    Parameters
    ----------
    lesson_name : str
    *additional_names : str
        Names of further functions of the lesson, which are not graded.
    """
    lesson = next(lesson for lesson in every_lesson() if lesson.name == lesson_name)
    statements, skipped = slicing.parse_notebook([lesson.text])
    if skipped:
        raise ValueError(f"{lesson.name}: {skipped[0].sentence}")
    names = (*lesson.names, *additional_names)
    namespace = {"__name__": lesson.name}
    for statement in slicing.slice_for(names, statements):
        exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    return types.SimpleNamespace(**{name: namespace[name] for name in names})
