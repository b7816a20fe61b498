"""Assertions about the boxes that a detector returns for a scan."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

import utils
from utils.boxes import Box, distance_outside
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief, needs, point_text
from utils.checks.boxes import footprint
from utils.checks.failures import fixed
from utils.checks.run_cache import answer_to, once
from utils.checks.scans import EGO_CAR, clear_cars, clear_people

if TYPE_CHECKING:
    from utils.simulator.frames import Frame

HELD = 0.8  # share of an obstacle's returns that its box must contain
PIECES = 4  # most boxes on one car: its own, a mirror, and clusters seen through its windows
MOST_BOXES = 1000  # more are refused: comparing them is slow, and no right answer has as many
# Boxes this many times as large as their cars are not turned. Over forty squares, turned boxes
# have less than 1.25 times the area of the cars, and boxes along the axes more than 1.5 times.
UNTURNED = 1.33
LARGEST_OF_A_PERSON = 3.0  # square metres
SEEN = "in the scan of this row, cars that stand free near the sensor have boxes of their own"


def detected(detect_obstacles: Callable, frame: Frame) -> object:
    """Return the detector's answer for an unchanged frame, cached for the run."""
    return answer_to(detect_obstacles, frame, frame.cloud)


def as_boxes(answer: object) -> np.ndarray:
    """Convert an answer to boxes, of any number.

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    if isinstance(answer, (list, tuple)) and not answer:
        return np.empty((0, 8, 3))
    boxes = as_array(answer, what="an array of boxes")
    if boxes.size == 0 and boxes.shape[:1] == (0,):
        return np.empty((0, 8, 3))
    if boxes.ndim != 3 or boxes.shape[1:] != (8, 3):
        raise WrongForm(
            fixed("The answer must hold N boxes of 8 corners (rows) of 3 coordinates."),
            yours=f"shape {boxes.shape}",
            expected="shape (N, 8, 3)",
        )
    if len(boxes) > MOST_BOXES:
        raise WrongForm(
            "There are more than a thousand boxes, in a street of some dozens of things.",
            yours=f"{len(boxes)} boxes",
            expected="about 10 to 80",
            hint=IN_PIECES,
        )
    if not np.isfinite(boxes).all():
        bad = np.flatnonzero(~np.isfinite(boxes).all(axis=(1, 2)))[0]
        raise WrongForm(
            "A box has a corner that is not finite.",
            yours=brief(boxes[bad]),
            hint="Returns that are not a number must be gone before boxes are fitted; and a "
            "cluster of one point has no direction to divide by.",
        )
    return boxes.astype(float)


_FEW_GHOSTS = 2


def box_of(thing: Box, boxes: np.ndarray, frame: Frame) -> int | None:
    """Return the index of the box that contains most of a car or person and little else, or None.

    None also if more than `PIECES` boxes are on it, or if a much larger box contains it as well.

    Parameters
    ----------
    thing : utils.boxes.Box
    boxes : numpy.ndarray, shape (N, 8, 3)
    frame : utils.simulator.frames.Frame
    """
    returns = frame.cloud[frame.scan.objects == thing.identity, :3]
    # Detectors cut the ground at different heights, and may lose the wheels with it.
    returns = returns[returns[:, 2] > thing.centre[2] - thing.size[2] / 2 + 0.55]
    if len(_standing_on(thing, boxes)) > PIECES:
        return None
    holding = {
        int(number): _within(returns, boxes[number], 0.2).mean()
        for number in _covering(boxes, thing.centre, 4.0)
    }
    fitting = {
        number: _fits(boxes[number], thing) for number, share in holding.items() if share >= HELD
    }
    if any(holding[number] >= 0.9 and not fits for number, fits in fitting.items()):
        return None
    return next((number for number, fits in fitting.items() if fits), None)


def assert_cars_found(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """Assert that at least half of the clear cars have a box of their own.

    A sensible detector misses one in a hundred of them, at the edge of its region.

    Parameters
    ----------
    answers : sequence of object
        The detector's answer for each frame.
    frames : sequence of utils.simulator.frames.Frame
    """
    _assert_found(answers, [(frame, clear_cars(frame)) for frame in frames], "cars")


_NAMES = {"pedestrian": "person", "truck": "lorry"}


def assert_reached(answer: object, thing: Box, frame: Frame) -> None:
    """Assert that some box contains a thing, whatever else it or other boxes contain."""
    boxes, name = as_boxes(answer), _NAMES.get(thing.kind, thing.kind)
    returns = frame.cloud[frame.scan.objects == thing.identity, :3]
    returns = returns[returns[:, 2] > thing.centre[2] - thing.size[2] / 2 + 0.55]
    if not any(
        _within(returns, boxes[number], 0.2).mean() >= HELD
        for number in _covering(boxes, thing.centre, 4.0)
    ):
        raise CheckFailed(
            f"No box holds the {name} at {point_text(thing.centre[:2])}.",
            given=_visible_part(thing, frame),
            yours=f"{len(boxes)} boxes in that scan",
            expected=f"one around that {name}",
            draw=lambda: _draw(frame, boxes, [thing.corners], "missed"),
        )


def assert_kind_reached(answer: object, kind: str, frame: Frame) -> None:
    """Assert that some box contains each thing of a kind in the frame."""
    for thing in frame.boxes:
        if thing.kind == kind:
            assert_reached(answer, thing, frame)


def assert_apart(answer: object, frame: Frame, gap: float) -> None:
    """Assert that no box contains both cars of a frame, which are parked `gap` metres apart."""
    boxes = as_boxes(answer)
    cars = [box for box in frame.boxes if box.kind == "car"]
    for box in boxes:
        shares = [
            _within(frame.cloud[frame.scan.objects == car.identity, :3], box, 0.2).mean()
            for car in cars
        ]
        if min(shares) > 0.5:
            raise CheckFailed(
                f"Two cars, parked {gap} m apart, have one box.",
                yours="one box around both",
                expected="a box for each",
                draw=lambda box=box: _draw(frame, boxes, [box], "two cars"),
                hint="Two things are one cluster where the threshold is larger than the gap "
                "between them: is threshold handed on?",
            )


def assert_road_free(answer: object, frame: Frame) -> None:
    """Assert that hardly a box is around road or nothing."""
    boxes = as_boxes(answer)
    ghosts = [box for box in boxes if not _holds_obstacle(box, frame)]
    if len(ghosts) > _FEW_GHOSTS:
        raise CheckFailed(
            f"{len(ghosts)} boxes hold road, or nothing at all, for example at "
            f"{point_text(ghosts[0][:, :2].mean(axis=0))}.",
            given="a road that climbs",
            yours=f"{len(boxes)} boxes in that scan",
            expected="boxes around cars, a lorry and a person",
            draw=lambda: _draw(frame, boxes, ghosts, "road"),
        )


def assert_people_found(answer: object, frame: Frame) -> None:
    """Assert that at least half of the clear people have a box of their own."""
    _assert_found([answer], [(frame, clear_people(frame))], "people")


def assert_sees(answer: object, frame: Frame) -> None:
    """Require that the clear cars are found, as a detector without boxes would pass other checks.

    Raises
    ------
    utils.checks.failures.NotYet
        If they are not found.
    """
    with needs(SEEN):
        assert_cars_found([answer], [frame])


@once
def assert_cars_seen(detect_obstacles: Callable, frame: Frame) -> None:
    """Apply `assert_sees` to the detector's answer for an unchanged frame."""
    assert_sees(detected(detect_obstacles, frame), frame)


def assert_boxes_real(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """Assert that there are not too many boxes, and that at most 40 % are mostly road or empty.

    A frame may have up to 20 boxes more than twice its number of true boxes.
    """
    ghosts, total = [], 0
    for answer, frame in zip(answers, frames, strict=True):
        boxes = as_boxes(answer)
        most = 2 * len(frame.boxes) + 20
        if len(boxes) > most:
            raise CheckFailed(
                "There are far more boxes than things in the street.",
                yours=f"{len(boxes)} boxes",
                expected=f"fewer than {most}",
                draw=lambda frame=frame, boxes=boxes: _draw(frame, boxes),
                hint=IN_PIECES,
            )
        total += len(boxes)
        ghosts += [(box, frame, boxes) for box in boxes if not _holds_obstacle(box, frame)]
    if len(ghosts) <= 0.4 * total:
        return
    box, frame, boxes = ghosts[0]
    held = np.count_nonzero(_within(_sorted_by_x(frame)[0], box, 0.05))
    raise CheckFailed(
        f"Boxes hold more road than obstacle, or nothing at all: {len(ghosts)} of {total}, "
        f"for example {point_text(box[:, :2].mean(axis=0))}.",
        yours=f"{held or 'no'} return{'s' if held != 1 else ''} in that box",
        expected="boxes around cars, people, poles, walls",
        draw=lambda: _draw(
            frame, boxes, [ghost for ghost, home, _ in ghosts if home is frame], "nothing in it"
        ),
    )


def assert_own_car_free(answer: object, frame: Frame) -> None:
    """Assert that no box is centred on the ego car."""
    boxes = as_boxes(answer)
    middles = boxes[:, :, :2].mean(axis=1)
    inside = ((middles > EGO_CAR[0]) & (middles < EGO_CAR[1])).all(axis=1)
    if inside.any():
        raise CheckFailed(
            "A box stands where the own car is.",
            yours=f"a box with its middle at {point_text(middles[inside][0])}",
            expected="none between x = -1.5 and 2.6 m, y = -1.7 and 1.7 m",
            draw=lambda: _draw(frame, boxes, boxes[inside], "own car"),
        )


def assert_nothing_at_sensor(answer: object, frame: Frame) -> None:
    """Assert that no box contains the sensor's position, where lost returns are recorded."""
    boxes = as_boxes(answer)
    sensor = np.zeros((1, 3))
    near = _covering(boxes, sensor[0], 0.1)
    at = [number for number in near if _within(sensor, boxes[number], 0.1).any()]
    if at:
        raise CheckFailed(
            fixed(
                "A box stands around (0, 0, 0): that is where the sensor is, and where it puts "
                "returns that were lost."
            ),
            yours=f"a box from {point_text(boxes[at[0]].min(axis=0))} to "
            f"{point_text(boxes[at[0]].max(axis=0))}",
            expected="no box there",
            draw=lambda: _draw(frame, boxes, boxes[at], "lost returns"),
        )


def assert_dry(answer: object, frame: Frame, drops: np.ndarray) -> None:
    """Assert that at most a third of the raindrops have a box.

    Parameters
    ----------
    answer : object
    frame : utils.simulator.frames.Frame
    drops : numpy.ndarray, shape (n, 4)
        Single returns in the air, which were added to the detector's input.
    """
    boxes = as_boxes(answer)
    small = boxes[np.ptp(boxes, axis=1).max(axis=1) < 1.0]
    away = np.linalg.norm(small.mean(axis=1)[:, None] - drops[:, :3], axis=2)
    wet = np.count_nonzero((away < 0.5).any(axis=0))
    if wet > len(drops) // 3:
        raise CheckFailed(
            "Single returns in the air have boxes.",
            yours=f"boxes around {wet} of {len(drops)} drops of rain",
            expected="none around clusters of one point",
            draw=lambda: _draw(frame, boxes, small[(away < 0.5).any(axis=1)], "a drop"),
        )


def assert_gone(answer: object, car: Box, frame: Frame) -> None:
    """Assert that no box of a similar size is where a car used to be.

    Parameters
    ----------
    answer : object
    car : utils.boxes.Box
        A car that was removed from the frame.
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    left = [number for number in _standing_on(car, boxes) if _fits(boxes[number], car)]
    if left:
        raise CheckFailed(
            "A box stands where no car is: in this scan its place is empty.",
            yours=f"a box at {point_text(car.centre[:2])}",
            expected="boxes around what the scan holds",
            draw=lambda: _draw(frame, boxes, boxes[left], "nothing in it"),
        )


def assert_boxes_turned(answer: object, frame: Frame) -> None:
    """Assert that the boxes of cars at an angle are not much larger than the cars."""
    boxes = as_boxes(answer)
    pairs = [(car, box_of(car, boxes, frame)) for car in clear_cars(frame)]
    pairs = [(car, boxes[number]) for car, number in pairs if number is not None]
    area = sum(np.prod(_sides(box)) for _, box in pairs)
    true_area = sum(car.size[0] * car.size[1] for car, _ in pairs)
    if area > UNTURNED * true_area:
        raise CheckFailed(
            "The boxes of cars that stand at an angle are much larger than the cars.",
            yours=f"{area / len(pairs):.1f} square metres on average",
            expected=f"about {true_area / len(pairs):.1f} square metres",
            draw=lambda: _draw(frame, boxes, [car.corners for car, _ in pairs], "true"),
        )


def assert_upright(answer: object) -> None:
    """Assert that each box has a level floor, right angles, and a corner above each corner."""
    for box in as_boxes(answer):
        heights = np.sort(box[:, 2])
        if max(np.ptp(heights[:4]), np.ptp(heights[4:])) > 2e-3 or footprint(box) is None:
            raise CheckFailed(
                "Not all boxes stand upright on a rectangle.",
                yours=brief(box),
                expected="four corners at one height and right angles, four above",
            )


IN_PIECES = (
    "Draw the clusters before the boxes. A thing falls to pieces where the threshold is smaller "
    "than the gaps between its points."
)
_TOO_LARGE = (
    "Draw the clusters before the boxes. Is the road gone? Is the threshold smaller than the gaps "
    "between things?"
)


def _assert_found(
    answers: Sequence[object], wanted: Sequence[tuple[Frame, Sequence[Box]]], noun: str
) -> None:
    missed, count = [], 0
    for answer, (frame, things) in zip(answers, wanted, strict=True):
        boxes = as_boxes(answer)
        count += len(things)
        missed += [(thing, boxes, frame) for thing in things if box_of(thing, boxes, frame) is None]
    if len(missed) <= count // 2:
        return
    thing, boxes, frame = missed[0]
    how, hint = _how_missed(thing, boxes)
    raise CheckFailed(
        f"Of {count} {noun} standing free near the sensor, {len(missed)} "
        f"{'have' if len(missed) > 1 else 'has'} no box of their own"
        f", for example {point_text(thing.centre[:2])}: {how}.",
        given=_visible_part(thing, frame),
        yours=f"{len(boxes)} boxes in that scan",
        expected="for each a box around most of its returns and not much else",
        draw=lambda: _draw(
            frame,
            boxes,
            [item[0].corners for item in missed if item[2] is frame],
            "missed",
            "Each dashed box should have one of yours",
        ),
        hint=hint,
    )


def _how_missed(thing: Box, boxes: np.ndarray) -> tuple[str, str]:
    """Describe the boxes over an obstacle that has none of its own, with a hint."""
    over = boxes[_covering(boxes, thing.centre)]
    pieces = len(_standing_on(thing, boxes))
    if pieces > PIECES:
        return f"there are {pieces} boxes on it", IN_PIECES
    if not len(over):
        return "no box is over it", ""  # empty: the check has a hint of its own
    longest = max(max(_sides(box)) for box in over)
    if longest > max(thing.size[:2]) + 1.0:
        return (
            f"the box over it is {longest:.1f} m long, the {_name(thing)} {thing.size[0]:.1f} m",
            _TOO_LARGE,
        )
    return "no box over it holds most of its returns", IN_PIECES


def _visible_part(thing: Box, frame: Frame) -> str:
    returns = frame.cloud[frame.scan.objects == thing.identity, :3]
    cubes = len(np.unique(np.floor(returns[returns[:, 2] > -1.2] / 0.2), axis=0))
    return (
        f"a {_name(thing)} of {len(returns)} returns, which fill {cubes} cubes of 0.2 m above "
        "z = -1.2 m"
    )


def _name(thing: Box) -> str:
    return {"pedestrian": "person"}.get(thing.kind, thing.kind)


def _rectangle(box: np.ndarray) -> np.ndarray:
    """Return the floor rectangle (4, 2) of a box; the smallest around it if it is not upright."""
    standing = footprint(box)
    if standing is not None:
        return standing
    xy = box[:, :2]
    apart = (xy[:, None] - xy).reshape(-1, 2)
    angle = np.arctan2(apart[:, 1], apart[:, 0])  # the best rectangle has a side along two corners
    along = np.stack([np.cos(angle), np.sin(angle)])
    across = np.stack([-along[1], along[0]])
    best = np.argmin(np.ptp(xy @ along, axis=0) * np.ptp(xy @ across, axis=0))
    axes = np.stack([along[:, best], across[:, best]])
    (a, b), (c, d) = ((side.min(), side.max()) for side in (xy @ axes.T).T)
    return np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes


def _sides(box: np.ndarray) -> np.ndarray:
    """Return length and width (m) of a box, seen from above."""
    return np.linalg.norm(np.diff(_rectangle(box)[:3], axis=0), axis=1)


def _fits(box: np.ndarray, thing: Box) -> bool:
    """Return whether a box is not much larger than a car or person."""
    long, wide = np.sort(_sides(box))[::-1]
    most = max(2.5 * thing.size[0] * thing.size[1], LARGEST_OF_A_PERSON)
    return long <= thing.size[0] + 2.0 and long * wide <= most


def _within(points: np.ndarray, box: np.ndarray, margin: float) -> np.ndarray:
    """Return a mask (n,) of the points (n, 3) inside a box that is enlarged by a margin (m)."""
    low, high = box.min(axis=0), box.max(axis=0)
    level = (points[:, 2] >= low[2] - margin) & (points[:, 2] <= high[2] + margin)
    if np.hypot(*(high - low)[:2]) < 1e-9:
        return level  # the box of a single return has no sides
    return level & (distance_outside(points[:, :2], _rectangle(box)) <= margin)


@functools.lru_cache(maxsize=64)
def _sorted_by_x(frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Return the returns of a frame by ascending x, and whether each is from an obstacle."""
    order = np.argsort(frame.cloud[:, 0], kind="stable")
    return frame.cloud[order, :3], frame.scan.objects[order] > 0


def _holds_obstacle(box: np.ndarray, frame: Frame) -> bool:
    points, obstacle = _sorted_by_x(frame)
    first, last = np.searchsorted(points[:, 0], [box[:, 0].min() - 0.1, box[:, 0].max() + 0.1])
    held = obstacle[first:last][_within(points[first:last], box, 0.05)]
    return 2 * np.count_nonzero(held) > len(held)


def _standing_on(thing: Box, boxes: np.ndarray) -> np.ndarray:
    """Return the indices of the boxes whose centres are in the footprint of a car or person."""
    middles = boxes.mean(axis=1)
    middles[:, 2] = thing.centre[2]
    return np.flatnonzero(_within(middles, thing.corners, 0.0))


def _covering(boxes: np.ndarray, centre: Sequence[float], margin: float = 0.0) -> np.ndarray:
    """Return the indices of the boxes over a place, or within a margin (m) of it in x and y."""
    low, high = boxes[:, :, :2].min(axis=1) - margin, boxes[:, :, :2].max(axis=1) + margin
    return np.flatnonzero(((low <= centre[:2]) & (high >= centre[:2])).all(axis=1))


def _draw(
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
