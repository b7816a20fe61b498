"""Extract functions, with everything they use, for pasting into another notebook."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterable, Sequence

from utils.notebooks import slicing

_IMPORTS = (ast.Import, ast.ImportFrom)


def source_texts(names: Iterable[str], cells: Sequence[str], origin: str) -> list[str]:
    """Return the source of some functions and of the statements that they need.

    Parameters
    ----------
    names : iterable of str
    cells : sequence of str
        Source of each code cell.
    origin : str
        Name of the notebook.

    Returns
    -------
    list of str
        One string per statement, in the order of the notebook.

    Raises
    ------
    LookupError
        The notebook does not define one of the names.
    NotImplementedError
        One of these functions is still a stub.
    """
    names, statements = tuple(names), slicing.parse_notebook(cells)[0]
    defined = sorted(set().union(*(statement.binds for statement in statements)))
    for name in names:
        if name not in defined:
            similar = difflib.get_close_matches(name, defined, n=3, cutoff=0.4)
            meant = f" Did you mean {' or '.join(similar)}?" if similar else ""
            raise LookupError(f"{origin} does not define {name}.{meant}")
    found = []
    for statement in slicing.slice_for(names, statements):
        node = statement.node
        if is_stub(node):
            raise NotImplementedError(
                f"{node.name} in {origin} is still a stub. Write it there, and save the notebook."
            )
        first = min(part.lineno for part in (node, *getattr(node, "decorator_list", ())))
        lines = cells[statement.cell - 1].splitlines()[first - 1 : node.end_lineno]
        found.append("\n".join(lines))
    return found


def text_to_paste(names: Iterable[str], cells: Sequence[str], origin: str) -> str:
    """Return functions as text to paste: imports, a comment with their origin, definitions.

    Parameters
    ----------
    names, cells, origin
        As in `source_texts`.
    """
    texts = source_texts(names, cells, origin)
    others = [text for text in texts if not is_import(text)]
    used = {
        node.id for node in ast.walk(ast.parse("\n".join(others))) if isinstance(node, ast.Name)
    }
    imports = [text for text in texts if is_import(text) and _is_used(text, used)]
    above = "\n".join(dict.fromkeys(imports)) + "\n\n\n" if imports else ""
    return f"{above}# from {origin}\n" + "\n\n\n".join(others) + "\n"


def is_import(text: str) -> bool:
    """Return whether a statement is an import."""
    return isinstance(ast.parse(text).body[0], _IMPORTS)


def _is_used(text: str, used: set[str]) -> bool:
    """Return whether an import may bind one of the names, or changes the meaning of the code."""
    node = ast.parse(text).body[0]
    bound = {alias.asname or alias.name.split(".")[0] for alias in node.names}
    return "*" in bound or getattr(node, "module", "") == "__future__" or bool(bound & used)


def is_stub(node: ast.stmt) -> bool:
    """Return whether a statement defines a function that is not written yet."""
    last = node.body[-1] if isinstance(node, ast.FunctionDef) else None
    return (
        isinstance(last, ast.Raise)
        and last.exc is not None
        and ast.unparse(last.exc).split("(")[0] == "NotImplementedError"
    )
