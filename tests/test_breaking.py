"""Broken versions make the mistake that they describe, and their smallest clouds are minimal."""

from collections import deque

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist

from tests.lesson_texts import run_statements_for, source_of
from utils import breaking
from utils.breaking.puzzles import PUZZLES

# Kept answers with the same mistake as a broken version, by the letter of the version.
KEPT_ANSWERS = {
    "euclidean_clustering": {
        "A": "forgets the height",
        "B": "compares with the first point of the cluster only",
        "C": "compares the squared distance with the threshold",
    },
    "ransac_line": {"C": "the tolerance is squared"},
    "get_bounding_boxes": {
        "A": "minimum and maximum start at zero",
        "C": "also a box around label 0",
    },
}
REVEALING_CLOUDS = {
    "ransac_line": {
        "A": [[1, 0], [1, 3]],
        "B": [[0, 0], [5, 2]],
        "C": [[0, 0], [4, 0], [2, 0.4]],
    },
    "euclidean_clustering": {
        "A": [[0, 0, 0], [0, 0, 2]],
        "B": [[0, 0, 0], [0.7, 0, 0], [1.4, 0, 0]],
        "C": [[0, 0, 0], [0.85, 0, 0]],
    },
    "get_bounding_boxes": {"A": [[1, 1, 1, 1]], "B": [[1, 1, 1, 2]], "C": [[1, 1, 1, 0]]},
    "get_oriented_boxes": {
        "A": [[0, 0, 0, 1]] * 5 + [[3, 0, 0, 1]],
        "B": [[0, 0, 0, 1], [1, 0, 0, 1], [3, 0, 0, 1]],
        "C": [[0, 0, 0, 1], [2, 0, 0, 1]],
    },
    "euclidean_clustering_accelerated": {
        "A": [[0.05, 0, 0], [0.42, 0, 0], [1.2, 0, 0]],
        "B": [[0, 0, 0], [0.9, 0, 0]],
        "C": [[0, 0, 0], [0, 0, 2]],
    },
}


def cluster_with_scipy(cloud, threshold=0.5):
    """Cluster with SciPy, which computes all distances."""
    return connected_components(cdist(cloud, cloud) < threshold)[1] + 1


def function_of(exercise, name="the hints followed to the letter"):
    if exercise == "euclidean_clustering_accelerated":
        cluster_with_scipy.__name__ = exercise
        return cluster_with_scipy
    space = {"np": np, "deque": deque}
    if exercise == "get_oriented_boxes":
        space |= run_statements_for("11_pca_boxes", "turned", "floor_area_at", "closeness_at")
        name += "" if ", " in name else ", the closest rectangle"
    helpers = ("line_through", "point_line_distance") if exercise == "ransac_line" else ()
    for helper in helpers:
        exec(source_of(helper), space)
    exec(source_of(exercise, name), space)
    return space[exercise]


def some_cloud(rng, exercise, count):
    """Return random points that are often close together, above each other or on a grid."""
    size = PUZZLES[exercise].example.shape[1]
    cloud = rng.integers(0, 9, (count, size)) * rng.choice([0.2, 0.31, 0.45])
    if PUZZLES[exercise].columns.endswith("label"):
        cloud[:, 3] = rng.integers(0, 4, count)
    return cloud + rng.choice([0, 1]) * rng.normal(0, 0.05, cloud.shape) * [1, 1, 1, 0][:size]


def answers_differ(exercise, letter, function, cloud):
    puzzle = PUZZLES[exercise]
    right = puzzle.comparable(puzzle.answer_of(function, cloud))
    wrong = puzzle.comparable(puzzle.versions[letter].answer(function, cloud))
    return right.shape != wrong.shape or not np.allclose(right, wrong)


BROKEN_VERSIONS = [
    (exercise, letter) for exercise, puzzle in PUZZLES.items() for letter in puzzle.versions
]


@pytest.mark.parametrize(("exercise", "letter"), BROKEN_VERSIONS)
def test_the_smallest_cloud_shows_the_mistake_and_smaller_clouds_do_not(exercise, letter):
    function, cloud = (
        function_of(exercise),
        np.array(REVEALING_CLOUDS[exercise][letter], dtype=float),
    )
    smallest = PUZZLES[exercise].versions[letter].smallest_row_count
    assert len(cloud) == smallest and answers_differ(exercise, letter, function, cloud)
    rng = np.random.default_rng(1)
    for count in range(1, smallest):
        for _ in range(40 if exercise in ("ransac_line", "get_oriented_boxes") else 400):
            assert not answers_differ(exercise, letter, function, some_cloud(rng, exercise, count))


@pytest.mark.parametrize("way", ["principal axes in the plane", "the smallest rectangle"])
def test_the_smallest_clouds_do_not_depend_on_how_the_yaw_is_found(way):
    function = function_of("get_oriented_boxes", f"the hints followed to the letter, {way}")
    for letter, cloud in REVEALING_CLOUDS["get_oriented_boxes"].items():
        assert answers_differ("get_oriented_boxes", letter, function, np.array(cloud, dtype=float))


@pytest.mark.parametrize(("exercise", "letter"), BROKEN_VERSIONS)
def test_the_picture_shows_the_mistake(exercise, letter):
    assert answers_differ(exercise, letter, function_of(exercise), PUZZLES[exercise].example)


@pytest.mark.parametrize(
    ("exercise", "letter"),
    [(exercise, letter) for exercise in KEPT_ANSWERS for letter in KEPT_ANSWERS[exercise]],
)
def test_a_broken_version_agrees_with_a_kept_answer_that_has_the_same_mistake(exercise, letter):
    puzzle, right = PUZZLES[exercise], function_of(exercise)
    wrong = function_of(exercise, KEPT_ANSWERS[exercise][letter])
    rng, different = np.random.default_rng(2), 0
    for _ in range(10 if exercise == "ransac_line" else 60):
        cloud = some_cloud(rng, exercise, 8)
        made = puzzle.comparable(puzzle.versions[letter].answer(right, cloud))
        written = puzzle.comparable(puzzle.answer_of(wrong, cloud))
        assert made.shape == written.shape and np.allclose(made, written)
        different += answers_differ(exercise, letter, right, cloud)
    assert different


def test_messages_name_the_found_mistakes_and_the_remaining_ones(capsys):
    cluster = function_of("euclidean_clustering")
    chain = [[0, 0, 0], [0.7, 0, 0], [1.4, 0, 0]]
    breaking.tell_apart(cluster, A=chain, B=[*chain, [9, 9, 9]], C=[[0, 0, 0], [0.85, 0, 0]])
    a, b, c = capsys.readouterr().out.splitlines()
    assert a == "A ✗ With this cloud, A gives the same answer as your function."
    assert b.startswith("B ✓ Found with 4 rows.") and b.endswith("3 rows would be enough.")
    assert c == "C ✓ Found with 2 rows. It compares the squared distance with the threshold."
    breaking.tell_apart(function_of("ransac_line"), A=[[1, 0], [1, 3]])
    a, b, c = capsys.readouterr().out.splitlines()
    assert a.endswith("B is also wrong with this cloud.") and b == "B … no cloud yet."


@pytest.mark.parametrize(
    ("cloud", "message"),
    [
        ("abc", "list of at most 50 rows [x, y, z]"),
        ([1, 2, 3], "list of at most 50 rows"),
        (3, "list of at most 50 rows"),
        (np.array(5.0), "list of at most 50 rows"),
        ([[1, 2, 3], [4]], "list of at most 50 rows"),
        (np.empty((0, 3)), "no cloud yet"),
        ([[1, 2]], "list of at most 50 rows"),
        (np.zeros((51, 3)), "list of at most 50 rows"),
        ([[1, 2, float("nan")]], "Use finite numbers"),
    ],
)
def test_an_invalid_cloud_gets_a_message(cloud, message, capsys):
    breaking.tell_apart(function_of("euclidean_clustering"), A=cloud)
    assert message in capsys.readouterr().out


def test_failing_unwritten_and_unknown_functions_get_a_message(capsys):
    def euclidean_clustering(cloud, threshold=0.5):
        raise KeyError("mine")

    breaking.tell_apart(euclidean_clustering, A=[[0, 0, 0]])
    assert "Your function raised KeyError" in capsys.readouterr().out
    breaking.show_broken(euclidean_clustering)
    assert "Your function raised KeyError" in capsys.readouterr().out
    space = {}
    exec("def ransac_line(*about):\n    raise NotImplementedError", space)
    breaking.tell_apart(space["ransac_line"], A=[[0, 0]])
    assert "not written yet" in capsys.readouterr().out
    with pytest.raises(LookupError, match="no broken versions of 'len'"):
        breaking.show_broken(len)
    with pytest.raises(TypeError, match="no version Z"):
        breaking.tell_apart(function_of("euclidean_clustering"), Z=[[0, 0, 0]])


def test_an_endless_loop_is_stopped(capsys, monkeypatch):
    monkeypatch.setattr(breaking, "TIME_LIMIT", 0.3)

    def euclidean_clustering(cloud, threshold=0.5):
        while True:
            pass

    breaking.tell_apart(euclidean_clustering, A=[[0, 0, 0]])
    assert "A ✗ Your function did not answer within 0.3 seconds" in capsys.readouterr().out
    breaking.show_broken(euclidean_clustering)
    assert "a loop that never ends" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("exercise", PUZZLES)
def test_four_pictures_are_drawn(exercise, monkeypatch):
    monkeypatch.setattr(plt, "show", lambda: None)
    breaking.show_broken(function_of(exercise))
    titles = [axes.get_title(loc="left") for axes in plt.gcf().axes]
    assert titles == ["yours", "A", "B", "C"]
