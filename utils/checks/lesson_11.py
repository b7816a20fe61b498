"""Visible checks of lesson 11: `principal_axes` and `get_oriented_boxes`."""

from collections.abc import Callable, Sequence

import numpy as np

from utils.checks.boxes import as_cluster_boxes, assert_turned_boxes
from utils.checks.core import visible
from utils.checks.vocabulary import CheckFailed, as_array, assert_untouched, brief, frozen

_NAMES = ("first", "second", "third")


def _turn(points: np.ndarray, degrees: float) -> np.ndarray:
    """Points (n, 3) turned about z, anticlockwise."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y, z = points.T
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, z])


def _grid(length: float, width: float, height: float, steps: int = 7) -> np.ndarray:
    """(steps^3, 3): a solid block around the origin, its corners included."""
    half = np.linspace(-0.5, 0.5, steps)
    return np.stack(np.meshgrid(length * half, width * half, height * half), axis=-1).reshape(-1, 3)


# Left-handed answers slip through where a library happens to return a right-handed one, so
# there are several.
_TURNS = (20, 65, 110, 155, 200, 245, 290, 335)
_CAR = frozen(_turn(_grid(4.2, 1.8, 1.4), 35) + [9.0, -4.0, -0.9])
_VAN = frozen(_turn(_grid(5.0, 2.0, 2.2), 130) + [-7.0, 5.0, -0.6])
_STREET = frozen(
    np.column_stack([np.vstack([_CAR, [[30.0, 20.0, 4.0]], _VAN]), np.tile([0.1, 0.9, 0.5], 229)])
)
_LABELS = frozen(np.repeat([1, 0, 2], [343, 1, 343]))
_AREAS = (4.2 * 1.8, 5.0 * 2.0)


def as_axes(answer: object) -> np.ndarray:
    """An answer as three orthonormal, right-handed columns.

    Parameters
    ----------
    answer : object

    Returns
    -------
    numpy.ndarray, shape (3, 3)
    """
    axes = as_array(answer, what="three axes, one in each column")
    if axes.shape == (4, 4):
        raise CheckFailed(
            "Intensity is not a direction in space: take the first three columns.",
            yours="shape (4, 4)",
            expected="shape (3, 3)",
        )
    if axes.shape != (3, 3):
        raise CheckFailed(
            "Three axes of three components are a 3 x 3 matrix, however many points there are.",
            yours=f"shape {axes.shape}",
            expected="shape (3, 3)",
        )
    if not np.isfinite(axes).all():
        raise CheckFailed("Some components are not finite.", yours=brief(axes))
    axes = axes.astype(float)
    lengths = np.linalg.norm(axes, axis=0)
    if np.abs(lengths - 1).max() > 1e-3:
        raise CheckFailed(
            "Each axis must have length 1.",
            yours=f"lengths {brief(lengths)}",
            expected="1, 1 and 1",
        )
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-3:
        raise CheckFailed("The axes are not at right angles to each other.", yours=brief(axes))
    if np.linalg.det(axes) < 0:
        raise CheckFailed(
            "The axes are left-handed: they mirror, and no car turns into its own mirror image.",
            yours="determinant -1",
            expected="determinant +1",
        )
    return axes


def assert_axes(answer: object, expected: np.ndarray) -> None:
    """The columns point along the expected ones, whatever their signs.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (3, 3)
        Axes in columns; the spreads along them must differ clearly.
    """
    axes = as_axes(answer)
    cosines = np.abs(axes.T @ expected)
    off = np.degrees(np.arccos(np.clip(np.diag(cosines), 0, 1)))
    if off.max() <= 1.0:
        return
    if (cosines.max(axis=1) > np.cos(np.radians(1.0))).all():
        raise CheckFailed(
            "These are the right axes in another order.",
            yours=brief(axes),
            expected="in the columns by decreasing spread: " + brief(expected),
        )
    if (np.abs(axes @ expected).max(axis=1) > np.cos(np.radians(1.0))).all():
        raise CheckFailed(
            "The axes stand in the rows; each must be a column.",
            yours=brief(axes),
            expected=brief(expected),
        )
    column = int(off.argmax())
    raise CheckFailed(
        f"The {_NAMES[column]} axis is {off[column]:.0f} degrees off.",
        yours=brief(axes[:, column]),
        expected="plus or minus " + brief(expected[:, column]),
    )


def _axes_of_turn(degrees: float, order: Sequence[int] = (0, 1, 2)) -> np.ndarray:
    return _turn(np.eye(3), degrees).T[:, list(order)]


@visible(
    "principal_axes",
    weight=4,
    title="The first axis points along the longest side, the third along the shortest",
    why="The first axis becomes the heading of the car.",
    hint="np.linalg.eigh gives the variances in ascending order: turn the order of the "
    "columns round, axes[:, ::-1].",
)
def orders_by_spread(principal_axes: Callable) -> None:
    for degrees in (0, 35, 80):
        block = _turn(_grid(4.2, 1.8, 1.0), degrees) + [9.0, -4.0, -0.9]
        assert_axes(principal_axes(block.copy()), _axes_of_turn(degrees))
    tower = _turn(_grid(1.0, 2.0, 6.0), 25)
    assert_axes(principal_axes(points=tower.copy()), _axes_of_turn(25, (2, 1, 0)))


@visible(
    "principal_axes",
    weight=3,
    title="The axes are right-handed for every heading",
    why="A left-handed triple is a reflection. Read as a rotation it gives nonsense angles.",
    hint="Where np.linalg.det(axes) is negative, flip the sign of one column.",
)
def stays_right_handed(principal_axes: Callable) -> None:
    for degrees in _TURNS:
        block = _turn(_grid(4.2, 1.8, 1.0), degrees)
        assert_axes(principal_axes(block.copy()), _axes_of_turn(degrees))
        assert_axes(principal_axes(block[:, [2, 0, 1]]), _axes_of_turn(degrees)[[2, 0, 1]])


@visible(
    "principal_axes",
    weight=2,
    title="Where the cluster stands does not matter",
    why="Without centring, the first axis points from the sensor to the car.",
    hint="Subtract points.mean(axis=0), and do not divide by the standard deviation: that "
    "would make all directions equal.",
)
def centres_the_points(principal_axes: Callable) -> None:
    block = _turn(_grid(4.2, 1.8, 1.0), 50)
    for place in ([0.0, 0.0, 0.0], [25.0, 3.0, -1.0], [-8.0, -19.0, 4.0]):
        assert_axes(principal_axes(block + place), _axes_of_turn(50))


@visible(
    "principal_axes",
    weight=2,
    title="Takes a fourth column and leaves its input untouched",
    why="Intensity is not a direction in space.",
    hint="points[:, :3] are the coordinates. points - mean is a new array; points -= mean is not.",
)
def ignores_intensity(principal_axes: Callable) -> None:
    bright = np.column_stack([_CAR, np.linspace(0, 90, len(_CAR))])
    assert_axes(principal_axes(bright.copy()), _axes_of_turn(35))
    assert_untouched(principal_axes, bright)


@visible(
    "principal_axes",
    weight=2,
    title="Takes two points, one or none",
    why="A thin post far away returns a single point, and the pipeline must not stop.",
    hint="Any right-handed axes will do for a single point, for example np.eye(3). "
    "centred.T @ centred is 3 x 3 for any number of points; np.cov of one point is not "
    "a number.",
)
def takes_few_points(principal_axes: Callable) -> None:
    assert_axes(principal_axes(_CAR.copy()), _axes_of_turn(35))
    for few in (_CAR[:0], _CAR[:1], np.repeat(_CAR[:1], 3, axis=0), np.zeros((0, 4))):
        as_axes(principal_axes(few.copy()))
    pair = np.array([[1.0, 2.0, 0.0], [4.0, 6.0, 0.0]])
    along = np.abs(as_axes(principal_axes(pair.copy()))[:, 0] @ [0.6, 0.8, 0.0])
    if along < 0.999:
        raise CheckFailed(
            "For two points the first axis is the direction from one to the other.",
            yours=f"{np.degrees(np.arccos(min(along, 1))):.0f} degrees off",
        )


@visible(
    "get_oriented_boxes",
    weight=5,
    title="Every point of a cluster is inside its box",
    why="A box is a promise: outside of it the car is free to drive.",
    hint="Turn the points by minus yaw, take minimum and maximum, build the corners, and "
    "turn the corners by plus yaw.",
)
def contains_all_points(get_oriented_boxes: Callable) -> None:
    assert_turned_boxes(
        get_oriented_boxes(_STREET.copy(), _LABELS.copy()), _STREET, _LABELS, _AREAS
    )
    assert_turned_boxes(
        get_oriented_boxes(cloud=_STREET.copy(), cluster_labels=_LABELS.copy()),
        _STREET,
        _LABELS,
        _AREAS,
    )


@visible(
    "get_oriented_boxes",
    weight=4,
    title="Boxes turn with their clusters",
    why="A box along x and y around a diagonal car closes twice the street it needs.",
    hint="The yaw is np.arctan2(y, x) of the first principal axis of the points seen from "
    "above. Is its sign the same in both turns, in opposite directions?",
)
def turns_with_the_cluster(get_oriented_boxes: Callable) -> None:
    for degrees in (20, 45, 75, 120, 160):
        block = _turn(_grid(4.2, 1.8, 1.4), degrees) + [9.0, -4.0, -0.9]
        labels = np.ones(len(block), dtype=int)
        assert_turned_boxes(
            get_oriented_boxes(block.copy(), labels.copy()), block, labels, [4.2 * 1.8]
        )


@visible(
    "get_oriented_boxes",
    weight=3,
    title="Boxes stand upright: turned about z only, floor and roof level",
    why="A car stands on the road. A box that leans lifts its wheels off the ground.",
    hint="Find the yaw from x and y alone, for example with z set to 0; floor and roof are "
    "the smallest and the largest z.",
)
def stands_upright(get_oriented_boxes: Callable) -> None:
    # Bonnet low, boot high: in three dimensions the first axis of this car points upwards.
    leaning = _turn(_grid(4.2, 1.8, 0.6), 0)
    leaning[:, 2] += 0.25 * leaning[:, 0]
    leaning = _turn(leaning, 55) + [6.0, 3.0, -0.8]
    labels = np.ones(len(leaning), dtype=int)
    assert_turned_boxes(
        get_oriented_boxes(leaning.copy(), labels.copy()), leaning, labels, [4.2 * 1.8]
    )
    # A house front is higher than deep: the second axis in three dimensions is up.
    front = _turn(_grid(9.0, 0.4, 3.0), 65) + [6.0, 9.0, 0.5]
    assert_turned_boxes(get_oriented_boxes(front.copy(), labels.copy()), front, labels, [9.0 * 0.4])
    # A walker is taller than wide: the first axis in three dimensions is up.
    walker = _turn(_grid(0.3, 0.6, 1.7), 30) + [5.0, -2.0, -0.8]
    assert_turned_boxes(get_oriented_boxes(walker.copy(), labels.copy()), walker, labels)


@visible(
    "get_oriented_boxes",
    weight=3,
    title="One box for each label above 0, in ascending order, gaps or not",
    why="The next step wants to know which box is whose.",
    hint="Loop over np.unique(cluster_labels[cluster_labels > 0]).",
)
def one_box_for_each_label(get_oriented_boxes: Callable) -> None:
    swapped = np.array([0, 8, 3])[_LABELS]
    assert_turned_boxes(
        get_oriented_boxes(_STREET.copy(), swapped.copy()), _STREET, swapped, _AREAS[::-1]
    )


@visible(
    "get_oriented_boxes",
    weight=2,
    title="Takes clusters of one point or of points on a line, and no cluster at all",
    why="Posts return single points, thin walls return lines, and empty roads nothing.",
    hint="A box of one point is that point eight times. End with .reshape(-1, 8, 3).",
)
def takes_small_clusters(get_oriented_boxes: Callable) -> None:
    line = np.array([3.0, 1.0, 0.0]) + np.outer(np.linspace(0, 2, 9), [0.8, -0.6, 0.0])
    few = np.vstack([_STREET[:343, :3], [[4.0, 4.0, 1.0]], line, np.full((3, 3), -6.0)])
    labels = np.repeat([6, 1, 2, 4], [343, 1, 9, 3])
    boxes = get_oriented_boxes(few.copy(), labels.copy())
    assert_turned_boxes(boxes, few, labels)
    assert_turned_boxes(
        get_oriented_boxes(_CAR.copy(), _LABELS[:343].copy()), _CAR, _LABELS[:343], _AREAS[:1]
    )
    noise = np.zeros(len(_STREET), dtype=int)
    as_cluster_boxes(get_oriented_boxes(_STREET.copy(), noise.copy()), noise)
    as_cluster_boxes(get_oriented_boxes(np.empty((0, 3)), noise[:0].copy()), noise[:0])


@visible(
    "get_oriented_boxes",
    weight=1,
    title="Leaves cloud and labels untouched",
    why="The next step still needs them.",
    hint="cloud[mask, :3] is already a new array; cloud[:, 2] = 0 is not.",
)
def leaves_its_input(get_oriented_boxes: Callable) -> None:
    assert_untouched(get_oriented_boxes, _STREET, _LABELS)
    boxes = get_oriented_boxes(_STREET.copy(), _LABELS.copy())
    assert_turned_boxes(boxes, _STREET, _LABELS, _AREAS)
