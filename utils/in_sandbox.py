"""The part of `utils` that works in the grader's sandbox; every other name does nothing there.

Functions of a notebook may read clouds while they are judged. Checks run outside the sandbox, and
plots are not needed.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

__all__ = ["load_cloud", "read_cloud"]

INSTALLED = ("numpy", "scipy", "matplotlib", "shapely", "scikit-learn", "tqdm")
"""Packages that every answer may use, by their names on PyPI; a lesson may forbid parts of them."""

ABSENT = (
    "the judge provides only Python itself, NumPy, SciPy, Matplotlib, Shapely, scikit-learn and "
    "tqdm"
)
"""Reason why a module is missing, for messages of `check` and of the judge."""

CALL_SECONDS = 10.0
"""Seconds of work after which the judge stops an answer."""

PACKAGES = ("clouds",)
"""Packages of `utils` that student code can import in the sandbox."""

DATA = Path(__file__).resolve().parent.parent / "data"
FILES = tuple(sorted(DATA.glob("*.txt")))
"""Files that student code can read in the sandbox."""


def load_cloud(name: str | os.PathLike = "cloud.txt") -> np.ndarray:
    """Read a cloud from the working folder or the course, like `utils.load_cloud`."""
    path = Path(name).expanduser()
    return read_cloud(path if os.path.exists(path) else DATA / path)


def read_cloud(path: str | os.PathLike) -> np.ndarray:
    """Read a cloud, like `utils.read_cloud`."""
    from utils.clouds import read_cloud

    return read_cloud(path)
