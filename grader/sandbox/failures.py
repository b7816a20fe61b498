"""The ways in which a student's function can fail: an exception, or the end of its process."""

from __future__ import annotations

from utils.remote_objects import RemoteError, RemoteStopped

# Exceptions that a message about a hidden test may name. The list is short, because student code
# could reveal something about the test by its choice of exception.
KNOWN_EXCEPTIONS = (
    *("ArithmeticError", "AssertionError", "AttributeError", "AxisError", "FileNotFoundError"),
    *("FloatingPointError", "ImportError", "IndexError", "KeyError", "LinAlgError", "MemoryError"),
    *("ModuleNotFoundError", "NameError", "OverflowError", "QhullError", "RecursionError"),
    *("RuntimeError", "TypeError", "UnboundLocalError", "ValueError", "ZeroDivisionError"),
)
# If an exercise has more lines than this, messages about hidden tests do not show where an
# exception was raised, because student code could send a message by choosing the line.
MAX_LINES = 64


class StudentError(RemoteError):
    """A student's function raised an exception. `str()` is the worker's unfiltered report.

    Attributes
    ----------
    function : str
        Name of the function that was called.
    type_name, message : str
        Type and message of the exception. Student code can choose both, so neither is shown
        unfiltered; `grader.sandbox.error_descriptions` selects the parts that may be shown.
    place : str or None
        Cell and line in the notebook, such as ``code cell 3, line 12``; None if there is no such
        line, or if the notebook is too long to show it.
    line : str
        Source of that line.
    call_place : str or None
        Cell and line where the exercise called another function, if that function raised the
        exception.
    call_line : str
        Source of that line.
    inside : str
        The lesson's function in which the exception was raised; empty for other functions.
    forbidden : tuple of str
        Modules that the lesson does not allow.
    shown_type : str
        The type that may be shown for a hidden test: one of `KNOWN_EXCEPTIONS`, or "another
        exception".
    shown_place : str or None
        The place that may be shown for a hidden test: `call_place`, or else `place`. None if the
        place is not in the exercise, or if the exercise has more than `MAX_LINES` lines.
    safe_sentence : str
        A sentence that contains only the function's name, `shown_type` and `shown_place`.
    """

    def __init__(
        self,
        function: str,
        type_name: str,
        message: str = "",
        place: str | None = None,
        line: str = "",
        inside: str = "",
        in_short_exercise: bool = False,
        forbidden: tuple[str, ...] = (),
        call_place: str | None = None,
        call_line: str = "",
    ) -> None:
        self.function, self.forbidden = function, forbidden
        self.type_name, self.message = type_name, message
        self.place, self.line, self.inside = place, line, inside
        self.call_place, self.call_line = call_place, call_line
        where = f" ({place})" if place else ""
        self.shown_type = type_name if type_name in KNOWN_EXCEPTIONS else "another exception"
        self.shown_place = (call_place or place) if in_short_exercise else None
        shown_where = f" ({self.shown_place})" if self.shown_place else ""
        self.safe_sentence = f"{function} raised {self.shown_type}{shown_where}."
        super().__init__(f"{function} raised {type_name}: {message}{where}")


class CellSkipped(StudentError):
    """A student's function is missing, because its cell was skipped.

    Attributes
    ----------
    sentence : str
        Why the cell was skipped. It depends only on the notebook's source, so it may be shown.
    """

    def __init__(self, function: str, sentence: str) -> None:
        self.sentence = sentence
        super().__init__(function, "NotImplementedError")


class StudentStopped(RemoteStopped):
    """A student's process took too long, died or broke the protocol; `str()` says which.

    Attributes
    ----------
    reason : str
        A text that identifies the cause, to compare stops; by default the sentence.
    out_of_time : bool
        Whether a call to the student's function took too long.
    """

    def __init__(self, sentence: str, reason: str = "", out_of_time: bool = False) -> None:
        self.reason, self.out_of_time = reason or sentence, out_of_time
        super().__init__(sentence)


def explain_process_end(code: int | None) -> str:
    """Return a sentence that says why a process ended by itself.

    Parameters
    ----------
    code : int or None
        Exit code of the process, if known.
    """
    if code in (137, -9):
        return (
            "The notebook's process was killed. Either it used too much memory, or code in the "
            "notebook killed it."
        )
    if code in (152, -24):
        return "The notebook's process used up its processor time. Is there an endless loop?"
    if code in (139, -11):
        return "The notebook's process crashed (segmentation fault)."
    # The exit code is not shown, because student code could choose it to reveal something about a
    # hidden test.
    return "The notebook's process ended in the middle of a call, for example through os._exit."
