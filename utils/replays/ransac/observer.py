"""Observer that finds the rounds of a search while it runs.

A round is a call to `line_through` or `plane_through` from any function. Its arguments are the
sample, and its return value is the model. In a search without these calls, a round begins when new
points of the cloud appear in as many variables as a sample has points.
"""

from __future__ import annotations

import inspect
from collections.abc import Hashable
from dataclasses import dataclass, field
from types import CodeType, FrameType

import numpy as np

from utils.replays.ransac.tasks import ROUNDING, ROUNDS, Task
from utils.replays.tracer import RecordingComplete, values_in

MAX_ROUNDS = 3 * ROUNDS


@dataclass
class Round:
    """A sample with its model, and the masks that appeared in the round.

    If the sample does not consist of points of the cloud, `rows` is None and distances from the
    model are unknown.
    """

    task: Task
    number: int
    sample: np.ndarray | None
    model: np.ndarray | None = None
    raised: bool = False
    masks: dict[Hashable, tuple[bool, ...]] = field(default_factory=dict)

    @property
    def rows(self) -> list[int] | None:
        """Rows of the sample's points in the cloud; None if a point is not in the cloud."""
        if self.sample is None:
            return None
        gaps = np.linalg.norm(self.task.xyz[:, None] - self.sample, axis=2)
        return gaps.argmin(axis=0).tolist() if (gaps.min(axis=0) < ROUNDING).all() else None

    @property
    def near(self) -> np.ndarray | None:
        """Mask of the points within the tolerance of the model; None if it is unknown."""
        if self.model is None or self.rows is None:
            return None
        return distances_from(self.task.xyz, self.model) <= self.task.tolerance

    @property
    def count(self) -> int:
        """Number of points near the model."""
        return 0 if self.near is None else int(self.near.sum())


class SampleObserver:
    """Records each sample with its model, and all masks that appear in its round."""

    def __init__(self, task: Task, code: CodeType | None) -> None:
        self._task, self._code = task, code
        self._calls: list[Round] = []
        self._inferred: list[Round] = []  # found without a call
        self._last: dict[Hashable, tuple] = {}
        self._points: list[np.ndarray] = []  # points of the latest sample found without a call

    @property
    def rounds(self) -> list[Round]:
        """Rounds observed so far."""
        return self._calls or self._inferred

    @property
    def was_called(self) -> bool:
        """Whether the rounds were observed as calls, which ensures that none was missed."""
        return bool(self._calls)

    def see(self, frame: FrameType, event: str, value: object) -> None:
        """Store new samples, models and masks; `record` calls this at every event."""
        if self._code is not None and frame.f_code is self._code:
            self._see_model(event, frame, value)
            return
        if not self._calls:
            self._see_sample(frame)
        for name, held in values_in(frame) if self.rounds else ():
            mask = as_mask(held, len(self._task.points))
            if mask is not None and self._last.get(name) != (id(held), mask):
                self._last[name] = id(held), mask
                self.rounds[-1].masks[name] = mask

    def _begin(self, rounds: list[Round], sample: np.ndarray | None) -> None:
        if len(rounds) == MAX_ROUNDS:
            raise RecordingComplete
        rounds.append(Round(self._task, len(rounds) + 1, sample))

    def _see_model(self, event: str, frame: FrameType, value: object) -> None:
        if event == "call":
            self._begin(self._calls, _sample_in(frame, self._task.size))
        elif event == "exception":
            self._calls[-1].raised = True
        elif event == "line":  # the function has caught the exception
            self._calls[-1].raised = False
        elif event == "return" and not self._calls[-1].raised:
            self._calls[-1].model = as_model(value, self._task.size)

    def _see_sample(self, frame: FrameType) -> None:
        size = self._task.size
        held = [local for local in frame.f_locals.values() if self._is_point(local)]
        if len(held) == size and not any(point is old for point in held for old in self._points):
            self._points = held
            self._begin(self._inferred, np.array([point[:size] for point in held], dtype=float))
            if len(set(self._inferred[-1].rows)) == size:
                self._inferred[-1].model = _model_through(self._inferred[-1].sample)

    def _is_point(self, value: object) -> bool:
        if not isinstance(value, np.ndarray) or value.ndim != 1 or value.dtype.kind != "f":
            return False
        xyz = value[: self._task.size]
        if len(value) not in (self._task.size, self._task.points.shape[1]):
            return False
        return bool((np.linalg.norm(self._task.xyz - xyz, axis=1) < ROUNDING).any())


def _model_through(sample: np.ndarray) -> np.ndarray:
    """Return the line or plane through a sample, with a unit normal."""
    model = np.linalg.svd(np.column_stack([sample, np.ones(len(sample))]))[2][-1]
    return model / np.linalg.norm(model[:-1])


def _sample_in(frame: FrameType, size: int) -> np.ndarray | None:
    """Return the arguments of a call as points, shape (size, size); None if they are not points."""
    code = frame.f_code
    names = code.co_varnames[: code.co_argcount + bool(code.co_flags & inspect.CO_VARARGS)]
    values = [frame.f_locals[name] for name in names]
    if code.co_flags & inspect.CO_VARARGS:
        values = [*values[:-1], *values[-1]]
    try:
        sample = np.array([np.asarray(value, dtype=float)[:size] for value in values])
    except (TypeError, ValueError, IndexError):
        return None
    return sample if sample.shape == (size, size) else None


def as_model(value: object, size: int) -> np.ndarray | None:
    """Return the coefficients of a line or a plane as an array; None for anything else."""
    try:
        model = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None
    if model.shape != (size + 1,) or not np.isfinite(model).all() or not model[:size].any():
        return None
    return model


def as_mask(value: object, count: int) -> tuple[bool, ...] | None:
    """Return a mask as a tuple with one bool per point; None for anything else."""
    if isinstance(value, np.ndarray) and value.shape == (count,) and value.dtype.kind in "biu":
        value = value.tolist()
    if type(value) is not list or len(value) != count:
        return None
    if not all(isinstance(flag, bool | np.bool_ | int) and flag in (0, 1) for flag in value):
        return None
    return tuple(map(bool, value))


def distances_from(points: np.ndarray, model: np.ndarray) -> np.ndarray:
    """Return the distance of each point from a line or plane, with a normal of any length."""
    normal = model[:-1]
    return np.abs(points @ normal + model[-1]) / np.linalg.norm(normal)
