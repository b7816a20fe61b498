"""The part of a notebook that an exercise needs.

A notebook is a story: it loads a street, draws it, tries things out. The judge, and another
notebook, want the student's functions and what those functions use, and nothing that costs time
or can fail beside them. So the notebook is cut backwards from the functions' names: a top-level
statement stays when it binds, or changes, a name that is needed; the names it uses are then
needed too.

This module reads text that strangers wrote, and runs in the sandbox for that reason.
"""

import __future__

import ast
from collections.abc import Iterable, Iterator
from types import CodeType

from utils.notebooks.magics import parse_cell
from utils.notebooks.statements import Statement, describe


def parse_notebook(cells: Iterable[str]) -> tuple[list[Statement], list[str]]:
    """Top-level statements of a notebook's code cells.

    Parameters
    ----------
    cells : iterable of str
        Source of each code cell.

    Returns
    -------
    statements : list of Statement
    problems : list of str
        A sentence for each cell that is not Python.
    """
    statements, problems, future = [], [], 0
    for number, source in enumerate(cells, start=1):
        try:
            nodes = parse_cell(source).body
            future |= _future_flags(nodes)
            statements += [describe(number, node, future) for node in nodes]
        except SyntaxError as error:
            line = (error.text or "").strip()
            problems.append(
                f"Code cell {number} is not valid Python, so it was skipped: "
                f"{error.msg} (line {error.lineno}: {line[:80]!r})."
            )
        except Exception as error:  # strangers' text breaks parsers in ways of its own
            problems.append(
                f"Code cell {number} could not be read ({type(error).__name__}), so it was skipped."
            )
    return statements, problems


def slice_for(names: Iterable[str], statements: list[Statement]) -> list[Statement]:
    """The statements that the functions of some names need, in the order of the notebook."""
    kept = set().union(*(_needed_by(name, statements) for name in names))
    return [statements[position] for position in sorted(kept)]


def lines_of(names: Iterable[str], statements: list[Statement]) -> list[list[int]]:
    """Where a notebook writes functions, and those of its own functions that these need.

    Returns
    -------
    list of [int, int, int]
        Number of the code cell, first and last line.
    """
    return places_of(slice_for(names, statements))


def places_of(statements: Iterable[Statement]) -> list[list[int]]:
    """Where the functions and classes among some statements of a notebook stand; see `lines_of`."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    return [
        [statement.cell, statement.node.lineno, statement.node.end_lineno]
        for statement in statements
        if isinstance(statement.node, kinds) and statement.cell
    ]


def is_checked(name: str, statements: list[Statement]) -> bool:
    """Whether a `check(name)` follows the last definition: then it is an exercise."""
    return _end_of_exercise(name, statements) < len(statements)


def end_of_checks(names: Iterable[str], statements: list[Statement]) -> int:
    """Position of the last ``check(name)`` of some names; 0 without one."""
    names = tuple(names)
    return max(
        (
            position
            for position, statement in enumerate(statements)
            if any(_is_check(statement.node, name) for name in names)
        ),
        default=0,
    )


def _needed_by(name: str, statements: list[Statement]) -> set[int]:
    """Positions of the statements that one function needs."""
    # `sys.setrecursionlimit(...)` and its like work by what they do to the interpreter, so
    # they count even when no function names `sys`.
    needed, kept = {name, "sys"}, set()
    modules = {
        name
        for statement in statements
        if isinstance(statement.node, (ast.Import, ast.ImportFrom))
        for name in statement.binds
    }
    end = _end_of_exercise(name, statements)
    early = frozenset().union(*(statement.binds for statement in statements[:end]))
    grown = True
    while grown:
        grown = False
        for position, statement in enumerate(statements):
            touched = statement.binds | statement.changes | (statement.calls - modules)
            if position >= end:
                # The lesson goes on, and may use a helper's name for something of its own.
                touched = touched - early
            if position not in kept and touched & needed:
                kept.add(position)
                needed |= statement.uses
                grown = True
    return kept


def _end_of_exercise(name: str, statements: list[Statement]) -> int:
    """Position of the `check(name)` that follows its last definition; the end without one."""
    last = max(
        (
            position
            for position, statement in enumerate(statements)
            if name in statement.binds | statement.changes
        ),
        default=0,
    )
    for position, statement in enumerate(statements[last:], start=last):
        if _is_check(statement.node, name):
            return position
    return len(statements)


def _is_check(node: ast.stmt, name: str) -> bool:
    """Whether a statement is ``check(name)``, with or without more arguments."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Call)
        and _names(node.value.func, "check")
        and any(_names(argument, name) for argument in node.value.args[:1])
    )


def _names(node: ast.expr, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def compile_statement(statement: Statement, filename: str) -> CodeType:
    """Compile a statement.

    Parameters
    ----------
    statement : Statement
    filename : str
        What tracebacks will say.
    """
    module = ast.Module([statement.node], type_ignores=[])
    return compile(module, filename, "exec", flags=statement.future, dont_inherit=True)


def imported_modules(statements: Iterable[Statement]) -> Iterator[tuple[int, str]]:
    """Find what statements import, wherever it stands in them.

    Yields
    ------
    cell : int
        Of the statement, counted from 1.
    module : str
        Its dotted name.
    """
    for statement in statements:
        for node in ast.walk(statement.node):
            yield from ((statement.cell, module) for module in imported_by(node))


def imported_by(node: ast.AST) -> Iterator[str]:
    """Dotted names of what one node imports: modules, and what may be a module in one."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        yield node.module
        yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _future_flags(nodes: list[ast.stmt]) -> int:
    """Compiler flags that hold from a cell on; statements are compiled one by one."""
    names = [
        alias.name
        for node in nodes
        if isinstance(node, ast.ImportFrom) and node.module == "__future__"
        for alias in node.names
    ]
    return sum(
        {
            getattr(__future__, name).compiler_flag
            for name in names
            if name in __future__.all_feature_names
        }
    )
