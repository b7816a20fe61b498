"""The judge's side of the pipe: a student's functions, called as if they were ours.

``student.filter_ground(cloud)`` sends the cloud into the sandbox and returns what comes back.
Everything that comes back is a claim by a stranger: plain data or an exception, no more.
"""

from __future__ import annotations

import contextlib
import subprocess
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NoReturn

from grader.sandbox import Sandbox
from grader.sandbox.inside import wire
from grader.sandbox.protocol import Limits
from grader.sandbox.workers import Worker

LONGEST_TEXT = 500
MOST_PROBLEMS = 20


class StudentError(Exception):
    """A student's function raised; `str()` is the sentence to show."""

    def __init__(self, function: str, type_name: str, message: str, place: str | None) -> None:
        self.type_name, self.message = type_name, message
        where = f" ({place})" if place else ""
        super().__init__(f"{function} raised {type_name}: {message}{where}")


class StudentStopped(Exception):
    """A student's process hung, died or broke the protocol; `str()` is the sentence to show."""


class RemoteObject:
    """An object of a student's own class. It stays inside; its attributes and methods answer.

    ``tree.root`` is plain data, None, or a further `RemoteObject`; ``tree.insert(p, 0)`` calls.
    """

    def __init__(self, student: Student, number: int, worker: Worker, type_name: str) -> None:
        self._student, self._held = student, _Held(number, worker)
        self.type_name = type_name

    def __repr__(self) -> str:
        return f"<{self.type_name} of the student>"

    def __getattr__(self, name: str) -> object:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._student._ask(name, held=self._held, call=False)


@dataclass(frozen=True)
class _Held:
    """Where an object is: under a number, in a worker that may be gone by now."""

    number: int
    worker: Worker


class Student:
    """Proxy for the functions of one notebook.

    Parameters
    ----------
    cells : list of str
        Source of the notebook's code cells.
    names : tuple of str
        The functions and classes that will be called.
    sandbox : grader.sandbox.Sandbox
    limits : grader.sandbox.Limits
    forbidden : tuple of str
        Modules that the lesson does not allow.

    Attributes
    ----------
    problems : list of str
        What was wrong with the notebook's own cells, one sentence each.
    """

    def __init__(
        self,
        cells: Iterable[str],
        names: Iterable[str],
        sandbox: Sandbox,
        limits: Limits | None = None,
        forbidden: Iterable[str] = (),
    ) -> None:
        self._cells, self._names, self._sandbox = list(cells), tuple(names), sandbox
        self._limits, self._forbidden = limits or Limits(), tuple(forbidden)
        self._worker, self._missing, self._stops, self._calls = None, set(), [], 0
        self._time_left = self._limits.total_seconds
        self.problems = []

    def __enter__(self) -> Student:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __getattr__(self, name: str) -> object:
        if name.startswith("_") or name not in self._names:
            raise AttributeError(name)

        def function(*arguments: object, **keywords: object) -> object:
            return self._ask(name, arguments, keywords)

        function.__name__ = name
        return function

    def close(self) -> None:
        """Stop the sandbox."""
        if self._worker:
            self._worker.stop()
            self._worker = None

    def _ask(
        self,
        name: str,
        arguments: Sequence = (),
        keywords: dict | None = None,
        held: _Held | None = None,
        call: bool = True,
    ) -> object:
        """Call a function, or a method or an attribute of an object that is held inside."""
        if held is not None and held.worker is not self._worker:
            raise StudentStopped(
                "The notebook's process was stopped, and what it had built is "
                f"gone. {self._stops[-1]}"
            )
        self._ensure_running()
        if held is None and name in self._missing:
            raise StudentError(
                name,
                "NameError",
                "the notebook does not define it; keep the name of the function as it was given",
                None,
            )
        self._calls += 1
        request = {
            "id": self._calls,
            "name": name,
            "arguments": list(arguments),
            "keywords": keywords or {},
            "call": call,
            "object": held and held.number,
        }
        reply = self._exchange(
            f"{name} did not answer within {{seconds:.0f}} seconds; "
            "is there a loop that never ends?",
            self._limits.call_seconds,
            request,
        )
        number = reply.get("id") if isinstance(reply, dict) else None
        if type(number) is not int or number != self._calls:
            self._stop(f"{name} did not answer the question that was asked")
        if "error" in reply:
            raise StudentError(name, *_read_error(reply["error"]))
        if "object" in reply:
            if reply.get("callable") is True and not call:
                return lambda *values, **options: self._ask(name, values, options, held)
            return RemoteObject(self, reply["object"], self._worker, _readable(reply.get("type")))
        _apply_changes(reply.get("changed"), arguments)
        return reply.get("result")

    def _ensure_running(self) -> None:
        if self._worker:
            return
        if len(self._stops) > self._limits.restarts:
            raise StudentStopped(
                f"Not tried: the notebook's code had to be stopped "
                f"{len(self._stops)} times before. {self._stops[-1]}"
            )
        if self._time_left <= 0:
            raise StudentStopped(
                f"Not tried: the notebook had used up its {self._limits.total_seconds:.0f} seconds."
            )
        self._worker = self._sandbox.start(self._limits, self._forbidden)
        first_time = not self.problems and not self._stops
        seconds = self._limits.start_seconds
        too_slow = "The notebook's own cells did not finish within {seconds:.0f} seconds."
        found = self._exchange(
            too_slow, seconds, {"cells": self._cells, "names": list(self._names)}
        )
        failed = self._exchange(too_slow, seconds)
        if not (isinstance(found, dict) and isinstance(failed, dict)):
            self._stop("The notebook's own cells broke off the conversation with the judge.")
        self._missing = {name for name in self._names if name in _texts(failed.get("missing"))}
        if first_time:
            self.problems += _texts(found.get("problems")) + _texts(failed.get("problems"))

    def _exchange(self, too_slow: str, seconds: float, message: dict | None = None) -> object:
        """Send a message, if any, and return the next one."""
        begin = time.monotonic()
        deadline = begin + min(seconds, max(self._time_left, 0.1))
        try:
            if message is not None:
                wire.send(self._worker.write_end, message, deadline)
            return wire.receive(self._worker.read_end, deadline)
        except wire.WireTimeout:
            self._stop(too_slow.format(seconds=deadline - begin))
        except wire.WireError:
            self._stop(
                "What came back was not an answer: code in the notebook wrote to the "
                "judge's own channel."
            )
        except wire.WireClosed:
            self._stop(None)
        finally:
            self._time_left -= time.monotonic() - begin

    def _stop(self, sentence: str | None) -> NoReturn:
        """Kill the worker, remember why, and say so."""
        worker, self._worker = self._worker, None
        if sentence is None:
            with contextlib.suppress(subprocess.TimeoutExpired):  # it may live on, pipe closed
                worker.process.wait(timeout=2)
            sentence = _why_it_ended(worker.process.poll())
        worker.stop()
        self._stops.append(sentence)
        raise StudentStopped(sentence) from None


def _why_it_ended(code: int | None) -> str:
    if code in (137, -9):
        return (
            "The system stopped the notebook's process: it asked for too much memory, or "
            "killed itself."
        )
    if code in (152, -24):
        return "The notebook's process used up its processor time; is there a loop without end?"
    if code in (139, -11):
        return "The notebook's process crashed (segmentation fault)."
    return (
        f"The notebook's process ended in the middle of a call (exit code {code}), as "
        "os._exit and the like do."
    )


def _read_error(error: object) -> tuple[str, str, str | None]:
    if not isinstance(error, dict):
        return "Exception", "", None
    texts = [_readable(error.get(key) or "") for key in ("type", "message", "place")]
    return texts[0] or "Exception", texts[1], texts[2] or None


def _apply_changes(changed: object, arguments: Sequence) -> None:
    """Write what the student changed in an argument into ours, as a local call would."""
    for position, value in (changed or {}).items() if isinstance(changed, dict) else ():
        if not isinstance(position, int) or not 0 <= position < len(arguments):
            continue
        ours = arguments[position]
        if hasattr(ours, "shape") and getattr(value, "shape", None) == ours.shape:
            if ours.flags.writeable:
                ours[...] = value
        elif isinstance(ours, list) and isinstance(value, list):
            ours[:] = value


def _texts(values: object) -> list[str]:
    """A stranger's list of sentences, of which the first few are enough."""
    return (
        [_readable(value) for value in values[:MOST_PROBLEMS]] if isinstance(values, list) else []
    )


def _readable(value: object) -> str:
    """One line of text that is safe on a terminal: no colours, no commands, no turned lines."""
    text = value[:LONGEST_TEXT] if isinstance(value, str) else ""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
