"""Replace functions of a notebook with stored answers."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Collection
from html import escape

from utils.display import show
from utils.lent.encoding import decode, key_of, set_rng_states
from utils.lent.stubs import is_written, own, stub_of


class AnswerUnavailable(NotImplementedError):
    """No answer is stored for a call; a notebook shows only one line of this error.

    Attributes
    ----------
    missing_function : str
        Name of the function that is not written, or has not passed its check.
    """

    def __init__(self, missing_function: str, reason: str) -> None:
        self.missing_function = missing_function
        super().__init__(
            f"{missing_function} {reason}, and the course has stored answers only for the calls in "
            "this notebook."
        )

    def _render_traceback_(self) -> list[str]:
        return [str(self)]


class Lender:
    """Wraps functions of a notebook so that stored answers replace stubs.

    Parameters
    ----------
    stored : dict
        ``exercises`` and ``experiments``: for each function, its answers by the key of the call.
    namespace : dict
        The notebook's namespace.
    """

    def __init__(self, stored: dict, namespace: dict) -> None:
        self._stored, self._namespace = stored, namespace
        self._announced_names: set[str] = set()
        # Functions that are set aside, and functions that call them.
        self._own_functions: dict[str, Callable] = {}
        self.names_set_aside: frozenset[str] = frozenset()
        """Names of written functions that are treated as stubs."""

    @property
    def exercises(self) -> tuple[str, ...]:
        """Names of the functions that students write."""
        return tuple(self._stored.get("exercises", ()))

    def own_function(self, name: str) -> Callable | None:
        """Return the student's own function of that name, even while it is set aside."""
        function = self._own_functions.get(name, self._namespace.get(name))
        return own(function) if callable(function) else None

    def set_aside(self, names: Collection[str], callers: Collection[str]) -> None:
        """Treat functions as stubs until `restore_functions`.

        Their callers also use stored answers.
        """
        names = self.names_set_aside | {
            name for name in names if self._answers_of(name) is not None
        }
        for name in names - self.names_set_aside:
            self._own_functions.setdefault(name, self._namespace[name])
            self._namespace[name] = self._wrap(name, stub_of(name), self._answers_of(name))
        for name in set(callers) - names - self._own_functions.keys():
            self._own_functions[name] = self._namespace[name]
            self._namespace[name] = self._wrap(
                name, self.own_function(name), self._answers_of(name)
            )
        self.names_set_aside = frozenset(names)

    def restore_functions(self) -> None:
        """Restore the student's own functions that were set aside."""
        self._namespace.update(self._own_functions)
        self._own_functions.clear()
        self.names_set_aside = frozenset()

    def _answers_of(self, name: str) -> dict | None:
        return next((kind[name] for kind in self._stored.values() if name in kind), None)

    def wrap_stubs(self, *_: object) -> None:
        """Wrap every stub that a cell defined, so that it returns stored answers."""
        self._announced_names.clear()
        for kind, functions in self._stored.items():
            for name, answers in functions.items():
                function = self._namespace.get(name)
                if not callable(function) or hasattr(function, "is_lent_answers"):
                    continue
                if kind == "experiments" or not is_written(function):
                    self._namespace[name] = self._wrap(name, function, answers)

    def _wrap(self, name: str, function: Callable, answers: dict) -> Callable:
        @functools.wraps(function)
        def lent(*arguments: object, **keywords: object) -> object:
            # The key is computed first, because an experiment may change its arguments.
            key = key_of(arguments, keywords)
            try:
                return function(*arguments, **keywords)
            except NotImplementedError as error:
                missing = _missing_stub(error) or name
                if key not in answers:
                    raise AnswerUnavailable(missing, self._reason_text(missing)) from None
            if missing in self.names_set_aside:
                self.announce_replaced([missing])
            else:
                self._announce_stored_answer(name, "" if missing == function.__name__ else missing)
            stored = answers[key]
            set_rng_states(arguments, keywords, stored.get("rng", []))
            return decode(stored["answer"], arguments, self._namespace)

        lent.is_lent_answers = True
        return lent

    def _reason_text(self, missing_function: str) -> str:
        return (
            "has not passed its check"
            if missing_function in self.names_set_aside
            else "is not written yet"
        )

    def _announce_stored_answer(self, name: str, missing_function: str) -> None:
        """Say that an answer is the course's, and which missing function is the reason."""
        why = f"{missing_function or 'yours'} is not written yet."
        self._show_once(name, f"`{name}`: this is **the course's answer**; {why}")

    def announce_replaced(self, names: Collection[str], first: bool = False) -> None:
        """Say that stored answers replace functions in this cell, and how to get them back."""
        back = (
            " Yours is used again when it passes, or when you run its cell again." if first else ""
        )
        self._show_reason(names, f"this cell continues with **the course's answer**.{back}")

    def announce_recomputed(self, names: Collection[str]) -> None:
        """Say that the arguments of functions that may have changed them were recomputed."""
        sentence = "this cell continues with its original input, which was computed again."
        self._show_reason(names, sentence)

    def _show_reason(self, names: Collection[str], consequence: str) -> None:
        names = sorted(name for name in names if name not in self._announced_names)
        if names:
            have, its = ("has", "its check") if len(names) == 1 else ("have", "their checks")
            listed = " and ".join(f"`{name}`" for name in names)
            self._show_once(names[0], f"{listed} {have} not passed {its}, so {consequence}")
            self._announced_names.update(names)

    def announce_borrowed(self, name: str, functions: Collection[str]) -> None:
        """Say that the value of a name was computed from stored answers."""
        listed = " and ".join(f"`{function}`" for function in sorted(functions))
        self._show_once(
            name,
            f"`{name}` was computed with **the course's answer** for {listed}. To use yours, rerun "
            "the cell that computes it.",
        )

    def announce_returned(self, name: str) -> None:
        """Say that cells use the student's own function again."""
        self._show_once(name, f"`{name}` has passed, so the following cells use **yours** again.")

    def _show_once(self, name: str, sentence: str) -> None:
        """Show a sentence about a name, at most once per cell."""
        if name in self._announced_names:
            return
        self._announced_names.add(name)
        html = re.sub(r"`(\w+)`", r"<code>\1</code>", escape(sentence, quote=False))
        html = re.sub(r"\*\*(.+?)\*\*", r"<b>\1</b>", html)
        style = "border-left:4px solid #E69F00;padding:0.2em 0.8em"
        show(f"<div style='{style}'>{html}</div>", re.sub(r"[`*]", "", sentence))


def _missing_stub(error: NotImplementedError) -> str:
    """Return the name of the stub that stopped an experiment; empty if it is unknown."""
    if isinstance(error, AnswerUnavailable):
        return error.missing_function
    return _raising_function(error) or str(error).partition(" is not written yet")[0]


def _raising_function(error: NotImplementedError) -> str:
    """Return the name of the function that raised the error; empty if it is the wrapper."""
    traceback, name = error.__traceback__, ""
    while traceback:
        name = traceback.tb_frame.f_code.co_name
        traceback = traceback.tb_next
    return "" if name == "lent" else name
