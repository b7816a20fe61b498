"""Connect the course to systems that store results: nbgrader's gradebook and LMSs."""
