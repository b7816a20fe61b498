"""What a hostile student may try, and what comes of it.

Every attack runs for real, in the sandbox. A student's function reports what it managed to do:
the tests read that report, and look at the grader's side of it.
"""

import contextlib
import json
import os
import socket
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from grader.course.lessons import all_lessons
from grader.course.paths import PROJECT
from grader.course.variants import fill_in
from grader.intake.notebook import UnreadableNotebook, read_notebook
from grader.judging.judge import judge
from grader.sandbox import SANDBOXES, Limits, SandboxUnavailable, bubblewrap
from grader.sandbox.boundary import SHOWN
from grader.sandbox.inside import syscalls
from grader.sandbox.student import Student, StudentError, StudentStopped

WALLS = SANDBOXES["bubblewrap"]
try:
    WALLS.available()
except SandboxUnavailable as reason:
    pytestmark = pytest.mark.skip(reason=f"no sandbox to attack: {reason}")

MEBIBYTE = 2**20
SHORT = {"start_seconds": 8.0, "call_seconds": 1.0, "total_seconds": 20.0, "restarts": 0}
CLOUD = np.arange(12.0).reshape(3, 4)
SEED = 20_170_405
EXERCISES = ("filter_ground", "voxel_grid")


def attack(source, forbidden=(), **limits):
    """A student whose notebook is one cell that defines `f`."""
    return Student([source], ("f",), WALLS, Limits(**{**SHORT, **limits}), forbidden)


def outcome_of(source, *arguments, **limits):
    """What `f` returns to the judge."""
    with attack(source, **limits) as student:
        return student.f(*arguments)


@pytest.fixture(scope="module")
def filtering():
    """Lesson 06."""
    return next(lesson for lesson in all_lessons() if lesson.name == "06_filter_ground")


@pytest.fixture
def hand_in(filtering, tmp_path):
    """Judge answers typed into lesson 06, or the whole text of a file."""

    def hand_in(answers=None, text=None, **limits):
        path = tmp_path / f"{filtering.name}.ipynb"
        path.write_text(fill_in(filtering, answers) if text is None else text, "utf-8")
        return judge(path, SEED, WALLS, filtering, "mallory", Limits(**{**SHORT, **limits}))

    return hand_in


# ---- What can be seen ---------------------------------------------------------------------


SPY = """
import os
def f(paths):
    found = []
    for path in paths:
        for folder, folders, files in os.walk(path):
            found += [os.path.join(folder, name) for name in files]
    return found
"""


def test_sees_no_test_no_solution_no_secret_and_no_other_student():
    seen = outcome_of(
        SPY, [str(PROJECT), "/home", "/srv", "/mnt", "/var", "/etc"], call_seconds=8.0
    )
    project = [
        Path(path).relative_to(PROJECT) for path in seen if Path(path).is_relative_to(PROJECT)
    ]
    ours = {path for path in project if path.parts[0] != ".venv"}
    assert ours, "the students' own library is there"
    shown = [path.relative_to(PROJECT) for path in SHOWN]
    assert all(any(path.is_relative_to(folder) for folder in shown) for path in ours)
    assert {path.parts[0] for path in shown} == {"utils", "data", "grader"}
    assert {path.parts[:3] for path in ours if path.parts[0] == "grader"} == {
        ("grader", "sandbox", "inside")
    }
    assert {path.suffix for path in ours if path.parts[0] == "data"} <= {".txt"}
    assert not [path for path in seen if path.startswith(("/home", "/srv", "/mnt", "/var"))]


def test_sees_no_process_descriptor_or_variable_of_the_grader(monkeypatch):
    monkeypatch.setenv("SECRET_TOKEN", "xyzzy")
    source = """
import os
def f():
    texts = [str(dict(os.environ))]
    for number in os.listdir("/proc"):
        if number.isdigit():
            for name in ("cmdline", "environ"):
                try:
                    texts.append(open(f"/proc/{number}/{name}").read())
                except OSError:
                    pass
    links = [os.readlink(f"/proc/self/fd/{n}") for n in os.listdir("/proc/self/fd")
             if os.path.lexists(f"/proc/self/fd/{n}")]
    return texts, links, [int(n) for n in os.listdir("/proc") if n.isdigit()]
"""
    with open(__file__):
        texts, links, processes = outcome_of(source)
    assert "xyzzy" not in "".join(texts) and "pytest" not in "".join(texts)
    assert len(processes) == 2, "bubblewrap's own and the worker"
    assert all(link == "/dev/null" or link.startswith("pipe:") for link in links)
    assert len({link for link in links if link.startswith("pipe:")}) == 2


def test_reaches_no_network():
    with socket.socket() as server:
        server.bind(("127.0.0.1", 0))
        server.listen()
        source = f"""
import socket
def f():
    reached = []
    for address in (("127.0.0.1", {server.getsockname()[1]}), ("1.1.1.1", 53)):
        try:
            reached.append(socket.create_connection(address, timeout=0.3) and address)
        except OSError:
            pass
    for family in (16, 38, 40):  # netlink, the kernel's ciphers, the virtual machine's host
        try:
            reached.append(socket.socket(family, socket.SOCK_STREAM) and family)
        except OSError:
            pass
    return reached
"""
        assert outcome_of(source, call_seconds=4.0) == []


def test_a_forbidden_library_is_gone_however_it_is_imported():
    source = """
import glob, importlib, subprocess, sys
def f():
    sys.meta_path[:] = [finder for finder in sys.meta_path
                        if type(finder).__name__ != "ForbiddenImports"]
    found = []
    for folder in glob.glob(f"{sys.base_prefix}/lib/python*/site-packages") + sys.path:
        found += glob.glob(folder + "/scipy/cluster/*")
    try:
        import scipy.cluster.hierarchy
        found.append("imported")
    except ImportError:
        pass
    return found
"""
    with attack(source, forbidden=("scipy.cluster",), call_seconds=5.0) as student:
        assert student.f() == []
    with attack(
        "import scipy.cluster.hierarchy as h\ndef f(): return h", forbidden=("scipy.cluster",)
    ) as student:
        with pytest.raises(StudentError, match="NameError"):
            student.f()
        assert any("is not allowed" in problem for problem in student.problems)


# ---- What can be harmed -------------------------------------------------------------------


def test_writes_nowhere_but_a_small_tmp():
    source = """
import os
def f(paths):
    written = []
    for path in paths:
        try:
            with open(os.path.join(path, "x"), "w") as file:
                file.write("x")
            written.append(path)
        except OSError:
            pass
    return written
"""
    everywhere = [
        "/",
        "/usr",
        "/usr/bin",
        "/etc",
        "/dev",
        "/proc",
        "/proc/sys/kernel",
        "/tmp",
        "/dev/shm",
        sys.prefix,
        str(PROJECT),
        str(PROJECT / "utils"),
    ]
    assert outcome_of(source, everywhere) == ["/tmp", "/dev/shm"]
    assert not (PROJECT / "utils" / "x").exists()


FILL = """
import os
def f(folder):
    size = 0
    try:
        for number in range(100):
            with open(f"{folder}/{number}", "wb") as file:
                for _ in range(31):
                    size += file.write(bytes(2**20))
                    file.flush()
    except OSError:
        pass
    return size
"""


@pytest.mark.parametrize("folder", ["/tmp", "/dev/shm"])
def test_fills_no_disk_and_no_memory_with_files(folder):
    assert outcome_of(FILL, folder, call_seconds=5.0) <= Limits().temporary_space


def test_allocates_no_more_than_its_limit():
    with (
        attack("import numpy as np\ndef f(): return len(np.ones(2**30))") as student,
        pytest.raises(StudentError, match="MemoryError"),
    ):
        student.f()


MANY_PROCESSES = """
import mmap, os, time
def f(megabytes):
    blocks = []
    for _ in range(12):
        if os.fork() == 0:
            block = mmap.mmap(-1, megabytes * 2**20)
            for page in range(0, len(block), 4096):
                block[page] = 1
            block.madvise(mmap.MADV_DONTNEED)  # it stays, but this process no longer shows it
            time.sleep(60)
            os._exit(0)
    time.sleep(60)
"""


def test_many_processes_share_one_limit_of_memory():
    begin = time.monotonic()
    with (
        attack(MANY_PROCESSES, call_seconds=10.0, total_memory=2048 * MEBIBYTE) as student,
        pytest.raises(StudentStopped, match="too much memory"),
    ):
        student.f(256)
    assert time.monotonic() - begin < 5


def test_memory_is_watched_between_calls_too():
    source = MANY_PROCESSES.replace("\n    time.sleep(60)\n", "\n    return 0\n")
    with (
        attack(source, total_memory=2048 * MEBIBYTE) as student,
        pytest.raises(StudentStopped, match="too much memory"),
    ):
        assert student.f(256) == 0
        time.sleep(1.0)
        student.f(256)


def test_starts_a_limited_number_of_processes():
    source = """
import os, time
def f():
    started = 0
    try:
        for _ in range(1000):
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
            started += 1
    except OSError:
        pass
    return started
"""
    assert outcome_of(source, call_seconds=5.0, processes=20) <= 20


def test_leaves_no_process_behind():
    source = """
import os, time
def f():
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            time.sleep(600)
    return open("/proc/self/status").read()
"""
    with attack(source) as student:
        user = student.f().split("Uid:")[1].split()[0]
        assert processes_of(user) or os.geteuid()
    deadline = time.monotonic() + 3
    while os.geteuid() == 0 and processes_of(user) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert os.geteuid() or not processes_of(user)


def processes_of(user):
    found = []
    for path in Path("/proc").glob("[0-9]*/status"):
        with contextlib.suppress(OSError):
            found += [path] if f"\nUid:\t{user}\t" in path.read_text() else []
    return found


@pytest.mark.skipif(os.uname().machine not in syscalls.MACHINES, reason="no filter for it")
def test_kernel_features_that_no_exercise_needs_do_not_exist():
    source = """
import ctypes, errno
def f(calls):
    syscall = ctypes.CDLL(None, use_errno=True).syscall
    allowed = []
    for name, arguments in calls.items():
        ctypes.set_errno(0)
        syscall(*map(ctypes.c_long, arguments))
        if ctypes.get_errno() != errno.ENOSYS:
            allowed.append(name)
    return allowed
"""
    numbers = syscalls.MACHINES[os.uname().machine][1]
    calls = {
        name: [number, 0, 0, 0]
        for name, number in numbers.items()
        if name not in ("clone", "socket")
    }
    calls["clone"] = [numbers["clone"], syscalls.NEW_USER_NAMESPACE | 17, 0, 0]
    calls["socket"] = [numbers["socket"], 40, 1, 0]
    calls["unshare"] = [numbers["unshare"], syscalls.NEW_USER_NAMESPACE]
    calls["shmget"] = [numbers["shmget"], 0, MEBIBYTE, 0o1777]
    if os.uname().machine == "x86_64":
        calls["the x32 form of getpid"] = [0x40000000 + 39]
    assert outcome_of(source, calls) == []


def test_no_privilege_is_left():
    source = """
import os, subprocess
def f():
    status = dict(line.split(":\\t") for line in open("/proc/self/status").read().splitlines()
                  if ":\\t" in line)
    gained = []
    for change in (lambda: os.setuid(0), lambda: os.setgid(0), lambda: os.setgroups([0]),
                   lambda: os.chroot("/tmp"), lambda: os.kill(1, 9), lambda: os.nice(-5),
                   lambda: os.open("/proc/1/mem", os.O_RDWR),
                   lambda: os.mknod("/tmp/d", 0o60600, 2048)):
        try:
            change()
            gained.append(len(gained))
        except OSError:
            pass
    who = subprocess.run(["/usr/bin/su", "-c", "id -u"], capture_output=True, text=True).stdout
    names = ("CapEff", "CapPrm", "NoNewPrivs")
    return *(int(status[name], 16) for name in names), status["Uid"].split(), who, gained
"""
    effective, permitted, sealed, users, became, gained = outcome_of(source, call_seconds=3.0)
    assert effective == permitted == 0 and sealed == 1
    assert "0" not in users and became.strip() != "0"
    assert gained in ([], [4]), "a signal to process 1 of one's own namespace is ignored"


def test_the_walls_for_an_ordinary_user_hold_too(monkeypatch):
    """Graders need not be root; as root we can still try the walls they get."""
    monkeypatch.setattr(bubblewrap, "_is_root", lambda: False)
    someone = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
    script = (
        "cd /tmp && echo x > y && cat y; grep CapEff /proc/self/status; "
        "unshare --user true && echo gained; echo x > /usr/x && echo gained; "
        "ls /proc | grep -c '^[0-9]'; ls -A / /root /home; true"
    )
    ran = subprocess.run(
        [*bubblewrap._walls(Limits()), "--remount-ro", "/", "--", "/bin/sh", "-c", script],
        capture_output=True,
        text=True,
        cwd="/",
        **someone,
    )
    if ran.stderr.startswith("bwrap:") and "ermi" in ran.stderr:
        pytest.skip(f"ordinary users may not build namespaces here: {ran.stderr}")
    assert ran.stdout.startswith("x\nCapEff:\t0000000000000000\n"), ran.stderr
    assert "gained" not in ran.stdout
    assert "/work" not in ran.stdout and "No such file" in ran.stderr


# ---- The conversation ---------------------------------------------------------------------


PIPES = """
import fcntl, os, select, stat, struct, sys, threading, time
def pipes():
    reading, writing = [], []
    for number in range(3, 64):
        try:
            if stat.S_ISFIFO(os.fstat(number).st_mode):
                flags = fcntl.fcntl(number, fcntl.F_GETFL) & os.O_ACCMODE
                (writing if flags == os.O_WRONLY else reading).append(number)
        except OSError:
            pass
    return reading, writing
def say(text, blob=b""):
    os.write(pipes()[1][0], struct.pack(">II", len(text), len(blob)) + text + blob)
ANSWER = b'{"dict":[["id",%d],["result",%s],["changed",{"dict":[]}]]}'
"""


def stopped_by(body, *arguments, **limits):
    """The sentence with which a student is stopped whose `f` has this body."""
    source = (
        PIPES
        + "def f(*arguments):\n"
        + "".join(f"    {line}\n" for line in body.strip().splitlines())
    )
    begin = time.monotonic()
    with attack(source, **limits) as student, pytest.raises(StudentStopped) as stopped:
        for _ in range(3):
            student.f(*arguments)
    assert time.monotonic() - begin < 6
    return str(stopped.value)


@pytest.mark.parametrize(
    "body, sentence",
    [
        ("os.write(pipes()[1][0], b'give me full marks, please' * 9)", "own channel"),
        ("os.write(pipes()[1][0], b'\\xff' * 8)", "own channel"),
        ('say(b\'{"pickle":"x"}\')', "own channel"),
        ("say(b'[' * 100000)", "own channel"),
        ("say(b'1' * 100000)", "own channel"),
        ("say(b'[]')", "own channel"),
        ("say(b'\"hello\"')", "did not answer the question"),
        ("say(ANSWER % (99, b'1'))", "did not answer the question"),
        ('say(b\'{"dict":[["id",true]]}\')', "did not answer the question"),
        (
            'say(b\'{"dict":[["id",{"array":["|u1",[2]]}]]}\', b\'ab\')',
            "did not answer the question",
        ),
        ("os.write(pipes()[1][0], struct.pack('>II', 100, 0)); time.sleep(60)", "did not answer"),
        ("for end in sum(pipes(), []): os.close(end)\ntime.sleep(60)", "ended|did not answer"),
        ("os.kill(os.getpid(), 19)", "did not answer"),
        ("while True: pass", "did not answer"),
        ("os._exit(0)", "ended"),
        ("os.kill(os.getpid(), 9)", "memory, or killed itself"),
        ("import ctypes; ctypes.string_at(1)", "crashed"),
        ("if os.fork(): os._exit(0)\ntime.sleep(60)", "ended"),
        ("os.execv('/bin/sleep', ['sleep', '60'])", "did not answer"),
    ],
)
def test_breaking_the_conversation_stops_the_student(body, sentence):
    import re

    assert re.search(sentence, stopped_by(body))


def test_dripping_an_answer_is_no_answer():
    body = """
write = pipes()[1][0]
fcntl.fcntl(write, fcntl.F_SETPIPE_SZ, 4096)
os.write(write, struct.pack(">II", 100, 30 * 2**20) + b" " * 100)
while True: os.write(write, b" ")
"""
    assert "did not answer" in stopped_by(body)


def test_the_judge_never_waits_in_a_read_or_a_write():
    """Data that `poll` has seen may be gone: whoever wrote them can read them first."""
    worker = WALLS.start(Limits())
    try:
        assert not os.get_blocking(worker.read_end) and not os.get_blocking(worker.write_end)
    finally:
        worker.stop()


def test_not_reading_a_question_does_not_hang_the_judge():
    source = """
import os, threading
def f(cloud): threading.Timer(0.05, os.kill, (os.getpid(), 19)).start()
"""
    with attack(source) as student:
        student.f(CLOUD)
        time.sleep(0.3)
        with pytest.raises(StudentStopped, match="did not answer"):
            student.f(np.zeros((1_000_000, 4)))


def test_a_forged_answer_counts_as_an_answer_and_no_more():
    """Answering before the question: the judge looks at the answer, which has to be right."""
    source = (
        PIPES
        + """
def f(number):
    say(ANSWER % (2, b'"forged"'))
    return "honest"
"""
    )
    with (
        attack(source) as student,
        pytest.raises(StudentStopped, match="did not answer the question"),
    ):
        student.f(1)
    source = (
        PIPES
        + """
def f(number):
    if number == 1:
        threading.Timer(0.1, say, [ANSWER % (2, b'"forged"')]).start()
    else:
        time.sleep(1)
"""
    )
    with attack(source) as student:
        student.f(1)
        assert student.f(2) == "forged", "a claim like any other"


def test_what_lives_on_after_a_call_cannot_touch_what_was_answered():
    source = """
import threading, time
KEPT = []
def vandal():
    while True:
        for array in KEPT:
            array[:] = 7
def f(array):
    if not KEPT:
        threading.Thread(target=vandal, daemon=True).start()
    result = array + 1
    KEPT.append(result)
    return array.copy()
"""
    with attack(source) as student:
        answers = [student.f(CLOUD.copy()) for _ in range(3)]
    assert all(np.array_equal(answer, CLOUD) for answer in answers)


def test_after_too_many_stops_the_rest_is_not_tried():
    with attack("import os\ndef f(): os._exit(3)", restarts=1) as student:
        for sentence in ("exit code 3", "exit code 3", "Not tried"):
            with pytest.raises(StudentStopped, match=sentence):
                student.f()


# ---- Values that misbehave ----------------------------------------------------------------


@pytest.mark.parametrize(
    "value",
    [
        "np.array([object()], dtype=object)",
        "np.zeros(3, dtype='V8')",
        "lambda: 0",
        "object()",
        "np.zeros(3, dtype=[('a', 'f8'), ('b', 'O')])",
        "np.array(['2020-01-01'], dtype='M8[D]')",
        "10**5000",
        "np.zeros(2, complex)",
        "range(3)",
        "np",
        "{(1, 2): 3}",
        "{frozenset([1])}",
        "np.zeros((1,) * 30)",
        "np.ma.masked_array([1.0], [True])",
        "np.matrix([[1, 2]])",
        "float('nan')",
        "'\\udcff'",
        "'\\x1b[2J'",
        "np.longdouble(3)",
        "(i for i in range(3))",
        "np.broadcast_to(1.0, (3, 1000))",
        "np.zeros((0, 2**40))",
        "type('X', (), {})()",
    ],
)
def test_any_value_comes_back_as_plain_data_or_stays_inside(value):
    answer = outcome_of(f"import numpy as np\ndef f(): return {value}")
    assert type(answer).__name__ in ("Opaque", "RemoteObject", "list", "ndarray", "float", "str")
    str(answer).encode()


@pytest.mark.parametrize(
    "body, sentence",
    [
        ("return np.zeros(2**26)", "more data than any answer needs"),
        ("return ['x' * 1000] * 20000", "more data than any answer needs"),
        ("class A:\n    def __array__(self, *a, **k): raise RuntimeError('no')\nreturn A()", "no"),
        ("class A(list):\n    def __iter__(self): raise ValueError('no')\nreturn A([1])", "no"),
        ("class A(int):\n    def __int__(self): return 'x' * 9\nreturn A()", "TypeError"),
        ("class E(Exception):\n    def __str__(self): raise self\nraise E", "E:"),
        ("class E(Exception):\n    def __str__(self): return 'x' * 10**8\nraise E", "xxx"),
        ("raise type('E' * 10**6, (Exception,), {})", "EEE"),
        ("raise Exception('\\x1b]0;owned\\x07\\x1b[2J\\u202e\\udcff one\\n\\ntwo')", "one two"),
        ("raise SystemExit(0)", "SystemExit"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("raise BaseExceptionGroup('x', [KeyboardInterrupt()])", "BaseExceptionGroup"),
        ("def g(): g()\ng()", "RecursionError"),
    ],
)
def test_any_failure_is_one_short_printable_line(body, sentence):
    body = "".join(f"    {line}\n" for line in body.splitlines())
    with attack(f"import numpy as np\ndef f():\n{body}", call_seconds=3.0) as student:
        with pytest.raises(StudentError) as raised:
            student.f()
        assert sentence in str(raised.value)
        assert str(raised.value).isprintable() and len(str(raised.value)) < 1500
        with pytest.raises(StudentError):
            student.f()  # the same worker goes on


def test_problems_are_few_and_printable():
    cells = [f"x{n} = f = 1 / 0 # \x1b[2J" for n in range(300)] + ["def f(): return 1"]
    cells += [f"f.y = \x1b{n}" for n in range(50)]
    with Student(cells, ("f",), WALLS, Limits(**SHORT)) as student:
        student.f()
    assert 20 <= len(student.problems) <= 40
    assert all(sentence.isprintable() for sentence in student.problems)


def test_tampering_with_python_only_hurts_the_tamperer():
    source = """
import builtins, json, numpy, os, struct, sys, time
def f(cloud):
    wire = sys.modules["wire"]
    wire.encode = lambda value: b"never"
    json.dumps = struct.pack = builtins.len = builtins.isinstance = lambda *a, **k: 0
    numpy.ndarray = numpy.asarray = None
    sys.modules.clear()
    return cloud
"""
    with attack(source) as student, pytest.raises((StudentStopped, StudentError)):
        student.f(CLOUD)


def test_changes_of_arguments_reach_only_copies_of_their_own_kind():
    source = (
        PIPES
        + """
def f(*arguments):
    say(b'{"dict":[["id",1],["result",null],["changed",{"dict":[[0,{"array":["<f8",[2]]}],'
        b'[1,{"list":[7]}],[2,"text"],[3,9],[-1,{"list":[]}],["x",2]]}]]}', b"\\0" * 16)
    time.sleep(9)
"""
    )
    frozen, numbers, text = np.ones(2), [1, 2], "unchanged"
    frozen.flags.writeable = False
    with attack(source) as student:
        student.f(frozen, numbers, text)
    assert np.array_equal(frozen, [1, 1]) and numbers == [7] and text == "unchanged"


# ---- Honest students are not taken for hostile ones -----------------------------------------


@pytest.mark.parametrize(
    "body",
    [
        "return [row for row in cloud]",
        "return {int(n) for n in range(9)} and cloud",
        "from concurrent.futures import ThreadPoolExecutor as P\n"
        "return np.array(list(P(8).map(lambda row: row, cloud)))",
        "import multiprocessing as m\nwith m.Pool(4) as p: p.map(abs, range(9))\nreturn cloud",
        "import scipy.spatial as s\ns.cKDTree(cloud).query(cloud, workers=2)\nreturn cloud",
        "import tempfile\nwith tempfile.TemporaryFile() as t: np.save(t, cloud)\nreturn cloud",
        "import subprocess\nsubprocess.run('ls -la | head', shell=True)\nreturn cloud",
        "import asyncio\nasync def a(): return cloud\nreturn asyncio.run(a())",
        "import matplotlib.pyplot as plt\nplt.plot(cloud[:9])\nplt.show()\nreturn cloud",
        "import warnings, sys\nprint('x' * 10**6, file=sys.stderr)\nwarnings.warn('y')\n"
        "return cloud",
    ],
)
def test_ordinary_code_works(body):
    body = "".join(f"    {line}\n" for line in body.splitlines())
    cloud = np.random.default_rng(1).normal(size=(20_000, 4))
    answer = outcome_of(f"import numpy as np\ndef f(cloud):\n{body}", cloud, call_seconds=10.0)
    assert np.array_equal(np.asarray(answer), cloud)


# ---- The notebook file --------------------------------------------------------------------


def notebook_of(*sources, **metadata):
    return {
        "nbformat": 4,
        "nbformat_minor": 5,
        "metadata": metadata,
        "cells": [
            {
                "cell_type": "code",
                "metadata": {},
                "source": source,
                "outputs": [],
                "execution_count": None,
            }
            for source in sources
        ],
    }


@pytest.mark.parametrize(
    "content",
    [
        [],
        3,
        None,
        "cells",
        {"cells": 3},
        {"cells": [3]},
        {"cells": [[]]},
        {"cells": [{}]},
        {"worksheets": [{}]},
        {"cells": [{"cell_type": "code"}]},
        {"cells": [{"cell_type": "code", "source": [[["deep"]]]}]},
        {"cells": [{"cell_type": "code", "source": 5}]},
        {"cells": [], "metadata": []},
    ],
)
def test_what_is_json_but_no_notebook_says_so(content, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(json.dumps(content))
    with pytest.raises(UnreadableNotebook):
        read_notebook(path)


@pytest.mark.parametrize(
    "text",
    [
        "[" * 500_000,
        '{"a":' * 500_000,
        '{"cells":[],"metadata":{"a":[' + "[]," * 2_100_000 + "[]]}}",
        "1" * 100_000,
        '{"cells": [NaN',
        "\0" * 100,
        '{"cells":[{"cell_type":"code","source":[' + "[" * 900 + "]" * 900 + "]}]}",
    ],
)
def test_what_is_made_to_break_the_reader_does_not(text, tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_text(text)
    with pytest.raises(UnreadableNotebook):
        read_notebook(path)


@pytest.mark.parametrize(
    "make",
    [
        lambda path, other: path.symlink_to(other),
        lambda path, other: path.symlink_to("/dev/zero"),
        lambda path, other: os.mkfifo(path),
        lambda path, other: path.mkdir(),
    ],
    ids=["link to another student", "endless device", "pipe", "folder"],
)
def test_only_a_file_of_ones_own_is_read(make, tmp_path):
    other = tmp_path / "other.ipynb"
    other.write_text(json.dumps(notebook_of("x = 1")))
    path = tmp_path / "06_filter_ground.ipynb"
    make(path, other)
    with pytest.raises(UnreadableNotebook, match="cannot be opened|not an ordinary file"):
        read_notebook(path)


def test_endless_files_are_not_read_to_their_end(tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    with path.open("wb") as file:
        file.truncate(2**40)
    with pytest.raises(UnreadableNotebook, match="larger than"):
        read_notebook(path)


@pytest.mark.parametrize(
    "cell",
    [
        "(" * 100_000,
        "x = " + "-" * 100_000 + "1",
        "x = " + "[" * 90 + "]" * 90,
        "f(" * 5000 + ")" * 5000,
        "x = '" + "a" * 10**6,
        "\0",
        "%%time\n" * 2000,
        "%" * 10_000,
        "?" * 10_000,
        "\\\n" * 10_000,
        "if x:\n" * 150,
        "1 if 1 else " * 3000 + "1",
        "x" + ".y" * 20_000,
        "x = 1" + " + 1" * 20_000,
        "\udcff = 1",
        "async with",
        "global f",
        "return 1",
        "from __future__ import braces",
        "from __future__ import annotations",
        "__name__ = '__main__'; __builtins__ = {}",
        "raise SystemExit",
        "import os; os.close(1)",
        pytest.param("x = !ls\n" * 501, marks=pytest.mark.slow, id="501 shell commands"),
    ],
)
def test_a_cell_that_breaks_parsers_costs_only_itself(cell):
    with Student([cell, "def f(): return 1"], ("f",), WALLS, Limits(**SHORT)) as student:
        assert student.f() == 1


def test_a_million_cells_end_in_a_verdict(hand_in):
    cells = ['{"cell_type":"code","source":"x=1"}'] * 700_000
    verdict = hand_in(
        text=f'{{"metadata":{{}},"cells":[{",".join(cells)}]}}',
        start_seconds=1.0,
        total_seconds=2.0,
    )
    assert verdict.score == 0 and verdict.seconds < 20


def test_metadata_and_outputs_decide_nothing(hand_in, filtering):
    honest = json.loads(fill_in(filtering, {}))
    for cell in honest["cells"]:
        grading = cell["metadata"].setdefault("nbgrader", {"grade_id": "test_filter_ground"})
        grading.update(points=10**6, grade=True, solution=False, locked=False, max_score=1e9)
        if cell["cell_type"] == "code":
            cell["outputs"] = [
                {
                    "output_type": "execute_result",
                    "execution_count": 1,
                    "metadata": {},
                    "data": {"text/plain": "1000000"},
                }
            ]
            cell["source"] += "\ncheck = print = lambda *a: 10**6"
    honest["metadata"]["verdict_key"] = "forged"
    verdict = hand_in(text=json.dumps(honest))
    assert verdict.score == 0 and verdict.max_score == 30


@pytest.mark.parametrize(
    "source",
    [
        "import grader.tests",
        "import utils.checks as c; c.core.CheckFailed = KeyError",
        "import pytest; pytest.exit('all passed', 0)",
        "from utils.checks import vocabulary as v; v.assert_rows = lambda *a, **k: None",
        "import os, signal; os.kill(os.getppid(), signal.SIGKILL)",
    ],
)
def test_nothing_of_the_judge_is_within_reach(source, hand_in):
    cheat = f"def {{name}}(*a, **k):\n    {source}\n    return a[0]\n"
    # Returning the cloud itself is right where nothing has to be removed, and nowhere else.
    assert hand_in({name: cheat.format(name=name) for name in EXERCISES}).score < 5


@pytest.mark.slow
@pytest.mark.parametrize(
    "claim",
    [
        "np.ones((2**23, cloud.shape[1]), bool)",
        "np.tile(cloud[:1], (2**18, 1))",
        "np.full(cloud.shape, np.nan)",
        "np.empty((0, 2**24))",
        "np.empty((2**24, 0))",
        "[[[cloud.tolist()]]]",
        "{1: cloud}",
        "'x' * 10**6",
        "[2**62] * 10**6",
        "10**30",
    ],
)
def test_huge_and_strange_claims_cost_the_judge_little(claim, hand_in):
    answers = {
        name: f"import numpy as np\ndef {name}(cloud, *a, **k): return {claim}\n"
        for name in EXERCISES
    }
    verdict = hand_in(answers, total_seconds=60.0, call_seconds=5.0)
    assert verdict.score < 10 and verdict.seconds < 60


# ---- What people read ---------------------------------------------------------------------


INJECTION = (
    "</td><script>alert(1)</script>\\x1b]0;owned\\x07 ![x](http://evil/x.png) "
    "[bold]{{ 7 * 7 }}\\u202e\\udcff"
)


def test_messages_are_text_in_the_verdict_the_report_and_the_feedback(hand_in, tmp_path):
    from grader.classroom.grade import Submission
    from grader.classroom.report import write_report
    from grader.course.paths import Course
    from grader.lms.nbgrader_plugin import score_output

    verdict = hand_in(
        {"filter_ground": f"def filter_ground(*a, **k):\n    raise Exception('{INJECTION}')\n"}
    )
    text = json.dumps(verdict.as_dict(), ensure_ascii=False)
    assert "\\u001b" not in text and "\x1b" not in text and "\u202e" not in text
    lesson = next(lesson for lesson in all_lessons() if lesson.name == verdict.lesson)
    submission = Submission("<script>alert(2)</script>", lesson, tmp_path / "x.ipynb")
    page = write_report(Course(tmp_path), [(submission, verdict)]).read_text("utf-8")
    assert "<script>" not in page and "&lt;script&gt;alert(1)" in page and "{{ 7" in page
    for exercise in verdict.exercises:
        assert "<script>" not in score_output(exercise)["data"]["text/html"]
