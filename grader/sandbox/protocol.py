"""The interface of a sandbox: it starts workers, which do not contain student code yet.

The worker is `inside/worker.py`. It may run as a process, in a container or on another machine;
the judge only uses the interface `Worker`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

MEBIBYTE = 2**20


class SandboxUnavailable(Exception):
    """The requested sandbox cannot be built on this machine.

    Parameters
    ----------
    reason : str
        The reason in sentences.
    advice : str
        What to do on your own machine; ``str()`` shows it after the reason.
    """

    def __init__(self, reason: str, advice: str = "") -> None:
        super().__init__(reason, advice)
        self.reason, self.advice = reason, advice

    def __str__(self) -> str:
        return f"{self.reason} {self.advice}".rstrip()


@dataclass(frozen=True)
class Limits:
    """What a student's process may use.

    Attributes
    ----------
    start_seconds : float
        For the cells that the exercises need. These and the next three are seconds in which the
        process works or sleeps, without waiting for a processor; `grader.sandbox.time_budget`
        measures them.
    whole_seconds : float
        For all cells, which run if a name is still missing.
    call_seconds : float
        For one call. When calls that raised or were stopped have taken this long in an exercise,
        each later call gets an eighth of it.
    total_seconds : float
        For everything.
    wall_seconds : float
        Elapsed time for everything.
    restarts : int
        How often the process may die or hang before the remaining tests are given up.
    memory, total_memory : int
        Bytes for one process, and for the worker with all that it starts.
    processes : int
    file_size, temporary_space : int
        Bytes of one file, and of each temporary folder.
    """

    start_seconds: float = 10.0
    whole_seconds: float = 30.0
    call_seconds: float = 10.0
    total_seconds: float = 180.0
    wall_seconds: float = 600.0
    restarts: int = 3
    memory: int = 3072 * MEBIBYTE
    total_memory: int = 6144 * MEBIBYTE
    processes: int = 48
    file_size: int = 32 * MEBIBYTE
    temporary_space: int = 64 * MEBIBYTE

    def resources(self) -> dict[str, int]:
        """Return resource limits by the names of Python's `resource` module."""
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
    delayed : float
        Seconds that it has waited for a processor since it began.
    ready : bool
        Whether it is running or waiting for a processor.
    """

    delayed: float
    ready: bool


class Worker(Protocol):
    """A running worker that has applied its rules and has received no request yet.

    Attributes
    ----------
    read_end, write_end : int
        Non-blocking descriptors of the two pipes, or sockets, from and to the worker.
    """

    read_end: int
    write_end: int

    def cpu_seconds(self) -> float:
        """Return the processor time of the worker and of all that it started; never decreases.

        If that is unknown, elapsed time serves as an upper bound.
        """

    def threads(self) -> dict[int, Thread] | None:
        """Return the threads that run for the worker now, by ID; None if that is unknown.

        Threads that lowered their own scheduling priority are left out, because they chose to wait.
        """

    def has_ended(self, seconds: float) -> bool:
        """Return whether it ends by itself within some seconds; `stop` is called in any case."""

    def stop(self) -> int | None:
        """End the worker and all that it started, close the descriptors, return the exit code.

        Returns
        -------
        int or None
            A signal is a negative number, as in `subprocess`, or 128 plus the signal, as in a
            shell. None if the exit code is unknown.
        """


class Sandbox(Protocol):
    """One way to run a student's code; `grader.sandbox.SANDBOXES` lists them all.

    Attributes
    ----------
    name : str
        Its name for ``--sandbox``.
    warning : str
        What it does not protect, for the instructor; empty if it is safe for a class.
    """

    name: str
    warning: str

    def available(self) -> None:
        """Check that this machine has what it needs.

        Raises
        ------
        SandboxUnavailable
            If not; the message names the remedy.
        """

    def label(self) -> str:
        """Return the name and version of the program that builds the sandbox, for reports."""

    def walls(self) -> str:
        """List what protects this machine from student code."""

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named: Iterable[str] = (),
    ) -> Worker:
        """Start a worker that does not contain student code yet.

        Parameters
        ----------
        limits : Limits
        forbidden : iterable of str
            Dotted names of modules that the sandbox hides.
        packages : iterable of str
            Installed packages that the sandbox shows, by their names on PyPI.
        named : iterable of str
            Those packages that the student's code names, which may be imported in advance.

        Raises
        ------
        SandboxUnavailable
            If the worker does not report, which is the grader's fault, not the student's.
        """
