"""The interfaces of a sandbox and of the workers that it starts.

A worker runs `inside/worker.py`, as a process, in a container or on another machine. The judge
uses only the interface `Worker`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from grader.errors import UserError
from utils.in_sandbox import CALL_SECONDS

MEBIBYTE = 2**20


class SandboxUnavailable(UserError):
    """The requested sandbox cannot be built on this machine.

    Parameters
    ----------
    reason : str
        The reason in sentences.
    advice : str
        What the user can do instead. ``str()`` appends it to the reason.
    """

    is_multiline = True  # the reason may quote the output of a program

    def __init__(self, reason: str, advice: str = "") -> None:
        super().__init__(reason, advice)
        self.reason, self.advice = reason, advice

    def __str__(self) -> str:
        return f"{self.reason} {self.advice}".rstrip()


@dataclass(frozen=True)
class Limits:
    """Limits on the time, memory and files of a student's process.

    Attributes
    ----------
    start_seconds : float
        Time for the cells that the exercises need. This limit and the next three count seconds in
        which the process works or sleeps, but not seconds in which it waits for a processor. See
        `grader.sandbox.time_budget`.
    whole_seconds : float
        Time for all cells, which run if a name is still missing.
    call_seconds : float
        Time for one call. Once the failed calls of an exercise have taken this long in total, each
        later call gets an eighth of it. A call fails if it raises an exception or has to be
        stopped.
    total_seconds : float
        Time for the whole notebook, over all runs.
    wall_seconds : float
        Elapsed time for the whole notebook, over all runs; see `Budget.deadline`.
    restarts : int
        How often a new process may replace a process that died or took too long, for each exercise
        and for the notebook's own cells. After that, the judge skips the remaining tests.
    memory, total_memory : int
        Bytes for one process, and for all processes of the worker together.
    processes : int
    file_size, temporary_space : int
        Bytes of one file, and of each temporary folder.
    """

    start_seconds: float = 10.0
    whole_seconds: float = 30.0
    call_seconds: float = CALL_SECONDS
    total_seconds: float = 180.0
    wall_seconds: float = 600.0
    restarts: int = 3
    memory: int = 3072 * MEBIBYTE
    total_memory: int = 6144 * MEBIBYTE
    processes: int = 48
    file_size: int = 32 * MEBIBYTE
    temporary_space: int = 64 * MEBIBYTE

    def resources(self) -> dict[str, int]:
        """Return resource limits by their names in Python's `resource` module."""
        return {
            "RLIMIT_AS": self.memory,
            "RLIMIT_CPU": int(2 * self.total_seconds),
            "RLIMIT_FSIZE": self.file_size,
            "RLIMIT_NOFILE": 128,
            "RLIMIT_CORE": 0,
        }


class Thread(NamedTuple):
    """A thread of a worker.

    Attributes
    ----------
    delay_seconds : float
        Seconds for which the thread has waited for a processor since it started.
    is_ready : bool
        Whether the thread is running or waiting for a processor.
    """

    delay_seconds: float
    is_ready: bool


class Worker(Protocol):
    """A running worker that has applied its rules and has not received a request yet.

    Attributes
    ----------
    read_end, write_end : int
        Non-blocking descriptors of the two pipes, or sockets, from and to the worker.
    """

    read_end: int
    write_end: int

    def cpu_seconds(self) -> float:
        """Return the processor time in seconds of the worker and of everything that it started.

        The result never decreases. If the time is unknown, the result is elapsed time, as an upper
        bound.
        """

    def threads(self) -> dict[int, Thread] | None:
        """Return the current threads of the worker by ID, or None if they are unknown.

        Threads that lowered their own scheduling priority are left out. Otherwise student code
        could extend its time limit by making a thread wait.
        """

    def has_ended(self, seconds: float) -> bool:
        """Return whether the worker ends by itself within `seconds`; call `stop` in either case."""

    def lacked_memory(self) -> bool:
        """Return whether the worker died below its own limit because the machine lacked memory.

        The result is valid after `stop`.
        """

    def stop(self) -> int | None:
        """End the worker and everything that it started, and close the descriptors.

        Returns
        -------
        int or None
            Exit code of the worker, or None if unknown. If a signal ended the worker, the code is
            the negative signal number, as in `subprocess`, or 128 plus the number, as in a shell.
        """


class Sandbox(Protocol):
    """A way to run student code; `grader.sandbox.SANDBOXES` lists all sandboxes.

    Attributes
    ----------
    name : str
        Value of the option ``--sandbox`` that selects this sandbox.
    warning : str
        The risks of this sandbox, for the instructor; empty if it is safe for a class.
    """

    name: str
    warning: str

    def check_available(self) -> None:
        """Check that this machine can build the sandbox.

        Raises
        ------
        SandboxUnavailable
            If the machine cannot build it. The message says how to fix that.
        """

    def label(self) -> str:
        """Return the name and version of the program that builds the sandbox, for reports."""

    def protections(self) -> str:
        """Describe for the instructor how this machine is protected against student code."""

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named_packages: Iterable[str] = (),
    ) -> Worker:
        """Start a worker that does not contain student code yet.

        Parameters
        ----------
        limits : Limits
        forbidden : iterable of str
            Dotted names of modules that the sandbox hides.
        packages : iterable of str
            Installed packages that the sandbox shows, by their names on PyPI.
        named_packages : iterable of str
            The packages that the student's code mentions. Their modules may be imported early.

        Raises
        ------
        SandboxUnavailable
            If the worker does not report, which is the grader's fault, not the student's.
        """
