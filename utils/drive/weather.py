"""What gets between scanner and street: raindrops, and a wet, dirty bonnet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from utils.simulator.scanner import CLASSES, Scan

RAINDROP = len(CLASSES)
"""The class of a raindrop's return, after those of the simulator."""

KINDS = (*CLASSES, "raindrop")

BONNET = ((0.9, 2.3), (-0.9, 0.9), -0.85)
"""x from, to; y from, to; height of the bonnet in metres, the scanner at the origin."""


def with_rain(scan: Scan, drops: int, rng: np.random.Generator) -> Scan:
    """A scan with returns from single drops, most of them near, all of them in front of us.

    Parameters
    ----------
    scan : Scan
    drops : int
        How many; a drop in the beam returns one echo.
    rng : numpy.random.Generator
    """
    # As many per metre of beam, but far ones return too little to be heard.
    distance = 1.5 + rng.exponential(5.0, drops)
    azimuth, elevation = rng.uniform(-0.6, 0.6, drops), np.radians(rng.uniform(-8.0, 2.0, drops))
    flat = distance * np.cos(elevation)
    xyz = (flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation))
    rows = np.column_stack([*xyz, rng.uniform(0.01, 0.05, drops)])
    return _with(scan, rows, RAINDROP)


def with_dirt(scan: Scan, rng: np.random.Generator) -> Scan:
    """A scan with returns from a dirty bonnet, from edge to edge."""
    (back, front), (right, left), height = BONNET
    x, y = (axis.ravel() for axis in np.mgrid[back:front:0.1, right:left:0.1])
    rows = np.column_stack([x, y, np.full(x.size, height), np.full(x.size, 0.5)])
    rows[:, :3] += rng.normal(0.0, 0.02, (x.size, 3))
    return _with(scan, rows, CLASSES.index("ego"))


def _with(scan: Scan, rows: np.ndarray, code: int) -> Scan:
    """A scan with more rows, of one class and of no object."""
    count = len(rows)
    return replace(
        scan,
        cloud=np.vstack([scan.cloud, np.round(rows, 6)]),
        classes=np.append(scan.classes, np.full(count, code, dtype=np.uint8)),
        objects=np.append(scan.objects, np.zeros(count, dtype=np.int32)),
        beams=np.append(scan.beams, np.zeros(count, dtype=np.uint16)),
        times=np.append(scan.times, np.zeros(count)),
    )
