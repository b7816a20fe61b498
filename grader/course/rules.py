"""Rules that a course may change."""

# Least share of an exercise's points for an answer that is proven to be one edit from a right
# answer. With 0, the judge does not look for such an edit.
ONE_SLIP_KEEPS = 0.6
# The same share for a slip that misses the point of the exercise. An example is a horizontal
# distance that includes the height.
MISSED_TASK_KEEPS = 0.4
