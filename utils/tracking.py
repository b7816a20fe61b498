"""Track boxes from frame to frame with the functions from lesson 12.

A `Tracker` stores the tracks, and calls the student's functions to predict where a box should be
(`predict_boxes`), match boxes (`match_boxes`), correct the prediction (`correct_boxes`), keep
tracks without a box (`coast`) and confirm new tracks (`confirm`). All of them except `match_boxes`
are optional.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike

FARTHEST = 1.5
"""Largest distance in metres between the expected and the found position of the same box."""

GAIN = 0.5
"""Default gain, as measured in lesson 12 for the boxes of its street."""

PATIENCE = 3
"""Number of consecutive frames for which a track is kept without a box."""

NEEDED = 3
"""Number of frames with a box after which a track is confirmed."""


@dataclass(frozen=True, eq=False)
class Tracks:
    """All tracks, one per row. Tracks with a box in this frame come first, in the boxes' order.

    Attributes
    ----------
    ids : ndarray of int, shape (N,)
        Track IDs, which start from 1 and are never reused.
    boxes : ndarray, shape (N, 8, 3)
        Estimated corners, in metres.
    velocities : ndarray, shape (N, 3)
        Velocities in m/s, in the boxes' coordinate system (relative to a moving scanner).
    missed : ndarray of int, shape (N,)
        Number of consecutive frames without a box, including this one.
    age : ndarray of int, shape (N,)
        Number of frames with a box.
    confirmed : ndarray of bool, shape (N,)
        Whether the track counts; False for a tentative track.
    """

    ids: np.ndarray
    boxes: np.ndarray
    velocities: np.ndarray
    missed: np.ndarray
    age: np.ndarray
    confirmed: np.ndarray

    def __getitem__(self, rows: ArrayLike) -> Tracks:
        """Return the tracks in some rows."""
        return Tracks(*(values[rows] for values in vars(self).values()))

    def __add__(self, others: Tracks) -> Tracks:
        """Return these tracks, followed by the others."""
        pairs = zip(vars(self).values(), vars(others).values(), strict=True)
        return Tracks(*map(np.concatenate, pairs))


_SHAPES_AND_TYPES = (((), int), ((8, 3), float), ((3,), float), ((), int), ((), int), ((), bool))
NO_TRACKS = Tracks(*(np.zeros((0, *shape), kind) for shape, kind in _SHAPES_AND_TYPES))


class Tracker:
    """Assigns track IDs to boxes, so that an object keeps its ID from frame to frame.

    Parameters
    ----------
    match : callable
        ``match_boxes(previous, current, max_distance)``: the partner of each current box, or -1.
    predict : callable, optional
        ``predict_boxes(boxes, velocities, seconds)``: the moved boxes. By default, a box is
        expected where it was.
    correct : callable, optional
        ``correct_boxes(expected, velocities, found, gain, seconds)``: boxes and velocities between
        the expected and the measured ones. By default, boxes are where they are found, and
        velocities do not change.
    coast : callable, optional
        ``coast(missed, partners, patience)``: for each track, the number of consecutive frames
        without a box, and whether to keep it. By default, tracks without a box are dropped.
    confirm : callable, optional
        ``confirm(hits, partners, needed)``: for each box, the number of frames in which its track
        has had a box, and whether the track is confirmed. By default, every track is confirmed.
    max_distance : float
        Largest distance for `match`, in metres.
    gain : float
        Gain for `correct`, from 0 to 1.
    patience : int
        Number of frames for `coast`.
    needed : int
        Number of frames for `confirm`.
    newcomer : array_like, shape (3,), optional
        Initial velocity of new tracks in m/s. By default, the median of all tracks, because most
        obstacles do not move and so approach the ego car at its own speed.

    Attributes
    ----------
    tracks : Tracks
        The tracks after the last frame.
    match : callable
        The function passed as `match`.
    """

    def __init__(
        self,
        match: Callable,
        *,
        predict: Callable | None = None,
        correct: Callable | None = None,
        coast: Callable | None = None,
        confirm: Callable | None = None,
        max_distance: float = FARTHEST,
        gain: float = GAIN,
        patience: int = PATIENCE,
        needed: int = NEEDED,
        newcomer: ArrayLike | None = None,
    ) -> None:
        self.match, self._predict, self._correct = match, predict, correct
        self._coast, self._confirm = coast, confirm
        self._max_distance, self._gain = max_distance, gain
        self._patience, self._needed = patience, needed
        self._initial_velocity = newcomer
        self._next_id = 1
        self.tracks = NO_TRACKS

    @property
    def knows_velocities(self) -> bool:
        """Whether velocities are estimated, which requires both `predict` and `correct`."""
        return bool(self._predict and self._correct)

    def update(self, found: np.ndarray, seconds: float = 0.1) -> np.ndarray:
        """Update the tracks with the boxes of the next frame.

        Parameters
        ----------
        found : ndarray, shape (N, 8, 3)
        seconds : float
            Time since the previous frame.

        Returns
        -------
        ndarray of int, shape (N,)
            The track ID of each box.
        """
        found, old = np.asarray(found, dtype=float).reshape(-1, 8, 3), self.tracks
        expected = old.boxes
        if self._predict and len(expected):
            expected = np.asarray(self._predict(old.boxes, old.velocities, seconds))
        partners = np.asarray(self.match(expected, found, self._max_distance), dtype=int)
        matched_rows = np.flatnonzero((partners >= 0) & (partners < len(old.ids)))
        rows = partners[matched_rows]
        matched_tracks = self._new_tracks(found)
        matched_tracks.ids[matched_rows], matched_tracks.age[matched_rows] = (
            old.ids[rows],
            old.age[rows] + 1,
        )
        matched_tracks.velocities[matched_rows] = old.velocities[rows]
        if self._correct and len(matched_rows):
            matched_tracks.boxes[matched_rows], matched_tracks.velocities[matched_rows] = (
                self._correct(
                    expected[rows], old.velocities[rows], found[matched_rows], self._gain, seconds
                )
            )
        new = np.setdiff1d(np.arange(len(found)), matched_rows)
        matched_tracks.ids[new] = self._next_id + np.arange(len(new))
        self._next_id += len(new)
        if self._confirm:
            matched_tracks.age[:], matched_tracks.confirmed[:] = self._confirm(
                old.age, partners, self._needed
            )
        self.tracks = matched_tracks + self._coasting_tracks(expected, partners)
        return matched_tracks.ids

    def _new_tracks(self, found: np.ndarray) -> Tracks:
        n, velocity = len(found), self._initial_velocity
        if velocity is None:
            followed = self.tracks.velocities
            velocity = np.median(followed, axis=0) if len(followed) else np.zeros(3)
        nothing = np.zeros(n, dtype=int)
        return Tracks(
            nothing, found.copy(), np.tile(velocity, (n, 1)).astype(float), nothing.copy(),
            np.ones(n, dtype=int), np.ones(n, dtype=bool),
        )  # fmt: skip

    def _coasting_tracks(self, expected: np.ndarray, partners: np.ndarray) -> Tracks:
        """Return the tracks that are kept without a box in this frame."""
        old = self.tracks
        if not (self._coast and len(old.ids)):
            return NO_TRACKS
        missed, kept = map(np.asarray, self._coast(old.missed, partners, self._patience))
        coasts = ~np.isin(np.arange(len(old.ids)), partners) & kept.astype(bool)
        moved = replace(old, boxes=expected, missed=missed.astype(int))
        return moved[coasts]


def tracker_from(functions: SimpleNamespace, **settings: object) -> Tracker | None:
    """Build a tracker from the functions of a lesson 12 notebook.

    Parameters
    ----------
    functions : types.SimpleNamespace
        From `utils.load_my_functions`. Missing functions and stubs are left out.
    **settings : object
        Settings of `Tracker`, such as ``max_distance``.

    Returns
    -------
    Tracker or None
        None if `match_boxes` is not written.
    """
    written = {
        name: function
        for name, function in vars(functions).items()
        if callable(function) and not hasattr(function, "is_stub")
    }
    if "match_boxes" not in written:
        return None
    step_names = {
        "predict": "predict_boxes",
        "correct": "correct_boxes",
        "coast": "coast",
        "confirm": "confirm",
    }
    own_steps = {part: written.get(name) for part, name in step_names.items()}
    return Tracker(written["match_boxes"], **own_steps, **settings)
