"""Visible checks of lesson 12: `detect_obstacles` and `match_boxes`.

Detectors differ in what they look at, how they thin the cloud and where they cut. So they are
asked about what every sensible one sees: cars near by that stand free. What they say beyond
that only has to be real.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.boxes import Box, distance_outside
from utils.checks.boxes import footprint
from utils.checks.core import visible
from utils.checks.vocabulary import (
    CheckFailed,
    as_array,
    assert_left_alone,
    assert_untouched,
    brief,
    frozen,
    observe,
)

if TYPE_CHECKING:
    from utils.simulator import Sensor
    from utils.simulator.frames import Frame
    from utils.simulator.world import Obstacle

NEAR = 7.5  # m to the middle of a car: all of it is then within 10 m
MANY = 1500  # returns, of every second azimuth
FREE = 1.2  # m to the nearest other thing
HELD = 0.8  # of a car's returns, that its box must hold
PIECES = 4  # boxes that may stand on one car: its own, a mirror, what is seen through its windows
MOST_BOXES = 1000  # to look at; comparing more takes long, and none of them is right
OWN_CAR = frozen(np.array([[-1.5, -1.7], [2.6, 1.7]]))  # m from and to, x and y
# Boxes so many times as large as the cars in them are not turned. Over forty squares, turned ones
# stay below 1.25 times the area of the cars, boxes along the axes above 1.5.
UNTURNED = 1.33


def half_sensor() -> Sensor:
    """The 64-beam scanner with every second azimuth: half the returns, half the time.

    Returns
    -------
    utils.simulator.Sensor
    """
    from utils.simulator import hdl64

    sensor = hdl64()
    return dataclasses.replace(sensor, azimuth_step=2 * sensor.azimuth_step)


@functools.cache
def street(further: float = 0.0) -> Frame:
    """The street of `data/cloud.txt`, or the same from a place `further` along the road.

    Parameters
    ----------
    further : float
        In metres.

    Returns
    -------
    utils.simulator.frames.Frame
    """
    from utils.scenes import ROAD
    from utils.simulator.frames import observe
    from utils.simulator.layouts import lesson_obstacles
    from utils.simulator.pose import Pose
    from utils.simulator.streets import EGO_LANE, world_of

    world = world_of(ROAD, lesson_obstacles()).seen_from(Pose(further, EGO_LANE))
    return observe(world, half_sensor(), 12)


def street_before() -> Frame:
    """The street 4 m earlier: its clear cars stand where the other frame has none.

    Returns
    -------
    utils.simulator.frames.Frame
    """
    return street(-4.0)


@functools.lru_cache(maxsize=64)
def square(seed: int) -> Frame:
    """Three cars around the sensor, anywhere and turned in any way, between two rows of houses.

    Parameters
    ----------
    seed : int

    Returns
    -------
    utils.simulator.frames.Frame
    """
    frames = (_some_square((seed, 12, attempt)) for attempt in itertools.count())
    return next(frame for frame in frames if len(clear_cars(frame)) == 3)


def _some_square(seed: Sequence[int]) -> Frame:
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import Plan, placed, some_car, some_walker, street, world_of

    rng = np.random.default_rng(seed)
    things = []
    for _ in range(200):
        # Diagonal, so that a box along the axes is much too large; ahead or behind, not beside.
        yaw = np.radians(45 + 90 * rng.integers(4) + rng.uniform(-12, 12))
        x, y = rng.uniform((-7.2, -3.6), (7.2, 3.6))
        thing = placed(some_car(rng), x, y, yaw)
        if len(things) < 3 and _has_room(thing, things):
            things.append(thing)
    things += [placed(some_walker(rng), x, 0.0, speed=1.3) for x in (-12.0, 12.0)]
    empty = float("inf")
    houses = Plan(((-40.0, 40.0),), parked=empty, furniture=empty, driving=empty, walkers=15.0)
    ground = Ground(slope=0.02 * rng.uniform(-1, 1), width=10.0, crown=0.01, kerb=0.1)
    return observe(world_of(ground, [*things, *street(rng, houses)]), half_sensor(), seed)


def _has_room(thing: Obstacle, others: Sequence[Obstacle]) -> bool:
    """Whether a car stands near the sensor, but free of our own car and of others."""
    rim = _rim(thing)
    beside = ((rim > OWN_CAR[0] - FREE) & (rim < OWN_CAR[1] + FREE)).all(axis=1).any()
    gaps = [np.linalg.norm(rim[:, None] - _rim(other), axis=2).min() for other in others]
    distance = math.hypot(thing.pose.x, thing.pose.y)
    return not beside and 4.0 < distance < 0.98 * NEAR and min(gaps, default=9.0) > 1.2 * FREE


def _rim(thing: Obstacle) -> np.ndarray:
    """Places (m, 2) all around the footprint of an obstacle."""
    side = np.linspace(-0.5, 0.5, 20)
    half = np.full(20, 0.5)
    rim = (
        np.vstack(
            [
                np.column_stack(pair)
                for pair in ((side, half), (side, -half), (half, side), (-half, side))
            ]
        )
        * thing.size[:2]
    )
    cosine, sine = math.cos(thing.pose.yaw), math.sin(thing.pose.yaw)
    turn = np.array([[cosine, sine], [-sine, cosine]])
    return rim @ turn + [thing.pose.x, thing.pose.y]


def as_boxes(answer: object) -> np.ndarray:
    """An answer as boxes of any number.

    Parameters
    ----------
    answer : object

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
        raise CheckFailed(
            "The answer must hold N boxes of 8 corners (rows) of 3 coordinates.",
            yours=f"shape {boxes.shape}",
            expected="shape (N, 8, 3)",
        )
    if len(boxes) > MOST_BOXES:
        raise CheckFailed(
            "There are more than a thousand boxes, in a street of some dozens of things. Do "
            "obstacles fall to pieces?",
            yours=f"{len(boxes)} boxes",
            expected="about 10 to 80",
        )
    if not np.isfinite(boxes).all():
        bad = np.flatnonzero(~np.isfinite(boxes).all(axis=(1, 2)))[0]
        raise CheckFailed(
            "A box has a corner that is not finite. Did returns that are not a "
            "number stay in the cloud?",
            yours=brief(boxes[bad]),
        )
    return boxes.astype(float)


@functools.lru_cache(maxsize=64)
def clear_cars(frame: Frame) -> tuple[Box, ...]:
    """The cars of a frame that no detector may miss: near, well seen, standing free.

    Parameters
    ----------
    frame : utils.simulator.frames.Frame

    Returns
    -------
    tuple of utils.boxes.Box
    """
    from scipy.spatial import cKDTree

    xyz, objects = frame.cloud[:, :3], frame.scan.objects
    chosen = []
    for box in frame.boxes:
        if box.kind != "car" or math.hypot(*box.centre[:2]) > NEAR or box.returns < MANY:
            continue
        close = np.hypot(*(xyz[:, :2] - box.centre[:2]).T) < 6.0
        others = xyz[close & (objects > 0) & (objects != box.identity)]
        own = xyz[objects == box.identity]
        gaps = cKDTree(others).query(own, distance_upper_bound=FREE)[0] if len(others) else np.inf
        if np.isinf(gaps).all():
            chosen.append(box)
    return tuple(chosen)


def box_of(car: Box, boxes: np.ndarray, frame: Frame) -> int | None:
    """Number of the box that holds nearly all of a car and is not much larger; or None.

    None also for a car in pieces, and for one that stands in a much larger box besides.

    Parameters
    ----------
    car : utils.boxes.Box
    boxes : numpy.ndarray, shape (N, 8, 3)
    frame : utils.simulator.frames.Frame

    Returns
    -------
    int or None
    """
    returns = frame.cloud[frame.scan.objects == car.identity, :3]
    # Where the ground is cut is everyone's own choice, and wheels are nobody's.
    returns = returns[returns[:, 2] > car.centre[2] - car.size[2] / 2 + 0.55]
    if len(_standing_on(car, boxes)) > PIECES:
        return None
    holding = {
        int(number): _within(returns, boxes[number], 0.2).mean()
        for number in _covering(boxes, car.centre, 4.0)
    }
    if any(share >= 0.9 and not _fits(boxes[number], car) for number, share in holding.items()):
        return None
    return next(
        (
            number
            for number, share in holding.items()
            if share >= HELD and _fits(boxes[number], car)
        ),
        None,
    )


def assert_cars_found(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """At least half of the clear cars have a box of their own.

    A sensible detector misses one in a hundred of them, at the edge of its region.

    Parameters
    ----------
    answers : sequence of object
        For each frame what the detector said.
    frames : sequence of utils.simulator.frames.Frame
    """
    missed, count = [], 0
    for answer, frame in zip(answers, frames, strict=True):
        boxes = as_boxes(answer)
        for car in clear_cars(frame):
            count += 1
            if box_of(car, boxes, frame) is None:
                missed.append((car, boxes, frame))
    if len(missed) <= count // 2:
        return
    car, boxes, frame = missed[0]
    over = boxes[_covering(boxes, car.centre)]
    longest = max((max(_sides(box)) for box in over), default=0)
    pieces = len(_standing_on(car, boxes))
    how = (
        f"it is in {pieces} pieces"
        if pieces > PIECES
        else f"the box over it is {longest:.1f} m long, the car {car.size[0]:.1f} m"
        if longest
        else "no box is over it"
    )
    raise CheckFailed(
        f"{len(missed)} of {count} cars that stand free near the sensor have no box of their own. "
        f"One is at x = {car.centre[0]:.1f} m, y = {car.centre[1]:.1f} m: {how}.",
        yours=f"{len(boxes)} boxes in that scan",
        expected="for each such car a box around most of its returns and not much else",
        draw=lambda: _draw(
            frame,
            boxes,
            [item[0].corners for item in missed if item[2] is frame],
            "missed",
            "Each dashed car should have a box of its own",
        ),
    )


def assert_sees(answer: object, frame: Frame) -> None:
    """At least one clear car is found: who sees nothing is not praised for what they spare.

    Parameters
    ----------
    answer : object
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    if all(box_of(car, boxes, frame) is None for car in clear_cars(frame)):
        raise CheckFailed(
            "No car near by has a box of its own, so there is nothing to judge yet.",
            yours=f"{len(boxes)} boxes",
            expected="first of all, boxes around cars",
        )


def assert_boxes_real(answers: Sequence[object], frames: Sequence[Frame]) -> None:
    """At most four in ten boxes hold no obstacle, and there are not many more than obstacles.

    Parameters
    ----------
    answers : sequence of object
    frames : sequence of utils.simulator.frames.Frame
    """
    ghosts, total = [], 0
    for answer, frame in zip(answers, frames, strict=True):
        boxes = as_boxes(answer)
        most = 2 * len(frame.boxes) + 20
        if len(boxes) > most:
            raise CheckFailed(
                "There are far more boxes than things in the street. Do obstacles fall to pieces?",
                yours=f"{len(boxes)} boxes",
                expected=f"fewer than {most}",
                draw=lambda frame=frame, boxes=boxes: _draw(frame, boxes),
            )
        total += len(boxes)
        ghosts += [(box, frame, boxes) for box in boxes if not _holds_obstacle(box, frame)]
    if len(ghosts) <= 0.4 * total:
        return
    box, frame, boxes = ghosts[0]
    x, y = box[:, :2].mean(axis=0)
    held = _within(_sorted_by_x(frame)[0], box, 0.05).sum()
    raise CheckFailed(
        f"{len(ghosts)} of {total} boxes hold more road than obstacle, or nothing at all: "
        f"for example the one at x = {x:.1f} m, y = {y:.1f} m.",
        yours=f"{held} returns in it" if held else "no return in it",
        expected="cars, people, poles, walls",
        draw=lambda: _draw(
            frame, boxes, [ghost for ghost, of, _ in ghosts if of is frame], "nothing in it"
        ),
    )


def assert_own_car_free(answer: object, frame: Frame) -> None:
    """No box stands where the own car is.

    Parameters
    ----------
    answer : object
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    middles = boxes[:, :, :2].mean(axis=1)
    inside = ((middles > OWN_CAR[0]) & (middles < OWN_CAR[1])).all(axis=1)
    if inside.any():
        raise CheckFailed(
            "A box stands where the own car is. Its roof, and returns at exactly (0, 0, 0), are "
            "no obstacles.",
            yours=f"a box at x = {middles[inside][0, 0]:.1f} m, y = {middles[inside][0, 1]:.1f} m",
            expected="none between x = -1.5 and 2.6 m, y = -1.7 and 1.7 m",
            draw=lambda: _draw(frame, boxes, boxes[inside], "own car"),
        )


def without(car: Box, frame: Frame) -> Frame:
    """A frame without one of its cars: what it hid stays hidden.

    Parameters
    ----------
    car : utils.boxes.Box
    frame : utils.simulator.frames.Frame

    Returns
    -------
    utils.simulator.frames.Frame
    """
    left = frame.scan.objects != car.identity
    scan = dataclasses.replace(
        frame.scan,
        **{
            field.name: getattr(frame.scan, field.name)[left]
            for field in dataclasses.fields(frame.scan)
        },
    )
    boxes = tuple(box for box in frame.boxes if box.identity != car.identity)
    return dataclasses.replace(frame, scan=scan, boxes=boxes)


def assert_gone(answer: object, car: Box, frame: Frame) -> None:
    """No box of about its size stands where a car was.

    Parameters
    ----------
    answer : object
    car : utils.boxes.Box
        It is not in the frame any more.
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    left = [number for number in _standing_on(car, boxes) if _fits(boxes[number], car)]
    if left:
        raise CheckFailed(
            "A box stands where no car is: in this scan its place is empty.",
            yours=f"a box at x = {car.centre[0]:.1f} m, y = {car.centre[1]:.1f} m",
            expected="boxes around what the scan holds",
            draw=lambda: _draw(frame, boxes, boxes[left], "nothing in it"),
        )


def assert_boxes_turned(answer: object, frame: Frame) -> None:
    """The boxes of turned cars are hardly larger than the cars.

    Parameters
    ----------
    answer : object
    frame : utils.simulator.frames.Frame
    """
    boxes = as_boxes(answer)
    pairs = [(car, box_of(car, boxes, frame)) for car in clear_cars(frame)]
    pairs = [(car, boxes[number]) for car, number in pairs if number is not None]
    area = sum(np.prod(_sides(box)) for _, box in pairs)
    true_area = sum(car.size[0] * car.size[1] for car, _ in pairs)
    if area > UNTURNED * true_area:
        raise CheckFailed(
            "The boxes of cars that stand at an angle are much larger than the cars. Boxes must "
            "be turned with them.",
            yours=f"{area / len(pairs):.1f} square metres on average",
            expected=f"about {true_area / len(pairs):.1f} square metres",
            draw=lambda: _draw(frame, boxes, [car.corners for car, _ in pairs], "true"),
        )


@visible(
    "detect_obstacles",
    weight=2,
    title="Returns upright boxes: a level floor, right angles, a corner above each corner",
    why="Whoever plans a path asks of each corner how high it stands and what lies between.",
    hint="Let the last step be your get_oriented_boxes of lesson 11: it returns (N, 8, 3).",
)
def returns_boxes(detect_obstacles: Callable) -> None:
    boxes = as_boxes(detect_obstacles(street_before().cloud.copy()))
    if len(boxes) < 3:
        raise CheckFailed(
            "There are hardly any boxes, in a street full of cars.",
            yours=f"{len(boxes)} boxes",
            expected="about 10 to 80, by how far you look",
        )
    assert_sees(boxes, street_before())
    for box in boxes:
        heights = np.sort(box[:, 2])
        if max(np.ptp(heights[:4]), np.ptp(heights[4:])) > 2e-3 or footprint(box) is None:
            raise CheckFailed(
                "Not all boxes stand upright on a rectangle.",
                yours=brief(box),
                expected="four corners at one height and right angles, four above",
            )


@visible(
    "detect_obstacles",
    weight=5,
    title="Each car that stands free near the sensor has a box of its own",
    why="This is what the other eleven lessons were for.",
    hint="Draw the clusters before the boxes. Is the road gone? Are neighbours one cluster "
    "(threshold too large), is a car in pieces (too small), or too few points for "
    "min_num_points?",
)
def finds_cars(detect_obstacles: Callable) -> None:
    frames = [street(), street_before()]
    assert_cars_found([detect_obstacles(frame.cloud.copy()) for frame in frames], frames)


@visible(
    "detect_obstacles",
    weight=3,
    title="Boxes are around obstacles, not around road or nothing",
    why="A car that brakes for its own road will not be driven for long.",
    hint="Look at the ghosts from the side: road that rises above the ground level? Pieces "
    "of a few points, which filter_clusters should have removed?",
)
def leaves_the_road(detect_obstacles: Callable) -> None:
    answer = detect_obstacles(street_before().cloud.copy())
    assert_boxes_real([answer], [street_before()])
    assert_sees(answer, street_before())


@visible(
    "detect_obstacles",
    weight=2,
    title="Does not take its own car for an obstacle",
    why="An obstacle at 0 m means full braking, for ever.",
    hint="remove_ego_returns takes out the roof, drop_invalid the returns at (0, 0, 0): both "
    "before anything is averaged or clustered.",
)
def forgets_itself(detect_obstacles: Callable) -> None:
    answer = detect_obstacles(street_before().cloud.copy())
    assert_own_car_free(answer, street_before())
    assert_sees(answer, street_before())


@visible(
    "detect_obstacles",
    weight=3,
    title="Boxes turn with the cars",
    why="A car that pulls out of a parking space stands at an angle; a box along the axes "
    "would close the lane beside it.",
    hint="Fit the box along the main directions of the cluster, seen from above (lesson 11).",
)
def turns_boxes(detect_obstacles: Callable) -> None:
    answer = detect_obstacles(square(5).cloud.copy())
    assert_cars_found([answer], [square(5)])
    assert_boxes_turned(answer, square(5))


@visible(
    "detect_obstacles",
    weight=3,
    title="Takes an empty scan, three columns and returns that are not a number, and leaves "
    "its input untouched",
    why="A stream has no pause button: a bad frame must not stop it.",
    hint="Return np.empty((0, 8, 3)) as soon as nothing is left, after every filter that can "
    "leave nothing. Use cloud[:, :3].",
)
def takes_what_comes(detect_obstacles: Callable) -> None:
    for columns in (3, 4):
        boxes = as_boxes(detect_obstacles(np.empty((0, columns))))
        if len(boxes):
            raise CheckFailed("An empty scan has no obstacles.", yours=f"{len(boxes)} boxes")
    cloud = street_before().cloud[:, :3].copy()
    cloud[::50] = np.nan
    seen = observe(detect_obstacles, cloud)
    assert_left_alone(seen, cloud)
    assert_cars_found([seen.result], [street_before()])


def cubes(centres: ArrayLike, size: float = 1.0, turn: int = 0) -> np.ndarray:
    """Boxes around some places; `turn` starts the corners elsewhere, in the same cyclic order.

    Parameters
    ----------
    centres : array_like, shape (N, 2) or (N, 3)
    size : float
    turn : int

    Returns
    -------
    numpy.ndarray, shape (N, 8, 3)
    """
    centres = np.atleast_2d(np.asarray(centres, dtype=float)).reshape(len(centres), -1)
    if centres.shape[1] < 3:
        centres = np.column_stack([centres, np.zeros((len(centres), 3 - centres.shape[1]))])
    floor = np.roll([[1, 1, -1], [-1, 1, -1], [-1, -1, -1], [1, -1, -1]], turn, axis=0)
    return centres[:, None] + size / 2 * np.vstack([floor, floor + [0, 0, 2]])


def assert_matched(
    answer: object, expected: ArrayLike, previous: np.ndarray, current: np.ndarray
) -> None:
    """The answer names for each current box the right previous one.

    Parameters
    ----------
    answer : object
    expected : array_like of int, shape (N_current,)
    previous, current : numpy.ndarray, shape (N, 8, 3)
    """
    expected = np.asarray(expected, dtype=int).ravel()
    yours = as_array(answer, what="an array of indices")
    if yours.size == 0 and not len(expected):
        return
    if yours.shape != expected.shape:
        raise CheckFailed(
            "There must be one index for each current box.",
            yours=f"shape {yours.shape}",
            expected=f"shape {expected.shape}",
        )
    draw = functools.partial(_draw_matches, previous, current, yours, expected)
    if (
        not np.array_equal(yours, np.round(yours))
        or yours.min() < -1
        or yours.max() >= len(previous)
    ):
        raise CheckFailed(
            "Each entry is the index of a previous box, or -1.",
            yours=brief(yours),
            expected=brief(expected),
        )
    if np.array_equal(yours, expected):
        return
    taken, times = np.unique(yours[yours >= 0], return_counts=True)
    if (times > 1).any():
        message = f"Previous box {taken[times > 1][0]:.0f} is given to several current boxes."
    else:
        first = np.flatnonzero(yours != expected)[0]
        right = (
            "is new and has no partner"
            if expected[first] < 0
            else f"was previous box {expected[first]}"
        )
        message = f"Current box {first} {right}."
    raise CheckFailed(message, yours=brief(yours), expected=brief(expected), draw=draw)


@visible(
    "match_boxes",
    weight=4,
    title="Finds each box again after a small move, in whatever order the boxes come",
    why="Clusters are numbered anew in every frame; without names nobody knows who moved where.",
    hint="The centre of a box is the mean of its corners. Make a table of all distances "
    "between current and previous centres; the smallest entry is a pair.",
)
def finds_again(match_boxes: Callable) -> None:
    previous = cubes([[4, 1], [9, -3], [15, 2], [-6, -4]])
    order = [2, 0, 3, 1]
    current = previous[order] + [-0.5, 0.1, 0.0]
    assert_matched(match_boxes(previous.copy(), current.copy(), 1.5), order, previous, current)
    assert_matched(
        match_boxes(previous=previous.copy(), current=current.copy(), max_distance=1.5),
        order,
        previous,
        current,
    )


@visible(
    "match_boxes",
    weight=3,
    title="A box with no partner within max_distance is new: -1",
    why="Somebody steps out from behind a lorry. They must not inherit the name of the lorry.",
    hint="Compare the distance with max_distance before you accept a pair, and start from "
    "an array full of -1.",
)
def knows_new_ones(match_boxes: Callable) -> None:
    previous, current = cubes([[4, 1], [9, -3]]), cubes([[12, 5], [9.4, -3], [4, 3.5]])
    assert_matched(
        match_boxes(previous.copy(), current.copy(), 1.0), [-1, 1, -1], previous, current
    )
    assert_matched(match_boxes(previous.copy(), current.copy(), 3.0), [-1, 1, 0], previous, current)


@visible(
    "match_boxes",
    weight=4,
    title="One to one: two boxes never get the same partner, and the nearer one gets it",
    why="Two cars under one name are one car to the planner.",
    hint="Take the closest of all pairs first, then strike out its row and its column. "
    "Going through the current boxes in their order gives the partner to whoever comes "
    "first.",
)
def is_one_to_one(match_boxes: Callable) -> None:
    previous, current = cubes([[5, 0], [20, 0]]), cubes([[6.2, 0], [5.2, 0], [20.3, 0]])
    assert_matched(match_boxes(previous.copy(), current.copy(), 2.0), [-1, 0, 1], previous, current)
    current = current[::-1]
    assert_matched(match_boxes(previous.copy(), current.copy(), 2.0), [1, 0, -1], previous, current)


@visible(
    "match_boxes",
    weight=2,
    title="Takes no boxes on either side, and leaves its input untouched",
    why="The first frame has no frame before it, and an empty road has no boxes.",
    hint="argmin of an empty table is an error: return early, an array of -1 as long as current.",
)
def takes_no_boxes(match_boxes: Callable) -> None:
    some, none = cubes([[4, 1], [9, -3]]), np.empty((0, 8, 3))
    for previous, current, expected in (
        (none, some, [-1, -1]),
        (some, none, []),
        (none, none, []),
        (some, some, [0, 1]),
    ):
        answer = match_boxes(previous.copy(), current.copy(), 2.0)
        assert_matched(answer, expected, previous, current)
        assert_untouched(match_boxes, previous, current, 2.0)


def _sides(box: np.ndarray) -> np.ndarray:
    """Length and width (m) of the rectangle that a box stands on."""
    rectangle = footprint(box)
    if rectangle is None:
        return np.ptp(box[:, :2], axis=0)
    return np.linalg.norm(np.diff(rectangle[:3], axis=0), axis=1)


def _fits(box: np.ndarray, car: Box) -> bool:
    """Whether a box is not much larger than a car."""
    long, wide = np.sort(_sides(box))[::-1]
    return long <= car.size[0] + 2.0 and long * wide <= 2.5 * car.size[0] * car.size[1]


def _within(points: np.ndarray, box: np.ndarray, margin: float) -> np.ndarray:
    """Which points (n, 3) lie in a box, enlarged by a margin (m): (n,) of bool."""
    low, high = box.min(axis=0), box.max(axis=0)
    level = (points[:, 2] >= low[2] - margin) & (points[:, 2] <= high[2] + margin)
    if np.hypot(*(high - low)[:2]) < 1e-9:
        return level  # a box of one return has no sides to be within
    rectangle = footprint(box)
    if rectangle is None:
        rectangle = np.array([low[:2], [high[0], low[1]], high[:2], [low[0], high[1]]])
    return level & (distance_outside(points[:, :2], rectangle) <= margin)


@functools.lru_cache(maxsize=64)
def _sorted_by_x(frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Returns of a frame by ascending x, and whether each hit an obstacle."""
    order = np.argsort(frame.cloud[:, 0], kind="stable")
    return frame.cloud[order, :3], frame.scan.objects[order] > 0


def _holds_obstacle(box: np.ndarray, frame: Frame) -> bool:
    points, obstacle = _sorted_by_x(frame)
    first, last = np.searchsorted(points[:, 0], [box[:, 0].min() - 0.1, box[:, 0].max() + 0.1])
    held = obstacle[first:last][_within(points[first:last], box, 0.05)]
    return 2 * np.count_nonzero(held) > len(held)


def _standing_on(car: Box, boxes: np.ndarray) -> np.ndarray:
    """Numbers of the boxes whose middles lie in the footprint of a car."""
    middles = boxes.mean(axis=1)
    middles[:, 2] = car.centre[2]
    return np.flatnonzero(_within(middles, car.corners, 0.0))


def _covering(boxes: np.ndarray, centre: Sequence[float], margin: float = 0.0) -> np.ndarray:
    """Numbers of the boxes over a place, or within a margin (m) of it along x and y."""
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


def _draw_matches(
    previous: np.ndarray, current: np.ndarray, yours: np.ndarray, expected: np.ndarray
) -> None:
    axes = utils.plots.boxes(previous, reference=True, names=True, label="previous")
    if len(current):
        middle = np.vstack([previous, current])[:, :, :2].reshape(-1, 2)
        axes.set_xlim(middle[:, 0].min() - 2, middle[:, 0].max() + 2)
        axes.set_ylim(middle[:, 1].min() - 2, middle[:, 1].max() + 2)
        utils.plots.boxes(
            current,
            names=True,
            label="current",
            axes=axes,
            title="Solid lines: your pairs; dotted: the right ones",
        )
    for pairs, line, wide in ((expected, ":", 4.0), (yours.astype(int), "-", 1.5)):
        for number, partner in enumerate(pairs):
            if 0 <= partner < len(previous):
                ends = np.stack([previous[partner], current[number]])[:, :, :2].mean(axis=1)
                axes.plot(*ends.T, line, color="black", linewidth=wide)
