"""The class `Scene`: parts of a street, layers to turn on and off, and ways to show them."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from utils.plots.style import BLUE
from utils.scene3d import builders, output
from utils.scene3d.cameras import Camera
from utils.scene3d.parts import LAYERS, Part, Points, Segments

if TYPE_CHECKING:
    from utils.visits import Node

EGO_MINIMUM, EGO_MAXIMUM = (-1.5, -1.7, -1.0), (2.6, 1.7, -0.4)
"""Two opposite corners of the region, in metres, where a 64-beam sensor hits the ego car's roof."""

SIZE = (960, 540)


class Scene:
    """A street in three dimensions, built part by part.

    Each method ``add_...`` returns the scene, so that calls can be chained. It adds parts on a
    layer that `switch` turns on and off. Coordinates are the same as in the cloud: in metres, with
    x forward, y left, z up and the sensor at the origin.

    Parameters
    ----------
    title : str
        Text above the picture.
    alt : str
        Text alternative for readers who cannot see the picture; by default made from the parts.

    Attributes
    ----------
    caption : str
        Text below the picture, such as the number of the frame.
    switches : dict of str to bool
        For each layer, whether it is on.

    Examples
    --------
    >>> scene = Scene("The street").add_cloud(cloud).add_boxes(corners, names=True)
    >>> scene.show()                   # a picture
    >>> scene.show(interactive=True)   # a view to rotate and zoom
    """

    def __init__(self, title: str = "", *, alt: str = "") -> None:
        self.title = title
        self.alt = alt
        self.caption = ""
        self.switches = dict.fromkeys(LAYERS, True)
        self._parts: list[Part] = []

    @property
    def all_parts(self) -> tuple[Part, ...]:
        """All parts, in the order in which they were added."""
        return tuple(self._parts)

    @property
    def parts(self) -> tuple[Part, ...]:
        """The parts whose layers are on."""
        return tuple(part for part in self._parts if self.switches[part.layer])

    def switch(self, **layers: bool) -> Scene:
        """Turn layers on and off: ``scene.switch(clusters=False, boxes=True)``.

        Raises
        ------
        ValueError
            A layer does not exist; the message lists all layers.
        """
        for name in layers:
            _check_layer(name)
        self.switches.update({name: bool(on) for name, on in layers.items()})
        return self

    def only(self, *layers: str) -> Scene:
        """Turn these layers on and all others off; see `switch`."""
        return self.switch(**dict.fromkeys(LAYERS, False) | dict.fromkeys(layers, True))

    # Adding parts --------------------------------------------------------------------------

    def add_cloud(
        self,
        cloud: ArrayLike,
        *,
        values: ArrayLike | None = None,
        colour: str | None = None,
        size: float | None = None,
        layer: str = "data_points",
        name: str = "",
    ) -> Scene:
        """Add the points of a cloud.

        Parameters
        ----------
        cloud : (n, 3) or (n, 4) array_like of float
            In metres. Rows with a non-finite coordinate are left out.
        values : (n,) array_like of float, optional
            Values to colour the points by; the height by default.
        colour : str, optional
            One colour for all points, such as "#0072B2".
        size : float, optional
            Width of a dot in pixels; by default, it shrinks as the number of points grows.
        layer : str
            Name of a layer, such as "data_points" or "filtered_cloud".
        name : str
            Entry in the legend; the number of points is added.
        """
        _check_layer(layer)
        return self._add(builders.cloud_parts(cloud, values, colour, size, layer, name))

    def add_plane(
        self, cloud: ArrayLike, plane: Sequence[float] | np.ndarray | None = None
    ) -> Scene:
        """Add the points of a plane (green) and, given (a, b, c, d), a patch of the plane."""
        return self._add(builders.plane_parts(cloud, plane))

    def add_obstacles(self, cloud: ArrayLike) -> Scene:
        """Add the points of obstacles on the road (red)."""
        return self._add(
            builders.cloud_parts(cloud, None, builders.VERMILION, None, "obstacle_cloud", "")
        )

    def add_clusters(self, cloud: ArrayLike, labels: ArrayLike, *, names: bool = True) -> Scene:
        """Add points in the colours of their clusters, with labels at the twelve biggest clusters.

        Parameters
        ----------
        cloud : (n, 3) or (n, 4) array_like of float
            In metres.
        labels : (n,) array_like of int
            1 and above for clusters; 0 (or less) for noise, which is pale and small.
        names : bool
            Whether to write the labels.
        """
        return self._add(builders.cluster_parts(cloud, labels, names))

    def add_kd_tree(
        self,
        root: Node | None,
        minimum: ArrayLike | None = None,
        maximum: ArrayLike | None = None,
        *,
        depth: int = 3,
    ) -> Scene:
        """Add the planes along which the first levels of a kd-tree cut a region.

        Parameters
        ----------
        root : node or None
            An object with `point`, `left` and `right`; points have two or three coordinates.
        minimum, maximum : (3,) array_like of float, optional
            Two opposite corners of the region in metres; by default the region of the points added
            so far.
        depth : int
            Number of levels to draw; each has up to twice as many planes as the previous one.
        """
        low, high = self._extent()
        low = low if minimum is None else minimum
        high = high if maximum is None else maximum
        return self._add(builders.kd_parts(root, low, high, depth))

    def add_rays(
        self, cloud: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0), *, most: int = 1_000
    ) -> Scene:
        """Add the rays from the sensor at `origin` to its returns, at most `most` of them."""
        return self._add(builders.ray_parts(cloud, origin, most))

    def add_boxes(
        self,
        corners: ArrayLike,
        *,
        names: bool | Sequence[str | int] | None = None,
        reference: bool = False,
        name: str = "",
    ) -> Scene:
        """Add axis-aligned boxes (red).

        Parameters
        ----------
        corners : (N, 8, 3) array_like of float
            The eight corners of each box in metres, in any order. Boxes with a non-finite corner
            are left out.
        names : bool or sequence of str or int
            Names to write above the boxes; True for the row numbers.
        reference : bool
            Draw dashed grey lines, for true boxes or the previous frame's boxes.
        name : str
            Entry in the legend; the number of boxes is added.
        """
        return self._add(builders.box_parts(corners, names, reference, name, "boxes"))

    def add_oriented_boxes(
        self,
        corners: ArrayLike,
        *,
        names: bool | Sequence[str | int] | None = None,
        reference: bool = False,
        name: str = "",
    ) -> Scene:
        """Add boxes that are rotated about z (blue, with thicker lines); see `add_boxes`."""
        return self._add(builders.box_parts(corners, names, reference, name, "oriented_boxes"))

    def add_trails(self, trails: Iterable[ArrayLike]) -> Scene:
        """Add one line per object, through its past positions (m, 3) in metres, oldest first."""
        return self._add(builders.trail_parts(trails))

    def add_ego_car(
        self, minimum: Iterable[float] = EGO_MINIMUM, maximum: Iterable[float] = EGO_MAXIMUM
    ) -> Scene:
        """Add the box of the car that carries the sensor (magenta)."""
        return self._add(builders.ego_parts(minimum, maximum))

    def add_road(self, height: float = 2.6, *, length: float = 50.0, width: float = 12.0) -> Scene:
        """Add a straight road with lane lines, `height` metres below the sensor."""
        return self._add(builders.road_parts(height, length, width))

    def add_cars(self, corners: ArrayLike, *, colour: str = BLUE) -> Scene:
        """Add a car made of blocks for each box (N, 8, 3), with its length along the longer side.

        The corners are in metres.
        """
        return self._add(builders.car_parts(corners, colour))

    def add_lines(self, ends: ArrayLike, *, colour: str, width: float = 2.0, name: str) -> Scene:
        """Add straight lines (m, 2, 3) in metres, `width` pixels wide."""
        ends = np.asarray(ends, dtype=float)
        return self._add([Segments(ends, colour, width, "scene", name)])

    # Showing and saving --------------------------------------------------------------------

    def picture(
        self,
        camera: str | Camera = "XY",
        *,
        size: tuple[int, int] = SIZE,
        renderer: str | None = None,
    ) -> np.ndarray:
        """Draw the scene and return the image.

        Parameters
        ----------
        camera : {"XY", "TopDown", "Side", "FPS"} or Camera
        size : (int, int)
            Width and height in pixels.
        renderer : {"pyvista", "matplotlib"}, optional
            By default PyVista if it can draw here, or else matplotlib.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            Red, green and blue.
        """
        return output.picture_of(self, camera, size, renderer)

    def show(
        self,
        camera: str | Camera = "XY",
        *,
        interactive: bool = False,
        size: tuple[int, int] = SIZE,
        renderer: str | None = None,
        alt: str = "",
    ) -> None:
        """Show the scene in a notebook or, outside notebooks, in a window on the screen.

        Parameters
        ----------
        camera, size, renderer
            See `picture`.
        interactive : bool
            In a notebook, show a view to rotate and zoom with mouse, finger or keyboard. It has
            about 20 000 points at most. It needs no server and also works in a saved notebook.
        alt : str
            Text alternative for readers who cannot see the picture; by default from `describe`.
        """
        output.show(self, camera, interactive, size, renderer, alt)

    def save(
        self, path: str | os.PathLike, camera: str | Camera = "XY", *, size: tuple[int, int] = SIZE
    ) -> Path:
        """Save a picture (.png, .jpg, .jpeg, .webp) or the interactive view (.html); return `path`.

        `size` is the width and height of a picture in pixels.
        """
        return output.save(self, path, camera, size)

    def draw(self, camera: str | Camera = "XY", *, axes: Axes | None = None) -> Axes:
        """Draw with matplotlib into `axes` or into a new figure, and return the axes."""
        from utils.scene3d.with_matplotlib import draw

        return draw(self, camera, axes)

    def describe(self, camera: str | Camera = "XY") -> str:
        """Return a text alternative for a picture: `alt`, or else a list of the visible parts."""
        return output.describe(self, camera)

    def _repr_mimebundle_(
        self, include: Iterable[str] | None = None, exclude: Iterable[str] | None = None
    ) -> dict[str, str]:
        return output.bundle_of(self, "XY", False, SIZE, None, "")

    def _add(self, parts: list[Part]) -> Scene:
        self._parts += parts
        return self

    def _extent(self) -> tuple[np.ndarray, np.ndarray]:
        clouds = [part.xyz for part in self._parts if isinstance(part, Points) and len(part.xyz)]
        if not clouds:
            return np.full(3, -10.0), np.full(3, 10.0)
        points = np.concatenate(clouds).astype(float)
        return points.min(axis=0), points.max(axis=0)


def _check_layer(name: str) -> None:
    if name not in LAYERS:
        raise ValueError(f"There is no layer {name!r}. Choose one of {', '.join(LAYERS)}.")
