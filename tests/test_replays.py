"""Replays show a run as it happened, and mark a step as wrong only if it certainly is."""

import contextlib
import io
import math
import re
import sys
import threading
from collections import deque
from types import SimpleNamespace

import ipywidgets
import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components
from scipy.spatial.distance import cdist, pdist

from grader.course.kept_answers import answers_to
from tests.lesson_texts import source_of
from utils import replay, static_widgets
from utils.geometry import grow_tree
from utils.replays import clustering, play, player, ransac, tracer, walk
from utils.replays.clustering.points import GROUPS, POINTS, THRESHOLD
from utils.replays.ransac.tasks import LINE, PLANE, ROUNDS
from utils.visits import watched

HELPERS = {
    "ransac_line": ("line_through", "point_line_distance"),
    "ransac_plane": ("plane_through", "point_plane_distance", "fit_plane"),
    "euclidean_clustering": (),
    "search": (),
}
RUNS = {
    "ransac_line": ransac.replay_ransac_line,
    "ransac_plane": ransac.replay_ransac_plane,
    "euclidean_clustering": clustering.replay_clustering,
}


def function_of(exercise, source=None, name="the hints followed to the letter"):
    """Return a function as a notebook would define it, with its lesson's helpers."""
    space = {"np": np, "deque": deque, "math": math, "dist": math.dist, "__name__": "notebook"}
    for helper in HELPERS[exercise]:
        exec(source_of(helper), space)
    exec((source or source_of(exercise, name)).replace("%%time", ""), space)
    return space[exercise]


def run_of(exercise, name="the hints followed to the letter", source=None):
    with contextlib.redirect_stdout(io.StringIO()):  # some answers print a lot
        return RUNS[exercise](function_of(exercise, source, name))


def answer_names(exercise, right):
    return [answer.name for answer in answers_to(exercise) if answer.right is right]


# ---- the scenes --------------------------------------------------------------------------------


def test_groups_match_scipy_and_no_distance_is_at_the_threshold():
    gaps = cdist(POINTS[:, :3], POINTS[:, :3])
    labels = connected_components(gaps < THRESHOLD)[1]
    assert {frozenset(np.flatnonzero(labels == label).tolist()) for label in set(labels)} == {
        frozenset(group) for group in GROUPS
    }
    assert np.abs(pdist(POINTS[:, :3]) - THRESHOLD).min() > 0.02


@pytest.mark.parametrize("task", [LINE, PLANE], ids=["line", "plane"])
def test_one_round_is_best_and_no_point_is_at_the_tolerance(task):
    rng, counts = np.random.default_rng(task.seed), []
    for _ in range(ROUNDS):
        sample = task.xyz[rng.choice(len(task.points), task.size, replace=False)]
        if task is LINE:  # distance: twice the area of a triangle, divided by its base
            base = np.append(sample[1] - sample[0], 0)
            arms = np.column_stack([task.xyz - sample[0], np.zeros(len(task.xyz))])
        else:
            base = np.cross(sample[1] - sample[0], sample[2] - sample[0])
            arms = task.xyz - sample[0]
        area = np.cross(arms, base)[:, 2] if task is LINE else arms @ base
        gaps = np.abs(area) / np.linalg.norm(base)
        counts.append((gaps <= task.tolerance).sum())
        assert np.abs(gaps - task.tolerance).min() > 1e-4
    assert sorted(counts)[-1] > sorted(counts)[-2] and counts[0] < max(counts) > counts[-1]
    assert len(np.unique(task.xyz, axis=0)) == len(task.xyz)


# ---- right answers -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("exercise", "name"),
    [(exercise, name) for exercise in RUNS for name in answer_names(exercise, right=True)],
)
def test_right_answers_have_no_wrong_step(exercise, name):
    run = run_of(exercise, name)
    assert run.fault is None and len(run.steps) >= 1


@pytest.mark.parametrize("exercise", RUNS)
def test_watching_does_not_change_the_answer(exercise):
    task = {"ransac_line": LINE, "ransac_plane": PLANE}.get(exercise)
    given = (POINTS, THRESHOLD) if task is None else (task.points, ROUNDS, task.tolerance, 3)
    for answer in answers_to(exercise):
        if answer.right:
            function = function_of(exercise, answer.source)
            with contextlib.redirect_stdout(io.StringIO()):
                alone = function(given[0].copy(), *given[1:])
                seen = tracer.record(function, (given[0].copy(), *given[1:]), lambda *_: None)
            answers = (alone, seen.answer) if task is None else zip(alone, seen.answer, strict=True)
            for before, after in [answers] if task is None else answers:
                np.testing.assert_array_equal(before, after)


def test_the_queue_matches_the_table_in_the_lesson():
    texts = [step.description for step in run_of("euclidean_clustering").steps]
    assert texts[1:7] == [
        "Point 0 gets label 1. In the queue: 0.",
        "Point 0 is visited. Points 2 and 4 get label 1. In the queue: 2, 4.",
        "Point 2 is visited. Point 5 gets label 1. In the queue: 4, 5.",
        "Point 4 is visited. No point gets a label. In the queue: 5.",
        "Point 5 is visited. No point gets a label. In the queue: no point.",
        "Point 1 gets label 2. In the queue: 1.",
    ]
    assert len(texts) == 1 + len(GROUPS) + len(POINTS)


CLASS_WITH_A_STACK = """
class Crowd:
    def __init__(self, where, reach):
        self.where, self.reach = where[:, :3], reach
        self.whose, self.todo = np.full(len(where), np.nan), [9]

    def ask(self):
        who = self.todo.pop()
        for other in range(len(self.where)):
            way = self.where[other] - self.where[who]
            if way @ way < self.reach ** 2 and np.isnan(self.whose[other]):
                self.whose[other] = self.whose[who]
                self.todo += [other]

def euclidean_clustering(cloud, threshold=0.5):
    crowd, count = Crowd(cloud, threshold), 0
    for row in range(len(cloud)):
        if np.isnan(crowd.whose[row]):
            count += 1
            crowd.whose[row] = count
            crowd.todo[:] = [row]
            while crowd.todo:
                crowd.ask()
    return crowd.whose.astype(int).tolist()
"""


def test_the_replay_follows_a_class_with_a_stack_and_nan_labels():
    run = run_of("euclidean_clustering", source=CLASS_WITH_A_STACK)
    texts = [step.description for step in run.steps]
    assert run.fault is None
    assert "Point 0 is visited. Points 2 and 4 get label 1. In the queue: 2, 4." in texts
    assert "Point 4 is visited. Point 5 gets label 1. In the queue: 2, 5." in texts


def test_rounds_show_the_samples_of_the_generator():
    rng = np.random.default_rng(LINE.seed)
    for number, step in enumerate(run_of("ransac_line").steps[:ROUNDS], start=1):
        first, second = rng.choice(20, size=2, replace=False)
        assert step.description.startswith(
            f"Round {number}: points {first} and {second} are drawn."
        )


# ---- wrong answers -----------------------------------------------------------------------------

# For each wrong answer, the text of the step that is marked as wrong, and part of the reason.
WRONG = {
    "euclidean_clustering": {
        "compares with the first point of the cluster only": ("Point 5 gets label 3", "point 2"),
        "labels from 0": ("Point 0 gets label 0", "be 1 to 5"),
        "compares the squared distance with the threshold": (
            "Point 6 is visited",
            "8 and 6 have the same",
        ),
        "compares the distance with the squared threshold": (
            "Point 3 is visited",
            "Point 7 is 0.71 m away",
        ),
        "uses intensity as a coordinate": ("Point 0 is visited", "Point 2 is 0.47 m away"),
        "forgets the height": ("Point 1 is visited", "and 9 have the same label"),
        "the threshold is written into the function": ("Point 3 is visited", "Point 7 is 0.71 m"),
        "a cluster never ends": ("Point 0 is visited", "for the second time"),
        "everything is one cluster": ("Labels of points", "no chain of points"),
        "every point is its own cluster": ("Labels of points", "closer than 0.8 m"),
        "each point gets the label of an earlier neighbour": (
            "Point 11 gets label 4",
            "point 10 has 6",
        ),
        "increases the counter at every point": ("Point 6 gets label 7", "be 1 to 5"),
        "returns after the first cluster": ("Point 5 is visited", "got no label"),
        "distances without an axis": ("Point 2 gets label 3", "point 0 has 1"),
        "distances along the wrong axis": ("Point 0 gets label 1", "raised ValueError"),
        "append instead of extend": ("Points 2 and 4 get label 1", "raised ValueError"),
        "no parentheses around the masks": ("Point 0 gets label 1", "raised TypeError"),
        "adds the distances along the axes": ("Point 3 is visited", "Point 7 is 0.71 m away"),
        "takes the longest distance along an axis": (
            "Point 6 is visited",
            "8 and 6 have the same label",
        ),
        "forgets to return": ("Point 9 is visited", "returned None"),
        "puts a mask into the queue": ("Points 2 and 4 get label 1", "raised ValueError"),
        "uses np.where, which returns a tuple": ("Points 2 and 4 get label 1", "raised ValueError"),
    },
    "ransac_line": {
        "the last line instead of the best": (
            "Round 10",
            "Round 4 has 10 points within the threshold",
        ),
        "replaces only the line, not the mask": ("Round 10", "but yours has 0"),
        "the line with the fewest inliers": ("Round 4", "is the line of round 2, with 2"),
        "the mask of the last round, the line of the best": (
            "Round 10",
            "the mask of round 10",
        ),
        "no absolute value": ("Round 1", "Your mask has 17 points"),
        "the tolerance is squared": ("Round 1", "Your mask has 3 points"),
        "the normal is not normalised": ("Round 1", "They are not the same points"),
        "always three hundred rounds": ("Round 11", "one sample more"),
        "always fifty rounds": ("Round 11", "one sample more"),
        "indices instead of a mask": ("Round 10", "and the mask of its inliers"),
        "mask first, then the line": ("Round 10", "in this order"),
        "returns the line only": ("Round 10", "and the mask of its inliers"),
        "the points instead of a mask": ("Round 10", "and the mask of its inliers"),
        "outliers instead of inliers": ("Round 1", "Your mask has 16 points"),
    },
    "ransac_plane": {
        "the last sample wins": ("Round 10", "Round 5 has 36 points within the threshold"),
        "keeps the worst": ("Round 5", "of round 2, with 7"),
        "refits the plane and keeps the old mask": ("Your answer", "They are not the same points"),
        "always three hundred iterations": ("Round 11", "one sample more"),
        "always fifty iterations": ("Round 11", "one sample more"),
        "indices instead of a mask": ("Round 10", "in this order"),
        "returns only the model": ("Round 10", "in this order"),
        "inliers before model": ("Round 10", "in this order"),
        "outliers instead of inliers": ("Round 5", "yours has 28"),
        "four columns in the sample": ("Round 1", "raised ValueError"),
        "every point is an inlier of a flat road": ("Your answer", "Your mask has 64 points"),
        "the mask of the last sample": ("Round 10", "the mask of round 10"),
        "the model of the last sample": ("Round 10", "the mask of round 5"),
        "makes the normal long at the end": ("Your answer", "has length"),
    },
}


@pytest.mark.parametrize(
    ("exercise", "name"),
    [(exercise, name) for exercise in RUNS for name in answer_names(exercise, right=False)],
)
def test_the_replay_of_a_wrong_answer_marks_the_wrong_step(exercise, name, monkeypatch):
    monkeypatch.setattr(tracer, "SECONDS", 1)
    run = run_of(exercise, name)
    step_text, reason = WRONG[exercise].get(name, (None, None))
    if step_text is None:
        assert run.fault is None
        assert run.steps or run.remark
    else:
        assert step_text in run.steps[run.fault.step].description
        assert reason in run.fault.reason


def test_a_wrong_line_is_distinguished_from_a_wrong_search():
    function = function_of("ransac_line")
    exec("def line_through(p, q):\n    return 0.0, 1.0, -q[1]", function.__globals__)
    run = ransac.replay_ransac_line(function)
    assert run.fault.step == 0 and "Look at line_through" in run.fault.reason
    exec(source_of("line_through"), function.__globals__)
    assert ransac.replay_ransac_line(function).fault is None


def test_a_point_drawn_twice_is_reported():
    source = source_of("ransac_line").replace("i, j = rng.choice", "i, j = 2 * [rng.choice(20)]  #")
    run = run_of("ransac_line", source=source)
    assert run.fault.step == 0 and "was drawn twice" in run.fault.reason


@pytest.mark.slow
def test_choosing_by_distance_instead_of_count_is_accepted():
    """The replay accepts MSAC, which the lesson suggests, although it chooses other samples."""
    source = source_of("ransac_line").replace(
        "if mask.sum() > best_mask.sum()",
        "cost = np.sum(np.minimum(point_line_distance(points, candidate), 0.5) ** 2)\n"
        "        if best_line is None or cost < least",
    ).replace("best_line = candidate", "best_line, least = candidate, cost")  # fmt: skip
    disagree = 0
    for seed in range(20):
        run = ransac.replay_search(seeded_task(seed), function_of("ransac_line", source))
        assert run.fault is None
        best = max(int(step.description.split("drawn. ")[1].split()[0]) for step in run.steps[:-1])
        disagree += f"with {best} inliers" not in run.steps[-1].description
    assert disagree


def seeded_task(seed):
    return type(LINE)(*(vars(LINE) | {"seed": seed}).values())


# ---- runs that cannot be shown or do not end ---------------------------------------------------


def test_a_remark_explains_runs_that_cannot_be_shown():
    union, at_once = (
        run_of("euclidean_clustering", "union-find"),
        run_of("ransac_line", "all samples at once"),
    )
    assert "its steps cannot be shown" in union.remark and len(union.steps) == 1
    assert "its rounds cannot be shown" in at_once.remark and len(at_once.steps) == 1


def test_compiled_code_is_not_shown_and_not_marked_as_wrong():
    inner = function_of("euclidean_clustering")

    class Compiled:
        __name__ = "euclidean_clustering"

        def __call__(self, cloud, threshold):
            return inner(cloud, threshold)

    run = clustering.replay_clustering(Compiled())
    assert run.fault is None and "cannot be shown" in run.remark


ENDLESS = """
def euclidean_clustering(cloud, threshold=0.5):
    labels = np.zeros(len(cloud), dtype=int)
    while True:
        labels[0] = 1 - labels[0]
"""


@pytest.mark.parametrize("has_threads", [True, False])
def test_an_endless_run_is_stopped(has_threads, monkeypatch):
    monkeypatch.setattr(tracer, "SECONDS", 0.5)
    if not has_threads:  # Python in a browser has no threads

        def refuse(thread):
            raise RuntimeError("can't start new thread")

        monkeypatch.setattr(threading.Thread, "start", refuse)
    run = run_of("euclidean_clustering", source=ENDLESS)
    assert "was stopped" in run.remark and len(run.steps) <= clustering.MAX_STEPS
    assert sys.gettrace() is None


def test_an_earlier_trace_function_is_restored():
    lines = []

    def earlier_trace(frame, event, value):
        lines.append(event)

    before = sys.gettrace()
    sys.settrace(earlier_trace)
    try:
        run_of("ransac_line")
        assert sys.gettrace() is earlier_trace
    finally:
        sys.settrace(before)


def test_an_error_in_the_recorder_does_not_affect_the_answer():
    def broken(*_):
        raise KeyError

    ending = tracer.record(lambda x: x + 1, (1,), broken)
    assert ending.answer == 2 and sys.gettrace() is None


# ---- a search in a tree ------------------------------------------------------------------------

TREE_POINTS = [[-6, 0], [1, -2], [4, -1], [-2, 5], [-1, 1], [-7, 3], [-3, -9], [3, -7], [-9, -5],
           [-8, 6], [7, -6], [-4, -3], [6, 4], [5, 8], [0, 9]]  # fmt: skip
WRONG_SEARCHES = {
    "else instead of a second if": (2, "the right branch of node 1"),
    "visits every node": (13, "Nothing to its left can be near"),
    "visits every node but ignores those out of place": (13, "to its left can be near"),
    "prunes on one side only": (11, "Nothing to its left can be near"),
    "compares the squared distance with the tolerance": (6, "does not contain it"),
    "the sides are swapped": (1, "the right branch of node 0"),
    "the ends of the box are swapped": (2, "the right branch of node 1"),
    "returns at the first missing child": (3, "the left branch of node 2"),
    "the first axis is y": (6, "the left branch of node 3"),
    "returns every visited node": (1, "Node 0 is 8.1 m away"),
    "returns each index twice": (2, "2 times"),
    "loses the results from the left": (8, "Node 4 is 3.6 m away"),
    "forgets to return": (2, "does not contain it"),
    "skips everything below a distant node": (1, "the right branch of node 0"),
    "finds nothing": (0, "never visits any node"),
    "one if inside the other": (1, "the right branch of node 0"),
    "break instead of continue": (3, "the left branch of node 2"),
    "the depth does not grow on the left": (5, "the left branch of node 3"),
}


def walk_search(search, points=TREE_POINTS, goes_left=None):
    tree = SimpleNamespace(
        root=grow_tree(points, **({"goes_left": goes_left} if goes_left else {}))
    )
    with watched(tree) as visited, contextlib.redirect_stdout(io.StringIO()):
        found = search(tree, [2, -1], 4)
    return walk(tree.root, [2, -1], 4, visited, [] if found is None else sorted(found))


SEARCHES = [
    answer
    for answer in answers_to("search")
    if not re.search("class KdTree|NotImplementedError", answer.source)
    and "SciPy" not in answer.name
]


@pytest.mark.parametrize("answer", SEARCHES, ids=lambda variant: variant.name)
def test_the_replay_of_a_search_marks_the_wrong_step(answer):
    try:
        run = walk_search(function_of("search", answer.source))
    except TypeError:
        assert answer.name == "works on arrays only"
        return
    if answer.name in WRONG_SEARCHES:
        step, reason = WRONG_SEARCHES[answer.name]
        assert (run.fault.step, reason in run.fault.reason) == (step, True), run.fault
    else:
        assert run.fault is None
    if answer.right:
        assert len(run.steps) == 10


def test_a_wrong_tree_is_not_blamed_on_the_search():
    run = walk_search(
        function_of("search"), [[0, 0], [0, 3], [2, -1]], goes_left=lambda a, b: a <= b
    )
    assert run.fault is None and "insert" in run.remark


# ---- the player --------------------------------------------------------------------------------


@pytest.fixture
def shown_texts(monkeypatch):
    """Return a list that collects the player's texts, and "figure" for each figure."""
    seen = []
    monkeypatch.setattr(player, "show", lambda html, text: seen.append(text))
    monkeypatch.setattr(plt, "show", lambda: seen.append("figure") or plt.close("all"))
    return seen


def replace_interact(monkeypatch):
    """Replace `interact` with a version for tests; return a list that collects its sliders."""
    sliders = []

    def interact(step):
        def run(function):
            sliders.append(step)
            function(step.value)
            step.observe(lambda change: function(change["new"]), names="value")

        return run

    monkeypatch.setattr(ipywidgets, "interact", interact)
    return sliders


@pytest.mark.slow
def test_the_player_starts_at_the_first_wrong_step_and_has_buttons(shown_texts, monkeypatch):
    sliders = replace_interact(monkeypatch)
    play(run_of("euclidean_clustering", "forgets the height"))
    assert shown_texts[0] == "figure" and "✗ Wrong here." in shown_texts[1]
    (steps,) = sliders
    _, back, forward = steps.children
    start = steps.value
    back.click()
    assert steps.value == start - 1 and "✗" not in shown_texts[-1]
    steps.value = steps.max - 1
    for _ in range(3):
        forward.click()
    assert steps.value == steps.max and shown_texts.count("figure") == 4


def test_a_right_run_starts_at_its_first_step(shown_texts, monkeypatch):
    sliders = replace_interact(monkeypatch)
    play(run_of("ransac_plane"))
    assert sliders[0].value == 1 and not any("✗" in text for text in shown_texts)


@pytest.mark.slow
def test_replays_without_widgets_show_a_few_figures(shown_texts, monkeypatch):
    monkeypatch.setitem(sys.modules, "ipywidgets", None)
    del sys.modules["ipywidgets"]
    monkeypatch.setattr(static_widgets.util, "find_spec", lambda name: None)
    static_widgets.install_stand_in()
    try:
        play(run_of("ransac_line", "the tolerance is squared"))
        assert shown_texts.count("figure") == 1 and "✗" in shown_texts[-1]
        shown_texts.clear()
        play(run_of("ransac_line"))
        assert (
            shown_texts.count("figure") == player.STILL_PICTURES
            and "Your answer" in shown_texts[-1]
        )
    finally:
        del sys.modules["ipywidgets"]


@pytest.mark.slow
@pytest.mark.parametrize("exercise", RUNS)
def test_every_step_is_drawn(exercise):
    for step in run_of(exercise).steps:
        step.draw("a title")
        assert plt.gcf().axes[0].get_title(loc="left").startswith("a title")
        plt.close("all")


def test_stubs_and_other_functions_cannot_be_replayed(capsys):
    stub = "def euclidean_clustering(cloud, threshold=0.5):\n    raise NotImplementedError"
    replay(function_of("euclidean_clustering", stub))
    assert "not written yet" in capsys.readouterr().out
    with pytest.raises(LookupError, match="cannot be replayed"):
        replay(len)
