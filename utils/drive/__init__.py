"""Drive a car through simulated streets with the boxes of your own detector.

>>> from utils.drive import drive_street
>>> drive_street(3, detect_obstacles)

The modules, from the ground up: `rules` contains the constants; `actors`, `streets` and `weather`
build the world. `steps`, `motion` and `planner` are the car's built-in parts, and `clock`
measures the delay of the detector. `loop` runs a drive. `ground_truth`, `explanations` and
`metrics` evaluate it; `film`, `timeline` and `trip` show it. `standards` contains the results of
other detectors. `person` puts a person in the road, whom students drag in lesson 09.
"""

from utils.drive.clock import on_time
from utils.drive.naive_detector import occupied_squares
from utils.drive.steps import askew, chain
from utils.drive.streets import STREETS, Street
from utils.drive.trip import Trip, drive_street

__all__ = [
    "STREETS",
    "Street",
    "Trip",
    "askew",
    "chain",
    "drive_street",
    "occupied_squares",
    "on_time",
]
