"""Enter manual marks and comments that the gradebook lacks.

These are marks that were lost with a gradebook, and marks that another member of the same team
received for the same answer.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace

from nbgrader.api import Gradebook, MissingEntry

from grader.classroom.collect.instructor_answers import teams_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.lms.answer_fingerprints import read_fingerprints
from grader.lms.gradebook import gradebook_location
from grader.lms.mark_history import (
    A_PERSON,
    REMOVED,
    CurrentMark,
    MarkChange,
    MarkKey,
    current_marks,
    exercise_of,
    read_changes,
)

MAX_NAMES = 10  # at most this many students are named in a sentence


def lost_marks(course: Course, book: Gradebook, students: Collection[str]) -> list[MarkChange]:
    """Return the manual marks and comments that are in the log but not in the gradebook.

    Only the given students and exercises that still exist are considered. A mark that a person
    removed from the gradebook is not lost, because the log contains its removal.
    """
    last_changes = _last_marks_by_hand(course)
    existing = current_marks(course, book) if last_changes else {}
    lost = []
    for key, change in last_changes.items():
        mark = existing.get(key, CurrentMark())
        is_lost = (change.by_hand and not mark.by_hand) or (change.comment and not mark.comment)
        if is_lost and change.student in students and _exists(change):
            lost.append(change)
    return lost


def _last_marks_by_hand(course: Course) -> dict[MarkKey, MarkChange]:
    """Return the last mark and comment that a person gave for each exercise."""
    last_changes: dict[MarkKey, MarkChange] = {}
    removed: set[MarkKey] = set()
    for change in read_changes(course):
        if change.by == REMOVED:
            removed.add(change.key)
        elif change.by == A_PERSON:
            before = last_changes.get(change.key)
            if before and change.key in removed:
                # In a new gradebook, a mark without a comment does not mean that a person removed
                # the comment.
                last_changes[change.key] = replace(
                    change,
                    by_hand=change.by_hand or before.by_hand,
                    comment=change.comment or before.comment,
                    graded=change.graded if change.by_hand else before.graded,
                )
                if last_changes[change.key] != change:
                    continue
            removed.discard(change.key)
            last_changes[change.key] = change
    return last_changes


def restore_marks(course: Course, book: Gradebook, lost: Collection[MarkChange]) -> list[str]:
    """Enter lost marks and comments again; return sentences about what was restored."""
    restored, waiting = _enter(course, book, lost)
    sentences = [f"Restored from marks.jsonl: {_list_exercises(restored)}."] if restored else []
    if waiting:
        sentences.append(
            f"Review these marks, because the work may have changed: {_list_exercises(waiting)}."
        )
    return sentences


def share_marks_in_teams(course: Course, book: Gradebook, stages: Iterable[str]) -> list[str]:
    """Copy the mark for a team's written answer to its other members; return what was entered.

    The other members must have submitted the same answer, and must not have a mark or a comment.
    """
    team_changes: dict[MarkKey, set[MarkChange]] = {}
    teams = {stage: teams_in(course, stage) for stage in stages}
    marks = current_marks(course, book) if any(teams.values()) else {}
    for (student, stage, lesson, exercise), mark in marks.items():
        mates = {mate for team in teams.get(stage, ()) if student in team for mate in team}
        for mate in sorted(mates - {student}) if mark.by_hand and mark.graded else ():
            key = (mate, stage, lesson, exercise)
            other = marks.get(key)
            answers = read_fingerprints(course, mate, stage).get(lesson, {})
            is_free = other is not None and not (other.by_hand or other.comment)
            if is_free and answers.get(exercise) == mark.graded:
                by_person = (mark.by_hand, mark.comment, mark.graded)
                change = MarkChange("", *key, None, None, A_PERSON, *by_person)
                team_changes.setdefault(key, set()).add(change)
    # If the other members have different marks, a person has to decide.
    agreed = [
        change for changes in team_changes.values() if len(changes) == 1 for change in changes
    ]
    entered, _ = _enter(course, book, agreed)
    return (
        [f"Entered a team's mark for its other members: {_list_exercises(entered)}."]
        if entered
        else []
    )


def _enter(
    course: Course, book: Gradebook, changes: Collection[MarkChange]
) -> tuple[list[MarkChange], list[MarkChange]]:
    """Enter marks and comments; return those that were entered, and those that wait for a person.

    A mark applies only to what the person graded. If that has changed, or if it is unknown, the
    mark is entered and waits for a person.
    """
    restored, waiting = [], []
    for change in changes:
        try:
            notebook = book.find_submission_notebook(change.lesson, change.stage, change.student)
        except MissingEntry:  # the submission is not entered, so the mark stays lost
            continue
        answers = read_fingerprints(course, change.student, change.stage).get(change.lesson, {})
        for grade in notebook.grades:
            by_hand = grade.manual_score is not None or grade.extra_credit
            if exercise_of(grade.name) == change.exercise and change.by_hand and not by_hand:
                grade.manual_score, grade.extra_credit = change.by_hand
                graded = answers.get(grade.name, str(grade.auto_score))
                grade.needs_manual_grade = change.graded != graded
                if grade.needs_manual_grade:
                    waiting.append(change)
        for comment in notebook.comments:
            if exercise_of(comment.name) == change.exercise and not comment.manual_comment:
                comment.manual_comment = change.comment or None
        restored.append(change)
    book.db.commit()
    return restored, waiting


def lost_sentence(course: Course, lost: Collection[MarkChange]) -> str:
    """Describe the lost marks, and how to restore them."""
    marks = sum(change.by_hand is not None for change in lost)
    comments = sum(bool(change.comment) for change in lost)
    counts = [f"{marks} mark{'s' * (marks != 1)} given by hand"] * bool(marks)
    counts += [f"{comments} comment{'s' * (comments != 1)}"] * bool(comments)
    return (
        f"marks.jsonl contains {' and '.join(counts)} that the gradebook "
        f"{gradebook_location(course)} does not contain: {_list_exercises(lost)}. "
        "If this is the wrong gradebook, correct c.CourseDirectory.db_url in nbgrader_config.py. "
        "If the gradebook was lost, run: python -m grader grade --restore-marks"
    )


def _exists(change: MarkChange) -> bool:
    lesson = find_lesson(change.lesson)
    return lesson is not None and change.exercise in {
        exercise.name for exercise in lesson.exercises
    }


def _list_exercises(changes: Collection[MarkChange]) -> str:
    """List exercises, each with some of its students."""
    students: dict[tuple[str, str], list[str]] = {}
    for change in changes:
        students.setdefault((change.lesson, change.exercise), []).append(change.student)
    return "; ".join(
        f"{exercise} in {lesson} for {', '.join(names[:MAX_NAMES])}"
        + (f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else "")
        for (lesson, exercise), names in students.items()
    )
