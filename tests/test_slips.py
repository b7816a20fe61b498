"""From the checks alone, likely slips earn about as many points as a teacher would give."""

import textwrap

import pytest

from grader.course.lessons import lesson_of, load_reference
from grader.judging.runner import run_checks
from tests.slip_tables import TABLES, solution_of
from tests.students import student_with

SEED = 7
ALL = {
    f"{exercise}: {slip.title}": (exercise, slip)
    for table in TABLES.values()
    for exercise, likeliest in table.items()
    for slip in likeliest
}


def with_slip(exercise, slip):
    """Return the lesson, and the functions of its solution, one of them with the slip."""
    lesson, source = lesson_of(exercise), slip.applied_to(solution_of(exercise))
    answers = vars(load_reference(lesson.name))
    space = dict(answers[exercise].__globals__)
    exec(textwrap.dedent(source), space)
    return lesson, {**answers, exercise: space[exercise]}


def share_of(exercise, slip):
    """Return the share of the points that a slip earns, and the names of the failed checks."""
    lesson, answers = with_slip(exercise, slip)
    outcomes = run_checks(
        lesson, student_with(lesson, answers), SEED, lambda check: check.exercise == exercise
    )
    whole = sum(outcome.check.weight for outcome in outcomes)
    failed = [outcome.check for outcome in outcomes if outcome.failure is not None]
    return 1 - sum(check.weight for check in failed) / whole, [check.name for check in failed]


def test_each_slip_is_a_change_to_the_present_solution():
    for exercise, slip in ALL.values():
        source = solution_of(exercise)
        changed = slip.applied_to(source)
        assert changed != source, slip.title
        compile(textwrap.dedent(changed), slip.title, "exec")


@pytest.mark.slow
@pytest.mark.parametrize("case", ALL)
def test_a_slip_earns_the_share_that_a_teacher_would_give(case):
    exercise, slip = ALL[case]
    share, failed = share_of(exercise, slip)
    assert failed
    assert slip.harm.least <= share <= slip.harm.most, (round(share, 3), failed)
