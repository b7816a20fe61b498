"""Pages on which lessons run in the browser, with JupyterLite and a Pyodide kernel.

The site contains the pages, but not the kernel and its packages, because no package registry
offers NumPy for this kernel. The browser fetches the kernel and its packages from jsDelivr, and
ipywidgets from PyPI.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from grader.course.lessons import Lesson, every_lesson
from grader.course.standalone import make_standalone
from grader.site.errors import SiteError

FOLDER = "live"
EXTENSIONS = ("@jupyterlite/pyodide-kernel-extension", "@jupyter-widgets/jupyterlab-manager")
"""JupyterLab extensions that work without a server."""
WIDGETS = {
    "cell_type": "code",
    "id": "browser",
    "metadata": {"tags": ["raises-exception"]},
    "execution_count": None,
    "outputs": [],
    "source": ["# For sliders. Without a network they do not move, but the lesson still works.\n"]
    + ["%pip install -q ipywidgets"],
}


def address_of(lesson: Lesson) -> str:
    """Return the address, relative to the site's root, of the page on which a lesson runs."""
    return f"{FOLDER}/notebooks/index.html?path={lesson.name}.ipynb"


def notebook_of(lesson: Lesson) -> bytes:
    """Build a lesson's standalone notebook for the kernel in the browser."""
    content = json.loads(make_standalone(lesson.released.read_bytes()))
    setup = next(
        number
        for number, cell in enumerate(content["cells"])
        if "setup" in cell["metadata"].get("tags", ())
    )
    content["cells"].insert(setup, WIDGETS)
    content["metadata"]["kernelspec"] = {
        "display_name": "Python (Pyodide)",
        "language": "python",
        "name": "python",
    }
    return json.dumps(content, ensure_ascii=False, sort_keys=True).encode()


def write_live(pages: Path, folder: Path) -> None:
    """Write the pages on which lessons run.

    Parameters
    ----------
    pages : pathlib.Path
        Folder of the site. The pages go to its folder `live`.
    folder : pathlib.Path
        Empty working folder.

    Raises
    ------
    SiteError
        If JupyterLite fails.
    """
    (folder / "contents").mkdir(parents=True)
    for lesson in every_lesson():
        (folder / "contents" / f"{lesson.name}.ipynb").write_bytes(notebook_of(lesson))
    labextensions = Path(sys.prefix, "share", "jupyter", "labextensions")
    settings = {
        "contents": ["contents"],
        "output_dir": str(pages / FOLDER),
        "apps": ["notebooks", "lab"],
        "ignore_sys_prefix": ["federated_extensions"],
        "federated_extensions": [str(labextensions / name) for name in EXTENSIONS],
        "no_sourcemaps": True,
        "no_unused_shared_packages": True,
    }
    (folder / "jupyter_lite_config.json").write_text(json.dumps({"LiteBuildConfig": settings}))
    process = subprocess.run(
        [sys.executable, "-m", "jupyterlite_core", "build"],
        cwd=folder,
        capture_output=True,
        text=True,
    )
    if process.returncode:
        raise SiteError(f"JupyterLite ended with {process.returncode}:\n{process.stderr[-3000:]}")
