"""Preview of lesson 04: a street split by a kd-tree, and a search that visits few nodes."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.visits import watched


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    inside = (cloud[:, 2] > -1.2) & (np.abs(cloud[:, 0] - 8) < 20) & (np.abs(cloud[:, 1]) < 10)
    street = cloud[inside & (np.hypot(cloud[:, 0], cloud[:, 1]) > 2), :2]
    street = street[np.unique(np.floor(street / 0.9), axis=0, return_index=True)[1]]
    lesson = load_reference("04_kd_tree")
    tree = lesson.KdTree()
    for index in lesson.median_order(street):
        tree.insert(street[index], index)
    target, tolerance = np.array([8.8, -0.3]), 1.2
    with watched(tree) as visited:
        found = tree.search(target, tolerance)
    figure, axes = plt.subplots(figsize=(7, 3.8), layout="compressed")
    plots.kd_search(
        street,
        tree.root,
        target,
        tolerance,
        visited,
        found=found,
        names=False,
        legend=False,
        limits=((-12, 28), (-10, 10)),
        axes=axes,
    )
    return figure
