"""Verify the key of each question with a second method, in a new process.

Outcomes come from code that is not instrumented. Counts and values come from `sys.settrace`. Both
are computed with several choices of eigenvectors, because students cannot know which ones NumPy
returns.
"""

from __future__ import annotations

import functools

from grader.questions.answer import Answer, Behaviour
from grader.questions.question import CountClaim, OutcomeClaim, Question, ValueClaim
from grader.sandbox import Limits, Sandbox
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from utils.questions.texts import outcome_texts, reversed_vector, same_answer, value_text

CALL_SECONDS = 0.5  # for one case; a right answer needs some milliseconds


class Verifier:
    """Recomputes claims about one answer. Use it in a with block.

    Parameters
    ----------
    behaviour : grader.questions.answer.Behaviour
    sandbox : grader.sandbox.Sandbox
    limits : grader.sandbox.Limits, optional
    """

    def __init__(
        self, behaviour: Behaviour, sandbox: Sandbox, limits: Limits | None = None
    ) -> None:
        answer: Answer = behaviour.answer
        self._places = {line.number: [line.cell, line.line] for line in behaviour.lines}
        self._student = StudentProxy(answer.program, sandbox, limits)
        self._request = answer.request
        self._outcomes = functools.cache(self._compute_outcomes)
        self._traces = functools.cache(self._compute_traces)

    def __enter__(self) -> Verifier:
        self._read()
        return self

    def _read(self) -> None:
        self._student.interrupts_after = None
        self._student.read_answer(*self._request)
        self._student.interrupts_after = CALL_SECONDS

    def __exit__(self, *error: object) -> None:
        self._student.close()

    def confirms(self, question: Question) -> bool:
        """Return whether all claims of a question hold, and only one choice can be right."""
        try:
            if not all(map(self._holds, question.claims)):
                return False
            opposite = reversed_vector(question.right_choice)
            return not (self.has_free_signs(question) and opposite in question.choices)
        except StudentError:
            return False
        except StudentStopped:
            self._read()  # a new process does not know the answer yet
            return False

    def _holds(self, claim: OutcomeClaim | CountClaim | ValueClaim) -> bool:
        match claim:
            case OutcomeClaim(code, edit, text, True):
                return _are_all(text, self._outcomes(code, edit and edit.row))
            case OutcomeClaim(code, edit, text, False):
                outcomes = self._outcomes(code, edit and edit.row)
                return all(outcomes) and not any(same_answer(outcome, text) for outcome in outcomes)
            case CountClaim(code, line, count):
                return {self._count(trace, line) for trace in self._traces(code)} == {count}
            case ValueClaim(code, line, name, turn, text):
                return _are_all(text, self._values(code, line, name, turn))
        return False

    def has_free_signs(self, question: Question) -> bool:
        """Return whether the result of a question might as well have all signs reversed."""
        others = []  # results with other vectors than NumPy's
        for claim in question.claims:
            match claim:
                case OutcomeClaim(code, edit, _, True):
                    others += self._outcomes(code, edit and edit.row)[1:]
                case ValueClaim(code, line, name, turn, _):
                    others += self._values(code, line, name, turn)[1:]
        opposite = reversed_vector(question.right_choice)
        return opposite != question.right_choice and opposite in others

    def _values(self, code: str, line: int, name: str, turn: int) -> list[str]:
        """Return the value of a variable in each trace; empty if it has none."""
        results = []
        for trace in self._traces(code):
            rows = trace.get("notes")
            values = [
                value_text(row[3])
                for row in (rows if isinstance(rows, list) else ())
                if isinstance(row, list)
                and len(row) == 4
                and row[:3] == [*self._places[line], name]
            ]
            results.append(values[turn] if turn < len(values) else "")
        return results

    def _count(self, trace: dict, line: int) -> int:
        rows = trace.get("counts")
        counts = [
            row[2]
            for row in (rows if isinstance(rows, list) else ())
            if isinstance(row, list) and len(row) == 3 and row[:2] == self._places[line]
        ]
        return counts[0] if counts else 0

    def _compute_outcomes(self, code: str, row: tuple | None) -> list[str]:
        return outcome_texts(self._student.evaluate(row and list(row), code))

    def _compute_traces(self, code: str) -> list[dict]:
        reply = self._student.trace_case(code)
        traces = reply if isinstance(reply, list) else []
        return [trace for trace in traces if isinstance(trace, dict)]


def _are_all(text: str, results: list[str]) -> bool:
    """Return whether the first result equals a text, and the others up to reversed signs."""
    return bool(results) and all(
        same_answer(result, text) or (index and same_answer(result, reversed_vector(text)))
        for index, result in enumerate(results)
    )
