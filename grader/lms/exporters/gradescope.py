"""Marks for Gradescope: an autograder that hands them out, and judges nothing.

Gradescope takes marks of programming assignments from an autograder alone. This one brings them
along, by e-mail, and gives each submission its `results.json`, if it is the one that was judged.
No student code runs where it runs.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from grader.classroom.submissions import Replaced, Submission, find_submissions
from grader.course.archives import zipped
from grader.judging.verdict import ExerciseResult, Verdict, read_verdict
from grader.lms.exporters import inside_gradescope
from grader.lms.exporters.assignment_marks import Mark, marks_of
from grader.lms.exporters.inside_gradescope import digest, files_of
from grader.lms.exporters.protocol import Exported, Order
from grader.lms.results import MISSING, NotebookResult, write_number

SETUP = "#!/bin/sh\napt-get update && apt-get install -y python3\n"
PROGRAMS = ("setup.sh", "run_autograder")


def gradescope(order: Order) -> Exported:
    """Make an autograder for Gradescope, to be uploaded as it is.

    Returns
    -------
    Exported
        A zip.

    Raises
    ------
    ExportTrouble
    """
    marks = marks_of(order)
    given: dict[str, list[Submission]] = {}
    for submission in find_submissions(order.course):
        if order.assignment in (submission.lesson.stage, submission.lesson.name):
            given.setdefault(submission.student, []).append(submission)
    entries, lost = {}, list(marks.lost)
    sharing = Counter(_email(mark) for mark in marks.marks)
    for mark in marks.marks:
        email = _email(mark)
        try:
            if not email:
                raise _NoEntry("Gradescope knows them by e-mail, and the roster has none.")
            if sharing[email] > 1:
                raise _NoEntry(f"Gradescope knows them by e-mail, and {email} is another's, too.")
            entries[email] = _entry(order, mark, given.get(mark.person.id, ()))
        except _NoEntry as error:
            lost.append(f"{mark.person.called}, {write_number(mark.points)} points: {error}")
    files = {
        "setup.sh": SETUP,
        "run_autograder": Path(inside_gradescope.__file__).read_text("utf-8"),
        "marks.json": json.dumps(entries, indent=1, sort_keys=True),
    }
    content = zipped({name: text.encode() for name, text in files.items()}, PROGRAMS)
    return Exported(content, len(entries), tuple(lost), marks.notes)


class _NoEntry(Exception):
    """A mark cannot be handed out; the rest of the sentence."""


def _email(mark: Mark) -> str:
    """What Gradescope knows somebody by; empty where that is not known here."""
    return mark.person.email.strip().casefold()


def _entry(order: Order, mark: Mark, submissions: Sequence[Submission]) -> dict:
    """The results of one person, and by which files they are known."""
    course = order.course
    if not submissions:
        raise _NoEntry("nothing lies in submitted/ for it, so no submission can be compared.")
    judged, reports = [], {}
    for submission in submissions:
        verdict = read_verdict(submission.verdict_path(course))
        if verdict is None:
            raise _NoEntry("there is no verdict. Run `python -m grader grade`.")
        try:
            submission.read_again(course, verdict.fingerprint)
        except Replaced as error:
            raise _NoEntry(str(error)) from error
        judged.append(digest(submission.path))
        reports[submission.lesson.name] = verdict
    folders = {submission.place(course) for submission in submissions}
    known = [digest(path) for folder in folders for path in files_of(folder)]
    results = [
        notebook
        for notebook in order.results.notebooks
        if notebook.student == mark.person.id
        and order.assignment in (notebook.stage, notebook.lesson)
    ]
    return {
        "judged": sorted(judged),
        "known": sorted(known),
        "results": {
            "score": round(mark.points, 2),
            "output": _summary(results),
            "visibility": "visible",
            "tests": [_test(result, reports.get(result.lesson)) for result in results],
        },
    }


def _summary(results: Sequence[NotebookResult]) -> str:
    lines = [
        f"{one.lesson}: {write_number(one.score or 0.0)} of {write_number(one.max_score)} points"
        for one in results
    ]
    penalty = sum(result.penalty for result in results)
    if penalty:
        lines.append(f"Taken off for lateness: {write_number(penalty)} points")
    return "\n".join(lines)


def _test(result: NotebookResult, verdict: Verdict | None) -> dict:
    """A lesson, as one of Gradescope's tests."""
    return {
        "name": result.lesson,
        "score": round(result.score or 0.0, 2),
        "max_score": result.max_score,
        "output": "Nothing was handed in."
        if result.standing == MISSING
        else _told(result, verdict),
        "visibility": "visible",
    }


def _told(result: NotebookResult, verdict: Verdict | None) -> str:
    if verdict is None:
        return ""
    lines = [*verdict.problems]
    for exercise in verdict.exercises:
        lines += _exercise(exercise)
    by_hand = (result.score or 0.0) - verdict.score
    if abs(by_hand) >= 0.005:
        lines.append(f"Given by a person: {by_hand:+.4g} points")
    return "\n".join(lines)


def _exercise(exercise: ExerciseResult) -> list[str]:
    """The points of an exercise, and the first thing that fails in full."""
    head = f"{exercise.name}: {exercise.score:.4g} of {exercise.max_score:.4g} points"
    failed = [test for test in exercise.tests if not test.passed]
    lines = [head, *(f"  FAILED  {test.title}" for test in failed)]
    if failed:
        lines[2:2] = [f"          {line}" for line in failed[0].message.splitlines()]
    return [*lines, *([f"  {exercise.slip.sentence}"] if exercise.slip else [])]
