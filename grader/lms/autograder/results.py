"""Build the results of a submission in Gradescope's format.

The fields are documented at gradescope-autograders.readthedocs.io/en/latest/specs/.
"""

from __future__ import annotations

from collections.abc import Iterator

from grader.judging.points import sum_points
from grader.judging.verdict import ExerciseResult
from grader.lms.autograder.judging import JudgedLesson, JudgedSubmission

VISIBLE_NOW, VISIBLE_AFTERWARDS = "visible", "after_published"
"""Visibility of a result. Students may submit repeatedly, so the results of hidden tests are shown
only after the last submission."""
MISSING_NOTE = "Nothing was submitted for this lesson."


def build_results(judged: JudgedSubmission) -> dict:
    """Build the content of ``results.json``."""
    tests = [test for lesson in judged.lessons for test in _lesson_tests(lesson)]
    score = sum_points([lesson.verdict.score for lesson in judged.lessons if lesson.verdict])
    if sum_points([test.get("score", 0.0) for test in tests]) != score:
        raise ArithmeticError("The displayed points do not add up to the score.")
    return {
        "score": score,
        "output": "\n".join(judged.unjudged_notes),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "visibility": VISIBLE_NOW,
        "stdout_visibility": "hidden",
        "tests": tests,
    }


def _lesson_tests(judged: JudgedLesson) -> Iterator[dict]:
    number = judged.lesson.number
    if judged.verdict is None:
        for row, exercise in enumerate(judged.lesson.machine_graded, start=1):
            yield _scored_test(
                f"{number}.{row}", exercise.name, 0.0, exercise.points, MISSING_NOTE, VISIBLE_NOW
            )
        return
    later = [problem for problem in judged.verdict.problems if problem not in judged.notes]
    for messages, visibility in ((judged.notes, VISIBLE_NOW), (later, VISIBLE_AFTERWARDS)):
        if messages:
            yield _message_test(
                number, f"About {judged.lesson.name}", "\n".join(messages), visibility
            )
    for row, exercise in enumerate(judged.verdict.exercises, start=1):
        yield from _exercise_tests(f"{number}.{row}", exercise)


def _exercise_tests(number: str, exercise: ExerciseResult) -> Iterator[dict]:
    for row, test in enumerate(exercise.tests, start=1):
        name = f"{exercise.name}: {test.title}"
        visibility = VISIBLE_NOW if test.visible else VISIBLE_AFTERWARDS
        yield _scored_test(
            f"{number}.{row}", name, test.score, test.max_score, test.message, visibility
        )
    if not exercise.tests:
        message = "This exercise could not be judged. The message about the lesson says why."
        yield _scored_test(
            number, exercise.name, exercise.score, exercise.max_score, message, VISIBLE_NOW
        )
    if exercise.slip:
        fields = _message_test(
            number, f"{exercise.name}: one slip", exercise.slip.sentence, VISIBLE_AFTERWARDS
        )
        yield {**fields, "score": exercise.slip.score, "max_score": 0.0}


def _scored_test(
    number: str, name: str, score: float, max_score: float, output: str, visibility: str
) -> dict:
    status = "passed" if score == max_score else "failed"
    fields = _message_test(number, name, output, visibility)
    return {**fields, "score": score, "max_score": max_score, "status": status}


def _message_test(number: str, name: str, output: str, visibility: str) -> dict:
    return {"number": number, "name": name, "output": output, "visibility": visibility}
