"""Before a line of a student's runs: tests, seed and results are out of reach, or nothing runs."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from grader.sandbox import SANDBOXES, Sandbox, SandboxUnavailable

KINDS = ("bubblewrap", "chroot")
"""Of walls, the thickest first. One container judges one student's work, and ends."""
OURS_ALONE = ("source", "submission", "submission_metadata.json", "run_autograder")
NEVER_THEIRS = (".", "results")


class NotClosed(Exception):
    """Somebody else than root could come at tests, seed or results; `str()` says what to do."""


def close(root: Path) -> None:
    """Shut everybody but root out of what lies in Gradescope's folder, and look whether that holds.

    Parameters
    ----------
    root : pathlib.Path
        With ``source``, ``submission`` and ``results``.

    Raises
    ------
    NotClosed
    """
    if os.geteuid() != 0:
        raise NotClosed(
            "This autograder must be run by root, as Gradescope does: else student code would be "
            "the same user as what judges it. Leave setup.sh and run_autograder as they are."
        )
    for names, shut_off in ((OURS_ALONE, 0o077), (NEVER_THEIRS, 0o022)):
        for path in filter(os.path.lexists, (root / name for name in names)):
            _shut(path, shut_off)


def _shut(path: Path, shut_off: int) -> None:
    try:
        os.chown(path, 0, 0, follow_symlinks=False)
        path.chmod(stat.S_IMODE(path.lstat().st_mode) & ~shut_off)
    except OSError as error:
        raise NotClosed(f"{path} cannot be closed to others: {error.strerror}.") from None
    now = path.lstat()
    if now.st_uid or now.st_mode & shut_off or stat.S_ISLNK(now.st_mode):
        raise NotClosed(f"{path} stays open to others than root.")


def walls_here() -> Sandbox:
    """The thickest walls that can be built here.

    Raises
    ------
    grader.sandbox.SandboxUnavailable
        If there are none.
    """
    complaints = []
    for name in KINDS:
        try:
            SANDBOXES[name].available()
        except SandboxUnavailable as error:
            # Trust is no way out here.
            complaints.append(f"{name}: {str(error).split(' Student code')[0]}")
        else:
            return SANDBOXES[name]
    raise SandboxUnavailable(
        "No walls can be built here between student code and tests, seed and results, so no "
        "student code is run. Grade on a machine of your own, and hand out the marks with "
        "`python -m grader export --format gradescope`.\n" + "\n".join(complaints)
    )
