"""Time implementations in turn, so that a busy machine slows all of them alike."""

from __future__ import annotations

import json
import multiprocessing
import os
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grader.course.paths import PROJECT

FOLDER = PROJECT / ".bench"
ROUNDS = int(os.environ.get("ROUNDS", 9))
# Seconds after which a slow implementation skips its remaining rounds.
PATIENCE = float(os.environ.get("PATIENCE", 20))

# A function that takes a cloud and returns a function that does the work and returns the answer.
Implementation = Callable[[np.ndarray], Callable[[], np.ndarray]]


class MissingProgram(Exception):
    """An implementation cannot run here; `str()` says what is not installed."""


@dataclass(frozen=True)
class Result:
    """Times, answer and memory of one implementation on one cloud.

    Attributes
    ----------
    seconds : ndarray, shape (rounds,)
        Time of each round, or NaN if the round was skipped.
    answer : ndarray
    memory : float
        Peak bytes of a separate process, minus its bytes before the call; NaN if the system does
        not report them.
    """

    seconds: np.ndarray
    answer: np.ndarray
    memory: float

    @property
    def median(self) -> float:
        """Median seconds of all rounds."""
        return float(np.nanmedian(self.seconds))

    @property
    def least(self) -> float:
        """Seconds of the shortest round, which other processes disturbed least."""
        return float(np.nanmin(self.seconds))

    def times_as_long_as(self, reference: Result) -> tuple[float, float, float]:
        """Return the median, minimum and maximum of the ratios to another result's times."""
        quotients = self.seconds / reference.seconds
        return tuple(float(value) for value in np.nanpercentile(quotients, (50, 0, 100)))


def race(
    implementations: dict[str, Implementation], cloud: np.ndarray, memory: bool = True
) -> dict[str, Result]:
    """Run all installed implementations on a cloud, in turn.

    Parameters
    ----------
    implementations : dict of str to callable
    cloud : ndarray, shape (n, 3)
    memory : bool
        Whether to also measure memory, in a separate process for each implementation.

    Returns
    -------
    dict of str to Result
        Results of the installed implementations. A line is printed for each of the others.
    """
    ready, answers = {}, {}
    for name, implementation in implementations.items():
        try:
            work = implementation(cloud)
            answers[name] = work()  # imports, compiles and warms up
            ready[name] = work
        except (ImportError, MissingProgram) as reason:
            print(f"  {name} is skipped: {reason}")
    seconds = {name: np.full(ROUNDS, np.nan) for name in ready}
    for number in range(ROUNDS if ready else 0):
        names = list(ready)
        for name in names[number % len(names) :] + names[: number % len(names)]:
            if np.nansum(seconds[name]) < PATIENCE:
                begin = time.perf_counter()
                ready[name]()
                seconds[name][number] = time.perf_counter() - begin
    return {
        name: Result(
            seconds[name],
            answers[name],
            peak_of(implementations[name], cloud) if memory else float("nan"),
        )
        for name in ready
    }


def peak_of(implementation: Implementation, cloud: np.ndarray) -> float:
    """Return the peak bytes that a call adds in a separate process, after a call to warm up."""
    if not Path("/proc/self/clear_refs").exists():
        return float("nan")
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_peak, (implementation, cloud))


def _peak(implementation: Implementation, cloud: np.ndarray) -> float:
    implementation(cloud[:: len(cloud) // 1000 + 1])()
    work = implementation(cloud)
    process = getattr(work, "process", "self")
    before = _resident(process, "VmRSS")
    Path(f"/proc/{process}/clear_refs").write_text("5")  # resets VmHWM, the peak
    work()
    return _resident(process, "VmHWM") - before


def _resident(process: int | str, entry: str) -> float:
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith(entry))


def same_partition(labels: np.ndarray, others: np.ndarray) -> bool:
    """Return whether two labellings group the points in the same way."""
    pairs = np.unique(np.stack([labels, others]), axis=1).shape[1]
    return pairs == len(np.unique(labels)) == len(np.unique(others))


def exponent(sizes: Iterable[float], seconds: Iterable[float]) -> float:
    """Return the slope of the line through sizes and seconds on logarithmic axes."""
    return float(np.polyfit(np.log(list(sizes)), np.log(list(seconds)), 1)[0])


def save_results(subject: str, measurements: dict) -> Path:
    """Add measurements under a subject to `.bench/measured.json` and return its path."""
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / "measured.json"
    record = json.loads(path.read_text()) if path.exists() else {}
    path.write_text(json.dumps(record | {subject: measurements}, indent=1) + "\n")
    return path
