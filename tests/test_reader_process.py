"""What is done in a process of its own: it comes back, or a sentence says why it does not."""

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
from tests.notebook_runs import children
from utils.notebooks.reading import UnreadableNotebook


def for_ever():
    for _ in count():
        pass


def in_a_pattern():
    re.match("(a*)*b", "a" * 40)


def fill_the_memory():
    return [bytearray(2**24) for _ in range(1000)]


def answer_at_length():
    return "a" * (reader_process.LARGEST_REPLY + 1)


def stop_its_process():
    os.kill(os.getpid(), signal.SIGSTOP)


def end_its_process():
    os._exit(0)


def wait():
    time.sleep(1000)


def fail():
    raise RuntimeError("a fault of ours")


def refuse():
    raise UnreadableNotebook("file.ipynb is empty.")


@pytest.fixture
def soon(monkeypatch):
    """Small limits; the clock on the wall goes fast only where a test says so."""
    monkeypatch.setattr(reader_process, "SECONDS", 1)
    monkeypatch.setattr(reader_process, "MEGABYTES", 128)
    monkeypatch.setattr(reader_process, "LARGEST_REPLY", 2**22)
    return lambda: monkeypatch.setattr(reader_process, "PATIENCE", 0.5)


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    ("work", "says"),
    [
        (for_ever, "more than 1 seconds"),
        (in_a_pattern, "more than 1 seconds"),
        (fill_the_memory, "more than 128 MB of memory"),
        (answer_at_length, "more than 128 MB of memory"),
    ],
)
def test_too_much_is_said_in_a_sentence(work, says, soon):
    with pytest.raises(reader_process.TooCostly) as caught:
        reader_process.run_in_child("file.ipynb", work)
    assert f"Reading file.ipynb takes {says}" in str(caught.value)
    assert "hand it in again" in str(caught.value)


@pytest.mark.parametrize("work", [stop_its_process, end_its_process, wait])
def test_who_gives_no_answer_is_waited_for_so_long(work, soon):
    soon()
    with pytest.raises(reader_process.ReadingFailed, match="no answer within 0.5 seconds"):
        reader_process.run_in_child("file.ipynb", work)


def test_a_fault_of_ours_is_no_fault_of_the_file():
    with pytest.raises(reader_process.ReadingFailed, match="RuntimeError: a fault of ours"):
        reader_process.run_in_child("file.ipynb", fail)


def test_what_cannot_be_read_is_said_as_the_reader_said_it():
    with pytest.raises(UnreadableNotebook) as caught:
        reader_process.run_in_child("file.ipynb", refuse)
    assert type(caught.value) is UnreadableNotebook
    assert str(caught.value) == "file.ipynb is empty."


def test_words_arrive_as_they_are():
    for text in ("\udcff", "\U0001f697", "\0", "\u2028", "a" * 10**6):
        assert reader_process.run_in_child("file.ipynb", lambda text=text: text) == text


def test_where_no_process_can_be_forked_the_same_comes_back(monkeypatch):
    monkeypatch.delattr(os, "fork")
    assert reader_process.run_in_child("file.ipynb", lambda: (1, "a")) == [1, "a"]


def test_nothing_is_left_behind(soon):
    def open_files():
        return sorted(os.listdir("/dev/fd"))

    soon()
    before, others = open_files(), children()
    for work in (wait, end_its_process, answer_at_length):
        with pytest.raises((reader_process.TooCostly, reader_process.ReadingFailed)):
            reader_process.run_in_child("file.ipynb", work)
    assert open_files() == before
    assert children() <= others


def test_nobodys_files_are_held_open():
    """Whoever waits for the end of what judges does not wait for what it began."""
    pipes = [os.pipe() for _ in range(2)]
    os.close(pipes[0][0])  # so that its own have a lower number than another
    held = reader_process.run_in_child(
        "file.ipynb", lambda: [int(name) for name in os.listdir("/dev/fd")]
    )
    for number in (pipes[0][1], *pipes[1]):
        os.close(number)
        assert number not in held
    assert len(held) <= 5
    reader_process.run_in_child(
        "file.ipynb", lambda: [os.fstat(number).st_ino for number in (0, 1, 2)]
    )


def test_what_works_apart_ends_as_it_is_told_to(monkeypatch):
    """Whatever the judge itself does when it is told to."""
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        names = (signal.SIGINT, signal.SIGTERM, signal.SIGXCPU)
        asked = reader_process.run_in_child(
            "file.ipynb", lambda: [int(signal.getsignal(name)) for name in names]
        )
    finally:
        signal.signal(signal.SIGTERM, before)
    assert asked == [int(signal.SIG_DFL)] * 3


# ---- limits -------------------------------------------------------------------------------------


@pytest.fixture
def limits(monkeypatch):
    """A function that gives the limits that are set where there are such hard ones."""

    def limits(hard):
        found = {}
        monkeypatch.setattr(resource, "getrlimit", lambda which: (0, hard))
        monkeypatch.setattr(resource, "setrlimit", found.__setitem__)
        reader_process._limit()
        return found

    return limits


def test_what_works_apart_may_take_so_much_more_than_it_has(limits):
    found = limits(resource.RLIM_INFINITY)
    with open("/proc/self/status") as file:
        has = next(int(line.split()[1]) for line in file if line.startswith("VmSize:")) * 1024
    assert {hard for _, hard in found.values()} == {resource.RLIM_INFINITY}
    assert found[resource.RLIMIT_CORE][0] == 0
    assert found[resource.RLIMIT_CPU][0] == reader_process.SECONDS
    assert found[resource.RLIMIT_AS][0] == pytest.approx(has + 768 * 2**20, abs=2**24)


def test_where_less_is_allowed_it_is_less(limits):
    assert limits(5) == {
        resource.RLIMIT_CORE: (0, 5),
        resource.RLIMIT_CPU: (5, 5),
        resource.RLIMIT_AS: (5, 5),
    }


def test_the_largest_file_has_an_answer_and_no_answer_fills_the_memory():
    assert 64 * 2**20 < reader_process.LARGEST_REPLY < reader_process.MEGABYTES * 2**20


def test_a_machine_that_has_much_else_to_do_may_take_its_time():
    """It took two minutes for six seconds beside what was more important than it."""
    assert 50 * reader_process.SECONDS < reader_process.PATIENCE < pool.LONGEST


def test_which_end_is_too_much():
    for code in (0, 1, signal.SIGXCPU, -signal.SIGKILL, -signal.SIGSYS, 76, 78):
        assert reader_process._excess(code, b"") == ""
    assert reader_process._excess(-signal.SIGXCPU, b"") == "more than 10 seconds"
    assert (
        reader_process._excess(reader_process._OUT_OF_MEMORY, b"") == "more than 768 MB of memory"
    )


# ---- answers ------------------------------------------------------------------------------------


class Pipe:
    """What `select.poll` and `os.read` know of a pipe into which these parts are written."""

    def __init__(self, monkeypatch, parts, times=(100.0,)):
        self.parts, self.waited, self.asked_for = list(parts), [], []
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
        self.asked_for.append(size)
        return self.parts.pop(0)


def test_an_answer_is_read_until_it_ends_or_its_time_is_over(monkeypatch):
    pipe = Pipe(monkeypatch, [b"ab", b"c", b"", b"never"], (100.0, 100.5, 104.0))
    assert reader_process._read(7, 102.0) == b"abc"
    assert pipe.waited == [2000.0, 1500.0, 0.0]  # a negative time is for ever
    assert min(pipe.asked_for) >= 2**16, "a pipe holds as much"
    assert reader_process._read(7, 102.0) == b"never"


@pytest.mark.parametrize(("largest", "read"), [(3, b"abcd"), (4, b"abcdef"), (5, b"abcdef")])
def test_no_more_is_read_than_shows_that_it_is_too_much(largest, read, monkeypatch):
    monkeypatch.setattr(reader_process, "LARGEST_REPLY", largest)
    Pipe(monkeypatch, [b"ab", b"cd", b"ef", b"gh"])
    assert reader_process._read(7, 102.0) == read
    assert reader_process._excess(0, read) and not reader_process._excess(0, read[:largest])


def test_an_answer_has_until_then(monkeypatch):
    asked = []

    def read(pipe, until):
        asked.append(until)
        return json.dumps(["done", 7]).encode()

    monkeypatch.setattr(reader_process, "_read", read)
    monkeypatch.setattr(reader_process, "PATIENCE", 60)
    monkeypatch.setattr(reader_process.time, "monotonic", lambda: 1000.5)
    assert reader_process.run_in_child("file.ipynb", wait) == 7
    assert asked == [1060.5]


@pytest.mark.parametrize("reply", [b"", b"[", b"7", b"[" * 10**5])
def test_what_is_no_answer_is_none(reply, monkeypatch):
    monkeypatch.setattr(reader_process, "_read", lambda pipe, until: reply)
    with pytest.raises(reader_process.ReadingFailed, match="gave no answer"):
        reader_process.run_in_child("file.ipynb", wait)
