"""What a student reads of an exercise's checks: the first failure in full, the rest in few lines.

One mistake fails many checks. Those that say nothing of their own are told together.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from grader.judging.messages import in_common, without_numbers
from grader.judging.verdict import CheckResult, ExerciseResult, Kind

# Messages of these kinds are told together: what is said of one and of many.
TOGETHER = {
    Kind.SAME_REASON: ("fails for the same reason", "fail for the same reason"),
    Kind.WAITING: ("cannot be judged before this is right",) * 2,
}
ALIKE = ("fails in the same way", "fail in the same way")


@dataclass(frozen=True)
class Fold:
    """Failed checks that are told together.

    Attributes
    ----------
    says : str
        One line about all of them.
    count : int
    titles : tuple of str
        What they demand; with a number where several demand the same.
    """

    says: str
    count: int
    titles: tuple[str, ...]


@dataclass(frozen=True)
class Folded:
    """The checks of an exercise as they are told.

    Attributes
    ----------
    exercise : str
    first : CheckResult or None
        The failure to begin with, told in full; None where everything holds.
    others : tuple of CheckResult
        Failures that say something of their own.
    folds : tuple of Fold
    passed : tuple of CheckResult
    started : bool
        False for a stub that nobody touched: then only `not_started` says anything.
    """

    exercise: str
    first: CheckResult | None
    others: tuple[CheckResult, ...]
    folds: tuple[Fold, ...]
    passed: tuple[CheckResult, ...]
    started: bool

    @property
    def not_started(self) -> str:
        """The sentence on a stub: without what to do, which the notebook says."""
        stub = self.first.subject
        return f"{stub} is not started." if stub == self.exercise else self.first.message

    @property
    def in_words(self) -> str:
        """How many checks hold."""
        failed = (
            (self.first is not None) + len(self.others) + sum(fold.count for fold in self.folds)
        )
        most = failed + len(self.passed)
        if not most:
            return "nothing could be checked"
        if not failed:
            return f"all {most} checks hold"
        return f"{len(self.passed) or 'none'} of {most} checks hold"


def fold(exercise: ExerciseResult) -> Folded:
    """Sort the checks of an exercise by what there is to say about them."""
    passed = tuple(test for test in exercise.tests if test.passed)
    failed = [test for test in exercise.tests if not test.passed]
    first = next((test for test in failed if test.name == exercise.first), None)
    first = first or next(iter(failed), None)
    groups: dict[str | tuple[str, str], list[CheckResult]] = {}
    for test in failed:
        if test is not first:
            groups.setdefault(_kind(test, first), []).append(test)
    alone = {kind for kind, group in groups.items() if len(group) == 1 and isinstance(kind, str)}
    return Folded(
        exercise.name,
        first,
        tuple(groups[kind][0] for kind in groups if kind in alone),
        tuple(_fold(kind, group) for kind, group in groups.items() if kind not in alone),
        passed,
        started=not failed or bool(exercise.first),
    )


def _kind(test: CheckResult, first: CheckResult) -> str | tuple[str, str]:
    """What checks have in common: a message of their own, or what is said of one and of many."""
    if test.kind in TOGETHER:
        return TOGETHER[test.kind]
    message = without_numbers(test.message)
    said = without_numbers(first.message).splitlines()
    return ALIKE if set(message.splitlines()) <= set(said) else message


def _fold(kind: str | tuple[str, str], group: Sequence[CheckResult]) -> Fold:
    many = len(group) > 1
    says = f"{len(group)} more {kind[many]}." if isinstance(kind, tuple) else ""
    counts = Counter(test.title for test in group)
    titles = (f"{one} ({count} times)" if count > 1 else one for one, count in counts.items())
    says = says or f"{len(group)} more fail: {in_common([test.message for test in group])}"
    return Fold(says, len(group), tuple(titles))
