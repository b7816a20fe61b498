"""Title and why of the note about functions that do not compile, for all of lesson 13."""

COMPILES_TITLE = "Compiles with Numba and returns the same answer"
COMPILES_WHY = (
    "The cells below call the compiled function. In compiled code each variable keeps its type, "
    "every branch returns the same type, and all called functions must be compiled as well."
)
