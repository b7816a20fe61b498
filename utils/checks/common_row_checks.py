"""Common checks for functions that select rows of a cloud; see `common_checks`.

The cloud of the case has four columns. The case expects the mask of the rows to keep, which keeps
some rows and removes others.
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
    """Check that the kept rows have all their columns."""

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
        assert_all_columns(case.answer_of(function), case.first, case.expected)


def order(case: Case, name: str, *, weight: float = 1) -> None:
    """Check that the kept rows keep their order."""

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
        assert_order(case.answer_of(function), case.first, case.expected)


def nothing_left(
    case: Case,
    name: str,
    *,
    hint: str = "The same lines serve every case: an empty mask takes no row.",
    weight: float = 1,
) -> None:
    """Check clouds without points, with one point, and with only points that are removed."""
    cloud, removed = case.first, np.flatnonzero(~case.expected)[:3]
    one_kept = case.with_rows(np.flatnonzero(case.expected)[:1])

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
        case.precondition(function)
        columns = as_array(case.answer_of(function)).shape[1]
        for few in (cloud[:0], cloud[removed[:1]], cloud[removed]):
            assert_nothing_left(case.with_first(few).answer_of(function), few, columns)
        one_kept.assert_right(function)


def untouched(
    case: Case,
    name: str,
    *,
    why: str = "The next step of the pipeline may need the full cloud again.",
    weight: float = 1,
) -> None:
    """Check that the function does not change the cloud."""
    hint = "cloud[mask] is already a new array. Do not assign into cloud."
    common_checks.untouched(case, name, why=why, hint=hint, weight=weight)


def array(case: Case, name: str) -> None:
    """Note if the answer is a list, or an array that lost its columns; this costs no points."""

    def ask(function: Callable) -> None:
        answer = case.answer_of(function)
        if isinstance(answer, (list, tuple)):
            raise CheckFailed(f"The rows are in a {type(answer).__name__}.")
        nothing = as_array(case.with_first(case.first[:0]).answer_of(function))
        if nothing.ndim == 1:
            raise CheckFailed(
                "Without rows the array has lost its columns: later cells cannot take one of them.",
                yours=f"shape {nothing.shape}",
                expected=f"shape (0, {case.first.shape[1]})",
            )

    ask.__name__, ask.__module__ = name, case.lesson
    noted(
        case.exercise,
        title="The rows are an array that keeps its columns",
        why="Later cells take columns of it, such as rows[:, 2]. A list has no columns, nor has an "
        "array that is made of an empty list.",
    )(ask)
