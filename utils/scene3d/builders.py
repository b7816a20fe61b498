"""Convert data to parts of a scene, with their colours, names and layers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from utils.plots.arguments import as_cloud, as_labels, as_names, as_values
from utils.plots.style import (
    BLUE,
    COLOURS,
    GREEN,
    INK,
    MUTED,
    ORANGE,
    PALE,
    PALETTE,
    VERMILION,
    counted,
)
from utils.plots.trees import AXIS_STYLES
from utils.scene3d import solids
from utils.scene3d.parts import (
    LAYERS,
    Faces,
    Label,
    Part,
    Points,
    Segments,
    cut_into_dashes,
    dot_size,
    rgb_bytes,
)

if TYPE_CHECKING:
    from utils.visits import Node

MAGENTA, ASPHALT = "#C2158A", "#D3D7DB"
BOX_LOOKS = {"boxes": (VERMILION, 2.0), "oriented_boxes": (BLUE, 3.0)}
MAX_NAMES = 12
LABEL_RISE = 0.3
"""Metres from the top of an object to its label."""

LANE_LINE = 2.0
"""Metres from the centre of the road to a lane line."""

SINK = 0.12
"""Metres by which the road is drawn below its true height."""


def cloud_parts(
    cloud: ArrayLike,
    values: ArrayLike | None,
    colour: str | None,
    size: float | None,
    layer: str,
    name: str,
) -> list[Part]:
    """Return the points of a cloud, in one colour or coloured by `values` or by height."""
    cloud = as_cloud(cloud)
    if colour is not None:
        colours = np.tile(rgb_bytes(colour), (len(cloud), 1))
    else:
        colours = _colours_of_values(
            cloud[:, 2] if values is None else as_values(values, len(cloud))
        )
    return [_points(cloud, colours, size, layer, name or LAYERS[layer])]


def cluster_parts(cloud: ArrayLike, labels: ArrayLike, names: bool) -> list[Part]:
    """Return points in the colours of their clusters, pale noise, and labels of big clusters."""
    cloud = as_cloud(cloud)
    labels = as_labels(labels, len(cloud))
    noise = labels <= 0
    found, counts = np.unique(labels[~noise], return_counts=True)
    palette = np.array([rgb_bytes(colour) for colour in PALETTE])
    size = dot_size(len(cloud))
    colours = palette[(labels[~noise] - 1) % len(PALETTE)]
    name = f"points in {counted(len(found), 'cluster')}"
    parts: list[Part] = [_points(cloud[~noise], colours, size + 1, "clusters", name)]
    if noise.any():
        pale = np.tile(rgb_bytes(PALE), (np.count_nonzero(noise), 1))
        parts.append(_points(cloud[noise], pale, max(size - 1, 1), "clusters", "noise points"))
    for label in found[np.argsort(-counts, kind="stable")[:MAX_NAMES]] if names else ():
        members = cloud[labels == label, :3]
        members = members[np.isfinite(members).all(axis=1)]
        if len(members):
            parts.append(_label_above(members, str(label), "clusters"))
    return parts


def plane_parts(cloud: ArrayLike, plane: Sequence[float] | np.ndarray | None) -> list[Part]:
    """Return the points of a plane in green and, if the plane is given, a patch of the plane."""
    cloud = as_cloud(cloud)
    parts = cloud_parts(cloud, None, GREEN, None, "plane_cloud", "")
    if plane is not None:
        finite = cloud[np.isfinite(cloud[:, :3]).all(axis=1), :3]
        triangles, grid = solids.plane_patch(plane, finite)
        parts.append(Segments(grid, GREEN, 1.0, "plane_cloud"))
        parts.append(_faces(triangles, GREEN, "plane_cloud", 0.18, shaded=False))
    return parts


def kd_parts(root: Node | None, low: ArrayLike, high: ArrayLike, depth: int) -> list[Part]:
    """Return the cuts of a kd-tree in the colours of their axes; the first cuts have labels."""
    cuts = list(solids.kd_cuts(root, low, high, depth))
    parts: list[Part] = []
    for axis, (letter, _, colour) in enumerate(AXIS_STYLES):
        rings = np.array([cut.corners for cut in cuts if cut.axis == axis]).reshape(-1, 4, 3)
        if not len(rings):
            continue
        outline = rings[:, np.array(solids.RING)].reshape(-1, 2, 3)
        parts.append(Segments(outline, colour, 1.5, "kd_tree"))
        triangles = rings[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3, 3)
        name = f"cuts {letter}"
        parts.append(_faces(triangles, colour, "kd_tree", 0.16, name, shaded=False))
    for number, cut in enumerate(cuts[:MAX_NAMES], start=1):
        parts.append(Label(cut.corners[2], f"{number} {AXIS_STYLES[cut.axis][0]}", "kd_tree"))
    return parts


def ray_parts(cloud: ArrayLike, origin: ArrayLike, most: int) -> list[Part]:
    """Return lines from the sensor to at most `most` of its returns."""
    ends = as_cloud(cloud)[:, :3]
    ends = ends[np.isfinite(ends).all(axis=1)]
    name = counted(len(ends), "lidar ray")
    if len(ends) > most:
        name = f"{most:,} of {name}"
        # A random choice, because every k-th return could coincide with the order of the beams.
        ends = ends[np.random.default_rng(0).choice(len(ends), most, replace=False)]
    rays = np.stack([np.broadcast_to(np.asarray(origin, float), ends.shape), ends], axis=1)
    return [Segments(rays, ORANGE, 1.0, "lidar_rays", name, 0.3)]


def box_parts(
    corners: ArrayLike,
    names: bool | Sequence[str | int] | None,
    reference: bool,
    name: str,
    layer: str,
) -> list[Part]:
    """Return boxes as edges and transparent faces; reference boxes have only dashed grey edges."""
    corners = _as_corners(corners)
    texts = as_names(names, len(corners))
    finite = np.flatnonzero(np.isfinite(corners).all(axis=(1, 2)))
    corners = solids.order_corners(corners[finite])
    parts: list[Part] = [
        _label_above(box, texts[row], layer)
        for row, box in zip(finite, corners, strict=True)
        if texts
    ]
    name = f"{len(corners):,} {name or LAYERS[layer]}"
    edges = solids.edges_of(corners)
    colour, width = BOX_LOOKS[layer]
    if reference:
        return [*parts, Segments(cut_into_dashes(edges), MUTED, 2.0, layer, name, is_dashed=True)]
    faces = _faces(solids.faces_of(corners), colour, layer, 0.14)
    return [*parts, Segments(edges, colour, width, layer, name), faces]


def trail_parts(trails: Iterable[ArrayLike]) -> list[Part]:
    """Return one line per trail, through its positions (m, 3)."""
    lines = [np.asarray(trail, dtype=float).reshape(-1, 3) for trail in trails]
    lines = [line[np.isfinite(line).all(axis=1)] for line in lines]
    lines = [line for line in lines if len(line) > 1]
    ends = [np.stack([line[:-1], line[1:]], axis=1) for line in lines]
    ends = np.concatenate(ends) if ends else np.empty((0, 2, 3))
    return [Segments(ends, INK, 1.5, "trails", counted(len(lines), "trail"))]


def ego_parts(minimum: Iterable[float], maximum: Iterable[float]) -> list[Part]:
    """Return the box of the ego car in magenta."""
    corners = solids.upright_box(minimum, maximum)[None]
    edges = Segments(solids.edges_of(corners), MAGENTA, 2.5, "ego_car_box", LAYERS["ego_car_box"])
    return [edges, _faces(solids.faces_of(corners), MAGENTA, "ego_car_box", 0.25)]


def road_parts(height: float, length: float, width: float) -> list[Part]:
    """Return a straight road with two lane lines, `height` metres below the sensor."""
    ends = (-length / 2, length / 2)
    # The road is drawn slightly too low; otherwise it would hide half of the noisy returns.
    surface = solids.rectangle(ends, (-width / 2, width / 2), -height - SINK)
    lines = [[(x, side * LANE_LINE, -height - SINK / 2) for x in ends] for side in (-1, 1)]
    return [
        _faces(surface, ASPHALT, "scene", 1.0, shaded=False),
        Segments(np.array(lines), MUTED, 2.0, "scene"),
    ]


def car_parts(corners: ArrayLike, colour: str) -> list[Part]:
    """Return an opaque car made of blocks for each box."""
    corners = _as_corners(corners)
    corners = solids.order_corners(corners[np.isfinite(corners).all(axis=(1, 2))])
    blocks = [solids.block_car(box) for box in corners]
    blocks = np.concatenate(blocks) if blocks else np.empty((0, 8, 3))
    name = counted(len(corners), "car")
    return [
        Segments(solids.edges_of(blocks), INK, 1.0, "scene"),
        _faces(solids.faces_of(blocks), colour, "scene", 1.0, name),
    ]


def _points(
    cloud: np.ndarray, colours: np.ndarray, size: float | None, layer: str, name: str
) -> Points:
    finite = np.isfinite(cloud[:, :3]).all(axis=1)
    xyz = np.ascontiguousarray(cloud[finite, :3], dtype=np.float32)
    size = dot_size(len(xyz)) if size is None else float(size)
    colours = np.ascontiguousarray(colours[finite], dtype=np.uint8)
    return Points(xyz, colours, size, layer, f"{len(xyz):,} {name}")


def _faces(
    triangles: np.ndarray,
    colour: str,
    layer: str,
    opacity: float,
    name: str = "",
    *,
    shaded: bool = True,
) -> Faces:
    colours = np.tile(rgb_bytes(colour), (len(triangles), 1))
    if shaded:
        colours = solids.shaded_colours(triangles, colours)
    return Faces(triangles, colours, opacity, layer, name)


def _label_above(points: np.ndarray, text: str, layer: str) -> Label:
    middle = np.median(points[:, :2], axis=0)
    return Label(np.array([*middle, points[:, 2].max() + LABEL_RISE]), text, layer)


def _colours_of_values(values: np.ndarray) -> np.ndarray:
    """Return colours (n, 3) for values; the colour scale covers percentiles 1 to 99."""
    finite = values[np.isfinite(values)]
    low, high = np.percentile(finite, [1, 99]) if len(finite) else (0.0, 1.0)
    shares = (values - low) / (high - low if high > low else 1.0)
    return COLOURS(np.ma.masked_invalid(shares), bytes=True)[:, :3]


def _as_corners(corners: ArrayLike) -> np.ndarray:
    """Return boxes as a float array (N, 8, 3), or raise ValueError with the expected shape."""
    try:
        corners = np.asarray(corners, dtype=float)
    except (TypeError, ValueError):
        corners = np.empty((1, 1))
    if corners.size == 0 and corners.shape[0] == 0:
        return np.empty((0, 8, 3))
    if corners.ndim != 3 or corners.shape[1:] != (8, 3):
        raise ValueError(
            "Boxes must have shape (N, 8, 3), with eight corners (x, y, z) per box; "
            f"yours have {corners.shape}."
        )
    return corners
