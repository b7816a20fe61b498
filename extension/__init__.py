"""The course's additions to the grader: samples for hidden tests, and a league."""
