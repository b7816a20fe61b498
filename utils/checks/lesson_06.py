"""Visible checks of lesson 06: `filter_ground` and `voxel_grid`."""

from collections.abc import Callable

import numpy as np

from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_array,
    assert_rows,
    assert_same_set_of_rows,
    assert_untouched,
    frozen,
)

# Road at -1.73 m, a kerb, a bumper, a car roof and a sign; then a column of intensity.
_HEIGHTS = frozen(
    np.array(
        [
            [6.0, 0.5, -1.73, 0.20],
            [6.2, 0.5, -0.90, 0.90],
            [8.0, -2.0, -1.58, 0.30],
            [8.1, -2.0, -1.15, 0.40],
            [9.0, 3.0, 0.10, 0.60],
            [9.5, 3.0, -1.70, 0.10],
            [4.0, 1.0, 1.40, 0.80],
        ]
    )
)
# Two cells of 1 m: three points in one, one point in the other.
_CELLS = frozen(
    np.array(
        [
            [0.1, 0.1, 0.1, 0.0],
            [0.3, 0.5, 0.1, 0.3],
            [0.8, 0.3, 0.7, 0.9],
            [1.5, 0.5, 0.5, 0.4],
        ]
    )
)


@visible(
    "filter_ground",
    weight=4,
    title="Keeps what stands above the ground level and drops the road",
    why="A road point that stays becomes an obstacle, and the car brakes for asphalt.",
    hint="Compare the z column, cloud[:, 2], with ground_level. The result is one True or "
    "False per point.",
)
def keeps_what_stands_above(filter_ground: Callable) -> None:
    assert_rows(
        filter_ground(_HEIGHTS.copy(), -1.2),
        _HEIGHTS,
        np.array([False, True, False, True, True, False, True]),
    )


@visible(
    "filter_ground",
    weight=3,
    title="Follows ground_level, given by position, by name or left out",
    why="Another car carries its sensor at another height: the level must not be written "
    "into the function.",
    hint="Use the parameter ground_level in the comparison, and keep its default of -1.2.",
)
def follows_the_level(filter_ground: Callable) -> None:
    high = np.array([False, False, False, False, True, False, True])
    assert_rows(filter_ground(_HEIGHTS.copy(), 0.0), _HEIGHTS, high)
    assert_rows(filter_ground(cloud=_HEIGHTS.copy(), ground_level=0.0), _HEIGHTS, high)
    assert_rows(
        filter_ground(_HEIGHTS.copy()),
        _HEIGHTS,
        np.array([False, True, False, True, True, False, True]),
    )


@visible(
    "filter_ground",
    weight=2,
    title="Takes three columns as well as four, and an empty cloud",
    why="Some files hold no intensity, and after other filters nothing may be left.",
    hint="Index rows with the mask, cloud[mask], and leave the columns alone.",
)
def takes_every_shape(filter_ground: Callable) -> None:
    xyz = _HEIGHTS[:, :3]
    assert_rows(
        filter_ground(xyz.copy(), -1.2),
        xyz,
        np.array([False, True, False, True, True, False, True]),
    )
    for columns in (3, 4):
        assert_rows(
            filter_ground(np.empty((0, columns)), -1.2),
            np.empty((0, columns)),
            np.zeros(0, dtype=bool),
        )


@visible(
    "filter_ground",
    weight=1,
    title="Leaves its input untouched",
    why="The next step of the pipeline may need the full cloud again.",
    hint="cloud[mask] is already a new array. Do not assign into cloud.",
)
def leaves_its_input(filter_ground: Callable) -> None:
    assert_rows(filter_ground(_HEIGHTS.copy(), -1.2), _HEIGHTS, _HEIGHTS[:, 2] > -1.2)
    assert_untouched(filter_ground, _HEIGHTS, -1.2)


@visible(
    "voxel_grid",
    weight=3,
    title="One point per occupied cell",
    why="That is the whole purpose: as many points as cells, however dense the scan.",
    hint="floor(xyz / voxel_size) gives three whole numbers per point; np.unique with "
    "axis=0 finds the different ones.",
)
def one_point_per_cell(voxel_grid: Callable) -> None:
    rows = as_array(voxel_grid(_CELLS.copy(), 1.0), columns=4)
    if len(rows) != 2:
        raise CheckFailed(
            "Three points share one cell and the fourth has its own.",
            yours=f"{len(rows)} rows",
            expected="2 rows",
        )
    assert_same_set_of_rows(rows, np.array([[0.4, 0.3, 0.3, 0.4], [1.5, 0.5, 0.5, 0.4]]))


@visible(
    "voxel_grid",
    weight=3,
    title="Cells below zero are cells like any others",
    why="Half of the street has negative coordinates. Rounding towards zero would make the "
    "cells around the sensor twice as wide.",
    hint="np.floor(-0.3) is -1, but int(-0.3) is 0.",
)
def floors_below_zero(voxel_grid: Callable) -> None:
    cloud = np.array([[-0.3, 0.5, 0.5], [0.3, 0.5, 0.5], [-1.2, 0.5, 0.5], [-0.9, 0.5, 0.5]])
    assert_same_set_of_rows(
        voxel_grid(cloud.copy(), 1.0),
        np.array([[-0.6, 0.5, 0.5], [0.3, 0.5, 0.5], [-1.2, 0.5, 0.5]]),
    )


@visible(
    "voxel_grid",
    weight=2,
    title="Follows voxel_size, given by position, by name or left out",
    why="Cell size trades detail for speed, and every pipeline chooses its own.",
    hint="Divide by voxel_size before np.floor, and keep its default of 0.2.",
)
def follows_the_size(voxel_grid: Callable) -> None:
    cloud = np.array([[0.05, 0.05, 0.05], [0.15, 0.05, 0.05], [0.35, 0.05, 0.05]])
    two = np.array([[0.10, 0.05, 0.05], [0.35, 0.05, 0.05]])
    assert_same_set_of_rows(voxel_grid(cloud.copy()), two)
    assert_same_set_of_rows(voxel_grid(cloud=cloud.copy(), voxel_size=0.2), two)
    assert_same_set_of_rows(voxel_grid(cloud.copy(), 1.0), cloud.mean(axis=0, keepdims=True))


@visible(
    "voxel_grid",
    weight=2,
    title="Takes an empty cloud, and leaves its input untouched",
    why="After other filters nothing may be left, and the next step may need the full cloud.",
    hint="Return early when len(cloud) == 0, with the same number of columns.",
)
def takes_nothing(voxel_grid: Callable) -> None:
    assert_untouched(voxel_grid, _CELLS, 0.7)
    for columns in (3, 4):
        rows = as_array(voxel_grid(np.empty((0, columns)), 0.2), columns=columns)
        if len(rows):
            raise CheckFailed(
                "An empty cloud has no cells.", yours=f"{len(rows)} rows", expected="0 rows"
            )
    assert_same_set_of_rows(voxel_grid(_CELLS[:1].copy(), 1.0), _CELLS[:1])
