"""LiDAR simulator that casts rays at solids and records which object each ray hit.

The modules, from the solids up: `pose`, `shapes` and `bounds`; `ground`, `world` and `traffic`;
`sensor` and `scanner`; `frames`; `streets`, `layouts` and `scenes`. The same seed gives the same
bytes.
"""

from utils.simulator.scanner import CLASSES, Scan, scan
from utils.simulator.sensor import Sensor, hdl64, highway_sensor, layers, ray_directions, vlp16
from utils.simulator.world import World

__all__ = [
    "CLASSES",
    "Scan",
    "Sensor",
    "World",
    "hdl64",
    "highway_sensor",
    "layers",
    "ray_directions",
    "scan",
    "vlp16",
]
