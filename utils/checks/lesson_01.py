"""Visible checks of lesson 01: `horizontal_distance` and `drop_invalid`."""

from collections.abc import Callable

import numpy as np

from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_array,
    assert_close,
    assert_rows,
    assert_untouched,
    brief,
    frozen,
)

# Points on the ground plane of the sensor, echoes without brightness: sides 3-4-5 and the like.
_FLAT = frozen(
    np.array(
        [
            [3.0, 4.0, 0.0, 0.0],
            [-6.0, 8.0, 0.0, 0.0],
            [5.0, -12.0, 0.0, 0.0],
            [0.0, 7.0, 0.0, 0.0],
            [-2.0, 0.0, 0.0, 0.0],
        ]
    )
)
_FLAT_DISTANCES = frozen(np.array([5.0, 10.0, 13.0, 7.0, 2.0]))
# The same from the road up to the tree tops, in all brightnesses.
_STREET = frozen(
    _FLAT
    + [
        [0, 0, -1.7, 0.1],
        [0, 0, 4.0, 0.9],
        [0, 0, -0.4, 0.5],
        [0, 0, 2.5, 1.0],
        [0, 0, -1.6, 0.8],
    ]
)

# Good returns, some with a zero in them, and between them all kinds of bad ones.
_NAN, _INF = np.nan, np.inf
_GOOD = frozen(
    np.array(
        [
            [6.0, 0.5, -1.7, 0.2],
            [0.0, 5.0, -0.5, 0.9],
            [7.0, 0.0, 0.0, 0.0],
            [2.0, -3.0, 1.0, 0.4],
            [-9.0, 4.0, 0.0, 0.6],
        ]
    )
)
_ZERO = frozen(np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.3], [-0.0, 0.0, -0.0, 0.0]]))
_LOST = frozen(
    np.array(
        [
            [_NAN, _NAN, _NAN, 0.0],
            [_NAN, 1.0, 2.0, 0.5],
            [4.0, _NAN, 0.5, 0.5],
            [4.0, 1.0, _NAN, 0.5],
            [_INF, 1.0, 0.0, 0.1],
            [3.0, -_INF, 0.0, 0.1],
            [3.0, 2.0, _INF, 0.1],
        ]
    )
)


def assert_distances(answer: object, cloud: np.ndarray, expected: np.ndarray) -> None:
    """The answer is `expected`; where it is a well-known other number, say which.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    expected : numpy.ndarray, shape (n,)
    """
    yours = as_array(answer, what="an array of distances")
    if yours.shape != expected.shape:
        raise CheckFailed(
            f"There must be one distance for each of the {len(cloud)} points. A column of the "
            "cloud is cloud[:, 0]; cloud[0] is its first row.",
            yours=f"shape {yours.shape}",
            expected=f"shape {expected.shape}",
        )
    if np.allclose(yours, expected, rtol=0, atol=1e-3, equal_nan=True):
        return
    xyz = np.asarray(cloud[:, :3], dtype=float)
    mistakes = {
        "These are lengths of x, y, z: the height is mixed in.": np.linalg.norm(xyz, axis=1),
        "These are lengths of whole rows: height and intensity are mixed in.": np.linalg.norm(
            np.asarray(cloud, dtype=float), axis=1
        ),
        "These are squared distances: the square root is missing.": expected**2,
        "These are |x| + |y|, the way around the corner: square, add, take the root.": np.abs(
            xyz[:, 0]
        )
        + np.abs(xyz[:, 1]),
        "This is |x| alone: a point to the side is far away, too.": np.abs(xyz[:, 0]),
    }
    for sentence, numbers in mistakes.items():
        if np.allclose(yours, numbers, rtol=0, atol=1e-3):
            raise CheckFailed(sentence, yours=brief(yours), expected=brief(expected))
    assert_close(yours, expected, "distances")


@visible(
    "horizontal_distance",
    weight=2,
    title="The distance of points level with the sensor",
    why="Every later lesson asks which points are near.",
    hint="The root of x² + y², for whole columns: x = cloud[:, 0], y = cloud[:, 1].",
)
def measures_distance(horizontal_distance: Callable) -> None:
    assert_distances(horizontal_distance(_FLAT.copy()), _FLAT, _FLAT_DISTANCES)


@visible(
    "horizontal_distance",
    weight=5,
    title="Neither height nor intensity counts",
    why="The foot and the lamp of a lamp post are equally far to drive, and a bright number "
    "plate is no farther than a dark tyre.",
    hint="np.linalg.norm(cloud, axis=1) uses all columns. Use the first two only.",
)
def ignores_height_and_intensity(horizontal_distance: Callable) -> None:
    assert_distances(horizontal_distance(_STREET[:, :3].copy()), _STREET[:, :3], _FLAT_DISTANCES)
    assert_distances(horizontal_distance(_STREET.copy()), _STREET, _FLAT_DISTANCES)


@visible(
    "horizontal_distance",
    weight=2,
    title="Takes three columns as well as four, one point and none",
    why="Some files hold no intensity, and after a filter nothing may be left.",
    hint="Whole columns do it all: no loop over the points and no special case is needed.",
)
def takes_every_shape(horizontal_distance: Callable) -> None:
    for cloud in (
        _STREET[:, :3],
        _STREET,
        _STREET[2:3],
        _STREET[2:3, :3],
        _STREET[:0],
        _STREET[:0, :3],
    ):
        expected = np.sqrt((cloud[:, :2] ** 2).sum(axis=1))
        assert_distances(horizontal_distance(cloud.copy()), cloud, expected)


@visible(
    "horizontal_distance",
    weight=1,
    title="Leaves its input untouched",
    why="The next step of the pipeline still needs the cloud.",
    hint="x**2 makes a new array; x **= 2 and x *= x write into the cloud.",
)
def leaves_its_input(horizontal_distance: Callable) -> None:
    assert_untouched(horizontal_distance, _STREET)
    assert_distances(horizontal_distance(_STREET.copy()), _STREET, _FLAT_DISTANCES)


def _mixed(*parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Good and bad rows shuffled; the cloud, and a mask of the good ones."""
    cloud = np.vstack([_GOOD, *parts])
    order = np.random.default_rng(4).permutation(len(cloud))
    return cloud[order], order < len(_GOOD)


@visible(
    "drop_invalid",
    weight=3,
    title="Drops returns at (0, 0, 0), whatever their intensity",
    why="They look like an obstacle inside the sensor: the car would brake without end.",
    hint="Compare the coordinates cloud[:, :3] with 0. A row is bad when all three are 0.",
)
def drops_the_origin(drop_invalid: Callable) -> None:
    cloud, good = _mixed(_ZERO)
    assert_rows(drop_invalid(cloud.copy()), cloud, good, view="above")


@visible(
    "drop_invalid",
    weight=3,
    title="Drops rows with a coordinate that is NaN or infinite",
    why="One NaN turns a mean, a box or a whole map into NaN.",
    hint="np.isfinite is False for NaN and for both infinities. A good row is finite in all "
    "three coordinates; NaN == NaN is False, so comparing does not find it.",
)
def drops_what_is_not_finite(drop_invalid: Callable) -> None:
    cloud, good = _mixed(_LOST)
    assert_rows(drop_invalid(cloud.copy()), cloud, good, view="above")


@visible(
    "drop_invalid",
    weight=2,
    title="Keeps good points, also those with a 0 among their coordinates",
    why="A car exactly to the left has x = 0. It must not vanish for that.",
    hint="One coordinate of 0 is fine; all three are not. Their sum says little: "
    "2 - 3 + 1 is 0, too.",
)
def keeps_good_points(drop_invalid: Callable) -> None:
    crossing = np.array(
        [
            [0.0, 5.0, 0.0],
            [5.0, 0.0, 0.0],
            [0.0, 0.0, -1.7],
            [1.0, -1.0, 0.0],
            [0.01, 0.0, 0.0],
            [0.0, 0.0, 0.0],
        ]
    )
    assert_rows(drop_invalid(crossing.copy()), crossing, np.arange(6) < 5, view="above")
    cloud, good = _mixed(_ZERO, _LOST)
    assert_rows(drop_invalid(cloud.copy()), cloud, good, view="above")


@visible(
    "drop_invalid",
    weight=1,
    title="Judges by the coordinates: a missing intensity does no harm",
    why="Some scanners report the place of an echo but not its strength.",
    hint="Look at cloud[:, :3] only, and then index the whole cloud with the mask.",
)
def ignores_intensity(drop_invalid: Callable) -> None:
    cloud = np.vstack([_GOOD, _GOOD, _ZERO])
    cloud[:3, 3] = _NAN, _INF, 0.0
    good = np.arange(len(cloud)) < 2 * len(_GOOD)
    assert_rows(drop_invalid(cloud.copy()), cloud, good, view="above")


@visible(
    "drop_invalid",
    weight=2,
    title="Takes three columns, an empty cloud, and one without a good row",
    why="A sensor under snow returns nothing but lost echoes.",
    hint="The same masks serve every case: no special case is needed.",
)
def takes_every_shape_of_scan(drop_invalid: Callable) -> None:
    cloud, good = _mixed(_ZERO, _LOST)
    assert_rows(drop_invalid(cloud[:, :3].copy()), cloud[:, :3], good, view="above")
    for rows in (_ZERO, _LOST, _ZERO[:0], _LOST[:0, :3]):
        assert_rows(drop_invalid(rows.copy()), rows, np.zeros(len(rows), dtype=bool), view="above")


@visible(
    "drop_invalid",
    weight=1,
    title="Leaves its input untouched",
    why="Whoever looks for a broken beam needs the lost returns.",
    hint="cloud[mask] is already a new array. Do not assign into cloud.",
)
def leaves_the_scan(drop_invalid: Callable) -> None:
    cloud, good = _mixed(_ZERO, _LOST)
    assert_untouched(drop_invalid, cloud)
    assert_rows(drop_invalid(cloud.copy()), cloud, good, view="above")
