"""The log of marks says what changed, when, and by which verdict or that it was a person."""

import dataclasses
import json
import shutil

import pytest

from grader.course import paths
from grader.course.paths import Course
from grader.lms import gradebook, gradebook_writer
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.history import read_changes
from tests.test_gradebook import (
    DISTANCE,
    EARNED,
    GROUND,
    LATE,
    STAGE,
    hand_in,
    make_course,
    quiet,
    set_due,
    verdicts,
)

FIRST, SECOND, *_ = (exercise.name for exercise in GROUND.machine_graded)


@pytest.fixture(scope="module")
def entered_once(tmp_path_factory):
    made = make_course(tmp_path_factory.mktemp("history") / "course")
    enter_verdicts(made, verdicts(made), [STAGE], quiet)
    return made.root


@pytest.fixture
def course(entered_once, tmp_path):
    shutil.copytree(entered_once, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def enter_again(course, earned=EARNED, **more):
    """What is noted when the class is entered once more: (student, exercise, from, to, by)."""
    before = len(list(read_changes(course)))
    enter_verdicts(course, verdicts(course, earned, **more), [STAGE], quiet)
    return [
        (change.student, change.exercise, change.before, change.after, change.by)
        for change in list(read_changes(course))[before:]
    ]


def by_hand(course, student, exercise, **values):
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade(f"test_{exercise}", GROUND.name, STAGE, student)
        for name, value in values.items():
            setattr(grade, name, value)
        book.db.commit()


def test_the_first_marks_are_noted_with_the_verdict_they_come_from(course):
    changes = list(read_changes(course))
    assert {(one.student, one.lesson, one.exercise): one.after for one in changes} == {
        (student, lesson.name, exercise.name): score
        for student, lessons in EARNED.items()
        for lesson, scores in lessons.items()  # nothing of what was not handed in
        for exercise, score in zip(lesson.machine_graded, scores, strict=True)
    }
    assert {change.before for change in changes} == {None} and {one.stage for one in changes} == {
        STAGE
    }
    keys = {(one.student, one.lesson): one.by for one in changes}
    assert keys["ada", GROUND.name] == f"verdict of ada {EARNED['ada'][GROUND]}"
    assert all(one.when.endswith("+00:00") for one in changes)
    assert enter_again(course) == []


def test_a_line_is_as_people_read_it(course):
    first, *_ = (course.root / "marks.jsonl").read_text().splitlines()
    assert list(json.loads(first)) == [
        *("when", "student", "stage", "lesson", "exercise", "from", "to", "by"),
    ]


def test_another_verdict_is_named(course):
    hand_in(course, "ada", GROUND, " ")
    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 20.0)}}
    assert enter_again(course, earned, key="k2") == [
        ("ada", SECOND, 8.5, 20.0, "verdict k2"),
    ]


@pytest.mark.end_to_end
def test_marks_of_a_person_are_noticed(course):
    by_hand(course, "ada", SECOND, manual_score=12.0, needs_manual_grade=False)
    assert enter_again(course) == [("ada", SECOND, 8.5, 12.0, "a person")]
    by_hand(course, "ada", SECOND, extra_credit=0.5)
    assert enter_again(course) == [("ada", SECOND, 12.0, 12.5, "a person")]
    by_hand(course, "ada", SECOND, manual_score=None, extra_credit=None)
    assert enter_again(course) == [("ada", SECOND, 12.5, 8.5, "a person")]


def test_a_verdict_under_a_persons_mark_changes_no_mark(course):
    by_hand(course, "ada", SECOND, manual_score=12.0, needs_manual_grade=False)
    enter_again(course)
    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 2.0)}}
    assert enter_again(course, earned, key="k2") == []
    by_hand(course, "ada", SECOND, manual_score=None)
    assert enter_again(course, earned, key="k2") == [("ada", SECOND, 12.0, 2.0, "a person")]


def test_a_mark_by_hand_for_what_was_not_handed_in(course):
    by_hand(course, "bob", FIRST, manual_score=0.0)
    assert enter_again(course) == [("bob", FIRST, None, 0.0, "a person")]


def test_a_penalty_is_noted_apart(course):
    (course.root / "nbgrader_config.py").write_text(LATE)
    (course.submitted / "bob" / STAGE / "timestamp.txt").write_text("2026-03-01 12:00:00 UTC")
    set_due(course, "11")
    assert enter_again(course) == [
        ("bob", "late penalty", None, pytest.approx(2.075), "lateness"),
    ]
    set_due(course, "13")
    assert enter_again(course) == [
        ("bob", "late penalty", pytest.approx(2.075), None, "lateness"),
    ]


def test_what_is_withdrawn_is_noted(course):
    shutil.rmtree(course.submitted / "bob")
    found = enter_again(course)
    assert [(one[0], one[3:]) for one in found] == [
        ("bob", (None, "taken out of the gradebook"))
    ] * 3


def test_a_run_that_was_killed_before_noting_is_noted_by_the_next(course, monkeypatch):
    calls = []
    right = gradebook_writer.log_changes

    def die(*about):
        calls.append(about)
        if len(calls) == 2:
            raise KeyboardInterrupt
        right(*about)

    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 20.0)}}
    monkeypatch.setattr(gradebook_writer, "log_changes", die)
    with pytest.raises(KeyboardInterrupt):
        enter_again(course, earned, key="k2")
    monkeypatch.setattr(gradebook_writer, "log_changes", right)
    assert enter_again(course, earned, key="k2") == [("ada", SECOND, 8.5, 20.0, "verdict k2")]


@pytest.mark.parametrize("spoil", ["torn", "lost", "other"])
def test_a_spoilt_log_is_written_on_and_keeps_what_can_be_read(course, spoil):
    path = course.root / "marks.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    if spoil == "torn":
        path.write_bytes(b"".join(lines)[:-20])
    elif spoil == "lost":
        path.write_bytes(b"".join(lines[:-1]))
    else:
        path.write_bytes(b"[7]\n\xff{\n{}\n" + b"".join(lines[:-1]))
    last = json.loads(lines[-1])
    assert enter_again(course) == [
        (last["student"], last["exercise"], None, last["to"], last["by"]),
    ]
    assert len(list(read_changes(course))) == len(lines)
    assert enter_again(course) == []


def test_a_student_graded_alone_leaves_the_others(course):
    judged = [pair for pair in verdicts(course) if pair[0].student == "ada"]
    changed = [
        (one, dataclasses.replace(verdict, key=f"{verdict.key}, again")) for one, verdict in judged
    ]
    enter_verdicts(course, changed, [STAGE], quiet, student="ada")
    with gradebook.open_gradebook(course) as book:
        assert {
            submission.student.id for submission in book.find_assignment(STAGE).submissions
        } == {"ada", "bob"}
    shutil.rmtree(course.submitted / "ada")
    enter_verdicts(course, [], [STAGE], quiet, student="ada")
    with gradebook.open_gradebook(course) as book:
        assert {one.student.id for one in book.find_assignment(STAGE).submissions} == {"bob"}


def test_lessons_of_the_stage_are_told_apart(course):
    lessons = {change.lesson for change in read_changes(course)}
    assert lessons == {GROUND.name, DISTANCE.name}
