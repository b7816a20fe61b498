"""Steps of a clustering run: the point visited, the points labelled and the points waiting."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from utils.replays.clustering.observer import VariableTrack, group_numbers
from utils.replays.clustering.points import ABOVE, NEAR, POINTS, ROWS, THRESHOLD


@dataclass
class ClusteringStep:
    """One step of a clustering run.

    Attributes
    ----------
    before, labels : tuple
        Label of each point before and after the step.
    blank : object
        Label of a point that has none yet.
    visited : int or None
        Row of the point that the function visited.
    waiting : tuple or None
        Rows in the queue after the step; None without a queue.
    is_first : bool
        Whether the step shows the state before the first point.
    """

    before: tuple
    labels: tuple
    blank: object
    visited: int | None = None
    waiting: tuple | None = None
    is_first: bool = False

    @property
    def joined(self) -> list[int]:
        """Rows whose label changed in this step."""
        return [row for row in ROWS if self.labels[row] != self.before[row]]

    def has_label(self, row: int) -> bool:
        """Return whether a point has a label after this step."""
        return self.labels[row] != self.blank

    @property
    def description(self) -> str:
        """Description of the step in words."""
        if self.is_first:
            return "Before the first point: no point has a label."
        parts = [] if self.visited is None else [f"Point {self.visited} is visited."]
        for label in dict.fromkeys(self.labels[row] for row in self.joined):
            rows = [row for row in self.joined if self.labels[row] == label]
            gets = "gets" if len(rows) == 1 else "get"
            parts.append(f"{list_points(rows)} {gets} label {format_label(label)}.")
        if self.visited is not None and not self.joined:
            parts.append("No point gets a label.")
        if self.waiting is not None:
            waits = ", ".join(map(str, self.waiting)) or "no point"
            parts.append(f"In the queue: {waits}.")
        return " ".join(parts)

    def draw(self, title: str) -> None:
        """Draw the points with their labels, and a circle around the point visited."""
        import matplotlib.pyplot as plt

        from utils import plots
        from utils.plots.style import PAPER

        shown = [1 + number for number in group_numbers((self.blank, *self.labels))[1:]]
        shown = [number - 1 if self.has_label(row) else 0 for row, number in enumerate(shown)]
        _, axes = plt.subplots(figsize=(7.0, 5.4), layout="compressed")
        pairs = np.argwhere(np.triu(NEAR))
        limits = ((-1.3, 3.8), (-2.6, 1.3))
        plots.graph(POINTS[:, :2], pairs, labels=shown, names=True, axes=axes, limits=limits)
        for row, words in ABOVE.items():
            axes.annotate(
                words,
                POINTS[row, :2],
                xytext=(14, 2),
                textcoords="offset points",
                fontsize=9,
                zorder=9,  # above the circle around a visited point
                bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.85, "pad": 1.0},
            )
        look = {"markersize": 13, "fillstyle": "none", "color": "black"}
        if self.visited is not None:
            x, y = POINTS[self.visited, :2]
            plots.ring(axes, x, y, radius=THRESHOLD)
            axes.plot(x, y, "o", **look)
        for row in set(self.waiting or ()):
            axes.plot(*POINTS[row, :2], "s", **look)
        axes.get_legend().remove()
        axes.set_title(title, loc="left", fontsize=12, fontweight="bold")


def steps_of(labels: VariableTrack, queue: VariableTrack | None) -> list[ClusteringStep]:
    """Divide a run into steps; each visited point and each new cluster begins a step."""
    moments = [(time, "labels", state, new) for time, state, new in labels.states]
    moments += [(time, "queue", state, new) for time, state, new in (queue.states if queue else ())]
    moments.sort(key=lambda moment: moment[0])
    first = labels.states[0][1]
    blank = first[0] if len(set(first)) == 1 else object()
    steps = [ClusteringStep(first, first, blank, is_first=True)]
    waiting = () if queue else None
    for _, kind, state, new in moments:
        now = steps[-1]
        if kind == "queue":
            gone = Counter(waiting) - Counter(state)
            visited = next(iter(gone)) if gone.total() == 1 and not new else None
            if visited is not None or (new and now.visited is not None):
                steps.append(ClusteringStep(now.labels, now.labels, blank, visited))
            waiting = state
        elif state != now.labels:
            if now.is_first or not queue or (not waiting and _begins_cluster(now, state)):
                steps.append(ClusteringStep(now.labels, state, blank))
            steps[-1].labels = state
        steps[-1].waiting = waiting
    return steps


def _begins_cluster(now: ClusteringStep, state: tuple) -> bool:
    """Return whether the changed labels begin a cluster that lacks the point visited last."""
    changed = [row for row in ROWS if state[row] != now.labels[row]]
    if now.visited is None or now.visited in changed:
        return False
    return all(state[row] != now.labels[now.visited] for row in changed)


def list_points(rows: list[int]) -> str:
    """List points in words, such as "Points 1, 2 and 5"."""
    if len(rows) == 1:
        return f"Point {rows[0]}"
    return f"Points {', '.join(map(str, rows[:-1]))} and {rows[-1]}"


def format_label(label: object) -> str:
    """Format a label; a whole number has no decimals."""
    return f"{label:g}" if isinstance(label, float) else str(label)
