"""A judging process that dies or hangs does not affect the other processes of the pool."""

import os
import struct
import sys
import time
from concurrent.futures import BrokenExecutor, CancelledError

import pytest

from grader.classroom import pool
from grader.classroom.pool import Pool
from tests.prerequisites import PATIENCE

pytestmark = [pytest.mark.slow, pytest.mark.death]
LARGE = 400_000  # bytes, several times the capacity of a pipe


def size_of(data, seconds=0.0):
    time.sleep(seconds)
    return len(data), os.getpid()


def twice(data):
    return 2 * data


def die_while_sending_a_result():
    frame = sys._getframe()
    while "pipe" not in frame.f_locals:
        frame = frame.f_back
    os.write(frame.f_locals["pipe"].fileno(), struct.pack("!i", LARGE) + bytes(1000))
    os._exit(1)


def die_while_receiving_a_job():
    """Kill this process while half of the next job is in the pipe."""
    time.sleep(0.2)
    os.kill(os.getpid(), 9)


class Unpicklable(Exception):
    def __reduce__(self):
        raise TypeError("not to be pickled")


def fail(kind):
    raise kind("seven")


@pytest.mark.parametrize(
    ("death", "words"),
    [
        (os.abort, "signal 6"),
        (die_while_receiving_a_job, "signal 9"),
        (die_while_sending_a_result, "exit status 1"),
    ],
)
@pytest.mark.parametrize("workers", [1, 2])
def test_a_process_that_dies_loses_only_its_own_job(death, words, workers):
    with Pool(workers) as judges:
        futures = [judges.submit(twice, bytes(LARGE)) for _ in range(4)]
        futures.insert(2, judges.submit(death))
        for number, future in enumerate(futures):
            if number == 2:
                with pytest.raises(BrokenExecutor, match=f"ended.*{words}.*memory"):
                    future.result(PATIENCE)
            else:
                assert future.result(PATIENCE) == bytes(2 * LARGE)


def test_processes_are_kept_and_end_with_the_pool():
    with Pool(2) as judges:
        futures = [judges.submit(size_of, bytes(LARGE), 0.05) for _ in range(12)]
        pids = {future.result(PATIENCE)[1] for future in futures}
    assert 1 <= len(pids) <= 2
    assert not any(os.path.exists(f"/proc/{pid}") for pid in pids)


def test_a_process_that_hangs_is_killed(monkeypatch):
    monkeypatch.setattr(pool, "MAX_JOB_SECONDS", 0.5)
    with Pool(1) as judges:
        with pytest.raises(BrokenExecutor, match="signal 9"):
            judges.submit(time.sleep, 600).result(PATIENCE)
        monkeypatch.undo()
        assert judges.submit(size_of, b"abc").result(PATIENCE)[0] == 3


def test_an_interrupted_pool_ends_at_once():
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt), Pool(1) as judges:  # noqa: PT012
        futures = [judges.submit(time.sleep, 600) for _ in range(3)]
        time.sleep(0.5)
        raise KeyboardInterrupt
    assert time.monotonic() - start < PATIENCE
    for future in futures:
        with pytest.raises((BrokenExecutor, CancelledError)):
            future.result(PATIENCE)


@pytest.mark.parametrize(("kind", "raised"), [(KeyError, KeyError), (Unpicklable, RuntimeError)])
def test_an_exception_keeps_its_traceback(kind, raised):
    with Pool(1) as judges:
        with pytest.raises(raised) as caught:
            judges.submit(fail, kind).result(PATIENCE)
        texts = [str(caught.value), *getattr(caught.value, "__notes__", ())]
        assert any("in fail" in line for line in texts)
        assert judges.submit(size_of, b"abc").result(PATIENCE)[0] == 3


def test_a_process_leaves_the_busy_set_before_it_is_listed_as_idle():
    """Otherwise, a thread could take the process and then see it removed from the busy set."""
    with Pool(2) as judges:

        class Idle(list):
            def append(self, process):
                assert judges._lock.locked() and process not in judges._busy
                super().append(process)

        judges._idle = Idle()
        futures = [judges.submit(twice, number) for number in range(20)]
        assert [future.result(PATIENCE) for future in futures] == [2 * n for n in range(20)]
        assert judges._idle and not judges._busy


def allocate(size):
    return len(bytearray(size))


def test_a_job_that_needs_too_much_memory_fails_alone():
    with Pool(1) as judges:
        with pytest.raises(MemoryError):
            judges.submit(allocate, 4 * 2**30).result(PATIENCE)
        assert judges.submit(allocate, LARGE).result(PATIENCE) == LARGE
