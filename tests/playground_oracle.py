"""Count the clusters in the playground's scan with SciPy; `site_in_browser.py` runs this script.

    python -m tests.playground_oracle SCAN.js SETTINGS

SETTINGS is a JSON object with the plane and the positions of the sliders. The script prints four
numbers: the points on the ground, distant points, points in clusters, and clusters.
"""

import base64
import json
import sys
from pathlib import Path

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree


def scan_of(script):
    """Return the coordinates (n, 3) in a script of the playground as whole steps, and the step."""
    scan = json.loads(script[script.index("{") : script.rindex("}") + 1])
    return np.frombuffer(base64.b64decode(scan["xyz"]), "<i2").reshape(-1, 3), scan["step"]


def counts(points, step, settings):
    """Return the four numbers; see the module's docstring."""
    points = points.astype(float)
    a, b, c = settings["plane"]
    metres = ("ground", "distance", "threshold")
    reach, distance, gap = (round(settings[name] / step) for name in metres)
    on_ground = points[:, 2] - (a * points[:, 0] + b * points[:, 1] + c) <= reach
    far = ~on_ground & (np.hypot(points[:, 0], points[:, 1]) > distance)
    near = points[~on_ground & ~far]
    # Squared distances are whole numbers, so no distance is between these two.
    pairs = cKDTree(near).query_pairs(np.sqrt(gap**2 - 0.5), output_type="ndarray")
    graph = coo_array((np.ones(len(pairs), bool), pairs.T), shape=(len(near), len(near)))
    sizes = np.bincount(connected_components(graph, directed=False)[1])
    large = sizes[sizes >= settings["least"]]
    return [int(on_ground.sum()), int(far.sum()), int(large.sum()), len(large)]


if __name__ == "__main__":
    place, values = sys.argv[1:]
    print(json.dumps(counts(*scan_of(Path(place).read_text("utf-8")), json.loads(values))))
