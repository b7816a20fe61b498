"""Solids that a ray can hit: convex polyhedra, upright cylinders and spheres.

Every ray starts at the origin of the coordinates in which the solid is given. A solid is therefore
first moved into the sensor's frame, and then computes where the rays enter and leave it. The rays
are an array (3, ...) of unit directions; results have the shape of the trailing axes.

References
----------
T. L. Kay and J. T. Kajiya, "Ray tracing complex scenes", SIGGRAPH 1986 (the slab method).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from utils.simulator.bounds import (
    disc_azimuths,
    elevation_limits,
    polygon_azimuths,
    polygon_distance,
)
from utils.simulator.pose import Pose


@dataclass(frozen=True)
class Material:
    """Optical properties of a surface.

    Parameters
    ----------
    reflectivity : float
        Diffuse reflectivity, 0 to 1; retro-reflecting foil also has a value near 1.
    loss : float
        Share of pulses that are lost at any distance (glass, chrome).
    depth : float
        Mean free path in metres inside a porous solid such as foliage; 0 is opaque.
    """

    reflectivity: float = 0.3
    loss: float = 0.0
    depth: float = 0.0


@dataclass(frozen=True, eq=False)
class Convex:
    """The convex polyhedron {x : normals @ x <= offsets}.

    Parameters
    ----------
    normals : ndarray, shape (p, 3)
        Unit normals pointing outwards.
    offsets : ndarray, shape (p,)
        Signed distance of each face from the origin, in metres.
    corners : ndarray, shape (k, 3)
        Vertices in metres, used to select the rays that may hit the shape.
    material : Material
    """

    normals: np.ndarray
    offsets: np.ndarray
    corners: np.ndarray
    material: Material = Material()

    def moved(self, pose: Pose) -> Convex:
        """Return the solid with its own frame placed at `pose`."""
        normals = pose.rotate(self.normals)
        offsets = self.offsets + normals @ (pose.x, pose.y, pose.z)
        return replace(self, normals=normals, offsets=offsets, corners=pose.apply(self.corners))

    def crossings(self, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute where rays enter and leave the solid.

        Returns
        -------
        enter, leave, cosine : ndarray, shape rays.shape[1:]
            Distances in metres, and cosine of the angle of incidence at entry. A ray misses the
            solid if ``enter > leave``, and starts inside or beyond it if ``enter <= 0``.
        """
        enter = np.full(rays.shape[1:], -np.inf)
        leave = np.full(rays.shape[1:], np.inf)
        cosine = np.zeros(rays.shape[1:])
        with np.errstate(divide="ignore", invalid="ignore"):
            for normal, offset in zip(self.normals.tolist(), self.offsets.tolist(), strict=True):
                facing = _dot(normal, rays)
                distance = offset / facing
                if offset > 0:  # rays start on the inner side and can only leave
                    np.copyto(leave, distance, where=(facing > 0) & (distance < leave))
                else:
                    later = (facing < 0) & (distance > enter)
                    np.copyto(enter, distance, where=later)
                    np.copyto(cosine, -facing, where=later)
                    np.copyto(leave, -np.inf, where=facing >= 0)
        return enter, leave, cosine

    def azimuths(self) -> tuple[float, float]:
        """Return the first and last azimuth, in radians, of rays that may hit the shape."""
        return polygon_azimuths(self.corners[:, :2].tolist())

    def elevations(self) -> tuple[float, float]:
        """Return the lowest and highest elevation, in radians, of rays that may hit the shape."""
        corners = self.corners.tolist()
        nearest = polygon_distance([(x, y) for x, y, _ in corners])
        farthest = max(math.hypot(x, y) for x, y, _ in corners)
        heights = [z for _, _, z in corners]
        return elevation_limits(min(heights), max(heights), nearest, farthest)


def _dot(normal: list[float], rays: np.ndarray) -> np.ndarray:
    """Multiply a normal by rays (3, ...), skipping components of the normal that are zero."""
    terms = [part * axis for part, axis in zip(normal, rays, strict=True) if part]
    # Adding zero turns -0.0 into +0.0, so that the sign for a ray along a face is defined.
    return sum(terms[1:], start=terms[0]) + 0.0


@dataclass(frozen=True, eq=False)
class Cylinder:
    """An upright cylinder with the centre of its base (3,), radius and height in metres."""

    base: np.ndarray
    radius: float
    height: float
    material: Material = Material()

    def moved(self, pose: Pose) -> Cylinder:
        """Return the solid with its own frame placed at `pose`."""
        return replace(self, base=pose.apply(self.base))

    def crossings(self, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute where rays enter and leave the solid; see `Convex.crossings`."""
        x, y, z = self.base.tolist()
        with np.errstate(divide="ignore", invalid="ignore"):
            flat = rays[0] ** 2 + rays[1] ** 2
            along = rays[0] * x + rays[1] * y
            discriminant = along**2 - flat * (x * x + y * y - self.radius**2)
            root = np.sqrt(np.maximum(discriminant, 0.0))
            side_in = (along - root) / flat
            side_out = np.where(discriminant < 0, -np.inf, (along + root) / flat)
            vertical = rays[2] + 0.0
            floor, roof = z / vertical, (z + self.height) / vertical
        cap_in, cap_out = np.minimum(floor, roof), np.maximum(floor, roof)
        cosine = np.where(side_in >= cap_in, root / self.radius, np.abs(rays[2]))
        return np.maximum(side_in, cap_in), np.minimum(side_out, cap_out), cosine

    def azimuths(self) -> tuple[float, float]:
        """Return the first and last azimuth, in radians, of rays that may hit the shape."""
        return disc_azimuths(self.base, self.radius)

    def elevations(self) -> tuple[float, float]:
        """Return the lowest and highest elevation, in radians, of rays that may hit the shape."""
        x, y, z = self.base.tolist()
        reach = math.hypot(x, y)
        return elevation_limits(
            z, z + self.height, max(reach - self.radius, 0.0), reach + self.radius
        )


@dataclass(frozen=True, eq=False)
class Sphere:
    """A ball with centre (3,) and radius in metres."""

    centre: np.ndarray
    radius: float
    material: Material = Material()

    def moved(self, pose: Pose) -> Sphere:
        """Return the solid with its own frame placed at `pose`."""
        return replace(self, centre=pose.apply(self.centre))

    def crossings(self, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Compute where rays enter and leave the solid; see `Convex.crossings`."""
        x, y, z = self.centre.tolist()
        along = rays[0] * x + rays[1] * y + rays[2] * z
        discriminant = along**2 - (x * x + y * y + z * z - self.radius**2)
        root = np.sqrt(np.maximum(discriminant, 0.0))
        leave = np.where(discriminant < 0, -np.inf, along + root)
        return along - root, leave, root / self.radius

    def azimuths(self) -> tuple[float, float]:
        """Return the first and last azimuth, in radians, of rays that may hit the shape."""
        return disc_azimuths(self.centre, self.radius)

    def elevations(self) -> tuple[float, float]:
        """Return the lowest and highest elevation, in radians, of rays that may hit the shape."""
        x, y, z = self.centre.tolist()
        reach = math.hypot(x, y)
        return elevation_limits(
            z - self.radius, z + self.radius, max(reach - self.radius, 0.0), reach + self.radius
        )


Solid = Convex | Cylinder | Sphere


def box(
    length: float,
    width: float,
    height: float,
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0),
    material: Material = Material(),  # noqa: B008 (frozen, so safe to share)
    taper: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Convex:
    """Build a box, or a frustum whose roof is smaller than its floor.

    Parameters
    ----------
    length, width, height : float
        Extents of the floor along x and y, and the height, in metres.
    centre : tuple of float
        Centre of the box, halfway up, in metres.
    material : Material
    taper : tuple of float
        Distance of the roof's front, rear and two side edges from the floor's, inwards in metres.
        A windscreen leans by ``taper[0]``, a rear window by ``taper[1]``.
    """
    front, rear, side = taper
    x, y, z = length / 2, width / 2, height / 2
    floor = [(x, y, -z), (-x, y, -z), (-x, -y, -z), (x, -y, -z)]
    roof = [
        (x - front, y - side, z),
        (-x + rear, y - side, z),
        (-x + rear, -y + side, z),
        (x - front, -y + side, z),
    ]
    ahead, behind = _unit(height, front), _unit(height, rear)
    aside = _unit(height, side)
    normals = np.array(
        [
            (ahead[0], 0.0, ahead[1]),
            (-behind[0], 0.0, behind[1]),
            (0.0, aside[0], aside[1]),
            (0.0, -aside[0], aside[1]),
            (0.0, 0.0, 1.0),
            (0.0, 0.0, -1.0),
        ]
    )
    # Each side face contains a corner of the floor, and the roof face a corner of the roof.
    reach = [
        ahead[0] * x - ahead[1] * z,
        behind[0] * x - behind[1] * z,
        aside[0] * y - aside[1] * z,
        aside[0] * y - aside[1] * z,
        z,
        z,
    ]
    return Convex(normals, reach + normals @ centre, np.array(floor + roof) + centre, material)


def _unit(along: float, up: float) -> tuple[float, float]:
    """Scale the vector (along, up) to length 1."""
    length = math.sqrt(along * along + up * up)
    return along / length, up / length


def cylinder(
    radius: float,
    height: float,
    base: tuple[float, float, float] = (0.0, 0.0, 0.0),
    material: Material = Material(),  # noqa: B008
) -> Cylinder:
    """Build an upright cylinder on `base`."""
    return Cylinder(np.array(base, dtype=float), radius, height, material)


def sphere(
    radius: float,
    centre: tuple[float, float, float],
    material: Material = Material(),  # noqa: B008
) -> Sphere:
    """Build a ball around `centre`."""
    return Sphere(np.array(centre, dtype=float), radius, material)
