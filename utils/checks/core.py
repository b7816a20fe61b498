"""What a check is, how it is declared, and how a notebook runs it."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass

from utils.checks.tips import tip_for
from utils.checks.vocabulary import CheckFailed

# The lesson that asks for each exercise; `utils.checks.lesson_NN` declares its checks.
_LESSONS = {
    "01": ("horizontal_distance", "drop_invalid"),
    "02": ("line_through", "point_line_distance", "ransac_line"),
    "03": (
        "plane_through",
        "point_plane_distance",
        "ransac_plane",
        "fit_plane",
        "iterations_needed",
    ),
    "04": ("insert", "search", "median_order"),
    "05": ("euclidean_clustering",),
    "06": ("filter_ground", "voxel_grid"),
    "07": ("filter_by_distance", "crop_region", "remove_ego_returns"),
    "08": ("get_bounding_boxes",),
    "09": ("filter_clusters",),
    "10": ("euclidean_clustering_accelerated",),
    "11": ("principal_axes", "get_oriented_boxes"),
    "12": ("detect_obstacles", "match_boxes"),
}
_LESSON_OF = {exercise: number for number, exercises in _LESSONS.items() for exercise in exercises}
_CHECKS: dict[str, list["Check"]] = {}


@dataclass(frozen=True)
class Check:
    """One property that a right answer has.

    Attributes
    ----------
    exercise : str
        Name of the function under test.
    title : str
        The property, as a statement.
    why : str
        What goes wrong on the road without it.
    hint : str
        The first hint for someone who fails it.
    weight : float
        Its share of the exercise's points, relative to the other checks.
    run : callable
        Takes the function; raises `CheckFailed` where the property does not hold.
    """

    exercise: str
    title: str
    why: str
    hint: str
    weight: float
    run: Callable

    @property
    def name(self) -> str:
        """Short name, unique within the exercise."""
        return self.run.__name__


@dataclass(frozen=True)
class Outcome:
    """What came of running a check; `failure` is None where it passed."""

    check: Check
    failure: CheckFailed | None


class ChecksFailed(AssertionError):
    """Not all checks passed. A notebook shows one line of it; plain nbgrader counts it as 0."""

    def _render_traceback_(self) -> list[str]:
        return [str(self)]


def visible(exercise: str, *, title: str, why: str, hint: str, weight: float = 1.0) -> Callable:
    """Declare a function that takes the student's function as a visible check.

    Parameters
    ----------
    exercise : str
        Name of the student's function.
    title, why, hint : str
    weight : float
        As in `Check`.

    Returns
    -------
    callable
        The decorator; the function stays as it is.
    """

    def declare(run: Callable) -> Callable:
        _CHECKS.setdefault(exercise, []).append(Check(exercise, title, why, hint, weight, run))
        return run

    return declare


def checks_of(exercise: str) -> tuple[Check, ...]:
    """The visible checks of an exercise, in the order they are written.

    Parameters
    ----------
    exercise : str
        Name of a function of the course.

    Returns
    -------
    tuple of Check

    Raises
    ------
    LookupError
        If the course has no such exercise.
    """
    if exercise not in _LESSON_OF:
        known = ", ".join(_LESSON_OF)
        raise LookupError(
            f"There are no checks for {exercise!r}. Pass the function itself, "
            f"under the name it was given: one of {known}."
        )
    importlib.import_module(f"utils.checks.lesson_{_LESSON_OF[exercise]}")
    return tuple(_CHECKS[exercise])


def run_check(one_check: Check, function: Callable) -> Outcome:
    """Run one check.

    Parameters
    ----------
    one_check : Check
    function : callable

    Returns
    -------
    Outcome
    """
    try:
        one_check.run(function)
    except CheckFailed as failure:
        return Outcome(one_check, failure)
    except NotImplementedError:
        return Outcome(
            one_check,
            CheckFailed(
                f"{one_check.exercise} still raises NotImplementedError. Replace that line with "
                "your code and run its cell again."
            ),
        )
    except Exception as error:
        name = type(error).__name__
        return Outcome(
            one_check,
            CheckFailed(
                f"{one_check.exercise} raised {name}: {error}", tip=tip_for(name, str(error))
            ),
        )
    return Outcome(one_check, None)


def check(function: Callable, exercise: str | None = None) -> None:
    """Check an answer and show what is right, what is wrong and why it matters.

    Parameters
    ----------
    function : callable
        A function (or class) of the course that you wrote.
    exercise : str, optional
        Which exercise, where a class holds more than one; by default the function's own name.

    Raises
    ------
    ChecksFailed
        If a check fails, after everything has been shown.
    """
    from utils.checks.display import show

    exercise = exercise or getattr(function, "__name__", str(function))
    outcomes = [run_check(one_check, function) for one_check in checks_of(exercise)]
    show(outcomes)
    failed = sum(outcome.failure is not None for outcome in outcomes)
    if failed:
        raise ChecksFailed(
            f"{failed} of {len(outcomes)} checks failed; the table above says which and why."
        )
