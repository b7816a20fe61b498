"""A stand-in for Google Colab: an environment with Colab's versions, and a web server.

The versions are from Colab in August 2026. Only packages that a notebook can use are installed.
"""

import contextlib
import functools
import hashlib
import http.server
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
import threading
from pathlib import Path

from grader.course.paths import PROJECT

PINS = (
    "numpy==2.1.3",
    "scipy==1.16.3",
    "shapely==2.1.2",
    "matplotlib==3.10.0",
    "ipython==7.34.0",
    "ipykernel==6.17.1",
    "ipywidgets==7.7.1",
)
PYTHONS = ((3, 13), (3, 12))
# Colab's kernel loads this package before the first cell, so the course uses it to detect Colab.
MARK = "import sys, types; sys.modules['google.colab'] = types.ModuleType('google.colab')"
NEEDED_PROGRAMS = ("curl", "tar")  # programs that the setup cell runs


def missing_requirement():
    """Return a sentence that names what this machine lacks, or an empty string."""
    missing = [name for name in NEEDED_PROGRAMS if not shutil.which(name)]
    if sys.platform != "linux" or missing:
        return f"Linux with {' and '.join(NEEDED_PROGRAMS)}: sudo apt-get install curl tar"
    if not find_python():
        return "Python 3.12 or 3.13: install one, or make test PYTHON=python3.13"
    return ""


@functools.cache
def find_python():
    """Return a Python of Colab's version: this one, or one on PATH or in pyenv; None if missing."""
    if sys.version_info[:2] in PYTHONS:
        return sys.executable
    pyenv = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for major, minor in PYTHONS:
        candidates = [
            shutil.which(f"python{major}.{minor}"),
            *sorted(pyenv.glob(f"{major}.{minor}.*/bin/python")),
        ]
        for path in filter(None, candidates):
            program = "import ensurepip, sys, venv; print(*sys.version_info[:2])"
            done = subprocess.run([path, "-c", program], capture_output=True, text=True)
            # pyenv may have shims for versions that are not installed.
            if done.stdout.split() == [str(major), str(minor)]:
                return str(path)
    return None


def environment(cache):
    """Create the environment below the folder `cache`, unless an earlier run has created it.

    Returns
    -------
    pathlib.Path
        Folder of the environment.
    """
    import fcntl

    version = subprocess.run([find_python(), "-VV"], capture_output=True, text=True).stdout
    key = hashlib.sha256(repr((PINS, MARK, version)).encode()).hexdigest()[:12]
    folder = Path(cache) / key
    with open(Path(cache) / f"{key}.lock", "w") as lock:  # pytest-xdist runs several processes
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (folder / "complete").exists():
            shutil.rmtree(folder, ignore_errors=True)
            subprocess.run([find_python(), "-m", "venv", folder], check=True)
            subprocess.run(
                [
                    folder / "bin" / "python",
                    "-m",
                    "pip",
                    "install",
                    "--quiet",
                    "--disable-pip-version-check",
                    "--no-compile",
                    *PINS,
                ],
                check=True,
            )
            site = next(folder.glob("lib/python3.*/site-packages"))
            (site / "colab.pth").write_text(MARK + "\n")
            _describe_kernel(folder)
            (folder / "complete").touch()
    return folder


def _describe_kernel(folder):
    """Register the environment as the Jupyter kernel "colab", found with JUPYTER_PATH=`folder`."""
    argv = [
        str(folder / "bin" / "python"),
        "-Xfrozen_modules=off",
        "-m",
        "ipykernel_launcher",
        "-f",
        "{connection_file}",
    ]
    (folder / "kernels" / "colab").mkdir(parents=True)
    (folder / "kernels" / "colab" / "kernel.json").write_text(
        json.dumps({"argv": argv, "display_name": "Colab", "language": "python"})
    )


def archive_of(files, top="lab-main"):
    """Return the bytes of a .tar.gz with all files in one folder, like GitHub's archives.

    Parameters
    ----------
    files : dict of str to bytes
        Content by path.
    top : str
        Name of the folder.
    """
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz", compresslevel=1) as archive:
        for path, content in files.items():
            entry = tarfile.TarInfo(f"{top}/{path}")
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return buffer.getvalue()


def course_files():
    """Return the content of the repository's files by path, except those that are slow to pack."""
    return {
        path.relative_to(PROJECT).as_posix(): path.read_bytes()
        for folder in ("data", "solutions", "utils")
        for path in (PROJECT / folder).rglob("*")
        if path.is_file() and path.suffix in (".py", ".md", ".html", ".js", ".json", ".txt", ".npz")
    }


@contextlib.contextmanager
def served(pages):
    """Serve `pages` (bytes by path) on this machine; yield the address and the requested paths."""
    requests = []

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            requests.append(self.path)
            content = pages.get(self.path)
            self.send_response(404 if content is None else 200)
            self.end_headers()
            self.wfile.write(content or b"")

        def log_message(self, *message):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}", requests
    finally:
        server.shutdown()
        server.server_close()
