"""What many checks rest on is asked once a run, and remembered until its end."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from contextvars import ContextVar

from utils.checks.failures import CheckFailed, FarTooMuch

_KNOWN: ContextVar[dict | None] = ContextVar("known", default=None)


@contextlib.contextmanager
def one_run() -> Iterator[None]:
    """A run of checks on the same functions: while it lasts, `once` remembers."""
    token = _KNOWN.set({})
    try:
        yield
    finally:
        _KNOWN.reset(token)


def once(assertion: Callable[[Callable], None]) -> Callable[[Callable], None]:
    """Decorate an assertion about a function: in one run it is asked once, and fails each time.

    Parameters
    ----------
    assertion : callable
        Takes a student's function; raises `CheckFailed`. Whatever else it raises is not
        remembered: a process that was stopped may answer the next time.

    Returns
    -------
    callable
    """

    @functools.wraps(assertion)
    def asked(function: Callable) -> None:
        known, key = _KNOWN.get(), (assertion, getattr(function, "__name__", None))
        if known is None:
            assertion(function)
            return
        if key not in known:
            try:
                assertion(function)
            except FarTooMuch:  # of such answers each is counted
                raise
            except CheckFailed as failure:
                known[key] = failure
            else:
                known[key] = None
        if known[key] is not None:
            raise known[key].with_traceback(None)

    return asked
