"""The interface of the executors that judge notebooks in parallel.

Any `concurrent.futures.Executor` will do. The grader calls `submit` and `shutdown`, and uses the
executor as a context manager. Functions, arguments and results can be pickled, and do not need
files on the grader's machine. An executor may have an attribute `capacity`, the number of notebooks
to give to it at a time.
"""

import os
from concurrent.futures import Executor

DEFAULT_CAPACITY = max(64, 3 * (os.cpu_count() or 1))


class ExecutorLost(Exception):
    """All workers are gone; `str()` is the sentence to show. Finished verdicts are kept."""


def capacity(executor: Executor) -> int:
    """Return how many notebooks to give to an executor at a time; all of them are in memory."""
    return getattr(executor, "capacity", DEFAULT_CAPACITY)
