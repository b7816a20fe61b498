"""Assertions about the boxes around labelled clusters, each for one property.

A box has eight corners in any order; the boxes are in ascending order of their labels. Pictures
show a box together with the points of its cluster.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

import utils
from utils.boxes import distance_outside
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    WrongForm,
    as_array,
    brief_text,
    point_text,
)
from utils.checks.failures import fixed

# Metres by which a point may be outside its box: more than rounding errors, less than the
# resolution of a scanner.
_SLACK = 2 * TOLERANCE
# A box is loose if its area exceeds this multiple of the smallest box's area. On the visible sides
# of a car, a box along the principal axes is larger than the smallest box, but below this limit.
LOOSE = 1.5
# Largest accepted angle in degrees between the sides of a box and those of its block. An answer
# that tries headings in steps of 5° must pass.
_HEADING_TOLERANCE = 6.0


def as_cluster_boxes(answer: object, cluster_labels: np.ndarray) -> np.ndarray:
    """Convert an answer to boxes, one for each label above 0.

    Parameters
    ----------
    answer : object
    cluster_labels : numpy.ndarray of int, shape (n,)

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    count = len(_box_labels(cluster_labels))
    if count == 0 and isinstance(answer, (list, tuple)) and not answer:
        return np.empty((0, 8, 3))  # an empty list is accepted
    boxes = as_array(answer, description="an array of boxes")
    sides = {"yours": f"shape {boxes.shape}", "expected": f"shape ({count}, 8, 3)"}
    if count == 0 and boxes.size == 0 and boxes.shape != (0, 8, 3):
        raise CheckFailed(fixed("An array without boxes must have the shape (0, 8, 3)."), **sides)
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise WrongForm(_explain_shape(boxes.shape), **sides)
    if len(boxes) != count:
        raise CheckFailed(
            f"Your function returned {_count_text(len(boxes), 'box')} for "
            f"{_count_text(count, 'cluster')}.",
            input_text=f"labels that occur: {brief_text(np.unique(cluster_labels))}",
            hint="Return one box for each label above 0 that occurs, and no others: "
            "np.unique(cluster_labels) lists the labels.",
            **sides,
        )
    bad = np.flatnonzero(~np.isfinite(boxes).all(axis=(1, 2)))
    if len(bad):
        broken = boxes[bad[0]][~np.isfinite(boxes[bad[0]]).all(axis=1)]
        size = np.count_nonzero(cluster_labels == _box_labels(cluster_labels)[bad[0]])
        raise CheckFailed(
            f"{_name_in_row(bad[0], cluster_labels)} has a corner that is not finite.",
            input_text=f"a cluster of {_count_text(size, 'point')}",
            yours=brief_text(broken[0]),
        )
    return boxes.astype(float)


def corners_between(low: Sequence[float], high: Sequence[float]) -> np.ndarray:
    """Return the corners of an axis-aligned box, in arbitrary order.

    Parameters
    ----------
    low, high : sequence of float
        Smallest and largest x, y and z.

    Returns
    -------
    numpy.ndarray, shape (8, 3)
    """
    return np.array(list(product(*zip(low, high, strict=True))), dtype=float)


def same_corners(yours: np.ndarray, expected: np.ndarray) -> bool:
    """Return whether two boxes have the same corners, in any order.

    Parameters
    ----------
    yours, expected : numpy.ndarray, shape (8, 3)
    """
    return _missing_corner(yours, expected) is None


def assert_box_corners(
    answer: object, expected: np.ndarray, cloud: np.ndarray, cluster_labels: np.ndarray
) -> None:
    """Assert that each box has the expected corners, in any order.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (N, 8, 3)
        One axis-aligned box for each label above 0, in ascending label order.
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    """
    yours = as_cluster_boxes(answer, cluster_labels)
    near = np.abs(yours[:, None] - expected[:, :, None]).max(axis=3) <= TOLERANCE
    # If each corner is near exactly one other, the boxes are equal. Only the remaining boxes, such
    # as flat ones, need the slow comparison.
    alike = (near.sum(axis=1) == 1).all(axis=1) & (near.sum(axis=2) == 1).all(axis=1)
    wrong = [row for row in np.flatnonzero(~alike) if not same_corners(yours[row], expected[row])]
    if not wrong:
        return
    labels, row = _box_labels(cluster_labels), wrong[0]
    if all(any(same_corners(mine, box) for mine in yours) for box in expected):
        raise CheckFailed(
            "The boxes are right, but not in the order of the labels.",
            input_text=f"labels that occur: {brief_text(np.unique(cluster_labels))}",
            yours=f"row {row} is not the box of label {labels[row]}",
            expected="one box for each label, in ascending order of the labels",
            hint="Loop over the labels from the smallest to the largest: np.unique sorts them.",
        )
    points = cloud[cluster_labels == labels[row], :3]
    raise _describe_difference(yours[row], expected[row], points, _name_in_row(row, cluster_labels))


def _describe_difference(
    yours: np.ndarray, expected: np.ndarray, points: np.ndarray, name: str
) -> CheckFailed:
    """Describe how a box differs: by one of its six bounds if axis-aligned, else by a corner."""
    place = expected[_missing_corner(yours, expected)]
    nearest = yours[np.linalg.norm(yours - place, axis=1).argmin()]
    ends = np.array([[box.min(axis=0), box.max(axis=0)] for box in (yours, expected)])
    is_axis_aligned = same_corners(yours, corners_between(*ends[0]))
    # Choose the axis for the message first, so that the picture can show it.
    axis = int((np.abs(ends[0] - ends[1]) > TOLERANCE).any(axis=0).argmax())
    if not is_axis_aligned:
        axis = int(np.abs(nearest - place).argmax())
    view = "side" if axis == 2 else "above"

    def draw() -> None:
        _draw_box(
            points, yours, expected, [place], view, "The circle should contain a corner of your box"
        )

    if is_axis_aligned:
        # Choose a corner at the wrong end, because the corners at the other end may be right.
        end = np.abs(ends[0] - ends[1])[:, axis].argmax()
        place = expected[np.isclose(expected[:, axis], ends[1][end, axis])][0]
        letter, input_text = "xyz"[axis], None
        if len(points) <= 20:
            input_text = f"{letter} of its points: {brief_text(points[:, axis])}"
        return CheckFailed(
            f"The smallest or the largest {letter} of {_lower_first(name)} is wrong.",
            input_text=input_text,
            yours="from {:.2f} to {:.2f}".format(*ends[0][:, axis]),
            expected="from {:.2f} to {:.2f}".format(*ends[1][:, axis]),
            draw=draw,
        )
    if all(any(_is_same_corner(corner, wanted) for wanted in expected) for corner in yours):
        return CheckFailed(
            f"{name} has some corners twice and others not at all.",
            yours=f"{len(np.unique(yours.round(3), axis=0))} different corners",
            expected=f"also a corner at {point_text(place)}",
            draw=draw,
        )
    return CheckFailed(
        f"{name} is missing a corner.",
        yours=f"the nearest corner is {point_text(nearest)}",
        expected=f"a corner at {point_text(place)}",
        draw=draw,
    )


def assert_upright(answer: object, cloud: np.ndarray, cluster_labels: np.ndarray) -> None:
    """Assert that each box has a level, rectangular floor and a level roof directly above it.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    """
    for box, points, name in _boxes_with_points(answer, cloud, cluster_labels):
        _assert_level(box, points, name)
        _require_footprint(box, points, name)


def assert_heights(answer: object, cloud: np.ndarray, cluster_labels: np.ndarray) -> None:
    """Assert that each box extends from the lowest to the highest point of its cluster.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    """
    for box, points, name in _boxes_with_points(answer, cloud, cluster_labels):
        for word, which, yours, right in (
            ("floor", "lowest", box[:, 2].min(), points[:, 2].min()),
            ("roof", "highest", box[:, 2].max(), points[:, 2].max()),
        ):
            if abs(yours - right) > _SLACK:
                raise CheckFailed(
                    f"The {word} of {_lower_first(name)} is not at the height of its "
                    f"{which} point.",
                    yours=f"z = {yours:.2f}",
                    expected=f"z = {right:.2f}",
                    draw=lambda box=box, points=points: _draw_box(points, box, view="side"),
                )


def assert_contains_points(
    answer: object, cloud: np.ndarray, cluster_labels: np.ndarray, input_text: str | None = None
) -> None:
    """Assert that, seen from above, each box contains all points of its cluster.

    A tight box, at any heading, covers less than the square of the diagonal of the points'
    bounding rectangle. Much larger boxes fail, because they would contain anything.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    input_text : str, optional
        The arguments of the call, for the message.
    """
    for box, points, name in _boxes_with_points(answer, cloud, cluster_labels):
        rectangle = _require_footprint(box, points, name)
        across = np.linalg.norm(np.ptp(points[:, :2], axis=0))
        if _area(rectangle) > (1.2 * across + _SLACK) ** 2:
            raise CheckFailed(
                f"{name} covers far more ground than any box around its points needs.",
                input_text=input_text,
                yours=f"{_area(rectangle):.1f} square metres",
                expected=f"less than {max(across**2, 0.1):.1f} square metres",
                hint="Take the minimum and maximum of the points of one label, after turning "
                "them by minus yaw.",
                draw=lambda box=box, points=points: _draw_box(points, box),
            )
        outside = _distances_outside(points[:, :2], rectangle)
        if outside.max() <= _SLACK:
            continue
        farthest, missed = points[outside.argmax()], np.count_nonzero(outside > _SLACK)
        raise CheckFailed(
            f"{name} does not contain all of its points: {missed} of {len(points)} "
            f"{'is' if missed == 1 else 'are'} outside.",
            input_text=input_text,
            yours=f"{point_text(farthest)} is {outside.max():.2f} m outside",
            expected="every point of the cluster inside",
            draw=lambda box=box, points=points, farthest=farthest: _draw_box(
                points, box, circles=[farthest], title="The circled point is outside its box"
            ),
        )


def assert_headings(
    answer: object,
    cloud: np.ndarray,
    cluster_labels: np.ndarray,
    headings: Sequence[float],
    input_text: str | None = None,
) -> None:
    """Assert that the sides of each box are parallel to those of the block inside it.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
        Blocks that are clearly longer than wide, seen from above.
    cluster_labels : numpy.ndarray of int, shape (n,)
    headings : sequence of float
        Headings of the blocks, in degrees.
    input_text : str, optional
        The arguments of the call, for the message.
    """
    for (box, points, name), heading in zip(
        _boxes_with_points(answer, cloud, cluster_labels), headings, strict=True
    ):
        sides = np.diff(_require_footprint(box, points, name)[:3], axis=0)
        along = sides[np.linalg.norm(sides, axis=1).argmax()]
        yours = np.degrees(np.arctan2(along[1], along[0]))
        off = abs((yours - heading + 45) % 90 - 45)
        if np.linalg.norm(along) <= TOLERANCE or off > _HEADING_TOLERANCE:
            raise CheckFailed(
                f"{name} is not aligned with its cluster: it has the wrong heading.",
                input_text=input_text,
                yours=f"a side at {yours % 90:.0f}° to the x axis",
                expected=f"a side at {heading % 90:.0f}°",
                draw=lambda box=box, points=points: _draw_box(
                    points, box, title="The box and the points of its cluster"
                ),
            )


def assert_snug(
    answer: object,
    cloud: np.ndarray,
    cluster_labels: np.ndarray,
    smallest_areas: Sequence[float],
    input_text: str | None = None,
) -> None:
    """Assert that no box covers more than `LOOSE` times the area that it needs.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    smallest_areas : sequence of float
        Area in square metres of the smallest rectangle around each cluster, seen from above;
        infinite if a box may be loose.
    input_text : str, optional
        The arguments of the call, for the message.
    """
    for (box, points, name), smallest in zip(
        _boxes_with_points(answer, cloud, cluster_labels), smallest_areas, strict=True
    ):
        area = _area(_require_footprint(box, points, name))
        if area > LOOSE * smallest + _SLACK:
            raise CheckFailed(
                f"{name} covers far more ground than it needs.",
                input_text=input_text,
                yours=f"{area:.1f} square metres",
                expected=f"about {smallest:.1f} square metres",
                draw=lambda box=box, points=points: _draw_box(points, box),
            )


def footprint(box: np.ndarray) -> np.ndarray | None:
    """Return the floor rectangle of an upright box.

    Parameters
    ----------
    box : numpy.ndarray, shape (8, 3)
        Corners in any order.

    Returns
    -------
    numpy.ndarray, shape (4, 2), or None
        Corners in cyclic order; None unless they form a rectangle with one corner above each.
    """
    pairs = _corner_pairs(box)
    below, above = box[pairs[:, 0], :2], box[pairs[:, 1], :2]
    if np.abs(below - above).max() > _SLACK:
        return None
    # Of these three orders, only the cyclic one leaves no error. Pairing each corner with the
    # farthest would fail for long thin boxes, where rounding decides between two corners.
    orders = [below[list(order)] for order in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 1, 3))]
    best = min(orders, key=_deviation_from_rectangle)
    return best if _deviation_from_rectangle(best) <= _SLACK else None


def _deviation_from_rectangle(corners: np.ndarray) -> float:
    """Return the deviation in metres of four corners (4, 2) in cyclic order from a rectangle."""
    # For so few numbers, plain Python is several times as fast as NumPy.
    first, second, third, fourth = corners.tolist()
    sums = zip(first, third, second, fourth, strict=True)
    middles_apart = math.hypot(*(a + c - b - d for a, c, b, d in sums)) / 2
    return max(middles_apart, abs(math.dist(third, first) - math.dist(fourth, second)))


def _corner_pairs(box: np.ndarray) -> np.ndarray:
    """Return pairs of rows, (4, 2): each corner of the floor and the corner above it."""
    if np.ptp(box[:, 2]) > 4 * TOLERANCE:
        order = np.argsort(box[:, 2], kind="stable")
        floor, roof = order[:4].tolist(), order[4:].tolist()
    else:  # flat: floor and roof coincide
        floor, roof = list(range(8)), list(range(8))
    pairs, places = [], box[:, :2].tolist()
    while floor:
        row = floor.pop(0)
        others = [other for other in roof if other != row]
        partner = min(others, key=lambda other: math.dist(places[other], places[row]))
        roof = [other for other in others if other != partner]
        floor = [other for other in floor if other != partner]
        pairs.append((row, partner))
    return np.array(pairs)


def _boxes_with_points(
    answer: object, cloud: np.ndarray, cluster_labels: np.ndarray
) -> Iterator[tuple[np.ndarray, np.ndarray, str]]:
    """Yield each box (8, 3), the points (m, 3) of its cluster, and a name for the message."""
    boxes = as_cluster_boxes(answer, cluster_labels)
    labels = _box_labels(cluster_labels)
    clusters = [np.asarray(cloud[cluster_labels == label, :3], dtype=float) for label in labels]
    _assert_order(boxes, clusters)
    for box, points, label in zip(boxes, clusters, labels, strict=True):
        yield box, points, _name_of_label(label)


def _require_footprint(box: np.ndarray, points: np.ndarray, name: str) -> np.ndarray:
    rectangle = footprint(box)
    if rectangle is None:
        hint = (
            "Turn the box about z only. Then each corner of the roof has the same x and y as the "
            "one below it."
        )
        if np.ptp(box[:, 2]) > _SLACK and len(np.unique(box, axis=0)) < len(box):
            hint = "Write eight different corners. In your box, one corner occurs twice."
        raise CheckFailed(
            f"{name} does not have a rectangular floor.",
            yours=brief_text(box[:, :2]),
            expected="four corners with right angles and another corner above each",
            hint=hint,
            draw=lambda: _draw_box(points, box),
        )
    return rectangle


def _area(rectangle: np.ndarray) -> float:
    return float(np.prod(np.linalg.norm(np.diff(rectangle[:3], axis=0), axis=1)))


def _distances_outside(points: np.ndarray, rectangle: np.ndarray) -> np.ndarray:
    """Return how far points (n, 2) are outside a rectangle (4, 2) of any size; negative inside."""
    reach = np.linalg.norm(np.diff(rectangle[:3], axis=0), axis=1).max() / 2
    if reach <= TOLERANCE:  # so small that rounding alone determines the heading
        return np.linalg.norm(points - rectangle.mean(axis=0), axis=1) - reach
    return distance_outside(points, rectangle)


def _assert_order(boxes: np.ndarray, clusters: list[np.ndarray]) -> None:
    if len(boxes) < 2:
        return
    low, high = boxes.min(axis=1) - _SLACK, boxes.max(axis=1) + _SLACK
    means = np.array([points.mean(axis=0) for points in clusters])[:, None]
    contains = ((low <= means) & (means <= high)).all(axis=2)
    if not contains.diagonal().all() and contains.any(axis=0).all() and contains.any(axis=1).all():
        raise CheckFailed(
            "The boxes are not in the order of the labels.",
            yours=f"the box in row {np.flatnonzero(~contains.diagonal())[0]} belongs "
            "to another cluster",
            expected="one box for each label, in ascending order of the labels",
            hint="Loop over the labels from the smallest to the largest: np.unique sorts them.",
        )


def _assert_level(box: np.ndarray, points: np.ndarray, name: str) -> None:
    heights = np.sort(box[:, 2])
    uneven = max(np.ptp(heights[:4]), np.ptp(heights[4:]))
    if uneven > _SLACK:
        raise CheckFailed(
            f"{name} is tilted: its floor or its roof is not level.",
            yours=f"corners of one face differ in height by {uneven:.2f} m",
            expected="turned about z only",
            draw=lambda: _draw_box(points, box, view="side"),
        )


def _missing_corner(yours: np.ndarray, expected: np.ndarray) -> int | None:
    """Return the index of the first expected corner without a partner; None if all have one."""
    free = list(range(8))
    for corner, place in enumerate(expected):
        partner = next((row for row in free if _is_same_corner(yours[row], place)), None)
        if partner is None:
            return corner
        free.remove(partner)
    return None


def _is_same_corner(corner: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(corner - other).max() <= TOLERANCE)


def _explain_shape(shape: tuple[int, ...]) -> str:
    if len(shape) == 3 and shape[1:] == (3, 8):
        return "The corners are in columns: each corner must be a row (x, y, z)."
    if len(shape) == 3 and shape[1:] == (8, 4):
        return "A corner has x, y and z only: leave the intensity out."
    if len(shape) == 3 and shape[2] == 3:
        return f"There are {shape[1]} corners for each box; {fixed('a box has 8')}."
    if shape == (8, 3):
        return "This is a single box. Even a single box must be in an array of boxes."
    return fixed("The answer must contain N boxes with 8 corners (rows) of 3 coordinates each.")


def _box_labels(cluster_labels: np.ndarray) -> np.ndarray:
    return np.unique(cluster_labels[cluster_labels > 0])


def _name_in_row(row: int, cluster_labels: np.ndarray) -> str:
    return _name_of_label(_box_labels(cluster_labels)[row])


def _name_of_label(label: int) -> str:
    return f"The box of label {label}"


def _lower_first(name: str) -> str:
    return name[0].lower() + name[1:]


def _count_text(count: int, noun: str) -> str:
    plural = noun + ("es" if noun.endswith("x") else "s")
    return f"{count} {noun if count == 1 else plural}"


def _draw_box(
    points: np.ndarray,
    yours: np.ndarray,
    expected: np.ndarray | None = None,
    circles: Sequence[np.ndarray] = (),
    view: str = "above",
    title: str | None = None,
) -> None:
    """Draw a box (8, 3) and the points (m, 3) that it should contain, all of them in view."""
    columns = [0, 1] if view == "above" else [0, 2]
    shown = [points, yours] if expected is None else [points, yours, expected]
    in_view = np.vstack(shown)[:, columns]
    margin = 0.08 * np.ptp(in_view, axis=0).max() + 0.3
    limits = tuple(zip(in_view.min(axis=0) - margin, in_view.max(axis=0) + margin, strict=True))
    axes = None
    if expected is not None:
        axes = utils.plots.boxes(
            expected[None], cloud=points, view=view, label="expected", reference=True, limits=limits
        )
    axes = utils.plots.boxes(
        yours[None],
        cloud=points if axes is None else None,
        view=view,
        label="yours",
        limits=limits,
        axes=axes,
        title=title,
    )
    for place in circles:
        axes.plot(
            *np.asarray(place)[columns],
            "o",
            markersize=16,
            markerfacecolor="none",
            markeredgecolor="black",
            markeredgewidth=1.6,
            zorder=9,
        )
