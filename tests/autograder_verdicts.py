"""Made-up verdicts for tests of the autograder for Gradescope."""

from grader.course.lessons import find_lesson
from grader.judging.verdict import JUDGED, CheckResult, ExerciseResult, Verdict

SEED = 2**64 + 20_170_405
SIX = find_lesson("06_filter_ground")
STAGE = SIX.stage


def verdict(exercises=(), status=JUDGED, problems=(), faults=()):
    score = round(sum(exercise.score for exercise in exercises), 2)
    return Verdict(SIX.name, "", status, score, 30.0, exercises, problems, 1.0, "k", faults)


def exercise_result(slip=None):
    checks = (
        CheckResult("a", "A road is ground", False, 0.0, 6.67, "Yours: 1 <b>", True),
        CheckResult("b", "A hidden road", False, 0.0, 6.67, "A wall is not a road.", False),
        CheckResult("c", "Nothing changes", True, 6.66, 6.66, "", False),
    )
    kept = slip.score if slip else 0.0
    return ExerciseResult("filter_ground", round(6.66 + kept, 2), 20.0, checks, "", "a", slip)
