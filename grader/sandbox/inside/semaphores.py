"""Semaphores of `multiprocessing` that look again and again, as nobody here can be woken.

To wait and to wake across processes take a futex that is not private, which `syscalls` leaves
without effect. What `multiprocessing` builds its locks, queues and pools from looks, sleeps, and
looks again.
"""

import _multiprocessing
import time

SHORTEST, LONGEST = 50e-6, 2e-3


class SemLock(_multiprocessing.SemLock):
    """Like the one that it is made from, but for how it waits."""

    def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
        """Take it; False where it is not free, or not in time."""
        end = None if timeout is None else time.monotonic() + timeout
        pause = SHORTEST
        while not super().acquire(False):
            if not block or (end is not None and time.monotonic() >= end):
                return False
            time.sleep(pause)
            pause = min(2 * pause, LONGEST)
        return True

    def __enter__(self) -> bool:
        return self.acquire()


def poll() -> None:
    """Let every semaphore of this process, and of those that it forks, be such a one."""
    _multiprocessing.SemLock = SemLock
