"""The ten likeliest slips in each exercise, and what a teacher would let each earn.

A module a lesson, each with a table ``SLIPS`` by exercise. A slip is a change of the lesson's own
solution; `tests/test_slips.py` makes it, asks all checks, and compares what they leave with what
the slip's harm allows.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Harm:
    """What a slip makes of the result, and the shares of an exercise that its checks may leave."""

    word: str
    least: float
    most: float


# Whoever uses the result gets nonsense: the outliers for the inliers, no d, axes exchanged.
USELESS = Harm("useless", 0.0, 0.5)
# Right for some inputs, wrong for others that every user meets.
PARTLY = Harm("partly", 0.1, 0.85)
# A caller would mend it, or hardly ever meet it.
SMALL = Harm("small", 0.6, 0.97)


@dataclass(frozen=True)
class Slip:
    """One change of a solution.

    Attributes
    ----------
    title : str
        What went wrong, in a few words.
    old, new : str
        Text of the solution's function, which stands there once, and what stands there instead.
    harm : Harm
    """

    title: str
    old: str
    new: str
    harm: Harm
