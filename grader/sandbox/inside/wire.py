"""Send and receive messages through a pipe whose other end may be hostile."""

import os
import select
import time
from collections.abc import Callable

if __package__:
    from grader.sandbox.inside import wire_format
else:  # in the worker, which sees this folder but not its parents
    import wire_format


class WireTimeout(Exception):
    """The other end did not reply in time."""


class WireClosed(Exception):
    """The other end has closed the pipe."""


def start_time_limit(seconds: float) -> Callable[[], float]:
    """Return a function that limits elapsed time.

    Returns
    -------
    callable
        Returns the remaining seconds, or raises `WireTimeout` if there are none.
    """
    end = time.monotonic() + seconds

    def remaining_seconds() -> float:
        if (seconds := end - time.monotonic()) <= 0:
            raise WireTimeout
        return seconds

    return remaining_seconds


def send(descriptor: int, value: object, time_limit: Callable[[], float] | None = None) -> None:
    """Write one message.

    Parameters
    ----------
    descriptor : int
        Must be non-blocking if there is a `time_limit`, because the other end could otherwise make
        a write wait forever.
    value : object
        Encoded by `wire_format.encode`.
    time_limit : callable, optional
        A time limit like the result of `start_time_limit`. By default there is no limit.

    Raises
    ------
    WireTimeout
        If the other end does not read the message in time.
    WireClosed
        If the other end has closed the pipe.
    wire_format.TooLarge
        If the value is larger than any answer can be.
    """
    view = memoryview(wire_format.encode(value))
    while view:
        seconds_left = time_limit and time_limit()
        try:
            view = view[os.write(descriptor, view) :]
        except BlockingIOError:
            _wait(descriptor, seconds_left, select.POLLOUT)
        except BrokenPipeError:
            raise WireClosed from None


def receive(descriptor: int, time_limit: Callable[[], float] | None = None) -> object:
    """Read one message and decode it; see `receive_bytes`."""
    return wire_format.decode(*receive_bytes(descriptor, time_limit))


def receive_bytes(
    descriptor: int, time_limit: Callable[[], float] | None = None
) -> tuple[bytearray, bytearray]:
    """Read one message.

    Parameters
    ----------
    descriptor : int
        Must be non-blocking if there is a `time_limit`. Otherwise, the other end could make a read
        wait forever by reading the bytes itself after `poll` has announced them.
    time_limit : callable, optional
        As for `send`.

    Returns
    -------
    tree, blob : bytearray
        The parts of the message, to be decoded by `wire_format.decode`.

    Raises
    ------
    WireTimeout
        If the message is not complete in time.
    WireClosed
        If the other end has closed the pipe.
    wire_format.WireError
        If the message is larger than the limits.
    """
    header = _read(descriptor, wire_format.HEADER.size, time_limit)
    tree, blob = (_read(descriptor, size, time_limit) for size in wire_format.sizes_in(header))
    return tree, blob


def _read(descriptor: int, size: int, time_limit: Callable[[], float] | None) -> bytearray:
    data = bytearray(size)
    missing = memoryview(data)
    while missing:
        # The limit applies even if the data arrive one byte at a time.
        seconds_left = time_limit and time_limit()
        try:
            count = os.readv(descriptor, [missing])
        except BlockingIOError:
            _wait(descriptor, seconds_left, select.POLLIN)
            continue
        if not count:
            raise WireClosed
        missing = missing[count:]
    return data


def _wait(descriptor: int, seconds: float | None, event: int) -> None:
    poll = select.poll()
    poll.register(descriptor, event)
    poll.poll(None if seconds is None else 1000 * seconds)
