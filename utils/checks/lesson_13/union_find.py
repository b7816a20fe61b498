"""Visible checks of `root_of` and `unite`."""

from collections.abc import Callable

import numpy as np

from utils.checks.assertions import CheckFailed, brief, frozen, needs
from utils.checks.compiled import assert_compiles
from utils.checks.core import noted, visible
from utils.checks.diagnosis import Mistake, mistakes
from utils.checks.lesson_03.iterations_needed import assert_number
from utils.checks.lesson_13.words import COMPILES, WHY_COMPILED

# Two pieces and a cell that is alone: 9 -> 4 -> 7 -> 1 and 8 -> 7, 2 -> 1; 6 -> 3 -> 0; 5.
_PARENT = frozen(np.array([0, 1, 1, 0, 7, 5, 3, 1, 7, 4]))
_ROOTS = frozen(np.array([0, 1, 1, 0, 1, 5, 0, 1, 1, 1]))
_GIVEN = f"parent {brief(_PARENT)}"
_ENDLESS = "does each round of the loop go on to another cell, until one is its own parent?"


def _steps(parent: np.ndarray, cell: int) -> list[int] | None:
    """The cells on the way to a root, with both ends; None where the way goes round."""
    way = [cell]
    while parent[way[-1]] != way[-1]:
        way.append(int(parent[way[-1]]))
        if len(way) > len(parent):
            return None
    return way


def _roots(parent: np.ndarray, given: str) -> np.ndarray:
    """The root of each cell in what a student's function made of the parents."""
    if not ((parent >= 0) & (parent < len(parent))).all():
        raise CheckFailed(
            "A parent is no cell.",
            given=given,
            yours=f"parent {brief(parent)}",
            expected=f"numbers from 0 to {len(parent) - 1}",
        )
    ways = [_steps(parent, cell) for cell in range(len(parent))]
    if None in ways:
        raise CheckFailed(
            f"From cell {ways.index(None)} the parents lead round in a circle, to no root.",
            given=given,
            yours=f"parent {brief(parent)}",
        )
    return np.array([way[-1] for way in ways])


# ---- root_of -----------------------------------------------------------------------------------


@visible(
    "root_of",
    title="Follows the parents up to the root",
    why="Two cells are in the same piece if their roots are the same, and not their parents.",
    hint="while parent[cell] != cell: go on to the next one, cell = parent[cell]. Return the cell "
    "where this ends.",
    slow=_ENDLESS,
)
def finds_the_root(root_of: Callable) -> None:
    for cell in (3, 8, 6, 9, 4):
        parent = _PARENT.copy()
        yours = assert_number(root_of(parent, cell))
        if yours != _ROOTS[cell]:
            way = " → ".join(map(str, _steps(_PARENT, cell)))
            raise CheckFailed(
                f"This is not the root of cell {cell}.",
                given=f"{_GIVEN}, so that the way is {way}",
                yours=brief(yours[()]),
                expected=str(_ROOTS[cell]),
            )


@visible(
    "root_of",
    title="Who is their own parent is the root",
    why="At the start every cell is alone.",
    hint="Without a single round of the loop, the cell itself is returned.",
    slow=_ENDLESS,
)
def stays_at_a_root(root_of: Callable) -> None:
    for cell in (0, 1, 5):
        yours = assert_number(root_of(_PARENT.copy(), cell))
        if yours != cell:
            raise CheckFailed(
                f"Cell {cell} is its own parent.",
                given=_GIVEN,
                yours=brief(yours[()]),
                expected=str(cell),
            )


@visible(
    "root_of",
    title="No cell changes its piece",
    why="Whoever asks for a root does not want to join or to part anything.",
    hint="Write into parent[cell] alone, and nothing but a cell that is farther up: "
    "parent[parent[cell]].",
    slow=_ENDLESS,
)
def keeps_the_pieces(root_of: Callable) -> None:
    for cell in (9, 6, 8, 5):
        parent = _PARENT.copy()
        root_of(parent, cell)
        given = f"{_GIVEN}, after root_of(parent, {cell})"
        yours = _roots(parent, given)
        wrong = np.flatnonzero(yours != _ROOTS)
        if len(wrong):
            raise CheckFailed(
                f"Cell {wrong[0]} has another root than before.",
                given=given,
                yours=f"root {yours[wrong[0]]}; parent {brief(parent)}",
                expected=f"root {_ROOTS[wrong[0]]}",
            )


@visible(
    "root_of",
    title="Shortens the way, to half or less",
    why="Without it some ways grow as long as there are cells, and each question walks them again.",
    hint="Before you go on, let the cell point at its grandparent: parent[cell] = "
    "parent[parent[cell]]. Then go there.",
    slow=_ENDLESS,
)
def shortens_the_way(root_of: Callable) -> None:
    with needs("it follows the parents up to the root"):
        finds_the_root(root_of)
    n = 9  # a line: each points at the one before
    parent = np.maximum(np.arange(n) - 1, 0)
    root_of(parent, n - 1)
    given = f"each of {n} cells points at the one before, after root_of(parent, {n - 1})"
    _roots(parent, given)
    steps = len(_steps(parent, n - 1)) - 1
    if steps > n // 2:
        raise CheckFailed(
            f"The way from cell {n - 1} is hardly shorter than it was.",
            given=given,
            yours=f"{steps} steps; parent {brief(parent)}",
            expected=f"at most {n // 2}",
        )


@noted("root_of", title=COMPILES, why=WHY_COMPILED)
def root_of_compiles(root_of: Callable) -> None:
    def ask(function: Callable) -> list[int]:
        parent = _PARENT.copy()
        return [*map(int, [function(parent, 9), function(parent, 6)]), *parent.tolist()]

    assert_compiles(root_of, ask)


def _up(steps: int) -> Callable:
    """Predicts the cell so many steps farther up, or the root if that is nearer."""

    def predicts(right: int, parent: np.ndarray, cell: int) -> int:
        way = _steps(parent, cell)
        return way[min(steps, len(way) - 1)]

    return predicts


# One long way, whose order nobody reads off the numbers: 7 → 0 → 3 → 6 → 2 → 5 → 4 → 1.
_LONG = frozen(np.array([3, 1, 5, 6, 1, 4, 2, 0]))
mistakes(
    "root_of",
    Mistake(
        "It goes one step, to the parent: `if` where `while` is needed, or `return` in the loop.",
        _up(1),
        "Repeat until parent[cell] == cell.",
    ),
    Mistake(
        "It goes two steps, to the grandparent, and no farther.",
        _up(2),
        "Repeat until parent[cell] == cell, and return after the loop.",
    ),
    Mistake(
        "It ends one step before the root: the condition asks about the next cell.",
        lambda right, parent, cell: _steps(parent, cell)[-2],
        "while parent[cell] != cell.",
    ),
    Mistake(
        "It returns the cell that was given.",
        lambda right, parent, cell: cell,
        "cell = parent[cell] in the loop, and return cell after it.",
        is_cheap=True,
    ),
    cases=((_LONG, 7), (_LONG, 0), (_LONG, 3)),
    right=lambda parent, cell: _steps(parent, cell)[-1],
)


# ---- unite -------------------------------------------------------------------------------------


def _together(a: int, b: int) -> np.ndarray:
    """The root of each cell when the pieces of two are joined, the smaller root for both."""
    both = [_ROOTS[a], _ROOTS[b]]
    return np.where(np.isin(_ROOTS, both), min(both), _ROOTS)


def _united(unite: Callable, a: int, b: int) -> tuple[np.ndarray, str]:
    """The roots after a call, and what was given."""
    parent = _PARENT.copy()
    unite(parent, a, b)
    given = f"{_GIVEN}, after unite(parent, {a}, {b})"
    return _roots(parent, given), given


def _groups(roots: np.ndarray) -> list[list[int]]:
    return [np.flatnonzero(roots == root).tolist() for root in dict.fromkeys(roots.tolist())]


def _assert_joined(unite: Callable, a: int, b: int) -> None:
    yours, given = _united(unite, a, b)
    right = _groups(_together(a, b))
    if _groups(yours) != right:
        raise CheckFailed(
            "Other cells hang together.",
            given=given,
            yours=f"pieces {brief(_groups(yours))}",
            expected=f"pieces {brief(right)}",
        )


@visible(
    "unite",
    title="All cells of both pieces hang together afterwards, and no others",
    why="A car falls apart where only the two cells are joined and not all that hangs on them.",
    hint="Find both roots first, root_of(parent, a) and root_of(parent, b). Then one root gets the "
    "other for its parent.",
    slow=_ENDLESS,
)
def joins_the_pieces(unite: Callable) -> None:
    for a, b in ((0, 1), (5, 3), (8, 6), (6, 9), (9, 5)):
        _assert_joined(unite, a, b)


@visible(
    "unite",
    title="Who is together already stays so",
    why="Of the pairs of near cells, most are in one piece already.",
    hint="If both roots are the same, parent[root] = root changes nothing: no special case is "
    "needed.",
    slow=_ENDLESS,
)
def joins_twice(unite: Callable) -> None:
    for a, b in ((8, 9), (9, 1), (5, 5), (0, 6)):
        _assert_joined(unite, a, b)


@visible(
    "unite",
    title="The larger root points at the smaller",
    why="The first cell of a piece is its root then, whatever the order of the pairs.",
    hint="parent[max(...)] = min(...), of the two roots.",
    slow=_ENDLESS,
)
def points_at_the_smaller(unite: Callable) -> None:
    with needs("all cells of both pieces hang together"):
        joins_the_pieces(unite)
    for a, b in ((6, 9), (9, 6), (5, 8), (2, 5)):
        yours, given = _united(unite, a, b)
        right = _together(a, b)
        if not np.array_equal(yours, right):
            raise CheckFailed(
                "The pieces are joined, under the larger root.",
                given=given,
                yours=f"root {yours[a]}",
                expected=f"root {right[a]}",
            )


@noted("unite", title=COMPILES, why=WHY_COMPILED)
def unite_compiles(unite: Callable) -> None:
    def ask(function: Callable) -> list[int]:
        parent = _PARENT.copy()
        function(parent, 6, 9)
        return parent.tolist()

    assert_compiles(unite, ask)


def _roots_after(unite: Callable, parent: np.ndarray, a: int, b: int) -> list[list[int]]:
    """What `unite` makes of the parents, as the pieces."""
    unite(parent, a, b)
    return _groups(_roots(parent, ""))


def _written_at(choose: Callable) -> Callable:
    """Predicts the pieces when one parent is written: takes both cells and both roots."""

    def predicts(right: list, parent: np.ndarray, a: int, b: int) -> list[list[int]]:
        child, above = choose(a, b, _steps(parent, a)[-1], _steps(parent, b)[-1])
        parent[child] = above
        return _groups(_roots(parent, ""))

    return predicts


mistakes(
    "unite",
    Mistake(
        "The two cells are joined, and not their roots: what hangs on the way up is left behind.",
        _written_at(lambda a, b, root_a, root_b: (max(a, b), min(a, b))),
        "a, b = root_of(parent, a), root_of(parent, b) comes first.",
    ),
    Mistake(
        "The first cell, and not its root, gets another parent.",
        _written_at(lambda a, b, root_a, root_b: (a, root_b)),
        "a = root_of(parent, a), too.",
    ),
    Mistake(
        "The second cell, and not its root, gets another parent.",
        _written_at(lambda a, b, root_a, root_b: (b, root_a)),
        "b = root_of(parent, b), too.",
    ),
    Mistake(
        "Nothing is joined.",
        lambda right, parent, a, b: _groups(_roots(parent, "")),
        "Write into the array: parent[...] = ...",
        is_cheap=True,
    ),
    cases=((_PARENT, 6, 9), (_PARENT, 9, 3), (_PARENT, 3, 8), (_PARENT, 4, 6)),
    right=lambda parent, a, b: _groups(_together(a, b)),
    same=lambda answer, predicted: answer == predicted,
    ask=_roots_after,
)
