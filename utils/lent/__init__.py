"""The course's own answers, lent to who has not written a function yet.

``lesson_NN.json`` holds what the functions of a lesson answered in its solved notebook: labels,
boxes, numbers, and no code. Who is stuck can go on: a function that is still a stub answers the
calls that the notebook makes, and says whose answer it is.
`grader.course.lending` records the answers. Who has written one that does not pass its check gets
them where a cell fails for its sake; see `utils.lent.going_on`.
"""

from __future__ import annotations

import contextlib
import dis
import functools
import json
import re
from collections.abc import Callable, Collection, Iterator
from html import escape
from pathlib import Path
from types import FunctionType
from typing import TYPE_CHECKING

from utils.lent.encoding import decode, encode, key_of, rng_states, set_rng_states
from utils.showing import shell, show

if TYPE_CHECKING:
    from utils.lent.going_on import GoingOn

_HERE = Path(__file__).resolve().parent
# Written by `python -m grader build`: by which the cells of each lesson are known.
CELLS = _HERE / "cells.json"
# Of the lesson that lends in this kernel, by its number.
_LENDING: dict[str, GoingOn] = {}
# What asks functions on its own account, and not on the notebook's.
_UNHEARD = ("check", "replay", "show_broken", "tell_apart")


class NotLent(NotImplementedError):
    """The course lends nothing for this call. A notebook shows one line of it.

    Attributes
    ----------
    missing : str
        The function that would have to answer.
    """

    def __init__(self, missing: str, why: str) -> None:
        self.missing = missing
        super().__init__(
            f"{missing} {why}, and the course lends its answers only to the calls that stand in "
            "this notebook."
        )

    def _render_traceback_(self) -> list[str]:
        return [str(self)]


def lend_answers(number: str) -> None:
    """From now on, after each cell, lend answers to the stubs of a lesson, and go on with them.

    Parameters
    ----------
    number : str
        Of the lesson, such as "06". Without stored answers, or outside a notebook, nothing
        happens.
    """
    path = _HERE / f"lesson_{number}.json"
    if shell() is None or not path.exists() or number in _LENDING:
        return
    from utils.lent.going_on import GoingOn

    lender = Lender(json.loads(path.read_text("utf-8")), shell().user_ns)
    cells = json.loads(CELLS.read_text("utf-8")).get(number, [])
    going_on = GoingOn(lender, shell().user_ns, cells, shell().showtraceback)
    _LENDING[number] = going_on
    shell().showtraceback = going_on.show_traceback
    shell().events.register("pre_run_cell", going_on.before_cell)
    shell().events.register("post_run_cell", going_on.after_cell)
    shell().events.register("post_run_cell", lender.look_round)


def hear(exercise: str, passed: bool, hangs: bool = False) -> None:
    """Learn what came of checking an exercise.

    Parameters
    ----------
    exercise : str
    passed, hangs : bool
        Whether every check passed; whether the function did not come back.
    """
    for going_on in _LENDING.values():
        going_on.hear(exercise, passed, hangs)


def is_written(function: Callable) -> bool:
    """Whether somebody has written a function, or it is still a stub.

    Parameters
    ----------
    function : callable

    Returns
    -------
    bool
        A class counts as written, and whatever else has no Python code to look at.
    """
    code = getattr(own(function), "__code__", None)
    if code is None or "NotImplementedError" not in code.co_names:
        return True
    # A stub may begin with a line that is given, and it never comes to a return.
    return any(step.opname.startswith("RETURN_") for step in dis.get_instructions(code))


def own(function: Callable) -> Callable:
    """The function that somebody wrote, without what answers for it.

    Parameters
    ----------
    function : callable
        Perhaps one that lends or records answers.

    Returns
    -------
    callable
        The function itself where it is somebody's own already.
    """
    return function.__wrapped__ if hasattr(function, "is_lent_answers") else function


class Lender:
    """Puts stored answers behind the stubs of a notebook.

    Parameters
    ----------
    stored : dict
        ``exercises`` and ``experiments``: for each function, its answers by the key of the call.
    namespace : dict
        The notebook's.
    """

    def __init__(self, stored: dict, namespace: dict) -> None:
        self._stored, self._namespace = stored, namespace
        self._said: set[str] = set()
        self._mine: dict[str, Callable] = {}  # what stands aside, or calls such
        self.aside: frozenset[str] = frozenset()
        """Functions that are written, and taken for stubs."""

    def mine(self, name: str) -> Callable | None:
        """The function of a name that somebody wrote, also while it stands aside."""
        function = self._mine.get(name, self._namespace.get(name))
        return own(function) if callable(function) else None

    def callers_of(self, name: str) -> set[str]:
        """The exercises that are written, and call one of this name."""
        from utils.checks.using import functions_used

        written = {other: self.mine(other) for other in self._stored.get("exercises", ())}
        return {
            other
            for other, function in written.items()
            if other != name and function is not None and name in functions_used(function)
        }

    def put_aside(self, names: Collection[str]) -> None:
        """Take functions for stubs, until `give_back`; what calls them gets answers, too."""
        kept = {name: self._answers(name) for name in names}
        names = self.aside | {name for name, answers in kept.items() if answers is not None}
        callers = set().union(*map(self.callers_of, names)) - names
        for name in names - self.aside:
            self._mine.setdefault(name, self._namespace[name])
            self._namespace[name] = self._lending(name, _stub(name), self._answers(name))
        for name in callers - self._mine.keys():
            self._mine[name] = self._namespace[name]
            self._namespace[name] = self._lending(name, self.mine(name), self._answers(name))
        self.aside = frozenset(names)

    def give_back(self) -> None:
        """Let every function that stands aside be what somebody wrote."""
        self._namespace.update(self._mine)
        self._mine.clear()
        self.aside = frozenset()

    def _answers(self, name: str) -> dict | None:
        return next((kind[name] for kind in self._stored.values() if name in kind), None)

    def look_round(self, *_: object) -> None:
        """After a cell: every stub that it defined gets answers."""
        self._said.clear()
        for kind, functions in self._stored.items():
            for name, answers in functions.items():
                function = self._namespace.get(name)
                if not callable(function) or hasattr(function, "is_lent_answers"):
                    continue
                if kind == "experiments" or not is_written(function):
                    self._namespace[name] = self._lending(name, function, answers)

    def _lending(self, name: str, function: Callable, answers: dict) -> Callable:
        @functools.wraps(function)
        def lent(*arguments: object, **keywords: object) -> object:
            # Before it runs: an experiment may change what it is given.
            key = key_of(arguments, keywords)
            try:
                return function(*arguments, **keywords)
            except NotImplementedError as error:
                missing = _missing(error) or name
                if key not in answers:
                    raise NotLent(missing, self._why(missing)) from None
            if missing in self.aside:
                self.say_aside([missing])
            else:
                self._say(name, "" if missing == function.__name__ else missing)
            stored = answers[key]
            set_rng_states(arguments, keywords, stored.get("rng", []))
            return decode(stored["answer"], arguments, self._namespace)

        lent.is_lent_answers = True
        return lent

    def _why(self, missing: str) -> str:
        return "has not passed its check" if missing in self.aside else "is not written yet"

    def _say(self, name: str, missing: str) -> None:
        """Whose answer it is, and for want of what, where that is another function."""
        why = f"{missing or 'yours'} is not written yet."
        self._tell(name, f"`{name}`: this is **the course's answer**; {why}")

    def say_aside(self, names: Collection[str], first: bool = False) -> None:
        """That a cell goes on without functions, and how one gets them back."""
        back = " Yours is back when it passes, or when you run its own cell again." if first else ""
        self._tell_of(names, f"this cell goes on with **the course's answer**.{back}")

    def say_anew(self, names: Collection[str]) -> None:
        """That a cell goes on with what functions were given, as it was before."""
        self._tell_of(names, "this cell goes on with what it was given, made anew.")

    def _tell_of(self, names: Collection[str], what: str) -> None:
        names = sorted(name for name in names if name not in self._said)
        if names:
            have, its = ("has", "its check") if len(names) == 1 else ("have", "their checks")
            said = " and ".join(f"`{name}`" for name in names)
            self._tell(names[0], f"{said} {have} not passed {its}: {what}")
            self._said.update(names)

    def say_borrowed(self, name: str, functions: Collection[str]) -> None:
        """That a name holds what was made of the course's answers."""
        whose = " and ".join(f"`{function}`" for function in sorted(functions))
        self._tell(
            name,
            f"`{name}` was made with **the course's answer** for {whose}. Run the cell that makes "
            "it again, and it is made with yours.",
        )

    def say_returned(self, name: str) -> None:
        """That a function is somebody's own again."""
        self._tell(name, f"`{name}` has passed: from here on, the cells have **yours** again.")

    def _tell(self, about: str, sentence: str) -> None:
        """Show a sentence, once a cell."""
        if about in self._said:
            return
        self._said.add(about)
        said = re.sub(r"`(\w+)`", r"<code>\1</code>", escape(sentence, quote=False))
        said = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", said)
        style = "border-left:4px solid #E69F00;padding:0.2em 0.8em"
        show(f"<div style='{style}'>{said}</div>", re.sub(r"[`*]", "", sentence))


class Recorder(Lender):
    """Writes down what the functions of a solved notebook answer, but for what `_UNHEARD` asks.

    Parameters
    ----------
    exercises, experiments : iterable of str
        Names of functions.
    namespace : dict
        The notebook's.
    """

    def __init__(self, exercises: list[str], experiments: list[str], namespace: dict) -> None:
        stored = {
            "exercises": {name: {} for name in exercises},
            "experiments": {name: {} for name in experiments},
        }
        super().__init__(stored, namespace)
        # What an experiment asks is part of its own answer, and what `check` asks of nobody's.
        self._depth = 0
        self._faults: list[str] = []

    def look_round(self, *_: object) -> None:
        """After a cell: every function that it defined is listened to."""
        for functions in self._stored.values():
            for name, answers in functions.items():
                function = self._namespace.get(name)
                if callable(function) and not hasattr(function, "is_recorded"):
                    # Without what was stored before and may be lent already.
                    self._namespace[name] = self._lending(name, own(function), answers)
        for name in _UNHEARD:
            asks = self._namespace.get(name)
            if callable(asks) and not hasattr(asks, "is_unheard"):
                self._namespace[name] = self._unheard(asks)

    def _unheard(self, asks: Callable) -> Callable:
        @functools.wraps(asks)
        def unheard(*arguments: object, **keywords: object) -> object:
            with self._deeper():
                return asks(*arguments, **keywords)

        unheard.is_unheard = True
        return unheard

    @contextlib.contextmanager
    def _deeper(self) -> Iterator[None]:
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    def _lending(self, name: str, function: Callable, answers: dict) -> Callable:
        @functools.wraps(function)
        def recorded(*arguments: object, **keywords: object) -> object:
            if self._depth:
                return function(*arguments, **keywords)
            key = key_of(arguments, keywords)
            with self._deeper():
                answer = function(*arguments, **keywords)
            try:
                answers[key] = {"answer": encode(answer, arguments)}
            except TypeError as error:
                self._faults.append(f"{name}: {error}")
            else:
                if states := rng_states(arguments, keywords):
                    answers[key]["rng"] = states
            return answer

        recorded.is_lent_answers = recorded.is_recorded = True
        return recorded

    def text(self) -> str:
        """What is to be stored, as JSON; with sentences on what cannot be."""
        return json.dumps(self._stored | {"faults": self._faults})


def record_answers(exercises: list[str], experiments: list[str], path: str) -> None:
    """From now on, write down what functions answer, after each cell anew.

    Parameters
    ----------
    exercises, experiments : list of str
        Names of functions.
    path : str
        Of the file to write.
    """
    recorder = Recorder(exercises, experiments, shell().user_ns)

    def after_cell(*_: object) -> None:
        recorder.look_round()
        Path(path).write_text(recorder.text(), "utf-8")

    shell().events.register("post_run_cell", after_cell)


def _missing(error: NotImplementedError) -> str:
    """The stub for want of which an experiment stopped; empty where nobody can know."""
    if isinstance(error, NotLent):
        return error.missing
    return _cause(error) or str(error).partition(" is not written yet")[0]


def _cause(error: NotImplementedError) -> str:
    """The function in which a stub was met."""
    traceback, name = error.__traceback__, ""
    while traceback:
        name = traceback.tb_frame.f_code.co_name
        traceback = traceback.tb_next
    return "" if name == "lent" else name


def _stub(name: str) -> FunctionType:
    """A function that nobody has written."""

    def stub(*arguments: object, **keywords: object) -> None:
        raise NotImplementedError

    code = stub.__code__.replace(co_name=name)
    return FunctionType(code, globals(), name)
