"""What somebody has written, and what is a stub still."""

from __future__ import annotations

import dis
from collections.abc import Callable
from types import FunctionType

# What asks functions on its own account, and not on the notebook's.
ASKING = ("check", "replay", "show_broken", "tell_apart")


def is_written(function: Callable) -> bool:
    """Whether somebody has written a function, or it is still a stub.

    Returns
    -------
    bool
        A class counts as written, and whatever else has no Python code to look at.
    """
    code = getattr(own(function), "__code__", None)
    if code is None or "NotImplementedError" not in code.co_names:
        return True
    # A stub may begin with a line that is given, and it never comes to a return.
    return any(step.opname.startswith("RETURN_") for step in dis.get_instructions(code))


def own(function: Callable) -> Callable:
    """The function that somebody wrote, without what answers for it.

    Parameters
    ----------
    function : callable
        Perhaps one that lends or records answers.

    Returns
    -------
    callable
        The function itself where it is somebody's own already.
    """
    return function.__wrapped__ if hasattr(function, "is_lent_answers") else function


def stub_of(name: str) -> FunctionType:
    """A function that nobody has written."""

    def stub(*arguments: object, **keywords: object) -> None:
        raise NotImplementedError

    code = stub.__code__.replace(co_name=name)
    return FunctionType(code, globals(), name)
