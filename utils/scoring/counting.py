"""Counts for scoring boxes and tracks: matches, precision, recall and identity switches.

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
    "NameMistakes",
    "Score",
    "TrackedFrame",
    "holders",
    "match",
    "name_mistakes",
    "plane_iou",
    "score_boxes",
    "score_stream",
    "space_iou",
]


@dataclass(frozen=True)
class Score:
    """Counts of found, false and missed boxes; the scores of frames can be added.

    Without found boxes the precision is 1, because no box is false. Without true boxes the recall
    is 1, because no box is missed.
    """

    true_positives: int = 0
    false_positives: int = 0
    false_negatives: int = 0
    identity_switches: int = 0

    @property
    def precision(self) -> float:
        """The share of the found boxes that match a true box."""
        return _share(self.true_positives, self.true_positives + self.false_positives)

    @property
    def recall(self) -> float:
        """The share of the true boxes that were found."""
        return _share(self.true_positives, self.true_positives + self.false_negatives)

    @property
    def f1(self) -> float:
        """The harmonic mean of precision and recall."""
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
    """A tracker's boxes for one frame, and the true boxes.

    Parameters
    ----------
    found : ndarray, shape (N, 8, 3)
    labels : sequence of int, length N
        The track ID of each box, which should be the same for an obstacle in every frame.
    truth : ndarray, shape (M, 8, 3)
    identities : sequence of int, length M
        Identity of the obstacle in each true box.
    """

    found: np.ndarray
    labels: tuple[int, ...]
    truth: np.ndarray
    identities: tuple[int, ...]


@dataclass(frozen=True)
class NameMistakes:
    """A tracker's mistakes with track IDs in a stream.

    Attributes
    ----------
    switches : int
        Number of times that an obstacle was found without any track ID that it had the last time.
    shared : int
        Number of track IDs that two or more obstacles had, one after the other or at once.
    """

    switches: int
    shared: int


def match(overlaps: np.ndarray, minimum_overlap: float = 0.5) -> np.ndarray:
    """Pair found and true boxes one to one so that the sum of the overlaps is largest.

    Parameters
    ----------
    overlaps : ndarray, shape (N, M)
        From `plane_iou` or `space_iou`.
    minimum_overlap : float
        Boxes that overlap less are not paired.

    Returns
    -------
    ndarray of int, shape (N,)
        For every found box the index of its true box, or -1.
    """
    from scipy.optimize import linear_sum_assignment  # imported here because it takes 0.2 s

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
    """Compare the boxes found in one frame with the true boxes.

    Parameters
    ----------
    found : ndarray, shape (N, 8, 3)
    truth : ndarray, shape (M, 8, 3)
    minimum_overlap : float
        Smallest overlap at which a box counts as found.
    overlap : callable
        `plane_iou` or `space_iou`.
    """
    hits = int(np.count_nonzero(match(overlap(found, truth), minimum_overlap) >= 0))
    return Score(hits, len(found) - hits, len(truth) - hits)


def score_stream(
    frames: Iterable[TrackedFrame],
    minimum_overlap: float = 0.5,
    overlap: Callable[[np.ndarray, np.ndarray], np.ndarray] = plane_iou,
) -> Score:
    """Score a tracker over a stream, including its identity switches.

    An obstacle keeps its last label while the two boxes overlap enough, even if another box
    overlaps a little more. A switch is counted whenever an obstacle is found with a
    different label than the last time (CLEAR MOT).

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


def holders(boxes: np.ndarray, cloud: np.ndarray, objects: np.ndarray) -> np.ndarray:
    """Return, for each box, the obstacle with the most returns in it.

    Parameters
    ----------
    boxes : ndarray, shape (N, 8, 3)
        Upright boxes; the four corners of the floor come first, in order around the floor.
    cloud : ndarray, shape (n, 3) or (n, 4)
    objects : ndarray of int, shape (n,)
        The true obstacle of each return; 0 for none, such as the road.

    Returns
    -------
    ndarray of int, shape (N,)
        0 for a box without returns from an obstacle.
    """
    standing = np.flatnonzero(objects > 0)
    xy, objects = np.asarray(cloud)[standing, :2], objects[standing]
    found = np.zeros(len(boxes), dtype=int)
    for number, box in enumerate(np.asarray(boxes, dtype=float)):
        corner, sides = box[0, :2], box[[1, 3], :2] - box[0, :2]
        length = np.maximum((sides**2).sum(axis=1), 1e-9)
        low, high = box[:4, :2].min(axis=0) - 0.1, box[:4, :2].max(axis=0) + 0.1
        near = np.flatnonzero(((xy >= low) & (xy <= high)).all(axis=1))
        # Boxes around centroids of a thinned cloud are slightly too small, hence the margin.
        share = (xy[near] - corner) @ sides.T / length
        margin = 0.1 / np.sqrt(length)
        held = near[((share >= -margin) & (share <= 1 + margin)).all(axis=1)]
        if len(held):
            found[number] = np.bincount(objects[held]).argmax()
    return found


def name_mistakes(things: Iterable[np.ndarray], names: Iterable[np.ndarray]) -> NameMistakes:
    """Count the changes of an obstacle's track ID, and the IDs that several obstacles had.

    Parameters
    ----------
    things : iterable of ndarray of int
        For each frame, the true obstacle of each box, from `holders`.
    names : iterable of ndarray of int
        For each frame, the track ID of each box.
    """
    known: dict[int, set[int]] = {}
    bearers: dict[int, set[int]] = {}
    switches = 0
    for frame_things, frame_names in zip(things, names, strict=True):
        here: dict[int, set[int]] = {}
        for thing, name in zip(frame_things.tolist(), frame_names.tolist(), strict=True):
            if thing:
                here.setdefault(thing, set()).add(name)
                bearers.setdefault(name, set()).add(thing)
        switches += sum(
            thing in known and not known[thing] & now_named for thing, now_named in here.items()
        )
        known |= here
    return NameMistakes(switches, sum(len(had_by) > 1 for had_by in bearers.values()))


def _share(part: int, whole: int) -> float:
    return part / whole if whole else 1.0
