"""The lessons, students and settings of the course, and the build of its notebooks."""
