"""Code that only a newer Python can parse is distinguished from code that is not valid at all."""

import ast
import sysconfig
from pathlib import Path

import pytest

from utils.notebooks import newer_syntax, slicing
from utils.notebooks.newer_syntax import parse_newer_syntax

# Code that was added to Python, and the version that added it, from the lists of changes in
# Python's documentation.
NEWER = {
    'x = f"{"level"}"': (3, 12),
    'x = f"{cloud["x"]!r:>{width}} {{}} {total=}"': (3, 12),
    'x = f"{chr(10).join(a)}{"\\n".join(b)}"': (3, 12),
    'x = f"""{a # a comment }\n}"""': (3, 12),
    'x = f"{\n    a\n}"': (3, 12),
    'x = f"{f"{f"{f"{1 + 1}"}"}"}"': (3, 12),
    "x = rf'{d['a']['b']}\\d' 'more' + \", \".join(f'{q['x']}' for q in z)": (3, 12),
    "def f[T](x: T) -> T:\n    return x": (3, 12),
    "class A[T: (int, str), *Ts, **P](B):\n    pass": (3, 12),
    "type X[T] = list[T]": (3, 12),
    "type X = list[int]": (3, 12),
    "try:\n    pass\nexcept A, B.c:  # both\n    pass": (3, 14),
    "try:\n    pass\nexcept* A, B:\n    pass": (3, 14),
    'x = t"{a} b"': (3, 14),
}
INVALID = [
    "def f(x)\n    return 1",
    "x = = 3",
    "x = f'{a'",
    "x = f'{a b}'",
    "x = f'{}'",
    "x = f'}'",
    "x = f'{a!x}'",
    'x = f"{d["a"}"',
    "x = \u201ca\u201d",
    "x\u00a0= 3",
    "if x = 3:\n    pass",
    "print 'a'",
    "x = 'a\nb'",
    "def f[T(x): pass",
    "def f[1](x): pass",
    "except A, B: pass",
    "type X",
    "x = '''a",
]


@pytest.fixture(autouse=True)
def oldest_python(monkeypatch):
    """Let the module treat all newer syntax as unknown, whichever Python runs the tests."""
    monkeypatch.setattr(newer_syntax, "RUNNING_VERSION", (3, 11))


@pytest.mark.parametrize("source, version", NEWER.items())
def test_newer_syntax_is_recognised_with_its_version(source, version):
    tree, found = parse_newer_syntax(f"a = 1\n{source}\nb = 2\n", ast.parse)
    assert found == version
    assert {"a", "b"} <= {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}


@pytest.mark.parametrize("source, version", NEWER.items())
def test_only_a_python_that_could_parse_the_code_excuses_it(source, version):
    assert parse_newer_syntax(source, ast.parse, (3, 11)) is None
    assert parse_newer_syntax(source, ast.parse, version)[1] == version
    assert (parse_newer_syntax(source, ast.parse, (3, 12)) is None) == (version == (3, 14))


@pytest.mark.parametrize("source", INVALID)
def test_code_that_no_version_accepts_stays_invalid(source):
    assert parse_newer_syntax(source, ast.parse) is None
    assert parse_newer_syntax(source, ast.parse, (3, 13)) is None


def test_the_syntax_of_an_unknown_version_is_not_called_invalid():
    assert parse_newer_syntax("x = = 3", ast.parse, (3, 99))[1] == (3, 99)


def test_valid_code_stays_valid_when_it_is_rewritten():
    """The standard library contains strings and comments of every form."""
    library = Path(sysconfig.get_path("stdlib"))
    files = sorted([*library.glob("*.py"), *library.glob("email/*.py")])[::6]
    for path in files:
        source = path.read_text("utf-8", "surrogateescape")
        if len(source) <= newer_syntax.MAX_CHARACTERS:
            ast.parse(newer_syntax._rewrite_python_3_14(source))


def test_magics_do_not_hide_newer_syntax():
    # No supported Python can parse a template string.
    cells = ['%matplotlib inline\n!echo "don\'t\nx = t"{"a"}"\nif x:\n    %who\n']
    _, (skipped,) = slicing.parse_notebook(cells)
    assert skipped.reason == "needs Python 3.14 or later" and len(skipped.newer.body) == 4


def test_long_invalid_code_is_refused():
    sources = [
        *('"\\"' * 60_000, "f'{" * 60_000, "a" * 190_000 + '"', " " * 190_000 + "x = = 3"),
        *("except " + "a," * 90_000, "def f[" * 30_000, "x = f'{" + "(" * 90_000),
    ]
    for source in sources:
        assert parse_newer_syntax(source, ast.parse) is None
