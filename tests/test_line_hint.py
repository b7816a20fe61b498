"""The hint names a line whose change fixes the answer; the search has no side effects."""

import os
import threading
import time

import numpy as np
import pytest

from tests.notebook_runs import child_processes
from tests.prerequisites import PATIENCE
from utils.checks import check, checks_of, line_hint
from utils.checks.core import ChecksFailed, run_check
from utils.checks.line_hint import find_line_hint

CHECKS = checks_of("line_through")
written = []


def wrong_sign(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]


def turned_twice(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a = dy / length
    b = dx / length
    return a, b, -(a * p[0] + b * p[1])


def wrong_twice(p, q):
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 1:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]


def without_return(boxes, velocities, seconds):
    moved = np.array(boxes, dtype=float)
    moved += velocities[:, None] * seconds


class Node:
    def __init__(self, point, index):
        self.point, self.index, self.left, self.right = point, index, None, None


def insert(tree, point, index):
    newcomer = Node(point, index)
    if tree.root is None:
        tree.root = newcomer
        return
    parent, depth = tree.root, 0
    while True:
        axis = depth % len(point)
        side = "left" if point[axis] > parent.point[axis] else "right"
        if getattr(parent, side) is None:
            setattr(parent, side, newcomer)
            return
        parent, depth = getattr(parent, side), depth + 1


class InsertsByFunction:
    root = None

    def insert(self, point, index):
        insert(self, point, index)


class InsertsByMethod:
    root = None

    def insert(self, point, index):
        newcomer = Node(point, index)
        if self.root is None:
            self.root = newcomer
            return
        parent, depth = self.root, 0
        while True:
            axis = depth % len(point)
            side = "left" if point[axis] < parent.point[axis] else "right"
            if getattr(parent, side) is None:
                setattr(parent, side, newcomer)
                return
            parent, depth = getattr(parent, side), depth


def draws_and_prints(p, q):
    import matplotlib.pyplot as plt

    plt.plot(p, q)
    plt.show()
    print("never seen", flush=True)
    written.append(p)
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, a * p[0] + b * p[1]


def writes_a_file(p, q):
    path = os.environ["A_FILE"]
    with open(path, "a") as file:
        file.write("x")
    return wrong_sign(p, q)


def asks_a_person(p, q):
    input("p? ")
    return wrong_sign(p, q)


def starts_a_program(p, q):
    os.system("touch " + os.environ["A_FILE"])
    return wrong_sign(p, q)


def never_ends(p, q):
    while q is not None:
        pass
    return wrong_sign(p, q)


def failed_checks(function):
    found = []
    for check_ in CHECKS:
        try:
            check_.run(function)
        except Exception:
            found.append(check_)
    return found


def text_of(line):
    with open(__file__) as file:
        return file.read().split("\n")[line.number - 1].strip()


def test_the_line_to_change_is_named():
    place = find_line_hint(wrong_sign, CHECKS, failed_checks(wrong_sign))
    (line,) = place.lines
    assert line.text == "return a, b, a * p[0] + b * p[1]"
    assert text_of(line) == line.text
    assert place.sentence == (
        f"A single change in line {line.number}, `{line.text}`, makes all checks here pass."
    )


def test_the_line_before_a_missing_line_is_not_blamed():
    checks = checks_of("predict_boxes")
    lost = [each for each in checks if run_check(each, without_return).failure]
    place = find_line_hint(without_return, checks, lost)
    (line,) = place.lines
    assert line.text == "moved += velocities[:, None] * seconds"
    assert place.sentence.startswith(f"A single change after line {line.number}, `{line.text}`,")


def test_all_lines_that_can_be_changed_are_named():
    place = find_line_hint(turned_twice, CHECKS, failed_checks(turned_twice))
    assert [line.text for line in place.lines] == [
        "dx, dy = q[0] - p[0], q[1] - p[1]",
        "a = dy / length",
        "b = dx / length",
    ]
    assert place.sentence.count(", or in line") == 2
    assert [text_of(line) for line in place.lines] == [line.text for line in place.lines]


def test_there_is_no_hint_if_too_many_lines_are_possible(monkeypatch):
    monkeypatch.setattr(line_hint, "MAX_LINES", 2)
    assert find_line_hint(turned_twice, CHECKS, failed_checks(turned_twice)) is None


def test_there_is_no_hint_for_two_mistakes():
    assert find_line_hint(wrong_twice, CHECKS, failed_checks(wrong_twice)) is None


def test_the_change_must_pass_all_shown_checks():
    """A change that fixes the failed checks but fails another one is not suggested."""

    def never(function):
        raise AssertionError

    lost = line_hint.Check("lost", "line_through", "", "", run=never)
    assert find_line_hint(wrong_sign, [*CHECKS, lost], failed_checks(wrong_sign)) is None


def test_the_search_has_no_visible_effects(capfd):
    failed = failed_checks(draws_and_prints)
    before, processes = len(written), threading.active_count()
    capfd.readouterr()
    assert find_line_hint(draws_and_prints, CHECKS, failed) is not None
    assert capfd.readouterr() == ("", "")
    assert len(written) == before
    assert threading.active_count() == processes


@pytest.mark.parametrize("function", [writes_a_file, starts_a_program, asks_a_person])
def test_functions_with_side_effects_are_stopped(function, tmp_path, monkeypatch):
    monkeypatch.setenv("A_FILE", str(tmp_path / "file"))
    assert find_line_hint(function, CHECKS, CHECKS[:1]) is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_an_endless_loop_is_stopped_in_time(monkeypatch):
    monkeypatch.setattr(line_hint, "SECONDS", 0.5)
    start = time.monotonic()
    assert find_line_hint(never_ends, CHECKS, CHECKS[:1]) is None
    assert time.monotonic() - start < PATIENCE


@pytest.mark.slow
def test_no_process_is_left_running(monkeypatch):
    monkeypatch.setattr(line_hint, "SECONDS", 0.5)
    others = child_processes()
    find_line_hint(never_ends, CHECKS, CHECKS[:1])
    assert child_processes() <= others


@pytest.mark.parametrize(
    "function", [len, np.hypot, lambda p, q: (1.0, 0.0, 0.0), type("A", (), {})]
)
def test_there_is_no_hint_for_a_function_without_source(function):
    assert find_line_hint(function, CHECKS, CHECKS[:1]) is None


def test_there_is_no_hint_without_fork(monkeypatch):
    monkeypatch.delattr(os, "fork")
    assert find_line_hint(wrong_sign, CHECKS, failed_checks(wrong_sign)) is None


def test_check_shows_the_hint_below_the_first_failure(capsys):
    with pytest.raises(ChecksFailed):
        check(wrong_sign, "line_through")
    output = capsys.readouterr().out
    assert output.count("Where to look: A single change in line ") == 1
    assert output.index("Where to look") < output.index("[waiting]")


@pytest.mark.parametrize(
    "kind, line",
    [
        (InsertsByFunction, 'side = "left" if point[axis] > parent.point[axis] else "right"'),
        (InsertsByMethod, "parent, depth = getattr(parent, side), depth"),
    ],
)
def test_the_hint_is_in_a_method_or_in_the_function_that_it_calls(kind, line):
    checks = checks_of("insert")
    failed = [each for each in checks if run_check(each, kind).failure]
    assert failed
    place = find_line_hint(kind, checks, failed)
    assert [each.text for each in place.lines] == [line]


def returns_at_the_top(p, q):
    return None
    dx, dy = q[0] - p[0], q[1] - p[1]
    length = np.hypot(dx, dy)
    if length == 0:
        return None
    a, b = -dy / length, dx / length
    return a, b, -(a * p[0] + b * p[1])


def test_the_first_line_of_a_function_is_never_named():
    place = find_line_hint(returns_at_the_top, CHECKS, failed_checks(returns_at_the_top))
    assert [line.text for line in place.lines] == ["return None"]
