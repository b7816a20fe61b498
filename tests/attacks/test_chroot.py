"""Attacks on the chroot sandbox, which is meant for containers that judge only one student.

With `ATTACKED=chroot`, the attacks in the other files also run in this sandbox.
"""

import os
import secrets
import signal
import subprocess
import sys
import time

import pytest

from grader.course.paths import PROJECT
from grader.sandbox import SANDBOXES, Limits, SandboxUnavailable, chroot, users
from grader.sandbox.failures import StudentStopped
from grader.sandbox.program import INSTALLED_PACKAGES, Program
from grader.sandbox.student import StudentProxy
from tests.attacks.attack import SHORT, function, with_attacks
from tests.prerequisites import PATIENCE, ROOT, require_sandbox

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module", autouse=True)
def chroot_sandbox():
    if os.geteuid():
        pytest.skip(ROOT)
    if chroot.path_in_writable_folders():
        pytest.skip("a course and a Python outside /tmp; clone the course elsewhere")
    return require_sandbox("chroot")


def attack(source, **limits):
    program = Program((source,), ("f",), packages=INSTALLED_PACKAGES)
    return StudentProxy(
        program, SANDBOXES["chroot"], Limits(**{**SHORT, "call_seconds": 5.0, **limits})
    )


def outcome_of(source, *arguments, **limits):
    with attack(source, **limits) as student:
        return student.f(*arguments)


LIST_FILES = """
import os
def f():
    return [os.path.join(top, name) for top, _, names in os.walk("/") for name in names]
"""


def test_only_the_files_that_student_code_needs_are_visible(tmp_path):
    (tmp_path / "seed").write_text("secret")
    seen = set(outcome_of(LIST_FILES))
    assert str(PROJECT / "grader" / "sandbox" / "inside" / "worker.py") in seen
    assert any(path.endswith("/numpy/__init__.py") for path in seen)
    ours = {path for path in seen if path.startswith(f"{PROJECT}/")}
    utils = ("utils/clouds/", "utils/in_sandbox.py", "utils/notebooks/")
    shown = ("grader/sandbox/inside/", *utils, "data/", ".venv/")
    assert ours and all(path[len(f"{PROJECT}/") :].startswith(shown) for path in ours)
    assert not [path for path in seen if "/nbgrader/" in path or "/proc/" in path]
    assert str(tmp_path / "seed") not in seen and "/etc/passwd" not in seen


@with_attacks(
    "body",
    {
        "changes the root directory": "os.chroot('/tmp')",
        "creates a device": "os.mknod('/tmp/disk', 0o60666, os.makedev(8, 0))",
        "becomes root": "os.setuid(0)",
        "becomes root with its saved user ID": "os.setresuid(-1, 0, -1)",
        "joins root's group": "os.setgroups([0])",
        "writes to the root directory": "open('/x', 'w')",
        "writes to the Python library": "open(os.__file__, 'a')",
        "changes the mode of a device": "os.chmod('/dev/null', 0)",
        "lists processes": "os.listdir('/proc')",
        "opens a socket": "import socket; socket.socket()",
        "opens a local socket": "import socket; socket.socket(socket.AF_UNIX)",
        "opens a netlink socket": "import socket; socket.socket(16, 3)",
        "mounts a file system": "assert ctypes.CDLL(None)"
        ".mount(b'x', b'/tmp', b'tmpfs', 0, None) == 0",
        "creates a namespace": "assert ctypes.CDLL(None).unshare(0x10000000) == 0",
    },
)
def test_privileged_actions_are_refused(body):
    source = "import ctypes, os\n" + function(
        f"try:\n    {body}\nexcept (OSError, AssertionError):\n    return 'refused'\n"
        "return 'gained'"
    )
    assert outcome_of(source) == "refused"


def test_processes_of_the_judge_cannot_be_killed():
    victim = subprocess.Popen(["sleep", "60"])
    body = (
        "refused = 0\nfor number in (victim, judge, parent, 1):\n"
        "    try: os.kill(number, 9)\n    except OSError: refused += 1\n"
        "try: os.kill(-1, 9)\nexcept OSError: pass\nreturn refused, os.getuid()"
    )
    source = "import os\n" + function(body, parameters="victim, judge, parent")
    try:
        refused, user = outcome_of(source, victim.pid, os.getpid(), os.getppid())
        assert refused == 4 and user >= 2**15
        assert victim.poll() is None
    finally:
        victim.kill()
        victim.wait()


LEAVE_TRACES = """
import os
def f(python, mark):
    if os.fork() == 0:
        os.setsid()
        if os.fork():
            os._exit(0)
        os.closerange(3, 64)
        os.execv(python, [python, "-c", "import time; time.sleep(300)", mark])
    os.wait()
    for folder in ("/tmp", "/dev/shm"):
        open(folder + "/left", "w").close()
        os.chmod(folder, 0o777)
    return os.listdir("/tmp")
"""


@pytest.mark.parametrize("how", ["stopped by the judge", "ended by itself"])
def test_processes_and_files_do_not_outlive_the_worker(how):
    mark = secrets.token_hex(8)
    with attack(LEAVE_TRACES) as student:
        assert student.f(sys.executable, mark) == ["left"]
        deadline = time.monotonic() + PATIENCE
        while not running_processes(mark):
            assert time.monotonic() < deadline, "nothing stays, so this test shows nothing"
            time.sleep(0.05)
        if how == "ended by itself":
            worker = student._worker
            os.kill(child_of(worker.process.pid), signal.SIGKILL)
            assert worker.has_ended(PATIENCE)
            assert not running_processes(mark)
    assert not running_processes(mark)
    find = "import os\n" + function("return os.listdir('/tmp') + os.listdir('/dev/shm')")
    assert outcome_of(find) == []


def running_processes(mark):
    listing = subprocess.run(["ps", "-wweo", "stat,args"], capture_output=True, text=True).stdout
    return [line for line in listing.splitlines() if mark in line and not line.startswith("Z")]


def child_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children") as file:
        return int(file.read().split()[0])


def test_two_concurrent_sandboxes_are_separate():
    put = "import os\n" + function(
        "open('/tmp/here', 'w').close()\nos.chmod('/tmp', 0o777)\nreturn os.getuid(), os.getpid()"
    )
    look = "import os\n" + function(
        "try: os.kill(pid, 9)\nexcept OSError: return os.listdir('/tmp'), os.getuid()",
        parameters="pid",
    )
    with attack(put) as first, attack(look) as second:
        user, pid = first.f()
        found, second_user = second.f(pid)
        assert found == [] and second_user != user
        assert first.f() == (user, pid)


def test_the_number_of_processes_is_limited():
    body = (
        "import time\nborn = 0\ntry:\n    while True:\n        if os.fork() == 0: time.sleep(60)\n"
        "        born += 1\nexcept OSError:\n    return born"
    )
    assert outcome_of("import os\n" + function(body)) < Limits().processes


def test_memory_of_orphaned_processes_counts_towards_the_limit():
    """The memory of an orphaned process counts, because it is still a descendant of the jailer."""
    body = (
        "import os, time, numpy as np\n"
        "if os.fork() == 0:\n    os.setsid()\n    if os.fork(): os._exit(0)\n"
        "    kept = np.ones(2**27)\n    time.sleep(600)\ntime.sleep(600)"
    )
    start = time.monotonic()
    with (
        attack(function(body), call_seconds=15.0, total_memory=2**30) as student,
        pytest.raises(StudentStopped, match="too much memory"),
    ):
        student.f()
    assert time.monotonic() - start < PATIENCE


CHECK_SANDBOX = """
from grader.sandbox import SANDBOXES, SandboxUnavailable
try:
    SANDBOXES["chroot"].check_available()
except SandboxUnavailable as error:
    print(error)
"""


@pytest.mark.parametrize("capability", ["sys_chroot", "setuid", "setgid", "chown", "mknod"])
def test_a_missing_capability_is_reported(capability):
    drop = [f"--bounding-set=-{capability}", f"--inh-caps=-{capability}"]
    command = ["setpriv", *drop, sys.executable]
    ran = subprocess.run(
        [*command, "-c", CHECK_SANDBOX], capture_output=True, text=True, cwd=PROJECT
    )
    assert ran.stdout.startswith("Root cannot build a chroot here."), ran


def test_the_chroot_sandbox_needs_root(monkeypatch):
    monkeypatch.setattr(users, "is_root", lambda: False)
    monkeypatch.setattr(chroot, "_find_problem", chroot._find_problem.__wrapped__)
    with pytest.raises(SandboxUnavailable, match="needs root"):
        SANDBOXES["chroot"].check_available()
