"""Help for authors: write the skeleton of a new lesson, and try a lesson while writing it."""
