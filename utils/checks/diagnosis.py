"""What somebody did, told only where it explains the answers and nothing else does.

A mistake predicts what a function would return that makes it. It is told if the function returns
just that on every case, two of which at least tell it from a right answer, and if no other
mistake of the exercise predicts the same.
"""

import copy
import inspect
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from utils.checks.assertions import CheckFailed, as_array

_TELLING_CASES = 2


@dataclass(frozen=True)
class Mistake:
    """One thing that people do.

    Attributes
    ----------
    says : str
        What it is, in a sentence about the code: "`<` stands where `<=` is asked for."
    predicts : callable
        Takes the right answer and then the arguments of a case; returns what the mistake would.
    hint : str
        What to do about it; empty where the sentence says so.
    is_cheap : bool
        Whether it is made without looking at the task. Then its name proves no slip; an edit does.
    is_the_task : bool
        Whether the exercise is about just this. Then it is no slip, however small the change.
    """

    says: str
    predicts: Callable
    hint: str = ""
    is_cheap: bool = False
    is_the_task: bool = False


@dataclass(frozen=True)
class _Known:
    cases: tuple
    right: Callable
    mistakes: tuple[Mistake, ...]
    same: Callable
    ask: Callable
    through: str


_KNOWN: dict[str, _Known] = {}


def same_array(answer: object, predicted: object) -> bool:
    """Whether an answer is an array of this shape and, nearly, these numbers."""
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


def _called(function: Callable, *case: object) -> object:
    return function(*case)


def mistakes(
    exercise: str,
    *known: Mistake,
    cases: Sequence[tuple],
    right: Callable,
    same: Callable = same_array,
    ask: Callable = _called,
    through: str = "",
) -> None:
    """Declare the usual mistakes of an exercise.

    Parameters
    ----------
    exercise : str
    known : Mistake
    cases : sequence of tuple
        Positional arguments of some small calls.
    right : callable
        Takes the arguments of a case; returns the right answer.
    same : callable
        Takes an answer and a prediction: whether they are the same.
    ask : callable
        Takes the function and the arguments of a case; returns the answer. By default it calls
        the function with them.
    through : str
        Name of the class that `ask` takes in place of the function, where the exercise is one of
        its methods.
    """
    _KNOWN[exercise] = _Known(tuple(cases), right, known, same, ask, through)


def asked_through(exercise: str) -> str:
    """Name of what `diagnose` takes: the exercise itself, or the class that it belongs to."""
    return exercise in _KNOWN and _KNOWN[exercise].through or exercise


def known_mistakes(exercise: str) -> tuple[Mistake, ...]:
    """What can be told about an exercise."""
    return _KNOWN[exercise].mistakes if exercise in _KNOWN else ()


def diagnose(exercise: str, function: Callable) -> Mistake | None:
    """The mistake that explains the answers of a function.

    Parameters
    ----------
    exercise : str
    function : callable
        The student's, or what stands for it in the judge; see `asked_through`.

    Returns
    -------
    Mistake or None
        None where none does, more than one does, or there is no answer to compare.
    """
    known = _KNOWN.get(exercise)
    if known is None:
        return None
    fitting, telling = list(known.mistakes), Counter()
    for case in known.cases:
        right = known.right(*copy.deepcopy(case))
        predicted = {
            mistake: mistake.predicts(copy.deepcopy(right), *copy.deepcopy(case))
            for mistake in fitting
        }
        try:
            answer = known.ask(function, *copy.deepcopy(case))
            fitting = [mistake for mistake in fitting if known.same(answer, predicted[mistake])]
        except Exception:  # of the student's code, or of a comparison with whatever it returned
            return None
        telling.update(mistake for mistake in fitting if not known.same(right, predicted[mistake]))
    fitting = [mistake for mistake in fitting if telling[mistake] >= _TELLING_CASES]
    return fitting[0] if len(fitting) == 1 else None


@dataclass(frozen=True)
class Player:
    """A function that makes one mistake and no other.

    Attributes
    ----------
    plays : callable
        Takes what the exercise takes.
    same : callable
        Takes an answer and one of its own: whether they are the same.
    """

    plays: Callable
    same: Callable


def player_of(exercise: str, mistake: Mistake, right: Callable) -> Player | None:
    """Whoever makes a mistake of an exercise, made of a right function.

    Parameters
    ----------
    exercise : str
    mistake : Mistake
    right : callable
        The lesson's own function, with the parameters of the exercise.

    Returns
    -------
    Player or None
        None for what is more than a function of its arguments, such as a method of a tree.
    """
    known = _KNOWN.get(exercise)
    if known is None or known.ask is not _called or known.through:
        return None
    signature = inspect.signature(right)

    def plays(*arguments: object, **keywords: object) -> object:
        bound = signature.bind(*copy.deepcopy(arguments), **copy.deepcopy(keywords))
        bound.apply_defaults()
        return mistake.predicts(right(*copy.deepcopy(bound.args)), *bound.args)

    return Player(plays, known.same)
