"""Visible checks of lesson 07: `filter_by_distance`, `crop_region`, `remove_ego_returns`.

Each check covers one property. `assert_near` and `assert_boxed` compare only which points are left;
separate checks cover the order of the rows and their intensity.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from utils.checks import common_checks, common_row_checks
from utils.checks.assertions import (
    CheckFailed,
    as_array,
    assert_places,
    brief,
    frozen,
    marked,
    needs,
    points_text,
    table,
)
from utils.checks.common_checks import Case
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes, same_array
from utils.checks.run_cache import once

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Low, dim points ahead of the car on the left, in no particular order. They are so near or so far
# that every measure of distance in the plane agrees, because separate checks cover directions,
# corners, heights and intensities.
_SCATTERED, _NEAR = marked(
    "6 0.5 -1.5 0.2 +; 2 15 0.2 0.8 -; 3 6 -0.9 0.9 +; 14 1 -1.1 0.3 -; 11 11.5 -1 0.4 -; "
    "1.5 8 0.3 0.6 +; 4 4 -0.4 0.5 +; 12 4 -0.7 0.1 -"
)

_MINIMUM, _MAXIMUM = (-10.0, -5.0, -2.0), (30.0, 6.0, 1.0)
# Each point is inside the box, or outside it in x, y and z alike: above the maximum in at least one
# coordinate and below the minimum in another.
_CROP_CLOUD, _INSIDE = marked(
    "1 2 -1 0.5 +; -12 -8 1.5 0.2 -; 28 -4 0.5 0.1 +; 40 -9 1.6 0.3 -; 33 7 -2.4 0.4 -; "
    "-9 5.5 0.9 0.9 +; -15 7 -2.6 0.6 -; 12 0 -1.9 0.4 +"
)
_EGO_BOX = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
# Returns of the ego car, and others that are outside its box in x, y and z alike, above the maximum
# in one coordinate and below the minimum in another.
_EGO_CLOUD, _IS_EGO = marked(
    "-1.3 0.4 -0.6 0.3 +; 5 -3 0.5 0.4 -; 1 -1 -0.5 0.5 +; -2 -2 0.3 0.2 -; "
    "12 -4.2 -1.4 0.7 -; 0.9 1 -0.9 0.5 +; -3 8 -1.6 0.9 -"
)
# y falls as x rises. The boxes built from _LIMITS mirror this, so that each point is inside in all
# three coordinates or in none.
_DIAGONAL = frozen(
    np.column_stack([np.arange(6.0), 5 - np.arange(6.0), np.arange(6.0), np.ones(6)])
)
# Points along the diagonal of a cube that does not contain the sensor: a function that doubles a
# corner by mistake leaves other rows.
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
    """Assert that corners of type `kind` leave the same rows as tuples, whether right or wrong."""
    with_tuples, with_kind = (
        as_array(function(_CUBE_DIAGONAL.copy(), *corners), what="the rows")
        for corners in (_CUBE, map(kind, _CUBE))
    )
    if not np.array_equal(with_tuples, with_kind):
        raise CheckFailed(
            "The same corners leave other rows when they are no tuples.",
            given=f"six points on a line, and corners {brief(kind(_CUBE[0]))} and "
            f"{brief(kind(_CUBE[1]))}",
            yours=f"{len(with_kind)} rows",
            expected=f"{len(with_tuples)} rows, as your function leaves with tuples",
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
    """Call `assert_places`; add the border to the picture and small clouds to the message."""
    is_small = len(cloud) <= 8
    given = f"points {points_text(cloud)}, {settings}" if is_small else None
    try:
        assert_places(answer, cloud, keep, view, given, points_text if is_small else None)
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


@once
def require_near_points(filter_by_distance: Callable) -> None:
    """Assert that near points stay and far ones go; raise `NotYet` if they do not."""
    with needs("what is near is kept, what is far is not"):
        assert_points_left(filter_by_distance(_SCATTERED.copy(), 10.0), _SCATTERED, 10.0, _NEAR)


@once
def require_crop(crop_region: Callable) -> None:
    """Assert that only points inside the box stay; raise `NotYet` if this fails."""
    with needs("what is inside the box is kept, what is outside is not"):
        answer = crop_region(_CROP_CLOUD.copy(), _MINIMUM, _MAXIMUM)
        assert_points_left_by_box(answer, _CROP_CLOUD, _MINIMUM, _MAXIMUM, _INSIDE)


@once
def require_ego_removed(remove_ego_returns: Callable) -> None:
    """Assert that only points inside the box go; raise `NotYet` if this fails."""
    with needs("what is inside the box is removed, what is outside is not"):
        assert_points_left_by_box(
            remove_ego_returns(_EGO_CLOUD.copy(), *_EGO_BOX), _EGO_CLOUD, *_EGO_BOX, ~_IS_EGO
        )


@visible(
    "filter_by_distance",
    weight=4,
    title="Keeps what is near and drops what is far",
    why="A far wall only costs time.",
    hint="Square x and y, add, take the root: one distance per point. Keep where it is at "
    "most `distance`.",
)
def keeps_what_is_near(filter_by_distance: Callable) -> None:
    assert_points_left(filter_by_distance(_SCATTERED.copy(), 10.0), _SCATTERED, 10.0, _NEAR)


@visible(
    "filter_by_distance",
    weight=3,
    title="Looks all around: ahead, behind, left and right",
    why="A car behind us is as real as one ahead.",
    hint="Behind us x is negative, on the right y is. Squares know no sign.",
)
def looks_all_around(filter_by_distance: Callable) -> None:
    require_near_points(filter_by_distance)
    cloud, near = marked("-6 2 +; -14 1 -; -3 -6 +; 3 -13 -; 2 -7 +; -11 -12 -", -0.5, 0.3)
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)


@visible(
    "filter_by_distance",
    weight=3,
    title="The border is a circle",
    why="In a square the corners are 41 % farther away than the sides.",
    hint="Pythagoras: neither the larger of x and y nor their sum is a distance.",
)
def draws_a_circle(filter_by_distance: Callable) -> None:
    require_near_points(filter_by_distance)
    cloud, near = marked("8 8 -; 6.5 6.5 +; 9.5 5 -; 9 3 +", -0.5, 0.3)
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)


@visible(
    "filter_by_distance",
    weight=4,
    title="Height does not count",
    why="A child in front of a lorry is far below its sensor: the straight line to it is "
    "longer than the way to it.",
    hint="Use columns 0 and 1 only. Column 2 is the height.",
)
def ignores_height(filter_by_distance: Callable) -> None:
    require_near_points(filter_by_distance)
    cloud, near = marked("11 1 0 0.1 -; 6 2 9 0.1 +; 4 3 -12 0.1 +; 13 2 -0.2 0.1 -")
    assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near, "side")


@visible(
    "filter_by_distance",
    weight=3,
    title="Intensity does not count",
    why="Another driver reports intensities up to 255, and every bright car would vanish.",
    hint="x and y alone make the distance: columns 0 and 1.",
)
def ignores_intensity(filter_by_distance: Callable) -> None:
    require_near_points(filter_by_distance)
    cloud, near = marked("6 0.5 0.2 255 +; 12 0.5 0.2 0 -; 2 7 0.2 40 +; 11 6 0.2 3 -")
    try:
        assert_points_left(filter_by_distance(cloud.copy(), 10.0), cloud, 10.0, near)
    except CheckFailed as failure:
        if failure.given:
            failure.given += ", intensities 255, 0, 40, 3"
        raise


@visible(
    "filter_by_distance",
    weight=5,
    title="The parameter decides how far is too far",
    why="A fast car must look farther than a slow one.",
    hint="Near is what is at most `distance` away, whatever number that is.",
)
def follows_the_distance(filter_by_distance: Callable) -> None:
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
    precondition=require_near_points,
)


@common_checks.default(
    _NEAR_CASE,
    "distance=10.0",
    title="The distance is 10 m unless another one is given",
    why="Later cells call filter_by_distance(cloud) and rely on it.",
    weight=2,
)
def keeps_the_default(filter_by_distance: Callable) -> None:
    cloud = np.array([[x, 0.1, -0.2, 0.3] for x in (9.8, 10.2, 7.0, 13.0)])
    near = np.array([True, False, True, False])
    given = f"points {points_text(cloud)}, no distance"
    assert_places(filter_by_distance(cloud.copy()), cloud, near, "above", given, points_text)


common_checks.names(
    _NEAR_CASE, "keeps_the_names", why="Others may call filter_by_distance(cloud, distance=25)."
)
common_row_checks.all_columns(_NEAR_CASE, "keeps_the_columns", weight=2)
common_row_checks.order(_NEAR_CASE, "keeps_the_order", weight=2)
common_checks.three_columns(
    _NEAR_CASE,
    "takes_three_columns",
    hint="Name the columns that you need, cloud[:, 0] and cloud[:, 1], and let the others be.",
)
common_row_checks.nothing_left(
    _NEAR_CASE,
    "takes_the_smallest",
    hint="The same two lines serve every case: an empty mask takes no row.",
    weight=2,
)
common_row_checks.untouched(_NEAR_CASE, "leaves_its_input", weight=2)


@noted(
    "filter_by_distance",
    title="A point at the very distance stays",
    why='The docstring says <=, "at most". In a scan no point lies on the border to the last '
    "digit; in a made-up example one does.",
)
def keeps_the_tie(filter_by_distance: Callable) -> None:
    cloud, near = marked("3 4 -0.5 0.1 +; 6 1 -0.5 0.1 -; 1 2 -0.5 0.1 +")
    assert_points_left(filter_by_distance(cloud.copy(), 5.0), cloud, 5.0, near)


common_row_checks.array(_NEAR_CASE, "returns_an_array")


@visible(
    "crop_region",
    weight=4,
    title="Keeps what is inside the box and drops what is outside",
    why="Without it the region of interest reaches to the horizon.",
    hint="Compare the first three columns with minimum and with maximum, join the tables "
    "with &, then .all(axis=1).",
)
def keeps_what_is_inside(crop_region: Callable) -> None:
    answer = crop_region(_CROP_CLOUD.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, _CROP_CLOUD, _MINIMUM, _MAXIMUM, _INSIDE)


@visible(
    "crop_region",
    weight=9,
    title="What is outside in x or in y alone goes, too",
    why="One side forgotten, and all houses of the street come in.",
    hint="A row is inside when all three coordinates are: .all(axis=1).",
)
def cuts_on_four_sides(crop_region: Callable) -> None:
    require_crop(crop_region)
    cloud, keep = marked("-11 2 -1 -; 31 2 -1 -; 1 2 -1 +; 1 -6 -1 -; 1 7 -1 -", 0.4)
    assert_points_left_by_box(
        crop_region(cloud.copy(), _MINIMUM, _MAXIMUM), cloud, _MINIMUM, _MAXIMUM, keep
    )


@visible(
    "crop_region",
    weight=5,
    title="What is below the floor or above the roof of the box goes, too",
    why="A bridge over the street is no obstacle.",
    hint="A point is inside where x, y and z all are: cloud[:, :3].",
)
def cuts_below_and_above(crop_region: Callable) -> None:
    require_crop(crop_region)
    cloud, keep = marked("1 2 -2.5 -; 1 2 -1 +; 1 2 1.5 -", 0.4)
    answer = crop_region(cloud.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, cloud, _MINIMUM, _MAXIMUM, keep, "side")


@noted(
    "crop_region",
    title="The faces belong to the box",
    why="Two boxes side by side leave no gap between them: write >= minimum and <= maximum. "
    "Measured points hardly ever lie exactly there, so it costs nothing.",
)
def counts_the_faces(crop_region: Callable) -> None:
    require_crop(crop_region)
    on_faces = table("-10 0 0; 30 0 0; 0 -5 0; 0 6 0; 0 0 -2; 0 0 1")
    on_faces = np.column_stack([on_faces, np.full(6, 0.4)])
    answer = crop_region(on_faces.copy(), _MINIMUM, _MAXIMUM)
    assert_points_left_by_box(answer, on_faces, _MINIMUM, _MAXIMUM, np.full(6, True))


@visible(
    "crop_region",
    weight=3,
    title="The parameters decide where the box is",
    why="The region changes with the road and with the speed.",
    hint="Inside is what lies between minimum and maximum, whatever these are.",
)
def follows_the_corners(crop_region: Callable) -> None:
    for low, high in _LIMITS:
        corners = (low, 5 - high, low), (high, 5 - low, high)
        keep = (_DIAGONAL[:, 0] > low) & (_DIAGONAL[:, 0] < high)
        assert_points_left_by_box(
            crop_region(_DIAGONAL.copy(), *corners), _DIAGONAL, *corners, keep
        )


@visible(
    "crop_region",
    weight=1,
    title="The corners may be tuples, lists or arrays",
    why="A box comes from a configuration file, from a map or from another array.",
    hint="An array compares itself with a tuple or a list of three numbers without more ado.",
)
def takes_any_corners(crop_region: Callable) -> None:
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
common_checks.names(
    _CROP_CASE,
    "names_the_corners",
    why="Others may call crop_region(cloud, minimum=..., maximum=...).",
)
common_row_checks.all_columns(
    _CROP_CASE, "crops_all_columns", hint="Compare cloud[:, :3], but index cloud itself.", weight=2
)
common_row_checks.order(_CROP_CASE, "crops_in_order")
common_checks.three_columns(
    _CROP_CASE, "crops_three_columns", hint="cloud[:, :3] is there in both."
)
common_row_checks.nothing_left(_CROP_CASE, "crops_the_smallest", weight=2)
common_row_checks.untouched(_CROP_CASE, "crops_a_copy")
common_row_checks.array(_CROP_CASE, "gives_an_array")


@visible(
    "remove_ego_returns",
    weight=4,
    title="Removes what is inside the box, and keeps what is outside",
    why="A return of our own mirror is an obstacle that never goes away.",
    hint="Find the rows inside as in crop_region, then keep the others: ~inside.",
)
def removes_our_own(remove_ego_returns: Callable) -> None:
    assert_points_left_by_box(
        remove_ego_returns(_EGO_CLOUD.copy(), *_EGO_BOX), _EGO_CLOUD, *_EGO_BOX, ~_IS_EGO
    )


@visible(
    "remove_ego_returns",
    weight=10,
    title="What shares y or x with our car stays",
    why="The car ahead of us shares y and z with us. It is the last one to lose.",
    hint="A row is outside when one coordinate is outside: not (a and b and c) is "
    "(not a) or (not b) or (not c).",
)
def keeps_ahead_and_beside(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    cloud, keep = marked("0.5 0 -0.7 -; 9 0 -0.7 +; -4 0 -0.7 +; 0.5 6 -0.7 +; 0.5 -3 -0.7 +", 0.4)
    assert_points_left_by_box(remove_ego_returns(cloud.copy(), *_EGO_BOX), cloud, *_EGO_BOX, keep)


@visible(
    "remove_ego_returns",
    weight=4,
    title="What is above or below the box stays",
    why="A sign above the bonnet, a kerb under the bumper: neither is our car.",
    hint="A point is inside where x, y and z all are: cloud[:, :3].",
)
def keeps_above_and_below(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    cloud, keep = marked("0.5 0 2 +; 0.5 0 -0.7 -; 0.5 0 -1.6 +", 0.4)
    assert_points_left_by_box(
        remove_ego_returns(cloud.copy(), *_EGO_BOX), cloud, *_EGO_BOX, keep, "side"
    )


@noted(
    "remove_ego_returns",
    title="The faces belong to the box",
    why="What crop_region keeps of a box, this removes: outside is < minimum or > maximum. "
    "Measured points hardly ever lie exactly there, so it costs nothing.",
)
def removes_the_faces(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    box = (-1.5, -1.75, -1.0), (2.5, 1.75, -0.5)
    on_faces = table(
        "-1.5 0 -0.75; 2.5 0 -0.75; 0 -1.75 -0.75; 0 1.75 -0.75; 0 0 -1; 0 0 -0.5; 7 6 0.5"
    )
    on_faces = np.column_stack([on_faces, np.full(7, 0.4)])
    assert_points_left_by_box(
        remove_ego_returns(on_faces.copy(), *box), on_faces, *box, np.arange(7) == 6
    )


@visible(
    "remove_ego_returns",
    weight=3,
    title="The parameters decide where the box is",
    why="A lorry is not a small car, and a roof rack is a part of ours.",
    hint="Inside is what lies between minimum and maximum, whatever these are.",
)
def follows_the_ego_box(remove_ego_returns: Callable) -> None:
    require_ego_removed(remove_ego_returns)
    for low, high in _LIMITS:
        corners = (low, 5 - high, low), (high, 5 - low, high)
        keep = (_DIAGONAL[:, 0] < low) | (_DIAGONAL[:, 0] > high)
        assert_points_left_by_box(
            remove_ego_returns(_DIAGONAL.copy(), *corners), _DIAGONAL, *corners, keep
        )


@visible(
    "remove_ego_returns",
    weight=1,
    title="The corners may be tuples, lists or arrays",
    why="A box comes from a configuration file, from a drawing or from another array.",
    hint="An array compares itself with a tuple or a list of three numbers without more ado.",
)
def takes_any_ego_box(remove_ego_returns: Callable) -> None:
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
common_checks.names(
    _EGO_CASE,
    "names_the_ego_box",
    why="Others may call remove_ego_returns(cloud, minimum=..., maximum=...).",
)
common_row_checks.all_columns(
    _EGO_CASE, "leaves_all_columns", hint="Compare cloud[:, :3], but index cloud itself.", weight=2
)
common_row_checks.order(_EGO_CASE, "leaves_the_order")
common_checks.three_columns(_EGO_CASE, "frees_three_columns", hint="cloud[:, :3] is there in both.")
common_row_checks.nothing_left(_EGO_CASE, "frees_the_smallest", weight=2)
common_row_checks.untouched(_EGO_CASE, "frees_a_copy")
common_row_checks.array(_EGO_CASE, "leaves_an_array")


def _rows_at_most(cloud: np.ndarray, values: np.ndarray, limit: float) -> np.ndarray:
    return np.delete(cloud, np.flatnonzero(values - limit > 0), axis=0)


def _horizontal_distances(cloud: np.ndarray) -> np.ndarray:
    return np.abs(cloud[:, :2] @ [1, 1j])  # the absolute value of the complex number x + iy


mistakes(
    "filter_by_distance",
    Mistake(
        "It is the other way round: what is far stays, and what is near goes.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, -_horizontal_distances(cloud), -distance
        ),
        'Near is "at most distance": which comparison says that?',
    ),
    Mistake(
        "The height is counted in: that is the straight line in space, not the way on the road.",
        lambda right, cloud, distance: _rows_at_most(
            right, (right[:, :3] ** 2).sum(axis=1), distance**2
        ),
        "Use columns 0 and 1 only. Column 2 is the height.",
    ),
    Mistake(
        "Height and intensity are counted in: that is the length of the whole row.",
        lambda right, cloud, distance: _rows_at_most(right, (right**2).sum(axis=1), distance**2),
        "Use columns 0 and 1 only.",
    ),
    Mistake(
        "The squared distance is compared with the plain one: a root is missing, or a square on "
        "the other side.",
        lambda right, cloud, distance: _rows_at_most(
            right, _horizontal_distances(right) ** 2, distance
        ),
        "np.sqrt(x**2 + y**2) or np.hypot(x, y) is the distance.",
    ),
    Mistake(
        "The distance is compared with the square of `distance`.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud), distance**2
        ),
        "Compare plain with plain, or squared with squared.",
    ),
    Mistake(
        "x and y are compared each by itself: that is a square, not a circle.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, np.abs(cloud[:, :2]).max(axis=1), distance
        ),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "x and y are compared each by itself, and with their signs: everything behind us on the "
        "right counts as near.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, :2].max(axis=1), distance),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "x and y are added up as lengths, |x| + |y|: it takes squares and a root.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, np.abs(cloud[:, :2]).sum(axis=1), distance
        ),
        "Square x and y, add, take the root: np.hypot(x, y).",
    ),
    Mistake(
        "x and y are added up, with their signs: it takes squares and a root.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, :2].sum(axis=1), distance),
        "Square x and y, add, take the root: np.hypot(x, y).",
    ),
    Mistake(
        "x and z make the distance; y, in column 1, is left out.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud[:, [0, 2]]), distance
        ),
        "Use columns 0 and 1. Column 2 is the height.",
    ),
    Mistake(
        "y and z make the distance; x, in column 0, is left out.",
        lambda right, cloud, distance: _rows_at_most(
            cloud, _horizontal_distances(cloud[:, [1, 2]]), distance
        ),
        "Use columns 0 and 1. Column 2 is the height.",
    ),
    Mistake(
        "Only y is compared, with its sign: everything on the right stays.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, 1], distance),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "Only y is compared: everything ahead and behind stays, however far.",
        lambda right, cloud, distance: _rows_at_most(cloud, np.abs(cloud[:, 1]), distance),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "Only x is compared, with its sign: everything behind us stays.",
        lambda right, cloud, distance: _rows_at_most(cloud, cloud[:, 0], distance),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "Only x is compared: everything beside us stays, however far.",
        lambda right, cloud, distance: _rows_at_most(cloud, np.abs(cloud[:, 0]), distance),
        "Combine x and y to one distance first: np.hypot(x, y).",
    ),
    Mistake(
        "A fixed distance of 10 m decides, whatever `distance` is.",
        lambda right, cloud, distance: _rows_at_most(cloud, _horizontal_distances(cloud), 10.0),
        "Compare with `distance`.",
    ),
    Mistake(
        "There is one distance for the whole cloud: an axis=1 is missing.",
        lambda right, cloud, distance: cloud[None][: int(np.linalg.norm(cloud[:, :2]) < distance)],
        "np.linalg.norm(..., axis=1) gives one number for each row.",
    ),
    Mistake(
        "What is returned are the distances that are left; it should be the rows.",
        lambda right, cloud, distance: _horizontal_distances(right),
        "Index the whole cloud with the mask: cloud[mask].",
    ),
    Mistake(
        "Far rows are set to 0. They should not be there at all.",
        lambda right, cloud, distance: cloud * (_horizontal_distances(cloud) < distance)[:, None],
        "Index with the mask: cloud[mask] holds only the rows where it is True.",
    ),
    Mistake(
        "Nothing is removed: the cloud comes back as it went in.",
        lambda right, cloud, distance: cloud,
        is_cheap=True,
    ),
    cases=(
        (
            table(
                "12 3 0.1 0.1; 1 1.5 0.5 0.1; 2 2.1 0.3 0.2; 2.8 2.6 0.2 0.1; -1.1 -2 2.5 0.1; "
                "1.5 1 0.2 9; -7 1 0.1 0.1; 0.8 0.9 0.1 0.1; 1 -6 0.1 0.3"
            ),
            3.0,
        ),
        (
            table(
                "4 4.5 0.2 0.3; 3 3.5 0.3 0.2; -30 -2 0.1 0.2; 1 3 -4.5 0.1; 2 -1.2 0.1 7; "
                "1 1.2 0.1 0.4; 2 -13 0.4 0.2; 26 2 0.1 0.1; -3 40 0.2 0.6"
            ),
            5.0,
        ),
        (table("3 2 0.1 0.1; -2 5 11 0.1; 1 2 0.1 14"), 12.0),
        (
            table("1 1.5 6 0.1; 2 -9 0.3 0.2; -1.5 2 -3.9 0.1; 0.5 3 0.2 0.1; -6 1 0.1 0.2"),
            4.0,
        ),
        (
            table("2 3 -8 0.1; -3 20 0.5 0.3; 5 4 4.5 0.2; -6 -2 -5 0.1; 30 2 1 0.4"),
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


# The first clouds have points inside a box, on its faces, and outside it on either side in one, two
# or three coordinates. The last three clouds have no point outside.
_BOXES = (
    (
        table(
            "2 1 0.5 0.5; 9 1 0.5 0.1; 2 -7 0.5 0.2; 2 1 5 0.3; 0.5 0.5 -0.7 0.4; -8 -9 0 0.6; "
            "9 8 7 0.7; -5 -6 -7 0.8; -9 0.5 8 0.2; 3 -1 0.5 0.9"
        ),
        (-1.0, -2.0, -0.5),
        (4.0, 2.0, 1.5),
    ),
    (
        table(
            "0.5 6 -0.5 0.5; 0 5 3 0.1; 9 5.5 -0.5 0.2; 40 -9 0.2 0.2; -14 -8 -4 0.3; "
            "0.5 6.5 -6 0.2; 0.5 -1 -0.6 0.4; 35 9.5 4 0.7"
        ),
        (-2.5, 4.0, -1.5),
        (1.5, 7.0, 0.5),
    ),
    (
        table(
            "1 2 3.5 0.3; 3 2.5 3.5 0.1; 2 4 3.5 0.1; 2 2.5 3 0.5; 2 3 3.5 0.2; 0 9 8 0.2; "
            "0.5 1 2 0.6"
        ),
        (1.0, 2.0, 3.0),
        (3.0, 4.0, 5.0),
    ),
    (
        table("4 2 1 0.3; 2 2 1 0.1; 2 1 0 0.2"),
        (0.0, 0.0, 0.0),
        (4.0, 4.0, 4.0),
    ),
    (
        table("0.5 -0.5 1.5 0.3; 1.5 0.5 2.5 0.1"),
        (0.0, -1.0, 1.0),
        (2.0, 1.0, 3.0),
    ),
    (
        table("-3.5 2.5 -1 0.7; -2.5 3.5 0.5 0.2; -1.5 4.5 0 0.1"),
        (-4.0, 2.0, -1.5),
        (-1.0, 5.0, 1.0),
    ),
)

mistakes(
    "crop_region",
    Mistake(
        "It is the other way round: what is inside goes, and what is outside stays.",
        lambda right, *case: _rows_outside(*case),
        "Index with the mask of the rows inside, without ~.",
    ),
    Mistake(
        "One coordinate inside the box is enough here; all three have to be.",
        lambda right, *case: case[0][_depths(*case).max(axis=1) >= 0],
        ".all(axis=1), not .any(axis=1).",
    ),
    Mistake(
        "Only x and y are compared; z has to be inside, too.",
        lambda right, *case: case[0][_depths(*case)[:, :2].min(axis=1) >= 0],
        "Compare all three coordinates: cloud[:, :3].",
    ),
    Mistake(
        "Only minimum is compared; what lies beyond maximum stays.",
        lambda right, cloud, low, high: _rows_inside(cloud, low, np.full(3, 1e3)),
        "Join both comparisons with &.",
    ),
    Mistake(
        "Only maximum is compared; what lies before minimum stays.",
        lambda right, cloud, low, high: _rows_inside(cloud, np.full(3, -1e3), high),
        "Join both comparisons with &.",
    ),
    Mistake(
        "The lesson's own region decides, whatever minimum and maximum are.",
        lambda right, cloud, low, high: _rows_inside(cloud, _MINIMUM, _MAXIMUM),
        "Compare with minimum and maximum, by their names.",
    ),
    Mistake(
        "Points outside are moved to the border. They should not be there at all.",
        lambda right, cloud, low, high: np.column_stack(
            [np.clip(cloud[:, :3], low, high), cloud[:, 3:]]
        ),
        "Index with a mask: cloud[mask] holds only the rows where it is True.",
    ),
    Mistake(
        "There is one answer for the whole cloud: axis=1 is missing.",
        lambda right, *case: case[0][None][: int(len(right) == len(case[0]))],
        ".all(axis=1) gives one True or False for each row.",
    ),
    Mistake(
        "Nothing is left: no point counts as inside.",
        lambda right, cloud, low, high: cloud[:0],
        "Inside is >= minimum and <= maximum. Are the two exchanged, or the comparisons?",
        is_cheap=True,
    ),
    Mistake(
        "Nothing is removed: the cloud comes back as it went in.",
        lambda right, cloud, low, high: cloud,
        "A point is inside where both comparisons hold, which & says. With | one of them is "
        "enough, and one of them always holds. Then index with the mask: cloud[inside].",
        is_cheap=True,
    ),
    cases=_BOXES,
    right=_rows_inside,
    same=_same_rows,
)

mistakes(
    "remove_ego_returns",
    Mistake(
        "It is the other way round: what is inside stays, and what is outside goes.",
        lambda right, *case: _rows_inside(*case),
        "Index with ~inside.",
    ),
    Mistake(
        "Only what is outside in x and in y and in z stays; one of them is enough.",
        lambda right, *case: case[0][_depths(*case).max(axis=1) < 0],
        "Join the comparisons that say outside with .any(axis=1); or invert at the very end, "
        "~inside.",
    ),
    Mistake(
        "Only x and y are compared; what is above or below the box is no part of it.",
        lambda right, *case: case[0][_depths(*case)[:, :2].min(axis=1) < 0],
        "Compare all three coordinates: cloud[:, :3].",
    ),
    Mistake(
        "The lesson's own box decides, whatever minimum and maximum are.",
        lambda right, cloud, low, high: _rows_outside(cloud, *_EGO_BOX),
        "Compare with minimum and maximum, by their names.",
    ),
    Mistake(
        "Returns of our own car are set to 0. They should not be there at all.",
        lambda right, *case: case[0] * (_depths(*case).min(axis=1, keepdims=True) < 0),
        "Index with a mask: cloud[mask] holds only the rows where it is True.",
    ),
    Mistake(
        "There is one answer for the whole cloud: axis=1 is missing.",
        lambda right, *case: case[0][None][: int(len(right) > 0)],
        ".all(axis=1) gives one True or False for each row.",
    ),
    Mistake(
        "Only minimum is compared; what lies beyond maximum goes, too.",
        lambda right, cloud, low, high: _rows_outside(cloud, low, np.full(3, 1e3)),
        "Join both comparisons with &.",
    ),
    Mistake(
        "Only maximum is compared; what lies before minimum goes, too.",
        lambda right, cloud, low, high: _rows_outside(cloud, np.full(3, -1e3), high),
        "Join both comparisons with &.",
    ),
    Mistake(
        "Nothing is left: every point counts as inside.",
        lambda right, cloud, low, high: cloud[:0],
        "Inside is >= minimum and <= maximum, which & joins; outside is < minimum or > maximum, "
        "which | joins. The other way round it holds always, or never.",
        is_cheap=True,
    ),
    Mistake(
        "Nothing is removed: the cloud comes back as it went in.",
        lambda right, cloud, low, high: cloud,
        "Inside is >= minimum and <= maximum: are the two exchanged? Then index with ~inside.",
        is_cheap=True,
    ),
    cases=_BOXES,
    right=_rows_outside,
    same=_same_rows,
)
