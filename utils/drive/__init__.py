"""Drive on your own code: a car in the simulator's streets that sees what a detector boxes.

>>> from utils.drive import drive_street
>>> drive_street(3, detect_obstacles)

From the ground up: `rules` has the numbers; `actors`, `streets` and `weather` make the world;
`steps`, `motion` and `planner` are the given rest of the car, and `clock` says how late its eyes
are; `driving` is the loop. `truth`, `reasons` and `measuring` judge a drive; `film`, `strip` and
`trip` show it; `standards` says how others did.
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
