"""Verify the key of each question with a second method, in a new process.

Outcomes come from code that is not instrumented. Counts and values come from `sys.settrace`.
"""

from __future__ import annotations

import functools

from grader.questions.answer import Answer, Behaviour
from grader.questions.question import CountClaim, OutcomeClaim, Question, ValueClaim
from grader.sandbox import Limits, Sandbox
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from utils.questions.texts import outcome_text, same_answer, value_text

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
        self._outcome = functools.cache(self._compute_outcome)
        self._trace = functools.cache(self._compute_trace)

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
        """Return whether all claims of a question hold."""
        try:
            return all(map(self._holds, question.claims))
        except StudentError:
            return False
        except StudentStopped:
            self._read()  # a new process does not know the answer yet
            return False

    def _holds(self, claim: OutcomeClaim | CountClaim | ValueClaim) -> bool:
        match claim:
            case OutcomeClaim(code, edit, text, holds):
                outcome = self._outcome(code, edit and edit.row)
                return bool(outcome) and same_answer(outcome, text) == holds
            case CountClaim(code, line, count):
                return self._count(code, line) == count
            case ValueClaim(code, line, name, turn, text):
                place = self._places[line]
                rows = self._trace(code).get("notes")
                values = [
                    value_text(row[3])
                    for row in (rows if isinstance(rows, list) else ())
                    if isinstance(row, list) and len(row) == 4 and row[:3] == [*place, name]
                ]
                return turn < len(values) and values[turn] == text
        return False

    def _count(self, code: str, line: int) -> int:
        rows = self._trace(code).get("counts")
        counts = [
            row[2]
            for row in (rows if isinstance(rows, list) else ())
            if isinstance(row, list) and len(row) == 3 and row[:2] == self._places[line]
        ]
        return counts[0] if counts else 0

    def _compute_outcome(self, code: str, row: tuple | None) -> str:
        return outcome_text(self._student.evaluate(row and list(row), code))

    def _compute_trace(self, code: str) -> dict:
        reply = self._student.trace_case(code)
        return reply if isinstance(reply, dict) else {}
