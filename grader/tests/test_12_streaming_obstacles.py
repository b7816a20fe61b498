"""Hidden tests of lesson 12. Titles and hints are shown to students; the code is not."""

import functools
import itertools

import numpy as np

from grader.judging.marks import hidden, visible_checks
from utils.checks.lesson_12 import (
    as_boxes,
    assert_boxes_real,
    assert_boxes_turned,
    assert_cars_found,
    assert_gone,
    assert_matched,
    assert_own_car_free,
    assert_sees,
    clear_cars,
    cubes,
    half_sensor,
    square,
    without,
)
from utils.checks.vocabulary import CheckFailed


@visible_checks("detect_obstacles", "match_boxes")
def test_visible(student, check):
    check.run(getattr(student, check.exercise))


@functools.lru_cache(maxsize=32)
def fresh_streets(seed):
    """Two streets that nobody has seen, with at least two clear cars each."""
    from utils.scenes import random_street

    frames = (random_street(seed + number, 0.4, half_sensor()) for number in itertools.count())
    return list(itertools.islice((frame for frame in frames if len(clear_cars(frame)) >= 2), 2))


@functools.lru_cache(maxsize=32)
def city_frames(seed):
    """Two frames of a drive through a city that nobody has seen, with a clear car or more."""
    from utils.scenes import city_block

    frames = (city_block(seed, 200)[number] for number in range(0, 200, 8))
    good = itertools.islice((frame for frame in frames if clear_cars(frame)), 2)
    return [*good, square(seed + 1), square(seed + 2)][:2]


@functools.lru_cache(maxsize=32)
def rain(seed):
    """Single returns (n, 4) in the air over a square, away from its things and each other."""
    from scipy.spatial import cKDTree

    rng = np.random.default_rng(seed)
    frame = square(seed)
    places = rng.uniform((-11, -5.5), (18, 5.5), (400, 2))
    things = cKDTree(frame.cloud[frame.scan.objects > 0, :2])
    places = places[(things.query(places)[0] > 1.5) & (np.hypot(*places.T) > 3.5)]
    drops = []
    for place in places:
        if all(np.hypot(*(place - other)) > 2.0 for other in drops):
            drops.append(place)
    return np.column_stack([drops, rng.uniform((-0.9, 0.0), (0.3, 0.1), (len(drops), 2))])


@functools.cache
def empty_road():
    """A scan of a level road and nothing else."""
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import world_of

    return observe(world_of(Ground(), ()), half_sensor(), 3)


def assert_detects(student, cloud, frame):
    """The detector finds the cars of a frame in a changed copy of its cloud."""
    answer = student.detect_obstacles(cloud)
    assert_cars_found([answer], [frame])
    return answer


@hidden(
    "detect_obstacles",
    weight=6,
    title="Finds the cars of streets you have not seen",
    hint="Try other scenes: scenes.random_street(1), (2), (3) with their true boxes.",
)
def test_fresh_streets(student, seed):
    frames = fresh_streets(seed)
    assert_cars_found([student.detect_obstacles(frame.cloud.copy()) for frame in frames], frames)


@hidden(
    "detect_obstacles",
    weight=4,
    title="Sees few ghosts in streets you have not seen",
    hint="Draw the boxes of scenes.random_street(1): which hold road, which hold nothing?",
)
def test_few_ghosts(student, seed):
    frames = fresh_streets(seed)
    answers = [student.detect_obstacles(frame.cloud.copy()) for frame in frames]
    assert_boxes_real(answers, frames)
    for answer, frame in zip(answers, frames, strict=True):
        assert_sees(answer, frame)


@hidden(
    "detect_obstacles",
    weight=4,
    title="Finds the cars of a drive through the city",
    hint="The road of the city climbs: what does your ground filter leave 20 m ahead?",
)
def test_city(student, seed):
    frames = city_frames(seed)
    answers = [student.detect_obstacles(frame.cloud.copy()) for frame in frames]
    assert_cars_found(answers, frames)
    assert_boxes_real(answers, frames)


@hidden(
    "detect_obstacles",
    weight=4,
    title="Turns the boxes of cars that stand at an angle",
    hint="Seen from above, the sides of a box should run along the sides of the car.",
)
def test_turned_cars(student, seed):
    frame = square(seed)
    answer = assert_detects(student, frame.cloud.copy(), frame)
    assert_boxes_turned(answer, frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="Right for any order of returns and in single precision",
    hint="Nothing may depend on which return comes first.",
)
def test_order_and_precision(student, seed):
    frame = square(seed + 3)
    shuffled = np.random.default_rng(seed).permutation(frame.cloud)
    assert_detects(student, shuffled, frame)
    frame = square(seed + 4)
    assert_detects(student, np.asfortranarray(frame.cloud[:, :3].astype(np.float32)), frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Bears returns that are not a number, and hundreds at (0, 0, 0)",
    hint="Let drop_invalid be the very first step.",
)
def test_dirty_scan(student, seed):
    frame = square(seed + 5)
    cloud = frame.cloud.copy()
    bad = np.random.default_rng(seed).choice(len(cloud), 3000, replace=False)
    cloud[bad[:1000], :3] = np.nan
    cloud[bad[1000:1500], 0] = np.inf
    cloud[bad[1500:2000], 2] = -np.inf
    cloud[bad[2000:]] = 0.0
    assert_own_car_free(assert_detects(student, cloud, frame), frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="Does not take single returns in the air, such as drops of rain, for obstacles",
    hint="filter_clusters removes clusters of a few points. Does the detector call it?",
)
def test_rain(student, seed):
    frame, drops = square(seed + 6), rain(seed + 6)
    boxes = as_boxes(assert_detects(student, np.vstack([frame.cloud, drops]), frame))
    small = boxes[np.ptp(boxes, axis=1).max(axis=1) < 1.0].mean(axis=1)
    wet = sum((np.linalg.norm(small - drop[:3], axis=1) < 0.5).any() for drop in drops)
    if wet > len(drops) // 3:
        raise CheckFailed(
            "Single returns in the air have boxes.",
            yours=f"boxes around {wet} of {len(drops)} drops of rain",
            expected="none around clusters of one point",
        )


@hidden(
    "detect_obstacles",
    weight=3,
    title="An empty road has no obstacles",
    hint="Each step must bear that nothing is left: no points, no labels, no clusters.",
)
def test_empty_road(student, seed):
    boxes = as_boxes(student.detect_obstacles(empty_road().cloud.copy()))
    if len(boxes) > 3:
        raise CheckFailed(
            "A level road without a single thing on it has obstacles.",
            yours=f"{len(boxes)} boxes",
            expected="0 boxes",
        )
    # Nor is there one where a car stood a moment ago.
    car = clear_cars(square(seed))[seed % 3]
    frame = without(car, square(seed))
    assert_gone(assert_detects(student, frame.cloud.copy(), frame), car, frame)


@hidden(
    "detect_obstacles",
    weight=1,
    title="Takes scans of a few returns",
    hint="Some steps need three points or more; what do they do with one?",
)
def test_small_scans(student, seed):
    frame = square(seed + 3)
    cloud = frame.cloud
    for count in (1, 2, 4):
        boxes = as_boxes(student.detect_obstacles(cloud[-count:].copy()))
        if len(boxes) > count:
            raise CheckFailed(
                "There are more boxes than returns.",
                yours=f"{len(boxes)} boxes",
                expected=f"at most {count}",
            )
    assert_detects(student, cloud.copy(), frame)


def scattered(rng, count):
    """Places (count, 2) in the plane, more than 7 m apart."""
    cells = rng.permutation(100)[:count]
    grid = np.column_stack([cells % 10, cells // 10]) * 9.0 - 45
    return grid + rng.uniform(-0.9, 0.9, (count, 2))


def moved_on(rng, count=12, gone=3, new=3, step=0.8):
    """Centres of two frames, and the right partner of each box of the second."""
    places = scattered(rng, count + new)
    stay = rng.permutation(count)[gone:]
    angle, length = rng.uniform([[0], [0.9]], [[2 * np.pi], [1]], (2, len(stay)))
    moved = places[stay] + step * (length * [np.cos(angle), np.sin(angle)]).T
    current = np.vstack([moved, places[count:]])
    partner = np.concatenate([stay, np.full(new, -1)])
    order = rng.permutation(len(current))
    return places[:count], current[order], partner[order]


def assert_pairs(student, previous, current, distance, partner):
    assert_matched(
        student.match_boxes(previous.copy(), current.copy(), distance), partner, previous, current
    )


@hidden(
    "match_boxes",
    weight=4,
    title="Follows many boxes, some of which come and go",
    hint="Draw both frames with plots.boxes and names=True, and go through your pairs.",
)
def test_many_boxes(student, seed):
    rng = np.random.default_rng(seed)
    for step, distance in ((0.8, 1.5), (2.2, 2.5), (0.3, 0.4)):
        previous, current, partner = moved_on(rng, step=step)
        assert_pairs(student, cubes(previous), cubes(current, 1.2), distance, partner)


@hidden(
    "match_boxes",
    weight=3,
    title="The order of a box's corners does not matter",
    hint="A box that turns a little may start its corners elsewhere. The mean of all eight stays.",
)
def test_order_of_corners(student, seed):
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_on(rng, step=0.3)
    turned = cubes(current, 2.0, turn=2)
    mixed = np.stack([box[rng.permutation(8)] for box in turned])
    assert_pairs(student, cubes(previous, 2.0), turned, 0.7, partner)
    assert_pairs(student, cubes(previous, 2.0), mixed, 0.7, partner)


@hidden(
    "match_boxes",
    weight=4,
    title="Rivals: the nearer one wins, the other is new",
    hint="Sort all pairs by distance, and go through them from the closest.",
)
def test_rivals(student, seed):
    rng = np.random.default_rng(seed)
    previous = scattered(rng, 8)
    offset = rng.uniform(0, 2 * np.pi, 8)
    aside = np.column_stack([np.cos(offset), np.sin(offset)])
    current = np.vstack([previous + 0.3 * aside, previous - 1.1 * aside])
    partner = np.concatenate([np.arange(8), np.full(8, -1)])
    for order in (np.arange(16), np.arange(16)[::-1], rng.permutation(16)):
        assert_pairs(student, cubes(previous), cubes(current[order]), 1.5, partner[order])


@hidden(
    "match_boxes",
    weight=2,
    title="The place and turn of the scene do not matter, nor single precision",
    hint="Only distances between centres count.",
)
def test_invariance(student, seed):
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_on(rng)
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    shift = rng.uniform(-40, 40, 2)
    assert_pairs(
        student, cubes(previous @ turn + shift), cubes(current @ turn + shift), 1.5, partner
    )
    assert_pairs(
        student, cubes(previous).astype(np.float32), cubes(current).astype(np.float32), 1.5, partner
    )


@hidden(
    "match_boxes",
    weight=2,
    title="More boxes than before, fewer than before, and one alone",
    hint="The answer is as long as current, whatever the length of previous.",
)
def test_lengths(student, seed):
    rng = np.random.default_rng(seed)
    for gone, new in ((0, 8), (9, 0), (12, 4), (0, 0)):
        previous, current, partner = moved_on(rng, gone=gone, new=new)
        assert_pairs(student, cubes(previous), cubes(current), 1.5, partner)
    one = cubes([[3.0, 4.0]])
    assert_pairs(student, one, one + 0.2, 1.0, [0])
    assert_pairs(student, one, one + [2.0, 0, 0], 1.0, [-1])
