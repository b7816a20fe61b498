"""The sandbox that bubblewrap builds on Linux.

It has no network, no privileges, a read-only file system without this project, a small private
/tmp, and its own process table.
"""

from __future__ import annotations

import functools
import itertools
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from grader.course.paths import PROJECT
from grader.sandbox import bubblewrap_program, users
from grader.sandbox.boundary import (
    BASE_PREFIX,
    HIDDEN_SYSTEM_FOLDERS,
    PREFIX,
    PYTHON,
    SHOWN_PATHS,
    SYSTEM_FOLDERS,
    files_of_packages,
    folders_of_modules,
    folders_of_packages,
)
from grader.sandbox.fork_client import client_for, modules_to_preload
from grader.sandbox.inside.syscalls import MACHINES
from grader.sandbox.launcher import launch
from grader.sandbox.program import INSTALLED_PACKAGES
from grader.sandbox.protocol import Limits, SandboxUnavailable, Worker


@dataclass(frozen=True)
class Bubblewrap:
    """The sandbox for untrusted code."""

    name: str = "bubblewrap"
    warning: str = ""

    def check_available(self) -> None:
        """Build a trial sandbox, once; see `grader.sandbox.protocol.Sandbox`."""
        _require_program()

    def label(self) -> str:
        """Return the program's version and origin; see `grader.sandbox.protocol.Sandbox`."""
        program = _require_program()
        return f"{program.version()} ({program.origin})"

    def protections(self) -> str:
        """List the protections on this machine, for the instructor."""
        user = (
            "an unused user for each notebook"
            if users.is_root()
            else "a separate user namespace for each notebook"
        )
        calls = "" if os.uname().machine in MACHINES else " (but no filter of system calls)"
        return (
            f"no network, no access to other processes, {user}, only listed files visible, limits "
            f"on memory, processes, files and time{calls}"
        )

    def start(
        self,
        limits: Limits,
        forbidden: Iterable[str] = (),
        packages: Iterable[str] = (),
        named_packages: Iterable[str] = (),
    ) -> Worker:
        """Start a worker in the sandbox; see `grader.sandbox.protocol.Sandbox`."""
        # The kernel counts processes by user, and separately in each user namespace. Without a
        # separate user or user namespace, the instructor's own processes would count.
        resources = limits.resources() | {"RLIMIT_NPROC": limits.processes}
        rules = {
            "user": users.unused_user_id() if users.is_root() else None,
            "limits": resources,
            "forbidden": list(forbidden),
        }
        packages, forbidden = tuple(packages), tuple(forbidden)
        file_options = _options_for_files(packages, forbidden)
        command = [*_sandbox_command(limits), *file_options, "--remount-ro", "/"]
        if _can_join_namespaces():
            client = client_for(modules_to_preload(packages), forbidden)
            return launch(
                command,
                "/tmp",
                rules,
                limits,
                client,
                bool(modules_to_preload(tuple(named_packages))),
            )
        return launch([*command, "--die-with-parent", "--"], "/tmp", rules, limits)


@functools.cache
def _find_program() -> tuple[bubblewrap_program.Executable | None, str]:
    """Return a bubblewrap program that works here, or the reason why there is none."""
    return bubblewrap_program.find_program(_isolation_options(Limits()))


def _require_program() -> bubblewrap_program.Executable:
    program, complaint = _find_program()
    if not program:
        raise SandboxUnavailable(
            complaint,
            "Student code runs only inside a sandbox. If you trust the code, you can grade it "
            "without a sandbox by adding: --sandbox process",
        )
    return program


@functools.cache
def _can_join_namespaces() -> bool:
    """Return whether a worker may join the namespaces of a sandbox, which some systems forbid."""
    rules = {
        "user": users.unused_user_id() if users.is_root() else None,
        "limits": Limits().resources(),
        "forbidden": [],
    }
    command = [*_sandbox_command(Limits()), *_options_for_files((), ()), "--remount-ro", "/"]
    try:
        # The trial uses the fork server that most lessons need, so that server starts only once.
        launch(
            command, "/tmp", rules, Limits(), client_for(modules_to_preload(INSTALLED_PACKAGES))
        ).stop()
    except SandboxUnavailable:
        return False
    return True


def _sandbox_command(limits: Limits) -> list[str]:
    """Return the bubblewrap command without the options of `_options_for_files`."""
    return [_require_program().path, *_isolation_options(limits)]


def _isolation_options(limits: Limits) -> list[str]:
    options = [
        "--unshare-net",
        "--unshare-pid",
        "--unshare-ipc",
        "--unshare-uts",
        "--unshare-cgroup-try",
        "--new-session",
    ]
    if users.is_root():
        # The limit on processes does not apply to real root, even in a user namespace. So root does
        # not get a user namespace. Instead, the worker changes to an unused user before it reads
        # student code.
        options += ["--cap-drop", "ALL", "--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    else:
        options += ["--unshare-user", "--disable-userns"]
    system = [
        ("--ro-bind-try", path, path)
        for path in (*SYSTEM_FOLDERS, "/etc/ld.so.cache", "/etc/alternatives")
    ]
    system += [
        ("--symlink", os.readlink(path), path)
        if os.path.islink(path)
        else ("--ro-bind-try", path, path)
        for path in ("/bin", "/lib", "/lib32", "/lib64")
        if os.path.lexists(path)
    ]
    return [
        *options,
        *itertools.chain(*system),
        "--proc",
        "/proc",
        # Process 1 is bubblewrap or the waiting shell, without our limits or system call filter.
        # If an ordinary user runs the grader, student code runs as the same user. It could then
        # write to the memory of process 1.
        "--tmpfs",
        "/proc/1",
        "--remount-ro",
        "/proc/1",
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


def _options_for_files(packages: tuple[str, ...], forbidden: Iterable[str]) -> list[str]:
    """Return options that show Python and the files in the boundary, without forbidden modules."""
    ours = [PYTHON, f"{PREFIX}/pyvenv.cfg", *map(str, (*SHOWN_PATHS, *files_of_packages(packages)))]
    shown = [path for path in dict.fromkeys(ours) if os.path.exists(path)]
    # The project or a folder of packages may be inside a visible folder. Such folders are hidden
    # first, and then only the files in `shown` are added again.
    # A link to a folder outside the visible ones leads nowhere, and bubblewrap could not cover it.
    covered = [*filter(os.path.isdir, map(os.path.realpath, HIDDEN_SYSTEM_FOLDERS)), str(PROJECT)]
    covered += map(str, folders_of_packages())
    covered = [path for path in covered if _is_in_any(path, (*SYSTEM_FOLDERS, BASE_PREFIX))]
    options = [] if _is_in_any(BASE_PREFIX, SYSTEM_FOLDERS) else _options_to_show([BASE_PREFIX])
    options += itertools.chain(*(("--tmpfs", path) for path in covered))
    options += _options_to_show(shown)
    for hidden in map(str, folders_of_modules(forbidden, packages)):
        options += ["--tmpfs", hidden, "--remount-ro", hidden]
    options += itertools.chain(*(("--remount-ro", path) for path in covered))
    return options


def _options_to_show(paths: list[str]) -> list[str]:
    """Return options that show files and folders and create their parent folders."""
    parents = {str(parent) for path in paths for parent in Path(path).parents}
    # With bubblewrap's default permissions, other users could not enter the folders.
    folders = (("--perms", "0755", "--dir", path) for path in sorted(parents, key=len))
    return [*itertools.chain(*folders), *itertools.chain(*(("--ro-bind", p, p) for p in paths))]


def _is_in_any(path: str, folders: Iterable[str]) -> bool:
    return any(Path(path).is_relative_to(folder) for folder in folders)
