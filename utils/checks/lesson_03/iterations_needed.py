"""Visible checks of `iterations_needed`."""

import math
from collections.abc import Callable, Sequence
from decimal import Decimal, localcontext

import numpy as np

from utils.checks import common_checks
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief_text, precondition
from utils.checks.common_checks import Case
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes


def assert_number(answer: object) -> np.ndarray:
    """Assert that the answer is a single number, and return it.

    Returns
    -------
    numpy.ndarray, shape ()
    """
    number = as_array(answer, description="a whole number")
    if number.shape != ():
        raise WrongForm(
            "The answer must be a single number.",
            yours=f"shape {number.shape}",
            expected="one whole number",
        )
    return number


def assert_nearly_right(answer: object, expected: int, *case: object) -> None:
    """Assert that the answer is right to within one, because another check covers rounding.

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
            "The number of samples is wrong.",
            input_text=_call_text(case),
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
    sides = {"input_text": _call_text(case), "yours": f"{number:g}", "expected": str(expected)}
    if number != np.round(number):
        raise CheckFailed("A number of rounds must be whole: round up.", **sides)
    if number != expected:
        messages = {
            -1: "This many samples do not reach the confidence: round up, not down.",
            1: "One sample fewer would be enough.",
        }
        message = messages.get(
            float(number) - expected, "This is not the smallest number of samples that is enough."
        )
        hint = "Round up with math.ceil, and do not add 1." if number == expected + 1 else ""
        raise CheckFailed(message, **sides, hint=hint)


def assert_infinite(answer: object) -> None:
    """Assert that the answer is `math.inf` or None: no number of samples is enough."""
    if answer is None or (isinstance(answer, float) and answer == np.inf):
        return
    raise CheckFailed(
        "Without inliers, no number of samples is enough.",
        input_text=_call_text((0.0, 3, 0.99)),
        yours=brief_text(answer),
        expected="math.inf",
    )


def _call_text(case: Sequence) -> str | None:
    names = ("inlier_ratio", "sample_size", "confidence")
    return ", ".join(f"{name}={value}" for name, value in zip(names, case, strict=False)) or None


def require_plain_cases(iterations_needed: Callable) -> None:
    """Raise `NotYet` if plain cases are wrong by more than one."""
    with precondition("the number of samples is right to within one"):
        assert_nearly_right(iterations_needed(0.6, 3, 0.99), 19)
        assert_nearly_right(iterations_needed(0.3, 3, 0.99), 169)


def require_decreasing_numbers(iterations_needed: Callable) -> None:
    """Raise `NotYet` unless the number of samples falls as the share of inliers rises."""
    with precondition("more inliers need fewer samples"):
        for_few, for_more, for_most = (
            float(assert_number(iterations_needed(ratio, 3, 0.99))) for ratio in (0.2, 0.4, 0.7)
        )
        if not np.inf > for_few > for_more > for_most > 0:
            raise CheckFailed("The number does not decrease as the share of inliers increases.")


@visible_check(
    "iterations_needed",
    weight=3,
    title="Finds the number of samples for a plane, to within one",
    why="With too few rounds, RANSAC misses the road; with too many, its result comes too late.",
    hint="Divide math.log(1 - confidence) by math.log(1 - inlier_ratio ** sample_size).",
)
def computes_the_number(iterations_needed: Callable) -> None:
    for ratio, expected in ((0.6, 19), (0.3, 169), (0.2, 574), (0.7, 11), (0.01, 4605168)):
        answer = iterations_needed(ratio, 3, 0.99)
        assert_nearly_right(answer, expected, ratio, 3, 0.99)


@visible_check(
    "iterations_needed",
    weight=2,
    title="Returns the smallest whole number that reaches the confidence",
    why="With one sample too few, RANSAC succeeds less often than the confidence promises.",
    hint="Use math.ceil, which rounds up to a whole number.",
)
def rounds_up(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for ratio, expected in ((0.6, 19), (0.4, 70), (0.75, 9), (0.8, 7), (0.98, 2), (0.999, 1)):
        assert_iterations(iterations_needed(ratio, 3, 0.99), expected, ratio, 3, 0.99)


@visible_check(
    "iterations_needed",
    weight=2,
    title="Works for any sample_size",
    why="A sample has two points for a line but three for a plane, so a plane needs more samples.",
    hint="Write inlier_ratio ** sample_size.",
)
def uses_the_sample_size(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for size, expected in ((1, 7), (2, 17), (4, 72), (5, 146)):
        assert_nearly_right(iterations_needed(0.5, size, 0.99), expected, 0.5, size, 0.99)


@visible_check(
    "iterations_needed",
    weight=1,
    title="Works for any confidence",
    why="One failure in a hundred is too many for a car that searches ten times a second.",
    hint="Take math.log of 1 - confidence, with the parameter instead of a fixed number.",
)
def uses_the_confidence(iterations_needed: Callable) -> None:
    require_plain_cases(iterations_needed)
    for confidence, expected in ((0.8, 34), (0.9, 49), (0.999, 145), (0.9999, 193)):
        answer = iterations_needed(0.36, 3, confidence)
        assert_nearly_right(answer, expected, 0.36, 3, confidence)
    # Here the inlier ratio is larger than the confidence.
    assert_nearly_right(iterations_needed(0.7, 4, 0.6), 4, 0.7, 4, 0.6)


@visible_check(
    "iterations_needed",
    weight=2,
    title="Returns 1 if all points are inliers",
    why="In an empty car park all points are ground, and the formula would take log(0).",
    hint="Return 1 if inlier_ratio is 1, before you take logarithms.",
)
def returns_one_without_outliers(iterations_needed: Callable) -> None:
    require_decreasing_numbers(iterations_needed)
    for ratio, size, confidence in ((1.0, 3, 0.99), (1, 2, 0.5)):
        answer = iterations_needed(ratio, size, confidence)
        if assert_number(answer) != 1:
            raise CheckFailed(
                "Every sample is good here, so you need exactly one.",
                input_text=_call_text((ratio, size, confidence)),
                yours=brief_text(answer),
                expected="1",
            )


@visible_check(
    "iterations_needed",
    weight=2,
    title="Returns infinity if there are no inliers",
    why="Without inliers no search can succeed, but an answer of 0 would mean that no round is "
    "needed.",
    hint="Return math.inf if inlier_ratio is 0, because the formula would divide by log(1) = 0.",
)
def returns_infinity_without_inliers(iterations_needed: Callable) -> None:
    require_decreasing_numbers(iterations_needed)
    try:
        answer = iterations_needed(0.0, 3, 0.99)
    except Exception as error:  # a ValueError is an acceptable answer
        if "ValueError" not in (type(error).__name__, getattr(error, "type_name", "")):
            raise
    else:
        assert_infinite(answer)


common_checks.promise_names(
    Case(
        __name__,
        "iterations_needed",
        {"inlier_ratio": 0.6, "sample_size": 3, "confidence": 0.99},
        expected=19,
        compare=lambda answer, *case: assert_nearly_right(answer, case[-1], *case[:-1]),
        precondition=require_plain_cases,
    ),
    "keeps_the_names_of_the_parameters",
    why="Other code may call iterations_needed(inlier_ratio=0.6, sample_size=3, confidence=0.99), "
    "because the names explain the numbers.",
)


def iterations_by_counting(ratio: float, size: int, confidence: float) -> int | None:
    """Return the right answer to `iterations_needed`, found by counting with 60 digits.

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


declare_mistakes(
    "iterations_needed",
    Mistake(
        "The function rounds the number down, so it is too small to reach the confidence.",
        lambda right, *case: right - 1,
        "Use math.ceil, which rounds up. int(...) and // round down.",
    ),
    Mistake(
        "The exponent is missing: w is the chance that one point is good, and w^s is the chance "
        "that a whole sample is good.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 1, confidence),
    ),
    Mistake(
        "w is multiplied by s instead of raised to the power s: w^s is the chance that all s "
        "points are good.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio * size, 1, confidence),
        "Write inlier_ratio ** sample_size with two asterisks. inlier_ratio * sample_size may be "
        "above 1, which is not a probability.",
    ),
    Mistake(
        "The exponent is always 3. It should be sample_size.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 3, confidence),
        "Write inlier_ratio ** sample_size.",
    ),
    Mistake(
        "The exponent is always 2. It should be sample_size.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, 2, confidence),
        "Write inlier_ratio ** sample_size.",
    ),
    Mistake(
        "Inliers and outliers are swapped: use w instead of 1 - w.",
        lambda right, ratio, size, confidence: iterations_by_counting(1 - ratio, size, confidence),
    ),
    Mistake(
        "The function takes the logarithm of the confidence; it must take the logarithm of 1 - "
        "confidence, the allowed chance of failure.",
        lambda right, ratio, size, confidence: iterations_by_counting(ratio, size, 1 - confidence),
    ),
    Mistake(
        "The function returns the number of samples that gives one good sample on average, and "
        "ignores the confidence.",
        lambda right, ratio, size, confidence: math.ceil(1 / ratio**size),
        "Solve 1 - (1 - w^s)^N >= confidence for N.",
        is_cheap=True,
    ),
    # One confidence is below 0.5. There, confusing confidence with 1 - confidence gives too many
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
