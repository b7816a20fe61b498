"""Record the answers of the functions in a solved notebook."""

from __future__ import annotations

import contextlib
import functools
import json
from collections.abc import Callable, Iterator
from pathlib import Path

import utils
from utils.display import shell
from utils.lent.encoding import encode, key_of, rng_states
from utils.lent.stand_ins import Lender
from utils.lent.stubs import CALLERS, own


class Recorder(Lender):
    """Records the answers of functions in a solved notebook, except in calls from `CALLERS`.

    Parameters
    ----------
    exercises, experiments : iterable of str
        Names of the functions to record.
    namespace : dict
        The notebook's namespace.
    """

    def __init__(self, exercises: list[str], experiments: list[str], namespace: dict) -> None:
        stored = {
            "exercises": {name: {} for name in exercises},
            "experiments": {name: {} for name in experiments},
        }
        super().__init__(stored, namespace)
        # Nested calls are not recorded: an experiment's own answer covers its calls, and the calls
        # of `check` are not part of the lesson.
        self._depth = 0
        self._faults: list[str] = []

    def wrap_stubs(self, *_: object) -> None:
        """Wrap every function that a cell defined, so that its answers are recorded."""
        for functions in self._stored.values():
            for name, answers in functions.items():
                function = self._namespace.get(name)
                if callable(function) and not hasattr(function, "is_recorded"):
                    # Use the function itself, because older stored answers may already replace it.
                    self._namespace[name] = self._wrap(name, own(function), answers)
        for name in CALLERS:
            caller = self._namespace.get(name)
            if callable(caller) and not hasattr(caller, "is_unrecorded"):
                self._namespace[name] = self._without_recording(caller)

    def wrap_callers(self) -> None:
        """Wrap the callers in `utils`, because a later cell may import and call one."""
        for name in set(CALLERS) & set(dir(utils)):
            setattr(utils, name, self._without_recording(getattr(utils, name)))

    def _without_recording(self, caller: Callable) -> Callable:
        @functools.wraps(caller)
        def unrecorded(*arguments: object, **keywords: object) -> object:
            with self._nested_call():
                return caller(*arguments, **keywords)

        unrecorded.is_unrecorded = True
        return unrecorded

    @contextlib.contextmanager
    def _nested_call(self) -> Iterator[None]:
        self._depth += 1
        try:
            yield
        finally:
            self._depth -= 1

    def _wrap(self, name: str, function: Callable, answers: dict) -> Callable:
        @functools.wraps(function)
        def recorded(*arguments: object, **keywords: object) -> object:
            if self._depth:
                return function(*arguments, **keywords)
            key = key_of(arguments, keywords)
            with self._nested_call():
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
        """Return the answers as JSON, with a message for each answer that cannot be stored."""
        return json.dumps(self._stored | {"faults": self._faults})


def record_answers(exercises: list[str], experiments: list[str], path: str) -> None:
    """Record the answers of functions from now on; rewrite the file after each cell.

    Parameters
    ----------
    exercises, experiments : list of str
        Names of the functions to record.
    path : str
        The file to write.
    """
    recorder = Recorder(exercises, experiments, shell().user_ns)
    recorder.wrap_callers()

    def after_cell(*_: object) -> None:
        recorder.wrap_stubs()
        Path(path).write_text(recorder.text(), "utf-8")

    shell().events.register("post_run_cell", after_cell)
