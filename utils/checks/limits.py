"""Limits of time and memory for a check in a notebook.

The judge's sandbox has its own limits.
"""

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

# Share of the free memory that student code may use before Python raises a MemoryError, which
# `check` can explain. The system kills a kernel that uses all memory, without a message.
_SHARE = 0.8


class TimeUp(Exception):
    """A call exceeded its time limit; the traceback of `__cause__` shows where it was."""


@contextlib.contextmanager
def limit_resources(seconds: float) -> Iterator[None]:
    """Raise `TimeUp` in the context after a time limit, and MemoryError before memory runs out.

    Only the main thread can be interrupted; other threads have no time limit. If no thread can be
    started, as in a browser, a trace function reads the clock at each line. Loops are then several
    times slower, and code that catches all exceptions is interrupted only once, without effect.
    """
    with limit_memory():
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        over, timed_out = threading.Event(), threading.Event()

        def alarm() -> None:
            wait = seconds
            while not over.wait(wait):
                timed_out.set()
                _thread.interrupt_main()
                wait = 1.0  # interrupt again, because the code may catch all exceptions

        watch = threading.Thread(target=alarm, daemon=True)
        trace = _clock_tracer(seconds, timed_out)
        with _allow_interrupts():
            try:
                try:
                    _start_clock(watch, trace)
                    yield
                finally:
                    _stop_clock(over, watch, trace, timed_out)
            except KeyboardInterrupt as interrupt:
                if timed_out.is_set():
                    raise TimeUp from interrupt
                raise


@contextlib.contextmanager
def _allow_interrupts() -> Iterator[None]:
    """Enable interrupts in the context; a shell script starts background jobs without them."""
    before = signal.getsignal(signal.SIGINT)
    if before in (signal.SIG_IGN, signal.SIG_DFL):
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if before in (signal.SIG_IGN, signal.SIG_DFL):
            signal.signal(signal.SIGINT, before)


def _start_clock(watch: threading.Thread, trace: Callable) -> None:
    try:
        watch.start()
    except RuntimeError:
        sys.settrace(trace)


def _clock_tracer(seconds: float, timed_out: threading.Event) -> Callable:
    """Return a trace function that raises once when time is up; Python then removes it.

    It never raises while the context is left, because the interrupt would then escape.
    """
    due = time.monotonic() + seconds
    own_files = {
        function.__code__.co_filename for function in (_clock_tracer, contextlib.contextmanager)
    }

    def trace(frame: FrameType, *_: object) -> Callable:
        if time.monotonic() > due and frame.f_code.co_filename not in own_files:
            timed_out.set()
            raise KeyboardInterrupt
        return trace

    return trace


def _stop_clock(
    over: threading.Event, watch: threading.Thread, trace: Callable, timed_out: threading.Event
) -> None:
    """Stop the clock; ignore an interrupt that arrives while it stops."""
    while True:
        try:
            over.set()
            if sys.gettrace() is trace:
                sys.settrace(None)
            if watch.is_alive():
                watch.join()
            if timed_out.is_set():
                time.sleep(0.01)
            return
        except KeyboardInterrupt:
            continue


@contextlib.contextmanager
def limit_memory() -> Iterator[None]:
    """Limit memory in the context to a share of the free memory; Linux only."""
    with contextlib.ExitStack() as after:
        with contextlib.suppress(ImportError, OSError, ValueError, StopIteration):
            import resource

            free = _kilobytes("/proc/meminfo", "MemAvailable") * _SHARE
            limit = int((_kilobytes("/proc/self/status", "VmSize") + free) * 1024)
            soft, hard = resource.getrlimit(resource.RLIMIT_AS)
            lower = [value for value in (soft, hard) if value != resource.RLIM_INFINITY]
            resource.setrlimit(resource.RLIMIT_AS, (min([limit, *lower]), hard))
            after.callback(resource.setrlimit, resource.RLIMIT_AS, (soft, hard))
        yield


def _kilobytes(file: str, name: str) -> float:
    lines = Path(file).read_text().splitlines()
    return float(next(line for line in lines if line.startswith(name + ":")).split()[1])
