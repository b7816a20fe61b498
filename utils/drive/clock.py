"""How late a detector is, counted so that the machine does not decide."""

from __future__ import annotations

import math
import statistics
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from utils.drive.rules import TICK

STANDARD = 0.020
"""Seconds that `_work` takes on the machine by which all others are measured."""

REMEMBERED = 5
"""Of so many scans the middle one counts: a hiccup is the machine's, and not the detector's."""


class Clock:
    """Counts the processor time of calls, as if on one and the same machine.

    What a fixed piece of work takes in this process says how fast this machine is. The time of
    all threads counts.
    """

    def __init__(self) -> None:
        took = []
        for _ in range(5):
            start = time.process_time()
            _work()
            took.append(time.process_time() - start)
        self._pace = STANDARD / max(min(took), 1e-6)
        self._last = deque(maxlen=REMEMBERED)

    def __call__(self, call: Callable[[], object]) -> tuple[object, float]:
        """What a call returns, and the seconds that such calls take."""
        start = time.process_time()
        answer = call()
        self._last.append((time.process_time() - start) * self._pace)
        return answer, statistics.median_low(self._last)


def on_time(call: Callable[[], object]) -> tuple[object, float]:
    """A clock for whom time does not count: every answer is there with the next scan."""
    return call(), 0.0


def ticks(seconds: float) -> int:
    """Scans after which an answer is there: with the next one, or later."""
    return max(1, math.ceil(seconds / TICK - 1e-9))


def _work() -> None:
    """Sorting, comparing and gathering, as detectors do it, and plain Python."""
    values = (np.arange(60_000) * 7919 % 60_013).astype(float)
    for _ in range(3):
        order = np.argsort(values, kind="stable")
        np.unique(np.floor(values[order] / 7), return_inverse=True)
    total = 0
    for value in range(60_000):
        total += value & 3
