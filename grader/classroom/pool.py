"""A pool of worker processes on this machine, each with its own pipe.

The pool of `concurrent.futures` shares one pipe between all its processes. Before Python 3.11.5 it
hangs forever if a process dies while a notebook that does not fit into the pipe is being sent
(github.com/python/cpython/issues/94777). In every version it hangs if a process is killed while it
sends a result, and the death of one process ends all others. This pool notices the death of a
process at once, and loses only the job that the process was working on.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor

SLOW_TO_IMPORT = ("grader.judging.judge", "scipy.spatial")
MAX_JOB_SECONDS = 60 * 60
"""Seconds that a job may take: far more than the sum of a notebook's time limits."""
SECONDS_TO_END = 10
MAX_MEMORY = 3 * 2**30
"""Bytes that a process may allocate; a correct notebook needs a tenth of this memory."""


class Pool(Executor):
    """An executor with a fixed number of processes, which are started when needed.

    A job whose process dies raises `BrokenExecutor`; the next job gets a new process. Cancelling
    pending jobs (`cancel_futures`, or an exception in the ``with`` statement) also kills busy
    processes. Their jobs start again in the next run.

    Parameters
    ----------
    workers : int
        Number of processes.
    """

    def __init__(self, workers: int) -> None:
        # Not a plain fork, because this process has threads, which a fork does not copy.
        self._context = multiprocessing.get_context("forkserver" if os.name == "posix" else "spawn")
        if os.name == "posix":
            self._context.set_forkserver_preload([*SLOW_TO_IMPORT])
        self._threads = ThreadPoolExecutor(workers)
        self._lock, self._closed = threading.Lock(), False
        self._idle: list[_Process] = []
        self._busy: set[_Process] = set()

    def __exit__(self, kind: type | None, *details: object) -> None:
        self.shutdown(cancel_futures=kind is not None)

    def submit(self, function: Callable, /, *arguments: object) -> Future:
        """Schedule a call; the function and its arguments are pickled at once."""
        return self._threads.submit(self._run_job, pickle.dumps((function, arguments)))

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; see `concurrent.futures.Executor.shutdown`."""
        self._threads.shutdown(wait=False, cancel_futures=cancel_futures)
        if cancel_futures:
            with self._lock:
                self._closed = True
                for process in self._busy:
                    process.kill()
        if wait:
            self._threads.shutdown()
            for process in self._idle:
                process.end()
            self._idle.clear()

    def _run_job(self, job: bytes) -> object:
        process = self._take_process()
        timer = threading.Timer(MAX_JOB_SECONDS, process.kill)
        timer.start()
        alive = False
        try:
            succeeded, value = pickle.loads(process.answer(job))
            alive = True
        except (EOFError, OSError):
            process.end()
            raise BrokenExecutor(
                f"The judging process ended ({process.exit_description}). Is there enough memory?"
            ) from None
        finally:
            timer.cancel()
            # Both collections change under the lock, because another thread may take the idle
            # process.
            with self._lock:
                self._busy.discard(process)
                if alive:
                    self._idle.append(process)
        if succeeded:
            return value
        raise value

    def _take_process(self) -> _Process:
        with self._lock:
            if self._closed:
                raise BrokenExecutor("Judging was stopped. Run the same command again.")
            process = self._idle.pop() if self._idle else _Process(self._context)
            self._busy.add(process)
            return process


class _Process:
    """A worker process and the parent's end of its pipe."""

    def __init__(self, context: multiprocessing.context.BaseContext) -> None:
        self._pipe, child_end = context.Pipe()
        # No other process has the child's end, so it closes when the child dies.
        with child_end:
            self._process = context.Process(target=_serve, args=(child_end,), daemon=True)
            self._process.start()

    def answer(self, job: bytes) -> bytes:
        """Send a job and wait for its result.

        Raises
        ------
        EOFError, OSError
            If the process dies.
        """
        self._pipe.send_bytes(job)
        return self._pipe.recv_bytes()

    def kill(self) -> None:
        """Kill the process."""
        self._process.kill()

    def end(self) -> None:
        """Close the pipe and wait for the process to end; kill it if it does not."""
        self._pipe.close()
        self._process.join(SECONDS_TO_END)
        self._process.kill()
        self._process.join(SECONDS_TO_END)

    @property
    def exit_description(self) -> str:
        """How the process ended, as shown to the instructor."""
        code = self._process.exitcode
        return f"signal {-code}" if code is not None and code < 0 else f"exit status {code}"


def _serve(pipe: multiprocessing.connection.Connection) -> None:
    """Run the jobs that arrive through a pipe, until it closes."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # the parent reports Ctrl-C
    threading.Thread(target=_die_with_parent, daemon=True).start()
    _limit_memory()
    with contextlib.suppress(EOFError, OSError):
        while True:
            pipe.send_bytes(run_job(pipe.recv_bytes()))


def _limit_memory() -> None:
    """Limit memory, so that a huge answer fails here before other processes run out of memory."""
    if os.name == "posix":
        import resource  # not on Windows

        _, hard = resource.getrlimit(resource.RLIMIT_DATA)
        limit = MAX_MEMORY if hard == resource.RLIM_INFINITY else min(MAX_MEMORY, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))


def _die_with_parent() -> None:
    """End this process when its parent dies, even during a job."""
    multiprocessing.parent_process().join()
    os._exit(1)


def run_job(job: bytes) -> bytes:
    """Run a pickled (function, arguments); return a pickled (True, result) or (False, error)."""
    try:
        function, arguments = pickle.loads(job)
        return pickle.dumps((True, function(*arguments)))
    except Exception as error:
        # A traceback cannot be pickled, but a note on the exception can.
        error.add_note("In the judging process:\n" + traceback.format_exc())
        try:
            return pickle.dumps((False, error))
        except Exception:
            return pickle.dumps((False, RuntimeError(traceback.format_exc())))
