"""Attempts to reach a forbidden module through permitted libraries that import it."""

import pytest

from grader.course.lessons import all_lessons, find_lesson
from grader.sandbox.program import INSTALLED_PACKAGES
from tests.attacks.attack import attack, function, with_attacks

FORBIDDING_LESSONS = {lesson.name: lesson for lesson in all_lessons() if lesson.header.forbidden}
# These libraries import modules that some lessons forbid.
IMPORT_LIBRARIES = """
import importlib
def import_libraries():
    for name in ("scipy.interpolate", "scipy.stats.qmc", "scipy.signal", "scipy.optimize",
                 "scipy.cluster.hierarchy", "scipy.cluster.vq", "scipy.spatial", "scipy.sparse",
                 "sklearn.manifold", "sklearn.mixture", "sklearn.cluster", "sklearn.neighbors",
                 "sklearn.semi_supervised", "sklearn.utils.estimator_checks"):
        try:
            importlib.import_module(name)
        except ImportError:
            pass
"""


def attack_on(lesson, source):
    """Return a proxy for a student of a lesson, with enough time to import large libraries."""
    seconds = {"call_seconds": 20.0, "total_seconds": 40.0}
    return attack(source, forbidden=lesson.header.forbidden, packages=INSTALLED_PACKAGES, **seconds)


@pytest.mark.slow
@with_attacks("forbidding", FORBIDDING_LESSONS)
def test_forbidden_code_is_not_in_memory_after_libraries_import_it(forbidding):
    """Memory contains stand-ins, but no code, classes or functions of forbidden modules."""
    source = (
        "# scipy is named here, so it may have been imported.\n"
        + IMPORT_LIBRARIES
        + """
import gc, sys, types
def f(forbidden):
    import_libraries()
    gc.unfreeze()
    is_in = lambda name: any(f"{name}.".startswith(f"{module}.") for module in forbidden)
    folders = tuple("/" + name.replace(".", "/") + "/" for name in forbidden)
    found = [line for line in open("/proc/self/maps") if any(part in line for part in folders)]
    stand_ins = [name for name in sys.modules if is_in(name)]
    for thing in gc.get_objects():
        kind, home = type(thing), getattr(type(thing), "__module__", "")
        if kind.__name__ in ("StandIn", "StandInModule"):
            continue
        if isinstance(thing, types.FunctionType):
            if any(part in thing.__code__.co_filename for part in folders):
                found.append(repr(thing))
        elif isinstance(thing, (type, types.BuiltinFunctionType)):
            home = thing.__module__
        if isinstance(home, str) and is_in(home):
            found.append(repr(thing))
    loaded = [name for name in sys.modules if name.split(".")[0] in ("scipy", "sklearn")]
    return found, stand_ins, len(loaded)
"""
    )
    with attack_on(forbidding, source) as student:
        found, stand_ins, loaded = student.f(list(forbidding.header.forbidden))
    assert found == []
    assert stand_ins and loaded > 200, "libraries imported the module"


# Each attempt assigns a function to `stolen`. The test calls it with the adjacency matrix of two
# close points.
NOTICED_ATTEMPTS = {
    "imports the module": "import scipy.sparse.csgraph as g\nstolen = g.NAME",
    "imports the function": "from scipy.sparse.csgraph import NAME as stolen",
    "imports the module from the package": "from scipy.sparse import csgraph\n"
    "stolen = csgraph.NAME",
    "calls the importer": "stolen = get('scipy.sparse.csgraph').NAME",
    "calls __import__": "stolen = __import__('scipy.sparse.csgraph', fromlist=['x']).NAME",
    "compiles the import statement": "space = {}\n"
    "exec('from scipy.sparse.csgraph import NAME as stolen', space)\nstolen = space['stolen']",
    "pretends to be a library": "space = {}\n"
    "source = 'from scipy.sparse.csgraph import NAME as stolen'\n"
    "exec(compile(source, scipy.__file__, 'exec'), space)\nstolen = space['stolen']",
    "an attribute of the package": "stolen = scipy.sparse.csgraph.NAME",
    "the package's namespace": "stolen = vars(scipy.sparse)['csgraph'].NAME",
    "sys.modules": "stolen = sys.modules['scipy.sparse.csgraph'].NAME",
    "a submodule": "stolen = sys.modules['scipy.sparse.csgraph']._traversal.NAME",
    "a library that imported it": "stolen = sklearn.manifold._isomap.NAME",
    "another library": "import sklearn.manifold._spectral_embedding as other\nstolen = other.NAME",
    "the namespace of a library function": "fit = sklearn.manifold.Isomap._fit_transform\n"
    "stolen = fit.__globals__['NAME']",
    "the garbage collector": "import gc\ngc.unfreeze()\n"
    "named = [thing for thing in gc.get_objects() if getattr(thing, '__name__', '') == 'NAME']\n"
    "stolen = named[-1]",
    "a pickle": "import pickle\nstolen = pickle.loads(b'cscipy.sparse.csgraph\\nNAME\\n.')",
    "a name as a string": "import pkgutil\n"
    "stolen = pkgutil.resolve_name('scipy.sparse.csgraph:NAME')",
    "removes the module and imports it again": "sys.modules.pop('scipy.sparse.csgraph')\n"
    "stolen = get('scipy.sparse.csgraph').NAME",
    "reloads the module": "stolen = importlib.reload(sys.modules['scipy.sparse.csgraph']).NAME",
    "the use in a library": "def stolen(near):\n"
    "    sklearn.manifold.Isomap(n_neighbors=1).fit([[0, 0], [0, 1], [9, 9], [9, 8.5]])\n"
    "    return 1, [0, 0]",
}
# These attempts end with an ordinary Python error, without the lesson's message.
SILENT_ATTEMPTS = {
    "also removes the importer": "sys.modules.pop('scipy.sparse.csgraph')\n"
    "sys.meta_path[:] = [importlib.machinery.PathFinder]\n"
    "stolen = get('scipy.sparse.csgraph').NAME",
    "changes the importer's rules": "for finder in sys.meta_path: finder.modules = ()\n"
    "sys.modules.pop('scipy.sparse.csgraph')\nstolen = get('scipy.sparse.csgraph').NAME",
    "the compiled file": "import glob\n"
    "files = glob.glob(scipy.__path__[0] + '/sparse/csgraph/_traversal*.so')\n"
    "spec = importlib.util.spec_from_file_location('_traversal', files[0])\n"
    "stolen = importlib.util.module_from_spec(spec).NAME",
    "a new process": "import subprocess\n"
    "code = 'import numpy as np; from scipy.sparse.csgraph import NAME; '\n"
    "code += 'print(NAME(np.array([[0, 1], [0, 0]]))[1].tolist())'\n"
    "done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True)\n"
    "stolen = lambda near: (1, list(map(int, done.stdout.strip()[1:-1].split(','))))",
    "a fork": "read, write = os.pipe()\n"
    "if os.fork() == 0:\n"
    "    try:\n"
    "        sys.meta_path[:] = [importlib.machinery.PathFinder]\n"
    "        sys.modules.pop('scipy.sparse.csgraph', 0)\n"
    "        stolen = get('scipy.sparse.csgraph').NAME\n"
    "        os.write(write, bytes(stolen(NEAR)[1].tolist()))\n"
    "    finally:\n"
    "        os._exit(0)\n"
    "os.close(write)\n"
    "stolen = lambda near: (1, list(os.read(read, 99)) or [][0])",
}
# These attempts misuse the stand-in, so they do not work in a lesson that allows the module.
STAND_IN_ATTEMPTS = {
    "creates a stand-in with its metaclass": "stolen = lambda near: type.__call__(stand_in)(near)",
    "creates a stand-in without a call": "stolen = lambda near: stand_in.__new__(stand_in)(near)",
    "a subclass of a stand-in": "class Mine(stand_in): pass\nstolen = Mine",
    "inspects the stand-in": "stolen = stand_in.real",
}
ALL_ATTEMPTS = NOTICED_ATTEMPTS | SILENT_ATTEMPTS | STAND_IN_ATTEMPTS
# Each attempt runs in a separate process, because some of them would break later ones.
RUN_ATTEMPT = """
import importlib, importlib.machinery, importlib.util, os, sys
import numpy as np, scipy.sparse, sklearn.manifold
from importlib import import_module as get
NEAR = np.array([[0, 1], [0, 0]])
ATTEMPTS = {}
def f(name):
    read, write = os.pipe()
    if os.fork() == 0:
        try:
            said = "components: %s" % list(map(int, ATTEMPTS[name]()(NEAR)[1]))
        except BaseException as error:
            said = f"{type(error).__name__}: {error}"
        os.write(write, said.encode())
        os._exit(0)
    os.close(write)
    with open(read) as pipe:
        return pipe.read()
"""
SENTENCE = "scipy.sparse.csgraph is not allowed in this lesson: it does the exercise for you"


def results_of(attempts, lesson_name):
    """Return the result of each attempt: the components that it found, or its exception."""
    source = RUN_ATTEMPT
    for number, attempt in enumerate(attempts.values()):
        lines = ["stand_in = sklearn.manifold._isomap.NAME", *attempt.split("\n"), "return stolen"]
        source += function("\n".join(lines), f"attempt_{number}", "")
        source += f"ATTEMPTS[{list(attempts)[number]!r}] = attempt_{number}\n"
    source = source.replace("NAME", "connected_components")
    with attack_on(find_lesson(lesson_name), source) as student:
        return {name: student.f(name) for name in attempts}


@pytest.mark.slow
def test_every_detected_attempt_gets_the_same_message():
    ends = results_of(NOTICED_ATTEMPTS, "05_euclidean_clustering")
    assert ends == dict.fromkeys(NOTICED_ATTEMPTS, f"ImportError: {SENTENCE}")


@pytest.mark.slow
def test_no_attempt_reaches_the_forbidden_function():
    ends = results_of(ALL_ATTEMPTS, "05_euclidean_clustering")
    assert len(ends) == len(ALL_ATTEMPTS)
    assert {name: end for name, end in ends.items() if "Error: " not in end} == {}


@pytest.mark.slow
def test_every_attempt_works_if_the_lesson_allows_the_module():
    """These attempts reach an allowed module; otherwise, the tests above could not fail."""
    attempts = NOTICED_ATTEMPTS | SILENT_ATTEMPTS
    ends = results_of(attempts, "10_accelerated_clustering")
    assert ends == dict.fromkeys(attempts, "components: [0, 0]")
