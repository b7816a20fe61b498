"""Read the JSON of a notebook that an editor or a merge tool has damaged.

The text is untrusted, so the search for each pattern takes linear time.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

# No cell of a notebook is nested this deep, but an output may be.
DEEPEST = 100
LONGEST_LABEL = 40
# A string that never ends reaches to the end of the text, so that no part is searched twice.
STRING = r'"(?:[^"\\]|\\.)*+(?:"|\\?\Z)'
_STRING_OR_BRACKET = re.compile(rf"{STRING}|[\[\]{{}}]", re.DOTALL)
_STRING_OR_TRAILING_COMMA = re.compile(rf"({STRING})|,(?=\s*+[\]}}])", re.DOTALL)
_BETWEEN = re.compile(r"[\s,]*")
_LESSON_IN_JSON = re.compile(r'"lidar_obstacle_lab"\s*:\s*\{\s*"lesson"\s*:\s*"(\w{1,60})"')
# A line end inside a string is not valid JSON, but it has only one meaning.
_DECODER = json.JSONDecoder(strict=False)


@dataclass(frozen=True)
class ConflictSide:
    """One side of the merge conflicts in a text.

    Attributes
    ----------
    sentence : str
        Says that this side was judged.
    text : str
        The text without the conflicts' markers and without their other side.
    """

    sentence: str
    text: str


def parse(text: str, name: str) -> tuple[object, str, bool]:
    """Parse JSON that may be damaged.

    Parameters
    ----------
    text : str
    name : str
        Name of the file in messages.

    Returns
    -------
    content : object
        The content; if the text is cut off, a notebook with the cells that are complete.
    sentence : str
        Description of the repair; empty if nothing is lost.
    is_whole : bool
        Whether the end of the content was found.
    """
    candidates = [ConflictSide("", text), *sides_of_conflicts(text, name)]
    for repair in (_unchanged, _without_trailing_commas):
        for side in candidates:
            try:
                content, rest = _decode(repair(side.text))
            except ValueError:
                continue
            return content, _join_sentences(side.sentence, _describe_rest(rest, name)), True
    side = candidates[min(1, len(candidates) - 1)]
    content = _complete_cells(_without_trailing_commas(_without_deep_nesting(side.text)))
    return content, side.sentence, False


def sides_of_conflicts(text: str, name: str) -> tuple[ConflictSide, ...]:
    """Return both sides of a text with merge conflicts; nothing if no conflict is complete."""
    if "<<<<<<<" not in text:
        return ()
    sides, now, labels = ([], []), (0, 1), ["", ""]
    found = False
    for line in text.split("\n"):
        marker, label = line[:7], line[7:].strip()
        if marker == "<<<<<<<" and now == (0, 1):
            now, labels[0] = (0,), labels[0] or label
        elif marker == "|||||||" and now == (0,):
            now = ()  # the version before both changes
        elif line.rstrip() == "=======" and now in ((0,), ()):
            now = (1,)
        elif marker == ">>>>>>>" and now == (1,):
            now, labels[1], found = (0, 1), labels[1] or label, True
        else:
            for side in now:
                sides[side].append(line)
    if not found:
        return ()
    return tuple(
        ConflictSide(
            f"A merge conflict was left in {name}. {whose}{_bracketed(label)} was judged. "
            "Resolve the conflict, and submit the file again.",
            "\n".join(lines),
        )
        for whose, label, lines in zip(("Your side", "The other side"), labels, sides, strict=True)
    )


def _bracketed(label: str) -> str:
    return f" ({label[:LONGEST_LABEL]})" if label else ""


def _unchanged(text: str) -> str:
    return text


def _without_trailing_commas(text: str) -> str:
    return _STRING_OR_TRAILING_COMMA.sub(lambda found: found[1] or "", text)


def _without_deep_nesting(text: str) -> str:
    """Replace everything that is nested too deep to be parsed, which only outputs can be."""
    return "".join(_split_off_deep_nesting(text))


def _split_off_deep_nesting(text: str) -> Iterator[str]:
    depth, start = 0, 0
    for token in _STRING_OR_BRACKET.finditer(text):
        if token[0] in ("[", "{"):
            depth += 1
            if depth == DEEPEST + 1:
                yield text[start : token.start()]
                yield "null"
        elif token[0] in ("]", "}"):
            depth -= 1
            if depth == DEEPEST:
                start = token.end()
    if depth <= DEEPEST:
        yield text[start:]


def _decode(text: str) -> tuple[object, str]:
    """Return the first value in a text, and the text after it."""
    try:
        content, end = _DECODER.raw_decode(text)
    except RecursionError:
        text = _without_deep_nesting(text)
        content, end = _DECODER.raw_decode(text)
    return content, text[end:].strip(" \t\r\n\0")


def _describe_rest(rest: str, name: str) -> str:
    return rest and (
        f"{name} continues after the end of the notebook, for example with a second copy. Only "
        "the notebook itself was read. Save it again in Jupyter and submit it again."
    )


def _join_sentences(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


def _complete_cells(text: str) -> dict:
    """Return a notebook with the cells that are complete before the file breaks off."""
    start = re.search(r'"cells"\s*:\s*\[', text) or re.match(r"\[", text)
    cells, place = [], start.end() if start else len(text)
    while True:
        try:
            cell, place = _DECODER.raw_decode(text, _BETWEEN.match(text, place).end())
        except ValueError:
            break
        if not isinstance(cell, dict):
            break
        cells.append(cell)
    lesson = _LESSON_IN_JSON.search(text)
    metadata = {"lidar_obstacle_lab": {"lesson": lesson[1]}} if lesson else {}
    return {"cells": cells, "metadata": metadata}
