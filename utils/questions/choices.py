"""Select plausible wrong choices, and put edits in a fair order."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable
from random import Random
from typing import TypeVar

from utils.questions.shown_values import is_selection
from utils.questions.texts import adds_nan, reversed_vector, same_answer, similarity

MAX_CHOICES, MIN_CHOICES = 4, 3

AnyEdit = TypeVar("AnyEdit")


def distractors(right: str, candidates: Iterable[str], code: str = "") -> list[str]:
    """Return up to three wrong choices: those that look most like the right one and occur most.

    A vector with all signs reversed is left out, because a line and a plane have two right vectors.
    If the right choice consists of rows that the case shows, the wrong ones do so too. Otherwise,
    students would find the right choice without reading the function. For the same reason, nan
    is a wrong choice only if the case or the right choice contains it, or the right choice is None.

    Parameters
    ----------
    right : str
    candidates : iterable of str
        Answers of functions with one changed line, the likeliest first; empty texts are ignored.
    code : str
        The code of the case.
    """
    counted: Counter[str] = Counter()
    has_shown_rows = is_selection(right, code)
    for candidate in candidates:
        is_right = any(same_answer(candidate, text) for text in (right, reversed_vector(right)))
        is_alike = not has_shown_rows or is_selection(candidate, code)
        reveals_nan = right != "None" and adds_nan(candidate, right + code)
        if candidate and is_alike and not is_right and not reveals_nan:
            same = next((known for known in counted if same_answer(known, candidate)), candidate)
            counted[same] += 1
    ranked = sorted(counted, key=lambda text: (-similarity(right, text), -counted[text]))
    return ranked[: MAX_CHOICES - 1]


def with_first(first: str, texts: Iterable[str]) -> list[str]:
    """Return texts with `first` moved to the front, and not repeated."""
    return [first, *(text for text in texts if not same_answer(text, first))]


def arrange(right: str, wrong: Iterable[str], random: Random) -> tuple[tuple[str, ...], int] | None:
    """Return the choices in random order and the index of the right one; None if too few."""
    choices = [right, *wrong][:MAX_CHOICES]
    if len(choices) < MIN_CHOICES:
        return None
    random.shuffle(choices)
    return tuple(choices), choices.index(right)


def in_rounds(edits: Iterable[AnyEdit]) -> list[AnyEdit]:
    """Order edits in rounds: the likeliest of each line first, then the second of each line.

    The attribute `first` of an edit is the number of its first line.
    """
    rounds: dict[int, list[AnyEdit]] = {}
    for edit in edits:
        rounds.setdefault(edit.first, []).append(edit)
    return [
        edit for row in itertools.zip_longest(*rounds.values()) for edit in row if edit is not None
    ]
