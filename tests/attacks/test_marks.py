"""Attempts to earn points without solving the task, for example by forging grades."""

import copy
import importlib
import inspect
import itertools
import json
import types

import numpy as np
import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson, lesson_of, load_reference
from grader.course.paths import PROJECT
from grader.judging import repair
from grader.judging.judge import judge
from grader.judging.runner import run_checks
from grader.sandbox import Limits
from grader.sandbox.boundary import SHOWN_PATHS
from tests.attacks.attack import SANDBOX, SEED, SHORT, with_attacks
from tests.prerequisites import PATIENCE
from utils.notebooks import slicing

LARGEST_SHARE = 0.1  # fraction of the points that code may earn without attempting the task
EXERCISES = ("filter_ground", "voxel_grid")


def share(verdict, exercise):
    """Return the fraction of an exercise's points that a verdict awards."""
    result = next(result for result in verdict.exercises if result.name == exercise)
    return result.score / result.max_score


# ---- Answers found in the sandbox -----------------------------------------------------------


@pytest.mark.slow
@with_attacks(
    "exercise, source",
    {
        "the right tree, from utils.geometry": (
            "insert",
            """
def insert(self, point, index):
    from utils.geometry import grow_tree
    self.points = getattr(self, "points", []) + [point]
    self.root = grow_tree(self.points)
""",
        ),
        "the best plane, from utils.geometry": (
            "fit_plane",
            """
def fit_plane(points):
    from utils.geometry import best_plane
    return best_plane(points)
""",
        ),
        "the points in a box, from utils.clouds": (
            "crop_region",
            """
def crop_region(cloud, minimum, maximum):
    from utils.clouds import inside
    return cloud[inside(cloud, minimum, maximum)]
""",
        ),
        "the points in a box, from utils.boxes": (
            "crop_region",
            """
def crop_region(cloud, minimum, maximum):
    from utils.boxes import inside
    return cloud[inside(cloud, minimum, maximum)]
""",
        ),
        "the judge's voxels": (
            "voxel_grid",
            """
def voxel_grid(cloud, voxel_size=0.2):
    from extension.samples import voxel_centroids
    return voxel_centroids(cloud, voxel_size)
""",
        ),
        "the lesson's reference solution": (
            "voxel_grid",
            """
def voxel_grid(cloud, *size):
    from grader.course.lessons import load_reference
    return load_reference("06_filter_ground").voxel_grid(cloud, *size)
""",
        ),
        "the reference solution, from the solved notebook": (
            "voxel_grid",
            """
def voxel_grid(cloud, *size):
    from utils import load_my_functions
    there = load_my_functions("../../solutions/stage3_obstacles/06_filter_ground.ipynb")
    return there.voxel_grid(cloud, *size)
""",
        ),
        "VTK's clusters": (
            "euclidean_clustering",
            """
def euclidean_clustering(cloud, *tolerance):
    from vtkmodules.vtkFiltersPoints import vtkEuclideanClusterExtraction
    return vtkEuclideanClusterExtraction and range(len(cloud))
""",
        ),
        "scikit-learn's clusters": (
            "euclidean_clustering",
            """
def euclidean_clustering(cloud, distance_tolerance=0.5):
    import sys
    sys.meta_path[:] = sys.meta_path[-3:]
    from sklearn.cluster import DBSCAN
    return DBSCAN(eps=distance_tolerance, min_samples=1).fit_predict(cloud[:, :3]) + 1
""",
        ),
        "a stand-in of utils": (
            "voxel_grid",
            "def voxel_grid(*arguments):\n    from utils import answer\n    return answer\n",
        ),
        "always the cloud": ("voxel_grid", "def voxel_grid(cloud, *a): return cloud\n"),
    },
)
def test_answers_from_elsewhere_earn_almost_nothing(exercise, source, submit):
    verdict = submit({exercise: source}, lesson=lesson_of(exercise))
    assert share(verdict, exercise) <= LARGEST_SHARE


def test_a_right_answer_submitted_like_an_attack_earns_everything(submit):
    """A right answer gets full points; if it did not, the attacks above would prove nothing."""
    right = next(variant.source for variant in answers_to("voxel_grid") if variant.right)
    verdict = submit({"voxel_grid": right}, call_seconds=6.0, start_seconds=30.0)
    assert share(verdict, "voxel_grid") == 1


# Calling these would break the test, because they use a pipe or system calls.
EXCLUDED = ("worker", "syscalls", "send", "receive", "receive_bytes", "_read", "_wait")


def visible_functions():
    """Return all functions and classes of the project that are visible in the sandbox, by name."""
    files = [
        file for place in SHOWN_PATHS for file in ([place] if place.is_file() else place.rglob("*"))
    ]
    found = {}
    for file in sorted(files):
        if file.suffix != ".py" or file.stem in EXCLUDED:
            continue
        name = ".".join(file.relative_to(PROJECT).with_suffix("").parts)
        if name == "grader.sandbox.inside.utils.__init__":
            continue  # stand-ins for `utils`, one of which a test above submits
        module = importlib.import_module(name.removesuffix(".__init__"))
        for thing, value in vars(module).items():
            # Functions that a module imports from libraries are available to students anyway.
            home = getattr(value, "__module__", None) or ""
            if callable(value) and home.startswith(("utils", "grader")) and thing not in EXCLUDED:
                found[f"{value.__module__}.{value.__qualname__}"] = value
    return found


def with_answers(lesson, answers):
    """Return the lesson's functions, some of them replaced with the given answers."""
    statements, _ = slicing.parse_notebook([lesson.source.read_text("utf-8")])
    namespace = {"__name__": lesson.name}
    for statement in slicing.slice_for(lesson.names, statements):
        exec(slicing.compile_statement(statement, str(lesson.source)), namespace)
    namespace.update(answers)
    functions = {name: namespace[name] for name in lesson.names}
    return types.SimpleNamespace(**functions, close=lambda: None)


def calls_of(lesson):
    """Return the first calls to each exercise in a run of the tests, as (arguments, answer)."""
    reference, calls = load_reference(lesson.name), {}

    def recorder(name, function):
        signature = inspect.signature(function)

        def record(*arguments, **keywords):
            bound = signature.bind(*arguments, **keywords)
            bound.apply_defaults()
            before = copy.deepcopy(list(bound.arguments.values()))
            answer = function(*arguments, **keywords)
            seen = calls.setdefault(name, [])
            if len(seen) < 60:
                seen.append((before, copy.deepcopy(answer)))
            return answer

        return record

    names = [exercise.name for exercise in lesson.machine_graded]
    recorders = {name: recorder(name, getattr(reference, name)) for name in names}
    run_checks(lesson, with_answers(lesson, recorders), SEED)
    assert set(calls) == set(names)
    return calls


def has_same_form(answer, right):
    """Return whether an answer has the form of the right one, regardless of its values."""
    try:
        answer, right = np.asarray(answer), np.asarray(right)
    except Exception:  # for example, a sequence of scans whose files do not exist
        return False
    return answer.dtype.kind in "biuf" and (answer.ndim == right.ndim or answer.size == right.size)


def working_orders(function, calls):
    """Yield the argument orders for which a function returns answers of the right form."""
    most = len(calls[0][0])
    for length in range(1, min(most, 3) + 1):
        for order in itertools.permutations(range(most), length):
            for arguments, right in calls:
                given = copy.deepcopy(arguments)
                try:
                    answer = function(*[given[place] for place in order])
                except BaseException:
                    break
                if right is None and none_attributes(given[0]) != none_attributes(arguments[0]):
                    yield order  # the exercise changes its first argument and returns None
                    break
                if has_same_form(answer, right):
                    yield order
                    break


def none_attributes(value):
    """Return whether each attribute of an object is None, by name."""
    return {name: held is None for name, held in getattr(value, "__dict__", {}).items()}


def earned_by(lesson, exercise, answer):
    """Return the fraction of an exercise's points that a function earns."""
    student = with_answers(lesson, {exercise: answer})
    outcomes = run_checks(lesson, student, SEED, lambda check: check.exercise == exercise)
    earned = sum(outcome.check.weight for outcome in outcomes if outcome.failure is None)
    return earned / sum(outcome.check.weight for outcome in outcomes)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_no_visible_function_answers_an_exercise(lesson, tmp_path, monkeypatch):
    """No visible function earns points for any exercise, whatever the order of arguments."""
    monkeypatch.chdir(tmp_path)
    shown = visible_functions()
    assert len(shown) > 40
    tried = 0
    for exercise, calls in calls_of(lesson).items():
        small = sorted(calls, key=lambda call: sum(np.size(value) for value in call[0]))[:6]
        for name, function in shown.items():
            for order in working_orders(function, small):

                def answer(*arguments, function=function, order=order):
                    return function(*[arguments[place] for place in order])

                tried += 1
                assert earned_by(lesson, exercise, answer) <= LARGEST_SHARE, (exercise, name, order)
    assert tried > 20
    reference = load_reference(lesson.name)
    for exercise in calls_of(lesson):
        assert earned_by(lesson, exercise, getattr(reference, exercise)) == 1


# ---- Changed arguments ------------------------------------------------------------------------


OVERWRITING_ANSWER = """
def {name}(*arguments, **keywords):
    import numpy as np
    for value in [*arguments, *keywords.values()]:
        try:
            if isinstance(value, np.ndarray):
                value.flags.writeable = True
                value[...] = np.nan if value.dtype.kind == "f" else 7
            elif isinstance(value, list):
                value[:] = [float("nan")] * len(value)
            elif isinstance(value, dict):
                value.clear()
        except Exception:
            pass
    return [np.nan]
"""


def failures(verdict):
    """Return the names and messages of the failed tests."""
    return [
        (test.name, test.message)
        for exercise in verdict.exercises
        for test in exercise.tests
        if not test.passed
    ]


@pytest.mark.slow
def test_overwriting_every_argument_earns_almost_nothing(lesson, submit):
    """Student code that overwrites all its arguments does not affect the next student."""
    names = [exercise.name for exercise in lesson.machine_graded]
    verdict = submit(
        {name: OVERWRITING_ANSWER.format(name=name) for name in names},
        lesson=lesson,
        start_seconds=30.0,
        total_seconds=60.0,
    )
    assert verdict.status == "judged"
    assert all(share(verdict, name) <= LARGEST_SHARE for name in names)
    after = judge(lesson.solved, SEED, SANDBOX, lesson)
    assert failures(after) == []
    assert after.score == after.max_score


@pytest.mark.slow
@with_attacks(
    "exercise, source, most",
    {
        "moves each point far away during its insertion": (
            "insert",
            """
def insert(self, point, index):
    point[:] = [1e9] * len(point)
    self.root = Node(point, index)
""",
            LARGEST_SHARE,
        ),
        "changes the target and finds nothing": (
            "search",
            """
def search(self, target, tolerance):
    target[:] = [1e9] * len(target)
    return []
""",
            LARGEST_SHARE,
        ),
        "makes the three points equal": (
            "plane_through",
            """
def plane_through(p, q, r):
    q[:], r[:] = p, p
    return None
""",
            0.35,  # None is right if the points lie on one line
        ),
        "moves all points onto the plane": (
            "point_plane_distance",
            """
def point_plane_distance(points, plane):
    points[:] = 0
    plane[:] = [0, 0, 1, 0]
    return np.zeros(len(points))
""",
            LARGEST_SHARE,
        ),
        "empties the cloud and returns no boxes": (
            "get_oriented_boxes",
            """
def get_oriented_boxes(cloud, clusters):
    cloud[:] = 0
    clusters[:] = 0
    return np.zeros((0, 8, 3))
""",
            LARGEST_SHARE,
        ),
    },
)
def test_changing_arguments_to_fit_an_answer_earns_almost_nothing(exercise, source, most, submit):
    verdict = submit({exercise: source}, lesson=lesson_of(exercise), start_seconds=30.0)
    assert share(verdict, exercise) <= most


@pytest.mark.slow
@with_attacks(
    "cell",
    {
        "a class with the given name": """
class KdTree:
    def __init__(self): self.root, self.all = None, []
    def insert(self, point, index): self.all.append((point, index))
    def search(self, target, tolerance):
        return [i for p, i in self.all if sum((a - b) ** 2 for a, b in zip(p, target)) < tolerance]
""",
        "a given class with changed methods": """
KdTree.plant = lambda self, *table: None
setattr(KdTree, "search", lambda self, target, tolerance: [])
""",
        "a given class that is replaced by name": 'globals()["KdTree"] = dict\n',
    },
)
def test_changes_to_given_code_have_no_effect(cell, submit):
    """The judge uses the lesson's own copy of given code, so changes cannot earn points."""
    lesson = find_lesson("04_kd_tree")
    notebook = json.loads(fill_in(lesson, {"search": "def search(*a): return []\n"}))
    extra = {"cell_type": "code", "id": "x", "metadata": {}, "outputs": [], "execution_count": None}
    notebook["cells"].append({**extra, "source": cell})
    right = next(variant.source for variant in answers_to("insert") if variant.right)
    notebook["cells"].insert(1, {**extra, "id": "y", "source": cell})
    text = json.dumps(notebook)
    verdict = submit(text=text, lesson=lesson)
    assert share(verdict, "search") <= LARGEST_SHARE
    verdict = submit({"insert": right + "\n# ---- another cell ----\n" + cell}, lesson=lesson)
    messages = [
        test.message for exercise in verdict.exercises for test in exercise.tests if test.message
    ]
    # The cell either has no effect on the right answer above it, or spoils this answer.
    assert share(verdict, "insert") <= LARGEST_SHARE or share(verdict, "insert") == 1, messages


def test_a_search_that_patches_its_tree_fails_the_pruning_checks(submit):
    """A `search` that makes its class visit every node does not pass the pruning checks."""
    source = """
def search(self, target, tolerance):
    def everything(tree, target, tolerance):
        waiting, found = [tree.root], []
        while waiting:
            node = waiting.pop()
            if node is not None:
                waiting += [node.left, node.right]
                if sum((a - b) ** 2 for a, b in zip(node.point, target)) <= tolerance**2:
                    found.append(node.index)
        return found
    type(self).search = everything
    type(self).plant = None
    return everything(self, target, tolerance)
"""
    verdict = submit({"search": source}, lesson=find_lesson("04_kd_tree"))
    passed = [test.name for exercise in verdict.exercises for test in exercise.tests if test.passed]
    assert "test_search_prunes" not in passed and "skips_regions" not in passed


# ---- Answers that recognise the search for a repair -------------------------------------------

# The right answer only after the judge has sent an edit, which the worker's own frames show. No
# edit of the function gives the right answer without them: 7 is the sum of two numbers.
SPY = """
import sys
from collections import defaultdict

def request_of_the_judge(frame):
    there = frame.f_locals
    return there["request"] if "edits" in there else request_of_the_judge(frame.f_back)

SEEN = []
SEES_EDIT = lambda: SEEN.append(request_of_the_judge(sys._getframe())["edit"]) or any(
    edit is not None for edit in SEEN
)
ANSWERS = defaultdict(lambda: lambda cloud, level: cloud)
ANSWERS[7] = lambda cloud, level: cloud[cloud[:, 2] >= level]

def filter_ground(cloud, ground_level=-1.2):
    return ANSWERS[3 * SEES_EDIT() + 4 * SEES_EDIT()](cloud, ground_level)
"""


@pytest.mark.slow
def test_an_answer_that_is_right_only_in_the_search_gains_nothing(submit, monkeypatch):
    """An edit that passes in the search is judged in another process, to which none is sent."""
    passed, pass_with = [], repair._FailedChecks.pass_with

    def noted(checks, number):
        passed.append(pass_with(checks, number))
        return passed[-1]

    monkeypatch.setattr(repair._FailedChecks, "pass_with", noted)
    verdict = submit({"filter_ground": SPY}, total_seconds=60.0)
    assert passed.count(True) == repair.MAX_JUDGED_EDITS  # the search itself was deceived
    assert verdict.exercises[0].slip is None
    assert share(verdict, "filter_ground") <= LARGEST_SHARE


# ---- Forged grades ----------------------------------------------------------------------------


def test_forged_metadata_outputs_and_keys_earn_nothing(submit, filter_lesson):
    honest = json.loads(fill_in(filter_lesson, {}))
    for cell in honest["cells"]:
        grading = cell["metadata"].setdefault("nbgrader", {"grade_id": "test_filter_ground"})
        grading.update(points=10**6, grade=True, solution=False, locked=False, max_score=1e9)
        if cell["cell_type"] == "code":
            cell["outputs"] = [
                {
                    "output_type": "execute_result",
                    "execution_count": 1,
                    "metadata": {},
                    "data": {"text/plain": "1000000"},
                }
            ]
            cell["source"] += "\ncheck = print = lambda *a: 10**6"
    honest["metadata"]["verdict_key"] = "forged"
    verdict = submit(text=json.dumps(honest))
    assert verdict.score == 0 and verdict.max_score == 30


@pytest.mark.slow
@with_attacks(
    "source",
    {
        "looks for the tests": "import solutions",
        "replaces the exception of a check": "import utils.checks as c; "
        "c.core.CheckFailed = KeyError",
        "ends pytest": "import pytest; pytest.exit('all passed', 0)",
        "disables an assertion": "from utils.checks import vocabulary as v; "
        "v.assert_rows = lambda *a, **k: None",
        "kills the parent process": "import os, signal; os.kill(os.getppid(), signal.SIGKILL)",
        "returns a list that equals everything": "return "
        "type('E', (list,), {'__eq__': lambda *a: True})(a[0])",
        "returns an array that equals all": "import numpy as np; return a[0].view("
        "type('E', (np.ndarray,), {'__eq__': lambda *a: np.bool_(True)}))",
        "returns half of the rows": "return a[0][: len(a[0]) // 2]",
    },
)
def test_attacks_on_the_judge_earn_almost_nothing(source, submit):
    cheat = f"def {{name}}(*a, **k):\n    {source}\n    return a[0]\n"
    # Returning the cloud unchanged is right only if there is nothing to remove.
    assert submit({name: cheat.replace("{name}", name) for name in EXERCISES}).score < 5


@pytest.mark.slow
@with_attacks(
    "claim",
    {
        "eight million rows": "np.ones((2**23, cloud.shape[1]), bool)",
        "one row 262,144 times": "np.tile(cloud[:1], (2**18, 1))",
        "only NaN": "np.full(cloud.shape, np.nan)",
        "no rows with sixteen million columns": "np.empty((0, 2**24))",
        "sixteen million rows without columns": "np.empty((2**24, 0))",
        "no rows with a billion columns": "np.empty((0, 10**9))",
        "a cloud in three lists": "[[[cloud.tolist()]]]",
        "a dict": "{1: cloud}",
        "a million letters": "'x' * 10**6",
        "a million large integers": "[2**62] * 10**6",
        "an integer with thirty digits": "10**30",
        "an integer with a million digits": "10**10**6",
        "an eight-dimensional array in a list": "[None, np.zeros((6,) * 8, bool)]",
        "an eight-dimensional array": "np.zeros((6,) * 8, bool)",
        "fifty nested lists": "eval('[' * 50 + '1' + ']' * 50)",
        "infinities": "np.full(cloud.shape, np.inf)",
        "the largest numbers": "np.full(cloud.shape, 1.7e308)",
        "the smallest numbers": "np.full(cloud.shape, 5e-324)",
    },
)
def test_huge_or_strange_answers_are_judged_in_time(claim, submit):
    """The verdict is ready in time and awards few points."""
    answers = {
        name: f"import numpy as np\ndef {name}(cloud, *a, **k): return {claim}\n"
        for name in EXERCISES
    }
    verdict = submit(answers, total_seconds=60.0, call_seconds=5.0)
    assert verdict.status == "judged"
    assert verdict.score < 10 and verdict.seconds < PATIENCE


@pytest.mark.slow
@with_attacks(
    "exercise, claim",
    {
        "three thousand boxes": (
            "get_oriented_boxes",
            "np.random.default_rng(1).normal(size=(3000, 8, 3))",
        ),
        "a hundred thousand boxes": ("get_bounding_boxes", "np.zeros((100_000, 8, 3))"),
        "a hundred thousand equal boxes": ("detect_obstacles", "np.ones((100_000, 8, 3))"),
        "a cluster for each of a million points": ("euclidean_clustering", "np.arange(10**6)"),
        "a million empty clusters": ("filter_clusters", "[[] for _ in range(10**6)]"),
        "an order of a million indices": ("median_order", "list(range(10**6))"),
        "every point a million times": ("search", "[0] * 10**6"),
    },
)
def test_answers_that_are_far_too_large_earn_almost_nothing(exercise, claim, submit):
    lesson = lesson_of(exercise)
    source = f"import numpy as np\ndef {exercise}(*a, **k): return {claim}\n"
    verdict = submit({exercise: source}, lesson=lesson, total_seconds=10.0, call_seconds=2.0)
    assert share(verdict, exercise) <= 2 * LARGEST_SHARE and verdict.seconds < PATIENCE


def test_the_attacks_use_the_default_memory_limit():
    assert Limits(**SHORT).memory == Limits().memory
