"""What the course consists of, and how its notebooks are built."""
