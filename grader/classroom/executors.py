"""What judges many notebooks at a time: anything that is a `concurrent.futures.Executor`.

Of an executor `submit` and `shutdown` are used, and that it is a context manager. Functions and
arguments can be pickled, and results: nothing needs a file of whoever grades. An executor may
have a number `room`: how many notebooks it likes to be given before it answers. Another executor
is a function that opens it, and a line in the table.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from grader.classroom.pool import Pool

ROOM = max(64, 3 * (os.cpu_count() or 1))


class ExecutorLost(Exception):
    """Nothing judges any more; `str()` is the sentence to show. What was judged is kept."""


def room(executor: Executor) -> int:
    """How many notebooks to give to an executor at a time: what it is given is in memory."""
    return getattr(executor, "room", ROOM)


def processors() -> int:
    """How many processors there are for us: a container may have less than its machine."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    try:
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        count = min(count, math.ceil(int(quota) / int(period)))
    except (OSError, ValueError):  # no limit, or no such file
        pass
    return max(1, count)


def scheduler(address: str, sandbox: str, tell: Callable[[str], None]) -> Executor:
    """The workers of a Dask cluster; see `grader.classroom.cluster.connect`."""
    from grader.classroom.cluster import connect  # Dask takes a second, and few have a cluster

    return connect(address, sandbox, tell)


EXECUTORS: dict[str, Callable[..., Executor]] = {"processes": Pool, "scheduler": scheduler}
