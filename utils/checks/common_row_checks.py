"""Promises of what chooses rows of a cloud; see `promises`.

The case is of a cloud of four columns, and expects the mask of the rows that stay: some do, and
some do not.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    assert_all_columns,
    assert_nothing_left,
    assert_order,
)
from utils.checks.common_checks import Case, promise
from utils.checks.core import noted


def all_columns(
    case: Case,
    name: str,
    *,
    hint: str = "Index the cloud itself with the mask, cloud[mask], and leave the columns alone.",
    weight: float = 1,
) -> None:
    """Rows that stay are whole."""

    @promise(
        "all_columns",
        case,
        name,
        title="Keeps all columns: the intensity stays with its point",
        why="Intensity tells a number plate from a bush, and later steps cannot get it back.",
        hint=hint,
        weight=weight,
    )
    def ask(function: Callable) -> None:
        assert_all_columns(case.ask(function), case.first, case.expected)


def order(case: Case, name: str, *, weight: float = 1) -> None:
    """Rows that stay have the order that they had."""

    @promise(
        "order",
        case,
        name,
        title="Keeps the order of the rows",
        why="Whoever knows the true object of each return finds it by its place among the rows.",
        hint="A mask keeps the order by itself.",
        weight=weight,
    )
    def ask(function: Callable) -> None:
        assert_order(case.ask(function), case.first, case.expected)


def nothing_left(
    case: Case,
    name: str,
    *,
    hint: str = "The same lines serve every case: an empty mask takes no row.",
    weight: float = 1,
) -> None:
    """No point, one point, and points none of which stays, are clouds like any others."""
    cloud, gone = case.first, np.flatnonzero(~case.expected)[:3]
    left = case.rows(np.flatnonzero(case.expected)[:1])

    @promise(
        "nothing_left",
        case,
        name,
        title="Takes no points, one point, and a cloud of which nothing is left",
        why="After other filters nothing may be left, or a single return.",
        hint=hint,
        weight=weight,
    )
    def ask(function: Callable) -> None:
        case.basic(function)
        columns = as_array(case.ask(function)).shape[1]
        for few in (cloud[:0], cloud[gone[:1]], cloud[gone]):
            assert_nothing_left(case.of(few).ask(function), few, columns)
        left.assert_right(function)


def untouched(
    case: Case,
    name: str,
    *,
    why: str = "The next step of the pipeline may need the full cloud again.",
    weight: float = 1,
) -> None:
    """The cloud is afterwards what it was before."""
    hint = "cloud[mask] is already a new array. Do not assign into cloud."
    common_checks.untouched(case, name, why=why, hint=hint, weight=weight)


def array(case: Case, name: str) -> None:
    """The answer is an array. A list costs no points, and gets a note."""

    def ask(function: Callable) -> None:
        answer = case.ask(function)
        if isinstance(answer, (list, tuple)):
            raise CheckFailed(f"The rows are in a {type(answer).__name__}.")

    ask.__name__, ask.__module__ = name, case.lesson
    noted(
        case.exercise,
        title="The rows are an array, not a list",
        why="Later cells take columns of it, such as rows[:, 2], which a list has not; and where "
        "no row is left, a list has no columns either.",
    )(ask)
