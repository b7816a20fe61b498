"""Read a submission in a process of its own, with limits on time and memory.

Reading takes a time that grows with the length of the text. If some text breaks this rule, only
its own author loses by it.

Student code does not run in that process, but it might exploit a bug in a parser, so the reply is
JSON. The process is forked, so that nothing has to be imported or read again.
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

# Processor seconds: five times what the largest honest file takes, full of numbers or pictures.
CPU_SECONDS = 10
MEGABYTES = 768
# Seconds of wall-clock time, for a busy machine: a process that reaches it got less than a
# sixtieth of a processor. In practice it ends only a process that waits.
LONGEST_WAIT = 600
LARGEST_REPLY = 2**28
_OUT_OF_MEMORY = 77


class TooCostly(UnreadableNotebook):
    """Reading took more time or memory than any notebook needs; `str()` is the sentence to show."""


class ReadingFailed(Exception):
    """The grader or this machine is at fault; `str()` tells the instructor what happened."""


def run_in_child(name: str, work: Callable[[], object]) -> object:
    """Run a function in another process.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    work : callable
        Takes nothing and returns a value that JSON can represent. Its side effects stay in the
        other process.

    Returns
    -------
    object
        The value, after a round trip through JSON.

    Raises
    ------
    TooCostly
    utils.notebooks.reading.UnreadableNotebook
        If `work` raised it.
    ReadingFailed
    """
    if not hasattr(os, "fork"):  # Windows, where there is no sandbox either
        return json.loads(json.dumps(work()))
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        _work_and_end(work, write_end)
    os.close(write_end)
    try:
        reply = _read(read_end, time.monotonic() + LONGEST_WAIT)
    finally:
        os.close(read_end)
        os.kill(child, signal.SIGKILL)  # it may still be running
        _, status = os.waitpid(child, 0)
    excess = _excess(os.waitstatus_to_exitcode(status), reply)
    if excess:
        raise TooCostly(
            f"Reading {name} takes {excess}. Clear its outputs (in JupyterLab: Edit, Clear "
            "Outputs of All Cells), delete text that does not belong to it, save, and "
            "submit it again."
        )
    try:
        kind, content = json.loads(reply)
    except (ValueError, TypeError, RecursionError):
        raise ReadingFailed(
            f"The process that read {name} gave no answer within {LONGEST_WAIT} seconds, or was "
            "ended from outside. Is this machine very busy, or short of memory?"
        ) from None
    if kind == "unreadable":
        raise UnreadableNotebook(content)
    if kind == "failed":
        raise ReadingFailed(f"Reading {name} failed:\n{content}")
    return content


def _excess(code: int, reply: bytes) -> str:
    """Return which limit was exceeded, in words; empty if none was."""
    if code == -signal.SIGXCPU:
        return f"more than {CPU_SECONDS} seconds"
    if code == _OUT_OF_MEMORY or len(reply) > LARGEST_REPLY:
        return f"more than {MEGABYTES} MB of memory"
    return ""


def _read(pipe: int, deadline: float) -> bytes:
    """Read a pipe until it closes, the reply is too large, or the time is over."""
    parts, size = [], 0
    ready = select.poll()
    ready.register(pipe, select.POLLIN)
    while size <= LARGEST_REPLY and ready.poll(max(0.0, 1000 * (deadline - time.monotonic()))):
        part = os.read(pipe, 2**20)
        if not part:
            break
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def _work_and_end(work: Callable[[], object], pipe: int) -> NoReturn:
    """Do the work in the child; end it without clean-up, as it shares files and locks."""
    code = 1
    try:
        gc.disable()  # a collection would touch, and so copy, all memory pages
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGXCPU):
            signal.signal(number, signal.SIG_DFL)
        _close_all_but(pipe)
        _set_limits()
        reply = memoryview(_reply(work))
        while reply:
            reply = reply[os.write(pipe, reply) :]
        code = 0
    except MemoryError:
        code = _OUT_OF_MEMORY
    finally:
        os._exit(code)  # closes the pipe, so that the exit code is there when the reply ends


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
    """Close inherited files, so that a process that waits for the parent's end can go on."""
    with contextlib.suppress(OSError):  # not every system has such a folder
        for number in map(int, os.listdir("/dev/fd")):
            if number > 2 and number != pipe:
                with contextlib.suppress(OSError):  # the listing's own
                    os.close(number)


def _set_limits() -> None:
    limits = {"RLIMIT_CORE": 0, "RLIMIT_CPU": CPU_SECONDS}
    with contextlib.suppress(OSError):  # without /proc the size of this process is unknown
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + MEGABYTES * 2**20
    for which, limit in limits.items():
        number = getattr(resource, which)
        _, hard = resource.getrlimit(number)
        unlimited = hard == resource.RLIM_INFINITY
        resource.setrlimit(number, (limit if unlimited else min(limit, hard), hard))
