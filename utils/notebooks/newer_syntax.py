"""Recognise code whose syntax is newer than the running Python.

The running Python only reports that such code is not valid. This module rewrites newer syntax into
older syntax. If the result is valid, a newer Python accepts the code. The result is parsed, but
never runs.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable

RUNNING_VERSION = sys.version_info[:2]
MAX_CHARACTERS = 200_000
"""Longer code is not examined, to save time."""
_STRING_START = re.compile(r"(?i:(?<!\w)(?P<prefix>[rbuft]{1,2}))?(?P<quote>'''|\"\"\"|'|\")")
_COMMENT = re.compile(r"#[^\n]*")
_MAGIC = re.compile(r"[ \t]*[!%][^\n]*")
# No string begins here, because the prefix of a string has at most two letters.
_PLAIN = re.compile(r"[^#'\"()\[\]{}:\n\w]+|\w{3,}+|\w{1,2}+(?!['\"])")
_GENERIC = re.compile(
    r"^[ \t]*(?:(?:async[ \t]+)?def|class|type)[ \t]+\w+[ \t]*(?=\[)", re.MULTILINE
)
_TYPE = re.compile(r"^([ \t]*)type[ \t]+(\w+[ \t]*=(?!=))", re.MULTILINE)
_EXCEPT = re.compile(r"^([ \t]*except\*?)[ \t]+([^\n:#()]+):", re.MULTILINE)


class _InvalidCode(Exception):
    """The code is not valid in any version of Python that is known here."""


def parse_newer_syntax(
    source: str, parse: Callable[[str], ast.Module], python: tuple[int, ...] = ()
) -> tuple[ast.Module, tuple[int, ...]] | None:
    """Parse code as a newer Python would, if it is not valid for the running Python.

    Parameters
    ----------
    source : str
        Code that `parse` refuses.
    parse : callable
        Takes the code of a cell or a module.
    python : tuple of int, optional
        The version of Python that ran the code, if it is known.

    Returns
    -------
    tree : ast.Module
        The parsed code, without type parameters and without strings that contain expressions.
        It is empty if the code is for a version whose syntax is not known here.
    version : tuple of int
        The oldest version of Python that can parse the code.

    If the code is not valid in a newer Python either, or if the Python that ran it is not newer,
    the result is None.
    """
    if len(source) > MAX_CHARACTERS:
        return None
    for version, rewrite in _REWRITERS:
        if version <= RUNNING_VERSION or (python and python < version):
            continue
        try:
            rewritten = rewrite(source)
            if rewritten != source:
                return parse(rewritten), version
        except Exception:  # untrusted text can break the parser in many ways
            continue
    newest = max(RUNNING_VERSION, _REWRITERS[-1][0])
    if python > newest:  # nothing is known here about the syntax of that version
        return ast.Module([], []), python
    return None


def _rewrite_python_3_12(source: str) -> str:
    source = _without_formatted_strings(source, "f")
    return _TYPE.sub(r"\1\2", _without_type_parameters(source))


def _rewrite_python_3_14(source: str) -> str:
    source = _without_formatted_strings(source, "ft")
    source = _TYPE.sub(r"\1\2", _without_type_parameters(source))
    return _EXCEPT.sub(_bracket_exceptions, source)


def _bracket_exceptions(clause: re.Match) -> str:
    is_bare_list = "," in clause[2] and " as " not in clause[2]
    return f"{clause[1]} ({clause[2]}):" if is_bare_list else clause[0]


# Each version that added syntax, and how to write its code in the syntax of Python 3.11.
_REWRITERS = (((3, 12), _rewrite_python_3_12), ((3, 14), _rewrite_python_3_14))


def _without_type_parameters(source: str) -> str:
    parts, start = [], 0
    for found in _GENERIC.finditer(source):
        end = _end_of_brackets(source, found.end())
        # Type parameters are written like the parameters of a function.
        ast.parse(f"def _({source[found.end() + 1 : end - 1]}): pass")
        parts.append(source[start : found.end()])
        start = end
    return "".join([*parts, source[start:]])


def _end_of_brackets(source: str, place: int) -> int:
    depth = 0
    for position in range(place, len(source)):
        depth += (source[position] in "([{") - (source[position] in ")]}")
        if depth == 0:
            return position + 1
    raise _InvalidCode


def _without_formatted_strings(source: str, kinds: str) -> str:
    """Replace each formatted string with an empty one, after checking its expressions."""
    return _copy_code(source, 0, kinds, in_expression=False)[0]


def _copy_code(source: str, place: int, kinds: str, in_expression: bool) -> tuple[str, int]:
    """Copy code without formatted strings; return the copy, and the position of its end.

    An expression in a formatted string ends at a brace or colon outside all brackets.
    """
    parts, depth = [], 0
    while place < len(source):
        starts_line = depth == 0 and source[place - 1 : place] in ("", "\n")
        magic = _MAGIC.match(source, place) if starts_line and not in_expression else None
        plain = magic or _PLAIN.match(source, place)
        if plain:
            parts.append(plain[0])
            place = plain.end()
            continue
        if string := _STRING_START.match(source, place):
            part, place = _copy_string(source, string, kinds)
            parts.append(part)
            continue
        if comment := _COMMENT.match(source, place):
            parts.append("" if in_expression else comment[0])
            place = comment.end()
            continue
        character = source[place]
        if in_expression and depth == 0 and character in ":}":
            return "".join(parts), place
        depth += (character in "([{") - (character in ")]}")
        parts.append(character)
        place += 1
    if in_expression:
        raise _InvalidCode
    return "".join(parts), place


def _copy_string(source: str, string: re.Match, kinds: str) -> tuple[str, int]:
    """Return a string, or an empty one in place of a formatted string, and the position after."""
    end, place = string["quote"], string.end()
    if any(kind in (string["prefix"] or "").lower() for kind in kinds):
        return '""', _end_of_literal(source, place, end, kinds) + len(end)
    while not source.startswith(end, place):
        if place >= len(source) or (source[place] == "\n" and len(end) == 1):
            raise _InvalidCode
        place += 1 + (source[place] == "\\")
    place += len(end)
    return source[string.start() : place], place


def _end_of_literal(source: str, place: int, end: str, kinds: str) -> int:
    """Return the position of the text that ends a formatted string or a format specification."""
    in_format = end == "}"
    while not source.startswith(end, place):
        if place >= len(source) or (source[place] == "\n" and end in "\"'"):
            raise _InvalidCode
        if source[place : place + 2] in ("{{", "}}") and not in_format:
            place += 2
        elif source[place] == "{":
            expression, place = _copy_code(source, place + 1, kinds, in_expression=True)
            _check_expression(expression)
            if source[place] == ":":
                place = _end_of_literal(source, place + 1, "}", kinds)
            place += 1
        elif source[place] == "}":
            raise _InvalidCode
        else:
            place += 1 + (source[place] == "\\" and source[place + 1 : place + 2] not in "{}")
    return place


def _check_expression(text: str) -> None:
    """Raise an exception unless this is an expression, possibly with `=` or a conversion."""
    text = text.rstrip()
    if text[-1:] in ("r", "s", "a") and text[:-1].rstrip().endswith("!"):
        text = text[:-1].rstrip()[:-1].rstrip()
    if text.endswith("=") and text[-2:] not in ("==", "!=", "<=", ">="):
        text = text[:-1]
    if not text.strip():
        raise _InvalidCode
    ast.parse(f"({text}\n)", mode="eval")
