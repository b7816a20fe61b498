"""Divide and add points in exact hundredths, so that checks add up to the exercise's points."""

from __future__ import annotations

from collections.abc import Sequence

from utils.checks.outcomes import Outcome


def divide_points(points: float, weights: Sequence[float]) -> list[float]:
    """Divide points by weight into whole hundredths that add up exactly.

    This is the largest remainder method (Hamilton's method). Each share is rounded down to a
    hundredth, and the remaining hundredths go to the shares with the largest remainders. If
    remainders are equal, the first share wins.

    Parameters
    ----------
    points : float
        At most two decimals.
    weights : sequence of float
        Positive.

    Returns
    -------
    list of float
        One share for each weight.
    """
    cents, whole = round(100 * points), sum(weights)
    exact = [cents * weight / whole for weight in weights]
    rounded = [int(share) for share in exact]
    order = sorted(range(len(exact)), key=lambda row: (round(rounded[row] - exact[row], 9), row))
    for row in order[: cents - sum(rounded)]:
        rounded[row] += 1
    return [share / 100 for share in rounded]


def sum_points(points: Sequence[float]) -> float:
    """Return the exact sum of points that have at most two decimals."""
    return sum(round(100 * share) for share in points) / 100


def points_of(points: float, outcomes: Sequence[Outcome]) -> float:
    """Return the points that an exercise earns: the shares of the checks that passed.

    Parameters
    ----------
    points : float
        The exercise's maximum.
    outcomes : sequence of Outcome
        The outcomes of all checks of the exercise.
    """
    maxima = divide_points(points, [outcome.check.weight for outcome in outcomes])
    return sum_points(
        [share for share, outcome in zip(maxima, outcomes, strict=True) if not outcome.failure]
    )
