"""Faults are told apart: what judge, machine or neighbour does costs no student a point."""

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
from grader.classroom.executors import EXECUTORS, processors
from grader.classroom.pool import Pool
from grader.classroom.protocol import ExecutorLost
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.console import progress_bar
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import Course
from grader.judging import judge as judging
from grader.judging import program_run
from grader.judging.runner import JudgeFault, run_checks
from grader.judging.verdict import FAILED, JUDGED, Verdict, read_verdict
from grader.sandbox import SANDBOXES, Limits, SandboxUnavailable, time_budget, usage
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import Program
from grader.sandbox.protocol import Thread
from grader.sandbox.student import StudentProxy
from tests.archives import notebook
from tests.prerequisites import PATIENCE
from tests.test_grade import rehearsed

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
def nothing_was_right_before(monkeypatch):
    """Each test has the judge ask anew: what it remembers is from one before it."""
    monkeypatch.setattr(judging, "_RIGHT", {})


class Inline(Executor):
    """Does everything at once, here, where a test can change what the judge is made of."""

    def __init__(self, workers):
        pass

    def submit(self, function, *arguments):
        future = Future()
        try:
            future.set_result(function(*arguments))
        except Exception as error:
            future.set_exception(error)
        return future


class Deadly(Pool):
    """Its processes die of one student, as often as it is asked, up to a number of times."""

    left = 0

    def submit(self, function, *arguments):
        if function is grade.judge_one and arguments[2] == "poison":
            Deadly.left -= 1
            if Deadly.left >= 0:
                return super().submit(os._exit, 1)
        return super().submit(function, *arguments)


@pytest.fixture
def course(tmp_path):
    """A class of three, all of them right."""
    made = Course(tmp_path / "course")
    for student in ("ada", "poison", "zoe"):
        path = made.submitted / student / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(fill_in(LESSON, RIGHT), "utf-8")
    return made


def graded(course, sandbox, open_executor=Inline, workers=1, progress=lambda *news: None):
    """Verdict of each student."""
    judged = grade.judge_class(course, (), SEED, sandbox, open_executor, workers, progress)
    return {submission.student: verdict for submission, verdict in judged}


def fatten(path):
    """Give a notebook 300 KB of text: more than a pipe holds."""
    notebook = json.loads(path.read_text("utf-8"))
    essay = {"cell_type": "markdown", "id": "essay", "metadata": {}, "source": "A word. " * 38_000}
    notebook["cells"].append(essay)
    path.write_text(json.dumps(notebook), "utf-8")


@pytest.mark.slow
@pytest.mark.death
@pytest.mark.parametrize(("deaths", "status", "score"), [(1, JUDGED, 30), (2, FAILED, 0)])
def test_a_dead_worker_costs_one_retry_of_one_notebook(course, sandbox, deaths, status, score):
    for path in course.submitted.rglob("*.ipynb"):
        fatten(path)
    Deadly.left = deaths
    verdicts = graded(course, sandbox, Deadly, 2)
    assert (verdicts["poison"].status, verdicts["poison"].score) == (status, score)
    if status == FAILED:
        assert "The process that judged died (exit status 1)" in verdicts["poison"].faults[0]
    assert [verdicts[name].score for name in ("ada", "zoe")] == [30, 30]


def test_a_judge_that_fails_takes_no_points_and_keeps_the_reason(course, sandbox, monkeypatch):
    def broken(*question):
        raise JudgeFault("pytest ran 3 of 9 tests")

    right = program_run.run_checks
    monkeypatch.setattr(program_run, "run_checks", broken)
    rehearsed(course, LESSON, SEED)
    verdicts = graded(course, sandbox)
    assert {verdict.status for verdict in verdicts.values()} == {FAILED}
    assert all("not the student's fault" in one.problems[0] for one in verdicts.values())
    assert "pytest ran 3 of 9" in verdicts["ada"].faults[0]
    assert "faults" not in verdicts["ada"].as_dict()  # for whoever grades, not for students
    # The next run tries again.
    monkeypatch.setattr(program_run, "run_checks", right)
    assert {one.score for one in graded(course, sandbox).values()} == {30}


def test_a_fault_is_told_of_an_untouched_notebook_too(monkeypatch):
    def broken(lesson):
        raise JudgeFault("pytest ran 3 of 9 tests")

    monkeypatch.setattr(program_run, "outcomes_of_untouched", broken)
    verdict = judging.judge(LESSON.released, SEED, None)
    assert verdict.status == FAILED and verdict.faults == ("pytest ran 3 of 9 tests",)
    assert judging.UNFAIR in verdict.problems


@pytest.mark.slow
def test_a_fault_of_a_test_is_not_a_wrong_answer(course, sandbox, monkeypatch):
    """An oracle that raises on the reference, too, is ours; one that raises on a claim is not."""
    right = program_run.run_checks

    def spoiled(*question):
        outcomes = right(*question)
        return [type(outcome)(outcome.check, ZeroDivisionError("oracle")) for outcome in outcomes]

    rehearsed(course, LESSON, SEED)
    complaints = judging.complaints_about_reference.__wrapped__  # what it remembers is from here
    monkeypatch.setattr(judging, "complaints_about_reference", complaints)
    monkeypatch.setattr(program_run, "run_checks", spoiled)
    verdict = graded(course, sandbox)["ada"]
    assert verdict.status == FAILED and "ZeroDivisionError: oracle" in verdict.faults[0]
    monkeypatch.setattr(judging, "complaints_about_reference", lambda *about: ())
    verdict = graded(course, sandbox)["ada"]
    assert (verdict.status, verdict.score) == (JUDGED, 0)


def shake_once(monkeypatch):
    """Let some tests end, the first time, as no answer makes them end; what was asked each time."""
    right, asked = program_run.run_checks, []

    def shaken(*question):
        outcomes = right(*question)
        asked.append([outcome.check.name for outcome in outcomes])
        if len(asked) > 1:
            return outcomes
        return [
            type(one)(one.check, OSError("once")) if "columns" in one.check.name else one
            for one in outcomes
        ]

    monkeypatch.setattr(program_run, "run_checks", shaken)
    return asked


@pytest.mark.slow
def test_what_befalls_a_rehearsal_once_is_no_fault_of_a_test(sandbox, monkeypatch):
    asked = shake_once(monkeypatch)
    assert judging.complaints_about_reference.__wrapped__(LESSON, SEED, sandbox) == ()
    assert len(asked) == 2


@pytest.mark.slow
@pytest.mark.parametrize("answers", [RIGHT, RIGHT | WRONG], ids=["right", "wrong"])
def test_what_befalls_the_judge_once_takes_no_points(answers, sandbox, tmp_path, monkeypatch):
    path = tmp_path / f"{LESSON.name}.ipynb"
    path.write_text(fill_in(LESSON, answers), "utf-8")
    expected = judging.judge(path, SEED, sandbox)
    asked = shake_once(monkeypatch)
    judging._RIGHT.clear()
    verdict = judging.judge(path, SEED, sandbox)
    assert (verdict.status, verdict.score) == (JUDGED, expected.score)
    assert verdict.exercises == expected.exercises
    assert len(asked[0]) > 10 > len(asked[1]) > 1  # nothing else is asked again


def test_nobody_is_graded_by_a_test_that_fails_the_solution(course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(rehearsals, "complaints_about_reference", lambda *about: ("voxel_grid, x",))
    with pytest.raises(rehearsals.RehearsalFailed, match="06_filter_ground:\nvoxel_grid, x"):
        graded(course, sandbox)
    assert not list(course.verdicts.rglob("*.json"))
    monkeypatch.setitem(EXECUTORS, "processes", Inline)
    assert commands.grade_course(course, (), SEED, sandbox, 1) == commands.FAULT
    assert "Nobody was graded" in capsys.readouterr().err


def test_rehearsals_are_remembered(course, sandbox, monkeypatch):
    told = []
    graded(course, sandbox, progress=lambda done, total, what: told.append((done, what)))
    assert told[:2] == [(0, None), (0, f"the course's own {LESSON.name} first")]
    monkeypatch.setattr(rehearsals, "complaints_about_reference", lambda *about: ("never asked",))
    (course.submitted / "ada" / LESSON.stage / "helper.py").write_text("x = 1")
    again = graded(course, sandbox, progress=lambda *news: told.append(news))
    assert again["ada"].score == 30 and not isinstance(told[-1][2], str)


@pytest.fixture
def three_lessons(course, monkeypatch):
    """The course with three lessons of each student; what is asked, in its order, and complaints.

    Nothing is judged in earnest.
    """
    for lesson in ("07_filter_by_distance", "08_bounding_boxes"):
        for student in ("ada", "poison", "zoe"):
            (course.submitted / student / LESSON.stage / f"{lesson}.ipynb").write_text("{}")
    asked, complaints = [], {}

    def rehearse_one(lesson, seed, sandbox):
        asked.append(lesson[:2])
        return complaints.get(lesson[:2], ())

    def judge_one(handed_in, lesson, student, seed, sandbox, alone=False):
        asked.append(f"{lesson[:2]} {student}")
        return Verdict(lesson, student, JUDGED, 1.0, 1.0, (), (), 0.0, "")

    monkeypatch.setattr(rehearsals, "rehearse_one", rehearse_one)
    monkeypatch.setattr(grade, "judge_one", judge_one)
    return course, asked, complaints


def judge_three(course, sandbox, open_executor=ThreadPoolExecutor, workers=1):
    return grade.judge_class(course, (), SEED, sandbox, open_executor, workers, lambda *news: None)


def test_the_first_verdict_waits_for_no_other_lesson(three_lessons, sandbox):
    course, asked, _ = three_lessons
    assert len(judge_three(course, sandbox)) == 9
    assert asked == [
        *("06", "06 ada", "06 poison", "06 zoe"),
        *("07", "07 ada", "07 poison", "07 zoe"),
        *("08", "08 ada", "08 poison", "08 zoe"),
    ]
    asked.clear()
    assert len(judge_three(course, sandbox)) == 9  # these verdicts have no key
    assert sorted(asked)[:2] == ["06 ada", "06 poison"] and len(asked) == 9


@pytest.mark.parametrize("workers", [1, 2, 9])
def test_no_lesson_is_judged_whose_own_solution_fails(three_lessons, sandbox, workers):
    course, asked, complaints = three_lessons
    complaints.update({"07": ("one",), "08": ("two", "three")})
    with pytest.raises(rehearsals.RehearsalFailed) as failed:
        judge_three(course, sandbox, workers=workers)
    assert str(failed.value).endswith("07_filter_by_distance:\none\n08_bounding_boxes:\ntwo\nthree")
    assert {what[:2] for what in asked if len(what) > 2} <= {"06"}
    judged = [path.parts[-3] for path in course.verdicts.glob("*/*/06*.json")]
    assert len(judged) == len([what for what in asked if len(what) > 2])  # what was done is kept


# ---- a class that is judged by nobody ----------------------------------------------------------


class Fares:
    """A class of three, who fare as it is said; keeps what was asked and what was told.

    `how` is by student and by the time that it is asked: an error, or what a verdict has.
    """

    def __init__(self, course, **how):
        self.course, self.how = course, how
        self.asked, self.told, self.opened = [], [], []

    def judge_one(self, handed_in, lesson, student, seed, sandbox, alone=False):
        self.asked.append((student, alone))
        time = [name for name, _ in self.asked].count(student)
        fares = self.how.get(student, {}).get(time, {})
        if isinstance(fares, Exception):
            raise fares
        key = grade.verdict_key(handed_in, LESSON, seed, student)
        about = {"key": key, "fingerprint": handed_in.fingerprint()} | fares
        return Verdict(lesson, student, JUDGED, 1.0, 30.0, (), (), 0.0, **about)

    def judged(self, monkeypatch, room=64):
        """Verdict of each, in the order in which they come back."""
        monkeypatch.setattr(grade, "judge_one", self.judge_one)

        class Narrow(Inline):
            def __init__(self, workers):
                self.room = room

        def open_executor(workers):
            self.opened.append(workers)
            return Narrow(workers)

        def tell(done, total, what):
            self.told.append((done, total, getattr(what, "student", what), len(self.asked)))

        judged = grade.judge_class(
            self.course, (), SEED, SANDBOXES["process"], open_executor, 3, tell
        )
        return {submission.student: verdict for submission, verdict in judged}


@pytest.fixture
def seen(course):
    """The class, and its lesson's own solution has been judged before."""
    rehearsed(course, LESSON, SEED)
    return course


def test_who_is_judged_is_counted_and_who_has_been_is_asked_no_more(seen, monkeypatch):
    fares = Fares(seen)
    verdicts = fares.judged(monkeypatch)
    assert list(verdicts) == ["ada", "poison", "zoe"] and fares.opened == [3]
    assert fares.asked == [("ada", False), ("poison", False), ("zoe", False)]
    counted = [(0, 3, None), (1, 3, "ada"), (2, 3, "poison"), (3, 3, "zoe")]
    assert [news[:3] for news in fares.told] == counted
    again = Fares(seen)
    assert again.judged(monkeypatch) == verdicts
    assert (again.asked, again.opened, again.told) == ([], [], [(3, 3, None, 0)])
    seen.verdicts.joinpath("poison", LESSON.stage, f"{LESSON.name}.json").unlink()
    once = Fares(seen)
    assert once.judged(monkeypatch) == verdicts
    assert once.asked == [("poison", False)]
    assert [news[:3] for news in once.told] == [(2, 3, None), (3, 3, "poison")]


@pytest.mark.parametrize("room", [1, 2, 3])
def test_no_more_is_read_ahead_than_there_is_room_for(seen, monkeypatch, room):
    fares = Fares(seen)
    fares.judged(monkeypatch, room)
    assert [asked for *_, asked in fares.told[1:]] == [min(room + one, 3) for one in range(3)]


def test_who_lacked_a_processor_is_judged_once_more_alone(seen, monkeypatch):
    fares = Fares(seen, poison={1: {"starved": True}})
    verdicts = fares.judged(monkeypatch)
    assert fares.asked == [("ada", False), ("poison", False), ("zoe", False), ("poison", True)]
    assert fares.opened == [3, 1] and not verdicts["poison"].starved
    assert [news[:3] for news in fares.told[-2:]] == [(3, 3, "zoe"), (3, 3, "poison")]
    assert Fares(seen).judged(monkeypatch) == verdicts


def test_a_notebook_that_kills_is_tried_once_more_alone(seen, monkeypatch):
    death = BrokenExecutor("The process that judged died (signal 9).")
    fares = Fares(seen, poison={1: death})
    verdicts = fares.judged(monkeypatch)
    assert fares.asked == [("ada", False), ("poison", False), ("zoe", False), ("poison", True)]
    assert {verdict.status for verdict in verdicts.values()} == {JUDGED}
    assert [news[:3] for news in fares.told[-2:]] == [(2, 3, "zoe"), (3, 3, "poison")]
    seen.verdicts.joinpath("poison", LESSON.stage, f"{LESSON.name}.json").unlink()
    verdicts = Fares(seen, poison={1: death, 2: death}).judged(monkeypatch)
    failed = verdicts["poison"]
    assert (failed.status, failed.score, failed.max_score) == (FAILED, 0.0, 30.0)
    assert [(exercise.score, exercise.tests) for exercise in failed.exercises] == [
        (0.0, ()),
        (0.0, ()),
    ]
    assert "died (signal 9)" in failed.faults[0] and failed.problems == (judging.UNFAIR,)
    assert (failed.lesson, failed.student, failed.key) == (LESSON.name, "poison", "")
    assert not failed.starved and failed.seconds == 0.0


@pytest.mark.parametrize("error", [SandboxUnavailable("no"), ExecutorLost("gone")])
def test_where_nothing_judges_any_more_nobody_has_failed(seen, monkeypatch, error):
    with pytest.raises(type(error)):
        Fares(seen, poison={1: error}).judged(monkeypatch)
    kept = [path.parts[-3] for path in seen.verdicts.glob("[!.]*/*/*.json")]
    assert kept == ["ada"]
    assert Fares(seen).judged(monkeypatch)["poison"].status == JUDGED


def test_one_notebook_that_fails_the_judge_stops_no_other(seen, monkeypatch):
    verdicts = Fares(seen, poison={1: ZeroDivisionError("oracle")}).judged(monkeypatch)
    assert [verdict.status for verdict in verdicts.values()] == [JUDGED, FAILED, JUDGED]
    assert "ZeroDivisionError: oracle" in verdicts["poison"].faults[0]
    again = Fares(seen)
    again.judged(monkeypatch)
    assert again.asked == [("poison", False)]


@pytest.mark.parametrize("alone", [False, True])
def test_a_time_limit_is_believed_of_who_had_the_machine_to_itself(course, monkeypatch, alone):
    asked = []

    def starving(*about):
        asked.append(about)
        return Verdict(LESSON.name, "ada", JUDGED, 0.0, 30.0, (), (), 0.0, "", starved=True)

    monkeypatch.setattr(grade, "judge_files", starving)
    (submission, *_) = find_submissions(course)
    verdict = grade.judge_one("a file", LESSON.name, "ada", SEED, "process", alone)
    assert verdict.starved != alone
    assert asked == [("a file", SEED, SANDBOXES["process"], LESSON, "ada")]
    assert grade.judge_one("a file", LESSON.name, "ada", SEED, "process").starved
    walls = SANDBOXES["process"]
    assert not grade.current_verdict(course, submission, SEED, walls).starved
    assert grade.judge_and_store(course, submission, SEED, walls).starved
    assert read_verdict(submission.verdict_path(course)).starved
    assert asked[-1] == (submission.read(course), SEED, walls, LESSON, "ada")


def test_who_has_a_verdict_keeps_it(seen, monkeypatch):
    verdicts = Fares(seen).judged(monkeypatch)
    (submission, *_) = find_submissions(seen)
    walls = SANDBOXES["process"]
    assert grade.current_verdict(seen, submission, SEED, walls) == verdicts["ada"]
    anew = Fares(seen)
    monkeypatch.setattr(grade, "judge_one", anew.judge_one)
    grade.current_verdict(seen, submission, SEED + 1, walls)
    assert anew.asked == [("ada", True)]


class Hesitant(Inline):
    """Rehearses at once, and judges after some seconds, unless it is called off before."""

    def submit(self, function, *arguments):
        if function is rehearsals.rehearse_one:
            return super().submit(function, *arguments)
        future = Future()
        timer = threading.Timer(5, lambda: future.set_result(function(*arguments)))
        future.add_done_callback(lambda _: timer.cancel())
        timer.start()
        return future


def test_who_waits_is_called_off_when_a_rehearsal_fails(three_lessons, sandbox):
    course, asked, complaints = three_lessons
    complaints.update({"07": ("one",)})
    with pytest.raises(rehearsals.RehearsalFailed):
        judge_three(course, sandbox, Hesitant, workers=9)
    assert asked == ["06", "07", "08"] and not list(course.verdicts.glob("*/stage*/*.json"))


class Busy(Inline):
    """Rehearses at once, and is at work on each notebook for a while: nobody can call it off."""

    def submit(self, function, *arguments):
        if function is rehearsals.rehearse_one:
            return super().submit(function, *arguments)
        future = Future()
        future.set_running_or_notify_cancel()
        threading.Timer(0.5, lambda: future.set_result(function(*arguments))).start()
        return future


def test_what_is_at_work_when_a_rehearsal_fails_is_kept(three_lessons, sandbox):
    course, asked, complaints = three_lessons
    complaints.update({"07": ("one",)})
    with pytest.raises(rehearsals.RehearsalFailed):
        judge_three(course, sandbox, Busy, workers=9)
    kept = {path.parts[-3] for path in course.verdicts.glob("*/stage*/*.json")}
    assert {what for what in asked if len(what) > 2} == {f"06 {student}" for student in kept}
    assert kept == {"ada", "poison", "zoe"}


class Dying(ThreadPoolExecutor):
    """The process that lets the solution of 07 be judged dies, up to a number of times."""

    left = 0

    def submit(self, function, *arguments):
        if function is rehearsals.rehearse_one and arguments[0].startswith("07") and Dying.left > 0:
            Dying.left -= 1
            future = Future()
            future.set_exception(BrokenExecutor("The process that judged died (signal 9)."))
            return future
        return super().submit(function, *arguments)


def test_a_process_that_dies_in_a_rehearsal_is_no_fault_of_the_lesson(three_lessons, sandbox):
    course, asked, _ = three_lessons
    Dying.left = 1
    judged = judge_three(course, sandbox, Dying)
    assert {(one.student, one.lesson.number) for one, _ in judged} == {
        (student, number) for student in ("ada", "poison", "zoe") for number in ("06", "07", "08")
    }
    assert len(asked) == 3 + 9
    before = asked[: asked.index("07")]  # once more when nobody else is at work
    assert "08" in before and "06 zoe" in before and "08 ada" not in before


def test_a_rehearsal_that_always_kills_its_process_is_named(three_lessons, sandbox):
    course, _, _ = three_lessons
    Dying.left = 2
    with pytest.raises(
        rehearsals.RehearsalFailed, match="07_filter_by_distance:\nThe process that"
    ):
        judge_three(course, sandbox, Dying)


@pytest.mark.slow
def test_a_starved_notebook_is_tried_again_alone(course, sandbox, monkeypatch):
    asked = []
    right = grade.judge_files

    def starving(handed_in, seed, sandbox, lesson, student):
        asked.append(student)
        verdict = right(handed_in, seed, sandbox, lesson, student)
        starved = student == "poison" and asked.count("poison") == 1
        return type(verdict)(**{**verdict.__dict__, "starved": starved})

    monkeypatch.setattr(grade, "judge_files", starving)
    verdicts = graded(course, sandbox)
    assert asked == ["ada", "poison", "zoe", "poison"]
    assert not verdicts["poison"].starved and verdicts["poison"].score == 30
    assert graded(course, sandbox) == verdicts and len(asked) == 4


@contextlib.contextmanager
def crowded(student, others):
    """Have the student's process share one processor with some that never rest."""
    one = {min(os.sched_getaffinity(0))}
    student._ensure_running()
    os.sched_setaffinity(student._worker.pids[-1], one)
    # In sessions of their own: some kernels share a processor out by session.
    command = [sys.executable, "-c", "while True: pass"]
    busy = [subprocess.Popen(command, start_new_session=True) for _ in range(others)]
    try:
        for process in busy:
            os.sched_setaffinity(process.pid, one)
        yield
    finally:
        for process in busy:
            process.kill()
            process.wait()


NEEDS = """
import time
def f(seconds):
    end = time.process_time() + seconds
    while time.process_time() < end: pass
    return seconds
def wait(seconds): time.sleep(seconds)
"""


@pytest.mark.slow
@pytest.mark.parametrize("others", [1, 3, 7])
def test_who_shares_the_processor_has_as_much_of_it_as_another(sandbox, others):
    """With three at work beside it, who needs 0.9 s of its 1.0 takes 3.6 by the wall's clock."""
    limits = Limits(call_seconds=1.0)
    with (
        StudentProxy(Program((NEEDS,), ("f",)), sandbox, limits) as student,
        crowded(student, others),
    ):
        assert student.f(0.9) == 0.9
        assert not student.starved
        assert student._budget.seconds > limits.total_seconds - 1.5


BRIEFLY = """
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
def test_who_waits_for_threads_or_children_that_wait_for_a_processor_does_not_sleep(sandbox, name):
    """Of what has ended nobody tells how long it was kept waiting; 0.6 s of 2.5 are needed."""
    program, limits = Program((BRIEFLY,), (name,)), Limits(call_seconds=2.5)
    with StudentProxy(program, sandbox, limits) as student, crowded(student, 5):
        assert getattr(student, name)() is None
        assert not student.starved


@pytest.mark.slow
def test_who_works_too_long_is_given_up_on_a_crowded_machine_and_not_called_starved(sandbox):
    limits = Limits(call_seconds=0.5)
    with StudentProxy(Program((NEEDS,), ("f",)), sandbox, limits) as student, crowded(student, 3):
        with pytest.raises(StudentStopped, match="did not answer within 0.5 seconds"):
            student.f(60)
        assert not student.starved


@pytest.mark.slow
def test_whom_the_walls_clock_gives_up_first_is_called_starved(sandbox):
    """It gets an eighth of a processor, where it could have needed more."""
    limits = Limits(call_seconds=8.0, wall_seconds=4.0)
    with StudentProxy(Program((NEEDS,), ("f",)), sandbox, limits) as student, crowded(student, 7):
        with pytest.raises(StudentStopped, match="4 seconds by the clock on the wall"):
            student.f(6)
        assert student.starved
        with pytest.raises(StudentStopped, match="Not tried: the notebook's 4 seconds"):
            student.f(0)


@pytest.mark.slow
def test_who_sleeps_is_given_up_as_soon_as_who_works_and_not_called_starved(sandbox):
    program = Program((NEEDS,), ("f", "wait"))
    for name in ("f", "wait"):
        with StudentProxy(program, sandbox, Limits(call_seconds=0.5)) as student:
            begin = time.monotonic()
            with pytest.raises(StudentStopped, match="did not answer"):
                getattr(student, name)(60)
            assert not student.starved
            assert student._budget.seconds == pytest.approx(179.4, abs=0.5)
            assert name == "f" or time.monotonic() - begin < PATIENCE


@pytest.mark.slow
def test_where_nobody_tells_who_waits_all_have_longer_and_are_starved(sandbox, monkeypatch):
    monkeypatch.setattr(usage, "_tells_delays", lambda: False)
    program = Program((NEEDS,), ("f", "wait"))
    with StudentProxy(program, sandbox, Limits(call_seconds=0.5)) as student:
        assert student.f(0.1) == 0.1
        student.wait(0.8)  # perhaps others were at work
        with pytest.raises(StudentStopped, match="did not answer"):
            student.wait(60)
        assert student.starved


class Pretended:
    """A worker of which only is told what it takes."""

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
        (1.0, 0.4, {1: 3.6, 2: 5.0}, 0.4),  # others were at work, too
        (1.0, 0.0, {1: 3.0, 2: 5.0}, 1.0),  # it slept
        (1.0, 0.1, {1: 3.2, 2: 5.2, 4: 0.3}, 0.7),  # threads that wait for each other
        (1.0, 2.0, {1: 3.0, 2: 5.0}, 2.0),  # several at once
        (3.0, 0.1, {1: 5.9, 2: 5.0}, 0.1),
        (0.06, 0.0, {1: 3.05, 2: 5.0}, 0.01),  # the clock of the kernel has not ticked yet
    ],
)
def test_a_call_takes_what_passes_while_nobody_keeps_it_waiting(
    waited, worked, delayed, seconds, monkeypatch
):
    now, worker = [100.0], Pretended()
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "seconds_of_our_own", lambda: 0.0)
    meter = time_budget.Meter(worker)
    now[0] += waited
    worker.worked, worker.delayed = worker.worked + worked, delayed
    meter.look(answered=True)
    assert meter.seconds == pytest.approx(seconds)


def test_while_we_read_an_answer_nobody_sleeps(monkeypatch):
    now, ours = [100.0], [2.0]
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "seconds_of_our_own", lambda: ours[0])
    meter = time_budget.Meter(Pretended())
    now[0] += 1.0
    ours[0] += 0.6
    meter.look(answered=True)
    assert meter.seconds == pytest.approx(0.4)


def test_who_is_ready_to_run_does_not_sleep(monkeypatch):
    """Of threads and children that have ended, nobody tells how long they were kept waiting."""
    now, ours, worker = [100.0], [2.0], Pretended()
    monkeypatch.setattr(time_budget.time, "monotonic", lambda: now[0])
    monkeypatch.setattr(time_budget, "seconds_of_our_own", lambda: ours[0])
    meter = time_budget.Meter(worker)
    for ready, worked, passed, at_work, taken in (
        (True, 0.1, 1.0, 0.0, 0.1),  # the others had the rest
        (False, 0.0, 0.5, 0.2, 0.4),  # it slept, but while we were at work
        (True, 0.2, 0.4, 0.0, 0.6),
        (True, 0.3, 1.0, 0.0, 0.9),
    ):
        worker.ready, worker.worked = ready, worker.worked + worked
        now[0] += passed
        ours[0] += at_work
        meter.look()
        assert meter.seconds == pytest.approx(taken)
    # Who has answered is at rest now, and slept before as often as was found.
    worker.ready = False
    now[0] += 1.0
    meter.look(answered=True)
    assert meter.seconds == pytest.approx(0.9 + 0.3 / 2.7)


@pytest.mark.slow
def test_who_sleeps_takes_time_and_who_waits_for_a_processor_does_not(sandbox):
    with StudentProxy(Program((NEEDS,), ("f", "wait")), sandbox) as student:
        # Sleep is told by looking now and then; beside others, some of it passes for waiting.
        assert student.wait.timed(1)[1] > 0.3
        with crowded(student, 11):
            assert student.f.timed(0.3)[1] < 1.8  # by the wall's clock, 3.6
        assert not student.starved


@pytest.mark.slow
def test_time_is_counted_wherever_the_work_is_done(sandbox):
    with StudentProxy(Program((WORK,), ("work", "delegate", "wait")), sandbox) as student:
        own = student.work.timed()[1]
        assert student.delegate.timed()[1] > own / 2 > 0.02
        assert 0.5 < student.wait.timed()[1] < 3


@pytest.mark.slow
def test_a_folder_whose_name_is_no_text_stops_nobody(course, sandbox, capsys):
    from grader.console import print_class
    from grader.lms.report import write_report

    name = os.fsdecode(b"J\xfcrgen")  # as old zips have it
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
    verdicts = graded(course, sandbox)
    assert verdicts["ada"].score == 30
    for name in ("thief", "twin"):
        assert verdicts[name].score == 0
        assert "link to another folder" in verdicts[name].problems[0]


def test_verdicts_can_be_read_by_fellow_graders(course, sandbox):
    graded(course, sandbox)
    umask = os.umask(0)
    os.umask(umask)
    for path in course.verdicts.rglob("*.json"):
        assert path.stat().st_mode & 0o777 == 0o666 & ~umask
        assert read_verdict(path) or path.parent.name == ".rehearsed"


def test_at_least_one_worker(capsys):
    assert processors() >= 1
    with pytest.raises(SystemExit) as caught:
        cli.main(["grade", "--workers", "0"])
    assert caught.value.code == 2
    assert "at least one" in capsys.readouterr().err


def test_every_file_is_accounted_for(course):
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
        "it is no notebook: 08_bounding_boxes.ipynb, as Jupyter saves it, would be judged",
        "it is no notebook: 06_filter_ground.ipynb, as Jupyter saves it, would be judged",
        "it is packed: python -m grader collect 'submitted/ada/stage3_obstacles/my work.zip' "
        "--stage stage3_obstacles --who 'my work=ada', and delete it",
        "01_point_clouds belongs to stage1_ransac: move it to ada/stage1_ransac/",
        "it does not lie in <student>/<stage>/: move it to ada/stage3_obstacles/",
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
        "8 final.ipynb",  # and what it says inside
    ],
)
def test_a_renamed_file_is_recognised_and_said_to_be(course, name):
    stage = course.submitted / "eve" / LESSON.stage
    (stage / name).parent.mkdir(parents=True)
    (stage / name).write_bytes(notebook(LESSON.name))
    (found,) = [
        submission for submission in find_submissions(course) if submission.student == "eve"
    ]
    notes = found.read(course).notes
    assert bool(notes) == (found.path.name != "06_filter_ground.ipynb")
    assert unaccounted_files(course) == []


def test_of_several_files_the_newest_counts(course):
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
    os.utime(stage / "06_filter_ground.ipynb", (1000, 1000))  # then the number of the copy says
    (found,) = [one for one in find_submissions(course) if one.student == "eve"]
    assert found.path.name == "06_filter_ground (2).ipynb"
    assert unaccounted_files(course) == []


def test_the_doctor_shows_how_far_the_solutions_are(course, sandbox, monkeypatch):
    """And nothing of the kind where they were seen before."""
    # Whether this machine can build a sandbox is another finding.
    monkeypatch.setattr(doctor, "_sandboxes", lambda: ())
    monkeypatch.setattr(doctor, "_versions", lambda: ())
    seen, bars = [], []
    monkeypatch.setattr(rehearsals, "rehearse_one", lambda *about: ())

    @contextlib.contextmanager
    def bar(title):
        bars.append(title)
        yield lambda done, total, what: seen.append((done, total))

    for _ in range(2):
        assert all(one.good for one in doctor.examine(course, 1, sandbox, Inline(1), bar))
    assert len(bars) == 1
    assert seen == [(done, 12) for done in range(13)]


def test_the_doctor_names_what_is_wrong(course, sandbox, monkeypatch):
    monkeypatch.setattr(doctor.Rehearsals, "finish", lambda *about: None)
    (course.submitted / "ada" / "lost.ipynb").write_text("{}")
    course.seed_file.write_text("1")
    course.seed_file.chmod(0o644)
    findings = list(doctor.examine(course, 1, sandbox, Inline(1), progress_bar))
    wrong = {finding.subject: finding.text for finding in findings if not finding.good}
    assert "lost.ipynb" in wrong["submitted"] and "chmod 600" in wrong["seed"]
    subjects = [finding.subject for finding in findings]
    for subject in ("Python", "packages", "boundary", "disk", "oracles", "sandbox bubblewrap"):
        assert subject in subjects


@pytest.mark.parametrize("with_dask", [False, True])
def test_the_doctor_compares_dask_where_it_is(monkeypatch, with_dask):
    found = {"rich": "0.1"} | dict.fromkeys(("dask", "distributed"), "0.2" if with_dask else None)

    def version(name, version=metadata.version):
        if name in found and found[name] is None:
            raise metadata.PackageNotFoundError(name)
        return found.get(name) or version(name)

    monkeypatch.setattr(doctor.metadata, "version", version)
    wrong = [finding.text for finding in doctor._versions() if not finding.good]
    assert len(wrong) == 1 + with_dask
    assert "rich 0.1 instead of " in wrong[0]
    assert wrong[0].endswith(". Run: pip install -r requirements.txt")
    if with_dask:
        assert "dask 0.2 instead of " in wrong[1] and "distributed 0.2 instead of " in wrong[1]
        assert wrong[1].endswith(". Run: pip install -r requirements-cluster.txt")


def test_the_doctor_sees_a_course_that_student_code_could_read(tmp_path, monkeypatch):
    monkeypatch.setattr(doctor, "is_shown", lambda path: path == tmp_path)
    finding = doctor._boundary(Course(tmp_path))
    assert not finding.good and str(tmp_path) in finding.text


def test_the_doctor_looks_whether_hidden_tests_could_be_read(monkeypatch):
    looked_at = []
    monkeypatch.setattr(doctor, "is_shown", lambda path: looked_at.append(path))
    assert doctor._boundary(Course()).good
    for lesson in all_lessons():
        assert any(lesson.tests.is_relative_to(path) and path.is_dir() for path in looked_at)


@pytest.mark.slow
def test_what_shows_students_words_is_asked_before_any_hidden_question(lesson):
    """Else a function could keep a hidden question, and tell it in a check that is shown."""

    def stub(*arguments, **keywords):
        raise NotImplementedError

    student = SimpleNamespace(**dict.fromkeys(lesson.names, stub), exercise="")
    visible = [outcome.check.is_shown for outcome in run_checks(lesson, student, SEED)]
    assert visible == sorted(visible, reverse=True) and set(visible) == {True, False}
