"""What a submission earned, in Gradescope's format.

The fields are those of gradescope-autograders.readthedocs.io/en/latest/specs/.
"""

from __future__ import annotations

from collections.abc import Iterator

from grader.judging.points import total
from grader.judging.verdict import ExerciseResult
from grader.lms.autograder.judging import Judged, JudgedLesson

NOW, AFTERWARDS = "visible", "after_published"
"""When a student reads it. Students hand in as often as they like: what was asked in secret, and
how it went, is for the time after the last of them."""
MISSING = "Nothing was handed in for this lesson."


def results_of(judged: Judged) -> dict:
    """The content of ``results.json``."""
    tests = [test for one in judged.lessons for test in _tests(one)]
    score = total([lesson.verdict.score for lesson in judged.lessons if lesson.verdict])
    if total([test.get("score", 0.0) for test in tests]) != score:
        raise ArithmeticError("What is shown does not add up to what was earned.")
    return {
        "score": score,
        "output": "\n".join(judged.left),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "visibility": NOW,
        "stdout_visibility": "hidden",
        "tests": tests,
    }


def _tests(one: JudgedLesson) -> Iterator[dict]:
    number = one.lesson.number
    if one.verdict is None:
        for row, exercise in enumerate(one.lesson.machine_graded, start=1):
            yield _scored(f"{number}.{row}", exercise.name, 0.0, exercise.points, MISSING, NOW)
        return
    later = [problem for problem in one.verdict.problems if problem not in one.notes]
    for said, when in ((one.notes, NOW), (later, AFTERWARDS)):
        if said:
            yield _told(number, f"About {one.lesson.name}", "\n".join(said), when)
    for row, exercise in enumerate(one.verdict.exercises, start=1):
        yield from _exercise(f"{number}.{row}", exercise)


def _exercise(number: str, exercise: ExerciseResult) -> Iterator[dict]:
    for row, test in enumerate(exercise.tests, start=1):
        name = f"{exercise.name}: {test.title}"
        when = NOW if test.visible else AFTERWARDS
        yield _scored(f"{number}.{row}", name, test.score, test.max_score, test.message, when)
    if not exercise.tests:
        why = "This could not be judged. What is said about the lesson above tells why."
        yield _scored(number, exercise.name, exercise.score, exercise.max_score, why, NOW)
    if exercise.slip:
        about = _told(number, f"{exercise.name}: one slip", exercise.slip.sentence, AFTERWARDS)
        yield {**about, "score": exercise.slip.score, "max_score": 0.0}


def _scored(number: str, name: str, score: float, max_score: float, output: str, when: str) -> dict:
    status = "passed" if score == max_score else "failed"
    about = _told(number, name, output, when)
    return {**about, "score": score, "max_score": max_score, "status": status}


def _told(number: str, name: str, output: str, when: str) -> dict:
    return {"number": number, "name": name, "output": output, "visibility": when}
