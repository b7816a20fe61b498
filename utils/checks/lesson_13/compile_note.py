"""Title and why of the note about functions that do not compile, for all of lesson 13."""

COMPILES_TITLE = "Compiles with Numba and returns the same answer"
COMPILES_WHY = (
    "The cells below call the compiled function. In compiled code, each variable must keep its "
    "type, every branch must return the same type, and every function that the code calls must be "
    "compiled as well."
)
