"""Texts of the note, shared by all functions of lesson 13, that a function does not compile."""

COMPILES_TITLE = "Compiles with Numba and returns the same answer"
"""Title of the note that checks whether a function compiles."""
COMPILES_WHY = (
    "The cells below call the compiled function. In compiled code each variable keeps its type, "
    "every branch returns the same type, and all called functions must be compiled as well."
)
