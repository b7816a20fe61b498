"""The places where a class can be judged. Another one is a function that opens it, and a line here.

What it opens is an executor as `grader.classroom.protocol` has it.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path

from grader.classroom.pool import Pool
from grader.classroom.protocol import ExecutorLost

NEEDED_BY_CLUSTERS = ("cloudpickle", "dask", "distributed")


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
    try:
        from grader.classroom.cluster import connect  # Dask takes a second, and few have a cluster
    except ModuleNotFoundError as error:
        if error.name not in NEEDED_BY_CLUSTERS:
            raise
        raise ExecutorLost(
            f"A cluster needs Dask, and {error.name} is not installed here. "
            "Run: pip install -r requirements-cluster.txt"
        ) from None

    return connect(address, sandbox, tell)


EXECUTORS: dict[str, Callable[..., Executor]] = {"processes": Pool, "scheduler": scheduler}
