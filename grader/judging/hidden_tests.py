"""The decorator of hidden tests, and the check that such a test stands for."""

import dataclasses

import pytest

from utils.checks import Check


def hidden(exercise: str, *, title: str, hint: str, weight: float = 1.0) -> pytest.MarkDecorator:
    """Mark a test of a lesson's ``hidden_tests.py``, which students do not see.

    Parameters
    ----------
    exercise : str
    title, hint : str
        Shown to students: they may say what is demanded, but not how it is tested. In the title of
        a parametrized test, ``{}`` is replaced by the id of the parameters.
    weight : float
        Share of the exercise's points, relative to its other checks.
    """
    return pytest.mark.judged(Check("", exercise, title, hint, weight))


def check_of(item: pytest.Item) -> Check:
    """Return the check that a test stands for."""
    check = item.get_closest_marker("judged").args[0]
    title = check.title.format(item.callspec.id) if hasattr(item, "callspec") else check.title
    return dataclasses.replace(check, name=item.name, title=title)
