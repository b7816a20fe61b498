"""Measure the memory, processor time and files of a process and its descendants, from /proc.

If the process or /proc does not exist, functions return 0, unless their docstrings say otherwise.
Every read may fail, because a process may end at any moment.
"""

from __future__ import annotations

import contextlib
import functools
import os
import time
from collections.abc import Iterator

from grader.sandbox.protocol import Thread

PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")
TICKS_PER_SECOND = os.sysconf("SC_CLK_TCK")
HAS_PROC = os.path.exists("/proc/self/stat")
# Kernel memory in bytes that even an empty file needs. No resource limit covers it.
BYTES_PER_FILE = 1024


def process_tree(pid: int) -> Iterator[int]:
    """Yield the IDs of a process and its descendants."""
    yield pid
    for children in _read_thread_files(pid, "children"):
        for child in children.split():
            yield from process_tree(int(child))


def memory_of_tree(pid: int) -> int:
    """Return the bytes mapped by a process and its descendants, plus kernel memory for their files.

    Mapped memory is counted instead of resident memory, because a shared page may occupy memory
    without being in the page tables of any process.
    """
    members = list(process_tree(pid))
    return sum(map(_mapped_bytes, members)) + max(map(_file_bytes, members), default=0)


def cpu_of_tree(pid: int) -> float:
    """Return the processor time in seconds that a process and its descendants have used.

    Without /proc, the result is elapsed time, as an upper bound.
    """
    return sum(map(_cpu_seconds, process_tree(pid))) if HAS_PROC else time.monotonic()


def threads_of_tree(pid: int) -> dict[int, Thread] | None:
    """Return the threads of a process and its descendants that have our priority or a higher one.

    Threads with another scheduling policy are left out.

    Returns
    -------
    dict of int to grader.sandbox.protocol.Thread, or None
        The threads by ID, or None if the kernel does not record waiting times.
    """
    if not _records_delays():
        return None
    ours = os.getpriority(os.PRIO_PROCESS, 0), os.sched_getscheduler(0)
    threads = {}
    for member in process_tree(pid):
        for thread in _thread_ids(member):
            with contextlib.suppress(OSError, ValueError):
                folder = f"/proc/{member}/task/{thread}"
                fields = _stat_fields(f"{folder}/stat")
                if int(fields[16]) <= ours[0] and int(fields[38]) == ours[1]:
                    threads[int(thread)] = Thread(_read_schedule(folder)[1], fields[0] == "R")
    return threads


def own_seconds() -> float:
    """Return the seconds for which the calling thread has run or waited for a processor."""
    return sum(_read_schedule("/proc/thread-self")) if _records_delays() else time.thread_time()


@functools.cache
def _records_delays() -> bool:
    """Return whether this kernel records how long threads wait. Some kernels always report 0."""
    try:
        return _read_schedule("/proc/self")[0] > 0
    except (OSError, ValueError):
        return False


def _read_schedule(folder: str) -> tuple[float, float]:
    """Return the seconds for which a thread has run, and has waited for a processor."""
    worked, waited, _ = _read_text(f"{folder}/schedstat").split()
    return int(worked) / 1e9, int(waited) / 1e9


def available_memory_share() -> float:
    """Return the share of the machine's memory that is available; 1 if unknown."""
    try:
        lines = _read_text("/proc/meminfo").splitlines()
    except OSError:
        return 1.0
    known = {line.split(":")[0]: line.split()[1] for line in lines}
    return int(known["MemAvailable"]) / int(known["MemTotal"])


def oom_kill_count() -> int:
    """Return how many processes the kernel has killed for lack of memory since it booted."""
    try:
        lines = _read_text("/proc/vmstat").splitlines()
    except OSError:
        return 0
    return next((int(line.split()[1]) for line in lines if line.startswith("oom_kill ")), 0)


def _mapped_bytes(pid: int) -> int:
    """Return the bytes that a process has mapped, according to its live threads.

    All threads share the same memory, but /proc shows 0 for a main thread that has ended.
    """
    pages = (int(text.split()[0]) for text in _read_thread_files(pid, "statm"))
    return max(pages, default=0) * PAGE_BYTES


def _read_thread_files(pid: int, name: str) -> Iterator[str]:
    """Yield the content of a /proc file for each thread; skip threads that have ended."""
    for thread in _thread_ids(pid):
        with contextlib.suppress(OSError):
            yield _read_text(f"/proc/{pid}/task/{thread}/{name}")


def _thread_ids(pid: int) -> list[str]:
    try:
        return os.listdir(f"/proc/{pid}/task")
    except OSError:
        return []


def _file_bytes(pid: int) -> int:
    """Return the bytes of kernel memory for files in the folders that student code can write to."""
    total, root = 0, f"/proc/{pid}/root"
    for folder in ("tmp", "dev/shm"):
        try:
            system = os.statvfs(f"{root}/{folder}")
            others = [os.stat(path).st_dev for path in (f"/{folder}", f"{root}/.")]
            is_separate = os.stat(f"{root}/{folder}").st_dev not in others
        except OSError:
            continue
        if is_separate:
            total += (system.f_files - system.f_ffree) * BYTES_PER_FILE
    return total


def _cpu_seconds(pid: int) -> float:
    try:
        return sum(map(int, _stat_fields(f"/proc/{pid}/stat")[11:15])) / TICKS_PER_SECOND
    except OSError:
        return 0.0


def _stat_fields(path: str) -> list[str]:
    """Return the fields of a /proc `stat` file, starting with the third."""
    # The second field is a name in parentheses, which may contain any bytes.
    return _read_text(path).rpartition(")")[2].split()


def _read_text(path: str) -> str:
    # A measurement reads dozens of files, and `Path.read_text` takes twice as long.
    with open(path, "rb", buffering=0) as file:
        return file.read().decode(errors="replace")
