"""Generate edits that correct a slip wherever it occurs in a function."""

from __future__ import annotations

import ast
import itertools
from collections.abc import Iterator

from utils.notebooks.edits_of_nodes import AXIS_FUNCTIONS, TWINS, Names, SourceText


def edits_of_several_nodes(
    source: SourceText, function: ast.AST, names: Names
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Yield the rank of each edit, and all its replacements.

    Such slips are a notebook variable or a number used instead of a parameter, two parameters that
    are exchanged in a statement or throughout, several calls that lack the same axis, and row
    numbers that are returned instead of a mask.

    Parameters
    ----------
    source : SourceText
    function : ast.AST
    names : Names
    """
    nodes = [node for statement in function.body for node in ast.walk(statement)]
    read = [node for node in nodes if isinstance(node, ast.Name)]
    used = {node.id for node in read}
    for parameter in [name for name in names.arguments if name not in used]:
        for foreign in names.missing:
            places = [source.span(node) for node in read if node.id == foreign]
            yield -1, [(*place, parameter) for place in places]
        for node in nodes:
            if isinstance(node, ast.Constant) and type(node.value) in (int, float):
                yield 0, [(*source.span(node), parameter)]
    statements = (ast.Assign, ast.AugAssign, ast.Return)
    for part in [function, *(node for node in nodes if isinstance(node, statements))]:
        inside = [node for node in ast.walk(part) if isinstance(node, ast.Name)]
        for one, other in itertools.combinations(names.arguments[1:], 2):
            if {one, other} <= {node.id for node in inside}:
                exchanged = {one: other, other: one}
                both = [node for node in inside if node.id in exchanged]
                yield 1, [(*source.span(node), exchanged[node.id]) for node in both]
    attributes = [node for node in nodes if isinstance(node, ast.Attribute)]
    for one, other in TWINS:
        exchanged = {one: other, other: one}
        both = [node for node in attributes if node.attr in exchanged]
        if len({node.attr for node in both}) > 1:
            ends = [(source.span(node)[1], node.attr) for node in both]
            yield 1, [(end - len(name), end, exchanged[name]) for end, name in ends]
    yield from _axes_of_several_calls(source, nodes)
    yield from _masks_of_returned_rows(source, nodes, names)


def _masks_of_returned_rows(
    source: SourceText, nodes: list[ast.AST], names: Names
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Turn a name in all `return` statements from row numbers of the first argument into a mask."""
    places: dict[str, list[tuple[int, int]]] = {}
    for node in nodes:
        if isinstance(node, ast.Return) and node.value is not None:
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            for value in values:
                if isinstance(value, ast.Name):
                    places.setdefault(value.id, []).append(source.span(value))
    for rows, spans in places.items() if names.arguments else ():
        mask = f"np.isin(np.arange(len({names.arguments[0]})), {rows})"
        yield 0, [(*span, mask) for span in spans]


def _axes_of_several_calls(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Add an axis to all calls without one, or give all calls of one function the same axis."""
    bare, given = [], {}
    for node in nodes:
        name = node.func.attr if isinstance(getattr(node, "func", None), ast.Attribute) else ""
        if name in AXIS_FUNCTIONS:
            axes = [word.value for word in node.keywords if word.arg == "axis"]
            bare += [] if axes else [(source.span(node)[1], ", " if node.args else "")]
            given.setdefault(name, []).extend(axes)
            given.setdefault("", []).extend(axes)
    for axis in (0, 1) if len(bare) > 1 else ():
        yield 1, [(end - 1, end, f"{comma}axis={axis})") for end, comma in bare]
    for axes in given.values():
        for axis in (0, 1) if len(axes) > 1 else ():
            yield 1, [(*source.span(value), str(axis)) for value in axes]
