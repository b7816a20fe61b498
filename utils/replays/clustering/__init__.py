"""Replay of lesson 05: points get labels in the order in which the student's code visits them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

from utils.checks.tips import unwritten_function
from utils.replays.clustering.faults import find_first_fault
from utils.replays.clustering.frames import ReplayFrame, format_label, frames_of
from utils.replays.clustering.observer import (
    LabelObserver,
    as_labels,
    find_labels,
    find_queue,
    group_numbers,
)
from utils.replays.clustering.points import GROUP_OF, POINTS, THRESHOLD
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
    frames = frames_of(labels, find_queue(observer.queues))
    wrong = find_first_fault(euclidean_clustering, frames, answer, ending)
    count = max(MAX_STEPS, wrong.step + 1 if wrong else 0)
    steps = [ReplayStep(frame.description, frame.draw) for frame in frames[:count]]
    remark = _remark(ending, answer, frames, wrong)
    if unwritten_function(ending.error, euclidean_clustering):
        remark += f" {describe_ending(ending, euclidean_clustering)}"
    return Replay(steps, wrong, remark)


def _remark(
    ending: Ending, answer: list | None, frames: list[ReplayFrame], wrong: Fault | None
) -> str:
    about = f"Twelve points, threshold {THRESHOLD} m."
    if ending.stopped:
        return f"{about} Your function was stopped because it did not end."
    if not wrong and answer is not None and group_numbers(answer) == group_numbers(GROUP_OF):
        about += " Your labels are right."
    visited = Counter(frame.visited for frame in frames if frame.visited is not None)
    if more := [row for row, count in visited.items() if count > 1]:
        about += f" Visited more than once: {', '.join(map(str, sorted(more)))}."
    return about


def _replay_answer(function: Callable, ending: Ending, answer: list | None) -> Replay:
    """Return a replay of the answer alone, for a run in which no labels were found."""
    if answer is None:
        return Replay(remark=describe_ending(ending, function))
    blank = object()
    frame = ReplayFrame((blank,) * len(POINTS), tuple(answer), blank)
    remark = (
        "While your function runs, no variable contains one label per point, so its steps cannot "
        "be shown. The picture shows its answer."
    )
    wrong = find_first_fault(function, [frame], answer, ending)
    says = f"Labels of points 0 to {len(POINTS) - 1}: {', '.join(map(format_label, answer))}."
    return Replay([ReplayStep(says, frame.draw)], wrong, remark)
