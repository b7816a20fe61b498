"""Attacks by a forked worker on the fork server, the judge and other workers."""

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from grader.course.lessons import all_lessons
from grader.course.paths import PROJECT
from grader.sandbox import Limits, bubblewrap, fork_client, users
from grader.sandbox.failures import StudentStopped
from grader.sandbox.usage import process_tree
from tests.attacks.attack import SANDBOX, attack, function, outcome_of
from tests.prerequisites import PATIENCE, skip_or_fail

INSPECT_WORKER = """
import gc, os, resource, signal, sys

def f():
    status = dict(line.split(":", 1) for line in open("/proc/self/status").read().splitlines())
    kept = ("CapInh", "CapPrm", "CapEff", "CapAmb", "Groups", "NoNewPrivs", "Seccomp", "Threads")
    limits = [name for name in dir(resource) if name.startswith("RLIMIT_")]
    return {
        "files": sorted(os.listdir("/proc/self/fd"), key=int)[:-1],
        "environment": sorted(f"{name}={value}" for name, value in os.environ.items()),
        "folder": os.getcwd(),
        "parent": os.getppid(),
        "status": [status[name].strip() for name in kept],
        "limits": [resource.getrlimit(getattr(resource, name)) for name in limits],
        "signals": [str(signal.getsignal(one)) for one in sorted(signal.valid_signals())],
        "umask": os.umask(0),
        "nice": os.nice(0),
        "path": list(sys.path),
        "flags": str(sys.flags),
        "root": sorted(os.listdir("/")),
        "processes": sorted(name for name in os.listdir("/proc") if name.isdigit()),
        "ours": sorted(name for name in sys.modules if name.split(".")[0] in ("grader", "pytest")),
    }
"""


@pytest.fixture(autouse=True)
def require_fork():
    """Skip these tests if workers cannot be forked."""
    if not bubblewrap._can_join_namespaces():
        skip_or_fail("the permission to enter namespaces; run: sudo make test")


def inspect_worker(monkeypatch, can_fork):
    with monkeypatch.context() as patch:
        if not can_fork:
            patch.setattr(bubblewrap, "_can_join_namespaces", lambda: False)
        return outcome_of(INSPECT_WORKER)


def test_a_forked_worker_has_no_more_rights_than_one_started_in_the_sandbox(monkeypatch):
    """Both have the same open files, privileges, groups, limits, signals, paths and variables."""
    forked, started = inspect_worker(monkeypatch, True), inspect_worker(monkeypatch, False)
    # The forked worker's parent is outside the sandbox, so its ID appears as 0. The other worker's
    # parent is process 1.
    assert (forked.pop("parent"), started.pop("parent")) == (0, 1)
    # three standard streams and two pipes
    assert len(forked.pop("files")) == 5
    started.pop("files")
    # A forked worker has no inheritable capabilities. If root runs the test, bubblewrap leaves two
    # to a started worker, which drops them itself.
    assert forked["status"].pop(0) == "0" * 16
    started["status"].pop(0)
    assert forked == started
    assert forked["ours"] == []


def test_all_namespaces_are_separate():
    """A worker shares only the time namespace with the grader, and for root the user namespace."""
    names = sorted(os.listdir("/proc/self/ns"))
    body = "import os\nreturn {name: os.readlink('/proc/self/ns/' + name) for name in names}"
    inside = outcome_of(function(body, parameters="names"), names)
    shared = {name for name in names if inside[name] == os.readlink(f"/proc/self/ns/{name}")}
    assert shared <= {"time", "time_for_children", *(("user",) if users.is_root() else ())}


def test_the_fork_server_and_the_judge_cannot_be_reached():
    """A worker can neither send signals to these processes nor open their memory in /proc."""
    body = (
        "import os, signal\nreached = []\n"
        "for number in [0, -1, *numbers]:\n"
        "    if number == 0: number = os.getppid()\n"
        "    try:\n        open(f'/proc/{number}/mem', 'r+b'); reached.append(number)\n"
        "    except OSError: pass\n"
        "    try:\n        if number > 0: os.kill(number, 0); reached.append(number)\n"
        "    except OSError: pass\n"
        "return reached"
    )
    with attack(function(body, parameters="numbers")) as student:
        student.f([])
        numbers = [number for number in process_tree(os.getpid()) if number > 10]
        assert student.f(numbers) == []


def test_workers_do_not_draw_the_same_numbers():
    body = "import random\nimport numpy as np\nreturn [random.random(), float(np.random.rand())]"
    drawn = [outcome_of(function(body)) for _ in range(3)]
    assert len({number for pair in drawn for number in pair}) == 6


SCIPY_IN_MEMORY = """
# scipy is named here, so it may have been imported.
import gc, sys, types
gc.unfreeze()  # shows what the fork server keeps from the collector
kinds = type, types.FunctionType, types.BuiltinFunctionType
homes = {thing.__module__ for thing in gc.get_objects() if isinstance(thing, kinds)}
names = homes | set(sys.modules)
return sorted(name for name in names if isinstance(name, str) and name.startswith("scipy"))
"""


def test_only_packages_of_the_lesson_are_preloaded():
    assert "scipy.spatial" in outcome_of(function(SCIPY_IN_MEMORY))
    assert outcome_of(function(SCIPY_IN_MEMORY), packages=("numpy",)) == []


def test_slow_packages_are_imported_only_if_the_code_names_them():
    forbidden = ("no_such_module",)  # no other test forbids this module, so a new server starts
    search = "import sys\nreturn sorted(name for name in sys.modules if name[:3] == 'sci')"
    assert outcome_of(function(search), forbidden=forbidden) == []
    named = outcome_of(function(f"# scipy\n{search}"), forbidden=forbidden)
    assert "scipy.spatial" in named and "scipy.sparse.csgraph" in named


@pytest.mark.parametrize(
    "forbidden, preloaded",
    [
        (("scipy",), None),
        (("scipy.spatial",), None),
        (("scipy.sparse.csgraph",), None),
        (("sklearn.cluster", "scipy.cluster"), "scipy.spatial"),
        *((lesson.header.forbidden, None) for lesson in all_lessons() if lesson.header.forbidden),
    ],
)
def test_forbidden_modules_are_not_in_memory(forbidden, preloaded):
    """The fork server does not preload a forbidden module, not even through another module."""
    names = outcome_of(function(SCIPY_IN_MEMORY), forbidden=forbidden)
    inside = tuple(f"{name}." for name in forbidden)
    assert not [name for name in names if f"{name}.".startswith(inside)]
    assert preloaded is None or preloaded in names


def test_the_end_of_a_worker_ends_only_its_children():
    body = (
        "import os, signal, time\n"
        "if os.fork() == 0:\n    time.sleep(600)\n"
        "if arguments[0]: os.kill(os.getpid(), signal.SIGKILL)\n"
        "return 1"
    )
    with attack(function(body)) as first, attack(function("return 2")) as second:
        first.f(False)
        assert second.f() == 2
        children = [number for pid in first._worker.pids for number in process_tree(pid)]
        with pytest.raises(StudentStopped, match="killed it"):
            first.f(True)
        assert second.f() == 2
    deadline = time.monotonic() + PATIENCE
    while any(os.path.exists(f"/proc/{number}") for number in children):
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_a_killed_fork_server_is_started_again():
    """The kernel may kill the server when memory is short, but the notebook is still judged."""
    with attack(function("return 3")) as student:
        assert student.f() == 3
        server = grandparent_of(student._worker.forked.pid)
        os.kill(server, signal.SIGKILL)
        assert student.f() == 3
        with attack(function("return 4")) as other:
            assert other.f() == 4


def grandparent_of(pid):
    """Return the ID of the parent of a process's parent; for a forked worker, the fork server."""
    for _ in range(2):
        with open(f"/proc/{pid}/stat") as stat:
            pid = int(stat.read().rpartition(")")[2].split()[1])
    return pid


def test_workers_can_be_forked_concurrently():
    seen = []

    def ask(number):
        seen.append(outcome_of(function("return arguments[0]"), number))

    threads = [threading.Thread(target=ask, args=(number,)) for number in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(seen) == list(range(6))


def test_a_killed_judge_leaves_no_processes():
    """The worker and the fork server end when the judge is killed and cannot clean up."""
    program = (
        "import sys, time\nfrom grader.sandbox import SANDBOXES, Limits\n"
        "worker = SANDBOXES['bubblewrap'].start(Limits(), (), ('numpy',))\n"
        "print(*worker.pids, flush=True)\ntime.sleep(600)\n"
    )
    judge = subprocess.Popen(
        [sys.executable, "-c", program], cwd=PROJECT, stdout=subprocess.PIPE, text=True
    )
    pids = [int(word) for word in judge.stdout.readline().split()]
    numbers = [*pids, *(number for pid in pids for number in process_tree(pid))]
    numbers.append(grandparent_of(pids[-1]))
    judge.kill()
    judge.wait()
    judge.stdout.close()
    deadline = time.monotonic() + PATIENCE
    while any(is_running(number) for number in numbers):
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.mark.slow
def test_a_judge_killed_while_building_a_sandbox_leaves_no_processes(tmp_path):
    """With bubblewrap's option --die-with-parent, one process would keep waiting."""
    # The processes are identified by the path of the test's folder in their environment.
    program = (
        "import os, signal, sys, time\nfrom grader.sandbox import bubblewrap, Limits\n"
        "from grader.sandbox.launcher import ENVIRONMENT\n"
        "sandbox = bubblewrap.Bubblewrap()\n"
        "bubblewrap._can_join_namespaces()\n"
        "ENVIRONMENT['MARK'] = sys.argv[1]\n"
        "for moment in range(20):\n"
        "    judge = os.fork()\n"
        "    if judge == 0:\n"
        "        sandbox.start(Limits(), (), ['scipy'])\n"
        "        time.sleep(600)\n"
        "    begun = open(f'/proc/{judge}/task/{judge}/children')\n"
        "    while not begun.read(): begun.seek(0)\n"
        "    time.sleep(moment / 1000)\n"
        "    os.kill(judge, signal.SIGKILL)\n"
        "    os.waitpid(judge, 0)\n"
    )
    subprocess.run([sys.executable, "-c", program, str(tmp_path)], cwd=PROJECT, check=True)
    deadline = time.monotonic() + PATIENCE
    while left := processes_with(str(tmp_path)):
        if time.monotonic() > deadline:
            for number in left:
                os.kill(number, signal.SIGKILL)
            pytest.fail(f"{len(left)} processes were left")
        time.sleep(0.05)


def processes_with(mark):
    """Return the IDs of processes whose environment contains the text `mark`."""
    found = []
    for number in filter(str.isdigit, os.listdir("/proc")):
        with contextlib.suppress(OSError):
            if mark.encode() in Path(f"/proc/{number}/environ").read_bytes():
                found.append(int(number))
    return found


def is_running(pid):
    """Return whether a process exists and is not a zombie."""
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_python_starts_in_the_sandbox_if_entering_namespaces_is_refused(monkeypatch):
    def refused(*request):
        raise bubblewrap.SandboxUnavailable("refused")

    monkeypatch.setattr(fork_client.ForkClient, "fork", refused)
    bubblewrap._can_join_namespaces.cache_clear()
    try:
        worker = SANDBOX.start(Limits())
        assert worker.forked is None
        assert worker.stop() == -9
    finally:
        bubblewrap._can_join_namespaces.cache_clear()
