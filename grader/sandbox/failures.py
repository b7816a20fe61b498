"""How a student's function fails: it raises, or its process ends. In our words, and in theirs."""

from __future__ import annotations

import builtins

from utils.remote import RemoteError

# Names that say something and that student code did not choose.
KNOWN_EXCEPTIONS = {
    name
    for name, value in vars(builtins).items()
    if isinstance(value, type) and issubclass(value, BaseException)
} | {"LinAlgError", "AxisError", "QhullError"}


class StudentError(RemoteError):
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


def why_it_ended(code: int | None) -> str:
    """A sentence on a process that ended by itself.

    Parameters
    ----------
    code : int or None
        Its exit code, where one is known.
    """
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
