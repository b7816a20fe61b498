"""Choose unused user IDs: if root runs the grader, each worker runs as a separate user."""

import os
import secrets
from pathlib import Path


def is_root() -> bool:
    """Return whether this process is root and other user IDs exist, unlike in some containers."""
    return os.geteuid() == 0 and _user_count() >= 2**16


def unused_user_id() -> int:
    """Return a random user ID from the upper half of all IDs, which is rarely used.

    The kernel counts processes separately for each user, and does not limit those of root.
    """
    count = _user_count()
    return count // 2 + secrets.randbelow(count // 2 - 2)


def _user_count() -> int:
    first, _, count = map(int, Path("/proc/self/uid_map").read_text().splitlines()[0].split())
    return count if first == 0 else 0
