"""The message about a function that hangs names the loop and asks a question about it."""

import numpy as np
import pytest

from utils.checks import checks_of, core
from utils.checks.core import run_check
from utils.checks.outcomes import Check


def mask_that_never_shrinks(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    queue = np.arange(len(cloud)) == 0
    while queue.any():
        point = cloud[np.flatnonzero(queue)[0], :3]
        near = np.linalg.norm(cloud[:, :3] - point, axis=1) < threshold
        labels[near] = 1
        queue |= near
    return labels


def no_way_out(cloud):
    number = 0
    while True:
        number += 1


def list_that_grows(cloud):
    queue = [0]
    for row in queue:
        queue[-1:] = [row, row]


def loop_in_a_loop(cloud):
    left = 10**9 * len(cloud)  # so the time limit ends the inner loop
    while left > 0:
        place = 0
        while place < left:
            place += 1


def calls_another(cloud):
    for row in cloud:
        no_way_out(row)


def loop_without_a_line(cloud):
    return sum(0 for _ in iter(int, 1))


def message_after(function, monkeypatch, slow=""):
    """Run a function that hangs as an answer, and return the message about it."""
    monkeypatch.setattr(core, "SECONDS", 0.2)
    name = function.__name__

    def call(answer):
        return answer(np.ones((3, 3)))

    check = Check("check", name, "It ends", "hint", run=call, slow=slow)
    return run_check(check, function).failure.message


def line_of(text):
    with open(__file__, encoding="utf-8") as file:
        return next(number for number, line in enumerate(file, 1) if line.strip() == text)


@pytest.mark.parametrize(
    ("function", "text", "question"),
    [
        (
            mask_that_never_shrinks,
            "while queue.any():",
            "Which line of the loop makes `queue.any()` false?",
        ),
        (no_way_out, "while True:", "Does the loop ever reach its `break` or `return`?"),
        (list_that_grows, "for row in queue:", "Does the loop add items to the list it runs over"),
    ],
)
def test_the_loop_is_named_with_a_question(function, text, question, monkeypatch):
    name = function.__name__
    assert message_after(function, monkeypatch) == (
        f"{name} did not return within 0.2 s. It was in the loop in line {line_of(text)} of the "
        f"cell of {name}, `{text}`. {question}"
        + (", or are there far too many items?" if function is list_that_grows else "")
        + " If one of your cells hangs, press the stop button ■ in the toolbar."
    )


def test_nested_loops_are_both_named(monkeypatch):
    message = message_after(loop_in_a_loop, monkeypatch)
    outer = f"line {line_of('while left > 0:')} of the cell of loop_in_a_loop, `while left > 0:`"
    inner = f"line {line_of('while place < left:')} of the cell of loop_in_a_loop"
    assert outer in message and f"{inner}, `while place < left:`" in message
    assert "Which of the two loops never ends?" in message


def test_a_loop_in_a_called_function_is_named(monkeypatch):
    message = message_after(calls_another, monkeypatch)
    assert message.startswith("calls_another did not return within")
    assert "of the cell of no_way_out, `while True:`. Does the loop ever" in message


def test_the_message_asks_about_a_loop_if_no_loop_is_found(monkeypatch):
    assert (
        "within 0.2 s: is there a loop that never ends, or one that is far too slow?"
        in message_after(loop_without_a_line, monkeypatch)
    )


def test_a_check_may_have_its_own_question(monkeypatch):
    message = message_after(no_way_out, monkeypatch, slow="does the walk end?")
    assert "of the cell of no_way_out, `while True:`. Does the walk end? If" in message
    assert "s: does the walk end? If" in message_after(
        loop_without_a_line, monkeypatch, "does the walk end?"
    )


def test_the_time_limit_is_in_the_text_and_at_most_15_seconds(monkeypatch):
    assert core.SECONDS <= 15
    monkeypatch.setattr(core, "SECONDS", 0.3)
    for name in ("euclidean_clustering", "euclidean_clustering_accelerated"):
        failure = run_check(checks_of(name)[0], mask_that_never_shrinks).failure
        assert failure.message.startswith(f"{name} did not return within 0.3 s. It was in the")
