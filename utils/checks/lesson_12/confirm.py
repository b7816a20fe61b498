"""Visible checks of `confirm`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    assert_arguments_unchanged,
    brief_text,
    frozen,
    observe,
)
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes, same_array
from utils.checks.failures import fixed
from utils.checks.lesson_12.steps import as_counts_and_flags, same_pair

_HITS = frozen(np.array([4, 1, 2, 3]))
_TRACK_OF_BOX = frozen(np.array([2, -1, 0, 1, -1]))
_GIVEN_HITS = "hits [4, 1, 2, 3], partners [2, -1, 0, 1, -1], needed 3"
_RIGHT_HITS = frozen(np.array([3, 1, 5, 2, 1]))


def _right_hits(
    hits: np.ndarray, partners: np.ndarray, needed: int
) -> tuple[np.ndarray, np.ndarray]:
    counts = [hits[partner] + 1 if partner >= 0 else 1 for partner in partners.tolist()]
    counts = np.array(counts, dtype=int)
    return counts, counts >= needed


def _call_confirm(confirm: Callable, *case: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a call: a count for each box, and whether its track counts."""
    hits, partners, needed = case
    answer = confirm(hits.copy(), partners.copy(), needed)
    return as_counts_and_flags(answer, ("hits", "confirmed"), len(partners), "boxes")


@visible_check(
    "confirm",
    title="Adds 1 to the count of each box's track, and counts 1 for a new track",
    why="If a new track begins with the count of another track, a ghost is confirmed at once.",
    hint=fixed(
        "Call np.append(hits, 0). Then -1 is the index of the 0, and partners selects an old count "
        "for each box."
    ),
)
def counts_frames_with_a_box(confirm: Callable) -> None:
    yours, _ = _call_confirm(confirm, _HITS, _TRACK_OF_BOX, 3)
    wrong = np.flatnonzero(yours != _RIGHT_HITS)
    if len(wrong):
        box, track = wrong[0], _TRACK_OF_BOX[wrong[0]]
        state = "is new" if track < 0 else f"belongs to track {track}"
        raise CheckFailed(
            f"Box {box} {state}, but its count is wrong.",
            input_text=_GIVEN_HITS,
            yours=f"hits {brief_text(yours)}",
            expected=f"hits {brief_text(_RIGHT_HITS)}",
        )


@visible_check(
    "confirm",
    title="Confirms a track that has had a box in at least needed frames",
    why="If a track is confirmed too early, the car brakes for a ghost. If it is confirmed too "
    "late, the car brakes too late for a pedestrian.",
    hint="Compare the new counts with needed: hits >= needed.",
)
def confirms_tracks_after_enough_frames(confirm: Callable) -> None:
    for needed in (3, 1, 2, 5):
        _, yours = _call_confirm(confirm, _HITS, _TRACK_OF_BOX, needed)
        right = needed <= _RIGHT_HITS
        if not np.array_equal(yours, right):
            box = np.flatnonzero(yours != right)[0]
            frames = f"{_RIGHT_HITS[box]} frame{'s' if _RIGHT_HITS[box] > 1 else ''}"
            raise CheckFailed(
                f"The track of box {box} has had a box in {frames} and should be "
                f"{'confirmed' if right[box] else 'tentative'}.",
                input_text=_GIVEN_HITS.replace("needed 3", f"needed {needed}"),
                yours=f"confirmed {brief_text(yours)}",
                expected=f"confirmed {brief_text(right)}",
            )


@visible_check(
    "confirm",
    title="Works when there are no boxes or no tracks",
    why="In the first frame there are no tracks, so every box is new.",
    hint=fixed("Append the 0 before you use partners as an index. An empty array has no last row."),
)
def works_without_boxes_or_tracks(confirm: Callable) -> None:
    empty = np.empty(0, dtype=int)
    for hits, partners in ((_HITS, empty), (empty, empty), (empty, np.array([-1, -1]))):
        counts, confirmed = _call_confirm(confirm, hits, partners, 3)
        right_counts, right_confirmed = _right_hits(hits, partners, 3)
        if not (same_array(counts, right_counts) and same_array(confirmed, right_confirmed)):
            raise CheckFailed(
                "In a frame without tracks, every box begins a tentative track.",
                input_text=f"hits {brief_text(hits)}, partners {brief_text(partners)}, needed 3",
                yours=f"hits {brief_text(counts)}, confirmed {brief_text(confirmed)}",
                expected=f"hits {brief_text(right_counts)}, confirmed "
                f"{brief_text(right_confirmed)}",
            )


@visible_check(
    "confirm",
    title="Does not change its input",
    why="If the function changes the counts, a second call for the same frame counts this frame "
    "twice.",
    hint="Begin with hits = np.append(hits, 0), which creates a new array. hits += 1 changes the "
    "input.",
)
def keeps_its_arrays_unchanged(confirm: Callable) -> None:
    arguments = _HITS, _TRACK_OF_BOX, 3
    assert_arguments_unchanged(observe(confirm, *arguments), *arguments)


def _prediction_from_hits(count: Callable) -> Callable:
    """Return a prediction with another rule for the counts, which decide which tracks count."""

    def predict(right: tuple, hits: np.ndarray, partners: np.ndarray, needed: int) -> tuple:
        counts = count(right[0], hits, partners)
        return counts, counts >= needed

    return predict


declare_mistakes(
    "confirm",
    Mistake(
        fixed(
            "A new track begins with the count of the last track, because the index -1 means the "
            "last row."
        ),
        _prediction_from_hits(lambda counts, hits, partners: hits[partners] + 1),
        fixed("Write np.append(hits, 0)[partners] + 1. Then the last row is a 0."),
    ),
    Mistake(
        "The count of a new track is 0. It should be 1, because the track has a box in this frame.",
        _prediction_from_hits(lambda counts, hits, partners: counts * (partners >= 0)),
        fixed("Write np.append(hits, 0)[partners] + 1, which adds 1 for new tracks also."),
    ),
    Mistake(
        "The counts do not include this frame.",
        _prediction_from_hits(lambda counts, hits, partners: counts - 1),
        "Add 1 to the count of each box, because each box is in this frame.",
    ),
    Mistake(
        "The count of every box is 1, however many boxes its track has had.",
        _prediction_from_hits(lambda counts, hits, partners: np.ones_like(counts)),
        fixed(
            "Use partners as an index: np.append(hits, 0)[partners] is the old count of each box."
        ),
    ),
    Mistake(
        "A track is confirmed one frame too late.",
        lambda right, hits, partners, needed: (right[0], right[0] > needed),
        "Compare the new counts with needed, and use >=.",
    ),
    Mistake(
        "A track is confirmed only in the frame in which its count is exactly needed.",
        lambda right, hits, partners, needed: (right[0], right[0] == needed),
        "Write hits >= needed, because a confirmed track stays confirmed.",
    ),
    Mistake(
        fixed("A track is always confirmed after 3 frames, whatever needed is."),
        lambda right, hits, partners, needed: (right[0], right[0] >= 3),
        "Compare the new counts with needed.",
    ),
    Mistake(
        "The second result says which tracks are tentative. It should say which tracks are "
        "confirmed.",
        lambda right, hits, partners, needed: (right[0], right[0] < needed),
    ),
    cases=(
        (np.array([4, 1, 3, 3, 2, 6]), np.array([2, -1, 0, 5, 1, -1, 4]), 4),
        (np.array([1, 2, 1, 5, 2]), np.array([3, -1, 1, 0, -1, 2, 4]), 2),
    ),
    right=_right_hits,
    is_same=same_pair,
)
