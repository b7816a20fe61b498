"""Rules that a course may change."""

# An answer that is provably one edit from a right one keeps this share of the exercise's points, if
# its checks earn less. With 0 the judge does not look for such an edit.
ONE_SLIP_KEEPS = 0.6
# The same where the slip is what the exercise is about, such as a height in a horizontal distance.
MISSED_TASK_KEEPS = 0.4
