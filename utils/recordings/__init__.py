"""Recordings: clouds with times, and true boxes if the recording is labelled.

`read_bag` opens a ROS recording and `read_kitti_raw` a KITTI drive, each as a lazy sequence.
`utils.recordings.sources` lists recordings that can be downloaded.
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
