"""A third kind of sandbox needs 40 lines: two classes and an entry in `SANDBOXES`."""

import json
import math
import os
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

import pytest

from grader import cli
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.sandbox import SANDBOXES, Limits, choose_sandbox, jail, launcher
from grader.sandbox.boundary import WORKER_SCRIPT
from grader.sandbox.failures import StudentStopped
from grader.sandbox.launcher import send_rules
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy


class StreamWorker:
    """A worker that communicates through its standard streams, as in a container."""

    def __init__(self):
        command = [sys.executable, "-I", "-B", str(WORKER_SCRIPT), "0", "1"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.read_end, self.write_end = self.process.stdout.fileno(), self.process.stdin.fileno()
        for end in (self.read_end, self.write_end):
            os.set_blocking(end, False)

    def cpu_seconds(self):
        return time.monotonic()

    def threads(self):
        return None

    def has_ended(self, seconds):
        try:
            return self.process.wait(seconds) is not None
        except subprocess.TimeoutExpired:
            return False

    def lacked_memory(self):
        return False

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self.process.stdin.close()
        return self.process.returncode


class Container:
    """A sandbox that starts workers with `StreamWorker`."""

    name, warning = "container", "It is a stand-in that does not isolate anything."

    def check_available(self):
        pass

    def protections(self):
        return "none"

    def start(self, limits, forbidden=(), packages=(), named_packages=()):
        worker = StreamWorker()
        rules = {"user": None, "limits": limits.resources(), "forbidden": list(forbidden)}
        send_rules(worker, rules)
        return worker


@pytest.fixture
def container(monkeypatch):
    """Register the third sandbox for one test, and return it."""
    monkeypatch.setitem(SANDBOXES, Container.name, Container())
    return choose_sandbox(Container.name)


@pytest.mark.slow
@pytest.mark.parametrize("is_shared", [0, 1])
def test_a_jail_contains_the_library_that_python_was_built_with(is_shared, monkeypatch):
    """A shared libpython may be outside the system's library folders."""
    variables = {"Py_ENABLE_SHARED": is_shared, "LIBDIR": "/opt/lib", "INSTSONAME": "libpy.so.1"}
    monkeypatch.setattr(sysconfig, "get_config_var", variables.get)
    assert (Path("/opt/lib/libpy.so.1") in jail._python_paths()) == is_shared


def test_a_third_sandbox_is_selected_by_its_name(container, tmp_path, capsys):
    """The name selects the sandbox at all steps, from the command line to the points."""
    lesson = find_lesson("06_filter_ground")
    right, wrong = (
        next(answer for answer in answers_to("voxel_grid") if answer.right == is_right)
        for is_right in (True, False)
    )
    ground = next(answer.source for answer in answers_to("filter_ground") if answer.right)
    lost = {}
    for answer in (right, wrong):
        path = tmp_path / "06_filter_ground.ipynb"
        path.write_text(fill_in(lesson, {"filter_ground": ground, "voxel_grid": answer.source}))
        options = ["--seed", str(2**64 + 1), "--json", "--sandbox", container.name]
        assert cli.main(["judge", str(path), *options]) == 0
        verdict = json.loads(capsys.readouterr().out)
        exercises = verdict["exercises"]
        lost[answer.right] = {
            part["name"] for part in exercises if part["score"] < part["max_score"]
        }
    assert lost == {True: set(), False: {"voxel_grid"}}


def test_hanging_and_dying_are_distinguished_in_a_third_sandbox(container):
    """The judge stops both, although it cannot see the processes in such a sandbox.

    Each case has its own function, because a function that was stopped gets less time later.
    """
    source = (
        "import os, time\n"
        "def hang():\n"
        "    time.sleep(600)\n"
        "def kill():\n"
        "    os.kill(os.getpid(), 9)\n"
        "def answer():\n"
        "    return 'answer'"
    )
    program = Program((source,), ("hang", "kill", "answer"))
    with StudentProxy(program, container, Limits(call_seconds=1)) as student:
        assert student.answer() == "answer"
        with pytest.raises(StudentStopped, match="did not answer within"):
            student.hang()
        with pytest.raises(StudentStopped, match="killed it"):
            student.kill()
        assert student.answer() == "answer"


@pytest.mark.parametrize("processors", [1, 2, 8, 12, 17, 64, 128, 1000])
def test_pipes_of_many_workers_stay_below_the_limit_of_a_user(processors):
    """Above 64 MiB, Linux would shrink each further pipe of the user, in all programs."""
    size = 2 ** math.ceil(math.log2(launcher.pipe_bytes(processors)))  # Linux rounds up
    assert 2**16 <= size <= 2**20
    assert size == 2**16 or 4 * processors * size <= 48 * 2**20
