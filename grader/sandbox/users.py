"""Unused user IDs: if root grades, each worker becomes a user of its own."""

import os
import secrets
from pathlib import Path


def is_root() -> bool:
    """Return whether this is root and can become other users; some containers have no others."""
    return os.geteuid() == 0 and _user_count() >= 2**16


def unused() -> int:
    """Return a random unused user ID; limits are counted by user and do not bind root."""
    count = _user_count()
    return count // 2 + secrets.randbelow(count // 2 - 2)


def _user_count() -> int:
    first, _, count = map(int, Path("/proc/self/uid_map").read_text().splitlines()[0].split())
    return count if first == 0 else 0
