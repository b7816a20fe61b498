"""What a process and all it started use: memory, processor time, files; read from /proc.

Each function gives 0 where there is no such process or no /proc, if it does not say else. What is
read may be gone in the same moment, so every read may fail.
"""

from __future__ import annotations

import contextlib
import functools
import os
import time
from collections.abc import Iterator
from pathlib import Path

from grader.sandbox.protocol import Thread

PAGE = os.sysconf("SC_PAGE_SIZE")
TICK = os.sysconf("SC_CLK_TCK")
PROC = os.path.exists("/proc/self/stat")
# An empty file takes about as much of the kernel's memory, which no limit of ours counts.
BYTES_OF_A_FILE = 1024


def tree(pid: int) -> Iterator[int]:
    """A process and its descendants."""
    yield pid
    for children in _of_threads(pid, "children"):
        for child in children.split():
            yield from tree(int(child))


def memory_of_tree(pid: int) -> int:
    """Bytes that a process and its descendants have mapped, and that their files take.

    Mapped and not used, because used memory can hide: pages shared by two processes may be
    in the page tables of neither.
    """
    members = list(tree(pid))
    return sum(map(_mapped, members)) + max(map(_files, members), default=0)


def cpu_of_tree(pid: int) -> float:
    """Seconds of processor time that a process and its descendants have had.

    Without /proc the clock on the wall, which the processor's is never ahead of.
    """
    return sum(map(_cpu, tree(pid))) if PROC else time.monotonic()


def threads_of_tree(pid: int) -> dict[int, Thread] | None:
    """The threads of a process and its descendants, as `grader.sandbox.protocol.Worker` wants them.

    Returns
    -------
    dict of int to grader.sandbox.protocol.Thread, or None
        By number. None where the kernel does not tell who waits for a processor.
    """
    if not _tells_delays():
        return None
    ours = os.getpriority(os.PRIO_PROCESS, 0), os.sched_getscheduler(0)
    threads = {}
    for member in tree(pid):
        for thread in _threads(member):
            with contextlib.suppress(OSError, ValueError):
                folder = f"/proc/{member}/task/{thread}"
                fields = _fields(f"{folder}/stat")
                if int(fields[16]) <= ours[0] and int(fields[38]) == ours[1]:
                    threads[int(thread)] = Thread(_schedule(folder)[1], fields[0] == "R")
    return threads


def seconds_of_our_own() -> float:
    """Seconds in which this very thread has been at work, or has waited for a processor."""
    return sum(_schedule("/proc/thread-self")) if _tells_delays() else time.thread_time()


@functools.cache
def _tells_delays() -> bool:
    """Whether this kernel tells who waits for a processor: some do not, and some say 0."""
    try:
        return _schedule("/proc/self")[0] > 0
    except (OSError, ValueError):
        return False


def _schedule(folder: str) -> tuple[float, float]:
    """Seconds that a thread has had a processor, and has waited for one."""
    worked, waited, _ = Path(folder, "schedstat").read_text().split()
    return int(worked) / 1e9, int(waited) / 1e9


def memory_left() -> float:
    """Share of the machine's memory that is available; 1 where that cannot be told."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return 1.0
    known = {line.split(":")[0]: line.split()[1] for line in lines}
    return int(known["MemAvailable"]) / int(known["MemTotal"])


def _mapped(pid: int) -> int:
    """Of its live threads: a leader that has ended shows no memory, and they share one."""
    pages = (int(text.split()[0]) for text in _of_threads(pid, "statm"))
    return max(pages, default=0) * PAGE


def _of_threads(pid: int, name: str) -> Iterator[str]:
    """A file of each thread; one that ends meanwhile hides none of the others."""
    for thread in _threads(pid):
        with contextlib.suppress(OSError):
            yield Path(f"/proc/{pid}/task/{thread}/{name}").read_text()


def _threads(pid: int) -> list[str]:
    try:
        return os.listdir(f"/proc/{pid}/task")
    except OSError:
        return []


def _files(pid: int) -> int:
    """Of the two folders that a student may write to, as this process sees them."""
    total, root = 0, f"/proc/{pid}/root"
    for folder in ("tmp", "dev/shm"):
        try:
            system = os.statvfs(f"{root}/{folder}")
            others = [os.stat(path).st_dev for path in (f"/{folder}", f"{root}/.")]
            of_its_own = os.stat(f"{root}/{folder}").st_dev not in others
        except OSError:
            continue
        if of_its_own:
            total += (system.f_files - system.f_ffree) * BYTES_OF_A_FILE
    return total


def _cpu(pid: int) -> float:
    try:
        return sum(map(int, _fields(f"/proc/{pid}/stat")[11:15])) / TICK
    except OSError:
        return 0.0


def _fields(path: str) -> list[str]:
    """Those of a file `stat`, from the third on."""
    # The second field is a name in parentheses, which may hold anything, and no text.
    return Path(path).read_text(errors="replace").rpartition(")")[2].split()
