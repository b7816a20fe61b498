"""Assertions about the results of `ransac_plane`: a model and a mask of its inliers."""

from collections.abc import Sequence

import numpy as np

from utils.checks.assertions import CheckFailed, WrongForm, as_array, as_shape, brief_text
from utils.checks.lesson_03.planes import as_plane, draw_edge_on
from utils.geometry import best_plane, distances_from_plane


def as_pair(answer: object) -> Sequence:
    """Return an answer as a pair, without checking its two values."""
    if answer is None:
        raise WrongForm(
            "The function returned None. End every path through it with `return` and the result.",
            yours="None",
            expected="(model, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise WrongForm(
            "Return two values, the model and the mask: `return model, inliers`.",
            yours=brief_text(answer),
            expected="(model, inliers)",
        )
    return answer


def as_model(answer: object, input_text: str | None = None) -> np.ndarray:
    """Return the model of an answer for points that contain a plane; ignore the mask.

    Parameters
    ----------
    answer : object
    input_text : str, optional
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
            "The model is None, although the points contain a plane.",
            input_text=input_text,
            yours="None",
            expected="four numbers (a, b, c, d)",
        )
    if as_array(model, description="four numbers (a, b, c, d)").dtype.kind == "b":
        raise WrongForm(
            "The first returned value is a mask, but the model comes first: `return model, "
            "inliers`.",
            yours=brief_text(model),
            expected="four numbers (a, b, c, d)",
        )
    return as_plane(model)


def as_mask(answer: object, n: int) -> np.ndarray:
    """Return the mask of an answer; ignore the model.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    numpy.ndarray of bool, shape (n,)
    """
    mask = as_array(as_pair(answer)[1], description="a mask of True and False")
    if mask.shape == (0,) and n == 0:
        return mask.astype(bool)
    if mask.dtype != bool:
        raise WrongForm(
            "The inliers must be a mask with one True or False per point, not numbers or indices.",
            yours=brief_text(mask),
            expected=f"{n} values, each True or False",
        )
    return as_shape(mask, (n,), "one True or False for each point")


def assert_finds_plane(
    answer: object,
    points: np.ndarray,
    distance_tolerance: float,
    on_plane: np.ndarray,
    share: float = 0.9,
    input_text: str | None = None,
) -> None:
    """Assert that most points of the right plane are near the model; ignore the mask.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
        Largest distance of a point that counts as near, in metres.
    on_plane : numpy.ndarray of bool, shape (n,)
        True for the points of the right plane.
    share : float
        Share of these points that must be near the model.
    input_text : str, optional
        The input of the function, for the message.
    """
    plane = as_model(answer, input_text)
    near = distances_from_plane(points, plane) <= distance_tolerance
    found, total = np.count_nonzero(near & on_plane), np.count_nonzero(on_plane)
    if found < share * total:
        subject = f"{total} of the" if total < len(points) else "all"
        raise CheckFailed(
            f"There is a plane with many more points near it: {subject} {len(points)} points "
            "lie on it.",
            input_text=input_text,
            yours=f"{np.count_nonzero(near)} points within {distance_tolerance:g} m",
            expected=f"about {total}",
            draw=lambda: draw_edge_on(
                points, plane, near, distance_tolerance, best_plane(points[on_plane])[0]
            ),
        )


def assert_nearest_are_inliers(answer: object, points: np.ndarray) -> None:
    """Assert that the inliers are the points nearest to the model, for any threshold.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    plane, mask = as_model(answer), as_mask(answer, len(points))
    gaps = distances_from_plane(points, plane)
    if not mask.any():
        raise CheckFailed(
            "The function returned a model, but its mask does not mark any points.",
            yours="0 inliers",
            expected=f"at least 3 inliers; the nearest point is {gaps.min():.2g} m away",
        )
    farthest, nearest = gaps[mask].max(), gaps[~mask].min(initial=np.inf)
    if farthest > nearest + 1e-4:
        raise CheckFailed(
            f"The mask does not belong to the returned model: a point {nearest:.3f} m away from "
            f"that plane is not an inlier, but one that is {farthest:.3f} m away is.",
            yours=f"{np.count_nonzero(mask)} inliers",
            draw=lambda: draw_edge_on(points, plane, mask, None),
        )


def assert_inliers_within_tolerance(
    answer: object, points: np.ndarray, distance_tolerance: float
) -> None:
    """Assert that the inliers are the points within the tolerance of the model.

    Both answers are accepted for points at exactly this distance.

    Parameters
    ----------
    answer : object
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    distance_tolerance : float
        Largest distance of an inlier, in metres.
    """
    plane, mask = as_model(answer), as_mask(answer, len(points))
    gaps = distances_from_plane(points, plane)
    clear = np.abs(gaps - distance_tolerance) > 1e-4
    wrong = np.flatnonzero((mask != (gaps <= distance_tolerance)) & clear)
    if len(wrong):
        first = wrong[0]
        verb = "is" if mask[first] else "is not"
        raise CheckFailed(
            f"With distance_tolerance={distance_tolerance:g}, a point {gaps[first]:.3f} m away "
            f"from the returned plane {verb} an inlier.",
            yours=f"{np.count_nonzero(mask)} inliers",
            expected=f"{np.count_nonzero(gaps <= distance_tolerance)} inliers",
            draw=lambda: draw_edge_on(points, plane, mask, distance_tolerance),
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
            "These points do not define a plane: the model must be None.",
            yours=brief_text(model),
            expected="None",
        )
    if as_mask(answer, n).any():
        raise CheckFailed(
            "Without a model there are no inliers: the mask must be all False.",
            yours=brief_text(np.asarray(inliers)),
            expected="all False",
        )
