"""The structure of the project itself."""

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

# From the ground up: a room imports from its own floor and from those below.
FLOORS = ("course", "intake", "sandbox", "judging", "classroom", "lms")


def imported_by(path):
    """Dotted names of all that a file imports."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("room", FLOORS)
def test_no_room_of_the_grader_imports_upwards(room):
    above = FLOORS[FLOORS.index(room) + 1 :]
    files = list((PROJECT / "grader" / room).rglob("*.py"))
    assert files
    for path in files:
        for name in imported_by(path):
            assert not any(name.startswith(f"grader.{other}") for other in above), (path, name)


def imports_within(root, rooms):
    """For each module of some folders, those of them that it imports, in whichever of its lines."""
    files = {
        ".".join(path.relative_to(root).with_suffix("").parts).removesuffix(".__init__"): path
        for room in rooms
        for path in (root / room).rglob("*.py")
    }
    found = {}
    for module, path in files.items():
        names = set(imported_by(path)) & files.keys() - {module}
        # `from package import module` imports the module, and uses nothing of the package.
        found[module] = {name for name in names if not any(n.startswith(f"{name}.") for n in names)}
    return found


def circle_in(imports):
    """Modules that import each other in a circle, or none."""
    try:
        TopologicalSorter(imports).prepare()
    except CycleError as circle:
        return circle.args[1]
    return []


def test_no_module_imports_what_imports_it():
    """Neither at once, nor in a function, nor for its annotations: the seam would be missing."""
    imports = imports_within(PROJECT, ("grader", "utils"))
    assert "grader.sandbox.protocol" in imports["grader.sandbox.student"]
    assert "utils.scene3d.viewer" in imports["utils.scene3d.output"], "in a function"
    assert circle_in(imports) == []


@pytest.mark.parametrize(
    "line", ["import b.c", "from b import c", "from b.c import x", "def f():\n    import b.c"]
)
def test_a_circle_is_found_wherever_the_import_stands(line, tmp_path):
    for path, text in {"a/__init__.py": line, "b/__init__.py": "", "b/c.py": "import a"}.items():
        (tmp_path / path).parent.mkdir(exist_ok=True)
        (tmp_path / path).write_text(text)
    assert set(circle_in(imports_within(tmp_path, "ab"))) == {"a", "b.c"}
    (tmp_path / "b" / "c.py").write_text("import math")
    assert circle_in(imports_within(tmp_path, "ab")) == []


def test_sandboxes_are_objects_and_not_names():
    """Which sandbox it is makes no difference to whoever uses one."""
    for path in (PROJECT / "grader").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Compare):
                values = [getattr(part, "value", None) for part in (node.left, *node.comparators)]
                assert not set(SANDBOXES) & {value for value in values if isinstance(value, str)}


def test_what_only_proof_runs_is_there(request):
    """A test that was renamed would silently run everywhere, or nowhere."""
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
def test_a_test_that_stands_still_is_named(processes, tmp_path):
    """And nobody waits for it: `make test` runs with the same settings, and more patience."""
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
    said = done.stdout + done.stderr
    assert done.returncode
    assert "Timeout" in done.stderr and 'test_still.py", line 2 in test_still' in said
    named = re.search(r"crashed while running '.*::test_still'", said)
    assert bool(named) == bool(processes)


def test_every_module_that_decides_is_changed_and_its_nearest_tests_are_there():
    rooms = (PROJECT / "grader" / room for room in ("judging", "intake"))
    modules = {path.relative_to(PROJECT).as_posix() for room in rooms for path in room.glob("*.py")}
    decide = {name for name in modules if not name.endswith("__init__.py")}
    assert not decide - set(mutants.TESTS), "name its nearest tests in TESTS of tests/mutants.py"
    for tests in mutants.TESTS.values():
        assert all((PROJECT / "tests" / name).is_file() for name in tests)


def test_what_nobody_could_notice_is_said_of_lines_that_are_there():
    said = mutants.equivalent()
    assert len(said) > 10
    for change in said:
        module, before, _ = change.split("\n")
        text = " ".join((PROJECT / module).read_text("utf-8").split())
        assert before.removeprefix("- ") in text, change
