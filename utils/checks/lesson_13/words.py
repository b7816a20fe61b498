"""Texts shared by the notes on all functions of lesson 13."""

COMPILES_TITLE = "Numba makes machine code of it, with the same answer"
"""Title of the note that checks whether a function compiles."""
COMPILES_WHY = (
    "What follows calls it compiled. There a variable keeps its type, every way through a function "
    "returns the same kind of thing, and what is called is compiled, too."
)
