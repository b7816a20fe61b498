"""Find mistakes that a search certainly made, and the round of each."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from utils.replays.player import Fault, earliest_fault
from utils.replays.ransac.observer import Round, as_mask, as_model, distances_from
from utils.replays.ransac.tasks import ROUNDING, ROUNDS, Task


@dataclass(frozen=True)
class ModelAndMask:
    """A model with the mask of its inliers, returned by a search."""

    task: Task
    model: np.ndarray | None
    mask: np.ndarray

    @classmethod
    def of(cls, task: Task, returned: object) -> ModelAndMask | None:
        """Read the answer of a search; return None unless it is a model and a mask."""
        if not isinstance(returned, tuple | list) or len(returned) != 2:
            return None
        model, mask = returned
        known = as_model(model, task.size)
        mask = as_mask(mask if type(mask) is not tuple else list(mask), len(task.points))
        if mask is None or (known is None and model is not None):
            return None
        return cls(task, known, np.array(mask))

    def is_from(self, round_: Round) -> bool:
        """Return whether the model equals a round's model, with either sign."""
        if self.model is None or round_.model is None:
            return False
        mine, other = (model / np.linalg.norm(model[:-1]) for model in (self.model, round_.model))
        return any(np.allclose(mine, sign * other, rtol=0, atol=ROUNDING) for sign in (1, -1))

    @property
    def expected(self) -> np.ndarray:
        """Mask of the points near the model."""
        if self.model is None:
            return np.zeros(len(self.mask), dtype=bool)
        return distances_from(self.task.xyz, self.model) <= self.task.tolerance

    @property
    def fits(self) -> bool:
        """Whether the mask matches the model; a point at the threshold may be in or out."""
        if self.model is None:
            return not self.mask.any()
        gaps = distances_from(self.task.xyz, self.model)
        clear = np.abs(gaps - self.task.tolerance) > 1e-6
        return bool((self.mask == self.expected)[clear].all())


@dataclass(frozen=True)
class Rounds:
    """All rounds of a search, and its answer.

    Attributes
    ----------
    task : Task
    rounds : list of Round
    answer : ModelAndMask or None
        None if the search did not return a model and a mask.
    """

    task: Task
    rounds: list[Round]
    answer: ModelAndMask | None

    @cached_property
    def winner(self) -> Round | None:
        """The round whose model was returned."""
        if self.answer is None:
            return None
        return next((round_ for round_ in self.rounds if self.answer.is_from(round_)), None)

    @cached_property
    def name_of_mask(self) -> Hashable:
        """Name of the variable that contained the returned mask in the winning round."""
        if self.winner is None:
            return None
        wanted = tuple(self.answer.mask.tolist())
        return next((name for name, mask in self.winner.masks.items() if mask == wanted), None)

    @property
    def fault(self) -> Fault | None:
        """The first mistake, or None."""
        found = [_find_mistake_in_round(round_) for round_ in self.rounds]
        if self.answer is not None:
            found += [
                self._find_missing_model(),
                self._find_wrong_mask(),
                self._find_wrong_normal_length(),
                self._find_better_round(),
            ]
        found.append(self._find_extra_sample())
        return earliest_fault([fault for fault in found if fault])

    @property
    def _last(self) -> int:
        """Index of the step that shows the answer."""
        return len(self.rounds)

    @cached_property
    def _best(self) -> Round | None:
        best = max(self.rounds, key=lambda round_: round_.count, default=None)
        return best if best and best.count else None

    def _find_missing_model(self) -> Fault | None:
        if self._best is None or self.answer.model is not None:
            return None
        why = f"{_count_in_words(self._best)}, but your answer has no {self.task.model}."
        return Fault(self._best.number - 1, why)

    def _find_wrong_mask(self) -> Fault | None:
        if self.answer.fits:
            return None
        task, mask = self.task, tuple(self.answer.mask.tolist())
        both = f"{sum(mask)} points, while {self.answer.expected.sum()} are"
        if self.winner is None:
            place = f"within {task.tolerance} m of the {task.model} that you return"
            return Fault(self._last, f"Your mask has {both} {place}. They are not the same points.")
        for round_ in self.rounds:  # the same variable in earlier rounds
            held = round_.masks.get(self.name_of_mask)
            if held is not None and round_.near is not None and tuple(round_.near.tolist()) != held:
                return Fault(
                    round_.number - 1,
                    f"Your mask has {sum(held)} points in this round, while {round_.count} are "
                    f"within {task.tolerance} m of the {task.model}. They are not the same points.",
                )
        why = f"Your answer is the {task.model} of round {self.winner.number}, whose mask has "
        why += f"{self.answer.expected.sum()} points, but yours has {sum(mask)}"
        for round_ in self.rounds:
            if round_.near is not None and tuple(round_.near.tolist()) == mask:
                step = max(round_.number, self.winner.number) - 1
                return Fault(step, f"{why}. It is the mask of round {round_.number}.")
        return Fault(self.winner.number - 1, f"{why}.")

    def _find_wrong_normal_length(self) -> Fault | None:
        length = 1 if self.answer.model is None else np.linalg.norm(self.answer.model[:-1])
        if abs(length - 1) < ROUNDING:
            return None
        return Fault(
            self._last, f"The normal of your {self.task.model} has length {length:.2f}, not 1."
        )

    def _find_better_round(self) -> Fault | None:
        best, winner = self._best, self.winner
        if not best or not winner or winner.count == best.count or self._was_closest():
            return None
        then = f"your answer is the {self.task.model} of round {winner.number}, with {winner.count}"
        step = max(best.number, winner.number) - 1
        return Fault(step, f"{_count_in_words(best)}, more than any other, but {then}.")

    def _was_closest(self) -> bool:
        """Return whether the winner has the lowest cost of MSAC, which the lesson mentions."""
        costs = {
            round_.number: np.sum(
                np.minimum(distances_from(self.task.xyz, round_.model), self.task.tolerance) ** 2
            )
            for round_ in self.rounds
            if round_.near is not None
        }
        return self.winner.number == min(costs, key=costs.get)

    def _find_extra_sample(self) -> Fault | None:
        samples = set()
        for round_ in self.rounds:
            if round_.rows is not None:
                samples.add(frozenset(round_.rows))
            if len(samples) > ROUNDS:
                return Fault(
                    round_.number - 1,
                    f"This is one sample more than the {ROUNDS} that the call allows.",
                )
        return None


def _find_mistake_in_round(round_: Round) -> Fault | None:
    """Return the mistake in a round's own sample or model, if any."""
    task, step, rows = round_.task, round_.number - 1, round_.rows
    if rows is not None and len(set(rows)) < task.size:
        twice = next(row for row in rows if rows.count(row) > 1)
        return Fault(
            step, f"Point {twice} was drawn twice. Such a sample does not define a {task.model}."
        )
    if rows is None or round_.raised:
        return None
    if round_.model is None:
        return Fault(
            step, f"{task.through} returned no {task.model} for these points, but they define one."
        )
    gaps = distances_from(round_.sample, round_.model)
    if gaps.max() > ROUNDING:
        return Fault(
            step,
            f"The {task.model} does not run through its sample: point {rows[gaps.argmax()]} is "
            f"{gaps.max():.2f} m away from it. Look at {task.through}.",
        )
    length = np.linalg.norm(round_.model[:-1])
    if abs(length - 1) > ROUNDING:
        return Fault(
            step,
            f"The normal of this {task.model} has length {length:.2f}, not 1. Look at "
            f"{task.through}.",
        )
    return None


def _count_in_words(round_: Round) -> str:
    return f"Round {round_.number} has {round_.count} points within the threshold"
