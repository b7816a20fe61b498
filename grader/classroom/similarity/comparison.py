"""Find the similar answers of a class to one exercise."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from grader.classroom.similarity.answers import ComparedAnswer
from grader.classroom.similarity.weights import Document, Weights

# A reported pair shares at least this fraction of its unusual parts, and at least this much
# information, in bits above log2 of the number of pairs in the class. `tests/test_similarity.py`
# measures hits and false alarms.
MIN_SHARE = 0.6
MIN_BITS = 7.0


@dataclass(frozen=True)
class Pair:
    """Two similar answers to one exercise.

    Attributes
    ----------
    exercise : str
    students : tuple of str
        The two students.
    share : float
        Fraction of the two answers' unusual parts that they have in common.
    bits : float
        How unusual the common part is, in bits.
    similar_steps : tuple of frozenset of int
        For each answer, the indices of its statements that the other answer also contains.
    step_counts : tuple of int
        The number of statements in each answer.
    exclusive_steps : int
        The number of common statements that no third answer has.
    other_counts : tuple of int
        The number of other answers in the class, and of answers kept with the course.
    nearest_shares : tuple of float
        The largest share between one of the two answers and a third answer in the class, and
        between one of them and a kept answer.
    """

    exercise: str
    students: tuple[str, str]
    share: float
    bits: float
    similar_steps: tuple[frozenset[int], frozenset[int]]
    step_counts: tuple[int, int]
    exclusive_steps: int
    other_counts: tuple[int, int]
    nearest_shares: tuple[float, float]


@dataclass(frozen=True)
class Comparison:
    """The comparison of all answers to one exercise.

    Attributes
    ----------
    exercise : str
    answer_count : int
        The number of answers.
    distinctive_count : int
        The number of answers with enough unusual parts to distinguish them from others.
    pairs : tuple of Pair
        Similar pairs, the most unusual first.
    """

    exercise: str
    answer_count: int
    distinctive_count: int
    pairs: tuple[Pair, ...]


def compare(
    exercise: str,
    answers: Mapping[str, ComparedAnswer],
    kept_answers: Sequence[ComparedAnswer] = (),
    suggested_answers: Iterable[ComparedAnswer] = (),
) -> Comparison:
    """Compare all answers to an exercise with each other.

    Parameters
    ----------
    exercise : str
    answers : dict of str to ComparedAnswer
        Answers by student.
    kept_answers : sequence of ComparedAnswer
        Right answers that are kept with the course. Each counts as the work of a separate author.
    suggested_answers : iterable of ComparedAnswer
        Answers that the lesson suggests.
    """
    documents = {student: Document(answer) for student, answer in answers.items()}
    kept_documents = [Document(answer) for answer in kept_answers]
    weights = Weights([*documents.values(), *kept_documents], map(Document, suggested_answers))
    least_bits = MIN_BITS + math.log2(max(1, math.comb(len(documents), 2)))
    shares = {
        (first_student, second_student): weights.share(
            documents[first_student], documents[second_student]
        )
        for first_student, second_student in itertools.combinations(documents, 2)
    }
    nearest, pairs = _two_nearest(shares), []
    for (first_student, second_student), share in shares.items():
        first_document, second_document = documents[first_student], documents[second_student]
        if share >= MIN_SHARE and weights.bits(first_document, second_document) >= least_bits:
            pairs.append(
                Pair(
                    exercise,
                    (first_student, second_student),
                    share,
                    weights.bits(first_document, second_document),
                    (
                        first_document.similar_steps(second_document),
                        second_document.similar_steps(first_document),
                    ),
                    (len(first_document.steps), len(second_document.steps)),
                    weights.exclusive_steps(first_document, second_document),
                    (len(documents) - 2, len(kept_documents)),
                    (
                        _largest_share_with_third((first_student, second_student), nearest),
                        _largest_share_with_kept(
                            first_document, second_document, kept_documents, weights
                        ),
                    ),
                )
            )
    pairs.sort(key=lambda pair: -pair.bits)
    distinctive = sum(
        weights.bits_of_copy(document) >= least_bits for document in documents.values()
    )
    return Comparison(exercise, len(documents), distinctive, tuple(pairs))


def _two_nearest(shares: Mapping[tuple[str, str], float]) -> dict[str, list[tuple[float, str]]]:
    """Return the two most similar students for each student, with their shares."""
    nearest_by_student: dict[str, list[tuple[float, str]]] = {}
    for pair, share in shares.items():
        for student, neighbour in (pair, pair[::-1]):
            nearest = nearest_by_student.setdefault(student, [])
            nearest.append((share, neighbour))
            nearest.sort(reverse=True)
            del nearest[2:]
    return nearest_by_student


def _largest_share_with_third(
    pair: tuple[str, str], nearest: Mapping[str, list[tuple[float, str]]]
) -> float:
    """Return the largest share of code that one of two students has in common with a third."""
    return max(
        (
            share
            for student in pair
            for share, neighbour in nearest[student]
            if neighbour not in pair
        ),
        default=0.0,
    )


def _largest_share_with_kept(
    first: Document, second: Document, kept_documents: Sequence[Document], weights: Weights
) -> float:
    """Return the largest share between one of two answers and a kept answer."""
    pairs = itertools.product((first, second), kept_documents)
    return max((weights.share(document, kept) for document, kept in pairs), default=0.0)
