"""Visible checks of `any_close`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    assert_arguments_unchanged,
    frozen,
    needs,
    observe,
    points_text,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_13.words import COMPILES_TITLE, COMPILES_WHY

# Rows 1 to 3 and 5 to 7 are the two cells. Their closest pair, rows 3 and 7, is 0.51 m apart; all
# other pairs are at least 0.9 m apart. Rows 0, 4 and 8 are in neither cell and closer to both.
_ROWS = frozen(
    np.array(
        [
            [0.8, 0.6, 0.7],
            [0.1, -0.4, 0.2],
            [-0.3, 0.1, 0.5],
            [0.5, 0.6, 0.3],
            [0.6, 0.5, 0.6],
            [1.4, 0.2, 1.1],
            [1.1, -0.5, 0.9],
            [0.77, 0.3, 0.62],
            [0.3, 0.3, 0.4],
        ]
    )
)
_CELLS = 1, 4, 5, 8
# Distances above and below that of the closest pair; their squares are the limits.
_ABOVE, _BELOW = 0.6, 0.45


def _squared_distances(points: np.ndarray, a: int, a_end: int, b: int, b_end: int) -> np.ndarray:
    """Return the squared distances of all pairs of points from two cells."""
    return ((points[a:a_end, None, :3] - points[None, b:b_end, :3]) ** 2).sum(axis=-1)


def _as_bool(answer: object) -> bool:
    """Convert an answer to True or False."""
    yours = as_array(answer, what="True or False")
    if yours.shape != ():
        raise WrongForm(
            "The answer is one True or False.",
            yours=f"shape {yours.shape}",
            expected="True or False",
        )
    return bool(yours)


def _assert_answer(any_close: Callable, points: np.ndarray, cells: tuple, distance: float) -> None:
    yours = _as_bool(any_close(points.copy(), *cells, distance**2))
    a, a_end, b, b_end = cells
    right = np.sqrt(_squared_distances(points, *cells).min()) < distance
    if yours != right:
        raise CheckFailed(
            "Two points of these rows are that close." if right else "No two are that close.",
            given=f"rows {a} to {a_end - 1}: {points_text(points[a:a_end])}; rows {b} to "
            f"{b_end - 1}: {points_text(points[b:b_end])}; limit {distance:g}² = {distance**2:.3g}",
            yours=str(yours),
            expected=str(bool(right)),
        )


@visible(
    "any_close",
    title="Compares the square of the distance with the limit",
    why="A pair that is wrongly close joins two cars; one that is missed cuts a car in two.",
    hint="x, y, z are differences, points[i, 0] - points[j, 0] and so on: is x * x + y * y + z * z "
    "below limit? No root, and limit as it is.",
)
def compares_two(any_close: Callable) -> None:
    for distance in (_ABOVE, _BELOW):
        _assert_answer(any_close, _ROWS[[3, 7]], (0, 1, 1, 2), distance)
    _assert_answer(any_close, 5 * _ROWS[[3, 7]], (0, 1, 1, 2), 5 * _ABOVE)
    _assert_answer(any_close, 5 * _ROWS[[3, 7]], (0, 1, 1, 2), 5 * _BELOW)


@visible(
    "any_close",
    title="Asks each of the one cell with each of the other",
    why="The nearest pair may be any: the first of both, or the last.",
    hint="A loop in a loop. Inside, return True where a pair is close, and nothing where it is "
    "not; return False after both loops.",
)
def asks_each_with_each(any_close: Callable) -> None:
    with needs("the square of a distance is compared with the limit"):
        compares_two(any_close)
    cell_points = np.delete(_ROWS, [0, 4, 8], axis=0)
    for rows in ([0, 1, 2, 3, 4, 5], [2, 0, 1, 3, 5, 4], [5, 4, 3, 2, 1, 0], [0, 2, 1, 5, 3, 4]):
        for distance in (_ABOVE, _BELOW):
            _assert_answer(any_close, cell_points[rows], (0, 3, 3, 6), distance)


@visible(
    "any_close",
    title="Looks at the rows of these cells alone",
    why="Compiled, nobody notices a row too many: it is a point of the next cell, or none at all.",
    hint="range(a, a_end) begins at a and ends before a_end.",
)
def keeps_to_its_rows(any_close: Callable) -> None:
    with needs("each of the one cell is asked with each of the other"):
        asks_each_with_each(any_close)
    for points in (_ROWS, _ROWS[::-1]):
        for distance in (_ABOVE, _BELOW):
            _assert_answer(any_close, points, _CELLS, distance)


@visible(
    "any_close",
    title="At exactly the limit two are not close",
    why="Lessons 05 and 10 join what is strictly closer: so the labels are the same.",
    hint="`<`, not `<=`.",
)
def is_strict(any_close: Callable) -> None:
    with needs("the square of a distance is compared with the limit"):
        compares_two(any_close)
    points = np.array([[1.0, 2.0, 0.5], [1.0, 2.5, 0.5]])
    if _as_bool(any_close(points, 0, 1, 1, 2, 0.25)):
        raise CheckFailed(
            "The two are as far apart as the limit says, and not closer.",
            given=fixed("two points 0.5 m apart, limit 0.5² = 0.25"),
            yours="True",
            expected="False",
        )


@visible(
    "any_close",
    title="Stops at the first pair that is close",
    why="It is what makes the loop fast: two crowded cells have a million pairs.",
    hint="return True inside both loops: it ends them, and the function.",
)
def stops_at_the_first(any_close: Callable) -> None:
    with needs("each of the one cell is asked with each of the other"):
        asks_each_with_each(any_close)
    n = 20
    index = np.arange(2 * n) % n
    points = np.column_stack([index * 0.7, index % 3 * 1.1, index * 0.0])
    reads = 0

    class Counted(np.ndarray):
        def __getitem__(self, key: object) -> object:
            nonlocal reads
            reads += 1
            return np.asarray(self)[key]

    if not _as_bool(any_close(points.view(Counted), 0, n, n, 2 * n, 0.1)) or reads > n:
        raise CheckFailed(
            "It goes on although the answer is known.",
            given=f"two cells of {n} points, of which the first two lie at the same place",
            yours=f"{reads} times something was read from points",
            expected="6 times",
        )


@visible(
    "any_close",
    title="Leaves the points as they are",
    why="The same rows are asked again, with other cells.",
    hint="Put the differences into variables of their own.",
)
def leaves_the_rows(any_close: Callable) -> None:
    arguments = _ROWS, *_CELLS, _BELOW**2
    assert_arguments_unchanged(observe(any_close, *arguments), *arguments)


@noted("any_close", title=COMPILES_TITLE, why=COMPILES_WHY)
def any_close_compiles(any_close: Callable) -> None:
    def answers(function: Callable) -> list[bool]:
        return [bool(function(_ROWS.copy(), *_CELLS, distance**2)) for distance in (_ABOVE, _BELOW)]

    assert_compiles(any_close, answers)


def _is_close(points: np.ndarray, a: int, a_end: int, b: int, b_end: int, limit: float) -> bool:
    return bool((_squared_distances(points, a, a_end, b, b_end) < limit).any())


def _decided_by(ask: Callable) -> Callable:
    """Return a prediction that `ask` makes from the squared distances and the limit."""

    def predicts(right: bool, points: np.ndarray, *rest: float) -> bool:
        *cells, limit = rest
        return bool(ask(_squared_distances(points, *cells), limit))

    return predicts


def _with_shifted_rows(first: int, last: int) -> Callable:
    """Return the prediction for cells that begin and end so many rows later."""
    return lambda right, points, a, a_end, b, b_end, limit: _is_close(
        points, a + first, a_end + last, b + first, b_end + last, limit
    )


def _without_axis(axis: int) -> Callable:
    return lambda right, points, *rest: _is_close(np.delete(points, axis, axis=1), *rest)


def _random_case(seed: int) -> tuple:
    """Return the arguments of a call with random points, so that the answer cannot be guessed."""
    rng = np.random.default_rng(seed)
    a, a_end, b, b_end = 1, 3 + seed % 2, 6, 8 + seed % 3
    limit = round(float(np.exp(rng.uniform(-2.5, 1.5))), 3)
    return frozen(rng.uniform(-0.8, 0.8, (12, 3))), a, a_end, b, b_end, limit


mistakes(
    "any_close",
    Mistake(
        "The distance itself is compared with the limit, which is a square, or the limit is "
        "squared once more.",
        _decided_by(lambda squares, limit: (np.sqrt(squares) < limit).any()),
        "No root, and limit as it is: x * x + y * y + z * z < limit.",
    ),
    Mistake(
        "The first pair decides: `return False` stands inside the loops.",
        _decided_by(lambda squares, limit: squares[0, 0] < limit),
        "return False as far to the left as the outer `for`: after both loops.",
    ),
    Mistake(
        "Only the first point of the one cell is asked: `return False` stands in the outer loop.",
        _decided_by(lambda squares, limit: (squares[0] < limit).any()),
        "return False as far to the left as the outer `for`.",
    ),
    Mistake(
        "All pairs have to be close: any one is enough.",
        _decided_by(lambda squares, limit: (squares < limit).all()),
    ),
    Mistake(
        "The answers are exchanged: True where no two are close.",
        lambda right, *case: not right,
    ),
    Mistake(
        "The row after each cell is looked at, too: a_end and b_end are without.",
        _with_shifted_rows(0, 1),
        "range(a, a_end) ends before a_end by itself.",
    ),
    Mistake(
        "The last row of each cell is never looked at.",
        _with_shifted_rows(0, -1),
        "range(a, a_end) ends before a_end by itself.",
    ),
    Mistake(
        "The first row of each cell is never looked at.",
        _with_shifted_rows(1, 0),
        "range(a, a_end) begins at a.",
    ),
    Mistake("x is left out.", _without_axis(0), "There are three differences."),
    Mistake("y is left out.", _without_axis(1), "There are three differences."),
    Mistake("z is left out.", _without_axis(2), "There are three differences."),
    Mistake("It says False, always.", lambda right, *case: False, is_cheap=True),
    Mistake("It says True, always.", lambda right, *case: True, is_cheap=True),
    cases=tuple(_random_case(seed) for seed in range(40)),
    right=_is_close,
    same=lambda answer, predicted: bool(as_array(answer)) == predicted,
)
