"""Lesson 01: one turn of the scanner, as it sees the street and as a map."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.plots.style import COLOURS


def draw() -> Figure:
    """Return the figure."""
    lesson = load_reference("01_point_clouds")
    cloud = lesson.drop_invalid(load_cloud("cloud.txt"))
    distance = lesson.horizontal_distance(cloud)
    azimuth = np.degrees(np.arctan2(cloud[:, 1], cloud[:, 0]))
    elevation = np.degrees(np.arctan2(cloud[:, 2], distance))
    figure, (panorama, above) = plt.subplots(
        2, 1, figsize=(8.5, 5.2), height_ratios=(1, 2.2), layout="compressed"
    )
    ahead = (np.abs(azimuth) < 75) & (elevation > -16)
    panorama.scatter(
        azimuth[ahead],
        elevation[ahead],
        c=distance[ahead],
        s=2.2,
        marker="s",
        cmap=COLOURS,
        vmin=3,
        vmax=20,
        linewidths=0,
        antialiased=False,
    )
    panorama.set(xlim=(75, -75), ylim=(-16, 2.4), facecolor="white")
    panorama.set_axis_off()
    near = (np.abs(cloud[:, 0] - 4) < 22) & (np.abs(cloud[:, 1]) < 11)
    plots.from_above(
        cloud[near],
        values=distance[near],
        label="distance (m)",
        limits=((-16, 24), (-10.5, 10.5)),
        axes=above,
    )
    return figure
