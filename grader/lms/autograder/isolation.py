"""Access restrictions that must be in place before student code runs in Gradescope's container."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable

PREFERRED_SANDBOXES = ("bubblewrap", "chroot")
"""Sandboxes, the strongest first. A chroot is enough, because a container judges one submission."""
ROOT_ONLY = ("source", "submission", "submission_metadata.json", "run_autograder")
NOT_WRITABLE = (".", "results")


class IsolationFailed(Exception):
    """Users other than root could access tests, seed or results; instructors see the message."""


def restrict_access(root: Path) -> None:
    """Restrict access to Gradescope's folders, and verify the permissions.

    Parameters
    ----------
    root : pathlib.Path
        Folder that contains ``source``, ``submission`` and ``results``.

    Raises
    ------
    IsolationFailed
        If the process is not run by root, or if the permissions cannot be changed.
    """
    if os.geteuid() != 0:
        raise IsolationFailed(
            "This autograder must run as root, as on Gradescope. Otherwise, student code would "
            "run as the same user as the judge. Do not change setup.sh or run_autograder."
        )
    for names, forbidden_bits in ((ROOT_ONLY, 0o077), (NOT_WRITABLE, 0o022)):
        for path in filter(os.path.lexists, (root / name for name in names)):
            _restrict(path, forbidden_bits)


def _restrict(path: Path, forbidden_bits: int) -> None:
    try:
        os.chown(path, 0, 0, follow_symlinks=False)
        path.chmod(stat.S_IMODE(path.lstat().st_mode) & ~forbidden_bits)
    except OSError as error:
        raise IsolationFailed(f"{path} cannot be protected: {error.strerror}.") from None
    status = path.lstat()
    if status.st_uid or status.st_mode & forbidden_bits or stat.S_ISLNK(status.st_mode):
        raise IsolationFailed(f"{path} can still be read by users other than root.")


def strongest_sandbox() -> Sandbox:
    """Return the strongest sandbox that works on this machine.

    Raises
    ------
    grader.sandbox.SandboxUnavailable
        If none of them works.
    """
    complaints = []
    for name in PREFERRED_SANDBOXES:
        try:
            SANDBOXES[name].check_available()
        except SandboxUnavailable as error:
            # Show only the reason, because the error's advice is to grade without a sandbox.
            complaints.append(f"{name}: {error.reason}")
        else:
            return SANDBOXES[name]
    raise SandboxUnavailable(
        "Student code was not run, because it cannot be isolated from tests, seed and results "
        "here. Grade on your own machine, and enter the marks with `python -m "
        "grader export --format gradescope`.\n" + "\n".join(complaints)
    )
