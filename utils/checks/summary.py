"""Choose the failure to show in full, and group the others.

Pedal, an autograder for introductory courses, calls this step the resolver: it ranks many findings
and shows one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from utils.checks.code_slips import CodeSlip
from utils.checks.diagnosis import Mistake
from utils.checks.failures import ExceptionRaised, NotStarted, NotYet
from utils.checks.line_hint import LineHint
from utils.checks.outcomes import Check, Outcome


@dataclass(frozen=True)
class Summary:
    """The results of an exercise, grouped for display.

    Attributes
    ----------
    passed : tuple of Outcome
    first : Outcome or None
        The failure to show in full.
    same : tuple of Outcome
        Failures with the same cause as `first`.
    others : tuple of Outcome
        Failures that may have other causes.
    waiting : tuple of Outcome
        Checks that cannot be judged yet; without a failure if they were not run.
    notes : tuple of Outcome
        Failed checks that cost no points.
    mistake : Mistake or CodeSlip or None
        The mistake that explains all answers, if `first` is about an answer; else the slip in
        the source of the function.
    wrong_helper : str or None
        A function that this one calls and that fails its own checks.
    line_hint : utils.checks.line_hint.LineHint or None
        The lines in which one change makes all visible checks pass.
    """

    passed: tuple[Outcome, ...]
    first: Outcome | None
    same: tuple[Outcome, ...] = ()
    others: tuple[Outcome, ...] = ()
    waiting: tuple[Outcome, ...] = ()
    notes: tuple[Outcome, ...] = ()
    mistake: Mistake | CodeSlip | None = None
    wrong_helper: str | None = None
    line_hint: LineHint | None = None

    @property
    def not_started(self) -> bool:
        """Whether the exercise, or a function that it calls, is still a stub."""
        return self.first is not None and isinstance(self.first.failure, NotStarted)

    @property
    def in_one_line(self) -> str:
        """The results in one line, for places without a table such as `nbgrader validate`."""
        if self.not_started:
            failure = self.first.failure
            return f"{failure.stub} is not started." if failure.own else failure.message
        failed = 1 + len(self.same) + len(self.others)
        count = failed + len(self.passed) + len(self.waiting)
        title = self.first.check.title if failed == 1 else f"The first is: {self.first.check.title}"
        return f"{failed} of {count} checks failed.\n{title}"


def summarise(
    outcomes: Sequence[Outcome],
    checks: Sequence[Check] = (),
    mistake: Mistake | None = None,
    notes: Sequence[Outcome] = (),
    wrong_helper: str | None = None,
    line_hint: LineHint | None = None,
    one_mistake: bool = False,
    slip: CodeSlip | None = None,
) -> Summary:
    """Choose the failure to show, and group the rest under it.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Results of the checks that were run, basic checks first.
    checks : sequence of Check
        All checks; those that were not run are waiting.
    mistake : Mistake, optional
    notes : sequence of Outcome
    wrong_helper : str, optional
    line_hint : utils.checks.line_hint.LineHint, optional
    one_mistake : bool
        Whether only one thing is known to be wrong. A `line_hint` implies it.
    slip : utils.checks.code_slips.CodeSlip, optional
    """
    passed = tuple(outcome for outcome in outcomes if outcome.failure is None)
    failed = [outcome for outcome in outcomes if outcome.failure is not None]
    ran = [outcome.check for outcome in outcomes]
    waiting = tuple(Outcome(check, None) for check in checks if check not in ran)
    notes = tuple(outcome for outcome in notes if outcome.failure is not None)
    if not failed:
        return Summary(passed, None, waiting=waiting, notes=notes)
    # A stub explains all other failures. Otherwise the most basic failure is shown.
    stubs = [outcome for outcome in failed if isinstance(outcome.failure, NotStarted)]
    ready = [outcome for outcome in failed if not isinstance(outcome.failure, NotYet)]
    if not ready and failed[0].failure.reason:
        # Every failed check waits for a precondition, so show why the first precondition fails.
        ready = [replace(failed[0], failure=failed[0].failure.reason)]
        failed[0] = ready[0]
    first = (stubs or ready or failed)[0]
    cause = first.failure.cause
    rest = [outcome for outcome in ready if outcome is not first]
    waiting += tuple(outcome for outcome in failed if outcome is not first and outcome not in ready)
    same = tuple(
        outcome
        for outcome in rest
        if one_mistake or line_hint or (cause is not None and outcome.failure.cause == cause)
    )
    others = tuple(outcome for outcome in rest if outcome not in same)
    mistake = (mistake if first.failure.is_about_an_answer else None) or slip
    return Summary(passed, first, same, others, waiting, notes, mistake, wrong_helper, line_hint)


def failure_texts(
    outcome: Outcome, mistake: Mistake | CodeSlip | None = None
) -> list[tuple[str, str]]:
    """Return the texts that explain a failure, each as (label, text).

    Parameters
    ----------
    outcome : Outcome
    mistake : Mistake or CodeSlip, optional
        The mistake that explains the failure.
    """
    failure = outcome.failure
    comparison = [("Yours", failure.yours), ("Expected", failure.expected)]
    if failure.yours == failure.expected:  # these texts do not show the difference
        comparison = []
    lines = [
        ("What your code does", mistake.description if mistake else ""),
        ("What happened", failure.message),
        *([("Where", _location_text(failure))] if isinstance(failure, ExceptionRaised) else []),
        ("In plain words", failure.tip),
        ("Given", failure.input_text),
        *comparison,
        ("Hint", hint_for(outcome, mistake)),
    ]
    if failure.is_about_the_check:
        lines.append(("Why it matters", outcome.check.why))
    return [(label, text) for label, text in lines if text]


def _location_text(failure: ExceptionRaised) -> str:
    line = f": `{failure.line}`" if failure.line else ""
    return f"{failure.place}{line}" if failure.place else ""


def hint_for(outcome: Outcome, mistake: Mistake | CodeSlip | None = None) -> str:
    """Return the hint of the mistake, else of the failure, else of the check."""
    if mistake:
        return mistake.hint
    failure = outcome.failure
    return failure.hint or (outcome.check.hint if failure.is_about_the_check else "")
