"""Preview of lesson 08: a street from above, with a box around every obstacle."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.boxes import Box
from utils.datasets import DATA


def draw() -> Figure:
    """Return the preview as a figure."""
    cloud = load_cloud("cloud.txt")
    truth = np.load(DATA / "cloud_truth.npz")
    near = (cloud[:, 2] >= -1.2) & (np.hypot(cloud[:, 0], cloud[:, 1]) < 20)  # as in the lesson
    labels = np.where(near, truth["objects"], 0)
    corners = load_reference("08_bounding_boxes").get_bounding_boxes(cloud, labels)
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
    plots.boxes(corners, cloud=cloud[labels > 0], limits=((-12, 22), (-9, 9)), axes=axes)
    row = np.flatnonzero(truth["box_identities"] == 10)[0]
    car = Box(truth["box_centres"][row], truth["box_sizes"][row], truth["box_yaws"][row], "car", 10)
    plots.boxes(car.corners[None], reference=True, label="the diagonal car itself", axes=axes)
    # With tick labels, a student could measure the area that the lesson asks for.
    axes.set(xticklabels=[], yticklabels=[], xlabel="x, forward", ylabel="y, left")
    return figure
