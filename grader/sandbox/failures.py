"""How a student's function fails: it raises an exception, or its process ends."""

from __future__ import annotations

from utils.remote_objects import RemoteError, RemoteStopped

# Informative names that student code did not choose. The list is short, because the choice among
# them could reveal something about a hidden question.
KNOWN_EXCEPTIONS = (
    *("ArithmeticError", "AssertionError", "AttributeError", "AxisError", "FileNotFoundError"),
    *("FloatingPointError", "ImportError", "IndexError", "KeyError", "LinAlgError", "MemoryError"),
    *("ModuleNotFoundError", "NameError", "OverflowError", "QhullError", "RecursionError"),
    *("RuntimeError", "TypeError", "UnboundLocalError", "ValueError", "ZeroDivisionError"),
)
# In an exercise with more lines, the line of an exception is not shown for hidden questions.
MOST_LINES = 64


class StudentError(RemoteError):
    """A student's function raised an exception; `str()` is what the worker reported.

    Attributes
    ----------
    function : str
        Name of the function that was called.
    type_name, message : str
        Type and message of the exception. Student code can choose both, so neither is shown as it
        is; `grader.sandbox.quotation` selects what may be shown.
    place : str or None
        Cell and line in the notebook, in the judge's own words.
    line : str
        Source of that line.
    calling : str or None
        Cell and line where the exercise called the function that raised, if that is another one.
    calling_line : str
        Source of that line.
    inside : str
        The exercise in which it happened; empty if it was in none.
    forbidden : tuple of str
        Modules that the lesson does not allow.
    told_type : str
        The type, as it may be shown for a hidden question: one of `KNOWN_EXCEPTIONS`, or
        "another exception".
    told_place : str or None
        The place, as it may be shown for a hidden question: `calling`, or else `place`, if the
        exercise has few lines.
    without_words : str
        The sentence with `told_type` and `told_place` only.
    """

    def __init__(
        self,
        function: str,
        type_name: str,
        message: str = "",
        place: str | None = None,
        line: str = "",
        inside: str = "",
        is_one_of_few: bool = False,
        forbidden: tuple[str, ...] = (),
        calling: str | None = None,
        calling_line: str = "",
    ) -> None:
        self.function, self.forbidden = function, forbidden
        self.type_name, self.message = type_name, message
        self.place, self.line, self.inside = place, line, inside
        self.calling, self.calling_line = calling, calling_line
        where = f" ({place})" if place else ""
        self.told_type = type_name if type_name in KNOWN_EXCEPTIONS else "another exception"
        self.told_place = (calling or place) if is_one_of_few else None
        told_where = f" ({self.told_place})" if self.told_place else ""
        self.without_words = f"{function} raised {self.told_type}{told_where}."
        super().__init__(f"{function} raised {type_name}: {message}{where}")


class StudentStopped(RemoteStopped):
    """A student's process hung, died or broke the protocol; `str()` is the sentence to show.

    Attributes
    ----------
    reason : str
        Equal for all stops with the same cause; by default the sentence.
    out_of_time : bool
        Whether a call of the student's function took too long.
    """

    def __init__(self, sentence: str, reason: str = "", out_of_time: bool = False) -> None:
        self.reason, self.out_of_time = reason or sentence, out_of_time
        super().__init__(sentence)


def why_it_ended(code: int | None) -> str:
    """Return a sentence on a process that ended by itself.

    Parameters
    ----------
    code : int or None
        Its exit code, if known.
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
    # The exit code is not shown: student code can choose it to reveal a hidden question.
    return "The notebook's process ended in the middle of a call, as os._exit and the like do."
