"""Read and write point clouds: one call for every common file format.

A cloud is a float array of shape (n, 3) or (n, 4): x forward, y left, z up in metres with the
sensor at the origin, then intensity. `read_cloud` and `write_cloud` choose the format by the
file's suffix, `read_sequence` opens a folder of clouds, `read_bag` a ROS recording and
`read_kitti_raw` a drive of KITTI. Everything that can be wrong with a file is one
`CloudFileError`.
"""

from .errors import CloudFileError
from .formats import SUFFIXES, read_cloud, write_cloud
from .kitti_labels import (
    Calibration,
    read_calibration,
    read_object_labels,
    read_tracking_labels,
)
from .kitti_raw import read_kitti_raw, read_tracklets
from .recording import RecordedFrame, Recording, inside
from .rosbag import Bag, read_bag
from .sequence import CloudFolder, read_sequence

__all__ = [
    "SUFFIXES",
    "Bag",
    "Calibration",
    "CloudFileError",
    "CloudFolder",
    "RecordedFrame",
    "Recording",
    "inside",
    "read_bag",
    "read_calibration",
    "read_cloud",
    "read_kitti_raw",
    "read_object_labels",
    "read_sequence",
    "read_tracking_labels",
    "read_tracklets",
    "write_cloud",
]
