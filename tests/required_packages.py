"""The packages that the project imports, and the versions that its requirements files pin."""

import ast
import functools
import re
import sys
from importlib import metadata

from grader.course.paths import PROJECT

INSIDE = {path.stem for path in (PROJECT / "grader" / "sandbox" / "inside").glob("*.py")}
OWN_PACKAGES = {"docs", "extension", "grader", "utils", "tests"} | INSIDE
# Optional packages that are used if installed: libraries in benchmarks and proofs, lesson 13's
# numba, and the viewer Rerun.
PEERS = {"dbscan", "mcap", "mcap_ros2", "numba", "open3d", "pypcd4", "rerun"}
BROWSER = {"selenium"}  # for tests/hub.py and others, which scripts in .ci run elsewhere


def normal(name):
    """Return a distribution's name in PyPI's normalised form."""
    return re.sub(r"[-_.]+", "-", name).lower()


def own_pins(file):
    """Return the versions that a file itself pins, by distribution."""
    text = (PROJECT / file).read_text("utf-8")
    return {
        normal(name): version for name, version in re.findall(r"^([\w.-]+)==([\w.]+)", text, re.M)
    }


def imports(text):
    """Yield the packages that a program imports, including imports inside functions."""
    without_magics = re.sub(r"^( *)%.*", r"\1pass", text, flags=re.M)
    for node in ast.walk(ast.parse(without_magics)):
        if isinstance(node, ast.Import):
            yield from (name.name.partition(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.partition(".")[0]


@functools.cache
def third_party_imports():
    """Return the third-party packages that each file of the project imports."""
    found = {}
    for folder in ("docs", "extension", "grader", "utils", "solutions", "tests"):
        for path in sorted((PROJECT / folder).rglob("*.py")):
            packages = set(imports(path.read_text("utf-8")))
            others = packages - OWN_PACKAGES - PEERS - BROWSER - sys.stdlib_module_names
            found[path.relative_to(PROJECT).as_posix()] = others
    return found


@functools.cache
def distributions():
    """Return the distributions that provide each importable package."""
    return metadata.packages_distributions()
