"""Visible checks of `iterations_needed`."""

import math
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief, needs
from utils.checks.common_checks import Case
from utils.checks.core import visible
from utils.checks.diagnosis import Mistake, mistakes


def assert_number(answer: object) -> np.ndarray:
    """Assert that the answer is a single number, and return it.

    Returns
    -------
    numpy.ndarray, shape ()
    """
    number = as_array(answer, what="a whole number")
    if number.shape != ():
        raise WrongForm(
            "The answer is one number.", yours=f"shape {number.shape}", expected="one whole number"
        )
    return number


def assert_nearly(answer: object, expected: int, *case: object) -> None:
    """Assert that the answer is right, give or take one, because another check covers rounding.

    Parameters
    ----------
    answer : object
    expected : int
    *case : object
        The arguments of the call, for the message.
    """
    number = assert_number(answer)
    if not abs(float(number) - expected) <= 1:
        raise CheckFailed(
            "This is not the number of samples that it takes.",
            given=_call_text(case),
            yours=f"{number:g}",
            expected=str(expected),
        )


def assert_iterations(answer: object, expected: int, *case: object) -> None:
    """Assert that the answer is exactly the expected whole number.

    Parameters
    ----------
    answer : object
    expected : int
    *case : object
        The arguments of the call, for the message.
    """
    number = assert_number(answer)
    sides = {"given": _call_text(case), "yours": f"{number:g}", "expected": str(expected)}
    if number != np.round(number):
        raise CheckFailed("Half a round cannot be played: take the next whole number.", **sides)
    if number != expected:
        messages = {
            -1: "One sample fewer does not reach the confidence: round up, not down.",
            1: "One sample fewer would be enough.",
        }
        message = messages.get(
            float(number) - expected, "This is not the smallest number that suffices."
        )
        raise CheckFailed(message, **sides)


def assert_never(answer: object) -> None:
    """Assert that no number is enough: `math.inf`, or None."""
    if answer is None or (isinstance(answer, float) and answer == np.inf):
        return
    raise CheckFailed(
        "Without a single inlier no number of samples is enough.",
        given=_call_text((0.0, 3, 0.99)),
        yours=brief(answer),
        expected="math.inf",
    )


def _call_text(case: Sequence) -> str | None:
    names = ("inlier_ratio", "sample_size", "confidence")
    return ", ".join(f"{name} {value}" for name, value in zip(names, case, strict=False)) or None


def require_plain_cases(iterations_needed: Callable) -> None:
    """Assert that plain cases are right, give or take one; raise `NotYet` if not."""
    with needs("the number of samples is right, give or take one"):
        assert_nearly(iterations_needed(0.6, 3, 0.99), 19)
        assert_nearly(iterations_needed(0.3, 3, 0.99), 169)


def require_decreasing_numbers(iterations_needed: Callable) -> None:
    """Assert that more inliers need fewer samples; raise `NotYet` if not."""
    with needs("the more inliers there are, the fewer samples it takes"):
        for_few, for_more, for_most = (
            float(assert_number(iterations_needed(ratio, 3, 0.99))) for ratio in (0.2, 0.4, 0.7)
        )
        if not np.inf > for_few > for_more > for_most > 0:
            raise CheckFailed("The number does not fall as the share of inliers grows.")


@visible(
    "iterations_needed",
    weight=3,
    title="Right for a plane, give or take one",
    why="A hundred too few and the road is missed; a thousand too many and the frame is late.",
    hint="Solve 1 - (1 - w^s)^N >= confidence for N: a quotient of two logarithms.",
)
def reckons_the_number(iterations_needed: Callable) -> None:
    for ratio, expected in ((0.6, 19), (0.3, 169), (0.2, 574), (0.7, 11), (0.01, 4605168)):
        answer = iterations_needed(ratio, 3, 0.99)
        assert_nearly(answer, expected, ratio, 3, 0.99)


@visible(
    "iterations_needed",
    weight=2,
    title="The smallest whole number that reaches the confidence",
    why="One sample too few and the promise is broken.",
    hint="math.ceil rounds up to a whole number.",
)
def smallest_that_suffices(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for ratio, expected in ((0.6, 19), (0.4, 70), (0.75, 9), (0.8, 7), (0.98, 2), (0.999, 1)):
        assert_iterations(iterations_needed(ratio, 3, 0.99), expected, ratio, 3, 0.99)


@visible(
    "iterations_needed",
    weight=2,
    title="Follows sample_size",
    why="A line needs two points, a plane three: the same inliers, another number.",
    hint="s is sample_size: w is taken to that power.",
)
def follows_the_sample_size(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for size, expected in ((1, 7), (2, 17), (4, 72), (5, 146)):
        assert_nearly(iterations_needed(0.5, size, 0.99), expected, 0.5, size, 0.99)


@visible(
    "iterations_needed",
    weight=1,
    title="Follows confidence",
    why="One failure in a hundred is too many for a car that searches ten times a second.",
    hint="Take the logarithm of 1 - confidence, with the parameter and no number of your own.",
)
def follows_the_confidence(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for confidence, expected in ((0.8, 34), (0.9, 49), (0.999, 145), (0.9999, 193)):
        answer = iterations_needed(0.36, 3, confidence)
        assert_nearly(answer, expected, 0.36, 3, confidence)
    # The inlier ratio is larger than the confidence.
    assert_nearly(iterations_needed(0.7, 4, 0.6), 4, 0.7, 4, 0.6)


@visible(
    "iterations_needed",
    weight=2,
    title="With nothing but inliers, one sample is enough",
    why="log(0) waits here, in an empty car park without a single obstacle.",
    hint="Look at w = 1 before you take logarithms.",
)
def one_is_enough(iterations_needed: Callable) -> None:
    require_decreasing_numbers(iterations_needed)
    for ratio, size, confidence in ((1.0, 3, 0.99), (1, 2, 0.5)):
        answer = iterations_needed(ratio, size, confidence)
        if assert_number(answer) != 1:
            raise CheckFailed(
                "Every sample is good here: one is enough, and there must be one.",
                given=_call_text((ratio, size, confidence)),
                yours=brief(answer),
                expected="1",
            )


@visible(
    "iterations_needed",
    weight=2,
    title="Without inliers, no number is enough",
    why="0 would mean: no need to search. The truth is: no use in searching.",
    hint="Return math.inf (or np.inf) when w is 0: a division by log(1) would fail.",
)
def none_is_enough(iterations_needed: Callable) -> None:
    require_decreasing_numbers(iterations_needed)
    try:
        answer = iterations_needed(0.0, 3, 0.99)
    except Exception as error:  # a ValueError is an acceptable answer
        if "ValueError" not in (type(error).__name__, getattr(error, "type_name", "")):
            raise
    else:
        assert_never(answer)


common_checks.names(
    Case(
        __name__,
        "iterations_needed",
        {"inlier_ratio": 0.6, "sample_size": 3, "confidence": 0.99},
        expected=19,
        compare=lambda answer, *case: assert_nearly(answer, case[-1], *case[:-1]),
        precondition=require_plain_cases,
    ),
    "keeps_the_names_of_the_parameters",
    why="Whoever reads the docstring calls iterations_needed(inlier_ratio=..., ...).",
)


def iterations_by_counting(ratio: float, size: int, confidence: float) -> int | None:
    """Return the right answer to `iterations_needed`, found by counting up with sixty digits.

    Returns
    -------
    int or None
        None if rounding errors could change the answer, or if fewer than 400 samples are not
        enough.
    """
    with localcontext(prec=60):
        p_bad_sample, p_all_bad = 1 - Decimal(ratio) ** size, Decimal(1)
        allowed = 1 - Decimal(confidence)
        for n_samples in range(1, 400):
            p_all_bad *= p_bad_sample
            if abs(p_all_bad - allowed) < allowed * Decimal("1e-6"):
                return None
            if p_all_bad <= allowed:
                return n_samples
    return None


mistakes(
    "iterations_needed",
    Mistake(
        "It is rounded down; one sample fewer does not reach the confidence.",
        lambda right, *case: right - 1,
        "math.ceil rounds up; int(...) and // round down.",
    ),
    Mistake(
        "The exponent is missing: w is the chance that one point is good, w^s that a whole "
        "sample is.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 1, confidence),
    ),
    Mistake(
        "w is multiplied by s, where it takes the power: w^s is the chance that all of s points "
        "are good.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio * size, 1, confidence),
        "w ** sample_size, with two stars; w * sample_size may be above 1, which no chance is.",
    ),
    Mistake(
        "The exponent is always 3, whatever sample_size is.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 3, confidence),
        "w ** sample_size",
    ),
    Mistake(
        "The exponent is always 2, whatever sample_size is.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 2, confidence),
        "w ** sample_size",
    ),
    Mistake(
        "Inliers and outliers are swapped: 1 - w is taken where w is asked for.",
        lambda right, ratio, size, confidence: iterations_by_counting(1 - ratio, size, confidence),
    ),
    Mistake(
        "The logarithm is that of the confidence; it must be that of 1 - confidence, the chance "
        "to fail that is allowed.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, size, 1 - confidence),
    ),
    Mistake(
        "So many samples give one good one on average; the confidence does not count.",
        lambda right, ratio, size, confidence: math.ceil(1 / ratio**size),
        "Solve 1 - (1 - w^s)^N >= confidence for N.",
    ),
    # One confidence is below a half: there, swapping confidence and 1 - confidence gives too many
    # samples instead of too few.
    cases=(
        (0.6, 2, 0.9),
        (0.4, 3, 0.95),
        (0.65, 4, 0.99),
        (0.45, 2, 0.8),
        (0.35, 3, 0.3),
        (0.6, 3, 0.99),
        (0.2, 2, 0.9),
        (0.25, 3, 0.9),
    ),
    right=iterations_by_counting,
)
