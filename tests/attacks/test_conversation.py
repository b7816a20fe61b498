"""Attacks through replies to the judge: invalid messages, deceptive values and odd exceptions."""

import os
import re
import threading
import time

import numpy as np
import pytest

from grader.sandbox import Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.inside.wire_format import OpaqueValue
from grader.sandbox.program import Program
from grader.sandbox.student import RemoteObject, StudentProxy
from tests.attacks.attack import (
    CLOUD,
    SANDBOX,
    SHORT,
    attack,
    function,
    outcome_of,
    with_attacks,
)
from tests.prerequisites import PATIENCE

pytestmark = pytest.mark.slow

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
ANSWER = b'{"dict":[["id",%d],["result",%s]]}'
"""


@with_attacks(
    "body, sentence",
    {
        "writes plain text": ("os.write(pipes()[1][0], b'full marks, please' * 9)", "own channel"),
        "writes the largest possible header": (
            "os.write(pipes()[1][0], b'\\xff' * 8)",
            "own channel",
        ),
        "sends a pickle": ('say(b\'{"pickle":"x"}\')', "own channel"),
        "sends a hundred thousand brackets": ("say(b'[' * 100000)", "own channel"),
        "sends an integer with a hundred thousand digits": ("say(b'1' * 100000)", "own channel"),
        "sends a list instead of a message": ("say(b'[]')", "own channel"),
        "sends a string instead of a message": ("say(b'\"hello\"')", "sent an invalid reply"),
        "answers a later call": ("say(ANSWER % (99, b'1'))", "sent an invalid reply"),
        "sends True as the ID": (
            'say(b\'{"dict":[["id",true]]}\')',
            "sent an invalid reply",
        ),
        "sends an array as the ID": (
            'say(b\'{"dict":[["id",{"array":["|u1",[2]]}]]}\', b\'ab\')',
            "sent an invalid reply",
        ),
        "sends a generator without a state": (
            'say(b\'{"generator":["0x0","0x0",0,[]]}\')',
            "own channel",
        ),
        "sends a generator with an enormous state": (
            "say(b'{\"generator\":[\"0x' + b'f' * 10**6 + b'\",\"0x1\",0,0]}')",
            "own channel",
        ),
        "sends half a reply": (
            "os.write(pipes()[1][0], struct.pack('>II', 100, 0)); time.sleep(60)",
            "did not answer",
        ),
        "closes the pipes and keeps running": (
            "for end in sum(pipes(), []): os.close(end)\ntime.sleep(60)",
            "ended|did not answer",
        ),
        "stops itself": ("os.kill(os.getpid(), 19)", "did not answer"),
        "runs forever": ("while True: pass", "did not answer"),
        "runs forever with an undecodable process name": (
            "import ctypes; ctypes.CDLL(None).prctl(15, b'\\xff\\xfe')\nwhile True: pass",
            "did not answer",
        ),
        "sleeps": ("time.sleep(600)", "did not answer"),
        "exits during a call": ("os._exit(0)", "ended"),
        "exits with code 0": (
            "try: os.kill(os.getppid(), 15)\nfinally: os._exit(0)",
            "ended",
        ),
        "kills itself": ("os.kill(os.getpid(), 9)", "or code in the notebook killed it"),
        "crashes": ("import ctypes; ctypes.string_at(1)", "crashed"),
        "exits but leaves a child running": ("if os.fork(): os._exit(0)\ntime.sleep(60)", "ended"),
        "replaces itself with another program": (
            "import sys\np = sys.executable\nos.execv(p, [p, '-c', 'import time; time.sleep(60)'])",
            "did not answer",
        ),
        "sends a reply byte by byte": (
            """
write = pipes()[1][0]
os.write(write, struct.pack(">II", 100, 30 * 2**20) + b" " * 100)
while True: os.write(write, b" ")
""",
            "did not answer",
        ),
        "sends a string as the changed arguments": (
            'say(b\'{"dict":[["id",2],["result",1],["arguments","none"]]}\'); time.sleep(9)',
            "sent an invalid reply",
        ),
        "sends too few changed arguments": (
            'say(b\'{"dict":[["id",2],["result",1],["arguments",{"list":[]}]]}\'); time.sleep(9)',
            "sent an invalid reply",
        ),
    },
)
def test_an_invalid_reply_stops_the_student(body, sentence):
    source = PIPES + function(body)
    start = time.monotonic()
    with attack(source, call_seconds=0.5) as student, pytest.raises(StudentStopped) as stopped:
        if '"arguments"' in body:
            student._calls = 1
            student.f.observe(1)
        for number in range(3):
            student.f(number)
    assert re.search(sentence, str(stopped.value))
    assert time.monotonic() - start < PATIENCE


# Code that sends every reply after the first in pieces.
PIECES = """
import os, time
write = os.write
def drip(end, data):
    written = write(end, data[:10])
    time.sleep(0.2)
    return written
def f(number):
    os.write = drip
    return float(number)
"""


def test_a_reply_in_pieces_has_the_full_time_limit():
    with attack(PIECES, call_seconds=5.0) as student:
        assert student.f(1) == 1.0
        assert not student.starved


def test_the_time_of_a_reply_in_pieces_is_charged_to_the_notebook():
    with (
        attack(PIECES, call_seconds=2.0, total_seconds=1.6) as student,
        pytest.raises(StudentStopped, match="did not answer"),
    ):
        for number in range(20):
            student.f(number)


def test_the_judge_never_blocks_in_a_read_or_write():
    """The pipes do not block, because student code can read output that `poll` has reported."""
    worker = SANDBOX.start(Limits())
    try:
        assert not os.get_blocking(worker.read_end)
        assert not os.get_blocking(worker.write_end)
    finally:
        worker.stop()


def test_a_request_that_is_not_read_stops_the_student():
    source = """
import os, threading
def f(cloud): threading.Timer(0.05, os.kill, (os.getpid(), 19)).start()
"""
    with attack(source) as student:
        student.f(CLOUD)
        time.sleep(0.3)
        with pytest.raises(StudentStopped, match="did not answer"):
            student.f(np.zeros((1_000_000, 4)))


def test_reading_the_request_before_the_worker_stops_the_student():
    """Student code that takes a request from the worker is stopped, because no reply is sent.

    A signal handler in the student's code reads the request while the worker waits for it.
    """
    body = """
def thief(*anything):
    select.select([pipes()[0][0]], [], [])
    os.read(pipes()[0][0], 10**6)
signal.signal(signal.SIGALRM, thief)
signal.setitimer(signal.ITIMER_REAL, 0.2)
"""
    source = PIPES + "import signal\n" + function(body)
    with attack(source) as student:
        student.f(1)
        time.sleep(0.5)
        with pytest.raises(StudentStopped, match="did not answer"):
            student.f(1)


def test_a_thread_that_races_the_worker_for_a_request_gains_nothing():
    """If the worker wins the race, its answer is honest. Otherwise, the student is stopped."""
    body = """
def thief():
    while True:
        select.select([pipes()[0][0]], [], [])
        os.read(pipes()[0][0], 10**6)
if arguments[0] == 0:
    threading.Thread(target=thief, daemon=True).start()
return arguments[0]
"""
    with attack(PIPES + function(body)) as student:
        try:
            assert [student.f(number) for number in range(20)] == list(range(20))
        except StudentStopped as stopped:
            assert re.search("did not answer|own channel|ended", str(stopped))


def test_a_forged_answer_is_checked_like_any_other_answer():
    """An answer sent before its call is refused; a forged one sent during its call counts."""
    source = PIPES + function("say(ANSWER % (2, b'\"forged\"'))\nreturn 'honest'")
    with (
        attack(source) as student,
        pytest.raises(StudentStopped, match="sent an invalid reply"),
    ):
        student.f(1)
    body = """
if arguments[0] == 1:
    threading.Timer(0.1, say, [ANSWER % (2, b'"forged"')]).start()
else:
    time.sleep(1)
"""
    with attack(PIPES + function(body)) as student:
        student.f(1)
        assert student.f(2) == "forged", "the forged answer is checked like any other"


def test_an_answer_cannot_be_changed_after_it_was_sent():
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


def test_calls_are_skipped_when_restarts_run_out():
    with attack("import os\ndef f(): os._exit(3)", restarts=1) as student:
        for sentence in ("os._exit", "os._exit", "Not run"):
            with pytest.raises(StudentStopped, match=sentence):
                student.f()


def test_an_exercise_that_exits_does_not_affect_other_exercises():
    cells = ("import os\ndef f(): os._exit(3)\ndef g(): return 1",)
    with StudentProxy(Program(cells, ("f", "g")), SANDBOX, Limits(**SHORT)) as student:
        for _ in range(4):
            student.exercise = "f"
            with pytest.raises(StudentStopped):
                student.f()
        student.exercise = "g"
        assert student.g() == 1


def test_an_endless_chain_of_attributes_is_supported():
    source = "class N:\n    @property\n    def left(self): return N()\ndef f(): return N()"
    with attack(source) as student:
        node = student.f()
        for _ in range(200):
            node = node.left
            assert isinstance(node, RemoteObject)
        with pytest.raises(AttributeError):
            _ = node._student._private


def test_forged_object_numbers_are_refused():
    """Only the judge can use an object's number, so student code gains nothing by sending one."""
    source = PIPES + function(
        'say(b\'{"dict":[["id",1],["object",{"list":[1]}],["type","x"]]}\'); time.sleep(2)'
    )
    with attack(source) as student, pytest.raises(StudentStopped, match="sent an invalid"):
        student.f(1)


def test_forged_attributes_are_ignored():
    """The judge ignores forged attributes, including those with invalid object numbers or names."""
    source = function("return Thing()") + "class Thing:\n    first = 1\n"
    with attack(source) as student:
        thing = student.f(1)
        number = thing._reference.number
        forged = {"first": 5, "b": {"object": [1]}, 3: {"result": 1}}
        student._remember([[number, forged], "xy", [1], [None, forged], [number, 7]])
        student._remember({number: forged})
        assert thing.first == 1
        with pytest.raises(StudentError, match="no attribute 'b'"):
            _ = thing.b


# ---- Deceptive values ----------------------------------------------------------------------


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
        "-10**5000",
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
        "np.zeros((0, 10**9))",
        "type('X', (), {})()",
        "np.random.default_rng(1)",
        "memoryview(b'x')",
        "__import__('utils').anything",
        "__import__('utils').plots.draw(1)",
    ],
)
def test_strange_values_arrive_as_plain_types(value):
    answer = outcome_of(f"import numpy as np\ndef f(): return {value}")
    kinds = ("OpaqueValue", "RemoteObject", "list", "ndarray", "float", "str", "Generator")
    assert type(answer).__name__ in kinds
    if isinstance(answer, (OpaqueValue, RemoteObject)):
        assert re.fullmatch(r"[a-zA-Z0-9_ ]+", answer.type_name)
    str(answer).encode()


@with_attacks(
    "body",
    {
        "a list that reports an enormous length": """
class A(list):
    def __len__(self): return 10**12
return A([1.0])
""",
        "a list with an endless iterator": """
class A(list):
    def __iter__(self):
        while True: yield 1.0
return A([1.0])
""",
        "an object that is a different array each time": """
class A:
    n = 0
    def __array__(self, *a, **k):
        A.n += 1
        return np.full(A.n, 1.0)
return A()
""",
        "a large array that claims to be small": """
class A(np.ndarray):
    nbytes = size = 0
    shape = (0,)
return np.zeros(2**24).view(A)
""",
        "an array with a forged tolist": """
class A(np.ndarray):
    def tolist(self): return ["forged"]
return np.zeros(3).view(A)
""",
        "an object that claims to be an array": """
class A:
    __class__ = np.ndarray
    dtype, shape, nbytes, size = np.dtype(float), (2,), 16, 2
return A()
""",
        "a dict with endless items": """
class A(dict):
    def items(self):
        while True: yield 1, 1
return A({1: 1})
""",
        "an int that changes its value": """
class A(int):
    def __lt__(self, other): return True
    def __ge__(self, other): return True
    def __int__(self): return 2**70
return A(5)
""",
        "a list that contains itself": "a = []\na.append(a)\nreturn a",
        "a list nested ten thousand levels deep": """
a = []
for _ in range(10_000): a = [a]
return a
""",
        "an object that claims to be a random generator": """
class Generator:
    bit_generator = np.random.PCG64()
class State(np.random.PCG64):
    state = {"state": {"state": "x", "inc": []}, "has_uint32": {}, "uinteger": None}
g = Generator()
g.bit_generator = State()
return g
""",
    },
)
def test_deceptive_values_arrive_as_plain_data(body):
    """The judge receives plain data that cannot change, or the call raises an error."""
    source = "import numpy as np\n" + function(body)
    with attack(source, call_seconds=2.0, memory=2**30) as student:
        try:
            answer = student.f()
        except (StudentError, StudentStopped):
            return
        plain = (np.ndarray, list, int, float, OpaqueValue, RemoteObject)
        assert type(answer) in plain
        assert not isinstance(answer, np.ndarray) or answer.nbytes <= 2**25
        assert repr(answer) == repr(answer) and len(repr(answer)) < 10_000


@with_attacks(
    "body, sentence",
    {
        "a huge array": ("return np.zeros(2**26)", "more data than any answer needs"),
        "a huge list": ("return ['x' * 1000] * 20000", "more data than any answer needs"),
        "300,000 empty lists": (
            "return [[]] * 300_000",
            "more data than any answer needs",
        ),
        "an array that cannot be read": (
            "class A:\n    def __array__(self, *a, **k): raise RuntimeError('no')\nreturn A()",
            "no",
        ),
        "a list that cannot be read": (
            "class A(list):\n    def __iter__(self): raise ValueError('no')\nreturn A([1])",
            "no",
        ),
        "an int that converts to a string": (
            "class A(int):\n    def __int__(self): return 'x' * 9\nreturn A()",
            "TypeError",
        ),
        "an exception whose message cannot be read": (
            "class E(Exception):\n    def __str__(self): raise self\nraise E",
            "E:",
        ),
        "an exception with a message of 100 MB": (
            "class E(Exception):\n    def __str__(self): return 'x' * 10**8\nraise E",
            "xxx",
        ),
        "an exception with a name of 1 MB": (
            "raise type('E' * 10**6, (Exception,), {})",
            "EEE",
        ),
        "an exception with terminal commands in its message": (
            "raise Exception('\\x1b]0;owned\\x07\\x1b[2J\\u202e\\udcff one\\n\\ntwo')",
            "one two",
        ),
        "an exception with terminal commands in its name": (
            "raise type('E\\x1b[2J\\n\\u202eE', (Exception,), {})('said')",
            "said",
        ),
        "SystemExit": ("raise SystemExit(0)", "SystemExit"),
        "KeyboardInterrupt": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        "a group of exceptions": (
            "raise BaseExceptionGroup('x', [KeyboardInterrupt()])",
            "BaseExceptionGroup",
        ),
        "500 nested exception groups": (
            "e = ValueError('deep')\nfor _ in range(500): e = ExceptionGroup('x', [e])\nraise e",
            "ExceptionGroup",
        ),
        "an exception with notes": (
            "e = ValueError('x')\ne.add_note('y' * 10**7)\nraise e",
            "ValueError: x",
        ),
        "endless recursion": ("def g(): g()\ng()", "RecursionError"),
    },
)
def test_strange_failures_get_a_short_message(body, sentence):
    """The message is one short printable line, and the worker answers the next call."""
    with attack("import numpy as np\n" + function(body), call_seconds=3.0) as student:
        with pytest.raises(StudentError) as raised:
            student.f()
        assert sentence in str(raised.value)
        assert str(raised.value).isprintable() and len(str(raised.value)) < 1500
        with pytest.raises(StudentError):
            student.f()


def test_problems_are_limited_and_printable():
    cells = [f"x{n} = f = 1 / 0 # \x1b[2J" for n in range(300)] + ["def f(): return 1"]
    cells += [f"f.y = \x1b{n}" for n in range(50)]
    with StudentProxy(Program(tuple(cells), ("f",)), SANDBOX, Limits(**SHORT)) as student:
        student.f()
    assert 20 < len(student.problems) <= 30
    assert all(sentence.isprintable() for sentence in student.problems)


@with_attacks(
    "body",
    {
        "the wire": "sys.modules['wire'].encode = lambda value: b'never'",
        "the slicer": "sys.modules['utils.notebooks.slicing'].slice_for = None\n"
        "sys.modules['wire'].send = lambda *a: None",
        "the builtins": "builtins.len = builtins.isinstance = lambda *a, **k: 0",
        "json and struct": "json.dumps = struct.pack = lambda *a, **k: 0",
        "numpy": "numpy.ndarray = numpy.asarray = None",
        "all modules": "sys.modules.clear()\nsys.modules['wire'] = None\nbuiltins.type = None",
        "the description of exceptions": """
class E(Exception):
    __traceback__ = property(lambda self: [][0])
raise E
""",
        "the calling frames": "frame = sys._getframe(1)\n"
        "frame.f_globals['reply'] = frame.f_globals['answer'] = None",
    },
)
def test_tampering_with_python_does_not_affect_other_students(body):
    """Student code can change only its own Python. The next student gets a new process."""
    source = "import builtins, json, numpy, struct, sys\n" + function(
        body + "\nreturn cloud", parameters="cloud"
    )
    with attack(source) as student:
        for _ in range(2):
            try:
                answer = student.f(CLOUD)
            except (StudentStopped, StudentError):
                continue
            assert np.array_equal(answer, CLOUD), "the answer has been changed"
    assert np.array_equal(outcome_of("def f(cloud): return cloud", CLOUD), CLOUD)


# ---- Changed arguments ------------------------------------------------------------------------


def test_overwriting_arguments_changes_only_copies():
    """The judge's own arguments do not change; `observe` returns the changed copies."""
    body = "for a in arguments:\n    a[:] = [9] * len(a)\nreturn arguments[0]"
    array, numbers = np.ones(2), [1, 2]
    with attack(function(body)) as student:
        seen = student.f.observe(array, numbers)
    assert np.array_equal(array, [1, 1]) and numbers == [1, 2]
    assert np.array_equal(seen.arguments[0], [9, 9]) and seen.arguments[1] == [9, 9]
    assert seen.shared_arguments == {0}


def test_forged_changes_of_arguments_affect_only_copies():
    """A forged report of changed arguments cannot change the judge's objects."""
    forged = (
        'say(b\'{"dict":[["id",1],["result",null],["shared",{"list":["x",-1,true,99]}],'
        '["arguments",{"list":[{"array":["<f8",[2]]},{"list":[7]},null]}]]}\', b"\\0" * 16)\n'
        "time.sleep(9)"
    )
    frozen, numbers, text = np.ones(2), [1, 2], "unchanged"
    frozen.flags.writeable = False
    with attack(PIPES + function(forged)) as student:
        seen = student.f.observe(frozen, numbers, text)
    assert np.array_equal(frozen, [1, 1]) and numbers == [1, 2] and text == "unchanged"
    assert seen.arguments[1:] == ([7], None) and seen.shared_arguments == {-1, 99}


# ---- Honest code is not refused --------------------------------------------------------------


@with_attacks(
    "body",
    {
        "a list of rows": "return [row for row in cloud]",
        "a set as an intermediate step": "return {int(n) for n in range(9)} and cloud",
        "threads": "from concurrent.futures import ThreadPoolExecutor as P\n"
        "return np.array(list(P(8).map(lambda row: row, cloud)))",
        "processes": "import multiprocessing as m\n"
        "with m.Pool(4) as p: p.map(abs, range(9))\nreturn cloud",
        "a SciPy tree": "import scipy.spatial as s\n"
        "s.cKDTree(cloud).query(cloud, workers=2)\nreturn cloud",
        "a temporary file": "import tempfile\n"
        "with tempfile.TemporaryFile() as t: np.save(t, cloud)\nreturn cloud",
        "a shell": "import subprocess\nsubprocess.run('ls -la | head', shell=True)\nreturn cloud",
        "coroutines": "import asyncio\nasync def a(): return cloud\nreturn asyncio.run(a())",
        "a figure": "import matplotlib.pyplot as plt\n"
        "plt.plot(cloud[:9])\nplt.show()\nreturn cloud",
        "warnings": "import warnings, sys\nprint('x' * 10**6, file=sys.stderr)\n"
        "warnings.warn('y')\nreturn cloud",
        "a plot from the course": "from utils import plots, check\n"
        "plots.side(cloud)\ncheck(len)\nreturn cloud",
    },
)
def test_ordinary_code_works(body):
    cloud = np.random.default_rng(1).normal(size=(20_000, 4))
    source = "import numpy as np\n" + function(body, parameters="cloud")
    answer = outcome_of(source, cloud, call_seconds=10.0, start_seconds=30.0, total_seconds=60.0)
    assert np.array_equal(np.asarray(answer), cloud)


def test_concurrent_judge_threads_get_their_own_answers():
    def call(number, answers):
        answers[number] = outcome_of("def f(n): return n", number, start_seconds=30.0)

    answers = {}
    threads = [threading.Thread(target=call, args=(number, answers)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == {number: number for number in range(4)}
