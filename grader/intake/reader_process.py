"""Read what a stranger handed in, in a process of its own, under a clock and a limit of memory.

What is done out here with a stranger's text takes a time that grows with its length. Should that
not be true of something one day, it costs the student whose text it is, and nobody else.

No code of students runs in that process, but a hole in a parser might be used: what comes back is
JSON. It is forked, so that nothing is imported or read again.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import select
import signal
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

from utils.notebooks.reading import UnreadableNotebook

with contextlib.suppress(ImportError):  # Windows has none
    import resource

# Of the processor: five times what the largest honest file takes, full of numbers or pictures.
SECONDS = 10
MEGABYTES = 768
# By the clock on the wall, for a machine that has much else to do: who works for so long has had
# less than a sixtieth of a processor. Only who stands still is ended by it.
PATIENCE = 600
LARGEST_REPLY = 2**28
_OUT_OF_MEMORY = 77


class TooCostly(UnreadableNotebook):
    """It took more time or memory than any notebook needs; `str()` is the sentence to show."""


class ReadingFailed(Exception):
    """The fault is ours, or this machine's; `str()` says what happened, for whoever grades."""


def apart(name: str, work: Callable[[], object]) -> object:
    """Have something done in another process.

    Parameters
    ----------
    name : str
        What sentences call the file that it is done with.
    work : callable
        Takes nothing and returns what JSON can hold. Nothing that it changes is changed here.

    Returns
    -------
    object
        The same, from JSON.

    Raises
    ------
    TooCostly
    utils.notebooks.reading.UnreadableNotebook
        As `work` raised it.
    ReadingFailed
    """
    if not hasattr(os, "fork"):  # Windows, where there is no sandbox either
        return json.loads(json.dumps(work()))
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        _work_and_end(work, writing)
    os.close(writing)
    try:
        reply = _read(reading, time.monotonic() + PATIENCE)
    finally:
        os.close(reading)
        os.kill(child, signal.SIGKILL)  # it may still be at work; who has ended does not mind
        _, status = os.waitpid(child, 0)
    how = _excess(os.waitstatus_to_exitcode(status), reply)
    if how:
        raise TooCostly(
            f"Reading {name} takes {how}. Clear its outputs (in JupyterLab: Edit, Clear Outputs "
            "of All Cells), delete text that does not belong to it, save, and hand it in again."
        )
    try:
        kind, content = json.loads(reply)
    except (ValueError, TypeError, RecursionError):
        raise ReadingFailed(
            f"The process that read {name} gave no answer within {PATIENCE} seconds, or was ended "
            "from outside. Is this machine very busy, or short of memory?"
        ) from None
    if kind == "unreadable":
        raise UnreadableNotebook(content)
    if kind == "failed":
        raise ReadingFailed(f"Reading {name} failed:\n{content}")
    return content


def _excess(code: int, reply: bytes) -> str:
    """What was too much, in words; empty where nothing was."""
    if code == -signal.SIGXCPU:
        return f"more than {SECONDS} seconds"
    if code == _OUT_OF_MEMORY or len(reply) > LARGEST_REPLY:
        return f"more than {MEGABYTES} MB of memory"
    return ""


def _read(pipe: int, until: float) -> bytes:
    """What comes through a pipe: until it closes, it is too much, or it has taken too long."""
    parts, size = [], 0
    ready = select.poll()
    ready.register(pipe, select.POLLIN)
    while size <= LARGEST_REPLY and ready.poll(max(0.0, 1000 * (until - time.monotonic()))):
        part = os.read(pipe, 2**20)
        if not part:
            break
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def _work_and_end(work: Callable[[], object], pipe: int) -> NoReturn:
    """What the other process does. It shares files and locks, so it must not end as others do."""
    code = 1
    try:
        gc.disable()  # looking through all objects would copy them
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGXCPU):
            signal.signal(number, signal.SIG_DFL)
        _close_all_but(pipe)
        _limit()
        reply = memoryview(_reply(work))
        while reply:
            reply = reply[os.write(pipe, reply) :]
        code = 0
    except MemoryError:
        code = _OUT_OF_MEMORY
    finally:
        os._exit(code)  # the pipe closes with it, so that there is a code as soon as it has


def _reply(work: Callable[[], object]) -> bytes:
    try:
        reply = ("done", work())
    except MemoryError:
        raise
    except UnreadableNotebook as error:
        reply = ("unreadable", str(error))
    except BaseException:
        reply = ("failed", traceback.format_exc())
    return json.dumps(reply).encode()


def _close_all_but(pipe: int) -> None:
    """Whoever waits for the end of this process's parent must not wait for this one, too."""
    with contextlib.suppress(OSError):  # not every system has such a folder
        for number in map(int, os.listdir("/dev/fd")):
            if number > 2 and number != pipe:
                with contextlib.suppress(OSError):  # the listing's own
                    os.close(number)


def _limit() -> None:
    limits = {"RLIMIT_CORE": 0, "RLIMIT_CPU": SECONDS}
    with contextlib.suppress(OSError):  # without /proc nobody tells how much it has
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + MEGABYTES * 2**20
    for which, limit in limits.items():
        number = getattr(resource, which)
        _, hard = resource.getrlimit(number)
        unlimited = hard == resource.RLIM_INFINITY
        resource.setrlimit(number, (limit if unlimited else min(limit, hard), hard))
