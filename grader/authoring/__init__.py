"""Help for authors: the skeleton of a new lesson, and a trial of a lesson that is being written."""
