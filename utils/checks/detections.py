"""Assertions about the boxes that a detector returns for a scan."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

import utils
from utils.boxes import Box, distance_outside
from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    brief_text,
    point_text,
    precondition,
)
from utils.checks.boxes import footprint
from utils.checks.failures import fixed
from utils.checks.run_cache import answer_to, once_per_run
from utils.checks.scans import EGO_CAR, clear_cars, clear_people

if TYPE_CHECKING:
    from utils.simulator.frames import Frame

_MIN_SHARE = 0.8  # smallest share of an object's returns that its box must contain
# A car may have four boxes: its own, and boxes of its mirror and of clusters seen through windows.
_MAX_BOXES_PER_OBJECT = 4
_MAX_BOXES = 1000  # comparing more boxes is slow, and no right answer has so many
# Largest area of turned boxes, as a multiple of the area of their cars. In forty scans by
# `scans.square`, turned boxes had less than 1.25 times the area of the cars, and axis-aligned boxes
# more than 1.5 times.
_MAX_AREA_RATIO = 1.33
_MAX_PERSON_AREA = 3.0  # square metres
_CARS_FOUND = "isolated cars near the sensor have separate boxes in the scan of this check"


def detect_once(detect_obstacles: Callable, frame: Frame) -> object:
    """Return the detector's answer for an unchanged frame, cached for the run of checks."""
    return answer_to(detect_obstacles, frame, frame.cloud)


def as_boxes(answer: object) -> np.ndarray:
    """Convert an answer to an array of boxes.

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    if isinstance(answer, (list, tuple)) and not answer:
        return np.empty((0, 8, 3))
    boxes = as_array(answer, description="an array of boxes")
    if boxes.size == 0 and boxes.shape[:1] == (0,):
        return np.empty((0, 8, 3))
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise WrongForm(
            fixed("The answer must contain N boxes of 8 corners (rows) of 3 coordinates."),
            yours=f"shape {boxes.shape}",
            expected="shape (N, 8, 3)",
        )
    if len(boxes) > _MAX_BOXES:
        raise WrongForm(
            "There are more than a thousand boxes, although the street has only a few dozen "
            "objects.",
            yours=f"{len(boxes)} boxes",
            expected="about 10 to 80",
            hint=_SPLIT_HINT,
        )
    if not np.isfinite(boxes).all():
        bad = np.flatnonzero(~np.isfinite(boxes).all(axis=(1, 2)))[0]
        raise WrongForm(
            "A box has a corner that is not finite.",
            yours=brief_text(boxes[bad]),
            hint="Remove returns that are not finite before you fit boxes. Do not divide by the "
            "length of a cluster, which is 0 for a single point.",
        )
    return boxes.astype(float)


_MAX_GHOSTS = 2


def box_of(obstacle: Box, boxes: np.ndarray, frame: Frame) -> int | None:
    """Return the index of the box that contains most of a car or person and little else, or None.

    The result is also None if more than `_MAX_BOXES_PER_OBJECT` boxes are on the object, or if a
    much larger box contains it as well.

    Parameters
    ----------
    obstacle : utils.boxes.Box
    boxes : numpy.ndarray, shape (N, 8, 3)
    frame : utils.simulator.frames.Frame
    """
    returns = frame.cloud[frame.scan.objects == obstacle.identity, :3]
    # Detectors cut the ground at different heights, and may remove the wheels with it.
    returns = returns[returns[:, 2] > obstacle.centre[2] - obstacle.size[2] / 2 + 0.55]
    if len(_boxes_on(obstacle, boxes)) > _MAX_BOXES_PER_OBJECT:
        return None
    shares = {
        int(number): _is_inside(returns, boxes[number], 0.2).mean()
        for number in _boxes_over(boxes, obstacle.centre, 4.0)
    }
    fitting = {
        number: _is_box_size_plausible(boxes[number], obstacle)
        for number, share in shares.items()
        if share >= _MIN_SHARE
    }
    if any(shares[number] >= 0.9 and not fits for number, fits in fitting.items()):
        return None
    return next((number for number, fits in fitting.items() if fits), None)


def assert_cars_found(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """Assert that at least half of the clear cars have a separate box.

    A sensible detector misses one in a hundred clear cars, at the edge of its region.

    Parameters
    ----------
    answers : sequence of object
        The detector's answer for each frame.
    frames : sequence of utils.simulator.frames.Frame
    """
    _assert_found(answers, [(frame, clear_cars(frame)) for frame in frames], "cars")


_NAMES = {"pedestrian": "person", "truck": "lorry"}


def assert_contained(answer: object, obstacle: Box, frame: Frame) -> None:
    """Assert that at least one box contains an object; it may contain other things as well."""
    boxes, name = as_boxes(answer), _object_name(obstacle)
    returns = frame.cloud[frame.scan.objects == obstacle.identity, :3]
    returns = returns[returns[:, 2] > obstacle.centre[2] - obstacle.size[2] / 2 + 0.55]
    if not any(
        _is_inside(returns, boxes[number], 0.2).mean() >= _MIN_SHARE
        for number in _boxes_over(boxes, obstacle.centre, 4.0)
    ):
        raise CheckFailed(
            f"No box contains the {name} at {point_text(obstacle.centre[:2])}.",
            input_text=_visible_part(obstacle, frame),
            yours=f"{len(boxes)} boxes in that scan",
            expected=f"a box around that {name}",
            draw=lambda: _draw_boxes(frame, boxes, [obstacle.corners], "missed"),
        )


def assert_kind_contained(answer: object, kind: str, frame: Frame) -> None:
    """Assert that each object of a kind in the frame is inside at least one box."""
    for obstacle in frame.boxes:
        if obstacle.kind == kind:
            assert_contained(answer, obstacle, frame)


def assert_separate_boxes(answer: object, frame: Frame, gap: float) -> None:
    """Assert that no box contains both cars of a frame, which are parked `gap` metres apart."""
    boxes = as_boxes(answer)
    cars = [box for box in frame.boxes if box.kind == "car"]
    for box in boxes:
        shares = [
            _is_inside(frame.cloud[frame.scan.objects == car.identity, :3], box, 0.2).mean()
            for car in cars
        ]
        if min(shares) > 0.5:
            raise CheckFailed(
                f"Two cars that are parked {gap} m apart share one box.",
                yours="one box around both",
                expected="a box for each",
                draw=lambda box=box: _draw_boxes(frame, boxes, [box], "two cars"),
                hint="Pass a smaller threshold to the clustering. Two objects become one cluster "
                "if the threshold is larger than the gap between them.",
            )


def assert_no_boxes_on_road(answer: object, frame: Frame) -> None:
    """Assert that at most `_MAX_GHOSTS` boxes contain mostly road or nothing at all."""
    boxes = as_boxes(answer)
    ghosts = [box for box in boxes if not _contains_obstacle(box, frame)]
    if len(ghosts) > _MAX_GHOSTS:
        raise CheckFailed(
            f"{len(ghosts)} boxes contain mostly road or nothing at all, for example at "
            f"{point_text(ghosts[0][:, :2].mean(axis=0))}.",
            input_text="a road that climbs",
            yours=f"{len(boxes)} boxes in that scan",
            expected="boxes around cars, a lorry and a person",
            draw=lambda: _draw_boxes(frame, boxes, ghosts, "road"),
        )


def assert_people_found(answer: object, frame: Frame) -> None:
    """Assert that at least half of the clear people have a separate box."""
    _assert_found([answer], [(frame, clear_people(frame))], "people")


def require_cars_found(answer: object, frame: Frame) -> None:
    """Assert that the clear cars are found; without boxes, other checks would pass by mistake.

    Raises
    ------
    utils.checks.failures.NotYet
        If they are not found.
    """
    with precondition(_CARS_FOUND):
        assert_cars_found([answer], [frame])


@once_per_run
def require_cars_found_in_frame(detect_obstacles: Callable, frame: Frame) -> None:
    """Apply `require_cars_found` to the detector's answer for an unchanged frame."""
    require_cars_found(detect_once(detect_obstacles, frame), frame)


def assert_few_ghosts(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """Assert that there are not too many boxes, and that at most 40 % are mostly road or empty.

    A frame may have up to 20 boxes more than twice its number of true boxes.
    """
    ghosts, total = [], 0
    for answer, frame in zip(answers, frames, strict=True):
        boxes = as_boxes(answer)
        most = 2 * len(frame.boxes) + 20
        if len(boxes) > most:
            raise CheckFailed(
                "There are far more boxes than objects in the street.",
                yours=f"{len(boxes)} boxes",
                expected=f"fewer than {most}",
                draw=lambda frame=frame, boxes=boxes: _draw_boxes(frame, boxes),
                hint=_SPLIT_HINT,
            )
        total += len(boxes)
        ghosts += [(box, frame, boxes) for box in boxes if not _contains_obstacle(box, frame)]
    if len(ghosts) <= 0.4 * total:
        return
    box, frame, boxes = ghosts[0]
    inside_box = np.count_nonzero(_is_inside(_sorted_by_x(frame)[0], box, 0.05))
    raise CheckFailed(
        f"{len(ghosts)} of {total} boxes contain more road than obstacle, or nothing at all, for "
        f"example at {point_text(box[:, :2].mean(axis=0))}.",
        yours=f"{inside_box or 'no'} return{'s' if inside_box != 1 else ''} in that box",
        expected="boxes around cars, people, poles and walls",
        draw=lambda: _draw_boxes(
            frame, boxes, [ghost for ghost, home, _ in ghosts if home is frame], "nothing in it"
        ),
    )


def assert_no_box_on_ego_car(answer: object, frame: Frame) -> None:
    """Assert that no box is centred on the ego car."""
    boxes = as_boxes(answer)
    centres = boxes[:, :, :2].mean(axis=1)
    inside = ((centres > EGO_CAR[0]) & (centres < EGO_CAR[1])).all(axis=1)
    if inside.any():
        raise CheckFailed(
            "A box covers the ego car.",
            yours=f"a box with its centre at {point_text(centres[inside][0])}",
            expected="no box with its centre between x = -1.5 and 2.6 m, y = -1.7 and 1.7 m",
            draw=lambda: _draw_boxes(frame, boxes, boxes[inside], "ego car"),
        )


def assert_no_box_at_sensor(answer: object, frame: Frame) -> None:
    """Assert that no box contains the sensor's position, where lost returns are recorded."""
    boxes = as_boxes(answer)
    sensor = np.zeros((1, 3))
    near = _boxes_over(boxes, sensor[0], 0.1)
    at = [number for number in near if _is_inside(sensor, boxes[number], 0.1).any()]
    if at:
        raise CheckFailed(
            fixed(
                "A box contains (0, 0, 0), the position of the sensor. Lost returns are recorded "
                "there."
            ),
            yours=f"a box from {point_text(boxes[at[0]].min(axis=0))} to "
            f"{point_text(boxes[at[0]].max(axis=0))}",
            expected="no box there",
            draw=lambda: _draw_boxes(frame, boxes, boxes[at], "lost returns"),
        )


def assert_raindrops_ignored(answer: object, frame: Frame, drops: np.ndarray) -> None:
    """Assert that at most a third of the raindrops have boxes.

    Parameters
    ----------
    answer : object
    frame : utils.simulator.frames.Frame
    drops : numpy.ndarray, shape (n, 4)
        Single returns in the air, which the detector's input contains.
    """
    boxes = as_boxes(answer)
    small = boxes[np.ptp(boxes, axis=1).max(axis=1) < 1.0]
    away = np.linalg.norm(small.mean(axis=1)[:, None] - drops[:, :3], axis=2)
    wet = np.count_nonzero((away < 0.5).any(axis=0))
    if wet > len(drops) // 3:
        raise CheckFailed(
            "There are boxes around single returns in the air.",
            yours=f"boxes around {wet} of {len(drops)} raindrops",
            expected="no boxes around single returns",
            draw=lambda: _draw_boxes(frame, boxes, small[(away < 0.5).any(axis=1)], "a drop"),
        )


def assert_no_box_left(answer: object, car: Box, frame: Frame) -> None:
    """Assert that no box of a similar size is where a car used to be.

    Parameters
    ----------
    answer : object
    car : utils.boxes.Box
        A car that was removed from the frame.
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    left = [
        number for number in _boxes_on(car, boxes) if _is_box_size_plausible(boxes[number], car)
    ]
    if left:
        raise CheckFailed(
            "A box surrounds an empty place. A car was there in another scan, but not in this one.",
            yours=f"a box at {point_text(car.centre[:2])}",
            expected="boxes only around objects in this scan",
            draw=lambda: _draw_boxes(frame, boxes, boxes[left], "nothing in it"),
        )


def assert_boxes_turned(answer: object, frame: Frame) -> None:
    """Assert that the boxes of cars at an angle are not much larger than the cars."""
    boxes = as_boxes(answer)
    pairs = [(car, box_of(car, boxes, frame)) for car in clear_cars(frame)]
    pairs = [(car, boxes[number]) for car, number in pairs if number is not None]
    area = sum(np.prod(_side_lengths(box)) for _, box in pairs)
    true_area = sum(car.size[0] * car.size[1] for car, _ in pairs)
    if area > _MAX_AREA_RATIO * true_area:
        raise CheckFailed(
            "The boxes of cars at an angle are much larger than the cars.",
            yours=f"{area / len(pairs):.1f} square metres on average",
            expected=f"about {true_area / len(pairs):.1f} square metres",
            draw=lambda: _draw_boxes(frame, boxes, [car.corners for car, _ in pairs], "true"),
        )


def assert_upright(answer: object) -> None:
    """Assert that each box has a level, rectangular floor and a level roof directly above it."""
    for box in as_boxes(answer):
        heights = np.sort(box[:, 2])
        if max(np.ptp(heights[:4]), np.ptp(heights[4:])) > 2e-3 or footprint(box) is None:
            raise CheckFailed(
                "A box is not upright, or its floor is not a rectangle.",
                yours=brief_text(box),
                expected="four corners at one height with right angles, and four above them",
            )


_SPLIT_HINT = (
    "Draw the clusters first. An object splits into several clusters if the threshold is smaller "
    "than the gaps between its points."
)
_MERGED_HINT = (
    "Draw the clusters first. The road must be gone, and the threshold must be smaller than the "
    "gaps between objects."
)


def _assert_found(
    answers: Sequence[object], wanted: Sequence[tuple[Frame, Sequence[Box]]], noun: str
) -> None:
    missed, count = [], 0
    for answer, (frame, obstacles) in zip(answers, wanted, strict=True):
        boxes = as_boxes(answer)
        count += len(obstacles)
        missed += [
            (obstacle, boxes, frame)
            for obstacle in obstacles
            if box_of(obstacle, boxes, frame) is None
        ]
    if len(missed) <= count // 2:
        return
    obstacle, boxes, frame = missed[0]
    how, hint = _describe_miss(obstacle, boxes)
    raise CheckFailed(
        f"{len(missed)} of {count} isolated {noun} near the sensor "
        f"{'have' if len(missed) > 1 else 'has'} no separate box, for example "
        f"the one at {point_text(obstacle.centre[:2])}: {how}.",
        input_text=_visible_part(obstacle, frame),
        yours=f"{len(boxes)} boxes in that scan",
        expected="one box for each, around most of its returns and little else",
        draw=lambda: _draw_boxes(
            frame,
            boxes,
            [item[0].corners for item in missed if item[2] is frame],
            "missed",
            "Each dashed box should have one of your boxes",
        ),
        hint=hint,
    )


def _describe_miss(obstacle: Box, boxes: np.ndarray) -> tuple[str, str]:
    """Describe the boxes over an object that has no separate box; return this text and a hint."""
    over = boxes[_boxes_over(boxes, obstacle.centre)]
    pieces = len(_boxes_on(obstacle, boxes))
    if pieces > _MAX_BOXES_PER_OBJECT:
        return f"there are {pieces} boxes on it", _SPLIT_HINT
    if not len(over):
        return "no box covers it", ""  # empty: the check has its own hint
    longest = max(max(_side_lengths(box)) for box in over)
    if longest > max(obstacle.size[:2]) + 1.0:
        return (
            f"the box over it is {longest:.1f} m long, but the {_object_name(obstacle)} is only "
            f"{obstacle.size[0]:.1f} m long",
            _MERGED_HINT,
        )
    return "no box contains most of its returns", _SPLIT_HINT


def _visible_part(obstacle: Box, frame: Frame) -> str:
    returns = frame.cloud[frame.scan.objects == obstacle.identity, :3]
    cubes = len(np.unique(np.floor(returns[returns[:, 2] > -1.2] / 0.2), axis=0))
    return (
        f"a {_object_name(obstacle)} with {len(returns)} returns, which fill {cubes} cubes of "
        "0.2 m above z = -1.2 m"
    )


def _object_name(obstacle: Box) -> str:
    return _NAMES.get(obstacle.kind, obstacle.kind)


def _floor_rectangle(box: np.ndarray) -> np.ndarray:
    """Return the floor (4, 2) of an upright box, or the smallest rectangle around another box."""
    floor = footprint(box)
    if floor is not None:
        return floor
    xy = box[:, :2]
    apart = (xy[:, None] - xy).reshape(-1, 2)
    # The smallest rectangle has a side through two of the corners.
    angle = np.arctan2(apart[:, 1], apart[:, 0])
    along = np.stack([np.cos(angle), np.sin(angle)])
    across = np.stack([-along[1], along[0]])
    with np.errstate(over="ignore"):  # a wrong answer may contain any number
        best = np.argmin(np.ptp(xy @ along, axis=0) * np.ptp(xy @ across, axis=0))
    axes = np.stack([along[:, best], across[:, best]])
    (a, b), (c, d) = ((side.min(), side.max()) for side in (xy @ axes.T).T)
    return np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes


def _side_lengths(box: np.ndarray) -> np.ndarray:
    """Return length and width (m) of a box, seen from above."""
    return np.linalg.norm(np.diff(_floor_rectangle(box)[:3], axis=0), axis=1)


def _is_box_size_plausible(box: np.ndarray, obstacle: Box) -> bool:
    """Return whether a box is not much larger than a car or person."""
    long, wide = np.sort(_side_lengths(box))[::-1]
    most = max(2.5 * obstacle.size[0] * obstacle.size[1], _MAX_PERSON_AREA)
    return long <= obstacle.size[0] + 2.0 and long * wide <= most


def _is_inside(points: np.ndarray, box: np.ndarray, margin: float) -> np.ndarray:
    """Return a mask (n,) of the points (n, 3) inside a box that is enlarged by a margin (m)."""
    low, high = box.min(axis=0), box.max(axis=0)
    level = (points[:, 2] >= low[2] - margin) & (points[:, 2] <= high[2] + margin)
    if np.hypot(*(high - low)[:2]) < 1e-9:
        return level  # the box of a single return has no sides
    return level & (distance_outside(points[:, :2], _floor_rectangle(box)) <= margin)


@functools.lru_cache(maxsize=64)
def _sorted_by_x(frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Return the returns of a frame in ascending order of x, and a mask of those from obstacles."""
    order = np.argsort(frame.cloud[:, 0], kind="stable")
    return frame.cloud[order, :3], frame.scan.objects[order] > 0


def _contains_obstacle(box: np.ndarray, frame: Frame) -> bool:
    points, obstacle = _sorted_by_x(frame)
    first, last = np.searchsorted(points[:, 0], [box[:, 0].min() - 0.1, box[:, 0].max() + 0.1])
    inside_box = obstacle[first:last][_is_inside(points[first:last], box, 0.05)]
    return 2 * np.count_nonzero(inside_box) > len(inside_box)


def _boxes_on(obstacle: Box, boxes: np.ndarray) -> np.ndarray:
    """Return the indices of the boxes whose centres are in the footprint of a car or person."""
    centres = boxes.mean(axis=1)
    centres[:, 2] = obstacle.centre[2]
    return np.flatnonzero(_is_inside(centres, obstacle.corners, 0.0))


def _boxes_over(boxes: np.ndarray, centre: Sequence[float], margin: float = 0.0) -> np.ndarray:
    """Return the indices of the boxes over a place, or within a margin (m) of it in x and y."""
    low, high = boxes[:, :, :2].min(axis=1) - margin, boxes[:, :, :2].max(axis=1) + margin
    return np.flatnonzero(((low <= centre[:2]) & (high >= centre[:2])).all(axis=1))


def _draw_boxes(
    frame: Frame,
    boxes: np.ndarray,
    reference: Sequence[np.ndarray] = (),
    label: str = "",
    title: str | None = None,
) -> None:
    above = frame.cloud[frame.scan.objects > 0]
    axes = utils.plots.boxes(
        boxes, cloud=above, label="yours", limits=((-15, 25), (-11, 11)), title=title
    )
    if len(reference):
        utils.plots.boxes(np.array(reference), reference=True, label=label, axes=axes)
        for corners in reference:
            axes.plot(
                *corners[:, :2].mean(axis=0),
                "o",
                markersize=26,
                markerfacecolor="none",
                markeredgecolor="black",
                markeredgewidth=1.6,
                zorder=9,
            )
