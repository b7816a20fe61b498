"""The course's own answers, lent to who has not written a function yet.

``lesson_NN.json`` holds what the functions of a lesson answered in its solved notebook: labels,
boxes, numbers, and no code. Who is stuck can go on: a function that is still a stub answers the
calls that the notebook makes, and says whose answer it is.
`grader.course.lending` records the answers.
"""

from __future__ import annotations

import contextlib
import dis
import functools
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from utils.lent.encoding import decode, encode, key_of, rng_states, set_rng_states
from utils.showing import shell, show

_HERE = Path(__file__).resolve().parent


def lend_answers(number: str) -> None:
    """From now on, after each cell, lend answers to the stubs of a lesson.

    Parameters
    ----------
    number : str
        Of the lesson, such as "06". Without stored answers, or outside a notebook, nothing
        happens.
    """
    path = _HERE / f"lesson_{number}.json"
    if shell() is None or not path.exists():
        return
    lender = Lender(json.loads(path.read_text("utf-8")), shell().user_ns)
    shell().events.register("post_run_cell", lender.look_round)


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
                missing = _missing(error)
                if key not in answers:
                    raise NotImplementedError(
                        f"{missing or name} is not written yet, and the course lends its "
                        "answers only to the calls that stand in this notebook."
                    ) from None
            self._say(name, "" if missing == function.__name__ else missing)
            stored = answers[key]
            set_rng_states(arguments, keywords, stored.get("rng", []))
            return decode(stored["answer"], arguments, self._namespace)

        lent.is_lent_answers = True
        return lent

    def _say(self, name: str, missing: str) -> None:
        """Once a cell: whose answer it is, and for want of what, where that is another function."""
        if name in self._said:
            return
        self._said.add(name)
        whose, why = "the course's answer", f"{missing or 'yours'} is not written yet."
        html = (
            "<div style='border-left:4px solid #E69F00;padding:0.2em 0.8em'>"
            f"<code>{name}</code>: this is <b>{whose}</b>; {why}</div>"
        )
        show(html, f"{name}: this is {whose}; {why}")


class Recorder(Lender):
    """Writes down what the functions of a solved notebook answer, but for `check` and `replay`.

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
        for name in ("check", "replay"):
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
    return _cause(error) or str(error).partition(" is not written yet")[0]


def _cause(error: NotImplementedError) -> str:
    """The function in which a stub was met."""
    traceback, name = error.__traceback__, ""
    while traceback:
        name = traceback.tb_frame.f_code.co_name
        traceback = traceback.tb_next
    return "" if name == "lent" else name
