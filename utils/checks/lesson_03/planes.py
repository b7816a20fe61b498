"""Functions that convert, compare, print and draw planes for the checks of lesson 03.

Four numbers and their negatives describe the same plane, so all functions here accept both. Only
`assert_unit_normal` tests the length of the normal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.assertions import CheckFailed, WrongForm, as_array, brief_text, frozen, point_text
from utils.checks.diagnosis import same_array
from utils.checks.failures import fixed
from utils.geometry import with_unit_normal

if TYPE_CHECKING:
    from matplotlib.axes import Axes


# Triangles on a level road, on a wall, on a slope, on a plane through the sensor and far away.
TRIANGLES = frozen(
    np.array(
        [
            [[4.0, 1.0, -1.7], [9.0, -2.0, -1.7], [6.0, 3.0, -1.7]],
            [[2.0, 5.0, 0.0], [8.0, 5.0, 1.0], [5.0, 5.0, -1.5]],
            [[0.0, 0.0, -1.0], [10.0, 0.0, 1.0], [3.0, 4.0, -2.0]],
            [[0.0, 0.0, 0.0], [3.0, 1.0, 0.5], [-2.0, 4.0, 1.0]],
            [[61.0, -40.0, 2.0], [64.0, -39.0, 2.5], [62.0, -35.0, -1.0]],
        ]
    )
)
LARGE_AND_SMALL = frozen(
    np.array(
        [
            [[0.0, 0.0, 1.0], [50.0, 0.0, 1.0], [0.0, 40.0, 3.0]],
            [[0.0, 0.0, 1.0], [0.5, 0.0, 1.0], [0.0, 0.4, 1.2]],
        ]
    )
)


def as_plane(answer: object) -> np.ndarray:
    """Convert an answer to the four numbers of a plane, with a normal of any length.

    Returns
    -------
    numpy.ndarray, shape (4,)

    Raises
    ------
    CheckFailed
        If the answer is not four finite numbers, or its normal is (0, 0, 0).
    """
    plane = as_array(answer, description="four numbers (a, b, c, d)")
    if plane.shape != (4,):
        note = " The fourth, d, is missing." if plane.shape == (3,) else ""
        raise WrongForm(
            f"A plane is four numbers (a, b, c, d).{note}",
            yours=f"shape {plane.shape}",
            expected="shape (4,)",
        )
    plane = plane.astype(float)
    if not np.isfinite(plane).all():
        raise CheckFailed("Some of the four numbers are not finite.", yours=brief_text(plane))
    if not plane[:3].any():
        raise CheckFailed(
            fixed("The normal (a, b, c) is (0, 0, 0), which has no direction."),
            yours=plane_text(plane),
        )
    return plane


def assert_unit_normal(answer: object) -> None:
    """Assert that the normal has length 1, whether its direction is right or wrong."""
    plane = as_plane(answer)
    length = np.linalg.norm(plane[:3])
    if abs(length - 1) > 1e-3:
        raise CheckFailed(
            f"The normal (a, b, c) has length {length:.4g}, {fixed('not 1')}.",
            yours=plane_text(plane),
            expected=plane_text(plane / length),
        )


def same_plane(answer: object, predicted: object) -> bool:
    """Return whether an answer equals the predicted four numbers or their negatives."""
    return same_array(answer, predicted) or same_array(answer, -np.asarray(predicted))


def triangle_text(triangle: np.ndarray) -> str:
    """Return three points, shape (3, 3), as text with their names p, q and r."""
    return ", ".join(f"{name} {point_text(p)}" for name, p in zip("pqr", triangle, strict=True))


def expected_text(plane: np.ndarray, expected: np.ndarray) -> str:
    """Return the right plane as text, with the sign that makes it more similar to `plane`."""
    return f"{plane_text(expected if expected[:3] @ plane[:3] >= 0 else -expected)} or its negative"


def plane_text(plane: np.ndarray | None) -> str:
    """Return the four numbers of a plane as text, rounded to three decimals."""
    if plane is None:
        return "None"
    return f"[{', '.join(f'{value:.6g}' for value in np.round(plane, 3) + 0.0)}]"


def draw_edge_on(
    points: np.ndarray,
    plane: np.ndarray,
    inliers: np.ndarray | None,
    tolerance: float | None,
    expected: np.ndarray | None = None,
) -> Axes:
    """Draw points and a plane edge-on, so that the plane appears as a line.

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)
    plane : numpy.ndarray, shape (4,)
    inliers : numpy.ndarray of bool, shape (n,), or None
        Points to highlight.
    tolerance : float or None
        Half the width of the band around the plane, in metres.
    expected : numpy.ndarray, shape (4,), optional
        The right plane, which is drawn as a level line.
    """
    plane = with_unit_normal(plane)
    level = plane if expected is None else expected
    level = level * (1 if level[2] >= 0 else -1)
    plane = plane * (1 if plane[:3] @ level[:3] >= 0 else -1)
    # The direction in which the plane rises above the level plane; any direction in the plane if
    # the two are parallel.
    along = plane[:3] - plane[:3] @ level[:3] * level[:3]
    if np.linalg.norm(along) < 1e-6:
        along = np.linalg.svd(level[None, :3])[2][1]
    along /= np.linalg.norm(along)
    rotation = np.column_stack([along, np.cross(level[:3], along), level[:3]])
    turned_plane = np.append(plane[:3] @ rotation, plane[3])
    turned_points = points[:, :3] @ rotation
    heights = [
        *turned_points[:, 2],
        -level[3],
        *([-plane[3] / turned_plane[2]] if turned_plane[2] > 0.5 else []),
    ]
    limits = [(min(row) - 0.3, max(row) + 0.3) for row in (turned_points[:, 0], heights)]
    axes = utils.plots.plane_model(
        turned_points, turned_plane, inliers, tolerance, title="yours", limits=limits
    )
    axes.set_xlabel("along the plane (m)")
    axes.set_ylabel("along the normal (m), 0 at the sensor")
    if expected is not None:
        axes.axhline(-level[3], color="black", linestyle="--")
        axes.text(axes.get_xlim()[0], -level[3], " expected", va="bottom")
    return axes


def scattered_plane(
    seed: int,
    n_plane: int,
    n_outliers: int,
    plane: ArrayLike | None = None,
    noise: float = 0.01,
    columns: int = 3,
) -> tuple[np.ndarray, np.ndarray]:
    """Return points on a 12 m wide square of a plane, mixed with outliers.

    Parameters
    ----------
    seed : int
        Seed of the random generator.
    n_plane, n_outliers : int
        Number of points on the plane, and of points off it.
    plane : (4,) array_like, optional
        A plane with a unit normal; by default a slope of 11 to 20 degrees that depends on `seed`.
    noise : float
        Standard deviation of the distances between the plane and its points, in metres.
    columns : {3, 4}
        Number of columns; the fourth is an intensity from 0 to 255.

    Returns
    -------
    points : numpy.ndarray, shape (n_plane + n_outliers, columns)
    on_plane : numpy.ndarray of bool, shape (n_plane + n_outliers,)
        True for the points of the plane.
    """
    rng = np.random.default_rng(seed)
    if plane is None:
        tilt, heading = rng.uniform(0.2, 0.35), rng.uniform(0, 2 * np.pi)
        level = np.sin(tilt) * np.array([np.cos(heading), np.sin(heading)])
        plane = (*level, np.cos(tilt), rng.choice((-1, 1)) * rng.uniform(1, 4))
    normal = np.asarray(plane[:3], dtype=float)
    across = np.cross(normal, (1.0, 0.0, 0.0) if abs(normal[0]) < 0.9 else (0.0, 1.0, 0.0))
    across /= np.linalg.norm(across)
    along = np.cross(normal, across)
    n = n_plane + n_outliers
    on_plane = rng.permutation(n) < n_plane
    places = rng.uniform(-6, 6, (n, 2))
    gaps = np.where(
        on_plane,
        np.clip(rng.normal(0, noise, n), -3 * noise, 3 * noise),
        rng.choice((-1, 1), n) * rng.uniform(0.6, 4.0, n),
    )
    points = places[:, :1] * across + places[:, 1:] * along + (gaps - plane[3])[:, None] * normal
    if columns == 4:
        points = np.column_stack([points, rng.integers(0, 256, n)])
    return points, on_plane
