"""Generate all functions that are one edit away from a student's function.

An edit undoes a typical slip. It changes an operator, a constant, a sign or an axis, swaps two
parts, adds or removes a call, an index or a name, or moves a statement. No edit invents a term that
is not in the function. The only new statements copy one name to another, or let a counter grow.

Singh et al. ("Automated feedback generation for introductory programming assignments", PLDI 2013)
write such rules for each exercise. Here they are the same for all exercises.

This module reads untrusted text, so it runs in the sandbox.
"""

from __future__ import annotations

import ast
import contextlib
import functools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from utils.notebooks.edits_of_indices import edits_of_indices
from utils.notebooks.edits_of_nodes import Names, SourceText, edits_of_node, names_in
from utils.notebooks.edits_of_several_nodes import edits_of_several_nodes
from utils.notebooks.statements import Statement

# Limit for the edits of all functions together; the likeliest are kept.
MAX_EDITS = 640
# Longer functions are not edited; no exercise of this course needs that many lines.
MAX_LINES = 120

_JUMPS = ("break", "continue", "return")


@dataclass(frozen=True)
class Edit:
    """A replacement for some lines of a cell.

    Attributes
    ----------
    cell : int
        Number of the code cell, from 1.
    first, last : int
        First and last line to replace.
    text : str
        The new lines.
    statement : str
        Source of the whole statement after the edit.
    rank : int
        Lower for likelier edits.
    """

    cell: int
    first: int
    last: int
    text: str
    statement: str
    rank: int


def edits_of(cells: list[str], statements: Iterable[Statement]) -> list[Edit]:
    """List the edits of some functions or classes; each edit changes one of them.

    Parameters
    ----------
    cells : list of str
        Source of the notebook's code cells.
    statements : iterable of Statement
        The definitions to change.

    Returns
    -------
    list of Edit
        At most `MAX_EDITS`, the likeliest first. Some are not valid Python, so the caller must
        expect a SyntaxError.
    """
    found = []
    for statement in statements:
        # A fault here must not stop the check, whose results matter more than a line hint.
        with contextlib.suppress(Exception):
            found += edits_of_statement(cells, statement)
    return sorted(found, key=lambda edit: edit.rank)[:MAX_EDITS]


def edits_of_statement(cells: list[str], statement: Statement) -> Iterator[Edit]:
    """Yield the edits of one function or class; see `edits_of`."""
    node = statement.node
    decorators = [decorator.lineno for decorator in getattr(node, "decorator_list", ())]
    first, last = min([node.lineno, *decorators]), node.end_lineno
    lines = cells[statement.cell - 1].split("\n")[first - 1 : last]
    block = "\n".join(lines)
    tree = ast.parse(block)
    if last - first >= MAX_LINES or ast.dump(tree.body[0]) != ast.dump(node):
        return
    seen = {block}
    for rank, text in sorted(_ranked_edits(block, tree), key=lambda pair: pair[0]):
        changed = text()
        if changed not in seen:
            seen.add(changed)
            yield _make_edit(statement.cell, first, lines, changed, rank)
        if len(seen) > MAX_EDITS:
            return


def _make_edit(cell: int, first: int, lines: list[str], changed: str, rank: int) -> Edit:
    """Build an edit that replaces only the lines that differ."""
    new = changed.split("\n")
    start = 0
    while start < min(len(lines), len(new)) and lines[start] == new[start]:
        start += 1
    end = 0
    while end < min(len(lines), len(new)) - start and lines[-1 - end] == new[-1 - end]:
        end += 1
    # An edit that only deletes lines also includes the line after them, so that it begins with a
    # deleted line. An edit that inserts lines, or deletes the last lines, also includes the line
    # before them.
    if start == len(new) - end and end:
        end -= 1
    elif start in (len(lines) - end, len(new) - end):
        start -= 1
    text = "\n".join(new[start : len(new) - end])
    return Edit(cell, first + start, first + len(lines) - end - 1, text, changed, rank)


def _ranked_edits(block: str, tree: ast.Module) -> Iterator[tuple[int, Callable[[], str]]]:
    """Yield the rank of each edit, lower for likelier ones, and a function that applies it."""
    source = SourceText(block)
    function = tree.body[0]
    docstrings = {id(node) for node in _docstrings(tree)}
    names = names_in(function)
    walked = list(_walk(function))
    for node, parent, field in walked:
        if id(node) in docstrings:
            continue
        for rank, start, end, text in edits_of_node(source, node, parent, field, names):
            yield rank, functools.partial(source.with_text, start, end, text)
    for rank, text in _with_return(block, function, names):
        yield rank, functools.partial(str, text)
    for rank, text in _moved_statements(block, function):
        yield rank, functools.partial(str, text)
    for rank, text in _with_assignment(block, function):
        yield rank, functools.partial(str, text)
    for text in _with_growing_counters(block, function):
        yield -1, functools.partial(str, text)
    for text in _with_new_defaults(block, function):
        yield 0, functools.partial(str, text)
    for rank, replacements in edits_of_several_nodes(source, function, names):
        yield rank, functools.partial(_replace_texts, source, replacements)
    for rank, replacements in edits_of_indices(source, walked, names):
        yield rank, functools.partial(_replace_texts, source, replacements)


def _walk(node: ast.AST, parent: ast.AST | None = None, field: str = "") -> Iterator[tuple]:
    """Yield each node, its parent and its field in the parent; skip signatures and decorators."""
    yield node, parent, field
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "args") and isinstance(
            node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.AnnAssign)
        ):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _walk(child, node, name)


def _docstrings(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


def _with_return(block: str, function: ast.AST, names: Names) -> Iterator[tuple[int, str]]:
    """Yield the rank and the block with a final `return` of a name or a part of an argument."""
    if isinstance(function, ast.FunctionDef) and not isinstance(function.body[-1], ast.Return):
        end = f"{block}\n{' ' * function.body[-1].col_offset}return "
        for name in names.bound:
            yield 1, end + name
            for whole in names.arguments:
                yield 4, f"{end}{whole}[{name}]"
                yield 4, f"{end}{whole}[~{name}]"


def _with_assignment(block: str, function: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the rank and the block with an added assignment in a loop, such as `best = row`.

    The name on the left occurs in a `return` or in the condition of an `if`. It is set only before
    the loop, or the assignment follows another one in an `if`. The name on the right is set in the
    loop.
    """
    lines = block.split("\n")
    used = [
        node.test if isinstance(node, ast.If) else node
        for node in ast.walk(function)
        if isinstance(node, (ast.Return, ast.If))
    ]
    shown = {name.id for node in used for name in ast.walk(node) if isinstance(name, ast.Name)}
    for loop in ast.walk(function):
        if isinstance(loop, (ast.For, ast.While)):
            nodes = list(ast.walk(loop))
            inside = {node.id: True for node in nodes if _is_set(node)}
            before = {node.id for node in ast.walk(function) if _is_set(node)} - inside.keys()
            in_if = {child for node in nodes if isinstance(node, ast.If) for child in node.body}
            for node in nodes:
                if not isinstance(node, ast.Assign):
                    continue
                first, indent = node.end_lineno, " " * node.col_offset
                for kept in sorted(shown & ({*before, *inside} if node in in_if else before)):
                    rank = 0 if node in in_if and kept in before else 1
                    for name in inside:
                        text = f"{indent}{kept} = {name}"
                        yield rank, "\n".join([*lines[:first], text, *lines[first:]])


def _with_growing_counters(block: str, function: ast.AST) -> Iterator[str]:
    """Yield the block with an added `cluster += 1` in a loop that reads the counter `cluster`.

    The counter is set only once in the function: to a whole number, before the loop.
    """
    lines = block.split("\n")
    nodes = list(ast.walk(function))
    times_set = Counter(node.id for node in nodes if _is_set(node))
    counters = {
        target.id: node.end_lineno
        for node in nodes
        if isinstance(node, ast.Assign) and type(getattr(node.value, "value", None)) is int
        for target in node.targets
        if isinstance(target, ast.Name) and times_set[target.id] == 1
    }
    steps = {}
    for loop in (node for node in nodes if isinstance(node, (ast.For, ast.While))):
        read = {node.id for node in ast.walk(loop) if isinstance(node, ast.Name)}
        for name in [name for name in counters if name in read and counters[name] < loop.lineno]:
            for statement in [node for part in loop.body for node in ast.walk(part)]:
                if isinstance(statement, ast.stmt):
                    text = f"{' ' * statement.col_offset}{name} += 1"
                    steps[statement.lineno - 1, text] = steps[statement.end_lineno, text] = None
    for line, text in steps:
        yield "\n".join([*lines[:line], text, *lines[line:]])


def _with_new_defaults(block: str, function: ast.AST) -> Iterator[str]:
    """Yield the block with a default list, set or dict that each call creates for itself."""
    if not isinstance(function, ast.FunctionDef):
        return
    lines = block.split("\n")
    has_docstring = ast.get_docstring(function) is not None
    before = function.body[0].end_lineno if has_docstring else function.body[0].lineno - 1
    indent = " " * function.body[0].col_offset
    defaults = function.args.defaults
    arguments = function.args.args[len(function.args.args) - len(defaults) :]
    for argument, default in zip(arguments, defaults, strict=True):
        if isinstance(default, (ast.List, ast.Set, ast.Dict, ast.Call)):
            text = f"{indent}{argument.arg} = {ast.unparse(default)}"
            yield "\n".join([*lines[:before], text, *lines[before:]])


def _is_set(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)


def _replace_texts(source: SourceText, replacements: list[tuple[int, int, str]]) -> str:
    """Return the whole text with several parts replaced."""
    for start, end, text in sorted(replacements, reverse=True):
        source = SourceText(source.with_text(start, end, text))
    return source.with_text(0, 0, "")


def _moved_statements(block: str, function: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield the rank and the block with statements moved, swapped or deleted, or a jump added."""
    lines = block.split("\n")
    yield from ((-1, text) for text in _returns_moved_out(lines, function, []))
    for parent in ast.walk(function):
        for field in ("body", "orelse", "finalbody"):
            body = getattr(parent, field, None)
            if isinstance(body, list) and body and isinstance(body[0], ast.stmt):
                yield from _edits_with_lines_moved_in(lines, body, getattr(parent, "col_offset", 0))
                # The special case of an empty tree often lacks its `return`.
                if isinstance(parent, ast.If) and parent in function.body:
                    end, indent = body[-1].end_lineno, " " * body[-1].col_offset
                    yield 1, "\n".join([*lines[:end], f"{indent}return", *lines[end:]])


def _returns_moved_out(lines: list[str], node: ast.AST, outside: list[ast.stmt]) -> Iterator[str]:
    """Yield the lines with one `return` moved after one of the blocks that contain it."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Return):
            first, last = child.lineno - 1, child.end_lineno
            for block in reversed(outside):
                shift = block.col_offset - child.col_offset
                end = block.end_lineno
                returned = _shift_lines(lines, first, last, shift)[first:last]
                yield "\n".join([*lines[:first], *lines[last:end], *returned, *lines[end:]])
        elif not isinstance(child, (ast.FunctionDef, ast.Lambda)):
            # A `case` has no column of its own, so only its `match` counts.
            is_block = isinstance(child, (ast.stmt, ast.ExceptHandler))
            blocks = [*outside, child] if is_block else outside
            yield from _returns_moved_out(lines, child, blocks)


def _edits_with_lines_moved_in(
    lines: list[str], body: list[ast.stmt], outer: int
) -> Iterator[tuple[int, str]]:
    depth = body[0].col_offset
    if ast.get_docstring(ast.Module(body, [])) is not None:
        body = body[1:]
    if not body:
        return
    rest = body[-1].end_lineno
    for position, statement in enumerate(body):
        first, last = statement.lineno - 1, statement.end_lineno
        if position:  # one level out, with all statements that follow
            yield 1, "\n".join(_shift_lines(lines, first, rest, outer - depth))
            before = body[position - 1]
            inner = getattr(before, "orelse", None) or getattr(before, "body", None)
            if inner:  # into the preceding block, with some of the statements that follow
                for end in [following.end_lineno for following in body[position:]]:
                    yield 2, "\n".join(_shift_lines(lines, first, end, inner[0].col_offset - depth))
            here, there = before.lineno - 1, before.end_lineno
            exchanged = lines[first:last] + lines[there:first] + lines[here:there]
            yield 2, "\n".join([*lines[:here], *exchanged, *lines[last:]])
        for earlier, skipped in enumerate(body[: max(position - 1, 0)]):  # further up
            start = skipped.lineno - 1
            moved = [*lines[first:last], *lines[start:first]]
            calls = all(isinstance(passed, ast.Expr) for passed in body[earlier:position])
            yield 1 if calls else 3, "\n".join([*lines[:start], *moved, *lines[last:]])
        for later in body[position + 2 :]:  # further down
            end = later.end_lineno
            moved = [*lines[last:end], *lines[first:last]]
            yield 3, "\n".join([*lines[:first], *moved, *lines[end:]])
        if len(body) > 1:
            yield 1, "\n".join([*lines[:first], *lines[last:]])
    for word in _JUMPS:
        yield 3, "\n".join([*lines[:rest], " " * depth + word, *lines[rest:]])


def _shift_lines(lines: list[str], first: int, last: int, columns: int) -> list[str]:
    """Return the lines with some of them indented, or unindented if `columns` is negative."""
    moved = [
        (" " * columns + line if columns > 0 else line[-columns:]) if line.strip() else line
        for line in lines[first:last]
    ]
    return [*lines[:first], *moved, *lines[last:]]
