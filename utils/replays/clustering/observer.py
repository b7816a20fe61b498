"""Observer that finds the labels and the queue among the variables of a student's function.

Any list or array with one entry per point may contain the labels. Any deque, list or set may
contain the waiting points. They are recognised by their changes, not by their names.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from types import FrameType

import numpy as np

from utils.replays.clustering.points import POINTS, ROWS
from utils.replays.tracer import RecordingComplete, values_in

MAX_MOMENTS, MAX_WAITING = 5_000, 300


@dataclass
class VariableTrack:
    """History of one variable, also in the functions to which it is passed.

    Attributes
    ----------
    last : object
        Latest object in the variable.
    states : list of (int, tuple, bool)
        Time of each change, the new value, and whether it is a new object.
    """

    last: object
    states: list[tuple[int, tuple, bool]] = field(default_factory=list)


class LabelObserver:
    """Records every variable that may contain the labels or the queue, at every line."""

    def __init__(self) -> None:
        self.tracks: list[VariableTrack] = []
        self.queues: list[VariableTrack] = []
        self._known: dict[tuple[str, Hashable], VariableTrack] = {}
        self._time = self._moments = 0

    def see(self, frame: FrameType, event: str, _: object) -> None:
        """Store the variables that have changed; `record` calls this at every event."""
        self._time += 1
        for name, value in values_in(frame):
            if (state := _as_entries(value)) is not None:
                self._note(self.tracks, "labels", name, value, state)
            if (state := _as_rows(value)) is not None:
                self._note(self.queues, "queue", name, value, state)
        if self._moments > MAX_MOMENTS:
            raise RecordingComplete

    def _note(
        self, tracks: list[VariableTrack], kind: str, name: Hashable, value: object, state: tuple
    ) -> None:
        # A track continues with the same object under another name, or with another object under
        # the same name.
        track = self._known.get((kind, id(value)))
        if track is None or track.last is not value:  # Python reuses the id of a deleted object
            track = self._known.get((kind, name))
        if track is None:
            track = VariableTrack(value)
            tracks.append(track)
        is_new = track.last is not value or not track.states
        track.last = value
        self._known[kind, id(value)] = self._known[kind, name] = track
        if is_new or track.states[-1][1] != state:
            self._moments += bool(track.states) and track.states[-1][1] != state
            track.states.append((self._time, state, is_new))


def _as_entries(value: object) -> tuple | None:
    """Return the entries of a list or array with one per point; None for anything else."""
    if isinstance(value, np.ndarray):
        is_one_each = value.shape == (len(POINTS),) and value.dtype.kind in "iuf"
        value = value.tolist() if is_one_each else None
    if type(value) is not list or len(value) != len(POINTS):
        return None
    if not all(entry is None or _is_number(entry) for entry in value):
        return None
    return tuple(None if entry != entry else entry for entry in value)  # NaN != NaN


def _as_rows(value: object) -> tuple | None:
    """Return the rows of points in a deque, list or set; None for anything else."""
    if type(value) not in (deque, list, set) or len(value) > MAX_WAITING:
        return None
    if not all(_is_number(row) and row in ROWS for row in value):
        return None
    return tuple(int(row) for row in (sorted(value) if type(value) is set else value))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | np.number) and not isinstance(value, bool)


def as_labels(answer: object) -> list | None:
    """Return an answer with one label per point as a list; None for anything else."""
    if isinstance(answer, np.ndarray) and answer.shape == (len(POINTS),):
        answer = answer.tolist()
    if isinstance(answer, list | tuple) and len(answer) == len(POINTS):
        return list(answer) if all(map(_is_number, answer)) else None
    return None


def find_labels(
    tracks: list[VariableTrack], returned: object, answer: list | None
) -> VariableTrack | None:
    """Find the variable with the labels: the returned one, or one with the same final groups."""
    changing = [track for track in tracks if len({state for _, state, _ in track.states}) > 1]
    for track in changing:
        if track.last is returned:
            return track
    if answer is not None:
        changing = [
            track
            for track in changing
            if group_numbers(track.states[-1][1]) == group_numbers(answer)
        ]
    # Labels begin with the same value for all points; several such variables are ambiguous.
    begins_alike = [track for track in changing if len(set(track.states[0][1])) == 1]
    return begins_alike[0] if len(begins_alike) == 1 else None


def group_numbers(labels: Sequence) -> list[int]:
    """Number the labels in order of appearance, so that equal groups give equal numbers."""
    order = {label: number for number, label in enumerate(dict.fromkeys(labels))}
    return [order[label] for label in labels]


def find_queue(queues: list[VariableTrack]) -> VariableTrack | None:
    """Find the queue, which gains points and loses one at a time; None if it is ambiguous."""

    def is_queue(track: VariableTrack) -> bool:
        steps = list(zip(track.states, track.states[1:], strict=False))
        kept = [(before[1], after[1]) for before, after in steps if not after[2]]
        gained = any(Counter(after) - Counter(before) for before, after in kept)
        lost = any((Counter(before) - Counter(after)).total() == 1 for before, after in kept)
        return gained and lost

    found = [track for track in queues if is_queue(track)]
    return found[0] if len(found) == 1 else None
