"""Work in a child process returns a result, or raises an error that states the reason."""

import json
import os
import re
import resource
import select
import signal
import time
from itertools import count

import pytest

from grader.classroom import pool
from grader.intake import reader_process
from tests.notebook_runs import child_processes
from utils.notebooks.reading import UnreadableNotebook


def loop_forever():
    for _ in count():
        pass


def match_slow_pattern():
    re.match("(a*)*b", "a" * 40)


def fill_memory():
    return [bytearray(2**24) for _ in range(1000)]


def return_long_answer():
    return "a" * (reader_process.MAX_REPLY_BYTES + 1)


def stop_own_process():
    os.kill(os.getpid(), signal.SIGSTOP)


def end_own_process():
    os._exit(0)


def sleep_long():
    time.sleep(1000)


def fail():
    raise RuntimeError("a fault of the grader")


def refuse():
    raise UnreadableNotebook("file.ipynb is empty.")


@pytest.fixture
def short_limits(monkeypatch):
    """Set small limits, and return a function that also shortens the wall-clock limit."""
    monkeypatch.setattr(reader_process, "CPU_SECONDS", 1)
    monkeypatch.setattr(reader_process, "MEGABYTES", 128)
    monkeypatch.setattr(reader_process, "MAX_REPLY_BYTES", 2**22)
    return lambda: monkeypatch.setattr(reader_process, "MAX_WAIT_SECONDS", 0.5)


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    ("work", "message"),
    [
        (loop_forever, "more than 1 seconds"),
        (match_slow_pattern, "more than 1 seconds"),
        (fill_memory, "more than 128 MB of memory"),
        (return_long_answer, "more than 128 MB of memory"),
    ],
)
def test_files_that_are_too_costly_get_a_message_with_the_limit(work, message, short_limits):
    with pytest.raises(reader_process.TooCostly) as caught:
        reader_process.run_in_child("file.ipynb", work)
    assert f"Reading file.ipynb takes {message}" in str(caught.value)
    assert "submit it again" in str(caught.value)


@pytest.mark.parametrize("work", [stop_own_process, end_own_process, sleep_long])
def test_a_child_without_an_answer_is_given_up_after_a_while(work, short_limits):
    short_limits()
    with pytest.raises(reader_process.ReadingFailed, match="did not reply within 0.5 seconds"):
        reader_process.run_in_child("file.ipynb", work)


def test_an_error_in_the_grader_is_not_reported_as_unreadable_file():
    with pytest.raises(reader_process.ReadingFailed, match="RuntimeError: a fault of the grader"):
        reader_process.run_in_child("file.ipynb", fail)


def test_the_readers_message_is_passed_on_unchanged():
    with pytest.raises(UnreadableNotebook) as caught:
        reader_process.run_in_child("file.ipynb", refuse)
    assert type(caught.value) is UnreadableNotebook
    assert str(caught.value) == "file.ipynb is empty."


def test_text_arrives_unchanged():
    for text in ("\udcff", "\U0001f697", "\0", "\u2028", "a" * 10**6):
        assert reader_process.run_in_child("file.ipynb", lambda text=text: text) == text


def test_the_result_is_the_same_without_fork(monkeypatch):
    monkeypatch.delattr(os, "fork")
    assert reader_process.run_in_child("file.ipynb", lambda: (1, "a")) == [1, "a"]


def test_no_open_files_or_processes_are_left(short_limits):
    def open_files():
        return sorted(os.listdir("/dev/fd"))

    short_limits()
    before, children_before = open_files(), child_processes()
    for work in (sleep_long, end_own_process, return_long_answer):
        with pytest.raises((reader_process.TooCostly, reader_process.ReadingFailed)):
            reader_process.run_in_child("file.ipynb", work)
    assert open_files() == before
    assert child_processes() <= children_before


def test_the_child_has_no_files_of_the_judge_open():
    """The child does not keep the judge's pipes open, so readers notice when the judge ends."""
    pipes = [os.pipe() for _ in range(2)]
    os.close(pipes[0][0])  # the child's own pipe will get this lower number
    open_numbers = reader_process.run_in_child(
        "file.ipynb", lambda: [int(name) for name in os.listdir("/dev/fd")]
    )
    for number in (pipes[0][1], *pipes[1]):
        os.close(number)
        assert number not in open_numbers
    assert len(open_numbers) <= 5
    reader_process.run_in_child(
        "file.ipynb", lambda: [os.fstat(number).st_ino for number in (0, 1, 2)]
    )


def test_the_child_uses_default_signal_handlers():
    """The child does not inherit handlers, even if the judge ignores the signals."""
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        names = (signal.SIGINT, signal.SIGTERM, signal.SIGXCPU)
        handlers = reader_process.run_in_child(
            "file.ipynb", lambda: [int(signal.getsignal(name)) for name in names]
        )
    finally:
        signal.signal(signal.SIGTERM, before)
    assert handlers == [int(signal.SIG_DFL)] * 3


# ---- limits -------------------------------------------------------------------------------------


@pytest.fixture
def limits(monkeypatch):
    """Return a function that returns the limits that the child sets under given hard limits."""

    def limits(hard):
        found = {}
        monkeypatch.setattr(resource, "getrlimit", lambda which: (0, hard))
        monkeypatch.setattr(resource, "setrlimit", found.__setitem__)
        reader_process._set_limits()
        return found

    return limits


def test_the_child_may_use_a_fixed_amount_of_additional_memory(limits):
    found = limits(resource.RLIM_INFINITY)
    with open("/proc/self/status") as file:
        used = next(int(line.split()[1]) for line in file if line.startswith("VmSize:")) * 1024
    assert {hard for _, hard in found.values()} == {resource.RLIM_INFINITY}
    assert found[resource.RLIMIT_CORE][0] == 0
    assert found[resource.RLIMIT_CPU][0] == reader_process.CPU_SECONDS
    assert found[resource.RLIMIT_AS][0] == pytest.approx(used + 768 * 2**20, abs=2**24)


def test_lower_hard_limits_are_respected(limits):
    assert limits(5) == {
        resource.RLIMIT_CORE: (0, 5),
        resource.RLIMIT_CPU: (5, 5),
        resource.RLIMIT_AS: (5, 5),
    }


def test_the_reply_limit_fits_the_largest_file_and_the_memory():
    assert 64 * 2**20 < reader_process.MAX_REPLY_BYTES < reader_process.MEGABYTES * 2**20


def test_the_longest_wait_is_long_enough_for_a_busy_machine():
    """The wait is long, because six seconds of work once took two minutes on a busy machine."""
    assert 50 * reader_process.CPU_SECONDS < reader_process.MAX_WAIT_SECONDS < pool.MAX_JOB_SECONDS


def test_the_exceeded_limit_follows_from_the_exit_code():
    for code in (0, 1, signal.SIGXCPU, -signal.SIGKILL, -signal.SIGSYS, 76, 78):
        assert reader_process._exceeded_limit(code, b"") == ""
    assert reader_process._exceeded_limit(-signal.SIGXCPU, b"") == "more than 10 seconds"
    assert (
        reader_process._exceeded_limit(reader_process._OUT_OF_MEMORY, b"")
        == "more than 768 MB of memory"
    )


# ---- answers ------------------------------------------------------------------------------------


class Pipe:
    """A replacement for `select.poll` and `os.read` that delivers the given parts."""

    def __init__(self, monkeypatch, parts, times=(100.0,)):
        self.parts, self.waited, self.sizes = list(parts), [], []
        clock = iter([*times, *[times[-1]] * 99])
        monkeypatch.setattr(select, "poll", lambda: self)
        monkeypatch.setattr(reader_process.time, "monotonic", lambda: next(clock))
        monkeypatch.setattr(os, "read", self.read)

    def register(self, pipe, event):
        assert (pipe, event) == (7, select.POLLIN)

    def poll(self, milliseconds):
        self.waited.append(milliseconds)
        return self.parts

    def read(self, pipe, size):
        self.sizes.append(size)
        return self.parts.pop(0)


def test_an_answer_is_read_until_its_end_or_its_deadline(monkeypatch):
    pipe = Pipe(monkeypatch, [b"ab", b"c", b"", b"never"], (100.0, 100.5, 104.0))
    assert reader_process._read_pipe(7, 102.0) == b"abc"
    assert pipe.waited == [2000.0, 1500.0, 0.0]  # a negative time would wait forever
    assert min(pipe.sizes) >= 2**16, "a pipe may contain this much"
    assert reader_process._read_pipe(7, 102.0) == b"never"


@pytest.mark.parametrize(("largest", "read"), [(3, b"abcd"), (4, b"abcdef"), (5, b"abcdef")])
def test_reading_stops_once_an_answer_is_too_long(largest, read, monkeypatch):
    monkeypatch.setattr(reader_process, "MAX_REPLY_BYTES", largest)
    Pipe(monkeypatch, [b"ab", b"cd", b"ef", b"gh"])
    assert reader_process._read_pipe(7, 102.0) == read
    assert reader_process._exceeded_limit(0, read) and not reader_process._exceeded_limit(
        0, read[:largest]
    )


def test_the_deadline_follows_from_the_patience(monkeypatch):
    deadlines = []

    def read(pipe, until):
        deadlines.append(until)
        return json.dumps(["done", 7]).encode()

    monkeypatch.setattr(reader_process, "_read_pipe", read)
    monkeypatch.setattr(reader_process, "MAX_WAIT_SECONDS", 60)
    monkeypatch.setattr(reader_process.time, "monotonic", lambda: 1000.5)
    assert reader_process.run_in_child("file.ipynb", sleep_long) == 7
    assert deadlines == [1060.5]


@pytest.mark.parametrize("reply", [b"", b"[", b"7", b"[" * 10**5])
def test_an_invalid_reply_counts_as_no_answer(reply, monkeypatch):
    monkeypatch.setattr(reader_process, "_read_pipe", lambda pipe, until: reply)
    with pytest.raises(reader_process.ReadingFailed, match="did not reply"):
        reader_process.run_in_child("file.ipynb", sleep_long)
