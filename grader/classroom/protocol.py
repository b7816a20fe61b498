"""What judges many notebooks at a time: anything that is a `concurrent.futures.Executor`.

Of an executor `submit` and `shutdown` are used, and that it is a context manager. Functions and
arguments can be pickled, and results: nothing needs a file of whoever grades. An executor may
have a number `room`: how many notebooks it likes to be given before it answers.
"""

import os
from concurrent.futures import Executor

ROOM = max(64, 3 * (os.cpu_count() or 1))


class ExecutorLost(Exception):
    """Nothing judges any more; `str()` is the sentence to show. What was judged is kept."""


def room(executor: Executor) -> int:
    """How many notebooks to give to an executor at a time: what it is given is in memory."""
    return getattr(executor, "room", ROOM)
