"""One card for all claims about boxes: hits at three overlaps, by distance, by what is hidden.

Each number comes with its standard error over the frames, by the jackknife (leave one out). So
frames should be independent: of eight streets, not of one second, in which all are nearly the same.

References
----------
B. Efron and C. Stein, "The jackknife estimate of variance", The Annals of Statistics, 1981.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from utils.boxes import Box, plane_iou
from utils.scoring.counting import match
from utils.simulator.frames import Frame
from utils.tables import show_table

OVERLAPS = (0.3, 0.5, 0.7)
ROAD_USERS = ("car", "truck", "cyclist", "pedestrian")
DISTANCES = (0.0, 10.0, 20.0, np.inf)
HIDDEN = (0.0, 0.1, 0.5, 1.01)
Region = tuple[tuple[float, float], tuple[float, float]]


def within(boxes: ArrayLike, region: Region) -> np.ndarray:
    """Which boxes have their middle in a region.

    Parameters
    ----------
    boxes : array_like, shape (N, 8, 3)
    region : ((x from, x to), (y from, y to))

    Returns
    -------
    ndarray of bool, shape (N,)
    """
    middles = np.reshape(boxes, (-1, 8, 3)).mean(axis=1)
    (left, right), (low, high) = region
    return ((middles[:, :2] > (left, low)) & (middles[:, :2] < (right, high))).all(axis=1)


def counted(frame: Frame, region: Region, least: int = 30) -> list[Box]:
    """The true boxes that a detector should find: road users in a region.

    Parameters
    ----------
    frame : Frame
    region : ((x from, x to), (y from, y to))
    least : int
        What has fewer returns is not asked for.
    """
    return [
        box
        for box in frame.boxes
        if box.kind in ROAD_USERS and box.returns >= least and within(box.corners, region)[0]
    ]


def hidden_shares(frame: Frame, boxes: Sequence[Box]) -> np.ndarray:
    """How much of each thing is hidden behind others, from 0 to 1.

    Of the rays towards its box, as seen from the sensor, that met a thing at all: the share which
    met another one before.

    Parameters
    ----------
    frame : Frame
    boxes : sequence of Box
        Some of its true ones.

    Returns
    -------
    ndarray, shape (len(boxes),)
    """
    standing = frame.scan.objects > 0
    objects, (x, y, z) = frame.scan.objects[standing], frame.cloud[standing, :3].T
    away, angle = np.hypot(x, y), np.arctan2(y, x)
    shares = []
    for box in boxes:
        corners, middle = box.corners, np.arctan2(box.centre[1], box.centre[0])
        far, edges = np.hypot(*corners[:, :2].T), np.arctan2(*corners[:, 1::-1].T)
        steep = corners[:, 2] / far
        before = np.flatnonzero((away < far.min()) & (objects != box.identity))
        beside, heights = _between(angle[before], middle), z[before] / away[before]
        stopped = np.count_nonzero(
            (beside <= _between(edges, middle).max())
            & (heights >= steep.min())
            & (heights <= steep.max())
        )
        shares.append(stopped / max(stopped + np.count_nonzero(objects == box.identity), 1))
    return np.array(shares)


def _between(angles: np.ndarray, angle: float) -> np.ndarray:
    """How far angles are from another one, in radians, the short way round."""
    return np.abs((angles - angle + np.pi) % (2 * np.pi) - np.pi)


def with_error(parts: ArrayLike, value: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """A number of a sum over frames, with its standard error by the jackknife.

    Parameters
    ----------
    parts : array_like, shape (n, k)
        Counts of each frame.
    value : callable
        From the sum of the counts, shape (k,), to the number.

    Returns
    -------
    tuple of float
        The number, and its error; NaN for the error of a single frame.
    """
    parts = np.asarray(parts, dtype=float)
    whole, n = parts.sum(axis=0), len(parts)
    if n < 2:
        return value(whole), np.nan
    without = np.array([value(whole - part) for part in parts])
    return value(whole), float(np.sqrt((n - 1) * np.var(without)))


@dataclass(frozen=True)
class ScoreRow:
    """One line of a card: a value and its error for each of `OVERLAPS`; of how many things."""

    name: str
    count: int
    values: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def texts(self) -> list[str]:
        """Such as "0.81 ± 0.03"."""
        if not self.count:
            return ["–"] * len(self.values)
        return [
            f"{value:.2f}" + ("" if np.isnan(error) else f" ± {error:.2f}")
            for value, error in zip(self.values, self.errors, strict=True)
        ]


@dataclass(frozen=True)
class ScoreCard:
    """What is said of boxes, row by row."""

    title: str
    rows: tuple[ScoreRow, ...]

    def __getitem__(self, name: str) -> ScoreRow:
        return next(row for row in self.rows if row.name == name)

    def show(self) -> None:
        """Show the card as a table."""
        headings = [self.title, "of", *(f"IoU {overlap}" for overlap in OVERLAPS)]
        show_table(headings, [[row.name, row.count, *row.texts] for row in self.rows])


def score_card(
    found: Sequence[np.ndarray],
    frames: Sequence[Frame],
    region: Region,
    title: str = "",
    overlap: Callable[[np.ndarray, np.ndarray], np.ndarray] = plane_iou,
) -> ScoreCard:
    """Compare boxes with the true ones of some frames.

    Parameters
    ----------
    found : sequence of ndarray, shape (N, 8, 3)
        The boxes of each frame. Those outside of the region are not looked at.
    frames : sequence of Frame
        Simulated: they know what hides what.
    region : ((x from, x to), (y from, y to))
        In metres; `counted` says which true boxes in it are asked for.
    title : str
    overlap : callable
        `plane_iou` or `space_iou`.

    Returns
    -------
    ScoreCard
        Precision, recall and F1; then recall by distance, and by how much is hidden.
    """
    pairs = list(zip(found, frames, strict=True))
    looked = [_Looked.at(boxes, frame, region, overlap) for boxes, frame in pairs]
    rows = [
        _row("precision", [(one.hits.sum(axis=1), one.found) for one in looked], _share),
        _row("recall", [(one.hits.sum(axis=1), len(one.away)) for one in looked], _share),
        _row(
            "F1",
            [(2 * one.hits.sum(axis=1), one.found + len(one.away)) for one in looked],
            _share,
            sum(len(one.away) for one in looked),
        ),
    ]
    for names, edges, of in (
        (("recall to 10 m", "recall, 10–20 m", "recall beyond 20 m"), DISTANCES, "away"),
        (("recall in plain view", "recall, partly hidden", "recall, half hidden or more"),
         HIDDEN, "hidden"),
    ):  # fmt: skip
        for name, low, high in zip(names, edges, edges[1:], strict=False):
            parts = []
            for one in looked:
                group = (getattr(one, of) >= low) & (getattr(one, of) < high)
                parts.append((one.hits[:, group].sum(axis=1), group.sum()))
            rows.append(_row(name, parts, _share))
    return ScoreCard(title, tuple(rows))


@dataclass(frozen=True, eq=False)
class _Looked:
    """One frame: which true boxes are hit at each overlap, (3, M), and what is known of them."""

    hits: np.ndarray
    found: int
    away: np.ndarray
    hidden: np.ndarray

    @classmethod
    def at(cls, boxes: np.ndarray, frame: Frame, region: Region, overlap: Callable) -> _Looked:
        boxes, truth = np.reshape(boxes, (-1, 8, 3)), counted(frame, region)
        boxes = boxes[within(boxes, region)]
        overlaps = overlap(boxes, np.array([box.corners for box in truth]).reshape(-1, 8, 3))
        hits = [np.isin(np.arange(len(truth)), match(overlaps, least)) for least in OVERLAPS]
        return cls(
            np.array(hits),
            len(boxes),
            np.array([np.hypot(*box.centre[:2]) for box in truth]),
            hidden_shares(frame, truth),
        )


def _share(counts: np.ndarray) -> float:
    part, whole = counts
    return part / whole if whole else 1.0


def _row(name: str, parts: list, value: Callable, count: int | None = None) -> ScoreRow:
    """Each part: hits at each overlap, and how many there are, of one frame."""
    said = [
        with_error([(hits[place], whole) for hits, whole in parts], value)
        for place in range(len(OVERLAPS))
    ]
    count = int(sum(whole for _, whole in parts)) if count is None else count
    values, errors = (tuple(numbers) for numbers in zip(*said, strict=True))
    if sum(whole > 0 for _, whole in parts) < 2:
        errors = (np.nan,) * len(OVERLAPS)  # without that one frame, there would be nothing to say
    return ScoreRow(name, count, values, errors)
