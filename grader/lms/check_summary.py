"""Summarise an exercise's checks for a student: the first failure in full, others in groups.

One mistake can fail many checks, so checks whose messages add nothing new share one line.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.judging.messages import common_text, remove_numbers
from grader.judging.verdict import CheckResult, ExerciseResult, MessageKind

# Kinds of messages that are grouped, each with the wording for one check and for several.
GROUP_WORDINGS = {
    MessageKind.SAME_REASON: ("fails for the same reason", "fail for the same reason"),
    MessageKind.WAITING: ("cannot be tested until this is right",) * 2,
}
SAME_FAILURE = ("fails in the same way", "fail in the same way")


@dataclass(frozen=True)
class CheckGroup:
    """A group of failed checks.

    Attributes
    ----------
    text : str
        One line about the group.
    count : int
    titles : tuple of str
        Titles of the checks, with a count if several have the same title.
    """

    text: str
    count: int
    titles: tuple[str, ...]


@dataclass(frozen=True)
class ExerciseSummary:
    """The summary of an exercise's checks.

    Attributes
    ----------
    exercise : str
    first : CheckResult or None
        The failure to fix first, shown in full; None if every check passed.
    others : tuple of CheckResult
        Failures with a message of their own.
    groups : tuple of CheckGroup
    passed : tuple of CheckResult
    is_started : bool
        False for an untouched stub, for which only `not_started_sentence` is worth showing.
    """

    exercise: str
    first: CheckResult | None
    others: tuple[CheckResult, ...]
    groups: tuple[CheckGroup, ...]
    passed: tuple[CheckResult, ...]
    is_started: bool

    @property
    def not_started_sentence(self) -> str:
        """Sentence about an unchanged stub, without the advice that the notebook shows."""
        stub = self.first.subject
        return f"{stub} is not started." if stub == self.exercise else self.first.message

    @property
    def description(self) -> str:
        """Number of checks that pass, in words."""
        failed = (
            (self.first is not None) + len(self.others) + sum(group.count for group in self.groups)
        )
        check_count = failed + len(self.passed)
        if not check_count:
            return "nothing could be checked"
        if check_count == 1:
            return "the only check failed" if failed else "the only check passed"
        if not failed:
            return f"all {check_count} checks passed"
        return f"{len(self.passed) or 'none'} of the {check_count} checks passed"


def summarise_checks(exercise: ExerciseResult) -> ExerciseSummary:
    """Summarise the checks of an exercise."""
    passed = tuple(test for test in exercise.tests if test.passed)
    failed = [test for test in exercise.tests if not test.passed]
    first = next((test for test in failed if test.name == exercise.first), None)
    first = first or next(iter(failed), None)
    groups: dict[str | tuple[str, str], list[CheckResult]] = {}
    for test in failed:
        if test is not first:
            groups.setdefault(_group_key(test, first), []).append(test)
    alone = {kind for kind, group in groups.items() if len(group) == 1 and isinstance(kind, str)}
    return ExerciseSummary(
        exercise.name,
        first,
        tuple(groups[kind][0] for kind in groups if kind in alone),
        tuple(_build_group(kind, group) for kind, group in groups.items() if kind not in alone),
        passed,
        is_started=not failed or bool(exercise.first),
    )


def _group_key(test: CheckResult, first: CheckResult) -> str | tuple[str, str]:
    """Return the key of a check's group: wordings for one check and for several, or a message."""
    if test.kind in GROUP_WORDINGS:
        return GROUP_WORDINGS[test.kind]
    message = remove_numbers(test.message)
    said = remove_numbers(first.message).splitlines()
    return SAME_FAILURE if set(message.splitlines()) <= set(said) else message


def _build_group(kind: str | tuple[str, str], group: Sequence[CheckResult]) -> CheckGroup:
    many = len(group) > 1
    says = f"{len(group)} more {kind[many]}." if isinstance(kind, tuple) else ""
    counts = Counter(test.title for test in group)
    titles = (f"{title} ({count} times)" if count > 1 else title for title, count in counts.items())
    says = says or f"{len(group)} more fail: {common_text([test.message for test in group])}"
    return CheckGroup(says, len(group), tuple(titles))
