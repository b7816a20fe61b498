"""Explanations in plain words for the exceptions that beginners meet."""

import linecache
import re
from collections.abc import Callable
from types import CodeType

_WHOLE = "An index or a count must be a whole number: use //, int(...) or .astype(int)."

# (exceptions, pattern of the message, pattern of the student's line, tip). The first match is used,
# so special cases come before general ones.
_TIPS = (
    (
        "NameError|UnboundLocalError",
        r"(cannot access|referenced) .*(local|free) variable|local variable",
        "",
        "This name gets its value further down in the same function, or in a branch that did not "
        "run. Give it a value before you use it.",
    ),
    (
        "NameError",
        r"does not define it",
        "",
        "The cell with the function is missing or did not run, or the function has another name.",
    ),
    (
        "NameError",
        r"name '(\w+)' is not defined",
        "",
        "Python does not know this name. Check the spelling, and run the cell that defines it. "
        "Inside a function, use its parameters.",
    ),
    (
        "TypeError",
        r"unexpected keyword argument",
        "",
        "The function has another name for a parameter of this call. Check the spelling, and keep "
        "the first line of each exercise as it was given.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes (from )?\d+ .*positional",
        r"\(\*",
        "The star passes one argument for each row. Pass as many rows as the function has "
        "parameters.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes (from )?\d+ .*positional",
        r"\(",
        "This line passes more or fewer arguments than the function takes. An array of two points "
        "is one argument. Write f(points[i], points[j]), or f(*pair) to pass its rows separately.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes (from )?\d+ .*positional",
        "",
        "A function was called with more or fewer arguments than it takes. Keep the first line of "
        "your function as it was given, including the defaults.",
    ),
    (
        "TypeError",
        r"cannot unpack non-iterable NoneType",
        "",
        "The right-hand side is None, which cannot be unpacked. A function returns None if it ends "
        "without `return`. Some functions return None on purpose, so check for None first.",
    ),
    (
        "AttributeError|TypeError",
        r"'?NoneType'?",
        "",
        "Something in this line is None: the result of a function without `return`, or a line, "
        "plane or node that does not exist. Check for None before you use it.",
    ),
    (
        "TypeError",
        r"only (length-1|0-dimensional|size-1) arrays can be converted",
        r"\bmath\.",
        "The functions of `math` take a single number. For a whole array, use those of NumPy, such "
        "as np.sqrt, np.cos or np.floor.",
    ),
    (
        "TypeError",
        r"only (length-1|0-dimensional|size-1) arrays can be converted",
        "",
        "This line needs a single number but has a whole array. Pick one of its values, or use a "
        "NumPy function.",
    ),
    (
        "TypeError",
        r"(ufunc 'bitwise_xor' not supported|unsupported operand type\(s\) for \^)",
        "",
        "`^` does not mean power in Python. Write x**2 for the square of x.",
    ),
    (
        "TypeError",
        r"(ufunc 'bitwise_(and|or)' not supported|unsupported operand type\(s\) for [&|])",
        "",
        "Python evaluates & and | before < and >. Put each comparison in parentheses: "
        "(a > 1) & (b < 2).",
    ),
    (
        "TypeError",
        r"ufunc 'invert' not supported",
        "",
        "~ inverts a mask, but these are numbers. Put ~ inside the brackets, before the mask: "
        "cloud[~mask].",
    ),
    (
        "ValueError",
        r"truth value of an array",
        r"[^&|]*[<>]=?.*[&|]",
        "Each comparison next to & or | needs its own parentheses: (a > 1) & (b < 2).",
    ),
    (
        "ValueError",
        r"truth value of an array",
        "",
        "Python's `if`, `while`, `and`, `or` and `not` need a single True or False, but this array "
        "has one for each element. Combine masks with & and |, each side in parentheses, and "
        "invert a mask with ~. To get a single True or False, use .any() or .all().",
    ),
    (
        "TypeError",
        r"'(numpy\.ndarray|int|float|list|tuple|numpy\.float64|numpy\.int64|bool)' object is not "
        r"callable",
        "",
        "Round brackets call a function, but this is a value. To pick an element, use square "
        "brackets: x[i]. If a variable has the name of a function, such as sum, max or list, "
        "rename the variable.",
    ),
    (
        "TypeError",
        r"'(builtin_function_or_method|function|type|method)' object is not subscriptable",
        "",
        "This line has square brackets after a function. To call the function, use round ones: "
        "f(x).",
    ),
    (
        "TypeError",
        r"'(int|float|numpy\.float64|numpy\.int64)' object is not (iterable|subscriptable)",
        "",
        "This is a single number, not an array or a list. It has no elements.",
    ),
    (
        "TypeError",
        r"can't multiply sequence by non-int|unsupported operand type\(s\) for .: 'list'|"
        r"'[<>]=?' not supported between instances of 'list'|list indices must be integers",
        "",
        "This is a list. Lists support neither arithmetic nor masks, so convert it with "
        "np.array(...).",
    ),
    (
        "AttributeError",
        r"'list' object has no attribute '(shape|min|max|sum|mean|astype|any|all|copy|ndim|T)'",
        "",
        "This is a list, not an array. Convert it with np.array(...).",
    ),
    ("TypeError", r"'float' object cannot be interpreted as an integer", "", _WHOLE),
    ("TypeError", r"only integer|integer scalar arrays|slice indices must be", "", _WHOLE),
    ("IndexError", r"only integers|of integer \(or boolean\) type", "", _WHOLE),
    (
        "TypeError",
        r"unhashable type: '(numpy.ndarray|list)'",
        "",
        "An array or a list cannot be a dictionary key or a member of a set. Convert it with "
        "tuple(...).",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 0; "
        r"(size of axis|dimension) is \d+ but .* (is|dimension is) [34]$",
        "",
        "The mask and the array have different lengths. Use a mask only on the array from which "
        "you computed it. Does this mask have one value for each column? cloud[:, 0] is a column "
        "of the cloud, cloud[0] is a row, and axis=1 gives one value for each row.",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 0; "
        r"(size of axis|dimension) is \d+ but .* (is|dimension is) 2$",
        "",
        "The mask and the array have different lengths. Use a mask only on the array from which "
        "you computed it. If this mask has one value for each of two columns, use axis=1 to get "
        "one value for each row.",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 1; "
        r"(size of axis|dimension) is 4 but .* (is|dimension is) 3$",
        r"^(?!.*\[:, *[^:\d ]).+",
        "This mask is a table with one value for each coordinate, but a point needs one value. "
        "Reduce each row to one value with .all(axis=1) or .any(axis=1).",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 1",
        "",
        "The mask is in the place that selects columns. Points are rows: cloud[mask].",
    ),
    (
        "IndexError",
        r"boolean index did not match",
        "",
        "The mask and the array have different lengths. Use a mask only on the array from which "
        "you computed it.",
    ),
    (
        "IndexError",
        r"index 3 is out of bounds for axis 1 with size 3",
        "",
        "Do not rely on column 3: the cloud has only three columns if the recording has no "
        "intensities.",
    ),
    (
        "IndexError",
        r"too many indices for array",
        "",
        "The array has fewer dimensions than the brackets have indices. For a single point, write "
        "p[0], not p[:, 0].",
    ),
    (
        "IndexError",
        r"out of bounds|out of range",
        "",
        "An index is past the end of the array or list. The last valid index is len(...) - 1, and "
        "an empty array has none.",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((?![34],)(\d+),([34])\) \(\1,\)",
        "",
        "Numbers that belong to the rows of a table must become a column first: counts[:, None].",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((\d+),([34])\) \((?!\1,)\d+,\2\)",
        "",
        "These are two tables with different numbers of rows. Should one be a single point? An "
        "index that is an array selects several rows. (If the index comes from a queue: append "
        "adds an array as one entry, and extend adds its numbers one by one. np.where returns a "
        "tuple around the array, and np.flatnonzero returns the array itself.)",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \([01],[34]\) \(\d+,\)",
        "",
        "One side is a table with one row or none. Is the index True or False, an entry of a mask, "
        "instead of the number of a row? np.flatnonzero(mask) lists the numbers.",
    ),
    (
        "ValueError",
        r"not broadcastable to correct shape",
        "",
        "np.add.at(sums, which, rows) needs one entry of `which` for each row of `rows`. `sums` "
        "needs a row for each group and as many columns as `rows`: np.zeros((groups, columns)). "
        "Compare the shapes. (Without axis=0, np.unique splits rows into single numbers. It "
        "returns values, inverse and counts in this order.)",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((?!3,)(\d+,)?4\) \(3,\)|"
        r"operands could not be broadcast together with shapes \((?!4,)(\d+,)?3\) \(4,\)",
        "",
        "One side has x, y and z; the other also has an intensity. Use cloud[:, :3] and point[:3].",
    ),
    (
        "ValueError",
        r"\(size (3 is different from 4|4 is different from 3)\)|"
        r"not aligned: (3 \(dim \d\) != 4|4 \(dim \d\) != 3)",
        "",
        "A product needs the same number of values on both sides. Use cloud[:, :3] or point[:3] "
        "with the first three numbers of a plane.",
    ),
    (
        "ValueError",
        r"could not broadcast input array",
        "",
        "The value on the right of = and the place where you store it have different shapes. The "
        "message names the shape of the value first.",
    ),
    (
        "ValueError",
        r"could not be broadcast",
        "",
        "The two shapes in the message do not match. Compare them from the right: in each pair, "
        "the numbers must be equal, or one must be 1. (n, 3) with (3,) works; (n, 3) with (n,) "
        "does not.",
    ),
    (
        "ValueError",
        r"zero-size array|need at least one array|arg(min|max) of an empty|empty sequence|"
        r"empty iterable",
        "",
        "This line takes the minimum or maximum of an empty array, or stacks an empty list. A "
        "cloud or a group of points can be empty, so handle that case first.",
    ),
    (
        "ValueError",
        r"cost matrix is infeasible",
        "",
        "Infinity forbids a pair, and one row has no allowed partner left. Use a huge number "
        "instead of infinity, and afterwards drop the pairs with that number.",
    ),
    (
        "ValueError",
        r"read-only",
        "",
        "The input must not change. Work on a copy.",
    ),
    (
        "ValueError",
        r"too many values to unpack \(expected 3",
        # Match only a name, one of its elements or its transpose: a call may return anything.
        r"(=|\bin)\s*(?=[^=]*(\.T\b|point|cloud|row|\b[pq]\b))[\w.]+(\[[^()]*\])*(\.T)?\s*:?\W*$",
        "There are more than three values on the right. A row of a cloud has four: x, y, z and the "
        "intensity. Use row[:3] or cloud[:, :3].",
    ),
    (
        "ValueError",
        r"(too many|not enough) values to unpack",
        "",
        "The left-hand side has more or fewer names than the right-hand side has values.",
    ),
    (
        "RecursionError",
        r"",
        "",
        "Python stops a function that calls itself about a thousand times. Does the function ever "
        "reach the case that ends the recursion? If it needs more calls for that, write a loop "
        "instead.",
    ),
    (
        "MemoryError",
        r"",
        "",
        "Your code needs more memory than is available. A table of all pairs of 120 000 points has "
        "14 400 000 000 entries. Work point by point, or cell by cell.",
    ),
    (
        "AttributeError",
        r"'int' object has no attribute '(choice|integers|permutation|random|shuffle)'",
        "",
        "rng may be a whole number. Begin with rng = np.random.default_rng(rng).",
    ),
    (
        "AttributeError",
        r"'KdTree' object has no attribute '(point|index|left|right)'",
        "",
        "A tree has only a root; point, index, left and right belong to a node. Begin at "
        "tree.root.",
    ),
    (
        "ValueError",
        r"larger sample than population|a (must be a positive integer|cannot be empty) unless",
        "",
        "This line draws more rows than the array has. Check len(points) first, and draw from all "
        "the points.",
    ),
    (
        "ValueError",
        r"index .*exceeds matrix dimension",
        "",
        "A pair contains a node that does not exist. With `count` nodes, the last is count - 1. Do "
        "`count` and the pairs refer to the same things: points, cells or pieces?",
    ),
    (
        "TypeError",
        r"'[<>]=?' not supported between instances of .*'tuple'",
        "",
        "A function that returns two values returns a pair. Unpack the pair with first, second = "
        "f(...), or take only the first value with f(...)[0].",
    ),
    (
        "ValueError",
        r"incompatible dimensions for cross product|must be \(arrays of\) 3-dimensional",
        "",
        "np.cross takes only x, y, z. Leave out the intensity with cloud[:, :3] or point[:3].",
    ),
    (
        "ValueError",
        r"math domain error|expected a positive input",
        r"\blog",
        "Zero and negative numbers have no logarithm. Handle that case first. If 1 - p is "
        "negative, p is above 1 and not a probability. Did you write w*s (a product) instead of "
        "w**s (a power)?",
    ),
    (
        "LinAlgError",
        r"did not converge",
        "",
        "This matrix contains NaN or an infinite number. The mean of no points is NaN, and so is "
        "np.cov of a single point. Handle these cases first.",
    ),
    (
        "ZeroDivisionError",
        r"",
        r"\blog",
        "The logarithm of 1 is 0, and you cannot divide by 0. Handle that case first. (1 minus a "
        "tiny number is rounded to 1.)",
    ),
    ("SystemExit", r"", "", "Delete exit() and quit(): they end the whole notebook."),
    (
        "EOFError",
        r"",
        "",
        "Delete input(): no one is at the keyboard when a notebook is judged.",
    ),
)


def tip_for(exception: str, message: str, line: str = "") -> str:
    """Return a tip for an exception.

    Parameters
    ----------
    exception : str
        Name of its type.
    message : str
    line : str
        The line of the student's code that raised it, if known.

    Returns
    -------
    str
        The tip; empty if there is none.
    """
    return next(
        (
            tip
            for kinds, pattern, code, tip in _TIPS
            if exception in kinds.split("|")
            and re.search(pattern, message)
            and re.search(code, line)
        ),
        "",
    )


def locate(error: BaseException, function: Callable) -> tuple[str, str, str]:
    """Locate an exception in the student's own code.

    Parameters
    ----------
    error : BaseException
    function : callable
        The student's function.

    Returns
    -------
    name : str
        Name of the function that raised it; empty if no code of the student was running.
    place : str
        For example "line 3 of the cell of ransac_line". If a helper raised it, the line of the
        call comes first and the line in the helper second.
    line : str
        The text of the line that raised it.
    """
    own, found = None, ("", "", "")
    for code, number in student_frames(error, function):
        line = linecache.getline(code.co_filename, number).strip()
        name = function_name(code)
        found = name, f"line {number} of the cell of {name}", line
        if name == getattr(function, "__name__", ""):
            own = found
    if own is None or own[0] == found[0]:
        return found
    # Naming only the helper could lead the student to change a helper that is right.
    return found[0], f"{own[1]}, `{own[2]}`, which calls {found[1]}", found[2]


def unwritten_function(error: BaseException | None, function: Callable) -> str:
    """Return the name of the stub that raised an exception; empty for any other exception."""
    if not isinstance(error, NotImplementedError):
        return ""
    # A notebook wraps each stub, and the wrapper's error contains the name (`utils.lent`).
    return getattr(error, "missing_function", "") or locate(error, function)[0]


def student_frames(error: BaseException, function: Callable) -> list[tuple[CodeType, int]]:
    """Return the frames of an exception in the student's code: code and line, outermost first.

    Parameters
    ----------
    error : BaseException
    function : callable
        The student's function or class.
    """
    methods = getattr(function, "__dict__", {}).values()  # if it is a class
    homes = [part.__globals__ for part in (function, *methods) if hasattr(part, "__globals__")]
    found, trace = [], error.__traceback__
    while trace is not None:
        if any(trace.tb_frame.f_globals is home for home in homes):
            found.append((trace.tb_frame.f_code, trace.tb_lineno))
        trace = trace.tb_next
    return found


def function_name(code: CodeType) -> str:
    """Return a function's name; for a comprehension or lambda, the name of the outer function."""
    named = [part for part in code.co_qualname.split(".") if not part.startswith("<")]
    return named[-1] if named else code.co_name
