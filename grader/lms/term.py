"""A student's total over the term, from which the lowest lessons may be left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from grader.course.deadlines import TermRules
from grader.lms.results import WAITING, NotebookResult, rounded_points


@dataclass(frozen=True)
class TermResult:
    """A student's total over all lessons that count so far.

    Attributes
    ----------
    points : float or None
        Points after penalties; None if the student has no mark yet.
    max_score : float
        Possible points; 0 if nothing counts, because the student is excused or an auditor.
    dropped : tuple of str
        Lessons that are left out.
    is_waiting : bool
        Whether work waits for a grader or is not entered yet, so that the total is not final.
    passed : bool or None
        Whether the points reach the pass mark; None if there is no pass mark or no final total.
    """

    points: float | None
    max_score: float
    dropped: tuple[str, ...] = ()
    is_waiting: bool = False
    passed: bool | None = None

    @property
    def share(self) -> float | None:
        """Fraction of the possible points; None without a mark."""
        return None if self.points is None or not self.max_score else self.points / self.max_score


def term_result(notebooks: Sequence[NotebookResult], rules: TermRules) -> TermResult:
    """Combine a student's results in all lessons.

    The lessons with the lowest share of their points are dropped, which never lowers the share of
    the total. A missing lesson has the share 0. One lesson always remains.
    """
    counted = [result for result in notebooks if result.counts]
    if not counted:
        return TermResult(None, 0.0)
    dropped = sorted(counted, key=_share)[: min(rules.drop_lowest, len(counted) - 1)]
    kept = [result for result in counted if result not in dropped]
    has_mark = any(result.points is not None for result in counted)
    points = sum(result.points or 0.0 for result in kept)
    maximum = sum(result.max_score for result in kept)
    waiting = any(result.status == WAITING for result in counted)
    passed = None
    if rules.pass_mark is not None and not waiting:
        # Points are shown with two decimal places, and the shown number decides.
        passed = round(points, 2) >= round(maximum * rules.pass_mark / 100, 2)
    return TermResult(
        points if has_mark else None,
        maximum,
        tuple(sorted(result.lesson for result in dropped)),
        waiting,
        passed,
    )


def describe_term(term: TermResult, rules: TermRules) -> str:
    """Describe a student's total in a sentence."""
    if not term.max_score:
        return "No lesson counts."
    if term.points is None:
        phrases = ["no mark yet"]
    else:
        phrases = [
            f"{rounded_points(term.points)} of {rounded_points(term.max_score)} points "
            f"({rounded_points(100 * term.share)} %)"
        ]
    phrases += [f"without {', '.join(term.dropped)}"] * bool(term.dropped)
    phrases += ["not final, because work is waiting for a grader"] * term.is_waiting
    if term.passed is not None:
        verb = "reaches" if term.passed else "does not reach"
        phrases.append(f"{verb} the pass mark of {rules.pass_mark:g} %")
    return f"{'; '.join(phrases)}."


def _share(result: NotebookResult) -> tuple[float, float]:
    """Return a sort key: the share of the points and, for equal shares, the most points first."""
    share = (result.points or 0.0) / result.max_score if result.max_score else 1.0
    return share, -result.max_score
