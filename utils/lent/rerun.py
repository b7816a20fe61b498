"""What has to be done again so that a cell finds what other functions would have left for it."""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from utils.lent.stubs import ASKING
from utils.notebooks import slicing
from utils.notebooks.statements import Statement

_IMPORTS = (ast.Import, ast.ImportFrom)
_PLAIN = (ast.Assign, ast.AugAssign, ast.AnnAssign, ast.Expr)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)


@dataclass(frozen=True)
class RerunPlan:
    """What a cell rests on.

    Attributes
    ----------
    functions : frozenset of str
        Those of the functions in question that the cell calls, itself or by way of others.
    given : frozenset of str
        Those of the others that were given what the cell needs, where that may be spoilt.
    statements : tuple of Statement
        To be done again before it, in this order.
    names : frozenset of str
        What depends on these functions by then, but for definitions.
    """

    functions: frozenset[str]
    given: frozenset[str]
    statements: tuple[Statement, ...]
    names: frozenset[str]


def key_of_cell(source: str) -> str:
    """A short text that is the same for the same cell, whatever an editor does to ends of lines."""
    lines = "\n".join(line.rstrip() for line in source.strip().splitlines())
    return hashlib.sha256(lines.encode()).hexdigest()[:8]


def is_about_ones_own(source: str) -> bool:
    """Whether a cell checks an answer, or replays it: of the course's there is nothing to see."""
    nodes = [statement.node for statement in slicing.parse_notebook([source])[0]]
    calls = [node.value for node in nodes if isinstance(node, ast.Expr)]
    return any(getattr(getattr(call, "func", None), "id", None) in ASKING for call in calls)


def free_names(source: str) -> set[str]:
    """The names that a cell finds, and does not make itself."""
    found, made = set(), set()
    for statement in slicing.parse_notebook([source])[0]:
        if not isinstance(statement.node, _PLAIN):
            made |= statement.binds  # a loop uses its own variable
        found |= statement.uses - made
        made |= statement.binds
    return found


def plan(
    cells: Sequence[str],
    callers: Mapping[str, Collection[str]],
    broken: Collection[int],
    spoilt: bool = False,
) -> RerunPlan:
    """Find out what the last of some cells rests on.

    Parameters
    ----------
    cells : sequence of str
        Of the lesson, in its order; empty where one did not run.
    callers : mapping of str to collection of str
        For each function in question its name, and the names of functions that call it.
    broken : collection of int
        Places of cells that did not come to their end: whatever stands in them counts as not done.
    spoilt : bool
        Whether to make anew what the functions were given, as one that writes into it.
    """
    statements = slicing.parse_notebook(cells)[0]
    asked = {name for names in callers.values() for name in names}
    depends = _depending(statements, asked)
    given = {name: set(_given(statements, names)) for name, names in callers.items() if spoilt}
    renewed = set().union(*given.values())
    stale = _depending(statements, asked | renewed)
    modules = {name for one in statements if isinstance(one.node, _IMPORTS) for name in one.binds}
    needed, kept, names = set(), [], set()
    for position in reversed(range(len(statements))):
        statement = statements[position]
        changes = statement.changes | (statement.calls - modules)
        defines = isinstance(statement.node, _DEFINITIONS)
        if statement.cell < len(cells):
            if not (statement.binds | changes) & needed:
                continue
            wanted = statement.cell - 1 in broken or (stale[position] and not defines)
            if wanted or statement.binds & renewed:
                kept.append(statement)
                renewed = renewed | changes
        needed |= _found_by(statement)
        if depends[position] and not defines:
            names |= statement.binds | statement.changes
    functions = frozenset(name for name, others in callers.items() if needed & set(others))
    others = frozenset(name for name, about in given.items() if needed & about) - functions
    return RerunPlan(functions, others, tuple(reversed(kept)), frozenset(names))


def _depending(statements: Sequence[Statement], names: Collection[str]) -> list[bool]:
    """Of each statement, whether it uses one of some names, or what was made of one."""
    touched, found = set(names), []
    for statement in statements:
        found.append(bool(_found_by(statement) & touched))
        if found[-1]:
            touched |= statement.binds | statement.changes
    return found


def _found_by(statement: Statement) -> set[str]:
    """The names that a statement finds; a loop makes some of those that it uses anew each time."""
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
        one.id
        for one in ast.walk(node)
        if isinstance(one, ast.Name) and isinstance(one.ctx, context)
    }


def _given(statements: Sequence[Statement], functions: Collection[str]) -> Iterator[str]:
    """Names that stand as arguments in calls of some functions."""
    for statement in statements:
        for node in ast.walk(statement.node):
            if isinstance(node, ast.Call) and getattr(node.func, "id", None) in functions:
                arguments = [*node.args, *(keyword.value for keyword in node.keywords)]
                yield from (argument.id for argument in arguments if isinstance(argument, ast.Name))
