"""Explanations in plain words for the exceptions that beginners meet."""

import linecache
import re
from collections.abc import Callable
from types import CodeType

_WHOLE = "An index must be a whole number: use //, int(...) or .astype(int)."

# (exception, pattern of its message, pattern of the student's line, tip). The first match is used,
# so special cases come before general ones.
_TIPS = (
    (
        "NameError|UnboundLocalError",
        r"(cannot access|referenced) .*(local|free) variable|local variable",
        "",
        "This name gets its value further down in the same function, or in a branch that was not "
        "taken. Give it one before the first use.",
    ),
    (
        "NameError",
        r"does not define it",
        "",
        "The cell with the function is missing, was not run, or the function has another name.",
    ),
    (
        "NameError",
        r"name '(\w+)' is not defined",
        "",
        "Python does not know this name: is it spelt as where you made it, and did you run that "
        "cell? Inside a function, use its parameters.",
    ),
    (
        "TypeError",
        r"unexpected keyword argument",
        "",
        "A parameter has another name than the call gives it. Keep the names in the first line of "
        "the function as given.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes (from )?\d+ .*positional",
        r"\(",
        "This line gives a function more or fewer values than it takes. An array of two points is "
        "one value: f(points[i], points[j]), or f(*pair) to hand over its rows one by one.",
    ),
    (
        "TypeError",
        r"missing \d+ required positional|takes (from )?\d+ .*positional",
        "",
        "A function is called with more or fewer values than its first line has. Keep the first "
        "line of yours, defaults included, as given.",
    ),
    (
        "TypeError",
        r"cannot unpack non-iterable NoneType",
        "",
        "The right-hand side is None and cannot be taken apart. A function gives None where it "
        "ends without `return`, or returns None on purpose: look whether it is None first.",
    ),
    (
        "AttributeError|TypeError",
        r"'?NoneType'?",
        "",
        "Something in this line is None: the result of a function without `return`, or an empty "
        "place, such as the child of a leaf. Look whether it is None before you use it.",
    ),
    (
        "TypeError",
        r"only (length-1|0-dimensional|size-1) arrays can be converted",
        r"\bmath\.",
        "The functions of `math` take one number. For a whole array take NumPy's: np.sqrt, "
        "np.cos, np.floor.",
    ),
    (
        "TypeError",
        r"only (length-1|0-dimensional|size-1) arrays can be converted",
        "",
        "A single number is asked for here, and this is a whole array: take one of its values, or "
        "a function of NumPy's.",
    ),
    (
        "TypeError",
        r"(ufunc 'bitwise_xor' not supported|unsupported operand type\(s\) for \^)",
        "",
        "`^` is not a power in Python: x**2 is the square.",
    ),
    (
        "TypeError",
        r"(ufunc 'bitwise_(and|or)' not supported|unsupported operand type\(s\) for [&|])",
        "",
        "& and | are worked out before < and >: put each comparison in parentheses, "
        "(a > 1) & (b < 2).",
    ),
    (
        "TypeError",
        r"ufunc 'invert' not supported",
        "",
        "~ turns round a mask, True into False, and these are numbers. It belongs inside the "
        "brackets: cloud[~mask].",
    ),
    (
        "ValueError",
        r"truth value of an array",
        r"[^&|]*[<>]=?.*[&|]",
        "Each comparison beside & and | needs parentheses of its own: (a > 1) & (b < 2).",
    ),
    (
        "ValueError",
        r"truth value of an array",
        "",
        "Python's if, while, and, or, not want one True or False, and this is one for each "
        "element. Combine masks with & and |, each side in parentheses, and turn one round with ~; "
        "or take .any() or .all().",
    ),
    (
        "TypeError",
        r"'(numpy\.ndarray|int|float|list|tuple|numpy\.float64|numpy\.int64|bool)' object is not "
        r"callable",
        "",
        "Round brackets call a function, and this is a value. Either square brackets are meant, "
        "x[i], or a variable took the name of a function, such as sum, max or list.",
    ),
    (
        "TypeError",
        r"'(builtin_function_or_method|function|type|method)' object is not subscriptable",
        "",
        "Square brackets stand behind a function: call it with round ones.",
    ),
    (
        "TypeError",
        r"'(int|float|numpy\.float64|numpy\.int64)' object is not (iterable|subscriptable)",
        "",
        "This is one number, not an array or a list: it has no elements.",
    ),
    (
        "TypeError",
        r"can't multiply sequence by non-int|unsupported operand type\(s\) for .: 'list'|"
        r"'[<>]=?' not supported between instances of 'list'|list indices must be integers",
        "",
        "This is a list. Lists do not calculate and take no masks: wrap it in np.array(...).",
    ),
    (
        "AttributeError",
        r"'list' object has no attribute '(shape|min|max|sum|mean|astype|any|all|copy|ndim|T)'",
        "",
        "This is a list, not an array: wrap it in np.array(...).",
    ),
    ("TypeError", r"'float' object cannot be interpreted as an integer", "", _WHOLE),
    ("TypeError", r"only integer|integer scalar arrays|slice indices must be", "", _WHOLE),
    ("IndexError", r"only integers|of integer \(or boolean\) type", "", _WHOLE),
    (
        "TypeError",
        r"unhashable type: '(numpy.ndarray|list)'",
        "",
        "An array or a list cannot be a dictionary key or a set member: use tuple(...).",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 0; "
        r"(size of axis|dimension) is \d+ but .* (is|dimension is) [34]$",
        "",
        "The mask and the array have different lengths: a mask fits the array that it was made "
        "from. Three or four values may be one value for each column: a column of the cloud is "
        "cloud[:, 0], while cloud[0] is a row; and axis=1 goes along a row.",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 0; "
        r"(size of axis|dimension) is \d+ but .* (is|dimension is) 2$",
        "",
        "The mask and the array have different lengths: a mask fits the array that it was made "
        "from. Two values may be one for each of two columns; axis=1 goes along a row.",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 1; "
        r"(size of axis|dimension) is 4 but .* (is|dimension is) 3$",
        r"^(?!.*\[:, *[^:\d ]).+",
        "This mask is a table, with one value for each coordinate. A point needs one value: "
        ".all(axis=1) makes one of each row, or .any(axis=1).",
    ),
    (
        "IndexError",
        r"boolean index did not match indexed array along (axis|dimension) 1",
        "",
        "The mask stands where columns are chosen. Points are rows: cloud[mask].",
    ),
    (
        "IndexError",
        r"boolean index did not match",
        "",
        "The mask and the array have different lengths: a mask fits the array that it was made "
        "from.",
    ),
    (
        "IndexError",
        r"index 3 is out of bounds for axis 1 with size 3",
        "",
        "The cloud may have three columns: not every recording has intensity.",
    ),
    (
        "IndexError",
        r"too many indices for array",
        "",
        "The array has fewer dimensions than the brackets name: a single point is p[0], not "
        "p[:, 0].",
    ),
    (
        "IndexError",
        r"out of bounds|out of range",
        "",
        "An index points past the end: the last one is len(...) - 1, and of nothing there is none.",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((?![34],)(\d+),([34])\) \(\1,\)",
        "",
        "One number for each row has to become a column first: counts[:, None].",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((\d+),([34])\) \((?!\1,)\d+,\2\)",
        "",
        "These are two tables with different numbers of rows: should one be a single point? An "
        "index that is an array takes many rows. (append puts an array into a queue as one entry; "
        "extend puts in its numbers one by one, but np.where gives a tuple that holds the array: "
        "np.flatnonzero gives the array itself.)",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \([01],[34]\) \(\d+,\)",
        "",
        "One side is a table of no row, or of one. Was a row taken by True or False, an entry of a "
        "mask, in place of its number? np.flatnonzero(mask) lists the numbers.",
    ),
    (
        "ValueError",
        r"not broadcastable to correct shape",
        "",
        "np.add.at(sums, which, rows) needs an entry of `which` for each of the rows, and in sums "
        "a row for each kind, with as many columns: np.zeros((kinds, columns)). Compare the "
        "shapes. (np.unique takes rows apart without axis=0, and returns values, inverse, counts "
        "in this order.)",
    ),
    (
        "ValueError",
        r"operands could not be broadcast together with shapes \((?!3,)(\d+,)?4\) \(3,\)|"
        r"operands could not be broadcast together with shapes \((?!4,)(\d+,)?3\) \(4,\)",
        "",
        "One side has x, y, z, the other has intensity, too: take [:, :3] of a cloud, [:3] of a "
        "point.",
    ),
    (
        "ValueError",
        r"\(size (3 is different from 4|4 is different from 3)\)|"
        r"not aligned: (3 \(dim \d\) != 4|4 \(dim \d\) != 3)",
        "",
        "A product needs as many numbers on both sides: x, y, z of a point, [:, :3] of a cloud, "
        "and the first three numbers of a plane.",
    ),
    (
        "ValueError",
        r"could not broadcast input array",
        "",
        "What stands on the right of = has another shape than the place that it is written to. "
        "The message names both, the right one first.",
    ),
    (
        "ValueError",
        r"could not be broadcast",
        "",
        "The two shapes in the message do not fit: seen from the right, they must be equal or 1. "
        "(n, 3) with (3,) works, (n, 3) with (n,) does not.",
    ),
    (
        "ValueError",
        r"zero-size array|need at least one array|arg(min|max) of an empty|empty sequence|"
        r"empty iterable",
        "",
        "Here there is nothing to take the smallest or largest of, or to stack: a cloud can be "
        "empty, and a label that does not occur has no rows.",
    ),
    (
        "ValueError",
        r"cost matrix is infeasible",
        "",
        "With infinity for what may not be, some row has nobody left to go to. Write a huge "
        "number there, and leave out the pairs that have it.",
    ),
    (
        "ValueError",
        r"read-only",
        "",
        "The input must stay as it is: work on a copy.",
    ),
    (
        "ValueError",
        r"too many values to unpack \(expected 3",
        # Only a name, one of its elements or its transpose: a call may return anything.
        r"(=|\bin)\s*(?=[^=]*(\.T\b|point|cloud|row|\b[pq]\b))[\w.]+(\[[^()]*\])*(\.T)?\s*:?\W*$",
        "There are more than three values on the right. A row of a cloud has four: x, y, z and the "
        "intensity. Take [:3] of a row, [:, :3] of a cloud.",
    ),
    (
        "ValueError",
        r"(too many|not enough) values to unpack",
        "",
        "The left-hand side has more or fewer names than there are values on the right.",
    ),
    (
        "RecursionError",
        r"",
        "",
        "The function calls itself about a thousand times, and there Python stops: does it ever "
        "reach the case that ends it? What goes deep by nature is written as a loop.",
    ),
    (
        "MemoryError",
        r"",
        "",
        "That asks for more memory than there is. All pairs of 120 000 points are 14 400 000 000 "
        "numbers: go point by point, or cell by cell.",
    ),
    (
        "AttributeError",
        r"'int' object has no attribute '(choice|integers|permutation|random|shuffle)'",
        "",
        "rng may be a whole number: begin with rng = np.random.default_rng(rng).",
    ),
    (
        "AttributeError",
        r"'KdTree' object has no attribute '(point|index|left|right)'",
        "",
        "A tree has a root and nothing else; point, index, left and right are those of a node. "
        "Begin at tree.root.",
    ),
    (
        "ValueError",
        r"larger sample than population|a (must be a positive integer|cannot be empty) unless",
        "",
        "More rows are to be drawn here than there are to draw from: look at len(points) first, "
        "and draw from all of them.",
    ),
    (
        "ValueError",
        r"index .*exceeds matrix dimension",
        "",
        "A pair names a node that is not there: of `count` nodes the last is count - 1. Do count "
        "and pairs speak of the same things, points, cells or pieces?",
    ),
    (
        "TypeError",
        r"'[<>]=?' not supported between instances of .*'tuple'",
        "",
        "A function that returns two things gives a pair: take it apart, one, other = f(...), or "
        "take the first of them, f(...)[0].",
    ),
    (
        "ValueError",
        r"incompatible dimensions for cross product|must be \(arrays of\) 3-dimensional",
        "",
        "np.cross takes x, y, z and nothing more: leave out the intensity, with [:, :3] of a "
        "cloud or [:3] of a point.",
    ),
    (
        "ValueError",
        r"math domain error|expected a positive input",
        r"\blog",
        "0 has no logarithm, and no negative number has one: look at that case first. 1 - p is "
        "negative where p is above 1, which no chance is: w**s is a power, w*s a product.",
    ),
    (
        "LinAlgError",
        r"did not converge",
        "",
        "There is a NaN in this matrix, or an infinite number. The mean of no points is NaN, and "
        "so is np.cov of a single point: look at these cases first.",
    ),
    (
        "ZeroDivisionError",
        r"",
        r"\blog",
        "The logarithm of 1 is 0, by which nobody can divide: look at that case first. (1 minus "
        "something tiny is 1, too.)",
    ),
    ("SystemExit", r"", "", "Leave out exit() and quit(): they end the whole notebook."),
    (
        "EOFError",
        r"",
        "",
        "Leave out input(): nobody sits at the keyboard when a notebook is judged.",
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


def place_in(error: BaseException, function: Callable) -> tuple[str, str, str]:
    """Locate an exception in the student's own code.

    Parameters
    ----------
    error : BaseException
    function : callable
        The student's function.

    Returns
    -------
    name : str
        The function that raised it; empty if it is not one of the student's.
    place : str
        Such as "line 3 of the cell of ransac_line". If a helper raised it, the line of the call
        comes first and the line in the helper second.
    line : str
        The text of the line that raised it.
    """
    own, found = None, ("", "", "")
    for code, number in frames_of(error, function):
        line = linecache.getline(code.co_filename, number).strip()
        name = written_name(code)
        found = name, f"line {number} of the cell of {name}", line
        if name == getattr(function, "__name__", ""):
            own = found
    if own is None or own[0] == found[0]:
        return found
    # Naming only the helper could lead the student to change a helper that is right.
    return found[0], f"{own[1]}, `{own[2]}`, which calls {found[1]}", found[2]


def frames_of(error: BaseException, function: Callable) -> list[tuple[CodeType, int]]:
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


def written_name(code: CodeType) -> str:
    """Return the name after `def`; for a comprehension or lambda, of the function around it."""
    named = [part for part in code.co_qualname.split(".") if not part.startswith("<")]
    return named[-1] if named else code.co_name
