"""Distinguish written functions from stubs."""

from __future__ import annotations

import dis
from collections.abc import Callable
from types import FunctionType

# Course functions that call the student's function; the notebook does not use their results.
CALLERS = ("ask_about", "check", "replay", "show_broken", "tell_apart")


def is_written(function: Callable) -> bool:
    """Return whether a function is more than a stub.

    Returns
    -------
    bool
        True also for classes and other objects without Python code.
    """
    code = getattr(own(function), "__code__", None)
    if code is None or "NotImplementedError" not in code.co_names:
        return True
    # A stub may begin with given lines, but its code contains no return.
    return any(step.opname.startswith("RETURN_") for step in dis.get_instructions(code))


def own(function: Callable) -> Callable:
    """Return the student's own function, without the wrapper around it.

    Parameters
    ----------
    function : callable
        A function, or a wrapper that returns or records stored answers.

    Returns
    -------
    callable
        The wrapped function; `function` itself if it is not wrapped.
    """
    return function.__wrapped__ if hasattr(function, "is_lent_answers") else function


def stub_of(name: str) -> FunctionType:
    """Return a stub with the given name."""

    def stub(*arguments: object, **keywords: object) -> None:
        raise NotImplementedError

    code = stub.__code__.replace(co_name=name)
    return FunctionType(code, globals(), name)
