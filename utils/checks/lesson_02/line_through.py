"""Visible checks of `line_through`."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    brief_text,
    frozen,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.failures import fixed
from utils.checks.lesson_02.lines import as_line, normal_length
from utils.checks.run_cache import once_per_run

# Pairs of points on slanted lines. No pair is exactly 1 m apart, so that a normal that is not
# divided by its length is wrong.
_PAIRS = (
    ((1.0, 2.0), (4.0, 6.0)),
    ((-3.0, 5.0), (2.0, -7.0)),
    ((8.0, 8.0), (2.0, 2.0)),
    ((0.1, 0.1), (0.4, 0.5)),
)


def assert_on_line(answer: object, p: ArrayLike, q: ArrayLike) -> None:
    """Assert that two different points lie on the line, whose normal may have any length.

    Parameters
    ----------
    answer : object
        The line that the student's function returned for `p` and `q`.
    p, q : array_like, shape (2,)
    """
    p, q = np.asarray(p, dtype=float), np.asarray(q, dtype=float)
    line = as_line(answer)
    length = normal_length(line)
    values = [line[:2] @ point + line[2] for point in (p, q)]
    for point, value in zip((p, q), values, strict=True):
        if abs(value) > TOLERANCE * length:
            raise CheckFailed(
                f"The line through {point_text(p)} and {point_text(q)} misses "
                f"{point_text(point)} by {abs(value) / length:.2f} m.",
                draw=lambda: utils.plots.line_model(
                    np.array([p, q]), line, title="your line and the two points"
                ),
                yours=f"a x + b y + c is {values[0]:.2f} and {values[1]:.2f} at the two points",
                expected="0 and 0",
            )


def assert_unit_normal(answer: object) -> None:
    """Assert that the normal of a line has length 1; the position of the line is ignored."""
    line = as_line(answer)
    length = normal_length(line)
    if abs(length - 1) > TOLERANCE:
        raise CheckFailed(
            fixed("The normal (a, b) must have length 1."),
            yours=f"length {length:.3f} in {brief_text(line)}",
            expected="length 1",
        )


@once_per_run
def require_slanted_lines(line_through: Callable) -> None:
    """Raise `NotYet` if slanted lines are wrong."""
    with precondition("a slanted line passes through its two points"):
        for p, q in _PAIRS:
            assert_on_line(line_through(np.array(p), np.array(q)), p, q)


def assert_no_line(line_through: Callable, point: ArrayLike) -> None:
    """Assert that the answer for two equal points is None."""
    answer = line_through(np.array(point, dtype=float), np.array(point, dtype=float))
    if answer is not None:
        is_repeated = isinstance(answer, tuple) and all(part is None for part in answer)
        raise CheckFailed(
            "Infinitely many lines pass through two equal points, so the answer must be None.",
            input_text=f"the point {point_text(point)} twice",
            yours=brief_text(answer),
            expected="None",
            hint="Write `return None`, with a single None." if is_repeated else "",
        )


@visible_check(
    "line_through",
    weight=4,
    title="Returns a line through both points",
    why="If the line misses its two points, it does not follow the wall that they are on.",
    hint="Turn the direction (dx, dy) by 90° to get the normal (-dy, dx). Then c is -(a x + b "
    "y) for the x and y of p.",
)
def passes_through_both(line_through: Callable) -> None:
    for p, q in _PAIRS:
        assert_on_line(line_through(np.array(p), np.array(q)), p, q)


@visible_check(
    "line_through",
    weight=3,
    title="Returns a normal of length 1",
    why="If the normal had length 5, all distances from the line would be five times too large.",
    hint="Divide the normal by its length, np.hypot(dx, dy), before you compute c.",
)
def has_a_unit_normal(line_through: Callable) -> None:
    require_slanted_lines(line_through)
    for p, q in _PAIRS:
        assert_unit_normal(line_through(np.array(p), np.array(q)))


@visible_check(
    "line_through",
    weight=2,
    title="Works for lines parallel to an axis",
    why="All points of a wall straight ahead have the same x, and the car is about to hit that "
    "wall.",
    hint="Do not use the slope dy / dx, which is undefined if dx is 0. Return None only if both x "
    "and y are equal.",
)
def finds_axis_parallel_lines(line_through: Callable) -> None:
    require_slanted_lines(line_through)
    for p, q in (
        ((2.0, -3.0), (2.0, 4.0)),
        ((2.0, 4.0), (2.0, -3.0)),
        ((-5.0, 1.5), (3.0, 1.5)),
        ((0.0, 2.0), (0.0, 5.0)),
    ):
        answer = line_through(np.array(p), np.array(q))
        if answer is None:
            raise CheckFailed(
                "The answer is None although the points differ.",
                input_text=f"{point_text(p)} and {point_text(q)}",
                yours="None",
                expected="three numbers (a, b, c)",
            )
        assert_on_line(answer, p, q)


@visible_check(
    "line_through",
    weight=2,
    title="Returns None for equal points",
    why="RANSAC sometimes draws two equal points, which do not define a line.",
    hint="Test the length before you divide by it, and return None if it is 0.",
)
def returns_none_for_equal_points(line_through: Callable) -> None:
    require_slanted_lines(line_through)
    for point in ((0.0, 0.0), (3.0, -2.0)):
        assert_no_line(line_through, point)


@visible_check(
    "line_through",
    weight=1,
    title="Finds a line through points that are close together",
    why="A scanner may hit the same wall twice within a few centimetres, and RANSAC may draw "
    "these two points.",
    hint="Return None only if the length is exactly 0.",
)
def finds_lines_through_close_points(line_through: Callable) -> None:
    require_slanted_lines(line_through)
    for p, q in (((1.0, 2.0), (1.03, 2.04)), ((-4.0, 7.0), (-4.004, 7.003))):
        if line_through(np.array(p), np.array(q)) is None:
            raise CheckFailed(
                "The answer is None although the points differ.",
                input_text=f"two points {np.hypot(q[0] - p[0], q[1] - p[1]):.3f} m apart",
                yours="None",
                expected="three numbers (a, b, c)",
            )


_P, _Q = frozen((np.array(_PAIRS[0][0]), np.array(_PAIRS[0][1])))
common_checks.promise_untouched(
    Case(__name__, "line_through", {"p": _P, "q": _Q}, None, as_line, require_slanted_lines),
    "leaves_the_points",
    why="p and q may be rows of the scan, so changing them would move points of the wall.",
    hint="Write dx = q[0] - p[0], which changes nothing. q -= p changes q.",
)


# The right line and the second point of each pair, both keyed by the first point.
_LINES = {
    (1.0, 2.0): frozen(np.array([-0.8, 0.6, -0.4])),
    (-3.0, 5.0): frozen(np.array([12.0, 5.0, 11.0]) / 13),
    (6.0, 1.0): frozen(np.array([-0.6, -0.8, 4.4])),
}
_SECOND_POINTS = {(1.0, 2.0): (4.0, 6.0), (-3.0, 5.0): (2.0, -7.0), (6.0, 1.0): (-2.0, 7.0)}


def _distance_between(p: np.ndarray, q: np.ndarray) -> float:
    return float(np.linalg.norm(np.subtract(p, q)))


def _same_line(answer: object, predicted: np.ndarray) -> bool:
    """Return whether two lines have the same numbers, or the same with opposite signs."""
    return same_array(answer, predicted) or same_array(answer, -np.asarray(predicted))


declare_mistakes(
    "line_through",
    Mistake(
        "The line is right, but its normal is as long as the distance between the points.",
        lambda right, p, q: right * _distance_between(p, q),
        "Divide a and b by the length of the direction, then compute c.",
    ),
    Mistake(
        "(a, b) is parallel to the line. It must be perpendicular to the line.",
        lambda right, p, q: np.array([right[1], -right[0], right[0] * p[1] - right[1] * p[0]]),
        "Use (-dy, dx), which is perpendicular to the direction (dx, dy).",
    ),
    Mistake(
        "(a, b) is (dy, dx): dx and dy are swapped, but no sign is changed. This mirrors the "
        "direction instead of turning it.",
        lambda right, p, q: np.array([-right[0], right[1], right[0] * p[0] - right[1] * p[1]]),
        "Use (-dy, dx), and compute both dx and dy from p to q.",
    ),
    Mistake(
        "a and b are right, but c has the wrong sign.",
        lambda right, p, q: right * [1, 1, -1],
        "Choose c so that a x + b y + c is 0 at p.",
    ),
    Mistake(
        "a and b are divided by the length, but c is not.",
        lambda right, p, q: right * [1, 1, _distance_between(p, q)],
        "Compute c after you have divided a and b.",
    ),
    Mistake(
        "The vector (a, b, c) has length 1, but the normal (a, b) does not.",
        lambda right, p, q: right / np.linalg.norm(right),
        "Divide only by the length of (a, b).",
    ),
    Mistake(
        "c is always 0, so the line passes through (0, 0) instead of the points.",
        lambda right, p, q: right * [1, 1, 0],
        "Choose c so that a x + b y + c is 0 at p.",
    ),
    Mistake(
        "The function returns the slope and the intercept of y = m x + h. It should return a, b "
        "and c.",
        lambda right, p, q: np.array([-right[0], -right[2]]) / right[1],
        "Return (a, b, c) of the line a x + b y + c = 0.",
    ),
    cases=[(np.array(p), np.array(q)) for p, q in _SECOND_POINTS.items()],
    right=lambda p, q: _LINES[tuple(p.tolist())],
    is_same=_same_line,
)
