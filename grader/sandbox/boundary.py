"""The one line that must never blur: what a student's code can see.

Of this project what `SHOWN` lists; of the installed packages those that the lesson names and
what these need; and the system's own libraries. It is a list of what is shown: whatever else is
installed, or comes to lie in this project, stays outside. No test, no check, no solution, no
grade, no other submission. `grader.sandbox.bubblewrap` builds the walls from this list.
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

INSIDE = Path(__file__).resolve().parent / "inside"
WORKER = INSIDE / "worker.py"
# The worker runs the slicer in `utils.notebooks` on the notebook.
SHOWN = (
    INSIDE,
    PROJECT / "utils" / "notebooks",
    Path(in_sandbox.__file__),
    *(PROJECT / "utils" / name for name in in_sandbox.PACKAGES),
    *in_sandbox.FILES,
)
# NumPy carries the arrays; IPython reads its own magics.
ALWAYS = ("numpy", "ipython")

# A virtual environment may be named by a path that goes up and down again.
PYTHON = os.path.abspath(sys.executable)
PREFIX, BASE_PREFIX = os.path.abspath(sys.prefix), os.path.abspath(sys.base_prefix)
SYSTEM = ("/usr",)


@functools.cache
def files_of_packages(names: tuple[str, ...]) -> tuple[Path, ...]:
    """Everything that some packages, and what they need, put into ``site-packages``.

    Parameters
    ----------
    names : tuple of str
        As pip calls them. One that is not installed is left out.
    """
    found, waiting, seen = [], [*names, *ALWAYS], set()
    while waiting:
        name = re.sub(r"[-_.]+", "-", waiting.pop()).lower()
        if name in seen:
            continue
        seen.add(name)
        try:
            package = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue
        # Its `files` would say the same in ten times the time.
        record = (package.read_text("RECORD") or "").splitlines()
        tops = {re.split("[/,]", line, maxsplit=1)[0] for line in record} - {"..", "__pycache__"}
        # What pip notes about a package is of no use inside, and each window costs time.
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
    """Every folder in which some Python of what is shown looks for packages."""
    libraries = [
        Path(root, name)
        for root in (PREFIX, BASE_PREFIX, *SYSTEM, "/usr/local")
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
    """Those folders of some modules that would be shown with some packages."""
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
    """True where a file lies in something that every sandbox, or one for a lesson, shows."""
    roots = (*SYSTEM, BASE_PREFIX, *SHOWN, *files_of_packages(tuple(packages)))
    return any(path.is_relative_to(root) for root in roots)
