"""A late penalty per day, for `nbgrader_config.py`; nbgrader's own plugins offer all or nothing.

::

    c.AssignLatePenalties.plugin_class = "grader.lms.late.PercentPerDay"
    c.PercentPerDay.percent = 10
    c.PercentPerDay.grace_minutes = 15
    c.PercentPerDay.most_percent = 50
"""

import math

from nbgrader.plugins import LateSubmissionPlugin
from traitlets import Float

SECONDS_OF_A_DAY = 24 * 60 * 60


class PercentPerDay(LateSubmissionPlugin):
    """Deduct a percentage of the score for each day begun after the due date."""

    percent = Float(
        10.0, min=0.0, max=100.0, help="Part of the score, in percent, for each day begun."
    ).tag(config=True)
    grace_minutes = Float(
        0.0, min=0.0, help="Work that is late by no more than this counts as on time."
    ).tag(config=True)
    most_percent = Float(
        100.0, min=0.0, max=100.0, help="Largest part of the score, in percent, that is subtracted."
    ).tag(config=True)

    def late_submission_penalty(
        self, student_id: str, score: float, total_seconds_late: float
    ) -> float | None:
        """Return the points to deduct from a notebook, or None if it is on time; see nbgrader."""
        if total_seconds_late <= 60 * self.grace_minutes:
            return None
        days = math.ceil(total_seconds_late / SECONDS_OF_A_DAY)
        return score * min(self.percent * days, self.most_percent) / 100
