"""Preview of lesson 03: the road as a plane, seen from the side."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from utils import load_cloud, plots
from utils.datasets import DATA
from utils.geometry import best_plane


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    truth = np.load(DATA / "cloud_truth.npz")
    is_road = truth["classes"] == truth["class_names"].tolist().index("ground")
    street = (np.abs(cloud[:, 1]) < 5) & (cloud[:, 0] > -10) & (cloud[:, 0] < 30)
    plane, _ = best_plane(cloud[street & is_road])
    points = cloud[street][::8]
    inliers = np.abs(points[:, :3] @ plane[:3] + plane[3]) <= 0.2
    figure, axes = plt.subplots(figsize=(8.5, 3.4), layout="compressed")
    plots.plane_model(points, plane, inliers, 0.2, limits=((-10, 30), (-2.6, 1.4)), axes=axes)
    _leave_out_counts(axes)
    return figure


def _leave_out_counts(axes: Axes) -> None:
    """Remove the counts from the legend, because they would answer a question in the lesson."""
    for text in axes.get_legend().get_texts():
        text.set_text(text.get_text().partition(":")[0])
