"""A folder that holds what a worker is shown, and nothing else: its root, where nothing mounts.

Of files there are links, which take no room, or copies where the folder lies on another disk.
"""

from __future__ import annotations

import functools
import os
import re
import shutil
import stat
import subprocess
import sysconfig
import tempfile
from collections.abc import Container, Iterable, Iterator
from pathlib import Path

from grader.sandbox.boundary import (
    PREFIX,
    PYTHON,
    SHOWN,
    files_of_packages,
    folders_of_modules,
    folders_of_packages,
)

# What every system has, and programs take for granted: name, and its number (null(4), random(4)).
DEVICES = {"null": 3, "zero": 5, "full": 7, "random": 8, "urandom": 9}
HOME = "/tmp"
OPEN = (HOME, "/dev/shm")
# Of Python's library: what is installed beside it, its own tests, its windows.
LEFT_OUT = ("site-packages", "dist-packages", "test", "idlelib", "tkinter", "turtledemo")

_waiting: list[subprocess.Popen] = []


def build(
    packages: Iterable[str] = (), forbidden: Iterable[str] = (), within: Path | None = None
) -> Path:
    """Make a folder that can be the root of a worker.

    Parameters
    ----------
    packages, forbidden : iterable of str
        As for `grader.sandbox.protocol.Sandbox.start`.
    within : pathlib.Path, optional
        Where it stays, and only root can enter; by default it ends with this process.

    Raises
    ------
    OSError
        If this process may not.
    """
    jail = Path(tempfile.mkdtemp(dir=within or _folder_of_jails()))
    jail.chmod(0o755)
    packages = tuple(packages)
    hidden = {*folders_of_modules(forbidden, packages), *folders_of_packages()}
    shown = (*_python(), *_libraries(), *SHOWN, *files_of_packages(packages))
    for path in shown:
        _show(path, jail, hidden)
    (jail / "dev").mkdir(exist_ok=True)
    for name, number in DEVICES.items():
        os.mknod(jail / "dev" / name, stat.S_IFCHR | 0o666, os.makedev(1, number))
        os.chmod(jail / "dev" / name, 0o666)  # whatever the mask of this process
    return jail


def give(jail: Path, user: int) -> None:
    """Put empty folders into a jail, which a user alone can write to."""
    for name in OPEN:
        folder = jail / name.lstrip("/")
        # What a stranger has put there may lie deeper than Python can go.
        subprocess.run(["rm", "-rf", "--", folder], check=True)
        folder.mkdir(mode=0o700)
        os.chown(folder, user, user)


@functools.cache
def _folder_of_jails() -> str:
    """A folder that only root can enter, for the life of this process, however that ends."""
    folder = tempfile.mkdtemp(prefix="jails-")
    # Nobody writes to it: its input closes with this process.
    waits = ["/bin/sh", "-c", 'read line; rm -rf -- "$0"', folder]
    _waiting.append(subprocess.Popen(waits, stdin=subprocess.PIPE, start_new_session=True))
    return folder


def _python() -> Iterator[Path]:
    """Python as it runs here, with its library."""
    yield Path(PYTHON)
    yield Path(PREFIX, "pyvenv.cfg")
    library = Path(sysconfig.get_path("stdlib"))
    yield from (path for path in library.iterdir() if path.name not in LEFT_OUT)
    if sysconfig.get_config_var("Py_ENABLE_SHARED"):  # perhaps not among the system's libraries
        yield Path(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("INSTSONAME"))
    yield Path("/usr/lib/locale/C.utf8")
    yield Path("/etc/ld.so.cache")
    yield Path("/bin/sh")


def _libraries() -> Iterator[Path]:
    """Those of the system that any program finds, and what loads them."""
    known = subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True, text=True, check=True)
    for path in sorted(set(re.findall(r" => (/.*)$", known.stdout, re.M))):
        yield Path(path)
    for folder in map(Path, ("/lib", "/lib64")):  # where programs say that their loader is
        yield from folder.glob("ld-*.so*")


def _show(path: Path, jail: Path, hidden: Container[Path]) -> None:
    """Put a file or folder where it is outside, less some folders; and what links lead to."""
    if path in hidden or not path.exists():
        return
    for above in reversed(path.parents):
        if above.is_symlink():
            _link(above, _place(above, jail))
    place = _place(path, jail)
    if path.is_symlink():
        _link(path, place)
        _show(Path(os.path.normpath(path.parent / path.readlink())), jail, hidden)
    elif path.is_dir():
        _show_folder(path, place, jail, hidden)
    else:
        _link(path, place)


def _place(path: Path, jail: Path) -> Path:
    """Where a path is in a jail: below what its folder truly is."""
    place = jail / path.parent.resolve().relative_to("/") / path.name
    place.parent.mkdir(parents=True, exist_ok=True)
    return place


def _show_folder(folder: Path, place: Path, jail: Path, hidden: Container[Path]) -> None:
    place.mkdir(exist_ok=True)
    for entry in os.scandir(folder):
        path = folder / entry.name
        if entry.is_symlink():
            _show(path, jail, hidden)
        elif not entry.is_dir():
            _link(path, place / entry.name)
        elif path not in hidden and entry.name != "__pycache__":
            _show_folder(path, place / entry.name, jail, hidden)


def _link(path: Path, place: Path) -> None:
    """Put a file, or a link as it is, into a place, where it is not there yet."""
    try:
        os.link(path, place, follow_symlinks=False)
    except FileExistsError:
        return
    except OSError:  # another disk, or one that has no links
        shutil.copy(path, place, follow_symlinks=False)
