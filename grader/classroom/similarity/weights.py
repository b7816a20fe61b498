"""What two answers have in common that hardly anybody else has, and what that weighs.

The words of a step are cut into pieces of `LENGTH` words each, as Schleimer, Wilkerson and Aiken
do with whole programs (Winnowing: local algorithms for document fingerprinting, SIGMOD 2003).
Functions are short, so all pieces are kept, and none reaches from one step into the next: the
order of steps makes no difference.

Out go the pieces of what the lesson leads to, and those that many others have. A piece that is
left weighs the more the fewer have it: as many bits as it takes to say that somebody does
(Spärck Jones, A statistical interpretation of term specificity, 1972).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from grader.classroom.similarity.answers import ComparedAnswer

LENGTH = 6
# What more than a quarter of the others have is not told apart from what everybody has.
COMMON = 0.25

Piece = tuple[str, ...]


class Document:
    """An answer in pieces.

    Attributes
    ----------
    steps : list of frozenset of Piece
        Of each step.
    pieces : frozenset of Piece
        Of all.
    """

    def __init__(self, answer: ComparedAnswer) -> None:
        self.steps = [_pieces_of(step.words) for step in answer.steps]
        self.pieces = frozenset().union(*self.steps)

    def steps_like(self, other: Document) -> frozenset[int]:
        """Places of the steps of which the other has at least half."""
        return frozenset(
            place
            for place, step in enumerate(self.steps)
            if 2 * len(step & other.pieces) >= len(step)
        )


def _pieces_of(words: Piece) -> frozenset[Piece]:
    """All runs of `LENGTH` words of a step; of a shorter one, the whole."""
    places = range(max(1, len(words) - LENGTH + 1))
    return frozenset(words[place : place + LENGTH] for place in places)


class Weights:
    """Who has what among all answers to an exercise, and how unusual that is.

    Parameters
    ----------
    documents : sequence of Document
        All that are compared with each other.
    taught : iterable of Document
        What the lesson leads to: to share that is no surprise.
    """

    def __init__(self, documents: Sequence[Document], taught: Iterable[Document]) -> None:
        self._taught = frozenset().union(*(document.pieces for document in taught))
        self._with_step = Counter(step for document in documents for step in set(document.steps))
        holders = Counter(piece for document in documents for piece in document.pieces)
        others = max(0, len(documents) - 2)  # than the two who are compared
        # Bits of each piece, if one of the two has it, and if both have.
        self._of_one = {piece: self._bits(piece, n - 1, others) for piece, n in holders.items()}
        self._of_both = {piece: self._bits(piece, n - 2, others) for piece, n in holders.items()}

    def _bits(self, piece: Piece, holders: int, others: int) -> float:
        if piece in self._taught or holders > COMMON * others:
            return 0.0
        return math.log2((others + 1) / (max(0, holders) + 0.5))

    def share(self, one: Document, other: Document) -> float:
        """How much of what is unusual in two answers is in both (Dice's coefficient)."""
        shared = sum(self._of_both[piece] for piece in one.pieces & other.pieces)
        alone = sum(self._of_one[piece] for piece in one.pieces ^ other.pieces)
        return 2 * shared / (2 * shared + alone) if shared else 0.0

    def bits(self, one: Document, other: Document) -> float:
        """How unusual it is to have in common what these two have.

        A long step is one idea and not many: it counts as its average piece does.
        """
        weights = {piece: self._of_both[piece] for piece in one.pieces & other.pieces}
        return min(_sum_of_steps(document, weights) for document in (one, other))

    def bits_of_copy(self, document: Document) -> float:
        """The same, of an answer and a copy of it."""
        return self.bits(document, document)

    def only_theirs(self, one: Document, other: Document) -> int:
        """How many steps of the one, of those that the other has the like of, nobody else has."""
        steps = (one.steps[place] for place in one.steps_like(other))
        return sum(
            self._with_step[step] == 1 + (step in other.steps) and not step <= self._taught
            for step in steps
        )


def _sum_of_steps(document: Document, weights: Mapping[Piece, float]) -> float:
    steps = set(document.steps)
    return sum(sum(weights.get(piece, 0.0) for piece in step) / len(step) for step in steps)
