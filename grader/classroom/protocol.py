"""The interface of the executors that judge notebooks in parallel.

Any `concurrent.futures.Executor` will do. The grader calls `submit` and `shutdown`, and uses the
executor as a context manager. All functions, arguments and results can be pickled, and do not
depend on files on the grader's machine. An executor may have an attribute `capacity`, the number of
notebooks to submit at a time.
"""

import os
from concurrent.futures import Executor

DEFAULT_CAPACITY = max(64, 3 * (os.cpu_count() or 1))


class ExecutorLost(Exception):
    """No worker is left; the message is shown to the user. Finished verdicts are kept."""


def capacity(executor: Executor) -> int:
    """Return the number of notebooks to submit at a time, all of which are held in memory."""
    return getattr(executor, "capacity", DEFAULT_CAPACITY)
