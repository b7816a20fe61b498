"""Run small cases of a student's function, and of versions of it with one changed line."""

from __future__ import annotations

import ast
import contextlib
import io
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from utils.checks.limits import TimeUp, limit_resources
from utils.notebooks.edited_functions import edited_functions, function_with_code, read_definition
from utils.notebooks.small_cases import SEEDS, plain_value
from utils.questions.cases import Case
from utils.questions.changed_lines import as_written, is_readable
from utils.questions.choices import in_rounds
from utils.questions.texts import is_value, outcome_text

# Limits for all cases of one version; a right answer needs some milliseconds.
OWN_SECONDS, CHANGED_SECONDS = 10.0, 1.0
# After this processor time, no further versions are run. MAX_CHANGES is usually reached first.
MAX_CPU_SECONDS = 6.0
MAX_CHANGES = 40


@dataclass(frozen=True)
class Change:
    """A change of one line of a student's function.

    Attributes
    ----------
    line : int
        Number of the line in its cell.
    before, after : str
    function : callable
        The function, or the class, after the change.
    outcomes : tuple of str
        The outcome of each case.
    """

    line: int
    before: str
    after: str
    function: Callable
    outcomes: tuple[str, ...]


class Versions:
    """A student's function and its changed versions, after running all cases.

    Functions run in this process, without their output.

    Parameters
    ----------
    function : callable
        A function, or a class that contains the exercise.
    exercise : str
    cases : sequence of Case

    Attributes
    ----------
    source : str
        The definition of the exercise.
    own : tuple of str
        The outcome of each case with the student's own version; empty if the seed matters.
    changes : list of Change
        The likeliest changes of each line first.

    Raises
    ------
    utils.checks.limits.TimeUp
        If the function does not end in one of the cases.
    OSError, TypeError, SyntaxError, ValueError
        If the source of the function is not known.
    """

    def __init__(self, function: Callable, exercise: str, cases: tuple[Case, ...]) -> None:
        self.cases, self._function = cases, function
        definition = read_definition(exercise, function)
        self._names = function_with_code(exercise, function).__globals__
        self.source = "\n".join(definition.lines)
        with _limits(OWN_SECONDS):
            own = [self._outcome(function, case.code) for case in cases]
            self.own = tuple(
                text if self._confirms(function, case.code, text) else ""
                for case, text in zip(cases, own, strict=True)
            )
        shown = {
            edit: as_written(definition.lines[edit.first - 1], edit.text)
            for edit in definition.edits
            if edit.first == edit.last
            and edit.first > definition.statement.node.lineno  # not the `def` line
        }
        readable = [
            edit
            for edit, text in shown.items()
            if is_readable(definition.lines[edit.first - 1], text)
        ]
        self.changes = []
        until = time.process_time() + MAX_CPU_SECONDS
        for edit, changed in edited_functions(
            function, definition.statement, in_rounds(readable)[:MAX_CHANGES]
        ):
            if time.process_time() > until:
                break
            with contextlib.suppress(TimeUp), _limits(CHANGED_SECONDS):
                outcomes = tuple(self._outcome(changed, case.code) for case in cases)
                before = definition.lines[edit.first - 1].strip()
                line = definition.first + edit.first - 1
                after = shown[edit].strip()
                self.changes.append(Change(line, before, after, changed, outcomes))

    def values_near(self, case: int) -> Iterator[str]:
        """Yield the value of each changed version in a case."""
        return filter(is_value, (change.outcomes[case] for change in self.changes))

    def confirms(self, case: int, text: str, change: Change | None = None) -> bool:
        """Return whether a version returns the same value again, with each seed."""
        function = change.function if change else self._function
        with contextlib.suppress(TimeUp), _limits(CHANGED_SECONDS):
            return self._confirms(function, self.cases[case].code, text)
        return False

    def _confirms(self, function: Callable, code: str, text: str) -> bool:
        return all(self._outcome(function, code, seed) == text for seed in SEEDS)

    def _outcome(self, function: Callable, code: str, seed: int = SEEDS[0]) -> str:
        """Return the outcome of a case with a version, as a text."""
        names = {**self._names, "np": np, "rng": seed, function.__name__: function}
        *statements, last = ast.parse(code).body
        try:
            exec(compile(ast.Module(statements, []), "<case>", "exec"), names)
            value = eval(compile(ast.Expression(last.value), "<case>", "eval"), names)
        except Exception as error:
            return outcome_text(["error", type(error).__name__])
        return outcome_text(["value", plain_value(value)])


@contextlib.contextmanager
def _limits(seconds: float) -> Iterator[None]:
    """Limit time and memory in the context, and discard printed output and figures."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    figures = set(pyplot.get_fignums()) if pyplot else set()
    nowhere = io.StringIO()
    with (
        limit_resources(seconds),
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
        warnings.catch_warnings(action="ignore"),
    ):
        try:
            yield
        finally:
            for figure in set(pyplot.get_fignums()) - figures if pyplot else ():
                pyplot.close(figure)
