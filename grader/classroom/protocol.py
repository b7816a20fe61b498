"""The interface of the executors that judge notebooks in parallel.

Any `concurrent.futures.Executor` will do. Its `submit` and `shutdown` are used, and it is used as
a context manager. Functions, arguments and results can be pickled, and do not need files of the
grader's machine. An executor may have a number `capacity`: the notebooks that it accepts before it
answers.
"""

import os
from concurrent.futures import Executor

DEFAULT_CAPACITY = max(64, 3 * (os.cpu_count() or 1))


class ExecutorLost(Exception):
    """All workers are gone; `str()` is the sentence to show. Verdicts so far are kept."""


def capacity(executor: Executor) -> int:
    """Return how many notebooks to give to an executor at a time, as these are in memory."""
    return getattr(executor, "capacity", DEFAULT_CAPACITY)
