"""What student code finds under the name `utils`: readers of clouds, and agreement.

A notebook imports `check`, `plots` and more, and its functions may call them on the way. In here
nobody looks at pictures, and checks are run from outside. So everything but reading clouds agrees
to whatever it is asked, does nothing, and answers no exercise.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

import numpy as np

# What is real comes from the students' own library; nothing else of it is shown in here.
_LIBRARY = Path(__file__).resolve().parents[4] / "utils"
_DATA = _LIBRARY.parent / "data"
_REAL = ("utils.clouds.", "utils.notebooks.")
__path__ = [str(_LIBRARY)]


class Agreeable:
    """Has every attribute, can be called, entered and gone through; it is always another one."""

    def __getattr__(self, name: str) -> Agreeable:
        if name.startswith("__"):
            raise AttributeError(name)
        return Agreeable()

    def __call__(self, *arguments: object, **keywords: object) -> Agreeable:
        """Agree."""
        return Agreeable()

    def __iter__(self) -> Iterator:
        return iter(())

    def __getitem__(self, key: object) -> Agreeable:
        return Agreeable()

    def __len__(self) -> int:
        return 0

    def __enter__(self) -> Agreeable:
        return self

    def __exit__(self, *error: object) -> None:
        pass


class _Everything(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds every module of `utils` that is not real, and fills it with agreement."""

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """A spec for all but what is real."""
        if not fullname.startswith("utils.") or f"{fullname}.".startswith(_REAL):
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """An ordinary module will do."""

    def exec_module(self, module: types.ModuleType) -> None:
        """Let it agree to every name."""
        module.__getattr__ = _agree


def _agree(name: str) -> Agreeable:
    if name.startswith("__"):
        raise AttributeError(name)
    return Agreeable()


def load_cloud(name: str | os.PathLike = "cloud.txt") -> np.ndarray:
    """Read, as `utils.load_cloud` does, a file of the working folder or the course's own cloud."""
    path = Path(name).expanduser()
    return read_cloud(path if os.path.exists(path) else _DATA / path)


def read_cloud(path: str | os.PathLike) -> np.ndarray:
    """Read, as `utils.read_cloud` does."""
    from utils.clouds import read_cloud

    return read_cloud(path)


def load_my_functions(name: str | os.PathLike) -> NoReturn:
    """Say that there is one notebook only."""
    raise FileNotFoundError(
        f"There is no notebook {str(name)!r} here. (The judge sees one notebook only: paste what "
        "it needs into that notebook.)"
    )


def __getattr__(name: str) -> object:
    if name == "clouds":
        import utils.clouds

        return utils.clouds
    return _agree(name)


sys.meta_path.insert(0, _Everything())
