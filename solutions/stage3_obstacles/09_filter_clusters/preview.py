"""Preview of lesson 09: a wet street from above, with small clusters marked as noise."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import load_cloud, plots
from utils.datasets import DATA


def draw() -> Figure:
    """Return the preview as a figure."""
    scan, objects = load_cloud("cloud.txt"), np.load(DATA / "cloud_truth.npz")["objects"]
    standing = (scan[:, 2] >= -1.2) & (objects > 0) & (np.hypot(scan[:, 0], scan[:, 1]) < 30)
    rng = np.random.default_rng(9)
    puffs = rng.geometric(0.1, 60)
    middle = rng.uniform([-12, -3, -0.9], [25, 3, 0.2], (60, 3)).repeat(puffs, axis=0)
    spray = np.column_stack([rng.normal(middle, 0.15), np.zeros(len(middle))])
    labels = np.concatenate([objects[standing], 1000 + np.arange(60).repeat(puffs)])
    filtered = load_reference("09_filter_clusters").filter_clusters(labels, 100)
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
    plots.clusters(
        np.vstack([scan[standing], spray]), filtered, axes=axes, limits=((-12, 28), (-10, 10))
    )
    return figure
