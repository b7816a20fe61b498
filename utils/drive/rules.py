"""The numbers that a drive goes by: chosen for these streets, and set beside those of the field.

The car is that of the lessons: a scanner in the middle of the roof, the bumper 2.6 m ahead of it.
It thinks for half a second and brakes with 7 m/s²: lesson 07. From 30 km/h that is 9 m. The margin
beside the car, the room that it leaves, its comfort and its brakes' jerk are no norm's: they are
what a plain planner drives well with.

References
----------
- A driver needs longer: about 0.7 s who waits for the signal, 1.25 s for a brake light ahead, and
  1.5 s for what suddenly moves into the way. M. Green, "How long does it take to stop?
  Methodological analysis of driver perception-brake times", Transportation Human Factors 2 (3),
  195-216, 2000.
- German driving schools teach for an emergency a second of reaction and, in metres, half the
  square of a tenth of the speed in km/h, which is 7.7 m/s²: together 13.5 m from 30 km/h.
- Roads are built for more: AASHTO's "A Policy on Geometric Design of Highways and Streets" allows
  2.5 s, and a deceleration of 11.2 ft/s², or 3.4 m/s².
- Who crosses: Euro NCAP's test of emergency braking from the near side (CPNA) sends an adult at
  5 km/h, as was proposed for UN Regulation 152 (informal document AEBS-08-07, 2019); others send
  adults who run, and children out from behind parked cars.
- Behind a car that drives, room for what it still rolls is not needed: S. Shalev-Shwartz et al.,
  "On a formal model of safe and scalable self-driving cars", arXiv:1708.06374, 2017.
"""

from __future__ import annotations

TICK = 0.1
"""Seconds between two scans."""

REACTION = 0.5
DECELERATION = 7.0
"""Seconds that the planner allows for thinking, and m/s² with which the car can brake."""

SURE = 3
"""Scans in a row in which something has to be in the way: 0.2 s of the half second."""

OVER, STAYS, STILL = 0.5, 10, 0.3
"""What reaches farther over our own car than so many metres counts after so many scans in a row, if
from each to the next its middle keeps within so many metres."""

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
