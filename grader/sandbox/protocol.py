"""What a sandbox is: something that can start a worker with nothing of the student in it yet.

The worker is `inside/worker.py`, wherever and however it runs: a process, a container, another
machine. What the judge's side wants of it is `Worker`, and no more.
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
        Sentences that say why.
    advice : str
        What to do on a machine of one's own; ``str()`` shows it after the reason.
    """

    def __init__(self, reason: str, advice: str = "") -> None:
        super().__init__(reason, advice)
        self.reason, self.advice = reason, advice

    def __str__(self) -> str:
        return f"{self.reason} {self.advice}".rstrip()


@dataclass(frozen=True)
class Limits:
    """What a student's process may use.

    Seconds are those that `grader.sandbox.time_budget` counts, in which a process works or sleeps
    and nobody keeps it waiting: for the cells that the exercises need; for all cells, where a name
    is missing afterwards; for one call; and for everything together. `wall_seconds` are the wall's,
    for everything together. Where steps that raised, or had to be stopped, have taken as long as
    one may, the next have an eighth of that.

    Bytes of `memory` are for one process, of `total_memory` for it and all it starts. `restarts` is
    how often the process may die or hang before the rest of its tests are given up.
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
        """Resource limits by the names of Python's `resource` module."""
        return {
            "RLIMIT_AS": self.memory,
            "RLIMIT_CPU": int(2 * self.total_seconds),
            "RLIMIT_FSIZE": self.file_size,
            "RLIMIT_NOFILE": 128,
            "RLIMIT_CORE": 0,
        }


class Thread(NamedTuple):
    """A thread that runs for a worker.

    Attributes
    ----------
    delayed : float
        Seconds for which it wanted a processor and had none, since it began.
    ready : bool
        Whether it has a processor now, or wants one.
    """

    delayed: float
    ready: bool


class Worker(Protocol):
    """A running worker that knows its rules, and that nobody has asked anything yet.

    Attributes
    ----------
    read_end, write_end : int
        Descriptors of the two pipes, or sockets, to and from it. They do not block.
    """

    read_end: int
    write_end: int

    def cpu_seconds(self) -> float:
        """Processor time that it and all it started have had; at least never going back.

        Where nobody can tell, the clock on the wall, which the processor's is never ahead of.
        """

    def threads(self) -> dict[int, Thread] | None:
        """All that run for it now, by number; None where nobody can tell.

        Only those that want a processor as much as we do: who asks for little, waits of its own
        accord.
        """

    def has_ended(self, seconds: float) -> bool:
        """Whether it ends by itself within some seconds; `stop` is called in any case."""

    def stop(self) -> int | None:
        """End it and all it started, close the descriptors, and tell its exit code.

        Returns
        -------
        int or None
            As `subprocess` has it, a signal as a negative number, or as a shell, 128 more than
            the signal; None where nobody knows.
        """


class Sandbox(Protocol):
    """One way to run a student's code; `grader.sandbox.SANDBOXES` lists them all.

    Attributes
    ----------
    name : str
        What ``--sandbox`` calls it.
    warning : str
        What it does not protect, for whoever grades; empty where it has walls.
    """

    name: str
    warning: str

    def available(self) -> None:
        """Return if this machine has what it needs.

        Raises
        ------
        SandboxUnavailable
            With the command that would mend it.
        """

    def label(self) -> str:
        """Name the program that builds the sandbox, with its version, for reports."""

    def walls(self) -> str:
        """Say what stands between a student's code and this machine."""

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named: Iterable[str] = (),
    ) -> Worker:
        """Start a worker; nothing of the student is in it yet.

        Parameters
        ----------
        limits : Limits
        forbidden : iterable of str
            Dotted names of modules that shall not exist inside.
        packages : iterable of str
            Installed packages, as pip calls them, that shall exist inside.
        named : iterable of str
            Those of them that the code to come names: they may be imported beforehand.

        Raises
        ------
        SandboxUnavailable
            If the worker does not report: the fault is then ours, not the student's.
        """
