"""Declare checks, and run them in a notebook."""

from __future__ import annotations

import importlib
import pkgutil
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from types import FunctionType
from typing import TYPE_CHECKING

from utils.checks.code_slips import find_code_slip
from utils.checks.compiled import as_python
from utils.checks.diagnosis import Mistake, diagnose, object_to_diagnose
from utils.checks.failures import (
    CallStopped,
    CheckFailed,
    ExceptionRaised,
    NotStarted,
    UnusableModule,
)
from utils.checks.import_guard import BlockedModules
from utils.checks.limits import TimeUp, limit_resources
from utils.checks.line_hint import find_line_hint
from utils.checks.outcomes import Check, Outcome
from utils.checks.run_cache import cached_run
from utils.checks.static_analysis import (
    absent_modules,
    forbidden_modules,
    functions_used,
    refused_modules,
)
from utils.checks.summary import summarise
from utils.checks.timeouts import explanation, loops_around
from utils.checks.tips import locate, tip_for, unwritten_function
from utils.checks.waiting_cells import record_result
from utils.in_sandbox import ABSENT, CALL_SECONDS
from utils.lent.events import report_check
from utils.lent.stubs import own

if TYPE_CHECKING:
    from utils.checks.display import Table

# Time limit of one check, more than any right answer needs on a slow machine. It stops endless
# loops.
SECONDS = 15
# Processor time for all checks of an exercise. An answer that needs more is right but slow; the
# solutions need less than one second.
SLOW_SECONDS = 4.0

# The checks of each exercise. Importing a module or package `lesson_NN` adds its checks.
_CHECKS: dict[str, list[Check]] = {}


class ChecksFailed(AssertionError):
    """At least one check failed. A notebook shows only the message; nbgrader gives 0 points."""

    def _render_traceback_(self) -> list[str]:
        return [str(self)]


def visible_check(
    exercise: str, *, title: str, why: str, hint: str, weight: float = 1.0, slow: str = ""
) -> Callable:
    """Declare the decorated function, which takes the student's function, as a visible check.

    Parameters
    ----------
    exercise : str
        Name of the student's function.
    title, why, hint : str
    weight : float
    slow : str
        As in `Check`.

    Returns
    -------
    callable
        The decorator; it returns the function unchanged.

    Raises
    ------
    ValueError
        If another lesson has an exercise with that name, because its checks would count in both.
    """

    def declare(run: Callable) -> Callable:
        declared = Check(run.__name__, exercise, title, hint, weight, why, run, slow)
        others = _CHECKS.setdefault(exercise, [])
        if others and others[0].lesson != declared.lesson:
            raise ValueError(
                f"{declared.lesson} and {others[0].lesson} both have an exercise {exercise}. "
                "Rename one of them."
            )
        others.append(declared)
        return run

    return declare


def note_check(exercise: str, *, title: str, why: str) -> Callable:
    """Declare a check that costs no points; if it fails, `check` shows an amber note.

    Parameters
    ----------
    exercise : str
    title, why : str
        As in `Check`; `why` names the later cells that rely on the property.

    Returns
    -------
    callable
        The decorator; it returns the function unchanged.
    """
    return visible_check(exercise, title=title, why=why, hint="", weight=0)


def checks_of(exercise: str) -> tuple[Check, ...]:
    """Return the visible checks of an exercise that give points, in the order of declaration.

    Parameters
    ----------
    exercise : str
        Name of a function of the course.

    Raises
    ------
    LookupError
        If the course has no such exercise.
    """
    return tuple(declared for declared in _checks_and_notes_of(exercise) if not declared.is_note)


def notes_of(exercise: str) -> tuple[Check, ...]:
    """Return the notes of an exercise, which cost no points; see `checks_of`."""
    return tuple(declared for declared in _checks_and_notes_of(exercise) if declared.is_note)


def _checks_and_notes_of(exercise: str) -> list[Check]:
    modules = _modules_of_lessons()
    while exercise not in _CHECKS and modules:
        importlib.import_module(modules.pop(0))
    if exercise not in _CHECKS:
        # Sort by lesson, because `_CHECKS` is in the order of imports.
        names = sorted(_CHECKS, key=lambda name: _CHECKS[name][0].lesson)
        raise LookupError(
            f"There are no checks for {exercise!r}. Pass one of these functions, without renaming "
            f"it: {', '.join(names)}."
        )
    return _CHECKS[exercise]


def _modules_of_lessons() -> list[str]:
    """Return the full names of the modules that declare checks, in the order of the course."""
    package = importlib.import_module("utils.checks")
    names = sorted(module.name for module in pkgutil.iter_modules(package.__path__))
    return [f"{package.__name__}.{name}" for name in names if name.startswith("lesson_")]


def run_check(one_check: Check, function: Callable) -> Outcome:
    """Run one check within the limits of time and memory."""
    try:
        with limit_resources(SECONDS):
            one_check.run(function)
    except CheckFailed as failure:
        return Outcome(one_check, failure)
    except TimeUp as over:
        return Outcome(one_check, _describe_timeout(one_check, over, function))
    except Exception as error:
        return Outcome(one_check, _describe_exception(one_check, error, function))
    return Outcome(one_check, None)


def _describe_timeout(one_check: Check, time_up: TimeUp, function: Callable) -> CallStopped:
    """Describe a call that exceeded its time limit, and the loop that it was in."""
    timeout = f"{one_check.exercise} did not return within {SECONDS} s"
    reason = explanation(loops_around(time_up.__cause__, function), one_check.slow)
    advice = "If one of your cells hangs, press the stop button ■ in the toolbar."
    return CallStopped(f"{timeout}{reason} {advice}")


def _describe_exception(one_check: Check, error: Exception, function: Callable) -> CheckFailed:
    """Explain an exception to the student whose function raised it."""
    exercise = one_check.exercise
    if isinstance(error, ImportError) and error.name in forbidden_modules(one_check.lesson):
        return _refuse_modules(exercise, [error.name])
    kind, (_, place, line) = type(error).__name__, locate(error, function)
    if isinstance(error, NotImplementedError):
        return NotStarted(exercise, unwritten_function(error, function) or exercise)
    tip = tip_for(kind, str(error), line)
    message = f"{exercise} raised {kind}: {error}"
    return ExceptionRaised(message, kind=kind, place=place, line=line, tip=tip)


def check(function: Callable, exercise: str | None = None) -> None:
    """Check your answer and show what is right, what is wrong and why it matters.

    Parameters
    ----------
    function : callable
        Your function or class for an exercise.
    exercise : str, optional
        Name of the exercise, if a class contains several. By default, the name of the function.

    Raises
    ------
    ChecksFailed
        If a check fails. All results are shown first.
    """
    from utils.checks.display import Table

    if isinstance(function, str):
        raise TypeError(f"Pass the function itself, without quotation marks: check({function})")
    written = own(function)
    function = as_python(written)
    exercise = exercise or getattr(function, "__name__", str(function))
    owner = object_to_diagnose(exercise)
    if owner != exercise and isinstance(function, FunctionType):
        raise TypeError(f'Pass the class: check({owner}, exercise="{exercise}")')
    checks = checks_of(exercise)
    table, start = Table(checks), time.process_time()
    if refused := refused_modules(_method_or_function(function, exercise), checks[0].lesson):
        outcomes = [Outcome(checks[0], _refuse_modules(exercise, refused))]
    elif absent := absent_modules(_method_or_function(function, exercise), checks[0].lesson):
        outcomes = [Outcome(checks[0], _report_missing_modules(exercise, absent))]
    else:
        outcomes = _run_all(checks, function, table)
    seconds = time.process_time() - start
    failed = [outcome for outcome in outcomes if outcome.failure]
    mistake = wrong_helper = hint = slip = None
    # A function that exceeded its time limit would exceed it again. Stubs and refusals need no
    # diagnosis.
    if failed and not any(
        isinstance(outcome.failure, NotStarted | UnusableModule | CallStopped) for outcome in failed
    ):
        mistake, wrong_helper = (
            _find_mistake(exercise, function),
            _find_wrong_helper(exercise, function),
        )
        if not (mistake or wrong_helper):
            returned_none = any(outcome.failure.yours == "None" for outcome in failed)
            slip = find_code_slip(_written_function(function, exercise), returned_none)
        if not wrong_helper and threading.current_thread() is threading.main_thread():
            lost = [outcome.check for outcome in failed]
            hint = find_line_hint(function, checks, lost)
    notes = [] if failed else [run_check(note, function) for note in notes_of(exercise)]
    has_notes = any(note.failure for note in notes)
    summary = summarise(outcomes, checks, mistake, notes, wrong_helper, hint, slip=slip)
    if not failed and seconds > SLOW_SECONDS:
        summary = replace(summary, notes=(*summary.notes, _make_slowness_note(exercise, seconds)))
    table.finish(summary)
    stopped = any(isinstance(outcome.failure, CallStopped) for outcome in failed)
    record_result(exercise, written, not summary.first, has_notes)
    report_check(exercise, not summary.first, stopped)
    if summary.first:
        raise ChecksFailed(summary.in_one_line)


def _make_slowness_note(exercise: str, seconds: float) -> Outcome:
    """Return the note on an answer that is right but slow."""
    note = Check(
        "is_slow",
        exercise,
        title="The answer is right, but slow",
        hint="",
        weight=0,
        why="A scanner delivers ten scans a second.",
    )
    message = (
        f"All checks together took {seconds:.0f} s. The judge may use larger clouds, and it waits "
        f"at most {CALL_SECONDS:.0f} s for each answer."
    )
    return Outcome(note, CheckFailed(message))


def _method_or_function(function: Callable, exercise: str) -> Callable:
    """Return the method that solves an exercise if the function is a class, else the function."""
    return vars(function).get(exercise, function) if isinstance(function, type) else function


def _written_function(function: Callable, exercise: str) -> Callable:
    """Return the function that solves an exercise, even if a method of the class only calls it."""
    method = _method_or_function(function, exercise)
    names = getattr(getattr(method, "__code__", None), "co_names", ())
    return method.__globals__.get(exercise, method) if names == (exercise,) else method


def _run_all(checks: tuple[Check, ...], function: Callable, table: Table) -> list[Outcome]:
    """Run checks with forbidden modules blocked; if one is used, return only the refusal."""
    with BlockedModules(forbidden_modules(checks[0].lesson)) as blocked:
        outcomes = None
        while outcomes is None:
            outcomes = _run_each(checks, function, table, blocked)
    failures = [outcome.failure for outcome in outcomes]
    refused = next((failure for failure in failures if isinstance(failure, UnusableModule)), None)
    return [Outcome(checks[0], refused)] if refused else outcomes


def _run_each(
    checks: tuple[Check, ...], function: Callable, table: Table, blocked: BlockedModules
) -> list[Outcome] | None:
    """Run checks and show each result; stop after a timeout, a stub or a refusal.

    Return None if the function has imported a forbidden module. That module is blocked now, so the
    checks must start again.
    """
    outcomes = []
    with cached_run():
        for one_check in checks:
            outcomes.append(run_check(one_check, function))
            if blocked.hide():
                return None
            table.show(outcomes)
            if isinstance(outcomes[-1].failure, CallStopped | NotStarted | UnusableModule):
                break
    return outcomes


def _refuse_modules(exercise: str, modules: list[str]) -> UnusableModule:
    names = " and ".join(modules)
    return UnusableModule(
        f"{exercise} uses {names}, which is not allowed in this lesson: it does the exercise for "
        "you. The judge gives no points for such an answer."
    )


def _report_missing_modules(exercise: str, modules: list[str]) -> UnusableModule:
    names = " and ".join(modules)
    return UnusableModule(f"{exercise} uses {names}, but {ABSENT}.")


def _find_mistake(exercise: str, function: Callable) -> Mistake | None:
    try:
        with limit_resources(SECONDS):
            return diagnose(exercise, function)
    except TimeUp:
        return None


def _find_wrong_helper(exercise: str, function: Callable) -> str | None:
    """Return an exercise of the same lesson that the function calls and that fails its checks.

    Classes are not searched, because the exercises of a class are methods that call each other.
    """
    if isinstance(function, type):
        return None
    lesson = checks_of(exercise)[0].lesson
    for name, helper in functions_used(function).items():
        if name != exercise and name in _CHECKS and checks_of(name)[0].lesson == lesson:
            for one_check in checks_of(name):
                if run_check(one_check, helper).failure:
                    return name
    return None
