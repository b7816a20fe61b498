"""Walls built by bubblewrap, on Linux.

No network, a read-only system without this project, a small private /tmp, a process table of its
own and no privileges.
"""

from __future__ import annotations

import functools
import itertools
import os
import secrets
import shutil
import subprocess
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.sandbox.boundary import SHOWN
from grader.sandbox.protocol import Limits, SandboxUnavailable
from grader.sandbox.workers import Worker, launch


@dataclass(frozen=True)
class Bubblewrap:
    """The sandbox for strangers' code."""

    name: str = "bubblewrap"
    warning: str = ""

    def available(self) -> None:
        """Build a trial sandbox, once; see `grader.sandbox.protocol.Sandbox`."""
        complaint = _complaint()
        if complaint:
            raise SandboxUnavailable(
                f"{complaint} Student code is only run inside a sandbox. To grade code that you "
                "trust without one, add: --sandbox process"
            )

    def start(self, limits: Limits, forbidden: Iterable[str] = ()) -> Worker:
        """Start a worker behind walls; see `grader.sandbox.protocol.Sandbox`."""
        # Without a process table of its own this would count all processes of whoever grades.
        resources = limits.resources() | {"RLIMIT_NPROC": limits.processes}
        rules = {
            "user": _unused_user() if _is_root() else None,
            "limits": resources,
            "forbidden": list(forbidden),
        }
        walls = [*_walls(limits), *_windows(forbidden), "--remount-ro", "/", "--"]
        return launch(walls, "/tmp", rules, limits)


@functools.cache
def _complaint() -> str:
    """Why bubblewrap does not work here; empty where it does."""
    if not sys.platform.startswith("linux"):
        return "The sandbox needs Linux (on Windows: WSL 2; on a Mac: a Linux container)."
    if not shutil.which("bwrap"):
        return (
            "bubblewrap is not installed. Install it with: "
            "sudo apt-get install bubblewrap  (Fedora: sudo dnf install bubblewrap)."
        )
    trial = subprocess.run(
        [*_walls(Limits()), "/bin/sh", "-c", "true"], capture_output=True, text=True
    )
    if trial.returncode:
        return (
            f"bubblewrap is installed but cannot build a sandbox here: {trial.stderr.strip()}."
            " Inside a container, allow user namespaces (docker run --privileged); on "
            "Ubuntu 24.04: sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0."
        )
    return ""


def _is_root() -> bool:
    """True for a root who can become other users; in some containers it is the only one."""
    return os.geteuid() == 0 and _number_of_users() >= 2**16


def _unused_user() -> int:
    """A user of its own for each worker: limits are counted by user and do not bind root."""
    count = _number_of_users()
    return count // 2 + secrets.randbelow(count // 2 - 2)


def _number_of_users() -> int:
    first, _, count = map(int, Path("/proc/self/uid_map").read_text().splitlines()[0].split())
    return count if first == 0 else 0


def _walls(limits: Limits) -> list[str]:
    """The bubblewrap command up to what is seen through it."""
    options = [
        "--unshare-net",
        "--unshare-pid",
        "--unshare-ipc",
        "--unshare-uts",
        "--unshare-cgroup-try",
        "--die-with-parent",
        "--new-session",
    ]
    if _is_root():
        # Real root in a user namespace stays real root for resource limits; so no namespace,
        # and the worker leaves root for an unused user before it reads a line of the student.
        options += ["--cap-drop", "ALL", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    else:
        options += ["--unshare-user", "--disable-userns"]
    system = [
        ("--ro-bind-try", path, path) for path in ("/usr", "/etc/ld.so.cache", "/etc/alternatives")
    ]
    system += [
        ("--symlink", os.readlink(path), path)
        if os.path.islink(path)
        else ("--ro-bind-try", path, path)
        for path in ("/bin", "/lib", "/lib32", "/lib64")
        if os.path.lexists(path)
    ]
    return [
        "bwrap",
        *options,
        *itertools.chain(*system),
        "--proc",
        "/proc",
        "--dev",
        "/dev",
        "--perms",
        "1777",
        "--size",
        str(limits.temporary_space),
        "--tmpfs",
        "/dev/shm",
        "--remount-ro",
        "/dev",
        "--perms",
        "1777",
        "--size",
        str(limits.temporary_space),
        "--tmpfs",
        "/tmp",
        "--chdir",
        "/tmp",
    ]


def _windows(forbidden: Iterable[str]) -> list[str]:
    """Options that show Python and what the boundary lets through, less what is forbidden."""
    shown = [sys.base_prefix, sys.prefix, *map(str, SHOWN)]
    parents = {str(parent) for path in shown for parent in Path(path).parents}
    # Folders that bubblewrap makes by itself are closed to all but their owner.
    options = list(
        itertools.chain(*(("--perms", "0755", "--dir", path) for path in sorted(parents, key=len)))
    )
    options += itertools.chain(*(("--ro-bind", path, path) for path in dict.fromkeys(shown)))
    for module in forbidden:
        for folder in _folders_of(module):
            options += ["--tmpfs", folder, "--remount-ro", folder]
    return options


@functools.cache
def _folders_of(module: str) -> tuple[str, ...]:
    """Every folder of a module that can be seen inside; the system's Python may have it too."""
    libraries = [
        Path(root, name)
        for root in (sys.prefix, sys.base_prefix, "/usr", "/usr/local")
        for name in ("lib", "lib64")
    ]
    pattern = f"python*/*-packages/{module.replace('.', '/')}"
    return tuple(
        dict.fromkeys(
            str(folder)
            for library in libraries
            if not library.is_symlink()
            for folder in library.glob(pattern)
            if folder.is_dir()
        )
    )
