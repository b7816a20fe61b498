"""Visible checks of lesson 02: `line_through`, `point_line_distance` and `ransac_line`."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.core import visible
from utils.checks.vocabulary import (
    TOLERANCE,
    CheckFailed,
    as_array,
    assert_close,
    assert_untouched,
    brief,
    frozen,
    point_text,
)

# ---- lines -------------------------------------------------------------------------------------


def as_line(answer: object) -> np.ndarray:
    """An answer as the three numbers of a line.

    Parameters
    ----------
    answer : object

    Returns
    -------
    numpy.ndarray, shape (3,)
    """
    if answer is None:
        raise CheckFailed(
            "The function returned None, though the points differ. Does it end with `return`?",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    line = as_array(answer, what="three numbers (a, b, c)").astype(float)
    if line.shape != (3,):
        raise CheckFailed(
            "A line is three numbers (a, b, c).", yours=f"shape {line.shape}", expected="shape (3,)"
        )
    if not np.isfinite(line).all():
        raise CheckFailed(
            "The line holds numbers that are not finite: was something divided by 0?",
            yours=brief(line),
        )
    return line


def assert_line_through(answer: object, p: ArrayLike, q: ArrayLike) -> None:
    """The answer is the line through two different points, with a unit normal of either sign.

    Parameters
    ----------
    answer : object
    p, q : array_like, shape (2,)
    """
    p, q = np.asarray(p, dtype=float), np.asarray(q, dtype=float)
    line = as_line(answer)
    length = np.hypot(line[0], line[1])
    if length < 1e-9:
        raise CheckFailed(
            "The normal (a, b) has length 0: such a line has no direction.", yours=brief(line)
        )

    def draw() -> None:
        utils.plots.line_model(np.array([p, q]), line, title="your line, and its two points")

    values = [line[:2] @ point + line[2] for point in (p, q)]
    for point, value in zip((p, q), values, strict=True):
        if abs(value) > TOLERANCE * length:
            raise CheckFailed(
                f"The line through {point_text(p)} and {point_text(q)} misses "
                f"{point_text(point)} by {abs(value) / length:.2f} m.",
                draw=draw,
                yours=f"a x + b y + c is {values[0]:.2f} and {values[1]:.2f} at the two points",
                expected="0 and 0",
            )
    if abs(length - 1) > TOLERANCE:
        raise CheckFailed(
            "The normal (a, b) must have length 1. Divide it by its length.",
            yours=f"length {length:.3f}",
            expected="length 1",
        )


@visible(
    "line_through",
    weight=3,
    title="Both points lie on the line",
    why="A wall that misses the points it was made from is no wall.",
    hint="The normal is the direction (dx, dy) turned by a quarter: (-dy, dx). Then c is "
    "minus a times x of p minus b times y of p.",
)
def passes_through_both(line_through: Callable) -> None:
    for p, q in (
        ((0.0, 1.0), (4.0, 1.0)),
        ((1.0, 2.0), (4.0, 6.0)),
        ((-3.0, 5.0), (2.0, -7.0)),
        ((8.0, 8.0), (2.0, 2.0)),
    ):
        line = as_line(line_through(np.array(p), np.array(q)))
        length = max(np.hypot(line[0], line[1]), 1e-12)
        # The length of the normal is a matter for the next check.
        assert_line_through(line / length, p, q)


@visible(
    "line_through",
    weight=2,
    title="The normal has length 1",
    why="Only then does the equation measure metres.",
    hint="np.hypot(dx, dy) is the length of the direction, and of the normal, too.",
)
def has_a_unit_normal(line_through: Callable) -> None:
    for p, q in (((0.0, 0.0), (3.0, 4.0)), ((5.0, -1.0), (-7.0, 4.0)), ((0.1, 0.1), (0.4, 0.5))):
        assert_line_through(line_through(np.array(p), np.array(q)), p, q)


@visible(
    "line_through",
    weight=2,
    title="Upright and level lines are lines like any others",
    why="The wall straight ahead is an upright line, and the one that matters most.",
    hint="Do not compute a slope: dy / dx has no answer where dx is 0.",
)
def takes_upright_lines(line_through: Callable) -> None:
    for p, q in (
        ((2.0, -3.0), (2.0, 4.0)),
        ((2.0, 4.0), (2.0, -3.0)),
        ((-5.0, 1.5), (3.0, 1.5)),
        ((0.0, 2.0), (0.0, 5.0)),
    ):
        assert_line_through(line_through(np.array(p), np.array(q)), p, q)


@visible(
    "line_through",
    weight=2,
    title="Equal points give None",
    why="RANSAC draws such pairs now and then, and must be able to tell.",
    hint="Test the length before you divide by it, and return None where it is 0.",
)
def refuses_equal_points(line_through: Callable) -> None:
    assert_line_through(line_through(np.array([1.0, 2.0]), np.array([1.0, 3.0])), (1, 2), (1, 3))
    for point in ([0.0, 0.0], [3.0, -2.0]):
        answer = line_through(np.array(point), np.array(point))
        if answer is not None:
            raise CheckFailed(
                f"Through {point_text(point)} and {point_text(point)} run many lines, so "
                "there is no answer but None.",
                yours=brief(answer),
                expected="None",
            )


@visible(
    "line_through",
    weight=1,
    title="Leaves its input untouched",
    why="p and q are rows of the points that the next round needs.",
    hint="q -= p writes into q; dx = q[0] - p[0] does not.",
)
def leaves_the_points(line_through: Callable) -> None:
    p, q = np.array([1.0, 2.0]), np.array([4.0, 6.0])
    assert_untouched(line_through, p, q)
    assert_line_through(line_through(p.copy(), q.copy()), p, q)


# ---- distances ---------------------------------------------------------------------------------

# Points around the line 3 x - 4 y + 5 = 0, and their signed distances from it.
_SLANTED = frozen(np.array([0.6, -0.8, 1.0]))
_AROUND = frozen(
    np.array([[1.0, 2.0], [0.0, 0.0], [3.0, 1.0], [-2.0, 6.0], [5.0, 5.0], [0.0, 1.25]])
)
_SIGNED = frozen(np.array([0.0, 1.0, 2.0, -5.0, 0.0, 0.0]))


def assert_line_distances(
    answer: object, points: np.ndarray, line: np.ndarray, expected: np.ndarray
) -> None:
    """The answer is `expected`; where it is a well-known other number, say which.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2)
    line : numpy.ndarray, shape (3,)
    expected : numpy.ndarray, shape (n,)
        Distances in metres.
    """
    yours = as_array(answer, what="an array of distances")
    if yours.shape != expected.shape:
        raise CheckFailed(
            f"There must be one distance for each of the {len(points)} points. x "
            "of every point is points[:, 0]; points[0] is the first point.",
            yours=f"shape {yours.shape}",
            expected=f"shape {expected.shape}",
        )
    if np.allclose(yours, expected, rtol=0, atol=TOLERANCE):
        return
    a, b, c = (float(value) for value in line)
    if np.allclose(np.abs(yours), expected, rtol=0, atol=TOLERANCE):
        raise CheckFailed(
            "Distances on one side of the line are negative: the absolute value is missing.",
            yours=brief(yours),
            expected=brief(expected),
        )
    without_c = np.abs(a * points[:, 0] + b * points[:, 1])
    mistakes = {
        "These are distances from the parallel line through (0, 0): c is missing.": without_c,
        "The sign of c is wrong: the line is a x + b y + c = 0.": np.abs(
            a * points[:, 0] + b * points[:, 1] - c
        ),
        "These are squared distances.": expected**2,
    }
    if abs(b) > 1e-6:
        mistakes["These are distances straight up and down, not square to the line."] = (
            expected / abs(b)
        )
    for sentence, numbers in mistakes.items():
        if np.allclose(yours, numbers, rtol=0, atol=TOLERANCE):
            raise CheckFailed(sentence, yours=brief(yours), expected=brief(expected))
    assert_close(yours, expected, "distances")


@visible(
    "point_line_distance",
    weight=3,
    title="Distances in metres, square to the line",
    why="The tolerance of RANSAC is compared with them.",
    hint="a x + b y + c for all points at once, with points[:, 0] for x and points[:, 1] for y.",
)
def measures_square_to_the_line(point_line_distance: Callable) -> None:
    one_side = _SIGNED >= 0
    assert_line_distances(
        point_line_distance(_AROUND[one_side], _SLANTED.copy()),
        _AROUND[one_side],
        _SLANTED,
        _SIGNED[one_side],
    )


@visible(
    "point_line_distance",
    weight=3,
    title="Never negative, on whichever side a point lies",
    why="Without that, a whole half of the street is within any tolerance.",
    hint="np.abs takes the absolute value of a whole array.",
)
def takes_both_sides(point_line_distance: Callable) -> None:
    for sign in (1, -1):
        assert_line_distances(
            point_line_distance(_AROUND.copy(), sign * _SLANTED),
            _AROUND,
            sign * _SLANTED,
            np.abs(_SIGNED),
        )


@visible(
    "point_line_distance",
    weight=2,
    title="Upright and level lines are lines like any others",
    why="The wall straight ahead is an upright line.",
    hint="The formula needs no slope and no division.",
)
def measures_from_upright_lines(point_line_distance: Callable) -> None:
    for line, column, place in (
        ((1.0, 0.0, -2.0), 0, 2.0),
        ((-1.0, 0.0, 2.0), 0, 2.0),
        ((0.0, 1.0, 3.0), 1, -3.0),
    ):
        line = np.array(line)
        assert_line_distances(
            point_line_distance(_AROUND.copy(), line.copy()),
            _AROUND,
            line,
            np.abs(_AROUND[:, column] - place),
        )


@visible(
    "point_line_distance",
    weight=1,
    title="Takes one point and no point at all",
    why="A slice of the street may be empty.",
    hint="Whole columns do it all: no loop over the points and no special case is needed.",
)
def takes_few_points(point_line_distance: Callable) -> None:
    for points, expected in ((_AROUND[3:4], [5.0]), (_AROUND[:0], [])):
        assert_line_distances(
            point_line_distance(points.copy(), _SLANTED.copy()),
            points,
            _SLANTED,
            np.array(expected),
        )


@visible(
    "point_line_distance",
    weight=1,
    title="Leaves its input untouched",
    why="The next round of RANSAC needs the points as they were.",
    hint="points[:, 0] * a makes a new array; points[:, 0] *= a writes into the points.",
)
def leaves_points_and_line(point_line_distance: Callable) -> None:
    assert_untouched(point_line_distance, _AROUND, _SLANTED)
    answer = point_line_distance(_AROUND.copy(), _SLANTED.copy())
    assert_line_distances(answer, _AROUND, _SLANTED, np.abs(_SIGNED))


# ---- RANSAC ------------------------------------------------------------------------------------


def as_result(answer: object, n: int) -> tuple[np.ndarray | None, np.ndarray]:
    """An answer as (line or None, mask).

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    line : numpy.ndarray, shape (3,), or None
    inliers : numpy.ndarray of bool, shape (n,)
    """
    if answer is None:
        raise CheckFailed(
            "The function returned None. Does it end with `return line, inliers`?",
            yours="None",
            expected="a pair (line, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise CheckFailed(
            "The function must return two things, the line and the mask.",
            yours=brief(answer),
            expected="a pair (line, inliers)",
        )
    line, inliers = answer
    if inliers is None:
        raise CheckFailed(
            "The second result, the mask, is None.",
            yours="None",
            expected=f"{n} times True or False",
        )
    mask = as_array(inliers, what="a mask of True and False")
    if mask.shape == (3,) and n != 3 and isinstance(line, np.ndarray) and line.shape == (n,):
        raise CheckFailed(
            "The two results are in the wrong order: first the line, then the mask.",
            yours="(mask, line)",
            expected="(line, mask)",
        )
    if mask.size == 0:
        mask = mask.reshape(-1)
    if mask.shape != (n,) or not np.isin(mask, (0, 1)).all():
        raise CheckFailed(
            f"The inliers must be a mask: True or False for each of the {n} points. "
            "Are these the indices of the inliers, or the points themselves?",
            yours=brief(mask),
            expected=f"shape ({n},), dtype bool",
        )
    mask = mask.astype(bool)
    return (None if line is None else as_line(line)), mask


def assert_own_inliers(
    answer: object, points: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """The mask holds the points within the tolerance of the line that comes with it.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 2)
    tolerance : float
        In metres.

    Returns
    -------
    line : numpy.ndarray, shape (3,)
    inliers : numpy.ndarray of bool, shape (n,)
    """
    line, mask = as_result(answer, len(points))
    if line is None:
        raise CheckFailed(
            "There is no line, though the points differ: was the same point drawn twice?",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    length = np.hypot(line[0], line[1])
    if length < 1e-9:
        raise CheckFailed(
            "The normal (a, b) has length 0: such a line has no direction.", yours=brief(line)
        )
    flat = np.asarray(points, dtype=float)
    distance = np.abs(flat @ line[:2] + line[2]) / length
    # Floats differ in the last digits: at the very edge of the band either answer is right.
    wrong = (mask != (distance <= tolerance)) & (np.abs(distance - tolerance) > TOLERANCE)
    if not wrong.any():
        return line, mask
    near, far = wrong & ~mask, wrong & mask
    parts = []
    if near.any():
        parts.append(f"within {tolerance:g} m of the line but not marked: {near.sum()}")
    if far.any():
        parts.append(f"marked but farther away than {tolerance:g} m: {far.sum()}")
    raise CheckFailed(
        "The mask does not belong to the line. Points " + ", and ".join(parts) + ".",
        yours=f"{mask.sum()} inliers",
        expected=f"{(distance <= tolerance).sum()} inliers",
        draw=lambda: utils.plots.line_model(
            flat, line, mask, tolerance, title="your line, its band, and your inliers"
        ),
    )


def wall_and_clutter(
    seed: int | Sequence[int], inliers: int, others: int, noise: float = 0.1
) -> tuple[np.ndarray, np.ndarray]:
    """Points about a line in any direction, and others at least 1 m off; and who is who.

    Parameters
    ----------
    seed : int or sequence of int
    inliers, others : int
        Number of points about the line, and off it.
    noise : float
        How far points about the line are off it at most, in metres.

    Returns
    -------
    points : numpy.ndarray, shape (inliers + others, 2)
        Within about 10 m of the origin.
    on_line : numpy.ndarray of bool
    """
    rng = np.random.default_rng(seed)
    angle, offset = rng.uniform(0, np.pi), rng.uniform(-3, 3)
    along = np.array([np.cos(angle), np.sin(angle)])
    normal = np.array([-along[1], along[0]])
    wall = np.outer(rng.uniform(-10, 10, inliers), along)
    wall += np.outer(offset + rng.uniform(-noise, noise, inliers), normal)
    clutter = rng.uniform(-10, 10, (others, 2))
    aside = clutter @ normal - offset
    push = np.where(np.abs(aside) < 1, np.where(aside < 0, -1.0, 1.0), 0.0)
    points = np.vstack([wall, clutter + np.outer(push, normal)])
    order = rng.permutation(len(points))
    return points[order], (np.arange(len(points)) < inliers)[order]


def assert_finds(
    ransac_line: Callable,
    runs: Sequence[tuple[np.ndarray, np.ndarray]],
    needed: int,
    max_iterations: int,
    tolerance: float,
) -> None:
    """In at least `needed` of the runs most of the line is found.

    Parameters
    ----------
    ransac_line : callable
    runs : sequence of (points, on_line)
        As from `wall_and_clutter`.
    needed, max_iterations : int
    tolerance : float
        In metres.
    """
    missed = []
    for seed, (points, on_line) in enumerate(runs):
        line, mask = assert_own_inliers(
            ransac_line(points.copy(), max_iterations, tolerance, np.random.default_rng(seed)),
            points,
            tolerance,
        )
        if mask[on_line].sum() < 0.8 * on_line.sum():
            missed.append((points, line, mask))
    if len(runs) - len(missed) < needed:
        raise CheckFailed(
            f"The line was found in {len(runs) - len(missed)} of {len(runs)} runs; with "
            f"{max_iterations} iterations nearly all of them should find it. Is the best line "
            "kept, the one with the most inliers?",
            yours=f"{len(runs) - len(missed)} of {len(runs)}",
            expected=f"at least {needed}",
            draw=lambda: utils.plots.line_model(
                *missed[0], tolerance, title="a run that missed the line"
            ),
        )


@visible(
    "ransac_line",
    weight=5,
    title="Finds the line in a crowd",
    why="This is what it is for: the wall behind the people, and in lesson 03 the road.",
    hint="After each round compare the number of inliers with the best so far, and keep line "
    "and mask where it is larger. Return after the loop.",
)
def finds_the_line(ransac_line: Callable) -> None:
    assert_finds(ransac_line, [wall_and_clutter(seed, 24, 16) for seed in range(12)], 8, 60, 0.4)


@visible(
    "ransac_line",
    weight=3,
    title="The mask belongs to the line, for any tolerance, given by position or by name",
    why="The inliers go into the map, and the line to the steering: they must say the same.",
    hint="Keep line and mask together. Compare the distance itself with "
    "distance_tolerance, not its square.",
)
def marks_its_own_inliers(ransac_line: Callable) -> None:
    for seed, tolerance in enumerate((0.1, 0.4, 0.7, 2.5)):
        rng = np.random.default_rng(seed)
        # So rough a wall that any change of the line moves points into the band or out of it.
        points, _ = wall_and_clutter(100 + seed, 30, 10, noise=0.8)
        assert_own_inliers(ransac_line(points.copy(), 30, tolerance, rng), points, tolerance)
    answer = ransac_line(points=points.copy(), max_iterations=30, distance_tolerance=0.7, rng=rng)
    assert_own_inliers(answer, points, 0.7)
    # Any line has a mask of its own; it should be a line that was looked for.
    assert_finds(ransac_line, [wall_and_clutter(200 + run, 24, 16) for run in range(6)], 4, 60, 0.4)


@visible(
    "ransac_line",
    weight=2,
    title="Draws as many samples as max_iterations says",
    why="Ten rounds must take the time of ten rounds, and a hard street needs more.",
    hint="Loop with range(max_iterations). One sample of two points is one iteration.",
)
def draws_as_often_as_told(ransac_line: Callable) -> None:
    points, on_line = wall_and_clutter(7, 14, 46)  # a good sample: 1 in 25
    found = 0
    for seed in range(24):
        rng = np.random.default_rng(seed)
        _, mask = assert_own_inliers(ransac_line(points.copy(), 1, 0.3, rng), points, 0.3)
        found += mask[on_line].mean() >= 0.8
    if found >= 20:
        raise CheckFailed(
            "With max_iterations=1 the line was found nearly every time, though a "
            "single sample of two points is rarely a good one: were there more "
            "samples than that?",
            yours=f"{found} of 24 runs",
            expected="about 1 of 24 runs",
        )
    assert_finds(ransac_line, [(points, on_line)] * 12, 8, 250, 0.3)


@visible(
    "ransac_line",
    weight=2,
    title="All randomness comes from rng: the same seed, the same answer",
    why="A run that went wrong at night must be repeatable by day.",
    hint="Draw with the rng that the first line of the function makes, not with np.random "
    "or the module random.",
)
def repeats_with_its_seed(ransac_line: Callable) -> None:
    points, _ = wall_and_clutter(3, 20, 20)
    masks = []
    for seed in range(20):
        once, again = (
            assert_own_inliers(ransac_line(points.copy(), 1, 0.4, rng), points, 0.4)
            for rng in (np.random.default_rng(seed), np.random.default_rng(seed))
        )
        if not (np.allclose(once[0], again[0]) and np.array_equal(once[1], again[1])):
            raise CheckFailed(
                "The same seed gave two different answers.",
                yours=f"{once[1].sum()} and {again[1].sum()} inliers",
                expected="twice the same",
            )
        masks.append(once[1].tobytes())
    if len(set(masks)) == 1:
        raise CheckFailed(
            "20 different seeds gave 20 times the same sample: is a seed written "
            "into the function, or nothing drawn at all?",
            yours="1 answer",
            expected="about 20 different ones",
        )


@visible(
    "ransac_line",
    weight=2,
    title="Survives samples of equal points",
    why="Recordings hold the same point twice, or a thousand times when a beam is blocked.",
    hint="line_through answers None for them: go on with the next round then.",
)
def survives_equal_points(ransac_line: Callable) -> None:
    wall, _ = wall_and_clutter(11, 12, 0)
    points = np.vstack([np.tile([[2.0, 9.0]], (28, 1)), wall])
    for seed in range(4):
        rng = np.random.default_rng(seed)
        assert_own_inliers(ransac_line(points.copy(), 40, 0.3, rng), points, 0.3)
    twice = [wall_and_clutter(300 + run, 14, 7) for run in range(6)]
    twice = [(np.repeat(points, 2, axis=0), np.repeat(on_line, 2)) for points, on_line in twice]
    assert_finds(ransac_line, twice, 4, 60, 0.3)
    alike = np.tile([[2.0, 9.0]], (6, 1))
    line, mask = as_result(ransac_line(alike.copy(), 20, 0.3, np.random.default_rng(0)), 6)
    if line is not None:
        assert_own_inliers((line, mask), alike, 0.3)
    elif mask.any():
        raise CheckFailed(
            "Without a line there are no inliers.",
            yours=f"{mask.sum()} inliers",
            expected="(None, all False)",
        )


@visible(
    "ransac_line",
    weight=2,
    title="Answers (None, all False) for fewer than two points",
    why="A slice of the street may be empty. The car must not stop for that.",
    hint="Ask len(points) < 2 before the loop.",
)
def answers_for_too_few(ransac_line: Callable) -> None:
    points, on_line = wall_and_clutter(5, 30, 3)
    assert_finds(ransac_line, [(points, on_line)] * 6, 3, 40, 0.4)
    for few in (points[:0], points[:1]):
        line, mask = as_result(ransac_line(few.copy(), 10, 0.3, np.random.default_rng(0)), len(few))
        if line is not None or mask.any():
            raise CheckFailed(
                f"{len(few)} points make no line.",
                yours=brief((line, mask)),
                expected="(None, all False)",
            )


@visible(
    "ransac_line",
    weight=1,
    title="Leaves its input untouched",
    why="The next wall is searched among the same points.",
    hint="Draw indices instead of shuffling the points.",
)
def leaves_its_input(ransac_line: Callable) -> None:
    points, on_line = wall_and_clutter(6, 20, 10)
    assert_untouched(ransac_line, points, 30, 0.4, np.random.default_rng(2))
    assert_finds(ransac_line, [(points, on_line)] * 6, 3, 40, 0.4)


@visible(
    "ransac_line",
    weight=1,
    title="rng may be a whole number, too: a seed",
    why="A seed fits into a log file; a generator does not.",
    hint="Begin with rng = np.random.default_rng(rng): it makes a generator of a whole number, "
    "and leaves a generator as it is.",
)
def takes_a_seed(ransac_line: Callable) -> None:
    points, _ = wall_and_clutter(8, 20, 20)
    for seed in range(4):
        once, again = (
            assert_own_inliers(ransac_line(points.copy(), 2, 0.4, seed), points, 0.4)
            for _ in range(2)
        )
        if not np.array_equal(once[1], again[1]):
            raise CheckFailed(
                "The same seed gave two different answers.",
                yours=f"{once[1].sum()} and {again[1].sum()} inliers",
                expected="twice the same",
            )
    found = 0
    for seed in range(4):
        points, on_line = wall_and_clutter(400 + seed, 24, 12)
        _, mask = assert_own_inliers(ransac_line(points.copy(), 80, 0.4, seed), points, 0.4)
        found += mask[on_line].mean() >= 0.8
    if found < 3:
        raise CheckFailed(
            "With a whole number for rng the line was hardly ever found.",
            yours=f"found in {found} of 4 runs",
            expected="as often as with a generator",
        )
