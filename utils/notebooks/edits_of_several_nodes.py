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

    The edits correct these slips:

    - a notebook variable or a number in place of a parameter
    - two parameters that are exchanged in one statement or throughout
    - several calls without the same axis
    - row numbers returned instead of a mask
    - several calls that pass a counter without increasing it
    - calls whose results are lost
    - a superfluous operand in each copy of an expression
    - another operator in place of each power
    - `math` used for arrays
    - rows or all columns of a table where some columns are needed
    - columns that are shifted by one
    - exchanged + and -
    - an assignment to a variable instead of to its attribute

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
        for foreign in names.unbound:
            places = [source.span(node) for node in read if node.id == foreign]
            yield -1, [(*place, parameter) for place in places]
        for node in read:
            if node.id in names.arguments:
                yield 0, [(*source.span(node), parameter)]
        for node in nodes:
            if isinstance(node, ast.Constant) and type(node.value) in (int, float):
                yield 0, [(*source.span(node), parameter)]
    statements = (ast.Assign, ast.AugAssign, ast.Return)
    for part in [function, *(node for node in nodes if isinstance(node, statements))]:
        inside = [node for node in ast.walk(part) if isinstance(node, ast.Name)]
        for first, second in itertools.combinations(names.arguments[1:], 2):
            if {first, second} <= {node.id for node in inside}:
                exchanged = {first: second, second: first}
                both = [node for node in inside if node.id in exchanged]
                yield 1, [(*source.span(node), exchanged[node.id]) for node in both]
    attributes = [node for node in nodes if isinstance(node, ast.Attribute)]
    for first, second in TWINS:
        exchanged = {first: second, second: first}
        both = [node for node in attributes if node.attr in exchanged]
        if len({node.attr for node in both}) > 1:
            ends = [(source.span(node)[1], node.attr) for node in both]
            yield 1, [(end - len(name), end, exchanged[name]) for end, name in ends]
    yield from _axis_edits_of_several_calls(source, nodes)
    yield from _edits_of_returned_rows(source, nodes, names)
    yield from _edits_of_several_calls(source, nodes)
    yield from _edits_of_copied_expressions(source, nodes)
    yield from _edits_of_several_powers(source, nodes)
    yield from _exchanged_signs(source, nodes)
    yield from _attribute_assignments(source, nodes, attributes)
    yield from _edits_of_modules(source, nodes)
    yield from _edits_of_columns(source, nodes, names)
    yield from _edits_of_shifted_slices(source, nodes)
    differences = [node for node in nodes if isinstance(getattr(node, "op", None), ast.Sub)]
    operands = [node.right if isinstance(node, ast.BinOp) else node.value for node in differences]
    subtracted = {operand.id: 1 for operand in operands if isinstance(operand, ast.Name)}
    for node in nodes:
        # Add back what was subtracted.
        for name in subtracted if isinstance(node, ast.Assign) else ():
            yield 0, [(*source.span(node.value), f"({source.text_of(node.value)}) + {name}")]


def _edits_of_several_calls(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Add 1 to an argument of all calls of one function, or add lost results of one or all calls.

    The argument may be a part of a tuple, as in `queue.append((child, depth))`.
    """
    calls: dict[str, list[ast.Call]] = {}
    lost: dict[str, list[ast.Call]] = {}
    for node in nodes:
        if isinstance(node, ast.Call):
            calls.setdefault(source.text_of(node.func), []).append(node)
        elif isinstance(node, ast.Expr) and isinstance(getattr(node.value, "func", None), ast.Name):
            lost.setdefault(node.value.func.id, []).append(node.value)
    for several in calls.values():
        places: dict[str, list[tuple[int, int]]] = {}
        for call in several:
            for argument in call.args:
                parts = argument.elts if isinstance(argument, ast.Tuple) else [argument]
                for part in parts:
                    if isinstance(part, ast.Name):
                        places.setdefault(part.id, []).append(source.span(part))
        for name, spans in places.items():
            if len(spans) == len(several) > 1:
                yield 1, [(*span, f"{name} + 1") for span in spans]
    returned = {node.value.id: 1 for node in nodes if _is_return_of_a_name(node)}
    for several in lost.values():
        for name in returned:
            starts = [source.span(call)[0] for call in several]
            edits = [(start, start, f"{name} += ") for start in starts]
            yield 0, edits
            yield from ((0, [edit]) for edit in edits if len(edits) > 1)


def _is_return_of_a_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Return) and isinstance(node.value, ast.Name)


def _edits_of_copied_expressions(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Replace all copies of an expression, such as `label - 1`, with one of its operands."""
    copies: dict[str, list[ast.BinOp]] = {}
    for node in nodes:
        if isinstance(node, ast.BinOp):
            copies.setdefault(source.text_of(node), []).append(node)
    for several in copies.values():
        first = several[0]
        for operand in (first.left, first.right) if len(several) > 1 else ():
            yield 1, [(*source.span(node), f"({source.text_of(operand)})") for node in several]


def _edits_of_several_powers(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Turn each `x ^ 2`, or each `x * 2`, into a power."""
    places: dict[str, list[tuple[int, int, str]]] = {}
    for node in nodes:
        operator = type(node.op) if isinstance(node, ast.BinOp) else None
        is_doubled = operator is ast.Mult and getattr(node.right, "value", None) == 2
        if is_doubled or operator is ast.BitXor:
            sign = "*" if is_doubled else "^"
            start, end = source.span(node.left)[1], source.span(node.right)[0]
            at = start + source.text(start, end).find(sign)
            places.setdefault(sign, []).append((at, at + 1, "**"))
    for several in places.values():
        if len(several) > 1:
            yield 0, several


def _exchanged_signs(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Exchange + and - between expressions with equal operands, such as `x - r` and `x + r`."""
    same_operands: dict[tuple[str, str], list[ast.BinOp]] = {}
    for node in nodes:
        if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub)):
            operands = source.text_of(node.left), source.text_of(node.right)
            same_operands.setdefault(operands, []).append(node)
    for (left, right), several in same_operands.items():
        if len({type(node.op) for node in several}) > 1:
            signs = ["-" if isinstance(node.op, ast.Add) else "+" for node in several]
            yield (
                1,
                [
                    (*source.span(node), f"({left}) {sign} ({right})")
                    for node, sign in zip(several, signs, strict=True)
                ],
            )


def _attribute_assignments(
    source: SourceText, nodes: list[ast.AST], attributes: list[ast.Attribute]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Assign to an attribute of a variable, such as `node.left`, instead of to the variable."""
    known: dict[str, dict[str, int]] = {}
    for node in attributes:
        if isinstance(node.value, ast.Name):
            known.setdefault(node.value.id, {})[node.attr] = 1
    for node in nodes:
        for target in node.targets if isinstance(node, ast.Assign) else ():
            if isinstance(target, ast.Name):
                for name in known.get(target.id, ()):
                    yield 1, [(*source.span(target), f"{target.id}.{name}")]


def _edits_of_modules(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Replace each `math.` with `np.`."""
    modules = [node for node in nodes if isinstance(node, ast.Name) and node.id == "math"]
    if modules:
        yield 0, [(*source.span(node), "np") for node in modules]


def _edits_of_columns(
    source: SourceText, nodes: list[ast.AST], names: Names
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Turn all rows of a parameter into columns, or use its first columns in all operations."""
    rows: dict[str, list[int]] = {}
    operands: dict[str, list[int]] = {}
    for node in nodes:
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Constant):
            if isinstance(node.value, ast.Name):
                rows.setdefault(node.value.id, []).append(source.span(node.slice)[0])
        elif isinstance(node, (ast.BinOp, ast.Compare)):
            sides = node.comparators if isinstance(node, ast.Compare) else [node.right]
            for side in (node.left, *sides):
                if isinstance(side, ast.Name):
                    operands.setdefault(side.id, []).append(source.span(side)[1])
    for places, texts in ((rows, (":, ",)), (operands, ("[:, :3]", "[:, :2]"))):
        for name, several in places.items():
            for text in texts if name in names.arguments and len(several) > 1 else ():
                yield 1, [(place, place, text) for place in several]


def _edits_of_shifted_slices(
    source: SourceText, nodes: list[ast.AST]
) -> Iterator[tuple[int, list[tuple[int, int, str]]]]:
    """Begin and end one earlier in all copies of a slice: `1:4` becomes `:3`."""
    places: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for node in nodes:
        if isinstance(node, ast.Slice) and node.step is None:
            first, end = (getattr(bound, "value", None) for bound in (node.lower, node.upper))
            if type(first) is type(end) is int and first > 0:
                places.setdefault((first, end), []).append(source.span(node))
    for (first, end), spans in places.items():
        yield 0, [(*span, f"{first - 1 or ''}:{end - 1}") for span in spans]


def _edits_of_returned_rows(
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


def _axis_edits_of_several_calls(
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
