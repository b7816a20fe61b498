"""What `import` does in here, beside Python's own ways."""

import ast
import importlib.abc
import importlib.machinery
import os
import sys
from collections.abc import Iterable

from utils.notebooks import slicing
from utils.notebooks.forbidden import StandInModule, forbidden_part, refusal


class Forbidden(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Answers the import of a library that would do the exercise with a clear sentence.

    A library that imports it gets something that stands for it: of the code itself nothing comes
    into memory.
    """

    def __init__(self, modules: Iterable[str]) -> None:
        self.modules = tuple(modules)

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Refuse what is forbidden; leave everything else to other finders."""
        if not forbidden_part(fullname, self.modules):
            return None
        if not _a_library_asks():
            raise refusal(fullname)
        # What is not even installed is missing here, too. Of what is hidden the folder is there.
        inside = isinstance(sys.modules.get(fullname.rpartition(".")[0]), StandInModule)
        if inside or importlib.machinery.PathFinder.find_spec(fullname, path):
            return importlib.machinery.ModuleSpec(fullname, self, is_package=True)
        return None

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> StandInModule:
        """What stands for it."""
        return StandInModule(spec.name, forbidden_part(spec.name, self.modules))

    def exec_module(self, module: object) -> None:
        """There is nothing to run."""


def _a_library_asks() -> bool:
    """Whether it is code in a file that wants to import; a student's is in none."""
    frame = sys._getframe(1)
    while frame.f_code.co_filename == __file__ or _is_importlib(frame):
        frame = frame.f_back
    return os.path.isabs(frame.f_code.co_filename)


def _is_importlib(frame: object) -> bool:
    return str(frame.f_globals.get("__name__")).partition(".")[0] == "importlib"


def refuse_imports(tree: ast.AST, modules: Iterable[str]) -> None:
    """Make each statement inside some code raise that imports what is forbidden.

    Else it would find what stands there for libraries.
    """
    for parent in ast.walk(tree):
        for _, content in ast.iter_fields(parent):
            if isinstance(content, list):
                content[:] = [_refused(node, modules) for node in content]


def _refused(node: ast.AST, modules: Iterable[str]) -> ast.AST:
    name = next((name for name in slicing.imported_by(node) if forbidden_part(name, modules)), None)
    if name is None:
        return node
    [statement] = ast.parse(f"raise ImportError({str(refusal(name))!r}, name={name!r})").body
    for part in ast.walk(statement):
        ast.copy_location(part, node)
    return statement


class Beside(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Modules that were handed in beside the notebook; asked last, so they hide nothing."""

    def __init__(self, sources: dict[str, str], forbidden: Iterable[str]) -> None:
        self.sources, self.forbidden = sources, tuple(forbidden)

    def find_spec(
        self, fullname: str, path: object = None, target: object = None
    ) -> importlib.machinery.ModuleSpec | None:
        """A spec for a module that was handed in."""
        if fullname in self.sources:
            return importlib.machinery.ModuleSpec(fullname, self)
        return None

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> None:
        """An ordinary module will do."""

    def exec_module(self, module: object) -> None:
        """Run the source."""
        name = module.__name__
        tree = ast.parse(self.sources[name])
        refuse_imports(tree, self.forbidden)
        exec(compile(tree, f"{name}.py", "exec"), module.__dict__)
