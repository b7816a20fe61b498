"""Check functions that Numba compiles, by running their Python code.

The stop button cannot interrupt an endless loop in compiled code, and reading beyond the end of an
array raises no error there. The checks therefore run the Python code. One more check tests whether
the function compiles and then gives the same answers.
"""

from __future__ import annotations

import linecache
import re
import sys
from collections.abc import Callable
from types import FunctionType

from utils.checks.assertions import brief_text
from utils.checks.failures import CheckFailed


def as_python(function: Callable) -> Callable:
    """Return a function that runs as Python, together with the compiled functions that it calls.

    Returns
    -------
    callable
        The function itself if Numba has not compiled it; otherwise a copy whose globals keep their
        current values.
    """
    if not _is_compiled(function):
        return function
    names = dict(function.py_func.__globals__)
    numba = sys.modules["numba"]
    for name, value in names.items():
        if _is_compiled(value):
            names[name] = _with_globals(value.py_func, names)
        elif value is numba.njit or value is numba.jit:
            names[name] = _skip_compilation
    python = _with_globals(function.py_func, names)
    python.compiled = function
    return python


def assert_compiles(python: Callable, call: Callable[[Callable], object]) -> None:
    """Assert that a function compiles and then gives the same answers; pass without Numba.

    Parameters
    ----------
    python : callable
        A function from `as_python` whose answers are right.
    call : callable
        Calls a function and returns its answer, which is compared with ``==``.
    """
    compiled = getattr(python, "compiled", None)
    if compiled is None:
        if "numba" in sys.modules:
            raise CheckFailed(
                "Numba does not compile this function. Write `@njit` above its first line."
            )
        return
    expected = call(python)
    try:
        answer = call(compiled)
    except Exception as error:
        raise CheckFailed(
            f"Numba cannot compile this function. {_explain_error(error, compiled)}"
        ) from None
    if answer != expected:
        raise CheckFailed(
            f"The compiled function returns {brief_text(answer)}, but the Python code returns "
            f"{brief_text(expected)}. Does the function read beyond the end of an array? "
            "Numba does not check this."
        )


def _is_compiled(value: object) -> bool:
    return isinstance(getattr(value, "__dict__", {}).get("py_func"), FunctionType)


def _with_globals(function: FunctionType, names: dict) -> FunctionType:
    """Return a copy of a function with other globals."""
    copied = FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )
    copied.__module__, copied.__doc__ = function.__module__, function.__doc__
    return copied


def _skip_compilation(function: Callable | None = None, **options: object) -> Callable:
    """Return a function unchanged; this decorator replaces `njit`, with or without options."""
    return function or _skip_compilation


def _explain_error(error: Exception, compiled: Callable) -> str:
    """Return Numba's explanation of an error as one sentence, with the line if Numba names it."""
    # Remove addresses and paths, which do not help the student.
    text = re.sub(r" at 0x\w+|, defined at .*", "", str(error))
    lines = [line.strip() for line in text.splitlines()]
    kept = [line for line in lines if line and not line.startswith(("Failed in", "- "))]
    sentence = " ".join(kept[: 2 if kept and kept[0].endswith(":") else 1]).rstrip(".") + "."
    found = re.findall(r'^File ".*", line (\d+):', str(error), re.M)
    if not found:
        return f"Its message is: {sentence}"
    code = linecache.getline(compiled.py_func.__code__.co_filename, int(found[-1])).strip()
    return f"Its message about line {found[-1]}, `{code}`, is: {sentence}"
