"""Renderer based on matplotlib, for machines without PyVista; it draws the same scenes.

Points become an image in which the nearest point is on top. Transparent faces and most edges are
drawn over it, because matplotlib has no depth buffer. Its own 3D axes are not used, because their
camera cannot be inside a cloud.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from utils.plots.style import PAPER, canvas
from utils.scene3d.cameras import NEAREST, Camera, as_camera, clip_to_front
from utils.scene3d.eye_dome import eye_dome
from utils.scene3d.lettering import write
from utils.scene3d.parts import Drawable, Faces, Label, Part, Points, Segments

DOTS_PER_INCH = 100


def picture(scene: Drawable, camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """Draw a scene and return the picture as a uint8 array (height, width, 3)."""
    width, height = size
    figure = Figure(figsize=(width / DOTS_PER_INCH, height / DOTS_PER_INCH), dpi=DOTS_PER_INCH)
    screen = FigureCanvasAgg(figure)
    _draw_parts(figure.add_axes((0, 0, 1, 1)), scene, camera, size)
    screen.draw()
    image = np.asarray(screen.buffer_rgba())[:height, :width, :3].copy()
    return write(image, scene.parts, camera, scene.title, scene.caption)


def draw(scene: Drawable, camera: str | Camera, axes: Axes | None = None) -> Axes:
    """Draw a scene into `axes`, or into the axes of a new figure of notebook width."""
    camera = as_camera(camera)
    axes = canvas(axes)
    box = axes.get_window_extent()
    size = (max(round(box.width), 2), max(round(box.height), 2))
    _draw_parts(axes, scene, camera, size)
    labels = [part for part in scene.parts if isinstance(part, Label)]
    for label in labels:
        seen = camera.to_camera(label.at)
        if seen[2] > NEAREST:
            axes.text(
                *camera.to_pixels(seen, size),
                label.text,
                color=label.colour,
                ha="center",
                fontweight="bold",
                fontsize=9,
                clip_on=True,
                bbox={"facecolor": PAPER, "edgecolor": "none", "alpha": 0.8, "pad": 1},
            )
    axes.set_title(scene.title, loc="left", fontsize=12, fontweight="bold")
    return axes


def _draw_parts(axes: Axes, scene: Drawable, camera: Camera, size: tuple[int, int]) -> None:
    """Draw all parts except labels, in pixel coordinates."""
    axes.set_axis_off()
    parts = scene.parts
    opaque = [part for part in parts if isinstance(part, Faces) and part.opacity == 1.0]
    transparent = [part for part in parts if isinstance(part, Faces) and part.opacity < 1.0]
    _add_faces(axes, opaque, camera, size, 1)
    axes.imshow(
        _image_of_dots(parts, camera, size),
        extent=(0, size[0], size[1], 0),
        zorder=2,
        interpolation="nearest",
        aspect="auto",
    )
    _add_faces(axes, transparent, camera, size, 3)
    for part in parts:
        if isinstance(part, Segments) and len(part.ends):
            lines = camera.to_pixels(clip_to_front(camera.to_camera(part.ends)), size)
            width = part.width * 72 / DOTS_PER_INCH
            axes.add_collection(
                LineCollection(
                    lines,
                    colors=part.colour,
                    linewidths=width,
                    alpha=part.opacity,
                    zorder=1.5 if part.layer == "scene" else 4,
                ),
                autolim=False,
            )
    axes.set(xlim=(0, size[0]), ylim=(size[1], 0))


def _add_faces(
    axes: Axes, parts: list[Faces], camera: Camera, size: tuple[int, int], zorder: float
) -> None:
    """Draw triangles, the farthest first, and leave out those that reach behind the camera."""
    kept = [part for part in parts if len(part.triangles)]
    if not kept:
        return
    triangles = camera.to_camera(np.concatenate([part.triangles for part in kept]))
    colours = np.concatenate(
        [
            np.column_stack([part.colours / 255, np.full(len(part.colours), part.opacity)])
            for part in kept
        ]
    )
    shown = np.flatnonzero((triangles[:, :, 2] > NEAREST).all(axis=1))
    shown = shown[np.argsort(-triangles[shown, :, 2].mean(axis=1))]
    axes.add_collection(
        PolyCollection(
            camera.to_pixels(triangles[shown], size),
            facecolors=colours[shown],
            edgecolors="none",
            antialiased=False,
            zorder=zorder,
        ),
        autolim=False,
    )


def _image_of_dots(parts: Iterable[Part], camera: Camera, size: tuple[int, int]) -> np.ndarray:
    """Return an image (height, width, 4) of all points, with a transparent background."""
    width, height = size
    image = np.zeros((height, width, 3), dtype=np.uint8)
    depth = np.full((height, width), np.inf, dtype=np.float32)
    for part in parts:
        if not isinstance(part, Points) or not len(part.xyz):
            continue
        seen = camera.to_camera(part.xyz)
        rows = np.flatnonzero(seen[:, 2] > NEAREST)
        places = camera.to_pixels(seen[rows], size)
        # The nearest points come last, because the last value assigned to a pixel remains.
        order = np.argsort(-seen[rows, 2], kind="stable")
        rows, places = rows[order], np.floor(places[order] - (part.size - 1) / 2).astype(int)
        ahead = seen[rows, 2].astype(np.float32)
        for shift in np.ndindex(int(part.size), int(part.size)):
            across, down = (places + shift).T
            inside = (across >= 0) & (across < width) & (down >= 0) & (down < height)
            inside[inside] = ahead[inside] < depth[down[inside], across[inside]]
            depth[down[inside], across[inside]] = ahead[inside]
            image[down[inside], across[inside]] = part.colours[rows[inside]]
    covered = np.where(np.isfinite(depth), 255, 0).astype(np.uint8)
    return np.dstack([eye_dome(image, depth), covered])
