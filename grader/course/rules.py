"""Rules that a course may change."""

# Share of an exercise's points that an answer keeps at least if it is proven to have a single slip:
# one edit that corrects it, or one named mistake. With 0, the judge does not look for slips.
ONE_SLIP_KEEPS = 0.6
# The same share for a slip that misses the point of the exercise. An example is a horizontal
# distance that includes the height.
MISSED_TASK_KEEPS = 0.4
