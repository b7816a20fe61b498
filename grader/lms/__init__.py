"""Connection to systems that store the results of a course: nbgrader's gradebook and LMSs."""
