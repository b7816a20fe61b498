"""What a sandbox is: something that can start a worker with nothing of the student in it yet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from grader.sandbox.workers import Worker

MEBIBYTE = 2**20


class SandboxUnavailable(Exception):
    """The sandbox that was asked for cannot be built on this machine."""


@dataclass(frozen=True)
class Limits:
    """What a student's process may use.

    Seconds are of processor time, as `grader.sandbox.patience` counts it: for the notebook's own
    cells, for one call, and for everything together. Bytes of `memory` are for one process, of
    `total_memory` for it and all it starts. `restarts` is how often the process may die or hang
    before the rest of its tests are given up.
    """

    start_seconds: float = 30.0
    call_seconds: float = 10.0
    total_seconds: float = 180.0
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
