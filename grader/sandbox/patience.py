"""How long a worker may take: by the processor's time, and not by the clock on the wall."""

import time
from collections.abc import Callable

from grader.sandbox.inside import wire

# How many times its limit, by the clock on the wall, a step may take that gets no processor.
PATIENCE = 3
SOON = 0.05  # seconds, in which most answers come
A_WHILE = 0.3  # seconds, beside which the kernel's clock ticks finely enough


class Patience:
    """What a worker may take for one step of the conversation, from now on.

    On a busy machine a right answer comes late, so its limit is of the processor's time. Who waits
    instead of working is given up after a few times as long.

    Parameters
    ----------
    cpu_seconds : callable
        Returns the processor time that the worker has had.
    seconds : float
        Its limit.

    Attributes
    ----------
    starved : bool
        Whether the worker was given up and had hardly had a processor: on a quieter machine it may
        be right.
    """

    def __init__(self, cpu_seconds: Callable[[], float], seconds: float) -> None:
        self._cpu_seconds, self._seconds = cpu_seconds, seconds
        self._begin = time.monotonic()
        # Looking takes longer than most steps.
        self._look_at, self._had, self._worked = self._begin + SOON, None, 0.0
        self.starved = False

    def __call__(self) -> float:
        """For how many seconds at most to wait before it is asked again; see `wire.within`.

        Raises
        ------
        grader.sandbox.inside.wire.WireTimeout
        """
        now = time.monotonic()
        if now >= self._look_at:
            pause = self._look(now - self._begin)
            self._look_at = now + pause
        return self._look_at - now

    def _look(self, waited: float) -> float:
        """For how long not to look again."""
        if self._had is None:
            self._had = self._cpu_seconds()
        else:
            self._worked = self._cpu_seconds() - self._had
        left = min(self._seconds - self._worked, PATIENCE * self._seconds - waited)
        if left <= 0:
            self.starved = self._worked < self._seconds / 2
            raise wire.WireTimeout
        return max(SOON, left)

    @property
    def taken(self) -> float:
        """Seconds that the step has cost so far: of the processor, or a share of the wall's."""
        waited = time.monotonic() - self._begin
        return max(self._worked, waited / PATIENCE) if waited > SOON else 0.0


def stopwatch(cpu_seconds: Callable[[], float]) -> Callable[[], tuple[float, bool]]:
    """Begin to count what a worker takes.

    Parameters
    ----------
    cpu_seconds : callable
        As for `Patience`.

    Returns
    -------
    callable
        Returns seconds of the processor since then, or a share of the wall's, if that is more: what
        its children do for it, a process can hide. And whether the worker was starved meanwhile.
    """
    begin, had = time.monotonic(), cpu_seconds()

    def stop() -> tuple[float, bool]:
        worked, waited = cpu_seconds() - had, time.monotonic() - begin
        share = waited / PATIENCE
        return max(worked, share), waited > A_WHILE and worked < share / 2

    return stop
