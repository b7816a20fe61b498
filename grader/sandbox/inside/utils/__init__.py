"""The package `utils` in the sandbox: the names of `utils.in_sandbox`, and stand-ins.

A notebook imports `check`, `plots` and more, and its functions may call them. The sandbox does not
show plots, and checks run outside it. Names that are not in `utils.in_sandbox` are therefore
stand-ins, which accept every call and do nothing. Only `load_my_functions` raises an error.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import os
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

# Real modules come from the course's `utils`; the sandbox does not contain its other modules.
__path__ = [str(Path(__file__).resolve().parents[4] / "utils")]

from utils import in_sandbox  # noqa: E402

_REAL = tuple(f"utils.{name}." for name in ("in_sandbox", "notebooks", *in_sandbox.PACKAGES))


class StandIn:
    """An object that has every attribute and can be called, entered and iterated."""

    def __getattr__(self, name: str) -> StandIn:
        if name.startswith("__"):
            raise AttributeError(name)
        return StandIn()

    def __call__(self, *arguments: object, **keywords: object) -> StandIn:
        """Return another stand-in."""
        return StandIn()

    def __iter__(self) -> Iterator:
        return iter(())

    def __getitem__(self, key: object) -> StandIn:
        return StandIn()

    def __len__(self) -> int:
        return 0

    def __enter__(self) -> StandIn:
        return self

    def __exit__(self, *error: object) -> None:
        pass


class _StandInFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finder for modules of `utils` that the sandbox lacks; it fills them with stand-ins."""

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for each module of `utils` that the sandbox lacks."""
        if not fullname.startswith("utils.") or f"{fullname}.".startswith(_REAL):
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """Return None to get Python's default module."""

    def exec_module(self, module: types.ModuleType) -> None:
        """Give the module a stand-in for every name."""
        module.__getattr__ = _stand_in


def _stand_in(name: str) -> StandIn:
    if name.startswith("__"):
        raise AttributeError(name)
    return StandIn()


def load_my_functions(name: str | os.PathLike) -> NoReturn:
    """Raise an error, because the sandbox contains only one notebook."""
    raise FileNotFoundError(
        f"There is no notebook {str(name)!r} here. The judge sees only one notebook, so "
        "paste the functions that it needs into that notebook."
    )


def __getattr__(name: str) -> object:
    if name in in_sandbox.PACKAGES:
        return importlib.import_module(f"utils.{name}")
    if name in in_sandbox.__all__:
        return getattr(in_sandbox, name)
    return _stand_in(name)


sys.meta_path.insert(0, _StandInFinder())
