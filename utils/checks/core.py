"""What a check is, how it is declared, and how a notebook runs it."""

import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass

from utils.checks.tips import tip_for
from utils.checks.vocabulary import CheckFailed

# Every module `lesson_NN` of this package declares the checks of its exercises here.
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
    modules = _modules_of_lessons()
    while exercise not in _CHECKS and modules:
        importlib.import_module(modules.pop(0))
    if exercise not in _CHECKS:
        # By lesson, whatever was imported first.
        names = sorted(_CHECKS, key=lambda name: _CHECKS[name][0].run.__module__)
        raise LookupError(
            f"There are no checks for {exercise!r}. Pass the function itself, "
            f"under the name it was given: one of {', '.join(names)}."
        )
    return tuple(_CHECKS[exercise])


def _modules_of_lessons() -> list[str]:
    """Full names of the modules that declare checks, in the order of the course."""
    package = importlib.import_module("utils.checks")
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return [f"{package.__name__}.{name}" for name in names if name.startswith("lesson_")]


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
    failed = [outcome.check.title for outcome in outcomes if outcome.failure is not None]
    if failed:
        # Where there is no table, as in `nbgrader validate`, this is all that is shown.
        first = "" if len(failed) == 1 else ", the first of them"
        raise ChecksFailed(f"{len(failed)} of {len(outcomes)} checks failed{first}:\n{failed[0]}")
