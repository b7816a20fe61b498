"""What lives elsewhere, and how it is asked: in the judge, a student's functions and objects.

A check is given a function: in a notebook the student's own, in the judge one that asks across a
wall. Both can be called. What a check does to a function beyond that, such as looking at what
became of its arguments, happens where the function is: so whatever is `Remote` does it itself.
"""

from __future__ import annotations

from dataclasses import dataclass

ENDLESS = "is there a loop that never ends?"
"""What to ask whose function did not come back, unless a check knows better (`Check.slow`)."""


class Remote:
    """Marks what lives elsewhere; a class of a student's may have methods of any name.

    A function has `observe`, `timed` and `each`, an object `reach`: they do and return what the
    functions `observe`, `timed`, `call_each` and `reach` of `utils.checks.assertions` do.
    """


class RemoteError(Exception):
    """What a function that lives elsewhere raised there."""


class RemoteStopped(Exception):
    """What lives elsewhere hung or died, and is gone."""


@dataclass(frozen=True)
class Observed:
    """A call that was looked at.

    Attributes
    ----------
    result : object
        What the function returned.
    arguments : tuple
        What became of copies of the arguments.
    shared : frozenset of int
        Positions of the arguments that share their memory with the result.
    """

    result: object
    arguments: tuple
    shared: frozenset[int]
