"""Time and memory that a check may take in a notebook.

In the judge the sandbox has limits of its own.
"""

import _thread
import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

# Share of the memory that is free which student code may take before it gets a MemoryError, which
# can be explained; where a kernel takes all of it, the system ends it without a word.
_SHARE = 0.8


class TimeUp(Exception):
    """A call took longer than it may; its cause knows where it was."""


@contextlib.contextmanager
def limited(seconds: float) -> Iterator[None]:
    """Raise `TimeUp` in here after some seconds, and MemoryError before the machine is full.

    Only the main thread can be interrupted; in another one there is no limit of time. Where no
    thread can start, as in a browser, Python looks at the clock at each line: loops are several
    times slower, and code that catches everything is interrupted once, in vain.

    Parameters
    ----------
    seconds : float
    """
    with limited_memory():
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        over, rang = threading.Event(), threading.Event()

        def ring() -> None:
            wait = seconds
            while not over.wait(wait):
                rang.set()
                _thread.interrupt_main()
                wait = 1.0  # code that catches everything is interrupted again

        watch, look = threading.Thread(target=ring, daemon=True), _looking(seconds, rang)
        with _interruptible():
            try:
                try:
                    _start(watch, look)
                    yield
                finally:
                    _silence(over, watch, look, rang)
            except KeyboardInterrupt as interrupt:
                if rang.is_set():
                    raise TimeUp from interrupt
                raise


@contextlib.contextmanager
def _interruptible() -> Iterator[None]:
    """Let the clock be heard: what a script starts in the background ignores interrupts."""
    before = signal.getsignal(signal.SIGINT)
    if before in (signal.SIG_IGN, signal.SIG_DFL):
        signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        if before in (signal.SIG_IGN, signal.SIG_DFL):
            signal.signal(signal.SIGINT, before)


def _start(watch: threading.Thread, look: Callable) -> None:
    try:
        watch.start()
    except RuntimeError:
        sys.settrace(look)


def _looking(seconds: float, rang: threading.Event) -> Callable:
    """What Python calls at each line, to ring once: what raises is not called again."""
    due = time.monotonic() + seconds

    def look(*_: object) -> Callable:
        if time.monotonic() > due:
            rang.set()
            raise KeyboardInterrupt
        return look

    return look


def _silence(
    over: threading.Event, watch: threading.Thread, look: Callable, rang: threading.Event
) -> None:
    """End the watch; what rings in this very moment is heard here, and not later."""
    while True:
        try:
            over.set()
            if sys.gettrace() is look:
                sys.settrace(None)
            if watch.is_alive():
                watch.join()
            if rang.is_set():
                time.sleep(0.01)
            return
        except KeyboardInterrupt:
            continue


@contextlib.contextmanager
def limited_memory() -> Iterator[None]:
    """Let no more memory be taken than is free; only Linux can say how much that is."""
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
