"""Find mistakes that the answer proves, and the step of each."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.replays.clustering.points import GAPS, GROUP_OF, NEAR, ROWS, THRESHOLD
from utils.replays.clustering.steps import ClusteringStep, format_label, list_points
from utils.replays.endings import describe_ending
from utils.replays.player import Fault, earliest_fault
from utils.replays.tracer import Ending


def find_first_fault(
    function: Callable, steps: list[ClusteringStep], answer: list | None, ending: Ending
) -> Fault | None:
    """Return the first step with a mistake that the answer proves."""
    last = len(steps) - 1
    if ending.stopped:
        return _find_second_visit(steps)
    if ending.error:
        return Fault(last, describe_ending(ending, function))
    if answer is None:
        return Fault(
            last, f"{describe_ending(ending, function)} It should return one label for each point."
        )
    faults = [
        _find_merged_clusters(steps, answer),
        _find_split_cluster(steps, answer),
        _find_wrong_label(steps, answer),
    ]
    return earliest_fault([fault for fault in faults if fault])


def _find_merged_clusters(steps: list[ClusteringStep], answer: list) -> Fault | None:
    """Find points that have the same label but are not joined by a chain of neighbours."""
    for position, step in enumerate(steps):
        for row in step.joined:
            others = [
                other
                for other in ROWS
                if step.labels[other] == step.labels[row]
                and step.has_label(row)
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


def _find_split_cluster(steps: list[ClusteringStep], answer: list) -> Fault | None:
    """Find neighbours with different labels in the answer, or points without a label."""
    pairs = [
        (row, other) for row, other in np.argwhere(NEAR).tolist() if answer[row] != answer[other]
    ]
    for position, step in enumerate(steps):
        for row, other in pairs:
            near = f"Point {other} is {GAPS[row, other]:.2f} m away, closer than {THRESHOLD} m"
            apart = "In your answer they have different labels."
            parted = step.labels[row] != step.labels[other]
            if step.visited == row and parted and step.has_label(row):
                does = "has another label" if step.has_label(other) else "does not get its label"
                return Fault(position, f"{near}, but {does}. {apart}")
            both = step.has_label(row) and step.has_label(other) and row in step.joined
            if both and parted:
                gets = f"Point {row} gets label {format_label(step.labels[row])}"
                has = f"point {other} has {format_label(step.labels[other])}"
                return Fault(position, f"{gets}, but {has}. {near}. {apart}")
    without = [row for row in ROWS if not steps[-1].has_label(row)]
    if without and answer == list(steps[-1].labels):
        return Fault(
            len(steps) - 1, f"The function ends here. {list_points(without)} got no label."
        )
    return None


def _find_wrong_label(steps: list[ClusteringStep], answer: list) -> Fault | None:
    """Find a label outside 1 to the number of clusters."""
    count = len(set(answer))
    for position, step in enumerate(steps):
        for row in step.joined:
            if step.has_label(row) and answer[row] not in range(1, count + 1):
                return Fault(
                    position,
                    f"In your answer, point {row} has label {format_label(answer[row])}. The "
                    f"answer has {count} different labels, so they should be 1 to {count}.",
                )
    return None


def _find_second_visit(steps: list[ClusteringStep]) -> Fault | None:
    """Find the first point that an endless run visits a second time."""
    seen = set()
    for position, step in enumerate(steps):
        if step.visited in seen:
            return Fault(
                position,
                f"Point {step.visited} is visited for the second time. The run was stopped "
                "before its end.",
            )
        if step.visited is not None:
            seen.add(step.visited)
    return None
