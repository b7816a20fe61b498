"""Let students expose broken versions of a function with small clouds of points.

>>> show_broken(euclidean_clustering)
>>> tell_apart(euclidean_clustering, A=[[0, 0, 0], [0, 0, 2]])
"""

from __future__ import annotations

from collections.abc import Callable
from html import escape

import numpy as np
from numpy.typing import ArrayLike

from utils.breaking.puzzles import PUZZLES, Puzzle
from utils.checks.limits import TimeUp, limit_resources
from utils.checks.tips import unwritten_function
from utils.display import show
from utils.lent import is_written, own
from utils.remote_objects import ENDLESS_LOOP_HINT

MAX_ROWS = 50
TIME_LIMIT = 10
"""Time limit for four calls with a few dozen points; much more than any right answer needs."""


def show_broken(function: Callable) -> None:
    """Draw the answers of your function and of broken versions of it.

    Parameters
    ----------
    function : callable
        `ransac_line`, `euclidean_clustering`, `get_bounding_boxes`, `get_oriented_boxes` or
        `euclidean_clustering_accelerated`.
    """
    if (puzzle := _puzzle_of(function)) is None:
        return
    import matplotlib.pyplot as plt

    function, shown = own(function), puzzle.example
    try:
        with limit_resources(TIME_LIMIT):
            right = puzzle.answer_of(function, shown)
            puzzle.comparable(right)
            answers = {
                letter: version.answer(function, shown)
                for letter, version in puzzle.versions.items()
            }
    except Exception as error:
        print(_describe_error(error, function))
        return
    _, grid = plt.subplots(2, 2, figsize=(8.5, 7), layout="compressed")
    for (name, answer), axes in zip({"yours": right, **answers}.items(), grid.flat, strict=True):
        puzzle.draw(shown, answer, right, axes)
        axes.set_title(name, loc="left", fontsize=12, fontweight="bold")
    plt.show()


def tell_apart(function: Callable, **clouds: ArrayLike | None) -> None:
    """Show which clouds distinguish your function from its broken versions.

    Parameters
    ----------
    function : callable
        As for `show_broken`.
    **clouds : array_like
        One cloud per version, named by its letter; None or an empty list if you have none yet.
    """
    if (puzzle := _puzzle_of(function)) is None:
        return
    unknown = [letter for letter in clouds if letter not in puzzle.versions]
    if unknown:
        raise TypeError(f"There is no version {unknown[0]}, only {', '.join(puzzle.versions)}.")
    lines = {
        letter: _judge_cloud(puzzle, own(function), letter, clouds.get(letter))
        for letter in puzzle.versions
    }
    rows = "".join(f"<p><b>{letter}</b> {escape(line)}</p>" for letter, line in lines.items())
    show(rows, "\n".join(f"{letter} {line}" for letter, line in lines.items()))


def _puzzle_of(function: Callable) -> Puzzle | None:
    name = getattr(own(function), "__name__", str(function))
    if name not in PUZZLES:
        raise LookupError(
            f"There are no broken versions of {name!r}, only of {', '.join(PUZZLES)}."
        )
    if not is_written(function):
        print(f"{name} is not written yet, so there is nothing to break.")
        return None
    return PUZZLES[name]


def _judge_cloud(puzzle: Puzzle, function: Callable, letter: str, points: ArrayLike | None) -> str:
    """Return a line that says whether a cloud tells a version from the correct function."""
    if points is None:
        return "… no cloud yet."
    try:
        cloud = np.array(points, dtype=float)
        if cloud.size == 0:
            return "… no cloud yet."
    except (TypeError, ValueError):
        cloud = np.empty(0)
    if cloud.ndim != 2 or cloud.shape[1] != puzzle.example.shape[1] or len(cloud) > MAX_ROWS:
        return f"✗ Use a list of at most {MAX_ROWS} rows [{puzzle.columns}]."
    if not np.isfinite(cloud).all():
        return "✗ Use finite numbers: ordinary points are enough to show every fault."
    version, others = puzzle.versions[letter], [name for name in puzzle.versions if name != letter]
    try:
        with limit_resources(TIME_LIMIT):
            right = puzzle.comparable(puzzle.answer_of(function, cloud))
            differ = [
                name
                for name in (letter, *others)
                if not _are_equal(
                    right, puzzle.comparable(puzzle.versions[name].answer(function, cloud))
                )
            ]
    except Exception as error:
        return f"✗ {_describe_error(error, function)}"
    if letter not in differ:
        return f"✗ With this cloud, {letter} gives the same answer as your function."
    line = f"✓ Found with {_row_count_text(len(cloud))}. {version.description}"
    if len(cloud) > version.smallest_row_count:
        line += f" {_row_count_text(version.smallest_row_count).capitalize()} would be enough."
    if also := [name for name in differ if name != letter]:
        is_wrong = "is" if len(also) == 1 else "are"
        line += f" {' and '.join(also)} {is_wrong} also wrong with this cloud."
    return line


def _describe_error(error: Exception, function: Callable) -> str:
    if isinstance(error, TimeUp):
        return (
            f"Your function did not answer within {TIME_LIMIT} seconds, so nothing can be "
            f"compared. {ENDLESS_LOOP_HINT.capitalize()}"
        )
    if stub := unwritten_function(error, function):
        return f"{stub} is not written yet, so nothing can be compared."
    return f"Your function raised {type(error).__name__}, so nothing can be compared: {error}"


def _are_equal(first: np.ndarray, second: np.ndarray) -> bool:
    return first.shape == second.shape and bool(np.allclose(first, second))


def _row_count_text(count: int) -> str:
    return "1 row" if count == 1 else f"{count} rows"
