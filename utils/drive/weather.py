"""Disturbances of a scan: raindrops, and a wet, dirty bonnet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from utils.simulator.scanner import CLASSES, Scan

RAINDROP = len(CLASSES)
"""Class of a raindrop's return, which follows the classes of the simulator."""

KINDS = (*CLASSES, "raindrop")

BONNET = ((0.9, 2.3), (-0.9, 0.9), -0.85)
"""Range of the bonnet in x and in y, and its height, in metres with the scanner at the origin."""


def with_rain(scan: Scan, drops: int, rng: np.random.Generator) -> Scan:
    """Return a scan with added returns from raindrops in front of the car, most of them near.

    Parameters
    ----------
    scan : Scan
    drops : int
        Number of drops; each one returns one echo.
    rng : numpy.random.Generator
    """
    # Drops are equally frequent at any distance, but echoes of distant drops are too weak.
    distance = 1.5 + rng.exponential(5.0, drops)
    azimuth, elevation = rng.uniform(-0.6, 0.6, drops), np.radians(rng.uniform(-8.0, 2.0, drops))
    flat = distance * np.cos(elevation)
    xyz = (flat * np.cos(azimuth), flat * np.sin(azimuth), distance * np.sin(elevation))
    rows = np.column_stack([*xyz, rng.uniform(0.01, 0.05, drops)])
    return _with_rows(scan, rows, RAINDROP)


def with_dirt(scan: Scan, rng: np.random.Generator) -> Scan:
    """Return a scan with added returns from the whole surface of a dirty bonnet."""
    (back, front), (right, left), height = BONNET
    x, y = (axis.ravel() for axis in np.mgrid[back:front:0.1, right:left:0.1])
    rows = np.column_stack([x, y, np.full(x.size, height), np.full(x.size, 0.5)])
    rows[:, :3] += rng.normal(0.0, 0.02, (x.size, 3))
    return _with_rows(scan, rows, CLASSES.index("ego"))


def _with_rows(scan: Scan, rows: np.ndarray, code: int) -> Scan:
    """Return a scan with added rows of one class that belong to no object."""
    count = len(rows)
    return replace(
        scan,
        cloud=np.vstack([scan.cloud, np.round(rows, 6)]),
        classes=np.append(scan.classes, np.full(count, code, dtype=np.uint8)),
        objects=np.append(scan.objects, np.zeros(count, dtype=np.int32)),
        beams=np.append(scan.beams, np.zeros(count, dtype=np.uint16)),
        times=np.append(scan.times, np.zeros(count)),
    )
