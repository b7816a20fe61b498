"""What the course consists of: stages, lessons, exercises and their points.

Points come from the nbgrader metadata of the released notebooks, the reference solutions from
the lessons' sources: neither is written down a second time.
"""

import functools
import json
import re
import types
from dataclasses import dataclass

from grader.course.paths import PROJECT
from utils.notebooks import slicing

# Modules that do a lesson's exercise. Looking up neighbours is allowed; clustering is not.
CLUSTERING = ("sklearn.cluster", "scipy.cluster", "hdbscan", "dbscan", "open3d", "pcl")
FORBIDDEN = {
    "04_kd_tree": ("scipy.spatial", "sklearn.neighbors"),
    "05_euclidean_clustering": CLUSTERING,
    "10_accelerated_clustering": CLUSTERING,
}
# Classes that the judge makes objects of, beside the functions that are exercises.
CLASSES = {"04_kd_tree": ("KdTree",)}


@dataclass(frozen=True)
class Exercise:
    """One graded function.

    Attributes
    ----------
    name : str
        Name of the function.
    points : float
    cell : str
        nbgrader's ``grade_id`` of the cell that holds the points.
    by_hand : bool
        True where a person grades it.
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
    def source(self):
        """The one file in which the lesson is written."""
        return PROJECT / "solutions" / self.stage / f"{self.name}.py"

    @property
    def released(self):
        """The student's notebook."""
        return PROJECT / "notebooks" / self.stage / f"{self.name}.ipynb"

    @property
    def solved(self):
        """The instructor's notebook."""
        return self.source.with_suffix(".ipynb")

    @property
    def tests(self):
        """The judge's tests."""
        return PROJECT / "grader" / "tests" / f"test_{self.name}.py"

    @property
    def forbidden(self):
        """Modules that may not be used."""
        return FORBIDDEN.get(self.name, ())

    @property
    def names(self):
        """Functions and classes of the notebook that the judge uses."""
        return (
            *(exercise.name for exercise in self.exercises if not exercise.by_hand),
            *CLASSES.get(self.name, ()),
        )

    @functools.cached_property
    def exercises(self):
        """Tuple of `Exercise`, in the order of the notebook."""
        found = []
        for cell in json.loads(self.released.read_text("utf-8"))["cells"]:
            grading = cell["metadata"].get("nbgrader", {})
            if grading.get("grade"):
                name = grading["grade_id"].removeprefix("test_")
                found.append(
                    Exercise(
                        name,
                        float(grading["points"]),
                        grading["grade_id"],
                        bool(grading.get("solution")),
                    )
                )
        return tuple(found)


@functools.cache
def all_lessons():
    """Tuple of every `Lesson`, in the order of the course."""
    sources = sorted((PROJECT / "solutions").glob("stage*/[0-9][0-9]_*.py"))
    return tuple(Lesson(source.stem, source.parent.name) for source in sources)


def stages():
    """Names of the stages, in order."""
    return tuple(dict.fromkeys(lesson.stage for lesson in all_lessons()))


def find_lesson(text):
    """The lesson whose name occurs in a text, such as a file name.

    Browsers and editors rename files ("Copy of 06_filter_ground (1).ipynb").

    Parameters
    ----------
    text : str

    Returns
    -------
    Lesson or None
    """
    for lesson in all_lessons():
        if re.search(rf"(?<![0-9]){re.escape(lesson.name)}(?![a-z_])", text):
            return lesson
    return None


@functools.cache
def load_reference(lesson_name):
    """The reference functions of a lesson, as attributes of a namespace.

    Parameters
    ----------
    lesson_name : str

    Returns
    -------
    types.SimpleNamespace
    """
    lesson = next(lesson for lesson in all_lessons() if lesson.name == lesson_name)
    text = lesson.source.read_text("utf-8")
    statements, problems = slicing.parse_notebook([text])
    if problems:
        raise ValueError(f"{lesson.source.name}: {problems[0]}")
    namespace = {"__name__": lesson.name}
    for statement in slicing.slice_for(lesson.names, statements):
        exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    return types.SimpleNamespace(**{name: namespace[name] for name in lesson.names})
