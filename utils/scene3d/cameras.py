"""Cameras for viewing a scene, and the projection of points into the picture."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

VIEW_ANGLE = 49.13
"""Vertical field of view in degrees, as in the viewer of the Point Cloud Library."""

NEAREST = 0.05
"""Near clipping distance: parts closer to the camera, in metres, are not drawn."""


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in the coordinates of the cloud.

    Parameters
    ----------
    position, target : tuple of float
        Position of the camera, and the point that it looks at, in metres.
    up : tuple of float
        Direction that is upwards in the picture.
    view_angle : float
        Vertical field of view in degrees.
    seen_from : str
        Description of the viewpoint, for the alternative text of a picture.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    view_angle: float = VIEW_ANGLE
    seen_from: str = "from a custom viewpoint"

    def farther(self, factor: float) -> Camera:
        """Return a camera with the same target at `factor` times the distance."""
        offset = np.subtract(self.position, self.target) * factor
        return replace(self, position=tuple((self.target + offset).tolist()))

    def axes(self) -> np.ndarray:
        """Return the unit vectors to the right, upwards and forward, as rows of an array (3, 3)."""
        forward = np.subtract(self.target, self.position).astype(float)
        right = np.cross(forward, self.up)
        if not np.isfinite(forward).all() or not np.linalg.norm(right) > 0:
            raise ValueError(
                "The position and target of a camera must differ, and up must not be parallel to "
                f"the line between them; yours has position {self.position}, target "
                f"{self.target} and up {self.up}."
            )
        rows = np.stack([right, np.cross(right, forward), forward])
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def to_camera(self, points: np.ndarray) -> np.ndarray:
        """Return points in camera coordinates (..., 3): right, up and forward, in metres."""
        return (np.asarray(points, dtype=float) - self.position) @ self.axes().T

    def to_pixels(self, points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """Return pixel coordinates (..., 2), to the right and down, for the result of `to_camera`.

        The points must be in front of the camera.
        """
        width, height = size
        focal = height / 2 / np.tan(np.radians(self.view_angle) / 2)
        ahead = np.maximum(points[..., 2:], NEAREST)
        return points[..., :2] / ahead * (focal, -focal) + (width / 2, height / 2)


CAMERAS: dict[str, Camera] = {
    "XY": Camera((-16.0, -16.0, 16.0), (1.0, 1.0, 0.0), seen_from="from behind, right and above"),
    "TopDown": Camera(
        (0.0, 0.0, 16.0), (1.0, 0.0, 1.0), (1.0, 0.0, 0.0), seen_from="from above, forward is up"
    ),
    "Side": Camera((0.0, -16.0, 0.0), (0.0, 0.0, 1.0), seen_from="from the right-hand side"),
    "FPS": Camera((-10.0, 0.0, 0.0), (0.0, 0.0, 1.0), seen_from="along the road from behind"),
}
"""The four cameras of the Udacity course, which are near the sensor and show only nearby cars."""


def as_camera(camera: str | Camera) -> Camera:
    """Return a camera that is given as a `Camera` or by name, ignoring case."""
    if isinstance(camera, Camera):
        return camera
    for name, preset in CAMERAS.items():
        if str(camera).lower() == name.lower():
            return preset
    raise ValueError(
        f"There is no camera {camera!r}. Choose one of "
        f"{', '.join(CAMERAS)}, or create your own: Camera(position, target)."
    )


def clip_to_front(ends: np.ndarray) -> np.ndarray:
    """Clip segments (m, 2, 3) in camera coordinates to the part in front of the camera.

    Segments that are entirely behind the camera are dropped.
    """
    ahead = ends[:, :, 2] - NEAREST
    kept = (ahead > 0).any(axis=1)
    ends, ahead = ends[kept].copy(), ahead[kept]
    for behind, in_front in ((0, 1), (1, 0)):
        rows = np.flatnonzero(ahead[:, behind] < 0)
        share = ahead[rows, in_front] / (ahead[rows, in_front] - ahead[rows, behind])
        step = ends[rows, behind] - ends[rows, in_front]
        ends[rows, behind] = ends[rows, in_front] + share[:, None] * step
    return ends
