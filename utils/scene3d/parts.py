"""What a scene is made of: points, segments, faces and labels, each on a layer.

Whatever draws (PyVista, matplotlib, the viewer in the browser) has to know these four, and that
a scene is `Drawable`.
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
"""Everything that can be switched on and off, with its name for the reader."""


@dataclass(frozen=True, eq=False)
class Points:
    """Dots of a fixed size.

    Attributes
    ----------
    xyz : ndarray of float32, shape (n, 3)
        Finite, in metres.
    colours : ndarray of uint8, shape (n, 3)
    size : float
        Pixels.
    layer, name : str
        `name` is what the legend says, where there is something to say.
    """

    xyz: np.ndarray
    colours: np.ndarray
    size: float
    layer: str
    name: str = ""


@dataclass(frozen=True, eq=False)
class Segments:
    """Straight lines: ends (m, 2, 3) in metres, a colour such as "#0072B2", a width in pixels.

    Dashed lines come as many short ones; `broken` says so to the legend.
    """

    ends: np.ndarray
    colour: str
    width: float
    layer: str
    name: str = ""
    opacity: float = 1.0
    broken: bool = False


@dataclass(frozen=True, eq=False)
class Faces:
    """Triangles (m, 3, 3) in metres with a colour each, uint8 (m, 3); below 1 one looks through."""

    triangles: np.ndarray
    colours: np.ndarray
    opacity: float
    layer: str
    name: str = ""


@dataclass(frozen=True, eq=False)
class Label:
    """A word at a place (3,) in metres, always readable."""

    at: np.ndarray
    text: str
    layer: str
    colour: str = INK


Part = Points | Segments | Faces | Label


class Drawable(Protocol):
    """All that whatever draws wants of a `utils.scene3d.Scene`.

    Attributes
    ----------
    title, caption : str
        Written above the picture, and below it.
    alt : str
        What the picture shows, in words; empty where its parts say it.
    switches : dict of str to bool
        Which layers are on.
    all_parts, parts : tuple of Part
        Everything, and what is switched on.
    """

    title: str
    caption: str
    alt: str
    switches: dict[str, bool]
    all_parts: tuple[Part, ...]
    parts: tuple[Part, ...]


def bytes_of(colour: str) -> np.ndarray:
    """The colour "#0072B2" as three bytes."""
    return np.round(np.multiply(to_rgb(colour), 255)).astype(np.uint8)


def dot_size(count: int) -> float:
    """Pixels of a dot that suit a cloud of `count` points: large for few, small for many."""
    return float(np.clip(round(30 / max(count, 1) ** 0.25), 2, 6))


def dashed(ends: np.ndarray, dash: float = 0.25) -> np.ndarray:
    """Cut segments (m, 2, 3) into dashes of about `dash` metres with gaps between, (k, 2, 3).

    Not every renderer knows dashed lines; all of them know short ones.
    """
    if not len(ends):
        return ends
    lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    # An odd number of pieces, so that a dash lies at either end; a bound for a wild box.
    pieces = np.clip(np.nan_to_num(lengths / dash), 1, 400).astype(int) // 2 * 2 + 1
    rows = np.repeat(np.arange(len(ends)), (pieces + 1) // 2)
    first = np.concatenate([np.arange(0, count, 2) for count in pieces])
    shares = np.stack([first, first + 1], axis=1) / pieces[rows, None]
    start, step = ends[rows, 0], ends[rows, 1] - ends[rows, 0]
    return start[:, None] + shares[:, :, None] * step[:, None]
