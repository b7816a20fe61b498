"""What a test needs of the machine and of the user: without it, skip; where CI demands it, fail."""

import os
from pathlib import Path
from typing import NoReturn

import pytest

from grader.sandbox import Sandbox, SandboxUnavailable, bwrap, choose_sandbox

# Reasons to skip: what is missing, and how to get it. `make test` prints them at its end.
RECORDINGS = "recorded scans: REAL_CLOUDS=FOLDER make test"
CHROMIUM = "Chromium: sudo apt-get install chromium"
MATHJAX = "Chromium and MathJax: sudo apt-get install chromium libjs-mathjax"
PDF_TO_TEXT = "Chromium and pdftotext: sudo apt-get install chromium poppler-utils"
NUMBA = "Numba: .venv/bin/pip install -r requirements-compiled.txt"
FFMPEG = "ffmpeg: .venv/bin/pip install -r requirements-3d.txt"
ROOT = "root: sudo make test"

# Seconds in which something happens on any machine, however busy. Waiting ends when it does.
PATIENCE = 300


def not_here(reason: object) -> NoReturn:
    """Skip the test; fail it where the environment says ``REQUIRE_SANDBOX=1``."""
    if os.environ.get("REQUIRE_SANDBOX") == "1":
        pytest.fail(f"REQUIRE_SANDBOX=1, but: {reason}", pytrace=False)
    pytest.skip(str(reason))


def demand_walls(name: str = "bubblewrap") -> Sandbox:
    """The sandbox for strangers' code."""
    try:
        return choose_sandbox(name)
    except SandboxUnavailable as reason:
        # The rest tells whoever grades.
        not_here(f"a sandbox: {str(reason).partition(' Student code')[0]}")


def without_bubblewrap(folder: Path) -> dict[str, str]:
    """Variables with which a process finds no bubblewrap: no program, and a wheel without files."""
    wheel = folder / f"{bwrap.WHEEL.replace('-', '_')}-0.dist-info"
    wheel.mkdir()
    (wheel / "METADATA").write_text(f"Name: {bwrap.WHEEL}\nVersion: 0\n")
    return {"PATH": str(folder), "PYTHONPATH": str(folder)}
