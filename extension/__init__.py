"""What this course adds to the grader: samples for hidden tests, and a league."""
