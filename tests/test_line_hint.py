"""Where to look: true by construction, and nothing of it reaches the notebook."""

import os
import threading
import time

import numpy as np
import pytest

from tests.notebook_runs import children
from tests.prerequisites import PATIENCE
from utils.checks import check, checks_of, line_hint
from utils.checks.core import ChecksFailed
from utils.checks.line_hint import place_to_change

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


def failed_by(function):
    found = []
    for one in CHECKS:
        try:
            one.run(function)
        except Exception:
            found.append(one)
    return found


def text_of(line):
    with open(__file__) as file:
        return file.read().split("\n")[line.number - 1].strip()


def test_it_names_the_line():
    place = place_to_change(wrong_sign, CHECKS, failed_by(wrong_sign))
    (line,) = place.lines
    assert line.text == "return a, b, a * p[0] + b * p[1]"
    assert text_of(line) == line.text
    assert place.sentence == f"One change in {line}, makes everything here green."


def test_it_names_all_lines_of_which_any_does():
    place = place_to_change(turned_twice, CHECKS, failed_by(turned_twice))
    assert [line.text for line in place.lines] == [
        "dx, dy = q[0] - p[0], q[1] - p[1]",
        "a = dy / length",
        "b = dx / length",
    ]
    assert place.sentence.count(", or one in line") == 2
    assert [text_of(line) for line in place.lines] == [line.text for line in place.lines]


def test_of_many_lines_none_is_told(monkeypatch):
    monkeypatch.setattr(line_hint, "MOST_LINES", 2)
    assert place_to_change(turned_twice, CHECKS, failed_by(turned_twice)) is None


def test_what_is_wrong_in_two_places_is_not_told():
    assert place_to_change(wrong_twice, CHECKS, failed_by(wrong_twice)) is None


def test_it_is_told_only_where_all_shown_checks_pass():
    """A change that mends what failed and breaks another check is none."""

    def never(function):
        raise AssertionError

    lost = line_hint.Check("lost", "line_through", "", "", run=never)
    assert place_to_change(wrong_sign, [*CHECKS, lost], failed_by(wrong_sign)) is None


def test_nothing_of_it_is_seen_or_kept(capfd):
    failed = failed_by(draws_and_prints)
    before, processes = len(written), threading.active_count()
    capfd.readouterr()
    assert place_to_change(draws_and_prints, CHECKS, failed) is not None
    assert capfd.readouterr() == ("", "")
    assert len(written) == before
    assert threading.active_count() == processes


@pytest.mark.parametrize("function", [writes_a_file, starts_a_program, asks_a_person])
def test_what_reaches_out_is_kept_off(function, tmp_path, monkeypatch):
    monkeypatch.setenv("A_FILE", str(tmp_path / "file"))
    assert place_to_change(function, CHECKS, CHECKS[:1]) is None
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_loop_without_an_end_takes_no_longer_than_it_may(monkeypatch):
    monkeypatch.setattr(line_hint, "SECONDS", 0.5)
    begin = time.monotonic()
    assert place_to_change(never_ends, CHECKS, CHECKS[:1]) is None
    assert time.monotonic() - begin < PATIENCE


@pytest.mark.slow
def test_no_process_is_left(monkeypatch):
    monkeypatch.setattr(line_hint, "SECONDS", 0.5)
    others = children()
    place_to_change(never_ends, CHECKS, CHECKS[:1])
    assert children() <= others


@pytest.mark.parametrize(
    "function", [len, np.hypot, lambda p, q: (1.0, 0.0, 0.0), type("A", (), {})]
)
def test_what_has_no_text_of_its_own_has_no_line(function):
    assert place_to_change(function, CHECKS, CHECKS[:1]) is None


def test_without_processes_to_copy_nothing_is_said(monkeypatch):
    monkeypatch.delattr(os, "fork")
    assert place_to_change(wrong_sign, CHECKS, failed_by(wrong_sign)) is None


def test_check_tells_it_under_the_first_failure(capsys):
    with pytest.raises(ChecksFailed):
        check(wrong_sign, "line_through")
    said = capsys.readouterr().out
    assert said.count("Where to look: One change in line ") == 1
    assert said.index("Where to look") < said.index(
        "[passed]" if "[passed]" in said else "[waiting]"
    )
