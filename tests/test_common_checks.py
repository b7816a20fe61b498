"""A function that violates one of the common requirements fails only the check for it."""

import copy
import functools

import numpy as np
import pytest

from grader.course.lessons import load_reference
from tests.course_lessons import COURSE
from utils.checks import checks_of, common_checks
from utils.checks.core import run_check
from utils.checks.run_cache import cached_run

LESSONS = {exercise.name: lesson.name for lesson in COURSE for exercise in lesson.machine_graded}
for name in LESSONS:
    checks_of(name)  # imports the lesson, which declares its common checks


def parameter(promise, argument=""):
    """Return a common check as a test parameter, marked as slow if its lesson has speed checks."""
    slow = pytest.mark.slow if LESSONS[promise.case.exercise][:2] in ("10", "12") else ()
    exercise = promise.case.exercise
    return pytest.param(promise, argument, id=f"{exercise} {promise.name} {argument}", marks=slow)


def failures(exercise, function):
    """Return the message of each visible check that a function fails, by the check's name."""
    function.__name__ = exercise
    with cached_run():
        outcomes = [run_check(check, function) for check in checks_of(exercise)]
    return {outcome.check.name: str(outcome.failure) for outcome in outcomes if outcome.failure}


def failed_checks(exercise, function):
    """Return the names of the visible checks that a function fails."""
    return set(failures(exercise, function))


@functools.cache
def right_function(exercise):
    return getattr(load_reference(LESSONS[exercise]), exercise)


# ---- one wrong function for each kind of common check -------------------------------------------


def positional_only(right, promise):
    return lambda *arguments: right(*arguments)


def without_defaults(right, promise):
    def function(*arguments, **named):
        if len(arguments) + len(named) < len(promise.case.arguments):
            raise TypeError("missing 1 required positional argument")
        return right(*arguments, **named)

    return function


def with_changed_first_argument(change):
    """Break a function by changing its first argument; `change` receives all arguments."""

    def broken(right, promise):
        def function(*arguments, **named):
            first, *others = [*arguments, *named.values()]
            return right(*change(first, *others))

        return function

    return broken


def with_changed_answer(change):
    """Break a function by changing its answer; `change` also receives the arguments."""

    def broken(right, promise):
        def function(*arguments, **named):
            given = [*arguments, *named.values()]
            return change(right(*given), *given)

        return function

    return broken


def indexes_intensity(cloud, *others):
    cloud[:, 3]  # raises IndexError without a fourth column
    return cloud, *others


def adds_intensity(cloud, *others):
    if cloud.shape[1] == 4:
        cloud = cloud + np.outer(cloud[:, 3], [1.0, 0.0, 0.0, 0.0])
    return cloud, *others


def needs_a_point(cloud, *others):
    cloud[0]  # raises IndexError without points
    return cloud, *others


def needs_a_label(cloud, labels):
    labels[labels > 0].max()
    return cloud, labels


def counts_to_the_number_of_labels(cloud, labels):
    return cloud, np.where(labels > len(np.unique(labels[labels > 0])), 0, labels)


def boxes_noise(cloud, labels):
    return cloud, labels + (0 in labels and labels.any())


def orders_by_appearance(boxes, cloud, labels):
    _, first = np.unique(labels[labels > 0], return_index=True)
    return boxes[np.argsort(first)]


def separates_equal_points(labels, cloud, *others):
    twice = len(np.unique(cloud, axis=0)) < len(cloud)
    return np.arange(1, len(cloud) + 1) if twice else labels


BREAKING_FUNCTIONS = {
    "names": positional_only,
    "default": without_defaults,
    "three_columns": with_changed_first_argument(indexes_intensity),
    "fourth_column": with_changed_first_argument(adds_intensity),
    "few_points": with_changed_first_argument(needs_a_point),
    "nothing_left": with_changed_first_argument(needs_a_point),
    "all_columns": with_changed_answer(lambda rows, *given: rows[:, :3]),
    "order": with_changed_answer(lambda rows, *given: rows[::-1]),
    "no_boxes": with_changed_first_argument(needs_a_label),
    "gaps": with_changed_first_argument(counts_to_the_number_of_labels),
    "ascending": with_changed_answer(orders_by_appearance),
    "noise": with_changed_first_argument(boxes_noise),
    "equal_points": with_changed_answer(separates_equal_points),
}


@pytest.mark.parametrize(
    "promise, _",
    [parameter(promise) for promise in common_checks.all_promises() if promise.kind != "untouched"],
)
def test_a_broken_promise_fails_only_its_check(promise, _):
    exercise = promise.case.exercise
    assert failed_checks(
        exercise, BREAKING_FUNCTIONS[promise.kind](right_function(exercise), promise)
    ) == {promise.name}


# ---- arguments stay unchanged -------------------------------------------------------------------

# Changes of arguments that are hard to notice, because they affect a column, label or number that
# plain cases lack. `changes_last` changes arguments that are not listed here.
SIDE_EFFECTS = {
    "cloud": lambda cloud: cloud[:, 3:].fill(0.0),
    "cluster_labels": lambda labels: np.copyto(labels, -1, where=labels == 0),
    "line": lambda line: line[-1:].fill(0.0),
    "plane": lambda plane: plane[-1:].fill(0.0),
}


def changes_last(values):
    if values.size:
        values.flat[-1] += 1


def change_argument(right, given, argument):
    """Return the correct function with a side effect on one of its arguments."""
    position = list(given).index(argument)

    def function(*arguments, **named):
        values = [*arguments, *named.values()]
        answer = right(*copy.deepcopy(values))
        if position < len(values) and isinstance(values[position], np.ndarray):
            SIDE_EFFECTS.get(argument, changes_last)(values[position])
        return answer

    return function


UNTOUCHED_ARGUMENTS = [
    parameter(promise, argument)
    for promise in common_checks.all_promises()
    if promise.kind == "untouched"
    for argument, value in promise.case.arguments.items()
    if isinstance(value, np.ndarray)
]


@pytest.mark.parametrize("promise, argument", UNTOUCHED_ARGUMENTS)
def test_changing_an_argument_fails_only_that_check(promise, argument):
    exercise = promise.case.exercise
    wrong = change_argument(right_function(exercise), promise.case.arguments, argument)
    assert promise.name in failed_checks(exercise, wrong)
    assert failed_checks(exercise, wrong) <= {promise.name, *other_checks_about_writing(exercise)}


def other_checks_about_writing(exercise):
    """Return the names of the other checks that fail if a function changes its argument."""
    return {"returns_a_new_array"} if exercise == "filter_clusters" else set()


@pytest.mark.parametrize("exercise", [name for name in LESSONS if LESSONS[name][:2] < "10"])
def test_right_answers_pass_all_common_checks(exercise):
    wrapped = with_changed_answer(lambda answer, *given: answer)(right_function(exercise), None)
    names = {promise.name for promise in common_checks.all_promises()}
    messages = failures(exercise, wrapped)
    assert {name: text for name, text in messages.items() if name in names} == {}


# ---- how common checks are made -----------------------------------------------------------------


def test_every_promise_is_tested_with_a_function_that_breaks_it():
    assert {promise.kind for promise in common_checks.all_promises()} == {
        *BREAKING_FUNCTIONS,
        "untouched",
    }


@pytest.mark.parametrize(
    "promise, _", [parameter(promise) for promise in common_checks.all_promises()]
)
def test_a_common_check_belongs_to_its_lesson(promise, _):
    [check] = [check for check in checks_of(promise.case.exercise) if check.name == promise.name]
    assert check.lesson == f"lesson_{LESSONS[promise.case.exercise][:2]}"
    assert check.title and check.why and check.hint


def test_in_full_adds_missing_features_to_a_plain_case():
    plain = {"cloud": np.zeros((3, 3)), "cluster_labels": np.array([1, 2, 2]), "min_num_points": 3}
    full = common_checks.extend_arguments(plain)
    dark_cloud = common_checks.extend_arguments({"cloud": np.zeros((3, 4))})["cloud"]
    assert dark_cloud.shape == (3, 4) and dark_cloud[:, 3].all()
    assert list(full) == list(plain) and full["min_num_points"] == 3
    assert full["cloud"].shape == (5, 4) and full["cloud"][:, 3].all()
    assert full["cluster_labels"].tolist() == [1, 2, 2, 0, 0]
    assert plain["cloud"].shape == (3, 3) and plain["cluster_labels"].tolist() == [1, 2, 2]


def test_in_full_returns_complete_values_unchanged():
    plain = {
        "cloud": np.ones((3, 4)),
        "cluster_labels": np.array([0, 2, 2]),
        "line": np.array([0.6, 0.8, 1.0]),
    }
    assert all(
        common_checks.extend_arguments(plain)[name] is value for name, value in plain.items()
    )


def test_a_line_through_the_origin_is_moved_away_from_it():
    assert common_checks.extend_arguments({"line": np.array([0.6, -0.8, 0.0])})["line"][2] != 0
    flat = {"points": np.ones((4, 2))}
    assert common_checks.extend_arguments(flat)["points"] is flat["points"], (
        "points on a map have two columns"
    )


def test_cases_are_read_only():
    for promise in common_checks.all_promises():
        for value in (*promise.case.arguments.values(), promise.case.expected):
            assert not isinstance(value, np.ndarray) or not value.flags.writeable, promise
