"""In a notebook, too, what a lesson forbids refuses while a function is checked.

Where notebooks are judged it is not even there; here libraries hold it, which may hand it on or use
it for a student.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from types import BuiltinFunctionType, FunctionType, ModuleType, TracebackType

from utils.notebooks.forbidden import StandIn, StandInModule, forbidden_part, stand_in

_CYTHON = "cython_function_or_method"


class Refusing:
    """Within the context, stand-ins replace the contents of some modules, wherever imported."""

    def __init__(self, modules: Sequence[str]) -> None:
        self._modules, self._beginnings = modules, tuple(f"{module}." for module in modules)
        self._hidden: dict[str, ModuleType] = {}
        self._replaced: list[tuple[dict, str, object]] = []

    def __enter__(self) -> Refusing:
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
        # What was imported meanwhile has got stand-ins.
        for namespace in _namespaces():
            for name, value in list(namespace.items()):
                if isinstance(value, StandInModule):
                    namespace[name] = sys.modules[value.__name__]
                elif isinstance(value, StandIn):
                    namespace[name] = getattr(sys.modules[value.__module__], value.__name__, value)

    def hide(self) -> bool:
        """Hide what has been imported of these modules until now; whether there was any."""
        found = {
            name: module
            for name, module in list(sys.modules.items())
            if isinstance(module, ModuleType)
            and not isinstance(module, StandInModule)
            and f"{name}.".startswith(self._beginnings)
        }
        if not found:
            return False
        self._hidden |= found
        sys.modules.update({name: self._module(name) for name in found})
        for namespace in _namespaces():
            for name, value in list(namespace.items()):
                home = _home(value)
                if f"{home}.".startswith(self._beginnings):
                    self._replaced.append((namespace, name, value))
                    namespace[name] = self._stand_in(value, home)
        return True

    def _stand_in(self, value: object, home: str) -> object:
        if isinstance(value, ModuleType):
            return sys.modules.get(home, value)
        return stand_in(value.__name__, home, forbidden_part(home, self._modules))

    def _module(self, name: str) -> StandInModule:
        module = StandInModule(name, forbidden_part(name, self._modules))
        real = vars(self._hidden[name])
        # By these others are found beside it, and compiled code links against it.
        special = {name for name in real if name.startswith("__")} - {"__getattr__"}
        vars(module).update({name: real[name] for name in special})
        return module


def _namespaces() -> Iterator[dict]:
    """Of all modules that are there."""
    for module in list(sys.modules.values()):
        if isinstance(module, ModuleType) and not isinstance(module, StandInModule):
            yield vars(module)


def _home(value: object) -> str:
    """The module that a thing is, or in which it was written; of a value, none is known."""
    if isinstance(value, StandIn | StandInModule):
        return ""
    if isinstance(value, ModuleType):
        return value.__name__
    kinds = type, FunctionType, BuiltinFunctionType
    if isinstance(value, kinds) or type(value).__name__ == _CYTHON:
        return str(value.__module__)
    return ""
