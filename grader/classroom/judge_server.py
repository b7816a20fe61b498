"""The process in which a worker of a cluster judges: it alone knows the course's code.

The worker starts it in the folder that the course was unpacked into, and talks to it through a
pipe. A worker may so judge for several courses, or versions of one, after and beside each other.
"""

from __future__ import annotations

import functools
import os
import pickle
import threading
from concurrent.futures import Future
from multiprocessing.connection import Connection

from grader.classroom.pool import Pool, do
from grader.judging.key import versions
from grader.sandbox import SANDBOXES, SandboxUnavailable

IDLE = 30 * 60
"""Seconds after which nobody is waiting any more: whoever graded was killed, say."""


def serve(descriptor: int, count: int, sandbox: str) -> None:
    """Judge what comes through a pipe, until it closes.

    First goes out what there is here: versions, and why there is no sandbox, if there is none.
    Then jobs come in as (number, bytes) and go out as (number, bytes), in any order.

    Parameters
    ----------
    descriptor : int
        Of our end of the pipe.
    count : int
        How many notebooks to judge at a time.
    sandbox : str
        A name in `grader.sandbox.SANDBOXES`.
    """
    pipe, lock = Connection(descriptor), threading.Lock()
    pipe.send({"versions": versions(), "complaint": _complaint(sandbox)})
    pool = Pool(count)

    def answer(number: int, future: Future) -> None:
        died = future.exception()
        with lock:
            pipe.send((number, pickle.dumps((False, died)) if died else future.result()))

    try:
        while pipe.poll(IDLE):
            number, job = pipe.recv()
            pool.submit(do, job).add_done_callback(functools.partial(answer, number))
    finally:
        os._exit(1)  # nobody waits for what is being judged


def _complaint(sandbox: str) -> str:
    try:
        SANDBOXES[sandbox].available()
    except SandboxUnavailable as error:
        return str(error)
    return ""
