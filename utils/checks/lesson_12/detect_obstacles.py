"""Visible checks of `detect_obstacles`: further properties are judged only if cars are found."""

from __future__ import annotations

from collections.abc import Callable
from types import CodeType, SimpleNamespace

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief,
    needs,
    observe,
)
from utils.checks.core import noted, visible
from utils.checks.detections import (
    as_boxes,
    assert_apart,
    assert_boxes_real,
    assert_boxes_turned,
    assert_cars_found,
    assert_cars_seen,
    assert_dry,
    assert_kind_reached,
    assert_nothing_at_sensor,
    assert_own_car_free,
    assert_people_found,
    assert_reached,
    assert_road_free,
    assert_sees,
    assert_upright,
    detected,
)
from utils.checks.failures import fixed
from utils.checks.scans import (
    GAP,
    car_across,
    climb,
    crossing,
    own_car,
    rain,
    square,
    street,
    street_before,
    walk,
    with_invalid,
)
from utils.checks.static_analysis import functions_used

SQUARE_SEED, WALK_SEED, CLIMB_SEED = 25, 7, 4


@visible(
    "detect_obstacles",
    weight=5,
    title="Each car that stands free near the sensor has a box of its own",
    why="This is what the other eleven lessons were for.",
    hint="Follow the returns near that place: how many are left after each step, and at which do "
    "they vanish?",
)
def finds_cars(detect_obstacles: Callable) -> None:
    # Cover every scan that later checks use, one by one, because those checks can be judged only if
    # the cars in their scan are found.
    for frame in (street(), street_before(), square(SQUARE_SEED), walk(WALK_SEED)):
        assert_cars_found([detected(detect_obstacles, frame)], [frame])


@visible(
    "detect_obstacles",
    weight=9,
    title="People who stand free near the sensor have boxes, too",
    why="They are the smallest that there is on a road, and the ones that matter most.",
    hint="How many points of a person are left before clustering? min_num_points must be smaller.",
)
def finds_people(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, walk(WALK_SEED))
    assert_people_found(detected(detect_obstacles, walk(WALK_SEED)), walk(WALK_SEED))


@visible(
    "detect_obstacles",
    weight=3,
    title="A car across the road has a box, 8 to 10 m ahead",
    why="At 30 km/h a car needs 9 m to stop: who looks less far brakes too late.",
    hint="Where does your region of interest end? It must reach 10 m ahead, and a little more.",
)
def looks_far_enough(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, square(SQUARE_SEED))
    frame = crossing(SQUARE_SEED)
    assert_reached(detected(detect_obstacles, frame), car_across(frame), frame)


@visible(
    "detect_obstacles",
    weight=3,
    title="Boxes are around obstacles, not around road or nothing",
    why="A car that brakes for its own road will not be driven for long.",
    hint="Look at the ghosts from the side: road that rises above the ground level, where a plane "
    "(lesson 03) would rise with it? Pieces of a few points, which filter_clusters should have "
    "removed?",
)
def leaves_the_road(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, street_before())
    assert_boxes_real([detected(detect_obstacles, street_before())], [street_before()])


def _assert_seen_on_the_climb(detect_obstacles: Callable, kind: str) -> None:
    """Require the cars of a simple street, then each thing of a kind on the road that climbs."""
    assert_cars_seen(detect_obstacles, street_before())
    frame = climb(CLIMB_SEED)
    assert_kind_reached(detected(detect_obstacles, frame), kind, frame)


@visible(
    "detect_obstacles",
    weight=3,
    title="A person next to the bumper has a box",
    why="Whoever crosses in front of a standing car is nearer than anything else.",
    hint="remove_ego_returns takes away the box of the own car, from (-1.5, -1.7, -1.0) to "
    "(2.6, 1.7, -0.4), and nothing beyond it.",
)
def finds_the_person_at_the_bumper(detect_obstacles: Callable) -> None:
    _assert_seen_on_the_climb(detect_obstacles, "pedestrian")


@visible(
    "detect_obstacles",
    weight=3,
    title="Cars at the edge of the road, up to 7 m to the side, have boxes",
    why="A parked car pulls out, and a door opens: both begin next to the lane.",
    hint="Where does your region of interest end to the side?",
)
def looks_to_the_side(detect_obstacles: Callable) -> None:
    _assert_seen_on_the_climb(detect_obstacles, "car")


@visible(
    "detect_obstacles",
    weight=3,
    title="A lorry has a box, although it has many points",
    why="The largest thing on the road is the last one to overlook.",
    hint="filter_clusters has a minimum and no maximum: a cluster of many points is a wall or "
    "a lorry.",
)
def finds_the_lorry(detect_obstacles: Callable) -> None:
    _assert_seen_on_the_climb(detect_obstacles, "truck")


@visible(
    "detect_obstacles",
    weight=3,
    title="Two cars that are parked closely have two boxes",
    why="A single box closes the gap from which a child may run.",
    hint="Two things are one cluster where the threshold is larger than the gap between them.",
)
def keeps_parked_cars_apart(detect_obstacles: Callable) -> None:
    with needs("cars at the edge of the road have boxes"):
        _assert_seen_on_the_climb(detect_obstacles, "car")
    frame = climb(CLIMB_SEED)
    assert_apart(detected(detect_obstacles, frame), frame, GAP)


@visible(
    "detect_obstacles",
    weight=12,
    title="Does not take its own car for an obstacle",
    why="An obstacle at 0 m means full braking, for ever.",
    hint="Call remove_ego_returns with the whole box of the own car, from (-1.5, -1.7, -1.0) to "
    "(2.6, 1.7, -0.4), before anything is averaged or clustered. Here the scanner sees bonnet "
    "and roof from edge to edge.",
)
def forgets_itself(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    answer = detect_obstacles(np.vstack([frame.cloud, own_car(SQUARE_SEED)]))
    assert_sees(answer, frame)
    assert_own_car_free(answer, frame)


@visible(
    "detect_obstacles",
    weight=12,
    title="Boxes turn with the cars",
    why="A car that pulls out of a parking space stands at an angle; a box along the axes "
    "would close the lane beside it.",
    hint="Let get_oriented_boxes of lesson 11 fit the boxes: it turns each with its points, seen "
    "from above.",
)
def turns_boxes(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, square(SQUARE_SEED))
    assert_boxes_turned(detected(detect_obstacles, square(SQUARE_SEED)), square(SQUARE_SEED))


@visible(
    "detect_obstacles",
    weight=2,
    title="Boxes stand upright: a level floor, right angles, a corner above each corner",
    why="Whoever plans a path asks of each corner how high it stands and what lies between.",
    hint="Let the last step be your get_oriented_boxes of lesson 11: it turns about z alone.",
)
def stands_upright(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, square(SQUARE_SEED))
    assert_upright(detected(detect_obstacles, square(SQUARE_SEED)))


@visible(
    "detect_obstacles",
    weight=13,
    title="Single returns in the air, such as drops of rain, are no obstacles",
    why="In a shower the car would stop at every drop.",
    hint="filter_clusters returns new labels, without the clusters of a few points. Are these the "
    "labels that get boxes?",
)
def ignores_rain(detect_obstacles: Callable) -> None:
    frame, drops = square(SQUARE_SEED), rain(SQUARE_SEED)
    answer = detect_obstacles(np.vstack([frame.cloud, drops]))
    assert_sees(answer, frame)
    assert_dry(answer, frame, drops)


@visible(
    "detect_obstacles",
    weight=2,
    title="Copes with returns that are not a number, and hundreds at (0, 0, 0)",
    why="Whatever the scanner loses comes as such a row. A stream has no pause button.",
    hint="Let drop_invalid be the very first step.",
)
def drops_invalid(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    answer = detect_obstacles(with_invalid(frame.cloud, 1))
    assert_sees(answer, frame)
    assert_nothing_at_sensor(answer, frame)


@visible(
    "detect_obstacles",
    weight=1,
    title="Takes an empty scan",
    why="A bad frame must not stop the stream.",
    hint="Return np.empty((0, 8, 3)) as soon as nothing is left, after every filter that can "
    "leave nothing.",
)
def takes_an_empty_scan(detect_obstacles: Callable) -> None:
    assert_cars_seen(detect_obstacles, square(SQUARE_SEED))
    boxes = as_boxes(detect_obstacles(np.empty((0, 4))))
    if len(boxes):
        raise CheckFailed("An empty scan has no obstacles.", yours=f"{len(boxes)} boxes")


@visible(
    "detect_obstacles",
    weight=5,
    title="Takes scans without intensity: three columns",
    why="Not every scanner measures it, and a cloud may come from elsewhere.",
    hint="Use cloud[:, :3] from the start.",
)
def takes_three_columns(detect_obstacles: Callable) -> None:
    frame = square(SQUARE_SEED)
    assert_cars_seen(detect_obstacles, frame)
    assert_cars_found([detect_obstacles(frame.cloud[:, :3].copy())], [frame])


@visible(
    "detect_obstacles",
    weight=1,
    title="Leaves its input untouched",
    why="The next cells score and draw the very cloud that the detector was given.",
    hint="Choose rows with a mask, which makes a new array, and write into none that came in.",
)
def leaves_the_cloud(detect_obstacles: Callable) -> None:
    cloud = square(SQUARE_SEED).cloud.copy()
    cloud[::50, 3] = np.nan  # a function that cleans the cloud in place replaces these
    observed = observe(detect_obstacles, cloud)
    assert_sees(observed.result, square(SQUARE_SEED))
    assert_arguments_unchanged(observed, cloud)


@noted(
    "detect_obstacles",
    title="A road that climbs is not an obstacle",
    why="Where a road climbs by 4 %, one level for the ground leaves the road from 13 m ahead on, "
    "and the car brakes there. A plane through the low points (lesson 03) climbs with the road.",
)
def follows_the_climb(detect_obstacles: Callable) -> None:
    assert_road_free(detected(detect_obstacles, climb(CLIMB_SEED)), climb(CLIMB_SEED))


@noted(
    "detect_obstacles",
    title="Returns an array",
    why="The cells below choose boxes with a mask: a list takes none.",
)
def returns_an_array(detect_obstacles: Callable) -> None:
    for cloud in (street_before().cloud.copy(), np.empty((0, 4))):
        answer = detect_obstacles(cloud)
        if np.shape(answer)[1:] != (8, 3) or not isinstance(answer, np.ndarray):
            raise CheckFailed(
                fixed(
                    "np.array(boxes).reshape(-1, 8, 3) is an array also where there are no boxes."
                ),
                yours=brief(answer),
            )


@noted(
    "detect_obstacles",
    title="The four corners of the floor come first, or those of the roof",
    why="The score card takes the first four for the ground that a box covers.",
)
def has_the_floor_first(detect_obstacles: Callable) -> None:
    for box in as_boxes(detect_obstacles(street_before().cloud.copy())):
        if np.ptp(box[:4, 2]) > 2e-3:
            raise CheckFailed("The first four corners are not at one height.", yours=brief(box))


@noted(
    "detect_obstacles",
    title="Stands in this notebook, with all that it calls",
    why="The judge sees this notebook only. There the detector would find nothing and earn "
    "nothing: paste what it needs into the cells above it.",
)
def stands_alone(detect_obstacles: Callable) -> None:
    if name := _foreign_name(detect_obstacles):
        raise CheckFailed(f"The detector uses {name}, which brings functions of another notebook.")


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
