"""Count the operations with which lesson 13 turns a scan into boxes.

Additions, multiplications, divisions, comparisons and moves of a number count as one operation.
The bytes are those of all points that a step reads or writes, as if nothing stayed in the cache.

    PYTHONPATH=. python tests/benchmarks/count_operations.py [SCAN ...]     # cloud.txt by default
"""

import sys

import numpy as np

from grader.course.lessons import load_reference
from utils import load_cloud

RANSAC_ITERATIONS = 50  # of RANSAC
POINT = 24  # bytes of x, y, z
PLANE = 8  # three products, three sums, the absolute value and the comparison


def counts(cloud: np.ndarray) -> dict[str, tuple[int, int]]:
    """Return the operations and bytes of each step for one scan."""
    steps = load_reference("12_streaming_obstacles").detect_obstacles.__globals__
    valid = steps["drop_invalid"](cloud)[:, :3]
    region = steps["crop_region"](valid, (-15, -7, -3), (35, 9, 1))
    points = steps["remove_ego_returns"](region, (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4))
    low = points[points[:, 2] < -1.2]
    _, near = steps["ransac_plane"](low, RANSAC_ITERATIONS, 0.2, 0)
    road = steps["fit_plane"](low[near])
    high = points[steps["point_plane_distance"](points, road) > 0.3]
    voxels = steps["voxel_grid"](high, 0.2)
    n, p, q, k, h, v = (len(rows) for rows in (cloud, points, low, low[near], high, voxels))
    return {
        "useful points": (n * 15 + p * 3, (n + p) * POINT),
        "ground by RANSAC": (q * PLANE * RANSAC_ITERATIONS, q * POINT * RANSAC_ITERATIONS),
        # Two passes over all points: means, and nine products of deviations.
        "plane through its inliers": (2 * p * PLANE + k * (3 + 9 * 4), 2 * p * POINT),
        "points above the ground": (p * PLANE + h * 3, (p + h) * POINT),
        # Cells, three digits of the sort with ten operations each, and means.
        "voxels": (h * (18 + 3 * 10 + 6), 5 * h * POINT),
        # Each voxel may be compared with the first points of all 62 cells that follow it.
        "clusters": (v * (18 + 3 * 10 + 62 * 10), 70 * v * POINT),
        # Four products, two sums and four extremes for each of 90 angles.
        "boxes": (v * 90 * 10, v * 90 * 4 * 8 * 2),
    }


def main(names: list[str]) -> None:
    """Print a table for each scan."""
    for name in names:
        found = counts(load_cloud(name))
        print(f"\n{name}\n\n| step | million operations | million bytes |\n|---|---:|---:|")
        for step, numbers in (found | {"sum": np.sum([*found.values()], axis=0)}).items():
            print(f"| {step} | {numbers[0] / 1e6:.1f} | {numbers[1] / 1e6:.1f} |")


if __name__ == "__main__":
    main(sys.argv[1:] or ["cloud.txt"])
