"""Points to the cent: what is shown for the checks of an exercise adds up to what it earns."""

from __future__ import annotations

from collections.abc import Sequence

from utils.checks.outcomes import Outcome


def shares(points: float, weights: Sequence[float]) -> list[float]:
    """Divide points by weight, to the cent, so that nothing is lost.

    The method of the largest remainder (Hamilton's): everybody gets their share without its
    fraction of a cent, and the cents that are left go to the largest fractions, the first of equals
    first.

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
    given = [int(share) for share in exact]
    order = sorted(range(len(exact)), key=lambda row: (round(given[row] - exact[row], 9), row))
    for row in order[: cents - sum(given)]:
        given[row] += 1
    return [share / 100 for share in given]


def total(points: Sequence[float]) -> float:
    """Sum of points, to the cent."""
    return sum(round(100 * share) for share in points) / 100


def points_of(points: float, outcomes: Sequence[Outcome]) -> float:
    """What an exercise earns: the shares of the checks that hold.

    Parameters
    ----------
    points : float
        Of the exercise.
    outcomes : sequence of Outcome
        All of its checks.
    """
    most = shares(points, [outcome.check.weight for outcome in outcomes])
    return total([share for share, one in zip(most, outcomes, strict=True) if not one.failure])
