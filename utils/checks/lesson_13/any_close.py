"""Visible checks of `any_close`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    assert_arguments_unchanged,
    frozen,
    observe,
    points_text,
    precondition,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.lesson_13.compile_note import COMPILES_TITLE, COMPILES_WHY

# Rows 1 to 3 and rows 5 to 7 are the two runs. Their closest points, rows 3 and 7, are 0.51 m
# apart; all other pairs are at least 0.9 m apart. Rows 0, 4 and 8 are in neither run, but they are
# closer than 0.45 m to row 3 or row 7, so reading them changes an answer.
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
# One distance above and one below the distance of the closest pair. Their squares are the limits.
_ABOVE, _BELOW = 0.6, 0.45


def _squared_distances(points: np.ndarray, a: int, a_end: int, b: int, b_end: int) -> np.ndarray:
    """Return the squared distances of all pairs of points from two runs."""
    return ((points[a:a_end, None, :3] - points[None, b:b_end, :3]) ** 2).sum(axis=-1)


def _as_bool(answer: object) -> bool:
    """Convert an answer to True or False."""
    yours = as_array(answer, description="True or False")
    if yours.shape != ():
        raise WrongForm(
            "The answer must be a single True or False.",
            yours=f"shape {yours.shape}",
            expected="True or False",
        )
    return bool(yours)


def _rows_text(points: np.ndarray, first: int, end: int) -> str:
    rows = f"row {first}" if end - first == 1 else f"rows {first} to {end - 1}"
    return f"{rows}: {points_text(points[first:end])}"


def _assert_answer(any_close: Callable, points: np.ndarray, runs: tuple, distance: float) -> None:
    yours = _as_bool(any_close(points.copy(), *runs, distance**2))
    a, a_end, b, b_end = runs
    right = np.sqrt(_squared_distances(points, *runs).min()) < distance
    if yours != right:
        raise CheckFailed(
            f"Two of these points are closer than {distance:g} m."
            if right
            else f"No two of these points are closer than {distance:g} m.",
            input_text=f"{_rows_text(points, a, a_end)}; {_rows_text(points, b, b_end)}; "
            f"limit {distance:g}² = {distance**2:.3g}",
            yours=str(yours),
            expected=str(bool(right)),
        )


@visible_check(
    "any_close",
    title="Compares the squared distance with the limit",
    why="If a pair counts as close by mistake, two cars merge. If a close pair is missed, one car "
    "splits.",
    hint="Compute the differences x, y and z, such as x = points[i, 0] - points[j, 0]. Compare x "
    "* x + y * y + z * z with limit, without a square root.",
)
def compares_squares(any_close: Callable) -> None:
    for distance in (_ABOVE, _BELOW):
        _assert_answer(any_close, _ROWS[[3, 7]], (0, 1, 1, 2), distance)
    _assert_answer(any_close, 5 * _ROWS[[3, 7]], (0, 1, 1, 2), 5 * _ABOVE)
    _assert_answer(any_close, 5 * _ROWS[[3, 7]], (0, 1, 1, 2), 5 * _BELOW)


@visible_check(
    "any_close",
    title="Compares each point of one run with each point of the other",
    why="Any pair may be the closest: the first points of both runs, or the last.",
    hint="Write a loop inside a loop. Return True inside both loops if a pair is close, and "
    "return False after both loops.",
)
def compares_all_pairs(any_close: Callable) -> None:
    with precondition("the squared distance is compared with the limit"):
        compares_squares(any_close)
    run_points = np.delete(_ROWS, [0, 4, 8], axis=0)
    for rows in ([0, 1, 2, 3, 4, 5], [2, 0, 1, 3, 5, 4], [5, 4, 3, 2, 1, 0], [0, 2, 1, 5, 3, 4]):
        for distance in (_ABOVE, _BELOW):
            _assert_answer(any_close, run_points[rows], (0, 3, 3, 6), distance)


@visible_check(
    "any_close",
    title="Reads only the rows of the two runs",
    why="A compiled function reads beyond its rows without an error. It then uses a point of the "
    "next run, or whatever is in memory.",
    hint="Loop over range(a, a_end), which begins at a and ends before a_end.",
)
def reads_only_its_rows(any_close: Callable) -> None:
    with precondition("each point of one run is compared with each point of the other"):
        compares_all_pairs(any_close)
    for points in (_ROWS, _ROWS[::-1]):
        for distance in (_ABOVE, _BELOW):
            _assert_answer(any_close, points, _CELLS, distance)


@visible_check(
    "any_close",
    title="Does not count a pair exactly at the limit as close",
    why="Lessons 05 and 10 join points that are strictly closer than the threshold. The labels "
    "must be the same.",
    hint="Write `<`, not `<=`.",
)
def is_strict(any_close: Callable) -> None:
    with precondition("the squared distance is compared with the limit"):
        compares_squares(any_close)
    # One pair along each axis: no change of a single difference keeps all three apart.
    for points in (np.vstack([np.zeros(3), pair]) for pair in np.eye(3) / 2):
        if _as_bool(any_close(points, 0, 1, 1, 2, 0.25)):
            raise CheckFailed(
                "The squared distance of the two points equals the limit, so they are not close.",
                input_text=fixed("two points 0.5 m apart, limit 0.5² = 0.25"),
                yours="True",
                expected="False",
            )


@visible_check(
    "any_close",
    title="Stops at the first close pair",
    why="Two long runs may have thousands of pairs, and a loop that stops early rarely needs "
    "them all.",
    hint="Write return True inside both loops. It ends both loops and the function.",
)
def stops_at_the_first_close_pair(any_close: Callable) -> None:
    with precondition("each point of one run is compared with each point of the other"):
        compares_all_pairs(any_close)
    n = 20
    index = np.arange(2 * n) % n
    points = np.column_stack([index * 0.7, index % 3 * 1.1, index * 0.0])
    reads = 0

    class CountingArray(np.ndarray):
        def __getitem__(self, key: object) -> object:
            nonlocal reads
            reads += 1
            return np.asarray(self)[key]

    if not _as_bool(any_close(points.view(CountingArray), 0, n, n, 2 * n, 0.1)) or reads > n:
        raise CheckFailed(
            "The function continues although the answer is already known.",
            input_text=f"two runs of {n} points, whose first points are at the same position",
            yours=f"{reads} values read from points",
            expected="6 values",
        )


@visible_check(
    "any_close",
    title="Does not change the points",
    why="Other calls compare the same rows with other runs.",
    hint="Store the differences in new variables.",
)
def keeps_the_points_unchanged(any_close: Callable) -> None:
    arguments = _ROWS, *_CELLS, _BELOW**2
    assert_arguments_unchanged(observe(any_close, *arguments), *arguments)


@note_check("any_close", title=COMPILES_TITLE, why=COMPILES_WHY)
def any_close_compiles(any_close: Callable) -> None:
    def call_twice(function: Callable) -> list[bool]:
        return [bool(function(_ROWS.copy(), *_CELLS, distance**2)) for distance in (_ABOVE, _BELOW)]

    assert_compiles(any_close, call_twice)


def _is_close(points: np.ndarray, a: int, a_end: int, b: int, b_end: int, limit: float) -> bool:
    return bool((_squared_distances(points, a, a_end, b, b_end) < limit).any())


def _prediction_from_squares(decide: Callable) -> Callable:
    """Return a prediction that `decide` makes from the squared distances and the limit."""

    def predict(right: bool, points: np.ndarray, *runs_and_limit: float) -> bool:
        *runs, limit = runs_and_limit
        return bool(decide(_squared_distances(points, *runs), limit))

    return predict


def _prediction_with_shifted_rows(first: int, last: int) -> Callable:
    """Return the prediction for runs that begin `first` rows and end `last` rows later."""
    return lambda right, points, a, a_end, b, b_end, limit: _is_close(
        points, a + first, a_end + last, b + first, b_end + last, limit
    )


def _prediction_without_axis(axis: int) -> Callable:
    return lambda right, points, *rest: _is_close(np.delete(points, axis, axis=1), *rest)


def _random_case(seed: int) -> tuple:
    """Return the arguments of a call with random points, so that the answer cannot be guessed."""
    rng = np.random.default_rng(seed)
    a, a_end, b, b_end = 1, 3 + seed % 2, 6, 8 + seed % 3
    limit = round(float(np.exp(rng.uniform(-2.5, 1.5))), 3)
    return frozen(rng.uniform(-0.8, 0.8, (12, 3))), a, a_end, b, b_end, limit


declare_mistakes(
    "any_close",
    Mistake(
        "The code compares the distance with the limit, which is already squared, or it squares "
        "the limit again.",
        _prediction_from_squares(lambda squares, limit: (np.sqrt(squares) < limit).any()),
        "Write x * x + y * y + z * z < limit, without a square root.",
    ),
    Mistake(
        "The function compares only the first pair, because `return False` is inside both loops.",
        _prediction_from_squares(lambda squares, limit: squares[0, 0] < limit),
        "Indent return False like the outer `for`, after both loops.",
    ),
    Mistake(
        "The function compares only the first point of the first run, because `return False` is "
        "inside the outer loop.",
        _prediction_from_squares(lambda squares, limit: (squares[0] < limit).any()),
        "Indent return False like the outer `for`, after both loops.",
    ),
    Mistake(
        "The answer is True only if all pairs are close. One close pair is enough.",
        _prediction_from_squares(lambda squares, limit: (squares < limit).all()),
    ),
    Mistake(
        "The function returns True if no two points are close, and False otherwise.",
        lambda right, *case: not right,
    ),
    Mistake(
        "The code also reads the row after each run. The rows a_end and b_end do not belong to "
        "the runs.",
        _prediction_with_shifted_rows(0, 1),
        "Use range(a, a_end), which already ends before a_end.",
    ),
    Mistake(
        "The code never reads the last row of each run.",
        _prediction_with_shifted_rows(0, -1),
        "Use range(a, a_end), which already ends before a_end.",
    ),
    Mistake(
        "The code never reads the first row of each run.",
        _prediction_with_shifted_rows(1, 0),
        "Use range(a, a_end), which begins at a.",
    ),
    Mistake(
        "The code leaves out the difference in x, so points one behind the other seem close.",
        _prediction_without_axis(0),
        "Use all three differences.",
    ),
    Mistake(
        "The code leaves out the difference in y, so points side by side seem close.",
        _prediction_without_axis(1),
        "Use all three differences.",
    ),
    Mistake(
        "The code leaves out the difference in z, so points one above the other seem close.",
        _prediction_without_axis(2),
        "Use all three differences.",
    ),
    Mistake(
        "The answer is always False, even if two points are close.",
        lambda right, *case: False,
        is_cheap=True,
    ),
    Mistake(
        "The answer is always True, even if no two points are close.",
        lambda right, *case: True,
        is_cheap=True,
    ),
    cases=tuple(_random_case(seed) for seed in range(40)),
    right=_is_close,
    is_same=lambda answer, predicted: bool(as_array(answer)) == predicted,
)
