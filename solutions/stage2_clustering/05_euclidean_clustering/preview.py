"""Preview of lesson 05: a street from above, as points and as numbered obstacles."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots

LIMITS = ((-5, 14), (-10, 8))


def draw() -> Figure:
    """Return the preview as a figure."""
    ground = load_reference("06_filter_ground")
    obstacles = ground.voxel_grid(ground.filter_ground(load_cloud("cloud.txt")), 0.2)
    x, y = obstacles[:, 0], obstacles[:, 1]
    obstacles = obstacles[(x > -8) & (x < 17) & (np.abs(y) < 12) & (np.hypot(x, y) > 2)]
    labels = load_reference("05_euclidean_clustering").euclidean_clustering(obstacles, 0.5)
    figure, panels = plt.subplots(1, 2, figsize=(8.5, 4.2), layout="compressed")
    for axes, numbers, title in zip(
        panels, (np.ones(len(obstacles), int), labels), ("points", "obstacles"), strict=True
    ):
        plots.clusters(obstacles, numbers, limits=LIMITS, axes=axes)
        axes.get_legend().remove()
        axes.set_title(title, loc="left", pad=6, fontweight="bold")
        axes.set(xticks=[], yticks=[], xlabel="", ylabel="")
    return figure
