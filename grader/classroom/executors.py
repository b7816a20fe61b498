"""The executors that can judge a class: processes on this machine, or a cluster.

To add an executor, write a function that opens an executor as described in
`grader.classroom.protocol`, and add it to `EXECUTORS`.
"""

import contextlib
import functools
import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from pathlib import Path

from grader.classroom.pool import Pool
from grader.classroom.protocol import ExecutorLost

CLUSTER_PACKAGES = ("cloudpickle", "dask", "distributed")


def processor_count() -> int:
    """Return the number of available processors; a container may have fewer than its machine."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    try:
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        count = min(count, math.ceil(int(quota) / int(period)))
    except (OSError, ValueError):  # the file is missing, or states no limit
        pass
    return max(1, count)


def connect_to_scheduler(address: str, sandbox: str, notify: Callable[[str], None]) -> Executor:
    """Connect to a Dask cluster; see `grader.classroom.cluster.connect`."""
    try:
        from grader.classroom.cluster import connect  # importing Dask takes a second
    except ModuleNotFoundError as error:
        if error.name not in CLUSTER_PACKAGES:
            raise
        raise ExecutorLost(
            f"A cluster needs Dask, and {error.name} is not installed here. "
            "Run: pip install -r requirements-cluster.txt"
        ) from None

    return connect(address, sandbox, notify)


EXECUTORS: dict[str, Callable[..., Executor]] = {
    "processes": Pool,
    "scheduler": connect_to_scheduler,
}


@contextlib.contextmanager
def executor_factory(
    scheduler: str | None, sandbox: str, notify: Callable[[str], None]
) -> Iterator[Callable[[int], Executor]]:
    """Yield a function that takes the number of workers and opens an executor.

    All executors of a cluster share one connection.

    Parameters
    ----------
    scheduler : str or None
        Address of a cluster. None selects processes on this machine.
    sandbox, notify
        As for `grader.classroom.cluster.connect`.
    """
    with contextlib.ExitStack() as stack:

        @functools.cache
        def open_cluster() -> Executor:
            return stack.enter_context(EXECUTORS["scheduler"](scheduler, sandbox, notify))

        if scheduler:
            yield lambda workers: contextlib.nullcontext(open_cluster())
        else:
            yield EXECUTORS["processes"]
