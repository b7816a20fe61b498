"""Assertions shared by the checks of many exercises.

Each assertion compares an answer with the expected one. Its failure says what differs and where,
and can draw the difference. Answers are accepted in any reasonable form: lists instead of arrays,
float32, or different labels for the same clusters.

Checks refer to `utils.plots` by its full name instead of importing names from it. It is then loaded
only when the first picture is drawn. Importing matplotlib is slow, and the judge does not need it.
"""

import contextlib
import copy
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import attrgetter

import numpy as np
from numpy.typing import ArrayLike

import utils
from utils.checks.failures import AnswerTooLarge, CheckFailed, NotYet, WrongForm, fixed
from utils.checks.size_limits import MAX_NUMBERS, NotNumbers, TooLarge, as_numbers, short_text
from utils.remote_objects import ObservedCall, RemoteProxy

# Metres. At the range of a LiDAR, rounding to single precision moves a point by less than this.
TOLERANCE = 1e-3


@contextlib.contextmanager
def precondition(requirement: str) -> Iterator[None]:
    """Turn a failure inside the context, which tests a precondition, into `NotYet`.

    Parameters
    ----------
    requirement : str
        The precondition, as a clause: "the right points are kept".
    """
    try:
        yield
    except (WrongForm, NotYet):
        raise
    except CheckFailed as failure:
        raise NotYet(requirement, failure) from None


def frozen(value: object) -> object:
    """Return a read-only copy, so that a constant cannot be changed by accident.

    Parameters
    ----------
    value : object
        An array, or a tuple of arrays.

    Returns
    -------
    object
        A read-only array, or a tuple of them.
    """
    if isinstance(value, tuple):
        return tuple(frozen(item) for item in value)
    array = np.array(value)
    array.flags.writeable = False
    return array


def parse_table(text: str) -> np.ndarray:
    """Return a read-only array of the rows of numbers in a text, such as ``"1 2 0.5; 3 4 0.5"``."""
    return frozen(np.array([row.split() for row in text.split(";")], dtype=float))


def parse_marked_points(text: str, *last: float) -> tuple[np.ndarray, np.ndarray]:
    """Parse a text such as ``"8 8 -; 6.5 6.5 +"`` into points and a mask.

    Parameters
    ----------
    text : str
        Rows of numbers, each followed by a plus (True in the mask) or a minus (False).
    last : float
        Numbers that are appended to every row.
    """
    rows = [row.split() for row in text.split(";")]
    points = np.array([[*row[:-1], *last] for row in rows], dtype=float)
    return frozen(points), frozen(np.array([row[-1] == "+" for row in rows]))


def brief_text(value: object) -> str:
    """Return a value as text of at most 90 characters; rows of up to 20 numbers stay complete."""
    if isinstance(value, np.generic):
        value = value.item()  # 2, not np.int64(2)
    if isinstance(value, np.ndarray) and value.ndim == 1 and value.size <= 20:
        return np.array2string(value, precision=3, separator=", ", max_line_width=10**6)
    if isinstance(value, np.ndarray):
        # NumPy shows the corners of an array. Their number doubles with each dimension.
        shown = value if value.ndim <= 3 else value.reshape(-1)
        text = np.array2string(shown, precision=3, threshold=12, edgeitems=3, separator=", ")
        text = f"shape {value.shape}: {' '.join(text.split())}"
    else:
        text = short_text(value)  # a list may be long and contain longer lists
    return text if len(text) <= 90 else text[:87] + "..."


def point_text(point: ArrayLike, digits: int = 2) -> str:
    """Return a point as text, (x, y) or (x, y, z), with rounded coordinates.

    Parameters
    ----------
    point : array_like, shape (2,), (3,) or (4,)
        A fourth number is ignored.
    digits : int
        Number of decimal places.
    """
    return "(" + ", ".join(f"{value:.{digits}f}" for value in point[:3]) + ")"


def points_text(points: np.ndarray, digits: int = 2) -> str:
    """Return points as text, such as "(1, 2, 0), (3, 4.5, 0)".

    Parameters
    ----------
    points : numpy.ndarray, shape (n, 3) or (n, 4)
        A fourth column is ignored.
    digits : int
        Largest number of decimal places.
    """
    rounded = (np.round(np.asarray(points, dtype=float)[:, :3], digits) + 0.0).tolist()
    return ", ".join(f"({x:.6g}, {y:.6g}, {z:.6g})" for x, y, z in rounded) or "none"


# NumPy wraps a value of these types in an array without reading it; list(...) reads it.
_UNREAD_TYPES = ("generator", "map", "filter", "zip", "set", "dict_keys", "dict_values")
_CUSTOM_CLASS = "an object of a custom class"  # the type name that the judge receives
# Explanations of other types that students return.
_TYPE_EXPLANATIONS = {
    "coroutine": (
        "The function returned a coroutine, and its body has not run. Delete `async` before `def`."
    ),
    "MaskedArray": (
        "The function returned a masked array. It hides values but still contains them. Return "
        "an ordinary array, for example cloud[mask]."
    ),
    "dict": (
        "The function returned a dict. Return its values as an array, for example "
        "np.array(list(result.values()))."
    ),
    _CUSTOM_CLASS: "The function returned an object of your own class. Return an array of numbers.",
}


def metres_text(distance: float, digits: int = 2) -> str:
    """Return a distance as text, such as "1.41 m"."""
    return f"{distance:.{digits}f} m"


def distinct_texts(
    to_text: Callable[[object, int], str], yours: object, expected: object
) -> tuple[str, str]:
    """Return two values as texts with enough digits to make the texts differ.

    Parameters
    ----------
    to_text : callable
        Takes a value and the number of decimal places; returns a text.
    yours, expected : object
    """
    for digits in range(2, 8):
        texts = to_text(yours, digits), to_text(expected, digits)
        if texts[0] != texts[1]:
            break
    return texts


def as_array(
    answer: object,
    columns: int | None = None,
    description: str = "an array",
    max_count: int = MAX_NUMBERS,
    row_noun: str = "point",
) -> np.ndarray:
    """Convert an answer to a numeric array.

    Parameters
    ----------
    answer : object
    columns : int, optional
        Require shape (n, columns).
    description : str
        The expected kind of answer, for the message.
    max_count : int
        As for `utils.checks.size_limits.as_numbers`.
    row_noun : str
        What one row describes, for the message.

    Raises
    ------
    WrongForm
        If the answer is None, not numeric, too large or of the wrong shape.
    """
    if answer is None:
        raise WrongForm(
            "The function returned None. End every path through it with `return` and the result.",
            yours="None",
            expected=description,
        )
    try:
        array = as_numbers(answer, max_count)
    except TooLarge as error:
        raise AnswerTooLarge(str(error), yours=brief_text(answer), expected=description) from None
    except NotNumbers:
        # In the judge, objects of other types arrive as stand-ins with a `type_name`. The student
        # chose that name, so it must not be part of the message.
        kind = getattr(answer, "type_name", "") or type(answer).__name__
        if type(answer).__module__ == "__main__":  # a class in the notebook
            kind = _CUSTOM_CLASS
        if kind in _UNREAD_TYPES:
            raise WrongForm(
                f"The function returned a {kind} instead of {description}. "
                "Convert it with list(...).",
                yours=f"a {kind}",
                expected=description,
            ) from None
        if about := _TYPE_EXPLANATIONS.get(kind):
            raise WrongForm(about, yours=kind, expected=description) from None
        pair = isinstance(answer, tuple) and len(answer) == 2
        raise WrongForm(
            f"The function must return {description}{', not a pair' if pair else ''}.",
            yours=f"{kind}: {brief_text(answer)}",
            expected=description,
        ) from None
    if columns is not None:
        if row_noun == "point" and _is_result_of_where(answer):
            raise WrongForm(
                "These are row numbers in a tuple, as np.where returns them. Return the rows "
                "themselves: cloud[mask].",
                yours=brief_text(array[0]),
                expected=description,
            )
        if array.size == 0 and array.ndim == 1:
            array = array.reshape(0, columns)
        if array.ndim != 2 or array.shape[1] != columns:
            raise WrongForm(
                _explain_row_shape(array, columns, row_noun),
                yours=f"{array.dtype} numbers of shape {array.shape}",
                expected=f"shape (n, {columns})",
            )
    return array


def _is_result_of_where(answer: object) -> bool:
    """Return whether an answer is a tuple with one array of row numbers, as `np.where` returns."""
    if not (isinstance(answer, tuple) and len(answer) == 1 and isinstance(answer[0], np.ndarray)):
        return False
    return answer[0].ndim == 1 and answer[0].dtype.kind == "i"


def _explain_row_shape(array: np.ndarray, columns: int, row_noun: str) -> str:
    """Explain why an array does not have one row for each point or other object."""
    is_cloud = row_noun == "point"
    if is_cloud and array.dtype.kind in "iu" and array.ndim == 1:
        return "If these are row numbers, return the rows themselves: cloud[rows]."
    if is_cloud and array.dtype.kind == "b" and array.ndim == 1:
        return "This is a mask, with True or False for each point. Return the rows: cloud[mask]."
    if array.ndim == 2 and array.shape[0] == columns:
        return (
            f"The answer has {columns} rows, as if each {row_noun} were a column. Return one row "
            f"per {row_noun}, with {columns} columns."
        )
    return f"The shape is {array.shape}. Return one row per {row_noun}, with {columns} columns" + (
        ", as in the input." if is_cloud else "."
    )


def as_shape(
    yours: np.ndarray, expected: tuple[int, ...], content: str, columns: int = 0
) -> np.ndarray:
    """Return an answer in the expected shape, or raise an error that explains a common slip.

    If no rows are expected, any array without rows is accepted.

    Parameters
    ----------
    yours : numpy.ndarray
    expected : tuple of int
    content : str
        The required content, such as "one distance for each of the 5 points".
    columns : int
        Number of columns of the input cloud; 0 if the input is not a cloud.

    Returns
    -------
    numpy.ndarray, of shape `expected`

    Raises
    ------
    WrongForm
        If the shape is different.
    """
    if yours.shape == expected or (yours.shape[:1] == (0,) == expected[:1]):
        return yours.reshape(expected)
    n, shape = expected[0] if expected else 0, yours.shape
    words = ""
    if len(expected) == 1:
        if shape == () and n > 1:
            words = f" This is one number for all points, so {fixed('axis=1')} may be missing."
        elif shape == (n, 1):
            words = fixed(
                " Shape (n, 1) is a table with one column. Select it with [:, 0], or leave out the "
                "None in [:, None]."
            )
        elif shape == (1, n):
            words = fixed(" Shape (1, n) is a table with one row. Select it with [0].")
        elif n > 1 and shape == (n, n):
            words = fixed(
                " Shape (n, n) results from combining (n, 1) and (n,). Both must be (n,)."
            )
        elif columns and shape == (columns,):
            words = f" There are {columns} numbers, one for each column. Use {fixed('axis=1')}."
    raise WrongForm(
        f"There must be {content}.{words}", yours=f"shape {shape}", expected=f"shape {expected}"
    )


def assert_rows(answer: object, cloud: np.ndarray, keep: np.ndarray, view: str = "side") -> None:
    """Assert that the answer is exactly the rows ``cloud[keep]``, in order.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    keep : numpy.ndarray of bool, shape (n,)
        The rows that a right answer keeps.
    view : {"side", "above"}
        Viewpoint of the picture.
    """
    yours = as_array(answer, columns=cloud.shape[1], description="an array of rows of the cloud")
    expected = cloud[keep]
    if yours.shape == expected.shape and _is_close(yours, expected):
        return
    sides = {"yours": _row_count_text(yours), "expected": _row_count_text(expected)}
    if len(yours) > len(cloud):
        raise CheckFailed("The answer has more rows than the cloud.", **sides)
    mine = _membership(cloud, yours)
    if mine is None:
        raise CheckFailed(
            "Some of the returned rows are not rows of the cloud: their values changed.",
            yours=brief_text(yours),
            expected=brief_text(expected),
            hint="Keep or drop whole rows, and do not write into them.",
        )
    if len(yours) == len(expected) and np.array_equal(mine, keep):
        raise CheckFailed(
            "The rows are right, but in the wrong order.",
            **sides,
            hint="Index with a mask, cloud[mask], which keeps the order.",
        )
    missing, extra = np.flatnonzero(keep & ~mine), np.flatnonzero(mine & ~keep)
    parts = []
    if len(missing):
        parts.append(
            f"{_row_count_text(missing)} missing, for example {point_text(cloud[missing[0]])}"
        )
    if len(extra):
        parts.append(
            f"{_row_count_text(extra)} too many, for example {point_text(cloud[extra[0]])}"
        )
    if not parts and len(yours) < len(expected):
        parts.append("rows that occur twice are kept only once")
    message = "; ".join(parts) or "some rows occur more than once"
    raise CheckFailed(
        message[0].upper() + message[1:] + ".",
        **sides,
        draw=lambda: utils.plots.difference(cloud, mine, keep, view=view),
    )


def assert_positions(
    answer: object,
    cloud: np.ndarray,
    keep: np.ndarray,
    view: str = "side",
    input_text: str | None = None,
    points_to_text: Callable[[np.ndarray], str] | None = None,
) -> None:
    """Assert that the answer contains the points of ``cloud[keep]``, in any order.

    Only x, y and z are compared.

    Parameters
    ----------
    answer : object
        Rows of three columns, or of as many as the cloud has.
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    keep : numpy.ndarray of bool, shape (n,)
        The rows that a right answer keeps.
    view : {"side", "above"}
        Viewpoint of the picture.
    input_text : str, optional
        The arguments of the call, for the message.
    points_to_text : callable, optional
        Takes points, shape (m, 3), and returns a short text. By default, the text is their number.
    """
    yours, places = _positions(answer, cloud), cloud[:, :3]
    expected = places[keep]
    if len(yours) == len(expected) and _is_close(yours, expected):
        return
    mine = _membership(places, yours) if len(yours) <= len(cloud) else None
    if mine is not None and len(yours) == len(expected) and np.array_equal(mine, keep):
        return
    try:
        assert_rows(yours, places, keep, view)
    except CheckFailed as failure:
        if points_to_text and len(yours) <= len(cloud):
            failure.yours, failure.expected = points_to_text(yours), points_to_text(expected)
        failure.input_text = input_text
        raise


def assert_order(answer: object, cloud: np.ndarray, keep: np.ndarray) -> None:
    """Assert that the rows of ``cloud[keep]`` keep their order.

    Parameters
    ----------
    answer, cloud, keep : object
        As for `assert_positions`.
    """
    with precondition("the right points are kept"):
        assert_positions(answer, cloud, keep)
    yours, expected = _positions(answer, cloud), cloud[keep, :3]
    if not _is_close(yours, expected):
        row = np.flatnonzero(~np.isclose(yours, expected, rtol=0, atol=TOLERANCE).all(axis=1))[0]
        mine, right = distinct_texts(point_text, yours[row], expected[row])
        raise CheckFailed(
            "The rows are right, but in the wrong order.",
            yours=f"row {row} is {mine}",
            expected=f"row {row} is {right}",
        )


def assert_all_columns(answer: object, cloud: np.ndarray, keep: np.ndarray) -> None:
    """Assert that the rows of ``cloud[keep]`` have all their columns, including intensity.

    Parameters
    ----------
    answer, cloud, keep : object
        As for `assert_positions`.
    """
    with precondition("the right points are kept"):
        assert_positions(answer, cloud, keep)
    yours, columns = as_array(answer), cloud.shape[1]
    if yours.ndim != 2 or yours.shape[1] != columns:
        raise CheckFailed(
            "The remaining rows do not have the columns of the cloud.",
            yours=f"shape {yours.shape}",
            expected=f"shape {cloud[keep].shape}",
        )
    if _membership(cloud, yours) is None:
        raise CheckFailed(
            "The coordinates are right, but the values in the other columns are not.",
            yours=brief_text(yours),
            expected=brief_text(cloud[keep]),
        )


def assert_empty_table(answer: object, cloud: np.ndarray, columns: int) -> None:
    """Assert that the answer is a table that has columns but no rows.

    Parameters
    ----------
    answer : object
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
        The input of the function.
    columns : int
        Number of columns that the function returns when it keeps rows. Another check tests
        whether that number is right.
    """
    wanted = "an array without rows"
    yours = as_array(answer, description=wanted)
    if yours.ndim != 2 or yours.shape[1] != columns:
        yours = as_array(answer, columns=cloud.shape[1], description=wanted)
    if len(yours):
        raise CheckFailed(
            "No rows should be left.",
            yours=f"{len(yours)} row{'s' if len(yours) != 1 else ''}",
            expected="0 rows",
        )


def _positions(answer: object, cloud: np.ndarray) -> np.ndarray:
    """Return x, y and z from rows of a cloud, which may lack the other columns."""
    wanted = "an array of rows of the cloud"
    yours = as_array(answer, description=wanted)
    if yours.ndim == 2 and yours.shape[1] == 3:
        return yours
    return as_array(answer, columns=cloud.shape[1], description=wanted)[:, :3]


def assert_same_set_of_rows(answer: object, expected: np.ndarray) -> None:
    """Assert that the answer consists of the rows of `expected`, in any order.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray, shape (n, columns)
    """
    yours = as_array(answer, columns=expected.shape[1], description="an array of points")
    if len(yours) != len(expected):
        raise CheckFailed(
            f"The function returned {len(yours)} rows instead of {len(expected)}.",
            yours=f"{len(yours)} rows",
            expected=f"{len(expected)} rows",
        )
    if len(expected) and not np.isfinite(yours).all():
        raise CheckFailed("Some values are not finite.", yours=brief_text(yours))
    if not len(expected):
        return
    from scipy.spatial import cKDTree

    distances, partners = cKDTree(expected).query(yours)
    # cKDTree returns the index n if the distance overflows.
    partners = np.minimum(partners, len(expected) - 1)
    extra = np.flatnonzero(distances > TOLERANCE)
    if len(extra):
        row, partner = yours[extra[0]], expected[partners[extra[0]]]
        raise CheckFailed(
            f"{_row_count_text(extra)} should not be there.",
            yours=f"for example {brief_text(row)}",
            expected=f"the nearest right row is {brief_text(partner)}",
        )
    if len(np.unique(partners)) < len(expected):
        raise CheckFailed("Some rows occur twice, and others are missing.")


def as_labels(answer: object, n: int, noun: str = "points") -> np.ndarray:
    """Convert an answer to labels, which are whole numbers.

    Parameters
    ----------
    answer : object
    n : int
        Number of points.
    noun : str
        The labelled objects, if they are not points, for the message.

    Returns
    -------
    numpy.ndarray of int, shape (n,)
    """
    labels = as_array(answer, description="an array of labels")
    labels = as_shape(labels, (n,), f"one label for each of the {n} {noun}")
    if labels.dtype.kind == "b":
        raise WrongForm(
            f"This is a mask, with True or False for each of the {noun}. Labels are whole numbers.",
            yours=brief_text(labels),
        )
    if labels.dtype.kind == "f" and not np.array_equal(labels, np.round(labels)):
        raise WrongForm("Labels must be whole numbers.", yours=brief_text(labels))
    return labels.astype(np.int64)


def count_overlaps(labels: np.ndarray, other_labels: np.ndarray) -> tuple[int, int, int]:
    """Count the groups of two partitions, and the pairs of groups that share points.

    Parameters
    ----------
    labels, other_labels : numpy.ndarray of int, shape (n,)

    Returns
    -------
    tuple of int
        Number of pairs that share points, of groups in `labels`, and of groups in
        `other_labels`. The three are equal if and only if both partitions group the points in the
        same way.
    """
    groups, mine = np.unique(labels, return_inverse=True)
    other_groups, theirs = np.unique(other_labels, return_inverse=True)
    # Sorting one number per pair is ten times as fast as sorting pairs.
    pairs = np.unique(mine * len(other_groups) + theirs)
    return len(pairs), len(groups), len(other_groups)


def assert_partition(answer: object, expected: np.ndarray, cloud: np.ndarray) -> None:
    """Assert that the answer groups the points as `expected` does, whatever its labels.

    Parameters
    ----------
    answer : object
    expected : numpy.ndarray of int, shape (n,)
    cloud : numpy.ndarray, shape (n, 3) or (n, 4)
    """
    yours = as_labels(answer, len(cloud))
    shared, number_yours, number_expected = count_overlaps(yours, expected)
    if shared == number_yours == number_expected:
        return
    hint = ""
    split = shared > number_expected
    merged = shared > number_yours
    message = {
        (True, True): "Some clusters are split and others are merged.",
        (True, False): "Points that belong together have different labels.",
        (False, True): "Points of different clusters have the same label.",
    }[split, merged]
    if expected.all() and not yours.all():
        without = np.count_nonzero(yours == 0)
        message = f"{without} of {len(yours)} points have " + fixed(
            "the label 0, which means that they have no label yet."
        )
        hint = (
            "Labels start at 1. Loop over every point. A point without a label begins a new "
            "cluster."
        )
    raise CheckFailed(
        message,
        hint=hint,
        yours=f"{number_yours} clusters",
        expected=f"{number_expected} clusters",
        draw=lambda: utils.plots.worst(cloud, yours, expected),
    )


def assert_close(
    answer: object, expected: ArrayLike, noun: str, tolerance: float = TOLERANCE
) -> None:
    """Assert that the answer has the expected shape and, within a tolerance, the expected values.

    Parameters
    ----------
    answer : object
    expected : array_like
    noun : str
        Plural noun for the numbers in the message, such as "distances".
    tolerance : float
        Largest absolute difference that is accepted.
    """
    expected = np.asarray(expected)
    yours = as_array(answer, description=f"an array of {noun}")
    yours = as_shape(yours, expected.shape, f"{noun} of shape {expected.shape}")
    if not np.allclose(yours, expected, rtol=0, atol=tolerance, equal_nan=True):
        wrong = np.count_nonzero(
            ~np.isclose(yours, expected, rtol=0, atol=tolerance, equal_nan=True)
        )
        raise CheckFailed(
            f"{wrong} of {expected.size} {noun} are wrong.",
            yours=brief_text(yours),
            expected=brief_text(expected),
        )


def observe(function: Callable, *arguments: object) -> ObservedCall:
    """Call a function on copies of its arguments; return its result and these copies.

    In the judge, the function runs in the sandbox, and the call is observed there.
    """
    if isinstance(function, RemoteProxy):
        return function.observe(*arguments)
    copies = copy.deepcopy(arguments)
    result = function(*copies)
    shared = {
        position
        for position, value in enumerate(copies)
        if isinstance(value, np.ndarray)
        and isinstance(result, np.ndarray)
        and np.shares_memory(value, result)
    }
    return ObservedCall(result, copies, frozenset(shared))


def time_call(function: Callable, *arguments: object) -> tuple[object, float]:
    """Call a function on copies of its arguments; return the answer and the time in seconds.

    The time is processor time. A function in the sandbox is timed there.
    """
    if isinstance(function, RemoteProxy):
        return function.timed(*arguments)
    copies = copy.deepcopy(arguments)
    start = time.process_time()
    answer = function(*copies)
    return answer, time.process_time() - start


def call_each(function: Callable, calls: Iterable[tuple]) -> list:
    """Call a function once on copies of each set of arguments; return the list of answers.

    A function in the sandbox receives all calls in one message. They share the time limit of one
    call, so use this for many fast calls.
    """
    if isinstance(function, RemoteProxy):
        return function.each(list(calls))
    return [function(*copy.deepcopy(arguments)) for arguments in calls]


def get_attribute_path(value: object, names: Sequence[str]) -> object:
    """Return `value.first.second` for two names; a remote value needs only one message."""
    if isinstance(value, RemoteProxy):
        return value.reach(names)
    return attrgetter(".".join(names))(value)


def assert_untouched(function: Callable, *arguments: object) -> None:
    """Assert that the function does not change its arguments, whatever it returns."""
    assert_arguments_unchanged(observe(function, *arguments), *arguments)


def assert_arguments_unchanged(seen: ObservedCall, *arguments: object) -> None:
    """Assert that an observed call did not change its arguments."""
    for before, after in zip(arguments, seen.arguments, strict=False):
        if not _is_unchanged(before, after):
            raise CheckFailed(
                "The function changed its input. Work on a copy, or build a new array.",
                **_first_change(before, after),
            )


def _first_change(before: object, after: object) -> dict[str, str]:
    """Return the first changed row or the whole argument, before and after the call, as text."""
    arrays = isinstance(before, np.ndarray) and isinstance(after, np.ndarray)
    if not arrays or before.ndim == 0 or after.shape != before.shape:
        return {"yours": brief_text(after), "expected": brief_text(before)}
    rows = zip(before, after, strict=True)
    row = next((row for row, (old, new) in enumerate(rows) if not _is_unchanged(old, new)), 0)
    return {
        "yours": f"after the call, row {row} is {brief_text(after[row])}",
        "expected": f"as before the call: {brief_text(before[row])}",
    }


def assert_new_array(function: Callable, *arguments: object) -> None:
    """Assert that the result does not share memory with an argument."""
    if observe(function, *arguments).shared_arguments:
        raise CheckFailed(
            "The result shares memory with the input, so a change to one changes both. Return a "
            "new array."
        )


def _is_unchanged(before: object, after: object) -> bool:
    """Return whether two values are equal; the second is untrusted and may be of any type."""
    if isinstance(before, np.random.Generator):
        return True  # a function may draw from a generator, which changes its state
    if isinstance(before, (list, tuple)):
        return (
            type(before) is type(after)
            and len(before) == len(after)
            and all(map(_is_unchanged, before, after))
        )
    if not isinstance(before, np.ndarray):
        return type(before) is type(after) and bool(before == after)
    if not isinstance(after, np.ndarray) or after.shape != before.shape:
        return False
    numbers = before.dtype.kind == "f" and after.dtype.kind == "f"
    return bool(np.array_equal(before, after, equal_nan=numbers))


def _is_close(yours: np.ndarray, expected: np.ndarray) -> bool:
    return bool(np.allclose(yours, expected, rtol=0, atol=TOLERANCE, equal_nan=True))


def _membership(cloud: np.ndarray, rows: np.ndarray) -> np.ndarray | None:
    """Return a mask of the rows of `cloud` that occur in `rows`; None if `rows` has others."""
    positions = {}
    for position, row in enumerate(_rounded(cloud)):
        positions.setdefault(row, []).append(position)
    mask = np.zeros(len(cloud), dtype=bool)
    for row in _rounded(rows):
        if row not in positions:
            return None
        mask[positions[row]] = True
    return mask


def _rounded(rows: np.ndarray) -> list[bytes]:
    """Return the bytes of each row, rounded to millimetres."""
    rounded = np.round(np.ascontiguousarray(rows, dtype=np.float32), 3) + np.float32(0)
    data = rounded.tobytes()
    size = len(data) // max(1, len(rounded)) or 1
    return [data[start : start + size] for start in range(0, len(data), size)]


def _row_count_text(rows: np.ndarray) -> str:
    return "1 row" if len(rows) == 1 else f"{len(rows)} rows"
