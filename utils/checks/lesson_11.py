"""Visible checks of lesson 11: `principal_axes`, `smallest_rectangle_yaw` and `get_oriented_boxes`.

`smallest_rectangle_yaw` gives no points, so it can be skipped.
"""

import contextlib
import functools
import itertools
from collections.abc import Callable, Sequence

import numpy as np

from utils.checks import common_box_checks, common_checks
from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    assert_untouched,
    brief_text,
    frozen,
    precondition,
)
from utils.checks.boxes import (
    assert_contains_points,
    assert_headings,
    assert_heights,
    assert_snug,
    assert_upright,
    same_corners,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed
from utils.checks.run_cache import once_per_run

_NAMES = ("longest", "middle", "shortest")
_MIN_COSINE = np.cos(np.radians(1.0))


def _turn(points: np.ndarray, degrees: float) -> np.ndarray:
    """Return points, shape (n, 3), turned anticlockwise about z."""
    cosine, sine = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    x, y, z = points.T
    return np.column_stack([cosine * x - sine * y, sine * x + cosine * y, z])


def _grid(length: float, width: float, height: float, steps: int = 4) -> np.ndarray:
    """Return points that fill a block around the origin, corners included; shape (steps**3, 3)."""
    half = np.linspace(-0.5, 0.5, steps)
    return np.array(list(itertools.product(length * half, width * half, height * half)))


# ---- principal_axes ----

# The small example of the lesson: points 2 m ahead and behind, 1 m to either side, and 0.5 m up and
# down.
_CROSS = frozen(np.vstack([np.diag([2.0, 1.0, 0.5]), -np.diag([2.0, 1.0, 0.5])]))
# Several headings, because a library may happen to return right-handed axes for one of them.
_TURNS = (20, 65, 110, 155, 200, 245, 290, 335)
# Length, width and height of a long, a tall and a thin block. The blocks are centred, because
# another check tests other positions.
_SIDES = ((4.2, 1.8, 1.0), (1.0, 2.0, 6.0), (5.0, 0.6, 2.4))


def as_axes(answer: object) -> np.ndarray:
    """Convert an answer to three directions of any length, in columns.

    Returns
    -------
    numpy.ndarray, shape (3, 3)

    Raises
    ------
    CheckFailed
        If the answer has another shape or contains numbers that are not finite.
    """
    axes = as_array(answer, description="three axes, one in each column")
    if axes.shape != (3, 3):
        message = fixed(
            "Three axes with three components each form a 3 x 3 matrix, however many points there "
            "are."
        )
        if axes.shape == (4, 4):
            message = "Intensity is not a direction in space. Use only the first three columns."
        elif axes.ndim == 2 and axes.shape[0] == axes.shape[1] > 4:
            message += (
                " q @ q.T has a row and a column for each point, and so does np.cov(q), which "
                "treats each row as a variable. Use q.T @ q or np.cov(q, rowvar=False)."
            )
        raise WrongForm(message, yours=f"shape {axes.shape}", expected="shape (3, 3)")
    if not np.isfinite(axes).all():
        raise CheckFailed("Some components of the axes are not finite.", yours=brief_text(axes))
    return axes.astype(float)


def assert_directions(answer: object, expected: np.ndarray, input_text: str | None = None) -> None:
    """Assert that each expected axis is parallel to some column, whatever its sign and length.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (3, k)
        The first k axes, in columns by decreasing spread. The spreads must differ clearly.
    input_text : str, optional
        The input of the function, for the message.
    """
    axes = as_axes(answer)
    lengths = np.linalg.norm(axes, axis=0)
    cosines = np.abs(expected.T @ (axes / np.where(lengths > 0, lengths, 1)))
    missing = np.flatnonzero(cosines.max(axis=1) < _MIN_COSINE)
    if not len(missing):
        return
    axis = missing[0]
    nearest = cosines[axis].argmax()
    angle = np.degrees(np.arccos(min(cosines[axis, nearest], 1)))
    raise CheckFailed(
        f"No column runs along the {_NAMES[axis]} direction of the points.",
        input_text=input_text,
        yours=f"the closest column, {_axis_text(axes[:, nearest])}, is {angle:.0f}° off",
        expected=f"a column {_axis_text(expected[:, axis])}, or its negative",
    )


def assert_sorted_by_spread(
    answer: object, points: np.ndarray, input_text: str | None = None
) -> None:
    """Assert that the spread of the points along the columns decreases from left to right.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3)
    input_text : str, optional
        The input of the function, for the message.
    """
    axes = as_axes(answer)
    spread = np.std(points @ (axes / np.linalg.norm(axes, axis=0)), axis=0)
    if (np.diff(spread) > 1e-3 * spread.max()).any():
        raise CheckFailed(
            "The columns are not sorted by the spread of the points along them.",
            input_text=input_text,
            yours=f"standard deviations {brief_text(spread)}",
            expected=f"the largest first, {brief_text(np.sort(spread)[::-1])}",
        )


def assert_right_handed(answer: object) -> None:
    """Assert that the determinant of the axes is not negative."""
    axes = as_axes(answer)
    if np.linalg.det(axes) < 0:
        raise CheckFailed(
            "The axes are left-handed: they describe a reflection, not a rotation.",
            yours=f"determinant {np.linalg.det(axes):.2f}",
            expected="determinant 1",
        )


def assert_orthonormal(answer: object) -> None:
    """Assert that the columns have length 1 and are at right angles to each other."""
    axes = as_axes(answer)
    lengths = np.linalg.norm(axes, axis=0)
    if np.abs(lengths - 1).max() > 1e-3:
        raise CheckFailed(
            fixed("Not every axis has length 1."),
            yours=f"lengths {brief_text(lengths)}",
            expected="1, 1 and 1",
        )
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-3:
        raise CheckFailed("The axes are not at right angles to each other.", yours=brief_text(axes))


def _axes_of(sides: Sequence[float], degrees: float) -> np.ndarray:
    """Return the axes of a block turned about z, in columns by decreasing spread."""
    return _turn(np.eye(3), degrees).T[:, np.argsort(sides)[::-1]]


def _axis_text(axis: np.ndarray) -> str:
    return brief_text(np.round(axis, 3) + 0.0)


def _block_text(sides: Sequence[float], degrees: float) -> str:
    size = " x ".join(f"{side:g}" for side in sides)
    return f"a block of {size} m, turned by {degrees}°"


def _rotation(yaw: float, pitch: float, roll: float) -> np.ndarray:
    """Return the rotation matrix for three angles in degrees; its columns are the rotated axes."""
    (cos_roll, sin_roll), (cos_pitch, sin_pitch) = (
        (np.cos(np.radians(angle)), np.sin(np.radians(angle))) for angle in (roll, pitch)
    )
    about_x = np.array([[1, 0, 0], [0, cos_roll, -sin_roll], [0, sin_roll, cos_roll]])
    about_y = np.array([[cos_pitch, 0, sin_pitch], [0, 1, 0], [-sin_pitch, 0, cos_pitch]])
    return _turn(np.eye(3), yaw).T @ about_y @ about_x


# With so many rotations, any library returns left-handed axes for some of them.
_ROTATIONS = tuple(
    frozen(_rotation(yaw, pitch, roll))
    for yaw, pitch, roll in itertools.product((20, 110, 200, 290), (-25, 35), (-30, 40))
)
_LEANING_TEXT = "a block of {:g} x {:g} x {:g} m that leans forwards and to the side".format(
    *_SIDES[0]
)


@once_per_run
def require_directions(principal_axes: Callable) -> None:
    """Assert that the function finds the directions of a turned block; raise `NotYet` if not."""
    with precondition("the columns run along the length, width and height of a block"):
        for sides in _SIDES:
            block = _turn(_grid(*sides), 25)
            assert_directions(principal_axes(block), _axes_of(sides, 25))


@visible_check(
    "principal_axes",
    weight=4,
    title="Returns columns along the length, width and height of a block",
    why="The axes become the sides of the box. If they are wrong, the box is turned the wrong way.",
    hint="Return the eigenvectors of the covariance matrix, one in each column. For centred "
    "points q, this matrix is q.T @ q / len(q).",
)
def finds_the_directions(principal_axes: Callable) -> None:
    assert_directions(
        principal_axes(_turn(_CROSS, 30)),
        _turn(np.eye(3), 30).T,
        "six points, 2 m ahead and behind, 1 m left and right, 0.5 m up and down, turned by 30°",
    )
    for sides in _SIDES:
        for degrees in (25, 50, 140):
            block = _turn(_grid(*sides), degrees)
            assert_directions(
                principal_axes(block), _axes_of(sides, degrees), _block_text(sides, degrees)
            )


@visible_check(
    "principal_axes",
    weight=4,
    title="Returns columns along the sides of a block that leans",
    why="On a hill, a car leans with the road, and its axes must lean with it.",
    hint="Treat x, y and z alike. Each axis is a column of the matrix, so if you reorder or flip "
    "axes, move or flip whole columns.",
)
def finds_leaning_directions(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    for axes in _ROTATIONS:
        answer = principal_axes(_grid(*_SIDES[0]) @ axes.T)
        try:
            assert_directions(answer, axes, _LEANING_TEXT)
        except CheckFailed as failure:
            if (row := _flipped_row(answer, axes)) is not None:
                failure.hint = (
                    f"Only the signs in row {row} are wrong. To reverse one axis, flip a column: "
                    "axes[:, 2] = -axes[:, 2]. axes[2] is a row."
                )
            raise


def _flipped_row(answer: object, expected: np.ndarray) -> int | None:
    """Return the row in which only the signs are wrong, or None."""
    for row in range(3):
        mirror = np.where(np.arange(3) == row, -1.0, 1.0)[:, None]
        with contextlib.suppress(CheckFailed):
            assert_directions(mirror * as_axes(answer), expected)
            return row
    return None


@visible_check(
    "principal_axes",
    weight=7,
    title="Sorts the axes from the largest spread to the smallest",
    why="The first axis becomes the heading of the car. In another order, the box is turned "
    "sideways.",
    hint="Reverse the columns, axes[:, ::-1], because np.linalg.eigh returns the variances in "
    "ascending order. np.linalg.eig returns them in no particular order, so sort them.",
)
def orders_by_spread(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    for sides in _SIDES:
        for degrees in (0, 25, 80):
            block = _turn(_grid(*sides), degrees)
            assert_sorted_by_spread(
                principal_axes(block.copy()), block, _block_text(sides, degrees)
            )


@visible_check(
    "principal_axes",
    weight=10,
    title="Returns right-handed axes for every heading",
    why="Left-handed axes describe a reflection. If you treat a reflection as a rotation, you "
    "compute wrong angles.",
    hint="If np.linalg.det(axes) is negative, flip the sign of one column. Do this last, because "
    "reversing the order of three columns also changes the sign of the determinant.",
)
def stays_right_handed(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    for sides in _SIDES:
        for index, degrees in enumerate(_TURNS):
            block = _turn(_grid(*sides), degrees)
            assert_right_handed(principal_axes(block[:, [2, 0, 1]] if index % 2 else block))


@visible_check(
    "principal_axes",
    weight=6,
    title="Returns axes of length 1 at right angles to each other",
    why="If an axis is longer than 1, the measured box is too large.",
    hint="Return the unit vectors of np.linalg.eigh or np.linalg.svd as they are, and do not "
    "multiply them by the spread.",
)
def has_unit_length(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    for sides in _SIDES:
        assert_orthonormal(principal_axes(_turn(_grid(*sides), 65)))


@visible_check(
    "principal_axes",
    weight=7,
    title="Returns the same axes wherever the cluster is",
    why="Without centring, the first axis points from the sensor to the car.",
    hint="Subtract points.mean(axis=0), the mean over the rows, from the points.",
)
def centres_the_points(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    sides = _SIDES[0]
    for place in ([25.0, 3.0, -1.0], [-8.0, -19.0, 4.0]):
        answer = principal_axes(_turn(_grid(*sides), 50) + place)
        assert_directions(
            answer,
            _axes_of(sides, 50),
            f"{_block_text(sides, 50)}, with its centre at {brief_text(place)}",
        )


@functools.cache
def _vehicles() -> tuple[tuple[str, np.ndarray, np.ndarray], ...]:
    """Return the name, the points and the axes of each vehicle in the lesson's street.

    The points, shape (n, 3), are not centred. The axes, shape (3, 3), are singular vectors in
    columns. A vehicle with two nearly equal spreads is left out, because its axes have no clear
    order.
    """
    from utils.datasets import course_street

    cloud, truth, _ = course_street()
    cloud = cloud[:, :3]
    near = (cloud[:, 2] >= -1.2) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 20)
    vehicles = []
    for label, kind in zip(truth["box_identities"], truth["box_kinds"], strict=True):
        points = cloud[near & (truth["objects"] == label)]
        if kind not in ("car", "truck") or len(points) < 100:
            continue
        # Keep at most 250 points, so that a function that builds an n x n matrix is not slow.
        points = points[:: -(-len(points) // 250)]
        _, spread, rows = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        if (spread[1:] < 0.9 * spread[:-1]).all():
            vehicles.append(
                (f"{kind} {label}, {len(points):,} points", frozen(points), frozen(rows.T))
            )
    return tuple(vehicles)


def assert_axes(answer: object, expected: np.ndarray, input_text: str | None = None) -> None:
    """Assert that each column is parallel to the expected axis in that column, up to the sign.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (3, 3)
        Axes in columns, by decreasing spread.
    input_text : str, optional
        The input of the function, for the message.
    """
    axes = as_axes(answer)
    lengths = np.linalg.norm(axes, axis=0)
    cosines = np.abs((expected * axes).sum(axis=0)) / np.where(lengths > 0, lengths, 1)
    wrong = np.flatnonzero(cosines < _MIN_COSINE)
    if len(wrong):
        column = wrong[0]
        angle = np.degrees(np.arccos(min(cosines[column], 1)))
        raise CheckFailed(
            f"Column {column} does not run along the {_NAMES[column]} direction of the points.",
            input_text=input_text,
            yours=f"{_axis_text(axes[:, column])}, {angle:.0f}° off",
            expected=f"{_axis_text(expected[:, column])}, or its negative",
        )


@visible_check(
    "principal_axes",
    weight=26,
    title="Returns the right axes for the vehicles of the lesson's street",
    why="The scanner sees only some sides of a vehicle. This check combines all the properties "
    "that the checks above test separately.",
    hint="First make the checks above pass. Then compare your axes of one vehicle with those of "
    "np.linalg.svd, which the lesson uses above the exercise.",
)
def finds_vehicles(principal_axes: Callable) -> None:
    for name, points, axes in _vehicles():
        assert_axes(principal_axes(points.copy()), axes, name)


_TURNED_BLOCK = frozen(_turn(_grid(*_SIDES[0]), 50))
_BLOCK_CASE = Case(
    __name__,
    "principal_axes",
    {"points": _TURNED_BLOCK},
    expected=frozen(_axes_of(_SIDES[0], 50)),
    compare=lambda answer, points, axes: assert_directions(answer, axes),
    precondition=require_directions,
)
common_checks.promise_fourth_column(
    _BLOCK_CASE,
    "ignores_intensity",
    np.linspace(0, 90, len(_TURNED_BLOCK)),
    title="Ignores intensity in a fourth column",
    why="Intensity is not a direction in space, so bright points must not turn the axes.",
    hint="Use only the coordinates, points[:, :3].",
)


@visible_check(
    "principal_axes",
    weight=2,
    title="Works on two points, on a single point and on no points",
    why="A thin post far away may return a single point, and that must not crash the program.",
    hint="If there are no points, return np.eye(3). Otherwise compute q.T @ q / len(q), which is "
    "3 x 3 even for a single centred point q.",
)
def works_on_few_points(principal_axes: Callable) -> None:
    require_directions(principal_axes)
    pair = np.array([[1.5, 2.0, 0.0], [-1.5, -2.0, 0.0]])
    assert_directions(principal_axes(pair.copy()), np.array([[0.6, 0.8, 0.0]]).T, "two points")
    for points in (pair, pair[:1], np.repeat(pair[:1], 3, axis=0), pair[:0]):
        assert_orthonormal(principal_axes(points.copy()))
    # Without points the function computes nothing, so its constant answer must be right-handed.
    # Axes of few points may be mirrored here, because another check tests handedness.
    assert_right_handed(principal_axes(pair[:0].copy()))


common_checks.promise_names(
    _BLOCK_CASE.without_precondition,
    "keeps_the_name",
    title="Keeps the name of its parameter, points",
    why="Other code may call principal_axes(points=...).",
)
common_checks.promise_untouched(
    _BLOCK_CASE.with_first(frozen(_TURNED_BLOCK + [9.0, -4.0, -0.9])),
    "leaves_its_input",
    why="The next step uses the same points.",
    hint="Write points - mean, which creates a new array. points -= mean changes the input.",
)


@note_check(
    "principal_axes",
    title="Returns an array, not a list",
    why="Later cells use principal_axes(points)[:, 0], which does not work on a list.",
)
def returns_an_array(principal_axes: Callable) -> None:
    answer = principal_axes(_grid(*_SIDES[0]))
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The function returns the axes as a {type(answer).__name__}.")


# Blocks away from the origin, each moved exactly along one of its axes. Without centring, that axis
# becomes the first.
_BLOCKS = tuple(
    frozen((_turn(_grid(*sides), degrees) + 8 * _axes_of(sides, degrees)[:, axis],))
    for sides, degrees, axis in zip(_SIDES, (25, 110, 155), (2, 1, 2), strict=True)
)


def _right_axes(points: np.ndarray) -> np.ndarray:
    blocks = zip(_BLOCKS, _SIDES, (25, 110, 155), strict=True)
    return next(
        _axes_of(sides, degrees) for (block,), sides, degrees in blocks if (block == points).all()
    )


def _uncentred_axes(right: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the axes, beginning with the axis that points to the mean of the points."""
    if not len(points):
        return right
    first = np.abs(points.mean(axis=0) @ right).argmax()
    return np.column_stack([right[:, first], np.delete(right, first, axis=1)])


def _same_axes(answer: object, predicted: np.ndarray) -> bool:
    """Return whether two matrices are equal up to the signs of their elements."""
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    return yours.shape == (3, 3) and np.allclose(np.abs(yours), np.abs(predicted), atol=1e-3)


declare_mistakes(
    "principal_axes",
    Mistake(
        "The axes are right, but the columns are in order of increasing spread.",
        lambda right, points: right[:, ::-1],
        "Reverse the columns with axes[:, ::-1], so that the largest variance comes first.",
    ),
    Mistake(
        "The axes are right, but they are in the rows. Each axis should be a column.",
        lambda right, points: right.T,
        "Transpose the axes of np.linalg.svd with .T, because they are rows. The axes of "
        "np.linalg.eigh are already columns.",
    ),
    Mistake(
        "The code reorders the rows of the matrix. Each axis is a column, so it should reorder "
        "the columns.",
        lambda right, points: right[::-1, ::-1],
        "Write axes[:, order], which reorders the columns. axes[order] reorders the rows.",
    ),
    Mistake(
        "The points are not centred, so the first axis points from the sensor to the cluster.",
        _uncentred_axes,
        "Subtract points.mean(axis=0) before anything else.",
    ),
    Mistake(
        "The code divides each coordinate by its spread. The spreads of x and y are then equal, "
        "and the first axis of any turned block is at 45° or −45°.",
        lambda right, points: np.sqrt([[0.5, 0, 0.5], [0.5, 0, 0.5], [0, 1, 0]]),
        "Only subtract the mean; do not divide by the standard deviation.",
    ),
    cases=_BLOCKS,
    right=_right_axes,
    is_same=_same_axes,
)


# ---- smallest_rectangle_yaw ----

_DEGREES = frozen(np.arange(90))
# Points of a car of 4 x 1.8 m from which the scanner sees two sides and a mirror. Most points are
# on the long side, so the first principal axis leans.
_SIDES_AND_MIRROR = frozen(
    np.vstack(
        [
            np.column_stack([np.linspace(0, 4, 11), np.zeros(11), np.linspace(0.2, 1.2, 11)]),
            np.column_stack([np.zeros(4), np.linspace(0.3, 1.8, 4), np.linspace(1.2, 0.3, 4)]),
            [[2.8, 1.3, 0.9]],
        ]
    )
)


def _areas(points: np.ndarray, degrees: object = _DEGREES) -> np.ndarray:
    """Return the area (m²) of the rectangle around points, seen from above, at each angle."""
    places = points[:, 0] + 1j * points[:, 1]
    turned = np.exp(-1j * np.radians(degrees))[..., None] * places
    return np.ptp(turned.real, axis=-1) * np.ptp(turned.imag, axis=-1)


def _as_yaw(answer: object) -> float:
    """Return an answer as a single finite number."""
    yaw = as_array(answer, description="an angle in radians")
    if yaw.shape != ():
        note = ""
        if yaw.shape == (90,):
            note = " These are ninety numbers. Select one of the ninety angles and return it."
        raise WrongForm(
            f"The answer must be a single angle.{note}",
            yours=f"shape {yaw.shape}",
            expected="one angle in radians",
        )
    if not np.isfinite(yaw):
        raise WrongForm("The angle is not finite.", yours=f"{yaw}", expected="an angle in radians")
    return float(yaw)


def _assert_smallest_area(answer: object, points: np.ndarray, input_text: str) -> None:
    """Assert that the rectangle at the returned angle is as small as at the best of 90 angles."""
    yaw, areas = _as_yaw(answer), _areas(points)
    best, area = areas.argmin(), float(_areas(points, np.degrees(yaw)))
    if area > areas[best] * (1 + 1e-4):
        raise CheckFailed(
            "The rectangle at this angle is not the smallest.",
            input_text=input_text,
            yours=f"{yaw:.4f} rad, which is {np.degrees(yaw):.1f}°, with {area:.2f} m²",
            expected=f"{np.radians(best):.4f} rad, which is {best}°, with {areas[best]:.2f} m²",
        )


@visible_check(
    "smallest_rectangle_yaw",
    title="Returns the yaw of a rectangle in radians",
    why="The box is turned by this yaw. At a wrong yaw, the box is larger than the car.",
    hint="Use the index of the smallest area to select one of the angles. The index itself is not "
    "an angle in radians.",
)
def finds_the_yaw_of_a_rectangle(smallest_rectangle_yaw: Callable) -> None:
    for degrees, place in ((30, [0, 0, 0]), (72, [9, -4, -1]), (0, [5, 3, 0]), (89, [-6, 8, 1])):
        points = _turn(_grid(4.0, 2.0, 1.5, steps=2), degrees) + place
        _assert_smallest_area(
            smallest_rectangle_yaw(points.copy()),
            points,
            f"the corners of a block of 4 x 2 m, turned by {degrees}°",
        )


@once_per_run
def _require_yaw_of_a_rectangle(smallest_rectangle_yaw: Callable) -> None:
    with precondition("the function returns the yaw of a rectangle"):
        finds_the_yaw_of_a_rectangle(smallest_rectangle_yaw)


@visible_check(
    "smallest_rectangle_yaw",
    title="Finds the smallest area around parts of a vehicle",
    why="The scanner sees only some sides of a vehicle, so its points do not form a rectangle.",
    hint="Compare the areas that floor_area_at returns for all ninety angles.",
)
def finds_the_smallest_area(smallest_rectangle_yaw: Callable) -> None:
    _require_yaw_of_a_rectangle(smallest_rectangle_yaw)
    for degrees in (20, 65):
        points = _turn(_SIDES_AND_MIRROR, degrees) + [7.0, -3.0, -1.2]
        _assert_smallest_area(
            smallest_rectangle_yaw(points.copy()),
            points,
            f"two sides of a car of 4 x 1.8 m and its mirror, turned by {degrees}°",
        )
    for name, points, _ in _vehicles():
        _assert_smallest_area(smallest_rectangle_yaw(points.copy()), points, name)


@visible_check(
    "smallest_rectangle_yaw",
    title="Ignores intensity in a fourth column",
    why="The lesson calls the function with rows of the cloud, which contain the intensity.",
    hint="Pass the points on to floor_area_at as they are, or use only points[:, :2].",
)
def takes_a_fourth_column(smallest_rectangle_yaw: Callable) -> None:
    _require_yaw_of_a_rectangle(smallest_rectangle_yaw)
    points = _turn(_SIDES_AND_MIRROR, 40)
    bright = np.column_stack([points, np.linspace(0, 90, len(points))])
    _assert_smallest_area(
        smallest_rectangle_yaw(bright), points, "sixteen points with an intensity each"
    )


@visible_check(
    "smallest_rectangle_yaw",
    title="Works on a single point and on points on a line",
    why="A thin post may return a single point. Any angle is right for it.",
    hint="Use the same code for a single point. All areas are 0, and argmin() returns an index.",
)
def finds_a_yaw_for_few_points(smallest_rectangle_yaw: Callable) -> None:
    _require_yaw_of_a_rectangle(smallest_rectangle_yaw)
    line = np.outer(np.linspace(1, 3, 5), [1.0, 0.0, 0.2])
    for points in (line, line[:1]):
        _as_yaw(smallest_rectangle_yaw(points.copy()))


@visible_check(
    "smallest_rectangle_yaw",
    title="Does not change its input",
    why="The next step puts a box around the same points.",
    hint="If you centre the points, write points - mean, which creates a new array. points -= mean "
    "changes the input.",
)
def leaves_the_points(smallest_rectangle_yaw: Callable) -> None:
    assert_untouched(smallest_rectangle_yaw, _turn(_SIDES_AND_MIRROR, 40) + [7.0, -3.0, -1.2])


def _first_axis_yaw(points: np.ndarray) -> float:
    """Return the yaw of the direction in which points are spread most, seen from above."""
    (xx, xy), (_, yy) = np.cov(points[:, 0], points[:, 1])
    return 0.5 * np.arctan2(2 * xy, xx - yy)


def _same_yaw(answer: object, predicted: float) -> bool:
    """Return whether two angles in radians are equal up to quarter turns."""
    try:
        yours = _as_yaw(answer)
    except CheckFailed:
        return False
    return abs((yours - predicted + np.pi / 4) % (np.pi / 2) - np.pi / 4) < 1e-4


declare_mistakes(
    "smallest_rectangle_yaw",
    Mistake(
        "The function returns the index of the smallest area, or its angle in degrees. It should "
        "return the angle in radians.",
        lambda right, points: np.degrees(right),
        "Use the index to select one of the angles, which are in radians.",
    ),
    Mistake(
        "The function returns the angle of the largest area.",
        lambda right, points: np.radians(_areas(points).argmax()),
        "Use argmin(), which finds the smallest area. argmax() finds the largest.",
    ),
    Mistake(
        "The function returns the smallest area instead of its angle.",
        lambda right, points: _areas(points).min(),
        "Use argmin(), which returns the index of the smallest area. min() returns the area "
        "itself.",
    ),
    Mistake(
        "The function returns minus the yaw, which is the angle that turns the rectangle back.",
        lambda right, points: -right,
        "Return the angle from the x axis to a side of the rectangle, anticlockwise as seen from "
        "above.",
    ),
    Mistake(
        "The function returns the yaw of the first principal axis.",
        lambda right, points: _first_axis_yaw(points),
        "Compare the areas of the rectangles at all ninety angles instead.",
    ),
    cases=tuple(
        frozen((_turn(_SIDES_AND_MIRROR * [1, width, 1], degrees) + [7.0, -3.0, -1.2],))
        for width, degrees in ((1.0, 17), (0.9, 62), (1.1, 33), (0.8, 81))
    ),
    right=lambda points: np.radians(_areas(points).argmin()),
    is_same=_same_yaw,
)


# ---- get_oriented_boxes ----

_SIZES = ((5.0, 2.0, 1.4), (6.0, 2.4, 2.2))
_PLACES = ([9.0, -4.0, -0.9], [-7.0, 5.0, -0.6])
_AREAS = tuple(length * width for length, width, _ in _SIZES)
_HEADINGS = (20, 65, 110, 160)
_LABELS = frozen(np.repeat([1, 2], 64))


def _street(*headings: float) -> np.ndarray:
    """Return the points of two blocks with these headings in degrees; shape (128, 3).

    `_LABELS` contains the labels of the points.
    """
    blocks = zip(_SIZES, headings, _PLACES, strict=True)
    return np.vstack([_turn(_grid(*size), heading) + place for size, heading, place in blocks])


# The small example of the lesson: the corners of a rectangle, and one point above its centre.
_FIVE_POINTS = frozen(
    np.array([[2, 1, -1.5], [-2, 1, -1.5], [-2, -1, -1.5], [2, -1, -1.5], [0, 0, 0]], dtype=float)
)

# Points on the front halves of both sides of a block, as fractions of its length, width and
# height. They move the mean away from the centre but do not change the axes.
_FRONT = frozen(
    np.column_stack([np.repeat(np.linspace(0.1, 0.5, 10), 2), [0.5, -0.5] * 10, np.zeros(20)])
)

# Clusters along x and y, for the checks that do not depend on turning.
_STRAIGHT = frozen(_street(0, 0))


@once_per_run
def require_straight_boxes(get_oriented_boxes: Callable) -> None:
    """Assert that the boxes of clusters along x contain their points; raise `NotYet` if not."""
    with precondition("the boxes of two clusters along the x axis contain their points"):
        assert_contains_points(
            get_oriented_boxes(_STRAIGHT.copy(), _LABELS.copy()), _STRAIGHT, _LABELS
        )


def _two_blocks_text(*headings: float) -> str:
    blocks = [
        f"{length:g} x {width:g} m, turned by {heading}°"
        for (length, width, _), heading in zip(_SIZES, headings, strict=True)
    ]
    return f"label 1: a block of {blocks[0]}; label 2: {blocks[1]}"


@visible_check(
    "get_oriented_boxes",
    weight=11,
    title="Returns boxes that contain every point of their clusters",
    why="The car may drive wherever there is no box, so every point of an obstacle must be inside "
    "a box.",
    hint="Turn the points by minus yaw, take minimum and maximum, build the corners, and turn "
    "them by plus yaw.",
)
def contains_all_points(get_oriented_boxes: Callable) -> None:
    # A few points stick out on all four sides, and a box that ignores the outermost points misses
    # them. Most points are in front, so the mean is not the centre.
    outer_tips = np.array([[0.55, 0, 0], [-0.55, 0, 0], [0, 0.6, 0], [0, -0.6, 0]])
    tip_offsets = np.vstack([outer_tips, _FRONT])
    # 30° comes first, because this angle clearly shows how far a box is turned the wrong way.
    for heading in (30, *_HEADINGS, 0):
        tips = [
            _turn(tip_offsets * size, heading) + place
            for size, place in zip(_SIZES, _PLACES, strict=True)
        ]
        street = np.vstack([_street(heading, heading), *tips])
        labels = np.concatenate([_LABELS, np.repeat([1, 2], len(tip_offsets))])
        answer = get_oriented_boxes(street.copy(), labels.copy())
        assert_contains_points(answer, street, labels, _two_blocks_text(heading, heading))


@visible_check(
    "get_oriented_boxes",
    weight=9,
    title="Turns each box with its cluster",
    why="A box along x and y around a diagonal car blocks twice as much of the street as "
    "necessary.",
    hint="Turn the points by minus yaw and the corners by plus yaw. The yaw, in radians, is the "
    "angle with the largest closeness_at or the smallest floor_area_at, or np.arctan2(y, x) of "
    "the first axis seen from above.",
)
def turns_with_the_cluster(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    points, labels = _turn(_FIVE_POINTS, 30) + [8.0, 0.0, 0.0], np.ones(5, dtype=int)
    assert_headings(
        get_oriented_boxes(points.copy(), labels.copy()),
        points,
        labels,
        (30,),
        "five points: the corners of a 4 x 2 m rectangle, turned by 30°, and one above their "
        "centre",
    )
    for heading in _HEADINGS:
        street = _street(heading, heading + 15)
        answer = get_oriented_boxes(street.copy(), _LABELS.copy())
        assert_headings(
            answer,
            street,
            _LABELS,
            (heading, heading + 15),
            _two_blocks_text(heading, heading + 15),
        )


@visible_check(
    "get_oriented_boxes",
    weight=5,
    title="Returns boxes that cover little more ground than their clusters",
    why="The car does not drive on the ground inside a box, so a box that is too large blocks a "
    "free lane.",
    hint="Turn the points by minus yaw before you take their minimum and maximum.",
)
def is_no_larger_than_needed(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    for heading in _HEADINGS:
        street = _street(heading, heading)
        answer = get_oriented_boxes(street.copy(), _LABELS.copy())
        assert_snug(answer, street, _LABELS, _AREAS, _two_blocks_text(heading, heading))


@visible_check(
    "get_oriented_boxes",
    weight=2,
    title="Returns upright boxes with a level floor and roof",
    why="A car stands on the road, but the floor of a leaning box is partly above the road and "
    "partly below it.",
    hint="Turn about z only, so that all four floor corners have the same z, and so do the roof "
    "corners.",
)
def keeps_boxes_upright(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    # The bonnet is low and the boot high, so the first principal axis in space is tilted.
    leaning = _street(0, 0)
    leaning[:, 2] += 0.25 * leaning[:, 0]
    assert_upright(get_oriented_boxes(leaning.copy(), _LABELS.copy()), leaning, _LABELS)


@visible_check(
    "get_oriented_boxes",
    weight=2,
    title="Puts the floor at the lowest point and the roof at the highest",
    why="The floor and the roof of a box show whether the car can drive over a kerb or under a "
    "branch.",
    hint="Put the floor at the smallest z of the cluster, and the roof at the largest.",
)
def reaches_floor_and_roof(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    answer = get_oriented_boxes(_STRAIGHT.copy(), _LABELS.copy())
    assert_heights(answer, _STRAIGHT, _LABELS)


@visible_check(
    "get_oriented_boxes",
    weight=8,
    title="Finds the heading of an object that is taller than it is long",
    why="A pedestrian is longest along z, and this direction says nothing about the heading.",
    hint="Compute the yaw from x and y alone, for example with principal_axes(points * [1, 1, 0]).",
)
def finds_heading_from_above(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    for size, heading, place in (
        ((0.7, 0.3, 1.7), 30, [5.0, -2.0, -0.8]),
        ((1.4, 0.4, 2.6), 100, [-6.0, 4.0, -0.4]),
    ):
        # The block leans slightly, in a direction other than its heading.
        upright = _grid(*size)
        leaning = upright + np.outer(upright[:, 2], [0.04, 0.04, 0.0])
        points, labels = _turn(leaning, heading) + place, np.ones(len(leaning), dtype=int)
        answer = get_oriented_boxes(points.copy(), labels.copy())
        input_text = f"{_block_text(size, heading)}, leaning by 5 cm per metre"
        assert_headings(answer, points, labels, (heading,), input_text)


_BOXES_CASE = Case(
    __name__,
    "get_oriented_boxes",
    {"cloud": _STRAIGHT, "cluster_labels": _LABELS},
    expected=None,
    compare=lambda answer, cloud, labels, _: assert_contains_points(answer, cloud, labels),
    precondition=require_straight_boxes,
)
common_box_checks.promise_label_gaps(
    _BOXES_CASE,
    "allows_gaps",
    [3, 8],
    hint="Loop over np.unique(cluster_labels[cluster_labels > 0]).",
)
common_box_checks.promise_label_order(_BOXES_CASE, "follows_the_labels", [2, 1])
common_box_checks.promise_no_box_for_noise(_BOXES_CASE, "leaves_noise_alone", weight=6)


@visible_check(
    "get_oriented_boxes",
    weight=1,
    title="Works on clusters of one point, of equal points and of points on a line",
    why="A post may return a single point, and a thin wall a line of points. Both are obstacles.",
    hint="Use the same code for every cluster. All eight corners of the box of a single point are "
    "this point.",
)
def works_on_small_clusters(get_oriented_boxes: Callable) -> None:
    require_straight_boxes(get_oriented_boxes)
    line = np.array([3.0, 1.0, 0.0]) + np.outer(np.linspace(0, 2, 9), [1.0, 0.0, 0.0])
    turned_line = _turn(line, 89)  # 89° is the last angle of a search in whole degrees
    points = np.vstack([[[4.0, 4.0, 1.0]], line, np.full((3, 3), -6.0), turned_line])
    labels = np.repeat([1, 2, 3, 4], [1, 9, 3, 9])
    assert_contains_points(get_oriented_boxes(points.copy(), labels.copy()), points, labels)


common_box_checks.promise_empty_result(
    _BOXES_CASE,
    "works_without_clusters",
    hint="End with .reshape(-1, 8, 3), because np.array([]) has shape (0,).",
    weight=2,
)
common_box_checks.promise_intensity_ignored(_BOXES_CASE, "ignores_intensity_in_boxes")
common_checks.promise_names(
    _BOXES_CASE.without_precondition,
    "keeps_the_names",
    why="Other code may call get_oriented_boxes(cloud=..., cluster_labels=...).",
    weight=0.5,
)
common_box_checks.promise_untouched(
    _BOXES_CASE,
    "leaves_cloud_and_labels",
    hint="Select points with cloud[mask, :3], which is already a new array. cloud[:, 2] = 0 "
    "changes the input.",
    weight=0.5,
)


@note_check(
    "get_oriented_boxes",
    title="Returns the four floor corners in order around the box, then the roof corners above "
    "them",
    why="floor_area, a few cells below, measures from corner 0 to 1 and from 1 to 2. If the "
    "corners are in another order, it computes a wrong area.",
)
def orders_the_corners(get_oriented_boxes: Callable) -> None:
    floor, roof = np.split(
        as_array(get_oriented_boxes(_street(20, 20), _LABELS.copy()))[0].astype(float), 2
    )
    if floor[:, 2].max() > roof[:, 2].min():
        raise CheckFailed("The first four corners are not the corners of the floor.")
    sides = np.roll(floor, -1, axis=0) - floor
    if np.abs((sides * np.roll(sides, -1, axis=0)).sum(axis=1)).max() > 0.1:
        raise CheckFailed("The first four corners are not in order around the floor.")
    if np.abs(roof[:, :2] - floor[:, :2]).max() > 1e-2:
        raise CheckFailed(
            fixed("Corners 4 to 7 are not directly above corners 0 to 3 in the same order.")
        )


@note_check(
    "get_oriented_boxes",
    title="Returns the boxes as an array, not as a list",
    why="floor_area, a few cells below, subtracts one corner from another, which does not work "
    "with lists.",
)
def returns_boxes_as_an_array(get_oriented_boxes: Callable) -> None:
    answer = get_oriented_boxes(_STRAIGHT.copy(), _LABELS.copy())
    if isinstance(answer, (list, tuple)):
        raise CheckFailed(f"The function returns the boxes as a {type(answer).__name__}.")


def _make_box(
    centre: np.ndarray, length: float, width: float, height: float, degrees: float
) -> np.ndarray:
    """Return the corners of a turned box, shape (8, 3); the side from 0 to 1 is its length."""
    signs = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2
    floor = np.column_stack([signs * [length, width], np.full(4, -height / 2)])
    return _turn(np.vstack([floor, floor + [0, 0, height]]), degrees) + centre


def _box_parameters(box: np.ndarray) -> tuple[np.ndarray, float, float, float, float]:
    """Return centre, length, width, height and heading (degrees) of a box from `_make_box`."""
    length_side, width_side = box[1] - box[0], box[2] - box[1]
    heading = np.degrees(np.arctan2(length_side[1], length_side[0]))
    length, width = np.linalg.norm(length_side), np.linalg.norm(width_side)
    return box.mean(axis=0), length, width, np.ptp(box[:, 2]), heading


def _enclosing_sides(box: np.ndarray, degrees: float) -> tuple[float, float]:
    """Return the sides of the smallest rectangle around a box, turned by `degrees` from it."""
    _, length, width, _, heading = _box_parameters(box)
    cosine, sine = np.abs([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    return length * cosine + width * sine, length * sine + width * cosine


def _axis_aligned(box: np.ndarray) -> np.ndarray:
    centre, _, _, height, heading = _box_parameters(box)
    return _make_box(centre, *_enclosing_sides(box, heading), height, 0)


def _degrees_as_radians(box: np.ndarray) -> np.ndarray:
    """Return the box if its heading, in whole degrees from 0 to 89, is mistaken for radians."""
    centre, _, _, height, heading = _box_parameters(box)
    yaw = np.degrees(np.round(heading) % 90)
    return _make_box(centre, *_enclosing_sides(box, yaw - heading), height, yaw)


def _turned_by_45(box: np.ndarray) -> np.ndarray:
    centre, _, _, height, heading = _box_parameters(box)
    return _make_box(centre, *_enclosing_sides(box, 45), height, heading + 45)


def _negative_heading(box: np.ndarray) -> np.ndarray:
    centre, _, _, height, heading = _box_parameters(box)
    return _make_box(centre, *_enclosing_sides(box, 2 * heading), height, -heading)


def _turned_twice(box: np.ndarray) -> np.ndarray:
    centre, _, _, height, heading = _box_parameters(box)
    moved_centre = _turn(centre[None], 2 * heading)[0]
    return _make_box(moved_centre, *_enclosing_sides(box, 2 * heading), height, heading)


def _prediction_turned_about_sensor(times: int) -> Callable:
    """Return the prediction of the right boxes, turned about the sensor by `times` headings."""
    return lambda right, cloud, labels: np.stack(
        [_turn(box, times * _box_parameters(box)[4]) for box in right]
    )


def _prediction_with_changed_boxes(change: Callable) -> Callable:
    return lambda right, cloud, labels: np.stack([change(box) for box in right])


def _predict_boxes_around_mean(
    right: np.ndarray, cloud: np.ndarray, labels: np.ndarray
) -> np.ndarray:
    """Return boxes of the right size, centred on the means of their points."""
    means = [cloud[labels == label, :3].mean(axis=0) for label in (1, 2)]
    return right + (np.array(means) - right.mean(axis=1))[:, None]


def _lopsided_street(*headings: float) -> np.ndarray:
    """Return the two blocks with more points in front, and a point of label 0."""
    sides = [
        _turn(_FRONT * size, heading) + place
        for size, place, heading in zip(_SIZES, _PLACES, headings, strict=True)
    ]
    return np.vstack([_street(*headings), *sides, [[30.0, 20.0, 4.0]]])


_TWO_HEADINGS = ((20, 65), (35, 10), (75, 55))
_LOPSIDED_LABELS = frozen(np.concatenate([_LABELS, np.repeat([1, 2], len(_FRONT)), [0]]))
_STREETS = tuple(
    frozen((_lopsided_street(*headings), _LOPSIDED_LABELS)) for headings in _TWO_HEADINGS
)


def _right_boxes(cloud: np.ndarray, labels: np.ndarray) -> np.ndarray:
    headings = next(
        pair
        for pair, (street, _) in zip(_TWO_HEADINGS, _STREETS, strict=True)
        if (street == cloud).all()
    )
    blocks = zip(_PLACES, _SIZES, headings, strict=True)
    return np.stack([_make_box(np.array(place), *size, heading) for place, size, heading in blocks])


def _same_boxes(answer: object, predicted: np.ndarray) -> bool:
    """Return whether boxes have the same corners, in any order and up to half a turn.

    An axis may point forwards or backwards, so a yaw may differ by half a turn.
    """
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    return yours.shape == predicted.shape and all(
        same_corners(mine, box) or same_corners(mine * [-1, -1, 1], box)
        for mine, box in zip(yours, predicted, strict=True)
    )


declare_mistakes(
    "get_oriented_boxes",
    Mistake(
        "The boxes are not turned: their sides are parallel to x and y.",
        _prediction_with_changed_boxes(_axis_aligned),
        "Turn the points by minus yaw before you take their minimum and maximum.",
    ),
    Mistake(
        "The code turns both points and corners by minus yaw. It should turn the corners back by "
        "plus yaw.",
        _prediction_turned_about_sensor(-2),
        "Turn the points by minus yaw and the corners by plus yaw.",
    ),
    Mistake(
        "The code turns both points and corners by plus yaw. It should turn the points by minus "
        "yaw.",
        _prediction_with_changed_boxes(_turned_twice),
        "Turn the points by minus yaw and the corners by plus yaw.",
    ),
    Mistake(
        "The code does not turn the corners back, so the boxes are around the turned points, not "
        "around the cluster.",
        _prediction_turned_about_sensor(-1),
        "After you have built the corners from minimum and maximum, turn them by plus yaw.",
    ),
    Mistake(
        "The code turns the boxes by minus the heading. It should turn them by plus the heading.",
        _prediction_with_changed_boxes(_negative_heading),
        "Turn the points by minus yaw first, and the corners by plus yaw afterwards. If you use "
        "np.arctan2, pass y first and then x, from one column of the axes.",
    ),
    Mistake(
        "The boxes are the largest rectangles around their points, not the smallest, so they are "
        "off by 45°.",
        _prediction_with_changed_boxes(_turned_by_45),
        "Use np.argmin, which finds the smallest area. np.argmax finds the largest.",
    ),
    Mistake(
        "The code uses an angle in degrees, or the index of the smallest area, as an angle in "
        "radians.",
        _prediction_with_changed_boxes(_degrees_as_radians),
        "Write angles[areas.argmin()], not areas.argmin(). For 30°, write np.radians(30).",
    ),
    Mistake(
        "The code centres each box on the mean of its points, which is closer to the side with "
        "more points.",
        _predict_boxes_around_mean,
        "Put the centre halfway between minimum and maximum.",
    ),
    Mistake(
        "Label 0 also gets a box, but it is not an obstacle.",
        lambda right, cloud, labels: np.concatenate(
            [np.repeat(cloud[labels == 0], 8, axis=0)[None], right]
        ),
        "Keep only labels > 0.",
    ),
    cases=_STREETS,
    right=_right_boxes,
    is_same=_same_boxes,
)
