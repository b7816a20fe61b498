"""Find the lines of a function in which one small change makes every visible check pass.

The changed functions run in a forked copy of this process, which ends afterwards. The copy writes
no files, opens no connections and draws nothing. It reports only the numbers of changes with which
every visible check passes.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from utils.checks.limits import limit_memory
from utils.checks.outcomes import Check
from utils.checks.run_cache import cached_run
from utils.display import shell
from utils.notebooks.edited_functions import Definition, edited_functions, read_definition
from utils.notebooks.edits import Edit

# Seconds for finding the first line, and for each further line. They are processor time, so that a
# busy machine finds the same lines; elapsed time may be PATIENCE times as long.
SECONDS, SECONDS_FOR_OTHERS, PATIENCE = 3.0, 1.0, 5
MAX_LINES = 3  # a hint with more lines would not say where to look
# Limit for one check, because a change may cause an endless loop.
SECONDS_OF_A_CHECK = 0.5
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
# Audit events with effects outside the process: https://docs.python.org/3/library/audit_events.html
_OUTSIDE_EVENTS = (
    *("os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.truncate"),
    *("os.chmod", "os.chown", "os.utime", "os.kill", "os.system", "os.exec", "os.fork"),
    *("os.posix_spawn", "os.spawn", "os.startfile", "subprocess.", "shutil.", "socket."),
    *("tempfile.", "webbrowser.", "urllib.", "ftplib.", "smtplib.", "signal.pthread_kill"),
)


@dataclass(frozen=True)
class Line:
    """A line of a cell: its number, its text, and whether another line should follow it."""

    number: int
    text: str
    is_incomplete: bool = False

    def __str__(self) -> str:
        return f"{'after' if self.is_incomplete else 'in'} line {self.number}, `{self.text}`"


@dataclass(frozen=True)
class LineHint:
    """Lines of a function; one change in any of them makes all checks pass."""

    lines: tuple[Line, ...]

    @property
    def sentence(self) -> str:
        """The hint for the student, as one sentence."""
        lines = ", or ".join(map(str, self.lines))
        return f"A single change {lines}, makes all checks here pass."


def find_line_hint(
    function: Callable, checks: Sequence[Check], failed: Sequence[Check]
) -> LineHint | None:
    """Return the lines of a function where one change makes all checks pass.

    Parameters
    ----------
    function : callable
        The student's function, or a class with a method that is the exercise.
    checks : sequence of utils.checks.outcomes.Check
        All visible checks of the exercise.
    failed : sequence of utils.checks.outcomes.Check
        The checks that the function fails.

    Returns
    -------
    LineHint or None
        None if no such line is found in time, if there are more than `MAX_LINES`, or if the
        system cannot fork a process.
    """
    exercise = checks[0].exercise
    with contextlib.suppress(OSError, TypeError, SyntaxError, ValueError):
        definition = read_definition(exercise, function)
        order = [*failed, *(check for check in checks if check not in failed)]
        passing = _find_passing_edits(function, definition, order)
        lines = tuple(_line_of(edit, definition) for edit in passing)
        return LineHint(lines) if 0 < len(lines) <= MAX_LINES else None
    return None


def _line_of(edit: Edit, definition: Definition) -> Line:
    row = definition.lines[edit.first - 1]
    # An edit that only inserts lines begins with the unchanged line before them.
    is_incomplete = edit.text.startswith(f"{row}\n")
    return Line(definition.first + edit.first - 1, row.strip(), is_incomplete)


def _find_passing_edits(
    function: Callable, definition: Definition, checks: list[Check]
) -> list[Edit]:
    """Find edits that make all checks pass, by line and at most one in each, in a forked copy."""
    if not hasattr(os, "fork"):
        return []
    read_end, write_end = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # fork does not copy other threads
        child = os.fork()
    if child == 0:
        try:
            _isolate()
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            for number in _search_passing_edits(function, definition, checks):
                os.write(write_end, b"%d " % number)
                signal.setitimer(signal.ITIMER_PROF, SECONDS_FOR_OTHERS)
        finally:
            os._exit(0)  # skips exit handlers and buffers, which belong to the notebook
    os.close(write_end)
    received, until = b"", time.monotonic() + PATIENCE * SECONDS
    try:
        while select.select([read_end], [], [], max(0.0, until - time.monotonic()))[0]:
            part = os.read(read_end, 1024)
            if not part:
                break
            received += part
    finally:
        os.close(read_end)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
    edits = [definition.edits[int(number)] for number in received.split()]
    return sorted(edits, key=lambda edit: edit.first)


def _search_passing_edits(
    function: Callable, definition: Definition, checks: list[Check]
) -> Iterator[int]:
    """Yield the index of each edit that makes all checks pass, at most one for each line.

    Only the likeliest edits count, because an unlikely edit may be far from the mistake that it
    cancels. An edit of the `def` line says nothing about the body of the function.
    """
    found, best = set(), None
    for edit, changed in edited_functions(function, definition.statement, definition.edits):
        line, rank = edit.first, edit.rank
        if best is not None and rank > best:
            return
        if line > 1 and line not in found and all(_passes(check, changed) for check in checks):
            best = rank
            found.add(line)
            yield definition.edits.index(edit)


def _isolate() -> None:
    """Keep the output and side effects of this process away from the notebook, files and screen."""
    with contextlib.suppress(Exception):
        shell().display_pub.publish = lambda *arguments, **keywords: None
    if "matplotlib" in sys.modules:
        import matplotlib

        matplotlib.use("agg")
    nowhere = os.open(os.devnull, os.O_RDWR)
    for standard in (0, 1, 2):
        os.dup2(nowhere, standard)
    sys.stdin = open(os.devnull)  # noqa: SIM115 (this process ends with it)
    sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115

    def refuse(event: str, arguments: tuple) -> None:
        if event.startswith(_OUTSIDE_EVENTS) or (event == "open" and arguments[2] & _WRITING):
            raise PermissionError(event)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGPROF, signal.SIG_DFL)  # ends this process
    for clock in (signal.SIGVTALRM, signal.SIGALRM):
        signal.signal(clock, _raise_timeout)
    sys.addaudithook(refuse)


def _raise_timeout(*_: object) -> None:
    raise TimeoutError


def _passes(check: Check, function: Callable) -> bool:
    signal.setitimer(signal.ITIMER_VIRTUAL, SECONDS_OF_A_CHECK)
    signal.setitimer(signal.ITIMER_REAL, PATIENCE * SECONDS_OF_A_CHECK)
    try:
        with limit_memory(), cached_run():
            check.run(function)
    except BaseException:
        return False
    finally:
        for clock in (signal.ITIMER_VIRTUAL, signal.ITIMER_REAL):
            signal.setitimer(clock, 0)
    return True
