"""The security boundary: the list of files that student code can see.

Student code sees the parts of this project in `SHOWN_PATHS`, the installed packages that its lesson
allows and their dependencies, and the system's libraries. All other files are hidden, such as
tests, checks, solutions, grades and other submissions. New files and packages are also hidden,
unless they are in a listed folder. `grader.sandbox.bubblewrap` and `grader.sandbox.jail` build
sandboxes from this list.
"""

from __future__ import annotations

import functools
import os
import re
import sys
import sysconfig
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from grader.course.paths import PROJECT
from utils import in_sandbox

INSIDE_FOLDER = Path(__file__).resolve().parent / "inside"
WORKER_SCRIPT = INSIDE_FOLDER / "worker.py"
# `utils.notebooks` is shown because the worker uses its slicer.
SHOWN_PATHS = (
    INSIDE_FOLDER,
    PROJECT / "utils" / "notebooks",
    Path(in_sandbox.__file__),
    *(PROJECT / "utils" / name for name in in_sandbox.PACKAGES),
    *in_sandbox.FILES,
)
# Packages that the worker always needs: NumPy for arrays, and IPython to parse magics.
REQUIRED_PACKAGES = ("numpy", "ipython")

# The path of a virtual environment may contain "..", which `abspath` removes.
PYTHON = os.path.abspath(sys.executable)
PREFIX, BASE_PREFIX = os.path.abspath(sys.prefix), os.path.abspath(sys.base_prefix)
SYSTEM_FOLDERS = ("/usr",)
# Folders in the system folders that are hidden. This one is nbgrader's default exchange, whose
# submissions the instructor's account can read. Otherwise student code could read them as well.
HIDDEN_SYSTEM_FOLDERS = ("/usr/local/share/nbgrader",)


@functools.cache
def files_of_packages(names: tuple[str, ...]) -> tuple[Path, ...]:
    """Return the top-level files and folders of some packages and of all their dependencies.

    Parameters
    ----------
    names : tuple of str
        Names of packages on PyPI. Packages that are not installed are left out.
    """
    found, waiting, seen = [], [*names, *REQUIRED_PACKAGES], set()
    while waiting:
        name = re.sub(r"[-_.]+", "-", waiting.pop()).lower()
        if name in seen:
            continue
        seen.add(name)
        try:
            package = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue
        # Reading RECORD is ten times as fast as `package.files`.
        record = (package.read_text("RECORD") or "").splitlines()
        tops = {re.split("[/,]", line, maxsplit=1)[0] for line in record} - {"..", "__pycache__"}
        # The sandbox does not need pip's metadata, and each mount costs time.
        tops = {top for top in tops if not top.endswith(".dist-info")}
        found += [Path(os.path.abspath(package.locate_file(top))) for top in sorted(tops)]
        waiting += [
            re.match(r"[\w.-]+", requirement)[0]
            for requirement in package.requires or ()
            if "extra ==" not in requirement
        ]
    return tuple(dict.fromkeys(path for path in found if path.exists()))


@functools.cache
def folders_of_packages() -> tuple[Path, ...]:
    """Return the folders in which the Python installations in the sandbox look for packages."""
    libraries = [
        Path(root, name)
        for root in (PREFIX, BASE_PREFIX, *SYSTEM_FOLDERS, "/usr/local")
        for name in ("lib", "lib64")
    ]
    folders = [
        folder
        for library in libraries
        if not library.is_symlink()
        for folder in library.glob("python*/*-packages")
    ]
    folders.append(Path(os.path.abspath(sysconfig.get_path("purelib"))))
    return tuple(dict.fromkeys(folder for folder in folders if folder.is_dir()))


def folders_of_modules(modules: Iterable[str], packages: tuple[str, ...]) -> list[Path]:
    """Return the folders of the modules that belong to the given packages."""
    shown = files_of_packages(packages)
    folders = [
        folder / module.replace(".", "/") for module in modules for folder in folders_of_packages()
    ]
    return [
        folder
        for folder in folders
        if folder.is_dir() and any(folder.is_relative_to(path) for path in shown)
    ]


def is_shown(path: Path, packages: Iterable[str] = ()) -> bool:
    """Return whether the sandbox shows a file if a lesson allows the given packages."""
    roots = (*SYSTEM_FOLDERS, BASE_PREFIX, *SHOWN_PATHS, *files_of_packages(tuple(packages)))
    return any(path.is_relative_to(root) for root in roots)
