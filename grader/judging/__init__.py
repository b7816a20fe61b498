"""Judge submissions; every point is decided outside the process that runs the student's code."""
