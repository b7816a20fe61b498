"""Common checks for functions that select rows of a cloud; see `common_checks`.

The cloud of the case has four columns. `expected` is the mask of the rows to keep, with at least
one True and one False.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    assert_all_columns,
    assert_empty_table,
    assert_order,
)
from utils.checks.common_checks import Case, promise
from utils.checks.core import note_check


def promise_all_columns(
    case: Case,
    name: str,
    *,
    hint: str = "Index the whole cloud with the mask: cloud[mask] keeps all columns.",
    weight: float = 1,
) -> None:
    """Check that the kept rows have all their columns."""

    @promise(
        "all_columns",
        case,
        name,
        title="Keeps all columns, including the intensity",
        why="The intensity distinguishes a number plate from a bush, and later steps cannot "
        "restore it.",
        hint=hint,
        weight=weight,
    )
    def check(function: Callable) -> None:
        assert_all_columns(case.answer_of(function), case.first, case.expected)


def promise_order(case: Case, name: str, *, weight: float = 1) -> None:
    """Check that the kept rows keep their order."""

    @promise(
        "order",
        case,
        name,
        title="Keeps the order of the rows",
        why="Other arrays, such as the true object of each return, are in the same order as the "
        "rows.",
        hint="Index with a mask, which never changes the order.",
        weight=weight,
    )
    def check(function: Callable) -> None:
        assert_order(case.answer_of(function), case.first, case.expected)


def promise_empty_table(
    case: Case,
    name: str,
    *,
    hint: str = "Use the same mask for every cloud: a mask without any True selects no rows.",
    weight: float = 1,
) -> None:
    """Check clouds without points, with one point, and with only points that are removed."""
    cloud, removed = case.first, np.flatnonzero(~case.expected)[:3]
    one_kept = case.with_rows(np.flatnonzero(case.expected)[:1])

    @promise(
        "nothing_left",
        case,
        name,
        title="Works on an empty cloud, on one point, and when no point is left",
        why="Other filters may leave one return or none, and that must not crash the program.",
        hint=hint,
        weight=weight,
    )
    def check(function: Callable) -> None:
        case.precondition(function)
        columns = as_array(case.answer_of(function)).shape[1]
        for few in (cloud[:0], cloud[removed[:1]], cloud[removed]):
            assert_empty_table(case.with_first(few).answer_of(function), few, columns)
        one_kept.assert_right(function)


def promise_untouched(
    case: Case,
    name: str,
    *,
    why: str = "The next step may need the full cloud again.",
    weight: float = 1,
) -> None:
    """Check that the function does not change the cloud."""
    hint = "Return cloud[mask], which is already a new array. Do not write into cloud."
    common_checks.promise_untouched(case, name, why=why, hint=hint, weight=weight)


def note_array(case: Case, name: str) -> None:
    """Add a note, which costs no points, if the rows are in a list or lose their columns."""

    def check(function: Callable) -> None:
        answer = case.answer_of(function)
        if isinstance(answer, (list, tuple)):
            raise CheckFailed(f"The rows are in a {type(answer).__name__}.")
        without_rows = as_array(case.with_first(case.first[:0]).answer_of(function))
        if without_rows.ndim == 1:
            raise CheckFailed(
                "When no row is left, the array also loses its columns, which later cells need.",
                yours=f"shape {without_rows.shape}",
                expected=f"shape (0, {case.first.shape[1]})",
            )

    check.__name__, check.__module__ = name, case.lesson
    note_check(
        case.exercise,
        title="Returns an array that keeps its columns",
        why="Later cells index its columns, as in rows[:, 2]. A list has no columns, and neither "
        "does an array made from an empty list.",
    )(check)
