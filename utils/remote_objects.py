"""Base classes for proxies of functions and objects in another process.

In a notebook, a check receives the student's own function. In the judge, it receives a proxy that
forwards each call to the sandbox. A check calls both in the same way. Some checks need more than
the result, such as the arguments after the call. A proxy observes them in the other process.
"""

from __future__ import annotations

from dataclasses import dataclass

ENDLESS_LOOP_HINT = "is there a loop that never ends, or one that is far too slow?"
"""Default hint for a call that exceeds its time limit; a check may have its own (`Check.slow`)."""


class RemoteProxy:
    """Base class of all proxies.

    Checks test for this class rather than for a method, because a student's class may have methods
    of any name. Functions have `observe`, `timed` and `each`; objects have `reach`. These do the
    same as `observe`, `time_call`, `call_each` and `get_attribute_path` in
    `utils.checks.assertions`.
    """


class RemoteError(Exception):
    """A function in another process raised an exception."""


class RemoteStopped(Exception):
    """The process that ran a function died, or was ended because it hung."""


@dataclass(frozen=True)
class ObservedCall:
    """Observations made during one call.

    Attributes
    ----------
    result : object
        Return value of the function.
    arguments : tuple
        State of the arguments after the call; the function received copies.
    shared_arguments : frozenset of int
        Positions of the arguments that share memory with the result.
    """

    result: object
    arguments: tuple
    shared_arguments: frozenset[int]
