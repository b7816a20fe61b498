"""Assertions about the results of `ransac_plane`: a model and a mask of its inliers."""

from collections.abc import Sequence

import numpy as np

from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief, in_shape
from utils.checks.lesson_03.planes import as_plane, draw_on_edge
from utils.geometry import best_plane, gaps_from


def as_pair(answer: object) -> Sequence:
    """Return an answer as a pair, without judging its two parts."""
    if answer is None:
        raise WrongForm(
            "The function returned None. Does every way through it end with `return`?",
            yours="None",
            expected="(model, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise WrongForm(
            "Return two things, the model and the mask: `return model, inliers`.",
            yours=brief(answer),
            expected="(model, inliers)",
        )
    return answer


def as_model(answer: object, given: str | None = None) -> np.ndarray:
    """Return the model of an answer for points that have a plane; the mask is ignored.

    Parameters
    ----------
    answer : object
    given : str, optional
        The input of the function, for the message.

    Returns
    -------
    numpy.ndarray, shape (4,)
        A plane with a normal of any length.

    Raises
    ------
    CheckFailed
        If the model is None or is not a plane.
    """
    model, _ = as_pair(answer)
    if model is None:
        raise CheckFailed(
            "There is a plane, and none was found: the model is None.",
            given=given,
            yours="None",
            expected="four numbers (a, b, c, d)",
        )
    if as_array(model, what="four numbers (a, b, c, d)").dtype.kind == "b":
        raise WrongForm(
            "The first of the two things that are returned is a mask; the model comes first: "
            "`return model, inliers`.",
            yours=brief(model),
            expected="four numbers (a, b, c, d)",
        )
    return as_plane(model)


def as_mask(answer: object, n: int) -> np.ndarray:
    """Return the mask of an answer; the model is ignored.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    numpy.ndarray of bool, shape (n,)
    """
    mask = as_array(as_pair(answer)[1], what="a mask of True and False")
    if mask.shape == (0,) and n == 0:
        return mask.astype(bool)
    if mask.dtype != bool:
        raise WrongForm(
            "The inliers must be a mask, one True or False per point, not numbers or indices.",
            yours=brief(mask),
            expected=f"{n} times True or False",
        )
    return in_shape(mask, (n,), "one True or False for each point")


def assert_finds(
    answer: object,
    points: np.ndarray,
    distance_tolerance: float,
    belongs: np.ndarray,
    share: float = 0.9,
    given: str | None = None,
) -> None:
    """Assert that most points of the right plane are near the model; the mask is ignored.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
        Largest distance of a point that counts as near, in metres.
    belongs : numpy.ndarray of bool, shape (n,)
        True for the points of the right plane.
    share : float
        Share of these points that must be near the model.
    given : str, optional
        The input of the function, for the message.
    """
    plane = as_model(answer, given)
    near = gaps_from(points, plane) <= distance_tolerance
    found, total = np.count_nonzero(near & belongs), np.count_nonzero(belongs)
    if found < share * total:
        subject = f"{total} of the" if total < len(points) else "all"
        raise CheckFailed(
            "A plane with many more points near it exists: "
            f"{subject} {len(points)} points lie on it.",
            given=given,
            yours=f"{np.count_nonzero(near)} points within {distance_tolerance:g} m",
            expected=f"about {total}",
            draw=lambda: draw_on_edge(
                points, plane, near, distance_tolerance, best_plane(points[belongs])[0]
            ),
        )


def assert_nearest_are_inliers(answer: object, points: np.ndarray) -> None:
    """Assert that the inliers are the points nearest to the model, up to any distance.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane, mask = as_model(answer), as_mask(answer, len(points))
    gaps = gaps_from(points, plane)
    if not mask.any():
        raise CheckFailed(
            "There is a model, and the mask says that no point is near it.",
            yours="0 inliers",
            expected=f"at least the 3 points that the plane goes through; the nearest point is "
            f"{gaps.min():.2g} m away",
        )
    farthest, nearest = gaps[mask].max(), gaps[~mask].min(initial=np.inf)
    if farthest > nearest + 1e-4:
        raise CheckFailed(
            "The mask does not belong to the returned model: a point that is "
            f"{nearest:.3f} m away from that plane is no inlier, and one that is {farthest:.3f} m "
            "away is.",
            yours=f"{np.count_nonzero(mask)} inliers",
            draw=lambda: draw_on_edge(points, plane, mask, None),
        )


def assert_inliers_within_tolerance(
    answer: object, points: np.ndarray, distance_tolerance: float
) -> None:
    """Assert that the inliers are the points within the tolerance of the model.

    Either answer is accepted for points at the border.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
        Largest distance of an inlier, in metres.
    """
    plane, mask = as_model(answer), as_mask(answer, len(points))
    gaps = gaps_from(points, plane)
    clear = np.abs(gaps - distance_tolerance) > 1e-4
    wrong = np.flatnonzero((mask != (gaps <= distance_tolerance)) & clear)
    if len(wrong):
        first = wrong[0]
        article = "an" if mask[first] else "no"
        raise CheckFailed(
            f"With distance_tolerance={distance_tolerance:g} a point that is {gaps[first]:.3f} m "
            f"away from the returned plane is {article} inlier.",
            yours=f"{np.count_nonzero(mask)} inliers",
            expected=f"{np.count_nonzero(gaps <= distance_tolerance)} inliers",
            draw=lambda: draw_on_edge(points, plane, mask, distance_tolerance),
        )


def assert_nothing_found(answer: object, n: int) -> None:
    """Assert that the answer is (None, all False), because there is no plane.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.
    """
    model, inliers = as_pair(answer)
    if model is not None:
        raise CheckFailed(
            "No plane can be found here: the model must be None.",
            yours=brief(model),
            expected="None",
        )
    if as_mask(answer, n).any():
        raise CheckFailed(
            "Without a model there are no inliers: the mask must be all False.",
            yours=brief(np.asarray(inliers)),
            expected="all False",
        )
