"""Build the panel at the top of the website's front page: a scan that readers turn and divide.

The scan is a script, because a page that is opened from a disk cannot fetch files.
``playground.js`` decodes the scan, and computes and draws everything.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from pathlib import Path

import jinja2
import numpy as np

HERE = Path(__file__).parent
CLOUD = HERE.parents[1] / "data" / "cloud.txt"
STEP = 0.0025  # metres; with it, 16 bits reach 82 m in each direction


def panel(keep: Callable[[bytes, str], str]) -> str:
    """Render the panel as HTML.

    Parameters
    ----------
    keep : callable
        Stores the content of a file with a suffix, and returns its path in the site.
    """
    cloud = np.loadtxt(CLOUD, usecols=(0, 1, 2))
    template = jinja2.Template((HERE / "playground.html").read_text("utf-8"), autoescape=True)
    return template.render(
        scan=keep(scan_script(cloud), ".js"),
        style=keep((HERE / "playground.css").read_bytes(), ".css"),
        script=keep((HERE / "playground.js").read_bytes(), ".js"),
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
