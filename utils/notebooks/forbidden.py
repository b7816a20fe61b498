"""What a lesson forbids, because it does the exercise: how it is refused, and what stands for it.

Libraries import such modules for purposes of their own, scikit-learn a graph search with its first
line. They find a module in which every name is there, and refuses to be used.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from types import ModuleType

# Compiled code that links against compiled code looks for it as soon as it is imported:
# `scipy.interpolate` for these.
_MESH = "__pyx_t_5scipy_7spatial_6_qhull_DelaunayInfo_t *"
_LINKED = {
    "scipy.spatial._qhull": {
        "_get_delaunay_info": f"int ({_MESH}, PyObject *, int, int, int)".encode(),
        "_barycentric_coordinates": b"void (int, double *, double const *, double *)",
        "_find_simplex": (
            f"int ({_MESH}, double *, double const *, int *, double, double)".encode()
        ),
    }
}


def forbidden_part(name: str, modules: Iterable[str]) -> str | None:
    """That one of some modules which a dotted name is, or lies in."""
    return next((module for module in modules if f"{name}.".startswith(f"{module}.")), None)


def refusal(module: str) -> ImportError:
    """What is raised where code imports, or uses, what its lesson forbids."""
    sentence = f"{module} is not allowed in this lesson: it does the exercise for you"
    return ImportError(sentence, name=module)


class StandIn(type):
    """The kind of all names in a module that is not there.

    Each is a class, as a class can be had for a base, by `isinstance` and as a decorator's argument
    before anybody uses it. Call it, and it refuses.
    """

    def __call__(cls, *arguments: object, **keywords: object) -> None:
        """Refuse."""
        raise refusal(cls.forbidden)

    def __getattr__(cls, name: str) -> StandIn:
        """A method, or what else may lie in it."""
        return _inside(name, cls.__module__, cls.forbidden)


class StandInModule(ModuleType):
    """A module that is not there, with every name that anybody asks for.

    Parameters
    ----------
    name : str
    forbidden : str
        What the lesson forbids: this, or what it lies in.
    """

    def __init__(self, name: str, forbidden: str) -> None:
        super().__init__(name)
        self.__forbidden__ = forbidden
        if name in _LINKED:
            self.__pyx_capi__ = _unusable(name)

    def __getattr__(self, name: str) -> StandIn:
        """A stand-in; the same one each time."""
        value = _inside(name, self.__name__, self.__forbidden__)
        setattr(self, name, value)
        return value


def stand_in(name: str, module: str, forbidden: str) -> StandIn:
    """What stands for a function or a class of a forbidden module."""
    return StandIn(name, (), {"__module__": module, "forbidden": forbidden})


def _inside(name: str, module: str, forbidden: str) -> StandIn:
    if name.startswith("__"):  # by these Python asks what a thing can do
        raise AttributeError(name)
    return stand_in(name, module, forbidden)


@functools.cache
def _unusable(module: str) -> dict[str, object]:
    """Functions of C that can be linked against; whoever could call one is refused before."""
    import ctypes

    new = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)(
        ("PyCapsule_New", ctypes.pythonapi)
    )
    raises = ctypes.cast(ctypes.pythonapi.PyErr_BadInternalCall, ctypes.c_void_p)
    return {name: new(raises, kind, None) for name, kind in _LINKED[module].items()}
