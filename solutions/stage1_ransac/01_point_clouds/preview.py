"""Preview of lesson 01: one turn of the scanner as a panorama and as a map."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.plots.style import COLOURS

# For each label: azimuth in the panorama, position of the object on the map, offset of the text.
LABELLED = {
    "cyclist": (41, (3.4, 2.0), (-12, 32)),
    "turning car": (20.5, (7.0, 3.4), (24, 32)),
    "pedestrian": (-2, (8.9, -0.3), (34, 20)),
    "parked car": (-24, (6.8, -2.4), (20, -34)),
}
LABEL = {"ha": "center", "va": "bottom", "fontsize": 10.5, "zorder": 9}


def draw() -> Figure:
    """Return the preview as a figure."""
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
    for name, (middle, _, _) in LABELLED.items():
        panorama.text(middle, 3.0, name, **LABEL | {"fontsize": 9.5})
    near = (np.abs(cloud[:, 0] - 4) < 22) & (np.abs(cloud[:, 1]) < 11)
    plots.from_above(
        cloud[near],
        values=distance[near],
        label="distance (m)",
        limits=((-16, 24), (-10.5, 10.5)),
        axes=above,
    )
    for name, (_, place, offset) in LABELLED.items():
        above.annotate(
            name,
            place,
            xytext=offset,
            textcoords="offset points",
            arrowprops={"arrowstyle": "-", "linewidth": 1.2},
            bbox={"facecolor": "white", "alpha": 0.85, "edgecolor": "none", "pad": 1.0},
            **LABEL,
        )
    return figure
