"""Attacks on the machine's resources: memory, disks, processes and the kernel."""

import contextlib
import os
import secrets
import sys
import time
from pathlib import Path

import pytest

from grader.course.paths import PROJECT
from grader.sandbox import Limits, launcher
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.inside import syscalls
from tests.attacks.attack import (
    HOLD_MEMORY,
    MEBIBYTE,
    SHORT,
    attack,
    function,
    needs_namespaces,
    outcome_of,
    stopped_by,
    with_attacks,
)
from tests.prerequisites import PATIENCE, skip_or_fail

TOO_MUCH = "too much memory"


# ---- Files --------------------------------------------------------------------------------


def test_only_temporary_folders_are_writable():
    source = """
import os
def f(paths):
    written = []
    for path in paths:
        try:
            with open(os.path.join(path, "x"), "w") as file:
                file.write("x")
            written.append(path)
        except OSError:
            pass
    return written
"""
    everywhere = [
        *("/", "/usr", "/usr/bin", "/etc", "/dev", "/proc", "/proc/sys/kernel", "/tmp", "/dev/shm"),
        sys.prefix,
        sys.base_prefix,
        str(PROJECT),
        str(PROJECT / "utils" / "clouds"),
        str(PROJECT / "grader" / "sandbox" / "inside"),
    ]
    written = outcome_of(source, everywhere)
    # A project in /tmp appears in the sandbox's own, writable /tmp. Only its shown subfolders are
    # read-only.
    own = {str(PROJECT), sys.prefix} if PROJECT.is_relative_to("/tmp") else set()
    assert {"/tmp", "/dev/shm"} <= set(written) <= {"/tmp", "/dev/shm"} | own
    assert not (PROJECT / "utils" / "clouds" / "x").exists()


@needs_namespaces
@with_attacks(
    "folder, body",
    {
        "fills /tmp with large files": ("/tmp", "size += file.write(bytes(2**20)); file.flush()"),
        "fills /dev/shm with large files": (
            "/dev/shm",
            "size += file.write(bytes(2**20)); file.flush()",
        ),
        "fills /dev/shm with blocks that are reserved and not written": (
            "/dev/shm",
            "os.posix_fallocate(file.fileno(), 0, 31 * 2**20); size += 2**20",
        ),
    },
)
def test_space_for_files_is_limited(folder, body):
    source = f"""
import os
def f(folder):
    size = 0
    try:
        for number in range(100):
            with open(f"{{folder}}/{{number}}", "wb") as file:
                for _ in range(31):
                    {body}
    except OSError:
        pass
    return size
"""
    assert 0 < outcome_of(source, folder, call_seconds=5.0) <= Limits().temporary_space


EMPTY_FILES = """
import ctypes, os, time
def f(folder, hide):
    if hide:
        ctypes.CDLL(None).prctl(4, 0)  # PR_SET_DUMPABLE hides its folders in /proc
    with __import__("contextlib").suppress(OSError):
        for number in range(300_000):
            os.close(os.open(f"{folder}/{number}", os.O_CREAT | os.O_WRONLY))
    time.sleep(5)
"""


@needs_namespaces
@pytest.mark.slow
@with_attacks(
    "folder, hide",
    {
        "300,000 empty files in /tmp": ("/tmp", False),
        "300,000 empty files in /dev/shm": ("/dev/shm", False),
        "300,000 empty files, by a hidden process": ("/tmp", True),
    },
)
def test_the_kernel_memory_of_empty_files_counts_towards_the_limit(folder, hide):
    limits = {"total_memory": 350 * MEBIBYTE, "call_seconds": 10.0}
    with attack("def f(): return 1", **limits) as student:
        assert student.f() == 1, "an idle worker is far below the limit"
    assert TOO_MUCH in stopped_by(EMPTY_FILES, folder, hide, **limits)


# ---- Memory -------------------------------------------------------------------------------


def test_allocating_more_than_the_limit_raises_memory_error():
    with (
        attack("import numpy as np\ndef f(): return len(np.ones(2**30))") as student,
        pytest.raises(StudentError, match="MemoryError"),
    ):
        student.f()


@pytest.mark.slow
@with_attacks(
    "body",
    {
        "in twelve processes": "children(12, 256)",
        "in processes that remove it from their page tables": """
children(12, 256, lambda block: (block.madvise(mmap.MADV_DONTNEED), time.sleep(60)))
""",
        "in processes whose first thread has ended": """
for _ in range(12):
    if os.fork() == 0:
        threading.Thread(target=lambda: (hold(256), time.sleep(60))).start()
        ctypes.CDLL(None).pthread_exit(None)
""",
        "in a process with short-lived threads": """
children(12, 256)
while True:
    threads = [threading.Thread(target=int) for _ in range(30)]
    for thread in threads: thread.start()
    for thread in threads: thread.join()
""",
        "in grandchildren whose parents have ended": """
for _ in range(12):
    if os.fork() == 0:
        if os.fork() == 0:
            hold(256)
            time.sleep(60)
        os._exit(0)
""",
        "in processes with their own session": """
children(12, 256, lambda block: (os.setsid(), time.sleep(60)))
""",
        "in processes with an undecodable name": """
ctypes.CDLL(None).prctl(15, b"x) R 1 (")
children(12, 256)
""",
    },
)
def test_total_memory_of_all_processes_is_limited(body):
    source = HOLD_MEMORY + function(body + "\ntime.sleep(600)")
    start = time.monotonic()
    sentence = stopped_by(source, call_seconds=20.0, total_memory=1500 * MEBIBYTE)
    assert TOO_MUCH in sentence
    assert time.monotonic() - start < PATIENCE


def test_memory_allocated_between_two_calls_counts_towards_the_limit():
    source = HOLD_MEMORY + function("children(12, 256)\nreturn 0")
    with (
        attack(source, total_memory=1500 * MEBIBYTE) as student,
        pytest.raises(StudentStopped, match=TOO_MUCH),
    ):
        assert student.f() == 0
        deadline = time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            time.sleep(0.5)
            student.f()


def test_a_process_cannot_save_itself_by_lowering_the_oom_score(monkeypatch):
    """A process that resets `oom_score_adj` is still stopped when memory runs out."""
    refuse = """
try:
    open("/proc/self/oom_score_adj", "w").write("0")
except OSError:
    pass
"""
    source = HOLD_MEMORY + function(refuse + "held = hold(1500)\ntime.sleep(60)")
    monkeypatch.setattr(launcher, "available_memory_share", lambda: 0.01)
    with attack(source, call_seconds=20.0) as student:
        with pytest.raises(StudentStopped, match=TOO_MUCH):
            student.f()
        assert student.starved, "below its own limit, so it deserves another try"
    with attack("def f(): return 1") as student:
        time.sleep(0.5)
        assert student.f() == 1, "a process with little memory is not stopped"


@pytest.mark.parametrize("others", [0, 1])
def test_only_a_lack_of_memory_makes_a_killed_process_starved(others, monkeypatch):
    """A process is starved only if the kernel's count of out-of-memory kills has increased."""
    kills = iter([5, 5 + others])
    monkeypatch.setattr(launcher, "oom_kill_count", lambda: next(kills))
    with attack(function("import os\nos.kill(os.getpid(), 9)")) as student:
        with pytest.raises(StudentStopped, match=TOO_MUCH):
            student.f()
        assert student.starved == bool(others)


def test_a_process_above_its_own_limit_is_not_starved(monkeypatch):
    monkeypatch.setattr(launcher, "oom_kill_count", lambda: time.monotonic())  # grows
    source = HOLD_MEMORY + function("children(12, 256)\ntime.sleep(60)")
    with attack(source, call_seconds=20.0, total_memory=1500 * MEBIBYTE) as student:
        with pytest.raises(StudentStopped, match=TOO_MUCH):
            student.f()
        assert not student.starved


# ---- Processes ----------------------------------------------------------------------------


def test_the_number_of_processes_is_limited():
    source = """
import os, time
def f():
    started = 0
    try:
        for _ in range(1000):
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
            started += 1
    except OSError:
        pass
    return started
"""
    assert 0 < outcome_of(source, call_seconds=5.0, processes=20) <= 20


def test_no_process_outlives_the_worker():
    """Even processes that were forked twice, in their own session, end with the worker."""
    source = """
import ctypes, os, time
def f(name):
    ctypes.CDLL(None).prctl(15, name.encode())
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(600)
    return 1
"""
    name = secrets.token_hex(6)
    with attack(source) as student:
        assert student.f(name) == 1
        assert processes_called(name), "running processes are found"
    deadline = time.monotonic() + PATIENCE
    while processes_called(name) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert processes_called(name) == []


def processes_called(name):
    found = []
    for path in Path("/proc").glob("[0-9]*/comm"):
        with contextlib.suppress(OSError):
            found += [path] if path.read_text().strip() == name else []
    return found


def test_limits_cannot_be_raised():
    source = """
import resource
def f(names):
    raised = []
    for name in names:
        which = getattr(resource, name)
        soft, hard = resource.getrlimit(which)
        try:
            resource.setrlimit(which, (hard + 1, hard + 1))
            raised.append(name)
        except (OSError, ValueError):
            pass
        if resource.getrlimit(which)[1] in (-1, resource.RLIM_INFINITY):
            raised.append(name + " is without end")
    return raised
"""
    names = [*Limits().resources(), "RLIMIT_NPROC"]
    assert outcome_of(source, names) == []


@with_attacks(
    "body",
    {
        "becomes root": "os.setuid(0)",
        "joins root's group": "os.setgid(0)",
        "joins additional groups": "os.setgroups([0])",
        "changes the root directory": "os.chroot('/tmp')",
        "raises its priority": "os.nice(-5)",
        "mounts a file system": "os.mknod('/tmp/d', 0o60600, 2048)",
        "writes to the memory of process 1": "os.open('/proc/1/mem', 2)",
        "writes to the memory of a thread of process 1": "os.open('/proc/1/task/1/mem', 2)",
        "reads the memory map of process 1": "open('/proc/1/maps').read()",
        "reads the root directory of process 1": "os.listdir('/proc/1/root')",
        "takes a descriptor of process 1": "os.listdir('/proc/1/fd')",
    },
)
def test_privileges_cannot_be_gained(body):
    source = "import os\n" + function(body)
    with attack(source) as student, pytest.raises(StudentError, match="Error"):
        student.f()


@needs_namespaces
def test_no_privileges_are_left():
    source = """
import os, subprocess
def f():
    status = dict(line.split(":\\t") for line in open("/proc/self/status").read().splitlines()
                  if ":\\t" in line)
    who = subprocess.run(["/usr/bin/su", "-c", "id -u"], capture_output=True, text=True).stdout
    names = ("CapEff", "CapPrm", "CapAmb", "NoNewPrivs", "Seccomp")
    return *(int(status[name], 16) for name in names), status["Uid"].split(), who
"""
    *capabilities, sealed, filtered, users, became = outcome_of(source, call_seconds=3.0)
    assert capabilities == [0, 0, 0] and sealed == 1
    assert filtered == (2 if os.uname().machine in syscalls.MACHINES else 0)
    assert "0" not in users and became.strip() != "0"
    if os.geteuid():
        assert set(users) == {str(os.geteuid())}, "an ordinary user does not change"
    else:
        assert int(users[0]) >= 2**15, "root becomes an unused user"


@pytest.fixture(scope="module")
def system_call_numbers():
    """Return the number of each system call on this machine, by name."""
    machine = os.uname().machine
    if machine not in syscalls.MACHINES:
        skip_or_fail(f"an x86-64 or arm64 processor, not {machine}: another machine")
    return syscalls.MACHINES[machine][1]


CALLS = [
    *(name for name in syscalls.MACHINES["x86_64"][1] if name not in syscalls.LIMITED_CALLS),
    "clone with a user namespace",
    "socket of an unusual family",
    "madvise to merge pages",
    "madvise to remove a page from memory",
    "prctl to merge pages",
    "ioctl for a file system",
    "futex with requeueing",
    "getpid in the x32 ABI",
]


@pytest.mark.parametrize("name", CALLS)
def test_system_calls_that_no_exercise_needs_are_refused(
    name, system_call_numbers, system_call_results
):
    assert system_call_results[name] == "no such call"


@pytest.fixture(scope="module")
def system_call_results(system_call_numbers):
    """Make each system call in the sandbox and return the results, by name."""
    source = """
import ctypes, errno
def f(calls):
    syscall = ctypes.CDLL(None, use_errno=True).syscall
    said = {}
    for name, arguments in calls.items():
        ctypes.set_errno(0)
        syscall(*map(ctypes.c_long, arguments))
        said[name] = "no such call" if ctypes.get_errno() == errno.ENOSYS else "done"
    return said
"""
    calls = {name: [number, 0, 0, 0] for name, number in system_call_numbers.items()}
    for name in syscalls.LIMITED_CALLS:
        del calls[name]
    calls["madvise to merge pages"] = [
        system_call_numbers["madvise"],
        0,
        0,
        syscalls.MADV_MERGEABLE,
    ]
    calls["madvise to remove a page from memory"] = [
        system_call_numbers["madvise"],
        0,
        0,
        syscalls.MADV_PAGEOUT,
    ]
    calls["prctl to merge pages"] = [
        system_call_numbers["prctl"],
        syscalls.PR_SET_MEMORY_MERGE,
        1,
        0,
        0,
        0,
    ]
    calls["ioctl for a file system"] = [
        system_call_numbers["ioctl"],
        0,
        0xC020660B,  # FS_IOC_FIEMAP
    ]
    calls["futex with requeueing"] = [system_call_numbers["futex"], 0, 3, 0]
    calls["clone with a user namespace"] = [
        system_call_numbers["clone"],
        syscalls.CLONE_NEWUSER | 17,
        0,
        0,
    ]
    calls["socket of an unusual family"] = [system_call_numbers["socket"], 40, 1, 0]
    calls["unshare"] = [system_call_numbers["unshare"], syscalls.CLONE_NEWUSER]
    calls["shmget"] = [system_call_numbers["shmget"], 0, MEBIBYTE, 0o1777]
    calls["getpid in the x32 ABI"] = [0x40000000 + 39]
    results = outcome_of(source, calls)
    allowed = outcome_of(source, {"getpid": [39 if os.uname().machine == "x86_64" else 172]})
    assert allowed == {"getpid": "done"}, "ordinary calls are allowed"
    return results


@with_attacks(
    "body",
    {
        "requests a real-time priority": "os.sched_setscheduler(0, 1, os.sched_param(1))",
        "sets the clock": "time.clock_settime(time.CLOCK_REALTIME, 0)",
        "changes the host name": "socket.sethostname('owned')",
        "mounts a file system": "assert not ctypes.CDLL(None).mount(b'a', b'/tmp', b'tmpfs', 0, 0)",
        "changes kernel settings": "open('/proc/sys/kernel/core_pattern', 'w')",
        "restarts the machine": "open('/proc/sysrq-trigger', 'w').write('b')",
        "opens a disk": "open('/dev/sda', 'rb') if os.path.exists('/dev/sda') else os.stat('/x')",
        "opens a terminal": "open('/dev/tty', 'w')",
    },
)
def test_machine_settings_cannot_be_changed(body):
    source = "import ctypes, os, socket, time\n" + function(body)
    with attack(source) as student, pytest.raises(StudentError, match="Error"):
        student.f()


def test_the_attacks_use_shorter_limits_than_the_judge():
    real = Limits()
    assert all(value <= getattr(real, name) for name, value in SHORT.items())
