"""Install PyVista in Google Colab without changing the packages already there.

Colab comes with NumPy, SciPy, matplotlib, IPython and ipywidgets, in versions that Colab itself
relies on. The course's notebooks run with these versions. Only `utils.scene3d` needs PyVista.
"""

from __future__ import annotations

import importlib
import subprocess
import sys
import tempfile
from importlib import metadata
from pathlib import Path

PYVISTA = ("pyvista==0.49.1", "vtk==9.7.2")  # the same versions as in requirements-3d.txt


def in_colab() -> bool:
    """Return whether this is a notebook in Google Colab."""
    return "google.colab" in sys.modules


def install_pyvista() -> str:
    """Install PyVista without changing any installed package.

    Returns
    -------
    str
        pip's error message; empty if the installation succeeded.
    """
    print("Installing PyVista. This takes half a minute, once per session.", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        pip = subprocess.run(pip_command(Path(folder)), capture_output=True, text=True)
    importlib.invalidate_caches()
    errors = [line for line in pip.stderr.splitlines() if line.startswith("ERROR")]
    return (
        "" if pip.returncode == 0 else (errors or [f"pip exited with status {pip.returncode}"])[-1]
    )


def pip_command(folder: Path) -> list[str]:
    """Write constraints with all installed versions into `folder`, and return the pip command."""
    # Python imports the first of two copies of a package. In a dict the last entry wins, so the
    # distributions are read in reverse.
    installed = {dist.name: dist.version for dist in reversed([*metadata.distributions()])}
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
