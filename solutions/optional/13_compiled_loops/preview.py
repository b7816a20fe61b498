"""Preview of lesson 13: the clusters of a scan and the closest rectangles around them."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")[:, :3]
    points = cloud[(cloud[:, 2] > -1.2) & (np.hypot(cloud[:, 0], cloud[:, 1]) > 2)]
    points = load_reference("06_filter_ground").voxel_grid(points, 0.2)
    labels = load_reference("10_accelerated_clustering").euclidean_clustering_accelerated(points)
    labels = load_reference("09_filter_clusters").filter_clusters(labels, 10)
    boxes = load_reference("11_pca_boxes").get_oriented_boxes(points, labels)
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
    plots.clusters(points[labels > 0], labels[labels > 0], axes=axes)
    boxes = boxes[np.ptp(boxes[:, :, :2], axis=1).max(axis=1) < 8]  # without house fronts
    plots.boxes(boxes, limits=((-15, 35), (-9, 11)), axes=axes)
    if axes.get_legend():
        axes.get_legend().remove()
    return figure
