"""Plain data on a pipe: the only thing that passes between a student's code and the judge.

A message is a JSON tree followed by the bytes of its arrays. Numbers, strings, containers and
arrays of plain dtype pass; anything else arrives as an `Opaque` that holds only the name of
its type. Nothing is ever unpickled, and every size is checked before memory is taken, because
whoever writes the other end may be hostile.
"""

import json
import math
import os
import select
import struct
import time
from dataclasses import dataclass

import numpy as np

PLAIN_KINDS = "biuf"
MAXIMUM_TREE = 16 * 2**20
MAXIMUM_ARRAYS = 256 * 2**20
MAXIMUM_DEPTH = 60
_HEADER = struct.Struct(">II")


class WireError(Exception):
    """What came over the pipe is not a message."""


class WireTimeout(Exception):
    """The other end did not answer in time."""


class WireClosed(Exception):
    """The other end has gone."""


@dataclass(frozen=True)
class Opaque:
    """Stands for a value that is not plain data."""

    type_name: str


def encode(value):
    """Bytes of a message.

    Parameters
    ----------
    value : object
        Any tree; what is not plain data becomes an `Opaque`.

    Returns
    -------
    bytes
    """
    arrays = []
    tree = json.dumps(_to_tree(value, arrays, 0), separators=(",", ":")).encode()
    blob = b"".join(arrays)
    if len(tree) > MAXIMUM_TREE or len(blob) > MAXIMUM_ARRAYS:
        tree, blob = json.dumps({"too large": type(value).__name__}).encode(), b""
    return _HEADER.pack(len(tree), len(blob)) + tree + blob


def decode(tree, blob):
    """Value of a message; every claim in it is checked.

    Parameters
    ----------
    tree, blob : bytes

    Returns
    -------
    object
        Arrays come back writable.

    Raises
    ------
    WireError
        If the bytes are not what `encode` writes.
    """
    try:
        return _from_tree(json.loads(tree), memoryview(blob), 0)
    except WireError:
        raise
    except Exception as error:  # hostile bytes may break json or numpy in any way they like
        raise WireError(f"not a message: {type(error).__name__}") from None


def _to_tree(value, arrays, depth):
    if depth > MAXIMUM_DEPTH:
        return {"opaque": "a very deeply nested value"}
    if value is None or isinstance(value, (bool, str)):
        return str(value) if isinstance(value, str) else value
    if isinstance(value, np.ndarray):
        return _array_to_tree(np.asarray(value), arrays, depth)
    if isinstance(value, np.generic):
        return _to_tree(value.item(), arrays, depth) if value.dtype.kind in PLAIN_KINDS + "U" \
            else {"opaque": type(value).__name__}
    if isinstance(value, int):
        return int(value) if abs(value) < 2**63 else {"opaque": "an integer beyond 64 bits"}
    if isinstance(value, float):
        return float(value)
    if isinstance(value, (list, tuple, set, frozenset)):
        name = next(kind.__name__ for kind in (list, tuple, set, frozenset)
                    if isinstance(value, kind))
        return {"set" if name == "frozenset" else name:
                [_to_tree(item, arrays, depth + 1) for item in value]}
    if isinstance(value, dict):
        return {"dict": [[_to_tree(key, arrays, depth + 1), _to_tree(item, arrays, depth + 1)]
                         for key, item in value.items()]}
    if isinstance(value, Opaque):
        return {"opaque": value.type_name}
    if hasattr(value, "__array__"):  # a pandas or torch user answers correctly too
        return _array_to_tree(np.asarray(value), arrays, depth)
    return {"opaque": type(value).__name__[:100]}


def _array_to_tree(array, arrays, depth):
    if array.dtype.kind not in PLAIN_KINDS or array.dtype.itemsize > 8:
        if array.dtype.kind in "OU" and array.size < 1_000_000:
            return _to_tree(array.tolist(), arrays, depth + 1)
        return {"opaque": f"an array of {array.dtype}"[:100]}
    data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<")).tobytes()
    offset = sum(map(len, arrays))
    arrays.append(data)
    return {"array": [array.dtype.newbyteorder("<").str, list(array.shape), offset]}


def _from_tree(tree, blob, depth):
    if depth > MAXIMUM_DEPTH + 5:
        raise WireError("nested too deeply")
    if tree is None or isinstance(tree, (bool, int, float, str)):
        return tree
    if not isinstance(tree, dict) or len(tree) != 1:
        raise WireError("unknown node")
    (kind, content), = tree.items()
    if kind in ("list", "tuple", "set"):
        items = [_from_tree(item, blob, depth + 1) for item in content]
        return {"list": list, "tuple": tuple, "set": set}[kind](items)
    if kind == "dict":
        return {_from_tree(key, blob, depth + 1): _from_tree(item, blob, depth + 1)
                for key, item in content}
    if kind == "array":
        return _array_from_tree(content, blob)
    if kind in ("opaque", "too large"):
        return Opaque(str(content)[:100])
    raise WireError(f"unknown kind of value {kind[:20]!r}")


def _array_from_tree(content, blob):
    dtype_text, shape, offset = content
    dtype = np.dtype(str(dtype_text))
    if dtype.kind not in PLAIN_KINDS or dtype.itemsize > 8 or dtype.fields or dtype.subdtype:
        raise WireError(f"array of {dtype_text!r}")
    if len(shape) > 16 or not all(isinstance(n, int) and 0 <= n < 2**40 for n in shape):
        raise WireError("array of impossible shape")
    count = math.prod(shape)
    if not isinstance(offset, int) or offset < 0 or \
            offset + count * dtype.itemsize > len(blob):
        raise WireError("array outside its message")
    return np.frombuffer(blob, dtype, count, offset).reshape(shape).copy()


def send(descriptor, value, deadline=None):
    """Write one message.

    Raises
    ------
    WireTimeout, WireClosed
    """
    view = memoryview(encode(value))
    while view:
        _wait(descriptor, deadline, writing=True)
        try:
            # A pipe that is ready takes at least PIPE_BUF bytes; more could block.
            view = view[os.write(descriptor, view[: select.PIPE_BUF if deadline else None]):]
        except BrokenPipeError:
            raise WireClosed from None


def receive(descriptor, deadline=None):
    """Read one message.

    Raises
    ------
    WireTimeout, WireClosed, WireError
    """
    tree_size, blob_size = _HEADER.unpack(_read(descriptor, _HEADER.size, deadline))
    if tree_size > MAXIMUM_TREE or blob_size > MAXIMUM_ARRAYS:
        raise WireError("a message larger than any answer can be")
    tree = _read(descriptor, tree_size, deadline)
    return decode(tree, _read(descriptor, blob_size, deadline))


def _read(descriptor, size, deadline):
    parts, missing = [], size
    while missing:
        _wait(descriptor, deadline, writing=False)
        part = os.read(descriptor, min(missing, 2**20))
        if not part:
            raise WireClosed
        parts.append(part)
        missing -= len(part)
    return b"".join(parts)


def _wait(descriptor, deadline, writing):
    if deadline is None:
        return
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT if writing else select.POLLIN)
    if not poll.poll(max(0.0, deadline - time.monotonic()) * 1000):
        raise WireTimeout
