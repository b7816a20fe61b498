"""No student loses points through faults of the judge, the machine or other students' code."""

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from concurrent.futures import BrokenExecutor, Executor, Future, ThreadPoolExecutor
from importlib import metadata
from types import SimpleNamespace

import pytest

from grader import cli, commands
from grader.classroom import doctor, grade, rehearsals
from grader.classroom.executors import EXECUTORS, processor_count
from grader.classroom.pool import Pool
from grader.classroom.protocol import ExecutorLost
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.console import progress_bar
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import Course
from grader.grading import grade_course
from grader.judging import judge as judging
from grader.judging import program_run
from grader.judging.collection import JudgeFault
from grader.judging.runner import run_checks
from grader.judging.verdict import FAILED, JUDGED, Verdict, read_verdict
from grader.sandbox import SANDBOXES, Limits, SandboxUnavailable, time_budget, usage
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.protocol import Thread
from grader.sandbox.student import StudentProxy
from tests.archives import notebook
from tests.prerequisites import PATIENCE
from tests.test_grade import record_rehearsal

SEED = 20_170_405
LESSON = find_lesson("06_filter_ground")
RIGHT = {
    exercise: next(variant.source for variant in answers_to(exercise) if variant.right)
    for exercise in ("filter_ground", "voxel_grid")
}
WRONG = {
    "voxel_grid": next(answer.source for answer in answers_to("voxel_grid") if not answer.right)
}


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


@pytest.fixture(autouse=True)
def empty_cache(monkeypatch):
    """Empty the cache of right notebooks, which earlier tests may have filled."""
    monkeypatch.setattr(judging, "_full_mark_decisions", {})


class InlineExecutor(Executor):
    """Executor that runs jobs immediately in this process, where tests can replace functions."""

    def __init__(self, workers):
        pass

    def submit(self, function, *arguments):
        future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


class DeadlyExecutor(Pool):
    """Executor in which the process that judges the student "poison" dies `left` times."""

    left = 0

    def submit(self, function, *arguments):
        if function is grade.judge_one and arguments[2] == "poison":
            DeadlyExecutor.left -= 1
            if DeadlyExecutor.left >= 0:
                return super().submit(os._exit, 1)
        return super().submit(function, *arguments)


@pytest.fixture
def course(tmp_path):
    """Return a course in which three students submit right answers."""
    course = Course(tmp_path / "course")
    for student in ("ada", "poison", "zoe"):
        path = course.submitted / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in(LESSON, RIGHT), "utf-8")
    return course


def grade_class(
    course, sandbox, open_executor=InlineExecutor, workers=1, progress=lambda *news: None
):
    """Grade the course; return the verdict of each student."""
    judged = grade.judge_class(course, (), SEED, sandbox, open_executor, workers, progress)
    return {submission.student: verdict for submission, verdict in judged}


def add_long_text(path):
    """Add 300 KB of text to a notebook, which is more than a pipe can buffer."""
    notebook = json.loads(path.read_text("utf-8"))
    essay = {"cell_type": "markdown", "id": "essay", "metadata": {}, "source": "A word. " * 38_000}
    notebook["cells"].append(essay)
    path.write_text(json.dumps(notebook), "utf-8")


@pytest.mark.slow
@pytest.mark.death
@pytest.mark.parametrize(("deaths", "status", "score"), [(1, JUDGED, 30), (2, FAILED, 0)])
def test_a_dead_worker_costs_one_retry_of_one_notebook(course, sandbox, deaths, status, score):
    for path in course.submitted.rglob("*.ipynb"):
        add_long_text(path)
    DeadlyExecutor.left = deaths
    verdicts = grade_class(course, sandbox, DeadlyExecutor, 2)
    assert (verdicts["poison"].status, verdicts["poison"].score) == (status, score)
    if status == FAILED:
        assert "The judging process ended (exit status 1)" in verdicts["poison"].faults[0]
    assert [verdicts[name].score for name in ("ada", "zoe")] == [30, 30]


def test_a_fault_of_the_judge_is_recorded_and_costs_no_points(course, sandbox, monkeypatch):
    def broken(*question):
        raise JudgeFault("pytest ran 3 of 9 tests")

    original = program_run.run_checks
    monkeypatch.setattr(program_run, "run_checks", broken)
    record_rehearsal(course, LESSON, SEED)
    verdicts = grade_class(course, sandbox)
    assert {verdict.status for verdict in verdicts.values()} == {FAILED}
    assert all("not the student's fault" in verdict.problems[0] for verdict in verdicts.values())
    assert "pytest ran 3 of 9" in verdicts["ada"].faults[0]
    assert "faults" not in verdicts["ada"].as_dict()  # only graders see faults
    # The next run tries again.
    monkeypatch.setattr(program_run, "run_checks", original)
    assert {verdict.score for verdict in grade_class(course, sandbox).values()} == {30}


def test_a_fault_is_reported_for_an_untouched_notebook(monkeypatch):
    def broken(lesson):
        raise JudgeFault("pytest ran 3 of 9 tests")

    monkeypatch.setattr(program_run, "outcomes_of_untouched", broken)
    verdict = judging.judge(LESSON.released, SEED, None)
    assert verdict.status == FAILED and verdict.faults == ("pytest ran 3 of 9 tests",)
    assert judging.JUDGE_FAILED_NOTE in verdict.problems


@pytest.mark.slow
def test_a_faulty_check_is_not_a_wrong_answer(course, sandbox, monkeypatch):
    """If an oracle also fails for the reference, it is faulty. Otherwise, the answer is wrong."""
    original = program_run.run_checks

    def raising(*question):
        outcomes = original(*question)
        return [type(outcome)(outcome.check, ZeroDivisionError("oracle")) for outcome in outcomes]

    record_rehearsal(course, LESSON, SEED)
    complaints = judging.reference_failures.__wrapped__  # bypasses the cache
    monkeypatch.setattr(judging, "reference_failures", complaints)
    monkeypatch.setattr(program_run, "run_checks", raising)
    verdict = grade_class(course, sandbox)["ada"]
    assert verdict.status == FAILED and "ZeroDivisionError: oracle" in verdict.faults[0]
    monkeypatch.setattr(judging, "reference_failures", lambda *about: ())
    verdict = grade_class(course, sandbox)["ada"]
    assert (verdict.status, verdict.score) == (JUDGED, 0)


def fail_once(monkeypatch):
    """Make some checks raise OSError in the first run; return a list of the checks in each run."""
    original, calls = program_run.run_checks, []

    def failing_once(*question):
        outcomes = original(*question)
        calls.append([outcome.check.name for outcome in outcomes])
        if len(calls) > 1:
            return outcomes
        return [
            type(outcome)(outcome.check, OSError("once"))
            if "columns" in outcome.check.name
            else outcome
            for outcome in outcomes
        ]

    monkeypatch.setattr(program_run, "run_checks", failing_once)
    return calls


@pytest.mark.slow
def test_a_failure_that_does_not_recur_in_a_rehearsal_is_ignored(sandbox, monkeypatch):
    calls = fail_once(monkeypatch)
    assert judging.reference_failures.__wrapped__(LESSON, SEED, sandbox) == ()
    assert len(calls) == 2


@pytest.mark.slow
@pytest.mark.parametrize("answers", [RIGHT, RIGHT | WRONG], ids=["right", "wrong"])
def test_a_failure_that_does_not_recur_costs_no_points(answers, sandbox, tmp_path, monkeypatch):
    path = tmp_path / f"{LESSON.name}.ipynb"
    path.write_text(fill_in(LESSON, answers), "utf-8")
    expected = judging.judge(path, SEED, sandbox)
    calls = fail_once(monkeypatch)
    judging._full_mark_decisions.clear()
    verdict = judging.judge(path, SEED, sandbox)
    assert (verdict.status, verdict.score) == (JUDGED, expected.score)
    assert verdict.exercises == expected.exercises
    assert len(calls[0]) > 10 > len(calls[1]) > 1  # only failed checks run again


def test_nothing_is_graded_by_a_check_that_fails_the_solution(course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(rehearsals, "reference_failures", lambda *about: ("voxel_grid, x",))
    with pytest.raises(rehearsals.RehearsalFailed, match="06_filter_ground:\nvoxel_grid, x"):
        grade_class(course, sandbox)
    assert not list(course.verdicts.rglob("*.json"))
    monkeypatch.setitem(EXECUTORS, "processes", InlineExecutor)
    assert grade_course(course, (), SEED, sandbox, 1) == commands.FAULT
    assert "No notebook was graded" in capsys.readouterr().err


def test_rehearsals_are_stored(course, sandbox, monkeypatch):
    events = []
    grade_class(course, sandbox, progress=lambda done, total, what: events.append((done, what)))
    assert events[:2] == [(0, None), (0, f"the course's solution of {LESSON.name}")]
    monkeypatch.setattr(rehearsals, "reference_failures", lambda *about: ("not called",))
    (course.submitted / "ada" / LESSON.stage / "helper.py").write_text("x = 1")
    again = grade_class(course, sandbox, progress=lambda *news: events.append(news))
    assert again["ada"].score == 30 and not isinstance(events[-1][2], str)


@pytest.fixture
def three_lessons(course, monkeypatch):
    """Return a course with three lessons per student, the list of judged jobs, and complaints.

    The judge is replaced with functions that only record the jobs. Tests can add complaints about
    the course's own solutions, by lesson number.
    """
    for lesson in ("07_filter_by_distance", "08_bounding_boxes"):
        for student in ("ada", "poison", "zoe"):
            (course.submitted / student / LESSON.stage / f"{lesson}.ipynb").write_text("{}")
    calls, complaints = [], {}

    def rehearse_one(lesson, seed, sandbox):
        calls.append(lesson[:2])
        return complaints.get(lesson[:2], ())

    def judge_one(submitted_files, lesson, student, seed, sandbox, is_alone=False):
        calls.append(f"{lesson[:2]} {student}")
        return Verdict(lesson, student, JUDGED, 1.0, 1.0, (), (), 0.0, "")

    monkeypatch.setattr(rehearsals, "rehearse_one", rehearse_one)
    monkeypatch.setattr(grade, "judge_one", judge_one)
    return course, calls, complaints


def judge_three(course, sandbox, open_executor=ThreadPoolExecutor, workers=1):
    return grade.judge_class(course, (), SEED, sandbox, open_executor, workers, lambda *news: None)


def test_the_first_verdict_does_not_wait_for_other_lessons(three_lessons, sandbox):
    course, calls, _ = three_lessons
    assert len(judge_three(course, sandbox)) == 9
    assert calls == [
        *("06", "06 ada", "06 poison", "06 zoe"),
        *("07", "07 ada", "07 poison", "07 zoe"),
        *("08", "08 ada", "08 poison", "08 zoe"),
    ]
    calls.clear()
    assert len(judge_three(course, sandbox)) == 9  # because these verdicts have no key
    assert sorted(calls)[:2] == ["06 ada", "06 poison"] and len(calls) == 9


@pytest.mark.parametrize("workers", [1, 2, 9])
def test_a_lesson_whose_solution_fails_is_not_judged(three_lessons, sandbox, workers):
    course, calls, complaints = three_lessons
    complaints.update({"07": ("one",), "08": ("two", "three")})
    with pytest.raises(rehearsals.RehearsalFailed) as failed:
        judge_three(course, sandbox, workers=workers)
    assert str(failed.value).endswith("07_filter_by_distance:\none\n08_bounding_boxes:\ntwo\nthree")
    assert {job[:2] for job in calls if len(job) > 2} <= {"06"}
    judged = [path.parts[-3] for path in course.verdicts.glob("*/*/06*.json")]
    assert len(judged) == len([job for job in calls if len(job) > 2])  # finished verdicts are kept


# ---- a class with a fake judge -----------------------------------------------------------------


class FakeJudge:
    """A judge of a class of three that returns given outcomes and records calls and progress.

    `outcomes` contains an exception or fields of the verdict, by student and number of the call.
    """

    def __init__(self, course, **outcomes):
        self.course, self.outcomes = course, outcomes
        self.calls, self.events, self.opened = [], [], []

    def judge_one(self, submitted_files, lesson, student, seed, sandbox, is_alone=False):
        self.calls.append((student, is_alone))
        attempt = [name for name, _ in self.calls].count(student)
        outcome = self.outcomes.get(student, {}).get(attempt, {})
        if isinstance(outcome, Exception):
            raise outcome
        key = grade.verdict_key(submitted_files, LESSON, seed, student)
        fields = {"key": key, "fingerprint": submitted_files.fingerprint()} | outcome
        return Verdict(lesson, student, JUDGED, 1.0, 30.0, (), (), 0.0, **fields)

    def grade(self, monkeypatch, capacity=64):
        """Grade the class; return the verdict of each student in order of completion."""
        monkeypatch.setattr(grade, "judge_one", self.judge_one)

        class WithCapacity(InlineExecutor):
            def __init__(self, workers):
                self.capacity = capacity

        def open_executor(workers):
            self.opened.append(workers)
            return WithCapacity(workers)

        def record(done, total, what):
            self.events.append((done, total, getattr(what, "student", what), len(self.calls)))

        judged = grade.judge_class(
            self.course, (), SEED, SANDBOXES["process"], open_executor, 3, record
        )
        return {submission.student: verdict for submission, verdict in judged}


@pytest.fixture
def prepared(course):
    """Return the course with a record that the lesson's own solution was judged."""
    record_rehearsal(course, LESSON, SEED)
    return course


def test_progress_counts_submissions_and_verdicts_are_reused(prepared, monkeypatch):
    judge = FakeJudge(prepared)
    verdicts = judge.grade(monkeypatch)
    assert list(verdicts) == ["ada", "poison", "zoe"] and judge.opened == [3]
    assert judge.calls == [("ada", False), ("poison", False), ("zoe", False)]
    counted = [(0, 3, None), (1, 3, "ada"), (2, 3, "poison"), (3, 3, "zoe")]
    assert [news[:3] for news in judge.events] == counted
    second = FakeJudge(prepared)
    assert second.grade(monkeypatch) == verdicts
    assert (second.calls, second.opened, second.events) == ([], [], [(3, 3, None, 0)])
    prepared.verdicts.joinpath("poison", LESSON.stage, f"{LESSON.name}.json").unlink()
    third = FakeJudge(prepared)
    assert third.grade(monkeypatch) == verdicts
    assert third.calls == [("poison", False)]
    assert [news[:3] for news in third.events] == [(2, 3, None), (3, 3, "poison")]


@pytest.mark.parametrize("capacity", [1, 2, 3])
def test_reading_ahead_is_limited_by_the_capacity(prepared, monkeypatch, capacity):
    judge = FakeJudge(prepared)
    judge.grade(monkeypatch, capacity)
    assert [count for *_, count in judge.events[1:]] == [
        min(capacity + done, 3) for done in range(3)
    ]


def test_a_starved_submission_is_judged_again_alone(prepared, monkeypatch):
    judge = FakeJudge(prepared, poison={1: {"starved": True}})
    verdicts = judge.grade(monkeypatch)
    assert judge.calls == [("ada", False), ("poison", False), ("zoe", False), ("poison", True)]
    assert judge.opened == [3, 1] and not verdicts["poison"].starved
    assert [news[:3] for news in judge.events[-2:]] == [(3, 3, "zoe"), (3, 3, "poison")]
    assert FakeJudge(prepared).grade(monkeypatch) == verdicts


def test_a_notebook_that_kills_its_judge_is_judged_again_alone(prepared, monkeypatch):
    death = BrokenExecutor("The judging process ended (signal 9).")
    judge = FakeJudge(prepared, poison={1: death})
    verdicts = judge.grade(monkeypatch)
    assert judge.calls == [("ada", False), ("poison", False), ("zoe", False), ("poison", True)]
    assert {verdict.status for verdict in verdicts.values()} == {JUDGED}
    assert [news[:3] for news in judge.events[-2:]] == [(2, 3, "zoe"), (3, 3, "poison")]
    prepared.verdicts.joinpath("poison", LESSON.stage, f"{LESSON.name}.json").unlink()
    verdicts = FakeJudge(prepared, poison={1: death, 2: death}).grade(monkeypatch)
    failed = verdicts["poison"]
    assert (failed.status, failed.score, failed.max_score) == (FAILED, 0.0, 30.0)
    assert [(exercise.score, exercise.tests) for exercise in failed.exercises] == [
        (0.0, ()),
        (0.0, ()),
    ]
    assert "ended (signal 9)" in failed.faults[0] and failed.problems == (
        judging.JUDGE_FAILED_NOTE,
    )
    assert (failed.lesson, failed.student, failed.key) == (LESSON.name, "poison", "")
    assert not failed.starved and failed.seconds == 0.0


@pytest.mark.parametrize("error", [SandboxUnavailable("no"), ExecutorLost("gone")])
def test_losing_the_sandbox_or_executor_is_not_a_failed_verdict(prepared, monkeypatch, error):
    with pytest.raises(type(error)):
        FakeJudge(prepared, poison={1: error}).grade(monkeypatch)
    kept = [path.parts[-3] for path in prepared.verdicts.glob("[!.]*/*/*.json")]
    assert kept == ["ada"]
    assert FakeJudge(prepared).grade(monkeypatch)["poison"].status == JUDGED


def test_a_notebook_that_fails_the_judge_does_not_stop_others(prepared, monkeypatch):
    verdicts = FakeJudge(prepared, poison={1: ZeroDivisionError("oracle")}).grade(monkeypatch)
    assert [verdict.status for verdict in verdicts.values()] == [JUDGED, FAILED, JUDGED]
    assert "ZeroDivisionError: oracle" in verdicts["poison"].faults[0]
    judge_again = FakeJudge(prepared)
    judge_again.grade(monkeypatch)
    assert judge_again.calls == [("poison", False)]


@pytest.mark.parametrize("alone", [False, True])
def test_a_verdict_of_a_submission_judged_alone_is_not_starved(course, monkeypatch, alone):
    calls = []

    def starving(*about):
        calls.append(about)
        return Verdict(LESSON.name, "ada", JUDGED, 0.0, 30.0, (), (), 0.0, "", starved=True)

    monkeypatch.setattr(grade, "judge_files", starving)
    (submission, *_) = find_submissions(course)
    verdict = grade.judge_one("a file", LESSON.name, "ada", SEED, "process", alone)
    assert verdict.starved != alone
    assert calls == [("a file", SEED, SANDBOXES["process"], LESSON, "ada")]
    assert grade.judge_one("a file", LESSON.name, "ada", SEED, "process").starved
    sandbox = SANDBOXES["process"]
    assert not grade.current_verdict(course, submission, SEED, sandbox).starved
    assert grade.judge_and_store(course, submission, SEED, sandbox).starved
    assert read_verdict(submission.verdict_path(course)).starved
    assert calls[-1] == (submission.read(course), SEED, sandbox, LESSON, "ada")


def test_an_existing_verdict_is_reused(prepared, monkeypatch):
    verdicts = FakeJudge(prepared).grade(monkeypatch)
    (submission, *_) = find_submissions(prepared)
    sandbox = SANDBOXES["process"]
    assert grade.current_verdict(prepared, submission, SEED, sandbox) == verdicts["ada"]
    judge_again = FakeJudge(prepared)
    monkeypatch.setattr(grade, "judge_one", judge_again.judge_one)
    grade.current_verdict(prepared, submission, SEED + 1, sandbox)
    assert judge_again.calls == [("ada", True)]


class DelayedExecutor(InlineExecutor):
    """Executor that rehearses immediately, but judges after five seconds unless cancelled."""

    def submit(self, function, *arguments):
        if function is rehearsals.rehearse_one:
            return super().submit(function, *arguments)
        future = Future()
        timer = threading.Timer(5, lambda: future.set_result(function(*arguments)))
        future.add_done_callback(lambda _: timer.cancel())
        timer.start()
        return future


def test_waiting_jobs_are_cancelled_when_a_rehearsal_fails(three_lessons, sandbox):
    course, calls, complaints = three_lessons
    complaints.update({"07": ("one",)})
    with pytest.raises(rehearsals.RehearsalFailed):
        judge_three(course, sandbox, DelayedExecutor, workers=9)
    assert calls == ["06", "07", "08"] and not list(course.verdicts.glob("*/stage*/*.json"))


class BusyExecutor(InlineExecutor):
    """Executor that rehearses immediately, and judges for half a second, even if cancelled."""

    def submit(self, function, *arguments):
        if function is rehearsals.rehearse_one:
            return super().submit(function, *arguments)
        future = Future()
        future.set_running_or_notify_cancel()
        threading.Timer(0.5, lambda: future.set_result(function(*arguments))).start()
        return future


def test_running_jobs_are_finished_when_a_rehearsal_fails(three_lessons, sandbox):
    course, calls, complaints = three_lessons
    complaints.update({"07": ("one",)})
    with pytest.raises(rehearsals.RehearsalFailed):
        judge_three(course, sandbox, BusyExecutor, workers=9)
    kept = {path.parts[-3] for path in course.verdicts.glob("*/stage*/*.json")}
    assert {job for job in calls if len(job) > 2} == {f"06 {student}" for student in kept}
    assert kept == {"ada", "poison", "zoe"}


class DyingExecutor(ThreadPoolExecutor):
    """Executor in which the process that judges the solution of lesson 07 dies `left` times."""

    left = 0

    def submit(self, function, *arguments):
        if (
            function is rehearsals.rehearse_one
            and arguments[0].startswith("07")
            and DyingExecutor.left > 0
        ):
            DyingExecutor.left -= 1
            future = Future()
            future.set_exception(BrokenExecutor("The judging process ended (signal 9)."))
            return future
        return super().submit(function, *arguments)


def test_a_rehearsal_whose_process_dies_is_repeated(three_lessons, sandbox):
    course, calls, _ = three_lessons
    DyingExecutor.left = 1
    judged = judge_three(course, sandbox, DyingExecutor)
    assert {(submission.student, submission.lesson.number) for submission, _ in judged} == {
        (student, number) for student in ("ada", "poison", "zoe") for number in ("06", "07", "08")
    }
    assert len(calls) == 3 + 9
    before = calls[: calls.index("07")]  # the second rehearsal runs alone
    assert "08" in before and "06 zoe" in before and "08 ada" not in before


def test_a_rehearsal_that_always_kills_its_process_is_reported(three_lessons, sandbox):
    course, _, _ = three_lessons
    DyingExecutor.left = 2
    with pytest.raises(
        rehearsals.RehearsalFailed, match="07_filter_by_distance:\nThe judging process ended"
    ):
        judge_three(course, sandbox, DyingExecutor)


@pytest.mark.slow
def test_a_starved_notebook_is_tried_again_alone(course, sandbox, monkeypatch):
    calls = []
    original = grade.judge_files

    def starving(submitted_files, seed, sandbox, lesson, student):
        calls.append(student)
        verdict = original(submitted_files, seed, sandbox, lesson, student)
        starved = student == "poison" and calls.count("poison") == 1
        return type(verdict)(**{**verdict.__dict__, "starved": starved})

    monkeypatch.setattr(grade, "judge_files", starving)
    verdicts = grade_class(course, sandbox)
    assert calls == ["ada", "poison", "zoe", "poison"]
    assert not verdicts["poison"].starved and verdicts["poison"].score == 30
    assert grade_class(course, sandbox) == verdicts and len(calls) == 4


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
    limits, begin = Limits(wall_seconds=4.0), time.monotonic()
    with (
        StudentProxy(Program((COMPUTING_FUNCTION,), ("f",)), sandbox, limits) as student,
        crowd_processor(student, 7),
    ):
        while time.monotonic() - begin < 6:
            student.f(0.1)  # it lasts 0.8 s
        assert not student.starved


@pytest.mark.slow
def test_a_sleeping_call_is_stopped_like_a_busy_one_and_not_starved(sandbox):
    program = Program((COMPUTING_FUNCTION,), ("f", "wait"))
    for name in ("f", "wait"):
        with StudentProxy(program, sandbox, Limits(call_seconds=0.5)) as student:
            begin = time.monotonic()
            with pytest.raises(StudentStopped, match="did not answer"):
                getattr(student, name)(60)
            assert not student.starved
            assert student._budget.seconds == pytest.approx(179.4, abs=0.5)
            assert name == "f" or time.monotonic() - begin < PATIENCE


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


@pytest.mark.slow
def test_a_folder_name_that_is_not_text_does_not_stop_grading(course, sandbox, capsys):
    from grader.console import print_class
    from grader.lms.report import write_report

    name = os.fsdecode(b"J\xfcrgen")  # old zip programs write such names
    path = course.submitted / name / LESSON.stage / f"{LESSON.name}.ipynb"
    path.parent.mkdir(parents=True)
    path.write_text(fill_in(LESSON, RIGHT), "utf-8")
    judged = grade.judge_class(
        course, (), SEED, sandbox, EXECUTORS["processes"], 2, lambda *news: None
    )
    assert {verdict.score for _, verdict in judged} == {30}
    print_class(judged)
    write_report(course, judged)
    assert "rgen" in capsys.readouterr().out


def test_a_link_to_another_students_folder_earns_nothing(course, sandbox):
    (course.submitted / "thief").mkdir()
    (course.submitted / "thief" / LESSON.stage).symlink_to(
        course.submitted / "ada" / LESSON.stage, target_is_directory=True
    )
    (course.submitted / "twin").symlink_to(course.submitted / "ada", target_is_directory=True)
    verdicts = grade_class(course, sandbox)
    assert verdicts["ada"].score == 30
    for name in ("thief", "twin"):
        assert verdicts[name].score == 0
        assert "in a linked folder" in verdicts[name].problems[0]


def test_verdict_files_have_ordinary_permissions(course, sandbox):
    grade_class(course, sandbox)
    umask = os.umask(0)
    os.umask(umask)
    for path in course.verdicts.rglob("*.json"):
        assert path.stat().st_mode & 0o777 == 0o666 & ~umask
        assert read_verdict(path) or path.parent.name == ".rehearsed"


def test_workers_must_be_at_least_one(capsys):
    assert processor_count() >= 1
    with pytest.raises(SystemExit) as caught:
        cli.main(["grade", "--workers", "0"])
    assert caught.value.code == 2
    assert "must be at least 1, not" in capsys.readouterr().err


def test_files_that_are_not_judged_are_listed_with_a_reason(course):
    stage = course.submitted / "ada" / LESSON.stage
    (stage / "helper.py").write_text("")
    (stage / "timestamp.txt").write_text("")
    (stage / "submission_secret.txt").write_text("")
    assert unaccounted_files(course) == []
    (stage / "08_bounding_boxes.md").write_text("")
    (stage / "06_filter_ground.py").write_text("")
    (stage / "my work.zip").write_bytes(b"")
    (stage / "01_point_clouds.ipynb").write_text("{}")
    (course.submitted / "ada" / "06_filter_ground.ipynb").write_text("{}")
    reasons = {str(path): reason for path, reason in unaccounted_files(course)}
    assert set(reasons.values()) == {
        "it is not a notebook; submit 08_bounding_boxes.ipynb as Jupyter saves it",
        "it is not a notebook; submit 06_filter_ground.ipynb as Jupyter saves it",
        "it is a zip; run python -m grader collect 'submitted/ada/stage3_obstacles/my work.zip' "
        "--stage stage3_obstacles --who 'my work=ada', and delete the zip",
        "01_point_clouds belongs to stage1_ransac; move it to ada/stage1_ransac/",
        "it is not in <student>/<stage>/; move it to ada/stage3_obstacles/",
    }
    assert len(find_submissions(course)) == 3


@pytest.mark.parametrize(
    "name",
    [
        "06_filter_ground (1).ipynb",
        "06_filter_ground-Copy1.ipynb",
        "Copy of 06_filter_ground.ipynb",
        "06_Filter_Ground.IPYNB",
        "ada_lovelace_123_456_06_filter_ground-2.ipynb",
        "homework/06_filter_ground.ipynb",
        "8 final.ipynb",  # its content identifies the lesson
        "06_filter_ground.ipynb.txt",
        "06_filter_ground.ipynb.json",
        "8.IPYNB.txt",
    ],
)
def test_a_renamed_file_is_recognised_and_noted(course, name):
    stage = course.submitted / "eve" / LESSON.stage
    (stage / name).parent.mkdir(parents=True)
    (stage / name).write_bytes(notebook(LESSON.name))
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "eve"
    ]
    notes = found.read(course).notes
    assert bool(notes) == (found.path.name != "06_filter_ground.ipynb")
    assert unaccounted_files(course) == []


def test_a_folder_with_many_files_is_listed_instead_of_the_files(course):
    stage = course.submitted / "ada" / LESSON.stage
    for number in range(30):
        (stage / f"{number}.png").write_text("")
        module = stage / f"venv/lib/python3.12/site-packages/numpy/{number}.ipynb"
        module.parent.mkdir(parents=True, exist_ok=True)
        module.write_text("")
        (stage / "venv" / "bin" / str(number)).mkdir(parents=True)
        (stage / "venv" / "bin" / str(number) / "activate").write_text("")
    (course.submitted / "eve" / LESSON.stage).mkdir(parents=True)
    (course.submitted / "eve" / LESSON.stage / "photo.png").write_text("")
    reason = "it is not a notebook from this course"
    assert {str(path): reason for path, reason in unaccounted_files(course)} == {
        f"submitted/ada/{LESSON.stage}": f"30 files: {reason}",
        f"submitted/ada/{LESSON.stage}/venv": f"30 files: {reason}",
        f"submitted/eve/{LESSON.stage}/photo.png": reason,
    }


def test_the_newest_of_several_files_counts(course):
    stage = course.submitted / "eve" / LESSON.stage
    stage.mkdir(parents=True)
    for age, name in enumerate(
        ("06_filter_ground (1)", "06_filter_ground", "06_filter_ground (2)")
    ):
        (stage / f"{name}.ipynb").write_text("{}")
        os.utime(stage / f"{name}.ipynb", (1000, 1000 + (age == 1)))
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "eve"
    ]
    assert found.path.name == "06_filter_ground.ipynb"
    assert "The newest, 06_filter_ground.ipynb, was judged" in found.read(course).notes[0]
    os.utime(stage / "06_filter_ground.ipynb", (1000, 1000))  # now the number of the copy decides
    (found,) = [item for item in find_submissions(course) if item.student == "eve"]
    assert found.path.name == "06_filter_ground (2).ipynb"
    assert unaccounted_files(course) == []


def test_the_doctor_shows_progress_of_the_rehearsals(course, sandbox, monkeypatch):
    """No progress bar is shown if the solutions have already been judged."""
    # Sandboxes and versions depend on the machine; other tests cover them.
    monkeypatch.setattr(doctor, "_examine_sandboxes", lambda: ())
    monkeypatch.setattr(doctor, "_examine_versions", lambda: ())
    steps, bars = [], []
    monkeypatch.setattr(rehearsals, "rehearse_one", lambda *about: ())

    @contextlib.contextmanager
    def bar(title):
        bars.append(title)
        yield lambda done, total, what: steps.append((done, total))

    for _ in range(2):
        assert all(
            finding.is_good
            for finding in doctor.examine(course, 1, sandbox, InlineExecutor(1), bar)
        )
    assert len(bars) == 1
    assert steps == [(done, 12) for done in range(13)]


def test_the_doctor_lists_problems(course, sandbox, monkeypatch):
    monkeypatch.setattr(doctor.Rehearsals, "finish", lambda *about: None)
    (course.submitted / "ada" / "lost.ipynb").write_text("{}")
    course.seed_file.write_text("1")
    course.seed_file.chmod(0o644)
    findings = list(doctor.examine(course, 1, sandbox, InlineExecutor(1), progress_bar))
    wrong = {finding.subject: finding.text for finding in findings if not finding.is_good}
    assert "lost.ipynb" in wrong["submitted"] and "chmod 600" in wrong["seed"]
    subjects = [finding.subject for finding in findings]
    for subject in ("packages", "isolation", "disk", "solutions", "sandbox bubblewrap"):
        assert subject in subjects
    python = next(finding.text for finding in findings if finding.subject == "Python")
    version = ".".join(map(str, sys.version_info[:2]))
    assert f"Students may use Python {version} or older." in python


@pytest.mark.parametrize("with_dask", [False, True])
def test_the_doctor_compares_the_version_of_an_installed_dask(monkeypatch, with_dask):
    found = {"rich": "0.1"} | dict.fromkeys(("dask", "distributed"), "0.2" if with_dask else None)

    def version(name, version=metadata.version):
        if name in found and found[name] is None:
            raise metadata.PackageNotFoundError(name)
        return found.get(name) or version(name)

    monkeypatch.setattr(doctor.metadata, "version", version)
    wrong = [finding.text for finding in doctor._examine_versions() if not finding.is_good]
    assert len(wrong) == 1 + with_dask
    assert "rich is 0.1, but should be " in wrong[0]
    assert wrong[0].endswith(". Run: pip install -r requirements.txt")
    if with_dask:
        assert (
            "dask is 0.2, but should be " in wrong[1]
            and "distributed is 0.2, but should be " in wrong[1]
        )
        assert wrong[1].endswith(". Run: pip install -r requirements-cluster.txt")


def test_the_doctor_reports_a_course_that_student_code_could_read(tmp_path, monkeypatch):
    monkeypatch.setattr(doctor, "is_shown", lambda path: path == tmp_path)
    finding = doctor._examine_boundary(Course(tmp_path))
    assert not finding.is_good and str(tmp_path) in finding.text


def test_the_doctor_checks_that_hidden_tests_cannot_be_read(monkeypatch):
    checked = []
    monkeypatch.setattr(doctor, "is_shown", lambda path: checked.append(path))
    assert doctor._examine_boundary(Course()).is_good
    for lesson in all_lessons():
        assert any(lesson.tests.is_relative_to(path) and path.is_dir() for path in checked)


@pytest.mark.slow
def test_visible_checks_run_before_hidden_tests(lesson):
    """Otherwise, a function could store a hidden test's input and reveal it in a visible check."""

    def stub(*arguments, **keywords):
        raise NotImplementedError

    student = SimpleNamespace(**dict.fromkeys(lesson.names, stub), exercise="")
    visible = [outcome.check.is_shown for outcome in run_checks(lesson, student, SEED)]
    assert visible == sorted(visible, reverse=True) and set(visible) == {True, False}
