"""What many checks rest on is asked once a run."""

import pytest

from utils.checks.failures import CheckFailed
from utils.checks.remembering import once, one_run


def counted(outcomes):
    """An assertion that ends as it is told, call by call, and whom it was asked about."""
    asked = []

    @once
    def assertion(function):
        asked.append(function)
        outcome = outcomes[min(len(asked), len(outcomes)) - 1]
        if outcome:
            raise outcome

    return assertion, asked


def f():
    pass


def g():
    pass


def test_a_run_asks_once():
    assertion, asked = counted([None])
    with one_run():
        assertion(f), assertion(f), assertion(g)
    assert asked == [f, g]


def test_a_failure_is_told_each_time():
    assertion, asked = counted([CheckFailed("wrong"), None])
    with one_run():
        for _ in range(3):
            with pytest.raises(CheckFailed, match="wrong"):
                assertion(f)
    assert asked == [f]


def test_the_next_run_asks_anew():
    assertion, asked = counted([CheckFailed("wrong"), None])
    with one_run(), pytest.raises(CheckFailed):
        assertion(f)
    with one_run():
        assertion(f)
        with one_run():
            assertion(f)
        assertion(f)
    assert len(asked) == 3


def test_what_is_no_answer_is_asked_again():
    """A process that was stopped may answer the next time."""
    assertion, asked = counted([OSError("stopped"), None])
    with one_run():
        with pytest.raises(OSError):
            assertion(f)
        assertion(f)
    assert len(asked) == 2


def test_without_a_run_nothing_is_remembered():
    assertion, asked = counted([None])
    assertion(f), assertion(f)
    assert len(asked) == 2
