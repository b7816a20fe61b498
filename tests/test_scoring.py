"""Overlaps, matching and scores agree with polygon clipping, brute force and counts by hand."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from shapely import MultiPoint

from utils.boxes import Box, distances_between, footprints
from utils.scenes import lesson_street
from utils.scoring import (
    Score,
    TrackedFrame,
    match,
    plane_iou,
    score_boxes,
    score_stream,
    space_iou,
)


def corners(x=0.0, y=0.0, z=0.0, length=4.0, width=2.0, height=1.5, yaw=0.0):
    return Box((x, y, z), (length, width, height), yaw, "car", 1).corners


def random_boxes(rng, count, spread=4.0):
    return np.array(
        [
            corners(*rng.uniform(-spread, spread, 3), *rng.uniform(0.2, 5, 3), rng.uniform(-4, 4))
            for _ in range(count)
        ]
    )


def area(polygon):
    """Return the area of a polygon, computed with the shoelace formula."""
    return sum(x * v - u * y for (x, y), (u, v) in sides(polygon)) / 2


def sides(polygon):
    return zip(polygon, polygon[1:] + polygon[:1], strict=True)


def clip(polygon, start, end):
    """Return the part of a polygon to the left of a line (Sutherland and Hodgman, 1974)."""
    along = end[0] - start[0], end[1] - start[1]
    kept = []
    for here, there in sides(polygon):
        left, right = (
            along[0] * (y - start[1]) - along[1] * (x - start[0]) for x, y in (here, there)
        )
        if left >= 0:
            kept.append(here)
        if left * right < 0:
            way = left / (left - right)
            kept.append([a + way * (b - a) for a, b in zip(here, there, strict=True)])
    return kept


def clipped_iou(box, other, space):
    first, second = box[:4, :2].tolist(), other[:4, :2].tolist()
    common = first
    for start, end in sides(second):
        common = clip(common, start, end)
    shared, sizes = area(common), [area(first), area(second)]
    if space:
        low, high = max(box[0, 2], other[0, 2]), min(box[4, 2], other[4, 2])
        shared *= max(high - low, 0.0)
        sizes = [sizes[0] * (box[4, 2] - box[0, 2]), sizes[1] * (other[4, 2] - other[0, 2])]
    return shared / (sum(sizes) - shared)


@pytest.mark.parametrize("overlap", [plane_iou, space_iou])
def test_overlap_agrees_with_polygon_clipping(overlap):
    rng = np.random.default_rng(0)
    boxes, others = random_boxes(rng, 60), random_boxes(rng, 50)
    expected = [[clipped_iou(a, b, overlap is space_iou) for b in others] for a in boxes]
    assert np.count_nonzero(expected) > 300
    assert_allclose(overlap(boxes, others), expected, atol=1e-9)


@settings(max_examples=150, deadline=None)
@given(
    st.tuples(*[st.sampled_from([-2.0, -1.0, 0.0, 1e-7, 1.0, 2.0, 4.0])] * 2),
    st.tuples(*[st.sampled_from([1.0, 2.0, 2.0 + 1e-9, 4.0])] * 2),
    st.sampled_from([0.0, 1e-9, np.pi / 4, np.pi / 2, np.pi / 2 + 1e-12, 0.3]),
    st.sampled_from([0.0, 1.0, 1e5]),
)
def test_overlap_is_accurate_despite_shared_edges_corners_and_rounding(shift, size, yaw, far):
    box = corners(far, far, yaw=yaw)[None]
    other = corners(far + shift[0], far + shift[1], 0.0, *size, yaw=0.0)[None]
    local_box, local_other = box - (far, far, 0), other - (far, far, 0)
    expected = clipped_iou(local_box[0], local_other[0], False)
    assert_allclose(plane_iou(box, other)[0, 0], expected, atol=1e-6 if far < 10 else 1e-4)


def boxes_on(floors):
    """Return boxes (N, 8, 3) with the given floors (N, 4, 2)."""
    return np.stack(
        [np.pad(floors, ((0, 0), (0, 0), (0, 1)), constant_values=z) for z in (0, 1)], 1
    )


@pytest.mark.parametrize("seed", range(3))
def test_geometry_of_floors_agrees_with_shapely(seed):
    """Four random points can also have a triangle as their hull."""
    rng = np.random.default_rng(seed)
    floors = rng.normal(0, 2, (80, 4, 2))
    boxes = np.vstack([boxes_on(floors).reshape(-1, 8, 3), random_boxes(rng, 40)])
    hulls = [MultiPoint(box[:4, :2]).convex_hull for box in boxes]
    areas = [[hull.intersection(other).area for other in hulls] for hull in hulls]
    unions = [[hull.union(other).area for other in hulls] for hull in hulls]
    assert_allclose(plane_iou(boxes, boxes), np.divide(areas, unions), atol=1e-9)
    gaps = [[hull.distance(other) for other in hulls] for hull in hulls]
    assert np.count_nonzero(gaps) > 1000 and np.count_nonzero(np.equal(gaps, 0)) > 1000
    assert_allclose(distances_between(boxes, boxes), gaps, atol=1e-9)
    for footprint, hull in zip(footprints(boxes), hulls, strict=True):
        assert_allclose(MultiPoint(footprint).convex_hull.area, hull.area)


def test_boxes_with_a_corner_that_is_not_finite_have_no_overlap():
    some = random_boxes(np.random.default_rng(2), 3)
    for value in (np.nan, np.inf):
        lost = some.copy()
        lost[1, 2, 0] = value
        assert_allclose(np.diag(plane_iou(lost, some)), [1, 0, 1])


def test_overlaps_agree_with_results_computed_by_hand():
    square = corners(0, 0, 0, 2, 2, 2)[None]
    assert_allclose(plane_iou(square, square), 1.0)
    assert_allclose(space_iou(square, square), 1.0)
    assert_allclose(plane_iou(square, square + (1, 0, 0)), 1 / 3)
    assert_allclose(space_iou(square, square + (1, 0, 1)), 1 / 7)
    assert_allclose(plane_iou(square, square + (1, 0, 9)), 1 / 3)
    assert_allclose(space_iou(square, square + (0, 0, 9)), 0.0)
    assert_allclose(plane_iou(square, square + (2, 0, 0)), 0.0, atol=1e-12)
    # Two squares, one rotated by 45 degrees, intersect in a regular octagon.
    octagon = 8 * (np.sqrt(2) - 1)
    turned = corners(0, 0, 0, 2, 2, 2, np.pi / 4)[None]
    assert_allclose(plane_iou(square, turned), octagon / (8 - octagon))


def test_the_order_of_floor_and_roof_corners_does_not_matter():
    rng = np.random.default_rng(3)
    boxes, others = random_boxes(rng, 20), random_boxes(rng, 20)
    mixed = np.array(
        [np.vstack([box[:4][rng.permutation(4)], box[4:][rng.permutation(4)]]) for box in boxes]
    )
    assert_allclose(space_iou(mixed, others), space_iou(boxes, others), atol=1e-12)


def test_axis_aligned_boxes_may_have_the_corner_order_of_the_lesson():
    bits = np.arange(8)
    corner = np.column_stack([bits & 1, bits >> 1 & 1, bits >> 2]) * (4.0, 2.0, 1.5)
    assert_allclose(space_iou(corner[None], corners(2, 1, 0.75)[None]), 1.0)


@pytest.mark.parametrize("overlap", [plane_iou, space_iou])
def test_empty_lists_and_flat_boxes_have_no_overlap(overlap):
    some, none = random_boxes(np.random.default_rng(1), 3), np.zeros((0, 8, 3))
    assert overlap(none, some).shape == (0, 3)
    assert overlap(some, none).shape == (3, 0)
    assert overlap([], []).shape == (0, 0)
    line, point = corners(width=0.0)[None], corners(length=0.0, width=0.0, height=0.0)[None]
    for flat in (line, point):
        assert_allclose(overlap(flat, corners()[None]), 0.0)
        assert_allclose(overlap(flat, flat), 0.0)


@pytest.mark.parametrize("overlap", [plane_iou, space_iou])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_box_that_is_not_finite_has_no_overlap(overlap, bad):
    boxes = np.repeat(corners()[None], 3, axis=0)
    boxes[1, 0, 0] = bad
    assert_allclose(overlap(boxes, boxes), [[1, 0, 1], [0, 0, 0], [1, 0, 1]])


@pytest.mark.parametrize("shape", [(8, 3), (2, 4, 2), (2, 3, 8)])
def test_arrays_that_are_not_boxes_are_refused(shape):
    with pytest.raises(ValueError, match=r"\(N, 8, 3\)"):
        plane_iou(np.ones(shape), np.ones((1, 8, 3)))


@pytest.mark.parametrize("seed", range(20))
def test_matching_finds_the_best_of_all_permutations(seed):
    rng = np.random.default_rng(seed)
    overlaps = rng.random((4, 5)) * (rng.random((4, 5)) < 0.7)
    partners = match(overlaps, 0.4)
    paired = np.flatnonzero(partners >= 0)
    assert len(set(partners[paired])) == len(paired)
    assert np.all(overlaps[paired, partners[paired]] >= 0.4)
    worth = np.where(overlaps >= 0.4, overlaps, 0.0)
    best = max(worth[range(4), order].sum() for order in permutations(range(5), 4))
    assert_allclose(overlaps[paired, partners[paired]].sum(), best)


def test_matching_accepts_empty_lists():
    assert match(np.zeros((0, 3))).shape == (0,)
    assert match(np.zeros((2, 0))).tolist() == [-1, -1]
    assert match(np.zeros((2, 2)), 0.0).tolist() == [-1, -1]


def test_scores_of_a_frame_agree_with_a_count_by_hand():
    truth = np.array([corners(0), corners(10), corners(20)])
    found = np.array([corners(0.2), corners(13), corners(20, 0.1), corners(20, 0.3)])
    score = score_boxes(found, truth)
    assert score == Score(2, 2, 1)
    assert (score.precision, score.recall) == (0.5, 2 / 3)
    assert_allclose(score.f1, 2 * 0.5 * (2 / 3) / (0.5 + 2 / 3))
    assert score + score == Score(4, 4, 2)
    # The lifted boxes coincide with the true ones in the plane, but do not overlap in space.
    lifted = truth + (0, 0, 5.0)
    assert score_boxes(lifted, truth).f1 == 1.0
    assert score_boxes(lifted, truth, overlap=space_iou).f1 == 0.0


def test_empty_frames_have_scores():
    none, some = np.zeros((0, 8, 3)), corners()[None]
    assert (score_boxes(none, none).precision, score_boxes(none, none).f1) == (1.0, 1.0)
    assert (score_boxes(none, some).recall, score_boxes(none, some).f1) == (0.0, 0.0)
    assert (score_boxes(some, none).precision, score_boxes(some, none).f1) == (0.0, 0.0)


def test_the_true_boxes_of_a_street_score_full_marks():
    boxes = np.array([box.corners for box in lesson_street().boxes if box.kind != "foliage"])
    assert score_boxes(boxes, boxes[::-1], 0.99, space_iou) == Score(len(boxes))


def tracked_frame(truth, found):
    """Return a frame; `truth` and `found` map labels to the x of the boxes."""
    return TrackedFrame(
        np.array([corners(x) for x in found.values()]),
        tuple(found),
        np.array([corners(x) for x in truth.values()]),
        tuple(truth),
    )


def test_a_faithful_tracker_never_switches_labels():
    frames = [tracked_frame({1: t, 2: 20 - t}, {7: 20 - t, 8: t + 0.1}) for t in range(8)]
    assert score_stream(frames) == Score(16, 0, 0, 0)


def test_each_change_of_label_is_one_switch():
    frames = [
        tracked_frame({1: 0, 2: 10}, {7: 0, 8: 10}),
        tracked_frame({1: 0, 2: 10}, {8: 0, 7: 10}),  # both labels are swapped
        tracked_frame({1: 0, 2: 10}, {8: 0}),  # one object is missed
        tracked_frame({1: 0, 2: 10}, {8: 0, 9: 10}),  # the object is found again, under a new label
    ]
    assert score_stream(frames) == Score(7, 0, 1, 3)


def test_a_label_that_can_be_kept_is_kept():
    # Label 8 overlaps more, but label 7 was on the object before and still matches.
    frames = [tracked_frame({1: 0}, {7: 0}), tracked_frame({1: 0}, {7: 0.4, 8: 0.1})]
    assert score_stream(frames) == Score(2, 1, 0, 0)


def test_empty_streams_have_scores():
    assert score_stream([]) == Score()
    empty = TrackedFrame(np.zeros((0, 8, 3)), (), np.zeros((0, 8, 3)), ())
    assert score_stream([empty, tracked_frame({1: 0}, {}), tracked_frame({}, {3: 0})]) == Score(
        0, 1, 1
    )
