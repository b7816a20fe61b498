"""Who breaks a promise that an exercise makes loses its check, and no other."""

import copy
import functools

import numpy as np
import pytest

from grader.course.lessons import load_reference
from tests.course_lessons import COURSE
from utils.checks import checks_of, common_checks
from utils.checks.core import run_check
from utils.checks.run_cache import one_run

LESSONS = {exercise.name: lesson.name for lesson in COURSE for exercise in lesson.machine_graded}
for name in LESSONS:
    checks_of(name)  # imports the lesson, which declares its promises


def marked(made, argument=""):
    """A promise as a case of a test; those on speed make some lessons slow."""
    slow = pytest.mark.slow if LESSONS[made.case.exercise][:2] in ("10", "12") else ()
    exercise = made.case.exercise
    return pytest.param(made, argument, id=f"{exercise} {made.name} {argument}", marks=slow)


def failures(exercise, function):
    """What is said of each visible check that a function does not pass, by its name."""
    function.__name__ = exercise
    with one_run():
        ended = [run_check(check, function) for check in checks_of(exercise)]
    return {outcome.check.name: str(outcome.failure) for outcome in ended if outcome.failure}


def lost(exercise, function):
    """Names of the visible checks that a function does not pass."""
    return set(failures(exercise, function))


@functools.cache
def right(exercise):
    return getattr(load_reference(LESSONS[exercise]), exercise)


# ---- one wrong function for each kind of promise ------------------------------------------------


def by_place_alone(right, made):
    return lambda *arguments: right(*arguments)


def with_all_arguments(right, made):
    def function(*arguments, **named):
        if len(arguments) + len(named) < len(made.case.given):
            raise TypeError("missing 1 required positional argument")
        return right(*arguments, **named)

    return function


def on_first(change):
    """The right answer to a changed first argument; the change knows all of them."""

    def broken(right, made):
        def function(*arguments, **named):
            first, *others = [*arguments, *named.values()]
            return right(*change(first, *others))

        return function

    return broken


def with_answer(change):
    """The right answer, changed; the change knows the arguments."""

    def broken(right, made):
        def function(*arguments, **named):
            given = [*arguments, *named.values()]
            return change(right(*given), *given)

        return function

    return broken


def indexes_intensity(cloud, *others):
    cloud[:, 3]  # there is none
    return cloud, *others


def adds_intensity(cloud, *others):
    if cloud.shape[1] == 4:
        cloud = cloud + np.outer(cloud[:, 3], [1.0, 0.0, 0.0, 0.0])
    return cloud, *others


def asks_the_first_point(cloud, *others):
    cloud[0]  # there is none
    return cloud, *others


def asks_for_a_largest_label(cloud, labels):
    labels[labels > 0].max()
    return cloud, labels


def counts_to_the_number_of_labels(cloud, labels):
    return cloud, np.where(labels > len(np.unique(labels[labels > 0])), 0, labels)


def boxes_noise(cloud, labels):
    return cloud, labels + (0 in labels and labels.any())


def by_appearance(boxes, cloud, labels):
    _, first = np.unique(labels[labels > 0], return_index=True)
    return boxes[np.argsort(first)]


def parts_equal_points(labels, cloud, *others):
    twice = len(np.unique(cloud, axis=0)) < len(cloud)
    return np.arange(1, len(cloud) + 1) if twice else labels


BREAKS = {
    "names": by_place_alone,
    "default": with_all_arguments,
    "three_columns": on_first(indexes_intensity),
    "fourth_column": on_first(adds_intensity),
    "few_points": on_first(asks_the_first_point),
    "nothing_left": on_first(asks_the_first_point),
    "all_columns": with_answer(lambda rows, *given: rows[:, :3]),
    "order": with_answer(lambda rows, *given: rows[::-1]),
    "no_boxes": on_first(asks_for_a_largest_label),
    "gaps": on_first(counts_to_the_number_of_labels),
    "ascending": with_answer(by_appearance),
    "noise": on_first(boxes_noise),
    "equal_points": with_answer(parts_equal_points),
}


@pytest.mark.parametrize(
    "made, _", [marked(made) for made in common_checks.made() if made.kind != "untouched"]
)
def test_who_breaks_a_promise_loses_that_check(made, _):
    exercise = made.case.exercise
    assert lost(exercise, BREAKS[made.kind](right(exercise), made)) == {made.name}


# ---- what is left untouched ---------------------------------------------------------------------

# What a function may write that is hard to see: into a column, a label or a number that a plain
# case does not have, else into the last number.
SPOILS = {
    "cloud": lambda cloud: cloud[:, 3:].fill(0.0),
    "cluster_labels": lambda labels: np.copyto(labels, -1, where=labels == 0),
    "line": lambda line: line[-1:].fill(0.0),
    "plane": lambda plane: plane[-1:].fill(0.0),
}


def spoils_last(values):
    if values.size:
        values.flat[-1] += 1


def spoiling(right, given, argument):
    """The right answer, after which one of the caller's arguments is written into."""
    place = list(given).index(argument)

    def function(*arguments, **named):
        values = [*arguments, *named.values()]
        answer = right(*copy.deepcopy(values))
        if place < len(values) and isinstance(values[place], np.ndarray):
            SPOILS.get(argument, spoils_last)(values[place])
        return answer

    return function


UNTOUCHED = [
    marked(made, argument)
    for made in common_checks.made()
    if made.kind == "untouched"
    for argument, value in made.case.given.items()
    if isinstance(value, np.ndarray)
]


@pytest.mark.parametrize("made, argument", UNTOUCHED)
def test_who_writes_into_an_argument_loses_that_check(made, argument):
    exercise = made.case.exercise
    wrong = spoiling(right(exercise), made.case.given, argument)
    assert made.name in lost(exercise, wrong)
    assert lost(exercise, wrong) <= {made.name, *also_about_writing(exercise)}


def also_about_writing(exercise):
    """A result that is a part of the input is changed with it."""
    return {"returns_a_new_array"} if exercise == "filter_clusters" else set()


@pytest.mark.parametrize("exercise", [name for name in LESSONS if LESSONS[name][:2] < "10"])
def test_the_right_answer_breaks_none(exercise):
    wrapped = with_answer(lambda answer, *given: answer)(right(exercise), None)
    names = {made.name for made in common_checks.made()}
    said = failures(exercise, wrapped)
    assert {name: text for name, text in said.items() if name in names} == {}


# ---- how they are made --------------------------------------------------------------------------


def test_every_kind_has_somebody_who_breaks_it():
    assert {made.kind for made in common_checks.made()} == {*BREAKS, "untouched"}


@pytest.mark.parametrize("made, _", [marked(made) for made in common_checks.made()])
def test_a_promise_is_a_check_of_its_lesson(made, _):
    [check] = [one for one in checks_of(made.case.exercise) if one.name == made.name]
    assert check.lesson == f"lesson_{LESSONS[made.case.exercise][:2]}"
    assert check.title and check.why and check.hint


def test_the_plain_case_is_seen_in_full():
    plain = {"cloud": np.zeros((3, 3)), "cluster_labels": np.array([1, 2, 2]), "min_num_points": 3}
    full = common_checks.in_full(plain)
    dark = common_checks.in_full({"cloud": np.zeros((3, 4))})["cloud"]
    assert dark.shape == (3, 4) and dark[:, 3].all()
    assert list(full) == list(plain) and full["min_num_points"] == 3
    assert full["cloud"].shape == (5, 4) and full["cloud"][:, 3].all()
    assert full["cluster_labels"].tolist() == [1, 2, 2, 0, 0]
    assert plain["cloud"].shape == (3, 3) and plain["cluster_labels"].tolist() == [1, 2, 2]


def test_what_has_all_there_is_stays_as_it_is():
    plain = {
        "cloud": np.ones((3, 4)),
        "cluster_labels": np.array([0, 2, 2]),
        "line": np.array([0.6, 0.8, 1.0]),
    }
    assert all(common_checks.in_full(plain)[name] is value for name, value in plain.items())


def test_a_line_through_the_origin_is_moved_off_it():
    assert common_checks.in_full({"line": np.array([0.6, -0.8, 0.0])})["line"][2] != 0
    flat = {"points": np.ones((4, 2))}
    assert common_checks.in_full(flat)["points"] is flat["points"], (
        "points on a map have two columns"
    )


def test_nobody_can_change_a_case():
    for made in common_checks.made():
        for value in (*made.case.given.values(), made.case.expected):
            assert not isinstance(value, np.ndarray) or not value.flags.writeable, made
