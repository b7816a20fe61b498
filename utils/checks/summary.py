"""From many failures to one story: the first in full, what it explains folded under it.

Pedal, an autograder of introductory courses, calls this its resolver: many findings, ranked, one
told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from utils.checks.diagnosis import Mistake
from utils.checks.failures import NotStarted, NotYet, Raised
from utils.checks.line_hint import LineHint
from utils.checks.outcomes import Check, Outcome


@dataclass(frozen=True)
class Story:
    """What is told about an exercise.

    Attributes
    ----------
    passed : tuple of Outcome
    first : Outcome or None
        The failure that is told in full.
    same : tuple of Outcome
        Failures with the same cause.
    others : tuple of Outcome
        Failures of which nobody knows whether they have the same cause.
    waiting : tuple of Outcome
        What cannot be judged yet; without a failure where it was not even run.
    notes : tuple of Outcome
        What costs no points.
    mistake : Mistake or None
        What explains all answers; None where the first failure is no answer.
    blamed : str or None
        A function that this one calls and that is wrong itself.
    place : utils.checks.line_hint.LineHint or None
        Where one change makes everything pass that students see.
    """

    passed: tuple[Outcome, ...]
    first: Outcome | None
    same: tuple[Outcome, ...] = ()
    others: tuple[Outcome, ...] = ()
    waiting: tuple[Outcome, ...] = ()
    notes: tuple[Outcome, ...] = ()
    mistake: Mistake | None = None
    blamed: str | None = None
    place: LineHint | None = None

    @property
    def not_started(self) -> bool:
        """True for a stub that nobody touched."""
        return self.first is not None and isinstance(self.first.failure, NotStarted)

    @property
    def in_one_line(self) -> str:
        """For where there is no table, as in `nbgrader validate`."""
        if self.not_started:
            failure = self.first.failure
            return f"{failure.stub} is not started." if failure.own else failure.message
        failed = 1 + len(self.same) + len(self.others)
        count = failed + len(self.passed) + len(self.waiting)
        which = "" if failed == 1 else ", the first of them"
        return f"{failed} of {count} checks failed{which}:\n{self.first.check.title}"


def resolve(
    outcomes: Sequence[Outcome],
    checks: Sequence[Check] = (),
    mistake: Mistake | None = None,
    notes: Sequence[Outcome] = (),
    blamed: str | None = None,
    place: LineHint | None = None,
    alone: bool = False,
) -> Story:
    """Find out what to tell.

    Parameters
    ----------
    outcomes : sequence of Outcome
        What was run, basics first.
    checks : sequence of Check
        All there are; those that were not run are waiting.
    mistake : Mistake, optional
    notes : sequence of Outcome
    blamed : str, optional
    place : utils.checks.line_hint.LineHint, optional
    alone : bool
        Whether one thing alone is proven to be wrong, as it is where there is a place.
    """
    passed = tuple(outcome for outcome in outcomes if outcome.failure is None)
    failed = [outcome for outcome in outcomes if outcome.failure is not None]
    ran = [outcome.check for outcome in outcomes]
    waiting = tuple(Outcome(check, None) for check in checks if check not in ran)
    notes = tuple(outcome for outcome in notes if outcome.failure is not None)
    if not failed:
        return Story(passed, None, waiting=waiting, notes=notes)
    # A stub explains everything; otherwise the checks stand in the order to read them in.
    stubs = [outcome for outcome in failed if isinstance(outcome.failure, NotStarted)]
    ready = [outcome for outcome in failed if not isinstance(outcome.failure, NotYet)]
    first = (stubs or ready or failed)[0]
    cause = first.failure.cause
    rest = [outcome for outcome in ready if outcome is not first]
    waiting += tuple(outcome for outcome in failed if outcome is not first and outcome not in ready)
    same = tuple(
        outcome
        for outcome in rest
        if alone or place or (cause is not None and outcome.failure.cause == cause)
    )
    others = tuple(outcome for outcome in rest if outcome not in same)
    mistake = mistake if first.failure.is_about_an_answer else None
    return Story(passed, first, same, others, waiting, notes, mistake, blamed, place)


def details(outcome: Outcome, mistake: Mistake | None = None) -> list[tuple[str, str]]:
    """What there is to say about a failure, each as (label, text).

    Parameters
    ----------
    outcome : Outcome
    mistake : Mistake, optional
        What explains it.
    """
    failure = outcome.failure
    said = [
        ("What your code does", mistake.says if mistake else ""),
        ("What happened", failure.message),
        *([("Where", _where(failure))] if isinstance(failure, Raised) else []),
        ("In plain words", failure.tip),
        ("Given", failure.given),
        ("Yours", failure.yours),
        ("Expected", failure.expected),
        ("Hint", hint_for(outcome, mistake)),
    ]
    if failure.is_about_the_check:
        said.append(("Why it matters", outcome.check.why))
    return [(label, text) for label, text in said if text]


def _where(failure: Raised) -> str:
    line = f": `{failure.line}`" if failure.line else ""
    return f"{failure.place}{line}" if failure.place else ""


def hint_for(outcome: Outcome, mistake: Mistake | None = None) -> str:
    """The hint that belongs to a failure: of its cause, of its own, or of what was checked."""
    if mistake:
        return mistake.hint
    failure = outcome.failure
    return failure.hint or (outcome.check.hint if failure.is_about_the_check else "")
