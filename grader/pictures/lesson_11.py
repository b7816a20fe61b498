"""Lesson 11: a diagonal car from above, with the box along the street and the one that turns."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.datasets import DATA


def draw() -> Figure:
    """Return the figure."""
    cloud = load_cloud("cloud.txt")
    objects = np.load(DATA / "cloud_truth.npz")["objects"]
    car = cloud[(objects == 10) & (cloud[:, 2] >= -1.2)]
    one = np.ones(len(car), dtype=int)
    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="compressed")
    view = ((4.0, 10.4), (1.2, 6.4))
    plots.boxes(
        load_reference("08_bounding_boxes").get_bounding_boxes(car, one),
        cloud=car,
        reference=True,
        label="along the street",
        limits=view,
        axes=axes,
    )
    plots.boxes(
        load_reference("11_pca_boxes").get_oriented_boxes(car, one),
        axes=axes,
        label="turned with the car",
    )
    return figure
