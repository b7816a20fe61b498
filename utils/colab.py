"""What Google Colab lacks, installed beside what it has.

Colab brings NumPy, SciPy, matplotlib, IPython and ipywidgets in versions that its own machinery
relies on. A notebook of the course runs with these; only `utils.scene3d` wants more.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

PYVISTA = ("pyvista==0.49.1", "vtk==9.7.2")  # as in requirements-3d.txt


def in_colab() -> bool:
    """Whether this is a notebook in Google Colab."""
    return "google.colab" in sys.modules


def install_pyvista() -> str:
    """Install PyVista, and change nothing that is there.

    Returns
    -------
    str
        What kept it from being installed, in pip's words; empty when nothing did.
    """
    print("Installing PyVista, once in a session: about half a minute.", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(pip_install(Path(folder)), capture_output=True, text=True)
    importlib.invalidate_caches()
    errors = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
    return "" if done.returncode == 0 else (errors or [f"pip ended with {done.returncode}"])[-1]


def pip_install(folder: Path) -> list[str]:
    """The command of pip, with a file in `folder` that holds every installed version in place."""
    # Of two copies Python takes the one that comes first, so that one has to come last here.
    installed = {found.name: found.version for found in reversed([*metadata.distributions()])}
    constraints = folder / "constraints.txt"
    constraints.write_text("".join(f"{name}=={version}\n" for name, version in installed.items()))
    return [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "--constraint",
        str(constraints),
        *PYVISTA,
    ]
