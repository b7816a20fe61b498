"""Visible checks of the three steps of lesson 10, mostly on its seven points.

The steps give no points, because a solution need not use them. If the exercise calls a step that
fails here, `check` says so.
"""

from collections.abc import Callable, Sequence

import numpy as np

from utils.checks.assertions import (
    CheckFailed,
    WrongForm,
    as_array,
    as_labels,
    as_shape,
    assert_arguments_unchanged,
    brief_text,
    count_overlaps,
    frozen,
    observe,
    precondition,
)
from utils.checks.core import visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.failures import fixed

# At this threshold a cell is 1 m wide.
WIDE_THRESHOLD = float(np.sqrt(3))
SEVEN_POINTS = frozen(
    np.array(
        [
            [0.1, 0.2, 0.0],
            [1.2, 0.9, 0.0],
            [2.7, 0.5, 0.0],
            [2.95, 0.3, 0.0],
            [4.6, 0.2, 0.0],
            [6.1, 0.7, 0.0],
            [-0.4, 2.6, 0.0],
        ]
    )
)
_LETTERS = "abcdefg"  # the names of the points in the lesson
# Results of the steps for these points, as the lesson prints them.
_CELLS = frozen(np.array([[-1, 2, 0], [0, 0, 0], [1, 0, 0], [2, 0, 0], [4, 0, 0], [6, 0, 0]]))
_FIRST = frozen(np.array([6, 0, 1, 2, 4, 5]))
_CELL_OF_POINT = frozen(np.array([1, 2, 3, 3, 4, 5, 0]))
_PAIRS = frozen(np.array([[0, 1], [0, 2], [1, 2], [1, 3], [2, 3], [3, 4], [4, 5]]))
_PIECES = frozen(np.array([0, 1, 1, 1, 2, 2]))
_JOINED = frozen(np.array([0, 1, 1, 1, 1, 1]))
_GIVEN = "the seven points, threshold √3 m"


def _results(answer: object, names: Sequence[str]) -> tuple:
    """Return the results of a step as a tuple with one result for each name."""
    if not isinstance(answer, (tuple, list)) or len(answer) != len(names):
        raise WrongForm(
            f"The step must return {len(names)} results: {', '.join(names)}.",
            yours=brief_text(answer),
        )
    return tuple(answer)


def _assert_same_pieces(answer: object, expected: np.ndarray, input_text: str) -> None:
    """Assert that the cells are joined into the expected pieces, whatever their labels."""
    yours = as_labels(answer, len(expected), noun="cells")
    shared, number_yours, number_expected = count_overlaps(yours, expected)
    if not shared == number_yours == number_expected:
        raise CheckFailed(
            "The cells are not joined into the right pieces.",
            input_text=input_text,
            yours=f"pieces {_pieces_text(yours)}",
            expected=f"pieces {_pieces_text(expected)}",
        )


def _pieces_text(label: np.ndarray) -> str:
    groups = [np.flatnonzero(label == piece).tolist() for piece in dict.fromkeys(label.tolist())]
    return brief_text(groups)


# ---- step 1 ------------------------------------------------------------------------------------


def _assert_cells(answer: object, points: np.ndarray, threshold: float, input_text: str) -> None:
    cells, first, cell_of_point = _results(answer, ("cells", "first", "cell_of_point"))
    cells = as_array(
        cells, columns=3, description="cells with three numbers each", row_noun="cell"
    ).astype(float)
    right = np.floor(points / (threshold / np.sqrt(3)))
    cell_rows = as_array(cell_of_point, description="the row of a cell for each point")
    one_per_point = f"one number in cell_of_point for each of the {len(points)} points"
    cell_rows = as_labels(as_shape(cell_rows, (len(points),), one_per_point), len(points))
    n_cells = len(np.unique(right, axis=0))
    if len(cells) != n_cells or cell_rows.min() < 0 or cell_rows.max() >= len(cells):
        raise CheckFailed(
            f"The points are in {n_cells} different cells, {fixed('numbered from 0')}.",
            input_text=input_text,
            yours=f"{len(cells)} cells; cell_of_point is {brief_text(cell_rows)}",
            expected=f"{n_cells} cells",
        )
    wrong = np.flatnonzero((cells[cell_rows] != right).any(axis=1))
    if len(wrong):
        row = wrong[0]
        raise CheckFailed(
            f"The cell of point {_LETTERS[row]}, at {brief_text(points[row])}, is wrong.",
            input_text=input_text,
            yours=f"cell {brief_text(cells[cell_rows[row]])}",
            expected=f"cell {brief_text(right[row])}",
        )
    rows = as_array(first, description="one row number for each cell")
    if rows.shape != (n_cells,) or not np.isin(rows, np.arange(len(points))).all():
        raise WrongForm(
            "There must be one representative for each cell: the row of one of its points.",
            yours=brief_text(rows),
            expected=f"{n_cells} rows from 0 to {len(points) - 1}",
        )
    misplaced = np.flatnonzero(cell_rows[rows.astype(int)] != np.arange(n_cells))
    if len(misplaced):
        cell = misplaced[0]
        raise CheckFailed(
            f"The representative of cell {cell} is in another cell.",
            input_text=input_text,
            yours=f"row {rows[cell]:g}",
            expected=f"one of the rows {brief_text(np.flatnonzero(cell_rows == cell))}",
        )


@visible_check(
    "points_in_cells",
    title="Finds the six cells that contain the seven points",
    why="Points that share a cell are joined without measuring. A wrong cell joins points that "
    "are far apart.",
    hint="Compute rows = np.floor(points / side) with side = threshold / np.sqrt(3), here 1 m. "
    "Then call np.unique(as_numbers(rows), ...) for first and cell_of_point. The different cells "
    "are rows[first].",
)
def finds_the_cells(points_in_cells: Callable) -> None:
    _assert_cells(
        points_in_cells(SEVEN_POINTS.copy(), WIDE_THRESHOLD), SEVEN_POINTS, WIDE_THRESHOLD, _GIVEN
    )


@visible_check(
    "points_in_cells",
    title="Makes cells that are threshold / √3 wide for any threshold",
    why="Two points in a larger cell may be too far apart to be neighbours. With smaller cells, "
    "close points may be more than two cells apart.",
    hint="Write side = threshold / np.sqrt(3). The diagonal of a cell then equals the threshold.",
)
def scales_with_the_threshold(points_in_cells: Callable) -> None:
    with precondition("the function finds the six cells that contain the seven points"):
        _assert_cells(
            points_in_cells(SEVEN_POINTS.copy(), WIDE_THRESHOLD),
            SEVEN_POINTS,
            WIDE_THRESHOLD,
            _GIVEN,
        )
    for threshold in (0.5, 2.5):
        input_text = f"the seven points, threshold {threshold:g} m"
        _assert_cells(
            points_in_cells(SEVEN_POINTS.copy(), threshold), SEVEN_POINTS, threshold, input_text
        )


@visible_check(
    "points_in_cells",
    title="Does not change the points",
    why="Step 2 uses the same points. If step 1 changes them, step 2 measures wrong distances.",
    hint="Write points / side, which creates a new array. points /= side changes the input.",
)
def keeps_the_points_unchanged(points_in_cells: Callable) -> None:
    assert_arguments_unchanged(observe(points_in_cells, SEVEN_POINTS, 0.5), SEVEN_POINTS, 0.5)


def _cell_of_each_point(
    points_in_cells: Callable, points: np.ndarray, threshold: float
) -> np.ndarray:
    """Return the cell of each point according to the student, shape (n, 3)."""
    cells, _, cell_of_point = points_in_cells(points, threshold)
    return np.asarray(cells, dtype=float)[np.asarray(cell_of_point)]


def _prediction_of_cells(side: float = 1 / np.sqrt(3), rounding: Callable = np.floor) -> Callable:
    """Return the prediction for cells with another side, in thresholds, or another rounding."""
    return lambda right, points, threshold: rounding(points / (side * threshold))


declare_mistakes(
    "points_in_cells",
    Mistake(
        "The code rounds -0.4 to 0, perhaps with .astype(int).",
        _prediction_of_cells(rounding=np.trunc),
        "Use np.floor, which also rounds down below zero.",
    ),
    Mistake(
        "The code rounds to the nearest whole number, so it rounds 0.6 to 1.",
        _prediction_of_cells(rounding=np.round),
        "Use np.floor, which rounds 0.6 down to 0.",
    ),
    Mistake(
        "The side of a cell is the threshold, so two points in one cell may be 1.7 times the "
        "threshold apart.",
        _prediction_of_cells(side=1.0),
        "Make the side threshold / np.sqrt(3), so that the diagonal equals the threshold.",
    ),
    Mistake(
        "The side of a cell is threshold / sqrt(2), which is right only in the plane.",
        _prediction_of_cells(side=1 / np.sqrt(2)),
        "Make the side threshold / np.sqrt(3), because the diagonal of a cube is side * "
        "np.sqrt(3).",
    ),
    cases=((SEVEN_POINTS, WIDE_THRESHOLD), (SEVEN_POINTS, 0.5), (SEVEN_POINTS[:, ::-1], 2.5)),
    right=lambda points, threshold: np.floor(points / (threshold / np.sqrt(3))),
    call=_cell_of_each_point,
)


# ---- step 2 ------------------------------------------------------------------------------------

# Six points in the first cell, then one point in each of three cells, each of them two cells
# further along x, y or z. The first four points are close together, so code that mistakes rows of
# cells for rows of points joins all four cells. No two of these cells are close.
_HEAP = frozen(np.vstack([0.1 + 0.02 * np.arange(6)[:, None] * np.ones(3), 2.05 * np.tri(3)]))
_HEAP_CELLS = frozen(np.array([[0, 0, 0], [2, 0, 0], [2, 2, 0], [2, 2, 2]]))
_HEAP_FIRST = frozen(np.array([0, 6, 7, 8]))


def _join_seven(join_cheaply: Callable) -> tuple:
    arguments = SEVEN_POINTS.copy(), _CELLS.copy(), _FIRST.copy(), WIDE_THRESHOLD
    return _results(join_cheaply(*arguments), ("pairs", "label"))


@visible_check(
    "join_cheaply",
    title="Finds all seven pairs of neighbouring cells",
    why="A pair that is missing here is never measured, so one object can become two clusters.",
    hint="Call cKDTree(cells).query_pairs(2, p=np.inf, output_type='ndarray'), which finds all "
    "pairs of cells at most two steps apart along each axis. Return all of these pairs, joined or "
    "not.",
)
def finds_the_neighbours(join_cheaply: Callable) -> None:
    pairs = _join_seven(join_cheaply)[0]
    pairs = as_array(pairs, columns=2, description="pairs of cells", row_noun="pair of cells")
    yours = np.unique(np.sort(pairs, axis=1), axis=0)
    if len(yours) != len(pairs) or not np.array_equal(yours, _PAIRS):
        raise CheckFailed(
            "pairs must contain every pair of cells that are at most two steps apart, and each "
            "pair only once.",
            input_text=_GIVEN,
            yours=brief_text(yours.tolist()),
            expected=brief_text(_PAIRS.tolist()),
        )


@visible_check(
    "join_cheaply",
    title="Joins neighbouring cells whose representatives are close",
    why="One distance between representatives can replace thousands of distances between points.",
    hint="Compute gap, the distance between the two representatives of each pair, with "
    "np.linalg.norm(..., axis=1). Join the pairs with gap < threshold.",
)
def joins_close_representatives(join_cheaply: Callable) -> None:
    _assert_same_pieces(_join_seven(join_cheaply)[1], _PIECES, _GIVEN)


@visible_check(
    "join_cheaply",
    title="Measures distances between representatives",
    why="Cell 3 is not the point in row 3. Code that confuses the two joins objects that are far "
    "apart.",
    hint="Measure between points[first[pairs[:, 0]]] and points[first[pairs[:, 1]]], with x, y "
    "and z. pairs contains rows of cells, and first turns them into rows of points.",
)
def measures_representatives(join_cheaply: Callable) -> None:
    arguments = _HEAP.copy(), _HEAP_CELLS.copy(), _HEAP_FIRST.copy(), WIDE_THRESHOLD
    _, label = _results(join_cheaply(*arguments), ("pairs", "label"))
    input_text = "six points in cell (0, 0, 0), then one in each of (2, 0, 0), (2, 2, 0), (2, 2, 2)"
    _assert_same_pieces(
        label, np.arange(4), f"{input_text}; neighbouring cells are about 2 m apart, threshold √3 m"
    )


# ---- step 3 ------------------------------------------------------------------------------------

# Five cells in a row, two steps apart. The first points of neighbouring cells are too far apart.
# Other points of these cells are close, except in the last two cells. The last cell has four points
# and the others have three, so the lesson's `on_floors` returns arrays p and q of different
# lengths.
_IN_CELL = frozen(np.array([[0.1, 0.5, 0.9]] * 4 + [[0.9, 0.95, 0.85]]))
_ROW = frozen(
    np.outer(np.append((2 * np.arange(5)[:, None] + _IN_CELL).ravel(), 8.92), np.eye(3)[0])
)
_ROW_CELLS = frozen(np.append(np.repeat(np.arange(5), 3), 4))
_ROW_PAIRS = frozen(np.array([[0, 1], [1, 2], [2, 3], [3, 4]]))


def _exact_arguments(label: np.ndarray) -> tuple:
    return SEVEN_POINTS, _CELL_OF_POINT, _PAIRS, label, WIDE_THRESHOLD


@visible_check(
    "join_exactly",
    title="Joins all cells of the two pieces that points d and e connect",
    why="If a close pair is missed, or only one cell of a piece gets the new label, a car stays "
    "split into two clusters.",
    hint="Go through the pairs whose two labels differ. If smallest_distance is below the "
    "threshold, give all cells of both pieces the same label: label[label == label[j]] = label[i].",
)
def joins_exactly(join_exactly: Callable) -> None:
    # Pieces may be numbered in any order, so either of the two pieces may have the larger number.
    # If the pair of points d and e is the last, no later pair can relabel a forgotten cell.
    for label, order in ((_PIECES, [0, 1, 2, 3, 4, 5, 6]), (2 - _PIECES, [0, 1, 2, 3, 4, 6, 5])):
        answer = join_exactly(
            SEVEN_POINTS.copy(), _CELL_OF_POINT.copy(), _PAIRS[order], label.copy(), WIDE_THRESHOLD
        )
        _assert_same_pieces(
            answer, _JOINED, f"{_GIVEN}; pieces {_pieces_text(_PIECES)} after step 2"
        )


@visible_check(
    "join_exactly",
    title="Does not change the labels of step 2",
    why="If you run the cell below a second time, it must start from the pieces of step 2, not "
    "from pieces that are already joined.",
    hint="Write label = label.copy() before you change any label.",
)
def keeps_the_labels_unchanged(join_exactly: Callable) -> None:
    with precondition("the function joins the two pieces that points d and e connect"):
        joins_exactly(join_exactly)
    assert_arguments_unchanged(
        observe(join_exactly, *_exact_arguments(_PIECES)), *_exact_arguments(_PIECES)
    )


@visible_check(
    "join_exactly",
    title="Joins a row of close pieces, but not the last piece, which is too far away",
    why="After step 2, a wall may consist of dozens of pieces, each of them close only to the "
    "next.",
    hint="In each round, compare the two labels in the copy that the loop changes, and relabel "
    "the whole piece: label[label == label[j]] = label[i].",
)
def joins_a_row_of_pieces(join_exactly: Callable) -> None:
    label = np.array([3, 0, 4, 1, 2])
    answer = join_exactly(_ROW.copy(), _ROW_CELLS.copy(), _ROW_PAIRS.copy(), label, WIDE_THRESHOLD)
    input_text = (
        "five cells in a row, each a separate piece with three or four points; the closest points "
        "of neighbouring cells are 1.2 m apart up to the fourth cell, threshold √3 m"
    )
    _assert_same_pieces(answer, np.array([0, 0, 0, 0, 1]), input_text)


# Six cells in a row, one point in each, in two pieces: cells 0 to 2 and cells 3 to 5. The only open
# pair is the last pair, so no later pair can relabel a forgotten cell.
_SIX_POINTS = frozen(np.outer(np.arange(6) + 0.5, np.eye(3)[0]))
_SIX_PAIRS = frozen(np.array([[0, 1], [1, 2], [3, 4], [4, 5], [2, 3]]))
_SIX_CASES = tuple(
    (_SIX_POINTS, frozen(np.arange(6)), frozen(pairs), frozen(label), WIDE_THRESHOLD)
    for pairs in (_SIX_PAIRS, _SIX_PAIRS[:, ::-1])
    for label in (np.repeat([0, 1], 3), np.repeat([4, 2], 3))
)


def _prediction_of_one_cell(changed: int) -> Callable:
    """Return the prediction for code that relabels only cell i (0) or j (1) of the open pair."""

    def predict(right: np.ndarray, *case: object) -> np.ndarray:
        _, _, pairs, label, _ = case
        label = label.copy()
        label[pairs[-1, changed]] = label[pairs[-1, 1 - changed]]
        return label

    return predict


def _is_same_partition(answer: object, predicted: np.ndarray) -> bool:
    shared, yours, expected = count_overlaps(as_labels(answer, len(predicted)), predicted)
    return shared == yours == expected


declare_mistakes(
    "join_exactly",
    Mistake(
        "Only cell j gets the new label, and the rest of its piece keeps the old one.",
        _prediction_of_one_cell(1),
        "Relabel the whole piece of j: label[label == label[j]] = label[i].",
    ),
    Mistake(
        "Only cell i gets the new label, and the rest of its piece keeps the old one.",
        _prediction_of_one_cell(0),
        "Relabel the whole piece of j instead: label[label == label[j]] = label[i].",
    ),
    cases=_SIX_CASES,
    right=lambda points, cell_of_point, pairs, label, threshold: np.zeros(6, dtype=int),
    is_same=_is_same_partition,
)
