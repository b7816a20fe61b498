"""Read notebook files, extract the code of an exercise, and load a student's functions."""
