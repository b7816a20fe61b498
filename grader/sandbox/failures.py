"""How a student's function fails: it raises, or its process ends. In our words, and in theirs."""

from __future__ import annotations

from utils.remote_objects import RemoteError, RemoteStopped

# Names that say something and that student code did not choose. Few: which of them it is may
# tell something about a hidden question.
KNOWN_EXCEPTIONS = (
    *("ArithmeticError", "AssertionError", "AttributeError", "AxisError", "FileNotFoundError"),
    *("FloatingPointError", "ImportError", "IndexError", "KeyError", "LinAlgError", "MemoryError"),
    *("ModuleNotFoundError", "NameError", "OverflowError", "QhullError", "RecursionError"),
    *("RuntimeError", "TypeError", "UnboundLocalError", "ValueError", "ZeroDivisionError"),
)
# As many lines of a student's own are told apart about a hidden question.
MOST_LINES = 64


class StudentError(RemoteError):
    """A student's function raised; `str()` is what the judge was told.

    Attributes
    ----------
    function : str
        What was called.
    type_name, message : str
        The student's words: not to be told. What may be is in `grader.sandbox.quotation`.
    place : str or None
        Where in the notebook, in our words.
    line : str
        What stands there, in the student's.
    calling : str or None
        Where the exercise's own function called what raised, if that was another.
    calling_line : str
        What stands there.
    inside : str
        The exercise that it happened in; empty where it was in none.
    forbidden : tuple of str
        Modules that the lesson does not allow.
    told_type, told_place : str, str or None
        What may be told of a hidden question: a type of Python's or NumPy's that is among few,
        and the place if it is: where the exercise called what raised, if that was another.
    without_words : str
        The sentence with these alone.
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
        The same for all that have one reason; by default the sentence.
    out_of_time : bool
        Whether a call of the student's function took too long.
    """

    def __init__(self, sentence: str, reason: str = "", out_of_time: bool = False) -> None:
        self.reason, self.out_of_time = reason or sentence, out_of_time
        super().__init__(sentence)


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
