"""`check()` refuses what the judge refuses, and allows what it allows."""

import contextlib

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson, load_reference
from grader.intake.notebook import read_notebook
from grader.judging.judge import judge
from tests.students import answers_in
from utils.checks import check
from utils.checks.core import ChecksFailed

FIVE = ("05_euclidean_clustering", "euclidean_clustering")
TEN = ("10_accelerated_clustering", "euclidean_clustering_accelerated")
# What does the exercise of lesson 05, in all the ways in which one may write it.
DONE_BY_A_LIBRARY = {
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
BY_A_GRAPH = {
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


GROWN = """
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


def grown(imported, prepare, neighbours):
    """The exercise of lesson 05, with neighbours that a library finds."""
    source = GROWN.replace("IMPORT", imported).replace("PREPARE", prepare)
    return source.replace("NEIGHBOURS", neighbours)


BELOW = "np.nextafter(threshold, 0)"
QUERY = f"tree.query_radius(points[[waiting.pop()]], {BELOW})[0]"
FAR = "np.linalg.norm(points - points[waiting.pop()], axis=1)"
# A neighbour search is allowed; these libraries import what is forbidden for other purposes.
SEARCHES = {
    "scikit-learn's tree": grown(
        "from sklearn.neighbors import KDTree", "tree = KDTree(points)", QUERY
    ),
    "scikit-learn's tree, inside": grown(
        "", "from sklearn.neighbors import KDTree\n    tree = KDTree(points)", QUERY
    ),
    "scikit-learn's neighbours": grown(
        "from sklearn.neighbors import NearestNeighbors",
        f"tree = NearestNeighbors(radius={BELOW}).fit(points)",
        "tree.radius_neighbors(points[[waiting.pop()]])[1][0]",
    ),
    "SciPy's tree": grown(
        "from scipy.spatial import cKDTree",
        "tree = cKDTree(points)",
        f"tree.query_ball_point(points[waiting.pop()], {BELOW})",
    ),
    "a library that is not used": grown(
        "from sklearn.mixture import GaussianMixture\nfrom scipy import stats",
        "stats.norm.cdf(0.0)",
        f"np.flatnonzero({FAR} < threshold)",
    ),
}
# What these use does the exercise, and is had from a library, or used by one.
BY_A_LIBRARY_INSIDE = {
    "a name in a library": (
        grown(
            "import sklearn.manifold._isomap as library\nfrom scipy.spatial.distance import cdist",
            "return library.connected_components(cdist(points, points) < threshold)[1] + 1",
            "[]",
        ),
        "scipy.sparse.csgraph",
    ),
    "a name in a library, imported inside": (
        grown(
            "from scipy.spatial.distance import cdist",
            "import sklearn.manifold._isomap as library\n"
            "    return library.connected_components(cdist(points, points) < threshold)[1] + 1",
            "[]",
        ),
        "scipy.sparse.csgraph",
    ),
    "a library that uses one": (
        grown(
            "from sklearn.mixture import GaussianMixture",
            "GaussianMixture(1).fit(np.arange(9.0).reshape(-1, 1))",
            f"np.flatnonzero({FAR} < threshold)",
        ),
        "sklearn.cluster",
    ),
    "a library that imports it when it is used": (
        grown(
            "from sklearn.preprocessing import KBinsDiscretizer",
            "KBinsDiscretizer(2, strategy='kmeans').fit(np.arange(9.0).reshape(-1, 1))",
            f"np.flatnonzero({FAR} < threshold)",
        ),
        "sklearn.cluster",
    ),
    "the modules there are": (
        grown(
            "import sys\nimport sklearn.mixture",
            "tools = sklearn.mixture and sys.modules['sklearn.cluster']\n"
            "    return tools.DBSCAN(eps=threshold, min_samples=1).fit(points).labels_ + 1",
            "[]",
        ),
        "sklearn.cluster",
    ),
    "the importer": (
        grown(
            "import importlib",
            "tools = importlib.import_module('sklearn.cluster')\n"
            "    return tools.DBSCAN(eps=threshold, min_samples=1).fit(points).labels_ + 1",
            "[]",
        ),
        "sklearn.cluster",
    ),
}


def shown_by_check(name, source, capsys):
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


@pytest.mark.parametrize("way", DONE_BY_A_LIBRARY | BY_A_GRAPH)
def test_what_does_the_exercise_is_refused_in_05(way, sandbox, tmp_path, capsys):
    source = (DONE_BY_A_LIBRARY | BY_A_GRAPH)[way]
    shown = shown_by_check(FIVE[1], source, capsys)
    assert "not allowed in this lesson" in shown and "[passed]" not in shown
    score, said = score_of(*FIVE, source, sandbox, tmp_path)
    assert score == 0 and "not allowed in this lesson" in said
    assert "spelt" not in said, "a name that is refused is no typing mistake"


@pytest.mark.slow
@pytest.mark.parametrize("way", SEARCHES)
def test_a_search_for_neighbours_earns_everything_in_05(way, sandbox, tmp_path, capsys):
    shown = shown_by_check(FIVE[1], SEARCHES[way], capsys)
    assert "[passed]" in shown and "[failed]" not in shown
    assert score_of(*FIVE, SEARCHES[way], sandbox, tmp_path) == (40, "()['']")


@pytest.mark.slow
@pytest.mark.parametrize("way", BY_A_LIBRARY_INSIDE)
def test_what_a_library_holds_is_refused_in_05(way, sandbox, tmp_path, capsys):
    """At the first `check`, which has libraries imported, and at the next."""
    source, module = BY_A_LIBRARY_INSIDE[way]
    sentence = "not allowed in this lesson: it does the exercise for you"
    for _ in range(2):
        shown = shown_by_check(FIVE[1], source, capsys)
        assert f"{module}, which is {sentence}" in shown and "[passed]" not in shown
    score, said = score_of(*FIVE, source, sandbox, tmp_path)
    assert score == 0 and f"{module} is {sentence}" in said


@pytest.mark.parametrize("way", DONE_BY_A_LIBRARY)
def test_what_does_the_exercise_is_refused_in_10(way, sandbox, tmp_path, capsys):
    source = DONE_BY_A_LIBRARY[way]
    shown = shown_by_check(TEN[1], source, capsys)
    assert "not allowed in this lesson" in shown and "[passed]" not in shown
    score, said = score_of(*TEN, source, sandbox, tmp_path)
    assert score == 0 and "not allowed in this lesson" in said


@pytest.mark.slow
@pytest.mark.parametrize("way", BY_A_GRAPH)
def test_connected_components_are_allowed_in_10(way, sandbox, tmp_path, capsys):
    """They list all pairs, and lose what that costs, but nobody refuses them."""
    shown = shown_by_check(TEN[1], BY_A_GRAPH[way], capsys)
    assert "not allowed" not in shown
    assert "[passed] Finds the one close pair of two crowded cells" in shown
    score, said = score_of(*TEN, BY_A_GRAPH[way], sandbox, tmp_path)
    assert score > 10 and "not allowed" not in said


def test_the_lessons_own_tools_pass_all_checks_of_10(tmp_path, capsys):
    """Its plan, with the `components` that a cell above the exercise gives."""
    lesson = find_lesson(TEN[0])
    plan = next(variant.source for variant in answers_to(TEN[1]) if variant.right)
    path = tmp_path / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, {TEN[1]: plan}), "utf-8")
    function = answers_in(lesson, read_notebook(path).code)[TEN[1]]
    assert "connected_components" in function.__globals__["components"].__code__.co_names
    check(function)
    assert "failed" not in capsys.readouterr().out


# ---- what costs no points ----------------------------------------------------------------------

CHANGED = {
    "labels of another type": (
        "def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold) * 1.0\n",
        ["whole numbers by type"],
    ),
    "another order": (
        "def NAME(cloud, threshold=0.5):\n"
        "    labels = right(cloud, threshold)\n"
        "    return labels.max(initial=0) + 1 - labels\n",
        ["as they first appear"],
    ),
    "at the threshold, too": (
        "def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold * (1 + 1e-9))\n",
        ["exactly at the threshold"],
    ),
    "nothing": ("def NAME(cloud, threshold=0.5):\n    return right(cloud, threshold)\n", []),
}


@pytest.mark.parametrize("lesson_name, name", [FIVE, TEN])
@pytest.mark.parametrize("change", CHANGED)
def test_what_costs_no_points_is_a_note(lesson_name, name, change, capsys):
    source, titles = CHANGED[change]
    space = {"right": getattr(load_reference(lesson_name), name), "__name__": "__main__"}
    exec(source.replace("NAME", name), space)
    check(space[name])
    shown = capsys.readouterr().out
    assert "[failed]" not in shown and shown.count("[note]") == len(titles)
    assert all(title in shown for title in titles)
