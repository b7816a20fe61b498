"""Slicing keeps the statements of a notebook that its exercises need, and no others."""

import builtins
import re
import textwrap

import pytest

from utils.notebooks import slicing


def notebook(text):
    """Return the code cells of a text in which lines of --- separate the cells."""
    return [textwrap.dedent(cell) for cell in textwrap.dedent(text).split("---\n")]


def run_slice(text, *names):
    """Run the slice of a notebook; return the namespace, its source and the invalid cells."""
    statements, skipped = slicing.parse_notebook(notebook(text))
    kept, namespace = slicing.slice_for(names or ("f",), statements), {"__name__": "__main__"}
    for statement in kept:
        exec(slicing.compile_statement(statement, f"code cell {statement.cell}"), namespace)
    source = "\n".join(slicing.ast.unparse(statement.node) for statement in kept)
    return namespace, source, [cell for cell in skipped if not cell.magic]


class StandIn:
    """A stand-in for IPython that does nothing, like the one in the sandbox."""

    def __getattr__(self, name):
        return lambda *values, **options: None


# In each notebook, f() returns 42 if the slice has everything that `f` needs.
@pytest.mark.parametrize(
    "text",
    [
        "def f(): return 42",
        "def f(): return helper()\n---\ndef helper(): return LIMIT\n---\nLIMIT = 42",
        "import math as m\n---\ndef f(): return m.floor(42.5)",
        "from math import *\n---\ndef f(): return floor(42.5)",
        "from os import path as p\ndef f(): return 42 if p.sep else 0",
        "import xml.dom.minidom\ndef f(): return 42 if xml.dom.minidom else 0",
        "try:\n    import no_such_library as fast\nexcept ImportError:\n    fast = None\n"
        "def f(): return 41 if fast else 42",
        "A = B = 21\ndef f(): return A + B",
        "A, *B = 40, 1, 1\ndef f(): return A + sum(B)",
        "N: int = 42\ndef f() -> 'int': return N",
        "N = 0\nfor k in range(43): N = k\ndef f(): return N",
        "if True:\n    def g(): return 42\nelse:\n    g = None\ndef f(): return g()",
        "with open('/dev/null') as file: N = 42\ndef f(): return N + len(file.name) - 9",
        "if (N := 42) > 1: pass\ndef f(): return N",
        "[last := n for n in range(43)]\ndef f(): return last",
        "f = lambda: 42",
        "f = None\ndef f(): return 42",
        "def f(): raise NotImplementedError\n---\ndef f(): return 42",
        "def f(): return 42\n---\ndef g(): return 1",
        "def f(): return 2\n---\n_old = f\ndef f(): return 40 + _old()",
        "TABLE = []\nTABLE.append(42)\ndef f(): return TABLE[0]",
        "TABLE = {}\nTABLE['a'] = 42\ndef f(): return TABLE['a']",
        "TABLE = [0, 42]\ndel TABLE[0]\ndef f(): return TABLE[0]",
        "TABLE = [40]\nTABLE[0] += 2\ndef f(): return TABLE[0]",
        "TABLE = [42]\nTABLE += [1]\ndef f(): return TABLE[0]",
        "TABLE = []\nfor n in range(43): TABLE.append(n)\ndef f(): return TABLE[-1]",
        "COUNT = 41\ndef f():\n    global COUNT\n    COUNT += 1\n    return COUNT",
        "def f():\n    n = 41\n    def g():\n        nonlocal n\n        n += 1\n    g()\n"
        "    return n",
        "class A:\n    LIMIT = 42\n---\ndef f(): return A.LIMIT",
        "class A: pass\nclass B(A): n = 42\ndef f(): return B.n",
        "class A: pass\n---\nA.limit = 42\n---\ndef f(): return A.limit",
        "class A: pass\n---\ndef method(self): return 42\nA.go = method\n---\n"
        "def f(): return A().go()",
        "class A: pass\nsetattr(A, 'n', 42)\ndef f(): return A.n",
        "class A:\n    def go(self): return OFFSET\nOFFSET = 42\ndef f(): return A().go()",
        "K = 21\nclass A:\n    table = [k * K for k in range(3)]\n---\ndef f(): return A.table[2]",
        "def twice(g): return lambda: 2 * g()\n@twice\ndef f(): return 21",
        "import functools\n@functools.lru_cache(maxsize=None)\ndef f(): return 42",
        "from dataclasses import dataclass\n@dataclass\nclass P:\n    n: int = 42\n"
        "def f(): return P().n",
        "DEFAULT = 42\ndef f(n=DEFAULT): return n",
        "import asyncio\nasync def g(): return 42\ndef f(): return asyncio.run(g())",
        "N = 42\ndef f(): return int(f'{N:d}')",
        "N = 42\ndef f(): return [N for _ in range(3)][0]",
        "N = 42\ndef f(): return (lambda: (lambda: N)())()",
        "def f():\n    match 1:\n        case 1: return N\nN = 42",
        "from __future__ import annotations\n---\ndef f(a: NoSuchType = 1) -> NorThis: return 42",
        "'''A docstring.'''\n\ndef f(): return 42",
        "def f(): return 42\n---\ndel f_other\n---\nf = f",
        "import sys\nsys.setrecursionlimit(5000)\n"
        "def f(): return 42 if sys.getrecursionlimit() == 5000 else 0",
        "import numpy as np\nnp.random.seed(1)\nR = np.random.rand()\n"
        "def f(): return 42 if round(R, 6) == 0.417022 else 0",
        "%matplotlib inline\nN = 42\n---\ndef f(): return N",
        "%%time\nN = 42\n---\ndef f(): return N",
        "%%capture out\n%%time\nN = 42\n---\ndef f(): return N",
        "files = !ls\nN = 42\n---\ndef f(): return N",
        "!pip install something\nN = 42\n---\ndef f(): return N",
        "N = 42\nN?\n?print\nprint??\n---\ndef f(): return N",
        "%timeit -n1 1 + 1\nN = 42\n---\ndef f(): return N",
        "def f():\n    %timeit 1\n    return 42",
        "%%bash\nrm -rf / ; def f(\n---\ndef f(): return 42",
        "%%html\n<b>f = 1</b>\n---\ndef f(): return 42",
        "def f(): return 42\n---\ndef f(:\n---\nx = = 3",
        "print('Python 2 is', 'gone')\nprint 'yes'\n---\ndef f(): return 42",
        ">>> N = 42\n>>> M = 1\n---\ndef f(): return N",
        "def f(): return 42\r\n",
        "N=42;M=1\ndef f(): return N",
        "def f(): return 42  # \u4f60\u597d",
    ],
)
def test_a_slice_keeps_statements_that_the_function_needs(text, monkeypatch):
    monkeypatch.setattr(builtins, "get_ipython", StandIn, raising=False)
    namespace, _, _ = run_slice(text)
    assert namespace["f"]() == 42


@pytest.mark.parametrize(
    "line",
    [
        "slow_experiment()",
        "check(f)",
        "raise RuntimeError",
        "1 / 0",
        "cloud = slow_experiment()",
        "labels = f()",
        "print(f())",
        "assert f() == 0",
        "for n in range(10**9): pass",
        "while True: pass",
        "input('Your name? ')",
        "exit()",
        "import no_such_module",
        "plt.plot(f())",
        "np.testing.assert_equal(f(), 0)",
        "np.savetxt('/x', slow_experiment())",
        "sys.exit()",
        "sys.path.append('..')",
        "%timeit slow_experiment()",
        "!sleep 100",
        "%%timeit\nslow_experiment()",
        "results.append(slow_experiment())",
        "f()",
        "f().x = 1",
        "with open('/no/such/file') as g: text = g.read()",
        "class Later(slow_experiment()): pass",
    ],
)
def test_a_slice_omits_statements_that_the_function_does_not_need(line):
    text = (
        f"import sys\nimport numpy as np\nimport this_is_not_needed\n---\n{line}\n---\n"
        "def f(): return np.int64(42)\n---\ndef slow_experiment(): raise SystemExit"
    )
    namespace, source, problems = run_slice(text)
    assert namespace["f"]() == 42 and not problems
    assert "slow" not in source and "this_is_not_needed" not in source and len(source) < 90


@pytest.mark.parametrize(
    "comprehension",
    [
        "[n for n in slow_experiment()]",
        "{n for n in slow_experiment()}",
        "{n: k for n, k in slow_experiment()}",
        "sum([[n for n in row] for row in slow_experiment()], [])",
        "[max(n for n in row) for row in slow_experiment()]",
    ],
)
def test_variables_of_a_comprehension_are_local(comprehension):
    text = f"n = k = row = 42\n---\nothers = {comprehension}\n---\ndef f(): return n + k - row"
    namespace, source, problems = run_slice(text)
    assert namespace["f"]() == 42 and not problems
    assert "slow" not in source
    needs = f"others = {comprehension}\n---\nn = k = row = 0\n---\ndef f(): return others"
    assert "row = 0" not in run_slice(needs.replace("slow_experiment()", "[]"))[1]


def test_the_last_definition_wins_as_it_does_in_a_notebook():
    namespace, _, _ = run_slice("def f(): return 1\n---\ndef f(): return 2\n---\nf = f or None")
    assert namespace["f"]() == 2


def test_a_cell_with_a_syntax_error_is_named_and_other_cells_are_kept():
    namespace, _, skipped = run_slice("x = 1\n---\ndef g(:\n    pass\n---\ndef f(): return x")
    assert namespace["f"]() == 1
    (cell,) = skipped
    assert cell.sentence.startswith("Code cell 2 is not valid Python, so it was skipped: ")
    assert "def g(:" in cell.sentence


@pytest.mark.parametrize(
    "source, reason, remedy",
    [
        ("def f(:\n    return 1", "not valid Python: .*line 1: 'def f\\(:'", "Correct it"),
        ("def f():\n\u00a0   return 1", "not valid Python: .*U\\+00A0", "type it again"),
        ("def f():\n    return \u201ca\u201d", "not valid Python: .*U\\+201C", "type it again"),
        ("def f(a\uff1d1):\n    return a", "not valid Python: .*U\\+FF1D", "type it again"),
        ("def f():\n    return 1\0", "NUL \\(line 2\\)", "type it again"),
        ("f = lambda: '" + "(" * 9, "not valid Python: .*unterminated", "Correct it"),
        ("%%timeit -n 3\ndef f(): pass", "begins with %%timeit", "Delete that line"),
        ("%%time\n\n%%cython\ndef f(): pass", "begins with %%cython", "Delete that line"),
        ("class A:\n    def f(self:", "not valid Python", "Correct it"),
    ],
)
def test_a_skipped_cell_explains_why_its_function_is_missing(source, reason, remedy):
    statements, (cell,) = slicing.parse_notebook(["x = 1", source])
    assert [statement.cell for statement in statements] == [1]
    text = cell.describe_missing("f")
    assert text.startswith("f is in code cell 2, which was skipped, because it ")
    assert re.search(reason, text) and remedy in text
    assert cell.defines("f") and not cell.defines("g") and not cell.defines("return")


@pytest.mark.parametrize(
    "source", ["%%time\ndef f(): pass", "%%capture x\nf = 1", "%who", "# %%bash"]
)
def test_a_cell_that_runs_in_the_notebook_is_not_skipped(source):
    assert slicing.parse_notebook([source])[1] == []


def test_a_missing_function_keeps_no_statements():
    assert run_slice("x = 1\n---\nprint(x)", "f", "g")[1] == ""


@pytest.mark.parametrize(
    "line, module",
    [
        ("import sklearn.cluster", "sklearn.cluster"),
        ("import sklearn.cluster as c", "sklearn.cluster"),
        ("from sklearn import cluster", "sklearn.cluster"),
        ("from sklearn.cluster import DBSCAN", "sklearn.cluster"),
        ("def f():\n    from sklearn.cluster import DBSCAN", "sklearn.cluster"),
        ("try:\n    import open3d\nexcept ImportError: pass", "open3d"),
    ],
)
def test_imports_are_found_everywhere(line, module):
    statements, _ = slicing.parse_notebook(["x = 1", line])
    assert (2, module) in set(slicing.imported_modules(statements))


def test_an_error_names_the_cell_and_the_line():
    statements, _ = slicing.parse_notebook(["", "\n\ndef f():\n    return 1 / 0"])
    namespace = {}
    exec(slicing.compile_statement(statements[0], "code cell 2"), namespace)
    with pytest.raises(ZeroDivisionError) as raised:
        namespace["f"]()
    last = raised.traceback[-1]
    assert (str(last.frame.code.raw.co_filename), last.lineno + 1) == ("code cell 2", 4)


@pytest.mark.parametrize(
    "above",
    [
        "\n  \n%%time\n",
        "%%capture out\n\n%%time\n\n",
        "!ls \\\n  -l \\\n  /\n",
        "\n\n%matplotlib \\\n inline\nprint?\n",
        "\nfiles = %sx ls \\\n  -l\n",
        "In [1]: x = 1\n   ...: y = 2\n%who\n",
        "text = '''\n% of the points\n!\n'''\n%who\n",
    ],
)
def test_magics_leave_every_line_in_its_place(above):
    statements, skipped = slicing.parse_notebook([above + "def f():\n    %who\n    return 1 / 0"])
    assert not skipped
    assert statements[-1].node.body[-1].lineno == above.count("\n") + 3
    _, (cell,) = slicing.parse_notebook([above + "def g(:"])
    assert f"(line {above.count(chr(10)) + 1}: 'def g(:')" in cell.sentence


def test_magics_do_nothing_and_return_none():
    namespace, source, _ = run_slice(
        "x = %sx ls\ny = %who\nz = get_ipython().user_ns_of(1)\ndef f(): return x, y, z", "f"
    )
    assert namespace["f"]() == (None, None, None)
    assert "ipython" not in source


def test_a_function_checked_after_its_definition_is_an_exercise():
    cells = ["check(f)", "def f(): pass", "def g(): pass", "check(g, 'h')\nplain = 1", "check(fg)"]
    statements, _ = slicing.parse_notebook(cells)
    names = ("f", "g", "plain", "nothing")
    assert [slicing.is_checked(name, statements) for name in names] == [False, True, False, False]


def test_code_of_the_lesson_after_a_check_is_omitted():
    text = """
def near(point): return point + 1
def f(point): return near(point)
---
check(f)
---
near = missing[0]
def g(point): return late(point)
---
check(g)
---
def late(point): return point + 2
"""
    space, _, problems = run_slice(text, "f", "g")
    assert problems == []
    assert (space["f"](1), space["g"](1)) == (2, 3)


def test_a_definition_after_the_check_also_counts():
    text = """
def f(): return 1
---
check(f)
---
LEVEL = 5
def f(): return LEVEL
"""
    space, _, _ = run_slice(text, "f")
    assert space["f"]() == 5
