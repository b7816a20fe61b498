"""Limits on the time that a notebook's process uses, and on elapsed time."""

from __future__ import annotations

import contextlib
import random
import time
from collections import Counter
from collections.abc import Iterator

from grader.sandbox.inside import wire
from grader.sandbox.protocol import Limits, Thread, Worker
from grader.sandbox.usage import own_seconds

# Elapsed time that a step may take, in multiples of its limit. This applies only if the kernel does
# not show whether a process sleeps or waits for a processor.
MAX_ELAPSED_FACTOR = 3
FIRST_MEASUREMENT = 0.05  # seconds; most replies arrive within this time
# Pause before the next measurement, as a share of the elapsed time. It is multiplied by a random
# factor between 1 and 2, so that student code cannot predict the measurement.
NEXT_MEASUREMENT = 1 / 16
_RANDOM = random.SystemRandom()


class Budget:
    """The remaining time of a notebook, for all of its processes together.

    Attributes
    ----------
    seconds : float
        Remaining time, as measured by a `Meter`.
    deadline : float
        Time on the monotonic clock at which the judge gives up on the notebook. The judge's own
        time, and time for which code waits for a processor, postpone it.
    failed_seconds : dict of str to float
        Seconds used by calls that raised or were stopped, by exercise or other step of a
        `StudentProxy`.
    judge_seconds : collections.Counter
        Processor seconds that the judge itself spent on failed checks and diagnosis, by exercise.
    timeouts : dict of str to str
        The first message that a step took too long, by exercise or other step.
    cells_finish : bool
        Whether the notebook's own cells finished when they last ran.
    starved : bool
        Whether the machine was too busy or had too little memory in any step: the judge gave up on
        code that had not used up its time, or a process was killed below its memory limit.
    """

    def __init__(self, limits: Limits) -> None:
        self.seconds = limits.total_seconds
        self.deadline = time.monotonic() + limits.wall_seconds
        self._judge_seconds_before = own_seconds()
        self.failed_seconds: dict[str, float] = {}
        self.judge_seconds: Counter[str] = Counter()
        self.timeouts: dict[str, str] = {}
        self.cells_finish, self.starved = True, False

    def postpone_deadline(self, waiting_seconds: float = 0.0) -> None:
        """Postpone the deadline by the judge's own time since the last call, and by a waiting time.

        Points would otherwise depend on how busy the machine is.

        Parameters
        ----------
        waiting_seconds : float
            Seconds for which a worker waited for a processor while the judge waited for the worker.
        """
        judge_seconds = own_seconds()
        self.deadline += waiting_seconds + judge_seconds - self._judge_seconds_before
        self._judge_seconds_before = judge_seconds

    def seconds_to_deadline(self) -> float:
        """Return the seconds until the deadline, which is negative after it."""
        self.postpone_deadline()
        return self.deadline - time.monotonic()

    @contextlib.contextmanager
    def charge_if_failed(self, task: str) -> Iterator[None]:
        """Count all seconds used in a with block as seconds of failed calls, if the block raises.

        A slow wrong function therefore gets no more time than one that hangs.
        """
        seconds, failed = self.seconds, self.failed_seconds.get(task, 0.0)
        try:
            yield
        except Exception:
            failed += seconds - self.seconds
            self.failed_seconds[task] = max(failed, self.failed_seconds.get(task, 0.0))
            raise

    def add_failed_seconds(self, task: str, seconds: float) -> None:
        """Record the seconds of a call that raised or had to be stopped."""
        self.failed_seconds[task] = self.failed_seconds.get(task, 0.0) + seconds


class Meter:
    """A meter of the time that a worker uses, counted from its creation.

    This time is the worker's processor time plus the time for which it sleeps. A worker counts as
    asleep if none of its threads is ready to run at the time of a measurement. The sum is at most
    the elapsed time minus the time for which the worker waits for a processor or for the judge,
    unless the processor time alone exceeds that.

    Attributes
    ----------
    seconds : float
        Time used until the last measurement.
    elapsed_seconds : float
        Elapsed time until the last measurement.
    waiting_seconds : float
        Seconds, until the last measurement, in which the worker neither ran nor slept and the judge
        did not run; 0 if the kernel does not show this.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker, self._start = worker, time.monotonic()
        self._initial_cpu_seconds, self._initial_judge_seconds = worker.cpu_seconds(), own_seconds()
        self._threads = worker.threads()
        self._sleep_seconds = self._measured_seconds = 0.0
        self.seconds = self.elapsed_seconds = self.waiting_seconds = 0.0

    @property
    def can_see_waiting(self) -> bool:
        """Whether the kernel shows if a thread sleeps or waits for a processor."""
        return self._threads is not None

    def measure(self, answered: bool = False) -> None:
        """Update the measured time. Frequent updates improve the estimate of the time asleep.

        Parameters
        ----------
        answered : bool
            Whether the worker has just replied, so that none of its threads is ready to run.
        """
        self.elapsed_seconds = time.monotonic() - self._start
        cpu_seconds = self._worker.cpu_seconds() - self._initial_cpu_seconds
        self.seconds = cpu_seconds
        if self.can_see_waiting:
            threads = self._worker.threads() or {}
            # Exclude the time in which the judge itself worked or waited for a processor.
            elapsed = self.elapsed_seconds - (own_seconds() - self._initial_judge_seconds)
            if answered and self._measured_seconds:  # assume the same share as before
                share = self._sleep_seconds / self._measured_seconds
            else:
                share = 1.0 if self._is_asleep(threads) else 0.0
            self._sleep_seconds += share * max(0.0, elapsed - self._measured_seconds)
            self._measured_seconds = elapsed
            upper_bound = elapsed - self._delay_seconds(threads)
            self.seconds = max(cpu_seconds, min(upper_bound, cpu_seconds + self._sleep_seconds))
            self.waiting_seconds = max(0.0, elapsed - self.seconds)

    def _is_asleep(self, threads: dict[int, Thread]) -> bool:
        """Return whether no thread is ready to run, in `threads` and in a second look.

        Threads are read one after another. If a child ends and wakes its parent after the parent
        is read but before the child is read, both seem to be asleep.
        """
        return not (_is_any_ready(threads) or _is_any_ready(self._worker.threads() or {}))

    def _delay_seconds(self, threads: dict[int, Thread]) -> float:
        """Return the seconds for which the worker waited for a processor.

        This is the longest wait of any live thread. The sum over all threads would be too large,
        because one thread may wait while another thread of the worker runs.
        """
        initial_delays = {number: thread.delay_seconds for number, thread in self._threads.items()}
        delays = (
            thread.delay_seconds - initial_delays.get(number, 0.0)
            for number, thread in threads.items()
        )
        return max(delays, default=0.0)


def _is_any_ready(threads: dict[int, Thread]) -> bool:
    return any(thread.is_ready for thread in threads.values())


class TimeLimit:
    """A time limit for one exchange of messages with a worker.

    Parameters
    ----------
    worker : grader.sandbox.protocol.Worker
    seconds : float
        The limit, as measured by a `Meter`.
    deadline : float
        Time on the monotonic clock at which the judge gives up on the worker in any case.
    meter : Meter, optional
        A meter that is already running; by default a new one.

    Attributes
    ----------
    starved : bool
        Whether the judge gave up on a worker that had not used up its time, because the machine
        was busy.
    """

    def __init__(
        self, worker: Worker, seconds: float, deadline: float, meter: Meter | None = None
    ) -> None:
        self._worker, self._seconds, self._deadline = worker, seconds, deadline
        # A measurement takes longer than most exchanges, so the first measurement is delayed.
        self._measure_at, self._meter = time.monotonic() + FIRST_MEASUREMENT, meter
        self.starved = False

    def __call__(self) -> float:
        """Return the maximum number of seconds to wait; see `wire.start_time_limit`.

        Raises
        ------
        grader.sandbox.inside.wire.WireTimeout
            If the limit is used up.
        """
        now = time.monotonic()
        if now >= self._measure_at:
            self._measure_at = now + self._measure(now)
        return self._measure_at - now

    def _measure(self, now: float) -> float:
        """Measure the time used, and return the seconds until the next measurement."""
        if self._meter is None:
            self._meter = Meter(self._worker)
            if not self._meter.can_see_waiting:
                self._deadline = min(self._deadline, now + MAX_ELAPSED_FACTOR * self._seconds)
        self._meter.measure()
        seconds_left = self._seconds - self._meter.seconds
        if seconds_left <= 0 or now >= self._deadline:
            self.starved = seconds_left > 0
            raise wire.WireTimeout
        pause = _RANDOM.uniform(1, 2) * NEXT_MEASUREMENT * self._meter.elapsed_seconds
        return max(FIRST_MEASUREMENT, min(seconds_left, self._deadline - now, pause))

    def used_seconds(self) -> float:
        """Return the seconds used so far; 0 if the exchange ended before the first measurement."""
        if self._meter is None:
            return 0.0
        self._meter.measure(answered=True)
        return max(0.0, self._meter.seconds)

    def waiting_seconds(self) -> float:
        """Return the seconds for which the worker waited, as measured by `used_seconds`."""
        return self._meter.waiting_seconds if self._meter else 0.0
