"""A sandbox for containers in which root cannot create namespaces: a chroot and an unused user.

The worker's root directory contains only the files that the worker may see. The worker runs as a
separate user, without privileges, and cannot create sockets. So it cannot reach the judge's files,
the judge's processes or a network. However, all workers share one kernel, and could exchange
messages through its counters. This sandbox is safe enough for a container that judges one student
and then ends, as on Gradescope. It is not safe for a class.
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
from grader.sandbox.boundary import PREFIX, PYTHON, SHOWN_PATHS
from grader.sandbox.inside.syscalls import MACHINES
from grader.sandbox.launcher import launch
from grader.sandbox.protocol import Limits, SandboxUnavailable, Worker

JAILER = Path(__file__).with_name("jailer.py")
_WRITABLE_PREFIXES = tuple(f"{folder}/" for folder in jail.WRITABLE_FOLDERS)


@dataclass(frozen=True)
class Chroot:
    """The sandbox for a container that judges only one student's work."""

    name: str = "chroot"
    warning: str = (
        "WARNING: weak isolation (--sandbox chroot). Submitted code runs in a chroot as a separate "
        "user, but notebooks can exchange messages and fill the disk. Use it only in a container "
        "that judges one student."
    )

    def check_available(self) -> None:
        """Start a trial worker, once; see `grader.sandbox.protocol.Sandbox`."""
        complaint = _find_problem()
        if complaint:
            raise SandboxUnavailable(complaint)

    def label(self) -> str:
        """Return the sandbox's name; see `grader.sandbox.protocol.Sandbox`."""
        return self.name

    def protections(self) -> str:
        """List the protections, for the instructor."""
        return (
            "a root directory with only listed files, an unused user for each worker, no sockets, "
            "limits on memory, processes and time"
        )

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named_packages: Iterable[str] = (),
    ) -> Worker:
        """Start a worker in a chroot; see `grader.sandbox.protocol.Sandbox`."""
        user, kind = users.unused_user_id(), (tuple(packages), tuple(forbidden))
        rules = {
            "user": user,
            "limits": limits.resources() | {"RLIMIT_NPROC": limits.processes},
            "forbidden": list(forbidden),
            "sockets": False,
        }
        try:
            folder = _take_jail(kind)
            jail.reset_writable_folders(folder, user)
        except OSError as error:
            raise SandboxUnavailable(f"Cannot create a folder for the sandbox: {error}") from None
        command = [
            sys.executable,
            "-I",
            "-S",
            "-B",
            str(JAILER),
            str(folder),
            jail.HOME,
            str(user),
        ]
        return launch(
            command, jail.HOME, rules, limits, release_folder=lambda: put_back_jail(kind, folder)
        )


Kind = tuple[tuple[str, ...], tuple[str, ...]]
"""The packages that a worker can see, and the modules that are hidden from it."""
_free_jails: dict[Kind, list[Path]] = defaultdict(list)


def put_back_jail(kind: Kind, folder: Path) -> None:
    """Make a folder built by `jail.build` available to the next worker of its kind."""
    _free_jails[kind].append(folder)


def _take_jail(kind: Kind) -> Path:
    """Return a folder that no other worker is using."""
    try:
        return _free_jails[kind].pop()
    except IndexError:
        return jail.build(*kind)


def path_in_writable_folders() -> str:
    """Return a path that the sandbox needs but that is in a writable folder; "" if there is none.

    Such a path would disappear, because `jail.reset_writable_folders` empties these folders.
    """
    shown = (PYTHON, PREFIX, *SHOWN_PATHS)
    return next((str(path) for path in shown if str(path).startswith(_WRITABLE_PREFIXES)), "")


@functools.cache
def _find_problem() -> str:
    """Return the reason why this sandbox cannot be built here; "" if it can."""
    if not sys.platform.startswith("linux") or os.uname().machine not in MACHINES:
        return f"This sandbox needs Linux on {' or '.join(MACHINES)}."
    if not users.is_root():
        return "This sandbox needs root, because only root can use chroot."
    if hidden := path_in_writable_folders():
        return (
            f"{hidden} is in {' or '.join(jail.WRITABLE_FOLDERS)}, where student code writes its "
            "files. Move the course and its .venv to another folder."
        )
    try:
        Chroot().start(Limits()).stop()
    except SandboxUnavailable as error:
        return (
            "Root cannot build a chroot here. It needs the capabilities that Docker grants by "
            f"default: SYS_CHROOT, SETUID, SETGID, CHOWN, MKNOD. {error}"
        )
    return ""
