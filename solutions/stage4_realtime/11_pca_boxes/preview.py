"""Preview of lesson 11: a diagonal car in a box along the street, and in the closest one."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.datasets import DATA


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    objects = np.load(DATA / "cloud_truth.npz")["objects"]
    car = cloud[(objects == 10) & (cloud[:, 2] >= -1.2)]
    labels = np.ones(len(car), dtype=int)
    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="compressed")
    plots.boxes(
        load_reference("08_bounding_boxes").get_bounding_boxes(car, labels),
        cloud=car,
        reference=True,
        limits=((4.0, 10.4), (1.2, 6.4)),
        axes=axes,
    )
    plots.boxes(load_reference("11_pca_boxes").get_oriented_boxes(car, labels), axes=axes)
    lines = axes.get_legend_handles_labels()[0]
    axes.legend(
        lines,
        ["along the street", "the closest rectangle"],
        loc="lower left",
        bbox_to_anchor=(0, 1),
        ncols=2,
    )
    return figure
