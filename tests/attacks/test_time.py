"""What a student's code may try to keep a class waiting, or to look as if others did."""

import math
import time

import pytest

from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT
from grader.judging import judge, repair
from grader.sandbox import Limits
from grader.sandbox import student as students
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import ONCE_MORE
from grader.sandbox.time_budget import Budget
from tests.attacks.attack import WALLS, attack, function, outcome_of, tried
from tests.attacks.test_resources import HOLD
from tests.prerequisites import PATIENCE

LINE = find_lesson("02_ransac_line")
# Of the limits, a quarter: so is what an exercise may cost at most, of its 15 seconds.
QUARTER = {"start_seconds": 2.5, "call_seconds": 2.5, "total_seconds": 45.0, "restarts": 3}
MOST = 15 / 4
SPIN = "while True: pass"
# It waits for children that nobody reaps, and of which the kernel would forget what they worked.
UNREAPED = """
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
while True:
    if os.fork() == 0:
        end = time.process_time() + 0.02
        while time.process_time() < end: pass
        os._exit(0)
    with contextlib.suppress(ChildProcessError): os.wait()
"""
PREPARED = "import contextlib, os, signal, threading, time\n" + HOLD


@tried(
    "body",
    {
        "never ends": SPIN,
        "sleeps": "time.sleep(600)",
        "sleeps a little at a time": "while True: time.sleep(0.01)",
        "stops itself": "os.kill(os.getpid(), signal.SIGSTOP)",
        "is stopped by its child": """
parent = os.getpid()
if os.fork() == 0:
    while True: os.kill(parent, signal.SIGSTOP)
time.sleep(600)
""",
        "waits for a thread that sleeps": """
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
        "sleeps while a thread asks for hardly any processor": """
def spin():
    os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), 19)
    while True: pass
threading.Thread(target=spin, daemon=True).start()
time.sleep(600)
""",
        "asks for what nobody else wants": "os.sched_setscheduler(0, os.SCHED_IDLE, "
        "os.sched_param(0))\nos.sched_setaffinity(0, {min(os.sched_getaffinity(0))})\n" + SPIN,
        "has its work done by children that nobody reaps": UNREAPED,
        "takes memory and sleeps": "held = hold(2500)\ntime.sleep(600)",
        "takes memory as long as there is some": "held = []\nwhile True: held.append([])",
        "takes memory for ever": """
held = []
while True:
    with contextlib.suppress(MemoryError):
        while True: held.append(bytearray(10**6))
""",
        "takes memory in children": "children(24, 256)\ntime.sleep(600)",
    },
)
@pytest.mark.slow
def test_keeps_the_class_waiting(body):
    """For each of its exercises once, not for each of its checks; and is no case of starving."""
    begin = time.monotonic()
    reasons = set()
    with attack(PREPARED + function(body), **QUARTER) as student:
        left = student._budget.seconds
        for _ in range(12):
            with pytest.raises((StudentStopped, StudentError)) as failed:
                student.f()
            reasons.add(getattr(failed.value, "reason", "MemoryError"))
        assert not student.starved
        # And for each process what it takes to find out that it has died.
        assert left - student._budget.seconds < 2 * MOST + 2
    assert len(reasons) <= 2, "one cause is told once"
    assert time.monotonic() - begin < 600


UNNOTICED = {
    "by a word": "signal.signal(signal.SIGCHLD, signal.SIG_IGN)",
    "by a flag": """
import ctypes
libc = ctypes.CDLL(None)
libc.sigaction.restype = ctypes.c_int
act = (ctypes.c_ulong * 32)()
act[17] = 2  # the flags, behind a handler and a mask: SA_NOCLDWAIT
assert libc.sigaction(int(signal.SIGCHLD), act, None) == 0
""",
    "by the kernel's own call": """
import ctypes, platform
libc = ctypes.CDLL(None)
act = (ctypes.c_ulong * 4)(1)  # SIG_IGN
number = {"x86_64": 13, "aarch64": 134}[platform.machine()]
assert libc.syscall(number, int(signal.SIGCHLD), act, None, 8) == 0
""",
    "at an address whose lower half is 0": """
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
@tried("unnoticed", UNNOTICED)
def test_a_processor_cannot_be_hidden_in_children_that_nobody_reaps(unnoticed):
    """They are reaped: the kernel knows what they have worked, whoever else is at work."""
    body = unnoticed + CHILDREN
    with attack(PREPARED + function(body), call_seconds=60.0, total_seconds=90.0) as student:
        student.start()
        before = student.cpu_seconds
        student.f()
        assert student.cpu_seconds - before > 0.8


@pytest.mark.slow
def test_a_processor_cannot_be_hidden_in_children_of_children_that_are_gone():
    body = (
        CHILDREN.replace("range(50)", "range(20)")
        .replace("0.02", "0.05")
        .replace(
            "    if os.fork() == 0:\n",
            "    if os.fork() == 0:\n        if os.fork(): os._exit(0)\n",
        )
    )
    with attack(PREPARED + function(body + "time.sleep(8)"), call_seconds=60.0) as student:
        student.start()
        before = student.cpu_seconds
        student.f()
        assert student.cpu_seconds - before > 0.8


def test_what_is_done_about_children_can_be_asked():
    asks = """
import ctypes
libc = ctypes.CDLL(None)
act = (ctypes.c_ulong * 32)(7)
return libc.sigaction(int(signal.SIGCHLD), None, act), int(act[0])
"""
    assert tuple(outcome_of(PREPARED + function(asks))) == (0, 0)


@pytest.mark.slow
def test_sleeps_just_short_of_the_limit():
    """Each call is answered; there is one budget for them all, and it is that of the wall."""
    with attack("import time\ndef f(): time.sleep(0.6)", total_seconds=2.0) as student:
        with pytest.raises(StudentStopped):
            for _ in range(10):
                student.f()
        assert not student.starved


@pytest.mark.slow
def test_answers_quickly_for_ever():
    """No call lasts long enough to be looked at, and yet there is an end."""
    begin = time.monotonic()
    with (
        attack("import time\ndef f(): time.sleep(0.02)", wall_seconds=3.0) as student,
        pytest.raises(StudentStopped, match="3 seconds by the clock on the wall"),
    ):
        while time.monotonic() - begin < PATIENCE:
            student.f()


@pytest.mark.slow
def test_its_cells_never_end():
    begin = time.monotonic()
    source = "def g():\n    while True: pass\nx = g()\ndef f(): return x\n"
    with attack(source, **QUARTER) as student:
        for exercise in "abcd":
            student.exercise = exercise
            for _ in range(6):
                with pytest.raises(StudentStopped, match="own cells"):
                    student.f()
        assert 45 - student._budget.seconds < MOST + 1
    assert time.monotonic() - begin < 600


@tried(
    "begins",
    {
        "a cell that never ends": "while True: pass",
        "a cell that ends the process": "import os\nos._exit(0)",
    },
)
@pytest.mark.slow
def test_what_never_begins_is_not_begun_again_to_look_for_an_edit(begins, hand_in, monkeypatch):
    """Its class would wait once more for each exercise."""
    begun, begin = [], type(WALLS).start

    def counted(*arguments):
        begun.append(arguments)
        return begin(*arguments)

    monkeypatch.setattr(type(WALLS), "start", counted)
    answer = function(begins, "g", "") + "x = g()\ndef line_through(p, q): return x"
    assert hand_in({"line_through": answer}, lesson=LINE, start_seconds=2.0).score == 0
    assert len(begun) == 1


def test_what_an_exercise_may_cost_is_what_the_threat_model_says():
    limits = Limits()
    again = limits.call_seconds * ONCE_MORE
    first = limits.call_seconds + limits.restarts * again
    threats = (PROJECT / "grader" / "README.md").read_text("utf-8").partition("## Threat model")[2]
    for told in (
        f"{limits.total_seconds:.0f} seconds in which its code works",
        f"and {limits.wall_seconds:.0f} of the wall",
        f"the first {limits.call_seconds:.0f} seconds are waited for",
        # As it is, and with right helpers, once each.
        f"{math.ceil(first)} in all, and {math.ceil(2 * again)} more where it is judged a second",
    ):
        assert told in threats
    assert repair.SECONDS <= 1 and "an edit takes a second of the processor" in threats


SLEEPY = {
    "line_through": "def line_through(first, second):\n    import time\n    time.sleep(600)\n",
    "point_line_distance": "def point_line_distance(points, line):\n    while True: pass\n",
    "ransac_line": "def ransac_line(points, max_iterations=100, distance_tolerance=0.1, rng=None):"
    "\n    line_through(*points[:2])\n    while True: pass\n",
}


@pytest.mark.slow
def test_a_notebook_that_sleeps_everywhere_has_one_budget(hand_in, monkeypatch):
    """It is judged twice, too: its last exercise calls the others."""
    budgets = []

    class Noted(Budget):
        def __init__(self, limits):
            super().__init__(limits)
            budgets.append(self)

    for module in (judge, repair, students):
        monkeypatch.setattr(module, "Budget", Noted)
    verdict = hand_in(SLEEPY, lesson=LINE, call_seconds=1.0, total_seconds=5.0, restarts=3)
    assert verdict.score == 0 and not verdict.starved
    for exercise in verdict.exercises:
        messages = [test.message for test in exercise.tests]
        assert sum("did not answer" in message for message in messages) <= 1
        assert sum("For the same reason" in message for message in messages) == len(messages) - 1
    [budget] = budgets
    assert -1.5 < budget.seconds < 0.5, "all of it is slept away, and hardly more"
