"""Starts the process in which a student's code runs, watches its memory, and ends it."""

from __future__ import annotations

import contextlib
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

from grader.sandbox.boundary import PYTHON, WORKER
from grader.sandbox.fork_client import ENVIRONMENT, ForkClient, Forked, read_line
from grader.sandbox.inside import wire
from grader.sandbox.protocol import MEBIBYTE, Limits, SandboxUnavailable, Thread, Worker
from grader.sandbox.usage import cpu_of_tree, memory_left, memory_of_tree, threads_of_tree

SECONDS_BETWEEN_LOOKS = 0.2
SECONDS_TO_REPORT = 60
SECONDS_TO_END = 10
LEAST_MEMORY_LEFT = 0.03
MODEST_MEMORY = 1024 * MEBIBYTE
# What waits behind walls as long as somebody holds the other end of its input; it says when they
# stand. Who is killed lets go of that in any case. Bubblewrap's own --die-with-parent does not:
# killed while it builds, it leaves a process that waits for it.
WAIT = "echo ready && read line"


@dataclass
class WorkerProcess:
    """A `grader.sandbox.protocol.Worker` that is a process of this machine.

    Attributes
    ----------
    process : subprocess.Popen
        The walls, with all that is behind them; without walls, the worker.
    read_end, write_end : int
    forked : grader.sandbox.fork_client.Forked, optional
        The worker, where it was forked and went behind the walls later.
    give_back : callable
        Called once all has ended, when its folder can be somebody else's.
    """

    process: subprocess.Popen
    read_end: int
    write_end: int
    forked: Forked | None = None
    give_back: Callable[[], object] = lambda: None
    _stopped: threading.Event = field(default_factory=threading.Event)
    _signals: threading.Lock = field(default_factory=threading.Lock)

    @property
    def pids(self) -> list[int]:
        """Processes whose descendants are all that runs for it, as numbered out here."""
        return [self.process.pid, *([self.forked.pid] if self.forked else [])]

    def stop(self) -> int | None:
        """Kill the worker and all it started; return its exit code, None where none is told."""
        self._stopped.set()
        # Nobody else waits for the process, so until here its number belongs to no other.
        with self._signals:
            code = _kill(self.process)
        if self.forked:
            # With the first process behind the walls the kernel ends all others there.
            code = self.forked.end(SECONDS_TO_END)
        self.process.stderr.close()
        for end in (self.read_end, self.write_end):
            os.close(end)
        if code is not None and code >= 0:  # else somebody may still be there
            self.give_back()
        return code

    def has_ended(self, seconds: float) -> bool:
        """Whether it ends by itself within some seconds; its exit code is kept for `stop`."""
        if self.forked:
            return self.forked.has_ended(seconds)
        deadline = time.monotonic() + seconds
        while not os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOWAIT | os.WNOHANG):
            if time.monotonic() > deadline:
                return False
            time.sleep(0.01)
        return True

    def cpu_seconds(self) -> float:
        """Processor time that it and all it started have had."""
        return sum(map(cpu_of_tree, self.pids))

    def threads(self) -> dict[int, Thread] | None:
        """All that run for it and want a processor as much as we do, by number."""
        every = [threads_of_tree(pid) for pid in self.pids]
        return None if None in every else dict(itertools.chain(*map(dict.items, every)))

    def watch_memory(self, limit: int) -> None:
        """Kill the worker when all its processes together take more than `limit` bytes.

        Or less, when the machine runs out: a student may refuse to be the one that Linux ends.
        """

        def watch() -> None:
            while not self._stopped.wait(SECONDS_BETWEEN_LOOKS):
                most = limit if memory_left() > LEAST_MEMORY_LEFT else MODEST_MEMORY
                if sum(map(memory_of_tree, self.pids)) > most:
                    with self._signals:
                        if not self._stopped.is_set():
                            _let_end(self.process)
                    return

        threading.Thread(target=watch, daemon=True).start()


def launch(
    walls: Sequence[str],
    home: str,
    rules: dict,
    limits: Limits,
    client: ForkClient | None = None,
    preload: bool = False,
    give_back: Callable[[], object] | None = None,
) -> WorkerProcess:
    """Start a worker behind some walls, and wait until it reports.

    Parameters
    ----------
    walls : sequence of str
        The command that runs another one inside; empty for none.
    home : str
        The folder that the worker may write to.
    rules : dict
        What the worker imposes on itself before it reads a line of the student: ``user``, the
        number of one to become, if any; ``limits``, as `Limits.resources` names them;
        ``forbidden``, modules.
    limits : Limits
    client : grader.sandbox.fork_client.ForkClient, optional
        Has workers forked that go behind these walls; by default Python is started there.
    preload : bool
        That the fork server shall have imported beforehand what is slow to import.
    give_back : callable, optional
        Called once all has ended. Then the walls are a process that ends all behind them when its
        input closes; else they end with it.

    Raises
    ------
    SandboxUnavailable
        If it does not report.
    """
    their_read, our_write = os.pipe()
    our_read, their_write = os.pipe()
    for end in (our_read, our_write):
        os.set_blocking(end, False)
    try:
        if client is None:
            command = [*walls, PYTHON, "-I", "-B", str(WORKER), str(their_read), str(their_write)]
            talk = subprocess.PIPE if give_back else subprocess.DEVNULL
            process, forked = _run(command, home, (their_read, their_write), talk), None
        else:
            request = {"own_users": rules["user"] is None, "home": home, "preload": preload}
            process, forked = _go_behind(walls, request, client, their_read, their_write)
    except SandboxUnavailable:
        for end in (our_read, our_write):
            os.close(end)
        raise
    finally:
        os.close(their_read)
        os.close(their_write)
    worker = WorkerProcess(process, our_read, our_write, forked, give_back or (lambda: None))
    try:
        introduce(worker, rules)
    except (wire.WireClosed, wire.WireTimeout):
        complaint = _last_words(process)
        worker.stop()
        raise SandboxUnavailable(f"The sandbox could not start Python: {complaint}") from None
    worker.watch_memory(limits.total_memory)
    return worker


def introduce(worker: Worker, rules: dict) -> None:
    """Tell a worker that has just started its rules, and wait until it has made them its own.

    Parameters
    ----------
    worker : Worker
    rules : dict
        As for `launch`.

    Raises
    ------
    grader.sandbox.inside.wire.WireClosed, grader.sandbox.inside.wire.WireTimeout
        If it does not report.
    """
    patience = wire.within(SECONDS_TO_REPORT)
    wire.send(worker.write_end, rules, patience)
    wire.receive(worker.read_end, patience)


def _kill(process: Popen) -> int | None:
    """End a process and its group; its exit code, None where the kernel does not let go of it."""
    for end in (_let_end, _kill_group):
        if process.returncode is None:  # else its number may be another's by now
            end(process)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(SECONDS_TO_END)
    return process.returncode


def _let_end(process: Popen) -> None:
    """Let what waits behind walls end, and with it all others there; kill what does not wait."""
    if process.stdin:
        process.stdin.close()
    else:
        _kill_group(process)


def _kill_group(process: Popen) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)


def _last_words(process: Popen) -> str:
    """End a process; what it has complained about until then."""
    _kill(process)
    # Something that it has started may live on, and hold the pipe open.
    os.set_blocking(process.stderr.fileno(), False)
    return (process.stderr.read() or b"").decode(errors="replace").strip()[-500:]


def _run(
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


def _go_behind(
    walls: Sequence[str], request: dict, client: ForkClient, read_end: int, write_end: int
) -> tuple[Popen, Forked]:
    """Build walls around something that only waits, and have a worker go behind them."""
    info, number = os.pipe()
    # The first process of a table of processes ends all others when it ends.
    options = ["--as-pid-1", "--info-fd", str(number), "--", "/bin/sh", "-c", WAIT]
    try:
        # Both ends: who cannot tell its number would end, and leave what waits for it.
        pipes = number, info
        both = subprocess.PIPE, subprocess.PIPE
        process = _run([*walls, *options], request["home"], pipes, *both)
    finally:
        os.close(number)
    try:
        # By what is behind the walls: they are complete.
        ready = read_line(process.stdout.fileno(), SECONDS_TO_REPORT)
        with os.fdopen(info) as told:
            first = json.load(told)["child-pid"] if ready else None
        if first is None:
            raise SandboxUnavailable("The sandbox cannot be built.")
        return process, client.fork({"walls": first, **request}, read_end, write_end)
    except SandboxUnavailable as fault:
        complaint = _last_words(process)
        process.stderr.close()
        raise SandboxUnavailable(f"{fault} {complaint}".strip()) from None
    finally:
        process.stdout.close()
