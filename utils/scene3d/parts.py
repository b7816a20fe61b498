"""The parts of a scene: points, segments, faces and labels, each on a layer.

Each renderer (PyVista, matplotlib, the viewer in the browser) draws these four kinds of parts. It
uses only the attributes of `Drawable` from a scene.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from matplotlib.colors import to_rgb

from utils.plots.style import INK

LAYERS: dict[str, str] = {
    "scene": "road and cars",
    "lidar_rays": "lidar rays",
    "filtered_cloud": "filtered points",
    "data_points": "data points",
    "plane_cloud": "plane points",
    "obstacle_cloud": "obstacle points",
    "kd_tree": "kd-tree",
    "clusters": "clusters",
    "ego_car_box": "ego car",
    "boxes": "boxes",
    "oriented_boxes": "oriented boxes",
    "trails": "trails",
}
"""Layers that can be turned on and off, with the names that readers see."""


@dataclass(frozen=True, eq=False)
class Points:
    """Dots of a fixed size.

    Attributes
    ----------
    xyz : ndarray of float32, shape (n, 3)
        Finite coordinates in metres.
    colours : ndarray of uint8, shape (n, 3)
        Red, green and blue.
    size : float
        Width of a dot in pixels.
    layer, name : str
        `name` is the entry in the legend; an empty name gives no entry.
    """

    xyz: np.ndarray
    colours: np.ndarray
    size: float
    layer: str
    name: str = ""


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines.

    A dashed line consists of many short segments.

    Attributes
    ----------
    ends : ndarray, shape (m, 2, 3)
        Both ends of each segment, in metres.
    colour : str
        A colour such as "#0072B2".
    width : float
        Width in pixels.
    layer, name : str
        `name` is the entry in the legend; an empty name gives no entry.
    opacity : float
        From 0 (invisible) to 1 (opaque).
    is_dashed : bool
        Whether to show a dashed line in the legend.
    """

    ends: np.ndarray
    colour: str
    width: float
    layer: str
    name: str = ""
    opacity: float = 1.0
    is_dashed: bool = False


@dataclass(frozen=True, eq=False)
class Faces:
    """Coloured triangles.

    Attributes
    ----------
    triangles : ndarray, shape (m, 3, 3)
        The three corners of each triangle, in metres.
    colours : ndarray of uint8, shape (m, 3)
        Red, green and blue of each triangle.
    opacity : float
        From 0 (invisible) to 1 (opaque).
    layer, name : str
        `name` is the entry in the legend; an empty name gives no entry.
    """

    triangles: np.ndarray
    colours: np.ndarray
    opacity: float
    layer: str
    name: str = ""


@dataclass(frozen=True, eq=False)
class Label:
    """A text at the position `at`, shape (3,) in metres, which no other part hides."""

    at: np.ndarray
    text: str
    layer: str
    colour: str = INK


Part = Points | Segments | Faces | Label


class Drawable(Protocol):
    """The attributes of a `utils.scene3d.Scene` that a renderer uses.

    Attributes
    ----------
    title, caption : str
        Text above the picture, and text below it.
    alt : str
        Text alternative of the picture; if empty, it is made from the names of the parts.
    switches : dict of str to bool
        For each layer, whether it is on.
    all_parts, parts : tuple of Part
        All parts, and the parts whose layers are on.
    """

    title: str
    caption: str
    alt: str
    switches: dict[str, bool]
    all_parts: tuple[Part, ...]
    parts: tuple[Part, ...]


def rgb_bytes(colour: str) -> np.ndarray:
    """Return a colour such as "#0072B2" as three bytes: red, green and blue."""
    return np.round(np.multiply(to_rgb(colour), 255)).astype(np.uint8)


def dot_size(count: int) -> float:
    """Return the size of a dot in pixels, smaller for a cloud with more points."""
    return float(np.clip(round(30 / max(count, 1) ** 0.25), 2, 6))


def cut_into_dashes(ends: np.ndarray, dash: float = 0.25) -> np.ndarray:
    """Cut segments (m, 2, 3) into dashes (k, 2, 3) of about `dash` metres, with equal gaps.

    Some renderers cannot draw dashed lines, but all of them can draw short segments.
    """
    if not len(ends):
        return ends
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    # An odd number of pieces puts a dash at either end. The limit guards against huge boxes.
    pieces = np.clip(np.nan_to_num(lengths / dash), 1, 400).astype(int) // 2 * 2 + 1
    rows = np.repeat(np.arange(len(ends)), (pieces + 1) // 2)
    first = np.concatenate([np.arange(0, count, 2) for count in pieces])
    shares = np.stack([first, first + 1], axis=1) / pieces[rows, None]
    start, step = ends[rows, 0], ends[rows, 1] - ends[rows, 0]
    return start[:, None] + shares[:, :, None] * step[:, None]
