"""Assertions about boxes: eight corners each, in any order, the boxes in ascending label order."""

from collections.abc import Sequence

import numpy as np

import utils
from utils.boxes import distance_outside
from utils.checks.vocabulary import TOLERANCE, CheckFailed, as_array, brief, point_text

# A point may stick out this far (m): less than any scanner measures, more than rounding does.
_SLACK = 2 * TOLERANCE
# A rectangle turned badly is at least so many times as large as the smallest one. Principal axes
# and the smallest rectangle differ on what a scanner sees of a car, but stay below it.
LOOSE = 1.5


def as_cluster_boxes(answer: object, cluster_labels: np.ndarray) -> np.ndarray:
    """An answer as boxes, one for each label above 0.

    Parameters
    ----------
    answer : object
    cluster_labels : numpy.ndarray of int, shape (n,)

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    count = len(_names(cluster_labels))
    if count == 0 and isinstance(answer, (list, tuple)) and not answer:
        return np.empty((0, 8, 3))  # a list of no boxes
    boxes = as_array(answer, what="an array of boxes")
    if boxes.shape != (count, 8, 3):
        raise CheckFailed(
            _wrong_shape(boxes.shape, count, cluster_labels),
            yours=f"shape {boxes.shape}",
            expected=f"shape ({count}, 8, 3)",
        )
    bad = np.flatnonzero(~np.isfinite(boxes).all(axis=(1, 2)))
    if len(bad):
        raise CheckFailed(
            f"{_box(bad[0], cluster_labels)} has a corner that is not finite: its "
            "minimum or maximum was never set.",
            yours=brief(boxes[bad[0]]),
        )
    return boxes.astype(float)


def assert_box_corners(
    answer: object, expected: np.ndarray, cloud: np.ndarray, cluster_labels: np.ndarray
) -> None:
    """Each box has the expected corners, in any order.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (N, 8, 3)
        One box for each label above 0, in ascending label order; corner k has the larger x where
        k & 1, the larger y where k & 2, the larger z where k & 4.
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    """
    yours = as_cluster_boxes(answer, cluster_labels)
    wrong = [
        box
        for box in range(len(expected))
        if _missing_corner(yours[box], expected[box]) is not None
    ]
    if not wrong:
        return
    if all(any(_missing_corner(mine, box) is None for mine in yours) for box in expected):
        raise CheckFailed(
            "These are the right boxes in another order.",
            yours=f"{_box(wrong[0], cluster_labels)} is not in row {wrong[0]}",
            expected="one box for each label, in ascending order of the labels",
        )
    box = wrong[0]
    corner = _missing_corner(yours[box], expected[box])
    place = expected[box][corner]
    nearest = yours[box][np.linalg.norm(yours[box] - place, axis=1).argmin()]
    if all(any(_same(mine, right) for right in expected[box]) for mine in yours[box]):
        message = "has some corners twice and others not at all"
        corner_text = f"{len(np.unique(yours[box].round(3), axis=0))} different corners"
    else:
        message = f"has no corner at {_corner_name(corner)}"
        corner_text = f"the nearest is {point_text(nearest)}"
    side = np.abs(nearest - place).argmax() == 2
    raise CheckFailed(
        f"{_box(box, cluster_labels)} {message} ({len(wrong)} of {len(expected)} boxes are wrong).",
        yours=corner_text,
        expected=point_text(place),
        draw=lambda: _draw(
            cloud,
            yours,
            expected,
            [place],
            "side" if side else "above",
            f"corner {corner}: the circle should hold one of yours",
        ),
    )


def assert_turned_boxes(
    answer: object,
    cloud: np.ndarray,
    cluster_labels: np.ndarray,
    smallest_areas: Sequence[float] | None = None,
) -> None:
    """Each box stands upright on a turned rectangle and holds all points of its cluster.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    cluster_labels : numpy.ndarray of int, shape (n,)
    smallest_areas : sequence of float, optional
        Area in square metres of the smallest rectangle around each cluster, seen from above.
        No box may cover more than `LOOSE` times as much. Without it boxes may be loose.
    """
    boxes = as_cluster_boxes(answer, cluster_labels)
    clusters = [
        np.asarray(cloud[cluster_labels == label, :3], dtype=float)
        for label in _names(cluster_labels)
    ]
    _assert_order(boxes, clusters)
    limits = [None] * len(boxes) if smallest_areas is None else smallest_areas
    for number, points in enumerate(clusters):
        name = _box(number, cluster_labels)
        _assert_level(boxes[number], name)
        _assert_heights(boxes[number], points, name)
        rectangle = footprint(boxes[number])
        if rectangle is None:
            raise CheckFailed(
                f"{name} does not stand on a rectangle.",
                yours=brief(boxes[number, :, :2]),
                expected="four corners with right angles, each with one above it",
                draw=lambda: _draw(cloud, boxes),
            )
        _assert_inside(points, rectangle, name, cloud, boxes)
        _assert_snug(rectangle, limits[number], name, cloud, boxes)


def footprint(box: np.ndarray) -> np.ndarray | None:
    """The rectangle (4, 2) on which an upright box stands, corners in cyclic order.

    Parameters
    ----------
    box : numpy.ndarray, shape (8, 3)
        Corners in any order.

    Returns
    -------
    numpy.ndarray or None
        None where the corners are not those of a rectangle with one corner above each.
    """
    pairs = _pairs(box)
    below, above = box[pairs[:, 0], :2], box[pairs[:, 1], :2]
    if np.abs(below - above).max() > _SLACK:
        return None
    # Of the three ways to go round, a rectangle's own leaves no error. Long thin boxes are the
    # reason not to look for the farthest corner: rounding decides which of two that is.
    rounds = [below[list(order)] for order in ((0, 1, 2, 3), (0, 1, 3, 2), (0, 2, 1, 3))]
    best = min(rounds, key=_crookedness)
    return best if _crookedness(best) <= _SLACK else None


def _crookedness(corners: np.ndarray) -> float:
    """How far four corners (4, 2) going round are from a rectangle, in metres."""
    first, second, third, fourth = corners
    middles_apart = np.linalg.norm(first + third - second - fourth) / 2
    diagonals = np.linalg.norm(third - first), np.linalg.norm(fourth - second)
    return max(middles_apart, abs(diagonals[0] - diagonals[1]))


def _pairs(box: np.ndarray) -> np.ndarray:
    """Rows of the four corners of the floor, each with the row of the one above it: (4, 2)."""
    if np.ptp(box[:, 2]) > 4 * TOLERANCE:
        order = np.argsort(box[:, 2], kind="stable")
        floor, roof = order[:4].tolist(), order[4:].tolist()
    else:  # flat: floor and roof coincide
        floor, roof = list(range(8)), list(range(8))
    pairs = []
    while floor:
        row = floor.pop(0)
        others = [other for other in roof if other != row]
        partner = min(others, key=lambda other: np.linalg.norm(box[other, :2] - box[row, :2]))
        roof = [other for other in others if other != partner]
        floor = [other for other in floor if other != partner]
        pairs.append((row, partner))
    return np.array(pairs)


def _outside(points: np.ndarray, rectangle: np.ndarray) -> np.ndarray:
    """How far points (n, 2) are outside a rectangle (4, 2), if need be a speck; negative inside."""
    reach = np.linalg.norm(np.diff(rectangle[:3], axis=0), axis=1).max() / 2
    if reach <= TOLERANCE:  # rounding alone decides where a speck heads
        return np.linalg.norm(points - rectangle.mean(axis=0), axis=1) - reach
    return distance_outside(points, rectangle)


def _assert_order(boxes: np.ndarray, clusters: list[np.ndarray]) -> None:
    if len(boxes) < 2:
        return
    low, high = boxes.min(axis=1) - _SLACK, boxes.max(axis=1) + _SLACK
    middles = np.array([points.mean(axis=0) for points in clusters])[:, None]
    holds = ((low <= middles) & (middles <= high)).all(axis=2)
    if not holds.diagonal().all() and holds.any(axis=0).all() and holds.any(axis=1).all():
        raise CheckFailed(
            "The boxes are in another order than the labels.",
            yours=f"the box in row {np.flatnonzero(~holds.diagonal())[0]} belongs "
            "to another cluster",
            expected="one box for each label, in ascending order of the labels",
        )


def _assert_level(box: np.ndarray, name: str) -> None:
    heights = np.sort(box[:, 2])
    uneven = max(np.ptp(heights[:4]), np.ptp(heights[4:]))
    if uneven > _SLACK:
        raise CheckFailed(
            f"{name} is tilted: its floor or its roof is not level.",
            yours=f"corners of one face differ in height by {uneven:.2f} m",
            expected="turned about z only",
        )


def _assert_heights(box: np.ndarray, points: np.ndarray, name: str) -> None:
    for word, yours, right in (
        ("floor", box[:, 2].min(), points[:, 2].min()),
        ("roof", box[:, 2].max(), points[:, 2].max()),
    ):
        if abs(yours - right) > _SLACK:
            which = "lowest" if word == "floor" else "highest"
            raise CheckFailed(
                f"The {word} of {name[0].lower() + name[1:]} is not at the height "
                f"of its {which} point.",
                yours=f"z = {yours:.2f}",
                expected=f"z = {right:.2f}",
            )


def _assert_inside(
    points: np.ndarray, rectangle: np.ndarray, name: str, cloud: np.ndarray, boxes: np.ndarray
) -> None:
    outside = _outside(points[:, :2], rectangle)
    if outside.max() <= _SLACK:
        return
    farthest = points[outside.argmax()]
    raise CheckFailed(
        f"{name} does not contain all of its points: {np.count_nonzero(outside > _SLACK)} of "
        f"{len(points)} are outside.",
        yours=f"{point_text(farthest)} is {outside.max():.2f} m outside",
        expected="every point of the cluster inside",
        draw=lambda: _draw(
            cloud, boxes, circles=[farthest], title="The circled point is outside its box"
        ),
    )


def _assert_snug(
    rectangle: np.ndarray,
    smallest_area: float | None,
    name: str,
    cloud: np.ndarray,
    boxes: np.ndarray,
) -> None:
    area = np.prod(np.linalg.norm(np.diff(rectangle[:3], axis=0), axis=1))
    if smallest_area is None or area <= LOOSE * smallest_area + _SLACK:
        return
    raise CheckFailed(
        f"{name} covers far more ground than it needs: it is not turned with its cluster.",
        yours=f"{area:.1f} square metres",
        expected=f"about {smallest_area:.1f} square metres",
        draw=lambda: _draw(cloud, boxes, title="Loose boxes: are they turned with their clusters?"),
    )


def _missing_corner(yours: np.ndarray, expected: np.ndarray) -> int | None:
    """Number of the first expected corner that none of yours stands for; None if all are there."""
    free = list(range(8))
    for corner, place in enumerate(expected):
        partner = next((row for row in free if _same(yours[row], place)), None)
        if partner is None:
            return corner
        free.remove(partner)
    return None


def _same(corner: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(corner - other).max() <= TOLERANCE)


def _wrong_shape(shape: tuple[int, ...], count: int, cluster_labels: np.ndarray) -> str:
    if count == 0:
        return (
            "Where no label is above 0 there are no boxes, but the array keeps its form: "
            "0 boxes of 8 corners of 3 coordinates."
        )
    if len(shape) == 3 and shape[1:] == (8, 3):
        if shape[0] == count + 1 and (cluster_labels <= 0).any():
            return f"{shape[0]} boxes for {count} clusters: label 0 is no obstacle, it gets no box."
        return f"{shape[0]} boxes for {count} clusters: one for each different label above 0."
    if len(shape) == 3 and shape[1:] == (3, 8):
        return "The corners stand in columns: each corner must be a row (x, y, z)."
    if len(shape) == 3 and shape[1:] == (8, 4):
        return "A corner has x, y and z only: leave the intensity out."
    if len(shape) == 3 and shape[2] == 3:
        return f"There are {shape[1]} corners for each box; a box has 8."
    if shape == (8, 3):
        return "This is one box alone; even one box is returned as an array of boxes."
    return "The answer must hold N boxes of 8 corners (rows) of 3 coordinates."


def _names(cluster_labels: np.ndarray) -> np.ndarray:
    return np.unique(cluster_labels[cluster_labels > 0])


def _box(number: int, cluster_labels: np.ndarray) -> str:
    return f"The box of label {_names(cluster_labels)[number]}"


def _corner_name(corner: int) -> str:
    parts = [("max " if corner >> axis & 1 else "min ") + "xyz"[axis] for axis in range(3)]
    return f"({', '.join(parts)})"


def _draw(
    cloud: np.ndarray,
    yours: np.ndarray,
    expected: np.ndarray | None = None,
    circles: Sequence[np.ndarray] = (),
    view: str = "above",
    title: str | None = None,
) -> None:
    columns = [0, 1] if view == "above" else [0, 2]
    shown = [yours] if expected is None else [yours, expected]
    seen = np.vstack([corners.reshape(-1, 3) for corners in shown] + list(circles))[:, columns]
    spare = 0.08 * np.ptp(seen, axis=0).max() + 0.3
    limits = tuple(zip(seen.min(axis=0) - spare, seen.max(axis=0) + spare, strict=True))
    axes = None
    if expected is not None:
        axes = utils.plots.boxes(
            expected, cloud=cloud, view=view, label="expected", reference=True, limits=limits
        )
    axes = utils.plots.boxes(
        yours,
        cloud=cloud if axes is None else None,
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
