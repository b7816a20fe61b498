"""The structure of the project itself."""

import ast
import os
import re
import subprocess
import sys

import pytest

from grader.course.paths import PROJECT
from grader.sandbox import SANDBOXES

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


def test_sandboxes_are_objects_and_not_names():
    """Which sandbox it is makes no difference to whoever uses one."""
    variants = PROJECT / "grader" / "variants"
    for path in set((PROJECT / "grader").rglob("*.py")) - set(variants.iterdir()):
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
    source = "\n".join(path.read_text("utf-8") for path in (PROJECT / "tests").rglob("test_*.py"))
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
    options = ["-p", "tests.conftest", "-o", "faulthandler_timeout=2", "-v", "test_still.py"]
    done = subprocess.run(
        [*map(str, command), *options],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
    said = done.stdout + done.stderr
    assert done.returncode
    assert "Timeout" in done.stderr and 'test_still.py", line 2 in test_still' in said
    named = re.search(r"crashed while running '.*::test_still'", said)
    assert bool(named) == bool(processes)
