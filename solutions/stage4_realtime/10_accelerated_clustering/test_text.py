"""Tests of the statements in lesson 10, with the algorithm that it teaches."""

import json
import re
from time import process_time

import numpy as np
import pytest
from scipy.spatial import cKDTree

from grader.course.kept_answers import answers_to
from grader.course.lessons import find_lesson, load_reference
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles
from grader.judging.runner import limited_cpu_time
from grader.lms.autograded_copy import build_copy
from tests.lesson_texts import run_statements_for
from utils import load_cloud
from utils.checks.core import checks_of, notes_of, run_check
from utils.checks.lesson_10.accelerated import _seconds_to_find_neighbours

NAME = "10_accelerated_clustering"
STEPS = ("points_in_cells", "join_cheaply", "join_exactly")
GIVEN = (
    "components",
    "join_all_pairs",
    "seconds_of",
    "clusters_by",
    "neighbours_by_tree",
    "same_clusters",
    "on_floors",
    "join_on_floors",
    "points_by_cell",
    "smallest_distance",
    "as_numbers",
    "spring_the_trap",
    "with_other_colours",
)
LESSON = load_reference(
    NAME, *STEPS, *GIVEN, "clustering_at_full_speed", "seven", "letters", "after_two_steps"
)


@pytest.fixture(scope="module")
def obstacles():
    cloud = load_cloud("cloud.txt")
    own_car = np.hypot(cloud[:, 0], cloud[:, 1]) < 2
    return cloud[(cloud[:, 2] > -1.2) & ~own_car, :3]


@pytest.fixture(scope="module")
def right_labels(obstacles):
    return LESSON.join_all_pairs(obstacles)


def open_pairs(label, pairs):
    return label[pairs[:, 0]] != label[pairs[:, 1]]


def test_the_steps_give_the_printed_results_on_seven_points():
    """Compare the results with those that the notebook prints as "expected"."""
    text, seven, wide = find_lesson(NAME).source.read_text("utf-8"), LESSON.seven, np.sqrt(3)
    cells, first, cell_of_point = LESSON.points_in_cells(seven, wide)
    assert f"[{', '.join(str(cell) for cell in cells[:, :2].astype(int).tolist())}]" in text
    letters = [LESSON.letters[row] for row in first]
    assert json.dumps(letters) in text and str(cell_of_point.tolist()) in text
    pairs, label = LESSON.join_cheaply(seven, cells, first, wide)
    assert str(sorted(pairs.tolist())) in text
    gaps = np.linalg.norm(seven[first[pairs[:, 0]]] - seven[first[pairs[:, 1]]], axis=1)
    # The text says: seven pairs are neighbours, three are joined, a fourth is then in one piece as
    # well, and three are left.
    assert (len(pairs), (gaps < wide).sum(), open_pairs(label, pairs).sum()) == (7, 3, 3)
    assert label[4] == label[5]  # an answer that relabels only cell 4 visibly leaves cell 5 behind
    before = label.copy()
    exact = LESSON.join_exactly(seven, cell_of_point, pairs, label, wide)
    assert np.array_equal(label, before)
    assert len(set(exact[1:])) == 1 and len(set(exact)) == 2
    found = LESSON.euclidean_clustering_accelerated(seven, wide)
    assert f"expected: {found}" in text


def test_one_cell_of_each_open_pair_visits_the_other_on_its_floor(obstacles):
    points = obstacles[::3]
    cells, first, cell_of_point = LESSON.points_in_cells(points, 0.4)
    pairs, label = LESSON.join_cheaply(points, cells, first, 0.4)
    chosen = pairs[open_pairs(label, pairs)]
    p, q, pair_of_q = LESSON.on_floors(points, cell_of_point, chosen, 0.4)
    floor_of_p, floor_of_q = (np.rint(one_cell[:, 3] / 0.8).astype(int) for one_cell in (p, q))
    assert np.allclose(p[:, 3], 0.8 * floor_of_p) and np.allclose(q[:, 3], 0.8 * floor_of_q)
    assert len(chosen) > 100
    many, visited = np.bincount(cell_of_point), 0
    # p contains each point at most once, on the floor of its own cell.
    assert (np.bincount(floor_of_p, minlength=len(many)) <= many).all()
    for number, (one_cell, other_cell) in enumerate(chosen):
        host, guest = (
            (one_cell, other_cell) if many[one_cell] >= many[other_cell] else (other_cell, one_cell)
        )
        mine, theirs = (points[cell_of_point == cell] for cell in (host, guest))
        gaps = np.linalg.norm(mine[:, None] - theirs, axis=2)
        for found, whole, gap in (
            (p[floor_of_p == host], mine, gaps.min(axis=1)),
            (q[pair_of_q == number], theirs, gaps.min(axis=0)),
        ):
            found = {*map(tuple, found[:, :3].tolist())}
            left_out = np.array([tuple(point) not in found for point in whole.tolist()])
            assert found <= {*map(tuple, whole.tolist())}
            assert not left_out.any() or len(whole) >= 100
            assert (gap[left_out] >= 0.4).all()  # these points are too far away to join the cells
        assert {*floor_of_q[pair_of_q == number]} <= {host}
        visited += (pair_of_q == number).any()
    assert visited > 100


def test_heaps_end_to_end_need_few_queries():
    """Require few points on the floors. With all points in one tree, tilted rods took 14 s."""
    rng = np.random.default_rng(5)
    rods = rng.uniform(0, [0.04, 0.002, 0.002], (4, 5000, 3))
    rods += [[[x, 0.0, 0.0]] for x in (0.0, 0.542, 6.0, 6.542)]
    points = rods.reshape(-1, 3) @ np.linalg.qr(rng.normal(size=(3, 3)))[0] + [3.0, -7.0, 1.0]
    cells, first, cell_of_point = LESSON.points_in_cells(points, 0.5)
    pairs, label = LESSON.join_cheaply(points, cells, first, 0.5)
    chosen = pairs[open_pairs(label, pairs)]
    p, q, _ = LESSON.on_floors(points, cell_of_point, chosen, 0.5)
    assert len(chosen) >= 2 and len(p) + len(q) < len(points) / 10
    for join in (LESSON.join_exactly, LESSON.join_on_floors):
        pieces = join(points, cell_of_point, pairs, label, 0.5)
        assert len(set(pieces[cell_of_point])) == 4


@pytest.mark.parametrize("radius", [0.001, 0.2, 1.0])
def test_clustering_is_exact_for_a_heap_within_a_shell(radius):
    """Nearly equal distances between a heap and a shell once made clustering take 7 s."""
    rng = np.random.default_rng(7)
    v = rng.normal(size=(2, 4000, 3))
    v /= np.linalg.norm(v, axis=2, keepdims=True)
    for gap, clusters in ((0.5001, 2), (0.4999, 1)):
        points = np.concatenate([radius * v[0], (radius + gap) * v[1]])
        points[4000] = (radius + gap) * v[0, 0]  # this pair's distance is exactly the gap
        for cluster in (LESSON.euclidean_clustering_accelerated, LESSON.clustering_at_full_speed):
            labels = cluster(points, 0.5)
            assert labels.max() == clusters and len(set(labels[:4000])) == 1


def test_on_floors_returns_nothing_without_open_pairs():
    none = np.empty((0, 2), dtype=int)
    p, q, pair_of_q = LESSON.on_floors(LESSON.seven, np.arange(7), none, 0.5)
    assert p.shape == q.shape == (0, 4) and pair_of_q.shape == (0,)


def test_points_by_cell_returns_the_points_of_each_cell(obstacles):
    points = obstacles[::9]
    _, _, cell_of_point = LESSON.points_in_cells(points, 0.5)
    inside = LESSON.points_by_cell(points, cell_of_point)
    assert len(inside) == cell_of_point.max() + 1 > 1000
    for cell, found in enumerate(inside):
        expected = points[cell_of_point == cell]
        assert sorted(map(tuple, found.tolist())) == sorted(map(tuple, expected.tolist()))


@pytest.mark.parametrize("sizes", [(1, 1), (7, 3), (60, 40)])
def test_smallest_distance_agrees_with_all_distances(sizes):
    p, q = (np.random.default_rng(size).normal(size=(size, 3)) for size in sizes)
    distances = [np.linalg.norm(one - other) for one in p for other in q]
    assert LESSON.smallest_distance(p, q) == pytest.approx(min(distances))


def test_points_d_and_e_are_close_but_their_representatives_are_not():
    """The picture of step 3 draws a line between the points, not between representatives."""
    seven = LESSON.seven
    assert "".join(LESSON.letters[[3, 4]]) == "de"
    _, first, cell_of_point = LESSON.points_in_cells(seven, np.sqrt(3))
    assert np.linalg.norm(seven[3] - seven[4]) < np.sqrt(3)
    representatives = first[cell_of_point[[3, 4]]]
    assert np.linalg.norm(np.subtract(*seven[representatives])) > np.sqrt(3)


@pytest.mark.slow
def test_one_tree_for_all_open_pairs_gives_the_same_pieces_sooner(obstacles):
    cells, first, cell_of_point = LESSON.points_in_cells(obstacles, 0.5)
    pairs, label = LESSON.join_cheaply(obstacles, cells, first, 0.5)
    arguments = obstacles, cell_of_point, pairs, label, 0.5
    assert open_pairs(label, pairs).sum() > 1000
    by_loop, on_floors = LESSON.join_exactly(*arguments), LESSON.join_on_floors(*arguments)
    assert LESSON.same_clusters(by_loop, on_floors)
    assert LESSON.seconds_of(LESSON.join_on_floors, *arguments) < LESSON.seconds_of(
        LESSON.join_exactly, *arguments
    )


def test_denser_clouds_have_more_points_in_each_cell(obstacles):
    cells = [len(LESSON.points_in_cells(obstacles[::step], 0.5)[0]) for step in (8, 4, 2, 1)]
    assert (np.divide(cells[1:], cells[:-1]) < 1.7).all()  # for twice as many points


@pytest.mark.parametrize("far", [1.0, 1e6, 1e13, 1e300])
def test_only_equal_rows_have_equal_numbers(far):
    rows = np.array([[0, 0, -3], [1, 0, 0], [0, 1, 0], [1, 0, 0], [-1, 0, 3], [0, 0, -3.0]]) * far
    different, kind = np.unique(rows, axis=0, return_inverse=True)
    numbers = LESSON.as_numbers(rows)
    assert np.array_equal(np.unique(numbers, return_inverse=True)[1], kind.ravel())
    assert len(np.unique(numbers)) == len(different)


def test_no_gap_of_the_seven_points_is_close_to_the_threshold():
    gaps = cKDTree(LESSON.seven).sparse_distance_matrix(cKDTree(LESSON.seven), 9.0).toarray()
    assert np.abs(gaps[gaps > 0] - np.sqrt(3)).min() > 0.05


@pytest.mark.slow
def test_the_cheap_step_settles_nearly_all_pairs(obstacles, right_labels):
    labels, cells, pairs, still_open = LESSON.after_two_steps(obstacles)
    assert len(obstacles) > 50_000 and cells < len(obstacles) / 5
    assert len(obstacles) / cells < 10  # the text says "a handful of points"
    assert 0.01 < still_open / pairs < 0.03  # the text says "about one pair in fifty"
    assert labels.max() > right_labels.max() + 1  # some clusters are split, but none are merged
    for part in np.unique(labels):
        assert len(np.unique(right_labels[labels == part])) == 1


@pytest.mark.slow
def test_both_versions_are_exact_and_give_equal_labels(obstacles, right_labels):
    for points, threshold in ((obstacles, 0.5), (obstacles[::5], 0.23), (obstacles[::9], 1.4)):
        taught = LESSON.euclidean_clustering_accelerated(points, threshold)
        assert np.array_equal(taught, LESSON.clustering_at_full_speed(points, threshold))
        exact = right_labels if points is obstacles else LESSON.join_all_pairs(points, threshold)
        assert LESSON.same_clusters(taught, exact)


def test_statements_about_pairs_are_true(obstacles):
    few, tree = obstacles[::20], cKDTree(obstacles)

    def mean_neighbours(tree, points, threshold):
        return (tree.query_ball_point(points, threshold, return_length=True) - 1).mean()

    assert mean_neighbours(tree, few, 0.5) / 2 > 100  # n - 1 pairs would be enough
    for threshold in (0.25, 0.5, 1.0):  # the text says "2 to 3.5 times"
        longer = mean_neighbours(tree, few, 2 * threshold) / mean_neighbours(tree, few, threshold)
        assert 2 < longer < 3.4
    half = np.random.default_rng(0).permutation(obstacles)[: len(obstacles) // 2]
    pairs = len(obstacles) * mean_neighbours(tree, few, 0.5)
    assert pairs / (len(half) * mean_neighbours(cKDTree(half), half[::10], 0.5)) == pytest.approx(
        4, rel=0.1
    )


def test_each_idea_leaves_far_fewer_pairs(obstacles):
    """The bar chart compares these numbers of pairs."""
    _, _, of_cells, still_open = LESSON.after_two_steps(obstacles)
    few, n = obstacles[::20], len(obstacles)
    neighbours = cKDTree(obstacles).query_ball_point(few, 0.5, return_length=True) - 1
    counts = n * (n - 1) / 2, n * neighbours.mean() / 2, of_cells, still_open
    assert (np.divide(counts[:-1], counts[1:]) > 40).all()
    assert counts[-1] > 1 and counts[0] < 1e11  # the ends of the axis


def test_a_denser_cloud_has_more_pairs_for_each_point(obstacles):
    """The text compares the smallest sample of the chart of times with the whole scan."""
    few = np.random.default_rng(10).permutation(obstacles)[:500]
    pairs = len(cKDTree(few).query_pairs(0.5)) / len(few)
    tree = cKDTree(obstacles)
    neighbours = tree.query_ball_point(obstacles[::20], 0.5, return_length=True) - 1
    assert 0.7 < pairs < 1.5 and neighbours.mean() / 2 > 100


@pytest.mark.slow
def test_the_time_to_list_and_join_all_pairs_grows_faster_and_faster(obstacles):
    points = np.random.default_rng(10).permutation(obstacles)
    sizes = 500, 2000, 8000, len(points)
    times = [LESSON.seconds_of(LESSON.join_all_pairs, points[:n]) for n in sizes]
    slopes = np.diff(np.log(times)) / np.diff(np.log(sizes))
    assert slopes[0] < 1.5 < slopes[-1] < 3  # about 2 on an idle machine


@pytest.mark.slow
def test_listing_pairs_is_faster_than_querying_and_joining(obstacles):
    """Listing and joining pairs takes about as long as querying the tree without joining."""
    by_tree = LESSON.clusters_by(LESSON.neighbours_by_tree)
    few = np.random.default_rng(1).permutation(obstacles)[:4000]
    for points in (few, obstacles):
        listed = LESSON.seconds_of(LESSON.join_all_pairs, points)
        assert LESSON.seconds_of(by_tree, points) > 2 * listed
        accelerated = LESSON.seconds_of(LESSON.euclidean_clustering_accelerated, points)
        # The text says that the list wins for a few thousand points.
        assert (listed < accelerated) == (points is few)
    querying = LESSON.seconds_of(LESSON.neighbours_by_tree, obstacles, obstacles)
    assert listed < 1.5 * querying


def test_larger_thresholds_give_fewer_cells_and_open_pairs(obstacles):
    counts = [
        LESSON.after_two_steps(obstacles[::3], threshold)[1:] for threshold in (0.2, 0.5, 1.0)
    ]
    assert (np.diff(counts, axis=0) < 0).all()


def test_a_growing_threshold_repairs_four_of_five_cars_and_joins_two():
    """Run the cells as given, and with the answer of the text."""
    text = find_lesson(NAME).source.read_text("utf-8")
    answer = re.search(r"Write `(limit = [^`]*)`", text)[1]
    given = run_statements_for(NAME, "torn", "shared", "pieces", "far_points", "far_objects")
    assert (len(given["pieces"]), given["torn"], given["shared"]) == (5, 5, 0)
    function = re.search(r"def cluster_far.*?\+ 1\n", text, re.S)[0]
    assert function.count("limit = 0.5 + 0 * distance") == 1
    exec(function.replace("limit = 0.5 + 0 * distance", answer), given)
    labels, objects = given["cluster_far"](given["far_points"]), given["far_objects"]
    cars = [number for number in (94, 95, 96, 119, 154) if (objects == number).sum() >= 10]
    pieces = [set(labels[objects == car].tolist()) for car in cars]
    assert len(pieces) == 5 and sum(len(names) > 1 for names in pieces) == 1
    assert sum(any(a & b for b in pieces if b is not a) for a in pieces) == 2
    assert pieces[2] & pieces[3] and "in the cluster of the car behind it" in text
    stray = (objects == 119) & np.isin(labels, list(pieces[2]))
    place = np.round(given["far_points"][stray, :2], 1).tolist()
    assert place == [[56.0, 3.5]] and "at (56.0, 3.5)" in text
    assert np.median(given["far_points"][objects == 119, 0]) < 56 - 1
    assert np.median(given["far_points"][objects == 96, 0]) > 56 + 1


def test_joining_without_measuring_acts_like_a_larger_threshold(obstacles):
    cells, _, which = LESSON.points_in_cells(obstacles, 0.5)
    pairs, _ = LESSON.join_cheaply(obstacles, cells, np.zeros(len(cells), int), 0.5)
    joined = LESSON.components(len(cells), pairs).max() + 1
    small, large = (
        LESSON.euclidean_clustering_accelerated(obstacles, threshold) for threshold in (0.85, 0.75)
    )
    assert small.max() < joined < large.max()


@pytest.mark.slow
def test_one_object_in_five_is_split_if_only_adjacent_cells_are_compared(obstacles, right_labels):
    cells, first, which = LESSON.points_in_cells(obstacles, 0.5)
    pairs = cKDTree(cells).query_pairs(1, p=np.inf, output_type="ndarray")
    label = LESSON.join_exactly(obstacles, which, pairs, np.arange(len(cells)), 0.5)[which]
    parts = np.unique(np.stack([right_labels, label]), axis=1)[0]
    assert np.mean(np.bincount(parts) > 1) == pytest.approx(0.2, abs=0.03)


def test_an_order_mistaken_for_ranks_gets_a_note():
    def clustering(cloud, threshold=0.5):
        points = cloud[:, :3]
        cells, first, cell_of_point = LESSON.points_in_cells(points, threshold)
        pairs, label = LESSON.join_cheaply(points, cells, first, threshold)
        label = LESSON.join_exactly(points, cell_of_point, pairs, label, threshold)
        _, start, which = np.unique(label[cell_of_point], return_index=True, return_inverse=True)
        return np.argsort(start)[which] + 1

    notes = notes_of("euclidean_clustering_accelerated")
    failed = {note.name for note in notes if run_check(note, clustering).failure}
    assert failed == {"numbers_by_appearance"}


def test_gaps_that_the_exact_step_leaves_get_only_notes():
    def clustering(cloud, threshold=0.5):
        points = cloud[:, :3]
        if len(points) == 0:
            return np.zeros(0, dtype=int)
        cells, first, cell_of_point = LESSON.points_in_cells(points, threshold)
        pairs, label = LESSON.join_cheaply(points, cells, first, threshold)
        return (
            LESSON.join_exactly(points, cell_of_point, pairs, label, threshold)[cell_of_point] + 1
        )

    name = "euclidean_clustering_accelerated"
    assert not [check.name for check in checks_of(name) if run_check(check, clustering).failure]
    failed = {note.name for note in notes_of(name) if run_check(note, clustering).failure}
    assert failed == {"leaves_no_gaps", "numbers_by_appearance"}


def test_representatives_alone_tear_other_clusters_in_a_moved_cloud(obstacles, right_labels):
    def torn(points):
        _, first, cell_of_point = LESSON.points_in_cells(points, 0.5)
        label = LESSON.join_all_pairs(points[first])[cell_of_point]
        parts = np.unique(np.stack([right_labels, label]), axis=1)[0]
        return set(np.flatnonzero(np.bincount(parts) > 1).tolist())

    before = torn(obstacles)
    for move in ([0.1, 0, 0], [0, 0.1, 0]):
        after = torn(obstacles + move)
        assert len(before & after) > 10 and before - after and after - before


def test_a_torn_part_gets_a_colour_that_is_not_used_near_it(obstacles, right_labels):
    """Seven colours are used in turn. The lesson draws this end of the street."""
    x, y, _ = obstacles.T
    seen = (x > 20) & (x < 40) & (np.abs(y) < 7)
    points, whole = obstacles[seen, :2], right_labels[seen] + 1
    parts = LESSON.after_two_steps(obstacles)[0][seen]
    labels = LESSON.with_other_colours(points, whole, parts)
    new = np.unique(labels[labels != whole])
    assert len(new) > 3 and len(np.unique(labels)) == len(np.unique(parts))
    for label in new:
        chosen = labels == label
        away = np.linalg.norm(points - np.median(points[chosen], axis=0), axis=1)
        assert away[~chosen & (labels % 7 == label % 7)].min(initial=99) > 4.5


def test_same_clusters_compares_both_ways():
    assert LESSON.same_clusters(np.array([5, 5, 2]), np.array([0, 0, 1]))
    assert not LESSON.same_clusters(np.array([1, 2, 3]), np.array([0, 0, 1]))
    assert not LESSON.same_clusters(np.array([0, 0, 1]), np.array([1, 2, 3]))


def test_the_solution_is_as_long_as_promised():
    """Compare "roughly N lines" with the solution, counting a wrapped line once."""
    text = find_lesson(NAME).source.read_text("utf-8")
    for name in (*STEPS, "euclidean_clustering_accelerated"):
        body = text[text.index(f"\ndef {name}(") :]
        promised = int(body.split("# roughly ")[1].split()[0])
        solution = body.split("### BEGIN SOLUTION\n")[1].split("### END")[0]
        lines = [line for line in solution.splitlines() if len(line) - len(line.lstrip()) < 24]
        assert abs(len(lines) - promised) <= 1, name


def test_the_first_argsort_lists_pieces_and_the_second_finds_their_places():
    pieces = np.array([7, 3, 7, 5])
    names, start = np.unique(pieces, return_index=True)
    in_order = np.argsort(start)
    assert names[in_order].tolist() == list(dict.fromkeys(pieces.tolist()))
    assert np.argsort(in_order).tolist() == [in_order.tolist().index(row) for row in range(3)]


@pytest.mark.slow
def test_the_fast_version_is_faster(obstacles):
    def seconds(cluster):
        start = process_time()
        cluster(obstacles)
        return process_time() - start

    # The two run alternately, so that a busy machine slows both. The text says more than 4, but
    # the ratio depends on the processor.
    versions = LESSON.euclidean_clustering_accelerated, LESSON.clustering_at_full_speed
    ratios = [seconds(versions[0]) / seconds(versions[1]) for _ in range(5)]
    assert np.median(ratios) > 2


def pairs_left_to_measure(points, monkeypatch):
    """Return how many pairs of cells the fast version measures after three for each cell."""
    steps, counts = LESSON.clustering_at_full_speed.__globals__, []
    original = steps["pairs_to_measure"]

    def counted(*arguments):
        pairs = original(*arguments)
        counts.append(len(pairs[0]))
        return pairs

    monkeypatch.setitem(steps, "pairs_to_measure", counted)
    LESSON.clustering_at_full_speed(points)
    return counts[0]


def test_three_neighbours_of_each_cell_settle_nine_of_ten_pairs(obstacles, monkeypatch):
    _, _, pairs, _ = LESSON.after_two_steps(obstacles)
    assert pairs_left_to_measure(obstacles, monkeypatch) / pairs == pytest.approx(0.1, abs=0.03)


def test_consecutive_points_often_share_a_cell(obstacles):
    _, _, cell_of_point = LESSON.points_in_cells(obstacles, 0.5)
    assert np.mean(cell_of_point[1:] == cell_of_point[:-1]) > 0.5


RNG = np.random.default_rng(11)


@pytest.mark.parametrize(
    ("points", "threshold"),
    [
        pytest.param(RNG.uniform(0, [30, 20, 3], (1500, 3)), 0.8, id="sparse"),
        pytest.param(RNG.uniform(0, [1, 1, 90], (3000, 3)), 0.3, id="a tower"),
        pytest.param(RNG.uniform(0, [90, 1, 1], (3000, 3)), 0.3, id="a beam"),
        pytest.param(RNG.uniform(0, 8, (3000, 3)).repeat(2, axis=0), 0.4, id="duplicates"),
        pytest.param(RNG.uniform(0, 8, (3000, 4)).astype(np.float32), 0.4, id="float32"),
        pytest.param(RNG.uniform(-1, 1, (500, 3)) + [1000, -1000, 50], 0.1, id="far away"),
        pytest.param(
            RNG.normal(size=(500, 3)) * 10.0 ** (np.arange(500)[:, None] % 13), 2.0, id="wide"
        ),
        pytest.param(np.zeros((1, 3)), 0.5, id="one point"),
        pytest.param(np.zeros((0, 4)), 0.5, id="no points"),
    ],
)
def test_the_fast_version_is_exact(points, threshold):
    labels = LESSON.clustering_at_full_speed(points, threshold)
    assert labels.shape == (len(points),)
    assert LESSON.same_clusters(labels, LESSON.join_all_pairs(points[:, :3], threshold))
    _, start = np.unique(labels, return_index=True)
    assert (np.diff(start) > 0).all() and labels[:1].tolist() in ([1], [])


def test_the_fast_version_leaves_invalid_points_alone(obstacles):
    points = obstacles[::40].copy()
    right = LESSON.join_all_pairs(points) + 1
    invalid = RNG.random(len(points)) < 0.1
    points[invalid, 1] = np.nan
    kept = LESSON.join_all_pairs(points[~invalid])
    labels = LESSON.clustering_at_full_speed(points)
    assert LESSON.same_clusters(labels[~invalid], kept) and not LESSON.same_clusters(labels, right)
    assert len(np.unique(labels)) == kept.max() + 1 + invalid.sum()
    for threshold in (0.0, -1.0):
        every = LESSON.clustering_at_full_speed(points, threshold)
        assert every.tolist() == list(range(1, len(points) + 1))


def test_the_fast_version_is_not_released():
    released = find_lesson(NAME).released.read_text("utf-8")
    for word in ("pairs_to_measure", "join_by_tree", "searchsorted"):
        assert word not in released


@pytest.mark.parametrize("quadratic", [True, False])
def test_the_trap_stops_functions_that_would_fill_the_memory(quadratic, capsys):
    sizes = []

    def use_time(cloud):
        sizes.append(len(cloud))
        n = len(cloud) / 1000
        until = process_time() + (0.03 * n**2 if quadratic else 0.03 * n)
        while process_time() < until:
            pass
        return np.zeros(len(cloud), int)

    LESSON.spring_the_trap(use_time, most=6_000)
    output = capsys.readouterr().out
    assert ("Stopped" in output) == quadratic
    assert (max(sizes) == 6_000) == quadratic  # at most 3,000 points in each heap
    assert "GB" in output.split("Stopped")[0]


def test_an_answer_follows_the_hints():
    names = [variant.name for variant in answers_to("euclidean_clustering_accelerated")]
    assert "the hints followed to the letter, in three steps" in names


def test_the_autograded_copy_keeps_the_students_steps():
    """The steps carry no points, but the graded function calls them."""
    lesson = find_lesson(NAME)
    notebook = json.loads(lesson.released.read_text("utf-8"))
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("grade_id") in STEPS:
            cell["source"] = [f"{cell['metadata']['nbgrader']['grade_id']} = print  # mine"]
    copy = build_copy(
        prepare(SubmittedFiles(f"{NAME}.ipynb", json.dumps(notebook).encode()), lesson)
    )
    for name in STEPS:
        found = [cell for cell in copy.cells if f"{name} = print" in cell.source]
        assert [cell.metadata.nbgrader.grade_id for cell in found] == [name]
        assert not any(f"def {name}(" in cell.source for cell in copy.cells)


def test_the_reference_time_is_never_zero():
    """A reference time of 0 would make every answer look slow on a fast machine."""
    cloud = np.random.default_rng(1).normal(size=(50, 3))
    with limited_cpu_time(60):
        assert min(_seconds_to_find_neighbours(cloud) for _ in range(200)) > 0
