"""Measure a detector's delay in scans, independently of the machine's speed."""

from __future__ import annotations

import math
import statistics
import time
from collections import deque
from collections.abc import Callable

import numpy as np

from utils.drive.rules import TICK

REFERENCE_SECONDS = 0.020
"""Seconds of processor time that `_run_benchmark` takes on the reference machine."""

CALLS_IN_MEDIAN = 5
"""Number of latest calls whose median counts, so that one slow call does not matter."""


class Clock:
    """Measures the processor time of calls, converted to time on the reference machine.

    The constructor times a fixed piece of work to determine how fast this machine is. The time of
    all threads counts.
    """

    def __init__(self) -> None:
        took = []
        for _ in range(5):
            start = time.process_time()
            _run_benchmark()
            took.append(time.process_time() - start)
        self._speed_factor = REFERENCE_SECONDS / max(min(took), 1e-6)
        self._latest_durations = deque(maxlen=CALLS_IN_MEDIAN)

    def __call__(self, call: Callable[[], object]) -> tuple[object, float]:
        """Return the result of a call, and the median duration of the latest calls in seconds."""
        start = time.process_time()
        answer = call()
        self._latest_durations.append((time.process_time() - start) * self._speed_factor)
        return answer, statistics.median_low(self._latest_durations)


def on_time(call: Callable[[], object]) -> tuple[object, float]:
    """Return the result of a call and a duration of 0 s, so that its answer is never late."""
    return call(), 0.0


def ticks(seconds: float) -> int:
    """Return the number of scans after which an answer is available, at least 1."""
    return max(1, math.ceil(seconds / TICK - 1e-9))


def _run_benchmark() -> None:
    """Run operations that are typical of detectors: sort, compare, gather, and a Python loop."""
    values = (np.arange(60_000) * 7919 % 60_013).astype(float)
    for _ in range(3):
        order = np.argsort(values, kind="stable")
        np.unique(np.floor(values[order] / 7), return_inverse=True)
    total = 0
    for value in range(60_000):
        total += value & 3
