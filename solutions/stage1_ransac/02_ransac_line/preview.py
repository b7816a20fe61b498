"""Preview of lesson 02: the quiz points with a line from least squares and from RANSAC."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import plots


def draw() -> Figure:
    """Return the preview as a figure."""
    rng = np.random.default_rng(18)
    steps = np.arange(-5, 5)
    points = np.vstack(
        [
            np.column_stack([steps, steps]) + rng.uniform(-0.6, 0.6, (10, 2)),
            rng.uniform(-5, 5, (10, 2)),
        ]
    )
    slope, height = np.polyfit(points[:, 0], points[:, 1], 1)
    line, inliers = load_reference("02_ransac_line").ransac_line(points, 10, 1.0, 1)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.7), layout="compressed")
    options = {"limits": ((-7.5, 7.5), (-6, 6))}
    plots.line_model(points, (slope, -1, height), axes=left, title="Least squares", **options)
    plots.line_model(points, line, inliers, 1.0, axes=right, title="RANSAC", **options)
    for axes in (left, right):
        axes.get_legend().remove()
        axes.set_title(axes.get_title(loc="left"), loc="left", fontweight="bold", pad=6)
    return figure
