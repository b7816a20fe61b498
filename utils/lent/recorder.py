"""What the functions of a solved notebook answer, written down to be lent."""

from __future__ import annotations

import contextlib
import functools
import json
from collections.abc import Callable, Iterator
from pathlib import Path

from utils.display import shell
from utils.lent.encoding import encode, key_of, rng_states
from utils.lent.stand_ins import Lender
from utils.lent.stubs import ASKING, own


class Recorder(Lender):
    """Writes down what the functions of a solved notebook answer, but for what `ASKING` asks.

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
        for name in ASKING:
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
