"""Visible checks of lesson 07: `filter_by_distance`, `crop_region`, `remove_ego_returns`.

Each check covers one property. `assert_points_left` and `assert_points_left_by_box` compare only
which points are left; separate checks cover the order of the rows and their intensity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from utils.checks import common_checks, common_row_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    assert_positions,
    brief_text,
    frozen,
    parse_marked_points,
    parse_table,
    points_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.run_cache import once_per_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Low, dim points ahead of the car on the left, in no particular order. All are so near or so far
# that every measure of distance in the plane gives the same answer: separate checks cover
# directions, corners, heights and intensities.
_SCATTERED, _NEAR = parse_marked_points(
    "6 0.5 -1.5 0.2 +; 2 15 0.2 0.8 -; 3 6 -0.9 0.9 +; 14 1 -1.1 0.3 -; 11 11.5 -1 0.4 -; "
    "1.5 8 0.3 0.6 +; 4 4 -0.4 0.5 +; 12 4 -0.7 0.1 -"
)

_MINIMUM, _MAXIMUM = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
# Each point is inside the box, or outside it on all three axes: above the maximum on at least one
# axis and below the minimum on another.
_CROP_CLOUD, _INSIDE = parse_marked_points(
    "1 2 -1 0.5 +; -12 -8 1.5 0.2 -; 28 -4 0.5 0.1 +; 40 -9 1.6 0.3 -; 33 7 -2.4 0.4 -; "
    "-9 5.5 0.9 0.9 +; -15 7 -2.6 0.6 -; 12 0 -1.9 0.4 +"
)
_EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
# Returns of the ego car, and others that are outside its box on all three axes: above the maximum
# on one axis and below the minimum on another.
_EGO_CLOUD, _IS_EGO = parse_marked_points(
    "-1.3 0.4 -0.6 0.3 +; 5 -3 0.5 0.4 -; 1 -1 -0.5 0.5 +; -2 -2 0.3 0.2 -; "
    "12 -4.2 -1.4 0.7 -; 0.9 1 -0.9 0.5 +; -3 8 -1.6 0.9 -"
)
# y falls as x rises, both in these points and in the boxes built from _LIMITS. Each point is
# therefore inside such a box on all three axes or on none.
_DIAGONAL = frozen(
    np.column_stack([np.arange(6.0), 5 - np.arange(6.0), np.arange(6.0), np.ones(6)])
)
# Points along the diagonal of a cube that does not contain the sensor, so that a function that
# doubles a corner by mistake returns different rows.
_CUBE_DIAGONAL = frozen(np.column_stack([*[np.arange(6.0)] * 3, np.ones(6)]))
_CUBE = (1.5, 1.5, 1.5), (3.5, 3.5, 3.5)
_LIMITS = (1.5, 3.5), (-0.5, 2.5), (3.5, 9.0)  # lower and upper limits of x and z


def assert_points_left(
    answer: object, cloud: np.ndarray, distance: float, near: np.ndarray, view: str = "above"
) -> None:
    """Assert that the points of ``cloud[near]`` are left, in any order.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    distance : float
        Largest horizontal distance of a point that stays, in metres.
    near : numpy.ndarray of bool, shape (n,)
        True for the points that stay.
    view : {"above", "side"}
        Viewpoint of the picture.
    """
    outline = _draw_circle if view == "above" else _draw_limits
    settings = f"distance {distance:g}"
    _assert_remaining(answer, cloud, near, settings, view, lambda axes: outline(axes, distance))


def _assert_any_corner_type(function: Callable, kind: Callable) -> None:
    """Assert that corners of type `kind` give the same rows as tuples, right or wrong."""
    with_tuples, with_kind = (
        as_array(function(_CUBE_DIAGONAL.copy(), *corners), description="the rows")
        for corners in (_CUBE, map(kind, _CUBE))
    )
    if not np.array_equal(with_tuples, with_kind):
        raise CheckFailed(
            "The function returns different rows when the same corners are passed as "
            f"{'lists' if kind is list else 'arrays'} instead of tuples.",
            input_text=f"six points on a line, and corners {brief_text(kind(_CUBE[0]))} and "
            f"{brief_text(kind(_CUBE[1]))}",
            yours=f"{len(with_kind)} rows",
            expected=f"{len(with_tuples)} rows, as with tuples",
        )


def assert_points_left_by_box(
    answer: object,
    cloud: np.ndarray,
    minimum: Sequence[float],
    maximum: Sequence[float],
    keep: np.ndarray,
    view: str = "above",
) -> None:
    """Assert that the points of ``cloud[keep]`` are left, in any order.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    minimum, maximum : sequence of float
        The x, y and z of two opposite corners of the box, for the message and the picture.
    keep : numpy.ndarray of bool, shape (n,)
        True for the points that stay, either those inside the box or those outside it.
    view : {"above", "side"}
        Viewpoint of the picture.
    """
    columns = [0, 1] if view == "above" else [0, 2]
    low, high = np.array(minimum)[columns], np.array(maximum)[columns]
    corners = "minimum {}, maximum {}".format(*map(points_text, ([minimum], [maximum])))
    _assert_remaining(
        answer, cloud, keep, corners, view, lambda axes: _draw_rectangle(axes, low, high)
    )


def _assert_remaining(
    answer: object,
    cloud: np.ndarray,
    keep: np.ndarray,
    settings: str,
    view: str,
    outline: Callable,
) -> None:
    """Call `assert_positions`; draw the border into its picture and describe a small cloud."""
    is_small = len(cloud) <= 8
    input_text = f"points {points_text(cloud)}, {settings}" if is_small else None
    try:
        assert_positions(answer, cloud, keep, view, input_text, points_text if is_small else None)
    except CheckFailed as failure:
        if difference := failure.draw:
            failure.draw = lambda: outline(difference())
        raise


def _draw_circle(axes: Axes, distance: float) -> None:
    from matplotlib.patches import Circle

    axes.add_patch(Circle((0, 0), distance, fill=False, edgecolor="black", linestyle="--"))
    _widen_limits(axes, (-distance, -distance), (distance, distance))


def _draw_limits(axes: Axes, distance: float) -> None:
    for x in (-distance, distance):
        axes.axvline(x, color="black", linestyle="--")


def _draw_rectangle(axes: Axes, low: np.ndarray, high: np.ndarray) -> None:
    from matplotlib.patches import Rectangle

    axes.add_patch(Rectangle(low, *(high - low), fill=False, edgecolor="black", linestyle="--"))
    _widen_limits(axes, low, high)


def _widen_limits(axes: Axes, low: Sequence[float], high: Sequence[float]) -> None:
    """Widen the limits of the axes until the whole border is visible."""
    margin = 0.05 * np.subtract(high, low)
    (left, bottom), (right, top) = low - margin, high + margin
    axes.set_xlim(min(axes.get_xlim()[0], left), max(axes.get_xlim()[1], right))
    axes.set_ylim(min(axes.get_ylim()[0], bottom), max(axes.get_ylim()[1], top))


@once_per_run
def require_near_points_kept(filter_by_distance: Callable) -> None:
    """Assert that near points stay and far ones are removed; raise `NotYet` if not."""
    with precondition("near points stay and far points are removed"):
        assert_points_left(filter_by_distance(_SCATTERED.copy(), 10.0), _SCATTERED, 10.0, _NEAR)


@once_per_run
def require_crop(crop_region: Callable) -> None:
    """Assert that only points inside the box stay; raise `NotYet` if not."""
    with precondition("points inside the box stay and points outside are removed"):
        answer = crop_region(_CROP_CLOUD.copy(), _MINIMUM, _MAXIMUM)
        assert_points_left_by_box(answer, _CROP_CLOUD, _MINIMUM, _MAXIMUM, _INSIDE)


@once_per_run
def require_ego_removed(remove_ego_returns: Callable) -> None:
    """Assert that only points inside the box are removed; raise `NotYet` if not."""
    with precondition("points inside the box are removed and points outside stay"):
        assert_points_left_by_box(
            remove_ego_returns(_EGO_CLOUD.copy(), *_EGO_BOX), _EGO_CLOUD, *_EGO_BOX, ~_IS_EGO
        )


@visible_check(
    "filter_by_distance",
    weight=4,
    title="Keeps near points and removes far ones",
    why="Points far away cost computing time, and the car can stop long before it reaches them.",
    hint="Square x and y, add them and take the square root: this gives one distance per point. "
    "Keep the points whose distance is at most `distance`.",
)
def keeps_near_points(filter_by_distance: Callable) -> None:
    assert_points_left(filter_by_distance(_SCATTERED.copy(), 10.0), _SCATTERED, 10.0, _NEAR)


@visible_check(
    "filter_by_distance",
    weight=3,
    title="Works in all directions: ahead, behind, left and right",
    why="A car may overtake from behind, and a pedestrian may step out on either side.",
    hint="Square x and y, because squaring removes the sign. x is negative behind the car, and y "
    "on its right.",
)
def works_in_all_directions(filter_by_distance: Callable) -> None:
    require_near_points_kept(filter_by_distance)
    cloud, near = parse_marked_points(
        "-6 2 +; -14 1 -; -3 -6 +; 3 -13 -; 2 -7 +; -11 -12 -", -0.5, 0.3
    )
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)


@visible_check(
    "filter_by_distance",
    weight=3,
    title="Keeps the points inside a circle",
    why="If you compare x and y separately, the border is a square, and its corners are 41 % too "
    "far away.",
    hint="Use np.hypot(x, y). Neither the larger of |x| and |y| nor their sum is the distance.",
)
def keeps_a_circle(filter_by_distance: Callable) -> None:
    require_near_points_kept(filter_by_distance)
    cloud, near = parse_marked_points("8 8 -; 6.5 6.5 +; 9.5 5 -; 9 3 +", -0.5, 0.3)
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)


@visible_check(
    "filter_by_distance",
    weight=4,
    title="Ignores the height",
    why="From the roof of a lorry, the straight line to a child is longer than the distance along "
    "the road, so the filter would remove the child.",
    hint="Use columns 0 and 1 only. Column 2 is the height.",
)
def ignores_height(filter_by_distance: Callable) -> None:
    require_near_points_kept(filter_by_distance)
    cloud, near = parse_marked_points("11 1 0 0.1 -; 6 2 9 0.1 +; 4 3 -12 0.1 +; 13 2 -0.2 0.1 -")
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near, "side")


@visible_check(
    "filter_by_distance",
    weight=3,
    title="Ignores the intensity",
    why="Some sensors report intensities up to 255. If the distance included intensity, every "
    "bright car would vanish.",
    hint="Use columns 0 and 1 only. Column 3 is the intensity.",
)
def ignores_intensity(filter_by_distance: Callable) -> None:
    require_near_points_kept(filter_by_distance)
    cloud, near = parse_marked_points("6 0.5 0.2 255 +; 12 0.5 0.2 0 -; 2 7 0.2 40 +; 11 6 0.2 3 -")
    try:
        assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)
    except CheckFailed as failure:
        if failure.input_text:
            failure.input_text += ", intensities 255, 0, 40, 3"
        raise


@visible_check(
    "filter_by_distance",
    weight=5,
    title="Uses the parameter distance as the limit",
    why="A fast car needs a longer distance to brake, so it must look farther ahead.",
    hint="Compare with `distance`, not with a fixed number.",
)
def uses_the_distance(filter_by_distance: Callable) -> None:
    cloud = np.array([[x, 0.2, -0.5, 0.3] for x in (9.0, 3.0, 30.0, 6.3, 12.0)])
    for distance in (5.0, 7.5, 11.0, 20.0):
        near = cloud[:, 0] < distance
        assert_points_left(filter_by_distance(cloud.copy(), distance), cloud, distance, near)


_NEAR_CASE = Case(
    __name__,
    "filter_by_distance",
    {"cloud": _SCATTERED, "distance": 10.0},
    expected=_NEAR,
    compare=assert_points_left,
    precondition=require_near_points_kept,
)


@common_checks.promise_default(
    _NEAR_CASE,
    "distance=10.0",
    title="Uses a distance of 10 m by default",
    why="Later cells call filter_by_distance(cloud) and rely on this default.",
    weight=2,
)
def keeps_the_default(filter_by_distance: Callable) -> None:
    cloud = np.array([[x, 0.1, -0.2, 0.3] for x in (9.8, 10.2, 7.0, 13.0)])
    near = np.array([True, False, True, False])
    input_text = f"points {points_text(cloud)}, distance not given"
    assert_positions(
        filter_by_distance(cloud.copy()), cloud, near, "above", input_text, points_text
    )


common_checks.promise_names(
    _NEAR_CASE, "keeps_the_names", why="Other code may call filter_by_distance(cloud, distance=25)."
)
common_row_checks.promise_all_columns(_NEAR_CASE, "keeps_the_columns", weight=2)
common_row_checks.promise_order(_NEAR_CASE, "keeps_the_order", weight=2)
common_checks.promise_three_columns(
    _NEAR_CASE,
    "works_with_three_columns",
    hint="Use only the columns that you need, cloud[:, 0] and cloud[:, 1].",
)
common_row_checks.promise_empty_table(
    _NEAR_CASE,
    "works_on_small_clouds",
    hint="Use the same mask for every cloud: a mask without any True selects no rows.",
    weight=2,
)
common_row_checks.promise_untouched(_NEAR_CASE, "leaves_its_input", weight=2)


@note_check(
    "filter_by_distance",
    title="Keeps points exactly at the distance",
    why="The docstring says <= distance. Measured points are hardly ever exactly at the distance, "
    "so this does not affect your score.",
)
def keeps_points_at_the_distance(filter_by_distance: Callable) -> None:
    cloud, near = parse_marked_points("3 4 -0.5 0.1 +; 6 1 -0.5 0.1 -; 1 2 -0.5 0.1 +")
    assert_points_left(filter_by_distance(cloud.copy(), 5.0), cloud, 5.0, near)


common_row_checks.note_array(_NEAR_CASE, "returns_an_array")


@visible_check(
    "crop_region",
    weight=4,
    title="Keeps points inside the box and removes points outside",
    why="Points on house fronts cost computing time, and the car does not drive there.",
    hint="Compare cloud[:, :3] with minimum and with maximum, combine the two tables with &, "
    "then call .all(axis=1).",
)
def keeps_points_inside(crop_region: Callable) -> None:
    answer = crop_region(_CROP_CLOUD.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, _CROP_CLOUD, _MINIMUM, _MAXIMUM, _INSIDE)


@visible_check(
    "crop_region",
    weight=9,
    title="Removes points that are outside in x only or in y only",
    why="If the function tests only one side of the street, all houses on the other side stay in "
    "the cloud.",
    hint="Compare x, y and z each with its own number in minimum and maximum, and combine the "
    "results with & or .all(axis=1).",
)
def removes_points_outside_in_x_or_y(crop_region: Callable) -> None:
    require_crop(crop_region)
    cloud, keep = parse_marked_points("-11 2 -1 -; 31 2 -1 -; 1 2 -1 +; 1 -6 -1 -; 1 7 -1 -", 0.4)
    assert_points_left_by_box(
        crop_region(cloud.copy(), _MINIMUM, _MAXIMUM), cloud, _MINIMUM, _MAXIMUM, keep
    )


@visible_check(
    "crop_region",
    weight=5,
    title="Removes points below or above the box",
    why="The car drives under a bridge, so it must not brake for one.",
    hint="Compare all of cloud[:, :3]: a point is inside only if x, y and z are all inside.",
)
def removes_points_below_or_above(crop_region: Callable) -> None:
    require_crop(crop_region)
    cloud, keep = parse_marked_points("1 2 -2.5 -; 1 2 -1 +; 1 2 1.5 -", 0.4)
    answer = crop_region(cloud.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, cloud, _MINIMUM, _MAXIMUM, keep, "side")


@note_check(
    "crop_region",
    title="Keeps points on the faces of the box",
    why="Two adjacent boxes must not leave a gap between them: write >= minimum and <= maximum. "
    "Measured points are hardly ever exactly on a face, so this does not affect your score.",
)
def keeps_points_on_faces(crop_region: Callable) -> None:
    require_crop(crop_region)
    on_faces = parse_table("-10 0 0; 30 0 0; 0 -5 0; 0 6 0; 0 0 -2; 0 0 1")
    on_faces = np.column_stack([on_faces, np.full(6, 0.4)])
    answer = crop_region(on_faces.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, on_faces, _MINIMUM, _MAXIMUM, np.full(6, True))


@visible_check(
    "crop_region",
    weight=3,
    title="Uses minimum and maximum as the corners of the box",
    why="A car looks farther ahead on a motorway than in a car park, so the corners of the box "
    "differ.",
    hint="Compare with minimum and maximum, not with fixed numbers.",
)
def uses_the_corners(crop_region: Callable) -> None:
    for low, high in _LIMITS:
        corners = (low, 5 - high, low), (high, 5 - low, high)
        keep = (_DIAGONAL[:, 0] > low) & (_DIAGONAL[:, 0] < high)
        assert_points_left_by_box(
            crop_region(_DIAGONAL.copy(), *corners), _DIAGONAL, *corners, keep
        )


@visible_check(
    "crop_region",
    weight=1,
    title="Accepts corners as tuples, lists or arrays",
    why="A box may come from a configuration file, a map or another array.",
    hint="Write cloud[:, :3] >= minimum. NumPy compares column by column, even if minimum is a "
    "tuple or a list.",
)
def accepts_any_corner_type(crop_region: Callable) -> None:
    require_crop(crop_region)
    for kind in (list, np.array):
        answer = crop_region(_CROP_CLOUD.copy(), kind(_MINIMUM), kind(_MAXIMUM))
        assert_points_left_by_box(answer, _CROP_CLOUD, _MINIMUM, _MAXIMUM, _INSIDE)
        _assert_any_corner_type(crop_region, kind)


_CROP_CASE = Case(
    __name__,
    "crop_region",
    {"cloud": _CROP_CLOUD, "minimum": _MINIMUM, "maximum": _MAXIMUM},
    expected=_INSIDE,
    compare=assert_points_left_by_box,
    precondition=require_crop,
)
common_checks.promise_names(
    _CROP_CASE,
    "names_the_corners",
    why="Other code may call crop_region(cloud, minimum=..., maximum=...).",
)
common_row_checks.promise_all_columns(
    _CROP_CASE, "crops_all_columns", hint="Compare cloud[:, :3], but index cloud itself.", weight=2
)
common_row_checks.promise_order(_CROP_CASE, "crops_in_order")
common_checks.promise_three_columns(
    _CROP_CASE,
    "crops_three_columns",
    hint="Use cloud[:, :3], which works with three columns and with four.",
)
common_row_checks.promise_empty_table(_CROP_CASE, "crops_small_clouds", weight=2)
common_row_checks.promise_untouched(_CROP_CASE, "crop_leaves_its_input")
common_row_checks.note_array(_CROP_CASE, "gives_an_array")


@visible_check(
    "remove_ego_returns",
    weight=4,
    title="Removes points inside the box and keeps points outside",
    why="A return from the ego car's mirror looks like an obstacle that never goes away.",
    hint="Find the rows inside the box as in crop_region, then keep the other rows: "
    "cloud[~inside].",
)
def removes_points_inside(remove_ego_returns: Callable) -> None:
    assert_points_left_by_box(
        remove_ego_returns(_EGO_CLOUD.copy(), *_EGO_BOX), _EGO_CLOUD, *_EGO_BOX, ~_IS_EGO
    )


@visible_check(
    "remove_ego_returns",
    weight=10,
    title="Keeps points that are outside in x only or in y only",
    why="A function that ignores x also removes the car ahead, which has the same y and z as the "
    "ego car.",
    hint="Invert the mask at the very end: cloud[~inside]. A row stays if at least one of its "
    "coordinates is outside.",
)
def keeps_points_outside_in_x_or_y(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    cloud, keep = parse_marked_points(
        "0.5 0 -0.7 -; 9 0 -0.7 +; -4 0 -0.7 +; 0.5 6 -0.7 +; 0.5 -3 -0.7 +", 0.4
    )
    assert_points_left_by_box(remove_ego_returns(cloud.copy(), *_EGO_BOX), cloud, *_EGO_BOX, keep)


@visible_check(
    "remove_ego_returns",
    weight=4,
    title="Keeps points above or below the box",
    why="A sign above the bonnet or a kerb under the bumper is not part of the ego car.",
    hint="Compare all of cloud[:, :3]: a point is inside only if x, y and z are all inside.",
)
def keeps_points_above_or_below(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    cloud, keep = parse_marked_points("0.5 0 2 +; 0.5 0 -0.7 -; 0.5 0 -1.6 +", 0.4)
    assert_points_left_by_box(
        remove_ego_returns(cloud.copy(), *_EGO_BOX), cloud, *_EGO_BOX, keep, "side"
    )


@note_check(
    "remove_ego_returns",
    title="Removes points on the faces of the box",
    why="remove_ego_returns should remove exactly the rows that crop_region keeps, so outside "
    "means < minimum or > maximum. Measured points are hardly ever exactly on a face, so this "
    "does not affect your score.",
)
def removes_points_on_faces(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    box = (-1.5, -1.75, -1.0), (2.5, 1.75, -0.5)
    on_faces = parse_table(
        "-1.5 0 -0.75; 2.5 0 -0.75; 0 -1.75 -0.75; 0 1.75 -0.75; 0 0 -1; 0 0 -0.5; 7 6 0.5"
    )
    on_faces = np.column_stack([on_faces, np.full(7, 0.4)])
    assert_points_left_by_box(
        remove_ego_returns(on_faces.copy(), *box), on_faces, *box, np.arange(7) == 6
    )


@visible_check(
    "remove_ego_returns",
    weight=3,
    title="Uses minimum and maximum as the corners of the box",
    why="The box depends on the vehicle: a lorry is larger, and a roof rack makes a car taller.",
    hint="Compare with minimum and maximum, not with fixed numbers.",
)
def uses_the_ego_box(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    for low, high in _LIMITS:
        corners = (low, 5 - high, low), (high, 5 - low, high)
        keep = (_DIAGONAL[:, 0] < low) | (_DIAGONAL[:, 0] > high)
        assert_points_left_by_box(
            remove_ego_returns(_DIAGONAL.copy(), *corners), _DIAGONAL, *corners, keep
        )


@visible_check(
    "remove_ego_returns",
    weight=1,
    title="Accepts corners as tuples, lists or arrays",
    why="A box may come from a configuration file, a drawing or another array.",
    hint="Write cloud[:, :3] >= minimum. NumPy compares column by column, even if minimum is a "
    "tuple or a list.",
)
def accepts_any_ego_box_type(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    for kind in (list, np.array):
        answer = remove_ego_returns(_EGO_CLOUD.copy(), kind(_EGO_BOX[0]), kind(_EGO_BOX[1]))
        assert_points_left_by_box(answer, _EGO_CLOUD, *_EGO_BOX, ~_IS_EGO)
        _assert_any_corner_type(remove_ego_returns, kind)


_EGO_CASE = Case(
    __name__,
    "remove_ego_returns",
    {"cloud": _EGO_CLOUD, "minimum": _EGO_BOX[0], "maximum": _EGO_BOX[1]},
    expected=frozen(~_IS_EGO),
    compare=assert_points_left_by_box,
    precondition=require_ego_removed,
)
common_checks.promise_names(
    _EGO_CASE,
    "names_the_ego_box",
    why="Other code may call remove_ego_returns(cloud, minimum=..., maximum=...).",
)
common_row_checks.promise_all_columns(
    _EGO_CASE, "keeps_all_columns", hint="Compare cloud[:, :3], but index cloud itself.", weight=2
)
common_row_checks.promise_order(_EGO_CASE, "keeps_the_row_order")
common_checks.promise_three_columns(
    _EGO_CASE,
    "removes_with_three_columns",
    hint="Use cloud[:, :3], which works with three columns and with four.",
)
common_row_checks.promise_empty_table(_EGO_CASE, "removes_from_small_clouds", weight=2)
common_row_checks.promise_untouched(_EGO_CASE, "removal_leaves_its_input")
common_row_checks.note_array(_EGO_CASE, "leaves_an_array")


def _rows_at_most(cloud: np.ndarray, values: np.ndarray, limit: float) -> np.ndarray:
    return np.delete(cloud, np.flatnonzero(values - limit > 0), axis=0)


def _horizontal_distances(cloud: np.ndarray) -> np.ndarray:
    return np.abs(cloud[:, :2] @ [1, 1j])  # the absolute value of the complex number x + iy


declare_mistakes(
    "filter_by_distance",
    Mistake(
        "The comparison is the wrong way round: far points stay and near points are removed.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, -_horizontal_distances(cloud), -distance
        ),
        "Near points are at most `distance` away, so keep the points with <=.",
    ),
    Mistake(
        "The height is included, so your code computes the distance in space, not along the road.",
        lambda right, cloud, distance: _rows_at_most(
            right, (right[:, :3] ** 2).sum(axis=1), distance**2
        ),
        "Use columns 0 and 1 only. Column 2 is the height.",
    ),
    Mistake(
        "Height and intensity are included, so the distance combines all columns.",
        lambda right, cloud, distance: _rows_at_most(right, (right**2).sum(axis=1), distance**2),
        "Use columns 0 and 1 only.",
    ),
    Mistake(
        "The squared distance is compared with `distance` itself: a square root is missing, or a "
        "square on the other side.",
        lambda right, cloud, distance: _rows_at_most(
            right, _horizontal_distances(right) ** 2, distance
        ),
        "Compute the distance with np.sqrt(x**2 + y**2) or np.hypot(x, y).",
    ),
    Mistake(
        "The distance is compared with the square of `distance`.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud), distance**2
        ),
        "Square both sides of the comparison, or neither.",
    ),
    Mistake(
        "x and y are compared separately, so the border is a square, not a circle.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, np.abs(cloud[:, :2]).max(axis=1), distance
        ),
        "Combine x and y into one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "x and y are compared separately and with their signs, so everything behind the car on "
        "the right counts as near.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, :2].max(axis=1), distance),
        "Combine x and y into one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "|x| and |y| are added. The distance is the square root of the sum of their squares.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, np.abs(cloud[:, :2]).sum(axis=1), distance
        ),
        "Square x and y, add them and take the square root, or call np.hypot(x, y).",
    ),
    Mistake(
        "x and y are added with their signs. The distance is the square root of the sum of their "
        "squares.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, :2].sum(axis=1), distance),
        "Square x and y, add them and take the square root, or call np.hypot(x, y).",
    ),
    Mistake(
        "The distance is computed from x and z; y, in column 1, is not used.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud[:, [0, 2]]), distance
        ),
        "Use columns 0 and 1. Column 2 is the height.",
    ),
    Mistake(
        "The distance is computed from y and z; x, in column 0, is not used.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud[:, [1, 2]]), distance
        ),
        "Use columns 0 and 1. Column 2 is the height.",
    ),
    Mistake(
        "Only y is compared, with its sign, so everything on the right stays.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, 1], distance),
        "Combine x and y into one distance first: np.hypot(x, y).",
        is_cheap=True,
    ),
    Mistake(
        "Only |y| is compared, so points straight ahead or behind stay, however far away they are.",
        lambda right, cloud, distance: _rows_at_most(cloud, np.abs(cloud[:, 1]), distance),
        "Combine x and y into one distance first: np.hypot(x, y).",
        is_cheap=True,
    ),
    Mistake(
        "Only x is compared, with its sign, so everything behind the car stays.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, 0], distance),
        "Combine x and y into one distance first: np.hypot(x, y).",
        is_cheap=True,
    ),
    Mistake(
        "Only |x| is compared, so points to the left or right stay, however far away they are.",
        lambda right, cloud, distance: _rows_at_most(cloud, np.abs(cloud[:, 0]), distance),
        "Combine x and y into one distance first: np.hypot(x, y).",
        is_cheap=True,
    ),
    Mistake(
        "The limit is fixed at 10 m; `distance` is ignored.",
        lambda right, cloud, distance: _rows_at_most(cloud, _horizontal_distances(cloud), 10.0),
        "Compare with `distance`.",
    ),
    Mistake(
        "Your code computes one distance for the whole cloud: axis=1 is missing.",
        lambda right, cloud, distance: cloud[None][: int(np.linalg.norm(cloud[:, :2]) < distance)],
        "Write np.linalg.norm(..., axis=1), which gives one number for each row.",
    ),
    Mistake(
        "Your code returns the distances of the near points. It should return whole rows.",
        lambda right, cloud, distance: _horizontal_distances(right),
        "Index the whole cloud with the mask: cloud[mask].",
    ),
    Mistake(
        "Far rows are set to 0. They should be removed.",
        lambda right, cloud, distance: cloud * (_horizontal_distances(cloud) < distance)[:, None],
        "Index with the mask: cloud[mask] contains only the rows where the mask is True.",
    ),
    Mistake(
        "Nothing is removed: the function returns the whole cloud. It should return only the rows "
        "within `distance`.",
        lambda right, cloud, distance: cloud,
        is_cheap=True,
    ),
    cases=(
        (
            parse_table(
                "12 3 0.1 0.1; 1 1.5 0.5 0.1; 2 2.1 0.3 0.2; 2.8 2.6 0.2 0.1; -1.1 -2 2.5 0.1; "
                "1.5 1 0.2 9; -7 1 0.1 0.1; 0.8 0.9 0.1 0.1; 1 -6 0.1 0.3"
            ),
            3.0,
        ),
        (
            parse_table(
                "4 4.5 0.2 0.3; 3 3.5 0.3 0.2; -30 -2 0.1 0.2; 1 3 -4.5 0.1; 2 -1.2 0.1 7; "
                "1 1.2 0.1 0.4; 2 -13 0.4 0.2; 26 2 0.1 0.1; -3 40 0.2 0.6"
            ),
            5.0,
        ),
        (parse_table("3 2 0.1 0.1; -2 5 11 0.1; 1 2 0.1 14"), 12.0),
        (
            parse_table("1 1.5 6 0.1; 2 -9 0.3 0.2; -1.5 2 -3.9 0.1; 0.5 3 0.2 0.1; -6 1 0.1 0.2"),
            4.0,
        ),
        (
            parse_table("2 3 -8 0.1; -3 20 0.5 0.3; 5 4 4.5 0.2; -6 -2 -5 0.1; 30 2 1 0.4"),
            7.0,
        ),
    ),
    right=lambda cloud, distance: _rows_at_most(cloud, _horizontal_distances(cloud), distance),
)


def _depths(cloud: np.ndarray, minimum: Sequence, maximum: Sequence) -> np.ndarray:
    """Return the depth of each coordinate inside a box, shape (n, 3); negative if outside."""
    middle, half = np.add(minimum, maximum) / 2, np.subtract(maximum, minimum) / 2
    return half - np.abs(cloud[:, :3] - middle)


def _rows_inside(cloud: np.ndarray, minimum: Sequence, maximum: Sequence) -> np.ndarray:
    return _rows_at_most(cloud, -_depths(cloud, minimum, maximum).min(axis=1), 0)


def _rows_outside(cloud: np.ndarray, minimum: Sequence, maximum: Sequence) -> np.ndarray:
    return cloud[_depths(cloud, minimum, maximum).min(axis=1) < 0]


def _same_rows(answer: object, predicted: np.ndarray) -> bool:
    """Return whether an answer is a table of the predicted rows; an empty list is not a table."""
    return same_array(answer, predicted) and as_array(answer).ndim > 1


# The first three clouds have points inside a box, on its faces, and outside it on one, two or three
# axes. The last three clouds have no points outside.
_BOXES = (
    (
        parse_table(
            "2 1 0.5 0.5; 9 1 0.5 0.1; 2 -7 0.5 0.2; 2 1 5 0.3; 0.5 0.5 -0.7 0.4; -8 -9 0 0.6; "
            "9 8 7 0.7; -5 -6 -7 0.8; -9 0.5 8 0.2; 3 -1 0.5 0.9"
        ),
        (-1.0, -2.0, -0.5),
        (4.0, 2.0, 1.5),
    ),
    (
        parse_table(
            "0.5 6 -0.5 0.5; 0 5 3 0.1; 9 5.5 -0.5 0.2; 40 -9 0.2 0.2; -14 -8 -4 0.3; "
            "0.5 6.5 -6 0.2; 0.5 -1 -0.6 0.4; 35 9.5 4 0.7"
        ),
        (-2.5, 4.0, -1.5),
        (1.5, 7.0, 0.5),
    ),
    (
        parse_table(
            "1 2 3.5 0.3; 3 2.5 3.5 0.1; 2 4 3.5 0.1; 2 2.5 3 0.5; 2 3 3.5 0.2; 0 9 8 0.2; "
            "0.5 1 2 0.6"
        ),
        (1.0, 2.0, 3.0),
        (3.0, 4.0, 5.0),
    ),
    (
        parse_table("4 2 1 0.3; 2 2 1 0.1; 2 1 0 0.2"),
        (0.0, 0.0, 0.0),
        (4.0, 4.0, 4.0),
    ),
    (
        parse_table("0.5 -0.5 1.5 0.3; 1.5 0.5 2.5 0.1"),
        (0.0, -1.0, 1.0),
        (2.0, 1.0, 3.0),
    ),
    (
        parse_table("-3.5 2.5 -1 0.7; -2.5 3.5 0.5 0.2; -1.5 4.5 0 0.1"),
        (-4.0, 2.0, -1.5),
        (-1.0, 5.0, 1.0),
    ),
)

declare_mistakes(
    "crop_region",
    Mistake(
        "The mask is inverted: points inside are removed and points outside stay.",
        lambda right, *case: _rows_outside(*case),
        "Index with the mask of the rows inside, without ~.",
    ),
    Mistake(
        "A point counts as inside if one of its coordinates is inside. All three must be inside.",
        lambda right, *case: case[0][_depths(*case).max(axis=1) >= 0],
        "Use .all(axis=1) instead of .any(axis=1).",
    ),
    Mistake(
        "Only x and y are compared. z must be inside as well.",
        lambda right, *case: case[0][_depths(*case)[:, :2].min(axis=1) >= 0],
        "Compare all three coordinates: cloud[:, :3].",
    ),
    Mistake(
        "Only minimum is compared, so points beyond maximum stay.",
        lambda right, cloud, low, high: _rows_inside(cloud, low, np.full(3, 1e3)),
        "Combine both comparisons with &.",
        is_cheap=True,
    ),
    Mistake(
        "Only maximum is compared, so points below minimum stay.",
        lambda right, cloud, low, high: _rows_inside(cloud, np.full(3, -1e3), high),
        "Combine both comparisons with &.",
        is_cheap=True,
    ),
    Mistake(
        "Your code always uses the lesson's region and ignores minimum and maximum.",
        lambda right, cloud, low, high: _rows_inside(cloud, _MINIMUM, _MAXIMUM),
        "Compare with the parameters minimum and maximum.",
    ),
    Mistake(
        "Points outside are moved to the border. They should be removed.",
        lambda right, cloud, low, high: np.column_stack(
            [np.clip(cloud[:, :3], low, high), cloud[:, 3:]]
        ),
        "Index with a mask: cloud[mask] contains only the rows where the mask is True.",
    ),
    Mistake(
        "Your code computes one True or False for the whole cloud: axis=1 is missing.",
        lambda right, *case: case[0][None][: int(len(right) == len(case[0]))],
        "Write .all(axis=1), which gives one True or False for each row.",
    ),
    Mistake(
        "Everything is removed: no point counts as inside.",
        lambda right, cloud, low, high: cloud[:0],
        "Write >= minimum and <= maximum. Perhaps your code swaps the corners or the comparisons.",
        is_cheap=True,
    ),
    Mistake(
        "Nothing is removed: the function returns the whole cloud. It should return only the rows "
        "inside the box.",
        lambda right, cloud, low, high: cloud,
        "Combine both comparisons with &, then index with the mask: cloud[inside]. With |, one "
        "true comparison is enough, and one of them is always true.",
        is_cheap=True,
    ),
    cases=_BOXES,
    right=_rows_inside,
    is_same=_same_rows,
)

declare_mistakes(
    "remove_ego_returns",
    Mistake(
        "The mask is inverted: points inside stay and points outside are removed.",
        lambda right, *case: _rows_inside(*case),
        "Index with ~inside.",
    ),
    Mistake(
        "A point stays only if it is outside in x, in y and in z. It should stay if it is outside "
        "in any of them.",
        lambda right, *case: case[0][_depths(*case).max(axis=1) < 0],
        "If you compare with < minimum and > maximum, call .any(axis=1). Otherwise invert the mask "
        "at the very end: ~inside.",
    ),
    Mistake(
        "Only x and y are compared, so points above or below the box are removed as well.",
        lambda right, *case: case[0][_depths(*case)[:, :2].min(axis=1) < 0],
        "Compare all three coordinates: cloud[:, :3].",
    ),
    Mistake(
        "Your code always uses the lesson's box and ignores minimum and maximum.",
        lambda right, cloud, low, high: _rows_outside(cloud, *_EGO_BOX),
        "Compare with the parameters minimum and maximum.",
    ),
    Mistake(
        "Returns from the ego car are set to 0. They should be removed.",
        lambda right, *case: case[0] * (_depths(*case).min(axis=1, keepdims=True) < 0),
        "Index with a mask: cloud[mask] contains only the rows where the mask is True.",
    ),
    Mistake(
        "Your code computes one True or False for the whole cloud: axis=1 is missing.",
        lambda right, *case: case[0][None][: int(len(right) > 0)],
        "Write .all(axis=1), which gives one True or False for each row.",
    ),
    Mistake(
        "Only minimum is compared, so points beyond maximum are removed as well.",
        lambda right, cloud, low, high: _rows_outside(cloud, low, np.full(3, 1e3)),
        "Combine both comparisons with &.",
        is_cheap=True,
    ),
    Mistake(
        "Only maximum is compared, so points below minimum are removed as well.",
        lambda right, cloud, low, high: _rows_outside(cloud, np.full(3, -1e3), high),
        "Combine both comparisons with &.",
        is_cheap=True,
    ),
    Mistake(
        "Everything is removed: no point counts as outside.",
        lambda right, cloud, low, high: cloud[:0],
        "For inside, combine >= minimum and <= maximum with &. For outside, combine < minimum and "
        "> maximum with |. If & and | are swapped, the condition is always true or never true.",
        is_cheap=True,
    ),
    Mistake(
        "Nothing is removed: the function returns the whole cloud. It should return only the rows "
        "outside the box.",
        lambda right, cloud, low, high: cloud,
        "Write >= minimum and <= maximum, then index with ~inside. Perhaps your code swaps the "
        "corners or the comparisons.",
        is_cheap=True,
    ),
    cases=_BOXES,
    right=_rows_outside,
    is_same=_same_rows,
)
