"""Replays of lessons 02 and 03: the rounds of RANSAC with sample, model and points near it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from utils.checks.tips import unwritten_function
from utils.lent import own
from utils.replays.endings import describe_ending
from utils.replays.player import Fault, Replay, ReplayStep
from utils.replays.ransac.faults import ModelAndMask, Rounds
from utils.replays.ransac.observer import Round, SampleObserver
from utils.replays.ransac.tasks import LINE, PLANE, ROUNDS, Task
from utils.replays.tracer import Ending, record


def replay_ransac_line(ransac_line: Callable) -> Replay:
    """Record how a student's `ransac_line` works on twenty points."""
    return replay_search(LINE, ransac_line)


def replay_ransac_plane(ransac_plane: Callable) -> Replay:
    """Record how a student's `ransac_plane` works on a small street."""
    return replay_search(PLANE, ransac_plane)


def replay_search(task: Task, search: Callable) -> Replay:
    """Record ten rounds of a search.

    Parameters
    ----------
    task : Task
        Points and arguments of the search.
    search : callable
        A student's `ransac_line` or `ransac_plane`.
    """
    through = own(getattr(search, "__globals__", {}).get(task.through))
    observer, points = SampleObserver(task, getattr(through, "__code__", None)), task.points.copy()
    ending = record(search, (points, ROUNDS, task.tolerance, task.seed), observer.see)
    if not np.array_equal(points, task.points):
        return Replay(remark="Your function changes its input, so its run cannot be shown.")
    answer = ModelAndMask.of(task, ending.answer) if ending.returned_normally else None
    rounds, outcome = observer.rounds, Rounds(task, observer.rounds, answer)
    if not rounds and answer is None:
        return Replay(remark=describe_ending(ending, search))
    steps = [_step(outcome, number) for number in range(1, len(rounds) + 1)]
    wrong = outcome.fault
    if answer:
        steps.append(_last_step(outcome))
    elif not wrong and not ending.stopped and not unwritten_function(ending.error, search):
        wrong = Fault(
            len(steps) - 1, describe_ending(ending, search) + _expected_text(task, ending)
        )
    remark = _remark(task, ending, rounds, observer.was_called)
    if unwritten_function(ending.error, search):
        remark += f" {describe_ending(ending, search)}"
    return Replay(steps, wrong, remark)


def _expected_text(task: Task, ending: Ending) -> str:
    if ending.error:
        return ""
    return f" It should return the {task.model} and the mask of its inliers, in this order."


def _remark(task: Task, ending: Ending, rounds: list[Round], was_called: bool) -> str:
    about = f"{len(task.points)} points, {ROUNDS} rounds, threshold {task.tolerance} m."
    if not rounds:
        return (
            f"{about} Your function does not call {task.through}, so its rounds cannot be shown. "
            "The picture shows its answer."
        )
    if ending.stopped:
        return f"{about} Your function was stopped after {len(rounds)} rounds."
    if len(rounds) != ROUNDS and ending.returned_normally and was_called:
        samples = "one sample" if len(rounds) == 1 else f"{len(rounds)} samples"
        return f"{about} Your function drew {samples}."
    return about


def _step(outcome: Rounds, number: int) -> ReplayStep:
    task, round_ = outcome.task, outcome.rounds[number - 1]
    says = [f"Round {number}:"]
    if round_.rows is None:
        says.append(
            "the sample contains something other than points of the cloud, so it is not shown."
        )
    elif round_.model is None:
        makes = "are drawn." if round_.raised else f"do not define a {task.model}."
        says.append(f"{_rows_text(round_.rows)} {makes}")
    else:
        most = max((before.count for before in outcome.rounds[: number - 1]), default=0)
        rank = "the most so far" if round_.count > most else f"while the most so far is {most}"
        says.append(
            f"{_rows_text(round_.rows)} are drawn. {round_.count} of {len(task.points)} points are "
            f"within {task.tolerance} m of their {task.model}, {rank}."
        )
    mask = round_.masks.get(outcome.name_of_mask)
    marked = round_.near if mask is None else np.array(mask)
    model = None if round_.rows is None else round_.model
    return ReplayStep(" ".join(says), lambda title: _draw(task, title, model, marked, round_.rows))


def _last_step(outcome: Rounds) -> ReplayStep:
    task, answer, winner = outcome.task, outcome.answer, outcome.winner
    if answer.model is None:
        says = f"Your answer: no {task.model}."
    else:
        name = f"the {task.model} of round {winner.number}" if winner else f"a {task.model}"
        says = f"Your answer: {name}, with {answer.mask.sum()} inliers."
    model, mask = answer.model, answer.mask
    return ReplayStep(says, lambda title: _draw(task, f"{title}, the answer", model, mask, None))


def _rows_text(rows: list[int]) -> str:
    *others, last = map(str, rows)
    return f"points {', '.join(others)} and {last}"


def _draw(
    task: Task,
    title: str,
    model: np.ndarray | None,
    mask: np.ndarray | None,
    rows: list[int] | None,
) -> None:
    import matplotlib.pyplot as plt

    from utils import plots

    shown = (task.points, model, mask if model is not None else None, task.tolerance)
    if task is LINE:
        _, axes = plt.subplots(figsize=(7.0, 5.4), layout="compressed")
        plots.line_model(*shown, limits=((-7.5, 7.5), (-5.8, 5.2)), axes=axes, title=title)
    else:
        _, axes = plt.subplots(figsize=(8.5, 4.2), layout="compressed")
        plots.plane_model(*shown, limits=((-9, 23), (-2.4, 1.4)), axes=axes, title=title)
    if rows is not None:
        across, up = task.points[rows][:, [0, -1 if task is LINE else 2]].T
        axes.plot(across, up, "o", color="black", markersize=12, fillstyle="none", zorder=9)
