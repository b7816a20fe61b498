"""Within a run, assertions and answers that several checks share are computed only once."""

import numpy as np
import pytest

from utils.checks.failures import CheckFailed
from utils.checks.run_cache import answer_to, cached_run, once_per_run


def counted_assertion(outcomes):
    """Return an assertion with given outcomes, one for each call, and a list of its calls."""
    calls = []

    @once_per_run
    def assertion(function):
        calls.append(function)
        outcome = outcomes[min(len(calls), len(outcomes)) - 1]
        if outcome:
            raise outcome

    return assertion, calls


def f():
    pass


def g():
    pass


def test_an_assertion_runs_once_per_run():
    assertion, calls = counted_assertion([None])
    with cached_run():
        assertion(f), assertion(f), assertion(g)
    assert calls == [f, g]


def test_a_cached_failure_is_raised_each_time():
    assertion, calls = counted_assertion([CheckFailed("wrong"), None])
    with cached_run():
        for _ in range(3):
            with pytest.raises(CheckFailed, match="wrong"):
                assertion(f)
    assert calls == [f]


def test_the_next_run_starts_with_an_empty_cache():
    assertion, calls = counted_assertion([CheckFailed("wrong"), None])
    with cached_run(), pytest.raises(CheckFailed):
        assertion(f)
    with cached_run():
        assertion(f)
        with cached_run():
            assertion(f)
        assertion(f)
    assert len(calls) == 3


def test_other_exceptions_are_not_cached():
    """Only check failures are cached, because a process that was stopped may answer next time."""
    assertion, calls = counted_assertion([OSError("stopped"), None])
    with cached_run():
        with pytest.raises(OSError):
            assertion(f)
        assertion(f)
    assert len(calls) == 2


def test_nothing_is_cached_outside_a_run():
    assertion, calls = counted_assertion([None])
    assertion(f), assertion(f)
    assert len(calls) == 2


def test_arguments_are_part_of_the_cache_key():
    calls = []
    assertion = once_per_run(lambda function, about: calls.append(about))
    with cached_run():
        assertion(f, 1), assertion(f, 2), assertion(f, 1)
    assert calls == [1, 2]


def test_a_cached_answer_is_a_copy():
    given, mine = [], np.zeros(2)

    def counts(array):
        array += 1
        mine[:] += array
        given.append(array)
        return mine

    question = np.ones(2)
    with cached_run():
        first, second = (answer_to(counts, "one", question) for _ in range(2))
        other = answer_to(counts, "other", question)
    assert len(given) == 2
    assert question.tolist() == [1, 1]
    assert first.tolist() == second.tolist() == [2, 2]
    assert other.tolist() == [4, 4]
    answer_to(counts, "one", question), answer_to(counts, "one", question)
    assert len(given) == 4


def test_only_arrays_are_cached():
    calls = []

    def lists(array):
        calls.append(array)
        return iter(array)

    with cached_run():
        for _ in range(2):
            assert [*answer_to(lists, "one", np.ones(2))] == [1, 1]
    assert len(calls) == 2
