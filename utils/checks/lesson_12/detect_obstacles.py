"""Visible checks of `detect_obstacles`; most of them wait until cars are found."""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType, SimpleNamespace

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief_text,
    observe,
    precondition,
)
from utils.checks.core import note_check, visible_check
from utils.checks.detections import (
    as_boxes,
    assert_boxes_turned,
    assert_cars_found,
    assert_contained,
    assert_few_ghosts,
    assert_kind_contained,
    assert_no_box_at_sensor,
    assert_no_box_on_ego_car,
    assert_no_boxes_on_road,
    assert_people_found,
    assert_raindrops_ignored,
    assert_separate_boxes,
    assert_upright,
    detect_once,
    require_cars_found,
    require_cars_found_in_frame,
)
from utils.checks.failures import fixed
from utils.checks.scans import (
    GAP,
    car_across,
    car_crossing,
    climbing_road,
    ego_car_points,
    insert_invalid,
    people_around_ego_car,
    raindrops,
    square,
    square_with_people,
    street,
    street_further_back,
)
from utils.checks.static_analysis import functions_used

SQUARE_SEED, WALK_SEED, CLIMB_SEED = 25, 7, 4


@visible_check(
    "detect_obstacles",
    weight=5,
    title="Finds isolated cars near the sensor",
    why="The detector combines your functions from earlier lessons. If any step loses a parked "
    "car, the ego car may hit it.",
    hint="Print how many returns of the missed car are left after each step, and fix the step "
    "that removes the last of them.",
)
def finds_cars(detect_obstacles: Callable) -> None:
    # Include every scan that later checks use, because those checks wait until the cars in their
    # scan are found.
    for frame in (
        street(),
        street_further_back(),
        square(SQUARE_SEED),
        square_with_people(WALK_SEED),
    ):
        assert_cars_found([detect_once(detect_obstacles, frame)], [frame])


@visible_check(
    "detect_obstacles",
    weight=9,
    title="Finds isolated people near the sensor",
    why="People are the smallest road users. If the detector misses a person, the ego car may hit "
    "them.",
    hint="Count the points of a person that are left before clustering, and keep min_num_points "
    "at or below that number.",
)
def finds_people(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, square_with_people(WALK_SEED))
    assert_people_found(
        detect_once(detect_obstacles, square_with_people(WALK_SEED)), square_with_people(WALK_SEED)
    )


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Finds a car that crosses the road 8 to 10 m ahead",
    why="At 30 km/h, a car needs about 9 m to brake to a stop. A detector with a shorter range "
    "finds obstacles too late.",
    hint="Let crop_region keep points up to a little more than 10 m ahead.",
)
def looks_far_enough(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, square(SQUARE_SEED))
    frame = car_crossing(SQUARE_SEED)
    assert_contained(detect_once(detect_obstacles, frame), car_across(frame), frame)


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Puts boxes around obstacles, not around the road or empty space",
    why="A car that brakes for the road itself is useless.",
    hint="Draw the wrong boxes from the side. If they contain road that rises above the ground "
    "level, use ransac_plane. If they contain only a few points, use filter_clusters.",
)
def avoids_ghosts(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, street_further_back())
    assert_few_ghosts(
        [detect_once(detect_obstacles, street_further_back())], [street_further_back()]
    )


def _assert_found_on_the_climb(detect_obstacles: Callable, kind: str) -> None:
    """Assert that the objects of a kind on a climbing road are in boxes.

    Raise `NotYet` if even the cars in an ordinary street are not found.
    """
    require_cars_found_in_frame(detect_obstacles, street_further_back())
    frame = climbing_road(CLIMB_SEED)
    assert_kind_contained(detect_once(detect_obstacles, frame), kind, frame)


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Finds people close to the ego car",
    why="If the detector misses a person right in front of the ego car or next to it, the car may "
    "start and hit them.",
    hint="Let remove_ego_returns remove the points in the box of the ego car, from (-1.5, -1.7, "
    "-1.0) to (2.6, 1.7, -0.4), and no others.",
)
def finds_the_person_at_the_bumper(detect_obstacles: Callable) -> None:
    _assert_found_on_the_climb(detect_obstacles, "pedestrian")
    frame = people_around_ego_car(CLIMB_SEED)
    assert_kind_contained(detect_once(detect_obstacles, frame), "pedestrian", frame)


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Finds cars at the edge of the road, up to 7 m to the side",
    why="A parked car may pull out, or its door may open, so the ego car must see it in time.",
    hint="Let crop_region keep points farther to the left and right.",
)
def looks_to_the_side(detect_obstacles: Callable) -> None:
    _assert_found_on_the_climb(detect_obstacles, "car")


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Finds a lorry, even if it has very many points",
    why="A lorry is the largest obstacle on the road. If it has no box, the ego car drives into "
    "it.",
    hint="Keep large clusters, because a cluster of many points may be a lorry.",
)
def finds_the_lorry(detect_obstacles: Callable) -> None:
    _assert_found_on_the_climb(detect_obstacles, "truck")


@visible_check(
    "detect_obstacles",
    weight=3,
    title="Puts separate boxes around two cars that are parked close together",
    why="A single box hides the gap from which a child may run into the road.",
    hint="Pass a smaller threshold to the clustering. Two objects become one cluster if the "
    "threshold is larger than the gap between them.",
)
def keeps_parked_cars_apart(detect_obstacles: Callable) -> None:
    with precondition("the detector finds cars at the edge of the road"):
        _assert_found_on_the_climb(detect_obstacles, "car")
    frame = climbing_road(CLIMB_SEED)
    assert_separate_boxes(detect_once(detect_obstacles, frame), frame, GAP)


@visible_check(
    "detect_obstacles",
    weight=12,
    title="Does not put a box around the ego car",
    why="With an obstacle at 0 m, the car would brake forever.",
    hint="Call remove_ego_returns with the whole box of the ego car, from (-1.5, -1.7, -1.0) to "
    "(2.6, 1.7, -0.4), before you thin or cluster the points. In this check, the scanner sees the "
    "whole bonnet and roof.",
)
def ignores_the_ego_car(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    answer = detect_obstacles(np.vstack([frame.cloud, ego_car_points(SQUARE_SEED)]))
    require_cars_found(answer, frame)
    assert_no_box_on_ego_car(answer, frame)


@visible_check(
    "detect_obstacles",
    weight=12,
    title="Turns each box with its car",
    why="A car that pulls out of a parking space is at an angle. A box along the axes would block "
    "the lane next to it.",
    hint="Fit the boxes with get_oriented_boxes from lesson 11, which turns each box with its "
    "points.",
)
def turns_boxes(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, square(SQUARE_SEED))
    assert_boxes_turned(detect_once(detect_obstacles, square(SQUARE_SEED)), square(SQUARE_SEED))


@visible_check(
    "detect_obstacles",
    weight=2,
    title="Returns upright boxes with a level, rectangular floor and the roof exactly above it",
    why="The ego car would compute a wrong height and a wrong area from a leaning box.",
    hint="End with your get_oriented_boxes from lesson 11, which turns boxes about z only.",
)
def returns_upright_boxes(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, square(SQUARE_SEED))
    assert_upright(detect_once(detect_obstacles, square(SQUARE_SEED)))


@visible_check(
    "detect_obstacles",
    weight=13,
    title="Ignores single returns in the air, such as raindrops",
    why="In rain, the car would otherwise brake for every drop.",
    hint="Fit boxes to the labels that filter_clusters returns. These are 0 for clusters of a few "
    "points.",
)
def ignores_rain(detect_obstacles: Callable) -> None:
    frame, drops = square(SQUARE_SEED), raindrops(SQUARE_SEED)
    answer = detect_obstacles(np.vstack([frame.cloud, drops]))
    require_cars_found(answer, frame)
    assert_raindrops_ignored(answer, frame, drops)


@visible_check(
    "detect_obstacles",
    weight=2,
    title="Works on scans with non-finite returns and with hundreds of returns at (0, 0, 0)",
    why="The scanner stores lost returns as such rows, and a stream must not stop because of them.",
    hint="Call drop_invalid first.",
)
def drops_invalid(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    answer = detect_obstacles(insert_invalid(frame.cloud, 1))
    require_cars_found(answer, frame)
    assert_no_box_at_sensor(answer, frame)


@visible_check(
    "detect_obstacles",
    weight=1,
    title="Works on an empty scan",
    why="An empty frame must not stop the stream.",
    hint="Return np.empty((0, 8, 3)) if no points are left after a filter.",
)
def works_on_an_empty_scan(detect_obstacles: Callable) -> None:
    require_cars_found_in_frame(detect_obstacles, square(SQUARE_SEED))
    boxes = as_boxes(detect_obstacles(np.empty((0, 4))))
    if len(boxes):
        raise CheckFailed("An empty scan has no obstacles.", yours=f"{len(boxes)} boxes")


@visible_check(
    "detect_obstacles",
    weight=5,
    title="Works on scans without intensity",
    why="Some scanners do not measure intensity, and some recordings do not store it.",
    hint="Use cloud[:, :3] from the start.",
)
def works_without_intensity(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    require_cars_found_in_frame(detect_obstacles, frame)
    assert_cars_found([detect_obstacles(frame.cloud[:, :3].copy())], [frame])


@visible_check(
    "detect_obstacles",
    weight=1,
    title="Does not change its input",
    why="The next cells score and draw the same cloud, so they need the original points.",
    hint="Select rows with a mask, which creates a new array, and do not write into the input.",
)
def keeps_the_cloud_unchanged(detect_obstacles: Callable) -> None:
    cloud = square(SQUARE_SEED).cloud.copy()
    cloud[::50, 3] = np.nan  # a function that cleans the cloud in place replaces these values
    observed = observe(detect_obstacles, cloud)
    require_cars_found(observed.result, square(SQUARE_SEED))
    assert_arguments_unchanged(observed, cloud)


@note_check(
    "detect_obstacles",
    title="Does not mistake a climbing road for an obstacle",
    why="On a road that climbs by 4 %, a fixed ground level does not remove the road beyond 13 m, "
    "and the car brakes for it. A plane through the low points (lesson 03) climbs with the road.",
)
def ignores_a_climbing_road(detect_obstacles: Callable) -> None:
    assert_no_boxes_on_road(
        detect_once(detect_obstacles, climbing_road(CLIMB_SEED)), climbing_road(CLIMB_SEED)
    )


@note_check(
    "detect_obstacles",
    title="Returns the boxes as an array, not as a list",
    why="The cells below select boxes with a mask, which does not work on a list.",
)
def returns_an_array(detect_obstacles: Callable) -> None:
    for cloud in (street_further_back().cloud.copy(), np.empty((0, 4))):
        answer = detect_obstacles(cloud)
        if np.shape(answer)[1:] != (8, 3) or not isinstance(answer, np.ndarray):
            raise CheckFailed(
                fixed(
                    "Return np.array(boxes).reshape(-1, 8, 3), which is an array even if there "
                    "are no boxes."
                ),
                yours=brief_text(answer),
            )


@note_check(
    "detect_obstacles",
    title="Starts each box with the four floor corners or the four roof corners",
    why="The score card uses the first four corners as the ground that a box covers.",
)
def lists_the_floor_first(detect_obstacles: Callable) -> None:
    for box in as_boxes(detect_obstacles(street_further_back().cloud.copy())):
        if np.ptp(box[:4, 2]) > 2e-3:
            raise CheckFailed(
                "The first four corners are not at the same height.", yours=brief_text(box)
            )


@note_check(
    "detect_obstacles",
    title="Uses only functions of this notebook",
    why="The judge runs only this notebook, so a detector that needs another notebook fails and "
    "earns no points. Paste the functions that the detector needs into the cells above it.",
)
def uses_this_notebook_only(detect_obstacles: Callable) -> None:
    if name := _foreign_name(detect_obstacles):
        raise CheckFailed(f"The detector uses {name}, which comes from another notebook.")


def _foreign_name(function: Callable) -> str | None:
    """Return the name through which a function, or one that it calls, uses another notebook."""
    functions = [function, *functions_used(function).values()]
    pending = [
        (called.__code__, called.__globals__) for called in functions if hasattr(called, "__code__")
    ]
    while pending:
        code, names = pending.pop(0)
        pending += [(nested, names) for nested in code.co_consts if isinstance(nested, CodeType)]
        for name in code.co_names:
            value = names.get(name)
            members = vars(value).values() if isinstance(value, SimpleNamespace) else [value]
            # `load_my_functions` sets the module of the functions to the name of their notebook.
            modules = {str(getattr(member, "__module__", "")) for member in members}
            if name == "load_my_functions" or any(
                module.endswith(".ipynb") and module != function.__module__ for module in modules
            ):
                return name
    return None
