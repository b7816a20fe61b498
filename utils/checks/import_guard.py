"""Block the modules that a lesson forbids while a notebook checks a function.

The judge's sandbox does not have these modules. In a notebook, other libraries may have imported
them, and student code could reach them through those libraries.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from types import BuiltinFunctionType, FunctionType, ModuleType, TracebackType

from utils.notebooks.forbidden import StandIn, StandInModule, forbidden_module_of, make_stand_in

_CYTHON = "cython_function_or_method"


class BlockedModules:
    """Context manager that replaces the contents of some modules with stand-ins everywhere."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._modules, self._prefixes = modules, tuple(f"{module}." for module in modules)
        self._hidden: dict[str, ModuleType] = {}
        self._replaced: list[tuple[dict, str, object]] = []

    def __enter__(self) -> BlockedModules:
        self.hide()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for namespace, name, value in self._replaced:
            if isinstance(namespace.get(name), StandIn | StandInModule):
                namespace[name] = value
        sys.modules.update(self._hidden)
        # Modules imported in the meantime have copied stand-ins into their own namespaces.
        for namespace in _namespaces():
            for name, value in list(namespace.items()):
                if isinstance(value, StandInModule):
                    namespace[name] = sys.modules[value.__name__]
                elif isinstance(value, StandIn):
                    namespace[name] = getattr(sys.modules[value.__module__], value.__name__, value)

    def hide(self) -> bool:
        """Hide the modules that have been imported by now; return whether any of them is new."""
        found = {
            name: module
            for name, module in list(sys.modules.items())
            if isinstance(module, ModuleType)
            and not isinstance(module, StandInModule)
            and f"{name}.".startswith(self._prefixes)
        }
        if not found:
            return False
        self._hidden |= found
        sys.modules.update({name: self._module(name) for name in found})
        for namespace in _namespaces():
            for name, value in list(namespace.items()):
                home = _module_of(value)
                if f"{home}.".startswith(self._prefixes):
                    self._replaced.append((namespace, name, value))
                    namespace[name] = self._stand_in(value, home)
        return True

    def _stand_in(self, value: object, home: str) -> object:
        if isinstance(value, ModuleType):
            return sys.modules.get(home, value)
        return make_stand_in(value.__name__, home, forbidden_module_of(home, self._modules))

    def _module(self, name: str) -> StandInModule:
        module = StandInModule(name, forbidden_module_of(name, self._modules))
        real = vars(self._hidden[name])
        # Python needs the special attributes to import submodules and to link compiled code.
        special = {name for name in real if name.startswith("__")} - {"__getattr__"}
        vars(module).update({name: real[name] for name in special})
        return module


def _namespaces() -> Iterator[dict]:
    """Yield the namespaces of all imported modules except stand-ins."""
    for module in list(sys.modules.values()):
        if isinstance(module, ModuleType) and not isinstance(module, StandInModule):
            yield vars(module)


def _module_of(value: object) -> str:
    """Return the name of a module, or of the module that defines a class or function, or ""."""
    if isinstance(value, StandIn | StandInModule):
        return ""
    if isinstance(value, ModuleType):
        return value.__name__
    kinds = type, FunctionType, BuiltinFunctionType
    if isinstance(value, kinds) or type(value).__name__ == _CYTHON:
        return str(value.__module__)
    return ""
