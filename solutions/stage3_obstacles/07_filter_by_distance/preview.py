"""Preview of lesson 07: a street with a circle, a region of interest and the ego car's box."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from utils import load_cloud, plots


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    standing = cloud[cloud[:, 2] >= -1.2]
    figure, axes = plt.subplots(figsize=(8.5, 4.6), layout="compressed")
    near = np.hypot(standing[:, 0], standing[:, 1]) <= 10
    plots.kept_and_removed(standing[::2], near[::2], limits=((-15, 35), (-13, 13)), axes=axes)
    axes.get_legend().remove()  # the counts would answer the lesson's first question
    look = {"fill": False, "edgecolor": "black", "linewidth": 1.3}
    axes.add_patch(plt.Circle((0, 0), 10, linestyle="--", **look))
    axes.add_patch(plt.Rectangle((-10, -5), 40, 11, **look))
    axes.add_patch(plt.Rectangle((-1.5, -1.7), 4.1, 3.4, **look))
    axes.annotate("10 m around the sensor", (6.6, 8.4), fontsize=10)
    axes.annotate("region of interest", (30, 6.3), ha="right", fontsize=10)
    axes.annotate("ego car", (2.8, -1.6), fontsize=10)
    return figure
