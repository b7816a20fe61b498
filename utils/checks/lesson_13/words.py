"""What is said of each function of the lesson in the same words."""

COMPILES = "Numba makes machine code of it, with the same answer"
"""Title of the note on a function that does not compile."""
WHY_COMPILED = (
    "What follows calls it compiled. There a variable keeps its type, every way through a function "
    "returns the same kind of thing, and what is called is compiled, too."
)
