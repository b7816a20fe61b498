"""Functions that convert, measure, compare and print lines for the checks of lesson 02."""

import numpy as np

from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief_text
from utils.checks.failures import fixed


def as_line(answer: object) -> np.ndarray:
    """Convert an answer to an array with the three numbers of a line.

    Returns
    -------
    numpy.ndarray, shape (3,)

    Raises
    ------
    CheckFailed
        If the answer is None or is not three finite numbers.
    """
    if answer is None:
        raise WrongForm(
            "The function returned None although the points differ. Does every path through it "
            "end with `return`?",
            yours="None",
            expected="three numbers (a, b, c)",
        )
    line = as_array(answer, description="three numbers (a, b, c)").astype(float)
    if line.shape != (3,):
        raise WrongForm(
            "A line is three numbers (a, b, c).", yours=f"shape {line.shape}", expected="shape (3,)"
        )
    if not np.isfinite(line).all():
        raise CheckFailed("Some of the three numbers are not finite.", yours=brief_text(line))
    return line


def normal_length(line: np.ndarray) -> float:
    """Return the length of the normal (a, b); raise `CheckFailed` if it is 0."""
    length = float(np.hypot(line[0], line[1]))
    if length < 1e-9:
        raise CheckFailed(
            fixed("The normal (a, b) has length 0, so the line has no direction."),
            yours=brief_text(line),
        )
    return length


def distances_from(line: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the distances of points from a line with a normal of any length; shape (n,)."""
    values = np.asarray(points, dtype=float) @ line[:2] + line[2]
    return np.abs(values) / normal_length(line)


def lines_equal(first: np.ndarray | None, second: np.ndarray | None) -> bool:
    """Return whether two lines have the same numbers, up to rounding, or are both None."""
    if first is None or second is None:
        return first is second
    return bool(np.allclose(first, second))


def line_text(line: np.ndarray | None) -> str:
    """Return the three numbers of a line as text; "None" if there is no line."""
    return "None" if line is None else brief_text(line)
