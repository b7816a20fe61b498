"""Your own run, step by step: ``replay(my_function)`` in a notebook.

A run is recorded from the function as it is, however it is written; the player shows it step by
step, and begins where it is wrong. Wrong is what certainly is: where nobody can
know, nothing is said.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

from utils.lent import is_written, own
from utils.replays.player import play
from utils.replays.search import walk

__all__ = ["play", "replay", "walk"]

# What can be replayed, and where it is known how.
_RUNS = {
    "ransac_line": ("utils.replays.ransac", "run_of_line"),
    "ransac_plane": ("utils.replays.ransac", "run_of_plane"),
    "euclidean_clustering": ("utils.replays.clustering", "run_of"),
}


def replay(function: Callable) -> None:
    """Show what a function of yours does with a few points, step by step.

    Parameters
    ----------
    function : callable
        `ransac_line`, `ransac_plane` or `euclidean_clustering`. It is not changed.
    """
    function = own(function)
    name = getattr(function, "__name__", str(function))
    if name not in _RUNS:
        raise LookupError(
            f"{name!r} cannot be replayed. Pass the function itself, under the name it was given: "
            f"one of {', '.join(_RUNS)}."
        )
    if not is_written(function):
        print(f"{name} is not written yet: there is nothing to replay.")
        return
    module, run_of = _RUNS[name]
    play(getattr(importlib.import_module(module), run_of)(function))
