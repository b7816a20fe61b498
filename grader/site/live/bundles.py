"""Bundle the browser's scripts with two packages from npm: an editor, and a shim for WASI."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from grader.site.errors import SiteError

BROWSER = Path(__file__).parent / "browser"
BUNDLED = ("editor.js", "worker.js")
PINS = ("package.json", "package-lock.json")


def scripts(folder: Path) -> dict[str, bytes]:
    """Return the scripts of the pages by name.

    Parameters
    ----------
    folder : pathlib.Path
        Folder into which npm installs; it is kept for the next build.

    Raises
    ------
    SiteError
        If npm is missing or fails.
    """
    _install(folder)
    modules = folder / "node_modules"
    files = {"live.js": (BROWSER / "live.js").read_bytes()}
    for name in BUNDLED:
        command = [modules / ".bin" / "esbuild", BROWSER / name, "--bundle", "--minify"]
        files[name] = _run([*command, "--format=iife", "--charset=utf8"], NODE_PATH=str(modules))
    return files


def _install(folder: Path) -> None:
    """Install the pinned packages, unless they are installed already."""
    ready = folder / "node_modules" / ".bin" / "esbuild"
    pins = {name: (BROWSER / name).read_bytes() for name in PINS}
    if ready.exists() and all((folder / name).read_bytes() == pins[name] for name in PINS):
        return
    if shutil.which("npm") is None:
        raise SiteError("`site --live` needs npm. Run: sudo apt-get install npm")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in pins.items():
        (folder / name).write_bytes(content)
    _run(["npm", "ci", "--prefix", folder, "--ignore-scripts", "--no-audit", "--no-fund"])


def _run(command: list[str | Path], **env: str) -> bytes:
    process = subprocess.run(
        [str(part) for part in command], env=os.environ | env, capture_output=True
    )
    if process.returncode:
        raise SiteError(f"{command[0]} failed:\n{process.stderr.decode()[-3000:]}")
    return process.stdout
