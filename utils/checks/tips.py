"""Plain words for the exceptions that beginners meet."""

import re

_WHOLE = "An index must be a whole number: use //, int(...) or .astype(int)."

# (exception, pattern of its message, what to say)
_TIPS = (
    (
        "NameError",
        r"name '(\w+)' is not defined",
        "Python does not know this name: is it spelt as where you made it, and did you run that "
        "cell? Inside a function, use its parameters.",
    ),
    (
        "NameError",
        r"does not define it",
        "The cell with the function is missing, was not run, or the function has another name.",
    ),
    (
        "TypeError",
        r"unexpected keyword argument",
        "A parameter was renamed. Keep the names in the first line of the function as given.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes \d+ positional",
        "The parameters changed. Keep the first line of the function, defaults included, as given.",
    ),
    ("TypeError", r"'NoneType'", "Something is None: a function without `return` gives None."),
    ("TypeError", r"only integer|integer scalar arrays", _WHOLE),
    ("IndexError", r"only integers|of integer \(or boolean\) type", _WHOLE),
    (
        "TypeError",
        r"unhashable type: 'numpy.ndarray'",
        "An array cannot be a dictionary key or a set member: use tuple(array).",
    ),
    (
        "IndexError",
        r"boolean index did not match",
        "The mask and the array have different lengths. Build the mask from the same array that "
        "you index, after any earlier filtering.",
    ),
    (
        "IndexError",
        r"index 3 is out of bounds for axis 1 with size 3",
        "The cloud may have three columns: not every recording has intensity.",
    ),
    (
        "IndexError",
        r"out of bounds",
        "An index points past the end. Is the cloud transposed, (3, n) for (n, 3), or empty?",
    ),
    (
        "ValueError",
        r"truth value of an array",
        "Python's if, and, or want one True or False. For arrays use a mask with & and |, "
        "each side in parentheses.",
    ),
    (
        "ValueError",
        r"could not be broadcast",
        "The shapes do not fit. (n, 3) minus (3,) works; (3, n) or (n, 4) minus (3,) does not: "
        "take cloud[:, :3].",
    ),
    (
        "ValueError",
        r"zero-size array|empty",
        "The cloud, or one cluster of it, can be empty. Return early, or use an operation that "
        "allows no rows.",
    ),
    (
        "ValueError",
        r"read-only|assignment destination",
        "The input must stay as it is: work on a copy.",
    ),
    (
        "RecursionError",
        r"",
        "Python stops after about a thousand nested calls and a cluster has many more points: "
        "use a queue and a loop.",
    ),
    (
        "MemoryError",
        r"",
        "That asks for more memory than there is. All pairs of 120 000 points are 14 400 000 000 "
        "numbers: go point by point, or cell by cell.",
    ),
    (
        "AttributeError",
        r"'int' object has no attribute '(choice|integers|permutation)'",
        "rng may be a whole number: begin with rng = np.random.default_rng(rng).",
    ),
    (
        "AttributeError",
        r"'list' object has no attribute",
        "This is a list, not an array: wrap it in np.array(...).",
    ),
    (
        "NotImplementedError",
        r"",
        "The stub is still there: replace `raise NotImplementedError` with your code.",
    ),
    ("SystemExit", r"", "Leave out exit() and quit(): they end the whole notebook."),
    ("EOFError", r"", "Leave out input(): nobody sits at the keyboard when a notebook is judged."),
)


def tip_for(exception: str, message: str) -> str:
    """A tip for an exception.

    Parameters
    ----------
    exception : str
        Name of its type.
    message : str

    Returns
    -------
    str
        Empty where there is nothing helpful to say.
    """
    return next(
        (tip for name, pattern, tip in _TIPS if name == exception and re.search(pattern, message)),
        "",
    )
