"""One frame of a stream with the boxes of a detector."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class DetectedFrame:
    """One frame with the answer of a detector.

    Attributes
    ----------
    number, total : int
        Position in the stream, from 1, and length of the stream.
    time : float
        Seconds since the first frame.
    cloud : ndarray, shape (n, 3) or (n, 4)
    true_boxes : tuple of utils.boxes.Box
        True boxes of road users; empty if they are unknown.
    boxes : ndarray, shape (N, 8, 3), or None
        Boxes of the detector; None without a detector, or if it failed.
    seconds : float
        Computing time of the detector.
    problem : str
        Why the scan could not be read, or why the detector failed; empty if neither happened.
    track_ids : tuple of int or None
        Track ID of each box; None without a tracker.
    trails : tuple of ndarray, shape (m, 3)
        Latest centres of each tracked object, oldest first, each relative to the scanner at that
        time. While an object has no box, its trail continues with the predicted centres.
    decision : str
        Decision of the simulated car in words; empty in streams without one.
    """

    number: int
    total: int
    time: float
    cloud: np.ndarray
    true_boxes: tuple
    boxes: np.ndarray | None = None
    seconds: float = 0.0
    problem: str = ""
    track_ids: tuple[int, ...] | None = None
    trails: tuple[np.ndarray, ...] = ()
    decision: str = ""

    @property
    def caption(self) -> str:
        """Caption with the position in the stream, the computing time and the number of boxes."""
        words = [f"frame {self.number} of {self.total}", f"{self.time:.1f} s"]
        if self.problem:
            words.append(self.problem[:90])
        elif self.boxes is not None:
            words.append(f"detected in {1000 * self.seconds:.0f} ms")
            words.append(f"{len(self.boxes)} box" + ("" if len(self.boxes) == 1 else "es"))
        return " · ".join(words)
