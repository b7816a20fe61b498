"""The judge's side of the pipe: a student's functions, called as if they were ours.

``student.filter_ground(cloud)`` sends the cloud into the sandbox and returns what comes back.
Everything that comes back is a claim by a stranger: plain data or an exception, no more. Nothing
that a function does to its arguments reaches our objects; `RemoteFunction.observe` looks at it.
"""

from __future__ import annotations

import builtins
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

from grader.sandbox.inside import wire
from grader.sandbox.patience import Patience, stopwatch
from grader.sandbox.program import Program
from grader.sandbox.protocol import Limits, Sandbox
from grader.sandbox.workers import Worker
from utils.checks.vocabulary import Observed

LONGEST_TEXT = 500
MOST_PROBLEMS = 20
# Names that say something and that student code did not choose.
KNOWN_EXCEPTIONS = {
    name
    for name, value in vars(builtins).items()
    if isinstance(value, type) and issubclass(value, BaseException)
} | {"LinAlgError", "AxisError", "QhullError"}


class StudentError(Exception):
    """A student's function raised; `str()` is the sentence to show.

    Attributes
    ----------
    type_name, message : str
        The student's words: not for the messages of hidden tests.
    place : str or None
        Where in the notebook, in our words.
    line : str
        What stands there, in the student's.
    inside : str
        The exercise that it happened in; empty where it was in none.
    without_words : str
        The same in our words alone: a type that Python or NumPy defines, and the place.
    """

    def __init__(
        self,
        function: str,
        type_name: str,
        message: str = "",
        place: str | None = None,
        line: str = "",
        inside: str = "",
    ) -> None:
        self.type_name, self.message = type_name, message
        self.place, self.line, self.inside = place, line, inside
        where = f" ({place})" if place else ""
        known = type_name if type_name in KNOWN_EXCEPTIONS else "an exception of its own"
        self.without_words = f"{function} raised {known}{where}."
        super().__init__(f"{function} raised {type_name}: {message}{where}")


class StudentStopped(Exception):
    """A student's process hung, died or broke the protocol; `str()` is the sentence to show."""


@dataclass(frozen=True)
class _Held:
    """Where an object is: under a number, in a worker that may be gone by now."""

    number: int
    worker: Worker


class RemoteFunction:
    """A function, a class or a method inside: call it, or observe what it does."""

    def __init__(self, student: Student, name: str, held: _Held | None = None) -> None:
        self._student, self.__name__, self._held = student, name, held

    def __call__(self, *arguments: object, **keywords: object) -> object:
        """Return what it returns."""
        return self._student._ask(self.__name__, [arguments], keywords, self._held)

    def observe(self, *arguments: object) -> Observed:
        """Call it, and look at what became of the arguments; see `utils.checks.vocabulary`."""
        return self._student._ask(self.__name__, [arguments], held=self._held, observe=True)

    def timed(self, *arguments: object) -> tuple[object, float]:
        """Return what it returns, and the seconds that it takes; see `stopwatch`."""
        self._student._ensure_running()
        stop = stopwatch(self._student._worker.cpu_seconds)
        answer = self(*arguments)
        seconds, starved = stop()
        self._student.starved |= starved
        return answer, seconds

    def each(self, calls: Sequence[Sequence]) -> None:
        """Call it with each of these arguments, in one message; they share the time of a call."""
        self._student._ask(self.__name__, calls, held=self._held)


class RemoteObject:
    """An object of a student's own class. It stays inside; its attributes and methods answer.

    ``tree.root`` is plain data, None, or a further `RemoteObject`; ``tree.insert(p, 0)`` calls.
    """

    def __init__(self, student: Student, held: _Held, type_name: str) -> None:
        self._student, self._held = student, held
        self.type_name = type_name

    def __repr__(self) -> str:
        return "<an object of the student>"

    def __getattr__(self, name: str) -> object:
        if name.startswith("_"):
            raise AttributeError(name)
        return self._student._ask(name, held=self._held, call=False)

    def reach(self, names: Sequence[str]) -> object:
        """Return where a way along attributes leads; see `utils.checks.vocabulary`."""
        return self._student._ask(".".join(names), held=self._held, call=False)


class Student:
    """Proxy for the functions of one notebook.

    Parameters
    ----------
    program : grader.sandbox.program.Program
    sandbox : grader.sandbox.Sandbox
    limits : grader.sandbox.Limits, optional

    Attributes
    ----------
    problems : list of str
        What was wrong with the notebook's own cells, one sentence each.
    uses : dict of str to tuple of str
        Which of the functions each of them calls, as the notebook's text says.
    exercise : str
        What is asked about now: an exercise that hangs costs the others nothing.
    starved : bool
        Whether a call was given up, or called slow, that had hardly had a processor: on a quieter
        machine it may be right.
    """

    def __init__(self, program: Program, sandbox: Sandbox, limits: Limits | None = None) -> None:
        self._program, self._sandbox, self._limits = program, sandbox, limits or Limits()
        self._worker, self._missing, self._calls = None, set(), 0
        # Attributes that came with another one, of the same object and of those that it leads to;
        # until something is called. Methods stay.
        self._known: dict[tuple[int, str], object] = {}
        self._methods: dict[tuple[int, str], RemoteFunction] = {}
        self._stops: dict[str, list[str]] = {}
        self._time_left = self._limits.total_seconds
        self._run_whole, self._told = True, False
        self.problems, self.exercise, self.starved = [], "", False
        self.uses: dict[str, tuple[str, ...]] = {}

    def __enter__(self) -> Student:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __getattr__(self, name: str) -> RemoteFunction:
        if name.startswith("_") or name not in self._program.names:
            raise AttributeError(name)
        return RemoteFunction(self, name)

    def close(self) -> None:
        """Stop the sandbox."""
        if self._worker:
            self._worker.stop()
            self._worker = None

    def _ask(
        self,
        name: str,
        calls: Sequence[Sequence] = (),
        keywords: dict | None = None,
        held: _Held | None = None,
        call: bool = True,
        observe: bool = False,
    ) -> object:
        """Call a function or a method of an object that is held inside, or ask for an attribute.

        Of several calls the last one's answer comes back, or the first exception.
        """
        if held is not None and held.worker is not self._worker:
            raise StudentStopped(
                "The notebook's process was stopped, and what it had built is gone."
            )
        self._ensure_running()
        if held is None and name in self._missing:
            raise StudentError(
                name,
                "NameError",
                "the notebook does not define it; keep the name of the function as it was given",
            )
        if call:
            self._known.clear()
        else:
            for known in (self._methods, self._known):
                if (held.number, name) in known:
                    return known[held.number, name]
        self._calls += 1
        request = {
            "id": self._calls,
            "name": name,
            "calls": [list(arguments) for arguments in calls],
            "keywords": keywords or {},
            "object": held and held.number,
            "observe": observe,
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
            raise self._error(name, reply["error"])
        if not _is_number(reply):
            self._stop(f"{name} did not answer the question that was asked")
        if "object" not in reply:
            result = reply.get("result")
        elif reply.get("callable") is True and not call:
            result = RemoteFunction(self, name, held)
        else:
            result = self._object(reply["object"], reply.get("type"))
            for method in _texts(reply.get("methods")):
                function = RemoteFunction(self, method, result._held)
                self._methods[result._held.number, method] = function
        self._remember(reply.get("beside"))
        if not call:
            result = self._known.get((held.number, name), result)
        if not observe:
            return result
        after, shared = reply.get("arguments"), reply.get("shared")
        if not isinstance(after, list) or len(after) != len(calls[0]):
            self._stop(f"{name} did not answer the question that was asked")
        return Observed(result, tuple(after), frozenset(_positions(shared)))

    def _object(self, number: int, kind: object) -> RemoteObject:
        return RemoteObject(self, _Held(number, self._worker), wire.known_type(kind))

    def _remember(self, beside: object) -> None:
        """Keep what came with an attribute: whoever asks for one walks the whole tree."""
        plain, others = beside if isinstance(beside, list) and len(beside) == 2 else ((), ())
        for number, name, value in _rows(plain, 3):
            self._known[number, name] = value
        for number, name, other, kind in _rows(others, 4):
            if type(other) is int:
                self._known[number, name] = self._object(other, kind)

    def _error(self, name: str, error: object) -> StudentError:
        if not isinstance(error, dict):
            return StudentError(name, "Exception")
        kind, message, place, inside = (
            _readable(error.get(key)) for key in ("type", "message", "place", "function")
        )
        line = self._program.line_at(place)
        place, line = (None, "") if line is None else (place, _readable(line))
        ours = (*self._program.names, *self._program.steps)
        inside = inside if inside in ours else ""
        return StudentError(name, kind or "Exception", message, place, line, inside)

    def _ensure_running(self) -> None:
        if self._worker:
            return
        stops = self._stops.get(self.exercise, [])
        if len(stops) > self._limits.restarts:
            raise StudentStopped(
                f"Not tried: this exercise's code had to be stopped {len(stops)} times before. "
                f"{stops[-1]}"
            )
        if self._time_left <= 0:
            raise StudentStopped(
                f"Not tried: the notebook had used up its {self._limits.total_seconds:.0f} seconds."
            )
        program = self._program
        self._known.clear()
        self._methods.clear()
        self._worker = self._sandbox.start(
            self._limits, program.forbidden, program.packages, program.named
        )
        found = self._start(
            {
                "cells": list(program.cells),
                "names": list(program.names),
                "modules": program.modules,
                "given": {"names": list(program.given.names), "source": program.given.source},
            }
        )
        failed = self._start()
        self._missing = set(_texts(failed.get("missing"))) & set(program.names)
        if not self._told:
            self.problems += _texts(found.get("problems")) + _texts(failed.get("problems"))
            self.uses = {name: tuple(used) for name, used in found["uses"].items()}
            self._told = True
        if self._missing and self._run_whole:
            self._try_whole_notebook()

    def _try_whole_notebook(self) -> None:
        """Run every cell, for names that nobody can read off the text."""
        try:
            found = self._start({"whole": True})
            self._missing &= set(_texts(found.get("missing")))
        except StudentStopped:  # a cell that hangs or quits: only now does it do harm
            self._run_whole = False
            self._stops[self.exercise].pop()
            self._ensure_running()

    def _start(self, message: dict | None = None) -> dict:
        """One step of starting a notebook."""
        too_slow = "The notebook's own cells did not finish within {seconds:.0f} seconds."
        answer = self._exchange(too_slow, self._limits.start_seconds, message)
        if not isinstance(answer, dict):
            self._stop("The notebook's own cells broke off the conversation with the judge.")
        return answer

    def _exchange(self, too_slow: str, seconds: float, message: dict | None = None) -> object:
        """Send a message, if any, and return the next one."""
        seconds = min(seconds, max(self._time_left, 0.1))
        patience = Patience(self._worker.cpu_seconds, seconds)
        try:
            if message is not None:
                wire.send(self._worker.write_end, message, patience)
            return wire.receive(self._worker.read_end, patience)
        except wire.WireTimeout:
            self.starved |= patience.starved
            self._stop(too_slow.format(seconds=seconds))
        except wire.WireError:
            self._stop(
                "What came back was not an answer: code in the notebook wrote to the "
                "judge's own channel."
            )
        except wire.WireClosed:
            self._stop(None)
        finally:
            self._time_left -= patience.taken

    def _stop(self, sentence: str | None) -> NoReturn:
        """Kill the worker, remember why, and say so."""
        worker, self._worker = self._worker, None
        by_itself = sentence is None and worker.has_ended(2)  # it may live on, pipe closed
        code = worker.stop()
        if sentence is None:
            sentence = _why_it_ended(code if by_itself else None)
        self._stops.setdefault(self.exercise, []).append(sentence)
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
    # Without the exit code: student code chooses it, and may have a hidden question in mind.
    return "The notebook's process ended in the middle of a call, as os._exit and the like do."


def _texts(values: object) -> list[str]:
    """A stranger's list of sentences, of which the first few are enough."""
    return (
        [_readable(value) for value in values[:MOST_PROBLEMS]] if isinstance(values, list) else []
    )


def _readable(value: object) -> str:
    """One line of text that is safe on a terminal: no colours, no commands, no turned lines."""
    text = value[:LONGEST_TEXT] if isinstance(value, str) else ""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _rows(columns: object, width: int) -> Iterator[tuple]:
    """Rows of a stranger's table that begin with a number and a name."""
    if not isinstance(columns, list) or [*map(type, columns)] != [list] * width:
        return
    for row in zip(*columns, strict=False):
        if type(row[0]) is int and type(row[1]) is str:
            yield row


def _is_number(told: dict) -> bool:
    """Whether an object that is told of comes under a number, if any is."""
    return "object" not in told or type(told["object"]) is int


def _positions(values: object) -> list[int]:
    return [v for v in values[:MOST_PROBLEMS] if type(v) is int] if isinstance(values, list) else []
