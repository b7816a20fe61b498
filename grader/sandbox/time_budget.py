"""How long a notebook may take: by what its process takes, and by one clock on the wall."""

from __future__ import annotations

import random
import time

from grader.sandbox.inside import wire
from grader.sandbox.protocol import Limits, Thread, Worker
from grader.sandbox.usage import seconds_of_our_own

# How many times its limit a step may take by the clock on the wall, where nobody can tell who
# waits for a processor from who sleeps.
PATIENCE = 3
SOON = 0.05  # seconds, in which most answers come
# After what share of a step's time it is looked at again, at least twice that at most: nobody
# knows when.
NEXT_LOOK = 1 / 16
_DICE = random.SystemRandom()


class Budget:
    """What a notebook may still take, over all the processes that it is asked in.

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

    That is the processor's time, and the time for which it sleeps: none of its threads was ready to
    run when it was looked at. All that passes while nobody keeps it waiting is the most it can be,
    neither others who are at work on this machine, nor we.

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
        self._threads = worker.threads()
        self._slept = self._noticed = 0.0
        self.seconds = self.waited = 0.0

    @property
    def tells(self) -> bool:
        """Whether who sleeps is told from who waits for a processor."""
        return self._threads is not None

    def look(self, answered: bool = False) -> None:
        """Read it; the oftener, the better is told for how long it sleeps.

        Parameters
        ----------
        answered : bool
            Whether it has done its work, so that nothing of it is ready to run.
        """
        self.waited = time.monotonic() - self._begin
        worked = self._worker.cpu_seconds() - self._had
        self.seconds = worked
        if self.tells:
            now = self._worker.threads() or {}
            # What passed while we were at work ourselves is ours.
            passed = self.waited - (seconds_of_our_own() - self._ours)
            share = 0.0 if any(thread.ready for thread in now.values()) else 1.0
            if answered and self._noticed:
                share = self._slept / self._noticed  # as before
            self._slept += share * max(0.0, passed - self._noticed)
            self._noticed = passed
            most = passed - self._delayed(now)
            self.seconds = max(worked, min(most, worked + self._slept))

    def _delayed(self, now: dict[int, Thread]) -> float:
        """Seconds for which others kept it waiting, of which threads that have ended tell nothing.

        That is the longest that any of its threads was. Their sum would be the larger, the more of
        them wait for each other; but while one waits for others, these work at least as long.
        """
        begun = {number: thread.delayed for number, thread in self._threads.items()}
        delays = (thread.delayed - begun.get(number, 0.0) for number, thread in now.items())
        return max(delays, default=0.0)


class Patience:
    """What a worker may take for one step of the conversation, from now on.

    Parameters
    ----------
    worker : grader.sandbox.protocol.Worker
    seconds : float
        Its limit, as a `Meter` counts.
    until : float
        When it is given up in any case.
    meter : Meter, optional
        What reads what the worker takes, if somebody has begun to.

    Attributes
    ----------
    starved : bool
        Whether the worker was given up before it had had its time: on a quieter machine it may be
        right.
    """

    def __init__(
        self, worker: Worker, seconds: float, until: float, meter: Meter | None = None
    ) -> None:
        self._worker, self._seconds, self._until = worker, seconds, until
        # Looking takes longer than most steps.
        self._look_at, self._meter = time.monotonic() + SOON, meter
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
        nap = _DICE.uniform(1, 2) * NEXT_LOOK * self._meter.waited
        return max(SOON, min(left, self._until - now, nap))

    def taken(self) -> float:
        """Seconds that the step has cost so far; nothing if it took no longer than most do."""
        if self._meter is None:
            return 0.0
        self._meter.look(answered=True)
        return max(0.0, self._meter.seconds)
