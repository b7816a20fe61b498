"""Build the playground on the front page: the course's scan, which readers turn and divide.

The scan is a script, because a page from a disk cannot fetch a file. ``static/playground.js``
decodes the scan, and computes and draws everything.
"""

from __future__ import annotations

import base64
import json

import numpy as np

from grader.course.paths import PROJECT
from grader.site.html_outputs import TEMPLATES
from grader.site.pictures import Pictures

CLOUD = PROJECT / "data" / "cloud.txt"
STEP = 0.0025  # metres; with it, 16 bits reach 82 m in each direction


def panel(pictures: Pictures) -> str:
    """Render the playground as HTML, and add its scan to the collection of files."""
    cloud = np.loadtxt(CLOUD, usecols=(0, 1, 2))
    return TEMPLATES.get_template("playground.html").render(
        scan=pictures.keep(scan_script(cloud), ".js"),
        count=f"{len(cloud):,}",
        error=f"{1000 * np.abs(cloud - STEP * np.round(cloud / STEP)).max():.0f}",
    )


def scan_script(xyz: np.ndarray) -> bytes:
    """Return a script that defines ``SCAN``: coordinates in steps of `STEP`, as 16-bit integers.

    Parameters
    ----------
    xyz : array (n, 3)
        Coordinates in metres.

    Raises
    ------
    ValueError
        If a coordinate does not fit into 16 bits.
    """
    steps = np.round(xyz / STEP)
    limit = np.iinfo(np.int16).max
    if not (np.abs(steps) <= limit).all():
        raise ValueError(f"The scan must be within {limit * STEP:.1f} m of the scanner.")
    packed = base64.b64encode(steps.astype("<i2").tobytes()).decode()
    return f"const SCAN = {json.dumps({'step': STEP, 'xyz': packed})};\n".encode()
