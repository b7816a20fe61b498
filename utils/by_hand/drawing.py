"""What a drawing shows: the board with the things to drag, and a function's answer about them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from utils.plots.arguments import as_labels
from utils.plots.models import as_coefficients, ends_of_line
from utils.plots.style import MARKERS, PALE, PALETTE, number

MAX_LABELLED_POINTS = 40
"""Labels are written at the points of a drawing only if it has at most this many points."""


@dataclass(frozen=True)
class Board:
    """The things to drag, and where the student can put them.

    Attributes
    ----------
    limits : ndarray, shape (2, 2)
        Visible region in metres: low and high x, then low and high y.
    points : ndarray, shape (n, 2)
        In metres.
    circle : (x, y, radius), optional
        Circle to drag, in metres.
    movable : tuple of int
        Rows of the points that can be dragged.
    can_add : bool
        Whether points can be added and removed.
    """

    limits: np.ndarray
    points: np.ndarray
    circle: tuple[float, float, float] | None = None
    movable: tuple[int, ...] = ()
    can_add: bool = False

    @property
    def largest_radius(self) -> float:
        """Half of the shorter side of the visible region, in metres."""
        return float(np.ptp(self.limits, axis=1).min() / 2)

    @property
    def arguments(self) -> tuple:
        """Arguments for the student's function: the circle's three numbers, or the points."""
        return (self.points.copy(),) if self.circle is None else self.circle

    def moved(self, points: ArrayLike, circle: ArrayLike | None) -> Board:
        """Return this board with the things at other places."""
        return replace(
            self,
            points=np.array(points, dtype=float).reshape(-1, 2),
            circle=None if circle is None else tuple(map(float, circle)),
        )


@dataclass(frozen=True)
class Drawing:
    """The answer of a student's function, drawn on top of the things to drag.

    Attributes
    ----------
    title : str
        The result in words, such as "3 clusters".
    labels : (n,) array_like of int, optional
        Label of each point. Each label above 0 has its own colour and marker; points with label 0
        are pale crosses.
    names : dict of int to str
        Names of labels in the legend. Without names, the labels are written at the points.
    lines : dict of str to (a, b, c)
        Names and coefficients of lines a x + b y + c = 0. None instead of a line is not drawn.
    tolerance : float, optional
        Half the width of a band around the first line, in metres.
    edges : (m, 2) array_like of int
        Pairs of rows of points to connect.
    rectangles : dict of str to (m, 4) array_like of float
        Names and corners (x_low, y_low, x_high, y_high) of hatched rectangles, in metres.
    """

    title: str = ""
    labels: ArrayLike | None = None
    names: Mapping[int, str] = field(default_factory=dict)
    lines: Mapping[str, ArrayLike | None] = field(default_factory=dict)
    tolerance: float | None = None
    edges: ArrayLike = ()
    rectangles: Mapping[str, ArrayLike] = field(default_factory=dict)

    def shapes(self, board: Board) -> dict[str, Any]:
        """Return everything to draw as lists and numbers, which JSON can represent.

        Raises
        ------
        ValueError
            A shape or label is wrong; the message gives the expected one.
        """
        count = len(board.points)
        labels = None if self.labels is None else as_labels(self.labels, count)
        lines, band = [], None
        for name, line in self.lines.items():
            if line is not None:
                line = as_coefficients(line, 3, name)
                ends = ends_of_line(line, board.limits)
                lines.append({"name": name, "ends": ends.tolist()})
                if len(lines) == 1 and self.tolerance is not None:
                    aside = float(self.tolerance) * line[:2]
                    band = {
                        "name": f"within {number(float(self.tolerance))} m",
                        "corners": [*(ends + aside).tolist(), *(ends[::-1] - aside).tolist()],
                    }
        return {
            "title": self.title,
            "groups": [] if labels is None else list(self._groups(labels)),
            "lines": lines,
            "band": band,
            "edges": np.array(self.edges, dtype=int).reshape(-1, 2).tolist(),
            "rectangles": [
                {"name": name, "boxes": np.array(boxes, dtype=float).reshape(-1, 4).tolist()}
                for name, boxes in self.rectangles.items()
            ],
        }

    def _groups(self, labels: np.ndarray) -> list[dict[str, Any]]:
        """Return the points of each label, with their marker and their entry in the legend."""
        groups = []
        for label in np.unique(np.maximum(labels, 0)).tolist():
            rows = np.flatnonzero(np.maximum(labels, 0) == label).tolist()
            name = self.names.get(label, "")
            groups.append(
                {
                    "rows": rows,
                    "legend": name and f"{name}: {len(rows)}",
                    "text": name or f"label {label}",
                    "number": "" if self.names or len(labels) > MAX_LABELLED_POINTS else str(label),
                    "colour": PALETTE[(label - 1) % len(PALETTE)] if label else PALE,
                    "marker": MARKERS[(label - 1) % len(MARKERS)] if label else "x",
                }
            )
        return groups
