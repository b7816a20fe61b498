"""What runs behind the wall: a notebook's code, and what the lesson adds to it and allows."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace

# What a lesson finds inside unless its header names more, as pip calls it.
PACKAGES = ("numpy", "scipy", "matplotlib")


# More than any lesson has, solved: which line it was is told of no longer notebook.
MOST_LINES_OF_ALL = 4096


def cell_and_line(place: str) -> tuple[int, int] | None:
    """Both numbers of a place such as ``code cell 3, line 12``; None if it is none."""
    found = re.fullmatch(r"code cell (\d{1,4}), line (\d{1,6})", place)
    return (int(found[1]), int(found[2])) if found else None


@dataclass(frozen=True)
class Given:
    """Code of the lesson that takes the place of whatever a notebook makes of it.

    Attributes
    ----------
    names : tuple of str
    source : str
    open : tuple of str
        Those of the names that a notebook may write anew: then its own count.
    """

    names: tuple[str, ...] = ()
    source: str = ""
    open: tuple[str, ...] = ()


@dataclass(frozen=True)
class Program:
    """All that a worker is told.

    Attributes
    ----------
    cells : tuple of str
        Source of the notebook's code cells.
    names : tuple of str
        The functions and classes that will be called.
    modules : dict of str to str
        Source of the modules that were handed in beside the notebook, by name.
    given : Given
    forbidden : tuple of str
        Modules that the lesson does not allow.
    packages : tuple of str
        Installed packages that it does.
    steps : tuple of str
        Functions that the lesson asks for and does not grade. They are not called; a message may
        name one that is still a stub.
    """

    cells: tuple[str, ...]
    names: tuple[str, ...]
    modules: dict[str, str] = field(default_factory=dict)
    given: Given = Given()
    forbidden: tuple[str, ...] = ()
    packages: tuple[str, ...] = PACKAGES
    steps: tuple[str, ...] = ()

    @property
    def named(self) -> tuple[str, ...]:
        """The packages that stand anywhere in the code, be it in a comment."""
        sources = (*self.cells, *self.modules.values(), self.given.source)
        return tuple(name for name in self.packages if any(name in source for source in sources))

    def edited(self, cell: int, first: int, last: int, text: str) -> Program:
        """The same, with something else in the place of some lines of a cell."""
        lines = self.cells[cell - 1].split("\n")
        changed = "\n".join([*lines[: first - 1], text, *lines[last:]])
        return replace(self, cells=(*self.cells[: cell - 1], changed, *self.cells[cell:]))

    def line_at(self, place: str) -> str | None:
        """What stands at a place such as ``code cell 3, line 12``; None if there is no such one.

        None, too, where there are so many lines that which of them it is says too much.
        """
        found = cell_and_line(place)
        if not found or sum(1 + cell.count("\n") for cell in self.cells) > MOST_LINES_OF_ALL:
            return None
        cell, line = found
        lines = self.cells[cell - 1].split("\n") if 0 < cell <= len(self.cells) else []
        return lines[line - 1].strip() if 0 < line <= len(lines) else None
