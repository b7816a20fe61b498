"""Import hooks in the sandbox: refuse forbidden modules, and find submitted ones."""

import ast
import importlib.abc
import importlib.machinery
import os
import sys
from collections.abc import Iterable

from utils.notebooks import slicing
from utils.notebooks.forbidden import StandInModule, forbidden_module_of, refusal


class ForbiddenModuleFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finder that refuses to import forbidden modules, with a clear error message.

    If an allowed library imports a forbidden module, it gets a stand-in. The code of a forbidden
    module is therefore never in memory.
    """

    def __init__(self, modules: Iterable[str]) -> None:
        self.modules = tuple(modules)

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Refuse forbidden modules, and leave all others to other finders."""
        if not forbidden_module_of(fullname, self.modules):
            return None
        if not _is_imported_by_library():
            raise refusal(fullname)
        # Only installed modules get a stand-in. The finder also finds hidden modules, because their
        # folders still exist, although they are empty.
        inside = isinstance(sys.modules.get(fullname.rpartition(".")[0]), StandInModule)
        if inside or importlib.machinery.PathFinder.find_spec(fullname, path):
            return importlib.machinery.ModuleSpec(fullname, self, is_package=True)
        return None

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> StandInModule:
        """Return a stand-in module."""
        return StandInModule(spec.name, forbidden_module_of(spec.name, self.modules))

    def exec_module(self, module: object) -> None:
        """Do nothing: a stand-in has no code."""


def _is_imported_by_library() -> bool:
    """Return whether a library does the import: its path is absolute, unlike student code's."""
    frame = sys._getframe(1)
    while frame.f_code.co_filename == __file__ or _is_importlib(frame):
        frame = frame.f_back
    return os.path.isabs(frame.f_code.co_filename)


def _is_importlib(frame: object) -> bool:
    return str(frame.f_globals.get("__name__")).partition(".")[0] == "importlib"


def refuse_imports(tree: ast.AST, modules: Iterable[str]) -> None:
    """Replace each statement that imports a forbidden module with one that raises an error.

    Otherwise student code might get the stand-in that was made for a library.
    """
    for parent in ast.walk(tree):
        for _, content in ast.iter_fields(parent):
            if isinstance(content, list):
                content[:] = [_refuse_statement(node, modules) for node in content]


def _refuse_statement(node: ast.AST, modules: Iterable[str]) -> ast.AST:
    name = next(
        (name for name in slicing.imported_by(node) if forbidden_module_of(name, modules)), None
    )
    if name is None:
        return node
    [statement] = ast.parse(f"raise ImportError({str(refusal(name))!r}, name={name!r})").body
    for part in ast.walk(statement):
        ast.copy_location(part, node)
    return statement


# The sandbox has no widgets, so tqdm's progress bars for notebooks are replaced with its progress
# bars for terminals.
WITHOUT_WIDGETS = {"tqdm.notebook": "from tqdm.std import tqdm, trange"}


class SubmittedModuleFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finder for modules that are given as source, such as those submitted with the notebook."""

    def __init__(self, sources: dict[str, str], forbidden: Iterable[str]) -> None:
        self.sources, self.forbidden = sources, tuple(forbidden)

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for a module whose source is given."""
        if fullname in self.sources:
            return importlib.machinery.ModuleSpec(fullname, self)
        return None

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """Return None to get Python's default module."""

    def exec_module(self, module: object) -> None:
        """Run the module's source; forbidden imports in it raise an error."""
        name = module.__name__
        tree = ast.parse(self.sources[name])
        refuse_imports(tree, self.forbidden)
        exec(compile(tree, f"{name}.py", "exec"), module.__dict__)
