"""Stored answers behind the functions of a notebook."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Collection
from html import escape

from utils.display import show
from utils.lent.encoding import decode, key_of, set_rng_states
from utils.lent.stubs import is_written, own, stub_of


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

    @property
    def exercises(self) -> tuple[str, ...]:
        """Names of the functions that somebody is to write."""
        return tuple(self._stored.get("exercises", ()))

    def mine(self, name: str) -> Callable | None:
        """The function of a name that somebody wrote, also while it stands aside."""
        function = self._mine.get(name, self._namespace.get(name))
        return own(function) if callable(function) else None

    def put_aside(self, names: Collection[str], callers: Collection[str]) -> None:
        """Take functions for stubs, until `give_back`; what calls them gets answers, too."""
        names = self.aside | {name for name in names if self._answers(name) is not None}
        for name in names - self.aside:
            self._mine.setdefault(name, self._namespace[name])
            self._namespace[name] = self._lending(name, stub_of(name), self._answers(name))
        for name in set(callers) - names - self._mine.keys():
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
