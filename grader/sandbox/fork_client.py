"""Get workers from a fork server, because starting Python for each worker is slower."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import select
import socket
import subprocess
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from grader.sandbox.boundary import PYTHON
from grader.sandbox.protocol import SandboxUnavailable

PROGRAM = Path(__file__).with_name("fork_server.py")
SECONDS_TO_FORK = 60
SLOW_TO_IMPORT = ("scipy.spatial", "scipy.sparse.csgraph")
# Each library gets one thread, because many notebooks are judged in parallel.
ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
MAX_REPORT_LENGTH = 400


@dataclass
class ForkClient:
    """Client of a `grader.sandbox.fork_server`, which it starts on the first request.

    Attributes
    ----------
    preloaded : tuple of str
        Modules that the server imports before it serves the first request that needs them.
    forbidden : tuple of str
        Modules that the server never imports.
    environment : dict of str to str
        Environment variables of the workers.
    """

    preloaded: tuple[str, ...]
    forbidden: tuple[str, ...]
    environment: dict[str, str]
    _requests: socket.socket | None = None
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def fork(self, request: dict, read_end: int, write_end: int) -> ForkedWorker:
        """Ask the server to fork a worker, and return the worker.

        Parameters
        ----------
        request : dict
            ``sandbox_pid``: ID of the first process in the sandbox. ``has_user_namespace``:
            whether the sandbox has a user namespace. ``home``: the worker's folder. ``preload``:
            whether the code mentions a module that is slow to import.
        read_end, write_end : int
            The worker's ends of its pipes.

        Raises
        ------
        SandboxUnavailable
            If the server does not report a worker in time.
        """
        report, status = os.pipe()
        try:
            with self._lock:
                self._send(json.dumps(request).encode(), [read_end, write_end, status])
        finally:
            os.close(status)
        line = read_line(report, SECONDS_TO_FORK)
        if not line.isdigit():
            os.close(report)
            raise SandboxUnavailable(f"The sandbox could not start a worker: {line or 'no reply'}")
        return ForkedWorker(int(line), report)

    def _send(self, data: bytes, pipes: list[int]) -> None:
        # Try twice, because the server may have been killed.
        for attempt in range(2):
            if self._requests is None:
                self._start()
            try:
                socket.send_fds(self._requests, [data], pipes)
                return
            except OSError:
                self._requests.close()
                self._requests = None
                if attempt:
                    raise SandboxUnavailable(
                        "The fork server exits as soon as it starts."
                    ) from None

    def _start(self) -> None:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.settimeout(SECONDS_TO_FORK)
        with theirs:
            settings = {"preloaded": self.preloaded, "forbidden": self.forbidden}
            command = [PYTHON, "-I", "-B", str(PROGRAM), str(theirs.fileno())]
            subprocess.Popen(
                [*command, json.dumps(settings)],
                pass_fds=(theirs.fileno(),),
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd="/",
                start_new_session=True,
            )
        self._requests = ours


@dataclass
class ForkedWorker:
    """A forked worker: its process ID outside the sandbox, and a pipe that reports its exit."""

    pid: int
    report: int
    _code: int | None = None

    def has_ended(self, seconds: float) -> bool:
        """Return whether the worker ends within the given number of seconds."""
        poll = select.poll()
        poll.register(self.report, select.POLLIN)
        return self._code is not None or bool(poll.poll(1000 * seconds))

    def exit_code(self, seconds: float) -> int | None:
        """Return the worker's exit code, or None if it does not arrive within `seconds`."""
        line = read_line(self.report, seconds)
        os.close(self.report)
        with contextlib.suppress(ValueError):
            return int(line)
        return None


def read_line(descriptor: int, seconds: float) -> str:
    """Return the next line from a pipe, without the line break; empty if none arrives in time."""
    poll, text = select.poll(), b""
    poll.register(descriptor, select.POLLIN)
    deadline = time.monotonic() + seconds
    while not text.endswith(b"\n") and len(text) < MAX_REPORT_LENGTH:
        if not poll.poll(max(0.0, 1000 * (deadline - time.monotonic()))):
            break
        # Read one byte at a time, because the next line is for a later call.
        byte = os.read(descriptor, 1)
        if not byte:
            break
        text += byte
    return text.decode(errors="replace").strip()


def modules_to_preload(packages: Sequence[str]) -> tuple[str, ...]:
    """Return the modules of a lesson's packages that are slow to import."""
    return SLOW_TO_IMPORT if "scipy" in packages else ()


@functools.cache
def client_for(modules: tuple[str, ...] = (), forbidden: tuple[str, ...] = ()) -> ForkClient:
    """Return the shared client for these preloaded and forbidden modules."""
    return ForkClient(modules, forbidden, ENVIRONMENT)
