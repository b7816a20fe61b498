"""Types for tables of the likeliest slips in each exercise, with the points that they may keep.

Each lesson has a module with a table ``SLIPS`` by exercise. A slip is one change to the lesson's
solution. `tests/test_slips.py` makes the change, runs all checks, and compares the remaining points
with the limits of the slip's harm.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Harm:
    """The effect of a slip on the result, and the range of the share of points that it keeps."""

    word: str
    least: float
    most: float


# The result is useless: outliers instead of inliers, a plane without d, or exchanged axes.
USELESS = Harm("useless", 0.0, 0.5)
# The result is right for some inputs but wrong for other common ones.
PARTLY = Harm("partly wrong", 0.1, 0.85)
# A caller could easily correct the result, or would rarely see the fault.
SMALL = Harm("small", 0.6, 0.97)
# The method that the lesson teaches is missing.
MISSING = Harm("method missing", 0.0, 0.5)
# The lesson shows this code as an idea that fails, or the code ignores its input.
NAIVE = Harm("naive", 0.0, 0.1)


# The whole body of the function.
BODY = "    ### BEGIN SOLUTION\n"


@dataclass(frozen=True)
class Slip:
    """One change to a solution.

    Attributes
    ----------
    title : str
        Description of the slip in a few words.
    old, new : str
        A text that occurs once in the solution's function, or `BODY`; and its replacement.
    harm : Harm
        The effect of the slip.
    """

    title: str
    old: str
    new: str
    harm: Harm

    def applied_to(self, source: str) -> str:
        """Return the source of the solution's function with the slip.

        Raises
        ------
        ValueError
            If the text to replace does not occur exactly once.
        """
        if source.count(self.old) != 1:
            raise ValueError(f"{self.old!r} occurs {source.count(self.old)} times")
        if self.old == BODY:
            return source[: source.index(BODY)] + self.new
        return source.replace(self.old, self.new)
