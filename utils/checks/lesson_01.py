"""Visible checks of lesson 01: `horizontal_distance` and `drop_invalid`."""

import math
from collections.abc import Callable

import numpy as np

from utils.checks import common_checks, common_row_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    as_array,
    assert_all_columns,
    assert_nothing_left,
    assert_order,
    assert_places,
    distinct_texts,
    frozen,
    in_shape,
    metres_text,
    needs,
    point_text,
    table,
)
from utils.checks.common_checks import Case
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.run_cache import once

# ---- horizontal_distance -----------------------------------------------------------------------

# Points level with the sensor, with intensity 0. Their distances are whole numbers (3-4-5 triangles
# and the like).
_FLAT = table("3 4 0 0; -6 8 0 0; 5 -12 0 0; 0 7 0 0; -2 0 0 0")
_DISTANCES = frozen(np.array([5.0, 10.0, 13.0, 7.0, 2.0]))
# The same points with other intensities, and at heights from the road up to the treetops.
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
    yours = as_array(answer, what="an array of distances")
    each_point = "the only point" if len(cloud) == 1 else f"each of the {len(cloud)} points"
    yours = in_shape(yours, expected.shape, f"one distance for {each_point}")
    wrong = np.flatnonzero(~np.isclose(yours, expected, rtol=0, atol=TOLERANCE).reshape(-1))
    if len(wrong):
        verb = "is" if len(wrong) == 1 else "are"
        mine, right = distinct_texts(metres_text, yours[wrong[0]], expected[wrong[0]])
        raise CheckFailed(
            f"{len(wrong)} of {len(cloud)} distances {verb} wrong.",
            given=f"a point at {point_text(cloud[wrong[0]])}",
            yours=mine,
            expected=right,
        )


@once
def require_level_distances(horizontal_distance: Callable) -> None:
    """Assert that distances of points level with the sensor are right; raise `NotYet` if not."""
    with needs("points level with the sensor are measured right"):
        assert_distances(horizontal_distance(_FLAT.copy()), _FLAT, _DISTANCES)


@once
def require_street_distances(horizontal_distance: Callable) -> None:
    """Assert that distances of points at various heights are right; raise `NotYet` if not."""
    with needs("the distances of points high and low are right"):
        assert_distances(horizontal_distance(_AT_ALL_HEIGHTS.copy()), _AT_ALL_HEIGHTS, _DISTANCES)


@visible(
    "horizontal_distance",
    weight=1,
    title="The distance of points level with the sensor",
    why="Every later lesson asks which points are near.",
    hint="The root of x² + y², for whole columns: x = cloud[:, 0], y = cloud[:, 1].",
)
def measures_distance(horizontal_distance: Callable) -> None:
    assert_distances(horizontal_distance(_FLAT.copy()), _FLAT, _DISTANCES)


@visible(
    "horizontal_distance",
    weight=5,
    title="Height does not count",
    why="The foot and the lamp of a lamp post are equally far to drive.",
    hint="Of the coordinates use x and y only, the columns 0 and 1.",
)
def ignores_height(horizontal_distance: Callable) -> None:
    require_level_distances(horizontal_distance)
    assert_distances(horizontal_distance(_AT_ALL_HEIGHTS.copy()), _AT_ALL_HEIGHTS, _DISTANCES)


@visible(
    "horizontal_distance",
    weight=1,
    title="Intensity does not count",
    why="A bright number plate is no farther than a dark tyre.",
    hint="The last column is no length: use the columns 0 and 1 only.",
)
def ignores_intensity(horizontal_distance: Callable) -> None:
    require_level_distances(horizontal_distance)
    assert_distances(
        horizontal_distance(_AT_ALL_INTENSITIES.copy()), _AT_ALL_INTENSITIES, _DISTANCES
    )


@visible(
    "horizontal_distance",
    weight=1,
    title="Distances are as exact as the coordinates",
    why="Each step of a pipeline adds its own errors. Rounding is for texts that people read.",
    hint="Return the numbers as they are, without round.",
)
def is_exact(horizontal_distance: Callable) -> None:
    require_street_distances(horizontal_distance)
    cloud = np.array([[1.0, 1.0, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0]])
    assert_distances(horizontal_distance(cloud.copy()), cloud, np.array([1.41421356, 2.23606798]))


_STREET_CASE = Case(
    __name__,
    "horizontal_distance",
    {"cloud": _AT_ALL_HEIGHTS},
    expected=_DISTANCES,
    compare=assert_distances,
    precondition=require_street_distances,
)
common_checks.three_columns(
    _STREET_CASE,
    "takes_three_columns",
    hint="Take x and y by their numbers, cloud[:, 0] and cloud[:, 1]: it does not matter then how "
    "many columns follow.",
)
common_checks.few_points(
    _STREET_CASE,
    "takes_few_points",
    title="Takes one point and none",
    why="After a filter nothing may be left.",
)
common_checks.untouched(
    _STREET_CASE,
    "leaves_its_input",
    why="The next step of the pipeline still needs the cloud.",
    hint="x**2 makes a new array; x **= 2 and x *= x write into the cloud.",
)


@noted(
    "horizontal_distance",
    title="The distances are an array",
    why="A later cell compares all of it with a number at once, which a list cannot do.",
)
def gives_an_array(horizontal_distance: Callable) -> None:
    _assert_array(horizontal_distance(_FLAT.copy()))


def _assert_array(answer: object) -> None:
    if not isinstance(answer, np.ndarray):
        raise CheckFailed(f"The answer is of type {type(answer).__name__}.")


# Clouds and their distances, keyed by the number of points. Every usual mistake changes the answer
# for both clouds.
_CLOUDS = {
    3: table("5 12 0.6 0.7; 3 -4 1.2 0.9; -8 6 -1.7 0.3"),
    5: table("-4 -3 2.2 0.5; 8 -15 -1.5 0.8; -12 5 0.9 0.2; 6 8 -0.7 0.6; -7 24 3.1 0.4"),
}
_CLOUD_DISTANCES = {
    3: frozen(np.array([13.0, 5.0, 10.0])),
    5: frozen(np.array([5.0, 17, 13, 10, 25])),
}


def _lengths(vectors: np.ndarray) -> np.ndarray:
    return np.array([math.hypot(*vector) for vector in vectors.tolist()])


mistakes(
    "horizontal_distance",
    Mistake(
        "These are lengths of x, y, z: the height is mixed in.",
        lambda right, cloud: np.sqrt(right**2 + cloud[:, 2] ** 2),
        "Use the first two columns only, the ones of x and y.",
        is_the_task=True,
    ),
    Mistake(
        "These are lengths of whole rows: height and intensity are mixed in.",
        lambda right, cloud: np.sqrt(right**2 + (cloud[:, 2:] ** 2).sum(axis=1)),
        "Use the first two columns only, the ones of x and y.",
        is_the_task=True,
    ),
    Mistake(
        "These are squared distances: the square root is missing.",
        lambda right, cloud: right**2,
    ),
    Mistake(
        "These are |x| + |y|, the way around the corner.",
        lambda right, cloud: np.sqrt(right**2 + 2 * np.abs(cloud[:, 0] * cloud[:, 1])),
        "Square both, add, and take the root of the sum.",
        is_cheap=True,
    ),
    Mistake(
        "This is the larger of |x| and |y|.",
        lambda right, cloud: np.abs(cloud[:, :2]).max(axis=1),
        "Square both, add, and take the root of the sum.",
        is_cheap=True,
    ),
    Mistake(
        "This is |x| alone; a point to the side is far away, too.",
        lambda right, cloud: np.abs(cloud[:, 0]),
        "Square x and y, add, and take the root.",
        is_cheap=True,
    ),
    Mistake(
        "These are lengths of y and z. Columns are counted from 0: x is cloud[:, 0].",
        lambda right, cloud: np.sqrt(right**2 - cloud[:, 0] ** 2 + cloud[:, 2] ** 2),
    ),
    Mistake(
        "The distances of points behind the sensor are negative.",
        lambda right, cloud: np.where(cloud[:, 0] < 0, -right, right),
        "A distance has no direction.",
    ),
    Mistake(
        "cloud[0] and cloud[1] are the first two rows, that is two points.",
        lambda right, cloud: _lengths(cloud[:2].T),
        "A column is cloud[:, 0]: all rows, column 0.",
    ),
    Mistake(
        "The lengths are taken down the columns, over all points.",
        lambda right, cloud: _lengths(cloud.T[:2]),
        "axis=1 goes along a row, and gives one number for each point.",
    ),
    Mistake(
        "The lengths are taken down all columns, over all points.",
        lambda right, cloud: _lengths(cloud.T),
        "axis=1 goes along a row, and gives one number for each point. Take the columns of x and y "
        "only.",
    ),
    Mistake(
        "The distances are sorted; the one of each point has to keep the point's place.",
        lambda right, cloud: np.sort(right),
    ),
    cases=[(cloud,) for cloud in _CLOUDS.values()],
    right=lambda cloud: _CLOUD_DISTANCES[len(cloud)],
)

# ---- drop_invalid ------------------------------------------------------------------------------

_NAN, _INF = np.nan, np.inf
# No coordinate of these points is 0, and no sum of the coordinates of a point is.
_GOOD = table("6 0.5 -1.7 0.2; 0.4 5 -0.5 0.9; 7 1 3 0; 2 -3.5 1 0.4; -9 4 0.3 0.6")
_ORIGIN = table("0 0 0 0; -0 0 -0 0; 0 0 0 0")
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


def _mixed(*lost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a shuffled cloud of good and lost rows, and the mask of its good rows."""
    cloud = np.vstack([_GOOD, *lost])
    order = np.random.default_rng(4).permutation(len(cloud))
    return cloud[order], order < len(_GOOD)


def assert_drops(drop_invalid: Callable, *lost: np.ndarray) -> None:
    """Assert that lost rows are dropped and good rows stay.

    Parameters
    ----------
    drop_invalid : callable
    *lost : numpy.ndarray, shape (m, 4)
        Rows that must be dropped.
    """
    cloud, good = _mixed(*lost)
    assert_places(drop_invalid(cloud.copy()), cloud, good, view="above")


@once
def require_lost_returns_dropped(drop_invalid: Callable) -> None:
    """Assert that one of the two common kinds of lost returns is dropped; raise `NotYet` if not.

    One kind is enough, so that a function which misses the other kind can still pass other checks.
    """
    with needs("lost returns go and the others stay"):
        try:
            assert_drops(drop_invalid, _ORIGIN)
        except CheckFailed:
            assert_drops(drop_invalid, _NANS)


@visible(
    "drop_invalid",
    weight=4,
    title="Drops returns at (0, 0, 0)",
    why="They look like an obstacle inside the sensor: the car would brake without end.",
    hint="Compare the coordinates with 0. A row is lost when all three are 0.",
)
def drops_the_origin(drop_invalid: Callable) -> None:
    assert_drops(drop_invalid, _ORIGIN)


@visible(
    "drop_invalid",
    weight=3,
    title="Drops returns at (0, 0, 0) whatever their intensity",
    why="A lost echo may come with the brightness of the one before.",
    hint="Compare cloud[:, :3] with 0, not the whole row.",
)
def drops_bright_ones(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_drops(drop_invalid, _BRIGHT_ORIGIN)


@visible(
    "drop_invalid",
    weight=4,
    title="Drops rows with a coordinate that is NaN",
    why="One NaN turns a mean, a box or a whole map into NaN.",
    hint="A good row is finite in all three coordinates: np.isfinite tells. NaN is not equal to "
    "anything, so comparing does not find it.",
)
def drops_nan(drop_invalid: Callable) -> None:
    assert_drops(drop_invalid, _NANS)


@visible(
    "drop_invalid",
    weight=2,
    title="Drops rows with a coordinate that is infinite",
    why="Some scanners write an infinite range where no echo came back.",
    hint="np.isfinite is False for NaN and for both infinities; np.isnan knows NaN alone.",
)
def drops_what_is_infinite(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_drops(drop_invalid, _INFINITE)


@visible(
    "drop_invalid",
    weight=5,
    title="Keeps good points with a 0 among their coordinates",
    why="A car exactly to the left has x = 0. It must not vanish for that.",
    hint="One coordinate of 0 is fine; all three are not. Their sum says little: "
    "2 - 3 + 1 is 0, too.",
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
            # These rows become all zeros when they are rounded down or up to whole numbers.
            [0.9, 0.0, 0.0, 0.1],
            [-0.9, 0.0, 0.0, 0.1],
            [0.0, 0.8, 0.0, 0.1],
            [0.0, -0.8, 0.0, 0.1],
            [0.0, 0.0, 0.7, 0.1],
            [0.0, 0.0, -0.7, 0.1],
        ]
    )
    answer = drop_invalid(crossing.copy())
    assert_places(answer, crossing, np.ones(len(crossing), dtype=bool), view="above")


@visible(
    "drop_invalid",
    weight=1,
    title="Keeps points that are merely close to the sensor",
    why="The nearest real point is the one that a car must brake for.",
    hint="Only exactly (0, 0, 0) is a lost return: compare with 0, not with a small number.",
)
def keeps_near_points(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    near = frozen(_GOOD * [0.01, 0.01, 0.01, 1])
    answer = drop_invalid(near.copy())
    assert_places(answer, near, np.ones(len(near), dtype=bool), view="above")


@visible(
    "drop_invalid",
    weight=1,
    title="A missing intensity does no harm",
    why="Some scanners report the place of an echo but not its strength.",
    hint="Look at cloud[:, :3] only, and then index the whole cloud with the mask.",
)
def allows_missing_intensity(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    cloud = _GOOD.copy()
    cloud[:3, 3] = _NAN, _INF, 0.0
    assert_places(drop_invalid(cloud.copy()), cloud, np.ones(len(cloud), dtype=bool), view="above")


@visible(
    "drop_invalid",
    weight=5,
    title="Keeps all columns: the intensity stays with its point",
    why="Intensity tells a number plate from a bush, and later steps cannot get it back.",
    hint="Make the masks from cloud[:, :3], and index the whole cloud with them, cloud[mask].",
)
def keeps_the_intensity(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    assert_all_columns(drop_invalid(_GOOD.copy()), _GOOD, np.ones(len(_GOOD), dtype=bool))


@visible(
    "drop_invalid",
    weight=1,
    title="Keeps every good row in its place, one that is there twice, too",
    why="Whoever knows the true object of each return finds it by its place among the rows.",
    hint="A mask keeps order and number by itself: sort nothing, and collect nothing.",
)
def keeps_the_order(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    twice = _GOOD[[0, 1, 1, 2, 0, 3, 4]]
    assert_order(drop_invalid(twice.copy()), twice, np.ones(len(twice), dtype=bool))


@visible(
    "drop_invalid",
    weight=1,
    title="Takes three columns as well as four",
    why="Some files hold no intensity.",
    hint="cloud[:, :3] are the coordinates, whether or not a column follows; cloud[:, :-1] are "
    "them only where one does.",
)
def takes_three_columns_of_a_scan(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    cloud, _ = _mixed(_ORIGIN, _NANS)
    four = as_array(drop_invalid(cloud.copy()))[:, :3]
    three = as_array(drop_invalid(cloud[:, :3].copy()), columns=3)
    if not np.array_equal(three, four, equal_nan=True):
        raise CheckFailed(
            "Of the same rows without their intensity, others are left.",
            yours=f"{len(three)} of {len(cloud)} rows",
            expected=f"the same {len(four)} as with intensity",
        )


@visible(
    "drop_invalid",
    weight=1,
    title="Takes an empty cloud, and one without a good row",
    why="A sensor under snow returns nothing but lost echoes.",
    hint="The same masks serve every case: no special case is needed.",
)
def takes_an_empty_scan(drop_invalid: Callable) -> None:
    require_lost_returns_dropped(drop_invalid)
    columns = as_array(drop_invalid(_GOOD.copy())).shape[1]
    for rows in (_ORIGIN[:0], _ORIGIN):
        assert_nothing_left(drop_invalid(rows.copy()), rows, columns)


_MIXED_SCAN, _IS_GOOD = frozen(_mixed(_ORIGIN, _NANS, _INFINITE))
common_row_checks.untouched(
    Case(
        __name__,
        "drop_invalid",
        {"cloud": _MIXED_SCAN},
        _IS_GOOD,
        assert_places,
        require_lost_returns_dropped,
    ),
    "leaves_the_scan",
    why="Whoever looks for a broken beam needs the lost returns.",
)


@noted(
    "drop_invalid",
    title="The rows are an array",
    why="The next functions take its columns, cloud[:, 0], which a list does not have.",
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
    6: table("2 2 1 0.2; 0 0 0 0.3; 0 3 0 0.2; 0 0 0 0; 4 -5 1 0.1; 3 1 2 0.7"),
}
_GOOD_ROWS = {14: (0, 3, 7, 8, 9, 12, 13), 9: (1, 4, 5, 6, 8), 6: (0, 2, 4, 5)}


def _rows_where(cloud: np.ndarray, keep: Callable) -> np.ndarray:
    """Return the rows for which `keep`, called with x, y, z as a list and the intensity, is true.

    The intensity of a row without one is 1.
    """
    kept = [bool(keep(row[:3], row[3] if row[3:] else 1.0)) for row in cloud.tolist()]
    return cloud[np.array(kept, dtype=bool)]


def _is_finite(value: float) -> bool:
    return math.isfinite(value)


mistakes(
    "drop_invalid",
    Mistake(
        "Nothing is dropped: the rows come back as they went in.",
        lambda right, cloud: cloud,
        "Index the cloud with both masks. A good row fulfils both, `&`; with `|` one is enough.",
        is_cheap=True,
    ),
    Mistake(
        "Returns at (0, 0, 0) stay.",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: all(map(_is_finite, xyz))),
        "In a lost row all three coordinates are 0: (... == 0).all(axis=1) tells, row by row.",
    ),
    Mistake(
        "Rows with coordinates that are not finite stay; only those at (0, 0, 0) go.",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: any(xyz)),
        "In a good row all three coordinates are finite: np.isfinite tells, number by number.",
    ),
    Mistake(
        "Rows with an infinite coordinate stay; those with NaN go.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(xyz) and not any(map(math.isnan, xyz))
        ),
        "np.isfinite is False for NaN and for both infinities.",
    ),
    Mistake(
        "Rows with NaN go; rows with an infinite coordinate stay, and those at (0, 0, 0), too.",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: not any(map(math.isnan, xyz))),
        "np.isfinite is False for NaN and for both infinities. In a row at (0, 0, 0) all three "
        "coordinates are 0.",
    ),
    Mistake(
        "A row goes as soon as one of its coordinates is 0.",
        lambda right, cloud: _rows_where(right, lambda xyz, _: all(xyz)),
        "Only a row in which all three are 0 is lost.",
    ),
    Mistake(
        "A row at (0, 0, 0) goes only if its intensity is 0, too.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, intensity: all(map(_is_finite, xyz)) and (any(xyz) or intensity != 0)
        ),
        "Compare cloud[:, :3] with 0, not the whole row.",
    ),
    Mistake(
        "Good points go because their intensity is not finite.",
        lambda right, cloud: _rows_where(right, lambda xyz, intensity: _is_finite(intensity)),
        "Look at cloud[:, :3] only.",
    ),
    Mistake(
        "Intensity is looked at as if it were a coordinate, in both masks.",
        lambda right, cloud: _rows_where(
            cloud,
            lambda xyz, intensity: (
                all(map(_is_finite, (*xyz, intensity))) and any((*xyz, intensity))
            ),
        ),
        "Look at cloud[:, :3] only.",
    ),
    Mistake(
        "Good points go because their coordinates add up to 0.",
        lambda right, cloud: _rows_where(right, lambda xyz, _: sum(xyz) != 0),
        "Ask whether all three are 0, each by itself.",
    ),
    Mistake(
        "A row that is not finite goes only if all three coordinates are not.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(map(_is_finite, xyz)) and any(xyz)
        ),
        "A good row is finite in all three coordinates: .all(axis=1), not .any(axis=1).",
    ),
    Mistake(
        "It is the lost returns that come back, and the good ones that go.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: not (all(map(_is_finite, xyz)) and any(xyz))
        ),
        "~ turns a mask around.",
    ),
    Mistake(
        "A row with NaN goes only if all three coordinates are NaN; those at (0, 0, 0) go.",
        lambda right, cloud: _rows_where(
            cloud, lambda xyz, _: any(xyz) and not all(map(math.isnan, xyz))
        ),
        "~ turns around what stands behind it, `.all(axis=1)` included: "
        "np.isfinite(xyz).all(axis=1) says it without.",
    ),
    Mistake(
        "It is the returns at (0, 0, 0) that stay, and the points that go.",
        lambda right, cloud: _rows_where(cloud, lambda xyz, _: not any(xyz)),
        "~ turns a mask around.",
    ),
    Mistake(
        "The coordinates alone are returned, without the intensity.",
        lambda right, cloud: right[:, :3],
        "Make the mask from cloud[:, :3], and index the whole cloud with it.",
    ),
    Mistake(
        "`cloud != nan` is True for every number, NaN included, and as a mask of the cloud's own "
        "shape it lays all numbers in one long row.",
        lambda right, cloud: cloud.reshape(-1),
        "np.isfinite and .all(axis=1) make a mask with one entry for each row.",
    ),
    *(
        Mistake(
            f"The mask asks each number whether it {test}: it has the cloud's own shape, and lays "
            "the numbers that pass in one long row.",
            lambda right, cloud, passes=passes: np.array(list(filter(passes, cloud.flat))),
            ".all(axis=1) makes of it a mask with one entry for each row.",
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
        "The masks hold one True or False for the whole cloud: axis=1 is missing in both.",
        lambda right, cloud: cloud[None][: int(np.isfinite(cloud[:, :3]).all())],
        ".all(axis=1) goes along the rows and gives one entry for each.",
    ),
    Mistake(
        "One lost row and all rows go: the mask of what is finite holds one True or False for the "
        "whole cloud.",
        lambda right, cloud: right[: len(right) * int(np.isfinite(cloud[:, :3]).all())],
        ".all(axis=1) goes along the rows and gives one entry for each.",
    ),
    cases=[(cloud,) for cloud in _SCANS.values()],
    right=lambda cloud: cloud[list(_GOOD_ROWS[len(cloud)])],
)
