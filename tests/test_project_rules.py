"""The modules of the project have the documented structure."""

import ast
import os
import re
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter

import pytest

from grader.course.paths import PROJECT
from grader.sandbox import SANDBOXES
from tests import mutants

# Layers of the grader, lowest first. A layer imports only from itself and from lower layers.
LAYERS = ("course", "intake", "sandbox", "judging", "classroom", "questions", "lms")


def imported_by(path):
    """Yield the dotted names of all modules that a file imports."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("layer", LAYERS)
def test_no_layer_of_the_grader_imports_from_a_higher_layer(layer):
    above = LAYERS[LAYERS.index(layer) + 1 :]
    files = list((PROJECT / "grader" / layer).rglob("*.py"))
    assert files
    for path in files:
        for name in imported_by(path):
            assert not any(name.startswith(f"grader.{upper}") for upper in above), (path, name)


def imports_within(root, folders):
    """Return the import graph within some folders: the set of imported modules for each module."""
    files = {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
        for folder in folders
        for path in (root / folder).rglob("*.py")
    }
    found = {}
    for module, path in files.items():
        names = set(imported_by(path)) & files.keys() - {module}
        # `from package import module` counts as an import of the module, not of the package.
        found[module] = {name for name in names if not any(n.startswith(f"{name}.") for n in names)}
    return found


def cycle_in(imports):
    """Return the modules of an import cycle, or an empty list."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as error:
        return error.args[1]
    return []


def test_there_are_no_import_cycles():
    """Imports inside functions and for annotations count, because they also couple modules."""
    imports = imports_within(PROJECT, ("extension", "grader", "utils"))
    assert "grader.sandbox.protocol" in imports["grader.sandbox.student"]
    assert "utils.scene3d.viewer" in imports["utils.scene3d.output"], "in a function"
    assert cycle_in(imports) == []


@pytest.mark.parametrize(
    "line", ["import b.c", "from b import c", "from b.c import x", "def f():\n    import b.c"]
)
def test_a_cycle_is_found_for_every_form_of_import(line, tmp_path):
    for path, text in {"a/__init__.py": line, "b/__init__.py": "", "b/c.py": "import a"}.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)
    assert set(cycle_in(imports_within(tmp_path, "ab"))) == {"a", "b.c"}
    (tmp_path / "b" / "c.py").write_text("import math")
    assert cycle_in(imports_within(tmp_path, "ab")) == []


def test_the_grader_never_compares_sandbox_names():
    """The grader never compares the name of a sandbox, so it treats all sandboxes alike."""
    for path in (PROJECT / "grader").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Compare):
                values = [getattr(part, "value", None) for part in (node.left, *node.comparators)]
                assert not set(SANDBOXES) & {value for value in values if isinstance(value, str)}


def test_tests_that_only_make_proof_runs_in_full_exist(request):
    """Every name in `A_FEW_OF_MANY` exists; otherwise, a renamed test would always run in full."""
    conftest = next(
        plugin
        for plugin in request.config.pluginmanager.get_plugins()
        if getattr(plugin, "A_FEW_OF_MANY", None)
    )
    folders = (PROJECT / "tests", PROJECT / "solutions")
    files = (path for folder in folders for path in folder.rglob("test_*.py"))
    source = "\n".join(path.read_text("utf-8") for path in files)
    for name in conftest.A_FEW_OF_MANY:
        assert source.count(f"def {name}(") == 1, name


@pytest.mark.slow
@pytest.mark.parametrize("processes", [0, 2])
def test_a_hanging_test_is_named(processes, tmp_path):
    """A run with a hanging test ends. `make test` uses the same settings with a longer timeout."""
    (tmp_path / "test_still.py").write_text(
        "import threading, pytest\n"
        "def test_still(): threading.Lock().acquire() and threading.Event().wait()\n"
        "@pytest.mark.parametrize('number', range(9))\n"
        "def test_quick(number): pass\n"
    )
    command = [sys.executable, "-m", "pytest", "-c", PROJECT / "pyproject.toml", "-n", processes]
    options = ["-p", "conftest", "-o", "faulthandler_timeout=1", "-v", "test_still.py"]
    done = subprocess.run(
        [*map(str, command), *options],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        timeout=600,
    )
    output = done.stdout + done.stderr
    assert done.returncode
    assert "Timeout" in done.stderr and 'test_still.py", line 2 in test_still' in output
    named = re.search(r"crashed while running '.*::test_still'", output)
    assert bool(named) == bool(processes)


def test_modules_that_decide_marks_have_mutation_tests():
    roots = (PROJECT / "grader" / root for root in ("judging", "intake"))
    modules = {path.relative_to(PROJECT).as_posix() for root in roots for path in root.glob("*.py")}
    decide = {name for name in modules if not name.endswith("__init__.py")}
    assert not decide - set(mutants.TESTS), "name its nearest tests in TESTS of tests/mutants.py"
    for tests in mutants.TESTS.values():
        assert all((PROJECT / "tests" / name).is_file() for name in tests)


def test_equivalent_mutants_quote_existing_lines():
    changes = mutants.equivalent_mutants()
    assert len(changes) > 10
    for change in changes:
        module, before, _ = change.split("\n")
        text = " ".join((PROJECT / module).read_text("utf-8").split())
        assert before.removeprefix("- ") in text, change
