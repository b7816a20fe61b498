"""Weigh the common parts of two answers by how rare they are in the class.

Each run of `PIECE_LENGTH` words in a statement is a piece. Schleimer, Wilkerson and Aiken
introduced such pieces for whole programs (Winnowing: local algorithms for document fingerprinting,
SIGMOD 2003). Functions are short, so all pieces are kept. No piece extends into the next statement,
so the order of statements does not matter.

Pieces that occur in the lesson's suggested answers or in many students' answers have no weight. The
weight of any other piece is its information in bits: the fewer answers contain the piece, the more
it weighs (Spärck Jones, A statistical interpretation of term specificity, 1972).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from grader.classroom.similarity.answers import ComparedAnswer

PIECE_LENGTH = 6
# A piece in more than a quarter of the other answers has no weight.
MAX_RARE_SHARE = 0.25

Piece = tuple[str, ...]


class Document:
    """The pieces of an answer.

    Attributes
    ----------
    steps : list of frozenset of Piece
        The pieces of each statement.
    pieces : frozenset of Piece
        All pieces.
    """

    def __init__(self, answer: ComparedAnswer) -> None:
        self.steps = [_pieces_of(step.words) for step in answer.steps]
        self.pieces = frozenset().union(*self.steps)

    def similar_steps(self, other: Document) -> frozenset[int]:
        """Return the indices of statements that share at least half their pieces with an answer."""
        return frozenset(
            index
            for index, step in enumerate(self.steps)
            if 2 * len(step & other.pieces) >= len(step)
        )


def _pieces_of(words: Piece) -> frozenset[Piece]:
    """Return all runs of `PIECE_LENGTH` words in a statement; a shorter statement is one piece."""
    starts = range(max(1, len(words) - PIECE_LENGTH + 1))
    return frozenset(words[index : index + PIECE_LENGTH] for index in starts)


class Weights:
    """The weights of all pieces in the answers to an exercise.

    Parameters
    ----------
    documents : sequence of Document
        All answers that are compared with each other.
    suggested : iterable of Document
        Answers that the lesson suggests, whose pieces have no weight.
    """

    def __init__(self, documents: Sequence[Document], suggested: Iterable[Document]) -> None:
        self._suggested = frozenset().union(*(document.pieces for document in suggested))
        self._step_counts = Counter(step for document in documents for step in set(document.steps))
        holders = Counter(piece for document in documents for piece in document.pieces)
        others = max(0, len(documents) - 2)  # answers other than the two that are compared
        # The bits of a piece depend on whether one or both of the two compared answers contain it.
        self._bits_in_one = {
            piece: self._bits(piece, n - 1, others) for piece, n in holders.items()
        }
        self._bits_in_both = {
            piece: self._bits(piece, n - 2, others) for piece, n in holders.items()
        }

    def _bits(self, piece: Piece, holders: int, others: int) -> float:
        if piece in self._suggested or holders > MAX_RARE_SHARE * others:
            return 0.0
        return math.log2((others + 1) / (max(0, holders) + 0.5))

    def share(self, first: Document, second: Document) -> float:
        """Return the fraction of unusual parts that two answers share (Dice's coefficient)."""
        shared = sum(self._bits_in_both[piece] for piece in first.pieces & second.pieces)
        different = sum(self._bits_in_one[piece] for piece in first.pieces ^ second.pieces)
        return 2 * shared / (2 * shared + different) if shared else 0.0

    def bits(self, first: Document, second: Document) -> float:
        """Return how unusual the common part of two answers is, in bits.

        A long statement is still a single idea, so each statement counts only as the mean of its
        pieces.
        """
        weights = {piece: self._bits_in_both[piece] for piece in first.pieces & second.pieces}
        return min(_sum_of_steps(document, weights) for document in (first, second))

    def bits_of_copy(self, document: Document) -> float:
        """Return how unusual the common part of an answer and an exact copy would be, in bits."""
        return self.bits(document, document)

    def exclusive_steps(self, first: Document, second: Document) -> int:
        """Return the number of common statements that no third answer has."""
        steps = (first.steps[index] for index in first.similar_steps(second))
        return sum(
            self._step_counts[step] == 1 + (step in second.steps) and not step <= self._suggested
            for step in steps
        )


def _sum_of_steps(document: Document, weights: Mapping[Piece, float]) -> float:
    steps = set(document.steps)
    return sum(sum(weights.get(piece, 0.0) for piece in step) / len(step) for step in steps)
