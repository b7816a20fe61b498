"""Build a root directory for `chroot` that contains only the files that a worker may see.

No mounts are needed. The files are hard links, which take no space, or copies if the folder is on
another disk.
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
    SHOWN_PATHS,
    files_of_packages,
    folders_of_modules,
    folders_of_packages,
)

# Devices that programs expect on every system, with their minor numbers; see null(4), random(4).
DEVICES = {"null": 3, "zero": 5, "full": 7, "random": 8, "urandom": 9}
HOME = "/tmp"
WRITABLE_FOLDERS = (HOME, "/dev/shm")
# Parts of Python's library that are not shown: installed packages (the boundary lists the ones that
# are shown), Python's own tests, and graphical programs.
OMITTED_FOLDERS = ("site-packages", "dist-packages", "test", "idlelib", "tkinter", "turtledemo")

_waiting_processes: list[subprocess.Popen] = []


def build(
    packages: Iterable[str] = (), forbidden: Iterable[str] = (), parent: Path | None = None
) -> Path:
    """Create a folder that can be the root directory of a worker.

    Parameters
    ----------
    packages, forbidden : iterable of str
        As for `grader.sandbox.protocol.Sandbox.start`.
    parent : pathlib.Path, optional
        Parent folder, which must be accessible to root alone. The new folder is not deleted. By
        default, the new folder is in a temporary folder and is deleted when this process ends.

    Raises
    ------
    OSError
        If this process does not have the necessary permissions.
    """
    jail = Path(tempfile.mkdtemp(dir=parent or _folder_of_jails()))
    jail.chmod(0o755)
    packages = tuple(packages)
    hidden = {*folders_of_modules(forbidden, packages), *folders_of_packages()}
    shown = (*_python_paths(), *_library_paths(), *SHOWN_PATHS, *files_of_packages(packages))
    for path in shown:
        _show(path, jail, hidden)
    (jail / "dev").mkdir(exist_ok=True)
    for name, number in DEVICES.items():
        os.mknod(jail / "dev" / name, stat.S_IFCHR | 0o666, os.makedev(1, number))
        os.chmod(jail / "dev" / name, 0o666)  # mknod applies the umask of this process
    return jail


def reset_writable_folders(jail: Path, user: int) -> None:
    """Empty the folders of a jail that a worker can write to, and make a user their owner."""
    for name in WRITABLE_FOLDERS:
        folder = jail / name.lstrip("/")
        # `rm` is used because student code may nest folders beyond Python's recursion limit.
        subprocess.run(["rm", "-rf", "--", folder], check=True)
        folder.mkdir(mode=0o700)
        os.chown(folder, user, user)


@functools.cache
def _folder_of_jails() -> str:
    """Return a folder that only root can enter and that is deleted when this process ends."""
    folder = tempfile.mkdtemp(prefix="jails-")
    # The shell waits until its input closes, which happens even if this process is killed.
    command = ["/bin/sh", "-c", 'read line; rm -rf -- "$0"', folder]
    _waiting_processes.append(
        subprocess.Popen(command, stdin=subprocess.PIPE, start_new_session=True)
    )
    return folder


def _python_paths() -> Iterator[Path]:
    """Yield the paths of the running Python, its library, and the system files that both need."""
    yield Path(PYTHON)
    yield Path(PREFIX, "pyvenv.cfg")
    library = Path(sysconfig.get_path("stdlib"))
    yield from (path for path in library.iterdir() if path.name not in OMITTED_FOLDERS)
    if sysconfig.get_config_var("Py_ENABLE_SHARED"):  # ldconfig does not always list this library
        yield Path(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("INSTSONAME"))
    yield Path("/usr/lib/locale/C.utf8")
    yield Path("/etc/ld.so.cache")
    yield Path("/bin/sh")


def _library_paths() -> Iterator[Path]:
    """Yield the system's shared libraries and the program loaders."""
    listing = subprocess.run(["/sbin/ldconfig", "-p"], capture_output=True, text=True, check=True)
    for path in sorted(set(re.findall(r" => (/.*)$", listing.stdout, re.M))):
        yield Path(path)
    for folder in map(Path, ("/lib", "/lib64")):  # programs expect their loader at this path
        yield from folder.glob("ld-*.so*")


def _show(path: Path, jail: Path, hidden: Container[Path]) -> None:
    """Link a file or folder into a jail at the same path, including targets of symbolic links.

    Hidden folders are left out.
    """
    if path in hidden or not path.exists():
        return
    for above in reversed(path.parents):
        if above.is_symlink():
            _link(above, _path_in_jail(above, jail))
    place = _path_in_jail(path, jail)
    if path.is_symlink():
        _link(path, place)
        _show(Path(os.path.normpath(path.parent / path.readlink())), jail, hidden)
    elif path.is_dir():
        _show_folder(path, place, jail, hidden)
    else:
        _link(path, place)


def _path_in_jail(path: Path, jail: Path) -> Path:
    """Return the location of a path in a jail, and create its parent folder.

    Symbolic links in the path of the parent folder are resolved.
    """
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
    """Link or copy a file or symbolic link to a path, unless the path already exists."""
    try:
        os.link(path, place, follow_symlinks=False)
    except FileExistsError:
        return
    except OSError:  # on another disk, or on a file system without hard links
        shutil.copy(path, place, follow_symlinks=False)
