"""Texts of untrusted values and outcomes, as they appear in questions."""

from __future__ import annotations

import math
import re

ENDLESS, ERROR = "it never ends", "an error: "
# Errors for undefined names. A question about them would not test understanding.
TRIVIAL_ERRORS = (f"{ERROR}NameError", f"{ERROR}UnboundLocalError")
MAX_VALUE_LENGTH = 150
MAX_EASY_NUMBERS = 16
NOTATION = (
    "Numbers are shown with at most three decimal places. Brackets stand for lists, tuples and "
    "arrays."
)


def outcome_text(outcome: object) -> str:
    """Return the outcome of a case as a text; empty if it does not suit a question on paper.

    Parameters
    ----------
    outcome : object
        Untrusted: a list of the outcome's kind and its content.
    """
    match outcome:
        case ["value", content]:
            return value_text(content)
        case ["error", str(name)] if name.isidentifier():
            return f"{ERROR}{name}"
        case ["endless"]:
            return ENDLESS
    return ""


def outcome_texts(outcomes: object) -> list[str]:
    """Return the texts of several untrusted outcomes."""
    return [outcome_text(outcome) for outcome in (outcomes if isinstance(outcomes, list) else ())]


def value_text(value: object) -> str:
    """Return a value as a text with at most three decimals; empty if it is not plain or too long.

    Arrays, tuples and lists look the same, because an exercise allows all of them.
    """
    try:
        text = _part_text(value)
    except (TypeError, ValueError, RecursionError):
        return ""
    return text if len(text) <= MAX_VALUE_LENGTH else ""


def _part_text(value: object) -> str:
    match value:
        case None | bool():
            return str(value)
        case int():
            return str(value) if abs(value) < 10**9 else ""
        case float():
            return _number_text(value)
        case str():
            return repr(value)
        case list():
            return f"[{', '.join(map(_part_text, value))}]"
        case {"set": list(parts)}:
            return "{" + ", ".join(map(_part_text, parts)) + "}"
        case {"dict": list(pairs)}:
            items = [f"{_part_text(key)}: {_part_text(part)}" for key, part in pairs]
            return "{" + ", ".join(items) + "}"
    raise TypeError


def _number_text(value: float) -> str:
    if not math.isfinite(value):
        return str(value)
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def same_answer(first: str, second: str) -> bool:
    """Return whether two texts mean the same answer, such as `[True, False]` and `[1, 0]`."""
    return _normal(first) == _normal(second)


def _normal(text: str) -> str:
    return text.replace("True", "1").replace("False", "0").replace("{", "[").replace("}", "]")


def is_value(text: str) -> bool:
    """Return whether a text is a value, and not an error or an endless call."""
    return bool(text) and text != ENDLESS and not text.startswith(ERROR)


def reversed_vector(text: str) -> str:
    """Return an answer in brackets with all signs reversed; any other answer as it is."""
    if not text.startswith("["):
        return text
    return re.sub(
        r"(-?)\b(\d+(?:\.\d+)?)",
        lambda number: number[2] if number[1] or not float(number[2]) else f"-{number[2]}",
        text,
    )


def is_easy(text: str) -> bool:
    """Return whether a text has only short numbers, with at most two decimals, and few of them."""
    return not re.search(r"\.\d{3}", text) and text.count(",") < MAX_EASY_NUMBERS


def adds_nan(text: str, before: str) -> bool:
    """Return whether a result contains nan or inf, unlike the result before.

    Such a result reveals the operation, and students exclude it without reading the code.
    """
    return any(name in text and name not in before for name in ("nan", "inf"))


def similarity(text: str, other: str) -> int:
    """Return how similar two answers look: 2 for the same form, 1 for two values, otherwise 0."""
    if not (is_value(text) and is_value(other)):
        return 0
    return 1 + (_form(text) == _form(other))


def is_alike(text: str, other: str) -> bool:
    """Return whether two values may be of one type: numbers, truths, or equally deep lists."""
    return _type(text) == _type(other)


def _type(text: str) -> tuple[str, bool, bool]:
    brackets = re.match(r"[\[{]*", text)[0]
    return brackets, text == "None", "True" in text or "False" in text


def _form(text: str) -> tuple[int, int, bool, bool, bool, bool]:
    """Return the brackets and commas of a value, and whether it has decimals or words."""
    return text.count("["), text.count(","), "." in text, is_easy(text), *_type(text)[1:]
