"""Hidden tests of lesson 12. Titles and hints are shown to students; the code is not.

Each tests one property, and only if cars are found or boxes are matched, so that a detector without
boxes earns nothing. Most tests have a square of their own, so that boxes at fixed places succeed by
luck at most once.
"""

import functools
import itertools

import numpy as np

from grader.judging.hidden_tests import hidden
from utils.checks.assertions import CheckFailed, needs
from utils.checks.detections import (
    as_boxes,
    assert_apart,
    assert_boxes_real,
    assert_boxes_turned,
    assert_cars_found,
    assert_cars_seen,
    assert_dry,
    assert_gone,
    assert_kind_reached,
    assert_nothing_at_sensor,
    assert_own_car_free,
    assert_people_found,
    assert_reached,
    assert_sees,
    detected,
)
from utils.checks.lesson_12.match_boxes import (
    assert_limit_respected,
    assert_matched,
    assert_one_to_one,
    cubes,
    require_matching,
)
from utils.checks.scans import (
    GAP,
    car_across,
    clear_cars,
    climb,
    crossing,
    ego_car_points,
    half_sensor,
    rain,
    square,
    walk,
    with_invalid,
    without,
)


@functools.lru_cache(maxsize=32)
def fresh_streets(seed):
    """Return two new streets with at least two clear cars each."""
    from utils.scenes import random_street

    frames = (random_street(seed + number, 0.4, half_sensor()) for number in itertools.count())
    return list(itertools.islice((frame for frame in frames if len(clear_cars(frame)) >= 2), 2))


@functools.lru_cache(maxsize=32)
def city_frame(seed):
    """Return a frame of a drive through a new city, with at least two clear cars.

    It is a full scan, with twice as many returns as in the other tests.
    """
    from utils.scenes import city_block

    frames = (city_block(seed, 200)[number] for number in range(0, 200, 8))
    return next((frame for frame in frames if len(clear_cars(frame)) >= 2), square(seed))


@functools.cache
def empty_road():
    """Return a scan of a level road without objects."""
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import world_of

    return observe(world_of(Ground(), ()), half_sensor(), 3)


def sees(student, frame):
    """Return the detector's boxes in a frame, after a check that it finds the frame's cars."""
    assert_cars_seen(student.detect_obstacles, frame)
    return detected(student.detect_obstacles, frame)


def assert_seen_on_climbs(student, seed, kind):
    """Require the cars of a square, then each thing of a kind on two roads that climb."""
    assert_cars_seen(student.detect_obstacles, square(seed))
    for frame in (climb(seed), climb(seed + 1)):
        assert_kind_reached(detected(student.detect_obstacles, frame), kind, frame)


def answer_for(student, cloud, frame):
    """Return the detector's boxes in a changed cloud, after a check that they contain the cars."""
    answer = student.detect_obstacles(cloud)
    assert_sees(answer, frame)
    return answer


@hidden(
    "detect_obstacles",
    weight=5,
    title="Finds the cars of streets you have not seen",
    hint="Try other scenes: scenes.random_street(1), (2), (3) with their true boxes.",
)
def test_fresh_streets(student, seed):
    assert_cars_seen(student.detect_obstacles, square(seed))
    frames = fresh_streets(seed)
    assert_cars_found([detected(student.detect_obstacles, frame) for frame in frames], frames)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds the cars of a drive through the city",
    hint="Draw your boxes on several frames of scenes.city_block: where is a car without one?",
)
def test_city(student, seed):
    assert_cars_seen(student.detect_obstacles, square(seed))
    frame = city_frame(seed)
    assert_cars_found([detected(student.detect_obstacles, frame)], [frame])


@hidden(
    "detect_obstacles",
    weight=9,
    title="Finds people in places you have not seen",
    hint="A person near by has 20 to 40 points after thinning: which of your steps asks for more?",
)
def test_people(student, seed):
    frame = walk(seed)
    assert_people_found(sees(student, frame), frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Looks 10 m ahead",
    hint="A region of interest that ends before 10 m cuts through cars that stand nearer.",
)
def test_reach(student, seed):
    assert_cars_seen(student.detect_obstacles, square(seed))
    frame = crossing(seed)
    assert_reached(detected(student.detect_obstacles, frame), car_across(frame), frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="A person next to the bumper has a box, on either side",
    hint="remove_ego_returns takes away the box of the own car and nothing beyond it.",
)
def test_person_at_the_bumper(student, seed):
    assert_seen_on_climbs(student, seed, "pedestrian")


@hidden(
    "detect_obstacles",
    weight=3,
    title="Cars at the edge of the road have boxes, on either side",
    hint="Where does your region of interest end to the side?",
)
def test_edge_of_the_road(student, seed):
    assert_seen_on_climbs(student, seed, "car")


@hidden(
    "detect_obstacles",
    weight=3,
    title="Lorries have boxes",
    hint="A cluster of a thousand points is a wall or a lorry.",
)
def test_lorries(student, seed):
    assert_seen_on_climbs(student, seed, "truck")


@hidden(
    "detect_obstacles",
    weight=3,
    title="Cars that are parked closely have boxes of their own",
    hint="Two things are one cluster where the threshold is larger than the gap between them.",
)
def test_parked_cars(student, seed):
    with needs("cars at the edge of the road have boxes"):
        assert_seen_on_climbs(student, seed, "car")
    for frame in (climb(seed), climb(seed + 1)):
        assert_apart(detected(student.detect_obstacles, frame), frame, GAP)


@hidden(
    "detect_obstacles",
    weight=4,
    title="Sees few ghosts in streets and a city you have not seen",
    hint="Draw the boxes of scenes.random_street(1): which hold road, which hold nothing? The road "
    "of the city climbs: what does your ground filter leave 20 m ahead?",
)
def test_few_ghosts(student, seed):
    for frames in (fresh_streets(seed), [city_frame(seed)]):
        assert_boxes_real([sees(student, frame) for frame in frames], frames)


@hidden(
    "detect_obstacles",
    weight=12,
    title="Turns the boxes of cars that stand at an angle",
    hint="Seen from above, the sides of a box should run along the sides of the car.",
)
def test_turned_cars(student, seed):
    frame = square(seed)
    assert_boxes_turned(sees(student, frame), frame)


@hidden(
    "detect_obstacles",
    weight=12,
    title="Does not take its own car for an obstacle, however much of it the scanner sees",
    hint="All that lies in the box of the own car has to go, up to its faces.",
)
def test_own_car(student, seed):
    frame = square(seed + 1)
    cloud = np.random.default_rng(seed).permutation(np.vstack([frame.cloud, ego_car_points(seed)]))
    assert_own_car_free(answer_for(student, cloud, frame), frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="Copes with scans with thousands of lost returns",
    hint="Let drop_invalid be the very first step.",
)
def test_dirty_scan(student, seed):
    frame = square(seed + 2)
    cloud = with_invalid(frame.cloud, seed)
    assert_nothing_at_sensor(answer_for(student, cloud, frame), frame)


@hidden(
    "detect_obstacles",
    weight=11,
    title="Does not take single returns in the air, such as drops of rain, for obstacles",
    hint="filter_clusters returns new labels, without the clusters of a few points. Are these the "
    "labels that get boxes?",
)
def test_rain(student, seed):
    frame, drops = square(seed + 3), rain(seed + 3)
    assert_dry(answer_for(student, np.vstack([frame.cloud, drops]), frame), frame, drops)


@hidden(
    "detect_obstacles",
    weight=2,
    title="No box is left where a car stood a moment ago",
    hint="Every call starts anew, with nothing but its cloud.",
)
def test_gone(student, seed):
    car = clear_cars(square(seed + 4))[seed % 3]
    frame = without(car, square(seed + 4))
    # The test is about boxes that this call leaves behind, so no other test uses this square.
    detected(student.detect_obstacles, square(seed + 4))
    assert_gone(answer_for(student, frame.cloud.copy(), frame), car, frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="An empty road has no obstacles",
    hint="Each step must cope with nothing being left: no points, no labels, no clusters.",
)
def test_empty_road(student, seed):
    assert_cars_seen(student.detect_obstacles, square(seed + 4))
    boxes = as_boxes(student.detect_obstacles(empty_road().cloud.copy()))
    if len(boxes) > 3:
        raise CheckFailed(
            "A level road without a single thing on it has obstacles.",
            yours=f"{len(boxes)} boxes",
            expected="0 boxes",
        )


@hidden(
    "detect_obstacles",
    weight=1,
    title="Right for any order of returns",
    hint="Nothing may depend on which return comes first.",
)
def test_order(student, seed):
    frame = square(seed + 5)
    shuffled = np.random.default_rng(seed).permutation(frame.cloud)
    assert_cars_found([student.detect_obstacles(shuffled)], [frame])


@hidden(
    "detect_obstacles",
    weight=1,
    title="Right in single precision",
    hint="Scanners store 32 bits: let astype(float) come first if a step of yours needs 64.",
)
def test_precision(student, seed):
    frame = square(seed + 6)
    cloud = np.asfortranarray(frame.cloud.astype(np.float32))
    assert_cars_found([student.detect_obstacles(cloud)], [frame])


@hidden(
    "detect_obstacles",
    weight=1,
    title="Takes scans of a few returns",
    hint="Some steps need three points or more; what do they do with one?",
)
def test_small_scans(student, seed):
    cloud = square(seed + 4).cloud
    assert_cars_seen(student.detect_obstacles, square(seed + 4))
    for count in (1, 2, 4):
        boxes = as_boxes(student.detect_obstacles(cloud[-count:].copy()))
        if len(boxes) > count:
            raise CheckFailed(
                "There are more boxes than returns.",
                yours=f"{len(boxes)} boxes",
                expected=f"at most {count}",
            )


def scattered(rng, count):
    """Return random places (count, 2) in the plane, more than 7 m apart."""
    cells = rng.permutation(100)[:count]
    grid = np.column_stack([cells % 10, cells // 10]) * 9.0 - 45
    return grid + rng.uniform(-0.9, 0.9, (count, 2))


def moved_on(rng, count=12, gone=0, new=0, step=0.8):
    """Return the centres of two frames, and the right partner of each box in the second."""
    places = scattered(rng, count + new)
    stay = rng.permutation(count)[gone:]
    angle, length = rng.uniform([[0], [0.9]], [[2 * np.pi], [1]], (2, len(stay)))
    moved = places[stay] + step * (length * [np.cos(angle), np.sin(angle)]).T
    current = np.vstack([moved, places[count:]])
    partner = np.concatenate([stay, np.full(new, -1)])
    order = rng.permutation(len(current))
    return places[:count], current[order], partner[order]


def rivals(rng):
    """Return the centres of two frames; two boxes, the nearer first, compete for each place."""
    previous = scattered(rng, 8)
    offset = rng.uniform(0, 2 * np.pi, 8)
    aside = np.column_stack([np.cos(offset), np.sin(offset)])
    return previous, np.vstack([previous + 0.3 * aside, previous - 1.1 * aside])


def assert_pairs(student, previous, current, distance, partner, look_at=slice(None)):
    answer = student.match_boxes(previous.copy(), current.copy(), distance)
    assert_matched(answer, partner, previous, current, look_at)


@hidden(
    "match_boxes",
    weight=4,
    title="Follows many boxes, whatever order they come in",
    hint="Draw both frames with plots.boxes and names=True, and go through your pairs.",
)
def test_many_boxes(student, seed):
    rng = np.random.default_rng(seed)
    for step in (0.3, 0.8, 1.2):
        previous, current, partner = moved_on(rng, step=step)
        assert_pairs(student, cubes(previous), cubes(current), 1.6, partner)


@hidden(
    "match_boxes",
    weight=2,
    title="Whoever comes into view is new",
    hint="The answer has -1 wherever no pair was made.",
)
def test_new_ones(student, seed):
    require_matching(student.match_boxes)
    previous, current, partner = moved_on(np.random.default_rng(seed), new=4)
    assert_pairs(student, cubes(previous), cubes(current), 1.6, partner, partner < 0)


@hidden(
    "match_boxes",
    weight=6,
    title="Partners are within max_distance, whatever it is",
    hint="Compare the distance itself, in metres, with max_distance, before you accept a pair.",
)
def test_limit(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    for step, limit, near in ((2.2, 2.4, True), (0.7, 0.6, False), (2.2, 1.9, False)):
        previous, current, partner = moved_on(rng, gone=3, new=3, step=step)
        expected = partner if near else np.full(len(partner), -1)
        boxes = cubes(previous), cubes(current)
        assert_limit_respected(student.match_boxes(*boxes, limit), expected, *boxes, limit)
    # In this case, the two pairs that are too far apart have the smaller sum of distances.
    start, angle = rng.uniform(-30, 30, 2), rng.uniform(0, 2 * np.pi)
    along = [np.cos(angle), np.sin(angle)]
    boxes = tuple(cubes(start + np.outer(ways, along)) for ways in ([0, 4], [3.2, 7.2]))
    assert_limit_respected(student.match_boxes(*boxes, 2.0), [1, -1], *boxes, 2.0)


@hidden(
    "match_boxes",
    weight=10,
    title="One to one, also in a crowd",
    hint="Two that want the same partner: what does the second one get?",
)
def test_one_to_one(student, seed):
    require_matching(student.match_boxes)
    previous, current = rivals(np.random.default_rng(seed))
    for order in (np.arange(16), np.arange(16)[::-1]):
        boxes = cubes(previous), cubes(current[order])
        assert_one_to_one(student.match_boxes(*boxes, 1.6), *boxes)


@hidden(
    "match_boxes",
    weight=4,
    title="Of many rivals the nearer ones win",
    hint="Sort all pairs by distance, and go through them from the closest.",
)
def test_nearer(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    previous, current = rivals(rng)
    partner = np.concatenate([np.arange(8), np.full(8, -1)])
    for order in (np.arange(16)[::-1], rng.permutation(16)):
        look_at = partner[order] >= 0
        assert_pairs(student, cubes(previous), cubes(current[order]), 1.6, partner[order], look_at)


@hidden(
    "match_boxes",
    weight=2,
    title="Of two earlier boxes near by the nearer one is the partner",
    hint="A box that has its partner takes no second one, whoever is left.",
)
def test_second_choice(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    current, previous = rivals(rng)
    for order in (np.arange(16), np.arange(16)[::-1], rng.permutation(16)):
        partner = np.argsort(order)[:8]
        assert_pairs(student, cubes(previous[order]), cubes(current), 1.6, partner)


@hidden(
    "match_boxes",
    weight=6,
    title="The order of a box's corners does not matter",
    hint="A box that turns a little may start its corners elsewhere. The mean of all eight stays.",
)
def test_order_of_corners(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_on(rng, step=0.3)
    turned = cubes(current, 2.0, turn=2)
    mixed = np.stack([box[rng.permutation(8)] for box in turned])
    assert_pairs(student, cubes(previous, 2.0), turned, 0.7, partner)
    assert_pairs(student, cubes(previous, 2.0), mixed, 0.7, partner)


@hidden(
    "match_boxes",
    weight=1,
    title="The place and turn of the scene do not matter",
    hint="Only distances between centres count.",
)
def test_anywhere(student, seed):
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_on(rng)
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    shift = rng.uniform(-40, 40, 2)
    boxes = cubes(previous @ turn + shift), cubes(current @ turn + shift)
    assert_pairs(student, *boxes, 1.6, partner)


@hidden(
    "match_boxes",
    weight=1,
    title="Right in single precision",
    hint="Only distances between centres count, to the centimetre.",
)
def test_precision_of_boxes(student, seed):
    previous, current, partner = moved_on(np.random.default_rng(seed))
    boxes = cubes(previous).astype(np.float32), cubes(current).astype(np.float32)
    assert_pairs(student, *boxes, 1.6, partner)


@hidden(
    "match_boxes",
    weight=2,
    title="More boxes than before, fewer than before, and one alone",
    hint="The answer is as long as current, whatever the length of previous.",
)
def test_lengths(student, seed):
    rng = np.random.default_rng(seed)
    for gone, new in ((0, 8), (9, 0)):
        previous, current, partner = moved_on(rng, gone=gone, new=new)
        look_at = partner >= 0
        assert_pairs(student, cubes(previous), cubes(current), 1.6, partner, look_at)
    single = cubes([[3.0, 4.0]])
    assert_pairs(student, single, single + 0.2, 1.6, [0])
