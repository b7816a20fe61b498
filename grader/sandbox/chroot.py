"""Walls for a root who may build no namespaces, as in most containers: a folder, and a user.

A worker's root is a folder in which there is nothing but what it is shown; it runs as a user that
nobody else is, without privileges, and cannot make a socket. So it reaches neither the files nor
the processes of whoever judges, nor a network. It is on the same machine as they, though, and sees
what a kernel counts for all: enough where a container judges one student's work and ends, as
Gradescope's do; too little for a class.
"""

from __future__ import annotations

import functools
import os
import sys
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.sandbox import jail, users
from grader.sandbox.boundary import PREFIX, PYTHON, SHOWN
from grader.sandbox.inside.syscalls import MACHINES
from grader.sandbox.launcher import launch
from grader.sandbox.protocol import Limits, SandboxUnavailable, Worker

JAILER = Path(__file__).with_name("jailer.py")
_OWN = tuple(f"{folder}/" for folder in jail.OPEN)


@dataclass(frozen=True)
class Chroot:
    """The sandbox for a container that judges the work of one student."""

    name: str = "chroot"
    warning: str = (
        "WARNING: thin walls (--sandbox chroot). Submitted code is shut in a folder, as a user of "
        "its own; but notebooks can tell each other something, and can fill the disk. Only where "
        "a container holds one student's work."
    )

    def available(self) -> None:
        """Start a worker, once; see `grader.sandbox.protocol.Sandbox`."""
        complaint = _complaint()
        if complaint:
            raise SandboxUnavailable(complaint)

    def label(self) -> str:
        """Name it; see `grader.sandbox.protocol.Sandbox`."""
        return self.name

    def walls(self) -> str:
        """Say which walls there are, for whoever grades."""
        return (
            "a folder with what is shown for a root, an unused user for each worker, no sockets, "
            "limits on memory, processes and time"
        )

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named: Iterable[str] = (),
    ) -> Worker:
        """Start a worker in a folder; see `grader.sandbox.protocol.Sandbox`."""
        user, kind = users.unused(), (tuple(packages), tuple(forbidden))
        rules = {
            "user": user,
            "limits": limits.resources() | {"RLIMIT_NPROC": limits.processes},
            "forbidden": list(forbidden),
            "sockets": False,
        }
        try:
            folder = _take(kind)
            jail.give(folder, user)
        except OSError as error:
            raise SandboxUnavailable(f"The folder for a sandbox cannot be made: {error}") from None
        walls = [sys.executable, "-I", "-S", "-B", str(JAILER), str(folder), jail.HOME, str(user)]
        return launch(walls, jail.HOME, rules, limits, give_back=lambda: offer(kind, folder))


Kind = tuple[tuple[str, ...], tuple[str, ...]]
"""Packages that a worker is shown, and modules that it is not."""
_free: dict[Kind, list[Path]] = defaultdict(list)


def offer(kind: Kind, folder: Path) -> None:
    """Have a folder used that `jail.build` made beforehand."""
    _free[kind].append(folder)


def _take(kind: Kind) -> Path:
    """A folder that nobody is in: no two are ever in one at a time."""
    try:
        return _free[kind].pop()
    except IndexError:
        return jail.build(*kind)


def hidden_by_their_own() -> str:
    """What a worker is shown that would lie in its own folders; empty where nothing does."""
    shown = (PYTHON, PREFIX, *SHOWN)
    return next((str(path) for path in shown if str(path).startswith(_OWN)), "")


@functools.cache
def _complaint() -> str:
    """Why such walls cannot be built here; empty where they can."""
    if not sys.platform.startswith("linux") or os.uname().machine not in MACHINES:
        return f"These walls need Linux on {' or '.join(MACHINES)}."
    if not users.is_root():
        return "These walls need root: only root can shut others in."
    if hidden := hidden_by_their_own():
        return (
            f"{hidden} lies in {' or '.join(jail.OPEN)}, where whoever is shut in has files of "
            "their own. Move the course elsewhere, with its .venv."
        )
    try:
        Chroot().start(Limits()).stop()
    except SandboxUnavailable as error:
        return (
            "Root may not shut others in here. It takes the capabilities that Docker gives by "
            f"default: SYS_CHROOT, SETUID, SETGID, CHOWN, MKNOD. {error}"
        )
    return ""
