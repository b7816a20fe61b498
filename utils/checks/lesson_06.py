"""Visible checks of lesson 06: `filter_ground` and `voxel_grid`."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

import utils
from utils.checks import common_checks, common_row_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    WrongForm,
    as_array,
    assert_empty_table,
    assert_positions,
    distinct_texts,
    frozen,
    parse_table,
    points_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.failures import fixed
from utils.checks.run_cache import once_per_run

# Returns from the road about 1.7 m below the sensor, a bumper, a kerb, a door, a roof and a sign.
_GROUND_CLOUD = parse_table(
    "6 0.5 -1.73 0.2; 6.2 0.5 -0.9 0.9; 8 -2 -1.58 0.3; 8.1 -2 -1.15 0.4; 9 3 0.1 0.6; "
    "9.5 3 -1.7 0.1; 4 1 1.4 0.8"
)
_IS_ABOVE = frozen(np.array([False, True, False, True, True, False, True]))


def assert_no_ground_left(
    answer: object, cloud: np.ndarray, keep: np.ndarray, level: float
) -> None:
    """Assert that the right points are left; their order and intensity are ignored.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    keep : numpy.ndarray of bool, shape (n,)
        True for the points that stay.
    level : float
        The ground level that the function was given, in metres, for the message.
    """
    is_small = len(cloud) <= 12
    try:
        assert_positions(
            answer,
            cloud,
            keep,
            input_text=f"{_heights_text(cloud)}, ground_level {level:g}" if is_small else None,
            points_to_text=_heights_text if is_small else None,
        )
    except CheckFailed as failure:
        if draw := failure.draw:
            failure.draw = lambda: utils.plots.clouds.mark_level(draw(), level)
        raise


def _heights_text(points: np.ndarray) -> str:
    texts = [f"{height:.4g}" for height in points[:, 2].tolist()]
    return f"heights {', '.join(texts)}" if texts else "no rows"


@once_per_run
def require_ground_removed(filter_ground: Callable) -> None:
    """Assert that road points are removed and higher ones stay; raise `NotYet` if not."""
    with precondition("points above ground_level stay and road points are removed"):
        assert_no_ground_left(
            filter_ground(_GROUND_CLOUD.copy(), -1.2), _GROUND_CLOUD, _IS_ABOVE, -1.2
        )


@visible_check(
    "filter_ground",
    weight=4,
    title="Keeps points above the ground level and removes the road",
    why="A road point that stays in the cloud looks like an obstacle, so the car brakes for "
    "asphalt.",
    hint="Compare the z column, cloud[:, 2], with ground_level. This gives one True or False per "
    "point.",
)
def keeps_points_above_the_level(filter_ground: Callable) -> None:
    assert_no_ground_left(filter_ground(_GROUND_CLOUD.copy(), -1.2), _GROUND_CLOUD, _IS_ABOVE, -1.2)


@visible_check(
    "filter_ground",
    weight=3,
    title="Uses ground_level as the threshold",
    why="On another car, the sensor may be at another height, so the function must not contain a "
    "fixed level.",
    hint="Keep a point if its z is at least ground_level. Do not write a number into the function.",
)
def uses_the_level(filter_ground: Callable) -> None:
    for level, rows_left in ((0.0, (4, 6)), (-1.65, (1, 2, 3, 4, 6)), (1.0, (6,))):
        keep = np.isin(np.arange(7), rows_left)
        assert_no_ground_left(
            filter_ground(_GROUND_CLOUD.copy(), level), _GROUND_CLOUD, keep, level
        )


_GROUND_CASE = Case(
    __name__,
    "filter_ground",
    {"cloud": _GROUND_CLOUD, "ground_level": -1.2},
    expected=_IS_ABOVE,
    compare=lambda answer, cloud, level, keep: assert_no_ground_left(answer, cloud, keep, level),
    precondition=require_ground_removed,
)


@common_checks.promise_default(
    _GROUND_CASE,
    "ground_level=-1.2",
    title="Uses a ground level of -1.2 m by default",
    why="Later cells call filter_ground(cloud) and rely on this default.",
    weight=2,
)
def keeps_the_default(filter_ground: Callable) -> None:
    cloud = np.array([[5, 1, z, 0.5] for z in (-1.23, -1.17, -1.02, -1.4)])
    keep = np.array([False, True, True, False])
    input_text = f"{_heights_text(cloud)}, ground_level not given"
    assert_positions(
        filter_ground(cloud.copy()),
        cloud,
        keep,
        input_text=input_text,
        points_to_text=_heights_text,
    )


common_checks.promise_names(
    _GROUND_CASE,
    "keeps_the_names",
    why="Other code may call filter_ground(cloud, ground_level=-1.5).",
)
common_row_checks.promise_all_columns(_GROUND_CASE, "keeps_the_columns", weight=2)
common_row_checks.promise_order(_GROUND_CASE, "keeps_the_order", weight=2)
common_checks.promise_three_columns(
    _GROUND_CASE,
    "takes_three_columns",
    hint="Compare only cloud[:, 2]. Then the number of columns does not matter.",
)
common_row_checks.promise_empty_table(
    _GROUND_CASE,
    "works_on_small_clouds",
    hint="Use the same mask for every cloud: a mask without any True selects no rows.",
    weight=2,
)
common_row_checks.promise_untouched(_GROUND_CASE, "leaves_its_input", weight=2)


@note_check(
    "filter_ground",
    title="Keeps points exactly at the ground level",
    why='The docstring says z >= ground_level, "at or above". The scan in this lesson has no '
    "point exactly at that height, but a cloud rounded to centimetres has many.",
)
def keeps_points_at_the_level(filter_ground: Callable) -> None:
    cloud = np.column_stack([np.ones((3, 2)), [-1.5, -1.25, -1.0]])
    assert_no_ground_left(filter_ground(cloud.copy(), -1.25), cloud, np.arange(3) > 0, -1.25)


common_row_checks.note_array(_GROUND_CASE, "returns_an_array")


def _rows_above(cloud: np.ndarray, values: np.ndarray, level: float) -> np.ndarray:
    return np.array([row for row, value in zip(cloud, values, strict=True) if value - level > 0])


declare_mistakes(
    "filter_ground",
    Mistake(
        "The comparison is the wrong way round: points below ground_level stay and points above "
        "it are removed.",
        lambda right, cloud, level: _rows_above(cloud, -cloud[:, 2], -level),
        "Turn the comparison round: z must be at or above ground_level.",
    ),
    Mistake(
        "Your code compares column 0, which is x. It should compare column 2, which is z.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, 0], level),
    ),
    Mistake(
        "Your code compares column 1, which is y. It should compare column 2, which is z.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, 1], level),
    ),
    Mistake(
        "Your code compares heights without their sign, so points far below the sensor count as "
        "high.",
        lambda right, cloud, level: _rows_above(cloud, np.abs(cloud[:, 2]), level),
        "Compare cloud[:, 2] unchanged. It is negative below the sensor, and so is the default "
        "ground_level.",
    ),
    Mistake(
        "The sign of ground_level is flipped: -1.2 acts like 1.2.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, 2], -level),
        "Compare with ground_level unchanged. Below the sensor, both ground_level and z are "
        "negative.",
    ),
    Mistake(
        "Your code compares the last column, which is the intensity in a cloud with four columns.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, -1], level),
        "Compare column 2, the heights, however many columns follow.",
    ),
    Mistake(
        "The level is fixed at -1.2; ground_level is ignored.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, 2], -1.2),
        "Compare the heights with ground_level.",
    ),
    Mistake(
        "The level is fixed at 0, the height of the sensor; ground_level is ignored.",
        lambda right, cloud, level: _rows_above(cloud, cloud[:, 2], 0.0),
        "Compare the heights with ground_level.",
    ),
    Mistake(
        "Your code returns only the heights of the remaining points. It should return whole rows.",
        lambda right, cloud, level: right[:, 2],
        "Index the whole cloud with the mask: cloud[mask].",
    ),
    Mistake(
        "Rows below the level are set to 0. They should be removed.",
        lambda right, cloud, level: cloud * (cloud[:, [2]] - level > 0),
        "Index with the mask: cloud[mask] contains only the rows where the mask is True.",
    ),
    Mistake(
        "Nothing is removed: the function returns the whole cloud. It should return only some of "
        "the rows.",
        lambda right, cloud, level: cloud,
        is_cheap=True,
    ),
    cases=(
        (np.array([[5, -3, -1.7], [9, 1, 0.9], [7, -1, -0.8], [-4, 3, -0.2]]), -0.5),
        (np.array([[0.2, 3, 0.3], [6, 0.1, -1.9], [-8, -2, 0.7], [9, 1, -0.6]]), 0.45),
        (np.array([[-4, 2, -1.6, 0.3], [5, -2, -1.9, 0.8], [8, 1, -1.3, 0.1]]), -1.45),
        (np.array([[3, -2, 0.35, 0.9], [-7, 4, 0.8, 0.2], [1, -5, -0.9, 0.7]]), -0.6),
        (np.array([[-3, 2, 0.25, 0.1], [7, -4, 0.9, 0.3], [-2, 1, -0.3, 0.8]]), 0.5),
    ),
    right=lambda cloud, level: _rows_above(cloud, cloud[:, 2], level),
)


# Points with positive coordinates that occupy five cells of 0.2 m, with 3, 1, 2, 1 and 1 points.
# Separate checks cover rounding to the nearest cell and starting the grid at the lowest corner of
# the cloud, so both give the right cells here. For the same reason, all points in a cell have the
# same intensity.
_CELLS = parse_table(
    "0.48 0.22 0.29 0.3; 1.02 1.03 1.08 0.7; 0.42 0.28 0.22 0.3; 0.45 0.67 0.26 0.5; "
    "0.45 0.25 0.24 0.3; 1.06 1.07 1.04 0.7; 3.47 0.28 0.25 0.2; 5.06 0.24 2.89 0.9"
)
_CENTROIDS = parse_table(
    "0.45 0.25 0.25 0.3; 0.45 0.67 0.26 0.5; 1.04 1.05 1.06 0.7; 3.47 0.28 0.25 0.2; "
    "5.06 0.24 2.89 0.9"
)


def assert_row_per_cell(answer: object, cloud: np.ndarray, number: int, size: float) -> np.ndarray:
    """Assert that there is one row per occupied cell; the values in the rows are ignored.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    number : int
        Number of occupied cells.
    size : float
        Side of a cell in metres.

    Returns
    -------
    numpy.ndarray, shape (number, 3)
        x, y and z of the answer.
    """
    yours = _xyz(answer, cloud)
    if len(yours) != number:
        raise CheckFailed(
            f"There are {'fewer' if len(yours) < number else 'more'} rows than occupied cells.",
            input_text=_call_text(cloud, size),
            yours=_row_count_text(len(yours)),
            expected=_row_count_text(number),
        )
    return yours


def assert_centroids(answer: object, cloud: np.ndarray, expected: np.ndarray, size: float) -> None:
    """Assert that the rows are the mean positions of the cells; other columns are ignored.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    expected : numpy.ndarray, shape (m, 3) or (m, 4)
        One row for each occupied cell, in any order.
    size : float
        Side of a cell in metres.
    """
    yours, right = assert_row_per_cell(answer, cloud, len(expected), size), expected[:, :3]
    if not _same_rows(yours, right):
        is_single = len(right) == 1
        mine, expected_text = distinct_texts(_points_or_count, yours, right)
        raise CheckFailed(
            "This is not the mean of the points in the cell."
            if is_single
            else "The number of rows is right, but some rows are not the mean of the points in "
            "their cell.",
            input_text=_call_text(cloud, size),
            yours=mine,
            expected=expected_text,
        )


@once_per_run
def require_row_per_cell(voxel_grid: Callable) -> None:
    """Assert that there is one point per occupied cell; raise `NotYet` if not."""
    with precondition("there is one point per occupied cell"):
        assert_row_per_cell(voxel_grid(_CELLS.copy(), 0.2), _CELLS, len(_CENTROIDS), 0.2)


def _xyz(answer: object, cloud: np.ndarray) -> np.ndarray:
    """Return x, y and z of an answer, which may lack the other columns."""
    yours, description = as_array(answer, description="an array of points"), "an array of points"
    if yours.ndim == 2 and yours.shape[1] == 3:
        return yours
    if yours.ndim == 1 and yours.size == cloud.shape[1] and yours.dtype.kind != "b":
        raise WrongForm(
            "This is a single row, not a table. Even a single centroid must be a row of a table.",
            yours=f"shape {yours.shape}",
            expected=f"shape (1, {cloud.shape[1]})",
        )
    return as_array(answer, columns=cloud.shape[1], description=description)[:, :3]


def _call_text(cloud: np.ndarray, size: float) -> str | None:
    return f"points {_points_or_count(cloud)}, cells of {size:g} m" if 0 < len(cloud) <= 8 else None


def _points_or_count(points: np.ndarray, digits: int = 2) -> str:
    return points_text(points, digits) if len(points) <= 8 else _row_count_text(len(points))


def _row_count_text(number: int) -> str:
    return f"{number} row{'s' if number != 1 else ''}"


@visible_check(
    "voxel_grid",
    weight=4,
    title="Returns one point per occupied cell",
    why="This is the purpose of a voxel grid: the number of points no longer depends on how "
    "dense the scan is.",
    hint="Compute np.floor(xyz / voxel_size), three whole numbers per point. Then find the "
    "different cells with np.unique(as_numbers(...)) or np.unique(..., axis=0).",
)
def returns_one_point_per_cell(voxel_grid: Callable) -> None:
    assert_row_per_cell(voxel_grid(_CELLS.copy(), 0.2), _CELLS, len(_CENTROIDS), 0.2)


@visible_check(
    "voxel_grid",
    weight=34,
    title="Returns the mean of the points in each cell",
    why="The mean of many noisy returns is usually closer to the surface than a single return.",
    hint="Add up the rows of each cell, and divide the sums by counts[:, None], a column with the "
    "number of points in each cell.",
)
def averages_each_cell(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    one_cell = _CELLS[[0, 2, 4]]
    assert_centroids(voxel_grid(one_cell.copy(), 0.2), one_cell, _CENTROIDS[:1], 0.2)
    assert_centroids(voxel_grid(_CELLS.copy(), 0.2), _CELLS, _CENTROIDS, 0.2)


@visible_check(
    "voxel_grid",
    weight=3,
    title="Averages all columns, including the intensity",
    why="A later step can recognise a number plate only if it is still bright after thinning.",
    hint="Add up whole rows, not only the coordinates: sums needs cloud.shape[1] columns.",
)
def averages_the_intensity(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    cloud = parse_table("0.02 0.04 0.06 0.02; 0.08 0.08 0.02 0.16; 0.08 0.06 0.04 0.12")
    yours = as_array(voxel_grid(cloud.copy(), 0.2))
    with precondition("each row is the mean of the points in its cell"):
        assert_centroids(yours, cloud, cloud.mean(axis=0, keepdims=True), 0.2)
    if yours.shape[1] != 4:
        raise CheckFailed(
            "The centroids do not have as many columns as the cloud.",
            yours=f"shape {yours.shape}",
            expected="shape (1, 4)",
        )
    if abs(yours[0, 3] - 0.1) > TOLERANCE:
        raise CheckFailed(
            "The intensity is not the mean of the intensities in the cell.",
            input_text="intensities 0.02, 0.16 and 0.12 in one cell",
            yours=f"intensity {yours[0, 3]:.2f}",
            expected="intensity 0.10",
        )


@visible_check(
    "voxel_grid",
    weight=4,
    title="Ignores the intensity when assigning points to cells",
    why="Two returns from the same place belong to the same cell, however bright they are. If "
    "intensities up to 255 counted as a coordinate, hardly any points would be merged.",
    hint="Compute the cell from x, y and z only: cloud[:, :3].",
)
def ignores_the_intensity(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    for intensities in ((0.1, 0.9, 0.5, 0.3), (40.0, 255.0, 3.0, 0.0)):
        cloud = np.column_stack([np.full((4, 3), 0.25), intensities])
        cloud[2:, 0] = 0.65
        try:
            assert_row_per_cell(voxel_grid(cloud.copy(), 0.2), cloud, 2, 0.2)
        except CheckFailed as failure:
            pairs = "intensities {:g} and {:g} at one place, {:g} and {:g} at another"
            failure.input_text = pairs.format(*intensities)
            raise


@visible_check(
    "voxel_grid",
    weight=2,
    title="Uses x, y and z to assign points to cells",
    why="Without z, a car and the bridge above it would be merged.",
    hint="Use three columns for the cell: cloud[:, :3].",
)
def uses_all_three_coordinates(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    for axis in range(3):
        cloud = np.full((3, 4), 0.25)
        cloud[:, axis] = 0.25, 1.05, 3.45
        assert_row_per_cell(voxel_grid(cloud.copy(), 0.2), cloud, 3, 0.2)


@visible_check(
    "voxel_grid",
    weight=3,
    title="Makes the cells next to zero as large as all others",
    why="Half of the street has negative coordinates, and rounding towards zero makes the cells "
    "around the sensor twice as wide.",
    hint="Use np.floor: np.floor(-0.3) is -1, but int(-0.3) and .astype(int) give 0.",
)
def floors_below_zero(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    # In the first case, all points are in the lower halves of their cells, so rounding to the
    # nearest cell gives the same result. The second case has cells 1 and -1, which must not be
    # merged.
    for axis in range(3):
        for coordinates in ((0.06, -0.14, -0.36, -0.32), (0.26, -0.14, 0.66)):
            cloud = np.full((len(coordinates), 4), 0.05)
            cloud[:, axis] = coordinates
            assert_row_per_cell(voxel_grid(cloud.copy(), 0.2), cloud, 3, 0.2)


# Pairs of cells that may get the same home-made key, such as the sum of the indices, their joined
# digits, a sum of products with primes, the indices without their signs, or the digits of a number
# to base 100. In the course's scan, the last of these keys merges one in twenty cells.
_CONFUSABLE = (
    ((1, 0, 0), (0, 1, 0)),
    ((1, 11, 1), (11, 1, 1)),
    ((3, 0, 0), (0, 0, 3)),
    ((-4, -4, -2), (4, 4, -2)),
    ((4, -3, 1), (4, 3, -1)),
    ((-4, 1, 0), (3, 1, 0)),
    ((5, -2, 2), (5, 1, 2)),
    ((5, 2, -1), (5, 2, 0)),
    ((12, 0, 0), (2, 1, 0)),
    ((100, 0, 0), (0, 1, 0)),
    ((100, 0, 0), (0, 0, 1)),
    ((0, 100, 0), (1, 0, 0)),
    ((0, 100, 0), (0, 0, 1)),
    ((0, 0, 100), (1, 0, 0)),
    ((0, 0, 100), (0, 1, 0)),
)


@visible_check(
    "voxel_grid",
    weight=4,
    title="Never merges points from different cells",
    why="Merging points from different cells creates a point between them, where there is nothing.",
    hint="Compare all three numbers of np.floor(xyz / voxel_size), including their signs. "
    "as_numbers(...) gives different numbers to different rows.",
)
def never_merges_cells(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    for pair in _CONFUSABLE:
        cloud = np.column_stack([(np.array(pair) + 0.5) * 0.2, np.ones(2)])
        rows = len(as_array(voxel_grid(cloud.copy(), 0.2)))
        if rows != 2:
            raise CheckFailed(
                f"The cells {pair[0]} and {pair[1]} are merged into one.",
                input_text="one point in each of the two cells, voxel_size=0.2",
                yours=f"{rows} row{'s' * (rows != 1)}",
                expected="2 rows",
            )


@visible_check(
    "voxel_grid",
    weight=2,
    title="Starts cells at multiples of voxel_size",
    why="If the grid moved with the points, the same wall would get different points in every "
    "scan.",
    hint="Compute the cell as np.floor(xyz / voxel_size). np.round shifts the cells by half a "
    "cell, and subtracting the minimum starts them at the edge of the cloud.",
)
def starts_cells_at_multiples(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    cloud = np.full((3, 4), 0.08)
    cloud[:, 0] = 0.14, 0.18, 0.26
    assert_row_per_cell(voxel_grid(cloud.copy(), 0.2), cloud, 2, 0.2)


@visible_check(
    "voxel_grid",
    weight=9,
    title="Uses voxel_size as the size of the cells",
    why="Larger cells trade detail for speed, so each program chooses its own size.",
    hint="Divide by the parameter: np.floor(xyz / voxel_size).",
)
def uses_the_voxel_size(voxel_grid: Callable) -> None:
    cloud = np.full((4, 4), 0.1)
    cloud[:, 1] = 0.1, 0.6, 2.1, 10.1
    for size, number in ((0.25, 4), (1.5, 3), (5.0, 2), (40.0, 1)):
        assert_row_per_cell(voxel_grid(cloud.copy(), size), cloud, number, size)


_GRID_CASE = Case(
    __name__,
    "voxel_grid",
    {"cloud": _CELLS, "voxel_size": 0.2},
    expected=len(_CENTROIDS),
    compare=lambda answer, cloud, size, number: assert_row_per_cell(answer, cloud, number, size),
    precondition=require_row_per_cell,
)


@common_checks.promise_default(
    _GRID_CASE,
    "voxel_size=0.2",
    title="Uses cells of 0.2 m by default",
    why="Other code may call voxel_grid(points) and rely on this default.",
)
def uses_the_default_size(voxel_grid: Callable) -> None:
    cloud = np.full((100, 4), 0.05)
    cloud[:, 0] = np.linspace(0.003, 3.997, 100)
    explicit = as_array(voxel_grid(cloud.copy(), 0.2))
    try:
        assert_row_per_cell(voxel_grid(cloud.copy()), cloud, len(explicit), 0.2)
    except CheckFailed as failure:
        failure.marked = fixed(
            "voxel_grid(cloud) and voxel_grid(cloud, 0.2) give different results."
        )
        failure.expected = f"{_row_count_text(len(explicit))}, as with voxel_size=0.2"
        raise


common_checks.promise_names(
    _GRID_CASE, "keeps_the_names", why="Other code may call voxel_grid(points, voxel_size=0.1)."
)
common_checks.promise_three_columns(
    _GRID_CASE,
    "thins_three_columns",
    hint="Take the number of columns from the cloud: cloud.shape[1].",
)


@visible_check(
    "voxel_grid",
    weight=4,
    title="Works on an empty cloud and on a single point",
    why="Other filters may leave one return or none, and the next step still indexes the columns.",
    hint="If len(cloud) == 0, return the cloud itself: it already has the right number of columns.",
)
def thins_small_clouds(voxel_grid: Callable) -> None:
    require_row_per_cell(voxel_grid)
    columns = as_array(voxel_grid(_CELLS.copy(), 0.2)).shape[1]
    empty = np.empty((0, 4))
    assert_empty_table(voxel_grid(empty.copy(), 0.2), empty, columns)
    horizontal = np.array([[3.47, -1.05, 0.0, 0.4]])  # z is 0 for a horizontal beam
    for point in (_CELLS[:1], horizontal):
        assert_row_per_cell(voxel_grid(point.copy(), 0.2), point, 1, 0.2)


common_checks.promise_untouched(
    _GRID_CASE,
    "leaves_its_input",
    why="The next step may need the full cloud again.",
    hint="Do not use `/=` on cloud or assign into it: that changes the caller's array.",
    weight=2,
)


common_row_checks.note_array(_GRID_CASE, "gives_an_array")


@note_check(
    "voxel_grid",
    title="Puts points on a cell border into the upper cell",
    why="The docstring says floor(xyz / voxel_size). With np.ceil, points on a border would be in "
    "the lower cell. In a scan, hardly any point is on a border, but in a cloud rounded to "
    "centimetres, many points are.",
)
def rounds_down(voxel_grid: Callable) -> None:
    cloud = np.full((3, 4), 0.1)
    cloud[:, 0] = 0.25, 0.375, 0.625
    assert_row_per_cell(voxel_grid(cloud.copy(), 0.25), cloud, 2, 0.25)


def _merge_without_signs(cloud: np.ndarray, size: float) -> np.ndarray:
    """Merge rows whose cell indices have the same absolute values."""
    cells = np.floor(np.abs(cloud[:, :3]) / size)
    _, which = np.unique(cells, axis=0, return_inverse=True)
    which = which.ravel()
    return np.array([cloud[which == cell].mean(axis=0) for cell in range(which.max() + 1)])


def _merge_cells(
    cloud: np.ndarray,
    step: float,
    first: float | np.ndarray = 0.0,
    columns: int = 3,
    merge: Callable = np.mean,
    missing_borders: tuple = (),
) -> np.ndarray:
    """Merge rows that share a cell; cell borders are at `first`, `first` ± `step`, ...

    Parameters
    ----------
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    step : float
        Distance between two borders, in metres.
    first : float or numpy.ndarray
        Position of border 0: one number for all columns, or one for each.
    columns : int
        Number of columns that determine the cell.
    merge : callable
        Takes the rows of a cell and ``axis=0``; returns one row.
    missing_borders : tuple of int
        Numbers of the missing borders.
    """
    steps = np.array([number for number in range(-60, 61) if number not in missing_borders])
    borders = np.broadcast_to(first, cloud.shape[1])[:, None] + step * steps
    cells = (cloud[:, :columns, None] >= borders[None, :columns]).sum(axis=2).tolist()
    groups = [[row for row in range(len(cloud)) if cells[row] == cell] for cell in cells]
    return np.array(
        [
            merge(cloud[group], axis=0)
            for first_row, group in enumerate(groups)
            if group[0] == first_row
        ]
    )


def _truncated_mean(rows: np.ndarray, axis: int) -> np.ndarray:
    """Return the mean of rows if the sum loses its decimals at every addition."""
    total = functools.reduce(lambda partial, row: np.trunc(partial + row), rows, np.zeros(4))
    return total / len(rows)


def _same_rows(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer has the predicted rows, duplicates included, in any order."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    return yours.shape == predicted.shape and same_array(
        _sorted_rows(yours), _sorted_rows(predicted)
    )


def _sorted_rows(rows: np.ndarray) -> np.ndarray:
    """Return rows sorted by column 0, then column 1 and so on; rounding does not break ties."""
    return rows[np.lexsort(np.round(rows.astype(float), 3).T[::-1] + 0.0)]


declare_mistakes(
    "voxel_grid",
    Mistake(
        "The rows of each cell are added up, but the sums are not divided by the counts.",
        lambda right, cloud, size: _merge_cells(cloud, size, merge=np.sum),
        "Return sums / counts[:, None]. With counts as a column, each row is divided by its own "
        "count.",
    ),
    Mistake(
        "Only the last row of each cell is added, and the result is divided by the count.",
        lambda right, cloud, size: _merge_cells(
            cloud, size, merge=lambda rows, axis: rows[-1] / len(rows)
        ),
        "Use np.add.at(sums, which, rows): it adds every row, but sums[which] += rows keeps only "
        "the last row of each cell.",
    ),
    Mistake(
        "The sums are whole numbers, so every addition cuts off the decimals.",
        lambda right, cloud, size: _merge_cells(cloud, size, merge=_truncated_mean),
        "Use np.zeros(shape) without dtype=int. np.zeros_like of an integer array cuts off the "
        "decimals as well.",
    ),
    Mistake(
        "Your code returns the first point of each cell. It should return the mean of all points "
        "in the cell.",
        lambda right, cloud, size: _merge_cells(cloud, size, merge=lambda rows, axis: rows[0]),
        "Add up the rows of each cell with np.add.at, and divide by the counts.",
    ),
    Mistake(
        "Your code returns the last point of each cell. It should return the mean of all points "
        "in the cell.",
        lambda right, cloud, size: _merge_cells(cloud, size, merge=lambda rows, axis: rows[-1]),
        "Add up the rows of each cell with np.add.at, and divide by the counts.",
    ),
    Mistake(
        "Your code returns the centre of each cell. It should return the mean of the points in "
        "the cell.",
        lambda right, cloud, size: (right[:, :3] // size + 0.5) * size,
        "Add up the rows of each cell with np.add.at, and divide by the counts.",
    ),
    Mistake(
        "Your code returns the three numbers of each cell. It should return the mean of the "
        "points in the cell.",
        lambda right, cloud, size: right[:, :3] // size,
        "Add up the rows of each cell with np.add.at, and divide by the counts.",
        is_cheap=True,
    ),
    Mistake(
        "Coordinates are rounded towards zero, so the two cells next to zero are merged.",
        lambda right, cloud, size: _merge_cells(cloud, size, missing_borders=(0,)),
        "Call np.floor first: .astype(int) alone only cuts off the decimals.",
    ),
    Mistake(
        "The sign is lost, so a cell on the left and its mirror image on the right are merged.",
        lambda right, cloud, size: _merge_without_signs(cloud, size),
        "Do not use abs: np.floor(xyz / voxel_size) may be negative.",
    ),
    Mistake(
        "Coordinates are rounded to the nearest whole number, so every cell starts half a cell "
        "too early.",
        lambda right, cloud, size: _merge_cells(cloud, size, first=size / 2),
        "Use np.floor instead of np.round.",
    ),
    Mistake(
        "The cells start at the lowest corner of the cloud. They should start at multiples of "
        "voxel_size.",
        lambda right, cloud, size: _merge_cells(cloud, size, first=cloud.min(axis=0)),
        "Do not subtract the minimum: np.floor(xyz / voxel_size) may be negative.",
    ),
    Mistake(
        "z is not used, so every cell is a column of unlimited height.",
        lambda right, cloud, size: _merge_cells(cloud, size, columns=2),
        "Use three columns for the cell: cloud[:, :3].",
    ),
    Mistake(
        "The intensity is used to choose the cell, so points at the same place are not merged if "
        "their brightness differs.",
        lambda right, cloud, size: _merge_cells(cloud, size, columns=4),
        "Compute the cells from cloud[:, :3] only.",
    ),
    Mistake(
        "The cell size is fixed at 0.2 m; voxel_size is ignored.",
        lambda right, cloud, size: _merge_cells(cloud, 0.2),
        "Divide by voxel_size.",
    ),
    Mistake(
        "voxel_size is not used, so all cells are 1 m wide.",
        lambda right, cloud, size: _merge_cells(cloud, 1.0),
        "Divide by voxel_size before np.floor.",
    ),
    Mistake(
        "The coordinates are multiplied by voxel_size. They should be divided by it.",
        lambda right, cloud, size: _merge_cells(cloud, 1 / size),
    ),
    *(
        Mistake(
            "The last cell is missing: your code writes each cell when the next one begins, and "
            "no cell follows the last one.",
            lambda right, cloud, size, by=by: right[
                np.lexsort(np.floor(right[:, :3] / size).T[by])
            ][:-1],
            "Write the last cell after the loop.",
        )
        for by in (slice(None, None, -1), slice(None))  # sorted first by x, or first by z
    ),
    Mistake(
        "Nothing is merged: the function returns the whole cloud. It should return one row per "
        "occupied cell.",
        lambda right, cloud, size: cloud,
        is_cheap=True,
    ),
    cases=(
        (
            parse_table(
                "0.3 0.1 0.1 0.1; -0.23 0.1 0.3 0.1; 0.45 0.2 0.4 0.9; 0.7 0.1 0.1 0.4; "
                "0.35 0.1 0.9 0.3; 1.4 0.3 0.1 0.2; -0.71 0.2 0.3 0.6"
            ),
            0.5,
        ),
        (
            parse_table(
                "1.3 -1.2 0.4 0.2; 2.3 -0.7 0.3 4.6; 1.1 -0.9 3.4 0.5; 3.9 0.6 0.2 0.8; "
                "1.8 -1.6 0.9 2.3; 2.9 -1.1 0.1 0.6; -3.2 -0.3 0.6 0.7"
            ),
            2.0,
        ),
        (
            parse_table(
                "0.11 0.33 0.22 0.1; 0.07 0.37 0.21 0.2; 0.14 0.31 0.28 0.9; 0.33 0.13 0.27 0.2"
            ),
            0.5,
        ),
    ),
    right=lambda cloud, size: _merge_cells(cloud, size),
    is_same=_same_rows,
)
