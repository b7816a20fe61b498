"""Functions that Numba compiles, asked as the Python that they were made of.

Compiled, a loop without an end hears no stop button, and a row that is not there is read all the
same. So what is checked is the Python; that it compiles and answers alike is one more property.
"""

from __future__ import annotations

import linecache
import re
import sys
from collections.abc import Callable
from types import FunctionType

from utils.checks.assertions import brief
from utils.checks.failures import CheckFailed


def as_python(function: Callable) -> Callable:
    """A function as Python runs it, and all that it calls, whether Numba compiles them or not.

    Parameters
    ----------
    function : callable

    Returns
    -------
    callable
        The function itself where Numba does not compile it. Names have the values of this moment.
    """
    if not _is_compiled(function):
        return function
    names = dict(function.py_func.__globals__)
    numba = sys.modules["numba"]
    for name, value in names.items():
        if _is_compiled(value):
            names[name] = _made_anew(value.py_func, names)
        elif value is numba.njit or value is numba.jit:
            names[name] = _as_it_is
    python = _made_anew(function.py_func, names)
    python.compiled = function
    return python


def assert_compiles(python: Callable, ask: Callable[[Callable], object]) -> None:
    """Compiled, a function answers as its Python does; nothing is asked where there is no Numba.

    Parameters
    ----------
    python : callable
        From `as_python`; its answers are right.
    ask : callable
        Takes a function; returns what it answers, to be compared.
    """
    compiled = getattr(python, "compiled", None)
    if compiled is None:
        if "numba" in sys.modules:
            raise CheckFailed("Numba does not compile it: write `@njit` above its first line.")
        return
    expected = ask(python)
    try:
        answer = ask(compiled)
    except Exception as error:
        raise CheckFailed(f"Numba cannot compile it. {_reason(error, compiled)}") from None
    if answer != expected:
        raise CheckFailed(
            f"Compiled, it answers {brief(answer)}, and as Python {brief(expected)}: does it reach "
            "beyond the end of an array? Numba does not look."
        )


def _is_compiled(value: object) -> bool:
    return isinstance(getattr(value, "__dict__", {}).get("py_func"), FunctionType)


def _made_anew(function: FunctionType, names: dict) -> FunctionType:
    """The same function, with other values behind the names that it takes from outside."""
    made = FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )
    made.__module__, made.__doc__ = function.__module__, function.__doc__
    return made


def _as_it_is(function: Callable | None = None, **options: object) -> Callable:
    """In place of `njit`, with and without options."""
    return function or _as_it_is


def _reason(error: Exception, compiled: Callable) -> str:
    """What Numba says, in a sentence, and of which line."""
    # Addresses and files of the machine tell nobody anything.
    text = re.sub(r" at 0x\w+|, defined at .*", "", str(error))
    lines = [line.strip() for line in text.splitlines()]
    said = [line for line in lines if line and not line.startswith(("Failed in", "- "))]
    sentence = " ".join(said[: 2 if said and said[0].endswith(":") else 1]).rstrip(".") + "."
    found = re.findall(r'^File ".*", line (\d+):', str(error), re.M)
    if not found:
        return f"It says: {sentence}"
    code = linecache.getline(compiled.py_func.__code__.co_filename, int(found[-1])).strip()
    return f"It says of line {found[-1]}, `{code}`: {sentence}"
