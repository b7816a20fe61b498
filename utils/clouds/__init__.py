"""Read and write point clouds in every common file format.

A cloud is a float array of shape (n, 3) or (n, 4): x forward, y left, z up in metres with the
sensor at the origin, then intensity. `read_cloud` and `write_cloud` choose the format by the
file's suffix. `read_sequence` opens a folder of clouds, `read_bag` a ROS recording and
`read_kitti_raw` a KITTI drive. Every problem with a file raises `CloudFileError`.
"""

from utils.clouds.errors import CloudFileError
from utils.clouds.formats import SUFFIXES, read_cloud, write_cloud
from utils.clouds.sequence import CloudFolder, read_sequence

__all__ = [
    "SUFFIXES",
    "CloudFileError",
    "CloudFolder",
    "read_cloud",
    "read_sequence",
    "write_cloud",
]
