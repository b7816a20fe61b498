"""Visible checks of `snuggest_turn`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    assert_arguments_unchanged,
    brief,
    frozen,
    needs,
    observe,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.words import COMPILES_TITLE, COMPILES_WHY

_TURNS = frozen(np.arange(90))


def _rectangle(turn: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    """Return eight points on a rectangle of 4 m by 2 m that is turned by `turn` degrees."""
    sides = np.array([2 + 1j, -2 + 1j, -2 - 1j, 2 - 1j, 0.3 + 1j, -2 + 0.4j, 1.1 - 1j, 2 + 0.2j])
    places = sides * np.exp(1j * np.radians(turn)) + x + 1j * y
    heights = [0.2, 1.4, 0.7, 1.1, 0.1, 0.9, 0.3, 1.3]
    return np.column_stack([places.real, places.imag, heights])


def _extents(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the extents of points in metres, along and across each of the 90 directions."""
    places = points[:, 0] + 1j * points[:, 1]
    turned = places[:, None] * np.exp(-1j * np.radians(_TURNS))
    return np.ptp(turned.real, axis=0), np.ptp(turned.imag, axis=0)


def _area(points: np.ndarray) -> np.ndarray:
    along, across = _extents(points)
    return along * across


def _answer_of(snuggest_turn: Callable, points: np.ndarray) -> int:
    """Return the answer of the function: the index of an angle, 0 to 89."""
    yours = float(assert_number(snuggest_turn(points.copy())))
    if yours not in _TURNS:
        raise WrongForm(
            "This is no number of a turn.",
            yours=f"{yours:g}",
            expected="a whole number from 0 to 89: the place of the least area, by argmin()",
        )
    return int(yours)


def _assert_finds_turn(snuggest_turn: Callable, turn: int, x: float = 0.0, y: float = 0.0) -> None:
    points = _rectangle(turn, x, y)
    yours = _answer_of(snuggest_turn, points)
    if yours != turn % 90:
        area = _area(points)
        raise CheckFailed(
            "At this turn the rectangle is not the least.",
            given=f"a rectangle of 4 by 2 m around ({x:g}, {y:g}) that leans by {turn}°",
            yours=f"{yours}, with {area[yours]:.2f} m²",
            expected=f"{turn % 90}, with {area[turn % 90]:.2f} m²",
        )


@visible(
    "snuggest_turn",
    title="A rectangle that leans by so much gives its turn",
    why="The turn is the yaw of the box: a box that leans otherwise is larger than the car.",
    hint="For each point and each turn: along = x * cosines[turn] + y * sines[turn], across = y * "
    "cosines[turn] - x * sines[turn]. Keep the smallest and the largest of both.",
)
def finds_the_lean(snuggest_turn: Callable) -> None:
    for turn in (30, 72, 11, 146):
        _assert_finds_turn(snuggest_turn, turn)


@visible(
    "snuggest_turn",
    title="The same away from the sensor",
    why="No car stands around the sensor, but our own.",
    hint="Before the first point the smallest is np.inf and the largest -np.inf: 0 would count as "
    "a point at the sensor.",
)
def finds_it_anywhere(snuggest_turn: Callable) -> None:
    with needs("a rectangle around the sensor gives its turn"):
        finds_the_lean(snuggest_turn)
    for turn, x, y in ((30, 12, -7), (72, -9, -14), (104, 21, 3)):
        _assert_finds_turn(snuggest_turn, turn, x, y)


def _random_points(seed: int) -> np.ndarray:
    """Return nine points at a random place, slightly wider in one direction than in the other."""
    rng = np.random.default_rng(seed)
    places = (rng.normal(size=(9, 2)) * [2.0, 1.4]) @ [1, 1j] * np.exp(1j * rng.uniform(0, np.pi))
    points = np.column_stack([places.real, places.imag, rng.normal(size=9)])
    return points + rng.uniform(-12, 12, 3)


@visible(
    "snuggest_turn",
    title="Of any points, the turn of least area",
    why="Of a car the scanner sees two sides and a mirror, and no rectangle.",
    hint="The area is a product, of largest minus smallest along and across, for all 90 turns at "
    "once: ((front - back) * (left - right)).",
)
def finds_the_least(snuggest_turn: Callable) -> None:
    with needs("a rectangle gives its turn, wherever it is"):
        finds_it_anywhere(snuggest_turn)
    for seed in (2, 6, 22, 24, 45, 47):  # here the smallest perimeter is at another turn
        points = _random_points(seed)
        yours, area = _answer_of(snuggest_turn, points), _area(points)
        if area[yours] > area.min() * (1 + 1e-9):
            raise CheckFailed(
                "At another turn the rectangle is smaller.",
                given=f"nine points, x {brief(points[:, 0])}, y {brief(points[:, 1])}",
                yours=f"{yours}, with {area[yours]:.2f} m²",
                expected=f"{area.argmin()}, with {area.min():.2f} m²",
            )


@visible(
    "snuggest_turn",
    title="Takes a single point",
    why="Some clusters are one return: any turn is right there, and no turn is a crash.",
    hint="No special case is needed: each area is 0, and argmin() takes the first.",
)
def takes_one_point(snuggest_turn: Callable) -> None:
    _answer_of(snuggest_turn, _rectangle(20, 5, 3)[:1])


@visible(
    "snuggest_turn",
    title="Leaves the points as they are",
    why="They are drawn after this, where they are.",
    hint="x, y = points[i, 0], points[i, 1], and variables of their own for what is computed.",
)
def leaves_the_cluster(snuggest_turn: Callable) -> None:
    points = _rectangle(20, 5, 3)
    assert_arguments_unchanged(observe(snuggest_turn, points), points)


@noted("snuggest_turn", title=COMPILES_TITLE, why=COMPILES_WHY)
def snuggest_turn_compiles(snuggest_turn: Callable) -> None:
    points = _rectangle(30, 12, -7)
    assert_compiles(snuggest_turn, lambda function: int(function(points)))


def _minimises(measure: Callable) -> Callable:
    """Return the prediction of the turn at which another measure is least."""
    return lambda right, points: int(measure(points).argmin())


def _with_sensor(points: np.ndarray) -> np.ndarray:
    return np.vstack([np.zeros(3), points])


mistakes(
    "snuggest_turn",
    Mistake(
        "It is the turn of the largest area.",
        lambda right, points: int(_area(points).argmax()),
        "argmin(), not argmax().",
    ),
    Mistake(
        "The sum of the two sides is least there, and not their product.",
        _minimises(lambda points: sum(_extents(points))),
        "An area is a product.",
    ),
    Mistake(
        "Only the extent along each direction is measured.",
        _minimises(lambda points: _extents(points)[0]),
        "Multiply it by the extent across the direction.",
    ),
    Mistake(
        "Only what lies across each direction is measured.",
        _minimises(lambda points: _extents(points)[1]),
        "The area is that times what lies along.",
    ),
    Mistake(
        "The sensor counts as a point: smallest and largest begin at 0.",
        _minimises(lambda points: _area(_with_sensor(points))),
        "np.full(90, np.inf) for the smallest, np.full(90, -np.inf) for the largest.",
    ),
    Mistake(
        "It turns the other way: the signs of both sines are exchanged.",
        _minimises(lambda points: _area(points * [1, -1, 1])),
        "along is x cos + y sin, across is y cos - x sin.",
    ),
    Mistake(
        "z is taken for y.",
        _minimises(lambda points: _area(points[:, [0, 2, 1]])),
        "The box is turned on the ground: points[i, 1] is y.",
    ),
    Mistake(
        "It returns the area, and not the number of its turn.",
        lambda right, points: float(_area(points).min()),
        "argmin() gives the place of the least, min() the least itself.",
    ),
    Mistake(
        "The turn is returned in radians.",
        lambda right, points: float(np.radians(right)),
        "The number of the turn, from 0 to 89, is what is asked for.",
    ),
    Mistake(
        "The last point is never looked at.",
        _minimises(lambda points: _area(points[:-1])),
        "range(len(points)) ends before len(points) by itself.",
    ),
    cases=tuple((frozen(_random_points(seed)),) for seed in (4, 13, 19, 28, 43, 46, 51, 57)),
    right=lambda points: int(_area(points).argmin()),
)
