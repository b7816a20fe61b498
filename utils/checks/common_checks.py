"""Checks that many exercises share, called promises, each declared in a few lines.

A lesson describes one plain call to the function of an exercise. For each promise, it then gives
the name, the weight and the texts. The promise becomes an ordinary visible check, in the order of
declaration::

    _CROP = Case(__name__, "crop_region", {"cloud": _ROOM, "minimum": ..., "maximum": ...},
                 expected=_INSIDE, compare=assert_boxed, precondition=assert_crops)

    common_checks.promise_names(_CROP, "names_the_corners", why="Others may pass them by name.")
    common_row_checks.promise_order(_CROP, "crops_in_order")

Promises for certain kinds of exercises are in `common_row_checks`, `common_box_checks` and
`common_cluster_checks`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from utils.checks.assertions import assert_untouched
from utils.checks.core import visible_check
from utils.checks.failures import CheckFailed
from utils.checks.limits import TimeUp
from utils.remote_objects import RemoteError, RemoteProxy

_FIRST_LINE = "Keep the first line of the function as it was given"


def _no_precondition(function: Callable) -> None:
    """Accept any function."""


@dataclass(frozen=True)
class Case:
    """A plain call to the function of an exercise, whose right answer is known.

    Attributes
    ----------
    lesson : str
        The `__name__` of the module that declares the promises.
    exercise : str
        Name of the student's function.
    arguments : mapping of str to object
        The arguments by name, in the order of the signature. Promises vary the first of them: a
        cloud, points or labels.
    expected : object
        The right answer, for `compare`. For a function that selects rows, the mask of the rows to
        keep.
    compare : callable
        Takes an answer, the arguments and `expected`; raises `CheckFailed` if the answer is wrong.
    precondition : callable, optional
        Takes the function; raises `NotYet` if a precondition of the promises is not met.
    """

    lesson: str
    exercise: str
    arguments: Mapping[str, object]
    expected: object
    compare: Callable
    precondition: Callable = _no_precondition

    @property
    def first(self) -> np.ndarray:
        """The first argument, which promises vary."""
        return next(iter(self.arguments.values()))

    @property
    def copies(self) -> dict[str, object]:
        """Copies of the arguments, which the function may change."""
        return copy.deepcopy(dict(self.arguments))

    @property
    def without_precondition(self) -> Case:
        """The same call, judged without its precondition."""
        return replace(self, precondition=_no_precondition)

    def with_first(self, first: np.ndarray, **changes: object) -> Case:
        """Return the same call with another first argument; `changes` replace other fields."""
        name = next(iter(self.arguments))
        return replace(self, arguments={**self.arguments, name: first}, **changes)

    def with_rows(self, which: slice | np.ndarray) -> Case:
        """Return the same call for some of the points; `expected` has one entry per point."""
        return self.with_first(self.first[which], expected=self.expected[which])

    def answer_of(self, function: Callable) -> object:
        """Call a function with copies of the arguments; return the answer."""
        return function(*self.copies.values())

    def assert_right(self, function: Callable) -> None:
        """Assert that a function returns the expected answer."""
        self.assert_right_answer(self.answer_of(function))

    def assert_right_answer(self, answer: object) -> None:
        """Assert that an answer is the expected one."""
        self.compare(answer, *self.arguments.values(), self.expected)


@dataclass(frozen=True)
class Promise:
    """A declared promise of an exercise, with its case and its check.

    Attributes
    ----------
    kind : str
        Short name, such as "untouched" for `promise_untouched`.
    case : Case
    name : str
        Name of the check.
    """

    kind: str
    case: Case
    name: str


_PROMISES: list[Promise] = []


def all_promises() -> tuple[Promise, ...]:
    """Return all promises of the imported lessons, in the order of their declaration."""
    return tuple(_PROMISES)


def promise(kind: str, case: Case, name: str, **words: object) -> Callable:
    """Return a decorator that makes a function the check of a promise.

    Parameters
    ----------
    kind : str
        Kind of promise, as in `Promise`.
    case : Case
    name : str
        Name of the check, unique within the exercise.
    **words : object
        Title, why, hint and weight, as for `visible_check`.

    Returns
    -------
    callable
        The decorator. The decorated function takes the student's function and raises
        `CheckFailed` if that function breaks the promise.
    """

    def declare(run: Callable) -> Callable:
        run.__name__, run.__module__ = name, case.lesson
        _PROMISES.append(Promise(kind, case, name))
        return visible_check(case.exercise, **words)(run)

    return declare


# ---- promises of every exercise ----------------------------------------------------------------


def promise_names(
    case: Case,
    name: str,
    *,
    why: str,
    title: str = "Keeps the names of its parameters",
    weight: float = 1,
) -> None:
    """Check that the arguments can be passed by name."""
    hint = f"{_FIRST_LINE}."

    @promise("names", case, name, title=title, why=why, hint=hint, weight=weight)
    def run(function: Callable) -> None:
        case.precondition(function)
        case.assert_right_answer(function(**case.copies))


def promise_default(
    case: Case, argument: str, *, title: str, why: str, weight: float = 1
) -> Callable:
    """Return a decorator for an assertion that omits an argument to test its default.

    Parameters
    ----------
    case : Case
    argument : str
        The parameter with its default, as in the signature: ``"distance=10.0"``.
    title, why : str
    weight : float

    Returns
    -------
    callable
        The decorator; it returns the function unchanged.
    """
    hint = f"{_FIRST_LINE}: {argument}."

    def declare(assertion: Callable) -> Callable:
        @promise(
            "default", case, assertion.__name__, title=title, why=why, hint=hint, weight=weight
        )
        def run(function: Callable) -> None:
            case.precondition(function)
            assertion(function)

        return assertion

    return declare


def promise_untouched(
    case: Case,
    name: str,
    *,
    why: str,
    hint: str,
    title: str = "Does not change its input",
    weight: float = 1,
) -> None:
    """Check that the function changes neither its arguments nor those of `extend_arguments`."""
    full = extend_arguments(case.arguments)
    is_more = any(full[argument] is not value for argument, value in case.arguments.items())

    @promise("untouched", case, name, title=title, why=why, hint=hint, weight=weight)
    def run(function: Callable) -> None:
        case.precondition(function)
        assert_untouched(function, *case.arguments.values())
        if not is_more:
            return
        own = RemoteError if isinstance(function, RemoteProxy) else Exception
        try:
            assert_untouched(function, *full.values())
        except (CheckFailed, TimeUp):
            raise
        except own:
            return  # other checks test whether the function accepts four columns or the label 0


def extend_arguments(arguments: Mapping[str, object]) -> dict[str, object]:
    """Add values that a function might overwrite but a simple call lacks.

    Clouds get intensities, labels get zeros, and lines and planes get an offset from the origin.

    Parameters
    ----------
    arguments : mapping of str to object
        Arguments by the parameter names of the course.
    """
    full, labels = dict(arguments), arguments.get("cluster_labels")
    strays = labels is not None and 0 not in labels
    if strays:
        full["cluster_labels"] = np.append(labels, [0, 0])
    for name in {"cloud", "points"} & set(full):
        cloud = full[name]
        if cloud.shape[1] >= 3 and not cloud[:, 3:].any():
            cloud = np.column_stack([cloud[:, :3], np.linspace(0.9, 0.1, len(cloud))])
        full[name] = np.vstack([cloud, cloud[:2] + 5.0]) if strays else cloud
    for name in {"line", "plane"} & set(full):
        if full[name][-1] == 0:
            full[name] = np.append(full[name][:-1], 0.7)
    return full


# ---- columns -----------------------------------------------------------------------------------


def promise_three_columns(case: Case, name: str, *, hint: str, weight: float = 1) -> None:
    """Check that the function accepts the cloud of the case without its intensity column."""

    @promise(
        "three_columns",
        case,
        name,
        title="Accepts three columns as well as four",
        why="Some recordings contain no intensity, and the car must see their points too.",
        hint=hint,
        weight=weight,
    )
    def run(function: Callable) -> None:
        case.precondition(function)
        case.with_first(case.first[:, :3]).assert_right(function)


def promise_fourth_column(
    case: Case,
    name: str,
    intensities: Sequence[float],
    *,
    title: str,
    why: str,
    hint: str,
    weight: float = 1,
) -> None:
    """Check that intensities do not affect the answer; the case has three columns."""

    @promise("fourth_column", case, name, title=title, why=why, hint=hint, weight=weight)
    def run(function: Callable) -> None:
        try:
            case.with_first(np.column_stack([case.first, intensities])).assert_right(function)
        except Exception:
            # If the answer is wrong even without intensities, they are not the cause.
            case.precondition(function)
            raise


# ---- one number per point: `expected` has an entry for each -------------------------------------


def promise_few_points(case: Case, name: str, *, title: str, why: str, weight: float = 1) -> None:
    """Check that the answer is one number for one point and empty for an empty cloud."""
    hint = "Compute with whole columns. You do not need a loop over the points or a special case."

    @promise("few_points", case, name, title=title, why=why, hint=hint, weight=weight)
    def run(function: Callable) -> None:
        case.precondition(function)
        for rows in (slice(1, 2), slice(0)):
            case.with_rows(rows).assert_right(function)
