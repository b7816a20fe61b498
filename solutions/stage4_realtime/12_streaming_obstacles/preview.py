"""Preview of lesson 12: a city street from above, with the boxes of one frame and their trails."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from grader.course.lessons import load_reference
from utils import plots, scenes


def draw() -> Figure:
    """Return the preview as a figure."""
    lesson = load_reference("12_streaming_obstacles")
    frames = list(scenes.city_block(1, 12))
    boxes, trails = np.empty((0, 8, 3)), []
    for frame in frames:
        found = lesson.detect_obstacles(frame.cloud, threshold=0.4)
        partners = lesson.match_boxes(boxes, found, 1.5)
        centres = found.mean(axis=1)[:, :2]
        trails = [
            [*(trails[partner] if partner >= 0 else ()), centre]
            for partner, centre in zip(partners, centres, strict=True)
        ]
        boxes = found
    figure, axes = plt.subplots(figsize=(8.5, 4.4), layout="compressed")
    standing = frames[-1].cloud[frames[-1].scan.objects > 0]
    plots.boxes(boxes, cloud=standing[::12], limits=((-12, 30), (-9, 10.5)), axes=axes)
    for trail in trails:
        axes.plot(*np.array(trail).T, ".-", color="black", linewidth=1, markersize=3)
    return figure
