"""How a pytest test says which exercise it belongs to and what a student may read of it."""

import pytest

from utils.checks import checks_of


def hidden(exercise: str, *, title: str, hint: str, weight: float = 1.0) -> pytest.MarkDecorator:
    """Mark a test of `grader/tests` that is not in the notebook.

    Parameters
    ----------
    exercise : str
    title, hint : str
        Shown to students: they may say what is demanded, never how it is tested.
    weight : float
        Share of the exercise's points, relative to its other checks.
    """
    return pytest.mark.judged(
        exercise=exercise, title=title, hint=hint, weight=weight, visible=False
    )


def visible_checks(*exercises: str) -> pytest.MarkDecorator:
    """Turn the notebook's own checks of some exercises into tests, as argument `check`."""
    return pytest.mark.parametrize(
        "check",
        [
            pytest.param(
                check,
                id=check.name,
                marks=pytest.mark.judged(
                    exercise=exercise,
                    title=check.title,
                    hint=check.hint,
                    weight=check.weight,
                    visible=True,
                ),
            )
            for exercise in exercises
            for check in checks_of(exercise)
        ],
    )
