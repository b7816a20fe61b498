"""The protocol between a student's process and the judge handles honest and hostile bytes."""

import json
import math
import os
import threading
import time
import tracemalloc

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from grader.judging.runner import MAX_REPLY_BYTES
from grader.sandbox.inside import wire, wire_format
from grader.sandbox.inside.wire import WireClosed, WireTimeout
from grader.sandbox.inside.wire_format import OpaqueValue, TooLarge, WireError

SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**63), 2**63 - 1),
    st.floats(),
    st.text(st.characters(exclude_categories=["Cs"])),
)
ARRAYS = st.sampled_from(wire_format.PLAIN_TYPES).flatmap(
    lambda dtype: st_numpy.arrays(dtype, st_numpy.array_shapes(min_dims=0, min_side=0))
)
VALUES = st.recursive(
    SCALARS | ARRAYS,
    lambda inner: st.one_of(
        st.lists(inner),
        st.lists(inner).map(tuple),
        st.sets(SCALARS),
        st.dictionaries(SCALARS, inner),
    ),
    max_leaves=12,
)


def parts(message):
    """Return the two parts of an encoded message: the JSON tree, and the bytes of the arrays."""
    tree_size, blob_size = wire_format.HEADER.unpack(message[:8])
    assert len(message) == 8 + tree_size + blob_size
    return message[8 : 8 + tree_size], message[8 + tree_size :]


def round_trip(value):
    return wire_format.decode(*parts(wire_format.encode(value)))


def is_same(first, second):
    """Return whether two values have the same type and are equal; NaN equals NaN."""
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return first.dtype == second.dtype and np.array_equal(first, second, equal_nan=True)
    if isinstance(first, (list, tuple)):
        return len(first) == len(second) and all(map(is_same, first, second))
    if isinstance(first, dict):
        return is_same(list(first.items()), list(second.items()))
    if isinstance(first, set):
        return sorted(map(repr, first)) == sorted(map(repr, second))
    return first == second or (
        isinstance(first, float) and math.isnan(first) and math.isnan(second)
    )


def is_plain(value):
    if isinstance(value, np.ndarray):
        return (
            value.dtype.newbyteorder("<").str in wire_format.PLAIN_TYPES and value.flags.writeable
        )
    if isinstance(value, dict):
        return all(is_plain(item) for pair in value.items() for item in pair)
    if isinstance(value, (list, tuple, set)):
        return all(map(is_plain, value))
    return type(value) in (type(None), bool, int, float, str, OpaqueValue)


@given(VALUES)
def test_plain_data_is_transferred_unchanged(value):
    assert is_same(round_trip(value), value)


@pytest.mark.parametrize(
    "array",
    [
        np.arange(6).reshape(2, 3)[:, ::2],
        np.asfortranarray(np.eye(3)),
        np.arange(3, dtype=">i4"),
        np.array(5.0),
        np.zeros((0, 4)),
        np.zeros((3, 0, 2), bool),
        np.broadcast_to(1.0, (2, 3)),
        np.arange(3, dtype=np.longdouble),
        np.arange(4.0).view(np.recarray),
        np.float32([1, np.nan]),
    ],
    ids=str,
)
def test_arrays_of_any_layout_arrive_writable(array):
    back = round_trip(array)
    assert back.shape == array.shape and back.flags.writeable and back.flags.aligned
    assert np.array_equal(back, np.asarray(array), equal_nan=True)


@pytest.mark.parametrize(
    "value",
    [
        [1.5, math.inf],
        (2**63 - 1, -(2**63)),
        [1, True],
        [1.0, 2],
        ["a", "\ud800"],
        [np.float64(2.5), 1.0],
        [],
        [2**63, 1],
    ],
)
def test_lists_of_one_type_and_mixed_lists_are_transferred_unchanged(value):
    """Lists of a single plain type are checked as a whole, which must not let other values pass."""
    assert round_trip(value) == type(value)(round_trip(item) for item in value)


@pytest.mark.slow
def test_a_list_of_many_rows_is_transferred_quickly():
    """Encoding and decoding take linear time; quadratic time would be minutes."""
    rows = list(np.random.default_rng(1).normal(size=(60_000, 4)))
    start = time.process_time()
    assert np.array_equal(round_trip(rows), rows)
    assert time.process_time() - start < 10.0


@pytest.mark.parametrize(
    "value, name",
    [
        (object(), "object"),
        (2**63, "64 bits"),
        (1j, "complex"),
        (np.zeros(2, complex), "complex"),
        ({(1, 2): 3}, "a dict with a key"),
        ({(1, 2)}, "a set with an element"),
        (np.zeros((1,) * 20), "an array of float64"),
        (np.zeros(2, "V4"), "an array of void"),
        (np.datetime64("2020"), "datetime64"),
        (np.ma.masked_array([1.0, 2.0], [True, False]), "MaskedArray"),
    ],
)
def test_objects_that_are_not_plain_data_arrive_as_the_name_of_their_type(value, name):
    back = round_trip([value, 1, np.ones(2)])
    assert isinstance(back[0], OpaqueValue) and name in back[0].type_name
    assert back[1] == 1 and np.array_equal(back[2], [1, 1])


def test_deep_and_endless_nesting_is_replaced_with_a_text():
    endless = []
    endless.append(endless)
    assert "deeply nested" in str(round_trip(endless))


@pytest.mark.parametrize(
    "value",
    [np.zeros(2**23), ["x" * 2**20] * 17, [np.zeros(2**21)] * 3, np.zeros((2**26, 0, 1)[::2])],
)
def test_a_value_that_is_too_large_is_refused_before_it_is_sent(value):
    if getattr(value, "size", 1) == 0:
        assert isinstance(round_trip(value), OpaqueValue)
        return
    with pytest.raises(TooLarge):
        wire_format.encode(value)


def test_commas_in_texts_do_not_count_as_values(monkeypatch):
    monkeypatch.setattr(wire_format, "MAX_COMMAS", 1000)
    monkeypatch.setattr(wire_format, "MAX_BRACKETS", 500)
    cells = ["pasted = [" + "1," * 1100 + "]", "[" * 600, '"\\' * 1100]
    assert round_trip({"cells": cells}) == {"cells": cells}
    values = [[1]] * 600
    with pytest.raises(TooLarge):
        wire_format.encode(values)


def test_unterminated_texts_take_linear_time():
    def seconds(tree):
        start = time.process_time()
        with pytest.raises(WireError):
            wire_format.decode(tree, b"")
        return time.process_time() - start

    for end in (b'"', b'\\"', b'"a', b"\\"):
        commas = b"," * (wire_format.MAX_COMMAS + 1)
        assert seconds(commas + end * 500_000) < 5


def decodes_or_refuses(tree, blob=b""):
    """Assert that `decode` returns plain data or raises `WireError`, and uses little memory."""
    tracemalloc.start()
    try:
        value = wire_format.decode(tree, blob)
    except WireError:
        value = None
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert is_plain(value)
    assert peak < 5_000_000 + 60 * (len(tree) + len(blob))
    json.dumps(str(value), ensure_ascii=False).encode()


JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text()
    | st.sampled_from([*wire_format.PLAIN_TYPES, "O", "V8", "f8,f8", "(2,)f8", "U9"]),
    lambda inner: (
        st.lists(inner)
        | st.dictionaries(
            st.sampled_from(["list", "tuple", "set", "dict", "array", "opaque", "pickle"]),
            inner,
            min_size=1,
            max_size=1,
        )
    ),
    max_leaves=30,
)


@given(st.binary(max_size=200), st.binary(max_size=50))
def test_any_bytes_are_decoded_or_refused(tree, blob):
    decodes_or_refuses(tree, blob)


@pytest.mark.slow
@given(JSON, st.binary(max_size=100))
@settings(max_examples=200)
def test_any_json_is_decoded_or_refused(tree, blob):
    decodes_or_refuses(json.dumps(tree).encode(), blob)


@given(VALUES, st.data())
def test_a_message_with_changed_bytes_is_decoded_or_refused(value, data):
    tree, blob = map(bytearray, parts(wire_format.encode(value)))
    for part in (tree, blob):
        if part:
            part[data.draw(st.integers(0, len(part) - 1))] = data.draw(st.integers(0, 255))
    decodes_or_refuses(bytes(tree), bytes(blob)[: data.draw(st.integers(0, len(blob)))])


@pytest.mark.parametrize(
    "tree",
    [
        b'{"array":["O",[1]]}',
        b'{"array":["|V8",[1]]}',
        b'{"array":["<f8,<f8",[1]]}',
        b'{"array":["(9,9)<f8",[1]]}',
        b'{"array":["<c16",[1]]}',
        b'{"array":["<f8",[-1]]}',
        b'{"array":["<f8",[true]]}',
        b'{"array":["<f8",[1.0]]}',
        b'{"array":["<f8",["1"]]}',
        b'{"array":["<f8",[9223372036854775808,0]]}',
        b'{"array":["<f8",[1099511627776,0]]}',
        b'{"array":["<f8",{"0":1}]}',
        b'{"array":["<f8",[2]]}',
        b'{"array":[["<f8"],[1]]}',
        b'{"array":["<f8",' + str([1] * 40).encode() + b"]}",
        b'{"array":"ab"}',
        b'{"array":3}',
        b'{"set":[{"list":[]}]}',
        b'{"set":[{"tuple":[1]}]}',
        b'{"dict":[[{"tuple":[]},1]]}',
        b'{"dict":[1]}',
        b'{"dict":[[1]]}',
        b'{"list":3}',
        b'{"opaque":[]}',
        b'{"opaque":"a","b":1}',
        b"9" * 30,
        b"9" * 10_000,
        b"[1]",
        b"{}",
        b'"\\ud800',
        b"\xff",
        b"[" * 10**6,
        b'{"list":[' * 200 + b"]}" * 200,
        b"-",
        b'{"list":[' + b"[]," * 99 + b"1]}",
    ],
)
def test_messages_with_false_sizes_are_refused(tree):
    with pytest.raises(WireError):
        wire_format.decode(tree, b"12345678")


def test_two_arrays_cannot_share_bytes():
    """A message of a few megabytes could otherwise expand to a hundred gigabytes of arrays."""
    claim = b'{"array":["|u1",[1048576]]}'
    with pytest.raises(WireError):
        wire_format.decode(b'{"list":[' + b",".join([claim] * 100_000) + b"]}", bytes(2**20))


@pytest.mark.parametrize(
    "unit",
    [b'{"set":[]}', b'{"array":["|b1",[0]]}', b'{"generator":["1","1",0,0]}', b'"ab"', b"1.5,null"],
)
def test_many_small_values_are_refused_before_memory_is_allocated(unit):
    """Decoding the values would take ten seconds and fifty times as much memory as the message."""
    most = wire_format.MAX_TREE_BYTES - 20
    tree = bytearray(b'{"list":[' + b",".join([unit] * (most // (len(unit) + 1))) + b"]}")
    tracemalloc.start()
    try:
        with pytest.raises(WireError, match="more values"):
            wire_format.decode(tree, b"")
        assert tracemalloc.get_traced_memory()[1] < 2**20
    finally:
        tracemalloc.stop()


def test_the_number_of_generators_is_limited():
    generators = [np.random.default_rng(seed) for seed in range(101)]
    assert len(round_trip(generators[:100])) == 100
    with pytest.raises(WireError, match="generators"):
        round_trip(generators)


@pytest.mark.slow
def test_the_largest_cloud_is_transferred_as_a_list_of_rows():
    cloud = np.random.default_rng(1).integers(-(2**9), 2**9, (120_000, 4)) / 4
    assert round_trip(cloud.tolist()) == cloud.tolist()
    assert np.array_equal(round_trip(list(cloud)), cloud)
    # The judge does not count even its longest form as too large.
    longest = np.random.default_rng(1).uniform(-0.01, 0, (120_000, 4)).tolist()
    assert len(wire_format.encode(longest)) < MAX_REPLY_BYTES


def test_keys_that_collide_are_refused():
    """Keys with equal hashes are refused, because building a set of them takes quadratic time."""
    modulus = 2**61 - 1
    colliding = b",".join(b"%d" % (n * modulus) for n in range(1, 100_000))
    start = time.process_time()
    with pytest.raises(WireError):
        wire_format.decode(b'{"set":[' + colliding + b"]}", b"")
    assert time.process_time() - start < 20  # building a set would take minutes


def test_lone_surrogates_are_replaced():
    assert wire_format.decode(b'"a\\ud800b"', b"") == "a?b"


@pytest.mark.parametrize(
    "value",
    [
        type("x78_755", (), {})(),
        type("x" * 10**6, (), {})(),
        type("\x1b[2J\u202e", (), {})(),
        np.zeros(2, [("x78_755", "O")]),
    ],
    ids=["a number", "a long one", "a command to the terminal", "the name of a field"],
)
def test_the_name_of_a_students_class_is_not_transferred(value):
    """Only a general description is sent, because the name could contain hidden input."""
    assert round_trip([value])[0].type_name in (
        "an object of a custom class",
        "an array of void",
    )


@pytest.mark.parametrize("value", [(n for n in ()), {}.keys(), zip(), print, 1j, np, type])
def test_the_name_of_a_python_type_is_transferred(value):
    assert round_trip([value])[0].type_name == type(value).__name__


# ---- On a pipe ----------------------------------------------------------------------------


@pytest.fixture
def pipe():
    """Return the non-blocking ends of a pipe."""
    ends = os.pipe()
    for end in ends:
        os.set_blocking(end, False)
    yield ends
    for end in ends:
        os.close(end)


def short_time_limit():
    return wire.start_time_limit(0.3)


def test_large_messages_are_sent_through_a_small_pipe(pipe):
    value = np.random.default_rng(1).normal(size=(120_000, 4))
    sender = threading.Thread(target=wire.send, args=(pipe[1], value, wire.start_time_limit(20)))
    sender.start()
    assert np.array_equal(wire.receive(pipe[0], wire.start_time_limit(20)), value)
    sender.join()


def test_a_silent_and_a_full_pipe_time_out(pipe):
    with pytest.raises(WireTimeout):
        wire.receive(pipe[0], short_time_limit())
    with pytest.raises(WireTimeout):
        wire.send(pipe[1], np.zeros(2**20), short_time_limit())


def test_an_incomplete_message_times_out(pipe):
    os.write(pipe[1], wire_format.encode(np.zeros(3))[:-1])
    with pytest.raises(WireTimeout):
        wire.receive(pipe[0], short_time_limit())


def test_the_time_limit_applies_while_data_trickles_in(pipe):
    """A reader that always finds more data must still observe the time limit."""
    os.write(pipe[1], wire_format.encode("complete, but too late"))
    with pytest.raises(WireTimeout):
        wire.receive(pipe[0], wire.start_time_limit(-1))


def test_withdrawn_data_does_not_block_the_reader(pipe, monkeypatch):
    """The reader does not block if the writer reads its own data back after `poll` reported it."""
    wait, calls = wire._wait, []

    def skip_first_wait(descriptor, seconds, event):
        calls.append(event)
        if len(calls) > 1:
            wait(descriptor, seconds, event)

    monkeypatch.setattr(wire, "_wait", skip_first_wait)
    with pytest.raises(WireTimeout):
        wire.receive(pipe[0], short_time_limit())
    assert len(calls) == 2


@pytest.mark.parametrize("header", [(2**32 - 1, 0), (0, 2**32 - 1), (2**25, 2**26)])
def test_a_message_that_is_too_large_is_refused_unread(pipe, header):
    os.write(pipe[1], wire_format.HEADER.pack(*header))
    with pytest.raises(WireError):
        wire.receive(pipe[0], short_time_limit())


def test_a_closed_pipe_is_reported():
    reading, writing = os.pipe()
    os.close(reading)
    with pytest.raises(WireClosed):
        wire.send(writing, 1)
    os.close(writing)
    reading, writing = os.pipe()
    os.write(writing, b"\0\0")
    os.close(writing)
    with pytest.raises(WireClosed):
        wire.receive(reading)
    os.close(reading)
