"""Find the statements of a notebook that an exercise needs, by program slicing.

A notebook also loads a street, draws it and tries things out. The judge, or another notebook, needs
only the student's functions and the statements that they use; others cost time and may fail. This
module keeps a top-level statement if it binds or changes a needed name; the names that the
statement uses are then needed as well.

This module reads untrusted text, so it runs in the sandbox.
"""

import __future__

import ast
from collections.abc import Iterable, Iterator
from types import CodeType

from utils.notebooks.magics import parse_cell
from utils.notebooks.skipped_cells import SkippedCell, hidden_cell, invalid_cell
from utils.notebooks.statements import Statement, analyse_statement


def parse_notebook(
    cells: Iterable[str], python: tuple[int, ...] = ()
) -> tuple[list[Statement], list[SkippedCell]]:
    """Parse the top-level statements of a notebook's code cells.

    Parameters
    ----------
    cells : iterable of str
        Source of each code cell.
    python : tuple of int, optional
        The version of Python that ran the notebook, if it is known.

    Returns
    -------
    statements : list of Statement
    skipped : list of SkippedCell
        The cells that are not valid Python, or whose magic keeps their code from the notebook.
    """
    statements, skipped, future = [], [], 0
    for number, source in enumerate(cells, start=1):
        try:
            nodes = parse_cell(source).body
            future |= _future_flags(nodes)
            statements += [analyse_statement(number, node, future) for node in nodes]
            hidden = None if nodes else hidden_cell(number, source)
            skipped += [hidden] if hidden else []
        except Exception as error:  # untrusted text can break the parser in many ways
            skipped.append(invalid_cell(number, source, error, python))
    return statements, skipped


def slice_for(names: Iterable[str], statements: list[Statement]) -> list[Statement]:
    """Return the statements that the named functions need, in the order of the notebook."""
    kept = set().union(*(_positions_needed_by(name, statements) for name in names))
    return [statements[position] for position in sorted(kept)]


def lines_of(names: Iterable[str], statements: list[Statement]) -> list[list[int]]:
    """Locate the named functions in a notebook, and the functions and classes that they need.

    Returns
    -------
    list of [int, int, int]
        Number of the code cell, first line and last line of each definition.
    """
    return places_of(slice_for(names, statements))


def places_of(statements: Iterable[Statement]) -> list[list[int]]:
    """Return the cell, first line and last line of each function or class among some statements."""
    kinds = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
    return [
        [statement.cell, statement.node.lineno, statement.node.end_lineno]
        for statement in statements
        if isinstance(statement.node, kinds) and statement.cell
    ]


def is_checked(name: str, statements: list[Statement]) -> bool:
    """Return whether `check(name)` follows the last definition of the name, as for an exercise."""
    return _end_of_exercise(name, statements) < len(statements)


def end_of_checks(names: Iterable[str], statements: list[Statement]) -> int:
    """Return the position of the last ``check(name)`` for one of the names; 0 if there is none."""
    names = tuple(names)
    return max(
        (
            position
            for position, statement in enumerate(statements)
            if any(_is_check(statement.node, name) for name in names)
        ),
        default=0,
    )


def _positions_needed_by(name: str, statements: list[Statement]) -> set[int]:
    """Return the positions of the statements that one function needs."""
    # Statements such as `sys.setrecursionlimit(...)` change the interpreter, so they are kept even
    # if the function does not mention `sys`.
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
                # After the exercise, the lesson may reuse a helper's name for something else.
                touched = touched - early
            if position not in kept and touched & needed:
                kept.add(position)
                needed |= statement.uses
                grown = True
    return kept


def _end_of_exercise(name: str, statements: list[Statement]) -> int:
    """Return the position of the `check(name)` after the last definition.

    Without such a check, return the number of statements.
    """
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
    """Return whether a statement is ``check(name)``, with or without more arguments."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Call)
        and _is_name(node.value.func, "check")
        and any(_is_name(argument, name) for argument in node.value.args[:1])
    )


def _is_name(node: ast.expr, name: str) -> bool:
    return isinstance(node, ast.Name) and node.id == name


def compile_statement(statement: Statement, filename: str) -> CodeType:
    """Compile a statement with the ``__future__`` flags of its notebook.

    Parameters
    ----------
    statement : Statement
    filename : str
        File name to show in tracebacks.
    """
    module = ast.Module([statement.node], type_ignores=[])
    return compile(module, filename, "exec", flags=statement.future, dont_inherit=True)


def imported_modules(statements: Iterable[Statement]) -> Iterator[tuple[int, str]]:
    """Yield the modules that statements import, including imports nested inside them.

    Yields
    ------
    cell : int
        Number of the statement's cell, counted from 1.
    module : str
        Dotted name of the module.
    """
    for statement in statements:
        for node in ast.walk(statement.node):
            yield from ((statement.cell, module) for module in imported_by(node))


def imported_by(node: ast.AST) -> Iterator[str]:
    """Yield the dotted names that one node imports: modules, and members that may be modules."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
        yield node.module
        yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _future_flags(nodes: list[ast.stmt]) -> int:
    """Return the compiler flags that a cell's ``__future__`` imports set for later statements."""
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
