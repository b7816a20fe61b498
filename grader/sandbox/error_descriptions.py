"""Describe exceptions outside hidden tests, without text that student code chose at run time.

Outside hidden tests, a notebook has not received the input of its own tests yet. It may still know
the input of another notebook's tests, because notebooks on one machine can exchange signals, for
example by how long they take. A message therefore contains only fixed text and:

- an exception type that is well known or appears in the failing line
- the failing line of the submission
- a name in that line
"""

from __future__ import annotations

import builtins
import re

from grader.sandbox.failures import KNOWN_EXCEPTIONS, StudentError
from utils.in_sandbox import ABSENT
from utils.notebooks.forbidden import forbidden_module_of, refusal

# Only this many characters of a line are shown and searched. Longer lines are rare.
MAX_LINE_LENGTH = 120
NAMED_EXCEPTIONS = frozenset(
    (
        *KNOWN_EXCEPTIONS,
        *(
            name
            for name, value in vars(builtins).items()
            if isinstance(value, type) and issubclass(value, BaseException)
        ),
    )
)
# Exception types, a pattern for the message, and the text to show. A name is shown only if it
# occurs in the failing line.
SENTENCES = (
    ("NameError", r"name '(\w+)' is not defined", "name '{}' is not defined"),
    ("NameError", r"the notebook does not define it", "the notebook does not define it"),
    (
        "NameError|UnboundLocalError",
        r".*variable '(\w+)'",
        "variable '{}' has no value yet",
    ),
    ("AttributeError", r".* has no attribute '(\w+)'", "no attribute '{}'"),
    ("TypeError", r".* unexpected keyword argument '(\w+)'", "no parameter '{}'"),
    ("ImportError", r"cannot import name '(\w+)'", "cannot import name '{}'"),
    ("ModuleNotFoundError", r"No module named '([\w.]+)'", f"no module named '{{}}': {ABSENT}"),
    ("ModuleNotFoundError", r"No module named ", f"a module is missing: {ABSENT}"),
    (
        "FileNotFoundError",
        r"There is no notebook .*The judge sees only one notebook",
        "the judge sees only this notebook, so paste the functions that it needs into it",
    ),
    ("MemoryError", r"it returned more data", "it returned more data than any answer needs"),
)


def describe_error(error: StudentError) -> str:
    """Return a sentence that says which exception a function raised, and where."""
    where = _quote_place(error.place, error.line)
    if error.call_place:  # the caller may have passed wrong arguments to a correct function
        where = f"{_quote_place(error.call_place, error.call_line)}, which calls {where}"
    return f"{error.function} raised {_type_and_message(error)}{where and f' ({where})'}."


def describe_failed_cell(error: StudentError) -> str:
    """Return a sentence that says which cell failed, and how."""
    where = f"{error.place.capitalize()}," if error.place else "A cell"
    line = _quote_line(error.line)
    return f"{where} failed: {_type_and_message(error)}{line and f' ({line})'}."


def _type_and_message(error: StudentError) -> str:
    """Return an exception's type and those parts of its message that may be shown."""
    kind, message, line = error.type_name, error.message, error.line[:MAX_LINE_LENGTH]
    module = message.partition(" ")[0]
    refused = forbidden_module_of(module, error.forbidden)
    if refused and (kind, message) == ("ImportError", str(refusal(module))):
        return f"ImportError: {refusal(refused)}"
    for kinds, pattern, sentence in SENTENCES:
        found = re.match(pattern, message) if kind in kinds.split("|") else None
        names = found.groups() if found else ()
        if found and all(re.search(rf"(?<!\w){re.escape(name)}(?!\w)", line) for name in names):
            return f"{kind}: {sentence.format(*names)}"
    raised = re.search(r"\braise\s+(?:\w+\.)*(\w+)", line)
    is_shown = kind in NAMED_EXCEPTIONS or (raised and raised[1] == kind)
    return kind if is_shown else "another exception"


def _quote_place(place: str | None, line: str) -> str:
    shown = _quote_line(line)
    return f"{place}{shown and f': {shown}'}" if place else ""


def _quote_line(line: str) -> str:
    shown = line if len(line) <= MAX_LINE_LENGTH else f"{line[:MAX_LINE_LENGTH]}…"
    return line and f"`{shown}`"
