"""Generate the edits of one node of a function's syntax tree; see `utils.notebooks.edits`."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterator
from dataclasses import dataclass

_COMPARISONS = {
    ast.Lt: ("<=", ">", ">=", "!="),
    ast.LtE: ("<", ">=", ">", "=="),
    ast.Gt: (">=", "<", "<=", "!="),
    ast.GtE: (">", "<=", "<", "=="),
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
_REPLACEMENTS = {
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
    "&": ("|", "*"),
    "|": ("&",),
    "^": ("&", "|", "**"),
    "and": ("or",),
    "or": ("and",),
}
TWINS = (
    ("left", "right"),
    ("low", "high"),
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
    ("point", "index"),  # of a node in a kd-tree
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
for _left, _right in TWINS:
    _TWIN.setdefault(_left, []).append(_right)
    _TWIN.setdefault(_right, []).append(_left)
_COMMUTE = (ast.Add, ast.Mult, ast.BitAnd, ast.BitOr, ast.BitXor)
AXIS_FUNCTIONS = frozenset(
    ["sum", "mean", "min", "max", "any", "all", "argmin", "argmax", "median", "prod"]
    + ["std", "var", "norm", "sort", "argsort", "cumsum", "delete"]
)
_WRAPS = ("abs({})", "{} ** 0.5", "{} ** 2")
_COLUMNS = ("[:, 0]", "[:, 1]", "[:, 2]")
_INDICES = ("[0]", "[1]", "[2]")
_SLICES = ("[:, :3]", "[:, :2]", "[:, ::-1]", ".copy()", *_COLUMNS)
_RARE_SLICES = ("[::-1]", "[1:]", "[:-1]", "[:3]", "[:2]", ".T")
_ROW_TESTS = (".all(axis=1)", ".any(axis=1)")
_CALLS = ("len({})", "{}.sum()", "np.floor({})", "np.linalg.norm({})", "np.isfinite({})")
_COMBINATIONS = ("{} / {}", "{} * {}", "{} + {}", "{} - {}", "{} ** {}")
# Methods whose result resembles the array on which they are called.
_SIMILAR = frozenset(["astype", "copy", "round", "tolist", "sort", "item"])
_KEYWORDS = {
    "choice": ("replace=False", "size=2", "size=3"),
    **dict.fromkeys(("zeros", "ones", "empty", "full", "array"), ("dtype=bool", "dtype=int")),
}


class SourceText:
    """A source text, with access to the part that each node of its syntax tree covers."""

    def __init__(self, text: str) -> None:
        self._bytes = text.encode()
        self._starts = [0]
        for line in self._bytes.split(b"\n"):
            self._starts.append(self._starts[-1] + len(line) + 1)

    def span(self, node: ast.AST) -> tuple[int, int]:
        """Return the positions, in bytes, at which a node begins and ends."""
        return (
            self._starts[node.lineno - 1] + node.col_offset,
            self._starts[node.end_lineno - 1] + node.end_col_offset,
        )

    def text(self, start: int, end: int) -> str:
        """Return the text between two positions."""
        return self._bytes[start:end].decode()

    def text_of(self, node: ast.AST) -> str:
        """Return the text of a node."""
        return self.text(*self.span(node))

    def with_text(self, start: int, end: int, text: str) -> str:
        """Return the whole text with the part between two positions replaced."""
        return (self._bytes[:start] + text.encode() + self._bytes[end:]).decode()


@dataclass(frozen=True)
class Names:
    """The names in a function or a class.

    Attributes
    ----------
    arguments : list of str
        Names of its parameters.
    bound : list of str
        Names of its parameters, and names that it assigns.
    unbound : list of str
        Names that it reads but does not assign. Builtins are left out, and so are names that it
        calls or whose attributes it uses.
    """

    arguments: list[str]
    bound: list[str]
    unbound: list[str]


def names_in(function: ast.AST) -> Names:
    """Collect the names in a function or a class, each once, in the order of `ast.walk`."""
    arguments, bound, read, elsewhere = {}, {}, {}, {*dir(builtins)}
    for node in ast.walk(function):
        if isinstance(node, ast.arg):
            arguments[node.arg] = bound[node.arg] = True
        elif isinstance(node, ast.Name):
            (bound if isinstance(node.ctx, ast.Store) else read)[node.id] = True
        elif isinstance(node, (ast.Call, ast.Attribute)):
            name = node.func if isinstance(node, ast.Call) else node.value
            elsewhere |= {name.id} if isinstance(name, ast.Name) else set()
    missing = [name for name in read if name not in bound and name not in elsewhere]
    return Names([*arguments], [*bound], missing)


def edits_of_node(
    source: SourceText, node: ast.AST, parent: ast.AST | None, field: str, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    """Yield the rank, start, end and new text of each edit of a node.

    Parameters
    ----------
    source : SourceText
    node, parent : ast.AST
    field : str
        The field of the parent that contains the node.
    names : Names

    Yields
    ------
    tuple of int, int, int, str
        Likelier edits have a lower rank. Positions are in bytes.
    """
    value = getattr(node, "value", None)
    if isinstance(node, ast.Compare):
        yield from _comparison_edits(source, node, names)
    elif isinstance(node, ast.BoolOp):
        yield from _operator_edits(source, node.values, [node.op] * (len(node.values) - 1))
        yield from _single_operand_edits(source, node.values, node)
        sign = " & " if isinstance(node.op, ast.And) else " | "
        yield 1, *source.span(node), sign.join(_as_mask(source, value) for value in node.values)
    elif isinstance(node, ast.BinOp):
        yield from _binary_operation_edits(source, node)
    elif isinstance(node, ast.UnaryOp):
        yield 0, *source.span(node), f"({source.text_of(node.operand)})"
        if isinstance(node.op, ast.Not) or (isinstance(node.op, ast.USub) and field == "slice"):
            yield 0, *source.span(node), f"~({source.text_of(node.operand)})"
        elif isinstance(node.op, ast.Invert) and isinstance(node.operand, ast.Subscript):
            table, mask = map(source.text_of, (node.operand.value, node.operand.slice))
            yield 0, *source.span(node), f"{table}[~({mask})]"
        elif isinstance(parent, ast.Tuple) and isinstance(node.operand, ast.Constant):
            for column in "012":  # the last column of a cloud may be the intensity
                yield 1, *source.span(node), column
    elif isinstance(node, ast.AugAssign):
        yield from _augmented_assignment_edits(source, node)
    elif isinstance(node, (ast.Break, ast.Continue, ast.Pass)):
        for word in ("break", "continue", "pass", "return"):
            yield 1, *source.span(node), word
    elif isinstance(node, ast.Constant):
        yield from _constant_edits(source, node)
        is_axis = isinstance(parent, ast.keyword) and parent.arg == "axis"
        if isinstance(parent, (ast.Call, ast.Compare, ast.keyword)) and not is_axis:
            yield from _decimal_point_edits(source, node)
    elif isinstance(node, ast.Call):
        yield from _call_edits(source, node, names)
    elif isinstance(node, (ast.Tuple, ast.List)):
        yield from _reordering_edits(source, node.elts, 0 if field == "value" else 1)
    elif isinstance(node, ast.Attribute):
        yield from _attribute_edits(source, node)
    elif isinstance(node, ast.Subscript):
        yield from _subscript_edits(source, node, names)
    elif isinstance(node, ast.Slice):
        yield from _slice_edits(source, node)
    elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
        for twin in _TWIN.get(node.id, ()):
            yield 1, *source.span(node), twin
        shown = isinstance(parent, (ast.Return, ast.Tuple, ast.Compare))
        for name in names.bound if node.id in names.bound else ():
            rank = 1 if _are_easily_confused(name, node.id) else 2 if shown else 4
            yield rank, *source.span(node), name
        if isinstance(parent, ast.Tuple):
            yield 2, *source.span(node), f"*{node.id}"
    elif isinstance(node, ast.keyword) and node.arg and isinstance(parent, ast.Call):
        yield 2, *_span_with_comma(source, node, parent), ""
    elif isinstance(node, ast.Return) and value is not None:
        yield from _return_edits(source, node, names)
    elif isinstance(node, ast.Return):
        yield from ((1, *source.span(node), word) for word in ("continue", "break", "pass"))
    elif isinstance(node, ast.Expr) and field == "body" and not isinstance(value, ast.Constant):
        if isinstance(value, ast.Call) and getattr(value.func, "id", "") == "print":
            inside = ", ".join(map(source.text_of, value.args))
            yield -1, *source.span(node), f"return {inside}"
        elif isinstance(value, ast.Call):
            for argument in value.args:
                if isinstance(argument, ast.Name):
                    yield 1, *source.span(node), f"{argument.id} = {source.text_of(value)}"
        yield 1, *source.span(node), f"return {source.text_of(node.value)}"
    elif isinstance(node, ast.Assign) and len(node.targets) == 1:
        yield from _assignment_edits(source, node, names)
    elif isinstance(node, ast.If):
        yield from _if_edits(source, node)
    elif isinstance(node, ast.For):
        yield 1, *source.span(node.iter), f"range({source.text_of(node.iter)})"
    if isinstance(node, ast.expr) and isinstance(getattr(node, "ctx", ast.Load()), ast.Load):
        yield from _wrapping_edits(source, node, parent, field)
        yield from _name_combination_edits(source, node, parent, field, names)


def _as_mask(source: SourceText, node: ast.expr) -> str:
    """Return the text of an operand in parentheses, with ~ instead of not."""
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return f"~({source.text_of(node.operand)})"
    return f"({source.text_of(node)})"


def _are_easily_confused(first: str, second: str) -> bool:
    """Return whether two names differ in one character, such as `px` and `qx`, or `p` and `q`."""
    pairs = [pair for pair in zip(first, second, strict=False) if pair[0] != pair[1]]
    if len(first) != len(second) or len(pairs) != 1:
        return False
    return len(first) > 1 or abs(ord(first) - ord(second)) == 1


def _operator_edits(
    source: SourceText,
    operands: list[ast.expr],
    operators: list[ast.AST],
    table: dict | None = None,
) -> Iterator[tuple[int, int, int, str]]:
    for left, operator, right in zip(operands, operators, operands[1:], strict=False):
        sign = _SIGNS[type(operator)]
        replacements = table[type(operator)] if table else _REPLACEMENTS[sign]
        start, end = source.span(left)[1], source.span(right)[0]
        at = source.text(start, end).find(sign)
        if at >= 0:
            for replacement in replacements:
                yield 0, start + at, start + at + len(sign), replacement


def _comparison_edits(
    source: SourceText, node: ast.Compare, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    """Change the operator, drop the comparison, or replace a side with a copy of the other.

    A chain becomes two masks, and the comparison of an element becomes an index.
    """
    yield from _operator_edits(source, [node.left, *node.comparators], node.ops, _COMPARISONS)
    for sign in ("&", "|"):  # x == 0 & y == 0 becomes (x == 0) & (y == 0)
        sides = source.text_of(node).split(sign)
        if len(node.ops) == len(sides) > 1:
            yield -1, *source.span(node), f" {sign} ".join(f"({side.strip()})" for side in sides)
    if len(node.ops) > 1:
        if len(node.ops) == 2:  # high <= x <= low
            middle, last = node.comparators
            yield 1, *_swap(source, node.left, last)
            (middle_start, middle_end), (_, end) = source.span(middle), source.span(last)
            start = source.span(node)[0]
            left, right = source.text(start, middle_end), source.text(middle_start, end)
            yield 0, start, end, f"({left}) & ({right})"  # Python's chain fails for arrays
        return
    if isinstance(node.left, ast.Subscript):  # x[d] <= r becomes x[d <= r]
        inside, (_, bracket) = source.span(node.left.slice)[1], source.span(node.left)
        end = source.span(node)[1]
        yield 1, inside, end, source.text(bracket, end) + source.text(inside, bracket)
    yield 2, *source.span(node), f"({source.text_of(node.left)})"
    for side, other in ((node.left, node.comparators[0]), (node.comparators[0], node.left)):
        inner = [part for part in ast.walk(side) if isinstance(part, ast.Name)]
        inner = [part for part in inner if part.id in names.bound]
        if len(inner) == 1 and not isinstance(side, ast.Name):
            (start, end), (first, last) = source.span(side), source.span(inner[0])
            for name in names.bound:
                text = source.text(start, first) + name + source.text(last, end)
                if name != inner[0].id:
                    yield 1, *source.span(other), text


def _single_operand_edits(
    source: SourceText, operands: list[ast.expr], node: ast.expr
) -> Iterator[tuple[int, int, int, str]]:
    for kept in operands if len(operands) == 2 else ():
        yield 3, *source.span(node), f"({source.text_of(kept)})"


def _binary_operation_edits(
    source: SourceText, node: ast.BinOp
) -> Iterator[tuple[int, int, int, str]]:
    yield from _operator_edits(source, [node.left, node.right], [node.op])
    small = isinstance(node.right, ast.Constant)
    if small:
        yield 0, *source.span(node), f"({source.text_of(node.left)})"
    else:
        yield from _single_operand_edits(source, [node.left, node.right], node)
    if not isinstance(node.op, _COMMUTE):
        yield 1, *_swap(source, node.left, node.right)
    if isinstance(node.op, ast.FloorDiv):
        for change in ("({} - 1)", "({} + 1)"):
            yield 0, *source.span(node.left), change.format(source.text_of(node.left))
    yield from _bracket_edits(source, node)


def _bracket_edits(source: SourceText, node: ast.BinOp) -> Iterator[tuple[int, int, int, str]]:
    """Add or remove parentheses, so that another operator is applied first."""
    start, end = source.span(node)
    if isinstance(node.left, ast.BinOp) and source.span(node.left)[0] == start:
        middle = source.span(node.left.right)[0]
        yield 0, middle, end, f"({source.text(middle, end)})"
    if isinstance(node.right, ast.BinOp) and source.span(node.right)[1] == end:
        middle = source.span(node.right.left)[1]
        yield 0, start, middle, f"({source.text(start, middle)})"
    for operand in (node.left, node.right):
        first, last = source.span(operand)
        around = source.text(max(start, first - 1), first) + source.text(last, min(last + 1, end))
        if isinstance(operand, ast.BinOp) and around == "()":
            yield 1, first - 1, last + 1, source.text_of(operand)
    call = node.left  # f(x) + y becomes f(x + y); `_moved_operand_edits` does the reverse
    if isinstance(call, ast.Call) and len(call.args) == 1 and not call.keywords:
        (first, last), close = source.span(call.args[0]), source.span(call)[1]
        rest = source.text(close, end)
        yield 1, first, end, source.text(first, last) + rest + source.text(last, close)


def _moved_operand_edits(source: SourceText, call: ast.Call) -> Iterator[tuple[int, int, int, str]]:
    """Move the last operand out of a call: f(x + y) becomes f(x) + y."""
    if len(call.args) == 1 and isinstance(call.args[0], ast.BinOp) and not call.keywords:
        inside = call.args[0]
        start, end = source.span(call)
        middle, last = source.span(inside.left)[1], source.span(inside)[1]
        moved = source.text(middle, last)
        yield 2, start, end, f"({source.text(start, middle)}{source.text(last, end)}{moved})"


def _swap(source: SourceText, first: ast.expr, second: ast.expr) -> tuple[int, int, str]:
    """Swap two nodes; return the start of the first, the end of the second, and the new text."""
    (start, middle), (further, end) = source.span(first), source.span(second)
    return start, end, source.text_of(second) + source.text(middle, further) + source.text_of(first)


def _augmented_assignment_edits(
    source: SourceText, node: ast.AugAssign
) -> Iterator[tuple[int, int, int, str]]:
    sign = _SIGNS[type(node.op)]
    start, end = source.span(node.target)[1], source.span(node.value)[0]
    at = source.text(start, end).find(sign + "=")
    for replacement in (*_REPLACEMENTS[sign], ""):
        yield 0, start + at, start + at + len(sign) + 1, f"{replacement}="


def _constant_edits(source: SourceText, node: ast.Constant) -> Iterator[tuple[int, int, int, str]]:
    value, (start, end) = node.value, source.span(node)
    if isinstance(value, bool):
        yield 0, start, end, str(not value)
    elif isinstance(value, int):
        for rank, changed in ((0, value + 1), (0, value - 1), (3, value + 2), (3, value - 2)):
            yield rank, start, end, f"({changed})" if changed < 0 else str(changed)
    elif isinstance(value, float):
        for changed in (value / 2, value * 2, value + 1, value - 1):
            yield 3, start, end, f"({changed!r})"


def _decimal_point_edits(
    source: SourceText, node: ast.Constant
) -> Iterator[tuple[int, int, int, str]]:
    """Move the decimal point of a number such as a threshold by one digit: 3 becomes 0.3."""
    value = node.value
    if type(value) is float:
        for factor in (10, 0.1):
            yield 0, *source.span(node), f"{value * factor:.12g}"
    elif type(value) is int and 1 < value < 10:
        yield 0, *source.span(node), f"0.{value}"


def _call_edits(
    source: SourceText, node: ast.Call, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
    if len(node.args) == 1:
        yield 1, *source.span(node), f"({source.text_of(node.args[0])})"
    if isinstance(node.func, ast.Attribute) and (not node.args or name in _SIMILAR):
        yield 1, *source.span(node), source.text_of(node.func.value)
    if isinstance(node.func, ast.Name) and not node.args and not node.keywords:
        for argument in names.bound:
            yield 2, *source.span(node), f"{node.func.id}([{argument}])"
    yield from _reordering_edits(source, node.args, 1)
    yield from _moved_operand_edits(source, node)
    if node.args:
        yield from _name_insertion_edits(source, node.args, names.bound, 5)
        for keyword in _KEYWORDS.get(name, ()):
            end = source.span(node)[1]
            yield 3, end - 1, end, f", {keyword})"
    if name in AXIS_FUNCTIONS and not any(word.arg == "axis" for word in node.keywords):
        start, end = source.span(node)
        comma = ", " if node.args or node.keywords else ""
        for axis in (0, 1, -1):
            yield 1, end - 1, end, f"{comma}axis={axis})"
    if isinstance(node.func, ast.Name) and node.func.id == "range":
        for argument in node.args:
            for change in ("{} + 1", "{} - 1"):
                yield 0, *source.span(argument), change.format(f"({source.text_of(argument)})")
        if len(node.args) == 1:
            yield 1, *source.span(node.args[0]), f"1, {source.text_of(node.args[0])}"
        else:
            yield 1, *source.span(node), f"range({source.text_of(node.args[1])})"


def _reordering_edits(
    source: SourceText, nodes: list[ast.expr], rank: int
) -> Iterator[tuple[int, int, int, str]]:
    """Swap two of the nodes, rotate three of them, or leave one out."""
    if len(nodes) > 4:
        pairs = list(zip(nodes, nodes[1:], strict=False))
    else:
        pairs = [(left, right) for k, left in enumerate(nodes) for right in nodes[k + 1 :]]
    pairs = [(left, right) for left, right in pairs if not isinstance(left, ast.Starred)]
    for left, right in pairs:
        yield rank, *_swap(source, left, right)
    if len(nodes) == 3:
        first, second, third = map(source.text_of, nodes)
        start, end = source.span(nodes[0])[0], source.span(nodes[-1])[1]
        yield 2, start, end, f"{second}, {third}, {first}"
        yield 2, start, end, f"{third}, {first}, {second}"
    for kept, gone in zip(nodes, nodes[1:], strict=False):
        yield 3, source.span(kept)[1], source.span(gone)[1], ""
        yield 3, source.span(kept)[0], source.span(gone)[0], ""


def _attribute_edits(
    source: SourceText, node: ast.Attribute
) -> Iterator[tuple[int, int, int, str]]:
    end = source.span(node)[1]
    for twin in _TWIN.get(node.attr, ()):
        yield 0, end - len(node.attr), end, twin
    if node.attr == "T":
        yield 1, end - 2, end, ""


def _subscript_edits(
    source: SourceText, node: ast.Subscript, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    start, end = source.span(node)
    value_end = source.span(node.value)[1]
    yield 1, value_end, end, ""
    inside = node.slice
    if not isinstance(inside, (ast.Slice, ast.Tuple, ast.Constant)):
        for change in ("{} + 1", "{} - 1"):
            yield 2, *source.span(inside), change.format(f"({source.text_of(inside)})")
    if not isinstance(inside, ast.Tuple):
        yield 1, *source.span(inside), f":, {source.text_of(inside)}"
    if not isinstance(inside, (ast.Slice, ast.Tuple, ast.Constant)):
        is_argument = getattr(node.value, "id", "") in names.arguments  # points instead of rows
        yield 1 if is_argument else 3, start, end, source.text_of(inside)


def _slice_edits(source: SourceText, node: ast.Slice) -> Iterator[tuple[int, int, int, str]]:
    for bound in (node.lower, node.upper, node.step):
        if bound is not None:
            yield 1, *source.span(bound), ""
            if not isinstance(bound, ast.Constant):
                # `rows[middle:]` may never end, and such an answer has fewer edits.
                is_rest = bound is node.lower and node.upper is None
                for rank, change in ((0 if is_rest else 1, "{} + 1"), (1, "{} - 1")):
                    yield rank, *source.span(bound), change.format(f"({source.text_of(bound)})")
    if isinstance(node.upper, ast.Constant) and node.upper.value == 1:  # :1 is x; :3 is x, y and z
        yield 1, *source.span(node.upper), "3"
    if node.lower is None:
        start = source.span(node)[0]
        yield 1, start, start, "1"
    if node.step is None and (node.lower is None) != (node.upper is None):  # x[a:] or x[:a]
        if node.upper is None:
            bound = source.text_of(node.lower).removeprefix("-")
            yield 1, *source.span(node), f":{bound}"
        else:
            yield 1, *source.span(node), f"{source.text_of(node.upper)}:"
    if node.upper is None and node.step is None:
        start, end = source.span(node)
        for bound in ("-1", "2", "3"):
            yield 1, end, end, bound


def _span_with_comma(source: SourceText, node: ast.keyword, call: ast.Call) -> tuple[int, int]:
    """Return the span of a keyword argument together with the comma before it."""
    start, end = source.span(node)
    before = [
        source.span(argument)[1]
        for argument in (*call.args, *call.keywords)
        if argument is not node
    ]
    earlier = [place for place in before if place <= start]
    return (max(earlier), end) if earlier else (start, end)


def _return_edits(
    source: SourceText, node: ast.Return, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    value = node.value
    yield 5, *source.span(node), source.text_of(value)
    several = value.elts if isinstance(value, ast.Tuple) else [value]
    yield from _name_insertion_edits(source, several, names.bound, 4)
    if not isinstance(value, ast.Tuple):
        for whole in names.arguments:
            yield 3, *source.span(value), f"{whole}[{source.text_of(value)}]"


def _name_insertion_edits(
    source: SourceText, nodes: list[ast.expr], names: list[str], rank: int
) -> Iterator[tuple[int, int, int, str]]:
    """Insert a name before, between or after some nodes."""
    if any(isinstance(node, ast.GeneratorExp) for node in nodes):
        return
    for name in names:
        start = source.span(nodes[0])[0]
        yield rank, start, start, f"{name}, "
        for node in nodes:
            end = source.span(node)[1]
            yield rank, end, end, f", {name}"


def _assignment_edits(
    source: SourceText, node: ast.Assign, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    target = node.targets[0]
    targets = target.elts if isinstance(target, ast.Tuple) else [target]
    yield from _name_insertion_edits(source, targets, names.unbound, 1)
    if isinstance(target, (ast.Name, ast.Subscript)):
        start = source.span(target)[1]
        end = source.span(node.value)[0]
        at = source.text(start, end).find("=")
        for rank, sign in ((2, "+="), (3, "-="), (3, "&="), (3, "|=")):
            yield rank, start + at, start + at + 1, sign
    if isinstance(target, ast.Name) and isinstance(node.value, ast.Name):
        yield 2, *_swap(source, target, node.value)
    if isinstance(target, ast.Subscript) and isinstance(node.value, ast.Name):
        yield 1, *_swap(source, target.slice, node.value)
    if isinstance(target, ast.Name):
        yield 1, *source.span(node.value), f"{target.id}[{source.text_of(node.value)}]"
        for whole in names.arguments:
            yield 2, *source.span(target), f"{whole}.{target.id}"


def _if_edits(source: SourceText, node: ast.If) -> Iterator[tuple[int, int, int, str]]:
    start = source.span(node)[0]
    if source.text(start, start + 5) == "elif ":
        yield 2, start, start + 4, "if"
    else:
        yield 2, start, start + 2, "elif"
        # `if queue:` is likelier to be meant as a loop than a comparison is.
        yield 1 if isinstance(node.test, ast.Name) else 2, start, start + 2, "while"


def _wrapping_edits(
    source: SourceText, node: ast.expr, parent: ast.AST | None, field: str
) -> Iterator[tuple[int, int, int, str]]:
    """Change a value where it is used, for example with a sign, a root, an index or a slice."""
    into = (ast.Return, ast.Assign, ast.AugAssign, ast.Call, ast.Tuple, ast.List, ast.Subscript)
    tested = isinstance(parent, (ast.If, ast.While, ast.IfExp)) and field == "test"
    placed = isinstance(parent, into) and field in ("value", "args", "elts", "slice")
    operand = isinstance(parent, (ast.BinOp, ast.Compare, ast.BoolOp))
    if not (tested or placed or operand) or isinstance(node, (ast.Starred, ast.Slice)):
        return
    if isinstance(node, ast.Constant) and type(node.value) not in (int, float):
        return
    start, end = source.span(node)
    text = source.text_of(node)
    name = isinstance(node, ast.Name)
    atom = name or isinstance(node, (ast.Attribute, ast.Subscript, ast.Call))
    inner = text if atom else f"({text})"
    if tested or isinstance(parent, ast.BoolOp):
        yield 0, start, end, f"(not {inner})"
        for method in (".all()", ".any()") if isinstance(node, ast.Compare) else ():
            yield 1, start, end, inner + method
    elif isinstance(parent, ast.Subscript):
        for rank, sign in ((0, "~"), (1, "-")) if field == "slice" else ():
            yield rank, start, end, sign + inner
    elif isinstance(node, ast.Constant):
        yield 1, start, end, f"(-{inner})"
    elif not isinstance(node, (ast.Tuple, ast.List)):
        if placed and not _is_arithmetic(node):
            yield 2, start, end, f"~{inner}"
        for wrap in _WRAPS:
            yield 1 if placed else 3, start, end, f"({wrap.format(inner)})"
        # Students rarely lose the sign of an array.
        number = isinstance(node, (ast.BinOp, ast.Name))
        yield 1 if placed and number else 3, start, end, f"(-{inner})"
        yield 3, start, end, f"(1 - {inner})"
        for part in _SLICES if atom and placed else ():
            yield 2, start, end, inner + part
        for part in _RARE_SLICES if atom and placed else ():
            yield 3, start, end, inner + part
        if operand and name:
            for part in (*_COLUMNS, *_INDICES):
                yield 3, start, end, inner + part
            divides = isinstance(getattr(parent, "op", None), ast.Div) and field == "right"
            yield 1 if divides else 3, start, end, inner + "[:, None]"
        for part in _ROW_TESTS if placed and not _is_arithmetic(node) else ():
            yield 2, start, end, inner + part
        operator = getattr(parent, "op", None)
        if atom and not name and field == "left" and isinstance(operator, (ast.Sub, ast.BitAnd)):
            yield 1, start, end, inner + "[:, None]"
        if atom and isinstance(operator, ast.MatMult):
            yield 1, start, end, f"{inner}.T"
        for change in ("{} + 1", "{} - 1") if placed else ():
            yield 1 if isinstance(node, ast.Name) else 3, start, end, f"({change.format(inner)})"
    if isinstance(parent, ast.Return):
        for rank, wrap in (
            *((0 if isinstance(node, ast.GeneratorExp) else 2, "list({})"), (2, "np.array({})")),
            *((3, "int({})"), (3, "float({})"), (3, "tuple({})")),
        ):
            yield (
                rank,
                start,
                end,
                wrap.format(f"({text})" if isinstance(node, ast.Tuple) else text),
            )


def _name_combination_edits(
    source: SourceText, node: ast.expr, parent: ast.AST | None, field: str, names: Names
) -> Iterator[tuple[int, int, int, str]]:
    """Put a value into a call, or combine it with one of the function's names."""
    into = (ast.Return, ast.Assign, ast.AugAssign, ast.Call, ast.Tuple, ast.List)
    operand = isinstance(parent, (ast.BinOp, ast.Compare))
    if not operand and not (isinstance(parent, into) and field in ("value", "args", "elts")):
        return
    if isinstance(node, (ast.Constant, ast.Tuple, ast.List, ast.Starred, ast.GeneratorExp)):
        return
    start, end = source.span(node)
    inner = source.text_of(node)
    for call in _CALLS if isinstance(node, (ast.Name, ast.Attribute)) else ():
        yield 3, start, end, call.format(inner)
    if operand and isinstance(node, ast.Name) and node.id in names.arguments:
        yield 2, start, end, f"np.array({inner})"
    atom = isinstance(node, (ast.Name, ast.Attribute, ast.Subscript, ast.Call))
    for name in names.bound if isinstance(node, ast.Name) else ():
        if name not in names.arguments and name != node.id:
            yield 3, start, end, f"{inner}[{name}]"
    for form in _COMBINATIONS:
        for name in names.bound:
            yield 5, start, end, f"({form.format(inner if atom else f'({inner})', name)})"


def _is_arithmetic(node: ast.expr) -> bool:
    """Return whether a node is arithmetic, such as a sum, rather than a combination of masks."""
    masks = (ast.BitAnd, ast.BitOr, ast.BitXor)
    return isinstance(node, ast.BinOp) and not isinstance(node.op, masks)
