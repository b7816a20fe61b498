"""Build and release the course, and collect and judge submissions: ``python -m grader``."""
