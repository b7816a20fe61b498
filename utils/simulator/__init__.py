"""The simulator: a LiDAR that casts rays at solids and knows what it hit.

From the solids up: `pose`, `shapes` and `bounds`; `ground`, `world` and `traffic`; `sensor` and
`scanner`; `frames`; `streets`, `layouts` and `scenes`. Same seed, same bytes.
"""

from utils.simulator.scanner import CLASSES, Scan, scan
from utils.simulator.sensor import Sensor, hdl64, highway_sensor, layers, ray_directions
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
]
