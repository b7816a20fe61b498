"""Tests that the optional lesson's loops agree with earlier lessons, compiled or not."""

import ast
import re
import textwrap
from types import FunctionType, SimpleNamespace

import nbformat
import numpy as np
import pytest
from sklearn.cluster import DBSCAN

from grader.course import durations
from grader.course.lessons import (
    all_lessons,
    find_lesson,
    load_reference,
    optional_lessons,
    stages,
)
from tests.prerequisites import NUMBA
from utils import load_cloud

NAME = "13_compiled_loops"
FUNCTIONS = (
    "any_close",
    "ascending",
    "cluster_compiled",
    "cluster_in_parallel",
    "count_near",
    "detect_compiled",
    "root_of",
    "snuggest_turn",
    "sort_by_cell",
    "unite",
    "voxel_means",
)
LESSON = next(lesson for lesson in optional_lessons() if lesson.name == NAME)
TEXT = LESSON.source.read_text("utf-8")


@pytest.fixture(scope="module")
def python_functions():
    """The lesson's functions in plain Python, even if Numba is installed."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(__import__("sys").modules, "numba", None)
        load_reference.cache_clear()
        functions = load_reference(NAME, *FUNCTIONS)
    load_reference.cache_clear()
    return functions


def renumber_in_order(labels):
    """Renumber labels 1, 2, ... in the order in which they first occur."""
    number = {}
    return np.array([number.setdefault(label, len(number) + 1) for label in labels.tolist()], int)


def cell_with(words):
    """Return the source of the only cell of the lesson that contains these words."""
    (cell,) = (cell for cell in TEXT.split("\n# %%") if words in cell)
    return cell


def steps_to_root(parents, cell):
    """Count the steps from a cell to its root."""
    steps = 0
    while parents[cell] != cell:
        cell, steps = parents[cell], steps + 1
    return steps


def test_it_belongs_to_no_stage_and_gives_no_points():
    assert LESSON not in all_lessons() and LESSON.stage not in stages()
    assert find_lesson(f"{NAME}.ipynb") is None and LESSON.exercises == ()
    assert LESSON.released.exists() and LESSON.solved.exists()


def test_it_takes_three_sittings():
    sittings = durations.sitting_minutes(nbformat.read(LESSON.solved, as_version=4))
    stated = re.search(r"in three sittings of about (\d+), (\d+) and (\d+) minutes", TEXT).groups()
    assert sittings == pytest.approx([int(minutes) for minutes in stated], rel=0.1)
    assert max(sittings) <= durations.MAX_MINUTES_WITHOUT_STOP


def test_path_halving_is_drawn_as_it_happens(python_functions):
    cell = cell_with("Draw path halving")
    before, after = (ast.literal_eval(found) for found in re.findall(r"(\[0[^]]*\])[,}]", cell))
    parent = np.array(before)
    assert python_functions.root_of(parent, 6) == 0 and parent.tolist() == after
    assert steps_to_root(before, 6) == 6 and steps_to_root(after, 6) == 3


def test_the_counting_sort_is_drawn_as_it_happens(python_functions):
    cell = cell_with("Draw a counting sort")
    numbers = np.array(ast.literal_eval(re.search(r"numbers = np\.array\((.*?)\)", cell)[1]))
    expected = [(np.sort(numbers) == value).argmax() for value in range(4)]
    starts = np.cumsum(np.bincount(numbers)) - np.bincount(numbers)
    assert starts.tolist() == expected
    assert (
        python_functions.ascending(numbers).tolist() == np.argsort(numbers, kind="stable").tolist()
    )


def test_each_column_of_cells_is_apart_from_the_next(python_functions):
    heights = np.arange(5) + 0.5
    points = np.array([[0.5, y, z] for y in (0.5, 1.5) for z in heights])
    numbers = python_functions.sort_by_cell(points, 1.0)[3]
    lower, upper = numbers[:5], numbers[5:]
    assert upper[0] - lower[-1] > 2  # no cell of the next column is within two steps along z


def test_the_tiny_case_and_the_answer_of_starts_of_are_right():
    (answer,) = re.findall(r"# ```python\n((?:#     .*\n)+)# ```\n# </details>", TEXT)
    loop = answer.replace("# ", "", answer.count("# "))
    (values,) = re.findall(r'print\("starts:", starts_of\((\[.*?\])\)', TEXT)
    names = {"values": ast.literal_eval(values), "starts": [0]}
    exec(textwrap.dedent(loop), names)
    expected = [*names["starts"], len(names["values"])]
    assert f"expected: {expected}" in TEXT
    assert "groups begin at 0, 3 and 5" in TEXT and expected == [0, 3, 5, 6]


def test_the_drawn_pointer_follows_the_first_column(python_functions):
    """The columns have the stated window, and half of the 25 columns are visited."""
    cell = cell_with("Draw the columns and the pointer")
    first, second = (ast.literal_eval(found) for found in re.findall(r"\(0, 1, [^)]*\)", cell)[:2])
    window = [height for height in second if abs(height - 4) <= 2]
    assert window[0] == 2 and set(window) <= set(range(2, 7))
    assert next(height for height in second if height >= first[first.index(4) + 1] - 2) == 4
    assert sum(1 for x in range(3) for y in range(-2, 3) if x or y >= 0) == 13


def test_expected_outputs_are_right(python_functions):
    parent = np.arange(7)
    for a, b in ((0, 2), (4, 0), (5, 2), (1, 3)):
        python_functions.unite(parent, a, b)
    assert f"expected: {[int(python_functions.root_of(parent, node)) for node in range(7)]}" in TEXT
    row = np.outer([0.0, 0.2, 1.0, 0.6], [1.0, 0.0, 0.0])
    answers = [python_functions.any_close(row, 0, 2, 2, 4, limit**2) for limit in (0.5, 0.3)]
    assert f"expected: {answers[0]} {answers[1]}" in TEXT
    assert not python_functions.any_close(row, 0, 2, 2, 4, 0.4**2 - 1e-9)
    assert python_functions.any_close(row, 0, 2, 2, 4, 0.4**2 + 1e-9)


def test_a_counting_sort_is_stable(python_functions):
    numbers = np.random.default_rng(1).integers(0, 2**40, 300) // 2**30 * 2**25
    assert np.array_equal(python_functions.ascending(numbers), np.argsort(numbers, kind="stable"))
    assert python_functions.ascending(np.zeros(3, np.int64)).tolist() == [0, 1, 2]


@pytest.mark.parametrize(("seed", "threshold", "width"), [(1, 0.5, 4), (2, 0.2, 3), (3, 1.7, 12)])
def test_the_clusters_are_exact(python_functions, seed, threshold, width):
    cloud = np.random.default_rng(seed).uniform(-width, width, (400, 4))
    cloud[200:, :3] = cloud[:200, :3] * 0.3
    truth = DBSCAN(eps=threshold, min_samples=1).fit_predict(cloud[:, :3])
    labels = python_functions.cluster_compiled(cloud, threshold)
    assert truth.max() > 2 and np.array_equal(labels, renumber_in_order(truth))


def test_the_clusters_of_the_street_are_exact(python_functions):
    cloud = load_cloud("cloud.txt")
    cloud = cloud[cloud[:, 2] > -1.2][::40]
    truth = DBSCAN(eps=0.9, min_samples=1).fit_predict(cloud[:, :3])
    assert np.array_equal(python_functions.cluster_compiled(cloud, 0.9), renumber_in_order(truth))


def test_a_run_has_four_points_on_average():
    cells = np.floor(load_cloud("cloud.txt")[:, :3] / (0.5 / np.sqrt(3)))
    runs = 1 + np.count_nonzero(np.diff(cells, axis=0).any(axis=1))
    assert "has four points on average" in TEXT and round(len(cells) / runs) == 4


@pytest.mark.parametrize(
    ("threads", "size"),
    [(2, (60, 20, 4)), (3, (0.6, 400, 20)), (2, (0, 90, 40))],
)
def test_threads_find_the_same_clusters(python_functions, threads, size):
    cloud = np.random.default_rng(threads).uniform(0, 1, (10_000 * threads, 4)) * [*size, 1]
    # Chains along x cross all borders between the threads.
    cloud[:600, 0], cloud[:600, 1:3] = (
        np.linspace(0, size[0], 600),
        np.repeat([[1, 2], [5, 3]], 300, 0),
    )
    truth = DBSCAN(eps=0.5, min_samples=1).fit_predict(cloud[:, :3])
    labels = python_functions.cluster_in_parallel(cloud, 0.5, threads)
    assert truth.max() > 100 and np.array_equal(labels, renumber_in_order(truth))


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", range(3))
def test_threads_refuse_points_without_a_cell(python_functions, bad, column):
    cloud = np.zeros((20_000, 3))
    cloud[:10_000, 0], cloud[15_000, column] = 1, bad
    with pytest.raises(ValueError, match="drop"):
        python_functions.cluster_in_parallel(cloud, 0.5, 2)


@pytest.mark.parametrize(("gap", "clusters"), [(0.51, 2), (0.49, 1)])
def test_crowded_cells_are_searched_with_a_tree(python_functions, gap, clusters):
    heaps = np.random.default_rng(4).uniform(0, 0.1, (2, 400, 3))
    heaps[0, 0], heaps[1, 0] = (0.1, 0.05, 0.05), (0.0, 0.05, 0.05)
    heaps[1, :, 0] += 0.1 + gap
    labels = python_functions.cluster_compiled(heaps.reshape(-1, 3), 0.5)
    assert labels.max() == clusters and len(set(labels[:400])) == 1


def test_the_smallest_clouds_are_clustered(python_functions):
    assert python_functions.cluster_compiled(np.empty((0, 4))).shape == (0,)
    assert python_functions.cluster_compiled(np.ones((1, 3))).tolist() == [1]
    assert python_functions.cluster_compiled(np.ones((3, 4))).tolist() == [1, 1, 1]
    assert python_functions.detect_compiled(np.empty((0, 4))).shape == (0, 8, 3)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e12])
def test_points_without_a_cell_are_refused_with_a_message(python_functions, bad):
    cloud = np.vstack([np.zeros(3), np.full(3, bad)])
    with pytest.raises(ValueError, match="drop"):
        python_functions.cluster_compiled(cloud)


def test_voxels_equal_those_of_lesson_06(python_functions):
    cloud = load_cloud("cloud.txt")[::60, :3]
    expected = load_reference("06_filter_ground").voxel_grid(cloud, 0.7)
    assert len(expected) < len(cloud) / 1.2
    assert np.allclose(
        python_functions.voxel_means(np.ascontiguousarray(cloud), 0.7), expected, atol=1e-12
    )


@pytest.mark.parametrize("seed", range(4))
def test_the_snuggest_turn_equals_that_of_lesson_11(python_functions, seed):
    area = load_reference("11_pca_boxes", "floor_area_at").floor_area_at
    points = np.random.default_rng(seed).normal(size=(40, 3)) * [3, 1, 1]
    turns = np.radians(np.arange(90))
    assert python_functions.snuggest_turn(points) == area(points, turns).argmin()


def by_smallest_rectangles(cloud):
    """Detect obstacles as in lesson 12, with headings from the smallest rectangles."""
    lesson = load_reference("11_pca_boxes")
    turns = np.radians(np.arange(90))

    def get_oriented_boxes(points, labels):
        boxes = []
        for label in np.unique(labels[labels > 0]):
            mine = points[labels == label]
            yaw = turns[lesson.floor_area_at(mine, turns).argmin()]
            ends = lesson.turned(mine, -yaw)
            (a, c, low), (b, d, high) = ends.min(axis=0), ends.max(axis=0)
            around = [(b, d), (a, d), (a, c), (b, c)]
            corners = [(x, y, z) for z in (low, high) for x, y in around]
            boxes.append(lesson.turned(np.array(corners), yaw))
        return np.array(boxes)

    detect = load_reference("12_streaming_obstacles").detect_obstacles
    steps = detect.__globals__ | {"get_oriented_boxes": get_oriented_boxes}
    return FunctionType(detect.__code__, steps, argdefs=detect.__defaults__)(cloud)


@pytest.mark.slow
def test_the_boxes_equal_those_of_lesson_12(python_functions):
    cloud = load_cloud("cloud.txt")[::8]
    expected = by_smallest_rectangles(cloud)
    boxes = python_functions.detect_compiled(cloud)
    assert len(expected) > 10 and np.allclose(boxes, expected, atol=1e-9)


@pytest.mark.slow
def test_the_box_of_the_lorry_leans_as_stated():
    place, degrees = re.search(r"lorry at \((\d+, \d+)\) leans by (\d+)°", TEXT).groups()
    boxes = by_smallest_rectangles(load_cloud("cloud.txt"))
    (lorry,) = (
        box
        for box in boxes
        if np.round(box.mean(axis=0)[:2]).tolist() == [int(number) for number in place.split(", ")]
    )
    sides = np.diff(lorry[:3], axis=0)[:, :2]
    along = sides[np.linalg.norm(sides, axis=1).argmax()]
    assert round(np.degrees(np.arctan(abs(along[1] / along[0])))) == int(degrees)


@pytest.mark.slow
def test_compiled_functions_give_the_same_results():
    pytest.importorskip("numba", reason=NUMBA)
    functions = load_reference(NAME, *FUNCTIONS)
    cloud = load_cloud("cloud.txt")
    lesson = load_reference("10_accelerated_clustering")
    labels = functions.cluster_compiled(cloud)
    assert np.array_equal(labels, lesson.euclidean_clustering_accelerated(cloud))
    for threads in (1, 2, 5):
        assert np.array_equal(functions.cluster_in_parallel(cloud, 0.5, threads), labels)
    expected = by_smallest_rectangles(cloud)
    assert np.allclose(functions.detect_compiled(cloud), expected, atol=1e-9)


@pytest.mark.parametrize("is_compiled", [True, False])
def test_output_mentions_compilation_only_if_compiled(python_functions, capsys, is_compiled):
    cells = [cell.source for cell in nbformat.read(LESSON.solved, as_version=4).cells]
    (cell,) = (source for source in cells if "first call{" in source)
    guess = SimpleNamespace(compare=lambda *_: None)
    names = {"np": np, "njit": lambda made: made, "ready": callable, "faster": guess}
    names |= {"points": np.ones((20, 3)), "level": np.array([0, 0, 1.0, -1])}
    names |= {"count_near": python_functions.count_near, "milliseconds": lambda *_, **__: 1.0}
    exec(cell, names | {"is_compiled": is_compiled})
    output = capsys.readouterr().out
    assert "the same number as NumPy" in output
    assert ("compil" in output) == is_compiled
