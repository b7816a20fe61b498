"""Grading on a Dask cluster produces the same gradebook as local grading, or can be resumed.

Dask's own command starts schedulers and workers in an empty folder, without the course.
"""

import contextlib
import dataclasses
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from concurrent.futures import BrokenExecutor
from io import BytesIO
from types import SimpleNamespace

import distributed
import pytest

from grader import cli, commands, grading
from grader.classroom import cluster, grade
from grader.classroom.executors import EXECUTORS
from grader.classroom.lock import course_lock
from grader.classroom.protocol import ExecutorLost, capacity
from grader.course.kept_answers import answers_to, fill_in
from grader.course.paths import Course
from grader.course.portable_files import FOLDERS
from grader.judging.verdict import read_verdict
from tests.executors import InlineExecutor
from tests.gradebooks import gradebook_rows, ignore_progress
from tests.graded_courses import (
    LESSON,
    SEED,
    answered_notebook,
    make_course,
    record_rehearsal,
)
from tests.prerequisites import without_bubblewrap

# Only one cluster runs at a time, because each uses all processors.
pytestmark = pytest.mark.xdist_group("cluster")
PATIENCE = 240


# ---- A class and its expected results ----------------------------------------------------------


@pytest.fixture(scope="module")
def local_run(tmp_path_factory, sandbox):
    """Grade a class on this machine; return its folder, verdicts and gradebook rows."""
    texts = {
        "broken": answered_notebook()[:5000],
        "half": answered_notebook("filter_ground"),
        "other": answered_notebook("voxel_grid"),
        "right": answered_notebook(),
        "untouched": fill_in(LESSON, {}),
    }
    course = make_course(tmp_path_factory.mktemp("local") / "course", LESSON, texts, sandbox)
    assert grading.grade_course(course, (), SEED, sandbox, 1) == commands.SUCCESS
    return SimpleNamespace(root=course.root, verdicts=verdicts_of(course), rows=marks(course))


@pytest.fixture
def course(tmp_path, local_run):
    """Return a copy of the class that has not been graded yet."""
    course = Course(tmp_path / "course")
    shutil.copytree(local_run.root, course.root)
    for folder in ("verdicts", "autograded", "report"):
        shutil.rmtree(course.root / folder)
    (course.root / "gradebook.db").unlink()
    settings = course.root / "nbgrader_config.py"
    settings.write_text(settings.read_text().replace(str(local_run.root), str(course.root)))
    return course


def verdicts_of(course):
    """Return the verdict of each student, with the run time set to zero."""
    paths = course.verdicts.glob(f"*/{LESSON.stage}/*.json")
    return {path.parts[-3]: dataclasses.replace(read_verdict(path), seconds=0.0) for path in paths}


def marks(course):
    found, comments, _ = gradebook_rows(course)
    return found, comments


def is_complete(course, local):
    return verdicts_of(course) == local.verdicts and marks(course) == local.rows


def grade_on(address, course, sandbox):
    return grading.grade_course(course, (), SEED, sandbox, 1, scheduler=address)


# ---- A cluster ---------------------------------------------------------------------------------


@pytest.fixture
def start(tmp_path):
    """Return functions that start schedulers and workers with an empty folder and environment."""
    started = []
    home = tmp_path / "nowhere"
    home.mkdir()

    def start_process(*words, **environment):
        log = open(tmp_path / f"log{len(started)}.txt", "w")  # noqa: SIM115
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *words, "--no-dashboard"],
            cwd=home,
            env={"PATH": os.environ["PATH"], "HOME": str(home), **environment},
            stdout=log,
            stderr=log,
        )
        started.append((process, log))
        return process

    def scheduler():
        file = tmp_path / f"scheduler{len(started)}.json"
        network = ("--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))
        process = start_process("scheduler", *network)
        wait_for(file.exists)
        wait_for(lambda: file.read_text().strip().endswith("}"))
        return json.loads(file.read_text())["address"], process

    def worker(address, *words, threads=1, **environment):
        options = ("--nthreads", str(threads), "--local-directory", str(tmp_path / "scratch"))
        return start_process("worker", address, *options, *words, **environment)

    yield SimpleNamespace(scheduler=scheduler, worker=worker)
    for process, log in started:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(20)
        process.kill()
        process.wait()
        log.close()


def wait_for(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.1)


def wait_for_workers(address, count):
    """Wait until `count` workers have joined a scheduler."""
    with distributed.Client(address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=PATIENCE)


@pytest.fixture
def schedule_after_first_verdict(monkeypatch):
    """Return a function that schedules an action to run when the first verdict is written."""

    def schedule(action):
        def write(verdict, path, original=grade.write_verdict):
            original(verdict, path)
            monkeypatch.setattr(grade, "write_verdict", original)
            action()

        monkeypatch.setattr(grade, "write_verdict", write)

    return schedule


# ---- Whole runs --------------------------------------------------------------------------------


@pytest.mark.slow
def test_workers_started_by_hand_give_the_same_gradebook(course, local_run, sandbox, start, capsys):
    """A worker with two threads and Dask's nanny grades; a second run needs no cluster."""
    address, process = start.scheduler()
    start.worker(address, threads=2)
    assert grade_on(address, course, sandbox) == commands.SUCCESS
    assert is_complete(course, local_run)
    assert "5 notebooks: 5 judged" in capsys.readouterr().out
    process.kill()
    assert grade_on(address, course, sandbox) == commands.SUCCESS
    assert "5 unchanged" in capsys.readouterr().out


# Attacks that might succeed on a cluster, where a worker's process judges, submissions and messages
# cross the network, and two notebooks share a worker.
LOCKS = """
import fcntl, glob, os, numpy, time
FILES = sorted(glob.glob(os.path.dirname(numpy.__file__) + "/*/tests/*.py"))[:64]
OPEN = [open(name) for name in FILES]
def taken(keep):
    for file in OPEN:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not keep: fcntl.flock(file, fcntl.LOCK_UN)
        except BlockingIOError: return True
        except OSError: pass
    return False
"""
HOSTILE = {
    "kills all processes": "import os\n    os.kill(-1, 9)\n    os._exit(0)",
    "floods": "return [cloud] * 100",
    "sleeps": "import time\n    time.sleep(600)",
    "speaks": "raise ValueError('LEA' + 'KED' + str(cloud[0].tolist()))",
}


def hostile_notebook(body, before=""):
    text = f"{before}\ndef filter_ground(cloud, ground_level=-1.2):\n    {body}\n"
    right = next(answer.source for answer in answers_to("voxel_grid") if answer.right)
    return fill_in(LESSON, {"filter_ground": text, "voxel_grid": right})


def with_brackets(text):
    content = json.loads(text)
    content["cells"].append({"cell_type": "markdown", "metadata": {}, "source": "](" * 100_000})
    return json.dumps(content)


@pytest.mark.slow
@pytest.mark.proof
def test_attacks_get_the_same_verdicts_on_a_cluster(tmp_path, sandbox, start):
    right = "return cloud[cloud[:, 2] >= ground_level]"
    texts = {
        "brackets": with_brackets(answered_notebook()),
        **{name.replace(" ", "_"): hostile_notebook(body) for name, body in HOSTILE.items()},
        # These two are adjacent in alphabetical order, so they are judged at the same time.
        "tells": hostile_notebook(right, f"{LOCKS}\nHELD = taken(True), time.sleep(3)"),
        "tells_hears": hostile_notebook(
            right.replace("return", "if HEARD: return"),
            f"{LOCKS}\nHEARD = any((taken(False), time.sleep(0.2))[0] for _ in range(10))",
        ),
        "zoe": answered_notebook(),
    }
    here = make_course(tmp_path / "here" / "course", LESSON, texts, sandbox)
    there = make_course(tmp_path / "there" / "course", LESSON, texts, sandbox)
    address, _ = start.scheduler()
    start.worker(address, threads=2)
    assert grade_on(address, there, sandbox) == commands.SUCCESS
    assert grading.grade_course(here, (), SEED, sandbox, 1) == commands.SUCCESS
    assert verdicts_of(there) == verdicts_of(here)
    assert marks(there) == marks(here)
    scores = {student: verdict.score for student, verdict in verdicts_of(there).items()}
    full = {student for student, score in scores.items() if score == 30}
    assert full == {"brackets", "tells", "zoe"}
    verdicts = "".join(path.read_text() for path in there.verdicts.rglob("*.json"))
    assert "code cell" in verdicts and "LEAKED" not in verdicts


@pytest.mark.slow
def test_a_local_cluster_grades_with_processes(course, local_run, sandbox, monkeypatch):
    """A dying process fails only its job, and each connection has its own version of the course."""
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None
        ) as there,
        cluster.connect(there.scheduler_address, sandbox.name, print) as executor,
    ):
        judged = grade.judge_class(
            course,
            (),
            SEED,
            sandbox,
            lambda workers: contextlib.nullcontext(executor),
            1,
            ignore_progress,
        )
        assert len(judged) == 5 and verdicts_of(course) == local_run.verdicts

        with pytest.raises(BrokenExecutor):
            executor.submit(os._exit, 1).result()
        assert executor.submit(max, 1, 2).result() == 2
        with pytest.raises(ZeroDivisionError) as caught:
            executor.submit(divmod, 1, 0).result()
        assert "In the judging process" in caught.value.__notes__[0]

        changed = BytesIO(cluster.packed_course())
        with zipfile.ZipFile(changed, "a") as archive:
            archive.writestr("grader/version.txt", "another")
        monkeypatch.setattr(cluster, "packed_course", changed.getvalue)
        has_file = "__import__('os').path.exists('grader/version.txt')"
        with cluster.connect(there.scheduler_address, sandbox.name, print) as another:
            assert another.submit(eval, has_file).result() is True
            assert executor.submit(eval, has_file).result() is False
        assert executor.submit(max, 1, 2).result() == 2


@pytest.mark.slow
def test_a_run_survives_the_loss_of_a_worker(
    course, local_run, sandbox, start, schedule_after_first_verdict
):
    address, _ = start.scheduler()
    first = start.worker(address, "--no-nanny", threads=2)

    def replace_worker():
        first.send_signal(signal.SIGKILL)
        start.worker(address)

    schedule_after_first_verdict(replace_worker)
    assert grade_on(address, course, sandbox) == commands.SUCCESS
    assert is_complete(course, local_run)


@pytest.mark.slow
def test_unsuitable_workers_are_refused_and_listed(
    course, local_run, sandbox, start, tmp_path, capfd
):
    """With only unsuitable workers, nothing is graded; with one suitable worker, everything is."""
    numpy = tmp_path / "stub" / "numpy-1.26.4.dist-info"
    numpy.mkdir(parents=True)
    (numpy / "METADATA").write_text("Metadata-Version: 2.1\nName: numpy\nVersion: 1.26.4\n")
    empty = tmp_path / "bin"
    empty.mkdir()
    broken = tmp_path / "broken" / "pytest"
    broken.mkdir(parents=True)
    (broken / "__init__.py").write_text("raise ImportError('no pytest here')\n")

    address, _ = start.scheduler()
    start.worker(address, "--no-nanny", PYTHONPATH=str(numpy.parent))
    start.worker(address, "--no-nanny", PYTHONPATH=str(broken.parent))
    count = 2
    if sandbox.name == "bubblewrap":
        start.worker(address, "--no-nanny", **without_bubblewrap(empty))
        count = 3
    wait_for_workers(address, count)

    assert grade_on(address, course, sandbox) == commands.FAULT
    errors = capfd.readouterr().err
    assert len(re.findall(r"Worker tcp://\S+ on \S+ gets no notebooks", errors)) == count
    assert re.search(r"It has numpy 1\.26\.4 instead of 2\.\S+ Install", errors)
    assert "It cannot run the course's code: ImportError: no pytest here." in errors
    assert ("bubblewrap is not installed" in errors) == (count == 3)
    assert f"No worker at {address} can judge" in errors
    assert not verdicts_of(course)

    start.worker(address)
    wait_for_workers(address, count + 1)
    assert grade_on(address, course, sandbox) == commands.SUCCESS
    assert is_complete(course, local_run)
    assert len(re.findall("gets no notebooks", capfd.readouterr().err)) == count


@pytest.mark.slow
def test_nothing_is_judged_twice_after_the_loss_of_the_scheduler(
    course, local_run, sandbox, start, schedule_after_first_verdict, capfd
):
    address, process = start.scheduler()
    start.worker(address)
    schedule_after_first_verdict(process.kill)
    assert grade_on(address, course, sandbox) == commands.FAULT
    errors = capfd.readouterr().err
    assert f"The scheduler {address} no longer answers. Verdicts are kept" in errors
    assert "Traceback" not in errors
    kept = {path: path.stat().st_mtime_ns for path in course.verdicts.rglob("*.json")}
    assert 1 <= len(verdicts_of(course)) < 5

    address, _ = start.scheduler()
    start.worker(address)
    assert grade_on(address, course, sandbox) == commands.SUCCESS
    assert is_complete(course, local_run)
    assert all(path.stat().st_mtime_ns == mtime for path, mtime in kept.items())


RUN = """
import sys
from pathlib import Path
from grader import cli, commands
from grader.course.paths import Course
commands.Course = lambda: Course(Path(sys.argv[1]))
sys.exit(cli.main(["grade", "--seed", sys.argv[2], "--sandbox", sys.argv[3],
    "--scheduler", sys.argv[4]]))
"""


@pytest.mark.slow
def test_the_same_command_resumes_a_stopped_or_killed_run(course, local_run, sandbox, start):
    """After Ctrl-C or SIGKILL, the same command completes the run; the workers keep running."""
    address, _ = start.scheduler()
    start.worker(address)
    command = [sys.executable, "-c", RUN, str(course.root), str(SEED), sandbox.name, address]
    kept = {}
    for signal_number, status in ((signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL), (0, 0)):
        running = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        if signal_number:
            more = len(kept) + 1
            wait_for(lambda more=more: len(verdicts_of(course)) >= more)
            running.send_signal(signal_number)
        _, errors = running.communicate(timeout=PATIENCE)
        assert running.returncode == status, errors
        assert (b"Stopped. Verdicts are kept" in errors) == (signal_number == signal.SIGINT)
        assert all(path.stat().st_mtime_ns == mtime for path, mtime in kept.items())
        paths = course.verdicts.glob(f"*/{LESSON.stage}/*.json")
        kept = {path: path.stat().st_mtime_ns for path in paths}
    assert is_complete(course, local_run)


# ---- Single rules ------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_scheduler_that_does_not_answer_is_reported(course, sandbox, monkeypatch, capsys):
    monkeypatch.setattr(cluster, "CONNECTION_TIMEOUT", 1)
    for address in ("tcp://127.0.0.1:9", "carrier-pigeon://roof"):
        assert grade_on(address, course, sandbox) == commands.FAULT
        assert f"No scheduler responded at {address}" in capsys.readouterr().err
    assert grade_on("tls://127.0.0.1:9", course, sandbox) == commands.FAULT
    assert "contains none" in capsys.readouterr().err
    with course_lock(course):  # fails if the run has kept the lock
        pass


@pytest.mark.parametrize("missing", ["cloudpickle", "dask", "distributed"])
def test_the_error_about_missing_dask_names_the_command_that_installs_it(
    missing, sandbox, monkeypatch
):
    monkeypatch.delitem(sys.modules, "grader.classroom.cluster")
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(ExecutorLost, match=f"{missing} .* pip install -r requirements-cluster.txt"):
        EXECUTORS["scheduler"]("tcp://127.0.0.1:9", sandbox.name, print)


def test_missing_workers_are_reported(sandbox, monkeypatch, tmp_path):
    monkeypatch.setattr(cluster, "MAX_WAIT_SECONDS", 1)
    monkeypatch.chdir(tmp_path)
    with (
        distributed.LocalCluster(n_workers=0, processes=False, dashboard_address=None) as there,
        cluster.connect(there.scheduler_address, sandbox.name, print) as executor,
    ):
        with pytest.raises(ExecutorLost, match="dask worker"):
            executor.submit(max, 1, 2).result()
        with pytest.raises(ExecutorLost):
            executor.submit(max, 1, 2)


def test_workers_and_a_scheduler_exclude_each_other(capsys):
    words = ["grade", "--workers", "2", "--scheduler", "tcp://127.0.0.1:8786"]
    assert cli.main(words) == commands.USAGE_ERROR
    assert "Use only one." in capsys.readouterr().err


def test_the_packed_course_contains_only_files_that_judging_reads():
    packed = cluster.packed_course()
    assert packed == cluster.packed_course()
    names = set(zipfile.ZipFile(BytesIO(packed)).namelist())
    lesson = "solutions/stage3_obstacles/06_filter_ground"
    assert {"data/cloud.txt", f"{lesson}.ipynb"} < names
    packed_for_lesson = {name for name in names if name.startswith(f"{lesson}/")}
    assert packed_for_lesson == {f"{lesson}/lesson.py", f"{lesson}/hidden_tests.py"}
    assert {name.split("/")[0] for name in names} == set(FOLDERS)
    assert not [name for name in names if "/." in name or "pycache" in name]
    assert len(packed) < 5e6


@pytest.mark.slow
def test_reading_ahead_is_limited_by_the_free_workers(course, sandbox, monkeypatch):
    """With one free worker, each verdict is written before the next notebook is read."""
    monkeypatch.setattr(InlineExecutor, "capacity", 1, raising=False)
    record_rehearsal(course, LESSON)
    events = []
    read, write = grade.Submission.read, grade.write_verdict
    known = grade.stored_verdict
    monkeypatch.setattr(grade, "stored_verdict", lambda *about: None)
    monkeypatch.setattr(
        grade.Submission, "read", lambda self, course: events.append("read") or read(self, course)
    )
    monkeypatch.setattr(
        grade, "write_verdict", lambda *about: events.append("write") or write(*about)
    )
    judged = grade.judge_class(course, (), SEED, sandbox, InlineExecutor, 1, ignore_progress)
    assert events == ["read", "write"] * 5 and capacity(InlineExecutor(1)) == 1
    assert all(known(course, submission, SEED) == verdict for submission, verdict in judged)
