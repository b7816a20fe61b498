"""What judges many notebooks at a time: anything that is a `concurrent.futures.Executor`.

Of an executor `submit` and `shutdown` are used, and that it is a context manager. Another one is
a function that opens it, and a line in the table.
"""

from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor


def processes(workers: int) -> Executor:
    """As many processes of this machine as notebooks shall be judged at a time."""
    return ProcessPoolExecutor(workers)


EXECUTORS: dict[str, Callable[[int], Executor]] = {"processes": processes}
