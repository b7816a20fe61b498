"""A call is charged for its own work and sleep, and not for waiting on a busy machine."""

import contextlib
import os
import subprocess
import sys
import time

import pytest

from grader.sandbox import Limits, time_budget, usage
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.protocol import Thread
from grader.sandbox.student import StudentProxy
from tests.prerequisites import PATIENCE

WORK = """
import os, time
def work(): sum(range(2 * 10**7))
def delegate():
    if os.fork() == 0:
        work()
        os._exit(0)
    os.wait()
def wait(): time.sleep(1.5)
"""


@contextlib.contextmanager
def crowd_processor(student, others):
    """Run `others` busy processes on the same processor as the student's process."""
    processor = {min(os.sched_getaffinity(0))}
    student._ensure_running()
    os.sched_setaffinity(student._worker.pids[-1], processor)
    # Each process has its own session, because some kernels share processor time among sessions.
    command = [sys.executable, "-c", "while True: pass"]
    busy = [subprocess.Popen(command, start_new_session=True) for _ in range(others)]
    try:
        for process in busy:
            os.sched_setaffinity(process.pid, processor)
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


COMPUTING_FUNCTION = """
import time
def f(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end: pass
    return seconds
def wait(seconds): time.sleep(seconds)
"""


@pytest.mark.slow
@pytest.mark.parametrize("others", [1, 3, 7])
def test_sharing_the_processor_does_not_cost_time(sandbox, others):
    """The call needs 0.9 s of its 1 s; next to three busy processes, it lasts 3.6 s."""
    limits = Limits(call_seconds=1.0)
    with (
        StudentProxy(Program((COMPUTING_FUNCTION,), ("f",)), sandbox, limits) as student,
        crowd_processor(student, others),
    ):
        assert student.f(0.9) == 0.9
        assert not student.starved
        assert student._budget.seconds > limits.total_seconds - 1.5


SHORT_WORK = """
import os, threading, time
def work():
    end = time.thread_time() + 0.02
    while time.thread_time() < end: pass
def threads():
    for _ in range(30):
        thread = threading.Thread(target=work)
        thread.start()
        thread.join()
def children():
    for _ in range(30):
        if os.fork() == 0:
            work()
            os._exit(0)
        os.wait()
"""


@pytest.mark.slow
@pytest.mark.parametrize("name", ["threads", "children"])
def test_waiting_for_threads_or_children_that_lack_a_processor_does_not_count_as_sleep(
    sandbox, name
):
    """The kernel discards the waiting times of finished threads; the call is not starved."""
    program, limits = Program((SHORT_WORK,), (name,)), Limits(call_seconds=2.5)
    with StudentProxy(program, sandbox, limits) as student, crowd_processor(student, 5):
        assert getattr(student, name)() is None
        assert not student.starved


@pytest.mark.slow
def test_a_call_that_is_too_slow_is_stopped_on_a_busy_machine_and_not_starved(sandbox):
    limits = Limits(call_seconds=0.5)
    with (
        StudentProxy(Program((COMPUTING_FUNCTION,), ("f",)), sandbox, limits) as student,
        crowd_processor(student, 3),
    ):
        with pytest.raises(StudentStopped, match="did not answer within 0.5 seconds"):
            student.f(60)
        assert not student.starved


@pytest.mark.slow
def test_a_call_that_the_wall_clock_stops_is_starved(sandbox):
    """The call gets an eighth of the processor, so it might have finished on an idle machine."""
    limits = Limits(call_seconds=8.0, wall_seconds=4.0)
    with (
        StudentProxy(Program((COMPUTING_FUNCTION,), ("f",)), sandbox, limits) as student,
        crowd_processor(student, 7),
    ):
        with pytest.raises(StudentStopped, match="4 seconds of elapsed time"):
            student.f(6)
        assert student.starved
        with pytest.raises(StudentStopped, match="Not run: the notebook has used up its 4"):
            student.f(0)


@pytest.mark.slow
def test_calls_that_wait_for_a_processor_may_exceed_the_elapsed_time(sandbox):
    limits, start = Limits(wall_seconds=4.0), time.monotonic()
    with (
        StudentProxy(Program((COMPUTING_FUNCTION,), ("f",)), sandbox, limits) as student,
        crowd_processor(student, 7),
    ):
        while time.monotonic() - start < 6:
            student.f(0.1)  # it lasts 0.8 s
        assert not student.starved


@pytest.mark.slow
def test_a_sleeping_call_is_stopped_like_a_busy_one_and_not_starved(sandbox):
    program, limits = Program((COMPUTING_FUNCTION,), ("f", "wait")), Limits(call_seconds=0.5)
    for name in ("f", "wait"):
        with StudentProxy(program, sandbox, limits) as student:
            start = time.monotonic()
            with pytest.raises(StudentStopped, match="did not answer"):
                getattr(student, name)(60)
            assert not student.starved
            charged = limits.total_seconds - student._budget.seconds
            assert 0.1 < charged < 1.1, "the call is charged for its limit, not for 60 seconds"
            if name == "wait":  # `f` may wait for a processor
                assert time.monotonic() - start < PATIENCE


@pytest.mark.slow
def test_calls_have_more_time_if_waiting_times_are_unknown(sandbox, monkeypatch):
    monkeypatch.setattr(usage, "_records_delays", lambda: False)
    program = Program((COMPUTING_FUNCTION,), ("f", "wait"))
    with StudentProxy(program, sandbox, Limits(call_seconds=0.5)) as student:
        assert student.f(0.1) == 0.1
        student.wait(0.8)  # not stopped, because the processor may have been busy
        with pytest.raises(StudentStopped, match="did not answer"):
            student.wait(60)
        assert student.starved


class FakeWorker:
    """A worker that only reports how much time it has used."""

    def __init__(self):
        self.worked, self.delayed, self.ready = 7.0, {1: 3.0, 2: 5.0}, False

    def cpu_seconds(self):
        return self.worked

    def threads(self):
        return {number: Thread(delayed, self.ready) for number, delayed in self.delayed.items()}


@pytest.mark.parametrize(
    "waited, worked, delayed, seconds",
    [
        (1.0, 0.9, {1: 3.1, 2: 5.0}, 0.9),
        (1.0, 0.4, {1: 3.6, 2: 5.0}, 0.4),  # other processes also ran
        (1.0, 0.0, {1: 3.0, 2: 5.0}, 1.0),  # the call slept
        (1.0, 0.1, {1: 3.2, 2: 5.2, 4: 0.3}, 0.7),  # threads waited for each other
        (1.0, 2.0, {1: 3.0, 2: 5.0}, 2.0),  # several threads ran at once
        (3.0, 0.1, {1: 5.9, 2: 5.0}, 0.1),
        (0.06, 0.0, {1: 3.05, 2: 5.0}, 0.01),  # the kernel's clock has not ticked yet
    ],
)
def test_a_call_is_charged_only_for_time_in_which_it_does_not_wait(
    waited, worked, delayed, seconds, monkeypatch
):
    now, worker = [100.0], FakeWorker()
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "own_seconds", lambda: 0.0)
    meter = time_budget.Meter(worker)
    now[0] += waited
    worker.worked, worker.delayed = worker.worked + worked, delayed
    meter.measure(answered=True)
    assert meter.seconds == pytest.approx(seconds)


@pytest.mark.parametrize("delayed, seconds_left", [(300.0, 597.0), (0.0, 297.0)])
def test_only_waiting_and_the_judges_time_postpone_the_deadline(delayed, seconds_left, monkeypatch):
    now, ours, worker = [100.0], [2.0], FakeWorker()
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "own_seconds", lambda: ours[0])
    budget = time_budget.Budget(Limits(wall_seconds=600.0))
    time_limit = time_budget.TimeLimit(worker, 10.0, budget.deadline)
    now[0] += 1.0
    time_limit()
    now[0] += 302.0  # the worker works for 2 s, and waits or sleeps
    worker.worked, worker.delayed[1] = worker.worked + 2.0, worker.delayed[1] + delayed
    time_limit.used_seconds()
    budget.postpone_deadline(time_limit.waiting_seconds())
    now[0] += 50.0
    ours[0] += 50.0
    assert budget.seconds_to_deadline() == pytest.approx(seconds_left)


def test_time_of_the_judge_is_not_counted_as_sleep(monkeypatch):
    now, ours = [100.0], [2.0]
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "own_seconds", lambda: ours[0])
    meter = time_budget.Meter(FakeWorker())
    now[0] += 1.0
    ours[0] += 0.6
    meter.measure(answered=True)
    assert meter.seconds == pytest.approx(0.4)


def test_threads_that_are_ready_to_run_do_not_sleep(monkeypatch):
    """While threads are ready to run, a call waits and does not sleep."""
    now, ours, worker = [100.0], [2.0], FakeWorker()
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "own_seconds", lambda: ours[0])
    meter = time_budget.Meter(worker)
    for ready, worked, passed, at_work, taken in (
        (True, 0.1, 1.0, 0.0, 0.1),  # other processes ran in the rest of the time
        (False, 0.0, 0.5, 0.2, 0.4),  # the call slept, partly while the judge worked
        (True, 0.2, 0.4, 0.0, 0.6),
        (True, 0.3, 1.0, 0.0, 0.9),
    ):
        worker.ready, worker.worked = ready, worker.worked + worked
        now[0] += passed
        ours[0] += at_work
        meter.measure()
        assert meter.seconds == pytest.approx(taken)
    # A call that has answered seems to sleep, so the share of sleep before the answer is used.
    worker.ready = False
    now[0] += 1.0
    meter.measure(answered=True)
    assert meter.seconds == pytest.approx(0.9 + 0.3 / 2.7)


@pytest.mark.slow
def test_sleep_counts_towards_the_limit_but_waiting_for_a_processor_does_not(sandbox):
    with StudentProxy(Program((COMPUTING_FUNCTION,), ("f", "wait")), sandbox) as student:
        # Sleep is sampled, so some sleep counts as waiting for a processor on a busy machine.
        assert student.wait.timed(1)[1] > 0.3
        with crowd_processor(student, 11):
            assert student.f.timed(0.3)[1] < 1.8  # it lasts 3.6 s
        assert not student.starved


@pytest.mark.slow
def test_the_work_of_children_is_counted(sandbox):
    with StudentProxy(Program((WORK,), ("work", "delegate", "wait")), sandbox) as student:
        own = student.work.timed()[1]
        assert student.delegate.timed()[1] > own / 2 > 0.02
        assert 0.5 < student.wait.timed()[1] < 3
