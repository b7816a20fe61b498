"""A check stops code that takes too much time or memory, and the notebook can continue."""

import contextlib
import signal
import subprocess
import sys
import threading
import time

import pytest

from grader.course.paths import PROJECT
from tests.artificial_checks import declare, forget_declarations, output_of
from tests.prerequisites import PATIENCE
from utils.checks import check, core
from utils.checks.limits import TimeUp, limit_resources


@pytest.fixture
def declarations(monkeypatch):
    forget_declarations(monkeypatch)


def endless(x):
    while True:
        x = x + 1


def ignores_interrupts(x):
    """Catch the first two interrupts, but not the third."""
    for _ in range(2):
        with contextlib.suppress(BaseException):
            endless(x)
    endless(x)


@pytest.mark.slow
@pytest.mark.parametrize("function", [endless, ignores_interrupts])
def test_a_loop_in_a_check_is_stopped(declarations, capsys, monkeypatch, function):
    monkeypatch.setattr(core, "SECONDS", 1)
    declare("one")(lambda double: None)
    declare("two")(lambda double: double(0))
    declare("three")(lambda double: None)
    start = time.monotonic()
    shown = output_of(function, capsys)
    assert time.monotonic() - start < PATIENCE
    assert "did not return within 1 s. It was in the loop in line" in shown
    assert "[passed] one" in shown and "[waiting] three" in shown


@pytest.mark.parametrize("handler", [signal.SIG_IGN, signal.SIG_DFL])
def test_the_time_limit_works_without_interrupts(handler):
    """The limit also works in background processes of scripts, which ignore interrupts."""

    def busy():
        end = time.monotonic() + 600
        while time.monotonic() < end:
            pass

    before = signal.signal(signal.SIGINT, handler)
    try:
        with pytest.raises(TimeUp), limit_resources(0.1):
            busy()
        assert signal.getsignal(signal.SIGINT) is handler
    finally:
        signal.signal(signal.SIGINT, before)


def test_a_check_may_have_its_own_question_about_a_timeout(declarations, capsys, monkeypatch):
    monkeypatch.setattr(core, "SECONDS", 1)
    declare("one", slow="is every point visited twice?")(lambda double: double(0))
    shown = output_of(endless, capsys)
    assert "`. Is every point visited twice? If" in shown and "never ends" not in shown


def test_the_time_limit_does_not_suppress_an_interrupt():
    with pytest.raises(KeyboardInterrupt), limit_resources(30):
        raise KeyboardInterrupt


def test_the_time_limit_never_interrupts_later_code():
    for _ in range(20):
        try:
            with limit_resources(0.002):
                time.sleep(0.002)
        except TimeUp:
            pass
    time.sleep(0.05)
    assert not [thread for thread in threading.enumerate() if thread.name.endswith("(ring)")]


def fail_to_start(self):
    raise RuntimeError("can't start new thread")


def busy_for(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


def test_an_endless_loop_is_stopped_even_without_threads(monkeypatch):
    monkeypatch.setattr(threading.Thread, "start", fail_to_start)
    start = time.monotonic()
    with pytest.raises(TimeUp), limit_resources(0.1):
        busy_for(600)
    assert time.monotonic() - start < PATIENCE
    with limit_resources(20):
        busy_for(0.01)
    assert sys.gettrace() is None


def test_a_limit_that_passes_at_the_end_of_a_call_does_not_escape(monkeypatch):
    """Without threads, the end of the context would be the first code that could be interrupted."""
    monkeypatch.setattr(threading.Thread, "start", fail_to_start)
    with limit_resources(0.01):
        time.sleep(0.05)
    assert sys.gettrace() is None


def test_a_check_prints_the_same_text_without_threads(declarations, capsys, monkeypatch):
    monkeypatch.setattr(core, "SECONDS", 0.5)
    monkeypatch.setattr(threading.Thread, "start", fail_to_start)
    declare("one")(lambda double: double(0))
    assert "was in the loop in line" in output_of(endless, capsys)
    check(lambda x: x, "double")
    assert "[passed] one" in capsys.readouterr().out


def test_nothing_is_limited_in_another_thread():
    found = []

    def work():
        with limit_resources(0.01):
            time.sleep(0.05)
            found.append(1)

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert found == [1]


@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="only Linux says how much memory is free"
)
def test_too_much_memory_is_an_error_and_not_a_crash():
    script = """
import numpy as np
from utils.checks.limits import limit_resources
try:
    with limit_resources(20):
        np.ones(2**50)
except MemoryError:
    print("caught")
kept = np.ones(10**7)
print(kept.size)
"""
    ran = subprocess.run(
        [sys.executable, "-c", script], cwd=PROJECT, capture_output=True, text=True
    )
    assert ran.stdout.split() == ["caught", "10000000"], ran.stderr
