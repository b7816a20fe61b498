"""Assertions about the results of `ransac_line`: a line and a mask of its inliers."""

import numpy as np

import utils
from utils.checks.assertions import TOLERANCE, CheckFailed, WrongForm, as_array, brief_text
from utils.checks.lesson_02.lines import as_line, distances_from


def as_line_and_mask(answer: object, n: int) -> tuple[np.ndarray | None, np.ndarray]:
    """Convert an answer to a pair of a line, which may be None, and a mask.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.

    Returns
    -------
    line : numpy.ndarray, shape (3,), or None
    mask : numpy.ndarray of bool, shape (n,)

    Raises
    ------
    CheckFailed
        If the answer is not such a pair.
    """
    if answer is None:
        raise WrongForm(
            "The function returned None. Does it end with `return line, inliers`?",
            yours="None",
            expected="a pair (line, inliers)",
        )
    if not isinstance(answer, (tuple, list)) or len(answer) != 2:
        raise WrongForm(
            "The function must return two values, the line and the mask.",
            yours=brief_text(answer),
            expected="a pair (line, inliers)",
        )
    line, inliers = answer
    if inliers is None:
        raise WrongForm(
            "The second returned value, the mask, is None.",
            yours="None",
            expected=f"{n} values, each True or False",
        )
    mask = as_array(inliers, description="a mask of True and False")
    if mask.shape == (3,) and n != 3 and isinstance(line, np.ndarray) and line.shape == (n,):
        raise WrongForm(
            "The two returned values are in the wrong order: return the line first, then the mask.",
            yours="(mask, line)",
            expected="(line, mask)",
        )
    if mask.size == 0:
        mask = mask.reshape(-1)
    if mask.shape != (n,) or not np.isin(mask, (0, 1)).all():
        raise WrongForm(
            f"The inliers must be a mask: True or False for each of the {n} points."
            f"{_kind_of_array(mask)}",
            yours=brief_text(mask),
            expected=f"shape ({n},), dtype bool",
        )
    mask = mask.astype(bool)
    return (None if line is None else as_line(line)), mask


def _kind_of_array(mask: np.ndarray) -> str:
    """Return a sentence about the content of an array that is not a mask; "" if unknown."""
    if mask.ndim == 2 and mask.shape[1] == 2:
        return " These are points."
    if mask.ndim == 1 and mask.dtype.kind in "iu" and (np.diff(mask) > 0).all():
        return " These are row numbers."
    return ""


def assert_mask_matches_line(
    answer: object, points: np.ndarray, tolerance: float
) -> tuple[np.ndarray, np.ndarray]:
    """Assert that the mask marks the points within the tolerance of the line returned with it.

    Parameters
    ----------
    answer : object
        The line and the mask that the student's function returned.
    points : numpy.ndarray, shape (n, 2)
    tolerance : float
        In metres.

    Returns
    -------
    line : numpy.ndarray, shape (3,)
    mask : numpy.ndarray of bool, shape (n,)
    """
    line, mask = as_line_and_mask(answer, len(points))
    if line is None:
        raise CheckFailed(
            "The line is None although the points differ.",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    distance = distances_from(line, points)
    # Rounding errors change the last digits, so both answers are accepted at the edge of the band.
    wrong = (mask != (distance <= tolerance)) & (np.abs(distance - tolerance) > TOLERANCE)
    if not wrong.any():
        return line, mask
    near, far = wrong & ~mask, wrong & mask
    parts = []
    if near.any():
        parts.append(
            f"Points within {tolerance:g} m of the line that are not marked: {near.sum()}."
        )
    if far.any():
        parts.append(f"Points farther away than {tolerance:g} m that are marked: {far.sum()}.")
    raise CheckFailed(
        " ".join(["The mask does not belong to the line.", *parts]),
        yours=inlier_count(mask),
        expected=inlier_count(distance <= tolerance),
        draw=lambda: utils.plots.line_model(
            np.asarray(points, dtype=float),
            line,
            mask,
            tolerance,
            title="your line, its band and your inliers",
        ),
    )


def inlier_count(mask: np.ndarray) -> str:
    """Return the number of inliers of a mask as text."""
    return "1 inlier" if mask.sum() == 1 else f"{mask.sum()} inliers"


def assert_nothing_found(answer: object, n: int) -> None:
    """Assert that the answer for too few points is None and a mask that is False everywhere."""
    line, mask = as_line_and_mask(answer, n)
    if line is not None or mask.any():
        raise CheckFailed(
            "There are no points, so there is no line."
            if n == 0
            else "A single point does not define a line.",
            yours=brief_text((line, mask)),
            expected="(None, all False)",
        )
