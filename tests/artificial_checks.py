"""Checks of an artificial exercise `double`, which tests declare."""

import pytest

from utils.checks import check, core, diagnosis
from utils.checks.core import ChecksFailed, visible_check


def forget_declarations(monkeypatch):
    """Remove the checks and mistakes that a test declares when the test ends."""
    monkeypatch.setattr(core, "_CHECKS", dict(core._CHECKS))
    monkeypatch.setattr(diagnosis, "_KNOWN", dict(diagnosis._KNOWN))


def declare(title, exercise="double", weight=1, **more):
    """Declare a check; the decorated function is called with the student's function."""
    return visible_check(
        exercise, title=title, why="It matters.", hint=f"Hint of {title}.", weight=weight, **more
    )


def output_of(function, capsys, **options):
    """Return the output of a `check` that fails."""
    with pytest.raises(ChecksFailed):
        check(function, "double", **options)
    return capsys.readouterr().out
