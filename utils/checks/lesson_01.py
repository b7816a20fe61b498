"""Visible checks of lesson 01: `horizontal_distance` and `drop_invalid`."""

import math
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks, common_row_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    as_array,
    as_shape,
    assert_all_columns,
    assert_empty_table,
    assert_order,
    assert_positions,
    distinct_texts,
    frozen,
    metres_text,
    parse_table,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.run_cache import once_per_run

# ---- horizontal_distance -----------------------------------------------------------------------

# Points at the height of the sensor with intensity 0. Their distances are whole numbers, as in
# 3-4-5 triangles.
_FLAT = parse_table("3 4 0 0; -6 8 0 0; 5 -12 0 0; 0 7 0 0; -2 0 0 0")
_DISTANCES = frozen(np.array([5.0, 10.0, 13.0, 7.0, 2.0]))
# The same points, first with other intensities, then at heights from the road to the treetops.
_AT_ALL_INTENSITIES = frozen(_FLAT + np.outer([0.1, 0.9, 0.5, 1.0, 0.8], [0, 0, 0, 1]))
_AT_ALL_HEIGHTS = frozen(_FLAT + np.outer([-1.7, 4.0, -0.4, 2.5, -1.6], [0, 0, 1, 0]))


def assert_distances(answer: object, cloud: np.ndarray, expected: np.ndarray) -> None:
    """Assert that the answer equals the expected distances.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    expected : numpy.ndarray, shape (n,)
        Horizontal distances in metres.
    """
    yours = as_array(answer, description="an array of distances")
    each_point = "the only point" if len(cloud) == 1 else f"each of the {len(cloud)} points"
    yours = as_shape(yours, expected.shape, f"one distance for {each_point}")
    wrong = np.flatnonzero(~np.isclose(yours, expected, rtol=0, atol=TOLERANCE).reshape(-1))
    if len(wrong):
        verb = "is" if len(wrong) == 1 else "are"
        mine, right = distinct_texts(metres_text, yours[wrong[0]], expected[wrong[0]])
        raise CheckFailed(
            f"{len(wrong)} of {len(cloud)} distances {verb} wrong.",
            input_text=f"a point at {point_text(cloud[wrong[0]])}",
            yours=mine,
            expected=right,
        )


@once_per_run
def require_distances_at_sensor_height(horizontal_distance: Callable) -> None:
    """Raise `NotYet` if distances of points at the height of the sensor are wrong."""
    with precondition("the distances of points at the height of the sensor are right"):
        assert_distances(horizontal_distance(_FLAT.copy()), _FLAT, _DISTANCES)


@once_per_run
def require_distances_at_all_heights(horizontal_distance: Callable) -> None:
    """Raise `NotYet` if distances of points at various heights are wrong."""
    with precondition("the distances of points at other heights are right"):
        assert_distances(horizontal_distance(_AT_ALL_HEIGHTS.copy()), _AT_ALL_HEIGHTS, _DISTANCES)


@visible_check(
    "horizontal_distance",
    weight=1,
    title="Measures the distance of points at the height of the sensor",
    why="A wrong distance makes the car brake too early or too late.",
    hint="Compute the square root of x² + y² for whole columns: x = cloud[:, 0], y = cloud[:, 1].",
)
def measures_distance(horizontal_distance: Callable) -> None:
    assert_distances(horizontal_distance(_FLAT.copy()), _FLAT, _DISTANCES)


@visible_check(
    "horizontal_distance",
    weight=5,
    title="Ignores the height of a point",
    why="The car drives the same distance to a lamp post, whether a return comes from its top or "
    "its foot.",
    hint="Use only x and y, which are columns 0 and 1.",
)
def ignores_height(horizontal_distance: Callable) -> None:
    require_distances_at_sensor_height(horizontal_distance)
    assert_distances(horizontal_distance(_AT_ALL_HEIGHTS.copy()), _AT_ALL_HEIGHTS, _DISTANCES)


@visible_check(
    "horizontal_distance",
    weight=1,
    title="Ignores the intensity of a point",
    why="A bright number plate is no farther away than the dark tyre below it.",
    hint="Use only columns 0 and 1, because the last column is not a length.",
)
def ignores_intensity(horizontal_distance: Callable) -> None:
    require_distances_at_sensor_height(horizontal_distance)
    assert_distances(
        horizontal_distance(_AT_ALL_INTENSITIES.copy()), _AT_ALL_INTENSITIES, _DISTANCES
    )


@visible_check(
    "horizontal_distance",
    weight=1,
    title="Does not round the distances",
    why="Rounding errors add up when later steps use these distances.",
    hint="Return the distances unrounded. Round numbers only when you print them.",
)
def is_exact(horizontal_distance: Callable) -> None:
    require_distances_at_all_heights(horizontal_distance)
    cloud = np.array([[1.0, 1.0, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0]])
    assert_distances(horizontal_distance(cloud.copy()), cloud, np.array([1.41421356, 2.23606798]))


_STREET_CASE = Case(
    __name__,
    "horizontal_distance",
    {"cloud": _AT_ALL_HEIGHTS},
    expected=_DISTANCES,
    compare=assert_distances,
    precondition=require_distances_at_all_heights,
)
common_checks.promise_three_columns(
    _STREET_CASE,
    "works_on_three_columns",
    hint="Select x and y as cloud[:, 0] and cloud[:, 1]. Then it does not matter how many "
    "columns follow.",
)
common_checks.promise_few_points(
    _STREET_CASE,
    "works_on_few_points",
    title="Works on a single point and on an empty cloud",
    why="A filter may leave no points, and that must not crash the program.",
)
common_checks.promise_untouched(
    _STREET_CASE,
    "leaves_its_input",
    why="The next step still needs the original cloud.",
    hint="Write x**2, which makes a new array. x **= 2 and x *= x change the cloud.",
)


@note_check(
    "horizontal_distance",
    title="Returns a NumPy array of distances",
    why="A later cell compares all distances with a number at once, which does not work with a "
    "list.",
)
def gives_an_array(horizontal_distance: Callable) -> None:
    _assert_array(horizontal_distance(_FLAT.copy()))


def _assert_array(answer: object) -> None:
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(f"The function returned a value of type {type(answer).__name__}.")


# Clouds and their distances, keyed by the number of points. Each common mistake gives a wrong
# answer for both clouds.
_CLOUDS = {
    3: parse_table("5 12 0.6 0.7; 3 -4 1.2 0.9; -8 6 -1.7 0.3"),
    5: parse_table("-4 -3 2.2 0.5; 8 -15 -1.5 0.8; -12 5 0.9 0.2; 6 8 -0.7 0.6; -7 24 3.1 0.4"),
}
_CLOUD_DISTANCES = {
    3: frozen(np.array([13.0, 5.0, 10.0])),
    5: frozen(np.array([5.0, 17, 13, 10, 25])),
}


def _lengths(vectors: np.ndarray) -> np.ndarray:
    return np.array([math.hypot(*vector) for vector in vectors.tolist()])


def _square_roots(values: np.ndarray) -> np.ndarray:
    """Return square roots; NaN, without a warning, for negative values."""
    return np.where(values < 0, np.nan, np.sqrt(np.abs(values)))


declare_mistakes(
    "horizontal_distance",
    Mistake(
        "The function returns the lengths of (x, y, z), which include the height.",
        lambda right, cloud: np.sqrt(right**2 + cloud[:, 2] ** 2),
        "Use only the first two columns, x and y.",
        is_the_task=True,
    ),
    Mistake(
        "The function returns the lengths of whole rows, which include height and intensity.",
        lambda right, cloud: np.sqrt(right**2 + (cloud[:, 2:] ** 2).sum(axis=1)),
        "Use only the first two columns, x and y.",
        is_the_task=True,
    ),
    Mistake(
        "The function returns squared distances: the square root is missing.",
        lambda right, cloud: right**2,
    ),
    Mistake(
        "The function doubles x and y instead of squaring them.",
        lambda right, cloud: _square_roots(2 * cloud[:, :2].sum(axis=1)),
        "x*2 is twice x. Write x**2 for the square of x.",
    ),
    Mistake(
        "The function returns |x| + |y|, which is too large unless x or y is 0.",
        lambda right, cloud: np.sqrt(right**2 + 2 * np.abs(cloud[:, 0] * cloud[:, 1])),
        "Square x and y, add the squares and take the square root of the sum.",
        is_cheap=True,
    ),
    Mistake(
        "The function returns the larger of |x| and |y|.",
        lambda right, cloud: np.abs(cloud[:, :2]).max(axis=1),
        "Square x and y, add the squares and take the square root of the sum.",
        is_cheap=True,
    ),
    Mistake(
        "The function returns |x|, but a point to the side can also be far away.",
        lambda right, cloud: np.abs(cloud[:, 0]),
        "Square x and y, add the squares and take the square root of the sum.",
        is_cheap=True,
    ),
    Mistake(
        "The function returns the lengths of (y, z). Columns are numbered from 0: x is cloud[:, "
        "0].",
        lambda right, cloud: np.sqrt(right**2 - cloud[:, 0] ** 2 + cloud[:, 2] ** 2),
    ),
    Mistake(
        "The distances of points behind the sensor are negative.",
        lambda right, cloud: np.where(cloud[:, 0] < 0, -right, right),
        "Do not change the sign of the square root: a distance is never negative.",
    ),
    Mistake(
        "cloud[0] and cloud[1] are the first two points, not the columns x and y.",
        lambda right, cloud: _lengths(cloud[:2].T),
        "Write cloud[:, 0] for the x of every point: all rows, column 0.",
    ),
    Mistake(
        "The function returns the lengths of the columns x and y. It should return one distance "
        "per point.",
        lambda right, cloud: _lengths(cloud.T[:2]),
        "Use axis=1, which works along each row and gives one number per point.",
    ),
    Mistake(
        "The function returns the lengths of all columns. It should return one distance per point.",
        lambda right, cloud: _lengths(cloud.T),
        "Use axis=1, which works along each row. Use only the columns x and y.",
    ),
    Mistake(
        "The function sorts the distances. They must be in the order of the points.",
        lambda right, cloud: np.sort(right),
    ),
    cases=[(cloud,) for cloud in _CLOUDS.values()],
    right=lambda cloud: _CLOUD_DISTANCES[len(cloud)],
)

# ---- drop_invalid ------------------------------------------------------------------------------

_NAN, _INF = np.nan, np.inf
# No coordinate of these points is 0, and no point has coordinates that add up to 0.
_GOOD = parse_table("6 0.5 -1.7 0.2; 0.4 5 -0.5 0.9; 7 1 3 0; 2 -3.5 1 0.4; -9 4 0.3 0.6")
_ORIGIN = parse_table("0 0 0 0; -0 0 -0 0; 0 0 0 0")
_BRIGHT_ORIGIN = frozen(_ORIGIN + np.outer([0.3, 1.0, 0.01], [0, 0, 0, 1]))
_NANS = frozen(
    np.array(
        [
            [_NAN, _NAN, _NAN, 0.1],
            [_NAN, 1.0, 2.0, 0.5],
            [4.0, _NAN, 0.5, 0.5],
            [4.0, 1.0, _NAN, 0.5],
        ]
    )
)
_INFINITE = frozen(
    np.array(
        [
            [_INF, 1.0, 0.5, 0.1],
            [3.0, -_INF, 0.5, 0.1],
            [3.0, 2.0, _INF, 0.1],
            [_INF, -_INF, _INF, 0.1],
        ]
    )
)


def _mix_rows(*lost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a shuffled cloud of good and lost rows and the mask of the good ones."""
    cloud = np.vstack([_GOOD, *lost])
    order = np.random.default_rng(4).permutation(len(cloud))
    return cloud[order], order < len(_GOOD)


def assert_drops_lost_rows(drop_invalid: Callable, *lost: np.ndarray) -> None:
    """Assert that lost rows are dropped and good rows stay.

    Parameters
    ----------
    drop_invalid : callable
    *lost : numpy.ndarray, shape (m, 4)
        Rows that must be dropped.
    """
    cloud, good = _mix_rows(*lost)
    assert_positions(drop_invalid(cloud.copy()), cloud, good, view="above")


@once_per_run
def require_lost_returns_dropped(drop_invalid: Callable) -> None:
    """Raise `NotYet` if neither of the two common kinds of lost returns is dropped.

    One kind is enough, so that a function that keeps the other kind can still pass other checks.
    """
    with precondition("the function drops lost returns and keeps the others"):
        try:
            assert_drops_lost_rows(drop_invalid, _ORIGIN)
        except CheckFailed:
            assert_drops_lost_rows(drop_invalid, _NANS)


@visible_check(
    "drop_invalid",
    weight=4,
    title="Drops returns at (0, 0, 0)",
    why="Lost returns look like an obstacle at the sensor, so the car would never stop braking.",
    hint="Compare cloud[:, :3] with 0. A return is lost if all three coordinates are 0.",
)
def drops_the_origin(drop_invalid: Callable) -> None:
    assert_drops_lost_rows(drop_invalid, _ORIGIN)


@visible_check(
    "drop_invalid",
    weight=3,
    title="Drops returns at (0, 0, 0) whatever their intensity",
    why="A scanner may give a lost return the intensity of the return before it, but there is "
    "still no obstacle at the sensor.",
    hint="Compare cloud[:, :3] with 0, not the whole row.",
)
def drops_bright_returns(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_drops_lost_rows(drop_invalid, _BRIGHT_ORIGIN)


@visible_check(
    "drop_invalid",
    weight=4,
    title="Drops rows in which any coordinate is NaN",
    why="One NaN turns the mean of the whole cloud into NaN.",
    hint="Use np.isfinite, which is True for all three coordinates of a good row. NaN is not "
    "equal to anything, so a comparison with NaN does not find it.",
)
def drops_nan(drop_invalid: Callable) -> None:
    assert_drops_lost_rows(drop_invalid, _NANS)


@visible_check(
    "drop_invalid",
    weight=2,
    title="Drops rows in which any coordinate is infinite",
    why="Some scanners report an infinite range if no echo comes back, and one such row makes the "
    "mean infinite.",
    hint="Use np.isfinite, which is False for NaN and for both infinities. np.isnan finds only "
    "NaN.",
)
def drops_infinite_rows(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_drops_lost_rows(drop_invalid, _INFINITE)


@visible_check(
    "drop_invalid",
    weight=5,
    title="Keeps good points that have a coordinate of 0",
    why="A car exactly to the left of the sensor has x = 0. It must not disappear.",
    hint="Drop a row only if all three coordinates are 0. Do not test their sum: 2 - 3 + 1 is "
    "also 0.",
)
def keeps_points_with_a_zero(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    crossing = np.array(
        [
            [0.0, 5.0, 0.4, 0.1],
            [5.0, 0.0, -0.4, 0.1],
            [4.0, -1.0, 0.0, 0.1],
            [0.0, 0.0, -1.7, 0.1],
            [0.0, 0.0, 2.3, 0.1],
            [0.0, 6.0, 0.0, 0.1],
            [3.0, 3.0, 0.0, 0.1],
            [-3.0, -3.0, 0.0, 0.1],
            [2.0, -3.0, 1.0, 0.1],
            # All coordinates of these points become 0 if they are truncated to whole numbers.
            [0.9, 0.0, 0.0, 0.1],
            [-0.9, 0.0, 0.0, 0.1],
            [0.0, 0.8, 0.0, 0.1],
            [0.0, -0.8, 0.0, 0.1],
            [0.0, 0.0, 0.7, 0.1],
            [0.0, 0.0, -0.7, 0.1],
        ]
    )
    answer = drop_invalid(crossing.copy())
    assert_positions(answer, crossing, np.ones(len(crossing), dtype=bool), view="above")


@visible_check(
    "drop_invalid",
    weight=1,
    title="Keeps points that are very close to the sensor",
    why="The nearest real point is the one that the car must brake for.",
    hint="Compare with 0, not with a small number: only a row at exactly (0, 0, 0) is a lost "
    "return.",
)
def keeps_near_points(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    near = frozen(_GOOD * [0.01, 0.01, 0.01, 1])
    answer = drop_invalid(near.copy())
    assert_positions(answer, near, np.ones(len(near), dtype=bool), view="above")


@visible_check(
    "drop_invalid",
    weight=1,
    title="Keeps points whose intensity is NaN, infinite or 0",
    why="Some scanners measure the position of an echo but not its strength, and the car must "
    "still brake for such a point.",
    hint="Test only cloud[:, :3], then index the whole cloud with the mask.",
)
def allows_missing_intensity(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    cloud = _GOOD.copy()
    cloud[:3, 3] = _NAN, _INF, 0.0
    assert_positions(
        drop_invalid(cloud.copy()), cloud, np.ones(len(cloud), dtype=bool), view="above"
    )


@visible_check(
    "drop_invalid",
    weight=5,
    title="Keeps the intensity of each point",
    why="The intensity distinguishes a number plate from a bush, and later steps cannot restore "
    "it.",
    hint="Make the masks from cloud[:, :3] and index the whole cloud with them: cloud[mask].",
)
def keeps_the_intensity(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_all_columns(drop_invalid(_GOOD.copy()), _GOOD, np.ones(len(_GOOD), dtype=bool))


@visible_check(
    "drop_invalid",
    weight=1,
    title="Keeps duplicates and the order of the good rows",
    why="Other arrays, such as the true object of each return, are in the same order as the rows.",
    hint="Index with a mask, cloud[mask], which keeps the order and the duplicates. Do not sort "
    "the rows.",
)
def keeps_the_order(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    twice = _GOOD[[0, 1, 1, 2, 0, 3, 4]]
    assert_order(drop_invalid(twice.copy()), twice, np.ones(len(twice), dtype=bool))


@visible_check(
    "drop_invalid",
    weight=1,
    title="Accepts three columns as well as four",
    why="Some recordings contain no intensity, and their lost returns must disappear too.",
    hint="Select the coordinates with cloud[:, :3], which works with and without an intensity. "
    "cloud[:, :-1] works only with one.",
)
def works_on_three_columns(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    cloud, _ = _mix_rows(_ORIGIN, _NANS)
    four = as_array(drop_invalid(cloud.copy()))[:, :3]
    three = as_array(drop_invalid(cloud[:, :3].copy()), columns=3)
    if not np.array_equal(three, four, equal_nan=True):
        raise CheckFailed(
            "Without the intensity column, the function keeps different rows.",
            yours=f"{len(three)} of {len(cloud)} rows",
            expected=f"the same {len(four)} rows as with the intensity",
        )


@visible_check(
    "drop_invalid",
    weight=1,
    title="Works on an empty cloud and on a cloud without good rows",
    why="A sensor covered with snow reports only lost returns, and that must not crash the "
    "program.",
    hint="Use the same masks for every cloud, without a special case.",
)
def works_on_empty_clouds(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    columns = as_array(drop_invalid(_GOOD.copy())).shape[1]
    for rows in (_ORIGIN[:0], _ORIGIN):
        assert_empty_table(drop_invalid(rows.copy()), rows, columns)


_MIXED_SCAN, _IS_GOOD = frozen(_mix_rows(_ORIGIN, _NANS, _INFINITE))
common_row_checks.promise_untouched(
    Case(
        __name__,
        "drop_invalid",
        {"cloud": _MIXED_SCAN},
        _IS_GOOD,
        assert_positions,
        require_lost_returns_dropped,
    ),
    "leaves_the_scan",
    why="Lost returns can reveal a broken beam, so the original scan must keep them.",
)


@note_check(
    "drop_invalid",
    title="Returns a NumPy array of rows",
    why="Later functions select columns, as in cloud[:, 0], which does not work with a list.",
)
def gives_an_array_of_rows(drop_invalid: Callable) -> None:
    _assert_array(drop_invalid(_GOOD.copy()))


# Clouds and the indices of their good rows, keyed by the number of rows. All values of the last
# cloud are finite.
_SCANS = {
    14: frozen(
        np.array(
            [
                [3.0, 4.0, 1.0, 0.5],
                [0.0, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.6],
                [0.0, 2.0, -1.0, 0.5],
                [_NAN, 1.0, 1.0, 0.5],
                [_NAN, _NAN, _NAN, 0.5],
                [_INF, 1.0, 1.0, 0.5],
                [1.0, 2.0, -3.0, 0.5],
                [5.0, 6.0, 1.0, _NAN],
                [-4.0, 3.0, 2.0, 0.0],
                [0.0, 0.0, 0.0, _NAN],
                [2.0, -_INF, 1.0, 0.5],
                [6.0, 2.0, 0.0, 0.5],
                [7.0, 1.0, 2.0, 0.5],
            ]
        )
    ),
    9: frozen(
        np.array(
            [
                [4.0, 1.0, _NAN, 0.2],
                [8.0, 2.0, 1.0, 0.2],
                [_INF, _INF, _INF, 0.2],
                [0.0, 0.0, 0.0, 0.4],
                [0.0, 0.0, -1.7, 0.2],
                [-2.0, 1.0, 1.0, 0.2],
                [9.0, 2.0, 1.0, _INF],
                [0.0, 0.0, 0.0, 0.0],
                [1.0, 1.0, 1.0, 0.3],
            ]
        )
    ),
    6: parse_table("2 2 1 0.2; 0 0 0 0.3; 0 3 0 0.2; 0 0 0 0; 4 -5 1 0.1; 3 1 2 0.7"),
}
_GOOD_ROWS = {14: (0, 3, 7, 8, 9, 12, 13), 9: (1, 4, 5, 6, 8), 6: (0, 2, 4, 5)}


def _rows_where(cloud: np.ndarray, keep: Callable) -> np.ndarray:
    """Return the rows for which `keep([x, y, z], intensity)` is true.

    In a cloud without an intensity column, `keep` gets the intensity 1.
    """
    kept = [bool(keep(row[:3], row[3] if row[3:] else 1.0)) for row in cloud.tolist()]
    return cloud[np.array(kept, dtype=bool)]


def _is_finite(value: float) -> bool:
    return math.isfinite(value)


declare_mistakes(
    "drop_invalid",
    Mistake(
        "Nothing is dropped: the function returns the whole cloud.",
        lambda right, cloud: cloud,
        "Index the cloud with both masks. A good row must satisfy both, so combine them with `&`; "
        "with `|`, one is enough.",
        is_cheap=True,
    ),
    Mistake(
        "The function keeps returns at (0, 0, 0).",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: all(map(_is_finite, xyz))),
        "Drop the rows in which all three coordinates are 0. Find them with (... == "
        "0).all(axis=1).",
    ),
    Mistake(
        "The function keeps rows with NaN or infinity and drops only rows at (0, 0, 0).",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: any(xyz)),
        "In a good row, all three coordinates are finite. Find these rows with "
        "np.isfinite(...).all(axis=1).",
    ),
    Mistake(
        "The function drops rows with NaN but keeps rows with an infinite coordinate.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(xyz) and not any(map(math.isnan, xyz))
        ),
        "Use np.isfinite, which is False for NaN and for both infinities.",
    ),
    Mistake(
        "The function drops rows with NaN but keeps rows with an infinite coordinate and rows at "
        "(0, 0, 0).",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: not any(map(math.isnan, xyz))),
        "Use np.isfinite, which is False for NaN and for both infinities. Also drop the rows in "
        "which all three coordinates are 0.",
    ),
    Mistake(
        "The function drops a row if any of its coordinates is 0.",
        lambda right, cloud: _rows_where(right, lambda xyz, _: all(xyz)),
        "Drop a row only if all three coordinates are 0.",
    ),
    Mistake(
        "The function drops a row at (0, 0, 0) only if its intensity is also 0.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, intensity: all(map(_is_finite, xyz)) and (any(xyz) or intensity != 0)
        ),
        "Compare cloud[:, :3] with 0, not the whole row.",
    ),
    Mistake(
        "The function drops good points whose intensity is NaN or infinite.",
        lambda right, cloud: _rows_where(right, lambda xyz, intensity: _is_finite(intensity)),
        "Test only cloud[:, :3].",
    ),
    Mistake(
        "Both masks test the intensity as if it were a coordinate.",
        lambda right, cloud: _rows_where(
            cloud,
            lambda xyz, intensity: (
                all(map(_is_finite, (*xyz, intensity))) and any((*xyz, intensity))
            ),
        ),
        "Test only cloud[:, :3].",
    ),
    Mistake(
        "The function drops good points whose coordinates add up to 0.",
        lambda right, cloud: _rows_where(right, lambda xyz, _: sum(xyz) != 0),
        "Compare each of the three coordinates with 0.",
    ),
    Mistake(
        "The function drops a row with NaN or infinity only if none of its coordinates is finite.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(map(_is_finite, xyz)) and any(xyz)
        ),
        "All three coordinates of a good row are finite: use .all(axis=1), not .any(axis=1).",
    ),
    Mistake(
        "The function returns the lost rows and drops the good ones.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: not (all(map(_is_finite, xyz)) and any(xyz))
        ),
        "~ inverts a mask: add the missing ~, or delete the extra one.",
    ),
    Mistake(
        "The function drops a row with NaN only if all three coordinates are NaN.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(xyz) and not all(map(math.isnan, xyz))
        ),
        "~ inverts everything after it, including `.all(axis=1)`. Write "
        "np.isfinite(xyz).all(axis=1) without ~.",
    ),
    Mistake(
        "The function keeps the returns at (0, 0, 0) and drops the points.",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: not any(xyz)),
        "~ inverts a mask: add the missing ~, or delete the extra one.",
    ),
    Mistake(
        "The function returns the coordinates without the intensity. It should return whole rows.",
        lambda right, cloud: right[:, :3],
        "Make the mask from cloud[:, :3] and index the whole cloud with it.",
    ),
    Mistake(
        "`cloud != nan` is True for every number, even for NaN. Indexing with a mask of the "
        "cloud's shape returns all numbers in one long row.",
        lambda right, cloud: cloud.reshape(-1),
        "Use np.isfinite and .all(axis=1), which make a mask with one entry per row.",
        is_cheap=True,
    ),
    *(
        Mistake(
            f"The mask tests whether each number {test}. It has the shape of the cloud, so "
            "indexing with it returns the selected numbers in one long row.",
            lambda right, cloud, passes=passes: np.array(list(filter(passes, cloud.flat))),
            "Add .all(axis=1) to get a mask with one entry per row.",
        )
        for test, passes in {
            "is finite": _is_finite,
            "is not NaN": lambda value: not math.isnan(value),
            "is not 0": lambda value: value != 0,
            "is finite and not 0": lambda value: _is_finite(value) and value != 0,
            "is neither NaN nor 0": lambda value: not math.isnan(value) and value != 0,
        }.items()
    ),
    Mistake(
        "The mask is a single True or False for the whole cloud, because axis=1 is missing.",
        lambda right, cloud: cloud[None][: int(np.isfinite(cloud[:, :3]).all())],
        "Write .all(axis=1), which works along each row and gives one entry per row.",
    ),
    Mistake(
        "The function drops all rows if one of them has NaN or infinity: its mask of finite rows "
        "is a single True or False.",
        lambda right, cloud: right[: len(right) * int(np.isfinite(cloud[:, :3]).all())],
        "Write .all(axis=1), which works along each row and gives one entry per row.",
    ),
    cases=[(cloud,) for cloud in _SCANS.values()],
    right=lambda cloud: cloud[list(_GOOD_ROWS[len(cloud)])],
)
