"""Stand-ins for modules that a lesson forbids because they solve its exercise.

Libraries import such modules for their own purposes; scikit-learn, for example, imports a graph
search in its first line. A library gets a stand-in instead. Every name exists in the stand-in, and
raises an error as soon as it is called.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from types import ModuleType

# When a compiled module is imported, it looks up the C functions that it links against.
# `scipy.interpolate` links against these.
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


def forbidden_module_of(name: str, modules: Iterable[str]) -> str | None:
    """Return the module that equals or contains a dotted name; None if there is none."""
    return next((module for module in modules if f"{name}.".startswith(f"{module}.")), None)


def refusal(module: str) -> ImportError:
    """Build the error for code that imports or uses a module that its lesson forbids."""
    sentence = f"{module} is not allowed in this lesson: it does the exercise for you"
    return ImportError(sentence, name=module)


class StandIn(type):
    """Metaclass of all names in a stand-in module.

    Each name is a class, because library code may use it as a base, in `isinstance` or as a
    decorator's argument without calling it. A call raises the error of `refusal`.
    """

    def __call__(cls, *arguments: object, **keywords: object) -> None:
        """Raise the error of `refusal`."""
        raise refusal(cls.forbidden)

    def __getattr__(cls, name: str) -> StandIn:
        """Return a stand-in for a method or any other attribute."""
        return _stand_in_attribute(name, cls.__module__, cls.forbidden)


class StandInModule(ModuleType):
    """A stand-in for a forbidden module, in which every name exists.

    Parameters
    ----------
    name : str
    forbidden : str
        The module that the lesson forbids: `name`, or a package that contains it.
    """

    def __init__(self, name: str, forbidden: str) -> None:
        super().__init__(name)
        self.__forbidden__ = forbidden
        if name in _LINKED:
            self.__pyx_capi__ = _unusable_functions(name)

    def __getattr__(self, name: str) -> StandIn:
        """Return a stand-in for a name, the same object at every access."""
        value = _stand_in_attribute(name, self.__name__, self.__forbidden__)
        setattr(self, name, value)
        return value


def make_stand_in(name: str, module: str, forbidden: str) -> StandIn:
    """Return a stand-in for a function or a class of a forbidden module."""
    return StandIn(name, (), {"__module__": module, "forbidden": forbidden})


def _stand_in_attribute(name: str, module: str, forbidden: str) -> StandIn:
    if name.startswith("__"):  # Python probes these to find out what an object can do
        raise AttributeError(name)
    return make_stand_in(name, module, forbidden)


@functools.cache
def _unusable_functions(module: str) -> dict[str, object]:
    """Return C functions to link against; a caller gets an error before it reaches them."""
    import ctypes

    new = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p)(
        ("PyCapsule_New", ctypes.pythonapi)
    )
    raises = ctypes.cast(ctypes.pythonapi.PyErr_BadInternalCall, ctypes.c_void_p)
    return {name: new(raises, kind, None) for name, kind in _LINKED[module].items()}
