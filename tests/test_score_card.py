"""The score card agrees with counts by hand, `score_boxes` and other error estimates."""

from types import SimpleNamespace

import numpy as np
import pytest

from utils import scenes
from utils.boxes import Box
from utils.scoring import Score, hidden_shares, score_boxes, score_card, with_error, within
from utils.scoring.card import counted

EVERYWHERE = ((-50, 50), (-50, 50))


def car(x, y=0.0, identity=1, returns=100, kind="car", size=(4.0, 2.0, 1.5)):
    return Box((x, y, 0.0), size, 0.0, kind, identity, returns=returns)


def frame_of(*boxes, cloud=None, objects=None):
    """Return a frame; without a cloud, no object in it is hidden."""
    cloud = np.zeros((0, 3)) if cloud is None else np.asarray(cloud, dtype=float)
    objects = np.asarray([] if objects is None else objects, dtype=int)
    return SimpleNamespace(boxes=boxes, cloud=cloud, scan=SimpleNamespace(objects=objects))


def shifted_corners(box, by):
    """Return the corners of a box moved by `by` metres along x.

    The IoU of a car 4 m long with its moved box is (4 - by) / (4 + by).
    """
    return box.corners + (by, 0, 0)


def test_hits_are_counted_at_three_overlaps_and_by_distance():
    near, middling, far = car(5), car(15, 9), car(30, -9)
    # Three boxes with overlaps of 0.78, 0.6 and 0.33, and one that does not overlap any object.
    found = np.array(
        [
            shifted_corners(near, 0.5),
            shifted_corners(middling, 1),
            shifted_corners(far, 2),
            shifted_corners(far, 12),
        ]
    )
    card = score_card([found], [frame_of(near, middling, far)], EVERYWHERE, "Three cars")
    assert card["recall"].values == pytest.approx((1, 2 / 3, 1 / 3))
    assert card["precision"].values == pytest.approx((3 / 4, 2 / 4, 1 / 4))
    assert card["F1"].values == pytest.approx((6 / 7, 4 / 7, 2 / 7))
    assert [card[name].values for name in ("recall to 10 m", "recall, 10–20 m")] == [
        (1, 1, 1), (1, 1, 0)
    ]  # fmt: skip
    assert card["recall beyond 20 m"].values == (1, 0, 0)
    assert [row.count for row in card.rows[:6]] == [4, 3, 3, 1, 1, 1]
    assert np.isnan(card["F1"].errors).all()  # undefined for a single frame


def test_the_card_agrees_with_score_boxes_on_a_street():
    frames = [scenes.random_street(seed, 0.9) for seed in range(2)]
    rng = np.random.default_rng(3)
    region = ((-15, 35), (-9, 9))
    found = [
        np.array([box.corners + rng.normal(0, 0.3, 3) for box in frame.boxes]) for frame in frames
    ]
    card = score_card(found, frames, region)
    for place, least in enumerate((0.3, 0.5, 0.7)):
        total = Score()
        for boxes, frame in zip(found, frames, strict=True):
            truth = np.array([box.corners for box in counted(frame, region)])
            total += score_boxes(boxes[within(boxes, region)], truth, least)
        values = [card[name].values[place] for name in ("precision", "recall", "F1")]
        assert values == pytest.approx([total.precision, total.recall, total.f1])
    assert card["recall"].count == sum(row.count for row in card.rows[3:6])
    assert card["recall"].count == sum(row.count for row in card.rows[6:])


def test_road_users_with_enough_returns_in_the_region_count():
    frame = frame_of(
        car(5, 0, 1), car(5, 9, 2, returns=29), car(5, 20, 3, kind="pole"), car(60, 0, 4),
        car(9, -9, 5, kind="pedestrian"),
    )  # fmt: skip
    assert [box.identity for box in counted(frame, EVERYWHERE)] == [1, 5]
    assert [box.identity for box in counted(frame, EVERYWHERE, least=20)] == [1, 2, 5]


def test_detected_boxes_outside_the_region_are_ignored():
    frame = frame_of(car(5))
    found = np.array([car(5).corners, car(80).corners])
    assert score_card([found], [frame], EVERYWHERE)["precision"].values == (1, 1, 1)


def test_a_card_may_have_no_objects_and_detections():
    nothing = np.empty((0, 8, 3))
    card = score_card([nothing, nothing], [frame_of(car(5)), frame_of()], EVERYWHERE)
    assert card["recall"].values == (0, 0, 0) and card["precision"].values == (1, 1, 1)
    assert card["recall beyond 20 m"].texts == ["–"] * 3


def test_a_value_from_one_frame_has_no_error():
    nothing = np.empty((0, 8, 3))
    frames = [frame_of(car(5), car(30, 9)), frame_of(car(5)), frame_of(car(5))]
    card = score_card([nothing] * 3, frames, EVERYWHERE)
    assert card["recall to 10 m"].texts == ["0.00 ± 0.00"] * 3
    assert card["recall beyond 20 m"].texts == ["0.00"] * 3
    assert card["precision"].texts == ["–"] * 3


def test_hidden_is_the_share_of_rays_that_hit_another_object_first():
    box = car(20, 0, 7)
    rays = [(18, 0, 0.2), (18, 0.5, 0.1), (18, -0.5, 0)]  # returns of the object
    before = [(9, 0.1, 0.0)]
    others = [(9, 3, 0), (9, 0, 2), (30, 0, 0), (8, 0.1, -0.1)]  # next to it, above, behind, ground
    frame = frame_of(box, cloud=rays + before + others, objects=[7] * 3 + [2] * 4 + [0])
    assert hidden_shares(frame, [box, box]) == pytest.approx([1 / 4, 1 / 4])
    assert hidden_shares(frame_of(box, cloud=rays, objects=[7] * 3), [box]) == 0
    behind_us = Box((-20, 0, 0), (4, 2, 1.5), 0.0, "car", 7)
    back = frame_of(
        behind_us, cloud=[(-x, y, z) for x, y, z in rays + before], objects=[7, 7, 7, 2]
    )
    assert hidden_shares(back, [behind_us]) == pytest.approx(1 / 4)


def test_the_error_of_a_mean_is_the_standard_error():
    rng = np.random.default_rng(0)
    numbers = rng.normal(5, 2, 40)
    value, error = with_error(
        np.column_stack([numbers, np.ones(40)]), lambda sums: sums[0] / sums[1]
    )
    assert value == pytest.approx(numbers.mean())
    assert error == pytest.approx(numbers.std(ddof=1) / np.sqrt(40))


def test_the_error_of_a_ratio_agrees_with_many_new_samples():
    rng = np.random.default_rng(1)

    def sample():
        whole = rng.integers(5, 20, 30)
        return np.column_stack([rng.binomial(whole, 0.7), whole])

    def share(sums):
        return sums[0] / sums[1]

    spread = np.std([share(sample().sum(axis=0)) for _ in range(2000)])
    errors = [with_error(sample(), share)[1] for _ in range(100)]
    assert np.mean(errors) == pytest.approx(spread, rel=0.1)


def test_a_card_is_shown_as_a_table(capsys):
    frames = [frame_of(car(5)), frame_of(car(6), car(30, 9))]
    found = [np.array([car(5).corners]), np.array([car(6.5).corners])]
    card = score_card(found, frames, EVERYWHERE, "Mine")
    card.show()
    head, *lines = capsys.readouterr().out.splitlines()
    assert head.split() == ["Mine", "of", "IoU", "0.3", "IoU", "0.5", "IoU", "0.7"]
    assert [line.split("  ")[0] for line in lines] == [row.name for row in card.rows]
    assert card["recall"].texts[0] == "0.67 ± 0.25" and "0.67 ± 0.25" in lines[1]
