"""Attempts to delay grading, or to make lost time look like the machine's fault."""

import math
import time

import pytest

from grader.classroom import pool
from grader.course.lessons import find_lesson, lesson_of
from grader.course.paths import PROJECT
from grader.judging import judge, program_run, repair, runner
from grader.sandbox import Limits
from grader.sandbox import student as students
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import SHARE_AFTER_FAILURES
from grader.sandbox.time_budget import Budget
from tests.attacks.attack import HOLD_MEMORY, SANDBOX, attack, function, outcome_of, with_attacks
from tests.prerequisites import PATIENCE

LINE = find_lesson("02_ransac_line")
# A quarter of the default limits, so an exercise may cost at most a quarter of 15 seconds.
QUARTER = {"start_seconds": 2.5, "call_seconds": 2.5, "total_seconds": 45.0, "restarts": 3}
LARGEST_COST = 15 / 4
ENDLESS_LOOP = "while True: pass"
# Ignores SIGCHLD, so that the kernel discards the processor time of its children.
ENDLESS_CHILDREN = """
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
while True:
    if os.fork() == 0:
        end = time.process_time() + 0.02
        while time.process_time() < end: pass
        os._exit(0)
    with contextlib.suppress(ChildProcessError): os.wait()
"""
IMPORTS = "import contextlib, os, signal, threading, time\n" + HOLD_MEMORY


@with_attacks(
    "body",
    {
        "runs forever": ENDLESS_LOOP,
        "sleeps": "time.sleep(600)",
        "sleeps for short intervals": "while True: time.sleep(0.01)",
        "stops itself": "os.kill(os.getpid(), signal.SIGSTOP)",
        "is stopped by its child": """
parent = os.getpid()
if os.fork() == 0:
    while True: os.kill(parent, signal.SIGSTOP)
time.sleep(600)
""",
        "waits for a sleeping thread": """
thread = threading.Thread(target=time.sleep, args=(600,))
thread.start()
thread.join()
""",
        "sleeps while threads wait for each other": """
def wake():
    while True:
        time.sleep(0.001)
        sum(range(1000))
for _ in range(30): threading.Thread(target=wake, daemon=True).start()
time.sleep(600)
""",
        "sleeps while a thread has the lowest priority": """
def spin():
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)
    while True: pass
threading.Thread(target=spin, daemon=True).start()
time.sleep(600)
""",
        "runs only when the processor is idle": "os.sched_setscheduler(0, os.SCHED_IDLE, "
        "os.sched_param(0))\nos.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n"
        + ENDLESS_LOOP,
        "works in children that are not reaped": ENDLESS_CHILDREN,
        "allocates memory and sleeps": "held = hold(2500)\ntime.sleep(600)",
        "allocates memory until it fails": "held = []\nwhile True: held.append([])",
        "allocates memory forever": """
held = []
while True:
    with contextlib.suppress(MemoryError):
        while True: held.append(bytearray(10**6))
""",
        "allocates memory in children": "children(24, 256)\ntime.sleep(600)",
    },
)
@pytest.mark.slow
def test_code_that_delays_the_class_costs_one_time_limit(body):
    """Slow code uses up the time limit once per exercise, not once per check."""
    start = time.monotonic()
    reasons = set()
    with attack(IMPORTS + function(body), **QUARTER) as student:
        left = student._budget.seconds
        for _ in range(12):
            with pytest.raises((StudentStopped, StudentError)) as failed:
                student.f()
            reasons.add(getattr(failed.value, "reason", "MemoryError"))
        assert not student.starved
        # Noticing the death of each process may take another 2 seconds.
        assert left - student._budget.seconds < 2 * LARGEST_COST + 2
    assert len(reasons) <= 2, "the same cause is reported once"
    assert time.monotonic() - start < 600


IGNORE_CHILD_SIGNALS = {
    "with signal.signal": "signal.signal(signal.SIGCHLD, signal.SIG_IGN)",
    "with a flag of sigaction": """
import ctypes
libc = ctypes.CDLL(None)
libc.sigaction.restype = ctypes.c_int
act = (ctypes.c_ulong * 32)()
act[17] = 2  # the flags, behind a handler and a mask: SA_NOCLDWAIT
assert libc.sigaction(int(signal.SIGCHLD), act, None) == 0
""",
    "with a system call": """
import ctypes, platform
libc = ctypes.CDLL(None)
act = (ctypes.c_ulong * 4)(1)  # SIG_IGN
number = {"x86_64": 13, "aarch64": 134}[platform.machine()]
assert libc.syscall(number, int(signal.SIGCHLD), act, None, 8) == 0
""",
    "with an address whose lower half is 0": """
import ctypes, mmap, platform
libc = ctypes.CDLL(None)
libc.mmap.restype = ctypes.c_void_p
there = 0x2000000000
assert libc.mmap(ctypes.c_void_p(there), 4096, 3, 0x100022, -1, 0) == there
ctypes.memmove(there, (ctypes.c_ulong * 4)(1), 32)
number = {"x86_64": 13, "aarch64": 134}[platform.machine()]
assert libc.syscall(number, int(signal.SIGCHLD), ctypes.c_void_p(there), None, 8) == 0
""",
}
CHILDREN = """
for _ in range(50):
    if os.fork() == 0:
        end = time.process_time() + 0.02
        while time.process_time() < end: pass
        os._exit(0)
    with contextlib.suppress(ChildProcessError): os.wait()
"""


@pytest.mark.slow
@with_attacks("unnoticed", IGNORE_CHILD_SIGNALS)
def test_processor_time_of_unreaped_children_counts(unnoticed):
    """Attempts to ignore SIGCHLD have no effect, so the processor time of children counts."""
    body = unnoticed + CHILDREN
    with attack(IMPORTS + function(body), call_seconds=60.0, total_seconds=90.0) as student:
        student.start()
        before = student.cpu_seconds
        student.f()
        assert student.cpu_seconds - before > 0.8


@pytest.mark.slow
def test_processor_time_of_orphaned_grandchildren_counts():
    body = (
        CHILDREN.replace("range(50)", "range(20)")
        .replace("0.02", "0.05")
        .replace(
            "    if os.fork() == 0:\n",
            "    if os.fork() == 0:\n        if os.fork(): os._exit(0)\n",
        )
    )
    with attack(IMPORTS + function(body + "time.sleep(8)"), call_seconds=60.0) as student:
        student.start()
        before = student.cpu_seconds
        student.f()
        assert student.cpu_seconds - before > 0.8


def test_the_handler_of_child_signals_can_be_queried():
    asks = """
import ctypes
libc = ctypes.CDLL(None)
act = (ctypes.c_ulong * 32)(7)
return libc.sigaction(int(signal.SIGCHLD), None, act), int(act[0])
"""
    assert tuple(outcome_of(IMPORTS + function(asks))) == (0, 0)


@pytest.mark.slow
def test_many_sleeping_calls_share_one_budget():
    """Each call is within its limit, but all calls together exceed the notebook's budget."""
    with attack("import time\ndef f(): time.sleep(0.6)", total_seconds=2.0) as student:
        with pytest.raises(StudentStopped):
            for _ in range(10):
                student.f()
        assert not student.starved


@pytest.mark.slow
def test_many_quick_calls_share_one_budget():
    """Each call is too short to be measured, but the total elapsed time is limited."""
    start = time.monotonic()
    with (
        attack("import time\ndef f(): time.sleep(0.02)", wall_seconds=3.0) as student,
        pytest.raises(StudentStopped, match="3 seconds of elapsed time"),
    ):
        while time.monotonic() - start < PATIENCE:
            student.f()


@pytest.mark.slow
def test_endless_cells_cost_one_time_limit():
    start = time.monotonic()
    source = "def g():\n    while True: pass\nx = g()\ndef f(): return x\n"
    with attack(source, **QUARTER) as student:
        for exercise in "abcd":
            student.exercise = exercise
            for _ in range(6):
                with pytest.raises(StudentStopped, match="own cells"):
                    student.f()
        assert QUARTER["total_seconds"] - student._budget.seconds < LARGEST_COST + 1
    assert time.monotonic() - start < 600


@with_attacks(
    "statement",
    {
        "a cell that runs forever": "while True: pass",
        "a cell that ends the process": "import os\nos._exit(0)",
    },
)
@pytest.mark.slow
def test_a_notebook_that_never_starts_is_not_searched_for_edits(statement, submit, monkeypatch):
    """The search for an edit is skipped, because each start would cost the full start limit."""
    starts, start = [], type(SANDBOX).start

    def count_start(*arguments):
        starts.append(arguments)
        return start(*arguments)

    monkeypatch.setattr(type(SANDBOX), "start", count_start)
    answer = function(statement, "g", "") + "x = g()\ndef line_through(p, q): return x"
    assert submit({"line_through": answer}, lesson=LINE, start_seconds=2.0).score == 0
    assert len(starts) == 1


def test_the_threat_model_states_what_an_exercise_may_cost():
    limits = Limits()
    again = limits.call_seconds * SHARE_AFTER_FAILURES
    first = limits.call_seconds + limits.restarts * again
    assert (again, repair.MAX_JUDGED_EDITS) == (limits.call_seconds / 8, 3)
    threats = (PROJECT / "docs" / "security.md").read_text("utf-8")
    for sentence in (
        f"{limits.total_seconds:.0f} seconds in which its code works",
        f"and {limits.wall_seconds:.0f} seconds of wall time",
        f"waits {limits.call_seconds:.0f} seconds for the first",
        f"at most {math.ceil(first)} seconds in the first run",
        f"after {limits.call_seconds:.0f} seconds, a slow wrong function has only an eighth",
    ):
        assert sentence in threats
    full, slow = repair.FULL_SEARCH, repair.SEARCH_IN_SLOW_CODE
    edits = f"the {full.likeliest_edits} likeliest edits, or {slow.likeliest_edits} if the exercise"
    assert (full.cpu_seconds, slow.cpu_seconds, repair.FURTHER_EDITS_SECONDS) == (16, 4, 1)
    assert (
        edits in threats
        and "until the student's code has used one second of processor time" in threats
    )
    assert "ends after 16 seconds of processor time, or after four if the exercise has" in threats
    assert repair.SEARCH_WITHOUT_POINTS.cpu_seconds == 2
    assert "as much as a slip keeps, the search ends after two seconds" in threats
    assert f"may together take {runner.TEST_SECONDS:.0f} seconds" in threats
    assert f"process of `grade` may allocate {pool.MAX_MEMORY // 2**30} GiB" in threats


SLEEPY = {
    "line_through": "def line_through(first, second):\n    import time\n    time.sleep(600)\n",
    "point_line_distance": "def point_line_distance(points, line):\n    while True: pass\n",
    "ransac_line": "def ransac_line(points, max_iterations=100, distance_tolerance=0.1, rng=None):"
    "\n    line_through(*points[:2])\n    while True: pass\n",
}


@pytest.fixture
def budgets(monkeypatch):
    """Return a list to which every new `Budget` is added."""
    created = []

    class RecordedBudget(Budget):
        def __init__(self, limits):
            super().__init__(limits)
            created.append(self)

    for module in (judge, program_run, repair, students):
        monkeypatch.setattr(module, "Budget", RecordedBudget)
    return created


@pytest.mark.slow
def test_a_wrong_function_that_is_slow_gets_no_more_time_than_one_that_hangs(
    submit, budgets, monkeypatch
):
    """Each call stays within its limit, so the time is cut because of the failed checks."""
    monkeypatch.setattr(repair, "SEARCH_IN_SLOW_CODE", repair.SearchLimits(128, 0.5))
    answer = "def line_through(p, q):\n    import time\n    time.sleep(1)\n    return 1.0, 2.0, 3.0"
    verdict = submit({"line_through": answer}, lesson=LINE, **QUARTER)
    assert verdict.score == 0 and not verdict.starved
    [budget] = budgets
    assert QUARTER["total_seconds"] - budget.seconds < 2 * LARGEST_COST


@pytest.mark.slow
def test_a_notebook_of_sleeping_functions_has_one_budget(submit, budgets):
    """All functions share one budget, as does the second run of the exercise that calls others."""
    verdict = submit(SLEEPY, lesson=LINE, call_seconds=1.0, total_seconds=5.0, restarts=3)
    assert verdict.score == 0 and not verdict.starved
    for exercise in verdict.exercises:
        messages = [test.message for test in exercise.tests]
        assert sum("did not answer" in message for message in messages) <= 1
        # On a busy machine, the budget may run out before the last exercise has had all its tries.
        others = ("Fails for the same reason", "Not run: the notebook had used up its")
        repeated = [text for text in messages if any(other in text for other in others)]
        assert len(repeated) >= len(messages) - 1
    [budget] = budgets
    assert -1.5 < budget.seconds < 0.5, "the budget is used up and hardly exceeded"


@pytest.mark.slow
@with_attacks(
    "exercise, source",
    {
        "spends seconds in a C function that holds the lock": (
            "line_through",
            "import re\ndef line_through(p, q):\n"
            "    return bool(re.match('(a+)+$', 'a' * 25 + 'b')), 2.0, 3.0\n",
        ),
        "starts other interpreters": (
            "line_through",
            "import subprocess, sys\ndef line_through(p, q):\n"
            "    subprocess.run([sys.executable, '-c', 'while True: pass'])\n",
        ),
        "returns 170,000 empty arrays": (
            "line_through",
            "import numpy as np\ndef line_through(p, q):\n    return [np.zeros(0)] * 170_000\n",
        ),
        "inserts forever": ("insert", "def insert(tree, point, index):\n    while True: pass\n"),
    },
)
def test_an_exercise_costs_the_class_no_more_than_promised(exercise, source, submit, budgets):
    """The cost is processor time of the student's code and the judge, not elapsed time."""
    start = time.process_time()
    verdict = submit({exercise: source}, lesson=lesson_of(exercise), **QUARTER)
    assert verdict.score == 0 and not verdict.starved
    [budget] = budgets
    # The first run, one short call of each later run, and the search for an edit.
    search_seconds = repair.SEARCH_IN_SLOW_CODE.cpu_seconds
    assert QUARTER["total_seconds"] - budget.seconds < 2 * LARGEST_COST + search_seconds
    assert budget.judge_seconds[exercise] < runner.TEST_SECONDS + 1
    assert time.process_time() - start < runner.TEST_SECONDS + repair.FULL_SEARCH.cpu_seconds
