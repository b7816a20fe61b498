"""Visible checks of lesson 07: `filter_by_distance`, `crop_region`, `remove_ego_returns`.

`assert_near` and `assert_boxed` compare a filtered cloud with the right one, and recognise the
usual slips by the rows that they keep.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from utils.checks.core import visible
from utils.checks.vocabulary import (
    TOLERANCE,
    CheckFailed,
    as_array,
    assert_rows,
    assert_untouched,
    frozen,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Near: ahead, behind on the right, left and right. Far: each coordinate below 10 and yet far,
# ahead, behind, and to the right. In no order that could be guessed.
_PLACES = frozen(
    np.array(
        [
            [6.0, 0.5, -1.5, 0.20],
            [-7.0, -6.0, -0.9, 0.90],
            [8.0, 8.0, -1.0, 0.40],
            [12.0, 0.3, -1.1, 0.30],
            [-10.6, 0.2, -0.7, 0.10],
            [1.5, 8.0, 0.3, 0.60],
            [3.0, -9.2, -0.4, 0.50],
            [1.0, -15.0, 0.2, 0.80],
        ]
    )
)
_NEAR = frozen(np.array([True, True, False, False, False, True, True, False]))
# A tree top and the road below a bridge are near; a low thing is far.
_TALL = frozen(
    np.array(
        [
            [11.0, 1.0, 0.0, 0.1],
            [9.0, 2.0, 7.0, 0.1],
            [-6.0, 7.0, -8.0, 0.1],
            [0.5, -10.8, -0.2, 0.1],
        ]
    )
)
_TALL_NEAR = frozen(np.array([False, True, True, False]))
# As from a driver that reports intensities from 0 to 255.
_BRIGHT = frozen(
    np.array(
        [
            [9.0, 0.5, 0.2, 255.0],
            [2.0, -7.0, 0.2, 40.0],
            [10.5, 0.5, 0.2, 0.0],
            [-9.0, 6.0, 0.2, 3.0],
        ]
    )
)
_BRIGHT_NEAR = frozen(np.array([True, True, False, False]))

_MINIMUM, _MAXIMUM = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
# Two rows inside, then one beyond each of the six faces, then two more inside.
_ROOM = frozen(
    np.array(
        [
            [1.0, 2.0, -1.0, 0.5],
            [28.0, -4.0, 0.5, 0.1],
            [-10.5, 2.0, -1.0, 0.2],
            [31.0, 2.0, -1.0, 0.3],
            [1.0, -5.5, -1.0, 0.4],
            [1.0, 6.5, -1.0, 0.6],
            [1.0, 2.0, -2.5, 0.7],
            [1.0, 2.0, 1.5, 0.8],
            [-9.0, 5.5, 0.9, 0.9],
            [12.0, 0.0, -1.9, 0.4],
        ]
    )
)
_INSIDE = frozen(np.array([True, True, False, False, False, False, False, False, True, True]))
_EGO = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
# Three returns of our own car; then others that share one or two coordinates with it.
_AROUND = frozen(
    np.array(
        [
            [-1.3, 0.4, -0.6, 0.3],
            [1.0, -1.0, -0.5, 0.5],
            [5.0, 1.0, -0.6, 0.4],
            [1.0, 2.4, -0.7, 0.2],
            [0.9, 1.0, -0.6, 0.5],
            [0.5, 0.5, 1.2, 0.1],
            [-3.0, -8.0, -0.8, 0.9],
            [12.0, 0.2, 2.0, 0.7],
        ]
    )
)
_OURS = frozen(np.array([True, True, False, False, True, False, False, False]))


def assert_near(answer: object, cloud: np.ndarray, distance: float, near: np.ndarray) -> None:
    """The answer is ``cloud[near]``: the rows whose horizontal distance is at most `distance`.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    distance : float
    near : numpy.ndarray of bool, shape (n,)
    """
    x, y = cloud[:, 0], cloud[:, 1]
    squared = x**2 + y**2
    slips = {
        "These are the far points: the comparison is the wrong way round.": ~near,
        "The height is counted in: that is the 3-D distance.": squared + cloud[:, 2] ** 2
        <= distance**2,
        "Height and intensity are counted in: that is the length of the row.": (cloud**2).sum(
            axis=1
        )
        <= distance**2,
        "This is a square, not a circle: each coordinate is compared by itself.": (
            np.abs(x) <= distance
        )
        & (np.abs(y) <= distance),
        "Only x is compared.": x <= distance,
        "Only x is compared, without its sign.": np.abs(x) <= distance,
        "x and y are added, not their squares.": np.abs(x) + np.abs(y) <= distance,
        "The squared distance is compared with the plain one.": squared <= distance,
    }
    _assert_rows(answer, cloud, near, slips, lambda axes: _circle(axes, distance))


def assert_boxed(
    answer: object,
    cloud: np.ndarray,
    minimum: Sequence[float],
    maximum: Sequence[float],
    keep: np.ndarray,
) -> None:
    """The answer is ``cloud[keep]``: the rows inside a box, or those not inside.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    minimum, maximum : three floats each
    keep : numpy.ndarray of bool, shape (n,)
    """
    xyz = cloud[:, :3]
    above, below = xyz >= np.array(minimum), xyz <= np.array(maximum)
    inside = (above & below).all(axis=1)
    flat = (above & below)[:, :2].all(axis=1)
    complement = np.array_equal(keep, ~inside)
    slips = {
        "These are the rows outside: the mask is the wrong way round.": ~inside,
        "Only x and y are compared: z decides, too.": flat,
        "Only minimum is compared.": above.all(axis=1),
        "Only maximum is compared.": below.all(axis=1),
        "One coordinate within the box is enough here: all three must be.": (above & below).any(
            axis=1
        ),
    }
    if complement:
        slips = {
            "These are the rows inside the box: keep the others.": inside,
            "Only x and y are compared: what is above or below the box is no part of it.": ~flat,
            "Only rows that are outside in x and in y and in z are left: one of them is enough.": ~(
                above & below
            ).any(axis=1),
        }
    _assert_rows(answer, cloud, keep, slips, lambda axes: _rectangle(axes, minimum, maximum))


def _assert_rows(
    answer: object,
    cloud: np.ndarray,
    keep: np.ndarray,
    slips: dict[str, np.ndarray],
    outline: Callable,
) -> None:
    """`assert_rows`, with the name of a slip that keeps just these rows, and a drawn border."""
    try:
        assert_rows(answer, cloud, keep, view="above")
    except CheckFailed as failure:
        difference = failure.draw
        draw = difference and (lambda: outline(difference()))
        name = next(
            (
                name
                for name, rows in slips.items()
                if not np.array_equal(rows, keep) and _same(answer, cloud[rows])
            ),
            "",
        )
        raise CheckFailed(
            f"{failure.message} {name}".strip(),
            yours=failure.yours,
            expected=failure.expected,
            draw=draw,
            tip=failure.tip,
        ) from None


def _same(answer: object, rows: np.ndarray) -> bool:
    try:
        array = as_array(answer)
    except CheckFailed:
        return False
    return array.shape == rows.shape and np.allclose(array, rows, rtol=0, atol=TOLERANCE)


def _circle(axes: Axes, distance: float) -> None:
    from matplotlib.patches import Circle

    axes.add_patch(Circle((0, 0), distance, fill=False, edgecolor="black", linestyle="--"))
    reach = 1.05 * distance
    for limits, change in ((axes.get_xlim(), axes.set_xlim), (axes.get_ylim(), axes.set_ylim)):
        change(min(limits[0], -reach), max(limits[1], reach))


def _rectangle(axes: Axes, minimum: Sequence[float], maximum: Sequence[float]) -> None:
    from matplotlib.patches import Rectangle

    length, width = maximum[0] - minimum[0], maximum[1] - minimum[1]
    axes.add_patch(
        Rectangle(minimum[:2], length, width, fill=False, edgecolor="black", linestyle="--")
    )


@visible(
    "filter_by_distance",
    weight=4,
    title="Keeps what is near and drops what is far, in every direction",
    why="A car behind us is as real as one ahead, and a far wall only costs time.",
    hint="Square x and y, add, take the root: one distance per point. Keep where it is at "
    "most `distance`.",
)
def keeps_what_is_near(filter_by_distance: Callable) -> None:
    assert_near(filter_by_distance(_PLACES.copy(), 10.0), _PLACES, 10.0, _NEAR)


@visible(
    "filter_by_distance",
    weight=3,
    title="Height does not count",
    why="A child in front of a lorry is far below its sensor: the straight line to it is "
    "longer than the way to it.",
    hint="Use columns 0 and 1 only. Column 2 is the height.",
)
def ignores_height(filter_by_distance: Callable) -> None:
    assert_near(filter_by_distance(_TALL.copy(), 10.0), _TALL, 10.0, _TALL_NEAR)


@visible(
    "filter_by_distance",
    weight=2,
    title="Intensity does not count",
    why="Another driver reports intensities up to 255, and every bright car would vanish.",
    hint="A norm over whole rows counts column 3, too. Use columns 0 and 1 only.",
)
def ignores_intensity(filter_by_distance: Callable) -> None:
    assert_near(filter_by_distance(_BRIGHT.copy(), 10.0), _BRIGHT, 10.0, _BRIGHT_NEAR)


@visible(
    "filter_by_distance",
    weight=3,
    title="Follows distance, given by position, by name or left out",
    why="A fast car must look farther than a slow one.",
    hint="Use the parameter distance in the comparison, and keep its default of 10.0.",
)
def follows_the_distance(filter_by_distance: Callable) -> None:
    close = np.array([True, False, False, False, False, True, False, False])
    assert_near(filter_by_distance(_PLACES.copy(), 8.5), _PLACES, 8.5, close)
    assert_near(filter_by_distance(cloud=_PLACES.copy(), distance=8.5), _PLACES, 8.5, close)
    assert_near(filter_by_distance(_PLACES.copy()), _PLACES, 10.0, _NEAR)


@visible(
    "filter_by_distance",
    weight=2,
    title="Takes three columns as well as four, and an empty cloud",
    why="Some files hold no intensity, and after other filters nothing may be left.",
    hint="Index rows with the mask, cloud[mask], and leave the columns alone.",
)
def takes_every_shape(filter_by_distance: Callable) -> None:
    xyz = _PLACES[:, :3]
    assert_near(filter_by_distance(xyz.copy(), 10.0), xyz, 10.0, _NEAR)
    for columns in (3, 4):
        nothing = np.empty((0, columns))
        assert_near(filter_by_distance(nothing.copy(), 10.0), nothing, 10.0, np.zeros(0, bool))


@visible(
    "filter_by_distance",
    weight=1,
    title="Leaves its input untouched",
    why="The next step of the pipeline may need the full cloud again.",
    hint="cloud[mask] is already a new array. Do not assign into cloud.",
)
def leaves_its_input(filter_by_distance: Callable) -> None:
    assert_near(filter_by_distance(_PLACES.copy(), 10.0), _PLACES, 10.0, _NEAR)
    assert_untouched(filter_by_distance, _PLACES, 10.0)


@visible(
    "crop_region",
    weight=4,
    title="Keeps what is inside the box, seen from all six sides",
    why="One side forgotten, and the region of interest reaches to the horizon.",
    hint="Compare the first three columns with minimum and with maximum, join the tables "
    "with &, then .all(axis=1).",
)
def keeps_what_is_inside(crop_region: Callable) -> None:
    assert_boxed(crop_region(_ROOM.copy(), _MINIMUM, _MAXIMUM), _ROOM, _MINIMUM, _MAXIMUM, _INSIDE)


@visible(
    "crop_region",
    weight=1,
    title="The faces belong to the box",
    why="Two boxes side by side shall leave no gap between them.",
    hint="Use >= and <=, not > and <.",
)
def faces_are_inside(crop_region: Callable) -> None:
    edge = np.array(
        [
            [-10.0, 0.0, 0.0],
            [30.0, 0.0, 0.0],
            [0.0, -5.0, 0.0],
            [0.0, 6.0, 0.0],
            [0.0, 0.0, -2.0],
            [0.0, 0.0, 1.0],
            [40.0, 0.0, 0.0],
        ]
    )
    assert_boxed(
        crop_region(edge.copy(), _MINIMUM, _MAXIMUM),
        edge,
        _MINIMUM,
        _MAXIMUM,
        np.array([True] * 6 + [False]),
    )


@visible(
    "crop_region",
    weight=2,
    title="Follows minimum and maximum, by name, as lists and as arrays",
    why="The region changes with the road and with the speed.",
    hint="Use the parameters minimum and maximum. Comparing an array with a tuple or a "
    "list of three numbers works without more ado.",
)
def follows_the_corners(crop_region: Callable) -> None:
    small = np.array([True] + [False] * 8 + [True])
    low, high = [0.0, -1.0, -1.95], [13.0, 3.0, 0.0]
    assert_boxed(
        crop_region(cloud=_ROOM.copy(), minimum=list(low), maximum=list(high)),
        _ROOM,
        low,
        high,
        small,
    )
    assert_boxed(crop_region(_ROOM.copy(), np.array(low), np.array(high)), _ROOM, low, high, small)


@visible(
    "crop_region",
    weight=2,
    title="Takes three or four columns and an empty cloud; leaves its input untouched",
    why="Some files hold no intensity, and after other filters nothing may be left.",
    hint="Compare cloud[:, :3], but index cloud itself.",
)
def crops_every_shape(crop_region: Callable) -> None:
    room = _ROOM[:, :3]
    answer = crop_region(room.copy(), _MINIMUM, _MAXIMUM)
    assert_boxed(answer, room, _MINIMUM, _MAXIMUM, _INSIDE)
    assert_untouched(crop_region, room, _MINIMUM, _MAXIMUM)
    for columns in (3, 4):
        nothing = np.empty((0, columns))
        assert_boxed(
            crop_region(nothing.copy(), _MINIMUM, _MAXIMUM),
            nothing,
            _MINIMUM,
            _MAXIMUM,
            np.zeros(0, bool),
        )


@visible(
    "remove_ego_returns",
    weight=4,
    title="Removes what is inside the box, and nothing else",
    why="A return of our own mirror is an obstacle that never goes away; a child beside "
    "the door must stay.",
    hint="Find the rows inside as in crop_region, then keep the others: ~inside.",
)
def removes_our_own(remove_ego_returns: Callable) -> None:
    assert_boxed(remove_ego_returns(_AROUND.copy(), *_EGO), _AROUND, *_EGO, ~_OURS)


@visible(
    "remove_ego_returns",
    weight=2,
    title="What shares only x, y or z with our car stays",
    why="The car ahead of us shares y and z with us. It is the last one to lose.",
    hint="A row is outside when one coordinate is outside: not (a and b and c) is "
    "(not a) or (not b) or (not c).",
)
def keeps_what_shares_a_coordinate(remove_ego_returns: Callable) -> None:
    cloud = np.array(
        [
            [0.5, 0.0, -0.7],
            [9.0, 0.0, -0.7],
            [0.5, 6.0, -0.7],
            [0.5, 0.0, 2.0],
            [9.0, 6.0, -0.7],
            [9.0, 0.0, 2.0],
            [0.5, 6.0, 2.0],
            [9.0, 6.0, 2.0],
        ]
    )
    assert_boxed(
        remove_ego_returns(cloud.copy(), *_EGO), cloud, *_EGO, np.array([False] + [True] * 7)
    )


@visible(
    "remove_ego_returns",
    weight=2,
    title="Follows minimum and maximum, by name, as lists and as arrays",
    why="A lorry is not a small car, and a roof rack is a part of ours.",
    hint="Use the parameters minimum and maximum.",
)
def follows_the_ego_box(remove_ego_returns: Callable) -> None:
    low, high = [0.8, 0.5, -1.0], [6.0, 3.0, -0.4]
    left = np.array([True, True, False, False, False, True, True, True])
    assert_boxed(
        remove_ego_returns(cloud=_AROUND.copy(), minimum=list(low), maximum=list(high)),
        _AROUND,
        low,
        high,
        left,
    )
    assert_boxed(
        remove_ego_returns(_AROUND.copy(), np.array(low), np.array(high)), _AROUND, low, high, left
    )


@visible(
    "remove_ego_returns",
    weight=2,
    title="Takes three or four columns and an empty cloud; leaves its input untouched",
    why="Some files hold no intensity, and after other filters nothing may be left.",
    hint="Compare cloud[:, :3], but index cloud itself.",
)
def removes_from_every_shape(remove_ego_returns: Callable) -> None:
    around = _AROUND[:, :3]
    assert_boxed(remove_ego_returns(around.copy(), *_EGO), around, *_EGO, ~_OURS)
    assert_untouched(remove_ego_returns, around, *_EGO)
    for columns in (3, 4):
        nothing = np.empty((0, columns))
        assert_boxed(remove_ego_returns(nothing.copy(), *_EGO), nothing, *_EGO, np.zeros(0, bool))
