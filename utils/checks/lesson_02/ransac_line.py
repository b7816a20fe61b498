"""Visible checks of `ransac_line`."""

from collections.abc import Callable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    TOLERANCE,
    CheckFailed,
    as_array,
    brief_text,
    frozen,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.failures import NotYet, fixed
from utils.checks.lesson_02.lines import distances_from, line_text, lines_equal
from utils.checks.lesson_02.results import (
    as_line_and_mask,
    assert_mask_matches_line,
    assert_nothing_found,
    inlier_count,
)
from utils.checks.lesson_02.runs import (
    answers_of_short_runs,
    assert_finds_line,
    follows_wall,
    wall_and_clutter,
)
from utils.checks.run_cache import once_per_run

_CLOUDS = tuple(frozen(wall_and_clutter(seed, 24, 16)) for seed in range(12))


@once_per_run
def require_line_among_outliers(ransac_line: Callable) -> None:
    """Raise `NotYet` if the line is not found among outliers."""
    with precondition("the line is found among outliers"):
        # At least 28 samples in 100 find the line, so 30 rounds miss it with a probability of
        # 0.72^30 < 1e-4.
        assert_finds_line(ransac_line, _CLOUDS, 8, 30, 0.4)


@visible_check(
    "ransac_line",
    weight=5,
    title="Finds the line among outliers",
    why="Even if people stand in front of a wall, the car must know where the wall is.",
    hint="After each round, compare the number of inliers with the number in the best mask so "
    "far. If it is larger, replace both line and mask.",
)
def finds_the_line(ransac_line: Callable) -> None:
    # 60 rounds miss the line with a probability of 0.72^60 < 1e-8.
    assert_finds_line(ransac_line, _CLOUDS, 8, 60, 0.4)


_RANSAC_CASE = Case(
    __name__,
    "ransac_line",
    {
        "points": _CLOUDS[1][0],
        "max_iterations": 30,
        "distance_tolerance": 0.4,
        "rng": np.random.default_rng(2),
    },
    expected=None,
    compare=lambda answer, points, *_: as_line_and_mask(answer, len(points)),
    precondition=require_line_among_outliers,
)
common_checks.promise_untouched(
    _RANSAC_CASE,
    "leaves_its_input",
    why="The next search needs the original points.",
    hint="Draw row numbers with rng.choice instead of shuffling the points.",
)


@visible_check(
    "ransac_line",
    weight=6,
    title="Returns the mask that belongs to the line, for any threshold",
    why="If the line and the mask come from different samples, later cells remove the wrong "
    "points.",
    hint="Replace line and mask together. Compare distances in metres with distance_tolerance, and "
    "do not square them.",
)
def mask_belongs_to_line(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for seed, tolerance in enumerate((0.1, 0.4, 0.7, 2.5)):
        rng = np.random.default_rng(seed)
        # The wall is so rough that another line would have different inliers.
        points, _ = wall_and_clutter(100 + seed, 30, 10, noise=0.8)
        assert_mask_matches_line(ransac_line(points.copy(), 30, tolerance, rng), points, tolerance)


@note_check(
    "ransac_line",
    title="Counts a point at exactly distance_tolerance as an inlier",
    why="In the docstring, distance_tolerance is the largest distance of an inlier, so write <=. "
    "Measured points are hardly ever at exactly that distance, so this does not affect your score.",
)
def includes_the_threshold(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_threshold_is_inclusive(ransac_line, np.array([[0.0, 0.0], [8.0, 0.0], [4.0, 1.0]]))


def assert_threshold_is_inclusive(ransac_line: Callable, points: np.ndarray) -> None:
    """Assert that a point exactly `distance_tolerance` away from the line counts as an inlier.

    Parameters
    ----------
    ransac_line : callable
    points : numpy.ndarray, shape (3, 2)
        Three points with whole-numbered coordinates, so that distances are exact. The first two
        are on a line parallel to an axis, and the third is exactly 1 m from that line.
    """
    axis = int(points[0, 1] == points[1, 1])  # the axis of the normal
    exact = np.insert(np.eye(2)[axis], 2, -points[0, axis])
    matching_lines = 0
    for seed in range(30):
        answer = ransac_line(points.copy(), 3, 1.0, np.random.default_rng(seed))
        line, mask = as_line_and_mask(answer, 3)
        # Skip other lines: one that was refitted to its inliers may be off in the last digits.
        if line is None or not (np.array_equal(line, exact) or np.array_equal(line, -exact)):
            continue
        if not mask[2]:
            raise CheckFailed(
                "A point at exactly distance_tolerance from the line is not marked.",
                input_text=f"distance_tolerance=1.0, the line {brief_text(line)} and the point "
                f"{point_text(points[2])}",
                yours="False",
                expected="True",
            )
        matching_lines += 1
        if matching_lines == 3:  # further comparisons give the same result
            return


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws as many samples as max_iterations allows",
    why="On a street with many outliers, RANSAC needs many rounds to find the wall.",
    hint="Loop over range(max_iterations) and draw one sample of two points in each round.",
)
def draws_enough_samples(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_no_round_is_missing(ransac_line)
    # About one sample in 25 gives the line.
    assert_finds_line(ransac_line, [wall_and_clutter(7, 14, 46)] * 12, 8, 250, 0.3)


def assert_no_round_is_missing(ransac_line: Callable) -> None:
    """Assert that one round is enough to find a line when all points lie on it."""
    steps = np.arange(10.0)
    wall = np.column_stack([steps, 2 * steps + 1])

    def runs_with_line(n_rounds: int) -> int:
        """Return the number of runs that find a line."""
        runs = (
            ransac_line(wall.copy(), n_rounds, 0.3, np.random.default_rng(seed))
            for seed in range(12)
        )
        return sum(as_line_and_mask(answer, 10)[0] is not None for answer in runs)

    if runs_with_line(1):
        return
    second_round_note = fixed(" With max_iterations=2 a line is found, so one round is missing.")
    raise CheckFailed(
        fixed("All ten points lie on one line, but a run with max_iterations=1 never finds a line.")
        + (second_round_note if runs_with_line(2) else ""),
        yours="no line in 12 of 12 runs",
        expected="a line in every run",
        hint="Loop over range(max_iterations): range(1, max_iterations) and range(max_iterations "
        "- 1) give one round fewer.",
    )


@visible_check(
    "ransac_line",
    weight=1,
    title="Draws no more samples than max_iterations allows",
    why="Each round takes time, and the next scan arrives in a tenth of a second.",
    hint="Loop over range(max_iterations) and draw one sample of two points in each round.",
)
def draws_no_more_samples(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    points, on_line = wall_and_clutter(7, 14, 46)
    generators = map(np.random.default_rng, range(48))
    answers = answers_of_short_runs(ransac_line, points, 1, 0.3, generators)
    found = sum(follows_wall(line, points[on_line], 0.3) for line, _ in answers)
    if found >= 24:  # practically impossible if one sample in 25 gives the line
        raise CheckFailed(
            fixed(
                "With max_iterations=1, the line was found in most runs, but a single sample "
                "hardly ever finds it. The function draws more samples than max_iterations allows."
            ),
            yours=f"found in {found} of 48 runs",
            expected="found in about 2 of 48 runs",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Draws two different points for each sample",
    why="If a point is drawn twice, there is no line, and the round is wasted.",
    hint="Draw with rng.choice(len(points), size=2, replace=False), which never draws a row twice.",
)
def draws_different_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    runs = lines_from_two_rounds(ransac_line, _TRIANGLE)
    n_without_line = sum(line is None for line in runs)
    if n_without_line:
        raise CheckFailed(
            "Any two of the three points define a line, but in some runs no line was found.",
            input_text="three points and max_iterations=2",
            yours=f"no line in {n_without_line} of {len(runs)} runs",
            expected="a line in every run",
        )


# Any two of these points define a line, and the other points are far from it.
_FOUR_POINTS = frozen(np.array([[1.0, 2.0], [5.0, -1.0], [-2.0, -4.0], [4.0, 6.0]]))
_TRIANGLE = frozen(_FOUR_POINTS[:3])


def lines_from_two_rounds(ransac_line: Callable, points: np.ndarray) -> list[np.ndarray | None]:
    """Return the lines of 64 two-round runs with different seeds; None for a run without a line.

    With three points, a function that draws with replacement finds no line in one run of nine.
    Another check looks for a missing round.

    Raises
    ------
    NotYet
        If no run finds a line.
    """
    generators = map(np.random.default_rng, range(64))
    lines = [line for line, _ in answers_of_short_runs(ransac_line, points, 2, 0.1, generators)]
    if all(line is None for line in lines):
        raise NotYet(f"two rounds find a line through some of the {len(points)} points")
    return lines


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws from all points, including the first and the last",
    why="A point that is never drawn may be one of the few on the wall.",
    hint="Draw with rng.choice(len(points), size=2, replace=False), which takes rows from 0 to "
    "len(points) - 1.",
)
def draws_from_all_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    answers = lines_from_two_rounds(ransac_line, _FOUR_POINTS)
    found = [line for line in answers if line is not None]
    lines, drawn, has_distant_rows = [], np.zeros(len(_FOUR_POINTS), dtype=bool), False
    for line in found:
        rows = np.flatnonzero(distances_from(line, _FOUR_POINTS) < TOLERANCE)
        if len(rows) >= 2:
            lines.append(line)
            drawn[rows] = True
            # Rows 0 and 3 count as neighbours, because a function may wrap around at the end.
            has_distant_rows |= rows[-1] - rows[0] == 2
        if drawn.all() and has_distant_rows:
            return
    if not lines:
        raise CheckFailed(
            "No line goes through two of the four points.",
            input_text="four points and max_iterations=2",
            yours=f"for example {line_text(found[0])}",
            expected="the line through the two points of a sample",
            hint="Return the line of the best sample. A line that is fitted to its inliers is also "
            "right: here it goes through the same two points.",
        )
    if all(lines_equal(line, lines[0]) for line in lines):
        return  # another check tests whether different seeds draw different samples
    if drawn.all():
        raise CheckFailed(
            "Only neighbouring rows are drawn together.",
            input_text="four points and max_iterations=2",
            yours=f"no line through rows 0 and 2 or through rows 1 and 3 in {len(lines)} runs",
            expected="one of these lines in about a third of the runs",
            hint="Draw both rows at random: rng.choice(len(points), size=2, replace=False).",
        )
    row = int(np.flatnonzero(~drawn)[0])
    raise CheckFailed(
        f"Row {row} of the four points was never drawn.",
        input_text="four points and max_iterations=2",
        yours=f"no line through row {row} in {len(lines)} runs",
        expected="a line through each row in about half of the runs",
    )


@visible_check(
    "ransac_line",
    weight=1,
    title="Finds walls parallel to an axis",
    why="A wall straight ahead of the car is parallel to the y axis, and the car must not hit it.",
    hint="Do not compute a slope: line_through and point_line_distance work for all directions.",
)
def finds_axis_parallel_lines_among_outliers(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for column in (0, 1):
        points = np.random.default_rng(column).uniform(-9, 9, (30, 2))
        points[:20, column] = 4.0
        assert_finds_line(ransac_line, [(points, np.arange(30) < 20)] * 6, 3, 80, 0.2)


@visible_check(
    "ransac_line",
    weight=2,
    title="Returns the same answer for the same seed",
    why="To debug a run that went wrong, you must be able to repeat it.",
    hint="Draw with rng.choice, never with np.random.choice or the module random.",
)
def repeats_with_the_same_seed(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    assert_repeats(ransac_line, np.random.default_rng)


@once_per_run
def assert_repeats(ransac_line: Callable, as_rng: Callable) -> None:
    """Assert that a second run with the same seed gives the same line and mask.

    Parameters
    ----------
    ransac_line : callable
    as_rng : callable
        Takes a seed and returns the value to pass as `rng`.
    """
    points, _ = wall_and_clutter(3, 20, 20)
    generators = [as_rng(seed) for seed in range(20) for _ in range(2)]
    answers = answers_of_short_runs(ransac_line, points, 2, 0.4, generators)
    for seed, (first, again) in enumerate(zip(answers[::2], answers[1::2], strict=True)):
        if not (lines_equal(first[0], again[0]) and np.array_equal(first[1], again[1])):
            raise CheckFailed(
                "The same seed gave two different answers.",
                input_text=f"the seed {seed} twice, with max_iterations=2",
                yours=f"first the line {line_text(first[0])}, then {line_text(again[0])}",
                expected="the same line and mask both times",
            )


@visible_check(
    "ransac_line",
    weight=2,
    title="Draws different samples for different seeds",
    why="If a run misses the wall, a run with another seed may find it.",
    hint="Begin with rng = np.random.default_rng(rng), and never use a fixed seed.",
)
def differs_with_other_seeds(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    points, _ = wall_and_clutter(3, 20, 20)
    lines = set()
    for seed in range(20):
        answer = ransac_line(points.copy(), 2, 0.4, np.random.default_rng(seed))
        lines.add(line_text(as_line_and_mask(answer, len(points))[0]))
        if len(lines) > 1:
            return
    if lines == {line_text(None)}:
        raise NotYet("two rounds find a line")
    raise CheckFailed(
        fixed("20 different seeds all gave the same line."),
        input_text="max_iterations=2",
        yours=f"always {lines.pop()}",
        expected="nearly 20 different lines",
    )


@visible_check(
    "ransac_line",
    weight=2,
    title="Continues after a sample of equal points",
    why="Equal points are common in recordings, and a sample of two of them must not end the "
    "search.",
    hint="If line_through returns None, write `continue`, which goes on with the next round. "
    "`break` ends the search.",
)
def continues_after_equal_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    wall, _ = wall_and_clutter(11, 12, 0)
    points = np.vstack([np.tile([[2.0, 9.0]], (28, 1)), wall])
    n_without_line = 0
    for seed in range(24):
        answer = ransac_line(points.copy(), 40, 0.3, np.random.default_rng(seed))
        n_without_line += as_line_and_mask(answer, len(points))[0] is None
    if n_without_line:
        raise CheckFailed(
            "Not all points are equal, but in some runs no line was found.",
            input_text="28 equal points, 12 others and max_iterations=40",
            yours=f"no line in {n_without_line} of 24 runs",
            expected="a line in every run",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Returns an answer if all points are equal",
    why="A blocked scanner reports the same point again and again, and that must not crash the "
    "program.",
    hint="If no round finds a line, return the initial values: None and a mask that is all False.",
)
def returns_for_equal_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    equal_points = np.tile([[2.0, 9.0]], (6, 1))
    answer = ransac_line(equal_points.copy(), 20, 0.3, np.random.default_rng(0))
    line, mask = as_line_and_mask(answer, 6)
    if line is not None:
        assert_mask_matches_line((line, mask), equal_points, 0.3)
    elif mask.any():
        raise CheckFailed(
            "If the line is None, no point can be an inlier.",
            yours=inlier_count(mask),
            expected="0 inliers",
        )


@visible_check(
    "ransac_line",
    weight=1,
    title="Works on two points and returns (None, all False) for fewer",
    why="An empty street gives no points, and that must not crash the program.",
    hint="If len(points) < 2, return None and np.zeros(len(points), dtype=bool) before the loop.",
)
def returns_for_too_few_points(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    for points in (np.empty((0, 2)), np.array([[3.0, 4.0]])):
        assert_nothing_found(
            ransac_line(points.copy(), 10, 0.3, np.random.default_rng(0)), len(points)
        )
    assert_two_points_are_enough(ransac_line, _TRIANGLE[:2])


def assert_two_points_are_enough(ransac_line: Callable, pair: np.ndarray) -> None:
    """Assert that at least one of 12 runs finds the line through two different points."""
    for seed in range(12):
        answer = ransac_line(pair.copy(), 10, 0.3, np.random.default_rng(seed))
        if as_line_and_mask(answer, 2)[0] is not None:
            return
    raise CheckFailed(
        "Two different points define a line, but no line is found with any seed.",
        input_text="two points and max_iterations=10",
        yours="None",
        expected="three numbers (a, b, c)",
        hint="Return early only if len(points) < 2: two points are enough for a sample.",
    )


@visible_check(
    "ransac_line",
    weight=2,
    title="Accepts an integer seed as rng",
    why="A seed can be written to a log file; a generator cannot.",
    hint="Begin with rng = np.random.default_rng(rng), which accepts a whole number or a "
    "generator.",
)
def takes_a_seed(ransac_line: Callable) -> None:
    require_line_among_outliers(ransac_line)
    with precondition("the same generator gives the same answer"):
        assert_repeats(ransac_line, np.random.default_rng)
    assert_repeats(ransac_line, int)
    found = 0
    for seed, (points, on_line) in enumerate(_CLOUDS):
        line, _ = as_line_and_mask(ransac_line(points.copy(), 30, 0.4, seed), len(points))
        found += follows_wall(line, points[on_line], 0.4)
    if found < 8:  # the same bound as in require_line_among_outliers
        raise CheckFailed(
            f"With a whole number as rng, the line was found in {found} of {len(_CLOUDS)} runs. "
            "With a generator, it is found in most of them.",
            yours=f"found in {found} of {len(_CLOUDS)} runs",
            expected="found as often as with a generator",
            hint="Create the generator once, before the loop. If you create it from the same "
            "seed in each round, it draws the same sample each time.",
        )


common_checks.promise_names(
    _RANSAC_CASE,
    "keeps_the_names",
    why="Other code may call ransac_line(points, max_iterations=40, distance_tolerance=0.1, "
    "rng=1), because the names explain the numbers.",
)


@note_check(
    "ransac_line",
    title="Returns a mask of True and False",
    why="Later cells use points[mask] and points[~mask]. With the numbers 0 and 1, both select the "
    "wrong points.",
)
def has_a_mask_of_booleans(ransac_line: Callable) -> None:
    points, _ = _CLOUDS[0]
    _, inliers = ransac_line(points.copy(), 20, 0.4, np.random.default_rng(0))
    dtype = as_array(inliers).dtype
    if dtype.kind != "b":
        raise CheckFailed(f"The mask has the type {dtype}.")
