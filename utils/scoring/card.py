"""A score card for boxes: hits at three overlaps, by distance and by hidden share.

Each number has a standard error over the frames, computed with the jackknife (leave one out). The
frames should therefore be independent, for example from eight streets. Frames within one second
are nearly the same.

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
HIDDEN_SHARES = (0.0, 0.1, 0.5, 1.01)
Region = tuple[tuple[float, float], tuple[float, float]]


def within(boxes: ArrayLike, region: Region) -> np.ndarray:
    """Return which boxes have their centre in a region.

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
    """Return the true boxes that a detector should find: road users in a region.

    Parameters
    ----------
    frame : Frame
    region : ((x from, x to), (y from, y to))
        In metres.
    least : int
        Smallest number of returns; boxes with fewer are left out.
    """
    return [
        box
        for box in frame.boxes
        if box.kind in ROAD_USERS and box.returns >= least and within(box.corners, region)[0]
    ]


def hidden_shares(frame: Frame, boxes: Sequence[Box]) -> np.ndarray:
    """Estimate how much of each obstacle is hidden behind others, from 0 to 1.

    The estimate uses the returns from obstacles in the direction of a box, as seen from the
    sensor. It is the share of these returns that comes from other obstacles in front of the box.

    Parameters
    ----------
    frame : Frame
    boxes : sequence of Box
        True boxes of the frame.

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
        off_centre, heights = _angle_differences(angle[before], middle), z[before] / away[before]
        stopped = np.count_nonzero(
            (off_centre <= _angle_differences(edges, middle).max())
            & (heights >= steep.min())
            & (heights <= steep.max())
        )
        shares.append(stopped / max(stopped + np.count_nonzero(objects == box.identity), 1))
    return np.array(shares)


def _angle_differences(angles: np.ndarray, angle: float) -> np.ndarray:
    """Return the absolute differences between `angles` and `angle`, from 0 to pi."""
    return np.abs((angles - angle + np.pi) % (2 * np.pi) - np.pi)


def with_error(parts: ArrayLike, value: Callable[[np.ndarray], float]) -> tuple[float, float]:
    """Compute a number from counts summed over frames, with a jackknife standard error.

    Parameters
    ----------
    parts : array_like, shape (n, k)
        Counts of each frame.
    value : callable
        Takes the sum of the counts, shape (k,); returns the number.

    Returns
    -------
    tuple of float
        The number and its standard error, which is NaN for a single frame.
    """
    parts = np.asarray(parts, dtype=float)
    whole, n = parts.sum(axis=0), len(parts)
    if n < 2:
        return value(whole), np.nan
    without = np.array([value(whole - part) for part in parts])
    return value(whole), float(np.sqrt((n - 1) * np.var(without)))


@dataclass(frozen=True)
class ScoreRow:
    """One row of a card: its count, and a value with its error for each of `OVERLAPS`."""

    name: str
    count: int
    values: tuple[float, ...]
    errors: tuple[float, ...]

    @property
    def texts(self) -> list[str]:
        """The values as text, such as "0.81 ± 0.03"."""
        if not self.count:
            return ["–"] * len(self.values)
        return [
            f"{value:.2f}" + ("" if np.isnan(error) else f" ± {error:.2f}")
            for value, error in zip(self.values, self.errors, strict=True)
        ]


@dataclass(frozen=True)
class ScoreCard:
    """The scores of boxes, row by row."""

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
    """Compare detected boxes with the true boxes of some frames.

    Parameters
    ----------
    found : sequence of ndarray, shape (N, 8, 3)
        The boxes of each frame. Boxes outside the region are ignored.
    frames : sequence of Frame
        Simulated frames, from which the hidden shares can be estimated.
    region : ((x from, x to), (y from, y to))
        Limits in metres; `counted` selects the true boxes in the region.
    title : str
    overlap : callable
        `plane_iou` or `space_iou`.

    Returns
    -------
    ScoreCard
        Precision, recall and F1, then recall by distance and by hidden share.
    """
    pairs = list(zip(found, frames, strict=True))
    scored = [_ScoredFrame.of(boxes, frame, region, overlap) for boxes, frame in pairs]
    rows = [
        _row("precision", [(frame.hits.sum(axis=1), frame.n_boxes) for frame in scored], _share),
        _row(
            "recall", [(frame.hits.sum(axis=1), len(frame.distances)) for frame in scored], _share
        ),
        _row(
            "F1",
            [
                (2 * frame.hits.sum(axis=1), frame.n_boxes + len(frame.distances))
                for frame in scored
            ],
            _share,
            sum(len(frame.distances) for frame in scored),
        ),
    ]
    for names, edges, attribute in (
        (("recall to 10 m", "recall, 10–20 m", "recall beyond 20 m"), DISTANCES, "distances"),
        (("recall in plain view", "recall, partly hidden", "recall, half hidden or more"),
         HIDDEN_SHARES, "hidden"),
    ):  # fmt: skip
        for name, low, high in zip(names, edges, edges[1:], strict=False):
            parts = []
            for frame in scored:
                group = (getattr(frame, attribute) >= low) & (getattr(frame, attribute) < high)
                parts.append((frame.hits[:, group].sum(axis=1), group.sum()))
            rows.append(_row(name, parts, _share))
    return ScoreCard(title, tuple(rows))


@dataclass(frozen=True, eq=False)
class _ScoredFrame:
    """The scores of a frame: hits (3, M) on its true boxes, their distances and hidden shares."""

    hits: np.ndarray
    n_boxes: int
    distances: np.ndarray
    hidden: np.ndarray

    @classmethod
    def of(cls, boxes: np.ndarray, frame: Frame, region: Region, overlap: Callable) -> _ScoredFrame:
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
    """Build a row; each part is one frame's hits at each overlap and its number of boxes."""
    scores = [
        with_error([(hits[place], whole) for hits, whole in parts], value)
        for place in range(len(OVERLAPS))
    ]
    count = int(sum(whole for _, whole in parts)) if count is None else count
    values, errors = (tuple(numbers) for numbers in zip(*scores, strict=True))
    if sum(whole > 0 for _, whole in parts) < 2:
        errors = (np.nan,) * len(OVERLAPS)  # leaving out the only frame with boxes leaves no data
    return ScoreRow(name, count, values, errors)
