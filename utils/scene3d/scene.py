"""The scene: what is in it, which of it is switched on, and how it is shown."""

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
"""Where the roof of the ego car returns echoes to a 64-beam sensor above it, in metres."""

SIZE = (960, 540)


class Scene:
    """A street in three dimensions, put together part by part.

    Every ``add_...`` returns the scene, so that calls can be chained, and puts its part on a
    layer that `switch` turns on and off. Coordinates are those of the cloud: metres, x forward,
    y left, z up, the sensor at the origin.

    Parameters
    ----------
    title : str
        Written above the picture.
    alt : str
        What the picture shows, for those who cannot see it; made from the parts when empty.

    Attributes
    ----------
    caption : str
        A line below the picture: what changes from frame to frame.
    switches : dict of str to bool
        Which layers are on.

    Examples
    --------
    >>> scene = Scene("The street").add_cloud(cloud).add_boxes(corners, names=True)
    >>> scene.show()                   # a picture
    >>> scene.show(interactive=True)   # one to turn and zoom
    """

    def __init__(self, title: str = "", *, alt: str = "") -> None:
        self.title = title
        self.alt = alt
        self.caption = ""
        self.switches = dict.fromkeys(LAYERS, True)
        self._parts: list[Part] = []

    @property
    def all_parts(self) -> tuple[Part, ...]:
        """What was added, in that order."""
        return tuple(self._parts)

    @property
    def parts(self) -> tuple[Part, ...]:
        """What was added and is switched on."""
        return tuple(part for part in self._parts if self.switches[part.layer])

    def switch(self, **layers: bool) -> Scene:
        """Turn layers on and off: ``scene.switch(clusters=False, boxes=True)``.

        Raises
        ------
        ValueError
            There is no such layer; the message names them all.
        """
        for name in layers:
            _check_layer(name)
        self.switches.update({name: bool(on) for name, on in layers.items()})
        return self

    def only(self, *layers: str) -> Scene:
        """Turn these layers on and all others off; see `switch`."""
        return self.switch(**dict.fromkeys(LAYERS, False) | dict.fromkeys(layers, True))

    # What can be added ---------------------------------------------------------------------

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
            What the colour shows; the height by default.
        colour : str, optional
            One colour for all points, such as "#0072B2".
        size : float, optional
            Pixels of a dot; by default smaller the more points there are.
        layer : str
            "data_points", "filtered_cloud" or another of the scene's layers.
        name : str
            For the legend, where the number of points is added.
        """
        _check_layer(layer)
        return self._add(builders.cloud_parts(cloud, values, colour, size, layer, name))

    def add_plane(
        self, cloud: ArrayLike, plane: Sequence[float] | np.ndarray | None = None
    ) -> Scene:
        """Add the points of the road (green) and, given (a, b, c, d), a piece of that plane."""
        return self._add(builders.plane_parts(cloud, plane))

    def add_obstacles(self, cloud: ArrayLike) -> Scene:
        """Add the points of what stands on the road (red)."""
        return self._add(
            builders.cloud_parts(cloud, None, builders.VERMILION, None, "obstacle_cloud", "")
        )

    def add_clusters(self, cloud: ArrayLike, labels: ArrayLike, *, names: bool = True) -> Scene:
        """Add points in the colour of their cluster; the twelve biggest also carry their label.

        Parameters
        ----------
        cloud : (n, 3) or (n, 4) array_like of float
        labels : (n,) array_like of int
            1 and above for clusters; 0 (or less) for noise, which is pale and small.
        names : bool
            Write the labels.
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
        """Add the planes in which the first levels of a kd-tree cut a region.

        Parameters
        ----------
        root : node or None
            With `point`, `left` and `right`; two or three dimensions.
        minimum, maximum : (3,) array_like of float, optional
            The region in metres; by default what holds the points added so far.
        depth : int
            Levels to draw; each has twice as many planes as the one before.
        """
        low, high = self._extent()
        low = low if minimum is None else minimum
        high = high if maximum is None else maximum
        return self._add(builders.kd_parts(root, low, high, depth))

    def add_rays(
        self, cloud: ArrayLike, origin: ArrayLike = (0.0, 0.0, 0.0), *, most: int = 1_000
    ) -> Scene:
        """Add the rays from the sensor to its returns, at most `most` of them."""
        return self._add(builders.ray_parts(cloud, origin, most))

    def add_boxes(
        self,
        corners: ArrayLike,
        *,
        names: bool | Sequence[str | int] | None = None,
        reference: bool = False,
        name: str = "",
    ) -> Scene:
        """Add regular boxes.

        Parameters
        ----------
        corners : (N, 8, 3) array_like of float
            Eight corners of each box in metres, in any order. Boxes with a non-finite corner are
            left out.
        names : bool or sequence of str or int
            Written above each box; True for its row number.
        reference : bool
            Dashed and grey, for true boxes or those of the frame before.
        name : str
            For the legend, where the number of boxes is added.
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
        """Add boxes turned about z, with thicker lines; see `add_boxes`."""
        return self._add(builders.box_parts(corners, names, reference, name, "oriented_boxes"))

    def add_trails(self, trails: Iterable[ArrayLike]) -> Scene:
        """Add the way that each thing came: for each its places (m, 3), oldest first, in metres."""
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
        """Add a block car into each box (N, 8, 3), its length along the longer side."""
        return self._add(builders.car_parts(corners, colour))

    def add_lines(self, ends: ArrayLike, *, colour: str, width: float = 2.0, name: str) -> Scene:
        """Add straight lines (m, 2, 3) in metres, `width` pixels wide."""
        ends = np.asarray(ends, dtype=float)
        return self._add([Segments(ends, colour, width, "scene", name)])

    # How it is shown -----------------------------------------------------------------------

    def picture(
        self,
        camera: str | Camera = "XY",
        *,
        size: tuple[int, int] = SIZE,
        renderer: str | None = None,
    ) -> np.ndarray:
        """Draw the scene.

        Parameters
        ----------
        camera : {"XY", "TopDown", "Side", "FPS"} or Camera
        size : (int, int)
            Width and height in pixels.
        renderer : {"pyvista", "matplotlib"}, optional
            By default PyVista where it can draw, else matplotlib.

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
        """Show the scene in the notebook; outside of one, in a window where there is a screen.

        Parameters
        ----------
        camera, size, renderer
            See `picture`.
        interactive : bool
            A view to turn and zoom, by mouse, finger or keyboard. It holds at most 20 000 points
            and works without a server, in a saved notebook too.
        alt : str
            What the picture shows, for those who cannot see it.
        """
        output.show(self, camera, interactive, size, renderer, alt)

    def save(
        self, path: str | os.PathLike, camera: str | Camera = "XY", *, size: tuple[int, int] = SIZE
    ) -> Path:
        """Write a picture (.png, .jpg, .webp) or the interactive view (.html)."""
        return output.save(self, path, camera, size)

    def draw(self, camera: str | Camera = "XY", *, axes: Axes | None = None) -> Axes:
        """Draw with matplotlib into `axes`, or into a new figure, and return the axes."""
        from utils.scene3d.with_matplotlib import draw

        return draw(self, camera, axes)

    def describe(self, camera: str | Camera = "XY") -> str:
        """Say in a sentence what a picture shows: the scene's `alt`, or what its parts are."""
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
        raise ValueError(f"There is no layer {name!r}. There are: {', '.join(LAYERS)}.")
