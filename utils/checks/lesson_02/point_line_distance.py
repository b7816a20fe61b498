"""Visible checks of `point_line_distance`."""

from collections.abc import Callable

import numpy as np

import utils
from utils.checks import common_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    WrongForm,
    as_array,
    as_shape,
    brief_text,
    distinct_texts,
    frozen,
    metres_text,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.run_cache import once_per_run

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
