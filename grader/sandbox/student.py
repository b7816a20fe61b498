"""The judge's side of the pipe: call a student's functions as if they were local.

``student.longest_run(values)`` sends the values to the sandbox and returns the result in the reply.
Replies are untrusted. They contain plain data, numbers of objects that stay in the sandbox, or an
exception. A function cannot change the caller's objects, but `RemoteFunction.observe` returns the
arguments as the function left them.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

from grader.sandbox.error_descriptions import describe_failed_cell
from grader.sandbox.failures import (
    MAX_LINES,
    CellSkipped,
    StudentError,
    StudentStopped,
    explain_process_end,
)
from grader.sandbox.inside import wire, wire_format
from grader.sandbox.program import Program, cell_and_line
from grader.sandbox.protocol import Limits, Sandbox, Worker
from grader.sandbox.reply_parser import (
    has_valid_object,
    parse_edits,
    parse_positions,
    parse_rows,
    parse_text,
    parse_texts,
)
from grader.sandbox.time_budget import Budget, Meter, TimeLimit
from utils.remote_objects import ENDLESS_LOOP_HINT, ObservedCall, RemoteProxy

# Names of two steps that precede the exercises: running the cells that they need, or all cells.
_NEEDED_CELLS, _ALL_CELLS = "the cells that are needed", "all cells"
# Once the failed calls of a step have together used up its time limit, each later call gets only
# this share of the limit. An endless loop then costs little more than one limit.
SHARE_AFTER_FAILURES = 1 / 8
# The exception that the worker raises in a call that it interrupts.
CALL_TIMEOUT = "CallTimeout"
# Maximum number of failed cells that are described. Later cells usually fail because of these.
MAX_FAILED_CELLS = 3


@dataclass(frozen=True)
class _Reference:
    """A reference to an object in a worker, which may have been stopped in the meantime."""

    number: int
    worker: Worker


class RemoteFunction(RemoteProxy):
    """A function, class or method in the sandbox that can be called or observed."""

    def __init__(
        self, student: StudentProxy, name: str, reference: _Reference | None = None
    ) -> None:
        self._student, self.__name__, self._reference = student, name, reference

    def __call__(self, *arguments: object, **keywords: object) -> object:
        """Return the result of a call."""
        return self._student._call_or_get(self.__name__, [arguments], keywords, self._reference)

    def observe(self, *arguments: object) -> ObservedCall:
        """Return the result of a call, and the arguments as they are after the call."""
        return self._student._call_or_get(
            self.__name__, [arguments], reference=self._reference, observe=True
        )

    def timed(self, *arguments: object) -> tuple[object, float]:
        """Return the result of a call, and its duration in seconds as measured by a `Meter`."""
        student = self._student
        student._ensure_running()
        meter = student._meter = Meter(student._worker)
        try:
            answer = self(*arguments)
        finally:
            student._meter = None
        meter.measure(answered=True)
        return answer, meter.seconds

    def each(self, calls: Sequence[Sequence]) -> list:
        """Return the results of several calls that share one message and one call's time limit."""
        return (
            self._student._call_or_get(
                self.__name__, calls, reference=self._reference, many_calls=True
            )
            if calls
            else []
        )


class RemoteObject(RemoteProxy):
    """An object of a student's own class, which stays in the sandbox.

    ``tree.root`` returns plain data, None or another `RemoteObject`. ``tree.insert(p, 0)`` calls a
    method.
    """

    def __init__(self, student: StudentProxy, reference: _Reference, type_name: str) -> None:
        self._student, self._reference = student, reference
        self.type_name = type_name

    def __repr__(self) -> str:
        return "<an object of the student>"

    def __getattr__(self, name: str) -> object:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._student._call_or_get(name, reference=self._reference, call=False)

    def reach(self, names: Sequence[str]) -> object:
        """Return the attribute at the end of a path, such as ``["root", "left"]``."""
        return self._student._call_or_get(".".join(names), reference=self._reference, call=False)


class StudentProxy:
    """Proxy for the functions of one notebook.

    Parameters
    ----------
    program : grader.sandbox.program.Program
        The notebook's code and the rules of its lesson.
    sandbox : grader.sandbox.Sandbox
        Starts the worker, and a new worker after one has been stopped.
    limits : grader.sandbox.Limits, optional
    budget : grader.sandbox.time_budget.Budget, optional
        The remaining time of the notebook; by default the full time.
    edited : str, optional
        An exercise for which edits are requested.

    Attributes
    ----------
    problems : list of str
        One sentence for each problem in the notebook's own cells.
    uses : dict of str to tuple of str
        The functions that each function calls, according to the notebook's source.
    newer_names : dict of str to str
        The part of the notebook that only a newer Python can run, by the function that needs it.
    exercise : str
        The exercise to which the next calls belong. Failed calls are counted separately for each
        exercise, so that an endless loop does not use up the restarts of other exercises.
    edits : tuple of tuple
        Edits of the exercise `edited`, likeliest first; empty before the start. Each edit consists
        of the cell's number, the first and last line, and the text that replaces these lines.
    edit_failed : bool
        Whether the edit that `edit` chose last could not be applied.
    largest_reply : int
        Bytes of the largest reply. The owner of the proxy may reset it.
    interrupts_after : float or None
        Processor seconds after which the worker interrupts a call by raising `CALL_TIMEOUT`. If
        None, only the limits end a call, and they also end its process.
    """

    def __init__(
        self,
        program: Program,
        sandbox: Sandbox,
        limits: Limits | None = None,
        budget: Budget | None = None,
        edited: str = "",
    ) -> None:
        self._edited, self.edits = edited, ()
        self._new_edit: int | None = None  # an edit that has not been sent yet
        self.edit_failed = False
        self._program, self._sandbox, self._limits = program, sandbox, limits or Limits()
        self._worker, self._missing, self._calls = None, set(), 0
        # A reply may contain more attributes than requested. They are valid until the next call,
        # which may change them. Methods stay valid.
        self._known: dict[tuple[int, str], object] = {}
        self._methods: dict[tuple[int, str], RemoteFunction] = {}
        self._stops: dict[str, list[StudentStopped]] = {}
        self._budget = budget or Budget(self._limits)
        # A step that took too long for an earlier proxy with the same budget gets no restarts.
        self._timed_out_before = frozenset(self._budget.timeouts)
        self._has_reported, self._last_seconds, self._past_seconds = False, 0.0, 0.0
        self.interrupts_after: float | None = None
        self._meter: Meter | None = None  # only while a call is timed
        self.problems, self.exercise, self.largest_reply = [], "", 0
        self.uses: dict[str, tuple[str, ...]] = {}
        self.newer_names: dict[str, str] = {}
        self._skipped: dict[str, str] = {}  # texts about functions in skipped cells
        self._lines: dict[str, list[list[int]]] = {}
        self._own_lines: dict[str, list[list[int]]] = {}  # without the lines of other exercises

    def __enter__(self) -> StudentProxy:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __getattr__(self, name: str) -> RemoteFunction:
        if name.startswith("_") or name not in self._program.names:
            raise AttributeError(name)
        return RemoteFunction(self, name)

    def start(self) -> None:
        """Start a worker, and run the cells that the functions need."""
        self._ensure_running()

    def edit(self, number: int) -> None:
        """Apply one of `edits` to the exercise for all later calls.

        The edit is sent together with the next call, because each message takes as long as a call.
        `edit_failed` then says whether the edited code could not be run.
        """
        self._new_edit, self.edit_failed = number, False

    @property
    def starved(self) -> bool:
        """Whether the budget's notebook was starved; see `Budget`."""
        return self._budget.starved

    @property
    def cpu_seconds(self) -> float:
        """Seconds of processor time of all workers of this proxy so far."""
        return self._past_seconds + (self._worker.cpu_seconds() if self._worker else 0.0)

    def close(self) -> None:
        """Stop the worker, if there is one."""
        if self._worker:
            self._worker.stop()
            self._worker = None

    def _call_or_get(
        self,
        name: str,
        calls: Sequence[Sequence] = (),
        keywords: dict | None = None,
        reference: _Reference | None = None,
        call: bool = True,
        observe: bool = False,
        many_calls: bool = False,
    ) -> object:
        """Call a function or a method of a remote object, or get an attribute.

        With `many_calls`, make all calls and return a list of plain results, or raise the first
        exception. Otherwise, `calls` contains at most one call.
        """
        self._check_exists(name, reference)
        if call:
            self._known.clear()
        else:
            for known in (self._methods, self._known):
                if (reference.number, name) in known:
                    return known[reference.number, name]
        request = {
            "name": name,
            "calls": [list(arguments) for arguments in calls],
            "keywords": keywords or {},
            "object": reference and reference.number,
            "observe": observe,
            "each": many_calls,
        }
        reply = self._reply_to(request)
        result = self._parse_result(reply, name, reference, call)
        if many_calls and (not isinstance(result, list) or len(result) != len(calls)):
            self._stop_for_wrong_reply(name)
        self._remember(reply.get("nearby"))
        if not call:
            return self._known.get((reference.number, name), result)
        return self._parse_observed(reply, result, name, len(calls[0])) if observe else result

    def _check_exists(self, name: str, reference: _Reference | None) -> None:
        """Ensure that a worker is running and that the function or object exists in it."""
        if reference is not None and reference.worker is not self._worker:
            raise StudentStopped("The notebook's process was stopped, and its objects are lost.")
        self._ensure_running()
        if reference is None and name in self._missing:
            if name in self._skipped:
                raise CellSkipped(name, self._skipped[name])
            raise StudentError(
                name,
                "NameError",
                "the notebook does not define it; do not rename the lesson's functions",
            )

    def _reply_to(self, request: dict) -> dict:
        """Send a request and return the reply, after checking that it belongs to this request.

        If the reply reports an exception, raise it.
        """
        self._calls += 1
        name = request["name"]
        reply = self._exchange(
            self.exercise,
            f"{name} did not answer within {{seconds:g}} seconds; {ENDLESS_LOOP_HINT}",
            self._limits.call_seconds,
            {
                "id": self._calls,
                "seconds": self.interrupts_after,
                "edit": self._new_edit,
                **request,
            },
        )
        self._new_edit = None
        number = reply.get("id") if isinstance(reply, dict) else None
        if type(number) is not int or number != self._calls:
            self._stop_for_wrong_reply(name)
        self.edit_failed |= reply.get("edit_failed") is True
        if "error" in reply:
            self._budget.add_failed_seconds(self.exercise, self._last_seconds)
            error = self._student_error(name, reply["error"])
            stub = error.inside or name
            if error.type_name == "NotImplementedError" and stub in self._skipped:
                raise CellSkipped(stub, self._skipped[stub])
            raise error
        if not has_valid_object(reply):
            self._stop_for_wrong_reply(name)
        return reply

    def _parse_result(
        self, reply: dict, name: str, reference: _Reference | None, call: bool
    ) -> object:
        """Return the result in a reply, or a proxy if the object stays in the sandbox."""
        if "object" not in reply:
            return reply.get("result")
        if reply.get("callable") is True and not call:
            return RemoteFunction(self, name, reference)
        result = self._remote_object(reply["object"], reply.get("type"))
        for method in parse_texts(reply.get("methods")):
            function = RemoteFunction(self, method, result._reference)
            self._methods[result._reference.number, method] = function
        return result

    def _parse_observed(self, reply: dict, result: object, name: str, count: int) -> ObservedCall:
        """Return the result of a call with its `count` arguments after the call."""
        after, shared = reply.get("arguments"), reply.get("shared")
        if not isinstance(after, list) or len(after) != count:
            self._stop_for_wrong_reply(name)
        return ObservedCall(result, tuple(after), frozenset(parse_positions(shared)))

    def _stop_for_wrong_reply(self, name: str) -> NoReturn:
        self._stop(self.exercise, f"the process sent an invalid reply to a call of {name}")

    def _remote_object(self, number: int, kind: object) -> RemoteObject:
        return RemoteObject(self, _Reference(number, self._worker), wire_format.known_type(kind))

    def _remember(self, nearby: object) -> None:
        """Store the further attributes in a reply, because callers usually walk a whole tree."""
        plain, others = nearby if isinstance(nearby, list) and len(nearby) == 2 else ((), ())
        for number, name, value in parse_rows(plain, 3):
            self._known[number, name] = value
        for number, name, other, kind in parse_rows(others, 4):
            if type(other) is int:
                self._known[number, name] = self._remote_object(other, kind)

    def _student_error(self, name: str, error: object) -> StudentError:
        if not isinstance(error, dict):
            return StudentError(name, "Exception")
        kind, message, place, inside = (
            parse_text(error.get(key)) for key in ("type", "message", "place", "function")
        )
        line = self._program.line_at(place)
        place, line = (None, "") if line is None else (place, parse_text(line))
        lesson_functions = (*self._program.names, *self._program.steps)
        inside = inside if inside in lesson_functions else ""
        lines_of_exercise = self._lines.get(self.exercise, ())
        is_short = place is not None and _is_in_short_ranges(place, lines_of_exercise)
        call_place = place and self._find_call_place(place, parse_texts(error.get("through")))
        call_line = parse_text(call_place and self._program.line_at(call_place))
        return StudentError(
            name,
            kind or "Exception",
            message,
            place,
            line,
            inside,
            is_short,
            self._program.forbidden,
            call_place,
            call_line,
        )

    def _find_call_place(self, place: str, through: list[str]) -> str | None:
        """Return the place where the exercise calls the function that raised an exception.

        Return None if the exception was raised in the exercise itself, or if the exercise is long.
        """
        own = self._own_lines.get(self.exercise, ())
        if _is_in_short_ranges(place, own):
            return None
        return next(
            (caller for caller in reversed(through) if _is_in_short_ranges(caller, own)), None
        )

    def _sentences_on_cells(self, failures: object) -> list[str]:
        """Return a sentence for each of the first cells that failed."""
        failures = failures if isinstance(failures, list) else []
        sentences = [
            describe_failed_cell(self._student_error("", failure))
            for failure in failures[:MAX_FAILED_CELLS]
        ]
        more = len(failures) > MAX_FAILED_CELLS
        return [*sentences, *["Later cells failed as well."] * more]

    def _ensure_running(self) -> None:
        self._check_elapsed_time()
        if self._worker:
            return
        for task in (self.exercise, _NEEDED_CELLS):
            self._check_restarts(task)
        if self._budget.seconds <= 0:
            raise StudentStopped(
                f"Not run: the notebook had used up its {self._limits.total_seconds:.0f} seconds."
            )
        program = self._program
        self._known.clear()
        self._methods.clear()
        self._budget.cells_finish = False
        self._worker = self._sandbox.start(
            self._limits, program.forbidden, program.packages, program.named_packages
        )
        notebook_report = self._exchange_at_start(
            {
                "cells": list(program.cells),
                "names": list(program.names),
                "modules": program.modules,
                "edited": self._edited,
                "python": list(program.python),
                "given": {
                    "names": list(program.given.names),
                    "source": program.given.source,
                    "open": list(program.given.open_names),
                },
            },
            too_slow=f"The judge could not read the notebook's {len(program.cells):,} code cells "
            "within {seconds:g} seconds. Delete the cells that the exercises do not need.",
        )
        cells_report = self._exchange_at_start()
        self._budget.cells_finish = True
        self._missing = set(parse_texts(cells_report.get("missing"))) & set(program.names)
        if not self._has_reported:
            # `notebook_report` can be trusted, because the worker sent it before student code ran.
            # `cells_report` cannot be trusted.
            self.problems += parse_texts(
                notebook_report.get("problems")
            ) + self._sentences_on_cells(cells_report.get("problems"))
            self.uses = {name: tuple(used) for name, used in notebook_report["uses"].items()}
            self._skipped = {
                name: parse_text(text) for name, text in notebook_report["skipped"].items()
            }
            self.newer_names = {
                name: parse_text(text) for name, text in notebook_report["newer"].items()
            }
            self._lines, self._own_lines = notebook_report["lines"], notebook_report["own_lines"]
            self.edits = parse_edits(notebook_report.get("edits"))
            self._has_reported = True
        if self._missing and _ALL_CELLS not in (*self._stops, *self._budget.timeouts):
            self._try_whole_notebook()

    def _check_elapsed_time(self) -> None:
        # The first condition is much quicker to test than the second one.
        if time.monotonic() >= self._budget.deadline and self._budget.seconds_to_deadline() <= 0:
            self._budget.starved = True
            self.close()
            raise StudentStopped(f"Not run: {self._describe_elapsed_limit()}")

    def _describe_elapsed_limit(self) -> str:
        seconds = f"{self._limits.wall_seconds:g}"
        return f"the notebook has used up its {seconds} seconds of elapsed time."

    def _check_restarts(self, task: str) -> None:
        stops = self._stops.get(task, [])
        if len(stops) > (0 if task in self._timed_out_before else self._limits.restarts):
            code = "the notebook's own cells" if task == _NEEDED_CELLS else "this exercise's code"
            times = "once" if len(stops) == 1 else f"{len(stops)} times"
            raise StudentStopped(
                f"Not run: {code} had already been stopped {times}. {stops[-1]}",
                stops[-1].reason,
                stops[-1].out_of_time,
            )

    def _try_whole_notebook(self) -> None:
        """Run all cells, because they may define names in ways that the source does not show."""
        try:
            reply = self._exchange_at_start(
                {"all_cells": True}, _ALL_CELLS, self._limits.whole_seconds
            )
            self._missing &= set(parse_texts(reply.get("missing")))
        except StudentStopped:  # because of a cell that no exercise needs
            self._ensure_running()

    def _exchange_at_start(
        self,
        message: dict | None = None,
        task: str = _NEEDED_CELLS,
        seconds: float | None = None,
        too_slow: str = "The notebook's own cells did not finish within {seconds:g} seconds.",
    ) -> dict:
        """Perform one step of starting a notebook, and return the worker's reply."""
        seconds = self._limits.start_seconds if seconds is None else seconds
        try:
            answer = self._exchange(task, too_slow, seconds, message)
        except wire_format.TooLarge:
            self._stop(task, "The notebook is larger than the judge can send to the sandbox.")
        if not isinstance(answer, dict):
            self._stop(task, "The notebook's own cells sent the judge an invalid reply.")
        return answer

    def _exchange(
        self, task: str, too_slow: str, seconds: float, message: dict | None = None
    ) -> object:
        """Send a message, if any, and return the reply; stop the worker if there is no reply."""
        seconds *= (
            SHARE_AFTER_FAILURES if self._budget.failed_seconds.get(task, 0.0) >= seconds else 1.0
        )
        seconds = min(seconds, max(self._budget.seconds, 0.1))
        time_limit = TimeLimit(self._worker, seconds, self._budget.deadline, self._meter)
        try:
            return self._send_and_receive(message, time_limit)
        except wire.WireTimeout:
            self._budget.starved |= time_limit.starved
            if time.monotonic() >= self._budget.deadline:
                self._budget.deadline = -math.inf  # no more calls, even if the judge was busy
                self._stop(
                    task, f"The judge stopped the notebook: {self._describe_elapsed_limit()}"
                )
            sentence = too_slow.format(seconds=round(seconds, 1))
            reason = self._budget.timeouts.setdefault(task, sentence)
            self._stop(task, sentence, reason, out_of_time=task not in (_NEEDED_CELLS, _ALL_CELLS))
        except wire_format.WireError:
            self._stop(
                task,
                "The judge received an invalid reply, because code in the notebook wrote to the "
                "judge's own channel.",
            )
        except wire.WireClosed:
            self._stop(task, None)

    def _send_and_receive(self, message: dict | None, time_limit: TimeLimit) -> object:
        try:
            if message is not None:
                wire.send(self._worker.write_end, message, time_limit)
            tree, blob = wire.receive_bytes(self._worker.read_end, time_limit)
            self.largest_reply = max(self.largest_reply, len(tree) + len(blob))
            return wire_format.decode(tree, blob)
        finally:
            self._last_seconds = time_limit.used_seconds()
            self._budget.seconds -= self._last_seconds
            waiting_seconds = time_limit.waiting_seconds()
            if waiting_seconds and not time_limit.starved:
                self._budget.postpone_deadline(waiting_seconds)

    def _stop(
        self, task: str, sentence: str | None, reason: str = "", out_of_time: bool = False
    ) -> NoReturn:
        """Kill the worker, record which step was stopped and why, and raise `StudentStopped`."""
        self._budget.add_failed_seconds(task, self._last_seconds)
        self._past_seconds = self.cpu_seconds
        worker, self._worker = self._worker, None
        by_itself = sentence is None and worker.has_ended(2)  # it may only have closed its pipe
        code = worker.stop()
        self._budget.starved |= worker.lacked_memory()
        if sentence is None:
            sentence = explain_process_end(code if by_itself else None)
        stop = StudentStopped(sentence, reason, out_of_time)
        self._stops.setdefault(task, []).append(stop)
        raise stop from None


def _is_in_short_ranges(place: str, ranges: Sequence[Sequence[int]]) -> bool:
    """Return whether a place is in ranges of lines with at most `MAX_LINES` lines in total.

    The place comes from the student's process. In a long exercise, the line number could encode a
    message.

    Parameters
    ----------
    place : str
        A place such as ``code cell 3, line 12``.
    ranges : sequence of sequence of int
        Cell, first and last line of each part of an exercise.
    """
    cell, line = cell_and_line(place) or (0, 0)
    is_there = any(
        cell == range_cell and first <= line <= last for range_cell, first, last in ranges
    )
    return is_there and sum(1 + last - first for _, first, last in ranges) <= MAX_LINES
