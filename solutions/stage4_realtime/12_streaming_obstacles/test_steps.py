"""Tests of the tracker's steps in lesson 12: kept answers, and the theory of the gains."""

import numpy as np
import pytest

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson, load_reference
from tests.lesson_texts import run_statements_for
from tests.ungraded_steps import assert_mistakes_have_answers, assert_notes_hold, failures_of
from utils.checks.diagnosis import diagnose
from utils.tracking import Tracker

LESSON = find_lesson("12_streaming_obstacles")
STEPS = ("predict_boxes", "correct_boxes", "coast", "confirm")
ANSWERS = [(name, variant) for name in STEPS for variant in answers_to(name)]


def function_of(name, variant):
    namespace = {"np": np}
    exec(variant.source, namespace)
    return namespace[name]


@pytest.mark.parametrize("name", STEPS)
def test_the_solution_passes(name):
    step = getattr(load_reference(LESSON.name, *STEPS), name)
    assert not failures_of(name, step) and diagnose(name, step) is None


@pytest.mark.parametrize(
    ("name", "variant"),
    [pytest.param(*answer, id=f"{answer[0]}: {answer[1].name}") for answer in ANSWERS],
)
def test_kept_answers_pass_or_fail_as_claimed(name, variant):
    function = function_of(name, variant)
    assert_notes_hold(variant, failures_of(name, function), diagnose(name, function))


@pytest.mark.parametrize("name", STEPS)
def test_every_known_mistake_has_a_kept_answer(name):
    assert_mistakes_have_answers(name, answers_to(name))


def test_a_ghost_in_one_frame_has_a_track_for_four_frames_but_is_never_confirmed():
    course = load_reference(LESSON.name, "match_boxes", *STEPS)
    tracker = Tracker(course.match_boxes, coast=course.coast, confirm=course.confirm)
    alive = []
    for boxes in (0, 1, 0, 0, 0, 0):
        tracker.update(np.ones((boxes, 8, 3)))
        assert not tracker.tracks.confirmed.any()
        alive.append(len(tracker.tracks.ids))
    assert alive == [0, 1, 1, 1, 1, 0]


def test_confirm_solves_the_tiny_case():
    confirm = function_of("confirm", next(answer for name, answer in ANSWERS if name == "confirm"))
    hits, confirmed = confirm(np.array([4, 1, 2, 3]), np.array([2, -1, 0, 1]), 3)
    assert hits.tolist() == [3, 1, 5, 2] and confirmed.tolist() == [True, False, True, False]


def steady_state_gains(wobble, acceleration, seconds):
    """Compute the gains of a steady-state constant-velocity Kalman filter by Riccati recursion."""
    transition = np.array([[1, seconds], [0, 1]])
    push = np.array([seconds**2 / 2, seconds]) * acceleration
    noise, covariance = np.outer(push, push), np.eye(2) * 100.0
    for _ in range(20_000):
        predicted = transition @ covariance @ transition.T + noise
        gains = predicted[:, 0] / (predicted[0, 0] + wobble**2)
        covariance = predicted - np.outer(gains, predicted[0])
    return gains


@pytest.mark.parametrize(
    ("wobble", "acceleration", "seconds"), [(0.085, 2.0, 0.1), (0.02, 3.0, 0.1), (0.3, 0.7, 0.25)]
)
def test_the_gains_are_those_of_a_steady_state_kalman_filter(wobble, acceleration, seconds):
    lesson = run_statements_for(LESSON.name, "gain_for", "correct_boxes")
    alpha, beta_per_second = steady_state_gains(wobble, acceleration, seconds)
    gain = lesson["gain_for"](wobble, acceleration, seconds)
    assert gain == pytest.approx(alpha, rel=1e-6)
    box = np.zeros((1, 8, 3))
    _, velocity = lesson["correct_boxes"](box, np.zeros((1, 3)), box + 1.0, gain, seconds)
    assert velocity[0, 0] == pytest.approx(beta_per_second, rel=1e-6)
