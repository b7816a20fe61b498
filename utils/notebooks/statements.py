"""The names that a top-level statement of a notebook binds, uses or changes."""

from __future__ import annotations

import ast
import symtable
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Statement:
    """One top-level statement.

    Attributes
    ----------
    cell : int
        Number of its code cell, from 1.
    node : ast.stmt
    binds, uses : frozenset of str
        Names that it assigns or imports, and names that it reads.
    changes : frozenset of str
        Names whose objects it changes.
    calls : frozenset of str
        Names of objects on which it calls a method only for its side effects. Such a call counts
        as changing the object, unless the object is a module.
    future : int
        Compiler flags of the ``from __future__ import`` statements so far.
    """

    cell: int
    node: ast.stmt
    binds: frozenset[str]
    uses: frozenset[str]
    changes: frozenset[str]
    calls: frozenset[str]
    future: int


def analyse_statement(cell: int, node: ast.stmt, future: int) -> Statement:
    """Determine the names that a statement binds, uses, changes and calls.

    Parameters
    ----------
    cell : int
        Number of its code cell, from 1.
    node : ast.stmt
    future : int
        Compiler flags that apply to the statement.
    """
    inside = _nodes_outside_functions(node)
    table = symtable.symtable(_statement_text(node, inside), "<cell>", "exec")
    symbols = table.get_symbols()
    uses = {symbol.get_name() for symbol in symbols if symbol.is_referenced()}
    binds = {
        symbol.get_name() for symbol in symbols if symbol.is_assigned() or symbol.is_imported()
    }
    for inner in _inner_tables(table):
        uses |= {symbol.get_name() for symbol in inner.get_symbols() if symbol.is_global()}
    # An assignment expression in a comprehension binds a name outside it.
    binds |= {inner.target.id for inner in inside if isinstance(inner, ast.NamedExpr)}
    if isinstance(node, ast.ImportFrom) and any(alias.name == "*" for alias in node.names):
        binds.add("sys")  # `*` may bind any name; every slice keeps a statement that binds `sys`
    return Statement(
        cell,
        node,
        frozenset(binds),
        frozenset(uses),
        frozenset(_changed_names(inside)),
        frozenset(_called_names(inside)),
        future,
    )


def _statement_text(node: ast.stmt, nodes: list[ast.AST]) -> str:
    """Return the text of a statement, with comprehensions changed to have their own scope."""
    comprehensions = (ast.ListComp, ast.SetComp, ast.DictComp)
    source = ast.unparse(node)
    if any(isinstance(inner, comprehensions) for inner in nodes):
        # The node itself must not change, and parsing its text again is faster than copying it.
        source = ast.unparse(_ComprehensionRewriter().visit(ast.parse(source)))
    return source


class _ComprehensionRewriter(ast.NodeTransformer):
    """Turns comprehensions into generators, whose names stay in an inner scope.

    From Python 3.12 on, `symtable` adds the names in comprehensions to the outer scope.
    """

    def visit_ListComp(self, node: ast.ListComp | ast.SetComp) -> ast.GeneratorExp:
        self.generic_visit(node)
        return ast.GeneratorExp(node.elt, node.generators)

    visit_SetComp = visit_ListComp

    def visit_DictComp(self, node: ast.DictComp) -> ast.GeneratorExp:
        self.generic_visit(node)
        return ast.GeneratorExp(ast.Tuple([node.key, node.value], ast.Load()), node.generators)


def _inner_tables(table: symtable.SymbolTable) -> Iterator[symtable.SymbolTable]:
    for child in table.get_children():
        yield child
        yield from _inner_tables(child)


def _changed_names(nodes: list[ast.AST]) -> Iterator[str]:
    """Yield the names whose objects a statement changes, given its nodes.

    Examples are ``a.b = 1``, ``a[0] = 1``, ``setattr(a, "b", 1)``, and the settings of a module:
    ``np.random.seed(1)``, ``sys.setrecursionlimit(9999)``.
    """
    for inner in nodes:
        if isinstance(inner, (ast.Attribute, ast.Subscript)) and isinstance(
            inner.ctx, (ast.Store, ast.Del)
        ):
            yield _root_name(inner)
        elif (
            isinstance(inner, ast.Call)
            and isinstance(inner.func, ast.Name)
            and inner.func.id in ("setattr", "delattr")
            and inner.args
        ):
            yield _root_name(inner.args[0])
        elif _is_bare_call(inner) and inner.value.func.attr.startswith(("set", "seed")):
            yield _root_name(inner.value.func)


def _called_names(nodes: list[ast.AST]) -> Iterator[str]:
    """Return names of objects with a method called only for its effect, as in ``a.append(b)``."""
    return (_root_name(inner.value.func) for inner in nodes if _is_bare_call(inner))


def _is_bare_call(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Call)
        and isinstance(node.value.func, ast.Attribute)
    )


def _nodes_outside_functions(node: ast.stmt) -> list[ast.AST]:
    """Return the nodes of a statement; none for a definition, because it changes nothing itself."""
    definition = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef))
    return [] if definition else list(ast.walk(node))


def _root_name(node: ast.expr) -> str:
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""
