"""Generate edits that add a missing index, or use another part of a result as an index."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

from utils.notebooks.edits_of_nodes import Names, SourceText

# Functions whose result is a tuple, of which students often need one part.
_WITH_SEVERAL_RESULTS = frozenset(["svd", "eigh", "eig", "where", "nonzero", "unique", "query"])
_NUMBERS = ("0", "1", "2", "3")

Edits = Iterator[tuple[int, list[tuple[int, int, str]]]]


def edits_of_indices(source: SourceText, walked: list[tuple], names: Names) -> Edits:
    """Yield the rank of each edit, and all its replacements.

    The edits correct these slips:

    - a mask, an index or another value that the function never uses
    - an index such as `[axis]` that is missing, although the function uses it elsewhere
    - a whole tuple or table in place of one of its elements
    - another part of a result, such as `x[first]` after `first, rows = f(y)`

    Parameters
    ----------
    source : SourceText
    walked : list of (ast.AST, ast.AST, str)
        Each node of the function, its parent, and its field in the parent.
    names : Names
    """
    values = [place for place in walked if _is_value(place, names)]
    yield from _edits_with_unused_names(source, walked, values)
    yield from _edits_with_used_indices(source, walked, values)
    yield from _edits_with_numbers(source, walked, values)
    yield from _edits_with_parts_of_results(source, walked, values)


def _is_value(place: tuple, names: Names) -> bool:
    """Return whether a node is a value that could have an index, such as a name of the function."""
    node, _, field = place
    if field in ("func", "slice") or not _is_read(node):
        return False
    if isinstance(node, (ast.Name, ast.Attribute)):
        root = node
        while isinstance(root, ast.Attribute):
            root = root.value
        return not isinstance(root, ast.Name) or root.id in names.bound
    return isinstance(node, (ast.Subscript, ast.Call))


def _is_read(node: ast.AST) -> bool:
    return isinstance(getattr(node, "ctx", ast.Load()), ast.Load)


def _indexed(source: SourceText, *nodes: ast.AST, index: str) -> list[tuple[int, int, str]]:
    """Return the replacements that add an index to some nodes."""
    ends = [source.span(node)[1] for node in nodes]
    return [(end, end, f"[{index}]") for end in ends]


def _pairs(values: list[tuple]) -> list[tuple[ast.AST, ast.AST]]:
    """Return the two sides of each comparison of two values."""
    by_parent: dict[int, list[ast.AST]] = {}
    for node, parent, _ in values:
        if isinstance(parent, ast.Compare):
            by_parent.setdefault(id(parent), []).append(node)
    return [tuple(nodes) for nodes in by_parent.values() if len(nodes) == 2]


def _edits_with_unused_names(source: SourceText, walked: list[tuple], values: list[tuple]) -> Edits:
    """Use a name that the function sets but never reads: as an index, a mask or another value."""
    loads = [node for node, _, _ in walked if isinstance(node, ast.Name) and _is_read(node)]
    read = {node.id for node in loads}
    for target, parent, field in walked:
        if not isinstance(target, ast.Name) or target.id in read or target.id[0] == "_":
            continue
        # Right answers often use only some of several results, such as those of `np.unique`.
        rank = 1 if isinstance(parent, ast.Tuple) else 0
        name, line = target.id, target.lineno
        indices = (name, f"~{name}") if field == "targets" else (name,)
        for node in [node for node, _, _ in values if node.lineno > line]:
            for index in indices:
                yield rank, _indexed(source, node, index=index)
        for node in [node for node in loads if node.lineno > line]:
            yield rank, [(*source.span(node), name)]
        for pair in [pair for pair in _pairs(values) if pair[0].lineno > line]:
            yield rank, _indexed(source, *pair, index=name)


def _edits_with_used_indices(source: SourceText, walked: list[tuple], values: list[tuple]) -> Edits:
    """Add a name that is an index elsewhere to an operand, or to all equal operands."""
    slices = [node.slice for node, _, _ in walked if isinstance(node, ast.Subscript)]
    indices = {node.id: True for node in slices if isinstance(node, ast.Name)}
    copies: dict[str, list[ast.AST]] = {}
    for node, parent, _ in values:
        is_assigned = isinstance(node, ast.Attribute) and isinstance(parent, ast.Assign)
        is_operand = isinstance(parent, (ast.BinOp, ast.Compare)) or is_assigned
        if is_operand and isinstance(node, (ast.Name, ast.Attribute)):
            copies.setdefault(source.text_of(node), []).append(node)
    for index in indices:
        for text, several in copies.items():
            if text not in indices:
                if len(several) > 1:
                    yield 1, _indexed(source, *several, index=index)
                for node in several:
                    yield 1, _indexed(source, node, index=index)


def _edits_with_numbers(source: SourceText, walked: list[tuple], values: list[tuple]) -> Edits:
    """Take one element of a tuple or a table whose other elements are used, or of a result."""
    subscripts = [node for node, _, _ in walked if isinstance(node, ast.Subscript)]
    split = {
        source.text_of(node.value)
        for node in subscripts
        if isinstance(node.slice, (ast.Constant, ast.Slice))
    }
    for node, parent, _ in values:
        is_operand = isinstance(parent, (ast.BinOp, ast.Compare, ast.Tuple))
        is_assigned = isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Name)
        if isinstance(node, ast.Call):
            name = getattr(node.func, "attr", "")
            is_whole = name in _WITH_SEVERAL_RESULTS and not isinstance(parent, ast.Subscript)
            is_whole = is_whole and (is_assigned or not isinstance(parent, ast.Assign))
        else:
            is_whole = is_operand and source.text_of(node) in split
            is_whole = is_whole or (is_assigned and isinstance(node, ast.Name))
        for number in _NUMBERS if is_whole else ():
            yield 1, _indexed(source, node, index=number)


def _edits_with_parts_of_results(
    source: SourceText, walked: list[tuple], values: list[tuple]
) -> Edits:
    """Replace one part of a result with another part, or use it as an index in `np.unique(x)`."""
    earlier: dict[str, int] = {}
    for node, _, _ in walked:
        target = node.targets[0] if isinstance(node, ast.Assign) else None
        if not isinstance(target, ast.Tuple) or isinstance(node.value, ast.Tuple):
            continue
        parts = [part.id for part in target.elts if getattr(part, "id", "_") != "_"]
        earlier |= dict.fromkeys(parts, node.lineno)
        names = (used for used, _, _ in walked if isinstance(used, ast.Name) and _is_read(used))
        for used, other in itertools.product(names, parts):
            if used.id in parts and used.id != other:
                yield 1, [(*source.span(used), other)]
    for node, parent, field in values:
        is_argument = field == "args" and isinstance(parent.func, ast.Attribute)
        if is_argument and isinstance(node, ast.Name) and node is parent.args[0]:
            for name, line in earlier.items():
                if line < node.lineno and name != node.id:
                    yield 1, _indexed(source, node, index=name)
