"""Eye-dome lighting: edges in depth made visible, which gives a bare cloud its shape.

C. Boucheny, "Interactive scientific visualization of large datasets: towards a
perceptive-based approach", PhD thesis, Université Joseph Fourier, 2009.
"""

from __future__ import annotations

import numpy as np

STRENGTH = 1.1
DARKEST = 0.5
"""What a colour keeps of its brightness: colours carry meaning."""

NEIGHBOURS = ((0, 1), (1, 0), (0, 2), (2, 0))


def eye_dome(image: np.ndarray, depth: np.ndarray, strength: float = STRENGTH) -> np.ndarray:
    """Darken what lies right behind something nearer.

    VTK has this as a render pass, but on paper white that draws a black rim around every single
    point: here the empty background is no neighbour.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3)
    depth : ndarray, shape (height, width)
        Metres in front of the camera; infinite where there is nothing.
    strength : float
        0 leaves the image as it is.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        Another image.
    """
    covered = np.isfinite(depth)
    steps = np.log2(np.where(covered, depth, 1.0), dtype=np.float32)
    hidden = np.zeros(depth.shape, dtype=np.float32)
    for down, across in NEIGHBOURS:
        here = (slice(down, None), slice(across, None))
        there = (slice(None, -down or None), slice(None, -across or None))
        both = covered[here] & covered[there]
        drop = np.where(both, steps[here] - steps[there], 0.0)
        hidden[here] += np.maximum(drop, 0.0)
        hidden[there] += np.maximum(-drop, 0.0)
    shade = np.exp2(-strength * hidden)
    return (image * np.maximum(shade, DARKEST)[..., None]).astype(np.uint8)
