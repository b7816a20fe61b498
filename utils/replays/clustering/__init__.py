"""Replay of lesson 05: points get labels in the order in which the student's code visits them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from utils.replays.clustering.faults import find_first_fault
from utils.replays.clustering.observer import (
    LabelObserver,
    as_labels,
    find_labels,
    find_queue,
    group_numbers,
)
from utils.replays.clustering.points import GROUP_OF, POINTS, THRESHOLD
from utils.replays.clustering.steps import ClusteringStep, format_label, steps_of
from utils.replays.endings import describe_ending
from utils.replays.player import Fault, Replay, ReplayStep
from utils.replays.tracer import Ending, record

MAX_STEPS = 200


def replay_clustering(euclidean_clustering: Callable) -> Replay:
    """Record how a function clusters twelve points.

    Parameters
    ----------
    euclidean_clustering : callable
        The student's function.
    """
    observer = LabelObserver()
    ending = record(euclidean_clustering, (POINTS.copy(), THRESHOLD), observer.see)
    answer = as_labels(ending.answer)
    labels = find_labels(observer.tracks, ending.answer, answer)
    if labels is None:
        return _replay_answer(euclidean_clustering, ending, answer)
    steps = steps_of(labels, find_queue(observer.queues))
    wrong = find_first_fault(euclidean_clustering, steps, answer, ending)
    count = max(MAX_STEPS, wrong.step + 1 if wrong else 0)
    shown = [ReplayStep(step.description, step.draw) for step in steps[:count]]
    return Replay(shown, wrong, _remark(ending, answer, steps, wrong))


def _remark(
    ending: Ending, answer: list | None, steps: list[ClusteringStep], wrong: Fault | None
) -> str:
    about = f"Twelve points, threshold {THRESHOLD} m."
    if ending.stopped:
        return f"{about} Your function was stopped because it did not end."
    if not wrong and answer is not None and group_numbers(answer) == group_numbers(GROUP_OF):
        about += " Your labels are right."
    visited = Counter(step.visited for step in steps if step.visited is not None)
    if more := [row for row, count in visited.items() if count > 1]:
        about += f" Visited more than once: {', '.join(map(str, sorted(more)))}."
    return about


def _replay_answer(function: Callable, ending: Ending, answer: list | None) -> Replay:
    """Return a replay of the answer alone, for a run in which no labels were found."""
    if answer is None:
        return Replay(remark=describe_ending(ending, function))
    blank = object()
    step = ClusteringStep((blank,) * len(POINTS), tuple(answer), blank)
    remark = (
        "While your function runs, no variable contains one label per point, so its steps cannot "
        "be shown. The picture shows its answer."
    )
    wrong = find_first_fault(function, [step], answer, ending)
    description = (
        f"Labels of points 0 to {len(POINTS) - 1}: {', '.join(map(format_label, answer))}."
    )
    return Replay([ReplayStep(description, step.draw)], wrong, remark)
