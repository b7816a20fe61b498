"""Plan which statements to rerun, so that a cell runs as if all functions were right.

A function is replaced when stored answers take its place, or when the student's own function does
so again.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from utils.lent.stubs import CALLERS
from utils.notebooks import slicing
from utils.notebooks.statements import Statement

_IMPORTS = (ast.Import, ast.ImportFrom)
_PLAIN = (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Expr)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


@dataclass(frozen=True)
class RerunPlan:
    """The functions that a cell depends on, and the statements to rerun before it.

    Attributes
    ----------
    functions : frozenset of str
        The replaced functions on which the cell depends, directly or indirectly.
    argument_takers : frozenset of str
        Other replaced functions that received a value the cell needs, and may have changed it.
    statements : tuple of Statement
        The statements to rerun before the cell, in this order.
    names : frozenset of str
        Names whose values depend on the replaced functions, except definitions.
    """

    functions: frozenset[str]
    argument_takers: frozenset[str]
    statements: tuple[Statement, ...]
    names: frozenset[str]


def key_of_cell(source: str) -> str:
    """Return a short key that identifies a cell, regardless of trailing spaces."""
    lines = "\n".join(line.rstrip() for line in source.strip().splitlines())
    return hashlib.sha256(lines.encode()).hexdigest()[:8]


def tests_own_function(source: str) -> bool:
    """Return whether a cell checks or replays the student's own function."""
    nodes = [statement.node for statement in slicing.parse_notebook([source])[0]]
    calls = [node.value for node in nodes if isinstance(node, ast.Expr)]
    return any(getattr(getattr(call, "func", None), "id", None) in CALLERS for call in calls)


def free_names(source: str) -> set[str]:
    """Return the names that a cell uses without binding them first."""
    found, made = set(), set()
    for statement in slicing.parse_notebook([source])[0]:
        if not isinstance(statement.node, _PLAIN):
            made |= statement.binds  # a loop binds its variable before using it
        found |= statement.uses - made
        made |= statement.binds
    return found


def plan_rerun(
    cells: Sequence[str],
    callers: Mapping[str, Collection[str]],
    failed_positions: Collection[int],
    include_changed: bool = False,
) -> RerunPlan:
    """Plan the rerun for the last of some cells.

    Parameters
    ----------
    cells : sequence of str
        The cells of the lesson, in order; an empty string for a cell that did not run.
    callers : mapping of str to collection of str
        For each replaced function, its own name and the names of the functions that call it.
    failed_positions : collection of int
        Positions of cells that failed; their statements count as not run.
    include_changed : bool
        Whether to recompute the arguments of replaced functions, which may have changed them.
    """
    statements = slicing.parse_notebook(cells)[0]
    callables = {name for names in callers.values() for name in names}
    depends = _dependency_flags(statements, callables)
    argument_names = {
        name: set(_argument_names(statements, names))
        for name, names in callers.items()
        if include_changed
    }
    renewed = set().union(*argument_names.values())
    stale = _dependency_flags(statements, callables | renewed)
    modules = {
        name
        for statement in statements
        if isinstance(statement.node, _IMPORTS)
        for name in statement.binds
    }
    needed, kept, names = set(), [], set()
    for position in reversed(range(len(statements))):
        statement = statements[position]
        changes = statement.changes | (statement.calls - modules)
        defines = isinstance(statement.node, _DEFINITIONS)
        if statement.cell < len(cells):
            if not (statement.binds | changes) & needed:
                continue
            wanted = statement.cell - 1 in failed_positions or (stale[position] and not defines)
            if wanted or statement.binds & renewed:
                kept.append(statement)
                renewed = renewed | changes
        elif isinstance(statement.node, ast.Assign):  # the cell does not need the earlier values
            needed -= statement.binds
        needed |= _names_read_by(statement)
        if depends[position] and not defines:
            names |= statement.binds | statement.changes
    functions = frozenset(name for name, others in callers.items() if needed & set(others))
    others = (
        frozenset(name for name, values in argument_names.items() if needed & values) - functions
    )
    return RerunPlan(functions, others, tuple(reversed(kept)), frozenset(names))


def _dependency_flags(statements: Sequence[Statement], names: Collection[str]) -> list[bool]:
    """Return, for each statement, whether it uses one of the names or a value derived from one."""
    touched, found = set(names), []
    for statement in statements:
        found.append(bool(_names_read_by(statement) & touched))
        if found[-1]:
            touched |= statement.binds | statement.changes
    return found


def _names_read_by(statement: Statement) -> set[str]:
    """Return the names that a statement reads from outside, except names that a loop sets first."""
    loop = statement.node
    if not isinstance(loop, ast.For):
        return set(statement.uses)
    met = _names_in(loop.iter)
    made = _names_in(loop.target) - met
    for inner in loop.body:
        if isinstance(inner, ast.Assign):
            met |= _names_in(inner.value)
            for target in inner.targets:
                stored = _names_in(target, ast.Store)
                met |= _names_in(target) - stored
                made |= stored - met
        met |= _names_in(inner)
    return set(statement.uses) - made


def _names_in(node: ast.AST, context: type = ast.expr_context) -> set[str]:
    return {
        child.id
        for child in ast.walk(node)
        if isinstance(child, ast.Name) and isinstance(child.ctx, context)
    }


def _argument_names(statements: Sequence[Statement], functions: Collection[str]) -> Iterator[str]:
    """Yield the names that are passed as arguments in calls of some functions."""
    for statement in statements:
        for node in ast.walk(statement.node):
            if isinstance(node, ast.Call) and getattr(node.func, "id", None) in functions:
                arguments = [*node.args, *(keyword.value for keyword in node.keywords)]
                yield from (argument.id for argument in arguments if isinstance(argument, ast.Name))
