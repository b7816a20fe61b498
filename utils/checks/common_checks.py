"""Promises that return in exercise after exercise: declared in a few lines, and asked in one way.

A lesson describes a plain call of its exercise once, and says under which name, with what weight
and in which words it makes each promise. The promise is then a visible check like any other, in
the place where it is declared::

    _CROP = Case(__name__, "crop_region", {"cloud": _ROOM, "minimum": ..., "maximum": ...},
                 expected=_INSIDE, look=assert_boxed, basic=assert_crops)

    promises.names(_CROP, "names_the_corners", why="Others may call crop_region(cloud, ...).")
    row_promises.order(_CROP, "crops_in_order")

What is not a parameter is the same wherever the promise is made. What only some kinds of exercises
promise stands in `row_promises`, `box_promises` and `cluster_promises`.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from utils.checks.assertions import assert_untouched
from utils.checks.core import visible
from utils.checks.failures import CheckFailed
from utils.checks.limits import TimeUp
from utils.remote_objects import Remote, RemoteError

_FIRST_LINE = "Keep the first line of the function as it was given"


def _nothing(function: Callable) -> None:
    """Ask for nothing first."""


@dataclass(frozen=True)
class Case:
    """A plain call of an exercise whose right answer is known.

    Attributes
    ----------
    lesson : str
        The module that declares the promises, its `__name__`.
    exercise : str
        Name of the student's function.
    given : mapping of str to object
        The arguments by name, in the order of the first line. What varies from promise to promise
        is the first of them: a cloud, points, labels.
    expected : object
        What `look` compares with: for a function that chooses rows the mask of those that stay.
    look : callable
        Takes an answer, the arguments and `expected`; raises `CheckFailed` where it is wrong.
    basic : callable, optional
        Takes the function; raises `NotYet` where a promise cannot be looked at.
    """

    lesson: str
    exercise: str
    given: Mapping[str, object]
    expected: object
    look: Callable
    basic: Callable = _nothing

    @property
    def first(self) -> np.ndarray:
        """The argument that varies."""
        return next(iter(self.given.values()))

    @property
    def copies(self) -> dict[str, object]:
        """The arguments, for a function that may do with them what it likes."""
        return copy.deepcopy(dict(self.given))

    @property
    def by_itself(self) -> Case:
        """The same call, looked at whatever else is wrong."""
        return replace(self, basic=_nothing)

    def of(self, first: np.ndarray, **more: object) -> Case:
        """The same call of something else; `more` are other fields, such as ``expected``."""
        name = next(iter(self.given))
        return replace(self, given={**self.given, name: first}, **more)

    def rows(self, which: slice | np.ndarray) -> Case:
        """The same call of some of the points, where `expected` has an entry for each."""
        return self.of(self.first[which], expected=self.expected[which])

    def ask(self, function: Callable) -> object:
        """What a function answers."""
        return function(*self.copies.values())

    def assert_right(self, function: Callable) -> None:
        """A function answers what is expected."""
        self.assert_right_answer(self.ask(function))

    def assert_right_answer(self, answer: object) -> None:
        """An answer is what is expected."""
        self.look(answer, *self.given.values(), self.expected)


@dataclass(frozen=True)
class Promise:
    """A promise that an exercise makes.

    Attributes
    ----------
    kind : str
        Which one, by the name of the function that declares it.
    case : Case
    name : str
        Of the check.
    """

    kind: str
    case: Case
    name: str


_MADE: list[Promise] = []


def made() -> tuple[Promise, ...]:
    """All promises of the lessons that are imported, in the order in which they are declared."""
    return tuple(_MADE)


def promise(kind: str, case: Case, name: str, **words: object) -> Callable:
    """Declare a function as the check that holds an exercise to a promise.

    Parameters
    ----------
    kind : str
        Which promise.
    case : Case
    name : str
        Of the check, unique within the exercise.
    **words : object
        Title, why, hint and weight, as `visible` takes them.

    Returns
    -------
    callable
        The decorator. The function takes the student's, and raises `CheckFailed` where it breaks
        the promise.
    """

    def declare(ask: Callable) -> Callable:
        ask.__name__, ask.__module__ = name, case.lesson
        _MADE.append(Promise(kind, case, name))
        return visible(case.exercise, **words)(ask)

    return declare


# ---- what every exercise promises --------------------------------------------------------------


def names(
    case: Case,
    name: str,
    *,
    why: str,
    title: str = "The parameters keep their names",
    weight: float = 1,
) -> None:
    """The arguments may be passed by name."""
    hint = f"{_FIRST_LINE}."

    @promise("names", case, name, title=title, why=why, hint=hint, weight=weight)
    def ask(function: Callable) -> None:
        case.basic(function)
        case.assert_right_answer(function(**case.copies))


def default(case: Case, argument: str, *, title: str, why: str, weight: float = 1) -> Callable:
    """An argument may be left out. Decorates the function that leaves it out and looks.

    Parameters
    ----------
    case : Case
    argument : str
        As in the first line of the exercise: ``"distance=10.0"``.
    title, why : str
    weight : float

    Returns
    -------
    callable
        The decorator; the function stays as it is.
    """
    hint = f"{_FIRST_LINE}: {argument}."

    def declare(look: Callable) -> Callable:
        @promise("default", case, look.__name__, title=title, why=why, hint=hint, weight=weight)
        def ask(function: Callable) -> None:
            case.basic(function)
            look(function)

        return look

    return declare


def untouched(
    case: Case,
    name: str,
    *,
    why: str,
    hint: str,
    title: str = "Leaves its input untouched",
    weight: float = 1,
) -> None:
    """The arguments are afterwards what they were before, and so are those of `in_full`."""
    full = in_full(case.given)
    is_more = any(full[argument] is not value for argument, value in case.given.items())

    @promise("untouched", case, name, title=title, why=why, hint=hint, weight=weight)
    def ask(function: Callable) -> None:
        case.basic(function)
        assert_untouched(function, *case.given.values())
        if not is_more:
            return
        own = RemoteError if isinstance(function, Remote) else Exception
        try:
            assert_untouched(function, *full.values())
        except (CheckFailed, TimeUp):
            raise
        except own:
            return  # whether it takes four columns, or a label 0, others ask


def in_full(given: Mapping[str, object]) -> dict[str, object]:
    """The arguments of a call with all that there may be to write into.

    A cloud has intensities, labels hold a 0, and no line or plane runs through the origin.

    Parameters
    ----------
    given : mapping of str to object
        By the names that the course gives them.
    """
    full, labels = dict(given), given.get("cluster_labels")
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


def three_columns(case: Case, name: str, *, hint: str, weight: float = 1) -> None:
    """A cloud may have no intensity. The case is of one that has."""

    @promise(
        "three_columns",
        case,
        name,
        title="Takes three columns as well as four",
        why="Some files hold no intensity.",
        hint=hint,
        weight=weight,
    )
    def ask(function: Callable) -> None:
        case.basic(function)
        case.of(case.first[:, :3]).assert_right(function)


def fourth_column(
    case: Case,
    name: str,
    intensities: Sequence[float],
    *,
    title: str,
    why: str,
    hint: str,
    weight: float = 1,
) -> None:
    """The answer is the same whatever the intensities are. The case is of three columns."""

    @promise("fourth_column", case, name, title=title, why=why, hint=hint, weight=weight)
    def ask(function: Callable) -> None:
        case.of(np.column_stack([case.first, intensities])).assert_right(function)


# ---- what answers for each point: `expected` has an entry for each ------------------------------


def few_points(case: Case, name: str, *, title: str, why: str, weight: float = 1) -> None:
    """One point has one answer, and none has none."""
    hint = "Whole columns do it all: no loop over the points and no special case is needed."

    @promise("few_points", case, name, title=title, why=why, hint=hint, weight=weight)
    def ask(function: Callable) -> None:
        case.basic(function)
        for rows in (slice(1, 2), slice(0)):
            case.rows(rows).assert_right(function)
