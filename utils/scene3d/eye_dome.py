"""Eye-dome lighting, which shows the shape of a cloud by darkening depth edges.

C. Boucheny, "Interactive scientific visualization of large datasets: towards a
perceptive-based approach", PhD thesis, Université Joseph Fourier, 2009.
"""

from __future__ import annotations

import numpy as np

STRENGTH = 1.1
DARKEST = 0.5
"""Smallest share of its brightness that a colour keeps, so that its meaning remains clear."""

NEIGHBOURS = ((0, 1), (1, 0), (0, 2), (2, 0))


def eye_dome(image: np.ndarray, depth: np.ndarray, strength: float = STRENGTH) -> np.ndarray:
    """Darken pixels that are next to a nearer pixel.

    VTK has a render pass for this, but on a white background it draws a black rim around every
    single point. Here, empty background does not count as a neighbour.

    Parameters
    ----------
    image : ndarray of uint8, shape (height, width, 3)
    depth : ndarray, shape (height, width)
        Distance from the camera in metres; infinite for empty background.
    strength : float
        Strength of the effect; 0 leaves the image unchanged.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        A new image.
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
