"""Tests of the statements in lesson 04, with answers that follow its hints."""

import functools
import math

import numpy as np
import pytest

from grader.course.lessons import find_lesson
from tests.lesson_texts import run_statements_for
from utils.datasets import DATA
from utils.visits import depth_of, describe_step, node_states, nodes_of, place_of, watched

LESSON = find_lesson("04_kd_tree")
NAMES = (
    "Node", "KdTree", "insert", "search", "median_order", "grow", "trace", "levels", "cost_of",
    "search_the_scan", "first_of", "eight", "seven", "better", "target", "radius", "looked_at",
    "fifteen", "flat", "thousand", "wall", "four", "cases", "post", "half_a_metre", "obstacles",
    "is_near", "cloud",
)  # fmt: skip


def notebook_with(**answers):
    """Return the names that the lesson defines, with the named kept answers."""
    return run_statements_for(LESSON.name, *NAMES, **answers)


@functools.cache
def lesson_names():
    return notebook_with()


def places(tree):
    return {node.index: place_of(tree.root, node.index) for node in nodes_of(tree.root)}


def prose():
    return LESSON.source.read_text("utf-8")


def test_a_strip_along_one_axis_contains_far_too_many_points():
    lesson = lesson_names()
    near = lesson["is_near"].sum()
    assert "A cyclist, a house front and, beyond the picture, a hedge are in it" in prose()
    truth = np.load(DATA / "cloud_truth.npz")
    ego_car = np.hypot(*lesson["cloud"][:, :2].T) < 2
    kinds = truth["classes"][(lesson["cloud"][:, 2] > -1.2) & ~ego_car]
    in_strip = np.abs(lesson["obstacles"][:, 0] - lesson["post"][0]) <= lesson["half_a_metre"]
    seen = in_strip & (np.abs(lesson["obstacles"][:, 1]) < 12)
    names = truth["class_names"][np.unique(kinds[seen])].tolist()
    beyond = truth["class_names"][np.unique(kinds[in_strip & ~seen])].tolist()
    assert sorted(names) == ["cyclist", "pole", "wall"] and "foliage" in beyond
    for axis, times in enumerate((5, 5, 100)):
        away = np.abs(lesson["obstacles"][:, axis] - lesson["post"][axis])
        assert (away <= lesson["half_a_metre"]).sum() > times * near


def test_ready_made_trees_equal_those_of_insert():
    lesson = lesson_names()
    for count in range(1, 9):
        ready, grown = lesson["first_of"](count), lesson["grow"](lesson["eight"][:count])
        assert places(ready) == places(grown)
    order = lesson["median_order"](lesson["seven"])
    assert places(lesson["better"]) == places(lesson["grow"](lesson["seven"], order))
    assert places(lesson["better"]) == places(
        lesson["grow"](lesson["seven"], [3, 0, 2, 1, 4, 6, 5])
    )
    tiny = places(lesson["grow"]([[5, 5], [2, 8], [7, 3]]))
    assert tiny == {0: "the root", 1: "left of 0", 2: "right of 0"}


def test_the_first_puzzle_has_the_stated_answer():
    lesson = lesson_names()
    assert places(lesson["first_of"](8))[7] == "left of 5"
    equal_left = notebook_with(insert="equal goes left")
    # The wrong answer is one of the puzzle's choices.
    assert places(equal_left["grow"](equal_left["eight"]))[7] == "left of 3"


def test_the_second_puzzle_matches_its_table():
    lesson = lesson_names()
    visited, found = lesson["trace"](lesson["better"], lesson["target"], lesson["radius"])
    assert sorted(visited) == sorted(lesson["looked_at"]) and found == [0, 4]
    states = node_states(lesson["better"].root, visited)
    by_index = {node.index: states[id(node)] for node in nodes_of(lesson["better"].root)}
    assert [index for index, fate in by_index.items() if fate == "pruned"] == [2, 6, 5]
    texts = [
        describe_step(lesson["better"].root, visited, step, lesson["target"], lesson["radius"])
        for step in range(1, 5)
    ]
    assert texts[0].startswith(
        "node 3 cuts x at 3, and the box reaches from -7 to 1: left searched, "
    )
    assert "right pruned; 10.0 m away: far" in texts[0]
    table = "# | 3, cuts x at 3 | -7 to 1 | yes | **no: three nodes pruned** | far |"
    assert table in prose()


def test_the_search_step_by_step_prunes_four_branches():
    lesson = lesson_names()
    yard = lesson["grow"](lesson["fifteen"])
    visited, found = lesson["trace"](yard, [2, -1], 4)
    states = node_states(yard.root, visited)
    branches = [
        child
        for node in nodes_of(yard.root)
        for child in (node.left, node.right)
        if child is not None and states[id(node)] == "looked at" and states[id(child)] == "pruned"
    ]
    assert (len(found), len(branches), depth_of(yard.root)) == (3, 4, 5)
    assert set(node_states(yard.root, visited, 0).values()) == {"not yet"}
    assert describe_step(yard.root, visited, 0, [2, -1], 4).startswith("Before")


def test_a_search_without_result_visits_some_nodes():
    lesson = lesson_names()
    garden = lesson["grow"](lesson["flat"])
    visited, found = lesson["trace"](garden, [14.0, -0.3], 0.2)
    assert found == [] and 0 < len(visited) < 20
    everything = [len(lesson["trace"](garden, [8.0, -0.3], radius)[0]) for radius in (1, 4, 10, 60)]
    assert everything == sorted(everything) and everything[-1] == len(lesson["flat"])


def test_levels_depend_on_the_order_of_insertion():
    lesson = lesson_names()
    assert lesson["levels"](lesson["wall"]) == 1000
    assert 10 <= lesson["levels"](lesson["thousand"]) < 40
    assert 10 <= lesson["levels"](np.random.default_rng(1).permutation(lesson["wall"])) < 40
    assert lesson["levels"](lesson["thousand"], lesson["median_order"](lesson["thousand"])) == 10
    recursive = notebook_with(insert="calls itself for each level")
    with pytest.raises(RecursionError):
        recursive["levels"](lesson["wall"])


def test_the_third_puzzle_matches_its_picture():
    seven, levels = lesson_names()["seven"], lesson_names()["levels"]
    assert np.argsort(seven[:, 0])[3] == 3 and np.argsort(seven[:, 1])[3] == 0
    assert seven[:, 0].argmax() == 6
    assert levels(seven, [3, 0, 2, 1, 4, 6, 5]) == 3
    order = [6, 0, 1, 3, 5, 4, 2]
    assert levels(seven, order) == 4
    tree = lesson_names()["grow"](seven, order)
    assert tree.root.index == 6 and tree.root.right is None


def test_medians_of_four_and_fifteen_points_are_as_stated():
    lesson = lesson_names()
    assert list(lesson["median_order"](lesson["four"])) in (
        [1, 0, 2, 3],
        [1, 2, 0, 3],
        [1, 2, 3, 0],
    )
    tree = lesson["grow"](lesson["fifteen"], lesson["median_order"](lesson["fifteen"]))
    assert (tree.root.index, depth_of(tree.root)) == (4, 4)


def test_search_costs_grow_as_stated():
    cost_of = lesson_names()["cost_of"]
    costs = {
        name: np.array([cost_of(name, n) for n in (125, 250, 500, 1000)])
        for name in ("medians first", "random order", "sorted by x", "a sorted wall")
    }
    slopes = {name: math.log2(cost[3] / cost[1]) / 2 for name, cost in costs.items()}
    assert 0.9 < slopes["a sorted wall"] < 1.1
    assert 0.4 < costs["a sorted wall"][3] / 1000 < 0.6
    assert slopes["medians first"] < 0.4
    medians, shuffled, by_x, wall = costs.values()
    # A random order costs more than medians at every size, and about a fifth more on average.
    assert (shuffled > medians).all()
    assert (shuffled / medians).mean() == pytest.approx(1.2, abs=0.06)
    assert shuffled[3] < by_x[3] < wall[3]


@pytest.mark.slow
@pytest.mark.parametrize(("dimensions", "least", "most"), [(3, 0, 0.05), (15, 0.9, 1)])
def test_in_many_dimensions_a_search_visits_nearly_every_node(dimensions, least, most):
    lesson = lesson_names()
    points = np.random.default_rng(3).uniform(size=(8000, dimensions))
    tree = lesson["grow"](points, lesson["median_order"](points))
    for target in points[:5]:
        radius = np.sort(np.linalg.norm(points - target, axis=1))[4] + 1e-9
        visited, found = lesson["trace"](tree, target.tolist(), radius)
        assert len(found) == 5
        assert least <= len(visited) / len(points) <= most


@pytest.mark.slow
def test_the_search_around_the_lamp_post_visits_few_nodes():
    lesson = lesson_names()
    levels, visits, found = lesson["search_the_scan"](lesson["post"], lesson["half_a_metre"])
    assert found == lesson["is_near"].sum()
    assert found < visits < 3 * found
    assert levels > 16 == int(np.log2(len(lesson["obstacles"]))) + 1
    # Equal coordinates cause the additional levels. Their number depends on the order of equal
    # values after sorting, which depends on the processor.
    exact = lesson["obstacles"]
    assert np.sum(exact[:, 2] == 0) == 1653
    moved = exact + np.random.default_rng(0).uniform(-4e-4, 4e-4, exact.shape)
    assert lesson["depth_of"](lesson["grow"](moved, lesson["median_order"](moved)).root) == 16


@pytest.mark.slow
def test_common_mistakes_find_the_points_in_the_drawing():
    wrong = {
        "the box decides": "the box decides",
        "if ... else": "else instead of a second if",
        "> instead of >=": "strictly greater on the right",
        "no condition": "visits every node",
    }
    for title, points, tree, centre, radius, finds, visited in lesson_names()["cases"]:
        lesson = notebook_with(search=wrong[title])
        with watched(tree) as seen:
            assert sorted(lesson["search"](tree, centre, radius)) == finds
        if visited is not None:
            assert sorted(seen) == sorted(visited)
        right = [i for i in range(len(points)) if math.dist(points[i], centre) <= radius]
        assert (right == finds) == (title == "no condition")
        assert set(right) == set(lesson_names()["search"](tree, centre, radius))


def test_equal_points_on_the_left_are_missed():
    lesson = notebook_with(insert="equal goes left")
    tree = lesson["grow"](lesson["eight"])
    assert 7 not in lesson["search"](tree, [2, 9], 4)
    assert math.dist(lesson["eight"][7], [2, 9]) <= 4
    assert round(math.sqrt(0.5), 2) == 0.71 and round(math.sqrt(3), 2) == 1.73
