"""Requirements of tests. If one is missing, the test is skipped, or fails if CI requires it."""

import os
from pathlib import Path
from typing import NoReturn

import pytest

from grader.sandbox import Sandbox, SandboxUnavailable, bubblewrap_program, choose_sandbox

# Reasons to skip a test: what is missing, and how to get it. `make test` prints them at the end.
RECORDINGS = "recorded scans: REAL_CLOUDS=FOLDER make test"
CHROMIUM = "Chromium: sudo apt-get install chromium"
MATHJAX = "Chromium and MathJax: sudo apt-get install chromium libjs-mathjax"
PDF_TO_TEXT = "Chromium and pdftotext: sudo apt-get install chromium poppler-utils"
LIBRARIES = "other libraries that read clouds: .venv/bin/pip install -r requirements-proof.txt"
NUMBA = "Numba: .venv/bin/pip install -r requirements-compiled.txt"
FFMPEG = "ffmpeg: .venv/bin/pip install -r requirements-3d.txt"
RERUN = "Rerun: .venv/bin/pip install -r requirements-viewers.txt"
ROOT = "root: sudo make test"

# Seconds within which an event must happen, even on a very busy machine.
PATIENCE = 300


def skip_or_fail(reason: object) -> NoReturn:
    """Skip the test, or fail it if the environment contains ``REQUIRE_SANDBOX=1``."""
    if os.environ.get("REQUIRE_SANDBOX") == "1":
        pytest.fail(f"REQUIRE_SANDBOX=1, but: {reason}", pytrace=False)
    pytest.skip(str(reason))


def require_sandbox(name: str = "bubblewrap") -> Sandbox:
    """Return the sandbox for untrusted code, or skip the test."""
    try:
        return choose_sandbox(name)
    except SandboxUnavailable as reason:
        # The rest of the message is advice for graders.
        skip_or_fail(f"a sandbox: {str(reason).partition(' Student code')[0]}")


def without_bubblewrap(folder: Path) -> dict[str, str]:
    """Return environment variables that hide bubblewrap, both the program and the wheel."""
    wheel = folder / f"{bubblewrap_program.WHEEL.replace('-', '_')}-0.dist-info"
    wheel.mkdir()
    (wheel / "METADATA").write_text(f"Name: {bubblewrap_program.WHEEL}\nVersion: 0\n")
    return {"PATH": str(folder), "PYTHONPATH": str(folder)}
