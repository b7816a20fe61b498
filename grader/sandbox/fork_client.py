"""Workers that need not start Python anew: asked of a fork server, which forks them."""

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
# One thread each: classes are graded many notebooks at a time.
ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}
LONGEST_REPORT = 400


@dataclass
class ForkClient:
    """Asks a process of `grader.sandbox.fork_server`, which it starts when it is first asked.

    Attributes
    ----------
    preloaded : tuple of str
        Modules that its workers have imported already, once a request has asked for them.
    forbidden : tuple of str
        Modules that come into no memory.
    environment : dict of str to str
        Of its workers.
    """

    preloaded: tuple[str, ...]
    forbidden: tuple[str, ...]
    environment: dict[str, str]
    _requests: socket.socket | None = None
    _turn: threading.Lock = field(default_factory=threading.Lock)

    def fork(self, request: dict, read_end: int, write_end: int) -> Forked:
        """Have a worker forked.

        Parameters
        ----------
        request : dict
            ``walls``, the number of the first process behind them; ``own_users``, whether they
            have a user namespace; ``home``, the worker's folder; ``preload``, whether its code
            names what is slow to import.
        read_end, write_end : int
            The worker's ends of its pipes.

        Raises
        ------
        SandboxUnavailable
            If none comes.
        """
        report, status = os.pipe()
        try:
            with self._turn:
                self._send(json.dumps(request).encode(), [read_end, write_end, status])
        finally:
            os.close(status)
        line = read_line(report, SECONDS_TO_FORK)
        if not line.isdigit():
            os.close(report)
            raise SandboxUnavailable(f"The sandbox could not start a worker: {line or 'no word'}")
        return Forked(int(line), report)

    def _send(self, data: bytes, pipes: list[int]) -> None:
        # A second time, as the process may have been killed.
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
                    raise SandboxUnavailable("The fork server ends as it starts.") from None

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
class Forked:
    """A worker that was forked: its number here outside, and where its end is reported."""

    pid: int
    report: int
    _code: int | None = None

    def has_ended(self, seconds: float) -> bool:
        """Whether it ends within some seconds."""
        poll = select.poll()
        poll.register(self.report, select.POLLIN)
        return self._code is not None or bool(poll.poll(1000 * seconds))

    def end(self, seconds: float) -> int | None:
        """Its exit code, once all behind its walls has been killed; None where none is told."""
        line = read_line(self.report, seconds)
        os.close(self.report)
        with contextlib.suppress(ValueError):
            return int(line)
        return None


def read_line(descriptor: int, seconds: float) -> str:
    """What is said next through a pipe, without its end; empty where nothing is."""
    poll, text = select.poll(), b""
    poll.register(descriptor, select.POLLIN)
    deadline = time.monotonic() + seconds
    while not text.endswith(b"\n") and len(text) < LONGEST_REPORT:
        if not poll.poll(max(0.0, 1000 * (deadline - time.monotonic()))):
            break
        # One byte at a time: the next line is for later.
        byte = os.read(descriptor, 1)
        if not byte:
            break
        text += byte
    return text.decode(errors="replace").strip()


def preloaded(packages: Sequence[str]) -> tuple[str, ...]:
    """What is slow to import and some notebooks ask for, of the packages that a lesson allows."""
    return SLOW_TO_IMPORT if "scipy" in packages else ()


@functools.cache
def client_for(modules: tuple[str, ...] = (), forbidden: tuple[str, ...] = ()) -> ForkClient:
    """What asks for workers that may have imported some modules, and never some others."""
    return ForkClient(modules, forbidden, ENVIRONMENT)
