"""Visible checks of `ransac_plane`."""

from collections.abc import Callable, Iterable

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import (
    CheckFailed,
    assert_untouched,
    call_each,
    frozen,
    point_text,
    precondition,
)
from utils.checks.common_checks import Case
from utils.checks.core import note_check, visible_check
from utils.checks.failures import NotYet, fixed
from utils.checks.lesson_03.planes import (
    TRIANGLES,
    as_plane,
    assert_unit_normal,
    plane_text,
    scattered_plane,
)
from utils.checks.lesson_03.results import (
    as_mask,
    as_model,
    as_pair,
    assert_finds_plane,
    assert_inliers_within_tolerance,
    assert_nearest_are_inliers,
    assert_nothing_found,
)
from utils.checks.run_cache import once_per_run
from utils.geometry import distances_from_plane

# The small example in the notebook: five points on a floor and two above it.
_SEVEN_POINTS = frozen(
    np.array(
        [
            [0.0, 0.0, -1.7],
            [4.0, 0.0, -1.7],
            [1.0, 3.0, -1.7],
            [5.0, 4.0, -1.7],
            [2.0, 5.0, -1.7],
            [1.5, 1.0, -0.2],
            [3.0, 2.0, 0.5],
        ]
    )
)


@once_per_run
def require_plane_among_outliers(ransac_plane: Callable) -> None:
    """Raise `NotYet` if the plane is not found among outliers."""
    with precondition("the plane is found among outliers"):
        for seed in (1, 2, 3):
            points, on_plane = scattered_plane(seed, 60, 20, noise=0.02)
            # One sample in three is good, so 60 rounds fail with a probability of 0.67^60 < 1e-10.
            answer = ransac_plane(points.copy(), 60, 0.2, np.random.default_rng(seed))
            assert_finds_plane(answer, points, 0.2, on_plane)


def require_plane_without_outliers(ransac_plane: Callable) -> None:
    """Raise `NotYet` if no plane is found when all points lie on it."""
    with precondition("a plane is found when all points lie on it"):
        points, on_plane = scattered_plane(2, 40, 0)
        answer = ransac_plane(points.copy(), 30, 0.3, np.random.default_rng(2))
        assert_finds_plane(answer, points, 0.5, on_plane, share=0.5)


@once_per_run
def _assert_masks_belong_to_models(ransac_plane: Callable) -> None:
    for seed in range(4):
        points, _ = scattered_plane(10 + seed, 50, 20, noise=0.1)
        rng = np.random.default_rng(seed)
        for iterations in (12, 30):
            assert_nearest_are_inliers(ransac_plane(points.copy(), iterations, 0.2, rng), points)


def ramp_with_collinear_points(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return shuffled points of the ramp z = y / 4 - 3, most of them on one line.

    The coordinates are whole numbers, so that computations are exact. More than half of all samples
    lie on a line and do not define a plane; all others define the plane of the ramp.

    Returns
    -------
    points : numpy.ndarray, shape (48, 3)
    on_plane : numpy.ndarray of bool, shape (48,)
        All True.
    """
    line = np.column_stack([np.arange(40), np.full(40, 4), np.full(40, -2)])
    steps = rng.integers(2, 8, 8)
    others = np.column_stack([rng.integers(0, 40, 8), 4 * steps, steps - 3])
    return rng.permutation(np.concatenate([line, others])).astype(float), np.ones(48, dtype=bool)


def _half_equal_points(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return shuffled points of a plane, half of them equal, and a mask that is all True."""
    points, on_plane = scattered_plane(seed, 40, 0)
    points[:20] = points[0]
    return np.random.default_rng(seed).permutation(points), on_plane


@visible_check(
    "ransac_plane",
    weight=5,
    title="Finds the plane among outliers",
    why="Points off the road may be obstacles, so the car must know where the road is.",
    hint="Draw three rows, compute their plane and count the points near it. Keep the plane "
    "with the highest count, and return it after the last round, not inside the loop.",
)
def finds_the_plane(ransac_plane: Callable) -> None:
    on_floor = _SEVEN_POINTS[:, 2] == -1.7
    # Two samples in seven are good, so 80 rounds fail with a probability of 0.714^80 < 1e-11.
    answer = ransac_plane(_SEVEN_POINTS.copy(), 80, 0.1, np.random.default_rng(1))
    assert_finds_plane(
        answer,
        _SEVEN_POINTS,
        0.1,
        on_floor,
        input_text="seven points, five of them on a floor at z = -1.7",
    )
    for seed in (1, 2, 3):
        points, on_plane = scattered_plane(seed, 60, 30, noise=0.02)
        rng = np.random.default_rng(seed)
        # At least 22 samples in 100 are good, so 90 rounds fail with a probability below 1e-9.
        assert_finds_plane(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, on_plane)


@visible_check(
    "ransac_plane",
    weight=14,
    title="Returns the mask that belongs to the model",
    why="If the plane and the mask come from different samples, later cells remove the wrong "
    "points.",
    hint="If a sample is better than the best so far, keep both its plane and its mask. If you "
    "refit the plane, compute its mask again.",
)
def mask_belongs_to_model(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    _assert_masks_belong_to_models(ransac_plane)


@visible_check(
    "ransac_plane",
    weight=4,
    title="Marks the points within distance_tolerance as inliers",
    why="The pavement is ten centimetres above the road. The threshold decides whether its points "
    "are inliers.",
    hint="Compare the distances with distance_tolerance, not with a fixed number.",
)
def uses_the_tolerance(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    with precondition("the mask belongs to the model"):
        _assert_masks_belong_to_models(ransac_plane)
    points, _ = scattered_plane(21, 90, 0, noise=0.2)
    for tolerance in (0.05, 0.12, 0.35):
        answer = ransac_plane(points.copy(), 30, tolerance, np.random.default_rng(5))
        assert_inliers_within_tolerance(answer, points, tolerance)


@visible_check(
    "ransac_plane",
    weight=1,
    title="Returns a model whose normal has length 1",
    why="If the normal had length 5, all distances from the plane would be five times too large.",
    hint="Return the four numbers of plane_through unchanged. Their normal already has length 1.",
)
def model_has_a_unit_normal(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    points, _ = scattered_plane(25, 60, 0)
    answer = ransac_plane(points.copy(), 40, 0.2, np.random.default_rng(4))
    as_model(answer)
    assert_unit_normal(answer[0])


@visible_check(
    "ransac_plane",
    weight=2,
    title="Draws as many samples as max_iterations allows",
    why="The fewer points belong to the plane, the more rounds RANSAC needs to find it.",
    hint="Loop with `for _ in range(max_iterations)`, draw one sample in each round, and return "
    "after the loop.",
)
def draws_enough_samples(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    assert_no_round_is_missing(ransac_plane)
    for seed in (31, 32):
        points, on_plane = scattered_plane(seed, 20, 40)
        rng = np.random.default_rng(6)
        assert_finds_plane(ransac_plane(points.copy(), 800, 0.2, rng), points, 0.2, on_plane)


def assert_no_round_is_missing(ransac_plane: Callable) -> None:
    """Assert that one round is enough to find a plane when every sample defines one."""
    points, _ = scattered_plane(33, 20, 0)

    def runs_with_plane(n_rounds: int) -> int:
        """Return the number of runs that find a plane."""
        runs = (
            ransac_plane(points.copy(), n_rounds, 0.2, np.random.default_rng(seed))
            for seed in range(12)
        )
        return sum(as_pair(answer)[0] is not None for answer in runs)

    if runs_with_plane(1):
        return
    second_round_note = fixed(" With max_iterations=2 a plane is found, so one round is missing.")
    raise CheckFailed(
        fixed(
            "All twenty points lie on one plane, but a run with max_iterations=1 never finds a "
            "plane."
        )
        + (second_round_note if runs_with_plane(2) else ""),
        yours="None in 12 of 12 runs",
        expected="a plane in every run",
        hint="Loop over range(max_iterations): range(1, max_iterations) and range(max_iterations "
        "- 1) give one round fewer.",
    )


@visible_check(
    "ransac_plane",
    weight=1,
    title="Draws no more samples than max_iterations allows",
    why="Each round takes time, and the next scan arrives in a tenth of a second.",
    hint="Loop with `for _ in range(max_iterations)` and draw one sample in each round.",
)
def draws_no_more_samples(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    points, on_plane = scattered_plane(32, 20, 40)
    generators = map(np.random.default_rng, range(48))
    found = sum(
        np.count_nonzero(on_plane & (distances_from_plane(points, plane) <= 0.2)) > 17
        for plane in _quick_planes(ransac_plane, points, 1, 0.2, generators)
        if plane is not None
    )
    if found > 18:  # one or two are expected
        raise CheckFailed(
            fixed(
                "With max_iterations=1, this plane is found again and again, but a single sample "
                "hardly ever finds it. The function draws more samples than max_iterations allows."
            ),
            yours=f"found in {found} of 48 runs",
            expected="found in about 2 of 48 runs",
        )


@visible_check(
    "ransac_plane",
    weight=3,
    title="Continues after samples that do not define a plane",
    why="Equal points and points on one line are common in recordings, and a sample of them must "
    "not end the search.",
    hint="If plane_through returns None, continue with the next sample. Count that round as well, "
    "or the loop may never end.",
)
def continues_after_degenerate_samples(ransac_plane: Callable) -> None:
    for seed in range(4):
        ramp, half_equal = (
            ramp_with_collinear_points(np.random.default_rng(seed)),
            _half_equal_points(40 + seed),
        )
        for (points, on_plane), input_text in (
            (ramp, "48 points on one plane, 40 of them on one line"),
            (half_equal, "40 points on one plane, 20 of them equal"),
        ):
            # Four samples in ten are good, so 40 rounds fail with a probability of 0.58^40 < 1e-9.
            answer = ransac_plane(points.copy(), 40, 0.2, np.random.default_rng(seed))
            assert_finds_plane(answer, points, 0.2, on_plane, input_text=input_text)


@visible_check(
    "ransac_plane",
    weight=2,
    title="Works on three points and returns (None, all False) for fewer",
    why="A filter may leave few points, and that must not crash the program.",
    hint="If len(points) < 3, return None and np.zeros(len(points), dtype=bool) before the loop.",
)
def returns_for_too_few_points(ransac_plane: Callable) -> None:
    require_plane_without_outliers(ransac_plane)
    for n in (0, 1, 2):
        for columns in (3, 4):
            points = np.arange(float(n * columns)).reshape(n, columns)
            rng = np.random.default_rng(9)
            assert_nothing_found(ransac_plane(points.copy(), 5, 0.2, rng), n)
    assert_three_points_are_enough(ransac_plane, TRIANGLES[0])


def assert_three_points_are_enough(ransac_plane: Callable, triangle: np.ndarray) -> None:
    """Assert that at least one of 12 runs finds the plane through three points."""
    for seed in range(12):
        answer = ransac_plane(triangle.copy(), 10, 0.2, np.random.default_rng(seed))
        if as_pair(answer)[0] is not None:
            return
    raise CheckFailed(
        "Three points that are not on one line define a plane, but no plane is found with any "
        "seed.",
        input_text="three points and max_iterations=10",
        yours="None",
        expected="four numbers (a, b, c, d)",
        hint="Return early only if len(points) < 3: three points are enough for a sample.",
    )


@visible_check(
    "ransac_plane",
    weight=1,
    title="Returns (None, all False) if all points lie on one line",
    why="On a flat wall, the returns of a horizontal beam lie on one line, and no three of them "
    "define a plane.",
    hint="Begin with model = None and a mask that is all False. If no sample gives a plane, "
    "return these two.",
)
def returns_none_for_points_on_a_line(ransac_plane: Callable) -> None:
    require_plane_without_outliers(ransac_plane)
    line = np.outer(np.arange(12.0), [1.0, 2.0, 1.0])
    assert_nothing_found(ransac_plane(line.copy(), 20, 0.2, np.random.default_rng(8)), 12)


@visible_check(
    "ransac_plane",
    weight=2,
    title="Draws three different rows for each sample",
    why="If a row is drawn twice, the sample has only two points, and the round is wasted.",
    hint="Draw with rng.choice(len(points), 3, replace=False), which never draws a row twice.",
)
def draws_different_rows(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    assert_rows_differ(ransac_plane, _FIVE_POINTS)


def assert_rows_differ(ransac_plane: Callable, points: np.ndarray) -> None:
    """Assert that every run finds a plane when any three points define one."""
    planes = planes_from_two_rounds(ransac_plane, points)
    n_without_plane = sum(plane is None for plane in planes)
    if n_without_plane:
        raise CheckFailed(
            "Any three of these points define a plane, but in some runs no plane was found.",
            input_text=f"{len(points)} points and max_iterations=2",
            yours=f"None in {n_without_plane} of {len(planes)} runs",
            expected="a plane in every run",
        )


# Any three of these points define a plane, and the others are at least 40 cm away from it. None of
# the ten planes is steep, because another check covers functions that reject steep planes.
_FIVE_POINTS = frozen(
    np.array([[9, 3, -2.1], [0, 8, -1.6], [7, -9, -1.1], [1, -8, -1.9], [-6, 5, -1.9]], dtype=float)
)


def planes_from_two_rounds(ransac_plane: Callable, points: np.ndarray) -> list[np.ndarray | None]:
    """Return the planes of 48 two-round runs with different seeds; None for a run without a plane.

    With five points, a function that draws with replacement finds no plane in a quarter of the
    runs. Another check looks for a missing round.

    Raises
    ------
    NotYet
        If no run finds a plane.
    """
    planes = _quick_planes(ransac_plane, points, 2, 0.1, map(np.random.default_rng, range(48)))
    if all(plane is None for plane in planes):
        raise NotYet(f"two rounds find a plane through some of the {len(points)} points")
    return planes


@visible_check(
    "ransac_plane",
    weight=2,
    title="Draws from all points, including the first and the last",
    why="A point that is never drawn may be one of the few on the road.",
    hint="Draw with rng.choice(len(points), 3, replace=False), which takes rows from 0 to "
    "len(points) - 1.",
)
def draws_from_all_rows(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    answers = planes_from_two_rounds(ransac_plane, _FIVE_POINTS)
    found = [plane for plane in answers if plane is not None]
    planes, drawn, has_distant_rows = [], np.zeros(len(_FIVE_POINTS), dtype=bool), False
    neighbours = {frozenset((row + np.arange(3)) % 5) for row in range(5)}
    for plane in found:
        rows = np.flatnonzero(distances_from_plane(_FIVE_POINTS, plane) < 2e-3)
        if len(rows) >= 3:
            planes.append(plane)
            drawn[rows] = True
            has_distant_rows |= frozenset(rows) not in neighbours
        if drawn.all() and has_distant_rows:
            return
    if not planes:
        raise CheckFailed(
            "No plane goes through three of the five points.",
            input_text="five points and max_iterations=2",
            yours=f"for example {plane_text(found[0])}",
            expected="the plane through the three points of a sample",
            hint="Return the plane of the best sample. A plane that is fitted to its inliers is "
            "also right: here it goes through the same three points.",
        )
    if all(_planes_equal(plane, planes[0]) for plane in planes):
        return  # another check tests whether different seeds draw different samples
    if drawn.all():
        raise CheckFailed(
            "Only neighbouring rows are drawn together.",
            input_text="five points and max_iterations=2",
            yours=f"every plane passes through three neighbouring rows in {len(planes)} runs",
            expected="planes through any three rows",
            hint="Draw three different rows, independently of each other: "
            "rng.choice(len(points), 3, replace=False).",
        )
    row = int(np.flatnonzero(~drawn)[0])
    raise CheckFailed(
        f"Row {row} of the five points was never drawn.",
        input_text="five points and max_iterations=2",
        yours=f"no plane through row {row} in {len(planes)} runs",
        expected="a plane through each row in more than half of the runs",
    )


@note_check(
    "ransac_plane",
    title="Counts a point at exactly distance_tolerance as an inlier",
    why="In the docstring, distance_tolerance is the largest distance of an inlier, so write <=. "
    "Measured points are hardly ever at exactly that distance, so this does not affect your score.",
)
def includes_the_threshold(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    four = np.array([[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [1.0, 1.0, 1.0]])
    assert_threshold_is_inclusive(ransac_plane, four)


def assert_threshold_is_inclusive(ransac_plane: Callable, points: np.ndarray) -> None:
    """Assert that a point exactly `distance_tolerance` away from the plane counts as an inlier.

    Parameters
    ----------
    ransac_plane : callable
    points : numpy.ndarray, shape (4, 3)
        Four points with whole-numbered coordinates, so that distances are exact. The first three
        are on a plane parallel to two axes, and the fourth is exactly 1 m from that plane.
    """
    [axis] = np.flatnonzero((points[:3] == points[0]).all(axis=0))  # the axis of the normal
    exact = np.append(np.eye(3)[axis], -points[0, axis])
    matching_planes = 0
    for seed in range(40):
        answer = ransac_plane(points.copy(), 3, 1.0, np.random.default_rng(seed))
        plane = _plane_or_none(answer)
        # Skip other planes: one that was refitted to its inliers may be off in the last digits.
        if plane is None or not (np.array_equal(plane, exact) or np.array_equal(plane, -exact)):
            continue
        if not as_mask(answer, 4)[3]:
            raise CheckFailed(
                "A point at exactly distance_tolerance from the plane is not marked.",
                input_text=f"distance_tolerance=1.0, the plane {plane_text(plane)} and the point "
                f"{point_text(points[3])}",
                yours="False",
                expected="True",
            )
        matching_planes += 1
        if matching_planes == 3:  # further comparisons give the same result
            return


@visible_check(
    "ransac_plane",
    weight=3,
    title="Ignores intensity in a fourth column",
    why="Bright paint lies flat on the road, so its intensity must not turn it into an obstacle.",
    hint="Use points[:, :3] for the sample and for the distances.",
)
def ignores_intensity(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    points, on_plane = scattered_plane(51, 50, 20, columns=4)
    rng = np.random.default_rng(10)
    assert_finds_plane(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, on_plane)


@visible_check(
    "ransac_plane",
    weight=2,
    title="Finds a wall as well as a road",
    why="The largest plane may be a wall. A program that needs the road tests the normal later.",
    hint="Do not test for roads in the loop: only the number of inliers decides.",
)
def finds_a_wall(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    points, on_plane = scattered_plane(52, 50, 20, plane=(0.6, 0.8, 0.0, -4.0))
    rng = np.random.default_rng(11)
    assert_finds_plane(ransac_plane(points.copy(), 90, 0.2, rng), points, 0.2, on_plane)


@visible_check(
    "ransac_plane",
    weight=1,
    title="Does not change its input",
    why="The next search needs the original cloud.",
    hint="Do not write into points[:, :3], which shares its memory with points. Build new arrays "
    "from it.",
)
def leaves_the_cloud(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    points, _ = scattered_plane(53, 50, 20)
    assert_untouched(ransac_plane, points, 50, 0.2, np.random.default_rng(12))


@visible_check(
    "ransac_plane",
    weight=3,
    title="Returns the same plane for the same seed, and other planes for other seeds",
    why="To debug a run that went wrong, you must be able to repeat it.",
    hint="Begin with rng = np.random.default_rng(rng) and draw with rng.choice, never with "
    "np.random.choice or a fixed seed.",
)
def depends_only_on_rng(ransac_plane: Callable) -> None:
    require_plane_without_outliers(ransac_plane)
    # Only one sample in eight is good, so planes differ even if they are refitted to their inliers.
    points, _ = scattered_plane(61, 30, 30, noise=0.05)
    generators = [np.random.default_rng(seed) for seed in range(12) for _ in range(2)]
    planes = _quick_planes(ransac_plane, points, 2, 0.2, generators)
    for seed, (first, again) in enumerate(zip(planes[::2], planes[1::2], strict=True)):
        if not _planes_equal(first, again):
            raise CheckFailed(
                "The same seed gave two different planes, so the result does not depend on rng "
                "alone.",
                input_text="the same points, max_iterations=2 and "
                f"rng=np.random.default_rng({seed}), twice",
                yours=f"{plane_text(first)} and {plane_text(again)}",
                expected="the same plane twice",
            )
    if all(plane is None for plane in planes):
        raise NotYet("two rounds find a plane")
    if all(_planes_equal(planes[0], plane) for plane in planes):
        raise CheckFailed(
            "Twelve seeds all gave the same plane, so the samples do not seem to depend on rng.",
            yours=f"always {plane_text(planes[0])}",
            expected="different planes",
        )


def _plane_or_none(answer: object) -> np.ndarray | None:
    model, _ = as_pair(answer)
    return None if model is None else as_plane(model)


def _quick_planes(
    ransac_plane: Callable,
    points: np.ndarray,
    max_iterations: int,
    tolerance: float,
    generators: Iterable[np.random.Generator],
) -> list[np.ndarray | None]:
    """Return the planes of many short runs, which share the time limit of one call."""
    calls = [(points, max_iterations, tolerance, rng) for rng in generators]
    return [_plane_or_none(answer) for answer in call_each(ransac_plane, calls)]


def _planes_equal(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    if first is None or second is None:
        return first is second
    return np.allclose(first, second, atol=1e-6) or np.allclose(first, -second, atol=1e-6)


@visible_check(
    "ransac_plane",
    weight=3,
    title="Accepts an integer seed as rng",
    why="A seed can be written to a log file; a generator cannot.",
    hint="Begin with rng = np.random.default_rng(rng), which accepts a whole number or a "
    "generator.",
)
def takes_a_seed(ransac_plane: Callable) -> None:
    require_plane_among_outliers(ransac_plane)
    for seed in (1, 2, 3):
        points, on_plane = scattered_plane(70 + seed, 60, 30)
        assert_finds_plane(ransac_plane(points.copy(), 90, 0.2, seed), points, 0.2, on_plane)
    generators, seeds = (
        _quick_planes(ransac_plane, points, 2, 0.2, values)
        for values in ((np.random.default_rng(3), np.random.default_rng(3)), (3, 3))
    )
    if _planes_equal(*generators) and not _planes_equal(*seeds):
        raise CheckFailed(
            fixed(
                "Two calls with rng=3 gave two different planes. Two calls with generators of that "
                "seed give the same plane."
            ),
            yours=" and ".join(map(plane_text, seeds)),
            expected="the same plane twice",
        )


_POINTS, _ON_PLANE = frozen(scattered_plane(1, 60, 30, noise=0.02))
common_checks.promise_names(
    Case(
        __name__,
        "ransac_plane",
        {
            "points": _POINTS,
            "max_iterations": 90,
            "distance_tolerance": 0.2,
            "rng": np.random.default_rng(1),
        },
        expected=_ON_PLANE,
        compare=lambda answer, points, _, tolerance, __, on_plane: assert_finds_plane(
            answer, points, tolerance, on_plane
        ),
        precondition=require_plane_among_outliers,
    ),
    "keeps_the_names_of_ransac",
    why="Other code may call ransac_plane(points, max_iterations=50, distance_tolerance=0.2, "
    "rng=1), because the names explain the numbers.",
)


@note_check(
    "ransac_plane",
    title="Returns the mask as a NumPy array",
    why="The next cells select the remaining points with ~inliers, which does not work with a "
    "list. np.array(...) makes an array.",
)
def gives_a_mask_array(ransac_plane: Callable) -> None:
    points, _ = scattered_plane(1, 60, 30)
    _, inliers = ransac_plane(points, 50, 0.2, np.random.default_rng(1))
    if not isinstance(inliers, np.ndarray):
        raise CheckFailed(f"The mask is a {type(inliers).__name__}.")
