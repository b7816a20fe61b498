"""Edits that undo a slip, which is a mistake that one small edit fixes."""

import ast
import textwrap

import pytest

from utils.notebooks import slicing
from utils.notebooks.edits import MAX_EDITS, edits_of, edits_of_statement

# Wrong and right lines of a function body; the parameters are x, y, z, n and node.
SLIPS = {
    "an operator": ("return x + y * z", "return x + y / z"),
    "a sign": ("return a, b, -(a * x + b * y)", "return a, b, a * x + b * y"),
    "a sign inside an expression": (
        "return -dy / length, dx / length",
        "return dy / length, dx / length",
    ),
    "a comparison": ("return x < y", "return x <= y"),
    "a comparison reversed": ("return x < y", "return x > y"),
    "is None": (
        "if x is None:\n    return y\nreturn z",
        "if x is not None:\n    return y\nreturn z",
    ),
    "a constant": ("for k in range(1, n):\n    x += k", "for k in range(0, n):\n    x += k"),
    "a bound": ("for k in range(n):\n    x += k", "for k in range(n + 1):\n    x += k"),
    "an upper bound with a lower one": (
        "for k in range(1, n):\n    x += k",
        "for k in range(1, n + 1):\n    x += k",
    ),
    "a bound with one too many": (
        "for k in range(n - 1):\n    x += k",
        "for k in range(n):\n    x += k",
    ),
    "an axis": ("return x.mean(axis=1)", "return x.mean(axis=0)"),
    "no axis": ("return x.mean()", "return x.mean(axis=0)"),
    "a mask": ("return x[y]", "return x[~y]"),
    "a mask of a call": ("return x[np.isnan(y)]", "return x[~np.isnan(y)]"),
    "a needless inversion": ("return x[~y]", "return x[y]"),
    "abs": ("return a * x + b < y", "return abs(a * x + b) < y"),
    "a needless abs": ("return abs(x)", "return x"),
    "a root": ("return x ** 2 + y ** 2", "return (x ** 2 + y ** 2) ** 0.5"),
    "a root of a sum": ("return np.sum(x)", "return np.sum(x) ** 0.5"),
    "a square": ("return x + y ** 2", "return x ** 2 + y ** 2"),
    "a copy": ("y = x\nreturn y", "y = x.copy()\nreturn y"),
    "an index": ("return x[:, 0]", "return x[:, 1]"),
    "a column": ("return x[0]", "return x[:, 0]"),
    "a table for a height": ("return x[x > y]", "return x[x[:, 2] > y]"),
    "a point for its number": ("return x - y[1]", "return x[1] - y[1]"),
    "rows for columns": ("return f(x[:3])", "return f(x[:, :3])"),
    "a table for its column": ("return f(x, y[:, 1])", "return f(x[:, 0], y[:, 1])"),
    "row and column": ("return x[0, :]", "return x[:, 0]"),
    "arguments": ("return f(x, y)", "return f(y, x)"),
    "the order of two returned values": ("return x, y", "return y, x"),
    "the order of three returned values": ("return x, y, z", "return z, x, y"),
    "names": ("dx = x\nreturn dx + y", "dx = y\nreturn dx + y"),
    "not and and for masks": ("return x[y and not z]", "return x[(y) & ~(z)]"),
    "parentheses around comparisons": (
        "return x[x == 0 & y == 0 & z == 0]",
        "return x[(x == 0) & (y == 0) & (z == 0)]",
    ),
    "a tuple in arithmetic": ("return x + (y - z)", "return x + (np.array(y) - z)"),
    "two parameters exchanged in a statement": (
        "a = y < x\nb = (y > x) & (z > y)\nreturn a & b",
        "a = y < x\nb = (z > x) & (y > z)\nreturn a & b",
    ),
    "a count that is never updated": (
        "best = 0\nfor k in x:\n    n = f(k)\n    if n > best:\n        y = k\nreturn y",
        "best = 0\nfor k in x:\n    n = f(k)\n    if n > best:\n        y = k\n"
        "        best = n\nreturn y",
    ),
    "a counter that never grows": (
        "y = 0\nfor k in x:\n    if k:\n        continue\n    z[k] = y\nreturn z",
        "y = 0\nfor k in x:\n    if k:\n        continue\n    y += 1\n    z[k] = y\nreturn z",
    ),
    "a counter that never grows in an inner loop": (
        "y = 1\nfor k in x:\n    while f(k):\n        g(y)\nreturn z",
        "y = 1\nfor k in x:\n    while f(k):\n        g(y)\n        y += 1\nreturn z",
    ),
    "a statement that comes too late": (
        "for k in x:\n    f(k)\n    y += k\n    z.append(k)\nreturn z",
        "for k in x:\n    z.append(k)\n    f(k)\n    y += k\nreturn z",
    ),
    "row numbers for a mask": (
        "if z:\n    return y, n\nreturn y, n",
        "if z:\n    return y, np.isin(np.arange(len(x)), n)\n"
        "return y, np.isin(np.arange(len(x)), n)",
    ),
    "a missing assignment in an if": (
        "for k in x:\n    if k:\n        y = k\n    else:\n        z = k\nreturn y, z",
        "for k in x:\n    if k:\n        y = k\n        z = k\n    else:\n        z = k\n"
        "return y, z",
    ),
    "one truth value of an array": ("if x == y:\n    return z", "if (x == y).all():\n    return z"),
    "the other child": ("node.left = x", "node.right = x"),
    "min and max": ("return x.min(), x.max()", "return x.max(), x.max()"),
    "a return one level out": (
        "for k in x:\n    if k:\n        y += k\n    return y",
        "for k in x:\n    if k:\n        y += k\nreturn y",
    ),
    "a line one level in": (
        "if x:\n    y = 1\nz = 2\nreturn z",
        "if x:\n    y = 1\n    z = 2\nreturn z",
    ),
    "two lines one level in": (
        "for k in x:\n    f(k)\ny += k\nz += k\nreturn z",
        "for k in x:\n    f(k)\n    y += k\n    z += k\nreturn z",
    ),
    "an if too deep": (
        "if x:\n    f(x)\n    if y:\n        f(y)",
        "if x:\n    f(x)\nif y:\n    f(y)",
    ),
    "break": ("for k in x:\n    if k:\n        break", "for k in x:\n    if k:\n        continue"),
    "a return": (
        "if x:\n    f(x)\nf(y)",
        "if x:\n    f(x)\n    return\nf(y)",
    ),
    "elif": ("if x:\n    f(x)\nif y:\n    f(y)", "if x:\n    f(x)\nelif y:\n    f(y)"),
    "a slice": ("return x", "return x[::-1]"),
    "the last columns for the first": ("return f(x[:, -3:])", "return f(x[:, :3])"),
    "the rest for the beginning": ("return x[n:]", "return x[:n]"),
    "the beginning for the rest": ("return x[:n]", "return x[n:]"),
    "a needless slice": ("return x[::-1]", "return x"),
    "three columns": ("return f(x)", "return f(x[:, :3])"),
    "a forgotten return": ("f(x)\nnp.sort(y)", "f(x)\nreturn np.sort(y)"),
    "a missing return": ("for k in x:\n    y += k", "for k in x:\n    y += k\nreturn y"),
    "a table for a mask": ("y = x > 0\nreturn f(y)", "y = (x > 0).all(axis=1)\nreturn f(y)"),
    "and": ("return x and y", "return x or y"),
    "a shift": ("return x << y", "return x >> y"),
    "a shift back": ("return x >> y & 1", "return x << y & 1"),
    "both masks": ("return x & y", "return x | y"),
    "not": ("while x:\n    y += 1", "while not x:\n    y += 1"),
    "+=": ("for k in x:\n    y = k\nreturn y", "for k in x:\n    y += k\nreturn y"),
    "a list for an array": ("return [x, y]", "return np.array([x, y])"),
    "two lines": ("y = f(x)\nx = g(y)\nreturn x", "x = g(y)\ny = f(x)\nreturn x"),
    "a needless line": ("x = f(x)\nx = g(x)\nreturn x", "x = g(x)\nreturn x"),
    "a keyword": ("return f(x, axis=1)", "return f(x)"),
    "transposed": ("return x @ y", "return x @ y.T"),
    "a call": ("return len(x)", "return x"),
    "pass": (
        "for k in x:\n    if k:\n        pass\n    y += k",
        "for k in x:\n    if k:\n        continue\n    y += k",
    ),
    "an early end": (
        "for k in x:\n    if k:\n        return\n    y += k",
        "for k in x:\n    if k:\n        continue\n    y += k",
    ),
    "a result that is not returned": ("y = x > 0\nx[y & z]", "y = x > 0\nreturn x[y & z]"),
    "is equal": ("return x <= y", "return x == y"),
    "a product for a conjunction": ("return x & y", "return x * y"),
    "one returned value too few": ("return x", "return x, y"),
    "two of three returned values": ("return x, z", "return x, y, z"),
    "a missing argument": ("return f(y)", "return f(x, y)"),
    "a missing name": ("dx = f(z)\nreturn dx + dy", "dx, dy = f(z)\nreturn dx + dy"),
    "no range": ("for k in n:\n    x += k", "for k in range(n):\n    x += k"),
    "no len": ("return x.sum() / y", "return x.sum() / len(y)"),
    "no sum": ("if x > y:\n    z = x", "if x > y.sum():\n    z = x"),
    "a missing factor": ("return x + y", "return x + (y * z)"),
    "a missing division": ("dx = x - y\nreturn dx", "dx = x - y\nreturn (dx / n)"),
    "with replacement": ("return z.choice(n, 2)", "return z.choice(n, 2, replace=False)"),
    "a mask returned": ("y = x > 0\nreturn y", "y = x > 0\nreturn x[y]"),
    "missing brackets on the right": ("return x ** 1 / 2", "return x ** (1 / 2)"),
    "missing brackets on the left": ("return n - 1 // 2", "return (n - 1) // 2"),
    "the upper middle": ("return x[n // 2]", "return x[(n - 1) // 2]"),
    "two missing axes": ("return x.min(), x.max()", "return x.min(axis=0), x.max(axis=0)"),
    "two wrong axes": (
        "return x.min(axis=1), x.max(axis=1)",
        "return x.min(axis=0), x.max(axis=0)",
    ),
    "a name from the notebook": (
        "y = y + z + n + node\nreturn street[street[:, 0] > y]",
        "y = y + z + n + node\nreturn x[x[:, 0] > y]",
    ),
    "a comparison of a name with itself": (
        "y = f(z)\nif y.sum() > 0:\n    z = y",
        "y = f(z)\nif y.sum() > z.sum():\n    z = y",
    ),
    "the wrong name returned": ("y = f(z)\nreturn x, y", "y = f(z)\nreturn x, z"),
    "a table returned for a mask": ("return abs(x - y) < n", "return (abs(x - y))"),
    "needless brackets": ("return n * (x + y * z)", "return n * x + y * z"),
    "a term outside the call": ("return abs(x) + y", "return abs(x + y)"),
    "a term inside the call": ("return np.sqrt(x + y)", "return (np.sqrt(x) + y)"),
    "a pair for numbers": ("return x, y", "return *x, y"),
    "whole numbers for a mask": ("return x.astype(int)", "return x"),
    "a power": ("return x", "return (x ** n)"),
    "the complement": ("return np.log(x)", "return np.log((1 - x))"),
    "an attribute": ("y = node", "x.y = node"),
    "rows of rows": ("x = np.argsort(y)\nreturn x", "x = x[np.argsort(y)]\nreturn x"),
    "a loop for an if": ("if x:\n    y = f(x)", "while x:\n    y = f(x)"),
    "an empty queue": ("z = deque()\nreturn z", "z = deque([x])\nreturn z"),
    "both sides exchanged": (
        "if x:\n    f(node.left)\nelse:\n    f(node.right)",
        "if x:\n    f(node.right)\nelse:\n    f(node.left)",
    ),
    "a missing assignment": (
        "y, z = 0, 0\nfor k in x:\n    n = f(k)\n    z = k\nreturn y, z",
        "y, z = 0, 0\nfor k in x:\n    n = f(k)\n    z = k\n    y = n\nreturn y, z",
    ),
    "and for masks": ("return x[y and z]", "return x[(y) & (z)]"),
    "not for a mask": ("return x[not y]", "return x[~(y)]"),
    "a result that is not assigned": ("f(x, y)\nreturn x", "x = f(x, y)\nreturn x"),
    "a column of numbers": ("return x / y", "return x / y[:, None]"),
    "the rows of a count": ("r = f(z)\nreturn y[n < 3], r", "r = f(z)\nreturn y[n[r] < 3], r"),
    "a number for a parameter": (
        "y = y + z + node\nreturn f(x) < 0.5",
        "y = y + z + node\nreturn f(x) < n",
    ),
    "two parameters exchanged": ("return y < x < z", "return z < x < y"),
    "print": ("y = 2 * x\nprint(y)", "y = 2 * x\nreturn y"),
    "a return two levels out": (
        "for k in x:\n    for m in k:\n        y += m\n        return y",
        "for k in x:\n    for m in k:\n        y += m\nreturn y",
    ),
    "a return one of two levels out": (
        "for k in x:\n    y = 0\n    for m in k:\n        y += m\n        return y",
        "for k in x:\n    y = 0\n    for m in k:\n        y += m\n    return y",
    ),
    "a mask that is not used": ("y = x > 0", "y = x > 0\nreturn x[~y]"),
    "a return after a special case": (
        "if x is None:\n    x = f(n)\ny = g(x)\nz.append(y)",
        "if x is None:\n    x = f(n)\n    return\ny = g(x)\nz.append(y)",
    ),
    "a counter that grows in no call": (
        "f(node.left, n)\nf((node.right, n))",
        "f(node.left, n + 1)\nf((node.right, n + 1))",
    ),
    "results of calls that are lost": (
        "y = []\nif x:\n    f(x)\nif z:\n    f(z)\nreturn y",
        "y = []\nif x:\n    y += f(x)\nif z:\n    y += f(z)\nreturn y",
    ),
    "^ for each power": ("return (x ^ 2 + y ^ 2) ** n", "return (x ** 2 + y ** 2) ** n"),
    "a double for each square": (
        "return f((x - n) * 2 + y * 2)",
        "return f((x - n) ** 2 + y ** 2)",
    ),
    "the result of one call that is lost": (
        "y = []\nif x:\n    f(x)\nif z:\n    y += f(z)\nreturn y",
        "y = []\nif x:\n    y += f(x)\nif z:\n    y += f(z)\nreturn y",
    ),
    "the ends of an interval": (
        "if x[n] + y < z:\n    f(x)\nif x[n] - y > z:\n    f(z)",
        "if x[n] - y < z:\n    f(x)\nif x[n] + y > z:\n    f(z)",
    ),
    "a variable for its attribute": (
        "if node.left is None:\n    node = x",
        "if node.left is None:\n    node.left = x",
    ),
    "one too few in each copy": ("return f(x[n - 1], y[n - 1])", "return f(x[n], y[n])"),
    "a mean that is not added again": (
        "q = x - y\nz = q @ n\nreturn z",
        "q = x - y\nz = (q @ n) + y\nreturn z",
    ),
    "a minus for a mask": ("return x[-y]", "return x[~(y)]"),
    "~ outside the brackets": ("return ~x[y]", "return x[~(y)]"),
    "a chain for masks": ("return x[y <= x <= z]", "return x[(y <= x) & (x <= z)]"),
    "a comparison outside the brackets": ("return x[y] <= n", "return x[y <= n]"),
    "no axis of rows to delete": ("return np.delete(x, y)", "return np.delete(x, y, axis=0)"),
    "math for arrays": (
        "y = math.sin(n)\nreturn math.sqrt(y)",
        "y = np.sin(n)\nreturn np.sqrt(y)",
    ),
    "rows for two columns": ("return np.hypot(x[0], x[1])", "return np.hypot(x[:, 0], x[:, 1])"),
    "all columns for three": (
        "return x[(x >= y) & (x <= z)]",
        "return x[(x[:, :3] >= y) & (x[:, :3] <= z)]",
    ),
    "columns shifted by one": ("return x[:, 1:4]", "return x[:, :3]"),
    "columns shifted by one in each copy": (
        "return x[:, 2:4] - x[:, 2:4].mean(axis=0)",
        "return x[:, 1:3] - x[:, 1:3].mean(axis=0)",
    ),
    "a mask that is not used as an index": (
        "near = x < y\nfar = z[:, :3]\nreturn far",
        "near = x < y\nfar = z[:, :3][near]\nreturn far",
    ),
    "an inverted mask that is not used as an index": (
        "near = x < y\nreturn z",
        "near = x < y\nreturn z[~near]",
    ),
    "a loop variable that is not used": (
        "for k in range(n):\n    z.append(f(x))",
        "for k in range(n):\n    z.append(f(x[k]))",
    ),
    "a value in place of one that is not used": (
        "rows = f(x)\nreturn z[n]",
        "rows = f(x)\nreturn z[rows]",
    ),
    "an index missing on both sides": (
        "axis = n % 2\nreturn x < node.point",
        "axis = n % 2\nreturn x[axis] < node.point[axis]",
    ),
    "an index that another operand has": (
        "split = node.point\nreturn x[n] < split",
        "split = node.point[n]\nreturn x[n] < split",
    ),
    "an index missing in each operand": (
        "split = z[n]\nreturn f(x, x - y < split, x + y > split)",
        "split = z[n]\nreturn f(x, x[n] - y < split, x[n] + y > split)",
    ),
    "a tuple in place of its last part": (
        "basis = np.linalg.svd(x)\nreturn basis @ y",
        "basis = np.linalg.svd(x)[2]\nreturn basis @ y",
    ),
    "a table in place of its last row": ("least = x\nreturn least", "least = x[2]\nreturn least"),
    "a tuple in place of one number": (
        "normal, offset = x[:3], x\nreturn y @ normal + offset",
        "normal, offset = x[:3], x[3]\nreturn y @ normal + offset",
    ),
    "another part of a result": (
        "first, rows = f(x)\nreturn g(y[first], y[rows])",
        "first, rows = f(x)\nreturn g(y[rows], y[rows])",
    ),
    "values of groups in place of points": (
        "first, rows = f(x, first=y)\nz = g(rows)\nreturn np.unique(z)",
        "first, rows = f(x, first=y)\nz = g(rows)\nreturn np.unique(z[rows])",
    ),
    "a decimal point that is missing": ("return f(x, 3) > 2", "return f(x, 0.3) > 2"),
    "a decimal point one digit too far": ("return f(x) > 0.03", "return f(x) > 0.3"),
    "a decimal point one digit too early": ("return f(x, y=2.5)", "return f(x, y=0.25)"),
    "a rest that begins one too early": ("return x[y:]", "return x[(y) + 1:]"),
    "differences that are not a table": (
        "return x.mean(axis=1) - y.mean(axis=1)",
        "return x.mean(axis=1)[:, None] - y.mean(axis=1)",
    ),
    "an index and a value exchanged": ("z[x] = y\nreturn z", "z[y] = x\nreturn z"),
    "the ends of a range": ("return x < y <= z", "return z < y <= x"),
    "the last column for the third": ("return x[:, -1] > z", "return x[:, 2] > z"),
    "a statement after two calls": (
        "f(x, n)\nf(y, n)\nz.append(n)",
        "z.append(n)\nf(x, n)\nf(y, n)",
    ),
}


def function(body):
    return "def f(x, y, z, n, node):\n" + textwrap.indent(body, "    ") + "\n"


def edits_in(*cells):
    statements, _ = slicing.parse_notebook(cells)
    return edits_of(
        cells,
        [statement for statement in statements if isinstance(statement.node, ast.FunctionDef)],
    )


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_one_edit_away(slip):
    wrong, right = map(function, SLIPS[slip])
    found = set()
    for edit in edits_in(wrong):
        try:
            found.add(ast.dump(ast.parse(edit.statement)))
        except SyntaxError:
            continue
    assert ast.dump(ast.parse(right)) in found


@pytest.mark.parametrize("slip", SLIPS)
def test_applying_an_edit_changes_only_its_lines(slip):
    """The lines are right even after multi-byte characters and in a decorated function."""
    wrong = function('"""Länge, in m²."""\n' + SLIPS[slip][0])
    cells = ["import math\n", f"é = '²'\n\n@staticmethod\n{wrong}\nprint(é)"]
    edits = edits_in(*cells)
    assert len(edits) == len({edit.statement for edit in edits}) > 3
    for edit in edits:
        lines = cells[edit.cell - 1].split("\n")
        changed = "\n".join([*lines[: edit.first - 1], edit.text, *lines[edit.last :]])
        assert edit.cell == 2
        assert 4 <= edit.first <= edit.last <= 4 + wrong.count("\n")
        assert edit.statement in changed
        assert changed.startswith("é = '²'") and changed.endswith("print(é)")


def test_an_axis_gets_no_decimal_point():
    statements = [edit.statement for edit in edits_in(function("return f(x, axis=2, y=2)"))]
    assert any("y=0.2" in statement for statement in statements)
    assert not any("axis=0.2" in statement for statement in statements)


@pytest.mark.parametrize("position", [0, 1])
def test_an_edit_that_deletes_a_line_begins_with_this_line(position):
    lines = ["z = f(x)", "return z"]
    lines.insert(position, "x = 10.0")
    wanted = function("z = f(x)\nreturn z").strip()
    cell = function("\n".join(lines))
    [deletion] = [edit for edit in edits_in(cell) if edit.statement.strip() == wanted]
    assert cell.split("\n")[deletion.first - 1].strip() == "x = 10.0"


def test_docstrings_and_signatures_are_not_edited():
    text = 'def f(x, k=3):\n    """A text."""\n    return x\n'
    assert all(
        edit.statement.startswith('def f(x, k=3):\n    """A text."""')
        for edit in edits_in(text)
        if edit.first < 3
    )


def test_moving_a_return_one_level_out_is_tried_first():
    first, *_ = edits_in(function("for k in x:\n    if k < y:\n        y = k + 1\n    return y"))
    assert first.statement + "\n" == function(
        "for k in x:\n    if k < y:\n        y = k + 1\nreturn y"
    )


@pytest.mark.slow
def test_an_edit_creates_a_new_list_instead_of_a_shared_default():
    wrong = (
        'def f(x, found=[], near=3):\n    """Find x."""\n    found.append(x)\n    return found\n'
    )
    right = wrong.replace("    found.append", "    found = []\n    found.append")
    assert right.strip() in {edit.statement for edit in edits_in(wrong)}


def test_using_an_unused_parameter_is_tried_early():
    wrong = function("a = f(x, axis=1)\nb = f(x, axis=1)\nreturn a - b + z * n[node]")
    right = wrong.replace("b = f(x", "b = f(y").strip()
    assert min(edit.rank for edit in edits_in(wrong) if edit.statement == right) <= 0


def test_exchanging_low_and_high_is_tried_early():
    wrong = function("low, high = x, y\nreturn [(low[0], z), (low[0], n), (low[0], node)]")
    right = wrong.replace("(low[0], n)", "(high[0], n)").strip()
    assert min(edit.rank for edit in edits_in(wrong) if edit.statement == right) <= 1


def test_exchanging_similar_names_is_tried_early():
    """In a function with many names, other edits would otherwise use up the limit."""
    code = """
def line_through(p, q):
    (px, py), (qx, qy) = p, q
    length = math.dist(p, q)
    if length == 0:
        return None
    a = (py - qy) / length
    b = (qx - px) / length
    return a, b, -(a * px + b * qy)
"""
    texts = [edit.text.strip() for edit in edits_in(code)]
    assert "return a, b, -(a * px + b * py)" in texts[:200]


def test_replacing_points_with_row_numbers_is_tried_early():
    found = edits_in(function("y = []\nfor k in f(z):\n    y.append(x[z[k]])\nreturn y"))
    [edit] = [edit for edit in found if "y.append(z[k])" in edit.text]
    assert edit.rank == 1


def test_making_a_divisor_a_column_is_tried_early():
    found = edits_in(function("return x / n + y"))
    ranks = {edit.text.strip(): edit.rank for edit in found if "[:, None]" in edit.text}
    assert ranks["return x / n[:, None] + y"] == 1
    assert ranks["return x[:, None] / n + y"] == 3


def test_changing_if_to_while_is_tried_early_for_a_queue():
    found = edits_in(function("if x:\n    y += x.pop()\nif y > z:\n    y = z\nreturn y"))
    ranks = {edit.text.strip(): edit.rank for edit in found if "while" in edit.text}
    assert ranks == {"while x:": 1, "while y > z:": 2}


def counter_increments(*lines):
    wrong = function("\n".join(lines))
    return [edit for edit in edits_in(wrong) if " += 1" in edit.statement]


def test_only_a_counter_that_no_loop_changes_gets_a_step():
    loop = ("for k in x:", "    z[k] = y")
    assert len(counter_increments("y = 0", *loop)) == 2
    assert counter_increments("y = 0", *loop, "    y = k") == []
    assert counter_increments("y = n", *loop) == []
    assert counter_increments("y = False", *loop) == []
    assert counter_increments(*loop, "y = 0") == []
    assert counter_increments("y = 0", "for k in x:", "    z[k] = n", "return y") == []


def test_the_number_of_edits_is_limited():
    long = function("\n".join(f"x{k} = x + {k} * y - n" for k in range(100)))
    assert len(edits_in(long)) == MAX_EDITS
    longer = function("\n".join(f"x{k} = x + {k} * y - n" for k in range(200)))
    assert edits_in(longer) == []


@pytest.mark.parametrize(
    "text",
    [
        "def f(x): return x",
        "def f(x): return x; y = 1",
        "def f(x):\n\treturn -x",
        "def f(): pass",
        "def f(x):\n    class A(metaclass=type):\n        pass\n    return A",
    ],
)
def test_unusual_code_does_not_raise(text):
    for edit in edits_in(text):
        assert edit.first >= 1


# Types that only some versions of Python have, and old names.
TYPES_OF_OTHER_VERSIONS = {
    *("TypeAlias", "TemplateStr", "Interpolation", "Index", "ExtSlice", "Suite"),
    *("Num", "Str", "Bytes", "NameConstant", "Ellipsis", "AugLoad", "AugStore", "Param"),
}
EVERY_KIND_OF_CODE = """\
def outer(x, y, z, n, *rest, key=None, **others):
    global g
    import math
    from os import path
    total: int = 0
    x += y; x -= y; x *= y; x /= z; x //= z; x %= n; x **= n
    x @= y; x &= y; x |= y; x ^= y; x <<= n; x >>= n
    z = -x + (+y) * ~z @ x if not key and y or n else (a := 3)
    z = x - y / z // n % 2 ** n << 1 >> 1 | x & y ^ z
    same = x is y, x is not y, x in z, x not in z, x == y != z < n <= 3 > x >= y
    d, s, l = {"k": 1, **others}, {1, *rest}, [x, y]
    parts = [k for k in x if k], {k for k in x}, {k: k for k in x}, (k for k in x)
    text = f"{x!r:>{n}} {y}"
    del parts[0], d["k"]
    for k in range(1, n):
        if k > 2:
            continue
        elif k:
            break
        return x[k, ::2]
    else:
        pass
    while x.size:
        with open(path) as f, open(text):
            return (lambda q: q.min())(x)
    try:
        assert x, "no x"
        raise ValueError(x) from None
    except (ValueError, TypeError) as error:
        return y
    else:
        return z
    finally:
        math.sqrt(x)
    try:
        pass
    except* OSError:
        pass
    match x:
        case [1, *others] | (2, others):
            return 1
        case {"k": 1, **others}:
            return None
        case complex(real=0) as w if w:
            return ...
        case None:
            return True
    class Inner(dict, metaclass=type):
        value = 1
    def inner():
        nonlocal total
        yield x
        yield from y
        return total
    async def waits():
        async for k in x:
            await k
        async with y as k:
            return [k async for k in z]
    return inner, waits
"""


def test_every_kind_of_code_has_edits():
    """A kind of statement or expression that the edits do not expect must not raise."""
    tree = ast.parse(EVERY_KIND_OF_CODE)
    used = {type(node) for node in ast.walk(tree)}
    bases = (ast.stmt, ast.expr, ast.operator, ast.unaryop, ast.cmpop, ast.boolop, ast.pattern)
    missing = {
        kind.__name__
        for base in bases
        for kind in base.__subclasses__()
        if kind not in used and kind.__name__ not in TYPES_OF_OTHER_VERSIONS
    }
    assert not missing
    parts = [EVERY_KIND_OF_CODE]
    # A function has a limited number of edits, so each statement is also tested on its own.
    head = EVERY_KIND_OF_CODE.partition("\n")[0]
    for statement in tree.body[0].body:
        if not isinstance(statement, ast.FunctionDef):
            lines = textwrap.indent(ast.unparse(statement), "    ")
            parts.append(f"{head}\n{lines}\n    return x\n")
    for text in parts:
        [statement] = slicing.parse_notebook([text])[0]
        assert list(edits_of_statement([text], statement)), text
