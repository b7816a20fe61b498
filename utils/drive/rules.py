"""Constants of a drive, chosen for these streets and compared with published values.

The car is the same as in the lessons: the scanner is in the middle of the roof, 2.6 m behind the
front bumper. As in lesson 07, the car reacts after half a second and brakes at 7 m/s². From 30
km/h, it stops after 9.1 m. No standard defines the side margin, the gap at standstill, the comfort
limits and the jerk. Their values let a simple planner drive well.

References
----------
- Drivers react more slowly: after about 0.7 s to an expected signal, 1.25 s to a brake light
  ahead, and 1.5 s to a sudden obstacle. M. Green, "How long does it take to stop?
  Methodological analysis of driver perception-brake times", Transportation Human Factors 2 (3),
  195-216, 2000.
- German driving schools teach one second of reaction for an emergency. The braking distance in
  metres is then half the square of a tenth of the speed in km/h, which is 7.7 m/s². With 9 m for
  the reaction, the total is 13.5 m from 30 km/h.
- Roads are designed for longer distances: AASHTO's "A Policy on Geometric Design of Highways and
  Streets" allows 2.5 s, and a deceleration of 11.2 ft/s², or 3.4 m/s².
- Crossing pedestrians: Euro NCAP's test of emergency braking from the near side (CPNA) uses an
  adult at 5 km/h, as proposed for UN Regulation 152 (informal document AEBS-08-07, 2019). Other
  tests use running adults, and children from behind parked cars.
- Behind a moving car, its own braking distance can be subtracted: S. Shalev-Shwartz et al.,
  "On a formal model of safe and scalable self-driving cars", arXiv:1708.06374, 2017.
"""

from __future__ import annotations

TICK = 0.1
"""Seconds between two scans."""

REACTION_TIME = 0.5
DECELERATION = 7.0
"""Reaction time that the planner allows, in s, and largest deceleration of the car, in m/s²."""

SCANS_TO_BE_SURE = 3
"""Number of scans in a row in which a box must be in the way; 0.2 s of the reaction time."""

OVERLAP_WITH_CAR, SCANS_TO_STAY, LARGEST_SHIFT = 0.5, 10, 0.3
"""A box that overlaps the ego car by more than OVERLAP_WITH_CAR metres counts only after
SCANS_TO_STAY scans in which its centre moves at most LARGEST_SHIFT metres from scan to scan."""

COMFORTABLE_DECELERATION = 3.0
ACCELERATION = 2.0
"""Deceleration of gentle braking and largest acceleration, in m/s²."""

JERK = 30.0
"""Largest jerk in m/s³; full braking builds up in a quarter of a second."""

BUMPER, TAIL, HALF_WIDTH = 2.6, -1.9, 0.9
"""Extent of the ego car relative to its scanner, in metres: ahead, behind and to either side."""

MARGIN = 0.4
CORRIDOR = HALF_WIDTH + MARGIN
"""Free margin on either side of the car, and half the width of the corridor, in metres."""

STANDSTILL_GAP = 2.0
"""Gap in metres that the car leaves to a standing obstacle when it stops."""


def stopping_distance(speed: float) -> float:
    """Return the stopping distance in metres including the reaction time, as in lesson 07.

    Parameters
    ----------
    speed : float
        Speed in m/s.
    """
    return REACTION_TIME * speed + speed**2 / (2 * DECELERATION)
