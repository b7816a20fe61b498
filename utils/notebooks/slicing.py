"""The part of a notebook that an exercise needs.

A notebook is a story: it loads a street, draws it, tries things out. The judge wants the
student's functions and what those functions use, and nothing that costs time or can fail
beside them. So the notebook is cut backwards from the functions' names: a top-level statement
stays when it binds, or changes, a name that is needed; the names it uses are then needed too.

This module reads text that strangers wrote, and runs in the sandbox for that reason.
"""

import __future__

import ast
import symtable
from dataclasses import dataclass


@dataclass(frozen=True)
class Statement:
    """One top-level statement.

    Attributes
    ----------
    cell : int
        Number of its code cell.
    node : ast.stmt
    binds, uses : frozenset of str
        Names.
    changes : frozenset of str
        Names whose objects it changes.
    calls : frozenset of str
        Names of which it calls a method for its effect alone: a change, unless they are modules.
    future : int
        Compiler flags of the ``from __future__ import`` statements so far.
    """

    cell: int
    node: ast.stmt
    binds: frozenset
    uses: frozenset
    changes: frozenset
    calls: frozenset
    future: int


def parse_notebook(cells):
    """Top-level statements of a notebook's code cells.

    Parameters
    ----------
    cells : list of str
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
            nodes = _parse(source).body
            future |= _future_flags(nodes)
            statements += [_describe(number, node, future) for node in nodes]
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


def slice_for(names, statements):
    """The statements that `names` need, in the order of the notebook.

    Parameters
    ----------
    names : iterable of str
    statements : list of Statement

    Returns
    -------
    list of Statement
    """
    kept = set().union(*(_needed_by(name, statements) for name in names))
    return [statements[position] for position in sorted(kept)]


def _needed_by(name, statements):
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


def _end_of_exercise(name, statements):
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
        if ast.unparse(statement.node).startswith((f"check({name})", f"check({name},")):
            return position
    return len(statements)


def compile_statement(statement, filename):
    """Code object of a statement; `filename` is what tracebacks will say."""
    return compile(
        ast.Module([statement.node], type_ignores=[]), filename, "exec", flags=statement.future
    )


def imported_modules(statements):
    """Yield (cell, dotted module name) for everything that the statements import."""
    for statement in statements:
        for node in ast.walk(statement.node):
            if isinstance(node, ast.Import):
                yield from ((statement.cell, alias.name) for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                yield statement.cell, node.module
                yield from ((statement.cell, f"{node.module}.{alias.name}") for alias in node.names)


def _parse(source):
    try:
        return ast.parse(source)
    except SyntaxError:
        plain = _without_magics(source)
        if plain == source:
            raise
        return ast.parse(plain)


def _without_magics(source):
    """Python text of a cell with IPython magics; needed for few cells and slow to import."""
    from IPython.core.inputtransformer2 import TransformerManager

    first, _, rest = source.lstrip().partition("\n")
    if first.startswith("%%"):
        # The bodies of these run in the notebook's own namespace; other cell magics hold
        # another language, or throw-away code.
        names = ("%%time", "%%capture", "%%prun")
        return _without_magics(rest) if first.split()[0] in names else ""
    return TransformerManager().transform_cell(source)


def _future_flags(nodes):
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


def _describe(cell, node, future):
    table = symtable.symtable(ast.unparse(node), "<cell>", "exec")
    symbols = table.get_symbols()
    uses = {symbol.get_name() for symbol in symbols if symbol.is_referenced()}
    binds = {
        symbol.get_name() for symbol in symbols if symbol.is_assigned() or symbol.is_imported()
    }
    for inner in _inner_tables(table):
        uses |= {symbol.get_name() for symbol in inner.get_symbols() if symbol.is_global()}
    binds |= {
        inner.target.id
        for inner in _walk_without_functions(node)
        if isinstance(inner, ast.NamedExpr)
    }  # one in a comprehension binds outside of it
    if isinstance(node, ast.ImportFrom) and any(alias.name == "*" for alias in node.names):
        binds.add("sys")  # it may bind anything, so it always stays
    return Statement(
        cell,
        node,
        frozenset(binds),
        frozenset(uses),
        frozenset(_changed_names(node)),
        frozenset(_called_names(node)),
        future,
    )


def _inner_tables(table):
    for child in table.get_children():
        yield child
        yield from _inner_tables(child)


def _changed_names(node):
    """Names whose objects a statement changes.

    ``a.b = 1``, ``a[0] = 1``, ``setattr(a, "b", 1)``, and the settings of a module:
    ``np.random.seed(1)``, ``sys.setrecursionlimit(9999)``.
    """
    for inner in _walk_without_functions(node):
        if isinstance(inner, (ast.Attribute, ast.Subscript)) and isinstance(
            inner.ctx, (ast.Store, ast.Del)
        ):
            yield _root(inner)
        elif (
            isinstance(inner, ast.Call)
            and isinstance(inner.func, ast.Name)
            and inner.func.id in ("setattr", "delattr")
            and inner.args
        ):
            yield _root(inner.args[0])
        elif _is_bare_call(inner) and inner.value.func.attr.startswith(("set", "seed")):
            yield _root(inner.value.func)


def _called_names(node):
    """Names of which a statement calls a method and drops the result: ``a.append(b)``."""
    return (
        _root(inner.value.func) for inner in _walk_without_functions(node) if _is_bare_call(inner)
    )


def _is_bare_call(node):
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Call)
        and isinstance(node.value.func, ast.Attribute)
    )


def _walk_without_functions(node):
    """The nodes of a statement, less definitions: those change nothing until they are called."""
    if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
        yield from ast.walk(node)


def _root(node):
    while isinstance(node, (ast.Attribute, ast.Subscript)):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""
