"""Functions that convert and compare the results of the four steps of a tracker."""

from __future__ import annotations

import numpy as np

from utils.checks.assertions import WrongForm, as_array, brief_text, frozen
from utils.checks.diagnosis import same_array

NO_BOXES = frozen(np.empty((0, 8, 3)))


def centres_of(boxes: np.ndarray) -> np.ndarray:
    """Return the centres of boxes, rounded to a tenth of a millimetre."""
    return np.round(boxes.mean(axis=1), 4) + 0.0


def as_boxes(answer: object, n: int) -> np.ndarray:
    """Convert an answer to an array of n boxes, shape (n, 8, 3)."""
    boxes = as_array(answer, description="an array of boxes")
    if boxes.size == 0 and n == 0:
        return NO_BOXES
    if boxes.shape != (n, 8, 3):
        note = " These are centres: move all eight corners." if boxes.shape == (n, 3) else ""
        raise WrongForm(
            f"There must be eight corners for each of the {n} boxes.{note}",
            yours=f"shape {boxes.shape}",
            expected=f"shape ({n}, 8, 3)",
        )
    return boxes


def as_pair(answer: object, names: tuple[str, str]) -> tuple[object, object]:
    """Return the two results of a step, without checking them."""
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise WrongForm(
            f"The step must return two results: {' and '.join(names)}.",
            yours=brief_text(answer),
            expected=", ".join(names),
        )
    return answer[0], answer[1]


def as_counts_and_flags(
    answer: object, names: tuple[str, str], n: int, noun: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a step: a count, and True or False, for each of the n rows."""
    counts, flags = map(as_array, as_pair(answer, names))
    if counts.dtype.kind == "b" and flags.dtype.kind in "iuf":
        raise WrongForm(
            f"The two results are in the wrong order: {names[0]} comes first, then {names[1]}.",
            yours=f"{brief_text(counts)}, {brief_text(flags)}",
            expected="numbers, then True or False",
        )
    for name, values in zip(names, (counts, flags), strict=True):
        if values.shape != (n,) and not values.size == n == 0:
            raise WrongForm(
                f"There must be one entry of {name} for each of the {n} {noun}.",
                yours=f"shape {values.shape}: {brief_text(values)}",
                expected=f"shape ({n},)",
            )
    return counts, flags.astype(bool)


def same_pair(answer: object, predicted: tuple) -> bool:
    """Return whether an answer has the two predicted results."""
    return (
        isinstance(answer, tuple | list)
        and len(answer) == len(predicted)
        and all(map(same_array, answer, predicted))
    )
