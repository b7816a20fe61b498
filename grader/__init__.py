"""Build, release, collect and judge the course: ``python -m grader``."""
