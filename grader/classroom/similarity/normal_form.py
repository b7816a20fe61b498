"""The normal form of a function, without details that are easily changed.

The normal form has no comments, layout, docstrings, annotations, `print` or `pass`, and no names
except those of parameters, modules and their members, and given functions. Equal numbers are spelt
in the same way. Some equivalent code has the same normal form: ``x += 1`` and ``x = x + 1``,
``a > b`` and ``b < a``, ``a + b`` and ``b + a``, ``a, b = 1, 2`` and two assignments, a `for` loop
and a `while` loop that counts.

The code is untrusted, so this module runs in a separate process; see
`grader.intake.reader_process`.
"""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

_BUILTINS = frozenset(dir(builtins))
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_LOOPS = (ast.For, ast.AsyncFor, ast.While)
_COMMUTATIVE = (ast.Add, ast.Mult, ast.BitAnd, ast.BitOr, ast.BitXor)
_MIRRORED_OPERATORS = {ast.Gt: ast.Lt, ast.GtE: ast.LtE}
_WITHOUT_EFFECT = (ast.Pass, ast.Import, ast.ImportFrom, ast.Global, ast.Nonlocal)


@dataclass(frozen=True)
class NormalStatement:
    """A statement in normal form; for a compound statement, only the header.

    Attributes
    ----------
    words : tuple of str
        The tokens of the normal form.
    first, last : int
        The first and last line.
    """

    words: tuple[str, ...]
    first: int
    last: int


def steps_of(
    node: ast.stmt, known: Mapping[str, str], parameters: Sequence[str] = ()
) -> Iterator[NormalStatement]:
    """Yield the statements in a function or another compound statement, from top to bottom.

    Parameters
    ----------
    node : ast.stmt
    known : dict of str to str
        Qualified names of modules and given functions, which the author did not choose.
    parameters : sequence of str
        Names of the function's parameters; each is replaced by its position.
    """
    positions = {name: f"parameter {index}" for index, name in enumerate(parameters)}
    return _Normalizer({**known, **positions}).steps([node])


class _Normalizer:
    """Converts statements to their normal form."""

    def __init__(self, known: Mapping[str, str]) -> None:
        self.known = known

    def steps(self, body: Iterable[ast.stmt]) -> Iterator[NormalStatement]:
        for node in body:
            if not _has_no_effect(node):
                yield from self._steps(node)

    def _steps(self, node: ast.stmt) -> Iterator[NormalStatement]:
        if isinstance(node, _FUNCTIONS):
            yield from self.steps(node.body)
        elif isinstance(node, (ast.Assign, ast.AnnAssign, ast.AugAssign)):
            for target, value in _assignments(node):
                yield self._step(node, node, "set", target, value)
        elif isinstance(node, _LOOPS):
            yield from self._loop(node)
        elif isinstance(node, ast.If):
            yield self._step(node, node.test, "if", node.test)
            yield from self.steps([*node.body, *node.orelse])
        elif isinstance(node, (ast.With, ast.AsyncWith)):
            yield self._step(node, node.items[-1].context_expr, "with", *node.items)
            yield from self.steps(node.body)
        elif isinstance(node, ast.ClassDef):
            yield NormalStatement(("class",), node.lineno, node.lineno)
            yield from self.steps(node.body)
        elif isinstance(node, ast.Try):
            handled = [inner for handler in node.handlers for inner in handler.body]
            yield from self.steps([*node.body, *handled, *node.orelse, *node.finalbody])
        elif isinstance(node, ast.Expr):
            yield self._step(node, node, "do", node.value)
        else:
            yield self._step(node, node, type(node).__name__, *ast.iter_child_nodes(node))

    def _step(self, node: ast.stmt, end: ast.AST, kind: str, *parts: ast.AST) -> NormalStatement:
        words = [kind, *(word for part in parts for word in self._words(part))]
        return NormalStatement(tuple(words), node.lineno, end.end_lineno)

    def _loop(self, node: ast.For | ast.AsyncFor | ast.While) -> Iterator[NormalStatement]:
        body, counting_range = node.body, None
        if isinstance(node, ast.While):
            end, head = node.test, [node.test]
            counting_range = _counting_range(node)
            if counting_range is not None:
                head = [node.test.left, counting_range]
                body = node.body[:-1]
        else:
            end, head = node.iter, [node.target, node.iter]
        yield self._step(node, end, "loop", *head)
        yield from self.steps([*body, *node.orelse])

    def _words(self, node: ast.AST) -> list[str]:
        if isinstance(node, ast.Name):
            return [self._name(node.id)]
        if isinstance(node, ast.Constant):
            return [_constant_word(node.value)]
        if isinstance(node, ast.Attribute):
            dotted = self._dotted(node)
            return [dotted] if dotted else [*self._words(node.value), f".{node.attr}"]
        if isinstance(node, ast.Call):
            named = sorted(
                [f"{keyword.arg}=", *self._words(keyword.value)] for keyword in node.keywords
            )
            return ["call", *self._all_words([node.func, *node.args]), *chain(*named), "end"]
        if isinstance(node, ast.BinOp):
            sides = [self._words(node.left), self._words(node.right)]
            if isinstance(node.op, _COMMUTATIVE):
                sides.sort()
            return [type(node.op).__name__, *sides[0], *sides[1]]
        if isinstance(node, ast.BoolOp):
            return [type(node.op).__name__, *chain(*sorted(map(self._words, node.values)))]
        if isinstance(node, ast.Compare) and len(node.ops) == 1:
            return self._comparison(node.left, node.ops[0], node.comparators[0])
        if isinstance(node, (ast.expr_context, ast.arguments)):
            return []
        return [type(node).__name__, *self._all_words(ast.iter_child_nodes(node))]

    def _all_words(self, nodes: Iterable[ast.AST]) -> list[str]:
        return [word for node in nodes for word in self._words(node)]

    def _comparison(self, left: ast.expr, operator: ast.cmpop, right: ast.expr) -> list[str]:
        kind = type(operator)
        if kind in _MIRRORED_OPERATORS:
            left, kind, right = right, _MIRRORED_OPERATORS[kind], left
        sides = [self._words(left), self._words(right)]
        if kind in (ast.Eq, ast.NotEq):
            sides.sort()
        return [kind.__name__, *sides[0], *sides[1]]

    def _dotted(self, node: ast.expr) -> str:
        """Return ``numpy.linalg.norm`` for ``np.linalg.norm``; empty if it is not in a module."""
        if isinstance(node, ast.Attribute):
            prefix = self._dotted(node.value)
            return prefix and f"{prefix}.{node.attr}"
        is_module = isinstance(node, ast.Name) and not self._name(node.id).startswith("parameter")
        return self.known.get(node.id, "") if is_module else ""

    def _name(self, name: str) -> str:
        return self.known.get(name) or (name if name in _BUILTINS else "name")


def _assignments(
    node: ast.Assign | ast.AnnAssign | ast.AugAssign,
) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield each (target, value) of an assignment statement."""
    if isinstance(node, ast.AugAssign):
        yield node.target, ast.BinOp(node.target, node.op, node.value)
        return
    for target in getattr(node, "targets", None) or [node.target]:
        are_tuples = isinstance(target, (ast.Tuple, ast.List)) and isinstance(
            node.value, (ast.Tuple, ast.List)
        )
        left, right = (target.elts, node.value.elts) if are_tuples else ([target], [node.value])
        if len(left) != len(right) or any(isinstance(part, ast.Starred) for part in left + right):
            left, right = [target], [node.value]
        yield from zip(left, right, strict=True)


def _counting_range(node: ast.While) -> ast.expr | None:
    """Return ``range(n)`` for a loop ``while i < n`` that ends with ``i += 1``; otherwise None."""
    test, last = node.test, node.body[-1]
    if (
        isinstance(test, ast.Compare)
        and isinstance(test.left, ast.Name)
        and isinstance(test.ops[0], ast.Lt)
        and len(test.ops) == 1
        and isinstance(last, (ast.AugAssign, ast.Assign))
    ):
        ((target, value),) = list(_assignments(last))[:1]
        if ast.unparse(target) == test.left.id and ast.unparse(value) == f"{test.left.id} + 1":
            return ast.Call(ast.Name("range"), [test.comparators[0]], [])
    return None


def _constant_word(value: object) -> str:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        try:
            return repr(float(value))
        except OverflowError:
            return "a large number"
    return type(value).__name__ if isinstance(value, (str, bytes)) else repr(value)


def _has_no_effect(node: ast.stmt) -> bool:
    if isinstance(node, ast.AnnAssign):
        return node.value is None
    if not isinstance(node, ast.Expr):
        return isinstance(node, _WITHOUT_EFFECT)
    value = node.value
    called = value.func if isinstance(value, ast.Call) else None
    return isinstance(value, ast.Constant) or (
        isinstance(called, ast.Name) and called.id in ("print", "display")
    )
