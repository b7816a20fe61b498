"""A stand-in for ipywidgets when it is not installed; the sliders never move."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import util
from types import ModuleType


class StaticWidget:
    """A widget of any kind, which always keeps its initial value."""

    def __init__(self, *_: object, value: object = None, **settings: object) -> None:
        self.value = value
        self.__dict__.update(settings)


def interact(**sliders: StaticWidget) -> Callable[[Callable], Callable]:
    """Return a decorator that calls the function once, with the initial value of each slider."""

    def run(function: Callable) -> Callable:
        function(**{name: slider.value for name, slider in sliders.items()})
        return function

    return run


def _widget_named(name: str) -> type[StaticWidget]:
    """Return the class of any widget; `__file__` and other names of Python are absent."""
    if name.startswith("__"):
        raise AttributeError(name)
    return StaticWidget


def install_stand_in() -> None:
    """Let ``import ipywidgets`` find a replacement if ipywidgets is not installed."""
    if "ipywidgets" in sys.modules or util.find_spec("ipywidgets"):
        return
    module = ModuleType("ipywidgets", __doc__)
    module.interact, module.is_still = interact, True
    module.__getattr__ = _widget_named
    sys.modules["ipywidgets"] = module
