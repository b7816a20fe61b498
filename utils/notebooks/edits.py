"""All functions that are one edit away from one that somebody wrote.

An edit is what a slip of the pen is, undone: another operator or comparison, a constant off by one,
a sign, an axis, two things exchanged, a call, an index or a name too many or too few, a statement
one level too deep. What an edit makes an edit undoes, but for what would have to be invented: a
whole statement, or a term that stands nowhere. Singh et al. ("Automated feedback generation for
introductory programming assignments", PLDI 2013) write such rules down for each exercise, and have
a solver compare with a model answer; here they are the same for all, and who tries them asks the
changed function.

This module reads text that strangers wrote, and runs in the sandbox for that reason.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from utils.notebooks.edits_of_nodes import Names, SourceText, edits_of_node, names_in
from utils.notebooks.statements import Statement

# Of one function; the likeliest edits come first.
MOST_EDITS = 600
# A function of more lines is no exercise of this course.
MOST_LINES = 120

_ENTERED = ("break", "continue", "return")


@dataclass(frozen=True)
class Edit:
    """Some lines of a cell, and what stands in their place.

    Attributes
    ----------
    cell : int
        Number of the code cell.
    first, last : int
        Numbers of its lines.
    text : str
        What takes their place.
    statement : str
        The whole changed statement.
    """

    cell: int
    first: int
    last: int
    text: str
    statement: str


def edits_of(cells: list[str], statements: Iterable[Statement]) -> list[Edit]:
    """Each way to change one of some functions, or classes, by one edit.

    Parameters
    ----------
    cells : list of str
        Source of the notebook's code cells.
    statements : iterable of Statement
        The definitions in question.

    Returns
    -------
    list of Edit
        `MOST_EDITS` at most, the likeliest first. Some are no Python; who runs them will see.
    """
    found = []
    for statement in statements:
        try:
            found += _edits_of_one(cells, statement)
        except (ValueError, IndexError, SyntaxError, RecursionError, MemoryError):
            continue  # text that means something else than it says
    found.sort(key=lambda ranked: ranked[0])
    return [edit for _, edit in found[:MOST_EDITS]]


def _edits_of_one(cells: list[str], statement: Statement) -> Iterator[tuple[int, Edit]]:
    node = statement.node
    decorators = [decorator.lineno for decorator in getattr(node, "decorator_list", ())]
    first, last = min([node.lineno, *decorators]), node.end_lineno
    lines = cells[statement.cell - 1].split("\n")[first - 1 : last]
    block = "\n".join(lines)
    tree = ast.parse(block)
    if last - first >= MOST_LINES or ast.dump(tree.body[0]) != ast.dump(node):
        return
    seen = {block}
    for rank, text in sorted(_texts(block, tree), key=lambda ranked: ranked[0]):
        changed = text()
        if changed not in seen:
            seen.add(changed)
            yield rank, _edit(statement.cell, first, lines, changed)
        if len(seen) > MOST_EDITS:
            return


def _edit(cell: int, first: int, lines: list[str], changed: str) -> Edit:
    """The lines that differ, and no others."""
    new = changed.split("\n")
    begin = 0
    while begin < min(len(lines), len(new)) and lines[begin] == new[begin]:
        begin += 1
    end = 0
    while end < min(len(lines), len(new)) - begin and lines[-1 - end] == new[-1 - end]:
        end += 1
    # What only takes lines away, or puts some between two, says so beside a line that stays.
    if begin in (len(lines) - end, len(new) - end):
        begin -= 1
    text = "\n".join(new[begin : len(new) - end])
    return Edit(cell, first + begin, first + len(lines) - end - 1, text, changed)


def _texts(block: str, tree: ast.Module) -> Iterator[tuple[int, Callable[[], str]]]:
    """What makes a changed block, with a rank: 0 for what is likeliest."""
    source = SourceText(block)
    function = tree.body[0]
    docstrings = {id(node) for node in _docstrings(tree)}
    names = names_in(function)
    for node, parent, field in _walk(function):
        if id(node) in docstrings:
            continue
        for rank, begin, end, text in edits_of_node(source, node, parent, field, names):
            yield rank, functools.partial(source.with_text, begin, end, text)
    for rank, text in _returning(block, function, names):
        yield rank, functools.partial(str, text)
    for text in _moved(block, function):
        yield 2, functools.partial(str, text)


def _walk(node: ast.AST, parent: ast.AST | None = None, field: str = "") -> Iterator[tuple]:
    """Each node inside, with what it belongs to and as what; without signatures."""
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


def _returning(block: str, function: ast.AST, names: Names) -> Iterator[tuple[int, str]]:
    """The block with a name returned in the end, or a part of an argument, where nothing is."""
    if isinstance(function, ast.FunctionDef) and not isinstance(function.body[-1], ast.Return):
        end = f"{block}\n{' ' * function.body[-1].col_offset}return "
        for name in names.bound:
            yield 1, end + name
            for whole in names.arguments:
                yield 4, f"{end}{whole}[{name}]"
                yield 4, f"{end}{whole}[~{name}]"


def _moved(block: str, function: ast.AST) -> Iterator[str]:
    """The block with some statements one level out or in, exchanged, left out or ended early."""
    lines = block.split("\n")
    for parent in ast.walk(function):
        for field in ("body", "orelse", "finalbody"):
            body = getattr(parent, field, None)
            if isinstance(body, list) and body and isinstance(body[0], ast.stmt):
                yield from _moved_in(lines, body, getattr(parent, "col_offset", 0))


def _moved_in(lines: list[str], body: list[ast.stmt], outer: int) -> Iterator[str]:
    depth = body[0].col_offset
    if ast.get_docstring(ast.Module(body, [])) is not None:
        body = body[1:]
    if not body:
        return
    rest = body[-1].end_lineno
    for position, statement in enumerate(body):
        first, last = statement.lineno - 1, statement.end_lineno
        if position:  # one level out, with all that follows
            yield _shifted(lines, first, rest, outer - depth)
            before = body[position - 1]
            inner = getattr(before, "orelse", None) or getattr(before, "body", None)
            if inner:  # into what stands before it, with some that follow
                for end in [one.end_lineno for one in body[position:]]:
                    yield _shifted(lines, first, end, inner[0].col_offset - depth)
            here, there = before.lineno - 1, before.end_lineno
            exchanged = lines[first:last] + lines[there:first] + lines[here:there]
            yield "\n".join([*lines[:here], *exchanged, *lines[last:]])
        if len(body) > 1:
            yield "\n".join([*lines[:first], *lines[last:]])
    for word in _ENTERED:
        yield "\n".join([*lines[:rest], " " * depth + word, *lines[rest:]])


def _shifted(lines: list[str], first: int, last: int, by: int) -> str:
    """The lines with some of them moved to the right, or to the left."""
    moved = [
        (" " * by + line if by > 0 else line[-by:]) if line.strip() else line
        for line in lines[first:last]
    ]
    return "\n".join([*lines[:first], *moved, *lines[last:]])
