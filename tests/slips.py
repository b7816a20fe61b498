"""Types for the ten likeliest slips in each exercise, with the points a teacher would allow.

Each lesson has a module with a table ``SLIPS`` by exercise. A slip is one change of the lesson's
own solution. `tests/test_slips.py` makes the change, runs all checks, and compares the remaining
points with the limits of the slip's harm.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Harm:
    """The effect of a slip on the result, and the share of points that may remain."""

    word: str
    least: float
    most: float


# The result is nonsense for its users: outliers for inliers, no d, or exchanged axes.
USELESS = Harm("useless", 0.0, 0.5)
# The result is right for some inputs but wrong for others that every user meets.
PARTLY = Harm("partly", 0.1, 0.85)
# A caller would fix the result easily, or hardly ever meet the fault.
SMALL = Harm("small", 0.6, 0.97)


@dataclass(frozen=True)
class Slip:
    """One change of a solution.

    Attributes
    ----------
    title : str
        Description of the slip in a few words.
    old, new : str
        Text that occurs once in the solution's function, and its replacement.
    harm : Harm
        Effect of the slip.
    """

    title: str
    old: str
    new: str
    harm: Harm
