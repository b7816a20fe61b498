"""Preview of lesson 06: a slice of street from the side, with the ground level."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from utils import load_cloud, plots


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    figure, axes = plt.subplots(figsize=(8.5, 2.8), layout="compressed")
    strip = cloud[np.abs(cloud[:, 1]) < 6]
    plots.kept_and_removed(
        strip, strip[:, 2] >= -1.2, view="side", axes=axes, limits=((-12, 28), (-2.6, 2.6))
    )
    axes.axhline(-1.2, color="black", linestyle="--", linewidth=1)
    axes.get_legend().remove()  # the counts would answer the lesson's first question
    axes.set_title("")
    return figure
