"""Students cannot import a forbidden module, but the libraries that need it still work."""

import functools
import json
import subprocess
import sys
from importlib import metadata

import pytest

from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT
from grader.sandbox import Limits
from grader.sandbox.boundary import files_of_packages
from grader.sandbox.program import INSTALLED_PACKAGES, Program
from grader.sandbox.student import StudentProxy
from utils.checks.import_guard import BlockedModules
from utils.notebooks.forbidden import StandIn, StandInModule

# Code that imports all public modules of some packages. For each failed import, it records the
# exception and the missing module.
SWEEP = '''
import contextlib, importlib, importlib.util, io, pkgutil, sys, warnings

def failures(packages, without, after=lambda: None):
    """Return {module: (exception, missing module)} for failed imports, and the number of others."""
    failed, count = {}, 0
    for name in public_modules([package for package in packages if package not in without]):
        if any(f"{name}.".startswith(f"{module}.") for module in without):
            continue
        try:
            with contextlib.redirect_stdout(io.StringIO()), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                importlib.import_module(name)
            count += 1
        except BaseException as error:
            said = f"{type(error).__name__}: {error}"
            while error.__cause__ or error.__context__:
                error = error.__cause__ or error.__context__
            failed[name] = said, str(getattr(error, "name", ""))
        after()
    return failed, count

def public_modules(packages):
    for package in packages:
        yield package
        folders = importlib.util.find_spec(package).submodule_search_locations
        for found in pkgutil.walk_packages(folders, f"{package}.", onerror=lambda name: None):
            if not any(part[0] == "_" or part == "tests" for part in found.name.split(".")):
                yield found.name
'''
# Code that runs SWEEP like a notebook, in which some modules may already have been imported.
NOTEBOOK_SWEEP = (
    SWEEP
    + """
import json
from utils.checks.import_guard import BlockedModules
from utils.notebooks.forbidden import StandIn, StandInModule
packages, without, forbidden, first = json.loads(sys.argv[1])
for name in first:
    importlib.import_module(name)
with BlockedModules(forbidden) as refusing:
    failed = failures(packages, without, refusing.hide)
left = [
    f"{name}.{inner}"
    for name, module in list(sys.modules.items())
    for inner, value in [("", module), *list(getattr(module, "__dict__", {}).items())]
    if isinstance(value, (StandIn, StandInModule))
]
print(json.dumps([*failed, left]))
"""
)


def import_names(packages):
    """Return the names under which Python imports packages."""
    names = {"scikit-learn": "sklearn"}
    return [names.get(package, package) for package in packages]


@functools.cache
def failed_imports_in_sandbox(packages, without, forbidden, sandbox):
    """Return the modules that cannot be imported in the sandbox, and the number of others."""
    source = f"{SWEEP}\ndef f(packages, without):\n    return failures(packages, without)\n"
    program = Program((source,), ("f",), forbidden=forbidden, packages=packages)
    limits = Limits(call_seconds=100.0, total_seconds=200.0)
    with StudentProxy(program, sandbox, limits) as student:
        failed, count = student.f(import_names(packages), list(without))
    return {name: tuple(failure) for name, failure in failed.items()}, count


@functools.cache
def failed_imports_in_notebook(packages, without, forbidden, first=()):
    """Like `failed_imports_in_sandbox`, but in a notebook during a check.

    Assert that no stand-ins remain.
    """
    given = json.dumps([import_names(packages), without, forbidden, first])
    done = subprocess.run(
        [sys.executable, "-c", NOTEBOOK_SWEEP, given],
        cwd=PROJECT,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    failed, count, left = json.loads(done.stdout.splitlines()[-1])
    assert left == []
    return {name: tuple(failure) for name, failure in failed.items()}, count


@pytest.mark.slow
def test_all_modules_that_a_lesson_allows_can_be_imported(lesson, sandbox):
    """The result is the same in the sandbox, in a checked notebook, and without rules."""
    forbidden = lesson.header.forbidden
    plain, count = failed_imports_in_notebook(INSTALLED_PACKAGES, forbidden, ())
    assert count > 300
    judged = failed_imports_in_sandbox(INSTALLED_PACKAGES, forbidden, forbidden, sandbox)
    assert judged == failed_imports_in_sandbox(INSTALLED_PACKAGES, forbidden, (), sandbox)
    loaded = tuple(
        name for name in forbidden if name.partition(".")[0] in import_names(INSTALLED_PACKAGES)
    )
    for first in {(), loaded}:
        assert failed_imports_in_notebook(INSTALLED_PACKAGES, forbidden, forbidden, first) == (
            plain,
            count,
        )
    # Modules that are missing only in the sandbox belong to packages that no lesson needs.
    visible = {path.stem for path in files_of_packages(INSTALLED_PACKAGES)}
    only_there = {name: missing for name, (_, missing) in judged[0].items() if name not in plain}
    installed = metadata.packages_distributions()
    for name, missing in only_there.items():
        package = missing.partition(".")[0]
        assert package in installed and package not in visible, f"{name}: {judged[0][name]}"


# ---- use of libraries ----------------------------------------------------------------------------

USES = {
    "04_kd_tree": """
import numpy as np
from scipy import integrate, interpolate, optimize, signal, stats
def f():
    xs = np.arange(5.0)
    grid = interpolate.RegularGridInterpolator((xs, xs), np.add.outer(xs, xs))
    return [
        float(stats.norm.cdf(0.0)),
        float(interpolate.interp1d(xs, xs**2)(3.0)),
        float(grid([1.0, 2.5])[0]),
        float(optimize.brentq(lambda x: x - 2.0, 0.0, 5.0)),
        float(signal.convolve([1.0, 1.0], [1.0, 1.0])[1]),
        float(integrate.quad(lambda x: x, 0.0, 2.0)[0]),
    ]
""",
    "05_euclidean_clustering": """
import numpy as np
from scipy import stats
from sklearn.decomposition import PCA
from sklearn.neighbors import BallTree, KDTree, NearestNeighbors, radius_neighbors_graph
def f():
    points = np.array([[0.0, 0.0], [0.0, 1.0], [5.0, 0.0]])
    return [
        len(KDTree(points).query_radius(points[:1], 2.0)[0]),
        len(BallTree(points).query_radius(points[:1], 2.0)[0]),
        len(NearestNeighbors(radius=2.0).fit(points).radius_neighbors(points[:1])[1][0]),
        int(radius_neighbors_graph(points, 2.0).nnz),
        float(PCA(1).fit(points).explained_variance_ratio_[0]) > 0.9,
        float(stats.norm.cdf(0.0)),
    ]
""",
}
EXPECTED = {
    "04_kd_tree": [0.5, 9.0, 3.5, 2.0, 2.0, 2.0],
    "05_euclidean_clustering": [2, 2, 2, 2, True, 0.5],
}


@pytest.mark.parametrize("name", USES)
def test_libraries_that_import_a_forbidden_module_work(name, sandbox):
    header = find_lesson(name).header
    program = Program(
        (USES[name],), ("f",), forbidden=header.forbidden, packages=INSTALLED_PACKAGES
    )
    with StudentProxy(program, sandbox, Limits()) as student:
        assert student.f() == pytest.approx(EXPECTED[name])


# ---- in a notebook -------------------------------------------------------------------------------


def test_hidden_modules_are_restored():
    """All references to modules are restored, even after an exception."""
    import scipy.sparse
    import sklearn.manifold._isomap as library
    from scipy.sparse import csgraph

    function, near = csgraph.connected_components, [[0, 1], [0, 0]]
    before = dict(vars(library)), dict(vars(scipy.sparse)), dict(vars(csgraph))
    with pytest.raises(ZeroDivisionError), BlockedModules(["scipy.sparse.csgraph"]):
        for reached in (
            library.connected_components,
            scipy.sparse.csgraph.connected_components,
            sys.modules["scipy.sparse.csgraph"].connected_components,
            sys.modules["scipy.sparse.csgraph._traversal"].connected_components,
        ):
            assert isinstance(reached, StandIn)
            with pytest.raises(ImportError, match=r"^scipy.sparse.csgraph is not allowed"):
                reached(near)
        raise ZeroDivisionError
    assert (dict(vars(library)), dict(vars(scipy.sparse)), dict(vars(csgraph))) == before
    assert library.connected_components is function
    assert sys.modules["scipy.sparse.csgraph"] is csgraph


def test_modules_that_are_not_forbidden_are_unchanged():
    import scipy.spatial
    import sklearn.metrics.cluster

    names = [
        (vars(module), dict(vars(module))) for module in (scipy.spatial, sklearn.metrics.cluster)
    ]
    with BlockedModules(["sklearn.cluster", "scipy.cluster"]):
        for now, before in names:
            assert now == before
    with BlockedModules([]) as refusing:
        assert not refusing.hide()


def test_a_stand_in_can_be_used_like_a_class():
    module = StandInModule("package.part", "package")
    tree = module.Tree
    assert module.Tree is tree and tree.__module__ == "package.part"
    assert not isinstance(3, tree) and not issubclass(int, tree)
    assert {tree: 1}[tree] == 1 and tree | None and not hasattr(tree, "__len__")

    class Better(tree):
        """A subclass of a stand-in."""

    for thing in (tree, Better, tree.build, module.function):
        with pytest.raises(ImportError, match="^package is not allowed in this lesson"):
            thing(1, two=2)
