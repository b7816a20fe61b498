"""Encode and decode plain data; student code and the judge exchange nothing else.

A message is a JSON tree followed by the bytes of its arrays. It can contain numbers, strings,
containers, arrays of a plain dtype and NumPy's default random generators. Other sequences and
array-like objects arrive as lists or arrays. Any other value arrives as an `OpaqueValue`, which
contains only the name of its type, and only if that is a type of Python or NumPy. The other end may
be hostile, so nothing is unpickled, and every size is checked before memory is allocated.
"""

import builtins
import json
import math
import re
import struct
import types
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

PLAIN_TYPES = ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f2", "<f4", "<f8")
MAX_TREE_BYTES = 16 * 2**20
MAX_ARRAY_BYTES = 32 * 2**20
# Limits on the numbers of values and containers in a tree. They are about twice as large as needed
# for the largest array, sent as a list of rows. Without them, a message could fill the memory,
# because a decoded value may take forty times as much memory as its encoded bytes.
MAX_COMMAS = 2**20
MAX_BRACKETS = 2**19
MAX_GENERATORS = 100
MAX_DEPTH = 60
MAX_DIMENSIONS = 16
HEADER = struct.Struct(">II")  # the sizes of the tree and of the arrays, in bytes
# A string without a closing quote extends to the end, so that the search takes linear time.
_TEXT = re.compile(rb'"(?:[^"\\]|\\.)*+"?', re.DOTALL)
_SCALARS = (type(None), bool, int, float, str, np.generic)
_NESTED_VALUE = "a very deeply nested value"
_LARGE_INTEGER = "an integer beyond 64 bits"
_NON_SCALAR_KEYS = {
    "dict": "a dict with a key that is neither a number nor a string",
    "set": "a set with an element that is neither a number nor a string",
}
_CUSTOM_OBJECT = "an object of a custom class"
# Type names that messages may contain. Other names are left out, because student code could hide
# the input of a hidden test in the name of a class.
_NAMES_OF_TYPES = {
    value.__name__
    for module in (builtins, types, np)
    for value in vars(module).values()
    if isinstance(value, type)
} | {"dict_keys", "dict_values", "dict_items", "MaskedArray"}
_KNOWN_TYPES = {
    *_NAMES_OF_TYPES,
    *(f"an array of {name}" for name in _NAMES_OF_TYPES),
    *_NON_SCALAR_KEYS.values(),
    _NESTED_VALUE,
    _LARGE_INTEGER,
}


class WireError(Exception):
    """The bytes are not a valid message."""


class TooLarge(Exception):
    """A value is larger than any answer can be."""


@dataclass(frozen=True)
class OpaqueValue:
    """A placeholder for a value that is not plain data."""

    type_name: str


def encode(value: object) -> bytes:
    """Return the bytes of a message.

    Parameters
    ----------
    value : object
        Any value. Parts that are not plain data become an `OpaqueValue`.

    Raises
    ------
    TooLarge
        If the message would be larger than the limits.
    """
    blob = bytearray()
    tree = json.dumps(_to_tree(value, blob, 0), separators=(",", ":")).encode()
    if len(tree) > MAX_TREE_BYTES or not _is_within_limits(tree):
        raise TooLarge
    return b"".join((HEADER.pack(len(tree), len(blob)), tree, blob))


def sizes_in(header: bytes) -> tuple[int, int]:
    """Return the sizes of the tree and of the arrays in bytes, from the header of a message.

    Parameters
    ----------
    header : bytes or bytearray
        `HEADER.size` bytes.

    Raises
    ------
    WireError
        If the message would be larger than the limits.
    """
    tree_size, blob_size = HEADER.unpack(header)
    if tree_size > MAX_TREE_BYTES or blob_size > MAX_ARRAY_BYTES:
        raise WireError("a message larger than any answer can be")
    return tree_size, blob_size


def decode(tree: bytes, blob: bytes) -> object:
    """Return the value of a message, after checking every type and size in it.

    Parameters
    ----------
    tree, blob : bytes or bytearray
        The parts that follow the header, in the sizes that the header states.

    Returns
    -------
    object
        The value. Its arrays are writable.

    Raises
    ------
    WireError
        If the bytes are not a valid message within the limits.
    """
    if not _is_within_limits(tree):
        raise WireError("more values than any answer has")
    try:
        return _from_tree(json.loads(tree), _Remainder(blob), 0)
    except WireError:
        raise
    except Exception as error:  # hostile bytes may cause any exception in json or numpy
        raise WireError(f"not a message: {type(error).__name__}") from None


def is_plain(value: object) -> bool:
    """Return whether a value can be sent as plain data; objects of a student's class cannot."""
    return isinstance(value, (*_SCALARS, np.ndarray, set, frozenset, dict, Sequence)) or hasattr(
        value, "__array__"
    )


def _to_tree(value: object, blob: bytearray, depth: int) -> object:
    if depth > MAX_DEPTH:
        return {"opaque": _NESTED_VALUE}
    if value is None or isinstance(value, (bool, str)):
        return str(value) if isinstance(value, str) else value
    if isinstance(value, np.ndarray):
        if np.ma.is_masked(value):  # as a plain array, it would contain the hidden values again
            return {"opaque": "MaskedArray"}
        return _array_to_tree(np.asarray(value), blob, depth)
    if isinstance(value, np.generic):
        if isinstance(value, np.longdouble):
            return float(value)  # `item()` would return a longdouble again
        plain = value.dtype.kind in "biufU"
        return _to_tree(value.item() if plain else OpaqueValue(type(value).__name__), blob, depth)
    if isinstance(value, int):
        return int(value) if _is_small(value) else {"opaque": _LARGE_INTEGER}
    if isinstance(value, float):
        return float(value)
    if isinstance(value, (list, tuple)):
        kind = "list" if isinstance(value, list) else "tuple"
        if _is_flat(value) or set(map(type, value)) == {str}:
            return {kind: list(value)}
        return {kind: [_to_tree(item, blob, depth + 1) for item in value]}
    if isinstance(value, (set, frozenset, dict)):
        return _dict_or_set_to_tree(value, blob, depth)
    if _is_generator(value):
        return {"generator": _state_of(value)}
    if isinstance(value, OpaqueValue):
        return {"opaque": value.type_name}
    if hasattr(value, "__array__"):  # results of pandas and torch are valid answers
        return _array_to_tree(np.asarray(value), blob, depth)
    if isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray, memoryview)):
        return _to_tree(list(value), blob, depth)  # a range or a deque, which NumPy can read
    return {"opaque": type(value).__name__}


def _dict_or_set_to_tree(value: set | frozenset | dict, blob: bytearray, depth: int) -> dict:
    # Only scalars are allowed as keys. Student code can create a million tuples with the same hash,
    # and the judge would take hours to build a set of them.
    name = "dict" if isinstance(value, dict) else "set"
    if not all(isinstance(key, _SCALARS) for key in value):
        return {"opaque": _NON_SCALAR_KEYS[name]}
    if name == "set":
        return {"set": [_to_tree(item, blob, depth + 1) for item in value]}
    return {
        "dict": [
            [_to_tree(key, blob, depth + 1), _to_tree(item, blob, depth + 1)]
            for key, item in value.items()
        ]
    }


def _array_to_tree(array: np.ndarray, blob: bytearray, depth: int) -> object:
    if array.dtype == np.longdouble:
        array = array.astype(float)
    little = array.dtype.newbyteorder("<")
    if len(blob) + array.nbytes > MAX_ARRAY_BYTES:
        raise TooLarge
    if little.str not in PLAIN_TYPES or not _is_possible_shape(array.shape):
        if array.dtype.kind in "OU" and array.size < 1_000_000:
            return _to_tree(array.tolist(), blob, depth + 1)
        return {"opaque": f"an array of {array.dtype.type.__name__}"}
    blob += np.ascontiguousarray(array, little).data.cast("B") if array.size else b""
    return {"array": [little.str, list(array.shape)]}


class _Remainder:
    """The part of a message that is not decoded yet."""

    def __init__(self, blob: bytes) -> None:
        self.blob, self.generators = memoryview(blob), MAX_GENERATORS

    def take_bytes(self, size: int) -> memoryview:
        """Return the next bytes and remove them, so that two arrays never share bytes."""
        if size > len(self.blob):
            raise WireError("array outside its message")
        taken, self.blob = self.blob[:size], self.blob[size:]
        return taken

    def take_generator(self) -> None:
        """Count a generator against the limit.

        Creating a generator takes as long as creating a hundred numbers.
        """
        if not self.generators:
            raise WireError("more generators than any answer has")
        self.generators -= 1


def _from_tree(tree: object, remainder: _Remainder, depth: int) -> object:
    if depth > MAX_DEPTH + 5:
        raise WireError("nested too deeply")
    if isinstance(tree, str):
        return _writable_text(tree)
    if tree is None or isinstance(tree, (bool, float)) or _is_small(tree):
        return tree
    if not isinstance(tree, dict) or len(tree) != 1:
        raise WireError("unknown node")
    ((kind, content),) = tree.items()
    if kind in ("list", "tuple"):
        flat = type(content) is list and _is_flat(content)
        items = content if flat else [_from_tree(item, remainder, depth + 1) for item in content]
        return items if kind == "list" else tuple(items)
    if kind == "set":
        return {_key_from_tree(item, remainder, depth) for item in content}
    if kind == "dict":
        return {
            _key_from_tree(key, remainder, depth): _from_tree(item, remainder, depth + 1)
            for key, item in content
        }
    if kind == "array":
        return _array_from_tree(content, remainder)
    if kind == "generator":
        remainder.take_generator()
        return _generator_from(content)
    if kind == "opaque" and isinstance(content, str):
        return OpaqueValue(known_type(content))
    raise WireError("unknown kind of value")


def _key_from_tree(tree: object, remainder: _Remainder, depth: int) -> object:
    key = _from_tree(tree, remainder, depth + 1)
    if not isinstance(key, (*_SCALARS, OpaqueValue)):
        raise WireError("unknown kind of key")
    return key


def _array_from_tree(content: list, remainder: _Remainder) -> np.ndarray:
    dtype, shape = content
    # Only the listed types are allowed, because NumPy accepts many other strings as dtypes.
    if dtype not in PLAIN_TYPES:
        raise WireError("array of unknown type")
    if not isinstance(shape, list) or not _is_possible_shape(shape):
        raise WireError("array of impossible shape")
    dtype = np.dtype(dtype)
    return np.frombuffer(
        bytearray(remainder.take_bytes(math.prod(shape) * dtype.itemsize)), dtype
    ).reshape(shape)


def _is_generator(value: object) -> bool:
    """Return whether a value is a generator from `numpy.random.default_rng`.

    The name is compared first, because importing numpy.random takes time.
    """
    return type(value).__name__ == "Generator" and isinstance(
        getattr(value, "bit_generator", None), np.random.PCG64
    )


def _state_of(generator: np.random.Generator) -> list:
    state = generator.bit_generator.state
    numbers = (state["state"]["state"], state["state"]["inc"])
    # The two numbers are sent as strings, because some JSON parsers cannot read 128-bit numbers.
    return [*map(hex, numbers), state["has_uint32"], state["uinteger"]]


def _generator_from(content: object) -> np.random.Generator:
    """Return a generator with the same state as the generator at the other end."""
    state, increment, has_uint32, uinteger = content
    bits = np.random.PCG64()
    bits.state = {
        "bit_generator": "PCG64",
        "state": {"state": int(state, 16), "inc": int(increment, 16)},
        "has_uint32": int(has_uint32),
        "uinteger": int(uinteger),
    }
    return np.random.Generator(bits)


def _is_possible_shape(shape: Sequence[int]) -> bool:
    # Each length is checked, because an array with a length of 0 has no data, so its other lengths
    # could be arbitrarily large.
    return len(shape) <= MAX_DIMENSIONS and all(
        type(n) is int and 0 <= n <= MAX_ARRAY_BYTES for n in shape
    )


def _is_within_limits(tree: bytes) -> bool:
    """Return whether a tree respects the limits on values and containers.

    Commas and brackets inside strings do not count, because a notebook may contain a long table.
    """
    commas, brackets = tree.count(b","), tree.count(b"[") + tree.count(b"{")
    if commas <= MAX_COMMAS and brackets <= MAX_BRACKETS:
        return True
    if tree.count(b'"') - tree.count(b'\\"') > 2 * MAX_COMMAS:  # each string is a value
        return False
    for text in _TEXT.finditer(tree):
        start, end = text.span()
        commas -= tree.count(b",", start, end)
        brackets -= tree.count(b"[", start, end) + tree.count(b"{", start, end)
    return commas <= MAX_COMMAS and brackets <= MAX_BRACKETS


def _is_small(value: object) -> bool:
    return isinstance(value, int) and -(2**63) <= value < 2**63


def _is_flat(values: Sequence) -> bool:
    """Return whether all values are floats, or all are small integers.

    Such values need no conversion. Most lists are flat, and converting their items one by one
    takes ten times as long.
    """
    kinds = set(map(type, values))
    if kinds == {int}:
        return _is_small(min(values)) and _is_small(max(values))
    return kinds == {float}


def _writable_text(text: str) -> str:
    """Return a text without lone surrogates, which cannot be written to a file."""
    return text if text.isascii() else text.encode("utf-8", "replace").decode()


def known_type(name: object) -> str:
    """Return the name of a type if it is known, or else a general description."""
    return name if isinstance(name, str) and name in _KNOWN_TYPES else _CUSTOM_OBJECT
