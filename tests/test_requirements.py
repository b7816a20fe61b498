"""Whoever runs some of the code has all that it imports, in the same versions as everybody."""

import ast
import functools
import re
import sys
from importlib import metadata

import pytest
from packaging.requirements import Requirement

from grader.course.paths import PROJECT

# Who runs what: of these, the longest that a path begins with.
NEEDED_BY = {
    "utils/": "requirements.txt",
    "utils/films/writers.py": "requirements-3d.txt",
    "utils/scene3d/opengl.py": "requirements-3d.txt",
    "utils/scene3d/with_pyvista.py": "requirements-3d.txt",
    "solutions/": "requirements.txt",
    "grader/": "requirements.txt",
    "grader/classroom/cluster.py": "requirements-cluster.txt",
    "grader/classroom/worker_plugin.py": "requirements-cluster.txt",
    "grader/site/": "requirements-site.txt",
    "tests/": "requirements-dev.txt",
}
FILES = (
    "requirements.txt",
    "requirements-compiled.txt",
    *sorted({*NEEDED_BY.values()} - {"requirements.txt"}),
)
INSIDE = {path.stem for path in (PROJECT / "grader" / "sandbox" / "inside").glob("*.py")}
OURS = {"grader", "utils", "tests"} | INSIDE
# What is used where somebody has installed it: peers of a benchmark, and lesson 13's compiler.
PEERS = {"dbscan", "open3d", "numba"}
BROWSER = {"selenium"}  # of tests/hub.py, for which .ci/hub makes an environment of its own


def normal(name):
    """The name of a distribution as PyPI compares it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def own_pins(file):
    """Version by distribution of what a file names itself."""
    text = (PROJECT / file).read_text("utf-8")
    return {
        normal(name): version for name, version in re.findall(r"^([\w.-]+)==([\w.]+)", text, re.M)
    }


def pins(file):
    """The same, with what it includes."""
    included = re.findall(r"^-r (\S+)", (PROJECT / file).read_text("utf-8"), re.M)
    found = own_pins(file)
    for other in included:
        found |= pins(other)
    return found


def imports(text):
    """The packages that a program imports, at its top or within a function."""
    without_magics = re.sub(r"^( *)%.*", r"\1pass", text, flags=re.M)
    for node in ast.walk(ast.parse(without_magics)):
        if isinstance(node, ast.Import):
            yield from (name.name.partition(".")[0] for name in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield node.module.partition(".")[0]


@functools.cache
def strangers_by_file():
    """For each of our files the packages of others that it imports."""
    found = {}
    for folder in ("grader", "utils", "solutions", "tests"):
        for path in sorted((PROJECT / folder).rglob("*.py")):
            packages = set(imports(path.read_text("utf-8")))
            others = packages - OURS - PEERS - BROWSER - sys.stdlib_module_names
            found[path.relative_to(PROJECT).as_posix()] = others
    return found


@functools.cache
def distributions():
    """Those that bring a package, by its name."""
    return metadata.packages_distributions()


def file_for(path):
    """The requirements of whoever runs the code in a file."""
    return NEEDED_BY[max((start for start in NEEDED_BY if path.startswith(start)), key=len)]


def not_listed(packages, file):
    """Of some packages those whose distribution is not in a file of requirements."""
    listed, homes = pins(file), distributions()
    return {
        package
        for package in packages
        if not {normal(home) for home in homes.get(package, ())} & listed.keys()
    }


@pytest.mark.slow
def test_what_is_imported_is_listed():
    strangers = strangers_by_file()
    assert {"numpy", "yaml", "nbgrader", "pyvista", "distributed", "hypothesis"} <= set().union(
        *strangers.values()
    )
    missing = {path: not_listed(found, file_for(path)) for path, found in strangers.items()}
    assert not {path: names for path, names in missing.items() if names}


@pytest.mark.slow
@pytest.mark.parametrize("path", [path for path in NEEDED_BY if path.endswith(".py")])
def test_a_file_with_requirements_of_its_own_needs_them(path):
    assert not_listed(strangers_by_file()[path], "requirements.txt")


@pytest.mark.parametrize("file", FILES)
def test_constraints_pin_what_the_requirements_name(file):
    held = own_pins("constraints.txt")
    other = {
        name: held.get(name) for name, version in pins(file).items() if held.get(name) != version
    }
    assert not other, "run: make constraints"


@pytest.mark.parametrize("file", FILES)
def test_every_requirement_is_a_pin_and_every_file_is_constrained(file):
    text = (PROJECT / file).read_text("utf-8")
    assert re.search(r"^-[rc] ", text, re.M)  # requirements.txt names the constraints
    pattern = (
        r"(#.*|-r requirements[\w-]*\.txt|-c constraints\.txt|[\w.-]+==[\w.]+( ; [^#]+)?( +#.*)?|)"
    )
    assert not [line for line in text.splitlines() if not re.fullmatch(pattern, line)]


def test_constraints_hold_everywhere():
    """No address, folder or hash stands in them, and one file serves every Python."""
    lines = (PROJECT / "constraints.txt").read_text("utf-8").splitlines()
    pattern = r"(#.*|[\w.-]+==[\w.]+( ; [\w.' ()<>=!]+)?( +# via [\w., -]+)?)"
    assert not [line for line in lines if not re.fullmatch(pattern, line)]


def needs(name):
    """What a distribution needs here, without extras; nothing if it is not installed here."""
    try:
        requirements = metadata.requires(name) or ()
    except metadata.PackageNotFoundError:  # such as a wheel for other machines
        return
    for text in requirements:
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield normal(requirement.name)


def test_constraints_pin_what_the_requirements_need_in_turn():
    found, waiting = set(), [*pins("requirements-dev.txt")]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += needs(name)
    assert len(found) > 100
    assert not found - own_pins("constraints.txt").keys(), "run: make constraints"
