"""Step-by-step replay of your own function: ``replay(my_function)`` in a notebook.

The function is run and recorded unchanged, in whatever style it is written. The player shows the
run step by step and begins at the first mistake. It reports only mistakes that are certain.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

from utils.lent import is_written, own
from utils.replays.player import play
from utils.replays.search import walk

__all__ = ["play", "replay", "walk"]

# Functions that can be replayed, each with the module and the function that record its run.
_RUNS = {
    "ransac_line": ("utils.replays.ransac", "replay_ransac_line"),
    "ransac_plane": ("utils.replays.ransac", "replay_ransac_plane"),
    "euclidean_clustering": ("utils.replays.clustering", "replay_clustering"),
}


def replay(function: Callable) -> None:
    """Show step by step how one of your functions works on a few points.

    Parameters
    ----------
    function : callable
        `ransac_line`, `ransac_plane` or `euclidean_clustering`. It is not changed.

    Raises
    ------
    LookupError
        The function is not one of these.
    """
    function = own(function)
    name = getattr(function, "__name__", str(function))
    if name not in _RUNS:
        raise LookupError(
            f"{name!r} cannot be replayed. Pass one of these functions, without renaming it: "
            f"{', '.join(_RUNS)}."
        )
    if not is_written(function):
        print(f"{name} is not written yet, so there is nothing to replay.")
        return
    module, run_of = _RUNS[name]
    play(getattr(importlib.import_module(module), run_of)(function))
