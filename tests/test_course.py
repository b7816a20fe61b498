"""A whole course, from release to export, with the real commands and faults at every step."""

import csv
import errno
import functools
import hashlib
import json
import os
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time

import pytest

from grader import cli, commands, grading
from grader.classroom.executors import EXECUTORS
from grader.classroom.lock import AlreadyRunning, course_lock
from grader.course import paths
from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT, Course
from grader.lms import gradebook_writer
from grader.lms.late import PercentPerDay
from tests.damaged_notebooks import EARNS_EVERYTHING, changed_notebook
from tests.executors import InlineExecutor
from tests.gradebooks import gradebook_rows, penalties
from tests.graded_courses import (
    REPORT,
    SEED,
    WRITTEN_LESSON,
    answered_notebook,
    enter_manual_mark,
    entered_scores,
    gradebook_of,
    judge_course,
    make_course,
    record_rehearsal,
    run_nbgrader,
    with_report,
)
from tests.postgresql import NotInstalled, server
from tests.prerequisites import PATIENCE

LESSON = find_lesson("06_filter_ground")
STAGES = (LESSON.stage, WRITTEN_LESSON.stage)


def submit(course, student, lesson, text, when=None, name=None):
    path = course.submitted / student / lesson.stage / (name or f"{lesson.name}.ipynb")
    path.parent.mkdir(parents=True, exist_ok=True)
    if isinstance(text, str):
        text = text.encode()
    path.write_bytes(text)
    if when:
        (path.parent / "timestamp.txt").write_text(when)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory, sandbox):
    """Judge two students once; all copies of the course can use the verdicts."""
    texts = {"ada": answered_notebook(), "bob": answered_notebook("voxel_grid")}
    course = make_course(tmp_path_factory.mktemp("judged") / "course", LESSON, texts, sandbox)
    judge_course(course, sandbox)
    return course.verdicts


@pytest.fixture
def course(tmp_path, sandbox, monkeypatch, verdicts):
    """Return a course of two lessons, with verdicts on the submissions of two students."""
    course = make_course(tmp_path / "course", LESSON, {"ada": answered_notebook()}, sandbox)
    for folder in ("solutions", "notebooks"):
        (course.root / folder / WRITTEN_LESSON.stage).mkdir()
    shutil.copy(WRITTEN_LESSON.solved, course.root / "solutions" / WRITTEN_LESSON.stage)
    shutil.copy(WRITTEN_LESSON.released, course.root / "notebooks" / WRITTEN_LESSON.stage)
    record_rehearsal(course, WRITTEN_LESSON)
    submit(course, "bob", LESSON, answered_notebook("voxel_grid"))
    shutil.copytree(verdicts, course.verdicts, dirs_exist_ok=True)
    monkeypatch.setitem(EXECUTORS, "processes", InlineExecutor)
    paths._folder.cache_clear()
    return course


def grade(course, sandbox, stages=()):
    return grading.grade_course(course, stages, SEED, sandbox, 1)


def configure(course, *lines):
    path = course.root / "nbgrader_config.py"
    path.write_text(path.read_text() + "\n" + "\n".join(lines) + "\n")
    paths._folder.cache_clear()


def file_digests(folder):
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def report_of(course):
    """Return the report's HTML without dates, durations and counts of judged notebooks."""
    page = (course.report / "index.html").read_text()
    page = re.sub(r"<h2>Slowest notebooks</h2>.*?</table>", "", page, flags=re.DOTALL)
    page = re.sub(r" \([^)]*judged [^)]*\)", "", page)  # notebooks judged now and earlier
    return re.sub(r"\d+ \w+ \d{4}, \d\d:\d\d|\b\d+(\.\d)?(?: |&nbsp;)s(econds)?\b", "", page)


def set_due(course, stage, when):
    with gradebook_of(course) as book:
        book.update_or_create_assignment(stage, duedate=when)


def mark_of(course, student):
    with gradebook_of(course) as book:
        grade = book.find_grade("write_up", WRITTEN_LESSON.name, WRITTEN_LESSON.stage, student)
        return grade.manual_score, grade.needs_manual_grade


@pytest.mark.slow
def test_a_course_runs_from_release_to_export(course, sandbox, capsys, monkeypatch):
    for stage in STAGES:
        made = run_nbgrader(course, "generate_assignment", stage, "--force")
        assert made.returncode == 0, made.stderr
    released = file_digests(course.root / "notebooks")
    configure(
        course,
        "c.AssignLatePenalties.plugin_class = 'grader.lms.late.PercentPerDay'",
        "c.PercentPerDay.percent = 10",
        "c.PercentPerDay.grace_minutes = 30",
    )
    for number, (name, (change, _)) in enumerate(EARNS_EVERYTHING.items()):
        submit(
            course,
            f"spoilt{number:02} {name[:30].replace('/', ' ')}",
            LESSON,
            changed_notebook(change),
        )
    submit(course, "carol", LESSON, answered_notebook(), "2026-11-03 12:00:00 UTC")
    submit(course, "dave", LESSON, answered_notebook(), "2026-11-01 12:20:00 UTC")
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT))
    submit(course, "frank", LESSON, answered_notebook(), name="Copy of 06_filter_ground (1).ipynb")
    submit(course, "gina", LESSON, "not a notebook", name="06_filter_ground.py")
    set_due(course, LESSON.stage, "2026-11-01 12:00:00 UTC")

    assert grade(course, sandbox) == commands.SUCCESS
    output = capsys.readouterr().out
    assert (
        "1 file was not judged:" in output and "06_filter_ground.py: it is not a notebook" in output
    )
    assert file_digests(course.root / "notebooks") == released
    scores = entered_scores(course)
    for student in {student for student, _, _ in scores} - {"bob", "erin", "carol"}:
        assert scores[student, LESSON.stage, LESSON.name] == 30, student
    # Carol is two days late after half an hour of grace, so she loses 20 % of 30 points.
    assert penalties(course) == {"carol": pytest.approx(2 * 3.0)}
    before = gradebook_rows(course)

    assert grade(course, sandbox) == commands.SUCCESS
    # Six students submitted one notebook each, in addition to the damaged notebooks.
    assert f"{len(EARNS_EVERYTHING) + 6} unchanged" in capsys.readouterr().out
    assert gradebook_rows(course) == before

    # Carol's due date moves, Bob submits again, and Erin gets a mark.
    set_due(course, LESSON.stage, "2026-11-09 12:00:00 UTC")
    submit(course, "bob", LESSON, answered_notebook())
    enter_manual_mark(course, "erin", 8)
    assert grade(course, sandbox) == commands.SUCCESS
    assert penalties(course) == {}
    assert entered_scores(course)["bob", LESSON.stage, LESSON.name] == 30
    assert mark_of(course, "erin") == (8, False)

    # The mark stays if other text changes. If the answer changes, a person must grade it again.
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT).replace("# 12 ·", "# Mine: 12 ·"))
    assert grade(course, sandbox, [WRITTEN_LESSON.stage]) == commands.SUCCESS
    assert mark_of(course, "erin") == (8, False)
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT + " And the tram."))
    assert grade(course, sandbox, [WRITTEN_LESSON.stage]) == commands.SUCCESS
    assert mark_of(course, "erin") == (8, True)

    # If points in the gradebook differ from the release, grading restores them.
    base = sqlite3.connect(course.root / "gradebook.db")
    base.execute("update grade_cells set max_score = 7")
    base.commit()
    base.close()
    assert grade(course, sandbox) == commands.SUCCESS
    assert {row[7] for row in gradebook_rows(course)[0]} == {5, 10, 20}

    feedback = run_nbgrader(course, "generate_feedback", WRITTEN_LESSON.stage)
    assert feedback.returncode == 0, feedback.stderr
    page = (
        course.root / "feedback" / "erin" / WRITTEN_LESSON.stage / f"{WRITTEN_LESSON.name}.html"
    ).read_text()
    assert "And the tram" in page
    feedback = run_nbgrader(course, "generate_feedback", LESSON.stage)
    assert feedback.returncode == 0, feedback.stderr
    monkeypatch.setattr(commands, "Course", lambda: course)
    assert cli.main(["export"]) == commands.SUCCESS
    with (course.root / "scores.csv").open(newline="", encoding="utf-8-sig") as file:
        exported = {row["Student"]: row for row in csv.DictReader(file)}
    assert exported["carol"][LESSON.name] == exported["carol"]["Total"] == "30"
    assert (exported["erin"][LESSON.name], exported["erin"][WRITTEN_LESSON.name]) == ("", "13")
    assert exported["erin"][f"{WRITTEN_LESSON.stage}: status"] == f"waiting: {WRITTEN_LESSON.name}"
    assert file_digests(course.root / "notebooks") == released


@pytest.mark.slow
def test_a_deleted_gradebook_is_written_again(course, sandbox):
    assert grade(course, sandbox) == commands.SUCCESS
    before = gradebook_rows(course)
    (course.root / "gradebook.db").unlink()
    assert grade(course, sandbox) == commands.SUCCESS
    assert gradebook_rows(course) == before


@pytest.mark.slow
def test_withdrawn_work_is_removed_but_manual_marks_remain(course, sandbox, capsys):
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT))
    assert grade(course, sandbox) == commands.SUCCESS
    enter_manual_mark(course, "erin", 8)
    shutil.rmtree(course.submitted / "bob")
    shutil.rmtree(course.submitted / "erin")
    assert grade(course, sandbox, [LESSON.stage]) == commands.SUCCESS
    assert {student for student, _, _ in entered_scores(course)} == {"ada", "erin"}
    assert not (course.autograded / "bob" / LESSON.stage).exists()
    assert grade(course, sandbox) == commands.FAULT
    assert "grader's marks or comments" in capsys.readouterr().err
    assert mark_of(course, "erin") == (8, False)


@pytest.mark.slow
def test_a_difference_in_the_gradebook_is_repaired_or_reported(
    course, sandbox, monkeypatch, capsys
):
    assert grade(course, sandbox) == commands.SUCCESS
    before = gradebook_rows(course)
    base = sqlite3.connect(course.root / "gradebook.db")
    base.execute("update grade set auto_score = 1")
    base.commit()
    base.close()
    assert grade(course, sandbox) == commands.SUCCESS
    assert gradebook_rows(course) == before
    monkeypatch.setattr(gradebook_writer, "_save", lambda *anything: None)
    (course.root / "gradebook.db").unlink()
    assert grade(course, sandbox) == commands.FAULT
    errors = capsys.readouterr().err
    assert "ada, stage3_obstacles, 06_filter_ground: test_filter_ground has None points" in errors
    assert "instead of 20" in errors


@pytest.mark.slow
def test_an_unreadable_time_is_reported(course, sandbox, capsys):
    submit(course, "ada", LESSON, answered_notebook(), when="yesterday, I think")
    set_due(course, LESSON.stage, "2026-11-01 12:00:00 UTC")
    assert grade(course, sandbox) == commands.SUCCESS
    output = capsys.readouterr()
    assert "The gradebook is not complete" not in output.err
    assert "ada, stage3_obstacles: timestamp.txt has 'yesterday, I think', which" in output.out
    assert entered_scores(course)["ada", LESSON.stage, LESSON.name] == 30


@pytest.mark.slow
def test_settings_of_the_course_are_used(course, sandbox):
    configure(
        course,
        "c.CourseDirectory.db_url = 'sqlite:///" + str(course.root / "elsewhere.db") + "'",
        "c.CourseDirectory.submitted_directory = 'inbox'",
        "c.CourseDirectory.autograded_directory = 'outbox'",
    )
    (course.root / "submitted").rename(course.root / "inbox")
    assert grade(course, sandbox) == commands.SUCCESS
    assert (course.root / "elsewhere.db").exists()
    assert not (course.root / "gradebook.db").exists()
    assert (course.root / "outbox" / "ada" / LESSON.stage / f"{LESSON.name}.ipynb").exists()
    assert entered_scores(course)["ada", LESSON.stage, LESSON.name] == 30


@pytest.fixture
def postgresql():
    """Yield the address of an empty database on a new server; skip without PostgreSQL."""
    try:
        with server() as address:
            yield address
    except NotInstalled as error:
        pytest.skip(str(error))


@pytest.mark.slow
def test_the_gradebook_may_be_on_a_server(course, sandbox, postgresql, capsys):
    configure(course, f"c.CourseDirectory.db_url = {postgresql!r}")
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT))
    assert grade(course, sandbox) == commands.SUCCESS
    output = capsys.readouterr().out
    assert "postgresql+pg8000://teacher:***@" in output and "secret" not in output
    enter_manual_mark(course, "erin", 8)
    submit(course, "bob", LESSON, answered_notebook())
    assert grade(course, sandbox) == commands.SUCCESS
    assert entered_scores(course)["bob", LESSON.stage, LESSON.name] == 30
    assert mark_of(course, "erin") == (8, False)
    assert not (course.root / "gradebook.db").exists()


@pytest.mark.parametrize(
    "late, points", [(0, 0), (60, 0), (601, 3), (86_400, 3), (86_401, 6), (10**8, 15)]
)
def test_the_late_penalty_grows_by_the_day(late, points):
    plugin = PercentPerDay(percent=10, grace_minutes=10, most_percent=50)
    assert (plugin.late_submission_penalty("ada", 30.0, late) or 0) == pytest.approx(points)


@pytest.mark.slow
def test_a_second_run_is_refused_while_the_first_runs(course, sandbox):
    refusal = f"process {os.getpid()}.*run the command again"
    with course_lock(course), pytest.raises(AlreadyRunning, match=refusal) as refused:
        grade(course, sandbox)
    assert refused.value.exit_status == commands.FAULT
    assert grade(course, sandbox) == commands.SUCCESS
    with course_lock(course), pytest.raises(AlreadyRunning), course_lock(course):
        pass


@pytest.mark.slow
def test_partial_files_of_an_earlier_run_are_removed(course, sandbox):
    for folder in (course.verdicts / "ada", course.report):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "x.part").write_text("half")
    for name in (".stage3_obstacles.part", ".stage3_obstacles.old"):
        (course.autograded / "ada" / name).mkdir(parents=True)
        (course.autograded / "ada" / name / "06_filter_ground.ipynb").write_text("{}")
    assert grade(course, sandbox) == commands.SUCCESS
    assert not list(course.root.rglob("*.part")) and not list(course.root.rglob("*.old"))


@pytest.mark.slow
@pytest.mark.parametrize("writes", [0, 1, 2, 3, 4, 5])
def test_a_full_disk_is_reported_and_loses_nothing(writes, course, sandbox, monkeypatch, capsys):
    """The disk is full after `writes` files: verdicts, fingerprints or the report."""
    left, replace = [writes], os.replace

    def replace_until_full(*arguments):
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return replace(*arguments)

    shutil.rmtree(course.verdicts)  # includes the record of the rehearsal
    monkeypatch.setattr(commands, "Course", lambda: course)
    call = ["grade", "--seed", str(SEED), "--sandbox", sandbox.name]
    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", replace_until_full)
        assert cli.main(call) == commands.FAULT
    assert "No space left" in (errors := capsys.readouterr().err) or "The disk is full" in errors
    assert cli.main(call) == commands.SUCCESS
    assert entered_scores(course)["ada", LESSON.stage, LESSON.name] == 30
    assert not list(course.root.rglob("*.part"))


@pytest.mark.slow
def test_students_may_have_unusual_names(course, sandbox):
    for name in ("[red]", "s*", "a b", "Ünal", "x'y", "..."):
        submit(course, name, LESSON, answered_notebook())
    deep = json.loads(answered_notebook())
    deep["metadata"]["a"] = functools.reduce(lambda inner, _: {"a": inner}, range(620), 1)
    submit(course, "deep", LESSON, json.dumps(deep))
    pipe = course.submitted / "pipe" / LESSON.stage / f"{LESSON.name}.ipynb"
    pipe.parent.mkdir(parents=True)
    os.mkfifo(pipe)
    os.mkfifo(course.submitted / "ada" / LESSON.stage / "another pipe")
    assert grade(course, sandbox) == commands.SUCCESS
    assert entered_scores(course)["deep", LESSON.stage, LESSON.name] == 30
    assert entered_scores(course)["pipe", LESSON.stage, LESSON.name] == 0
    assert entered_scores(course)["ada", LESSON.stage, LESSON.name] == 30
    assert entered_scores(course)["[red]", LESSON.stage, LESSON.name] == 30
    assert entered_scores(course)["s*", LESSON.stage, LESSON.name] == 30


# ---- Killed at any time -------------------------------------------------------------------


def run_in_a_child(course, sandbox, after, number):
    """Grade in a child process, and send it a signal if it still runs after `after` seconds.

    Return "killed" if the signal ended the process, and otherwise "ended".
    """
    child = os.fork()
    if not child:
        code = 99
        try:
            os.setpgid(0, 0)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            sys.stdout = sys.stderr = open(os.devnull, "w")  # noqa: SIM115
            code = grade(course, sandbox)
        finally:
            os._exit(code)
    deadline = time.monotonic() + after
    while time.monotonic() < deadline:
        if os.waitpid(child, os.WNOHANG)[0]:
            return "ended"
        time.sleep(0.001)
    os.kill(child, number)
    os.waitpid(child, 0)
    return "killed"


@pytest.mark.death
@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=lambda number: number.name)
@pytest.mark.parametrize("moments", [5, 50], ids=["five", "fifty"])
def test_a_killed_run_is_completed_by_the_same_command(course, sandbox, number, moments):
    """The signals arrive while the run is judging, entering marks or writing the report."""
    for student in ("carol", "dave"):
        submit(course, student, LESSON, answered_notebook("voxel_grid"))
    submit(course, "erin", WRITTEN_LESSON, with_report(REPORT))
    start = time.monotonic()
    assert grade(course, sandbox) == commands.SUCCESS
    cold = time.monotonic() - start
    expected, released = gradebook_rows(course), file_digests(course.root / "notebooks")
    copies, report = file_digests(course.autograded), report_of(course)
    start = time.monotonic()
    (course.root / "gradebook.db").unlink()
    shutil.rmtree(course.autograded)
    assert grade(course, sandbox) == commands.SUCCESS
    warm = time.monotonic() - start

    rng = random.Random(int(number))
    killed = 0
    for turn in range(moments):
        judge = turn % 10 == 0
        if judge:  # without verdicts, so that the run judges again
            shutil.rmtree(course.verdicts)
            record_rehearsal(course, WRITTEN_LESSON)
        if turn % 5 == 1:
            (course.root / "gradebook.db").unlink(missing_ok=True)
        shutil.rmtree(course.autograded / "ada", ignore_errors=True)
        after = rng.uniform(0, cold if judge else warm)
        killed += run_in_a_child(course, sandbox, after, number) == "killed"
        assert file_digests(course.root / "notebooks") == released
        if turn % 5 == 4:
            assert grade(course, sandbox) == commands.SUCCESS
            assert gradebook_rows(course) == expected
            assert file_digests(course.autograded) == copies
            assert report_of(course) == report
            assert not list(course.root.rglob("*.part"))
    assert killed > 0.1 * moments  # on a busy machine, the first run may have taken twice as long


@pytest.mark.death
@pytest.mark.slow
def test_workers_end_with_their_parent_process(tmp_path):
    code = (
        "import os, signal\n"
        "from grader.classroom.pool import Pool\n"
        "if __name__ == '__main__':\n"
        "    with Pool(2) as pool:\n"
        "        print(*{pool.submit(os.getpid).result() for _ in range(20)}, flush=True)\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    (tmp_path / "main.py").write_text(code)
    done = subprocess.run(
        [sys.executable, tmp_path / "main.py"],
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
    )
    workers = [int(word) for word in done.stdout.split()]
    assert workers
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and any(
        os.path.exists(f"/proc/{worker}") for worker in workers
    ):
        time.sleep(0.05)
    assert not any(os.path.exists(f"/proc/{worker}") for worker in workers)


@pytest.mark.slow
def test_two_runs_at_once_end_cleanly(course, sandbox):
    code = (
        "import sys; from pathlib import Path; from grader import cli, commands;"
        "from grader.course.paths import Course;"
        f"commands.Course = lambda: Course(Path({str(course.root)!r}));"
        f"sys.exit(cli.main(['grade', '--seed={SEED}', '--sandbox={sandbox.name}', '--workers=1']))"
    )
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", code],
            cwd=PROJECT,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        for _ in range(2)
    ]
    outputs = [run.communicate()[0] for run in runs]
    assert sorted(run.returncode for run in runs) in ([0, 0], [0, 1]), outputs
    for text, run in zip(outputs, runs, strict=True):
        assert run.returncode == 0 or "Another run is grading" in text
        assert "Traceback" not in text
    assert entered_scores(course)["ada", LESSON.stage, LESSON.name] == 30
    assert Course(course.root).report.joinpath("index.html").exists()
    assert json.loads(next(course.verdicts.rglob("06*.json")).read_text())
