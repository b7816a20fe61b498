"""Divide and add points to the cent, so that the checks of an exercise add up to its points."""

from __future__ import annotations

from collections.abc import Sequence

from utils.checks.outcomes import Outcome


def shares(points: float, weights: Sequence[float]) -> list[float]:
    """Divide points by weight, to the cent, so that the parts add up exactly.

    This is the method of the largest remainder (Hamilton's). Each part is rounded down to a cent,
    and the cents that are left go to the largest fractions; of equal fractions the first wins.

    Parameters
    ----------
    points : float
        With two decimals at most.
    weights : sequence of float
        Positive.

    Returns
    -------
    list of float
        One for each weight; they add up to `points`.
    """
    cents, whole = round(100 * points), sum(weights)
    exact = [cents * weight / whole for weight in weights]
    rounded = [int(share) for share in exact]
    order = sorted(range(len(exact)), key=lambda row: (round(rounded[row] - exact[row], 9), row))
    for row in order[: cents - sum(rounded)]:
        rounded[row] += 1
    return [share / 100 for share in rounded]


def total(points: Sequence[float]) -> float:
    """Return the sum of some points, to the cent."""
    return sum(round(100 * share) for share in points) / 100


def points_of(points: float, outcomes: Sequence[Outcome]) -> float:
    """Return the points that an exercise earns: the shares of the checks that passed.

    Parameters
    ----------
    points : float
        Points of the whole exercise.
    outcomes : sequence of Outcome
        Outcomes of all its checks.
    """
    maxima = shares(points, [outcome.check.weight for outcome in outcomes])
    return total([share for share, one in zip(maxima, outcomes, strict=True) if not one.failure])
