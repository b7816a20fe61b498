"""Recordings: clouds with times, and true boxes where somebody labelled them.

`read_bag` opens a ROS recording, `read_kitti_raw` a drive of KITTI; `utils.recordings.sources`
knows some that can be fetched. Each is a lazy sequence.
"""

from utils.recordings.kitti_labels import (
    Calibration,
    read_calibration,
    read_object_labels,
    read_tracking_labels,
)
from utils.recordings.kitti_raw import read_kitti_raw, read_tracklets
from utils.recordings.recording import RecordedFrame, Recording
from utils.recordings.rosbag import Bag, read_bag

__all__ = [
    "Bag",
    "Calibration",
    "RecordedFrame",
    "Recording",
    "read_bag",
    "read_calibration",
    "read_kitti_raw",
    "read_object_labels",
    "read_tracking_labels",
    "read_tracklets",
]
