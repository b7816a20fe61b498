"""Visible checks of `snuggest_turn`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    assert_arguments_unchanged,
    brief_text,
    frozen,
    observe,
    precondition,
)
from utils.checks.compiled import assert_compiles
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.compile_note import COMPILES_TITLE, COMPILES_WHY

_TURNS = frozen(np.arange(90))


def _rectangle(turn: float, x: float = 0.0, y: float = 0.0) -> np.ndarray:
    """Return eight points on a rectangle of 4 m by 2 m that is turned by `turn` degrees."""
    sides = np.array([2 + 1j, -2 + 1j, -2 - 1j, 2 - 1j, 0.3 + 1j, -2 + 0.4j, 1.1 - 1j, 2 + 0.2j])
    places = sides * np.exp(1j * np.radians(turn)) + x + 1j * y
    heights = [0.2, 1.4, 0.7, 1.1, 0.1, 0.9, 0.3, 1.3]
    return np.column_stack([places.real, places.imag, heights])


def _extents(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the extents of points (m) along and across each of the 90 directions, both (90,)."""
    places = points[:, 0] + 1j * points[:, 1]
    turned = places[:, None] * np.exp(-1j * np.radians(_TURNS))
    return np.ptp(turned.real, axis=0), np.ptp(turned.imag, axis=0)


def _area(points: np.ndarray) -> np.ndarray:
    along, across = _extents(points)
    return along * across


def _answer_of(snuggest_turn: Callable, points: np.ndarray) -> int:
    """Return the function's answer: the index of the angle in the search grid, 0 to 89."""
    yours = float(assert_number(snuggest_turn(points.copy())))
    if yours not in _TURNS:
        raise WrongForm(
            "The answer is not the index of an angle.",
            yours=f"{yours:g}",
            expected="a whole number from 0 to 89: the index of the smallest area, from argmin()",
        )
    return int(yours)


def _assert_finds_turn(snuggest_turn: Callable, turn: int, x: float = 0.0, y: float = 0.0) -> None:
    points = _rectangle(turn, x, y)
    yours = _answer_of(snuggest_turn, points)
    if yours != turn % 90:
        area = _area(points)
        raise CheckFailed(
            "The rectangle at this angle is not the smallest.",
            input_text=f"a rectangle of 4 by 2 m around ({x:g}, {y:g}), turned by {turn}°",
            yours=f"{yours}, with {area[yours]:.2f} m²",
            expected=f"{turn % 90}, with {area[turn % 90]:.2f} m²",
        )


@visible_check(
    "snuggest_turn",
    title="Finds the angle of a rectangle around the sensor",
    why="The angle becomes the yaw of the box. At a wrong angle the box is larger than the car.",
    hint="For each point and each turn, compute along = x * cosines[turn] + y * sines[turn] and "
    "across = y * cosines[turn] - x * sines[turn]. Keep the smallest and the largest of both.",
)
def finds_the_angle(snuggest_turn: Callable) -> None:
    for turn in (30, 72, 11, 146):
        _assert_finds_turn(snuggest_turn, turn)


@visible_check(
    "snuggest_turn",
    title="Finds the angle of a rectangle that is far from the sensor",
    why="The sensor is never inside another car, so a box that includes the sensor is too large.",
    hint="Start with np.inf for the smallest and -np.inf for the largest. If you start with 0, "
    "the sensor counts as a point.",
)
def finds_the_angle_anywhere(snuggest_turn: Callable) -> None:
    with precondition("the function finds the angle of a rectangle around the sensor"):
        finds_the_angle(snuggest_turn)
    for turn, x, y in ((30, 12, -7), (72, -9, -14), (104, 21, 3)):
        _assert_finds_turn(snuggest_turn, turn, x, y)


def _random_points(seed: int) -> np.ndarray:
    """Return nine random points that are spread slightly wider in one direction than across it."""
    rng = np.random.default_rng(seed)
    places = (rng.normal(size=(9, 2)) * [2.0, 1.4]) @ [1, 1j] * np.exp(1j * rng.uniform(0, np.pi))
    points = np.column_stack([places.real, places.imag, rng.normal(size=9)])
    return points + rng.uniform(-12, 12, 3)


@visible_check(
    "snuggest_turn",
    title="Finds the angle of the smallest area for any points",
    why="The scanner sees two sides and a mirror of a car, which do not form a rectangle.",
    hint="Compute the area for all 90 turns at once: (largest minus smallest along) times "
    "(largest minus smallest across).",
)
def finds_the_smallest_area(snuggest_turn: Callable) -> None:
    with precondition("the function finds the angle of a rectangle wherever it is"):
        finds_the_angle_anywhere(snuggest_turn)
    for seed in (2, 6, 22, 24, 45, 47):  # here the smallest perimeter is at another angle
        points = _random_points(seed)
        yours, area = _answer_of(snuggest_turn, points), _area(points)
        if area[yours] > area.min() * (1 + 1e-9):
            raise CheckFailed(
                "The rectangle is smaller at another angle.",
                input_text=f"nine points, x {brief_text(points[:, 0])}, "
                f"y {brief_text(points[:, 1])}",
                yours=f"{yours}, with {area[yours]:.2f} m²",
                expected=f"{area.argmin()}, with {area.min():.2f} m²",
            )


@visible_check(
    "snuggest_turn",
    title="Works on a single point",
    why="Some clusters are a single return. Any angle is right for them, but the function must "
    "not fail.",
    hint="Use the same code for a single point: each area is 0, and argmin() returns the first "
    "index.",
)
def works_on_one_point(snuggest_turn: Callable) -> None:
    _answer_of(snuggest_turn, _rectangle(20, 5, 3)[:1])


@visible_check(
    "snuggest_turn",
    title="Does not change the points",
    why="The next step fits a box around the same points.",
    hint="Write x, y = points[i, 0], points[i, 1], and store results in new variables.",
)
def keeps_the_points_unchanged(snuggest_turn: Callable) -> None:
    points = _rectangle(20, 5, 3)
    assert_arguments_unchanged(observe(snuggest_turn, points), points)


@note_check("snuggest_turn", title=COMPILES_TITLE, why=COMPILES_WHY)
def snuggest_turn_compiles(snuggest_turn: Callable) -> None:
    points = _rectangle(30, 12, -7)
    assert_compiles(snuggest_turn, lambda function: int(function(points)))


def _prediction_from_measure(measure: Callable) -> Callable:
    """Return a function that predicts the angle at which another measure is smallest."""
    return lambda right, points: int(measure(points).argmin())


def _add_sensor(points: np.ndarray) -> np.ndarray:
    return np.vstack([np.zeros(3), points])


declare_mistakes(
    "snuggest_turn",
    Mistake(
        "The function returns the index of the largest area.",
        lambda right, points: int(_area(points).argmax()),
        "Use argmin(), not argmax().",
    ),
    Mistake(
        "The function minimises the sum of the two sides instead of their product.",
        _prediction_from_measure(lambda points: sum(_extents(points))),
        "Find the smallest area, which is the product of the two sides.",
    ),
    Mistake(
        "The function measures only the extent along each direction, not the area.",
        _prediction_from_measure(lambda points: _extents(points)[0]),
        "Multiply the extent along each direction by the extent across it.",
    ),
    Mistake(
        "The function measures only the extent across each direction, not the area.",
        _prediction_from_measure(lambda points: _extents(points)[1]),
        "Multiply the extent across each direction by the extent along it.",
    ),
    Mistake(
        "The sensor counts as a point, because smallest and largest start at 0.",
        _prediction_from_measure(lambda points: _area(_add_sensor(points))),
        "Start with np.full(90, np.inf) for the smallest and np.full(90, -np.inf) for the largest.",
    ),
    Mistake(
        "The code turns the points the wrong way, because both sines have the wrong sign.",
        _prediction_from_measure(lambda points: _area(points * [1, -1, 1])),
        "Compute along as x cos + y sin, and across as y cos - x sin.",
    ),
    Mistake(
        "The function uses z instead of y.",
        _prediction_from_measure(lambda points: _area(points[:, [0, 2, 1]])),
        "The box turns on the ground, so use y, which is points[i, 1].",
    ),
    Mistake(
        "The function returns the smallest area instead of the index of its angle.",
        lambda right, points: float(_area(points).min()),
        "Use argmin(), which returns the index of the smallest area. min() returns the area "
        "itself.",
    ),
    Mistake(
        "The function returns the angle in radians. It should return the index of the angle.",
        lambda right, points: float(np.radians(right)),
        "Return the index of the angle, from 0 to 89.",
    ),
    Mistake(
        "The loop never reads the last point.",
        _prediction_from_measure(lambda points: _area(points[:-1])),
        "Use range(len(points)), which already ends before len(points).",
    ),
    cases=tuple((frozen(_random_points(seed)),) for seed in (4, 13, 19, 28, 43, 46, 51, 57)),
    right=lambda points: int(_area(points).argmin()),
)
