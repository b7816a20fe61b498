"""Where a scene is looked at from, and where its points then lie in the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

VIEW_ANGLE = 49.13
"""Degrees from the lower to the upper edge: what the viewer of the Point Cloud Library shows."""

NEAREST = 0.05
"""Metres in front of the camera from which on things are drawn."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in the coordinates of the cloud.

    Parameters
    ----------
    position, target : tuple of float
        Where it stands and what it looks at, in metres.
    up : tuple of float
        The direction that is upwards in the picture.
    view_angle : float
        Degrees from the lower to the upper edge of the picture.
    seen_from : str
        In words, for those who cannot see the picture.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    view_angle: float = VIEW_ANGLE
    seen_from: str = "from a place of its own"

    def farther(self, factor: float) -> Camera:
        """The same view from `factor` times the distance; below 1 it comes nearer."""
        offset = np.subtract(self.position, self.target) * factor
        return replace(self, position=tuple((self.target + offset).tolist()))

    def axes(self) -> np.ndarray:
        """Unit vectors to the right, upwards and forward, as rows of an array (3, 3)."""
        forward = np.subtract(self.target, self.position).astype(float)
        right = np.cross(forward, self.up)
        if not np.isfinite(forward).all() or not np.linalg.norm(right) > 0:
            raise ValueError(
                "A camera needs a position, a target elsewhere, and an upward direction that is "
                f"not the line between them; yours stands at {self.position}, looks at "
                f"{self.target} and has {self.up} upwards."
            )
        rows = np.stack([right, np.cross(right, forward), forward])
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def seen(self, points: np.ndarray) -> np.ndarray:
        """Metres to the right, upwards and forward of the camera, shape (..., 3)."""
        return (np.asarray(points, dtype=float) - self.position) @ self.axes().T

    def placed(self, seen: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """Pixels (..., 2), across and down, of what `seen` returned for points in front."""
        width, height = size
        focal = height / 2 / np.tan(np.radians(self.view_angle) / 2)
        ahead = np.maximum(seen[..., 2:], NEAREST)
        return seen[..., :2] / ahead * (focal, -focal) + (width / 2, height / 2)


CAMERAS: dict[str, Camera] = {
    "XY": Camera((-16.0, -16.0, 16.0), (1.0, 1.0, 0.0), seen_from="from behind, right and above"),
    "TopDown": Camera(
        (0.0, 0.0, 16.0), (1.0, 0.0, 1.0), (1.0, 0.0, 0.0), seen_from="from above, forward is up"
    ),
    "Side": Camera((0.0, -16.0, 0.0), (0.0, 0.0, 1.0), seen_from="from the right-hand side"),
    "FPS": Camera((-10.0, 0.0, 0.0), (0.0, 0.0, 1.0), seen_from="along the road from behind"),
}
"""The four cameras of the Udacity course; at a distance of 16 m they show the cars near by."""


def as_camera(camera: str | Camera) -> Camera:
    """A camera, given itself or by its name in any case."""
    if isinstance(camera, Camera):
        return camera
    for name, known in CAMERAS.items():
        if str(camera).lower() == name.lower():
            return known
    raise ValueError(
        f"There is no camera {camera!r}. There are: {', '.join(CAMERAS)}; "
        "or make your own: Camera(position, target)."
    )


def cut_off(ends: np.ndarray) -> np.ndarray:
    """Shorten seen segments (m, 2, 3) to what lies in front of the camera; drop the others."""
    ahead = ends[:, :, 2] - NEAREST
    kept = (ahead > 0).any(axis=1)
    ends, ahead = ends[kept].copy(), ahead[kept]
    for behind, other in ((0, 1), (1, 0)):
        rows = np.flatnonzero(ahead[:, behind] < 0)
        share = ahead[rows, other] / (ahead[rows, other] - ahead[rows, behind])
        step = ends[rows, behind] - ends[rows, other]
        ends[rows, behind] = ends[rows, other] + share[:, None] * step
    return ends
