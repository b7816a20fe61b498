"""The parts of the course, and the build of its notebooks."""
