"""Draw the pictures of the README and at the head of each lesson: ``make pictures``."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from grader.lessons import load_reference  # noqa: E402
from grader.paths import PROJECT  # noqa: E402
from utils import load_cloud, plots  # noqa: E402

STREET = ((-12, 28), (-10, 10))


def main():
    """Draw every picture and write it where it belongs."""
    cloud = load_cloud("cloud.txt")
    ground = load_reference("06_filter_ground")
    save(filter_ground_preview(cloud), "stage3_obstacles", "06_preview.png")
    obstacles = ground.voxel_grid(ground.filter_ground(cloud), 0.2)
    inside = (np.abs(obstacles[:, 0] - 8) < 20) & (np.abs(obstacles[:, 1]) < 10)
    clustering = load_reference("05_euclidean_clustering").euclidean_clustering
    labels = clustering(obstacles[inside], 0.5)
    save(clustering_preview(obstacles[inside], labels), "stage2_clustering", "05_preview.png")


def filter_ground_preview(cloud):
    """A slice of street from the side, with the ground level."""
    figure, axes = plt.subplots(figsize=(8.5, 2.8), layout="constrained")
    strip = cloud[np.abs(cloud[:, 1]) < 6]
    plots.kept_and_removed(strip, strip[:, 2] >= -1.2, view="side", axes=axes,
                           limits=((-12, 28), (-2.6, 2.6)))
    axes.axhline(-1.2, color="black", linestyle="--", linewidth=1)
    return figure


def clustering_preview(cloud, labels):
    """A street from above, every cluster in its own colour and marker."""
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="constrained")
    plots.clusters(cloud, labels, limits=STREET, axes=axes)
    return figure


def save(figure, stage, name):
    """Write a figure beside the lesson that shows it."""
    path = PROJECT / "solutions" / stage / "pictures" / name
    path.parent.mkdir(exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)


if __name__ == "__main__":
    main()
