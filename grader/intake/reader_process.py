"""Read a submission in a separate process, with limits on time and memory.

If a file takes too long to read, only its author is affected.

Student code does not run in that process. However, a file might exploit a bug in a parser, so the
process replies in JSON. The process is a fork, so it need not import modules again.
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

# Limit on processor time. The largest ordinary file needs a fifth of this time.
CPU_SECONDS = 10
MEGABYTES = 768
# Limit on elapsed time, for a process that waits. A process that computes reaches `CPU_SECONDS`
# first, unless it gets less than a sixtieth of a processor.
MAX_WAIT_SECONDS = 600
MAX_REPLY_BYTES = 2**28
_OUT_OF_MEMORY = 77


class TooCostly(UnreadableNotebook):
    """Reading exceeds the limit on time or memory; `str()` is the message for the student."""


class ReadingFailed(Exception):
    """Reading failed through no fault of the student; `str()` is the message for the instructor."""


def run_in_child(name: str, work: Callable[[], object]) -> object:
    """Run a function in a forked process, with limits on time and memory.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    work : callable
        Function without arguments that returns a value for JSON. Its side effects stay in the
        forked process.

    Returns
    -------
    object
        The value of `work`, after a round trip through JSON.

    Raises
    ------
    TooCostly
        If `work` exceeds a limit.
    utils.notebooks.reading.UnreadableNotebook
        If `work` raises it.
    ReadingFailed
        If `work` raises another exception, or the process does not reply.
    """
    if not hasattr(os, "fork"):  # Windows, where grading is not supported
        return json.loads(json.dumps(work()))
    read_end, write_end = os.pipe()
    child = os.fork()
    if child == 0:
        _run_and_exit(work, write_end)
    os.close(write_end)
    try:
        reply = _read_pipe(read_end, time.monotonic() + MAX_WAIT_SECONDS)
    finally:
        os.close(read_end)
        os.kill(child, signal.SIGKILL)  # the child may still be running
        _, status = os.waitpid(child, 0)
    excess = _exceeded_limit(os.waitstatus_to_exitcode(status), reply)
    if excess:
        raise TooCostly(
            f"Reading {name} takes {excess}. Clear its outputs (in JupyterLab: Edit, Clear "
            "Outputs of All Cells), delete text that does not belong to it, save, and "
            "submit it again."
        )
    try:
        reply_kind, content = json.loads(reply)
    except (ValueError, TypeError, RecursionError):
        raise ReadingFailed(
            f"The process that read {name} did not reply within {MAX_WAIT_SECONDS} seconds, or "
            "another program ended it. Is this machine very busy, or short of memory?"
        ) from None
    if reply_kind == "unreadable":
        raise UnreadableNotebook(content)
    if reply_kind == "failed":
        raise ReadingFailed(f"Reading {name} failed:\n{content}")
    return content


def _exceeded_limit(code: int, reply: bytes) -> str:
    """Describe the limit that the process exceeded; empty if it exceeded none."""
    if code == -signal.SIGXCPU:
        return f"more than {CPU_SECONDS} seconds"
    if code == _OUT_OF_MEMORY or len(reply) > MAX_REPLY_BYTES:
        return f"more than {MEGABYTES} MB of memory"
    return ""


def _read_pipe(pipe: int, deadline: float) -> bytes:
    """Read from a pipe until it closes, the reply is too large, or the time is up."""
    parts, size = [], 0
    ready = select.poll()
    ready.register(pipe, select.POLLIN)
    while size <= MAX_REPLY_BYTES and ready.poll(max(0.0, 1000 * (deadline - time.monotonic()))):
        part = os.read(pipe, 2**20)
        if not part:
            break
        parts.append(part)
        size += len(part)
    return b"".join(parts)


def _run_and_exit(work: Callable[[], object], pipe: int) -> NoReturn:
    """Do the work in the child, then exit without clean-up, because the parent shares its files."""
    code = 1
    try:
        gc.disable()  # garbage collection would write to all pages, and so copy them
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
        os._exit(code)  # also closes the pipe


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
    """Close inherited files, because a pipe that stays open would keep its reader waiting."""
    with contextlib.suppress(OSError):  # /dev/fd does not exist on every system
        for number in map(int, os.listdir("/dev/fd")):
            if number > 2 and number != pipe:
                with contextlib.suppress(OSError):  # `listdir` has closed its own descriptor
                    os.close(number)


def _set_limits() -> None:
    limits = {"RLIMIT_CORE": 0, "RLIMIT_CPU": CPU_SECONDS}
    with contextlib.suppress(OSError):  # without /proc, the size of this process is unknown
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limits["RLIMIT_AS"] = pages * resource.getpagesize() + MEGABYTES * 2**20
    for which, limit in limits.items():
        number = getattr(resource, which)
        _, hard = resource.getrlimit(number)
        unlimited = hard == resource.RLIM_INFINITY
        resource.setrlimit(number, (limit if unlimited else min(limit, hard), hard))
