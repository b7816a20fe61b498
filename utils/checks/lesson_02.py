"""Visible checks of lesson 02: `line_through`, `point_line_distance` and `ransac_line`."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    WrongForm,
    as_array,
    as_shape,
    brief_text,
    call_each,
    distinct_texts,
    frozen,
    metres_text,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.failures import NotYet, fixed
from utils.checks.run_cache import once_per_run

# ---- lines -------------------------------------------------------------------------------------

# Pairs of points on slanted lines. No pair is exactly 1 m apart, so that a normal that is not
# divided by its length is wrong.
_PAIRS = (
    ((1.0, 2.0), (4.0, 6.0)),
    ((-3.0, 5.0), (2.0, -7.0)),
    ((8.0, 8.0), (2.0, 2.0)),
    ((0.1, 0.1), (0.4, 0.5)),
)


def as_line(answer: object) -> np.ndarray:
    """Convert an answer to an array with the three numbers of a line.

    Returns
    -------
    numpy.ndarray, shape (3,)

    Raises
    ------
    CheckFailed
        If the answer is None or is not three finite numbers.
    """
    if answer is None:
        raise WrongForm(
            "The function returned None although the points differ. Does every path through it "
            "end with `return`?",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    line = as_array(answer, description="three numbers (a, b, c)").astype(float)
    if line.shape != (3,):
        raise WrongForm(
            "A line is three numbers (a, b, c).", yours=f"shape {line.shape}", expected="shape (3,)"
        )
    if not np.isfinite(line).all():
        raise CheckFailed("Some of the three numbers are not finite.", yours=brief_text(line))
    return line


def _normal_length(line: np.ndarray) -> float:
    length = float(np.hypot(line[0], line[1]))
    if length < 1e-9:
        raise CheckFailed(
            fixed("The normal (a, b) has length 0, so the line has no direction."),
            yours=brief_text(line),
        )
    return length


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
    length = _normal_length(line)
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
    length = _normal_length(line)
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

# ---- distances ---------------------------------------------------------------------------------

# A slanted line through (0, 0), with points on its positive side or on the line itself. In this
# plain case c is 0 and no distance needs an absolute value.
_SLANTED = frozen(np.array([0.6, -0.8, 0.0]))
_POSITIVE_SIDE = frozen(
    np.array([[3.0, 1.0], [5.0, 0.0], [2.0, -1.0], [-1.0, -2.0], [4.0, 3.0], [1.0, -3.0]])
)
_DISTANCES = frozen(np.array([1.0, 3.0, 2.0, 1.0, 0.0, 3.0]))


def assert_line_distances(
    answer: object, points: np.ndarray, line: np.ndarray, expected: np.ndarray
) -> None:
    """Assert that the answer equals the expected distances.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2)
    line : numpy.ndarray, shape (3,)
    expected : numpy.ndarray, shape (n,)
        Distances in metres.
    """
    yours = as_array(answer, description="an array of distances")
    each_point = "the only point" if len(points) == 1 else f"each of the {len(points)} points"
    if yours.shape == ():
        raise WrongForm(
            f"There must be one distance for {each_point}, but the answer is a single number.",
            yours=brief_text(yours.item()),
            expected=f"shape {expected.shape}",
        )
    yours = as_shape(yours, expected.shape, f"one distance for {each_point}")
    wrong = np.flatnonzero(~np.isclose(yours, expected, rtol=0, atol=TOLERANCE).reshape(-1))
    if len(wrong):
        verb = "is" if len(wrong) == 1 else "are"
        mine, right = distinct_texts(metres_text, yours[wrong[0]], expected[wrong[0]])
        raise CheckFailed(
            f"{len(wrong)} of {len(points)} distances {verb} wrong.",
            input_text=f"the line {brief_text(np.asarray(line))} and the point "
            f"{point_text(points[wrong[0]])}",
            yours=mine,
            expected=right,
            draw=lambda: _draw_circles(points, line, yours),
        )


def _draw_circles(points: np.ndarray, line: np.ndarray, distances: np.ndarray) -> None:
    """Draw a circle around each point, with the distance from the answer as its radius."""
    from matplotlib.patches import Circle

    limits = [[low - 4, high + 4] for low, high in zip(points.min(0), points.max(0), strict=True)]
    axes = utils.plots.line_model(
        points, line, limits=limits, title="Each circle should touch the line"
    )
    for point, distance in zip(points, distances, strict=True):
        if np.isfinite(distance):
            axes.add_patch(Circle(point, abs(float(distance)), fill=False, linewidth=0.8))


@once_per_run
def require_plain_distances(point_line_distance: Callable) -> None:
    """Raise `NotYet` if the plain case is wrong."""
    with precondition("distances from a line through (0, 0) are right on its positive side"):
        answer = point_line_distance(_POSITIVE_SIDE.copy(), _SLANTED.copy())
        assert_line_distances(answer, _POSITIVE_SIDE, _SLANTED, _DISTANCES)


@visible_check(
    "point_line_distance",
    weight=4,
    title="Measures the perpendicular distance from the line",
    why="RANSAC compares these distances with its threshold, so a wrong distance adds a point to "
    "the wall or removes it.",
    hint="Compute a x + b y + c for all points at once: x is points[:, 0] and y is points[:, 1].",
)
def measures_perpendicular_distances(point_line_distance: Callable) -> None:
    answer = point_line_distance(_POSITIVE_SIDE.copy(), _SLANTED.copy())
    assert_line_distances(answer, _POSITIVE_SIDE, _SLANTED, _DISTANCES)


@visible_check(
    "point_line_distance",
    weight=5,
    title="Returns no negative distances on either side of the line",
    why="A negative distance is below any threshold, so half of the street would count as inliers.",
    hint="Call np.abs, which takes the absolute value of a whole array.",
)
def measures_on_both_sides(point_line_distance: Callable) -> None:
    require_plain_distances(point_line_distance)
    points = np.vstack([-_POSITIVE_SIDE, _POSITIVE_SIDE])
    answer = point_line_distance(points.copy(), _SLANTED.copy())
    assert_line_distances(answer, points, _SLANTED, np.tile(_DISTANCES, 2))


@visible_check(
    "point_line_distance",
    weight=5,
    title="Works for lines that do not pass through (0, 0)",
    why="Hardly any wall passes through the scanner at (0, 0), so without c nearly all distances "
    "are wrong.",
    hint="Add c, with its sign, before you take the absolute value: |a x + b y + c|.",
)
def adds_c(point_line_distance: Callable) -> None:
    require_plain_distances(point_line_distance)
    for c, points, expected in (
        (2.0, [[1, 2], [3, 1], [0, 0], [2, -1], [-1, 1]], [1.0, 3.0, 2.0, 4.0, 0.6]),
        (-2.0, [[5, 0], [1, -3], [6, 1], [2, -1]], [1.0, 1.0, 0.8, 0.0]),
    ):
        points, line = np.array(points, dtype=float), np.array([0.6, -0.8, c])
        answer = point_line_distance(points.copy(), line.copy())
        assert_line_distances(answer, points, line, np.array(expected))


@visible_check(
    "point_line_distance",
    weight=7,
    title="Works for points on both sides of a line that does not pass through (0, 0)",
    why="A wall hardly ever passes through the scanner, and its points are on both sides of the "
    "line.",
    hint="Compute the whole sum including c, then take np.abs of it.",
)
def measures_on_both_sides_of_any_line(point_line_distance: Callable) -> None:
    with precondition("c is added and no distance is negative"):
        adds_c(point_line_distance)
        measures_on_both_sides(point_line_distance)
    points = np.vstack([-_POSITIVE_SIDE, _POSITIVE_SIDE])
    for c in (2.5, -2.5):
        line = np.array([*_SLANTED[:2], c])
        expected = np.abs(np.append(-_DISTANCES, _DISTANCES) + c)
        assert_line_distances(
            point_line_distance(points.copy(), line.copy()), points, line, expected
        )


@visible_check(
    "point_line_distance",
    weight=2,
    title="Works for lines parallel to an axis",
    why="A wall straight ahead of the car is parallel to the y axis, and the car must see it.",
    hint="Compute |a x + b y + c| without a slope and without a division.",
)
def measures_from_axis_parallel_lines(point_line_distance: Callable) -> None:
    require_plain_distances(point_line_distance)
    points = np.array([[2.0, 1.0], [5.0, 4.0], [0.0, 3.0], [7.0, 0.0], [1.0, 6.0]])
    for line, column in (((1.0, 0.0, 0.0), 0), ((0.0, 1.0, 0.0), 1)):
        line = np.array(line)
        answer = point_line_distance(points.copy(), line.copy())
        assert_line_distances(answer, points, line, points[:, column])


@visible_check(
    "point_line_distance",
    weight=1,
    title="Accepts the line as a tuple, a list or an array",
    why="Your line_through may return its three numbers in any of these types.",
    hint="Unpack the line with a, b, c = line, which works for all three types.",
)
def accepts_any_sequence(point_line_distance: Callable) -> None:
    require_plain_distances(point_line_distance)
    for line in (tuple(_SLANTED.tolist()), _SLANTED.tolist()):
        answer = point_line_distance(_POSITIVE_SIDE.copy(), line)
        assert_line_distances(answer, _POSITIVE_SIDE, _SLANTED, _DISTANCES)


_PLAIN_CASE = Case(
    __name__,
    "point_line_distance",
    {"points": _POSITIVE_SIDE, "line": _SLANTED},
    expected=_DISTANCES,
    compare=assert_line_distances,
    precondition=require_plain_distances,
)
common_checks.promise_few_points(
    _PLAIN_CASE,
    "works_on_few_points",
    title="Works on a single point and on an empty array",
    why="An empty street gives no points, and that must not crash the program.",
)


@note_check(
    "point_line_distance",
    title="Returns a NumPy array",
    why="ransac_line compares all distances with its threshold at once, which does not work "
    "with a list. np.array(...) makes an array.",
)
def returns_an_array(point_line_distance: Callable) -> None:
    answer = point_line_distance(_POSITIVE_SIDE.copy(), _SLANTED.copy())
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(f"The function returns the distances as a {type(answer).__name__}.")


common_checks.promise_untouched(
    _PLAIN_CASE,
    "leaves_points_and_line",
    why="The next round of RANSAC needs the original points.",
    hint="Write points[:, 0] * a, which makes a new array. points[:, 0] *= a changes the points.",
)


# Points with a line, and a x + b y + c at each point, both keyed by the number of points.
_POINTS_AND_LINE = {
    5: (
        frozen(np.array([[2.0, 1.0], [4.0, -1.0], [-3.0, 2.0], [-1.0, 0.0], [0.0, 3.0]])),
        frozen(np.array([0.6, -0.8, 1.0])),
    ),
    4: (
        frozen(np.array([[1.0, 5.0], [5.0, 0.0], [0.0, -2.0], [-5.0, 1.0]])),
        frozen(np.array([-0.28, 0.96, -2.0])),
    ),
}
_SIGNED_DISTANCES = {
    5: frozen(np.array([1.4, 4.2, -2.4, 0.4, -1.4])),
    4: frozen(np.array([2.52, -3.4, -3.92, 0.36])),
}


def _signed_distances(points: np.ndarray) -> np.ndarray:
    return _SIGNED_DISTANCES[len(points)]


declare_mistakes(
    "point_line_distance",
    Mistake(
        "Distances on one side of the line are negative: the absolute value is missing.",
        lambda right, points, line: _signed_distances(points),
        "Call np.abs, which takes the absolute value of a whole array.",
    ),
    Mistake(
        "All points on one side of the line get the distance 0.",
        lambda right, points, line: np.where(_signed_distances(points) < 0, 0, right),
        "Call np.abs, which takes the absolute value of a whole array.",
    ),
    Mistake(
        "The function measures the distances from the parallel line through (0, 0): c is missing.",
        lambda right, points, line: np.abs(_signed_distances(points) - line[2]),
    ),
    Mistake(
        "c has the wrong sign: it must be added to a x + b y.",
        lambda right, points, line: np.abs(_signed_distances(points) - 2 * line[2]),
    ),
    Mistake(
        "The absolute value is taken too early: c is added after it.",
        lambda right, points, line: np.abs(_signed_distances(points) - line[2]) + line[2],
        "Put c inside the parentheses of np.abs(...).",
    ),
    Mistake(
        "The function adds the absolute values of the three terms. It should take the absolute "
        "value of their sum.",
        lambda right, points, line: np.abs(line[:2] * points).sum(axis=1) + abs(line[2]),
        "Add the terms with their signs, then take the absolute value of the sum.",
    ),
    Mistake(
        "The function returns squared distances.",
        lambda right, points, line: right**2,
        "Use np.abs instead of the square, so that the result stays in metres.",
    ),
    Mistake(
        "The function measures the distances along y, not perpendicular to the line.",
        lambda right, points, line: right / abs(line[1]),
        "The normal has length 1, so do not divide: |a x + b y + c| is the distance.",
    ),
    Mistake(
        "x and y are swapped: a belongs to x, points[:, 0], and b to y, points[:, 1].",
        lambda right, points, line: np.abs(
            _signed_distances(points) + (line[0] - line[1]) * (points[:, 1] - points[:, 0])
        ),
    ),
    Mistake(
        "points[0] and points[1] are the first two points, not the columns x and y.",
        lambda right, points, line: np.abs(np.dot(line, [*points[:2], [1, 1]])),
        "Write points[:, 0] for the x of every point: all rows, column 0.",
    ),
    cases=_POINTS_AND_LINE.values(),
    right=lambda points, line: np.abs(_signed_distances(points)),
)

# ---- RANSAC ------------------------------------------------------------------------------------


def as_line_and_mask(answer: object, n: int) -> tuple[np.ndarray | None, np.ndarray]:
    """Convert an answer to a pair of a line, which may be None, and a mask.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    line : numpy.ndarray, shape (3,), or None
    inliers : numpy.ndarray of bool, shape (n,)

    Raises
    ------
    CheckFailed
        If the answer is not such a pair.
    """
    if answer is None:
        raise WrongForm(
            "The function returned None. Does it end with `return line, inliers`?",
            yours="None",
            expected="a pair (line, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise WrongForm(
            "The function must return two values, the line and the mask.",
            yours=brief_text(answer),
            expected="a pair (line, inliers)",
        )
    line, inliers = answer
    if inliers is None:
        raise WrongForm(
            "The second returned value, the mask, is None.",
            yours="None",
            expected=f"{n} values, each True or False",
        )
    mask = as_array(inliers, description="a mask of True and False")
    if mask.shape == (3,) and n != 3 and isinstance(line, np.ndarray) and line.shape == (n,):
        raise WrongForm(
            "The two returned values are in the wrong order: return the line first, then the mask.",
            yours="(mask, line)",
            expected="(line, mask)",
        )
    if mask.size == 0:
        mask = mask.reshape(-1)
    if mask.shape != (n,) or not np.isin(mask, (0, 1)).all():
        raise WrongForm(
            f"The inliers must be a mask: True or False for each of the {n} points."
            f"{_kind_of_array(mask)}",
            yours=brief_text(mask),
            expected=f"shape ({n},), dtype bool",
        )
    mask = mask.astype(bool)
    return (None if line is None else as_line(line)), mask


def _kind_of_array(mask: np.ndarray) -> str:
    """Return a sentence about the content of an array that is not a mask; "" if unknown."""
    if mask.ndim == 2 and mask.shape[1] == 2:
        return " These are points."
    if mask.ndim == 1 and mask.dtype.kind in "iu" and (np.diff(mask) > 0).all():
        return " These are row numbers."
    return ""


def distances_from(line: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distances of points from a line with a normal of any length; shape (n,)."""
    values = np.asarray(points, dtype=float) @ line[:2] + line[2]
    return np.abs(values) / _normal_length(line)


def assert_mask_matches_line(
    answer: object, points: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Assert that the mask marks the points within the tolerance of the line returned with it.

    Parameters
    ----------
    answer : object
        The line and the mask that the student's function returned.
    points : numpy.ndarray, shape (n, 2)
    tolerance : float
        In metres.

    Returns
    -------
    line : numpy.ndarray, shape (3,)
    inliers : numpy.ndarray of bool, shape (n,)
    """
    line, mask = as_line_and_mask(answer, len(points))
    if line is None:
        raise CheckFailed(
            "The line is None although the points differ.",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    distance = distances_from(line, points)
    # Rounding errors change the last digits, so both answers are accepted at the edge of the band.
    wrong = (mask != (distance <= tolerance)) & (np.abs(distance - tolerance) > TOLERANCE)
    if not wrong.any():
        return line, mask
    near, far = wrong & ~mask, wrong & mask
    parts = []
    if near.any():
        parts.append(
            f"Points within {tolerance:g} m of the line that are not marked: {near.sum()}."
        )
    if far.any():
        parts.append(f"Points farther away than {tolerance:g} m that are marked: {far.sum()}.")
    raise CheckFailed(
        " ".join(["The mask does not belong to the line.", *parts]),
        yours=_inlier_count(mask),
        expected=_inlier_count(distance <= tolerance),
        draw=lambda: utils.plots.line_model(
            np.asarray(points, dtype=float),
            line,
            mask,
            tolerance,
            title="your line, its band and your inliers",
        ),
    )


def _inlier_count(mask: np.ndarray) -> str:
    return "1 inlier" if mask.sum() == 1 else f"{mask.sum()} inliers"


def wall_and_clutter(
    seed: int | Sequence[int], inliers: int, outliers: int, noise: float = 0.1
) -> tuple[np.ndarray, np.ndarray]:
    """Return shuffled points near a random line and points at least 1 m away from it.

    Parameters
    ----------
    seed : int or sequence of int
        Seed of the random generator that draws the line and the points.
    inliers, outliers : int
        Number of points near the line, and of points away from it.
    noise : float
        Largest distance between the line and the points near it, in metres.

    Returns
    -------
    points : numpy.ndarray, shape (inliers + outliers, 2)
        Points within about 15 m of the origin.
    on_line : numpy.ndarray of bool, shape (inliers + outliers,)
        True for the points near the line.
    """
    rng = np.random.default_rng(seed)
    angle, offset = rng.uniform(0, np.pi), rng.uniform(-3, 3)
    direction = np.array([np.cos(angle), np.sin(angle)])
    normal = np.array([-direction[1], direction[0]])
    wall = np.outer(rng.uniform(-10, 10, inliers), direction)
    wall += np.outer(offset + rng.uniform(-noise, noise, inliers), normal)
    clutter = rng.uniform(-10, 10, (outliers, 2))
    offsets = clutter @ normal - offset
    shifts = np.where(np.abs(offsets) < 1, np.where(offsets < 0, -1.0, 1.0), 0.0)
    points = np.vstack([wall, clutter + np.outer(shifts, normal)])
    order = rng.permutation(len(points))
    return points[order], (np.arange(len(points)) < inliers)[order]


_CLOUDS = tuple(frozen(wall_and_clutter(seed, 24, 16)) for seed in range(12))


def follows_wall(line: np.ndarray | None, wall: np.ndarray, tolerance: float) -> bool:
    """Return whether at least 80 % of the points of a wall are within the tolerance of a line.

    Parameters
    ----------
    line : numpy.ndarray, shape (3,), or None
    wall : numpy.ndarray, shape (n, 2)
    tolerance : float
        In metres.
    """
    return line is not None and (distances_from(line, wall) <= tolerance).mean() >= 0.8


def assert_finds_line(
    ransac_line: Callable,
    runs: Sequence[tuple[np.ndarray, np.ndarray]],
    needed: int,
    max_iterations: int,
    tolerance: float,
) -> None:
    """Assert that at least `needed` of the runs find the line; the masks are ignored.

    Parameters
    ----------
    ransac_line : callable
    runs : sequence of (points, on_line)
        One pair for each run, as returned by `wall_and_clutter`.
    needed, max_iterations : int
        Number of runs that must find the line, and number of rounds in each run.
    tolerance : float
        In metres.
    """
    answers, missed, found = [], [], 0
    for seed, (points, on_line) in enumerate(runs):
        line, mask = _run_once(ransac_line, points, max_iterations, tolerance, seed)
        answers.append((line, mask))
        if not follows_wall(line, points[on_line], tolerance):
            missed.append((points, line, mask))
            continue
        found += 1
        if found == needed:  # more runs would take time and could not change the result
            break
    if found < needed:
        n_without_line = sum(line is None for _, line, _ in missed)
        observation, hint = _explain_runs(answers, ransac_line, runs, max_iterations, tolerance)
        raise CheckFailed(
            f"The line was found in {found} of {len(runs)} runs."
            + (
                f" In {n_without_line} of the {len(runs)} runs, the answer was None."
                if n_without_line
                else ""
            )
            + observation,
            yours=f"found in {found} of {len(runs)} runs",
            expected=f"found in nearly all runs, with {max_iterations} rounds",
            hint=hint,
            draw=lambda: utils.plots.line_model(
                *missed[0], tolerance, title="a run that missed the line"
            ),
        )


def _run_once(
    ransac_line: Callable, points: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> tuple[np.ndarray | None, np.ndarray]:
    """Return the line and the mask of one run with a generator made from `seed`."""
    rng = np.random.default_rng(seed)
    return as_line_and_mask(ransac_line(points.copy(), max_iterations, tolerance, rng), len(points))


def answers_of_short_runs(
    ransac_line: Callable,
    points: np.ndarray,
    max_iterations: int,
    tolerance: float,
    generators: Iterable[np.random.Generator | int],
) -> list[tuple[np.ndarray | None, np.ndarray]]:
    """Return the lines and masks of many short runs, which share the time limit of one call."""
    calls = [(points, max_iterations, tolerance, rng) for rng in generators]
    return [as_line_and_mask(answer, len(points)) for answer in call_each(ransac_line, calls)]


def _explain_runs(
    answers: Sequence[tuple],
    ransac_line: Callable,
    runs: Sequence[tuple],
    max_iterations: int,
    tolerance: float,
) -> tuple[str, str]:
    """Return a sentence about a likely reason why runs missed the line, and a hint.

    Both are empty if no reason is known.
    """
    if any(line is None for line, _ in answers):
        return "", ""
    if not any(mask.any() for _, mask in answers):
        return (
            " Each run returned a line but not a single inlier.",
            "When you replace the best line, also replace the best mask.",
        )
    if all(
        np.array_equal(mask, distances_from(line, points) > tolerance)
        for (line, mask), (points, _) in zip(answers, runs, strict=False)
    ):
        return (
            " Each mask marks the points that are farther from the line than the threshold.",
            "Compare with <=: inliers have a distance of at most distance_tolerance.",
        )

    def run_all(rounds: int) -> list[tuple]:
        return [
            _run_once(ransac_line, points, rounds, tolerance, seed)
            for seed, (points, _) in enumerate(runs)
        ]

    after_one = run_all(1)
    both = list(zip(after_one, answers, strict=True))
    if all(_lines_equal(first[0], last[0]) for first, last in both):
        masks_equal = all(np.array_equal(first[1], last[1]) for first, last in both)
        same = "the answers are the same" if masks_equal else "only the masks differ, not the lines"
        return (
            f" With {fixed('1 round')} instead of {max_iterations}, {same}.",
            "Create rng before the loop, draw a sample in each round, and return after the loop.",
        )
    after_half = run_all(max_iterations // 2)
    fewer = sum(
        last.sum() < first.sum() for (_, first), (_, last) in zip(after_half, answers, strict=True)
    )
    if fewer:
        return (
            f" In {fewer} of the {len(runs)} runs, the mask has fewer inliers after "
            f"{max_iterations} rounds than after {max_iterations // 2} rounds with the same "
            "seed.",
            "Replace the best line and mask only if the new mask has more inliers.",
        )
    return "", ""


@once_per_run
def require_line_among_outliers(ransac_line: Callable) -> None:
    """Raise `NotYet` if the line is not found among outliers."""
    with precondition("the line is found among outliers"):
        assert_finds_line(ransac_line, _CLOUDS, 8, 30, 0.4)


@visible_check(
    "ransac_line",
    weight=5,
    title="Finds the line among outliers",
    why="Even if people stand in front of a wall, the car must know where the wall is.",
    hint="After each round, compare the number of inliers with the number in the best mask so "
    "far. If it is larger, replace both line and mask.",
)
def finds_the_line(ransac_line: Callable) -> None:
    assert_finds_line(ransac_line, _CLOUDS, 8, 60, 0.4)


_RANSAC_CASE = Case(
    __name__,
    "ransac_line",
    {
        "points": _CLOUDS[1][0],
        "max_iterations": 30,
        "distance_tolerance": 0.4,
        "rng": np.random.default_rng(2),
    },
    expected=None,
    compare=lambda answer, points, *_: as_line_and_mask(answer, len(points)),
    precondition=require_line_among_outliers,
)
common_checks.promise_untouched(
    _RANSAC_CASE,
    "leaves_its_input",
    why="The next search needs the original points.",
    hint="Draw row numbers with rng.choice instead of shuffling the points.",
)


@visible_check(
    "ransac_line",
    weight=6,
    title="Returns the mask that belongs to the line, for any threshold",
    why="If the line and the mask come from different samples, later cells remove the wrong "
    "points.",
    hint="Replace line and mask together. Compare distances in metres with distance_tolerance, and "
    "do not square them.",
)
def mask_belongs_to_line(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for seed, tolerance in enumerate((0.1, 0.4, 0.7, 2.5)):
        rng = np.random.default_rng(seed)
        # The wall is so rough that another line would have different inliers.
        points, _ = wall_and_clutter(100 + seed, 30, 10, noise=0.8)
        assert_mask_matches_line(ransac_line(points.copy(), 30, tolerance, rng), points, tolerance)


@note_check(
    "ransac_line",
    title="Counts a point at exactly distance_tolerance as an inlier",
    why="In the docstring, distance_tolerance is the largest distance of an inlier, so write <=. "
    "Measured points are hardly ever at exactly that distance, so this does not affect your score.",
)
def includes_the_threshold(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_threshold_is_inclusive(ransac_line, np.array([[0.0, 0.0], [8.0, 0.0], [4.0, 1.0]]))


def assert_threshold_is_inclusive(ransac_line: Callable, points: np.ndarray) -> None:
    """Assert that a point exactly `distance_tolerance` away from the line counts as an inlier.

    Parameters
    ----------
    ransac_line : callable
    points : numpy.ndarray, shape (3, 2)
        Three points with whole-numbered coordinates, so that distances are exact. The first two
        are on a line parallel to an axis, and the third is exactly 1 m from that line.
    """
    axis = int(points[0, 1] == points[1, 1])  # the axis of the normal
    exact = np.insert(np.eye(2)[axis], 2, -points[0, axis])
    matching_lines = 0
    for seed in range(30):
        answer = ransac_line(points.copy(), 3, 1.0, np.random.default_rng(seed))
        line, mask = as_line_and_mask(answer, 3)
        # Skip other lines: one that was refitted to its inliers may be off in the last digits.
        if line is None or not (np.array_equal(line, exact) or np.array_equal(line, -exact)):
            continue
        if not mask[2]:
            raise CheckFailed(
                "A point at exactly distance_tolerance from the line is not marked.",
                input_text=f"distance_tolerance=1.0, the line {brief_text(line)} and the point "
                f"{point_text(points[2])}",
                yours="False",
                expected="True",
            )
        matching_lines += 1
        if matching_lines == 3:  # further comparisons give the same result
            return


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws as many samples as max_iterations allows",
    why="On a street with many outliers, RANSAC needs many rounds to find the wall.",
    hint="Loop over range(max_iterations) and draw one sample of two points in each round.",
)
def draws_enough_samples(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_no_round_is_missing(ransac_line)
    # About one sample in 25 gives the line.
    assert_finds_line(ransac_line, [wall_and_clutter(7, 14, 46)] * 12, 8, 250, 0.3)


def assert_no_round_is_missing(ransac_line: Callable) -> None:
    """Assert that one round is enough to find a line when all points lie on it."""
    steps = np.arange(10.0)
    wall = np.column_stack([steps, 2 * steps + 1])

    def runs_with_line(rounds: int) -> int:
        """Return the number of runs that find a line."""
        runs = (
            ransac_line(wall.copy(), rounds, 0.3, np.random.default_rng(seed)) for seed in range(12)
        )
        return sum(as_line_and_mask(answer, 10)[0] is not None for answer in runs)

    if runs_with_line(1):
        return
    second_round_note = fixed(" With max_iterations=2 a line is found, so one round is missing.")
    raise CheckFailed(
        fixed("All ten points lie on one line, but a run with max_iterations=1 never finds a line.")
        + (second_round_note if runs_with_line(2) else ""),
        yours="no line in 12 of 12 runs",
        expected="a line in every run",
        hint="Loop over range(max_iterations): range(1, max_iterations) and range(max_iterations "
        "- 1) give one round fewer.",
    )


@visible_check(
    "ransac_line",
    weight=1,
    title="Draws no more samples than max_iterations allows",
    why="Each round takes time, and the next scan arrives in a tenth of a second.",
    hint="Loop over range(max_iterations) and draw one sample of two points in each round.",
)
def draws_no_more_samples(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    points, on_line = wall_and_clutter(7, 14, 46)
    generators = map(np.random.default_rng, range(48))
    answers = answers_of_short_runs(ransac_line, points, 1, 0.3, generators)
    found = sum(follows_wall(line, points[on_line], 0.3) for line, _ in answers)
    if found >= 24:  # practically impossible if one sample in 25 gives the line
        raise CheckFailed(
            fixed(
                "With max_iterations=1, the line was found in most runs, but a single sample "
                "hardly ever finds it. The function draws more samples than max_iterations allows."
            ),
            yours=f"found in {found} of 48 runs",
            expected="found in about 2 of 48 runs",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Draws two different points for each sample",
    why="If a point is drawn twice, there is no line, and the round is wasted.",
    hint="Draw with rng.choice(len(points), size=2, replace=False), which never draws a row twice.",
)
def draws_different_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    runs = lines_from_two_rounds(ransac_line, _TRIANGLE)
    n_without_line = sum(line is None for line in runs)
    if n_without_line:
        raise CheckFailed(
            "Any two of the three points define a line, but in some runs no line was found.",
            input_text="three points and max_iterations=2",
            yours=f"no line in {n_without_line} of {len(runs)} runs",
            expected="a line in every run",
        )


# Any two of these points define a line, and the other points are far from it.
_FOUR_POINTS = frozen(np.array([[1.0, 2.0], [5.0, -1.0], [-2.0, -4.0], [4.0, 6.0]]))
_TRIANGLE = frozen(_FOUR_POINTS[:3])


def lines_from_two_rounds(ransac_line: Callable, points: np.ndarray) -> list[np.ndarray | None]:
    """Return the lines of 64 two-round runs with different seeds; None for a run without a line.

    With three points, a function that draws with replacement finds no line in one run of nine.
    Another check looks for a missing round.

    Raises
    ------
    NotYet
        If no run finds a line.
    """
    generators = map(np.random.default_rng, range(64))
    lines = [line for line, _ in answers_of_short_runs(ransac_line, points, 2, 0.1, generators)]
    if all(line is None for line in lines):
        raise NotYet(f"two rounds find a line through some of the {len(points)} points")
    return lines


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws from all points, including the first and the last",
    why="A point that is never drawn may be one of the few on the wall.",
    hint="Draw with rng.choice(len(points), size=2, replace=False), which takes rows from 0 to "
    "len(points) - 1.",
)
def draws_from_all_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    lines, drawn, has_distant_rows = [], np.zeros(len(_FOUR_POINTS), dtype=bool), False
    for line in lines_from_two_rounds(ransac_line, _FOUR_POINTS):
        if line is not None:
            lines.append(line)
            rows = np.flatnonzero(distances_from(line, _FOUR_POINTS) < TOLERANCE)
            drawn[rows] = True
            # Rows 0 and 3 count as neighbours, because a function may wrap around at the end.
            has_distant_rows |= rows[-1] - rows[0] == 2
        if drawn.all() and has_distant_rows:
            return
    if all(_lines_equal(line, lines[0]) for line in lines):
        return  # another check tests whether different seeds draw different samples
    if drawn.all():
        raise CheckFailed(
            "Only neighbouring rows are drawn together.",
            input_text="four points and max_iterations=2",
            yours=f"no line through rows 0 and 2 or through rows 1 and 3 in {len(lines)} runs",
            expected="one of these lines in about a third of the runs",
            hint="Draw both rows at random: rng.choice(len(points), size=2, replace=False).",
        )
    row = int(np.flatnonzero(~drawn)[0])
    raise CheckFailed(
        f"Row {row} of the four points was never drawn.",
        input_text="four points and max_iterations=2",
        yours=f"no line through row {row} in {len(lines)} runs",
        expected="a line through each row in about half of the runs",
    )


@visible_check(
    "ransac_line",
    weight=1,
    title="Finds walls parallel to an axis",
    why="A wall straight ahead of the car is parallel to the y axis, and the car must not hit it.",
    hint="Do not compute a slope: line_through and point_line_distance work for all directions.",
)
def finds_axis_parallel_lines_among_outliers(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for column in (0, 1):
        points = np.random.default_rng(column).uniform(-9, 9, (30, 2))
        points[:20, column] = 4.0
        assert_finds_line(ransac_line, [(points, np.arange(30) < 20)] * 6, 3, 80, 0.2)


@visible_check(
    "ransac_line",
    weight=2,
    title="Returns the same answer for the same seed",
    why="To debug a run that went wrong, you must be able to repeat it.",
    hint="Draw with rng.choice, never with np.random.choice or the module random.",
)
def repeats_with_the_same_seed(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_repeats(ransac_line, np.random.default_rng)


@once_per_run
def assert_repeats(ransac_line: Callable, as_rng: Callable) -> None:
    """Assert that a second run with the same seed gives the same line and mask.

    Parameters
    ----------
    ransac_line : callable
    as_rng : callable
        Takes a seed and returns the value to pass as `rng`.
    """
    points, _ = wall_and_clutter(3, 20, 20)
    generators = [as_rng(seed) for seed in range(20) for _ in range(2)]
    answers = answers_of_short_runs(ransac_line, points, 2, 0.4, generators)
    for seed, (first, again) in enumerate(zip(answers[::2], answers[1::2], strict=True)):
        if not (_lines_equal(first[0], again[0]) and np.array_equal(first[1], again[1])):
            raise CheckFailed(
                "The same seed gave two different answers.",
                input_text=f"the seed {seed} twice, with max_iterations=2",
                yours=f"first the line {_line_text(first[0])}, then {_line_text(again[0])}",
                expected="the same line and mask both times",
            )


def _lines_equal(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    if first is None or second is None:
        return first is second
    return bool(np.allclose(first, second))


def _line_text(line: np.ndarray | None) -> str:
    return "None" if line is None else brief_text(line)


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws different samples for different seeds",
    why="If a run misses the wall, a run with another seed may find it.",
    hint="Begin with rng = np.random.default_rng(rng), and never use a fixed seed.",
)
def differs_with_other_seeds(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    points, _ = wall_and_clutter(3, 20, 20)
    lines = set()
    for seed in range(20):
        answer = ransac_line(points.copy(), 2, 0.4, np.random.default_rng(seed))
        lines.add(_line_text(as_line_and_mask(answer, len(points))[0]))
        if len(lines) > 1:
            return
    if lines == {_line_text(None)}:
        raise NotYet("two rounds find a line")
    raise CheckFailed(
        fixed("20 different seeds all gave the same line."),
        input_text="max_iterations=2",
        yours=f"always {lines.pop()}",
        expected="nearly 20 different lines",
    )


@visible_check(
    "ransac_line",
    weight=2,
    title="Continues after a sample of equal points",
    why="Equal points are common in recordings, and a sample of two of them must not end the "
    "search.",
    hint="If line_through returns None, write `continue`, which goes on with the next round. "
    "`break` ends the search.",
)
def continues_after_equal_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    wall, _ = wall_and_clutter(11, 12, 0)
    points = np.vstack([np.tile([[2.0, 9.0]], (28, 1)), wall])
    n_without_line = 0
    for seed in range(24):
        answer = ransac_line(points.copy(), 40, 0.3, np.random.default_rng(seed))
        n_without_line += as_line_and_mask(answer, len(points))[0] is None
    if n_without_line:
        raise CheckFailed(
            "Not all points are equal, but in some runs no line was found.",
            input_text="28 equal points, 12 others and max_iterations=40",
            yours=f"no line in {n_without_line} of 24 runs",
            expected="a line in every run",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Returns an answer if all points are equal",
    why="A blocked scanner reports the same point again and again, and that must not crash the "
    "program.",
    hint="If no round finds a line, return the initial values: None and a mask that is all False.",
)
def returns_for_equal_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    equal_points = np.tile([[2.0, 9.0]], (6, 1))
    answer = ransac_line(equal_points.copy(), 20, 0.3, np.random.default_rng(0))
    line, mask = as_line_and_mask(answer, 6)
    if line is not None:
        assert_mask_matches_line((line, mask), equal_points, 0.3)
    elif mask.any():
        raise CheckFailed(
            "If the line is None, no point can be an inlier.",
            yours=_inlier_count(mask),
            expected="0 inliers",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Works on two points and returns (None, all False) for fewer",
    why="An empty street gives no points, and that must not crash the program.",
    hint="If len(points) < 2, return None and np.zeros(len(points), dtype=bool) before the loop.",
)
def returns_for_too_few_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for points in (np.empty((0, 2)), np.array([[3.0, 4.0]])):
        assert_nothing_found(
            ransac_line(points.copy(), 10, 0.3, np.random.default_rng(0)), len(points)
        )
    assert_two_points_are_enough(ransac_line, _TRIANGLE[:2])


def assert_two_points_are_enough(ransac_line: Callable, pair: np.ndarray) -> None:
    """Assert that at least one of 12 runs finds the line through two different points."""
    for seed in range(12):
        answer = ransac_line(pair.copy(), 10, 0.3, np.random.default_rng(seed))
        if as_line_and_mask(answer, 2)[0] is not None:
            return
    raise CheckFailed(
        "Two different points define a line, but no line is found with any seed.",
        input_text="two points and max_iterations=10",
        yours="None",
        expected="three numbers (a, b, c)",
        hint="Return early only if len(points) < 2: two points are enough for a sample.",
    )


def assert_nothing_found(answer: object, n: int) -> None:
    """Assert that the answer for too few points is None and a mask that is False everywhere."""
    line, mask = as_line_and_mask(answer, n)
    if line is not None or mask.any():
        raise CheckFailed(
            "There are no points, so there is no line."
            if n == 0
            else "A single point does not define a line.",
            yours=brief_text((line, mask)),
            expected="(None, all False)",
        )


@visible_check(
    "ransac_line",
    weight=2,
    title="Accepts an integer seed as rng",
    why="A seed can be written to a log file; a generator cannot.",
    hint="Begin with rng = np.random.default_rng(rng), which accepts a whole number or a "
    "generator.",
)
def takes_a_seed(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    with precondition("the same generator gives the same answer"):
        assert_repeats(ransac_line, np.random.default_rng)
    assert_repeats(ransac_line, int)
    found = 0
    for seed, (points, on_line) in enumerate(_CLOUDS):
        line, _ = as_line_and_mask(ransac_line(points.copy(), 30, 0.4, seed), len(points))
        found += follows_wall(line, points[on_line], 0.4)
    if found < 8:  # the same bound as in require_line_among_outliers
        raise CheckFailed(
            f"With a whole number as rng, the line was found in {found} of {len(_CLOUDS)} runs. "
            "With a generator, it is found in most of them.",
            yours=f"found in {found} of {len(_CLOUDS)} runs",
            expected="found as often as with a generator",
            hint="Create the generator once, before the loop. If you create it from the same "
            "seed in each round, it draws the same sample each time.",
        )


common_checks.promise_names(
    _RANSAC_CASE,
    "keeps_the_names",
    why="Other code may call ransac_line(points, max_iterations=40, distance_tolerance=0.1, "
    "rng=1), because the names explain the numbers.",
)


@note_check(
    "ransac_line",
    title="Returns a mask of True and False",
    why="Later cells use points[mask] and points[~mask]. With the numbers 0 and 1, both select the "
    "wrong points.",
)
def has_a_mask_of_booleans(ransac_line: Callable) -> None:
    points, _ = _CLOUDS[0]
    _, inliers = ransac_line(points.copy(), 20, 0.4, np.random.default_rng(0))
    dtype = as_array(inliers).dtype
    if dtype.kind != "b":
        raise CheckFailed(f"The mask has the type {dtype}.")
