"""Hidden tests of lesson 12. Students see the titles and hints but not the code.

Each test covers one property. It fails until the answer finds cars or matches boxes, so a detector
without boxes earns no points. Most tests use different squares, so a detector with boxes at fixed
places passes at most one test by luck.
"""

import functools
import itertools

import numpy as np

from grader.judging.hidden_tests import hidden
from utils.checks.assertions import CheckFailed, precondition
from utils.checks.detections import (
    as_boxes,
    assert_boxes_turned,
    assert_cars_found,
    assert_contained,
    assert_few_ghosts,
    assert_kind_contained,
    assert_no_box_at_sensor,
    assert_no_box_left,
    assert_no_box_on_ego_car,
    assert_people_found,
    assert_raindrops_ignored,
    assert_separate_boxes,
    detect_once,
    require_cars_found,
    require_cars_found_in_frame,
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
    car_crossing,
    clear_cars,
    climbing_road,
    ego_car_points,
    half_sensor,
    insert_invalid,
    people_around_ego_car,
    raindrops,
    remove_car,
    square,
    square_with_people,
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

    The frame is a full scan, with twice as many returns as in the other tests.
    """
    from utils.scenes import city_block

    frames = (city_block(seed, 200)[number] for number in range(0, 200, 8))
    return next((frame for frame in frames if len(clear_cars(frame)) >= 2), square(seed))


@functools.cache
def empty_road():
    """Return a frame of a level road without objects."""
    from utils.simulator.frames import observe
    from utils.simulator.ground import Ground
    from utils.simulator.streets import world_of

    return observe(world_of(Ground(), ()), half_sensor(), 3)


def boxes_in(student, frame):
    """Require that the detector finds the cars in a frame, and return its boxes."""
    require_cars_found_in_frame(student.detect_obstacles, frame)
    return detect_once(student.detect_obstacles, frame)


def assert_found_on_climbs(student, seed, kind):
    """Require that a square's cars are found, and check objects of a kind on two climbing roads."""
    require_cars_found_in_frame(student.detect_obstacles, square(seed))
    for frame in (climbing_road(seed), climbing_road(seed + 1)):
        assert_kind_contained(detect_once(student.detect_obstacles, frame), kind, frame)


def answer_for(student, cloud, frame):
    """Require that the detector finds the cars in a changed cloud, and return its boxes."""
    answer = student.detect_obstacles(cloud)
    require_cars_found(answer, frame)
    return answer


@hidden(
    "detect_obstacles",
    weight=5,
    title="Finds the cars on new streets",
    hint="Compare your boxes with the true boxes of other scenes, such as scenes.random_street(1).",
)
def test_fresh_streets(student, seed):
    require_cars_found_in_frame(student.detect_obstacles, square(seed))
    frames = fresh_streets(seed)
    assert_cars_found([detect_once(student.detect_obstacles, frame) for frame in frames], frames)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds the cars during a drive through a new city",
    hint="Draw your boxes on several frames of scenes.city_block, and look for cars without a box.",
)
def test_city(student, seed):
    require_cars_found_in_frame(student.detect_obstacles, square(seed))
    frame = city_frame(seed)
    assert_cars_found([detect_once(student.detect_obstacles, frame)], [frame])


@hidden(
    "detect_obstacles",
    weight=9,
    title="Finds people in new places",
    hint="Keep clusters of 25 points, because a nearby person has 25 to 50 points after thinning.",
)
def test_people(student, seed):
    frame = square_with_people(seed)
    assert_people_found(boxes_in(student, frame), frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds obstacles up to 10 m ahead",
    hint="Let crop_region keep points up to a little more than 10 m ahead. A smaller region may "
    "cut a car in two.",
)
def test_reach(student, seed):
    require_cars_found_in_frame(student.detect_obstacles, square(seed))
    frame = car_crossing(seed)
    assert_contained(detect_once(student.detect_obstacles, frame), car_across(frame), frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds people close to the ego car, ahead of it and on either side",
    hint="Let remove_ego_returns remove the points in the box of the ego car and no others.",
)
def test_people_close_to_the_ego_car(student, seed):
    assert_found_on_climbs(student, seed, "pedestrian")
    frame = people_around_ego_car(seed)
    assert_kind_contained(detect_once(student.detect_obstacles, frame), "pedestrian", frame)


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds cars at the edge of the road, on either side",
    hint="Let crop_region keep points farther to the left and right.",
)
def test_edge_of_the_road(student, seed):
    assert_found_on_climbs(student, seed, "car")


@hidden(
    "detect_obstacles",
    weight=3,
    title="Finds lorries",
    hint="Keep large clusters, because a cluster of many points may be a lorry.",
)
def test_lorries(student, seed):
    assert_found_on_climbs(student, seed, "truck")


@hidden(
    "detect_obstacles",
    weight=3,
    title="Puts separate boxes around cars that are parked close together",
    hint="Pass a smaller threshold to the clustering. Two objects become one cluster if the "
    "threshold is larger than the gap between them.",
)
def test_parked_cars(student, seed):
    with precondition("the detector finds cars at the edge of the road"):
        assert_found_on_climbs(student, seed, "car")
    for frame in (climbing_road(seed), climbing_road(seed + 1)):
        assert_separate_boxes(detect_once(student.detect_obstacles, frame), frame, GAP)


@hidden(
    "detect_obstacles",
    weight=4,
    title="Puts few boxes around the road or empty space on new streets and in a new city",
    hint="Draw your boxes for scenes.random_street(1), and look for boxes that contain only road "
    "or nothing. In the city, the road climbs, so a fixed ground level does not remove the road "
    "beyond 24 m.",
)
def test_few_ghosts(student, seed):
    for frames in (fresh_streets(seed), [city_frame(seed)]):
        assert_few_ghosts([boxes_in(student, frame) for frame in frames], frames)


@hidden(
    "detect_obstacles",
    weight=12,
    title="Turns the boxes of cars at an angle",
    hint="Fit the boxes with get_oriented_boxes from lesson 11, which turns each box with its "
    "points.",
)
def test_turned_cars(student, seed):
    frame = square(seed)
    assert_boxes_turned(boxes_in(student, frame), frame)


@hidden(
    "detect_obstacles",
    weight=12,
    title="Does not put a box around the ego car, however much of it the scanner sees",
    hint="Remove all returns inside the box of the ego car and on its faces.",
)
def test_ego_car(student, seed):
    frame = square(seed + 1)
    cloud = np.random.default_rng(seed).permutation(np.vstack([frame.cloud, ego_car_points(seed)]))
    assert_no_box_on_ego_car(answer_for(student, cloud, frame), frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="Works on scans with thousands of lost returns",
    hint="Call drop_invalid first.",
)
def test_lost_returns(student, seed):
    frame = square(seed + 2)
    cloud = insert_invalid(frame.cloud, seed)
    assert_no_box_at_sensor(answer_for(student, cloud, frame), frame)


@hidden(
    "detect_obstacles",
    weight=11,
    title="Ignores raindrops in new scenes",
    hint="Fit boxes to the labels that filter_clusters returns. These are 0 for clusters of a few "
    "points.",
)
def test_rain(student, seed):
    frame, drops = square(seed + 3), raindrops(seed + 3)
    assert_raindrops_ignored(
        answer_for(student, np.vstack([frame.cloud, drops]), frame), frame, drops
    )


@hidden(
    "detect_obstacles",
    weight=2,
    title="Does not return a box where a car was a moment ago",
    hint="Use only the cloud of the current call, and nothing from earlier calls.",
)
def test_removed_car(student, seed):
    car = clear_cars(square(seed + 4))[seed % 3]
    frame = remove_car(car, square(seed + 4))
    # The detector must see the car in the call just before. `detect_once` caches answers, so no
    # other test may use this square.
    detect_once(student.detect_obstacles, square(seed + 4))
    assert_no_box_left(answer_for(student, frame.cloud.copy(), frame), car, frame)


@hidden(
    "detect_obstacles",
    weight=2,
    title="Finds no obstacles on an empty road",
    hint="Make each step work even if no points, labels or clusters are left.",
)
def test_empty_road(student, seed):
    require_cars_found_in_frame(student.detect_obstacles, square(seed + 4))
    boxes = as_boxes(student.detect_obstacles(empty_road().cloud.copy()))
    if len(boxes) > 3:
        raise CheckFailed(
            "The detector finds obstacles on a level, empty road.",
            yours=f"{len(boxes)} boxes",
            expected="0 boxes",
        )


@hidden(
    "detect_obstacles",
    weight=1,
    title="Does not depend on the order of the returns",
    hint="Treat all returns alike. The result must not depend on which return comes first.",
)
def test_order(student, seed):
    frame = square(seed + 5)
    shuffled = np.random.default_rng(seed).permutation(frame.cloud)
    assert_cars_found([student.detect_obstacles(shuffled)], [frame])


@hidden(
    "detect_obstacles",
    weight=1,
    title="Works on float32 arrays",
    hint="Begin with cloud.astype(float) if one of your steps needs 64 bits, because scanners "
    "store 32-bit numbers.",
)
def test_single_precision(student, seed):
    frame = square(seed + 6)
    cloud = frame.cloud.astype(np.float32)
    assert_cars_found([student.detect_obstacles(cloud)], [frame])


@hidden(
    "detect_obstacles",
    weight=1,
    title="Works on scans of a few returns",
    hint="Test len(points) before each step that needs at least three points.",
)
def test_small_scans(student, seed):
    cloud = square(seed + 4).cloud
    require_cars_found_in_frame(student.detect_obstacles, square(seed + 4))
    distance = np.hypot(cloud[:, 0], cloud[:, 1])
    # All detectors keep these returns until they remove the road.
    road = cloud[(distance > 4) & (distance < 5) & (cloud[:, 2] < -1.5)]
    for count in (1, 2, 4):
        # The last returns are neighbours on the road. The others are in different voxels.
        for few in (cloud[-count:], road[:: len(road) // count][:count]):
            boxes = as_boxes(student.detect_obstacles(few.copy()))
            if len(boxes) > count:
                raise CheckFailed(
                    "The detector returns more boxes than the scan has returns.",
                    yours=f"{len(boxes)} boxes",
                    expected=f"at most {count}",
                )


def random_places(rng, count):
    """Return random places (count, 2) in the plane, more than 7 m apart."""
    cells = rng.permutation(100)[:count]
    grid = np.column_stack([cells % 10, cells // 10]) * 9.0 - 45
    return grid + rng.uniform(-0.9, 0.9, (count, 2))


def moved_boxes(rng, count=12, gone=0, new=0, step=0.8):
    """Return the box centres of two frames, and the right partner of each box in the second."""
    places = random_places(rng, count + new)
    stay = rng.permutation(count)[gone:]
    angle, length = rng.uniform([[0], [0.9]], [[2 * np.pi], [1]], (2, len(stay)))
    moved = places[stay] + step * (length * [np.cos(angle), np.sin(angle)]).T
    current = np.vstack([moved, places[count:]])
    partner = np.concatenate([stay, np.full(new, -1)])
    order = rng.permutation(len(current))
    return places[:count], current[order], partner[order]


def competing_boxes(rng):
    """Return the box centres of two frames, where two boxes compete for each box in the first.

    The nearer boxes come first.
    """
    previous = random_places(rng, 8)
    offset = rng.uniform(0, 2 * np.pi, 8)
    aside = np.column_stack([np.cos(offset), np.sin(offset)])
    return previous, np.vstack([previous + 0.3 * aside, previous - 1.1 * aside])


def assert_pairs(student, previous, current, distance, partner, compared_rows=slice(None)):
    answer = student.match_boxes(previous.copy(), current.copy(), distance)
    assert_matched(answer, partner, previous, current, compared_rows)


@hidden(
    "match_boxes",
    weight=4,
    title="Matches many boxes in any order",
    hint="Draw both frames with plots.boxes and names=True, and compare them with your pairs.",
)
def test_many_boxes(student, seed):
    rng = np.random.default_rng(seed)
    for step in (0.3, 0.8, 1.2):
        previous, current, partner = moved_boxes(rng, step=step)
        assert_pairs(student, cubes(previous), cubes(current), 1.6, partner)


@hidden(
    "match_boxes",
    weight=2,
    title="Marks boxes that come into view as new",
    hint="Return -1 for each box without a partner.",
)
def test_new_boxes(student, seed):
    require_matching(student.match_boxes)
    previous, current, partner = moved_boxes(np.random.default_rng(seed), new=4)
    assert_pairs(student, cubes(previous), cubes(current), 1.6, partner, partner < 0)


@hidden(
    "match_boxes",
    weight=6,
    title="Pairs only boxes that are within max_distance",
    hint="Compare the distance itself, in metres, with max_distance, before you accept a pair.",
)
def test_max_distance(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    for step, limit, near in ((2.2, 2.4, True), (0.7, 0.6, False), (2.2, 1.9, False)):
        previous, current, partner = moved_boxes(rng, gone=3, new=3, step=step)
        expected = partner if near else np.full(len(partner), -1)
        boxes = cubes(previous), cubes(current)
        assert_limit_respected(student.match_boxes(*boxes, limit), expected, *boxes, limit)
    # Here, the pairing with the smallest sum of distances has two pairs that are too far apart.
    start, angle = rng.uniform(-30, 30, 2), rng.uniform(0, 2 * np.pi)
    along = [np.cos(angle), np.sin(angle)]
    boxes = tuple(cubes(start + np.outer(metres, along)) for metres in ([0, 4], [3.2, 7.2]))
    assert_limit_respected(student.match_boxes(*boxes, 2.0), [1, -1], *boxes, 2.0)


@hidden(
    "match_boxes",
    weight=10,
    title="Gives each box at most one partner, even in a crowd",
    hint="If two boxes are close to the same partner, give it to the nearer one only.",
)
def test_one_to_one(student, seed):
    require_matching(student.match_boxes)
    previous, current = competing_boxes(np.random.default_rng(seed))
    for order in (np.arange(16), np.arange(16)[::-1]):
        boxes = cubes(previous), cubes(current[order])
        assert_one_to_one(student.match_boxes(*boxes, 1.6), *boxes)


@hidden(
    "match_boxes",
    weight=4,
    title="Gives partners to the nearer of many rivals",
    hint="Sort all pairs by distance, and start with the closest.",
)
def test_nearer_rival(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    previous, current = competing_boxes(rng)
    partner = np.concatenate([np.arange(8), np.full(8, -1)])
    for order in (np.arange(16)[::-1], rng.permutation(16)):
        compared_rows = partner[order] >= 0
        assert_pairs(
            student, cubes(previous), cubes(current[order]), 1.6, partner[order], compared_rows
        )


@hidden(
    "match_boxes",
    weight=2,
    title="Chooses the nearer of two nearby previous boxes",
    hint="Set the row and the column of each pair to np.inf, because a box that has a partner "
    "must not get a second one.",
)
def test_second_choice(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    current, previous = competing_boxes(rng)
    for order in (np.arange(16), np.arange(16)[::-1], rng.permutation(16)):
        partner = np.argsort(order)[:8]
        assert_pairs(student, cubes(previous[order]), cubes(current), 1.6, partner)


@hidden(
    "match_boxes",
    weight=6,
    title="Does not depend on the order of a box's corners",
    hint="Compare the means over all eight corners, boxes.mean(axis=1). A box that turns slightly "
    "may have its corners in another order.",
)
def test_order_of_corners(student, seed):
    require_matching(student.match_boxes)
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_boxes(rng, step=0.3)
    turned = cubes(current, 2.0, turn=2)
    mixed = np.stack([box[rng.permutation(8)] for box in turned])
    assert_pairs(student, cubes(previous, 2.0), turned, 0.7, partner)
    assert_pairs(student, cubes(previous, 2.0), mixed, 0.7, partner)


@hidden(
    "match_boxes",
    weight=1,
    title="Does not depend on the position or rotation of the scene",
    hint="Use only the distances between centres.",
)
def test_position_and_rotation(student, seed):
    rng = np.random.default_rng(seed)
    previous, current, partner = moved_boxes(rng)
    angle = rng.uniform(0, 2 * np.pi)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    shift = rng.uniform(-40, 40, 2)
    boxes = cubes(previous @ turn + shift), cubes(current @ turn + shift)
    assert_pairs(student, *boxes, 1.6, partner)


@hidden(
    "match_boxes",
    weight=1,
    title="Works on float32 boxes",
    hint="Use only the distances between centres, so that rounding does not decide a pair.",
)
def test_single_precision_of_boxes(student, seed):
    previous, current, partner = moved_boxes(np.random.default_rng(seed))
    boxes = cubes(previous).astype(np.float32), cubes(current).astype(np.float32)
    assert_pairs(student, *boxes, 1.6, partner)


@hidden(
    "match_boxes",
    weight=2,
    title="Works when a frame has more boxes than before, fewer boxes or a single box",
    hint="Return one entry for each current box, whatever the length of previous.",
)
def test_unequal_counts(student, seed):
    rng = np.random.default_rng(seed)
    for gone, new in ((0, 8), (9, 0)):
        previous, current, partner = moved_boxes(rng, gone=gone, new=new)
        compared_rows = partner >= 0
        assert_pairs(student, cubes(previous), cubes(current), 1.6, partner, compared_rows)
    single = cubes([[3.0, 4.0]])
    assert_pairs(student, single, single + 0.2, 1.6, [0])
