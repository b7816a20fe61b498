"""Preview of lesson 10: a car, connected by all pairs of points and by few pairs of cells."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from utils import load_cloud, plots


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    x, y, z = cloud[:, 0], cloud[:, 1], cloud[:, 2]
    car = cloud[(z > -1.2) & (x > 5) & (x < 10) & (y > -5) & (y < -1.2), :2]
    car = car[np.random.default_rng(2).choice(len(car), 260, replace=False)]
    side = 0.5 / np.sqrt(2)
    first = np.unique(np.floor(car / side), axis=0, return_index=True)[1]
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.9), layout="compressed")
    window = ((4.7, 9.6), (-4.6, -0.9))
    plots.graph(
        car,
        cKDTree(car).query_pairs(0.5, output_type="ndarray"),
        limits=window,
        axes=left,
        title="All pairs of neighbours",
    )
    edges = first[cKDTree(car[first]).query_pairs(0.5, output_type="ndarray")]
    plots.graph(car, edges, limits=window, axes=right, title="One point for each cell")
    right.plot(*car[first].T, "s", markersize=8, markerfacecolor="none", color="black")
    for axis, (low, high) in ((right.xaxis, window[0]), (right.yaxis, window[1])):
        axis.set_ticks(np.arange(np.ceil(low / side), high / side) * side, minor=True)
    right.grid(False)
    right.grid(which="minor", color="0.6", linewidth=0.7)
    right.tick_params(which="minor", length=0)
    return figure
