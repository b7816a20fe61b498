"""`check` accepts only the judge's packages, and prints the judge's message about others."""

import importlib
import sys

import pytest

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.judging.judge import judge
from utils.checks import check, static_analysis
from utils.checks.core import ChecksFailed
from utils.in_sandbox import ABSENT

SHAPELY = """
import numpy as np
from shapely import MultiPoint
def get_oriented_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        outline = MultiPoint(points[:, :2]).minimum_rotated_rectangle
        if outline.geom_type == "Polygon":
            corners = np.array(outline.exterior.coords)[:4]
        else:
            ends = np.array(outline.coords)
            corners = ends[[0, 0, -1, -1]]
        low, high = points[:, 2].min(), points[:, 2].max()
        boxes.append([[*corner, z] for z in (low, high) for corner in corners])
    return np.array(boxes).reshape(-1, 8, 3)
"""
DISTANCES = """
import numpy as np
from sklearn.metrics import pairwise_distances
def filter_by_distance(cloud, distance=10.0):
    if len(cloud) == 0:
        return cloud[:0]
    return cloud[pairwise_distances(cloud[:, :2], np.zeros((1, 2)))[:, 0] <= distance]
"""
PROGRESS_BAR = """
import numpy as np
from tqdm.{module} import tqdm
def filter_clusters(cluster_labels, min_num_points=100):
    kept = cluster_labels.copy()
    for label in tqdm(np.unique(cluster_labels)):
        if np.count_nonzero(cluster_labels == label) < min_num_points:
            kept[cluster_labels == label] = 0
    return kept
"""
ANSWERS = {"11_pca_boxes": ("get_oriented_boxes", SHAPELY)}
ANSWERS["09_filter_clusters"] = ("filter_clusters", PROGRESS_BAR.format(module="auto"))
ANSWERS["07_filter_by_distance"] = ("filter_by_distance", DISTANCES)


def judge_answers(lesson_name, answers, folder, sandbox):
    lesson = find_lesson(lesson_name)
    path = folder / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, answers), "utf-8")
    verdict = judge(path, 1, sandbox)
    return verdict, {exercise.name: exercise for exercise in verdict.exercises}


@pytest.mark.parametrize("lesson_name", ANSWERS)
def test_check_and_judge_accept_a_right_answer_that_uses_an_installed_package(
    lesson_name, tmp_path, sandbox
):
    name, source = ANSWERS[lesson_name]
    namespace = {"__name__": "__main__"}
    exec(source, namespace)
    check(namespace[name])
    _, results = judge_answers(lesson_name, {name: source}, tmp_path, sandbox)
    assert results[name].score == results[name].max_score


def test_a_progress_bar_for_notebooks_needs_no_widgets_in_the_judge(tmp_path, sandbox):
    answers = {"filter_clusters": PROGRESS_BAR.format(module="notebook")}
    _, results = judge_answers("09_filter_clusters", answers, tmp_path, sandbox)
    assert results["filter_clusters"].score == results["filter_clusters"].max_score


@pytest.fixture
def foreign_package(tmp_path, monkeypatch):
    """Make a package importable that the judge does not have."""
    folder = tmp_path / "site-packages"
    folder.mkdir()
    (folder / "foreign_bars.py").write_text("def bar(values):\n    return values\n")
    monkeypatch.syspath_prepend(folder)
    yield
    sys.modules.pop("foreign_bars", None)
    importlib.invalidate_caches()


BODY = """def filter_ground(cloud, ground_level=-1.2):
    return bar(cloud[cloud[:, 2] >= ground_level])
"""
IMPORTED = f"from foreign_bars import bar\n{BODY}"
INSIDE = IMPORTED.replace("    return", "    from foreign_bars import bar\n    return")
MODULE = BODY.replace("bar(", "foreign_bars.bar(")
BY_NAME = f"import foreign_bars\n{MODULE}"
FALLBACK = f"try:\n    from foreign_bars import bar\nexcept ImportError:\n    bar = list\n{BODY}"
NOT_NEEDED = f"import foreign_bars\n{BODY.replace('bar(', '(')}"


def defined(source, monkeypatch):
    """Return the function defined by a cell whose source Python can find."""
    namespace = {"__name__": "__main__"}
    lines = source.splitlines(keepends=True)
    monkeypatch.setitem(
        static_analysis.linecache.cache, "<a cell>", (len(source), None, lines, "<a cell>")
    )
    exec(compile(source, "<a cell>", "exec"), namespace)
    return namespace["filter_ground"]


@pytest.mark.parametrize("source", [IMPORTED, INSIDE, BY_NAME])
def test_check_names_a_package_that_the_judge_lacks_instead_of_results(
    source, foreign_package, monkeypatch, capsys
):
    with pytest.raises(ChecksFailed):
        check(defined(source, monkeypatch))
    output = capsys.readouterr().out
    assert f"filter_ground uses foreign_bars, but {ABSENT}." in " ".join(output.split())
    assert "passed" not in output


@pytest.mark.parametrize("source", [FALLBACK, NOT_NEEDED])
def test_an_import_with_a_fallback_or_without_a_use_costs_nothing(
    source, foreign_package, monkeypatch, tmp_path, sandbox
):
    source = source.replace("bar = list", "bar = lambda rows: rows")
    check(defined(source, monkeypatch))
    _, results = judge_answers("06_filter_ground", {"filter_ground": source}, tmp_path, sandbox)
    assert results["filter_ground"].score == 10


def test_check_accepts_an_import_of_the_students_own_module(tmp_path, monkeypatch):
    (tmp_path / "my_bars.py").write_text("def bar(values):\n    return values\n")
    monkeypatch.syspath_prepend(tmp_path)
    check(defined(IMPORTED.replace("foreign_bars", "my_bars"), monkeypatch))
    sys.modules.pop("my_bars", None)


DECORATED = """from foreign_bars import bar
@bar
def keep(cloud, level):
    return cloud[cloud[:, 2] >= level]
def filter_ground(cloud, ground_level=-1.2):
    return keep(cloud, ground_level)
"""


@pytest.mark.parametrize("source", [IMPORTED, BY_NAME, DECORATED])
def test_the_judge_names_the_missing_module_as_the_cause(source, tmp_path, sandbox):
    verdict, results = judge_answers(
        "06_filter_ground", {"filter_ground": source}, tmp_path, sandbox
    )
    result = results["filter_ground"]
    # Deleting the call of `bar` is one edit, but no edit deletes a decorator.
    assert result.score == (0 if source is DECORATED else 6)
    assert "ModuleNotFoundError" in result.cause and ABSENT in result.cause
    assert "Check the spelling" not in result.cause
    assert any("no module named 'foreign_bars'" in problem for problem in verdict.problems)


def test_a_missing_progress_bar_is_one_edit_away_from_a_right_answer(tmp_path, sandbox):
    _, results = judge_answers("06_filter_ground", {"filter_ground": IMPORTED}, tmp_path, sandbox)
    result = results["filter_ground"]
    assert (result.score, result.slip is not None) == (6, True)


def test_packages_that_check_accepts_can_be_imported_by_the_judge(sandbox):
    names = sorted(static_analysis._AVAILABLE - {*sys.stdlib_module_names, "", "builtins", "utils"})
    source = (
        "import importlib\n"
        f"def filter_ground(cloud, ground_level=-1.2):\n    return [n for n in {names} "
        "if not importlib.import_module(n)]\n"
    )
    from grader.sandbox import Limits
    from grader.sandbox.program import Program
    from grader.sandbox.student import StudentProxy

    program = Program((source,), ("filter_ground",))
    limits = Limits(call_seconds=60.0, total_seconds=120.0)
    with StudentProxy(program, sandbox, limits) as student:
        assert student.filter_ground(None) == []
