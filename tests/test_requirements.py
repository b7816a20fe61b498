"""Each requirements file lists all imports of its code, and all files pin the same versions."""

import re
from importlib import metadata

import pytest
from packaging.requirements import Requirement

from grader.course.paths import PROJECT
from tests.required_packages import distributions, normal, own_pins, third_party_imports

# The requirements file for the code below a path; the longest matching path applies.
NEEDED_BY = {
    "utils/": "requirements.txt",
    "utils/clouds/libraries.py": "requirements-formats.txt",
    "utils/films/writers.py": "requirements-3d.txt",
    "utils/scene3d/opengl.py": "requirements-3d.txt",
    "utils/scene3d/with_pyvista.py": "requirements-3d.txt",
    "solutions/": "requirements.txt",
    "docs/": "requirements-site.txt",
    "extension/": "requirements.txt",
    "grader/": "requirements.txt",
    "grader/classroom/cluster.py": "requirements-cluster.txt",
    "grader/classroom/worker_plugin.py": "requirements-cluster.txt",
    "grader/course/films.py": "requirements-3d.txt",
    "grader/site/": "requirements-site.txt",
    "grader/site/live/": "requirements-live.txt",
    "tests/": "requirements-dev.txt",
}
FILES = (
    "requirements.txt",
    "requirements-compiled.txt",
    "requirements-proof.txt",
    "requirements-viewers.txt",
    *sorted({*NEEDED_BY.values()} - {"requirements.txt"}),
)


def pins(file):
    """Return the versions that a file and the files it includes pin, by distribution."""
    included = re.findall(r"^-r (\S+)", (PROJECT / file).read_text("utf-8"), re.M)
    found = own_pins(file)
    for other in included:
        found |= pins(other)
    return found


def file_for(path):
    """Return the requirements file for the code in a file."""
    return NEEDED_BY[max((start for start in NEEDED_BY if path.startswith(start)), key=len)]


def unlisted_packages(packages, file):
    """Return the packages whose distributions are missing from a requirements file."""
    listed, homes = pins(file), distributions()
    return {
        package
        for package in packages
        if not {normal(home) for home in homes.get(package, ())} & listed.keys()
    }


@pytest.mark.slow
def test_all_imports_are_in_the_requirements():
    packages_by_file = third_party_imports()
    assert {"numpy", "yaml", "nbgrader", "pyvista", "distributed", "hypothesis"} <= set().union(
        *packages_by_file.values()
    )
    missing = {
        path: unlisted_packages(found, file_for(path)) for path, found in packages_by_file.items()
    }
    assert not {path: names for path, names in missing.items() if names}


@pytest.mark.slow
@pytest.mark.parametrize("path", [path for path in NEEDED_BY if path.endswith(".py")])
def test_files_with_their_own_requirements_need_them(path):
    assert unlisted_packages(third_party_imports()[path], "requirements.txt")


@pytest.mark.parametrize("file", FILES)
def test_constraints_pin_all_requirements(file):
    fixed = own_pins("constraints.txt")
    different = {
        name: fixed.get(name) for name, version in pins(file).items() if fixed.get(name) != version
    }
    assert not different, "run: make constraints"


@pytest.mark.parametrize("file", FILES)
def test_every_requirement_is_a_pin_and_every_file_is_constrained(file):
    text = (PROJECT / file).read_text("utf-8")
    assert re.search(r"^-[rc] ", text, re.M)  # constrained directly or by requirements.txt
    pattern = (
        r"(#.*|-r requirements[\w-]*\.txt|-c constraints\.txt|[\w.-]+==[\w.]+( ; [^#]+)?( +#.*)?|)"
    )
    assert not [line for line in text.splitlines() if not re.fullmatch(pattern, line)]


def test_constraints_work_on_every_machine():
    """Without addresses, folders and hashes, the file works for every Python on every machine."""
    lines = (PROJECT / "constraints.txt").read_text("utf-8").splitlines()
    pattern = r"(#.*|[\w.-]+==[\w.]+( ; [\w.' ()<>=!]+)?( +# via [\w., -]+)?)"
    assert not [line for line in lines if not re.fullmatch(pattern, line)]


def dependencies_of(name):
    """Yield the requirements of an installed distribution on this machine, without extras."""
    try:
        requirements = metadata.requires(name) or ()
    except metadata.PackageNotFoundError:  # for example, a wheel for other machines
        return
    for text in requirements:
        requirement = Requirement(text)
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield normal(requirement.name)


def test_constraints_pin_all_indirect_dependencies():
    found, waiting = set(), [*pins("requirements-dev.txt")]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += dependencies_of(name)
    assert len(found) > 100
    assert not found - own_pins("constraints.txt").keys(), "run: make constraints"
