"""Recognise known mistakes by their effect on the answers of a function.

Each mistake predicts the answers of a function that makes it. A mistake is reported if the function
returns the predicted answer in every case, if at least two of these answers are wrong, and if no
other known mistake explains them.
"""

import copy
import inspect
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from utils.checks.assertions import CheckFailed, as_array

_LEAST_WRONG_ANSWERS = 2


@dataclass(frozen=True)
class Mistake:
    """A common mistake in an exercise.

    Attributes
    ----------
    description : str
        One sentence about the code: "`<` is used instead of `<=`."
    predict : callable
        Takes the right answer and the arguments of a case; returns the answer with the mistake.
    hint : str
        How to fix it; empty if the sentence says so already.
    is_cheap : bool
        Whether a student could give the wrong answer without any work, for example labels that are
        all equal. The judge then counts it as a slip only if a single edit corrects the code.
    is_the_task : bool
        Whether avoiding the mistake is the point of the exercise. The judge then counts it as a
        slip only if a single edit corrects the code, and the answer keeps fewer points.
    """

    description: str
    predict: Callable
    hint: str = ""
    is_cheap: bool = False
    is_the_task: bool = False


@dataclass(frozen=True)
class _KnownMistakes:
    cases: tuple
    right: Callable
    mistakes: tuple[Mistake, ...]
    same: Callable
    call: Callable
    class_name: str


_KNOWN: dict[str, _KnownMistakes] = {}


def same_array(answer: object, predicted: object) -> bool:
    """Return whether an answer has the predicted shape and nearly the predicted numbers."""
    predicted = np.asarray(predicted)
    try:
        yours = as_array(answer)
    except CheckFailed:
        return False
    if yours.size == predicted.size == 0:
        return len(yours) == len(predicted)
    return yours.shape == predicted.shape and np.allclose(
        yours.astype(float), predicted.astype(float), rtol=1e-4, atol=1e-4, equal_nan=True
    )


def _plain_call(function: Callable, *case: object) -> object:
    return function(*case)


def declare_mistakes(
    exercise: str,
    *known: Mistake,
    cases: Sequence[tuple],
    right: Callable,
    is_same: Callable = same_array,
    call: Callable = _plain_call,
    class_name: str = "",
) -> None:
    """Declare the known mistakes of an exercise.

    Parameters
    ----------
    exercise : str
    known : Mistake
    cases : sequence of tuple
        Positional arguments of a few small calls.
    right : callable
        Takes the arguments of a case; returns the right answer.
    is_same : callable
        Takes an answer and a prediction; returns whether they are equal.
    call : callable
        Takes the function and the arguments of a case; returns the answer. By default, it calls
        the function with these arguments.
    class_name : str
        Name of the class that `call` takes instead of the function, if the exercise is a method.
    """
    _KNOWN[exercise] = _KnownMistakes(tuple(cases), right, known, is_same, call, class_name)


def object_to_diagnose(exercise: str) -> str:
    """Return the name of the object that `diagnose` takes: the exercise, or the class around it."""
    return exercise in _KNOWN and _KNOWN[exercise].class_name or exercise


def known_mistakes(exercise: str) -> tuple[Mistake, ...]:
    """Return the declared mistakes of an exercise."""
    return _KNOWN[exercise].mistakes if exercise in _KNOWN else ()


def diagnose(exercise: str, function: Callable) -> Mistake | None:
    """Return the mistake that explains the answers of a function, if there is exactly one.

    Parameters
    ----------
    exercise : str
    function : callable
        The student's function or class, or its proxy in the judge; see `object_to_diagnose`.

    Returns
    -------
    Mistake or None
        None if no mistake or several mistakes fit, or if a call fails.
    """
    known = _KNOWN.get(exercise)
    if known is None:
        return None
    fitting, wrong_answers = list(known.mistakes), Counter()
    for case in known.cases:
        right = known.right(*copy.deepcopy(case))
        predicted = {
            mistake: mistake.predict(copy.deepcopy(right), *copy.deepcopy(case))
            for mistake in fitting
        }
        try:
            answer = known.call(function, *copy.deepcopy(case))
            fitting = [mistake for mistake in fitting if known.same(answer, predicted[mistake])]
        except Exception:  # raised by the student's code or by comparing its result
            return None
        wrong_answers.update(
            mistake for mistake in fitting if not known.same(right, predicted[mistake])
        )
    fitting = [mistake for mistake in fitting if wrong_answers[mistake] >= _LEAST_WRONG_ANSWERS]
    return fitting[0] if len(fitting) == 1 else None


@dataclass(frozen=True)
class Imitation:
    """A function that makes one known mistake and no other.

    Attributes
    ----------
    call : callable
        The function, with the parameters of the exercise.
    same : callable
        Takes a student's answer and an answer of `call`; returns whether they are equal.
    """

    call: Callable
    same: Callable


def imitation_of(exercise: str, mistake: Mistake, right: Callable) -> Imitation | None:
    """Build a function that makes only this mistake, from a correct function.

    Parameters
    ----------
    exercise : str
    mistake : Mistake
    right : callable
        The lesson's own function, with the parameters of the exercise.

    Returns
    -------
    Imitation or None
        None if the exercise is not a plain function of its arguments, such as a method of a tree.
    """
    known = _KNOWN.get(exercise)
    if known is None or known.call is not _plain_call or known.class_name:
        return None
    signature = inspect.signature(right)

    def call(*arguments: object, **keywords: object) -> object:
        bound = signature.bind(*copy.deepcopy(arguments), **copy.deepcopy(keywords))
        bound.apply_defaults()
        answer = right(*copy.deepcopy(bound.args))
        if isinstance(answer, tuple):  # such as (a, b, c); predictions compute with arrays
            answer = np.array(answer)
        return None if answer is None else mistake.predict(answer, *bound.args)

    def same(answer: object, predicted: object) -> bool:
        return answer is None if predicted is None else known.same(answer, predicted)

    return Imitation(call, same)
