"""Checks of the kept answers to ungraded steps, which the judge does not run."""

from utils.checks import checks_of
from utils.checks.core import run_check
from utils.checks.diagnosis import known_mistakes


def failures_of(name, function):
    """Return the failed outcomes of a step's checks, by the name of the check."""
    outcomes = [run_check(check, function) for check in checks_of(name)]
    return {outcome.check.name: outcome for outcome in outcomes if outcome.failure}


def assert_notes_hold(answer, failed, mistake):
    """Assert that an answer fails as its notes say, and that students see the mistake in them.

    Parameters
    ----------
    answer : grader.course.kept_answers.KeptAnswer
    failed : dict of str to utils.checks.outcomes.Outcome
        The failed outcomes, by the name of the check.
    mistake : utils.checks.diagnosis.Mistake or None
        The diagnosis of the answer.
    """
    if answer.right:
        assert not failed and mistake is None
        return
    assert set(answer.loses) <= set(failed), sorted(failed)
    assert not answer.loses_only or set(failed) <= set(answer.loses), sorted(failed)
    messages = " ".join(
        f"{outcome.failure.message} {outcome.failure.hint or outcome.check.hint}"
        for outcome in failed.values()
    )
    assert answer.says in messages, messages
    assert bool(mistake) == bool(answer.told), mistake
    assert answer.told in (mistake.description if mistake else "")


def assert_mistakes_have_answers(name, answers):
    """Assert that the notes of some answers quote each known mistake in a step."""
    notes = [answer.told for answer in answers if answer.told]
    for mistake in known_mistakes(name):
        assert any(words in mistake.description for words in notes), mistake.description
