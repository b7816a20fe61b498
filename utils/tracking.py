"""Boxes under names, from frame to frame, by the functions of lesson 12.

A `Tracker` keeps the books. Whatever is clever about it, the student wrote: where a box should be
by now (`predict_boxes`), which box it is (`match_boxes`), what to believe (`correct_boxes`), and
whom to wait for (`coast`). All but the matching may be left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

FARTHEST = 1.5
"""Metres between where a box should be and where it is, up to which it is the same one."""

GAIN = 0.5
"""What lesson 12 measures for the boxes of its street."""

PATIENCE = 3
"""Frames in a row that a track lives on without a box."""


@dataclass(frozen=True, eq=False)
class Tracks:
    """All that is followed, a row for each: first what has a box in this frame, in its order.

    Attributes
    ----------
    names : ndarray of int, shape (N,)
        From 1, and never used again.
    boxes : ndarray, shape (N, 8, 3)
        Where each is believed to be, in metres.
    velocities : ndarray, shape (N, 3)
        Metres per second, in the frame in which the boxes are given: for a scanner that drives,
        relative to it.
    missed : ndarray of int, shape (N,)
        Frames in a row without a box, this one included.
    age : ndarray of int, shape (N,)
        Frames in which each had a box.
    """

    names: np.ndarray
    boxes: np.ndarray
    velocities: np.ndarray
    missed: np.ndarray
    age: np.ndarray

    def __getitem__(self, rows: ArrayLike) -> Tracks:
        """Some of them."""
        return Tracks(*(values[rows] for values in vars(self).values()))

    def __add__(self, others: Tracks) -> Tracks:
        """These, and below them the others."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Tracks(*map(np.concatenate, pairs))


_SHAPES = (((), int), ((8, 3), float), ((3,), float), ((), int), ((), int))
NOBODY = Tracks(*(np.zeros((0, *shape), kind) for shape, kind in _SHAPES))


class Tracker:
    """Gives boxes names that last.

    Parameters
    ----------
    match : callable
        ``match_boxes(previous, current, max_distance)``: the partner of each current box, or -1.
    predict : callable, optional
        ``predict_boxes(boxes, velocities, seconds)``: the boxes, moved. Without, a box is looked
        for where it was.
    correct : callable, optional
        ``correct_boxes(expected, velocities, found, gain, seconds)``: boxes and velocities,
        between what was expected and what was found. Without, boxes are where they are found, and
        keep the velocity that they began with.
    coast : callable, optional
        ``coast(missed, partners, patience)``: for each track its frames in a row without a box,
        and whether it is kept. Without, what has no box is dropped.
    max_distance : float
        In metres, for `match`.
    gain : float
        From 0 to 1, for `correct`.
    patience : int
        In frames, for `coast`.
    newcomer : array_like, shape (3,), optional
        Velocity of what is seen for the first time, in m/s. By default the median of all that are
        followed: most things stand, and come towards us as fast as we drive.

    Attributes
    ----------
    tracks : Tracks
        After the last frame.
    match : callable
        As given.
    """

    def __init__(
        self,
        match: Callable,
        *,
        predict: Callable | None = None,
        correct: Callable | None = None,
        coast: Callable | None = None,
        max_distance: float = FARTHEST,
        gain: float = GAIN,
        patience: int = PATIENCE,
        newcomer: ArrayLike | None = None,
    ) -> None:
        self.match, self._predict, self._correct, self._coast = match, predict, correct, coast
        self._max_distance, self._gain, self._patience = max_distance, gain, patience
        self._newcomer = newcomer
        self._unused = 1
        self.tracks = NOBODY

    @property
    def knows_velocities(self) -> bool:
        """Whether it predicts and corrects; else velocities are what they began with."""
        return bool(self._predict and self._correct)

    def update(self, found: np.ndarray, seconds: float = 0.1) -> np.ndarray:
        """Take the boxes of the next frame.

        Parameters
        ----------
        found : ndarray, shape (N, 8, 3)
        seconds : float
            Since the frame before.

        Returns
        -------
        ndarray of int, shape (N,)
            The name of each.
        """
        found, old = np.asarray(found, dtype=float).reshape(-1, 8, 3), self.tracks
        expected = old.boxes
        if self._predict and len(expected):
            expected = np.asarray(self._predict(old.boxes, old.velocities, seconds))
        partners = np.asarray(self.match(expected, found, self._max_distance), dtype=int)
        known = np.flatnonzero((partners >= 0) & (partners < len(old.names)))
        of = partners[known]
        seen = self._newcomers(found)
        seen.names[known], seen.age[known] = old.names[of], old.age[of] + 1
        seen.velocities[known] = old.velocities[of]
        if self._correct and len(known):
            seen.boxes[known], seen.velocities[known] = self._correct(
                expected[of], old.velocities[of], found[known], self._gain, seconds
            )
        new = np.setdiff1d(np.arange(len(found)), known)
        seen.names[new] = self._unused + np.arange(len(new))
        self._unused += len(new)
        self.tracks = seen + self._waiting(expected, partners)
        return seen.names

    def _newcomers(self, found: np.ndarray) -> Tracks:
        n, velocity = len(found), self._newcomer
        if velocity is None:
            followed = self.tracks.velocities
            velocity = np.median(followed, axis=0) if len(followed) else np.zeros(3)
        nothing = np.zeros(n, dtype=int)
        return Tracks(
            nothing, found.copy(), np.tile(velocity, (n, 1)).astype(float), nothing.copy(),
            np.ones(n, dtype=int),
        )  # fmt: skip

    def _waiting(self, expected: np.ndarray, partners: np.ndarray) -> Tracks:
        """The tracks that have no box in this frame and are kept."""
        old = self.tracks
        if not (self._coast and len(old.names)):
            return NOBODY
        missed, kept = map(np.asarray, self._coast(old.missed, partners, self._patience))
        alone = ~np.isin(np.arange(len(old.names)), partners) & kept.astype(bool)
        there = Tracks(old.names, expected, old.velocities, missed.astype(int), old.age)
        return there[alone]


def tracker_of(functions: SimpleNamespace, **settings: object) -> Tracker | None:
    """A tracker of the functions that a notebook of lesson 12 has.

    Parameters
    ----------
    functions : types.SimpleNamespace
        From `utils.load_my_functions`. What is missing or still a stub is left out.
    **settings : object
        As `Tracker` takes them, such as ``max_distance``.

    Returns
    -------
    Tracker or None
        None without `match_boxes`.
    """
    written = {
        name: function
        for name, function in vars(functions).items()
        if callable(function) and not hasattr(function, "is_stub")
    }
    if "match_boxes" not in written:
        return None
    parts = {"predict": "predict_boxes", "correct": "correct_boxes", "coast": "coast"}
    mine = {part: written.get(name) for part, name in parts.items()}
    return Tracker(written["match_boxes"], **mine, **settings)
