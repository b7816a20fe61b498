"""A late penalty per day, for use in `nbgrader_config.py`.

nbgrader's own penalty is all or nothing.

::

    c.AssignLatePenalties.plugin_class = "grader.lms.late.PercentPerDay"
    c.PercentPerDay.percent = 10
    c.PercentPerDay.grace_minutes = 15
    c.PercentPerDay.most_percent = 50
"""

import math

from nbgrader.plugins import LateSubmissionPlugin
from traitlets import Float

SECONDS_PER_DAY = 24 * 60 * 60


class PercentPerDay(LateSubmissionPlugin):
    """Subtract a percentage of the score for each day or part of a day after the due date."""

    percent = Float(
        10.0,
        min=0.0,
        max=100.0,
        help="Percentage of the score to subtract for each day or part of a day.",
    ).tag(config=True)
    grace_minutes = Float(
        0.0, min=0.0, help="Minutes after the due date during which work counts as on time."
    ).tag(config=True)
    most_percent = Float(
        100.0, min=0.0, max=100.0, help="Largest percentage of the score to subtract."
    ).tag(config=True)

    def late_submission_penalty(
        self, student_id: str, score: float, total_seconds_late: float
    ) -> float | None:
        """Return the points to subtract from a notebook, or None if it is on time; see nbgrader.

        In `total_seconds_late`, the course counts each calendar day as 86,400 seconds; see
        `grader.lms.penalties`.
        """
        if total_seconds_late <= 60 * self.grace_minutes:
            return None
        days = math.ceil(total_seconds_late / SECONDS_PER_DAY)
        return score * min(self.percent * days, self.most_percent) / 100
