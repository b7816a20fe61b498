"""Cache preconditions and answers that several checks share, for the duration of one run."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Hashable, Iterator
from contextvars import ContextVar

import numpy as np

from utils.checks.failures import AnswerTooLarge, CheckFailed
from utils.checks.size_limits import MAX_NUMBERS

_CACHE: ContextVar[dict | None] = ContextVar("known", default=None)


@contextlib.contextmanager
def cached_run() -> Iterator[None]:
    """Enable the cache of `once_per_run` and `answer_to` for a run of checks on some functions."""
    token = _CACHE.set({})
    try:
        yield
    finally:
        _CACHE.reset(token)


def once_per_run(assertion: Callable[..., None]) -> Callable[..., None]:
    """Decorate an assertion about a function, so that it runs only once per run of checks.

    Later calls raise the same failure again, or pass.

    Parameters
    ----------
    assertion : callable
        Takes a student's function and further hashable arguments; raises `CheckFailed`. Other
        exceptions are not cached, because a process that was stopped may answer the next time.
    """

    @functools.wraps(assertion)
    def cached(function: Callable, *arguments: Hashable) -> None:
        cache, key = _CACHE.get(), (assertion, getattr(function, "__name__", None), *arguments)
        if cache is None:
            assertion(function, *arguments)
            return
        if key not in cache:
            try:
                assertion(function, *arguments)
            except AnswerTooLarge:  # the judge counts each answer that is too large
                raise
            except CheckFailed as failure:
                cache[key] = failure.with_traceback(None)  # tracebacks keep answers in memory
            else:
                cache[key] = None
        if cache[key] is not None:
            raise cache[key].with_traceback(None)

    return cached


def answer_to(function: Callable, call: Hashable, *arguments: np.ndarray) -> object:
    """Return the answer of a student's function, which is called only once per run of checks.

    Only arrays are cached, because they can be copied; other answers may change later. An array
    that is larger than any right answer is not cached either.

    Parameters
    ----------
    function : callable
    call : hashable
        Identifies this call among all calls of the function.
    arguments : numpy.ndarray
        The arguments; the function receives copies.
    """
    cache, key = _CACHE.get(), (getattr(function, "__name__", None), call)
    if cache is not None and key in cache:
        return cache[key]
    answer = function(*(argument.copy() for argument in arguments))
    if cache is not None and isinstance(answer, np.ndarray) and answer.size <= MAX_NUMBERS:
        cache[key] = answer = answer.copy()  # the function may write to its own array later
    return answer
