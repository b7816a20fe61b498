"""Rules that a course may change."""

# If an answer is proven to be one edit from a right answer, it earns at least this share of the
# exercise's points. With 0, the judge does not look for such an edit.
ONE_SLIP_KEEPS = 0.6
# This share applies if the slip misses the point of the exercise. An example is a horizontal
# distance that includes the height.
MISSED_TASK_KEEPS = 0.4
