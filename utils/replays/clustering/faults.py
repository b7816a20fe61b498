"""Find mistakes that the answer proves, and the step of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks.tips import unwritten_function
from utils.replays.clustering.frames import ReplayFrame, format_label, list_points
from utils.replays.clustering.points import GAPS, GROUP_OF, NEAR, ROWS, THRESHOLD
from utils.replays.endings import describe_ending
from utils.replays.player import Fault, earliest_fault
from utils.replays.tracer import Ending


def find_first_fault(
    function: Callable, frames: list[ReplayFrame], answer: list | None, ending: Ending
) -> Fault | None:
    """Return the first step with a mistake that the answer proves."""
    last = len(frames) - 1
    if ending.stopped:
        return _find_second_visit(frames)
    if unwritten_function(ending.error, function):
        return None
    if ending.error:
        return Fault(last, describe_ending(ending, function))
    if answer is None:
        return Fault(
            last, f"{describe_ending(ending, function)} It should return one label for each point."
        )
    faults = [
        _find_merged_clusters(frames, answer),
        _find_split_cluster(frames, answer),
        _find_wrong_number(frames, answer),
    ]
    return earliest_fault([fault for fault in faults if fault])


def _find_merged_clusters(frames: list[ReplayFrame], answer: list) -> Fault | None:
    """Find points that have the same label but are not joined by a chain of neighbours."""
    for position, frame in enumerate(frames):
        for row in frame.joined:
            others = [
                other
                for other in ROWS
                if frame.labels[other] == frame.labels[row]
                and frame.has_label(row)
                and answer[other] == answer[row]
                and GROUP_OF[other] != GROUP_OF[row]
            ]
            if others:
                other = min(others, key=lambda other: GAPS[row, other])
                return Fault(
                    position,
                    f"Points {row} and {other} have the same label, here and in your answer. They "
                    f"are {GAPS[row, other]:.2f} m apart, and no chain of points with gaps below "
                    f"{THRESHOLD} m joins them.",
                )
    return None


def _find_split_cluster(frames: list[ReplayFrame], answer: list) -> Fault | None:
    """Find neighbours with different labels in the answer, or points without a label."""
    pairs = [
        (row, other) for row, other in np.argwhere(NEAR).tolist() if answer[row] != answer[other]
    ]
    for position, frame in enumerate(frames):
        for row, other in pairs:
            near = f"Point {other} is {GAPS[row, other]:.2f} m away, closer than {THRESHOLD} m"
            apart = "In your answer they have different labels."
            parted = frame.labels[row] != frame.labels[other]
            if frame.visited == row and parted and frame.has_label(row):
                does = "has another label" if frame.has_label(other) else "does not get its label"
                return Fault(position, f"{near}, but {does}. {apart}")
            both = frame.has_label(row) and frame.has_label(other) and row in frame.joined
            if both and parted:
                gets = f"Point {row} gets label {format_label(frame.labels[row])}"
                has = f"point {other} has {format_label(frame.labels[other])}"
                return Fault(position, f"{gets}, but {has}. {near}. {apart}")
    without = [row for row in ROWS if not frames[-1].has_label(row)]
    if without and answer == list(frames[-1].labels):
        return Fault(
            len(frames) - 1, f"The function ends here. {list_points(without)} got no label."
        )
    return None


def _find_wrong_number(frames: list[ReplayFrame], answer: list) -> Fault | None:
    """Find a label outside 1 to the number of clusters."""
    count = len(set(answer))
    for position, frame in enumerate(frames):
        for row in frame.joined:
            if frame.has_label(row) and answer[row] not in range(1, count + 1):
                return Fault(
                    position,
                    f"In your answer, point {row} has label {format_label(answer[row])}. The "
                    f"answer has {count} different labels, so they should be 1 to {count}.",
                )
    return None


def _find_second_visit(frames: list[ReplayFrame]) -> Fault | None:
    """Find the first point that an endless run visits a second time."""
    seen = set()
    for position, frame in enumerate(frames):
        if frame.visited in seen:
            return Fault(
                position,
                f"Point {frame.visited} is visited for the second time. The run was stopped "
                "before its end.",
            )
        if frame.visited is not None:
            seen.add(frame.visited)
    return None
