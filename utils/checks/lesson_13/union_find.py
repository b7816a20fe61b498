"""Visible checks of `root_of` and `unite`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import CheckFailed, brief_text, frozen, precondition
from utils.checks.compiled import assert_compiles
from utils.checks.core import note_check, visible_check
from utils.checks.diagnosis import Mistake, declare_mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.compile_note import COMPILES_TITLE, COMPILES_WHY

# Two pieces and a single cell: 9 -> 4 -> 7 -> 1 with 8 -> 7 and 2 -> 1; 6 -> 3 -> 0; and 5.
_PARENT = frozen(np.array([0, 1, 1, 0, 7, 5, 3, 1, 7, 4]))
_ROOTS = frozen(np.array([0, 1, 1, 0, 1, 5, 0, 1, 1, 1]))
_GIVEN = f"parent {brief_text(_PARENT)}"
_ENDLESS_HINT = "does each round of the loop move to another cell until a cell is its own parent?"


def _path(parent: np.ndarray, cell: int) -> list[int] | None:
    """Return the cells from `cell` to its root, inclusive; None if the parents form a cycle."""
    path = [cell]
    while parent[path[-1]] != path[-1]:
        path.append(int(parent[path[-1]]))
        if len(path) > len(parent):
            return None
    return path


def _roots(parent: np.ndarray, input_text: str) -> np.ndarray:
    """Return the root of each cell after a call to the student's function.

    Raises
    ------
    CheckFailed
        If a parent is not a cell, or the parents form a cycle.
    """
    if not ((parent >= 0) & (parent < len(parent))).all():
        raise CheckFailed(
            "An entry of parent is not the number of a cell.",
            input_text=input_text,
            yours=f"parent {brief_text(parent)}",
            expected=f"numbers from 0 to {len(parent) - 1}",
        )
    paths = [_path(parent, cell) for cell in range(len(parent))]
    if None in paths:
        raise CheckFailed(
            f"The parents of cell {paths.index(None)} form a cycle and never lead to a root.",
            input_text=input_text,
            yours=f"parent {brief_text(parent)}",
        )
    return np.array([path[-1] for path in paths])


# ---- root_of -----------------------------------------------------------------------------------


@visible_check(
    "root_of",
    title="Follows the parents up to the root",
    why="Two cells are in the same piece if they have the same root. Their parents may differ.",
    hint="While parent[cell] != cell, move on with cell = parent[cell]. Return the last cell.",
    slow=_ENDLESS_HINT,
)
def finds_the_root(root_of: Callable) -> None:
    for cell in (3, 8, 6, 9, 4):
        parent = _PARENT.copy()
        yours = assert_number(root_of(parent, cell))
        if yours != _ROOTS[cell]:
            path = " → ".join(map(str, _path(_PARENT, cell)))
            raise CheckFailed(
                f"This is not the root of cell {cell}.",
                input_text=f"{_GIVEN}, so the path is {path}",
                yours=brief_text(yours[()]),
                expected=str(_ROOTS[cell]),
            )


@visible_check(
    "root_of",
    title="Returns the cell itself if it is a root",
    why="At the start every cell is its own root, so this is the answer to the first calls.",
    hint="Return cell after the loop. For a root, the loop does not run at all.",
    slow=_ENDLESS_HINT,
)
def stays_at_a_root(root_of: Callable) -> None:
    for cell in (0, 1, 5):
        yours = assert_number(root_of(_PARENT.copy(), cell))
        if yours != cell:
            raise CheckFailed(
                f"Cell {cell} is its own parent, so it is a root.",
                input_text=_GIVEN,
                yours=brief_text(yours[()]),
                expected=str(cell),
            )


@visible_check(
    "root_of",
    title="Keeps every cell in its piece",
    why="If a search for a root moves cells to another piece, cars merge or split.",
    hint="Change only parent[cell], and only to a cell farther up: parent[parent[cell]].",
    slow=_ENDLESS_HINT,
)
def keeps_the_pieces(root_of: Callable) -> None:
    for cell in (9, 6, 8, 5):
        parent = _PARENT.copy()
        root_of(parent, cell)
        input_text = f"{_GIVEN}, after root_of(parent, {cell})"
        yours = _roots(parent, input_text)
        wrong = np.flatnonzero(yours != _ROOTS)
        if len(wrong):
            raise CheckFailed(
                f"The root of cell {wrong[0]} has changed.",
                input_text=input_text,
                yours=f"root {yours[wrong[0]]}; parent {brief_text(parent)}",
                expected=f"root {_ROOTS[wrong[0]]}",
            )


@visible_check(
    "root_of",
    title="Shortens a long path to half its length or less",
    why="Otherwise a path may become as long as the number of cells, and every call follows it "
    "again.",
    hint="Before you move on, let the cell point at its grandparent: parent[cell] = "
    "parent[parent[cell]]. Then go there.",
    slow=_ENDLESS_HINT,
)
def shortens_the_path(root_of: Callable) -> None:
    with precondition("the function follows the parents up to the root"):
        finds_the_root(root_of)
    n = 9  # a line in which each cell points at the cell before it
    parent = np.maximum(np.arange(n) - 1, 0)
    root_of(parent, n - 1)
    input_text = f"each of {n} cells points at the cell before it, after root_of(parent, {n - 1})"
    _roots(parent, input_text)
    steps = len(_path(parent, n - 1)) - 1
    if steps > n // 2:
        raise CheckFailed(
            f"The path from cell {n - 1} is still too long.",
            input_text=input_text,
            yours=f"{steps} steps; parent {brief_text(parent)}",
            expected=f"at most {n // 2} steps",
        )


@note_check("root_of", title=COMPILES_TITLE, why=COMPILES_WHY)
def root_of_compiles(root_of: Callable) -> None:
    def call_twice(function: Callable) -> list[int]:
        parent = _PARENT.copy()
        return [*map(int, [function(parent, 9), function(parent, 6)]), *parent.tolist()]

    assert_compiles(root_of, call_twice)


def _prediction_steps_up(steps: int) -> Callable:
    """Return a prediction: the cell `steps` steps up, or the root if the path is shorter."""

    def predict(right: int, parent: np.ndarray, cell: int) -> int:
        path = _path(parent, cell)
        return path[min(steps, len(path) - 1)]

    return predict


# One long path that is not sorted by number: 7 → 0 → 3 → 6 → 2 → 5 → 4 → 1.
_LONG_PATH = frozen(np.array([3, 1, 5, 6, 1, 4, 2, 0]))
declare_mistakes(
    "root_of",
    Mistake(
        "The code goes only one step, to the parent: it has `if` instead of `while`, or `return` "
        "inside the loop.",
        _prediction_steps_up(1),
        "Write while parent[cell] != cell, and return after the loop.",
    ),
    Mistake(
        "The code goes two steps, to the grandparent, and no farther.",
        _prediction_steps_up(2),
        "Write while parent[cell] != cell, and return after the loop.",
    ),
    Mistake(
        "The loop ends one step before the root, because the condition tests the next cell.",
        lambda right, parent, cell: _path(parent, cell)[-2],
        "Write while parent[cell] != cell.",
    ),
    Mistake(
        "The function returns its argument cell unchanged.",
        lambda right, parent, cell: cell,
        "Write cell = parent[cell] in the loop, and return cell after it.",
        is_cheap=True,
    ),
    cases=((_LONG_PATH, 7), (_LONG_PATH, 0), (_LONG_PATH, 3)),
    right=lambda parent, cell: _path(parent, cell)[-1],
)


# ---- unite -------------------------------------------------------------------------------------


def _joined_roots(a: int, b: int) -> np.ndarray:
    """Return the root of each cell after `a` and `b` are joined under the smaller root."""
    roots = [_ROOTS[a], _ROOTS[b]]
    return np.where(np.isin(_ROOTS, roots), min(roots), _ROOTS)


def _roots_after_unite(unite: Callable, a: int, b: int) -> tuple[np.ndarray, str]:
    """Return the roots after a call, and its arguments as text."""
    parent = _PARENT.copy()
    unite(parent, a, b)
    input_text = f"{_GIVEN}, after unite(parent, {a}, {b})"
    return _roots(parent, input_text), input_text


def _groups(roots: np.ndarray) -> list[list[int]]:
    return [np.flatnonzero(roots == root).tolist() for root in dict.fromkeys(roots.tolist())]


def _assert_joined(unite: Callable, a: int, b: int) -> None:
    yours, input_text = _roots_after_unite(unite, a, b)
    right = _groups(_joined_roots(a, b))
    if _groups(yours) != right:
        raise CheckFailed(
            "The cells are not joined into the right pieces.",
            input_text=input_text,
            yours=f"pieces {brief_text(_groups(yours))}",
            expected=f"pieces {brief_text(right)}",
        )


@visible_check(
    "unite",
    title="Joins all cells of both pieces, and no others",
    why="If only the two cells are joined, the rest of their pieces stays apart and a car splits.",
    hint="Find both roots first, root_of(parent, a) and root_of(parent, b). Then make one root "
    "the parent of the other.",
    slow=_ENDLESS_HINT,
)
def joins_the_pieces(unite: Callable) -> None:
    for a, b in ((0, 1), (5, 3), (8, 6), (6, 9), (9, 5)):
        _assert_joined(unite, a, b)


@visible_check(
    "unite",
    title="Does not change the pieces if both cells are already in the same piece",
    why="Most pairs of close cells are already in the same piece, which must stay as it is.",
    hint="Do not write a special case. If both roots are the same, parent[root] = root changes "
    "nothing.",
    slow=_ENDLESS_HINT,
)
def accepts_joined_cells(unite: Callable) -> None:
    for a, b in ((8, 9), (9, 1), (5, 5), (0, 6)):
        _assert_joined(unite, a, b)


@visible_check(
    "unite",
    title="Makes the larger root point at the smaller",
    why="The smallest cell of a piece is then its root, so the order of the pairs does not matter.",
    hint="Write parent[max(a, b)] = min(a, b) for the two roots a and b.",
    slow=_ENDLESS_HINT,
)
def points_at_the_smaller_root(unite: Callable) -> None:
    with precondition("all cells of both pieces are joined"):
        joins_the_pieces(unite)
    for a, b in ((6, 9), (9, 6), (5, 8), (2, 5)):
        yours, input_text = _roots_after_unite(unite, a, b)
        right = _joined_roots(a, b)
        if not np.array_equal(yours, right):
            raise CheckFailed(
                "The pieces are joined under the larger root instead of the smaller.",
                input_text=input_text,
                yours=f"root {yours[a]}",
                expected=f"root {right[a]}",
            )


@note_check("unite", title=COMPILES_TITLE, why=COMPILES_WHY)
def unite_compiles(unite: Callable) -> None:
    def call_unite(function: Callable) -> list[int]:
        parent = _PARENT.copy()
        function(parent, 6, 9)
        return parent.tolist()

    assert_compiles(unite, call_unite)


def _pieces_after(unite: Callable, parent: np.ndarray, a: int, b: int) -> list[list[int]]:
    """Return the pieces after a call to `unite`."""
    unite(parent, a, b)
    return _groups(_roots(parent, ""))


def _prediction_with_parent(choose: Callable) -> Callable:
    """Return the prediction of the pieces after one parent has changed.

    `choose` takes both cells and both roots; it returns the cell and its new parent.
    """

    def predict(right: list, parent: np.ndarray, a: int, b: int) -> list[list[int]]:
        child, new_parent = choose(a, b, _path(parent, a)[-1], _path(parent, b)[-1])
        parent[child] = new_parent
        return _groups(_roots(parent, ""))

    return predict


declare_mistakes(
    "unite",
    Mistake(
        "The code joins the two cells instead of their roots, so the cells on the path to a root "
        "are left behind.",
        _prediction_with_parent(lambda a, b, root_a, root_b: (max(a, b), min(a, b))),
        "Write a, b = root_of(parent, a), root_of(parent, b) first.",
    ),
    Mistake(
        "The code changes the parent of the first cell instead of the parent of its root.",
        _prediction_with_parent(lambda a, b, root_a, root_b: (a, root_b)),
        "Also write a = root_of(parent, a).",
    ),
    Mistake(
        "The code changes the parent of the second cell instead of the parent of its root.",
        _prediction_with_parent(lambda a, b, root_a, root_b: (b, root_a)),
        "Also write b = root_of(parent, b).",
    ),
    Mistake(
        "The function does not join anything, because parent is the same after the call.",
        lambda right, parent, a, b: _groups(_roots(parent, "")),
        "Change the array: parent[...] = ...",
        is_cheap=True,
    ),
    cases=((_PARENT, 6, 9), (_PARENT, 9, 3), (_PARENT, 3, 8), (_PARENT, 4, 6)),
    right=lambda parent, a, b: _groups(_joined_roots(a, b)),
    is_same=lambda answer, predicted: answer == predicted,
    call=_pieces_after,
)
