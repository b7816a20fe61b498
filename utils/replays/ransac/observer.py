"""The rounds of a search, as they are seen from outside.

A round is a call of `line_through` or `plane_through`, whoever makes it: what it gets is the
sample, what it returns is the model. Who does without them has a sample in as many variables, each
new, and each a point of the cloud.
"""

from __future__ import annotations

import inspect
from collections.abc import Hashable
from dataclasses import dataclass, field
from types import CodeType, FrameType

import numpy as np

from utils.replays.ransac.tasks import HAIR, ROUNDS, Task
from utils.replays.tracer import Enough, values_in

MOST_ROUNDS = 3 * ROUNDS


@dataclass
class Round:
    """A sample, and what was made of it.

    Its rows are None where it is none of the points: then nothing is known of distances.
    """

    task: Task
    number: int
    sample: np.ndarray | None
    model: np.ndarray | None = None
    raised: bool = False
    masks: dict[Hashable, tuple[bool, ...]] = field(default_factory=dict)

    @property
    def rows(self) -> list[int] | None:
        """The numbers of the points in the sample."""
        if self.sample is None:
            return None
        gaps = np.linalg.norm(self.task.xyz[:, None] - self.sample, axis=2)
        return gaps.argmin(axis=0).tolist() if (gaps.min(axis=0) < HAIR).all() else None

    @property
    def near(self) -> np.ndarray | None:
        """Which points are near the model, as geometry says."""
        if self.model is None or self.rows is None:
            return None
        return gaps_from(self.task.xyz, self.model) <= self.task.tolerance

    @property
    def count(self) -> int:
        """How many these are."""
        return 0 if self.near is None else int(self.near.sum())


class SampleObserver:
    """Notes each sample with its model, and all masks that come up in its round."""

    def __init__(self, task: Task, code: CodeType | None) -> None:
        self._task, self._code = task, code
        self._called: list[Round] = []
        self._met: list[Round] = []  # without a call
        self._last: dict[Hashable, tuple] = {}
        self._points: list[np.ndarray] = []  # of the last sample that was met

    @property
    def rounds(self) -> list[Round]:
        """What was seen."""
        return self._called or self._met

    @property
    def was_called(self) -> bool:
        """Whether these rounds are calls, and so all that there were."""
        return bool(self._called)

    def see(self, frame: FrameType, event: str, value: object) -> None:
        """Take down what is new; `record` calls it."""
        if self._code is not None and frame.f_code is self._code:
            self._see_model(event, frame, value)
            return
        if not self._called:
            self._see_sample(frame)
        for name, held in values_in(frame) if self.rounds else ():
            mask = as_mask(held, len(self._task.points))
            if mask is not None and self._last.get(name) != (id(held), mask):
                self._last[name] = id(held), mask
                self.rounds[-1].masks[name] = mask

    def _begin(self, rounds: list[Round], sample: np.ndarray | None) -> None:
        if len(rounds) == MOST_ROUNDS:
            raise Enough
        rounds.append(Round(self._task, len(rounds) + 1, sample))

    def _see_model(self, event: str, frame: FrameType, value: object) -> None:
        if event == "call":
            self._begin(self._called, _sample_in(frame, self._task.size))
        elif event == "exception":
            self._called[-1].raised = True
        elif event == "line":  # it was caught
            self._called[-1].raised = False
        elif event == "return" and not self._called[-1].raised:
            self._called[-1].model = as_model(value, self._task.size)

    def _see_sample(self, frame: FrameType) -> None:
        size = self._task.size
        held = [local for local in frame.f_locals.values() if self._is_point(local)]
        if len(held) == size and not any(one is old for one in held for old in self._points):
            self._points = held
            self._begin(self._met, np.array([one[:size] for one in held], dtype=float))
            if len(set(self._met[-1].rows)) == size:
                self._met[-1].model = _through(self._met[-1].sample)

    def _is_point(self, value: object) -> bool:
        if not isinstance(value, np.ndarray) or value.ndim != 1 or value.dtype.kind != "f":
            return False
        xyz = value[: self._task.size]
        if len(value) not in (self._task.size, self._task.points.shape[1]):
            return False
        return bool((np.linalg.norm(self._task.xyz - xyz, axis=1) < HAIR).any())


def _through(sample: np.ndarray) -> np.ndarray:
    """What runs through a sample: the direction in which it has no extent at all."""
    model = np.linalg.svd(np.column_stack([sample, np.ones(len(sample))]))[2][-1]
    return model / np.linalg.norm(model[:-1])


def _sample_in(frame: FrameType, size: int) -> np.ndarray | None:
    """The points that a function got; shape (size, size)."""
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
    """The numbers of a line or a plane; None for anything else."""
    try:
        model = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return None
    if model.shape != (size + 1,) or not np.isfinite(model).all() or not model[:size].any():
        return None
    return model


def as_mask(value: object, count: int) -> tuple[bool, ...] | None:
    """Something that says yes or no to each point."""
    if isinstance(value, np.ndarray) and value.shape == (count,) and value.dtype.kind in "biu":
        value = value.tolist()
    if type(value) is not list or len(value) != count:
        return None
    if not all(isinstance(one, bool | np.bool_ | int) and one in (0, 1) for one in value):
        return None
    return tuple(map(bool, value))


def gaps_from(points: np.ndarray, model: np.ndarray) -> np.ndarray:
    """Distance of each point from a line or a plane, whose normal may have any length."""
    normal = model[:-1]
    return np.abs(points @ normal + model[-1]) / np.linalg.norm(normal)
