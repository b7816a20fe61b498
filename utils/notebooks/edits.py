"""All functions that are one edit away from one that somebody wrote.

An edit is what a slip of the pen is, undone: another operator or comparison, a constant off by one,
a sign, an axis, two things exchanged, a call or an index too many or too few, a statement one level
too deep. Singh et al. ("Automated feedback generation for introductory programming assignments",
PLDI 2013) write such rules down for each exercise, and have a solver compare with a model answer;
here they are the same for all, and who tries them asks the changed function.

This module reads text that strangers wrote, and runs in the sandbox for that reason.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from utils.notebooks.statements import Statement

# Of one function; the likeliest edits come first.
MOST_EDITS = 600
# A function of more lines is no exercise of this course.
MOST_LINES = 120

_COMPARED = {
    ast.Lt: ("<=", ">", ">="),
    ast.LtE: ("<", ">=", ">"),
    ast.Gt: (">=", "<", "<="),
    ast.GtE: (">", "<=", "<"),
    ast.Eq: ("!=", "<=", ">="),
    ast.NotEq: ("==", "<", ">"),
    ast.Is: ("is not",),
    ast.IsNot: ("is",),
    ast.In: ("not in",),
    ast.NotIn: ("in",),
}
_SIGNS = {
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Is: "is",
    ast.IsNot: "is not",
    ast.In: "in",
    ast.NotIn: "not in",
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "//",
    ast.Mod: "%",
    ast.Pow: "**",
    ast.LShift: "<<",
    ast.RShift: ">>",
    ast.MatMult: "@",
    ast.BitAnd: "&",
    ast.BitOr: "|",
    ast.BitXor: "^",
    ast.And: "and",
    ast.Or: "or",
}
_INSTEAD = {
    "+": ("-", "*"),
    "-": ("+", "/"),
    "*": ("/", "+", "@", "**", "&"),
    "/": ("*", "//", "-"),
    "//": ("/", "%"),
    "%": ("//",),
    "**": ("*",),
    "<<": (">>", "**"),
    ">>": ("<<", "//"),
    "@": ("*",),
    "&": ("|",),
    "|": ("&",),
    "^": ("&", "|", "**"),
    "and": ("or",),
    "or": ("and",),
}
_TWINS = (
    ("left", "right"),
    ("min", "max"),
    ("argmin", "argmax"),
    ("minimum", "maximum"),
    ("any", "all"),
    ("floor", "ceil"),
    ("floor", "round"),
    ("ceil", "round"),
    ("sum", "mean"),
    ("mean", "median"),
    ("std", "var"),
    ("sin", "cos"),
    ("arcsin", "arccos"),
    ("append", "extend"),
    ("add", "update"),
    ("pop", "popleft"),
    ("hstack", "vstack"),
    ("column_stack", "vstack"),
    ("zeros", "ones"),
    ("isnan", "isfinite"),
    ("isinf", "isfinite"),
    ("logical_and", "logical_or"),
    ("dot", "cross"),
    ("log", "exp"),
)
_TWIN = {}
for _one, _other in _TWINS:
    _TWIN.setdefault(_one, []).append(_other)
    _TWIN.setdefault(_other, []).append(_one)
_COMMUTE = (ast.Add, ast.Mult, ast.BitAnd, ast.BitOr, ast.BitXor)
_ALONG_AN_AXIS = frozenset(
    ["sum", "mean", "min", "max", "any", "all", "argmin", "argmax", "median", "prod"]
    + ["std", "var", "norm", "sort", "argsort", "cumsum"]
)
_WRAPS = ("-{}", "abs({})", "{} ** 0.5", "{} ** 2")
_COLUMNS = ("[:, 0]", "[:, 1]", "[:, 2]")
_NUMBERS = ("[0]", "[1]", "[2]")
_SLICES = (
    *("[::-1]", "[1:]", "[:-1]", "[:, :3]", "[:, :2]", "[:3]", "[:2]", ".T", ".copy()"),
    *_COLUMNS,
)
_OF_EACH_ROW = (".all(axis=1)", ".any(axis=1)")
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
    for rank, changed in _texts(block, tree):
        if changed not in seen:
            seen.add(changed)
            yield rank, _edit(statement.cell, first, lines, changed)


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


def _texts(block: str, tree: ast.Module) -> Iterator[tuple[int, str]]:
    """The changed block, with a rank: 0 for what is likeliest."""
    source = _Source(block)
    function = tree.body[0]
    docstrings = {id(node) for node in _docstrings(tree)}
    names = _local_names(function)
    for node, parent, field in _walk(function):
        if id(node) in docstrings:
            continue
        for rank, begin, end, text in _of_node(source, node, parent, field, names):
            yield rank, source.with_text(begin, end, text)
    yield from ((1, text) for text in _returning(block, function, names))
    yield from ((2, text) for text in _moved(block, function))


class _Source:
    """A text, and where the nodes of its tree stand in it."""

    def __init__(self, text: str) -> None:
        self._bytes = text.encode()
        self._starts = [0]
        for line in self._bytes.split(b"\n"):
            self._starts.append(self._starts[-1] + len(line) + 1)

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Where a node begins and ends."""
        return (
            self._starts[node.lineno - 1] + node.col_offset,
            self._starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def text(self, begin: int, end: int) -> str:
        """What stands between two places."""
        return self._bytes[begin:end].decode()

    def of(self, node: ast.AST) -> str:
        """A node's text."""
        return self.text(*self.span(node))

    def with_text(self, begin: int, end: int, text: str) -> str:
        """All of it, with something else between two places."""
        return (self._bytes[:begin] + text.encode() + self._bytes[end:]).decode()


def _docstrings(tree: ast.AST) -> Iterator[ast.AST]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            yield node.value


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


def _local_names(function: ast.AST) -> list[str]:
    """Names of the parameters, and of what is assigned."""
    names = {}
    for node in ast.walk(function):
        if isinstance(node, ast.arg):
            names[node.arg] = True
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names[node.id] = True
    return list(names)


def _of_node(
    source: _Source, node: ast.AST, parent: ast.AST | None, field: str, names: list[str]
) -> Iterator[tuple[int, int, int, str]]:
    """Rank, begin, end and new text of each edit at a node."""
    if isinstance(node, ast.Compare):
        yield from _operators(source, [node.left, *node.comparators], node.ops, _COMPARED)
    elif isinstance(node, ast.BoolOp):
        yield from _operators(source, node.values, [node.op] * (len(node.values) - 1))
        yield from _without_one(source, node.values, node)
    elif isinstance(node, ast.BinOp):
        yield from _of_binary(source, node)
    elif isinstance(node, ast.UnaryOp):
        yield 0, *source.span(node), f"({source.of(node.operand)})"
    elif isinstance(node, ast.AugAssign):
        yield from _of_augmented(source, node)
    elif isinstance(node, (ast.Break, ast.Continue)):
        for word in ("break", "continue", "pass", "return"):
            yield 1, *source.span(node), word
    elif isinstance(node, ast.Constant):
        yield from _of_constant(source, node)
    elif isinstance(node, ast.Call):
        yield from _of_call(source, node)
    elif isinstance(node, (ast.Tuple, ast.List)):
        yield from _exchanged(source, node.elts, 0 if field == "value" else 1)
    elif isinstance(node, ast.Attribute):
        yield from _of_attribute(source, node)
    elif isinstance(node, ast.Subscript):
        yield from _of_subscript(source, node)
    elif isinstance(node, ast.Slice):
        yield from _of_slice(source, node)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        for twin in _TWIN.get(node.id, ()):
            yield 1, *source.span(node), twin
        if node.id in names:
            for other in names:
                yield 4, *source.span(node), other
    elif isinstance(node, ast.keyword) and node.arg:
        yield 2, *_with_comma(source, node, parent), ""
    elif isinstance(node, ast.Return) and node.value is not None:
        yield 5, *source.span(node), source.of(node.value)
    elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and field == "body":
        yield 1, *source.span(node), f"return {source.of(node.value)}"
    elif isinstance(node, ast.Assign) and len(node.targets) == 1:
        yield from _of_assignment(source, node)
    elif isinstance(node, ast.If):
        yield from _of_if(source, node)
    if isinstance(node, ast.expr) and isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
        yield from _wrapped(source, node, parent, field)


def _operators(
    source: _Source, operands: list[ast.expr], operators: list[ast.AST], table: dict | None = None
) -> Iterator[tuple[int, int, int, str]]:
    for left, operator, right in zip(operands, operators, operands[1:], strict=False):
        sign = _SIGNS[type(operator)]
        others = table[type(operator)] if table else _INSTEAD[sign]
        begin, end = source.span(left)[1], source.span(right)[0]
        at = source.text(begin, end).find(sign)
        if at >= 0:
            for other in others:
                yield 0, begin + at, begin + at + len(sign), other


def _without_one(
    source: _Source, operands: list[ast.expr], node: ast.expr
) -> Iterator[tuple[int, int, int, str]]:
    for kept in operands if len(operands) == 2 else ():
        yield 3, *source.span(node), f"({source.of(kept)})"


def _of_binary(source: _Source, node: ast.BinOp) -> Iterator[tuple[int, int, int, str]]:
    yield from _operators(source, [node.left, node.right], [node.op])
    small = isinstance(node.right, ast.Constant)
    if small:
        yield 0, *source.span(node), f"({source.of(node.left)})"
    else:
        yield from _without_one(source, [node.left, node.right], node)
    if not isinstance(node.op, _COMMUTE):
        yield 1, *_both(source, node.left, node.right)


def _both(source: _Source, one: ast.expr, other: ast.expr) -> tuple[int, int, str]:
    """Two neighbours exchanged."""
    (begin, middle), (further, end) = source.span(one), source.span(other)
    return begin, end, source.of(other) + source.text(middle, further) + source.of(one)


def _of_augmented(source: _Source, node: ast.AugAssign) -> Iterator[tuple[int, int, int, str]]:
    sign = _SIGNS[type(node.op)]
    begin, end = source.span(node.target)[1], source.span(node.value)[0]
    at = source.text(begin, end).find(sign + "=")
    for other in (*_INSTEAD[sign], ""):
        yield 0, begin + at, begin + at + len(sign) + 1, f"{other}="


def _of_constant(source: _Source, node: ast.Constant) -> Iterator[tuple[int, int, int, str]]:
    value, (begin, end) = node.value, source.span(node)
    if isinstance(value, bool):
        yield 0, begin, end, str(not value)
    elif isinstance(value, int):
        for rank, other in ((0, value + 1), (0, value - 1), (3, value + 2), (3, value - 2)):
            yield rank, begin, end, f"({other})" if other < 0 else str(other)
    elif isinstance(value, float):
        for other in (value / 2, value * 2, value + 1, value - 1):
            yield 3, begin, end, f"({other!r})"


def _of_call(source: _Source, node: ast.Call) -> Iterator[tuple[int, int, int, str]]:
    name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
    if len(node.args) == 1:
        yield 1, *source.span(node), f"({source.of(node.args[0])})"
    if isinstance(node.func, ast.Attribute) and not node.args:
        yield 1, *source.span(node), source.of(node.func.value)
    yield from _exchanged(source, node.args, 1)
    if name in _ALONG_AN_AXIS and not any(word.arg == "axis" for word in node.keywords):
        begin, end = source.span(node)
        comma = ", " if node.args or node.keywords else ""
        for axis in (0, 1, -1):
            yield 1, end - 1, end, f"{comma}axis={axis})"
    if isinstance(node.func, ast.Name) and node.func.id == "range":
        for argument in node.args:
            for change in ("{} + 1", "{} - 1"):
                yield 0, *source.span(argument), change.format(f"({source.of(argument)})")
        if len(node.args) == 1:
            yield 1, *source.span(node.args[0]), f"1, {source.of(node.args[0])}"
        else:
            yield 1, *source.span(node), f"range({source.of(node.args[1])})"


def _exchanged(
    source: _Source, nodes: list[ast.expr], rank: int
) -> Iterator[tuple[int, int, int, str]]:
    """Two of some exchanged, and one of them left out."""
    if len(nodes) > 4:
        pairs = list(zip(nodes, nodes[1:], strict=False))
    else:
        pairs = [(one, other) for k, one in enumerate(nodes) for other in nodes[k + 1 :]]
    pairs = [(one, other) for one, other in pairs if not isinstance(one, ast.Starred)]
    for one, other in pairs:
        yield rank, *_both(source, one, other)
    if len(nodes) == 3:
        first, second, third = map(source.of, nodes)
        begin, end = source.span(nodes[0])[0], source.span(nodes[-1])[1]
        yield 2, begin, end, f"{second}, {third}, {first}"
        yield 2, begin, end, f"{third}, {first}, {second}"
    for kept, gone in zip(nodes, nodes[1:], strict=False):
        yield 3, source.span(kept)[1], source.span(gone)[1], ""
        yield 3, source.span(kept)[0], source.span(gone)[0], ""


def _of_attribute(source: _Source, node: ast.Attribute) -> Iterator[tuple[int, int, int, str]]:
    end = source.span(node)[1]
    for twin in _TWIN.get(node.attr, ()):
        yield 0, end - len(node.attr), end, twin
    if node.attr == "T":
        yield 1, end - 2, end, ""


def _of_subscript(source: _Source, node: ast.Subscript) -> Iterator[tuple[int, int, int, str]]:
    begin, end = source.span(node)
    value_end = source.span(node.value)[1]
    yield 1, value_end, end, ""
    inside = node.slice
    if not isinstance(inside, (ast.Slice, ast.Tuple, ast.Constant)):
        for change in ("{} + 1", "{} - 1"):
            yield 2, *source.span(inside), change.format(f"({source.of(inside)})")
    if not isinstance(inside, ast.Tuple):
        yield 1, *source.span(inside), f":, {source.of(inside)}"


def _of_slice(source: _Source, node: ast.Slice) -> Iterator[tuple[int, int, int, str]]:
    for bound in (node.lower, node.upper, node.step):
        if bound is not None:
            yield 1, *source.span(bound), ""
            if not isinstance(bound, ast.Constant):
                for change in ("{} + 1", "{} - 1"):
                    yield 1, *source.span(bound), change.format(f"({source.of(bound)})")
    if node.lower is None:
        begin = source.span(node)[0]
        yield 1, begin, begin, "1"
    if node.upper is None and node.step is None:
        begin, end = source.span(node)
        for bound in ("-1", "2", "3"):
            yield 1, end, end, bound


def _with_comma(source: _Source, node: ast.keyword, call: ast.Call) -> tuple[int, int]:
    """Where a keyword argument stands, with the comma before it, or behind it."""
    begin, end = source.span(node)
    before = [source.span(one)[1] for one in (*call.args, *call.keywords) if one is not node]
    earlier = [place for place in before if place <= begin]
    return (max(earlier), end) if earlier else (begin, end)


def _of_assignment(source: _Source, node: ast.Assign) -> Iterator[tuple[int, int, int, str]]:
    target = node.targets[0]
    if isinstance(target, (ast.Name, ast.Subscript)):
        begin = source.span(target)[1]
        end = source.span(node.value)[0]
        at = source.text(begin, end).find("=")
        for sign in ("+=", "-=", "&=", "|="):
            yield 2, begin + at, begin + at + 1, sign
    if isinstance(target, ast.Name) and isinstance(node.value, ast.Name):
        yield 2, *_both(source, target, node.value)


def _of_if(source: _Source, node: ast.If) -> Iterator[tuple[int, int, int, str]]:
    begin = source.span(node)[0]
    if source.text(begin, begin + 5) == "elif ":
        yield 2, begin, begin + 4, "if"
    else:
        yield 2, begin, begin + 2, "elif"


def _wrapped(
    source: _Source, node: ast.expr, parent: ast.AST | None, field: str
) -> Iterator[tuple[int, int, int, str]]:
    """A value as it goes into something: with a sign, a root, a part, a copy more."""
    into = (ast.Return, ast.Assign, ast.AugAssign, ast.Call, ast.Tuple, ast.List, ast.Subscript)
    tested = isinstance(parent, (ast.If, ast.While, ast.IfExp)) and field == "test"
    placed = isinstance(parent, into) and field in ("value", "args", "elts", "slice")
    operand = isinstance(parent, (ast.BinOp, ast.Compare, ast.BoolOp))
    if not (tested or placed or operand) or isinstance(node, (ast.Starred, ast.Slice)):
        return
    if isinstance(node, ast.Constant) and type(node.value) not in (int, float):
        return
    begin, end = source.span(node)
    text = source.of(node)
    atom = isinstance(node, (ast.Name, ast.Attribute, ast.Subscript, ast.Call))
    inner = text if atom else f"({text})"
    if tested or isinstance(parent, ast.BoolOp):
        yield 0, begin, end, f"(not {inner})"
    elif isinstance(parent, ast.Subscript):
        yield from ((1, begin, end, sign + inner) for sign in "-~" if field == "slice")
    elif isinstance(node, ast.Constant):
        yield 1, begin, end, f"(-{inner})"
    elif not isinstance(node, (ast.Tuple, ast.List)):
        if placed and not _is_arithmetic(node):
            yield 0, begin, end, f"~{inner}"
        for wrap in _WRAPS:
            yield 1 if placed else 3, begin, end, f"({wrap.format(inner)})"
        for part in _SLICES if atom and placed else ():
            yield 2, begin, end, inner + part
        for part in (*_COLUMNS, *_NUMBERS) if operand and isinstance(node, ast.Name) else ():
            yield 3, begin, end, inner + part
        for part in _OF_EACH_ROW if placed and not _is_arithmetic(node) else ():
            yield 2, begin, end, inner + part
        if atom and isinstance(getattr(parent, "op", None), ast.MatMult):
            yield 1, begin, end, f"{inner}.T"
        for change in ("{} + 1", "{} - 1") if placed else ():
            yield 2, begin, end, f"({change.format(inner)})"
    if isinstance(parent, ast.Return):
        for wrap in ("np.array({})", "int({})", "float({})", "tuple({})", "list({})"):
            yield 3, begin, end, wrap.format(f"({text})" if isinstance(node, ast.Tuple) else text)


def _is_arithmetic(node: ast.expr) -> bool:
    """Whether it is no mask: a sum, a product, a power."""
    masks = (ast.BitAnd, ast.BitOr, ast.BitXor)
    return isinstance(node, ast.BinOp) and not isinstance(node.op, masks)


def _returning(block: str, function: ast.AST, names: list[str]) -> Iterator[str]:
    """The block with a name returned in the end, where nothing is."""
    if isinstance(function, ast.FunctionDef) and not isinstance(function.body[-1], ast.Return):
        depth = function.body[-1].col_offset
        yield from (f"{block}\n{' ' * depth}return {name}" for name in names)


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
            if inner:  # into what stands before it
                for end in {last, rest}:
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
