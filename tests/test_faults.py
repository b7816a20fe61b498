"""No student loses points through faults of the judge, the machine or other students' code."""

import dataclasses
import json
import os
import threading
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor

import pytest

from grader import cli, commands
from grader.classroom import grade, rehearsals
from grader.classroom.executors import EXECUTORS, processor_count
from grader.classroom.pool import Pool
from grader.classroom.protocol import ExecutorLost
from grader.classroom.submissions import find_submissions
from grader.course.kept_answers import answers_to, fill_in
from grader.grading import grade_course
from grader.judging import judge as judging
from grader.judging import program_run
from grader.judging.collection import JudgeFault
from grader.judging.verdict import FAILED, JUDGED, Verdict, read_verdict
from grader.sandbox import SANDBOXES, SandboxUnavailable
from tests.class_of_three import LESSON, RIGHT, SEED, class_of_three, grade_class
from tests.executors import InlineExecutor
from tests.graded_courses import record_rehearsal

WRONG = {
    "voxel_grid": next(answer.source for answer in answers_to("voxel_grid") if not answer.right)
}


@pytest.fixture(autouse=True)
def empty_cache(monkeypatch):
    """Empty the cache of right notebooks, which earlier tests may have filled."""
    monkeypatch.setattr(judging, "_full_mark_decisions", {})


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
    return class_of_three(tmp_path / "course")


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
        return dataclasses.replace(verdict, starved=starved)

    monkeypatch.setattr(grade, "judge_files", starving)
    verdicts = grade_class(course, sandbox)
    assert calls == ["ada", "poison", "zoe", "poison"]
    assert not verdicts["poison"].starved and verdicts["poison"].score == 30
    assert grade_class(course, sandbox) == verdicts and len(calls) == 4


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


def test_verdict_files_have_ordinary_permissions(course, sandbox):
    grade_class(course, sandbox)
    umask = os.umask(0)
    os.umask(umask)
    paths = list(course.verdicts.rglob("*.json"))
    assert paths
    for path in paths:
        assert path.stat().st_mode & 0o777 == 0o666 & ~umask
        assert read_verdict(path) or path.parent.name == ".rehearsed"


def test_workers_must_be_at_least_one(capsys):
    assert processor_count() >= 1
    with pytest.raises(SystemExit) as caught:
        cli.main(["grade", "--workers", "0"])
    assert caught.value.code == 2
    assert "must be at least 1, not" in capsys.readouterr().err
