"""Figures of RANSAC models: a line or a plane with its tolerance band, inliers and outliers."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import ArrayLike

from utils.plots.arguments import as_cloud, as_mask, as_points
from utils.plots.clouds import Group, draw_groups
from utils.plots.style import BLUE, GREEN, INK, PALE, VERMILION, finish, note, number, styled

FACE_ON = 0.5
"""Smallest length of a plane's unit normal, projected into the drawing, for drawing its line.

A plane with a shorter projection is seen almost face on.
"""


@styled
def line_model(
    points: ArrayLike,
    line: ArrayLike | None = None,
    inliers: ArrayLike | None = None,
    tolerance: float | None = None,
    *,
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw two-dimensional points with a line, its tolerance band, inliers and outliers.

    Parameters
    ----------
    points : (n, 2) array_like of float
    line : (a, b, c), optional
        The line a x + b y + c = 0, normalised or not. None draws only the points.
    inliers : (n,) array_like of bool, optional
    tolerance : float, optional
        Half the width of the band around the line, in the unit of the points.
    title : str, optional
    limits : ((x_low, x_high), (y_low, y_high)) or four numbers, optional
    axes : matplotlib.axes.Axes, optional
    """
    points = as_points(points)
    groups = _inlier_groups(inliers, len(points), VERMILION)
    axes = draw_groups(points, groups, view="above", limits=limits, axes=axes, title=title)
    if line is not None:
        _draw_line(axes, as_coefficients(line, 3, "line"), tolerance, "line")
    return finish(axes, title)


@styled
def plane_model(
    cloud: ArrayLike,
    plane: ArrayLike | None = None,
    inliers: ArrayLike | None = None,
    tolerance: float | None = None,
    *,
    view: str = "side",
    title: str | None = None,
    limits: ArrayLike | None = None,
    axes: Axes | None = None,
) -> Axes:
    """Draw a cloud and a cross-section of a plane, which appears as a line.

    From the side, the section is at y = 0, through the sensor. From above, it is at the median
    height of the inliers, which suits walls. A plane seen face on has no such line; a note in the
    corner says so.

    Parameters
    ----------
    cloud : (n, 3) or (n, 4) array_like of float
        In metres.
    plane : (a, b, c, d), optional
        The plane a x + b y + c z + d = 0, normalised or not. None draws only the cloud.
    inliers : (n,) array_like of bool, optional
    tolerance : float, optional
        Largest distance of an inlier from the plane in metres.
    view : {"side", "above"}
    title, limits, axes
        As in :func:`utils.plots.from_above`.
    """
    cloud = as_cloud(cloud)
    # A whole scan has so many outliers that a strong colour would hide the plane.
    groups = _inlier_groups(inliers, len(cloud), PALE)
    axes = draw_groups(cloud, groups, view=view, limits=limits, axes=axes, title=title)
    if plane is None:
        return axes
    a, b, c, d = as_coefficients(plane, 4, "plane")
    if view == "side":
        cut = np.array([a, c, d])
    else:
        on_plane = cloud[groups[-1].mask, 2]
        on_plane = on_plane[np.isfinite(on_plane)]
        cut = np.array([a, b, d + c * (np.median(on_plane) if len(on_plane) else 0.0)])
    if np.hypot(cut[0], cut[1]) < FACE_ON:
        note(axes, "the plane is seen face on")
        return axes
    _draw_line(axes, cut, tolerance, "plane")
    return finish(axes, title)


def _inlier_groups(inliers: ArrayLike | None, count: int, outlier_colour: str) -> tuple[Group, ...]:
    if inliers is None:
        return (Group("points", np.ones(count, dtype=bool), "o", BLUE),)
    inliers = as_mask(inliers, count, "inliers")
    return (
        Group("outliers", ~inliers, "x", outlier_colour),
        Group("inliers", inliers, "o", BLUE),
    )


def as_coefficients(model: ArrayLike, count: int, name: str) -> np.ndarray:
    """Return the coefficients of a model, scaled to a normal of length 1."""
    letters = ", ".join("abcd"[:count])
    try:
        model = np.asarray(model, dtype=float)
    except (TypeError, ValueError):
        model = np.empty(0)
    if model.shape != (count,):
        raise ValueError(f"{name} must be {count} numbers ({letters}); yours is {model!r}.")
    length = np.linalg.norm(model[:-1])
    if not np.isfinite(model).all() or length == 0:
        raise ValueError(
            f"{name} has no direction: ({letters[:-3]}) must be finite and not all zero; "
            f"yours is {model.tolist()}."
        )
    return model / length


def ends_of_line(line: np.ndarray, view: np.ndarray) -> np.ndarray:
    """Return two points (2, 2) of the line a u + b v + c = 0 that are outside the view.

    The coordinates u and v are the horizontal and the vertical coordinate of the drawing. The view
    has shape (2, 2): low and high u, then low and high v.
    """
    normal = line[:2]
    squared = normal @ normal
    along = np.array([-normal[1], normal[0]]) / np.sqrt(squared)
    middle = view.mean(axis=1)
    foot = middle - (normal @ middle + line[2]) / squared * normal
    # At any slope, the line is longer than the view, which clips it.
    return foot + np.outer([-2, 2], along) * np.linalg.norm(view[:, 1] - view[:, 0])


def _draw_line(axes: Axes, line: np.ndarray, tolerance: float | None, name: str) -> None:
    """Draw the line a u + b v + c = 0 and the band |a u + b v + c| <= tolerance."""
    normal = line[:2]
    ends = ends_of_line(line, np.array([axes.get_xlim(), axes.get_ylim()]))
    if tolerance is not None:
        offset = float(tolerance) / (normal @ normal) * normal
        corners = np.concatenate([ends + offset, ends[::-1] - offset])
        axes.add_patch(
            Polygon(
                corners,
                facecolor=GREEN,
                edgecolor=GREEN,
                alpha=0.18,
                linewidth=1.0,
                zorder=1,
                label=f"within {number(float(tolerance))} m",
            )
        )
    axes.plot(*ends.T, color=INK, linewidth=1.8, zorder=3, label=name, scalex=False, scaley=False)
