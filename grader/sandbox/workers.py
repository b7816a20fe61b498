"""The process in which a student's code runs, seen from outside: its pipes, its memory, its end."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass, field

from grader.sandbox.boundary import PYTHON, WORKER
from grader.sandbox.inside import wire
from grader.sandbox.processes import cpu_of_tree, memory_left, memory_of_tree
from grader.sandbox.protocol import MEBIBYTE, Limits, SandboxUnavailable

SECONDS_BETWEEN_LOOKS = 0.2
SECONDS_TO_REPORT = 60
LEAST_MEMORY_LEFT = 0.03
MODEST_MEMORY = 1024 * MEBIBYTE
# One thread each: classes are graded many notebooks at a time.
ENVIRONMENT = {
    "PATH": "/usr/bin:/bin",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "Agg",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
}


@dataclass
class Worker:
    """A running worker and the two ends of its pipes."""

    process: subprocess.Popen
    read_end: int
    write_end: int
    _stopped: threading.Event = field(default_factory=threading.Event)
    _signals: threading.Lock = field(default_factory=threading.Lock)

    def stop(self) -> int:
        """Kill the worker and all it started; return its exit code."""
        self._stopped.set()
        # Nobody else waits for the process, so until here its number belongs to no other.
        with self._signals:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.process.pid, signal.SIGKILL)
            code = self.process.wait()
        self.process.stderr.close()
        for end in (self.read_end, self.write_end):
            os.close(end)
        return code

    def has_ended(self, seconds: float) -> bool:
        """Whether it ends by itself within some seconds; its exit code is kept for `stop`."""
        deadline = time.monotonic() + seconds
        while not os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.01)
        return True

    def cpu_seconds(self) -> float:
        """Processor time that it and all it started have had."""
        return cpu_of_tree(self.process.pid)

    def watch_memory(self, limit: int) -> None:
        """Kill the worker when all its processes together take more than `limit` bytes.

        Or less, when the machine runs out: a student may refuse to be the one that Linux ends.
        """

        def watch() -> None:
            while not self._stopped.wait(SECONDS_BETWEEN_LOOKS):
                most = limit if memory_left() > LEAST_MEMORY_LEFT else MODEST_MEMORY
                if memory_of_tree(self.process.pid) > most:
                    with self._signals:
                        if not self._stopped.is_set():
                            os.kill(self.process.pid, signal.SIGKILL)
                    return

        threading.Thread(target=watch, daemon=True).start()


def launch(walls: Sequence[str], home: str, rules: dict, limits: Limits) -> Worker:
    """Start a worker behind some walls, and wait until it reports.

    Parameters
    ----------
    walls : sequence of str
        The command that runs another one inside; empty for none.
    home : str
        The folder that the worker may write to.
    rules : dict
        What the worker imposes on itself before it reads a line of the student:
        ``user``, ``limits``, ``forbidden``.
    limits : Limits

    Raises
    ------
    SandboxUnavailable
        If it does not report.
    """
    their_read, our_write = os.pipe()
    our_read, their_write = os.pipe()
    for end in (our_read, our_write):
        os.set_blocking(end, False)
    command = [*walls, PYTHON, "-I", "-B", str(WORKER), str(their_read), str(their_write)]
    try:
        process = subprocess.Popen(
            command,
            pass_fds=(their_read, their_write),
            env={"HOME": home, **ENVIRONMENT},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    finally:
        os.close(their_read)
        os.close(their_write)
    worker = Worker(process, our_read, our_write)
    try:
        deadline = time.monotonic() + SECONDS_TO_REPORT
        wire.send(our_write, rules, deadline)
        wire.receive(our_read, deadline)
    except (wire.WireClosed, wire.WireTimeout):
        os.kill(process.pid, signal.SIGKILL)
        complaint = process.stderr.read().decode(errors="replace").strip()[-500:]
        worker.stop()
        raise SandboxUnavailable(f"The sandbox could not start Python: {complaint}") from None
    worker.watch_memory(limits.total_memory)
    return worker
