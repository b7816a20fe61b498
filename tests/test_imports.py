"""The modules of `utils` load only the packages that they need, and never the grader."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parent.parent

HEAVY = {"matplotlib", "pyvista", "vtk", "vtkmodules", "scipy", "sklearn", "rosbags", "IPython"}
WITHOUT_A_PICTURE = (
    "utils",
    "utils.boxes",
    "utils.breaking",
    "utils.checks",
    "utils.clouds",
    "utils.datasets",
    "utils.geometry",
    "utils.ground",
    "utils.notebooks",
    "utils.recordings",
    "utils.replays",
    "utils.scenes",
    "utils.scoring",
    "utils.simulator",
    "utils.streets",
    "utils.tables",
    "utils.tracking",
    "utils.traffic",
    "utils.visits",
)
WITH_PICTURES = ("utils.drive", "utils.films", "utils.play", "utils.plots", "utils.scene3d")


def loaded_with(module):
    """Return the packages that a new interpreter has loaded after importing `module`."""
    command = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", command], cwd=PROJECT, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    return {name.partition(".")[0] for name in done.stdout.split()}


@pytest.mark.slow
@pytest.mark.parametrize("module", WITHOUT_A_PICTURE)
def test_modules_without_pictures_load_no_heavy_package(module):
    assert not loaded_with(module) & HEAVY


@pytest.mark.slow
@pytest.mark.parametrize("module", WITH_PICTURES)
def test_plotting_modules_load_no_heavy_package_except_matplotlib(module):
    assert loaded_with(module) & HEAVY == {"matplotlib"}


def test_utils_does_not_load_numpy():
    assert "numpy" not in loaded_with("utils")


@pytest.mark.parametrize("part", ["ground", "streets", "traffic"])
def test_parts_of_the_simulator_have_shorter_names(part):
    """Both names refer to the same module, so classes such as `Ground` exist only once."""
    short = importlib.import_module(f"utils.{part}")
    assert short is importlib.import_module(f"utils.simulator.{part}")
    assert short is getattr(importlib.import_module("utils"), part)
    with pytest.raises(ModuleNotFoundError, match=f"utils.{part}_"):
        importlib.import_module(f"utils.{part}_")


def imported_by(path):
    """Yield each module that a file imports, at the top or inside a function."""
    for node in ast.walk(ast.parse(path.read_bytes(), str(path))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


def test_utils_never_imports_the_grader():
    imports = {path: set(imported_by(path)) for path in (PROJECT / "utils").rglob("*.py")}
    assert any("numpy" in names for names in imports.values())  # proves that the files were read
    for path, names in imports.items():
        assert not [name for name in names if name.partition(".")[0] == "grader"], path
