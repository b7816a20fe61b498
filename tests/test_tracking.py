"""The tracker calls a student's functions and stores the tracks."""

from types import SimpleNamespace

import numpy as np
import pytest

from utils.tracking import Tracker, tracker_from


def boxes_at(*centres):
    corners = [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    unit = np.array(corners, dtype=float) - 0.5
    return np.array([unit + np.append(centre, 0.0) for centre in centres]).reshape(-1, 8, 3)


def match_nearest(previous, current, limit):
    """Match each box with the nearest previous box, or -1. This works if objects are far apart."""
    partners = []
    for box in current:
        away = [np.hypot(*(box - old).mean(axis=0)[:2]) for old in previous]
        partners.append(int(np.argmin(away)) if away and min(away) <= limit else -1)
    return partners


def move(boxes, velocities, seconds):
    return [[corner + seconds * way for corner in box] for box, way in zip(boxes, velocities)]  # noqa: B905


def correct_halfway(expected, velocities, found, gain, seconds):
    return expected + gain * (found - expected), velocities + 1.0


def keep_waiting(missed, partners, patience):
    counted = [0 if row in partners else before + 1 for row, before in enumerate(missed)]
    return counted, [count <= patience for count in counted]


def count_boxes(hits, partners, needed):
    counts = [hits[partner] + 1 if partner >= 0 else 1 for partner in partners]
    return counts, [count >= needed for count in counts]


def test_a_track_id_is_constant_and_never_reused():
    tracker = Tracker(match_nearest)
    assert tracker.update(boxes_at((0, 0), (9, 0))).tolist() == [1, 2]
    assert tracker.update(boxes_at((9, 1), (30, 0), (0, 1))).tolist() == [2, 3, 1]
    assert tracker.update(boxes_at()).tolist() == []
    assert tracker.update(boxes_at((9, 1))).tolist() == [4]
    assert tracker.tracks.age.tolist() == [1]


def test_the_last_position_counts_without_a_prediction():
    ways = {
        "stays": Tracker(match_nearest),
        "comes": Tracker(match_nearest, predict=move, newcomer=(-9, 0, 0)),
    }
    for way, tracker in ways.items():
        names = [tracker.update(boxes_at((x, 0)), 0.2).tolist() for x in (20, 18.2, 16.4)]
        assert names == ([[1], [2], [3]] if way == "stays" else [[1], [1], [1]])


def test_a_track_has_its_corrected_state():
    tracker = Tracker(
        match_nearest, predict=move, correct=correct_halfway, gain=0.25, newcomer=(-2, 0, 0)
    )
    tracker.update(boxes_at((10, 0)), 0.5)
    tracker.update(boxes_at((9.4, 0), (40, 0)), 0.5)  # the first box was expected at 9
    centres = tracker.tracks.boxes.mean(axis=1)[:, 0]
    np.testing.assert_allclose(centres, [9.1, 40])
    np.testing.assert_allclose(tracker.tracks.velocities, [(-1, 1, 1), (-2, 0, 0)])
    assert tracker.tracks.ids.tolist() == [1, 2]


@pytest.mark.parametrize(
    ("patience", "names"), [(0, [3, 2]), (1, [3, 2]), (2, [1, 2]), (5, [1, 2])]
)
def test_a_track_without_a_box_coasts_for_a_while(patience, names):
    tracker = Tracker(
        match_nearest, predict=move, coast=keep_waiting, patience=patience, newcomer=(-10, 0, 0)
    )
    tracker.update(boxes_at((20, 0), (50, 0)))
    for x in (49, 48):
        tracker.update(boxes_at((x, 0)))
    kept = patience >= 2
    assert tracker.tracks.missed.tolist() == ([0, 2] if kept else [0])
    if kept:
        assert tracker.tracks.boxes[1].mean(axis=0)[0] == pytest.approx(18)
    assert tracker.update(boxes_at((17, 0), (47, 0))).tolist() == names
    assert tracker.tracks.missed.tolist() == [0, 0]


def test_a_track_is_tentative_until_it_has_had_enough_boxes():
    both, left, right = boxes_at((0, 0), (9, 0)), boxes_at((0, 0)), boxes_at((9, 0))
    tracker = Tracker(match_nearest, coast=keep_waiting, confirm=count_boxes, needed=3)
    states = []
    for boxes in (left, both, right, both, boxes_at()):
        tracker.update(boxes)
        tracks = tracker.tracks
        states.append(dict(zip(tracks.ids.tolist(), tracks.confirmed.tolist(), strict=True)))
    assert states[:3] == [{1: False}, {1: False, 2: False}, {2: False, 1: False}]
    assert states[3:] == [{1: True, 2: True}] * 2, "a track stays confirmed while it coasts"
    assert tracker.tracks.age.tolist() == [3, 3]


def test_every_track_counts_if_confirm_is_not_written():
    tracker = Tracker(match_nearest)
    tracker.update(boxes_at((0, 0)))
    assert tracker.tracks.confirmed.tolist() == [True]


def test_a_new_track_moves_like_most_others():
    tracker = Tracker(match_nearest, correct=lambda expected, velocities, found, *_: (
        found, np.array([[-5.0, 0, 0], [-5, 0, 0], [7, 1, 0]])))  # fmt: skip
    for _ in range(2):
        tracker.update(boxes_at((0, 0), (9, 0), (18, 0)))
    tracker.update(boxes_at((40, 0)))
    assert tracker.tracks.velocities.tolist() == [[-5, 0, 0]]


def test_the_tracker_does_not_change_its_input():
    tracker, found = Tracker(match_nearest, correct=correct_halfway), boxes_at((0, 0))
    before = found.copy()
    tracker.update(found)
    tracker.update(found + 0.1)
    assert np.array_equal(found, before)


def test_an_invalid_partner_starts_a_new_track():
    tracker = Tracker(lambda previous, current, limit: [7] * len(current), coast=keep_waiting)
    tracker.update(boxes_at((0, 0)))
    assert tracker.update(boxes_at((0, 0))).tolist() == [2]


def test_functions_that_are_still_stubs_are_not_called():
    def coast(missed, partners, patience):
        raise NotImplementedError

    coast.is_stub = True
    functions = SimpleNamespace(match_boxes=match_nearest, predict_boxes=move, coast=coast)
    tracker = tracker_from(functions, newcomer=(-10, 0, 0))
    tracker.update(boxes_at((20, 0)))
    assert tracker.update(boxes_at((18, 0)), 0.2).tolist() == [1]
    tracker.update(boxes_at())
    assert len(tracker.tracks.ids) == 0
    assert tracker_from(SimpleNamespace(detect_obstacles=len)) is None
