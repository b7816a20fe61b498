"""Twelve points to cluster, with their true clusters."""

import numpy as np

THRESHOLD = 0.8
# The seven points of the lesson and five more. They include a chain whose middle point comes last,
# and a sign above the road.
POINTS = np.array(
    [
        [0.0, 0.0, 0.0, 0.1],
        [2.0, 0.1, 0.0, 0.9],
        [0.45, 0.15, 0.0, 0.9],
        [2.3, -0.2, 0.0, 0.2],
        [0.45, -0.15, 0.0, 0.1],
        [0.91, 0.0, 0.0, 0.9],
        [1.5, -1.1, 0.0, 0.5],
        [2.75, -0.75, 0.0, 0.9],
        [0.9, -1.7, 0.0, 0.1],
        [2.1, 0.45, 1.5, 0.9],
        [-0.35, -1.75, 0.0, 0.2],
        [0.31, -1.52, 0.0, 0.9],
    ]
)
GROUPS = ({0, 2, 4, 5}, {1, 3, 7}, {6}, {8, 10, 11}, {9})
ABOVE = {9: "1.5 m above the road"}

ROWS = range(len(POINTS))
GAPS = np.linalg.norm(POINTS[:, None, :3] - POINTS[None, :, :3], axis=2)
NEAR = (GAPS < THRESHOLD) & (GAPS > 0)
GROUP_OF = [next(number for number, group in enumerate(GROUPS) if row in group) for row in ROWS]
