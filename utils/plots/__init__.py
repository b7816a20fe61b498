"""Figures of clouds and of the results of algorithms, drawn with matplotlib.

Each function takes its data, then keyword options, then ``axes=None``. It draws into the given
axes or into a new figure of notebook width, and returns the axes. Axes that already show something
keep their view, so that figures can be drawn on top of each other. Nothing here solves an exercise.

>>> from utils import plots
>>> axes = plots.from_above(cloud, limits=((-20, 40), (-10, 10)))
>>> plots.boxes(corners, axes=axes)
"""

from utils.plots.annotations import ring
from utils.plots.clouds import from_above, from_side, kept_and_removed
from utils.plots.clusters import clusters, graph, growth
from utils.plots.comparison import difference, label_confusion, worst
from utils.plots.corners import boxes, corner_numbers
from utils.plots.curves import compare, curves, histogram
from utils.plots.models import line_model, plane_model
from utils.plots.regions import kd_search, kd_splits
from utils.plots.timings import timing
from utils.plots.trees import kd_tree

__all__ = [
    "boxes",
    "clusters",
    "compare",
    "corner_numbers",
    "curves",
    "difference",
    "from_above",
    "from_side",
    "graph",
    "growth",
    "histogram",
    "kd_search",
    "kd_splits",
    "kd_tree",
    "kept_and_removed",
    "label_confusion",
    "line_model",
    "plane_model",
    "ring",
    "timing",
    "worst",
]
