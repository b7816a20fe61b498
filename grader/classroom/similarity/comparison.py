"""Which answers of a class to an exercise are alike."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grader.classroom.similarity.answers import ComparedAnswer
from grader.classroom.similarity.weights import Document, Weights

# A pair is named if of all that is unusual in the two this much is in both,
LEAST_SHARE = 0.6
# and if that is so many bits more than it takes to name one pair among those of the class.
# `tests/test_similarity.py` measures what that finds, and what it finds wrongly.
LEAST_BITS = 7.0


@dataclass(frozen=True)
class Pair:
    """Two answers to one exercise that are alike.

    Attributes
    ----------
    exercise : str
    students : tuple of str
        Two.
    share : float
        How much of what is unusual in the two is in both.
    bits : float
        How unusual what they share is.
    alike : tuple of frozenset of int
        Of each of the two, places of the steps that the other has, too.
    steps : tuple of int
        How many steps each has.
    alone : int
        How many of these steps of the first are in no other answer.
    others : tuple of int
        How many other answers there are: in the class, and kept with the course.
    nearest : tuple of float
        The largest share of either of the two with one of these, and with one of those.
    """

    exercise: str
    students: tuple[str, str]
    share: float
    bits: float
    alike: tuple[frozenset[int], frozenset[int]]
    steps: tuple[int, int]
    alone: int
    others: tuple[int, int]
    nearest: tuple[float, float]


@dataclass(frozen=True)
class Comparison:
    """What comparing all answers to one exercise came to.

    Attributes
    ----------
    exercise : str
    written : int
        How many answers there are.
    telling : int
        How many of them hold enough that is unusual, to be told apart from others by it.
    pairs : tuple of Pair
        The most unusual first.
    """

    exercise: str
    written: int
    telling: int
    pairs: tuple[Pair, ...]


def compare(
    exercise: str,
    answers: Mapping[str, ComparedAnswer],
    kept: Sequence[ComparedAnswer] = (),
    taught: Iterable[ComparedAnswer] = (),
) -> Comparison:
    """Compare all answers to an exercise with each other.

    Parameters
    ----------
    exercise : str
    answers : dict of str to ComparedAnswer
        By student.
    kept : sequence of ComparedAnswer
        Right answers that are kept with the course. They stand beside the class, as others who
        wrote the same function.
    taught : iterable of ComparedAnswer
        What the lesson leads to.
    """
    mine = {student: Document(answer) for student, answer in answers.items()}
    beside = [Document(answer) for answer in kept]
    weights = Weights([*mine.values(), *beside], map(Document, taught))
    least = LEAST_BITS + math.log2(max(1, math.comb(len(mine), 2)))
    shares = {
        (one, other): weights.share(mine[one], mine[other])
        for one, other in itertools.combinations(mine, 2)
    }
    nearest, pairs = _two_nearest(shares), []
    for (one, other), share in shares.items():
        first, second = mine[one], mine[other]
        if share >= LEAST_SHARE and weights.bits(first, second) >= least:
            pairs.append(
                Pair(
                    exercise,
                    (one, other),
                    share,
                    weights.bits(first, second),
                    (first.steps_like(second), second.steps_like(first)),
                    (len(first.steps), len(second.steps)),
                    weights.only_theirs(first, second),
                    (len(mine) - 2, len(beside)),
                    (_nearest((one, other), nearest), _nearest_of(first, second, beside, weights)),
                )
            )
    pairs.sort(key=lambda pair: -pair.bits)
    telling = sum(weights.bits_of_copy(document) >= least for document in mine.values())
    return Comparison(exercise, len(mine), telling, tuple(pairs))


def _two_nearest(shares: Mapping[tuple[str, str], float]) -> dict[str, list[tuple[float, str]]]:
    """For each student the two who come nearest, and how near."""
    found: dict[str, list[tuple[float, str]]] = {}
    for both, share in shares.items():
        for who, whom in (both, both[::-1]):
            nearest = found.setdefault(who, [])
            nearest.append((share, whom))
            nearest.sort(reverse=True)
            del nearest[2:]
    return found


def _nearest(pair: tuple[str, str], nearest: Mapping[str, list[tuple[float, str]]]) -> float:
    """The largest share of either of two students with anybody else of the class."""
    return max(
        (share for who in pair for share, whom in nearest[who] if whom not in pair), default=0.0
    )


def _nearest_of(
    first: Document, second: Document, beside: Sequence[Document], weights: Weights
) -> float:
    """The largest share of either of two answers with one that is kept with the course."""
    both = itertools.product((first, second), beside)
    return max((weights.share(one, other) for one, other in both), default=0.0)
