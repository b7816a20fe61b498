"""Where a point is decided: outside the process of the student."""
