"""A question with one right choice, and the claims from which its key follows."""

from __future__ import annotations

from dataclasses import dataclass

from grader.questions.answer import Edit

DEPTHS = {"predict": 1, "trace": 2, "cost": 3, "which line": 4, "what if": 5, "necessary": 6}
"""Kinds of questions, from the easiest to the hardest."""


@dataclass(frozen=True)
class OutcomeClaim:
    """A version of the answer has, or does not have, an outcome.

    Attributes
    ----------
    code : str
        Statements of the case.
    edit : Edit or None
        None for the student's own version.
    text : str
    holds : bool
        False if the outcome must be different.
    """

    code: str
    edit: Edit | None
    text: str
    holds: bool = True


@dataclass(frozen=True)
class CountClaim:
    """A line runs a number of times."""

    code: str
    line: int
    count: int


@dataclass(frozen=True)
class ValueClaim:
    """A variable has a value after a line has run for the n-th time, counted from 0."""

    code: str
    line: int
    name: str
    turn: int
    text: str


@dataclass(frozen=True)
class Question:
    """A question about an answer.

    Attributes
    ----------
    kind : str
        One of `DEPTHS`.
    text : str
        The question; code is between backticks.
    code : str
        The call or calls that the question is about.
    choices : tuple of str
    key : int
        Index of the right choice.
    reason : str
        Sentence for the examiner about the right choice.
    is_about_code : bool
        False if all right answers have the same key, so the question is about the algorithm.
    claims : tuple
        What `grader.questions.verification` computes again.
    """

    kind: str
    text: str
    code: str
    choices: tuple[str, ...]
    key: int
    reason: str
    is_about_code: bool
    claims: tuple[OutcomeClaim | CountClaim | ValueClaim, ...]

    @property
    def right_choice(self) -> str:
        """The right choice."""
        return self.choices[self.key]

    @property
    def right_letter(self) -> str:
        """The letter of the right choice."""
        return "ABCD"[self.key]
