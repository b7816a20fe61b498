"""Limits for the size of an answer, far above any right answer, applied before it is compared.

In the judge, answers come from untrusted code, which could make a comparison take an hour.
"""

import reprlib
from collections import deque

import numpy as np

MAX_NUMBERS = 1_000_000
MAX_ROWS = 250_000  # nested lists: a whole scan has 120 000 rows
MAX_NUMBERS_PER_POINT = 100
# The limits in words, because the judge removes digits from messages.
_WORDS = {MAX_NUMBERS: "a million", MAX_NUMBERS_PER_POINT: "a hundred"}
MAX_DIMENSIONS = 3
MAX_INTEGER = 2**64
_NUMBERS = {bool, int, float}
_ITEMS = (bool, int, float, np.generic, range, deque)


class TooLarge(Exception):
    """An answer is larger than any right one; `str()` is a sentence that names the limit."""


class NotNumbers(Exception):
    """An answer is not an array of numbers or a list of them."""


def as_numbers(answer: object, max_count: int = MAX_NUMBERS) -> np.ndarray:
    """Convert an answer to an array of booleans, whole numbers or floats.

    Parameters
    ----------
    answer : object
    max_count : {1_000_000, 100}
        Largest number of values in a right answer.

    Returns
    -------
    numpy.ndarray
        An array of at most `MAX_DIMENSIONS` dimensions.

    Raises
    ------
    TooLarge
        If the answer exceeds a limit.
    NotNumbers
        If the answer is not an array of numbers or a list of them, or if values are masked.
    """
    if isinstance(answer, np.ma.MaskedArray) and np.ma.is_masked(answer):
        raise NotNumbers
    if not isinstance(answer, np.ndarray):
        _assert_plain_numbers(answer, max_count)
        try:
            answer = np.asarray(answer)
        except Exception:  # rows of different lengths, or an `__array__` written by the student
            raise NotNumbers from None
    _assert_few_dimensions(answer.ndim)
    _assert_number_count(answer.size, max_count)
    if answer.dtype.kind not in "biuf":
        raise NotNumbers
    return answer


def short_text(value: object) -> str:
    """Return a short `repr` of a value, shortened while it is built."""
    if isinstance(value, int) and abs(value) > MAX_INTEGER:
        return "a whole number with more than nineteen digits"
    try:
        return _SHORT.repr(value)
    except Exception:  # a `__repr__` written by the student
        return f"an object of type {type(value).__name__}"


class _ShortRepr(reprlib.Repr):
    """A `reprlib.Repr` that also shortens arrays, sets, dictionaries and huge numbers in a list."""

    def repr1(self, value: object, level: int) -> str:
        plain = value.item() if isinstance(value, np.generic) else value  # 2, not np.int64(2)
        return super().repr1(plain, level)

    def repr_int(self, value: int, level: int) -> str:
        return super().repr_int(value, level) if abs(value) <= MAX_INTEGER else "..."

    def repr_ndarray(self, value: np.ndarray, level: int) -> str:
        return f"array of shape {value.shape}"

    def repr_set(self, value: set, level: int) -> str:
        return f"set of {len(value)}" if len(value) > 100 else super().repr_set(value, level)

    def repr_dict(self, value: dict, level: int) -> str:
        return f"dict of {len(value)}" if len(value) > 100 else super().repr_dict(value, level)


_SHORT = _ShortRepr()


def _assert_plain_numbers(answer: object, max_count: int) -> None:
    """Refuse lists that are too long or too deeply nested, or contain text or other objects."""
    count, waiting = 0, [(answer, 0)]
    while waiting:
        value, depth = waiting.pop()
        if isinstance(value, (list, tuple)):
            count += len(value)
            _assert_number_count(count, max_count)
            _assert_few_dimensions(depth)
            kinds = set(map(type, value))
            if int in kinds and kinds <= _NUMBERS:
                _assert_small_integer(max(value, key=abs))
            elif not kinds <= _NUMBERS:
                if len(waiting) + len(value) > MAX_ROWS:
                    raise TooLarge("The answer is a list with far more rows than any cloud.")
                waiting += [(item, depth + 1) for item in value]
        elif isinstance(value, np.ndarray):
            count += value.size
            _assert_number_count(count, max_count)
            _assert_few_dimensions(value.ndim + depth)
        elif isinstance(value, int):
            _assert_small_integer(value)
        elif depth and not isinstance(value, _ITEMS) and not hasattr(value, "__array__"):
            raise NotNumbers


def _assert_number_count(count: int, max_count: int) -> None:
    if count > max_count:
        raise TooLarge(
            f"The answer contains more than {_WORDS[max_count]} values. No right answer has that "
            "many."
        )


def _assert_few_dimensions(dimensions: int) -> None:
    if dimensions > MAX_DIMENSIONS:
        raise TooLarge("The answer has more than three dimensions. No right answer has that many.")


def _assert_small_integer(number: int) -> None:
    if abs(number) > MAX_INTEGER:
        raise TooLarge(
            "The answer contains a number with more than nineteen digits. No right answer contains "
            "one that large."
        )
