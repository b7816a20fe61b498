"""The judging process on a cluster's worker, the only process there that imports the course.

The worker starts this process in the folder of the unpacked course, and communicates with it
through a pipe. A worker can therefore judge several courses, or versions of a course, at a time.
"""

from __future__ import annotations

import functools
import os
import pickle
import threading
from concurrent.futures import Future
from multiprocessing.connection import Connection

import grader.judging.judge  # noqa: F401  a worker that cannot import the judge gets no notebooks
from grader.classroom.pool import Pool, run_job
from grader.judging.verdict_key import versions
from grader.sandbox import SANDBOXES, SandboxUnavailable

MAX_IDLE_SECONDS = 30 * 60
"""Seconds without a job after which the process ends, because the run was probably killed."""


def serve(descriptor: int, workers: int, sandbox: str) -> None:
    """Judge the jobs that arrive through a pipe, until it closes.

    The first message reports the versions on this machine and, if the sandbox is not available,
    the reason. Then jobs arrive as (number, bytes), and results are sent as (number, bytes) in any
    order.

    Parameters
    ----------
    descriptor : int
        File descriptor of this process's end of the pipe.
    workers : int
        Number of notebooks to judge at a time.
    sandbox : str
        Name of a sandbox in `grader.sandbox.SANDBOXES`.
    """
    pipe, lock = Connection(descriptor), threading.Lock()
    pipe.send({"versions": versions(), "complaint": _sandbox_complaint(sandbox)})
    pool = Pool(workers)

    def answer(number: int, future: Future) -> None:
        error = future.exception()
        with lock:
            pipe.send((number, pickle.dumps((False, error)) if error else future.result()))

    try:
        while pipe.poll(MAX_IDLE_SECONDS):
            number, job = pipe.recv()
            pool.submit(run_job, job).add_done_callback(functools.partial(answer, number))
    finally:
        os._exit(1)  # the results of unfinished jobs are not needed


def _sandbox_complaint(sandbox: str) -> str:
    try:
        SANDBOXES[sandbox].check_available()
    except SandboxUnavailable as error:
        return str(error)
    return ""
