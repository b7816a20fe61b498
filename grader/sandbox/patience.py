"""How long a notebook may take: by what its process takes, and by one clock on the wall."""

from __future__ import annotations

import time
from collections.abc import Callable

from grader.sandbox.inside import wire
from grader.sandbox.protocol import Limits, Worker
from grader.sandbox.usage import seconds_of_our_own

# How many times its limit a step may take by the clock on the wall, where nobody can tell who
# waits for a processor from who sleeps. No call is called quicker than this share of the wall's.
PATIENCE = 3
SOON = 0.05  # seconds, in which most answers come
A_WHILE = 0.3  # seconds, beside which the kernel's clock ticks finely enough


class Budget:
    """What a notebook may still take, over all the processes that it is asked in.

    Parameters
    ----------
    limits : grader.sandbox.protocol.Limits

    Attributes
    ----------
    seconds : float
        What is left of its time, as a `Meter` counts it.
    until : float
        When its time by the clock on the wall is over.
    lost : dict of str to float
        Seconds that were taken to no end, by what they were taken for: an exercise, or another
        step of a `Student`.
    hung : dict of str to str
        In which sentence it was first said that one took too long.
    begins : bool
        Whether the notebook's own cells came to their end when they were last run.
    """

    def __init__(self, limits: Limits) -> None:
        self.seconds = limits.total_seconds
        self.until = time.monotonic() + limits.wall_seconds
        self.lost: dict[str, float] = {}
        self.hung: dict[str, str] = {}
        self.begins = True

    def note_lost(self, what: str, seconds: float) -> None:
        """Note that something took so long, and then raised or had to be stopped."""
        self.lost[what] = self.lost.get(what, 0.0) + seconds


class Meter:
    """What a worker takes, from now on.

    That is the processor's time; and whatever passes while nobody keeps it waiting, neither others
    who are at work on this machine, nor we. So who sleeps, or stops itself, or waits for a child
    that hides its work, takes the time on the wall.

    Parameters
    ----------
    worker : grader.sandbox.protocol.Worker

    Attributes
    ----------
    seconds : float
        What it has taken when it was last looked at.
    waited : float
        What had passed until then.
    """

    def __init__(self, worker: Worker) -> None:
        self._worker, self._begin = worker, time.monotonic()
        self._had, self._ours = worker.cpu_seconds(), seconds_of_our_own()
        self._delays = worker.delays()
        self.seconds = self.waited = 0.0

    @property
    def tells(self) -> bool:
        """Whether who sleeps is told from who waits for a processor."""
        return self._delays is not None

    def look(self) -> None:
        """Read it."""
        self.waited = time.monotonic() - self._begin
        worked = self._worker.cpu_seconds() - self._had
        self.seconds = max(worked, self.waited - self._kept() if self.tells else 0.0)

    def _kept(self) -> float:
        """Seconds for which it was kept waiting.

        That is the longest that any of its threads was. Their sum would be the larger, the more of
        them wait for each other; but while one waits for others, these work at least as long.
        """
        before, now = self._delays, self._worker.delays() or {}
        delays = (seconds - before.get(thread, 0.0) for thread, seconds in now.items())
        return max(delays, default=0.0) + seconds_of_our_own() - self._ours


class Patience:
    """What a worker may take for one step of the conversation, from now on.

    Parameters
    ----------
    worker : grader.sandbox.protocol.Worker
    seconds : float
        Its limit, as a `Meter` counts.
    until : float
        When it is given up in any case.

    Attributes
    ----------
    starved : bool
        Whether the worker was given up before it had had its time: on a quieter machine it may be
        right.
    """

    def __init__(self, worker: Worker, seconds: float, until: float) -> None:
        self._worker, self._seconds, self._until = worker, seconds, until
        # Looking takes longer than most steps.
        self._look_at, self._meter = time.monotonic() + SOON, None
        self.starved = False

    def __call__(self) -> float:
        """For how many seconds at most to wait before it is asked again; see `wire.within`.

        Raises
        ------
        grader.sandbox.inside.wire.WireTimeout
        """
        now = time.monotonic()
        if now >= self._look_at:
            self._look_at = now + self._look(now)
        return self._look_at - now

    def _look(self, now: float) -> float:
        """For how long not to look again."""
        if self._meter is None:
            self._meter = Meter(self._worker)
            if not self._meter.tells:
                self._until = min(self._until, now + PATIENCE * self._seconds)
        self._meter.look()
        left = self._seconds - self._meter.seconds
        if left <= 0 or now >= self._until:
            self.starved = left > 0
            raise wire.WireTimeout
        return max(SOON, min(left, self._until - now))

    def taken(self) -> float:
        """Seconds that the step has cost so far; nothing if it took no longer than most do."""
        if self._meter is None:
            return 0.0
        self._meter.look()
        return max(0.0, self._meter.seconds)


def stopwatch(worker: Worker) -> Callable[[], tuple[float, bool]]:
    """Begin to count what a worker takes.

    Parameters
    ----------
    worker : grader.sandbox.protocol.Worker

    Returns
    -------
    callable
        Returns seconds since then, as a `Meter` counts them, or a share of the wall's, if that is
        more: what its children do for it, a process can hide. And whether the worker was starved
        meanwhile.
    """
    meter = Meter(worker)

    def stop() -> tuple[float, bool]:
        meter.look()
        share = meter.waited / PATIENCE
        starved = meter.waited > A_WHILE and meter.seconds < share / 2
        return max(meter.seconds, share), starved

    return stop
