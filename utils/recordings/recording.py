"""Recordings as lazy sequences of frames, with true boxes if the recording is labelled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from utils.boxes import inside


@dataclass(frozen=True, eq=False)
class RecordedFrame:
    """One scan of a recording, with `cloud`, `boxes` and `time` like a simulated frame.

    Attributes
    ----------
    cloud : ndarray, shape (n, 3) or (n, 4)
    boxes : tuple of utils.boxes.Box
        Labelled objects in sensor coordinates; empty if the scan has no labels.
    time : float
        Seconds since the first frame.
    """

    cloud: np.ndarray
    boxes: tuple
    time: float


@dataclass(frozen=True, eq=False)
class Recording(Sequence):
    """A lazy sequence of the frames of a recording; each access reads one cloud.

    Attributes
    ----------
    clouds : sequence of ndarray
        One cloud per frame; this sequence is lazy as well.
    times : ndarray, shape (number of frames,)
        Seconds since the first frame.
    boxes : tuple of tuple of utils.boxes.Box, optional
        The labelled boxes of each frame.
    """

    clouds: Sequence[np.ndarray]
    times: np.ndarray
    boxes: tuple[tuple, ...] = field(default=())

    def __len__(self) -> int:
        return len(self.clouds)

    def __getitem__(self, index: int | slice) -> RecordedFrame | Recording:
        """Read frame `index`, or return a lazy recording for a slice."""
        if isinstance(index, slice):
            return Recording(self.clouds[index], self.times[index], self.boxes[index])
        cloud = self.clouds[index]
        boxes = self.boxes[index] if self.boxes else ()
        counted = tuple(replace(box, returns=int(inside(cloud, box).sum())) for box in boxes)
        return RecordedFrame(cloud, counted, float(self.times[index]))
