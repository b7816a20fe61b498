"""Visible checks of `coast`."""

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

_MISSED = frozen(np.array([2, 3, 2, 1, 1]))
_PARTNERS = frozen(np.array([-1, 3, 0, -1]))
_GIVEN = "missed [2, 3, 2, 1, 1], partners [-1, 3, 0, -1], patience 3"
_RIGHT_COUNTS = frozen(np.array([0, 4, 3, 0, 2]))


def _right_counts(
    missed: np.ndarray, partners: np.ndarray, patience: int
) -> tuple[np.ndarray, np.ndarray]:
    partners = set(np.asarray(partners).tolist())
    counts = [0 if row in partners else count + 1 for row, count in enumerate(missed.tolist())]
    counts = np.array(counts, dtype=int)
    return counts, counts <= patience


def _call_coast(coast: Callable, *case: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the two results of a call: a count for each track, and whether the track is kept."""
    missed, partners, patience = case
    answer = coast(missed.copy(), partners.copy(), patience)
    return as_counts_and_flags(answer, ("missed", "kept"), len(missed), "tracks")


@visible_check(
    "coast",
    title="Resets the count of each track that has a box, and adds 1 to all others",
    why="If a count is never reset, a track is dropped although it has a box in every second "
    "frame.",
    hint=fixed(
        "Call np.isin(np.arange(len(missed)), partners), which is True for the tracks that have a "
        "box."
    ),
)
def counts_missed_frames(coast: Callable) -> None:
    yours, _ = _call_coast(coast, _MISSED, _PARTNERS, 3)
    wrong = np.flatnonzero(yours != _RIGHT_COUNTS)
    if len(wrong):
        row = wrong[0]
        state = "has a box" if row in _PARTNERS else "has no box"
        raise CheckFailed(
            f"Track {row} {state}, but its count is wrong.",
            input_text=_GIVEN,
            yours=f"missed {brief_text(yours)}",
            expected=f"missed {brief_text(_RIGHT_COUNTS)}",
        )


@visible_check(
    "coast",
    title="Keeps a track that has missed at most patience frames in a row",
    why="If a track is dropped too early, its object gets a new track ID. If it is dropped too "
    "late, another object gets its track ID.",
    hint="Compare the new counts with patience: missed <= patience.",
)
def drops_tracks_after_patience(coast: Callable) -> None:
    for patience in (3, 0, 2, 10):
        _, yours = _call_coast(coast, _MISSED, _PARTNERS, patience)
        right = patience >= _RIGHT_COUNTS
        if not np.array_equal(yours, right):
            row = np.flatnonzero(yours != right)[0]
            verb = "kept" if right[row] else "dropped"
            raise CheckFailed(
                f"Track {row} has missed {_RIGHT_COUNTS[row]} frames in a row and should be {verb}."
                if _RIGHT_COUNTS[row]
                else f"Track {row} has a box and should be kept.",
                input_text=_GIVEN.replace("patience 3", f"patience {patience}"),
                yours=f"kept {brief_text(yours)}",
                expected=f"kept {brief_text(right)}",
            )


@visible_check(
    "coast",
    title="Works when there are no boxes or no tracks",
    why="In fog a whole frame may be empty, and the tracks must last until the boxes return.",
    hint="Work with whole arrays, without a special case.",
)
def works_on_empty_frames(coast: Callable) -> None:
    empty = np.empty(0, dtype=int)
    for missed, partners in ((_MISSED, empty), (empty, empty), (empty, np.array([-1, -1]))):
        counts, kept = _call_coast(coast, missed, partners, 10)
        right_counts, right_kept = _right_counts(missed, partners, 10)
        if not (same_array(counts, right_counts) and same_array(kept, right_kept)):
            raise CheckFailed(
                "In a frame without boxes, every track misses one more frame.",
                input_text=f"missed {brief_text(missed)}, partners {brief_text(partners)}, "
                "patience 10",
                yours=f"missed {brief_text(counts)}, kept {brief_text(kept)}",
                expected=f"missed {brief_text(right_counts)}, kept {brief_text(right_kept)}",
            )


@visible_check(
    "coast",
    title="Does not change the counts",
    why="If the function changes the counts, a second call for the same frame counts this frame "
    "twice.",
    hint="Begin with missed = missed + 1, which creates a new array. missed += 1 changes the "
    "input.",
)
def keeps_the_counts_unchanged(coast: Callable) -> None:
    assert_arguments_unchanged(observe(coast, _MISSED, _PARTNERS, 3), _MISSED, _PARTNERS, 3)


def _prediction_from_counts(count: Callable) -> Callable:
    """Return a prediction with another rule for the counts, which decide which tracks stay."""

    def predict(right: tuple, missed: np.ndarray, partners: np.ndarray, patience: int) -> tuple:
        has_box = np.isin(np.arange(len(missed)), partners)
        counts = count(missed, has_box, partners)
        return counts, counts <= patience

    return predict


def _count_last_track(missed: np.ndarray, has_box: np.ndarray, partners: np.ndarray) -> np.ndarray:
    """Return the counts if -1 is used as an index, which means the last track."""
    counts = missed + 1
    counts[partners] = 0
    return counts


declare_mistakes(
    "coast",
    Mistake(
        fixed(
            "The last track counts as seen whenever a box is new, because the index -1 means the "
            "last row."
        ),
        _prediction_from_counts(_count_last_track),
        fixed(
            "Leave out -1 with partners[partners >= 0], or use np.isin(np.arange(len(missed)), "
            "partners)."
        ),
    ),
    Mistake(
        "A track is dropped one frame too early: `<` should be `<=`.",
        lambda right, missed, partners, patience: (right[0], right[0] < patience),
        "Write missed <= patience, because a track that has missed exactly patience frames is "
        "still kept.",
    ),
    Mistake(
        "The function compares the old counts with patience, so a track is kept one frame too "
        "long.",
        lambda right, missed, partners, patience: (right[0], missed <= patience),
        "Compare the new counts with patience.",
    ),
    Mistake(
        "A track with a box keeps its old count, which should become 0.",
        _prediction_from_counts(
            lambda missed, has_box, partners: np.where(has_box, missed, missed + 1)
        ),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "Every count goes up by 1, whether the track has a box or not.",
        _prediction_from_counts(lambda missed, has_box, partners: missed + 1),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "The count of a track without a box is always 1, however many frames it has missed.",
        _prediction_from_counts(lambda missed, has_box, partners: np.where(has_box, 0, 1)),
        "Write np.where(seen, 0, missed + 1), where seen is the mask of the tracks that have a "
        "box.",
    ),
    Mistake(
        "Tracks with a box are treated as if they had none, and the other way round.",
        _prediction_from_counts(lambda missed, has_box, partners: np.where(has_box, missed + 1, 0)),
        "Reset the tracks in partners, because these are the tracks that have a box.",
    ),
    Mistake(
        "Only tracks with a box in this frame are kept, so no track coasts.",
        lambda right, missed, partners, patience: (right[0], right[0] == 0),
        "Return missed <= patience as kept, with the new counts.",
    ),
    Mistake(
        "The second result says which tracks are dropped. It should say which tracks are kept.",
        lambda right, missed, partners, patience: (right[0], right[0] > patience),
    ),
    cases=(
        (np.array([2, 3, 2, 1, 1, 4]), np.array([-1, 3, 0, -1]), 3),
        (np.array([2, 1, 0, 2, 2, 1, 2]), np.array([4, -1, 1, -1]), 2),
    ),
    right=_right_counts,
    is_same=same_pair,
)
