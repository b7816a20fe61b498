"""Lesson 05: a street from above, every cluster in its own colour and marker."""

import matplotlib.pyplot as plt
import numpy as np

from grader.lessons import load_reference
from utils import load_cloud, plots


def draw():
    """Return the figure."""
    ground = load_reference("06_filter_ground")
    obstacles = ground.voxel_grid(ground.filter_ground(load_cloud("cloud.txt")), 0.2)
    inside = (np.abs(obstacles[:, 0] - 8) < 20) & (np.abs(obstacles[:, 1]) < 10)
    cluster = load_reference("05_euclidean_clustering").euclidean_clustering
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
    plots.clusters(obstacles[inside], cluster(obstacles[inside], 0.5),
                   limits=((-12, 28), (-10, 10)), axes=axes)
    return figure
