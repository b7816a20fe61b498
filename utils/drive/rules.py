"""The numbers that a drive goes by, and where they come from.

The car is that of the lessons: a scanner in the middle of the roof, the bumper 2.6 m ahead of it.

References
----------
- Stopping: half a second of thinking, then 7 m/s²: lesson 07. UN Regulation 13-H asks of a
  passenger car's brakes a mean fully developed deceleration of at least 6.43 m/s² on a dry road
  (annex 3, 2.1.1), and UN Regulation 152 of automatic emergency braking at least 5 m/s².
- Behind a car that drives, room for what it still rolls is not needed: S. Shalev-Shwartz et al.,
  "On a formal model of safe and scalable self-driving cars", arXiv:1708.06374, 2017, lemma 2.
- Comfort: adaptive cruise control may brake with at most 3.5 m/s² at speeds above 20 m/s and
  5 m/s² below 5 m/s (ISO 15622:2018); 3 m/s² is felt as braking and not as an emergency.
- Who crosses: Euro NCAP's tests of emergency braking for vulnerable road users send adults at
  5 and 8 km/h, children at 5 km/h out from behind parked cars, cyclists at 10 to 20 km/h; its
  car-to-car tests brake the car ahead with 2 and 6 m/s².
"""

from __future__ import annotations

TICK = 0.1
"""Seconds between two scans."""

REACTION = 0.5
DECELERATION = 7.0
"""Seconds that the planner allows for thinking, and m/s² with which the car can brake."""

SURE = 3
"""Scans in a row in which something has to be in the way: 0.2 s of the half second."""

COMFORTABLE = 3.0
ACCELERATION = 2.0
"""m/s² of gentle braking, and of driving off."""

JERK = 30.0
"""m/s³: full braking builds up in a quarter of a second."""

BUMPER, TAIL, HALF_WIDTH = 2.6, -1.9, 0.9
"""The own car around its scanner, in metres: ahead, behind, and to either side."""

MARGIN = 0.4
CORRIDOR = HALF_WIDTH + MARGIN
"""The corridor reaches so far to either side, in metres."""

STANDSTILL = 2.0
"""Metres that are left before what stands, once we stand."""


def stopping_distance(speed: float) -> float:
    """Metres from the bumper to where the car stands, thinking included: lesson 07.

    Parameters
    ----------
    speed : float
        Metres per second.
    """
    return REACTION * speed + speed**2 / (2 * DECELERATION)
