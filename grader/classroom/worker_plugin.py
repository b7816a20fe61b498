"""A Dask plugin that copies the course's code to each worker and judges submissions there.

This module is pickled by value, because a worker has Python and the requirements but not the
course. It therefore imports no other module of this project.
"""

from __future__ import annotations

import asyncio
import contextlib
import io
import itertools
import multiprocessing
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import zipfile
from concurrent.futures import BrokenExecutor, Future
from pathlib import Path

from distributed import Status, Worker, WorkerPlugin, get_worker

MAX_START_SECONDS = 300
"""Seconds that the judging process may take to start; imports from a busy disk are slow."""


def judge_on_worker(name: str, job: bytes) -> bytes:
    """Run a job on the worker in this process; `name` is the plugin's name."""
    return get_worker().plugins[name].judge(job)


MAX_JOB_SECONDS = 70 * 60
"""Seconds after which a job counts as lost; the judging process itself gives up earlier."""
SECONDS_TO_END = 10


class UnsuitableWorker(Exception):
    """A worker cannot judge reliably; the message contains the reason and the remedy."""


class JudgePlugin(WorkerPlugin):
    """Unpacks the course on a worker, and judges submissions there in separate processes.

    The plugin gives a suitable worker a Dask resource with the plugin's name, one unit per thread.
    Every job requires that resource, so only suitable workers receive jobs, even if they join
    later.

    Parameters
    ----------
    name : str
    archive : bytes
        The course's code, as a zip file.
    versions : dict of str to str
        Versions that a worker must have, so that all workers give the same verdicts.
    sandbox : str
        Name of a sandbox in `grader.sandbox.SANDBOXES`.
    """

    def __init__(self, name: str, archive: bytes, versions: dict[str, str], sandbox: str) -> None:
        self.name = name
        self.archive = archive
        self.versions = versions
        self.sandbox = sandbox

    async def setup(self, worker: Worker) -> None:
        """Prepare the worker, and report whether it can judge."""
        self.threads = worker.state.nthreads
        self.lock, self.client, self.closed = threading.Lock(), None, False
        try:
            await asyncio.to_thread(self._prepare, worker.local_directory)
            complaint = ""
        except UnsuitableWorker as error:
            complaint = str(error)
        except Exception as error:
            complaint = f"It cannot load the course's code: {error!r}."
        if not complaint:
            await worker.set_resources(**{self.name: self.threads})
            # Pause and resume the worker, because the scheduler does not reconsider waiting tasks
            # when a worker only gains a resource.
            worker.status = Status.paused
            worker.status = Status.running
        report = {"worker": worker.address, "machine": socket.gethostname(), "complaint": complaint}
        worker.log_event(self.name, {**report, "threads": self.threads})

    def teardown(self, worker: Worker) -> None:
        """Remove everything that the plugin created."""
        with self.lock:
            self.closed = True
            if self.client:
                self.client.close()
        shutil.rmtree(self.folder, ignore_errors=True)

    def judge(self, job: bytes) -> bytes:
        """Run a job in the judging process.

        Raises
        ------
        BrokenExecutor
            If the process died or hangs. The next job starts a new process.
        """
        with self.lock:
            if self.closed:
                raise BrokenExecutor("This run has ended.")
            if self.client is None or self.client.dead:
                self.client = JudgeClient(self.folder, self.threads, self.sandbox)
            client = self.client
            future = client.submit(job)
        try:
            return future.result(MAX_JOB_SECONDS)
        except TimeoutError:
            client.close()
            raise BrokenExecutor(
                f"The judging process has not answered for {MAX_JOB_SECONDS / 60:.0f} minutes."
            ) from None

    def _prepare(self, parent: str) -> None:
        os.makedirs(parent, exist_ok=True)
        # Only this user may read the folder, because it contains hidden tests.
        self.folder = Path(tempfile.mkdtemp(prefix="course-", dir=parent))
        with zipfile.ZipFile(io.BytesIO(self.archive)) as archive:
            archive.extractall(self.folder)
        # Student code runs as another user, who must be able to read the files in the sandbox.
        for path in self.folder.rglob("*"):
            path.chmod(0o755 if path.is_dir() else 0o644)
        self.client = JudgeClient(self.folder, self.threads, self.sandbox)
        versions = self.client.greeting["versions"]
        mismatches = [
            f"{name} {versions[name]} instead of {wanted}"
            for name, wanted in self.versions.items()
            if versions[name] != wanted
        ]
        complaint = self.client.greeting["complaint"]
        if mismatches:
            complaint = (
                f"It has {', '.join(mismatches)}. Install the course's requirements-cluster.txt "
                "there."
            )
        if complaint:
            self.client.close()
            raise UnsuitableWorker(complaint)


class JudgeClient:
    """Starts a process of `grader.classroom.judge_server` and communicates with it.

    Attributes
    ----------
    greeting : dict
        The first message: the process's versions and, if it cannot judge, the reason.
    dead : bool
    """

    def __init__(self, folder: Path, threads: int, sandbox: str) -> None:
        self._pipe, child_end = multiprocessing.Pipe()
        serve = f"serve({child_end.fileno()}, {threads}, {sandbox!r})"
        with open(folder / "errors.txt", "w+b") as errors, child_end:
            self._process = subprocess.Popen(
                [sys.executable, "-c", f"from grader.classroom.judge_server import serve; {serve}"],
                cwd=folder,
                env={**os.environ, "PYTHONPATH": _path_with(folder)},
                pass_fds=[child_end.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
            )
        try:
            self.greeting = self._receive_greeting(folder)
        except BaseException:
            self.close()
            raise
        self.dead = False
        self._lock, self._numbers, self._waiting = threading.Lock(), itertools.count(), {}
        threading.Thread(target=self._listen, daemon=True).start()

    def submit(self, job: bytes) -> Future:
        """Send a job and return the future of its result."""
        future = Future()
        with self._lock:
            number = next(self._numbers)
            self._waiting[number] = future
            try:
                self._pipe.send((number, job))
            except OSError:  # the process has just died, which `_listen` may already have noticed
                if self._waiting.pop(number, None):
                    future.set_exception(_broken())
        return future

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(SECONDS_TO_END)

    def _receive_greeting(self, folder: Path) -> dict:
        if not self._pipe.poll(MAX_START_SECONDS):
            raise UnsuitableWorker(f"Its Python did not start within {MAX_START_SECONDS} s.")
        try:
            return self._pipe.recv()
        except EOFError:
            lines = (folder / "errors.txt").read_text("utf-8", "replace").strip().splitlines()
            raise UnsuitableWorker(
                f"It cannot run the course's code: {lines[-1] if lines else 'no reason given'}. "
                "Install the course's requirements-cluster.txt there."
            ) from None

    def _listen(self) -> None:
        try:
            while True:
                number, result = self._pipe.recv()
                self._waiting.pop(number).set_result(result)
        except (EOFError, OSError):
            with self._lock:
                self.dead, waiting = True, list(self._waiting.values())
                self._waiting.clear()
            for future in waiting:
                future.set_exception(_broken())
            self._process.wait()


def _broken() -> BrokenExecutor:
    return BrokenExecutor("The judging process ended.")


def _path_with(folder: Path) -> str:
    """Return a ``PYTHONPATH`` that puts the course before the worker's own modules."""
    return os.pathsep.join(filter(None, (str(folder), os.environ.get("PYTHONPATH"))))
