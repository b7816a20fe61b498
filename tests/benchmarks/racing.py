"""Time implementations in turn, so that a busy machine slows all of them alike.

Each implementation has its own process, which is paused while others take their turn. In a common
process, the libraries would slow each other: after a call of dbscan, its threads keep looking for
work, and the state of the heap decides how many fresh pages the next call needs.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import platform
import signal
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from grader.classroom.executors import processor_count
from grader.course.paths import PROJECT

FOLDER = PROJECT / ".bench"
ROUNDS = int(os.environ.get("ROUNDS", 9))
# Seconds after which a slow implementation skips its remaining rounds.
PATIENCE = float(os.environ.get("PATIENCE", 20))
SEED = int(os.environ.get("SEED", np.random.SeedSequence().entropy % 10**6))
# More bytes than a processor's caches hold.
EVICTING_BYTES = 2**27
# A call of this many seconds takes equally long with cold caches.
LONG_CALL = 1.0

# A function that takes a cloud and returns a function that does the work and returns the answer.
Implementation = Callable[[np.ndarray], Callable[[], np.ndarray]]


class MissingProgram(Exception):
    """An implementation cannot run here; `str()` says what is not installed."""


class Competitor:
    """A process in which one implementation is ready to work on one cloud.

    Parameters
    ----------
    implementation : callable
    cloud : ndarray, shape (n, 3)

    Attributes
    ----------
    answer : ndarray
    memory : float
        Peak bytes that a call adds; NaN if the system does not report them.

    Raises
    ------
    ImportError, MissingProgram
        If a library or program is not installed.
    """

    def __init__(self, implementation: Implementation, cloud: np.ndarray) -> None:
        self._executor = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
        self._process = self._executor.submit(os.getpid).result()
        self.answer, self.memory = self._executor.submit(_prepare, implementation, cloud).result()
        os.kill(self._process, signal.SIGSTOP)

    def turn(self) -> tuple[float, float, float]:
        """Return seconds of a call with cold caches, of the next, and the latter's CPU seconds."""
        os.kill(self._process, signal.SIGCONT)
        times = self._executor.submit(_take_turn).result()
        os.kill(self._process, signal.SIGSTOP)
        return times

    def close(self) -> None:
        """End the process."""
        os.kill(self._process, signal.SIGCONT)
        self._executor.shutdown()


def _prepare(implementation: Implementation, cloud: np.ndarray) -> tuple[np.ndarray, float]:
    global _work  # of this process
    implementation(cloud[:: len(cloud) // 1000 + 1])()  # imports and compiles
    _work = implementation(cloud)
    if not Path("/proc/self/clear_refs").exists():
        return _work(), float("nan")
    before = _resident("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")  # resets VmHWM, the peak
    return _work(), _resident("VmHWM") - before


def _resident(entry: str) -> float:
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith(entry))


def _take_turn() -> tuple[float, float, float]:
    np.ones(EVICTING_BYTES // 8)
    cold, processor = _time_call()
    return (cold, *(_time_call() if cold < LONG_CALL else (cold, processor)))


def _time_call() -> tuple[float, float]:
    start, processor = time.perf_counter(), time.process_time()
    _work()
    return time.perf_counter() - start, time.process_time() - processor


@contextlib.contextmanager
def started(
    implementations: dict[str, Implementation], cloud: np.ndarray
) -> Iterator[dict[str, Competitor]]:
    """Start the competitors that are installed, and print a line for each of the others."""
    competitors = {}
    with contextlib.ExitStack() as stack:
        for name, implementation in implementations.items():
            try:
                competitors[name] = Competitor(implementation, cloud)
            except (ImportError, MissingProgram) as reason:
                print(f"  {name} is skipped: {reason}")
            else:
                stack.callback(competitors[name].close)
        yield competitors


@dataclass(frozen=True)
class Race:
    """Times of all competitors, by name.

    Attributes
    ----------
    cold : dict of str to list of float
        Seconds of calls after other data has filled the caches; NaN in rounds that were skipped.
    seconds : dict of str to list of float
        Seconds of the calls that followed directly.
    processors : dict of str to float
        Mean number of processors that the latter calls used.
    others : float
        Mean number of other running threads just before the turns; NaN if the system does not say.
    """

    cold: dict[str, list[float]]
    seconds: dict[str, list[float]]
    processors: dict[str, float]
    others: float


def race(competitors: dict[str, Competitor]) -> Race:
    """Give each competitor one turn per round, in random order."""
    times = {name: np.full((3, ROUNDS), np.nan) for name in competitors}
    orders, others = np.random.default_rng(SEED), []
    for number in range(ROUNDS):
        for name in orders.permutation(list(competitors)):
            if np.nansum(times[name][1]) < PATIENCE:
                others.append(other_threads())
                times[name][:, number] = competitors[name].turn()
    return Race(
        {name: cold.tolist() for name, (cold, _, _) in times.items()},
        {name: seconds.tolist() for name, (_, seconds, _) in times.items()},
        {
            name: float(np.nansum(processor) / np.nansum(seconds))
            for name, (_, seconds, processor) in times.items()
        },
        float(np.mean(others)),
    )


def other_threads() -> float:
    """Return how many other threads are running or ready to run; NaN if the system does not say."""
    path = Path("/proc/loadavg")
    return int(path.read_text().split()[3].split("/")[0]) - 1 if path.exists() else float("nan")


def machine() -> str:
    """Return what this machine is, what it runs, its load and the time."""
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    about = dict(line.split(":", 1) for line in lines if ":" in line)
    about = {name.strip(): value.strip() for name, value in about.items()}
    model = about.get("model name", platform.processor() or platform.machine())
    frequency = f", {float(about['cpu MHz']):,.0f} MHz" if "cpu MHz" in about else ""
    return (
        f"{model}, {processor_count()} processors{frequency}; {platform.system()}, "
        f"Python {platform.python_version()}, NumPy {np.__version__}; "
        f"load average {os.getloadavg()[0]:.1f}; {time.strftime('%Y-%m-%d %H:%M %Z')}"
    )


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
