"""Points of a wall and clutter, and assertions about runs of `ransac_line` on them."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np

import utils
from utils.checks.assertions import CheckFailed, call_each
from utils.checks.failures import fixed
from utils.checks.lesson_02.lines import distances_from, lines_equal
from utils.checks.lesson_02.results import as_line_and_mask


def wall_and_clutter(
    seed: int | Sequence[int], n_wall: int, n_clutter: int, noise: float = 0.1
) -> tuple[np.ndarray, np.ndarray]:
    """Return shuffled points near a random line and points at least 1 m away from it.

    Parameters
    ----------
    seed : int or sequence of int
        Seed of the random generator that draws the line and the points.
    n_wall, n_clutter : int
        Number of points near the line, and of points away from it.
    noise : float
        Largest distance between the line and the points near it, in metres.

    Returns
    -------
    points : numpy.ndarray, shape (n_wall + n_clutter, 2)
        Points within about 15 m of the origin.
    on_line : numpy.ndarray of bool, shape (n_wall + n_clutter,)
        True for the points near the line.
    """
    rng = np.random.default_rng(seed)
    angle, offset = rng.uniform(0, np.pi), rng.uniform(-3, 3)
    direction = np.array([np.cos(angle), np.sin(angle)])
    normal = np.array([-direction[1], direction[0]])
    wall = np.outer(rng.uniform(-10, 10, n_wall), direction)
    wall += np.outer(offset + rng.uniform(-noise, noise, n_wall), normal)
    clutter = rng.uniform(-10, 10, (n_clutter, 2))
    offsets = clutter @ normal - offset
    shifts = np.where(np.abs(offsets) < 1, np.where(offsets < 0, -1.0, 1.0), 0.0)
    points = np.vstack([wall, clutter + np.outer(shifts, normal)])
    order = rng.permutation(len(points))
    return points[order], (np.arange(len(points)) < n_wall)[order]


def follows_wall(line: np.ndarray | None, wall: np.ndarray, tolerance: float) -> bool:
    """Return whether at least 80 % of the points of a wall are within the tolerance of a line.

    Parameters
    ----------
    line : numpy.ndarray, shape (3,), or None
    wall : numpy.ndarray, shape (n, 2)
    tolerance : float
        In metres.
    """
    return line is not None and (distances_from(line, wall) <= tolerance).mean() >= 0.8


def assert_finds_line(
    ransac_line: Callable,
    runs: Sequence[tuple[np.ndarray, np.ndarray]],
    needed: int,
    max_iterations: int,
    tolerance: float,
) -> None:
    """Assert that at least `needed` of the runs find the line; the masks are ignored.

    Parameters
    ----------
    ransac_line : callable
    runs : sequence of (points, on_line)
        One pair for each run, as returned by `wall_and_clutter`.
    needed, max_iterations : int
        Number of runs that must find the line, and number of rounds in each run.
    tolerance : float
        In metres.
    """
    answers, missed, found = [], [], 0
    for seed, (points, on_line) in enumerate(runs):
        line, mask = _run_once(ransac_line, points, max_iterations, tolerance, seed)
        answers.append((line, mask))
        if not follows_wall(line, points[on_line], tolerance):
            missed.append((points, line, mask))
            continue
        found += 1
        if found == needed:  # more runs would take time and could not change the result
            break
    if found < needed:
        n_without_line = sum(line is None for _, line, _ in missed)
        observation, hint = _explain_runs(answers, ransac_line, runs, max_iterations, tolerance)
        raise CheckFailed(
            f"The line was found in {found} of {len(runs)} runs."
            + (
                f" In {n_without_line} of the {len(runs)} runs, the answer was None."
                if n_without_line
                else ""
            )
            + observation,
            yours=f"found in {found} of {len(runs)} runs",
            expected=f"found in nearly all runs, with {max_iterations} rounds",
            hint=hint,
            draw=lambda: utils.plots.line_model(
                *missed[0], tolerance, title="a run that missed the line"
            ),
        )


def _run_once(
    ransac_line: Callable, points: np.ndarray, max_iterations: int, tolerance: float, seed: int
) -> tuple[np.ndarray | None, np.ndarray]:
    """Return the line and the mask of one run with a generator made from `seed`."""
    rng = np.random.default_rng(seed)
    return as_line_and_mask(ransac_line(points.copy(), max_iterations, tolerance, rng), len(points))


def answers_of_short_runs(
    ransac_line: Callable,
    points: np.ndarray,
    max_iterations: int,
    tolerance: float,
    generators: Iterable[np.random.Generator | int],
) -> list[tuple[np.ndarray | None, np.ndarray]]:
    """Return the lines and masks of many short runs, which share the time limit of one call."""
    calls = [(points, max_iterations, tolerance, rng) for rng in generators]
    return [as_line_and_mask(answer, len(points)) for answer in call_each(ransac_line, calls)]


def _explain_runs(
    answers: Sequence[tuple],
    ransac_line: Callable,
    runs: Sequence[tuple],
    max_iterations: int,
    tolerance: float,
) -> tuple[str, str]:
    """Return a sentence about a likely reason why runs missed the line, and a hint.

    Both are empty if no reason is known.
    """
    if any(line is None for line, _ in answers):
        return "", ""
    if not any(mask.any() for _, mask in answers):
        return (
            " Each run returned a line but not a single inlier.",
            "When you replace the best line, also replace the best mask.",
        )
    if all(
        np.array_equal(mask, distances_from(line, points) > tolerance)
        for (line, mask), (points, _) in zip(answers, runs, strict=True)
    ):
        return (
            " Each mask marks the points that are farther from the line than the threshold.",
            "Compare with <=: inliers have a distance of at most distance_tolerance.",
        )

    def run_all(n_rounds: int) -> list[tuple]:
        return [
            _run_once(ransac_line, points, n_rounds, tolerance, seed)
            for seed, (points, _) in enumerate(runs)
        ]

    after_one = run_all(1)
    both = list(zip(after_one, answers, strict=True))
    if all(lines_equal(first[0], last[0]) for first, last in both):
        masks_equal = all(np.array_equal(first[1], last[1]) for first, last in both)
        same = "the answers are the same" if masks_equal else "only the masks differ, not the lines"
        return (
            f" With {fixed('1 round')} instead of {max_iterations}, {same}.",
            "Create rng before the loop, draw a sample in each round, and return after the loop.",
        )
    after_half = run_all(max_iterations // 2)
    fewer = sum(
        last.sum() < first.sum() for (_, first), (_, last) in zip(after_half, answers, strict=True)
    )
    if fewer:
        return (
            f" In {fewer} of the {len(runs)} runs, the mask has fewer inliers after "
            f"{max_iterations} rounds than after {max_iterations // 2} rounds with the same "
            "seed.",
            "Replace the best line and mask only if the new mask has more inliers.",
        )
    return "", ""
