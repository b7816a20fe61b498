"""Start the process in which a student's code runs, watch its memory, and end it."""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import json
import os
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from subprocess import Popen

from grader.sandbox.boundary import PYTHON, WORKER_SCRIPT
from grader.sandbox.fork_client import ENVIRONMENT, ForkClient, ForkedWorker, read_line
from grader.sandbox.inside import wire
from grader.sandbox.protocol import MEBIBYTE, Limits, SandboxUnavailable, Thread, Worker
from grader.sandbox.usage import (
    available_memory_share,
    cpu_of_tree,
    memory_of_tree,
    oom_kill_count,
    threads_of_tree,
)

MEMORY_POLLING_INTERVAL = 0.2
SECONDS_TO_REPORT = 60
SECONDS_TO_END = 10
# An ordinary user may request 1 MiB for a pipe. If a user's pipes have more than 64 MiB in total,
# Linux gives each further pipe of this user only 8 KiB, even in other programs. A notebook on each
# processor needs up to four pipes, and the other half of the 64 MiB is left to other programs.
LARGEST_PIPE, USUAL_PIPE, MAX_PIPES_TOTAL = 2**20, 2**16, 2**25
KILLED_CODES = (-signal.SIGKILL, 128 + signal.SIGKILL)
MIN_MEMORY_LEFT = 0.03
MEMORY_WHEN_SCARCE = 1024 * MEBIBYTE
# The first process in the sandbox reports that the sandbox is built, then waits until its input
# closes, which also happens if the judge is killed. Bubblewrap's own --die-with-parent is not
# enough: if bubblewrap is killed while it builds the sandbox, it leaves a process behind.
WAIT_COMMAND = "echo ready && read line"


@dataclass
class WorkerProcess:
    """A `grader.sandbox.protocol.Worker` that is a process on this machine.

    Attributes
    ----------
    process : subprocess.Popen
        The sandbox's own process, or the worker itself if there is no sandbox.
    read_end, write_end : int
    forked : grader.sandbox.fork_client.ForkedWorker, optional
        The worker, if a fork server created it and it joined the sandbox later.
    release_folder : callable
        Called when all processes have ended, so that another worker can use the same folder.
    initial_kill_count : int
        The result of `oom_kill_count` when the worker started.
    """

    process: subprocess.Popen
    read_end: int
    write_end: int
    forked: ForkedWorker | None = None
    release_folder: Callable[[], object] = lambda: None
    initial_kill_count: int = 0
    _stopped: threading.Event = field(default_factory=threading.Event)
    _signals: threading.Lock = field(default_factory=threading.Lock)
    _above_limit = _lacked_memory = False

    @property
    def pids(self) -> list[int]:
        """IDs (outside the sandbox) of the processes whose descendants belong to the worker."""
        return [self.process.pid, *([self.forked.pid] if self.forked else [])]

    def stop(self) -> int | None:
        """Kill the worker and everything that it started; return its exit code if known."""
        self._stopped.set()
        had_to_be_killed = self.process.returncode is None and not self.has_ended(0)
        # No other code waits for this process, so the kernel has not reused its ID yet.
        with self._signals:
            code = _kill(self.process)
        if self.forked:
            # When the first process in a sandbox ends, the kernel ends all others there.
            code = self.forked.exit_code(SECONDS_TO_END)
        if code in KILLED_CODES and not self._above_limit and not had_to_be_killed:
            # The kernel may have killed other processes while student code killed the worker. The
            # notebook is then judged again, which gives the student no advantage.
            self._lacked_memory |= oom_kill_count() > self.initial_kill_count
        self.process.stderr.close()
        for end in (self.read_end, self.write_end):
            os.close(end)
        if code is not None and code >= 0:  # otherwise a process may still run in the folder
            self.release_folder()
        return code

    def has_ended(self, seconds: float) -> bool:
        """Return whether the worker ends by itself within `seconds`; call `stop` in either case."""
        if self.forked:
            return self.forked.has_ended(seconds)
        deadline = time.monotonic() + seconds
        while not os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.01)
        return True

    def lacked_memory(self) -> bool:
        """Return whether the worker died below its own limit because the machine lacked memory."""
        return self._lacked_memory

    def cpu_seconds(self) -> float:
        """Return the processor time of the worker and of everything that it started."""
        return sum(map(cpu_of_tree, self.pids))

    def threads(self) -> dict[int, Thread] | None:
        """Return the worker's threads by ID; see `grader.sandbox.protocol.Worker`."""
        trees = [threads_of_tree(pid) for pid in self.pids]
        return None if None in trees else dict(itertools.chain(*map(dict.items, trees)))

    def watch_memory(self, limit: int) -> None:
        """Kill the worker if its processes together use more than `limit` bytes.

        The limit is lower while the machine is running out of memory, because student code may
        have protected itself from the kernel's out-of-memory killer.
        """

        def watch() -> None:
            while not self._stopped.wait(MEMORY_POLLING_INTERVAL):
                most = limit if available_memory_share() > MIN_MEMORY_LEFT else MEMORY_WHEN_SCARCE
                used = sum(map(memory_of_tree, self.pids))
                if used > most:
                    with self._signals:
                        if not self._stopped.is_set():
                            self._above_limit = used > limit
                            self._lacked_memory = not self._above_limit
                            _end_gently(self.process)
                    return

        threading.Thread(target=watch, daemon=True).start()


def launch(
    sandbox_command: Sequence[str],
    home: str,
    rules: dict,
    limits: Limits,
    client: ForkClient | None = None,
    preload: bool = False,
    release_folder: Callable[[], object] | None = None,
) -> WorkerProcess:
    """Start a worker in a sandbox, and wait until it reports.

    Parameters
    ----------
    sandbox_command : sequence of str
        A command that runs another command in the sandbox; empty if there is no sandbox.
    home : str
        The folder that the worker may write to.
    rules : dict
        Rules that the worker applies to itself before it reads student code. ``user``: ID of the
        user to become, or None. ``limits``: the result of `Limits.resources`. ``forbidden``:
        modules to hide. ``sockets``: whether the worker may create sockets, by default True.
    limits : Limits
    client : grader.sandbox.fork_client.ForkClient, optional
        Client that forks a worker, which joins the sandbox. By default, Python starts inside the
        sandbox.
    preload : bool
        Whether the fork server must first import the modules that are slow to import.
    release_folder : callable, optional
        Called when all processes have ended. With `release_folder`, the sandbox must end all
        processes in it when its input closes, as `jailer.py` does. Without `release_folder`,
        killing the sandbox's process must be enough.

    Raises
    ------
    SandboxUnavailable
        If the worker does not report.
    """
    their_read, our_write = os.pipe()
    our_read, their_write = os.pipe()
    for end in (our_read, our_write):
        os.set_blocking(end, False)
        _enlarge(end)
    try:
        if client is None:
            command = [
                *sandbox_command,
                PYTHON,
                "-I",
                "-B",
                str(WORKER_SCRIPT),
                str(their_read),
                str(their_write),
            ]
            stdin = subprocess.PIPE if release_folder else subprocess.DEVNULL
            process, forked = _start_process(command, home, (their_read, their_write), stdin), None
        else:
            request = {
                "has_user_namespace": rules["user"] is None,
                "home": home,
                "preload": preload,
            }
            process, forked = _start_and_join(
                sandbox_command, request, client, their_read, their_write
            )
    except SandboxUnavailable:
        for end in (our_read, our_write):
            os.close(end)
        raise
    finally:
        os.close(their_read)
        os.close(their_write)
    after = release_folder or (lambda: None)
    worker = WorkerProcess(process, our_read, our_write, forked, after, oom_kill_count())
    try:
        send_rules(worker, rules)
    except (wire.WireClosed, wire.WireTimeout):
        complaint = _end_with_message(process)
        worker.stop()
        raise SandboxUnavailable(f"The sandbox could not start Python: {complaint}") from None
    worker.watch_memory(limits.total_memory)
    return worker


def _enlarge(pipe: int) -> None:
    """Enlarge a pipe, so that a large message needs fewer switches between the two processes."""
    with contextlib.suppress(AttributeError, OSError):  # not Linux, or too many large pipes
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, pipe_bytes(os.cpu_count() or 1))


def pipe_bytes(processors: int) -> int:
    """Return the size of a pipe to a worker on a machine with this many processors."""
    return max(USUAL_PIPE, min(LARGEST_PIPE, MAX_PIPES_TOTAL // (4 * processors)))


def send_rules(worker: Worker, rules: dict) -> None:
    """Send a new worker its rules, and wait until it reports that it has applied them.

    Parameters
    ----------
    worker : Worker
    rules : dict
        As for `launch`.

    Raises
    ------
    grader.sandbox.inside.wire.WireClosed, grader.sandbox.inside.wire.WireTimeout
        If the worker does not report.
    """
    time_limit = wire.start_time_limit(SECONDS_TO_REPORT)
    wire.send(worker.write_end, rules, time_limit)
    wire.receive(worker.read_end, time_limit)


def _kill(process: Popen) -> int | None:
    """End a process and its process group; return its exit code, or None if it does not end."""
    for end in (_end_gently, _kill_group):
        if process.returncode is None:  # after it has ended, another process may have its ID
            end(process)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(SECONDS_TO_END)
    return process.returncode


def _end_gently(process: Popen) -> None:
    """End a sandbox by closing its input; kill a process that does not wait for input."""
    if process.stdin:
        process.stdin.close()
    else:
        _kill_group(process)


def _kill_group(process: Popen) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _end_with_message(process: Popen) -> str:
    """End a process and return the last part of its error output."""
    _kill(process)
    # A process that the sandbox started may still be running and keep the pipe open.
    os.set_blocking(process.stderr.fileno(), False)
    return (process.stderr.read() or b"").decode(errors="replace").strip()[-500:]


def _start_process(
    command: Sequence[str],
    home: str,
    pipes: Sequence[int],
    stdin: int,
    stdout: int = subprocess.DEVNULL,
) -> Popen:
    return subprocess.Popen(
        command,
        pass_fds=pipes,
        env={"HOME": home, **ENVIRONMENT},
        stdin=stdin,
        stdout=stdout,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )


def _start_and_join(
    sandbox_command: Sequence[str], request: dict, client: ForkClient, read_end: int, write_end: int
) -> tuple[Popen, ForkedWorker]:
    """Build a sandbox whose only process waits, and let a forked worker join that sandbox."""
    info_read, info_write = os.pipe()
    # When process 1 of a PID namespace ends, the kernel kills all other processes there.
    options = ["--as-pid-1", "--info-fd", str(info_write), "--", "/bin/sh", "-c", WAIT_COMMAND]
    try:
        # Bubblewrap inherits both ends of the pipe, so that it cannot fail to write to the pipe.
        # After a failed write, bubblewrap would end and leave its child behind.
        pipes = info_write, info_read
        streams = subprocess.PIPE, subprocess.PIPE
        process = _start_process([*sandbox_command, *options], request["home"], pipes, *streams)
    finally:
        os.close(info_write)
    try:
        # The process inside writes this line when the sandbox is complete.
        ready = read_line(process.stdout.fileno(), SECONDS_TO_REPORT)
        with os.fdopen(info_read) as report:
            sandbox_pid = json.load(report)["child-pid"] if ready else None
        if sandbox_pid is None:
            raise SandboxUnavailable("The sandbox cannot be built.")
        worker = client.fork({"sandbox_pid": sandbox_pid, **request}, read_end, write_end)
        return process, worker
    except SandboxUnavailable as fault:
        complaint = _end_with_message(process)
        process.stderr.close()
        raise SandboxUnavailable(f"{fault} {complaint}".strip()) from None
    finally:
        process.stdout.close()
