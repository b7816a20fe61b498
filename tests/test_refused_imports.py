"""`check` refuses and allows the same libraries as the judge."""

import contextlib

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson, load_reference
from grader.intake.notebook import read_notebook
from grader.judging.judge import judge
from tests.students import answers_in
from utils.checks import check
from utils.checks.core import ChecksFailed

LESSON_05 = ("05_euclidean_clustering", "euclidean_clustering")
LESSON_10 = ("10_accelerated_clustering", "euclidean_clustering_accelerated")
# Answers to lesson 05 in which a library does the clustering, written in several ways.
CLUSTERING_LIBRARIES = {
    "scikit-learn": """
from sklearn.cluster import DBSCAN
def NAME(cloud, threshold=0.5):
    return DBSCAN(eps=threshold, min_samples=1).fit(cloud[:, :3]).labels_ + 1
""",
    "scikit-learn, inside": """
def NAME(cloud, threshold=0.5):
    import sklearn.cluster as tools
    return tools.DBSCAN(eps=threshold, min_samples=1).fit(cloud[:, :3]).labels_ + 1
""",
    "SciPy's hierarchy": """
from scipy.cluster.hierarchy import fclusterdata
def NAME(cloud, threshold=0.5):
    return fclusterdata(cloud[:, :3], threshold, criterion="distance", method="single")
""",
}
GRAPH_COMPONENTS = {
    "connected components": """
import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist
def NAME(cloud, threshold=0.5):
    near = cdist(cloud[:, :3], cloud[:, :3]) < threshold
    return connected_components(near, directed=False)[1] + 1 if len(cloud) else np.zeros(0, int)
""",
    "connected components, through the package": """
import numpy as np
import scipy.sparse
from scipy.spatial.distance import cdist
def NAME(cloud, threshold=0.5):
    near = cdist(cloud[:, :3], cloud[:, :3]) < threshold
    if len(cloud) == 0:
        return np.zeros(0, int)
    return scipy.sparse.csgraph.connected_components(near, directed=False)[1] + 1
""",
    "connected components, with a helper": """
import numpy as np
from scipy.sparse import csgraph
from scipy.spatial.distance import cdist
def pieces(near):
    return csgraph.connected_components(near, directed=False)[1] + 1
def NAME(cloud, threshold=0.5):
    return pieces(cdist(cloud[:, :3], cloud[:, :3]) < threshold) if len(cloud) else np.zeros(0, int)
""",
}


GROWING = """
import numpy as np
IMPORT
def NAME(cloud, threshold=0.5):
    points, labels, count = np.asarray(cloud)[:, :3], np.zeros(len(cloud), int), 0
    if not len(points):
        return labels
    PREPARE
    for seed in range(len(points)):
        if labels[seed]:
            continue
        count += 1
        labels[seed], waiting = count, [seed]
        while waiting:
            near = NEIGHBOURS
            new = [other for other in near if not labels[other]]
            labels[new] = count
            waiting += new
    return labels
"""


def growing_answer(imported, prepare, neighbours):
    """Return an answer to lesson 05 that grows clusters; `neighbours` is an expression."""
    source = GROWING.replace("IMPORT", imported).replace("PREPARE", prepare)
    return source.replace("NEIGHBOURS", neighbours)


BELOW = "np.nextafter(threshold, 0)"
QUERY = f"tree.query_radius(points[[waiting.pop()]], {BELOW})[0]"
DISTANCES = "np.linalg.norm(points - points[waiting.pop()], axis=1)"
# Neighbour searches are allowed, although their libraries import forbidden modules internally.
SEARCHES = {
    "scikit-learn's tree": growing_answer(
        "from sklearn.neighbors import KDTree", "tree = KDTree(points)", QUERY
    ),
    "scikit-learn's tree, inside": growing_answer(
        "", "from sklearn.neighbors import KDTree\n    tree = KDTree(points)", QUERY
    ),
    "scikit-learn's neighbours": growing_answer(
        "from sklearn.neighbors import NearestNeighbors",
        f"tree = NearestNeighbors(radius={BELOW}).fit(points)",
        "tree.radius_neighbors(points[[waiting.pop()]])[1][0]",
    ),
    "SciPy's tree": growing_answer(
        "from scipy.spatial import cKDTree",
        "tree = cKDTree(points)",
        f"tree.query_ball_point(points[waiting.pop()], {BELOW})",
    ),
    "a library that is not used": growing_answer(
        "from sklearn.mixture import GaussianMixture\nfrom scipy import stats",
        "stats.norm.cdf(0.0)",
        f"np.flatnonzero({DISTANCES} < threshold)",
    ),
}
# Answers that use a forbidden module through another library, and the module that is named.
INDIRECT_IMPORTS = {
    "a name in a library": (
        growing_answer(
            "import sklearn.manifold._isomap as library\nfrom scipy.spatial.distance import cdist",
            "return library.connected_components(cdist(points, points) < threshold)[1] + 1",
            "[]",
        ),
        "scipy.sparse.csgraph",
    ),
    "a name in a library, imported inside": (
        growing_answer(
            "from scipy.spatial.distance import cdist",
            "import sklearn.manifold._isomap as library\n"
            "    return library.connected_components(cdist(points, points) < threshold)[1] + 1",
            "[]",
        ),
        "scipy.sparse.csgraph",
    ),
    "a library that uses one": (
        growing_answer(
            "from sklearn.mixture import GaussianMixture",
            "GaussianMixture(1).fit(np.arange(9.0).reshape(-1, 1))",
            f"np.flatnonzero({DISTANCES} < threshold)",
        ),
        "sklearn.cluster",
    ),
    "a library that imports it when it is used": (
        growing_answer(
            "from sklearn.preprocessing import KBinsDiscretizer",
            "KBinsDiscretizer(2, strategy='kmeans').fit(np.arange(9.0).reshape(-1, 1))",
            f"np.flatnonzero({DISTANCES} < threshold)",
        ),
        "sklearn.cluster",
    ),
    "the loaded modules": (
        growing_answer(
            "import sys\nimport sklearn.mixture",
            "tools = sklearn.mixture and sys.modules['sklearn.cluster']\n"
            "    return tools.DBSCAN(eps=threshold, min_samples=1).fit(points).labels_ + 1",
            "[]",
        ),
        "sklearn.cluster",
    ),
    "the importer": (
        growing_answer(
            "import importlib",
            "tools = importlib.import_module('sklearn.cluster')\n"
            "    return tools.DBSCAN(eps=threshold, min_samples=1).fit(points).labels_ + 1",
            "[]",
        ),
        "sklearn.cluster",
    ),
}


def check_output(name, source, capsys):
    space = {"__name__": "__main__"}
    exec(source.replace("NAME", name), space)
    with contextlib.suppress(ChecksFailed):
        check(space[name])
    return capsys.readouterr().out


def score_of(lesson_name, name, source, sandbox, tmp_path):
    lesson = find_lesson(lesson_name)
    path = tmp_path / f"{lesson_name}.ipynb"
    path.write_text(fill_in(lesson, {name: source.replace("NAME", name)}), "utf-8")
    verdict = judge(path, 1, sandbox)
    return verdict.score, str(verdict.problems) + str(
        [exercise.cause for exercise in verdict.exercises]
    )


@pytest.mark.parametrize("way", CLUSTERING_LIBRARIES | GRAPH_COMPONENTS)
def test_a_library_that_does_the_clustering_is_refused_in_lesson_05(way, sandbox, tmp_path, capsys):
    source = (CLUSTERING_LIBRARIES | GRAPH_COMPONENTS)[way]
    output = check_output(LESSON_05[1], source, capsys)
    assert "not allowed in this lesson" in output and "[passed]" not in output
    score, reasons = score_of(*LESSON_05, source, sandbox, tmp_path)
    assert score == 0 and "not allowed in this lesson" in reasons
    assert "Check the spelling" not in reasons, "a refused name is not a typing mistake"


@pytest.mark.slow
@pytest.mark.parametrize("way", SEARCHES)
def test_a_search_for_neighbours_earns_everything_in_lesson_05(way, sandbox, tmp_path, capsys):
    output = check_output(LESSON_05[1], SEARCHES[way], capsys)
    assert "[passed]" in output and "[failed]" not in output
    assert score_of(*LESSON_05, SEARCHES[way], sandbox, tmp_path) == (40, "()['']")


@pytest.mark.slow
@pytest.mark.parametrize("way", INDIRECT_IMPORTS)
def test_a_forbidden_module_inside_a_library_is_refused_in_lesson_05(
    way, sandbox, tmp_path, capsys
):
    """The second `check` also refuses the answer, although the libraries are already imported."""
    source, module = INDIRECT_IMPORTS[way]
    sentence = "not allowed in this lesson: it does the exercise for you"
    for _ in range(2):
        output = check_output(LESSON_05[1], source, capsys)
        assert f"{module}, which is {sentence}" in output and "[passed]" not in output
    score, reasons = score_of(*LESSON_05, source, sandbox, tmp_path)
    assert score == 0 and f"{module} is {sentence}" in reasons


@pytest.mark.parametrize("way", CLUSTERING_LIBRARIES)
def test_a_library_that_does_the_clustering_is_refused_in_lesson_10(way, sandbox, tmp_path, capsys):
    source = CLUSTERING_LIBRARIES[way]
    output = check_output(LESSON_10[1], source, capsys)
    assert "not allowed in this lesson" in output and "[passed]" not in output
    score, reasons = score_of(*LESSON_10, source, sandbox, tmp_path)
    assert score == 0 and "not allowed in this lesson" in reasons


@pytest.mark.slow
@pytest.mark.parametrize("way", GRAPH_COMPONENTS)
def test_connected_components_are_allowed_in_lesson_10(way, sandbox, tmp_path, capsys):
    """Answers that list all pairs take too long and lose points, but they are not refused."""
    output = check_output(LESSON_10[1], GRAPH_COMPONENTS[way], capsys)
    assert "not allowed" not in output
    assert "[passed] Finds the only close pair of points in two crowded cells" in output
    score, reasons = score_of(*LESSON_10, GRAPH_COMPONENTS[way], sandbox, tmp_path)
    assert score > 10 and "not allowed" not in reasons


def test_answers_with_the_lessons_own_tools_pass_all_checks_of_lesson_10(tmp_path, capsys):
    """A right answer may call `components`, which a cell above the exercise defines."""
    lesson = find_lesson(LESSON_10[0])
    answer = next(answer.source for answer in answers_to(LESSON_10[1]) if answer.right)
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, {LESSON_10[1]: answer}), "utf-8")
    function = answers_in(lesson, read_notebook(path).code)[LESSON_10[1]]
    assert "connected_components" in function.__globals__["components"].__code__.co_names
    check(function)
    assert "failed" not in capsys.readouterr().out


# ---- deviations that cost no points ------------------------------------------------------------

NOTED_CHANGES = {
    "labels of another type": (
        "def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold) * 1.0\n",
        ["integer type"],
    ),
    "another order": (
        "def NAME(cloud, threshold=0.5):\n"
        "    labels = right(cloud, threshold)\n"
        "    return labels.max(initial=0) + 1 - labels\n",
        ["Numbers the clusters"],
    ),
    "at the threshold, too": (
        "def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold * (1 + 1e-9))\n",
        ["exactly"],
    ),
    "nothing": ("def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold)\n", []),
}


@pytest.mark.parametrize("lesson_name, name", [LESSON_05, LESSON_10])
@pytest.mark.parametrize("change", NOTED_CHANGES)
def test_deviations_that_cost_no_points_get_notes(lesson_name, name, change, capsys):
    source, titles = NOTED_CHANGES[change]
    space = {"right": getattr(load_reference(lesson_name), name), "__name__": "__main__"}
    exec(source.replace("NAME", name), space)
    check(space[name])
    output = capsys.readouterr().out
    assert "[failed]" not in output and output.count("[note]") == len(titles)
    assert all(title in output for title in titles)
