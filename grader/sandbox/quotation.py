"""What may be told of an exception outside of hidden tests: what stands in the submission anyway.

No hidden question is near, but a neighbour's may be: notebooks that are judged on one machine can
tell each other something, if only by how long they take. So no word is told that the code has
chosen. What remains is a type among Python's own, one line of the submission, and a name in it.
"""

from __future__ import annotations

import builtins
import re

from grader.sandbox.failures import KNOWN_EXCEPTIONS, StudentError
from utils.notebooks.forbidden import forbidden_part, refusal

# Of a line is shown, and looked at, what a person writes into one.
LONGEST_LINE = 120
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
# (exception, its message, what is told of it). A name is told if it stands in the line.
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
    (
        "ModuleNotFoundError",
        r"No module named '([\w.]+)'",
        "no module named '{}' where notebooks are judged: only the packages that the lesson needs "
        "are there",
    ),
    (
        "FileNotFoundError",
        r"There is no notebook .*The judge sees one notebook only",
        "the judge sees one notebook only: paste what it needs into that notebook",
    ),
    ("MemoryError", r"it returned more data", "it returned more data than any answer needs"),
)


def sentence_on(error: StudentError) -> str:
    """Which exception a function raised, and where."""
    where = _there(error.place, error.line)
    if error.calling:  # whoever looks at the other function alone may break one that is right
        where = f"{_there(error.calling, error.calling_line)}, which calls {where}"
    return f"{error.function} raised {_quoted(error)}{where and f' ({where})'}."


def sentence_on_cell(error: StudentError) -> str:
    """Which cell failed, and how."""
    where = f"{error.place.capitalize()}," if error.place else "A cell"
    line = _shown(error.line)
    return f"{where} failed: {_quoted(error)}{line and f' ({line})'}."


def _quoted(error: StudentError) -> str:
    """An exception's type, and what may be told of its message."""
    kind, message, line = error.type_name, error.message, error.line[:LONGEST_LINE]
    module = message.partition(" ")[0]
    refused = forbidden_part(module, error.forbidden)
    if refused and (kind, message) == ("ImportError", str(refusal(module))):
        return f"ImportError: {refusal(refused)}"
    for kinds, pattern, sentence in SENTENCES:
        found = re.match(pattern, message) if kind in kinds.split("|") else None
        names = found.groups() if found else ()
        if found and all(re.search(rf"(?<!\w){re.escape(name)}(?!\w)", line) for name in names):
            return f"{kind}: {sentence.format(*names)}"
    raised = re.search(r"\braise\s+(?:\w+\.)*(\w+)", line)
    is_told = kind in NAMED_EXCEPTIONS or (raised and raised[1] == kind)
    return kind if is_told else "another exception"


def _there(place: str | None, line: str) -> str:
    shown = _shown(line)
    return f"{place}{shown and f': {shown}'}" if place else ""


def _shown(line: str) -> str:
    shown = line if len(line) <= LONGEST_LINE else f"{line[:LONGEST_LINE]}…"
    return line and f"`{shown}`"
