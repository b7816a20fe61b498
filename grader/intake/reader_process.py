"""Read a submission in a separate process, with limits on time and memory.

If a file takes too long to read, only its author is affected.

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

with contextlib.suppress(ImportError):  # Windows does not have this module
    import resource

# Processor seconds: five times as long as the largest honest file takes.
CPU_SECONDS = 10
MEGABYTES = 768
# Seconds of wall-clock time. Even on a busy machine, a process reaches this limit only if it waits
# for something, or if it gets less than a sixtieth of a processor.
LONGEST_WAIT = 600
LARGEST_REPLY = 2**28
_OUT_OF_MEMORY = 77


class TooCostly(UnreadableNotebook):
    """Reading takes more time or memory than any notebook needs; `str()` is the message."""


class ReadingFailed(Exception):
    """The grader or this machine is at fault; `str()` tells the instructor what happened."""


def run_in_child(name: str, work: Callable[[], object]) -> object:
    """Run a function in another process.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    work : callable
        A function without arguments that returns a value that JSON can represent. Its side effects
        stay in the other process.

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
            f"The process that read {name} did not reply within {LONGEST_WAIT} seconds, or another "
            "program ended it. Is this machine very busy, or short of memory?"
        ) from None
    if kind == "unreadable":
        raise UnreadableNotebook(content)
    if kind == "failed":
        raise ReadingFailed(f"Reading {name} failed:\n{content}")
    return content


def _excess(code: int, reply: bytes) -> str:
    """Return a description of the limit that was exceeded; empty if none was."""
    if code == -signal.SIGXCPU:
        return f"more than {CPU_SECONDS} seconds"
    if code == _OUT_OF_MEMORY or len(reply) > LARGEST_REPLY:
        return f"more than {MEGABYTES} MB of memory"
    return ""


def _read(pipe: int, deadline: float) -> bytes:
    """Read from a pipe until it closes, the reply is too large, or the time is up."""
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
    """Do the work in the child; end without clean-up, because files and locks are shared."""
    code = 1
    try:
        gc.disable()  # a collection would write to all memory pages, and so copy them
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
        os._exit(code)  # also closes the pipe, so the exit code is known when the reply ends


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
    """Close inherited files, so that no other process has to wait until this one closes them."""
    with contextlib.suppress(OSError):  # some systems do not have this folder
        for number in map(int, os.listdir("/dev/fd")):
            if number > 2 and number != pipe:
                with contextlib.suppress(OSError):  # `listdir` has already closed its own file
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
