"""The log of marks records each change, its time, and the verdict or person that caused it."""

import dataclasses
import json
import shutil

import pytest

from grader.course import paths
from grader.course.paths import Course
from grader.lms import gradebook, gradebook_writer
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.mark_history import read_changes
from tests.gradebooks import (
    DISTANCE,
    EARNED,
    GROUND,
    LATE_PLUGIN,
    STAGE,
    ignore_progress,
    make_course,
    set_due,
    submit,
    verdicts,
)

FIRST, SECOND, *_ = (exercise.name for exercise in GROUND.machine_graded)


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("history") / "course")
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    return course.root


@pytest.fixture
def course(entered_root, tmp_path):
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def enter_again(course, earned=EARNED, **more):
    """Enter the class again; return (student, exercise, before, after, by) for each new change."""
    before = len(list(read_changes(course)))
    enter_verdicts(course, verdicts(course, earned, **more), [STAGE], ignore_progress)
    return [
        (change.student, change.exercise, change.before, change.after, change.by)
        for change in list(read_changes(course))[before:]
    ]


def enter_manual_mark(course, student, exercise, **values):
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade(f"test_{exercise}", GROUND.name, STAGE, student)
        for name, value in values.items():
            setattr(grade, name, value)
        book.db.commit()


def test_the_first_marks_are_logged_with_their_verdict(course):
    changes = list(read_changes(course))
    assert {
        (change.student, change.lesson, change.exercise): change.after for change in changes
    } == {
        (student, lesson.name, exercise.name): score
        for student, lessons in EARNED.items()
        for lesson, scores in lessons.items()  # EARNED contains only submitted lessons
        for exercise, score in zip(lesson.machine_graded, scores, strict=True)
    }
    assert {change.before for change in changes} == {None} and {
        change.stage for change in changes
    } == {STAGE}
    keys = {(change.student, change.lesson): change.by for change in changes}
    assert keys["ada", GROUND.name] == f"verdict of ada {EARNED['ada'][GROUND]}"
    assert all(change.when.endswith("+00:00") for change in changes)
    assert enter_again(course) == []


def test_each_line_has_readable_keys(course):
    first, *_ = (course.root / "marks.jsonl").read_text().splitlines()
    assert list(json.loads(first)) == [
        *("when", "student", "stage", "lesson", "exercise", "from", "to", "by"),
    ]


def test_a_change_names_the_new_verdict(course):
    submit(course, "ada", GROUND, " ")
    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 20.0)}}
    assert enter_again(course, earned, key="k2") == [
        ("ada", SECOND, 8.5, 20.0, "verdict k2"),
    ]


@pytest.mark.end_to_end
def test_manual_marks_are_logged(course):
    enter_manual_mark(course, "ada", SECOND, manual_score=12.0, needs_manual_grade=False)
    assert enter_again(course) == [("ada", SECOND, 8.5, 12.0, "a person")]
    enter_manual_mark(course, "ada", SECOND, extra_credit=0.5)
    assert enter_again(course) == [("ada", SECOND, 12.0, 12.5, "a person")]
    enter_manual_mark(course, "ada", SECOND, manual_score=None, extra_credit=None)
    assert enter_again(course) == [("ada", SECOND, 12.5, 8.5, "a person")]


def test_a_new_verdict_does_not_change_a_manual_mark(course):
    enter_manual_mark(course, "ada", SECOND, manual_score=12.0, needs_manual_grade=False)
    enter_again(course)
    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 2.0)}}
    assert enter_again(course, earned, key="k2") == []
    enter_manual_mark(course, "ada", SECOND, manual_score=None)
    assert enter_again(course, earned, key="k2") == [("ada", SECOND, 12.0, 2.0, "a person")]


def test_a_manual_mark_for_a_missing_notebook_is_logged(course):
    enter_manual_mark(course, "bob", FIRST, manual_score=0.0)
    assert enter_again(course) == [("bob", FIRST, None, 0.0, "a person")]


def test_a_penalty_is_logged_separately(course):
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    (course.submitted / "bob" / STAGE / "timestamp.txt").write_text("2026-03-01 12:00:00 UTC")
    set_due(course, "11")
    assert enter_again(course) == [
        ("bob", "late penalty", None, pytest.approx(2.075), "lateness"),
    ]
    set_due(course, "13")
    assert enter_again(course) == [
        ("bob", "late penalty", pytest.approx(2.075), None, "lateness"),
    ]


def test_withdrawn_work_is_logged(course):
    shutil.rmtree(course.submitted / "bob")
    found = enter_again(course)
    assert [(change[0], change[3:]) for change in found] == [
        ("bob", (None, "removed from the gradebook"))
    ] * 3


def test_changes_of_a_killed_run_are_logged_by_the_next_run(course, monkeypatch):
    calls = []
    original = gradebook_writer.log_changes

    def fail_second(*about):
        calls.append(about)
        if len(calls) == 2:
            raise KeyboardInterrupt
        original(*about)

    earned = EARNED | {"ada": EARNED["ada"] | {GROUND: (3.25, 20.0)}}
    monkeypatch.setattr(gradebook_writer, "log_changes", fail_second)
    with pytest.raises(KeyboardInterrupt):
        enter_again(course, earned, key="k2")
    monkeypatch.setattr(gradebook_writer, "log_changes", original)
    assert enter_again(course, earned, key="k2") == [("ada", SECOND, 8.5, 20.0, "verdict k2")]


@pytest.mark.parametrize("spoil", ["torn", "lost", "other"])
def test_a_damaged_log_is_continued_and_keeps_readable_lines(course, spoil):
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


def test_grading_one_student_does_not_remove_other_students(course):
    judged = [pair for pair in verdicts(course) if pair[0].student == "ada"]
    changed = [
        (submission, dataclasses.replace(verdict, key=f"{verdict.key}, again"))
        for submission, verdict in judged
    ]
    enter_verdicts(course, changed, [STAGE], ignore_progress, student="ada")
    with gradebook.open_gradebook(course) as book:
        assert {
            submission.student.id for submission in book.find_assignment(STAGE).submissions
        } == {"ada", "bob"}
    shutil.rmtree(course.submitted / "ada")
    enter_verdicts(course, [], [STAGE], ignore_progress, student="ada")
    with gradebook.open_gradebook(course) as book:
        assert {
            submission.student.id for submission in book.find_assignment(STAGE).submissions
        } == {"bob"}


def test_the_log_distinguishes_lessons_of_a_stage(course):
    lessons = {change.lesson for change in read_changes(course)}
    assert lessons == {GROUND.name, DISTANCE.name}
