"""What judges many notebooks at a time: anything that is a `concurrent.futures.Executor`.

Of an executor `submit` and `shutdown` are used, and that it is a context manager. Another one is
a function that opens it, and a line in the table.
"""

import math
import multiprocessing
import os
import threading
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path


def processes(workers: int) -> Executor:
    """As many processes of this machine as notebooks shall be judged at a time."""
    # Not by plain fork: whoever shows progress runs a thread, and threads do not survive that.
    context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
    if os.name == "posix":
        context.set_forkserver_preload(["grader.judging.judge"])
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_die_with_parent)


def _die_with_parent() -> None:
    """End this worker when whoever started the pool is gone, even killed."""

    def wait() -> None:
        multiprocessing.parent_process().join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()


def processors() -> int:
    """How many processors there are for us: a container may have less than its machine."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    try:
        quota, period = Path("/sys/fs/cgroup/cpu.max").read_text().split()
        count = min(count, math.ceil(int(quota) / int(period)))
    except (OSError, ValueError):  # no limit, or no such file
        pass
    return max(1, count)


EXECUTORS: dict[str, Callable[[int], Executor]] = {"processes": processes}
