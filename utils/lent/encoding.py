"""Encode answers as compact JSON, and calls as keys that are equal on all machines."""

from __future__ import annotations

import base64
import hashlib
import importlib
import numbers
import zlib
from collections.abc import Iterator
from dataclasses import fields, is_dataclass

import numpy as np

# Rounding steps in metres; the coarse one is for large arrays, which are only drawn as dots.
FINE, COARSE = 1e-4, 5e-3
MAX_FINE_NUMBERS = 3_000
MAX_PLAIN_NUMBERS = 64


def key_of(arguments: tuple, keywords: dict) -> str:
    """Return a short key that identifies a call on every machine.

    Only eight digits of each number count, because machines may round the last digits differently.
    """
    text = "\n".join(_key_texts([arguments, sorted(keywords.items())]))
    return hashlib.sha256(text.encode()).hexdigest()[:10]


def _key_texts(start: list) -> Iterator[str]:
    # A stack instead of recursion, because trees may be deep.
    waiting, seen = [start], set()
    while waiting:
        value = waiting.pop()
        if isinstance(value, np.ndarray):
            yield _array_key_text(value)
        elif value is None or isinstance(value, str | bytes):
            yield repr(value)
        elif isinstance(value, numbers.Number):
            yield f"{complex(value):.8g}"
        elif isinstance(value, np.random.Generator):
            yield repr(value.bit_generator.state)
        elif id(value) in seen:
            yield "again"
        elif isinstance(value, dict):
            seen.add(id(value))
            yield f"dict {len(value)}"
            waiting.extend(reversed([part for pair in value.items() for part in pair]))
        elif isinstance(value, list | tuple | range):
            seen.add(id(value))
            yield f"sequence {len(value)}"
            waiting.extend(reversed(value))
        elif is_dataclass(value) and not isinstance(value, type):
            seen.add(id(value))
            yield type(value).__name__
            waiting.extend(getattr(value, part.name, None) for part in reversed(fields(value)))
        else:
            yield getattr(value, "__name__", type(value).__name__)


def _array_key_text(array: np.ndarray) -> str:
    if array.dtype.kind not in "biuf":
        return f"{array.shape} {array.tolist()}"
    flat = np.nan_to_num(array.astype(float).ravel(), nan=7.7, posinf=8.8, neginf=9.9)
    # The weights make the order count. The shift distinguishes numbers with opposite signs.
    mean = np.mean(np.abs(flat + 97.31) * np.linspace(0.5, 1.5, flat.size)) if flat.size else 0.0
    return f"{array.shape} {mean:.8g}"


def rng_states(arguments: tuple, keywords: dict) -> list:
    """Return the states of the random generators among the arguments, in order."""
    return [rng.bit_generator.state for rng in _random_generators(arguments, keywords)]


def set_rng_states(arguments: tuple, keywords: dict, states: list) -> None:
    """Set the generators among the arguments to their states after the recorded call."""
    for generator, state in zip(_random_generators(arguments, keywords), states, strict=False):
        generator.bit_generator.state = state


def _random_generators(arguments: tuple, keywords: dict) -> list[np.random.Generator]:
    given = [*arguments, *keywords.values()]
    return [value for value in given if isinstance(value, np.random.Generator)]


def encode(answer: object, arguments: tuple = ()) -> object:
    """Encode an answer as JSON-compatible data, which `decode` reverses.

    Parameters
    ----------
    answer : object
        None, bools, numbers, strings, arrays, data classes, and lists, tuples and dictionaries of
        these.
    arguments : tuple
        Arguments of the call. If the answer consists of rows of one of them, only a mask is stored.

    Raises
    ------
    TypeError
        If the answer contains any other type.
    """
    table: list[dict] = []
    known: dict[int, int] = {}
    waiting: list[object] = []

    def encoded(value: object) -> object:
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, np.bool_):
            return bool(value)
        if isinstance(value, numbers.Integral):
            return int(value)
        if isinstance(value, numbers.Real):
            # Far more digits than `key_of` uses, because an answer may be the next call's argument.
            return float(f"{float(value):.15g}")
        if isinstance(value, np.ndarray):
            return _encode_array(value, arguments)
        if isinstance(value, list):
            return [encoded(part) for part in value]
        if isinstance(value, tuple):
            return {"tuple": [encoded(part) for part in value]}
        if isinstance(value, dict):
            return {"dict": [[encoded(key), encoded(part)] for key, part in value.items()]}
        if is_dataclass(value) and not isinstance(value, type):
            if id(value) not in known:
                known[id(value)] = len(known)
                waiting.append(value)
            return {"object": known[id(value)]}
        raise TypeError(f"an answer of type {type(value).__name__} cannot be stored")

    stored = encoded(answer)
    while waiting:
        value = waiting.pop(0)
        module = type(value).__module__
        table.append(
            {
                "class": type(value).__qualname__,
                "module": module if module.startswith("utils.") else "",
                "fields": {part.name: encoded(getattr(value, part.name)) for part in fields(value)},
            }
        )
    return {"answer": stored, "objects": table} if table else stored


def _encode_array(array: np.ndarray, arguments: tuple) -> dict:
    for number, argument in enumerate(arguments):
        rows = _rows_of(array, argument)
        if rows is not None:
            return {"rows_of": number, "mask": _pack(np.packbits(rows).tobytes())}
        pairs = _relabelling(array, argument)
        if pairs is not None:
            return {"renamed": number, "pairs": pairs}
    kind = array.dtype.kind
    if kind not in "biuf":
        raise TypeError(f"an array of {array.dtype} cannot be stored")
    about = {"shape": list(array.shape), "kind": kind}
    if array.ndim == 0 or array.size == 0:
        return about | {"numbers": array.ravel().tolist()}
    if kind == "f":
        if array.size <= MAX_PLAIN_NUMBERS:
            return about | {"numbers": [float(f"{x:.15g}") for x in array.ravel().tolist()]}
        if not np.isfinite(array).all() or np.abs(array).max() > 1e4:
            return about | {"single": _pack(array.astype("<f4").tobytes())}
        step = FINE if array.size <= MAX_FINE_NUMBERS else COARSE
        whole = np.round(array / step).astype(np.int64)
        about["step"] = step
    else:
        whole = array.astype(np.int64)
    # Neighbouring rows are similar, so their differences compress better. Placing bytes of equal
    # significance next to each other helps further.
    change = np.diff(whole.reshape(len(array), -1), axis=0, prepend=0)
    planes = change.astype("<i8").ravel().view(np.uint8).reshape(-1, 8).T
    return about | {"changes": _pack(planes.tobytes())}


def _rows_of(array: np.ndarray, argument: object) -> np.ndarray | None:
    """Return a mask (n,) of the argument's rows that form the answer; None if it has other rows."""
    if not isinstance(argument, np.ndarray) or array.ndim != 2 or argument.ndim != 2:
        return None
    if array.shape[1] != argument.shape[1] or array.dtype != argument.dtype:
        return None
    wanted, mask, found = [row.tobytes() for row in array], np.zeros(len(argument), bool), 0
    for number, row in enumerate(argument):
        if found < len(wanted) and row.tobytes() == wanted[found]:
            mask[number], found = True, found + 1
    return mask if found == len(wanted) else None


def _relabelling(array: np.ndarray, argument: object) -> list | None:
    """Return old and new labels if the answer relabels the argument consistently; else None."""
    if not isinstance(argument, np.ndarray) or array.ndim != 1 or array.shape != argument.shape:
        return None
    if array.dtype.kind not in "iu" or argument.dtype.kind not in "iu":
        return None
    labels, first = np.unique(argument, return_index=True)
    if not np.array_equal(array, array[first][np.searchsorted(labels, argument)]):
        return None
    return [labels.tolist(), array[first].tolist()]


def decode(stored: object, arguments: tuple, namespace: dict) -> object:
    """Decode an answer from `encode`.

    Parameters
    ----------
    stored : object
        The encoded answer.
    arguments : tuple
        Arguments of the call.
    namespace : dict
        The notebook's namespace, which contains its classes.
    """
    has_objects = isinstance(stored, dict) and "objects" in stored
    table = stored["objects"] if has_objects else []
    made = [object.__new__(_class_of(entry, namespace)) for entry in table]

    def decoded(value: object) -> object:
        if isinstance(value, list):
            return [decoded(part) for part in value]
        if not isinstance(value, dict):
            return value
        if "tuple" in value:
            return tuple(decoded(part) for part in value["tuple"])
        if "dict" in value:
            return {decoded(key): decoded(part) for key, part in value["dict"]}
        if "object" in value:
            return made[value["object"]]
        if "rows_of" in value:
            rows = arguments[value["rows_of"]]
            bits = np.frombuffer(_unpack(value["mask"]), np.uint8)
            return rows[np.unpackbits(bits, count=len(rows)).astype(bool)]
        if "renamed" in value:
            old, new = (np.array(part, dtype=np.int64) for part in value["pairs"])
            return new[np.searchsorted(old, arguments[value["renamed"]])]
        return _decode_array(value)

    for thing, entry in zip(made, table, strict=True):
        for name, value in entry["fields"].items():
            object.__setattr__(thing, name, decoded(value))
    return decoded(stored["answer"] if has_objects else stored)


def _class_of(entry: dict, namespace: dict) -> type:
    if entry["module"]:
        return getattr(importlib.import_module(entry["module"]), entry["class"])
    return namespace[entry["class"]]


def _decode_array(stored: dict) -> np.ndarray:
    shape = tuple(stored["shape"])
    kind = {"f": float, "b": bool}.get(stored["kind"], np.int64)
    if "numbers" in stored:
        return np.array(stored["numbers"], dtype=kind).reshape(shape)
    if "single" in stored:
        return np.frombuffer(_unpack(stored["single"]), "<f4").astype(float).reshape(shape)
    planes = np.frombuffer(_unpack(stored["changes"]), np.uint8).reshape(8, -1)
    whole = np.ascontiguousarray(planes.T).view("<i8").ravel()
    whole = np.cumsum(whole.reshape(shape[0], -1), axis=0).reshape(shape)
    return whole * stored["step"] if "step" in stored else whole.astype(kind)


def _pack(data: bytes) -> str:
    return base64.b85encode(zlib.compress(data, 9)).decode()


def _unpack(text: str) -> bytes:
    return zlib.decompress(base64.b85decode(text))
