"""Semaphores of `multiprocessing` that poll, because the sandbox forbids shared futexes.

A semaphore normally uses a shared futex to wait for another process or to wake it, but `syscalls`
disables shared futexes. All locks, queues and pools of `multiprocessing` are built on one semaphore
class. This module replaces that class with one that tries, sleeps, and tries again.
"""

import _multiprocessing
import time

MIN_DELAY, MAX_DELAY = 50e-6, 2e-3


class SemLock(_multiprocessing.SemLock):
    """A semaphore that polls."""

    def acquire(self, block: bool = True, timeout: float | None = None) -> bool:
        """Acquire the semaphore; return False if it is not free in time."""
        end = None if timeout is None else time.monotonic() + timeout
        delay = MIN_DELAY
        while not super().acquire(False):
            if not block or (end is not None and time.monotonic() >= end):
                return False
            time.sleep(delay)
            delay = min(2 * delay, MAX_DELAY)
        return True

    def __enter__(self) -> bool:
        return self.acquire()


def use_polling() -> None:
    """Use polling semaphores in this process and in all processes that it forks."""
    _multiprocessing.SemLock = SemLock
