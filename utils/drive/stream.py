"""Frames of a drive for other viewers, with the tracked boxes and the decisions of the car."""

from collections.abc import Iterator

import numpy as np

from utils.drive.loop import Drive, Moment
from utils.films.film import ROAD_USERS
from utils.films.frames import DetectedFrame
from utils.progress import progress


def frames_of(drive: Drive) -> Iterator[DetectedFrame]:
    """Yield the scan of each moment with the planner's boxes, and show a progress bar."""
    for number in progress(range(len(drive.moments)), "Writing the drive"):
        moment, frame = drive.moments[number], drive.frame(number)
        yield DetectedFrame(
            number + 1,
            len(drive.moments),
            moment.time,
            frame.cloud,
            tuple(box for box in frame.boxes if box.kind in ROAD_USERS),
            np.reshape([box.corners for box in moment.tracked_boxes], (-1, 8, 3)),
            track_ids=tuple(box.track_id for box in moment.tracked_boxes),
            decision=decision_of(moment),
        )


def decision_of(moment: Moment) -> str:
    """Return the speed and the decision of a moment in words."""
    decision = moment.decision
    words = f"{3.6 * moment.speed:.0f} km/h, {decision.acceleration:+.1f} m/s²"
    if decision.cause is None:
        return words
    return f"{words} because of track {decision.cause.track_id}, {decision.gap:.1f} m ahead"
