"""How good boxes and tracks are: overlap, matching, precision, recall and identity switches.

Boxes are arrays (N, 8, 3); see `utils.boxes`.

References
----------
K. Bernardin and R. Stiefelhagen, "Evaluating multiple object tracking performance: the CLEAR
MOT metrics", EURASIP Journal on Image and Video Processing, 2008.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from utils.boxes import plane_iou, space_iou

__all__ = [
    "Score",
    "TrackedFrame",
    "match",
    "plane_iou",
    "score_boxes",
    "score_stream",
    "space_iou",
]


@dataclass(frozen=True)
class Score:
    """Counts of what was found, invented and missed; scores add up over frames.

    Where nothing was claimed the precision is 1, where nothing was there the recall is 1: no
    claim was false and nothing was missed.
    """

    true_positives: int = 0
    false_positives: int = 0
    false_negatives: int = 0
    identity_switches: int = 0

    @property
    def precision(self) -> float:
        """Share of the found boxes that are true."""
        return _share(self.true_positives, self.true_positives + self.false_positives)

    @property
    def recall(self) -> float:
        """Share of the true boxes that were found."""
        return _share(self.true_positives, self.true_positives + self.false_negatives)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        twice = 2 * self.true_positives
        return _share(twice, twice + self.false_positives + self.false_negatives)

    def __add__(self, other: Score) -> Score:
        return Score(
            self.true_positives + other.true_positives,
            self.false_positives + other.false_positives,
            self.false_negatives + other.false_negatives,
            self.identity_switches + other.identity_switches,
        )


@dataclass(frozen=True, eq=False)
class TrackedFrame:
    """What a tracker said about one frame, and the truth.

    Parameters
    ----------
    found : ndarray, shape (N, 8, 3)
    labels : sequence of int, length N
        The tracker's name for each box, the same for the same thing in every frame.
    truth : ndarray, shape (M, 8, 3)
    identities : sequence of int, length M
        The true names.
    """

    found: np.ndarray
    labels: tuple[int, ...]
    truth: np.ndarray
    identities: tuple[int, ...]


def match(overlaps: np.ndarray, minimum_overlap: float = 0.5) -> np.ndarray:
    """Pair found and true boxes one to one so that the pairs' overlaps sum to the most.

    Parameters
    ----------
    overlaps : ndarray, shape (N, M)
        From `plane_iou` or `space_iou`.
    minimum_overlap : float
        Pairs that overlap less are not made.

    Returns
    -------
    ndarray of int, shape (N,)
        For every found box the index of its true box, or -1.
    """
    from scipy.optimize import linear_sum_assignment  # here: it takes 0.2 s to import

    overlaps = np.asarray(overlaps, dtype=float)
    allowed = (overlaps >= minimum_overlap) & (overlaps > 0)
    rows, columns = linear_sum_assignment(np.where(allowed, overlaps, 0.0), maximize=True)
    partners = np.full(len(overlaps), -1)
    good = allowed[rows, columns]
    partners[rows[good]] = columns[good]
    return partners


def score_boxes(
    found: np.ndarray,
    truth: np.ndarray,
    minimum_overlap: float = 0.5,
    overlap: Callable[[np.ndarray, np.ndarray], np.ndarray] = plane_iou,
) -> Score:
    """Compare the boxes found in one frame with the true ones.

    Parameters
    ----------
    found : ndarray, shape (N, 8, 3)
    truth : ndarray, shape (M, 8, 3)
    minimum_overlap : float
        Least overlap of a box that counts as found.
    overlap : callable
        `plane_iou` or `space_iou`.

    Returns
    -------
    Score
    """
    hits = int(np.count_nonzero(match(overlap(found, truth), minimum_overlap) >= 0))
    return Score(hits, len(found) - hits, len(truth) - hits)


def score_stream(
    frames: Iterable[TrackedFrame],
    minimum_overlap: float = 0.5,
    overlap: Callable[[np.ndarray, np.ndarray], np.ndarray] = plane_iou,
) -> Score:
    """Score a tracker over a stream, with the identity switches it makes.

    A thing keeps its label from the frame before while their boxes still overlap enough, even
    if another box overlaps a little more. A switch is counted whenever a thing is found under
    another label than the last time it was found (CLEAR MOT).

    Parameters
    ----------
    frames : iterable of TrackedFrame
    minimum_overlap, overlap
        As for `score_boxes`.

    Returns
    -------
    Score
        Summed over all frames.
    """
    total = Score()
    label_of: dict[int, int] = {}
    for frame in frames:
        overlaps = np.array(overlap(frame.found, frame.truth))
        known = np.array([label_of.get(identity) for identity in frame.identities])
        kept = np.array(frame.labels, dtype=object)[:, None] == known[None, :]
        kept = kept.astype(bool) & (overlaps >= minimum_overlap)
        # A bonus larger than any sum of overlaps keeps every pair that can be kept.
        bonus = 1.0 + len(frame.truth)
        partners = match(np.where(overlaps >= minimum_overlap, overlaps + bonus * kept, 0.0), 0.0)
        hits = switches = 0
        for label, partner in zip(frame.labels, partners, strict=True):
            if partner < 0:
                continue
            identity = frame.identities[partner]
            switches += label_of.get(identity, label) != label
            label_of[identity] = label
            hits += 1
        total += Score(hits, len(frame.found) - hits, len(frame.truth) - hits, switches)
    return total


def _share(part: int, whole: int) -> float:
    return part / whole if whole else 1.0
