"""A stub returns the course's stored answer and says so, so that students can continue."""

import json
import types
from dataclasses import dataclass, field

import numpy as np
import pytest

import utils
from grader.course.recorded_answers import changed_answers
from tests.lesson_texts import FOLLOWS_HINTS, source_of
from utils import lent
from utils.breaking import show_broken, tell_apart
from utils.lent import encoding
from utils.replays import ransac


@dataclass
class Node:
    value: float
    below: list = field(default_factory=list)


@dataclass(frozen=True)
class Pair:
    first: np.ndarray
    second: str


CLOUD = np.random.default_rng(1).normal(size=(500, 4))


@pytest.mark.parametrize(
    "answer",
    [
        None,
        True,
        7,
        -2.5,
        "text",
        [1, [2.5, None]],
        (1, (2, "b")),
        {"a": 1, 3: [2]},
        np.arange(12).reshape(3, 4),
        np.array([True, False]),
        np.empty((0, 8, 3)),
        np.array(3.5),
        np.linspace(-40, 80, 999).reshape(-1, 3),
        np.array([np.nan, np.inf, 1.0] * 40),
        np.zeros(0, dtype=int),
        np.array([[2**40, -3]]),
    ],
    ids=repr,
)
def test_a_stored_answer_can_be_restored(answer):
    stored = json.loads(json.dumps(encoding.encode(answer)))
    back = encoding.decode(stored, (), {})
    if isinstance(answer, np.ndarray):
        assert back.shape == answer.shape
        assert back.dtype.kind == answer.dtype.kind
        np.testing.assert_allclose(back, answer, atol=1e-4)
    else:
        assert back == answer
        assert type(back) is type(answer)


def test_kept_rows_are_stored_as_indices():
    kept = CLOUD[CLOUD[:, 2] > 0]
    stored = encoding.encode(kept, (CLOUD,))
    assert len(json.dumps(stored)) < 200
    assert np.array_equal(encoding.decode(stored, (CLOUD,), {}), kept)


def test_renamed_labels_are_stored_as_pairs():
    labels = np.repeat([0, 4, 9, 2], 50)
    renamed = np.where(labels == 4, 0, labels)
    stored = encoding.encode(renamed, (labels,))
    assert len(json.dumps(stored)) < 100
    assert np.array_equal(encoding.decode(stored, (labels,), {}), renamed)


def test_a_deep_tree_is_restored():
    root = node = Node(0.0)
    for depth in range(5000):
        node.below.append(Node(depth / 2))
        node = node.below[0]
    back = encoding.decode(encoding.encode(root), (), {"Node": Node})
    depth = 0
    while back.below:
        back, depth = back.below[0], depth + 1
    assert (depth, back.value) == (5000, 2499.5)
    assert encoding.key_of((root,), {}) != encoding.key_of((root.below[0],), {})


def test_an_object_of_a_frozen_class_is_restored():
    pair = encoding.decode(encoding.encode([Pair(np.ones(3), "b")]), (), {"Pair": Pair})[0]
    assert pair.second == "b" and pair.first.tolist() == [1, 1, 1]


def test_a_value_that_cannot_be_stored_is_refused():
    with pytest.raises(TypeError, match="of type function cannot be stored"):
        encoding.encode(lambda: 0)


def test_different_calls_have_different_keys():
    rng = np.random.default_rng(3)
    calls = [
        (CLOUD,),
        (CLOUD[:, :3],),
        (-CLOUD,),
        (CLOUD[::-1],),
        (CLOUD, 0.2),
        (CLOUD, 0.3),
        (rng,),
        (np.random.default_rng(4),),
        ([1, 2],),
        ((1, 2), None),
        (Node(1.0),),
        (Node(2.0),),
    ]
    assert len({encoding.key_of(call, {}) for call in calls}) == len(calls)


def test_keys_of_calls_ignore_the_last_digits():
    slightly = CLOUD * (1 + 1e-15)
    assert encoding.key_of((CLOUD, 0.1 + 0.2), {}) == encoding.key_of((slightly, 0.3), {})


def stub(cloud, level=0.0):
    """Raise NotImplementedError, after a docstring and a plan as in the lessons' stubs."""
    # 1. a step
    raise NotImplementedError()


def written(cloud, level=0.0):
    return cloud[cloud[:, 2] >= level]


def record_answers(functions, calls, experiments=()):
    names = [name for name in functions if name not in experiments]
    recorder = lent.Recorder(names, list(experiments), functions)
    recorder.wrap_stubs()
    for name, arguments in calls:
        functions[name](*arguments)
    stored = json.loads(recorder.text())
    assert stored.pop("faults") == []
    return stored


def test_a_stub_answers_the_calls_of_the_notebook(capsys):
    stored = record_answers({"keep": written}, [("keep", (CLOUD,)), ("keep", (CLOUD, 1.0))])
    namespace = {"keep": stub}
    lent.Lender(stored, namespace).wrap_stubs()
    assert np.array_equal(namespace["keep"](CLOUD, 1.0), written(CLOUD, 1.0))
    assert "the course's answer; yours is not written yet" in capsys.readouterr().out
    with pytest.raises(NotImplementedError, match="stub is not written yet, and the course has"):
        namespace["keep"](CLOUD, 2.0)


def test_a_written_function_is_not_replaced():
    stored = record_answers({"keep": written}, [("keep", (CLOUD,))])
    mine = types.FunctionType(written.__code__, {}, "keep")
    namespace = {"keep": mine}
    lent.Lender(stored, namespace).wrap_stubs()
    assert namespace["keep"] is mine


def test_a_stored_result_replaces_an_experiment_that_calls_a_stub(capsys):
    def experiment(cloud):
        return [len(namespace["keep"](cloud, level)) for level in (0, 1, 2)]

    namespace = {"keep": written, "experiment": experiment}
    calls = [("experiment", (CLOUD,))]
    stored = record_answers(namespace, calls, ["experiment"])
    assert stored["exercises"]["keep"] == {}
    expected = [int((CLOUD[:, 2] >= level).sum()) for level in (0, 1, 2)]

    namespace = {"keep": stub, "experiment": experiment}
    lent.Lender(stored, namespace).wrap_stubs()
    assert namespace["experiment"](CLOUD) == expected
    output = capsys.readouterr().out
    assert "experiment: this is the course's answer; stub is not written yet." in output
    namespace["keep"] = lambda cloud, level: cloud[:0]
    assert namespace["experiment"](CLOUD) == [0, 0, 0]


def test_a_generator_continues_as_after_the_real_call():
    def shuffled(rng):
        return rng.permutation(6)

    stored = record_answers({"shuffled": shuffled}, [("shuffled", (np.random.default_rng(5),))])
    namespace = {"shuffled": stub}
    lent.Lender(stored, namespace).wrap_stubs()
    mine, other = np.random.default_rng(5), np.random.default_rng(5)
    assert np.array_equal(namespace["shuffled"](mine), shuffled(other))
    assert mine.integers(1000) == other.integers(1000)


def test_a_check_calls_the_stub_itself():
    from utils import check
    from utils.checks.core import ChecksFailed

    def filter_ground(cloud, ground_level=-1.2):
        raise NotImplementedError

    namespace = {"filter_ground": filter_ground}
    lent.Lender({"exercises": {"filter_ground": {}}}, namespace).wrap_stubs()
    assert lent.own(namespace["filter_ground"]) is filter_ground
    with pytest.raises(ChecksFailed, match="filter_ground is not started"):
        check(namespace["filter_ground"])


# Exercises that call other exercises of their lesson, and those that are called.
HELPERS = {
    "ransac_line": ("line_through", "point_line_distance"),
    "ransac_plane": ("plane_through", "point_plane_distance"),
    "euclidean_clustering_accelerated": ("points_in_cells",),
    "get_oriented_boxes": ("principal_axes",),
}
# Kept answers that define their helpers themselves.
VARIANTS = {
    "euclidean_clustering_accelerated": f"{FOLLOWS_HINTS}, in three steps",
    "get_oriented_boxes": f"{FOLLOWS_HINTS}, principal axes in the plane",
}


def notebook_without(helper, exercise):
    """Return a notebook's namespace, with an exercise and its helpers but a stub of one helper."""
    names = {"np": np}
    for name in HELPERS[exercise] if "ransac" in exercise else ():
        exec(source_of(name), names)
    exec(source_of(exercise, VARIANTS.get(exercise, FOLLOWS_HINTS)), names)
    exec(f"def {helper}(*arguments):\n    raise NotImplementedError", names)
    kinds = {"exercises": dict.fromkeys((*HELPERS[exercise], exercise), {})}
    lent.Lender(kinds, names).wrap_stubs()
    assert hasattr(names[helper], "is_lent_answers")
    return names


@pytest.mark.parametrize(
    ("exercise", "helper"), [(name, helper) for name in HELPERS for helper in HELPERS[name]]
)
def test_a_check_names_the_unwritten_helper_and_not_its_caller(exercise, helper, capsys):
    from utils import check
    from utils.checks.core import ChecksFailed

    names = notebook_without(helper, exercise)
    sentence = f"{exercise} calls {helper}, which is not written yet. Write {helper} first."
    with pytest.raises(ChecksFailed, match=sentence):
        check(names[exercise])
    output = capsys.readouterr().out
    assert sentence in output and "is not started" not in output


@pytest.mark.parametrize("exercise", ["ransac_line", "ransac_plane"])
@pytest.mark.parametrize("position", [0, 1])
def test_a_player_stops_at_an_unwritten_helper_without_blame(exercise, position):
    helper = HELPERS[exercise][position]
    function = notebook_without(helper, exercise)[exercise]
    run = getattr(ransac, f"replay_{exercise}")(function)
    assert run.fault is None and len(run.steps) == 1
    assert run.remark.endswith(f" {helper} is not written yet, so the player cannot continue.")


def test_broken_versions_wait_for_an_unwritten_helper(capsys):
    boxes = notebook_without("principal_axes", "get_oriented_boxes")["get_oriented_boxes"]
    show_broken(boxes)
    sentence = "principal_axes is not written yet, so nothing can be compared."
    assert capsys.readouterr().out == sentence + "\n"
    tell_apart(boxes, A=[[0, 0, 0, 1], [4, 1, 2, 1]])
    assert f"A ✗ {sentence}" in capsys.readouterr().out


def test_calls_of_a_check_are_not_recorded():
    """Calls that a checked function makes to other functions are not recorded either."""

    def check(function):
        assert len(function(CLOUD, 3.0)) == int((CLOUD[:, 2] >= 3.0).sum())
        raise AssertionError("one did not pass")

    namespace = {"keep": written, "check": check}
    namespace["keep_twice"] = lambda cloud, level: namespace["keep"](cloud, level)
    recorder = lent.Recorder(["keep"], [], namespace)
    recorder.wrap_stubs()
    recorder.wrap_stubs()
    with pytest.raises(AssertionError, match="did not pass"):
        namespace["check"](namespace["keep_twice"])
    assert json.loads(recorder.text())["exercises"]["keep"] == {}
    namespace["keep_twice"](CLOUD, 3.0)
    assert len(json.loads(recorder.text())["exercises"]["keep"]) == 1


def test_calls_are_not_recorded_in_the_cell_that_imports_the_caller(monkeypatch):
    monkeypatch.setattr("utils.lent.recorder.CALLERS", ("ask_about",))
    monkeypatch.setattr(utils, "ask_about", lambda function: function(CLOUD, 3.0))
    namespace = {"keep": written}
    recorder = lent.Recorder(["keep"], [], namespace)
    recorder.wrap_callers()
    recorder.wrap_stubs()
    exec("from utils import ask_about\nask_about(keep)", namespace)
    assert json.loads(recorder.text())["exercises"]["keep"] == {}
    exec("keep(CLOUD, 3.0)", {**namespace, "CLOUD": CLOUD})
    assert len(json.loads(recorder.text())["exercises"]["keep"]) == 1


def test_stubs_are_distinguished_from_written_functions():
    assert not lent.is_written(stub)
    assert lent.is_written(written) and lent.is_written(len)

    def with_a_given_line(rng):
        rng = np.random.default_rng(rng)
        raise NotImplementedError

    def begun(cloud):
        if len(cloud) == 0:
            return cloud
        raise NotImplementedError

    assert not lent.is_written(with_a_given_line)
    assert lent.is_written(begun)
    namespace = {"keep": stub}
    lent.Lender({"exercises": {"keep": {}}}, namespace).wrap_stubs()
    assert not lent.is_written(namespace["keep"])


def test_lending_answers_without_a_notebook_does_nothing():
    lent.lend_answers("06")


def test_a_stored_answer_can_be_queried():
    line = tuple(np.random.default_rng(8).normal(size=(500, 3)).ravel())
    back = encoding.decode(json.loads(json.dumps(encoding.encode(line))), (), {})
    assert encoding.key_of((back,), {}) == encoding.key_of((line,), {})


def test_a_changed_experiment_is_recorded_again():
    namespace = {}
    exec(
        "def one(a):\n    return a + 1\ndef all(n):\n    return sum(map(one, range(n)))", namespace
    )
    lender = lent.Lender({"exercises": {"one": {}}, "experiments": {"all": {}}}, namespace)
    recorder = lent.Recorder(["one"], ["all"], namespace)
    for _ in range(2):
        lender.wrap_stubs()
        recorder.wrap_stubs()
    assert namespace["all"](4) == 10
    recorded = json.loads(recorder.text())
    assert [entry["answer"] for entry in recorded["experiments"]["all"].values()] == [10]
    assert recorded["exercises"]["one"] == {}


def test_an_experiment_is_recorded_again_although_it_is_stored():
    namespace = {"experiment": len}
    lent.Lender({"experiments": {"experiment": {}}}, namespace).wrap_stubs()
    stored = record_answers(namespace, [("experiment", ([1, 2],))], ["experiment"])
    assert [entry["answer"] for entry in stored["experiments"]["experiment"].values()] == [2]


def stored_answers(**answers):
    """Return stored answers, with one call for each function."""
    functions = {name: {"key": {"answer": answer}} for name, answer in answers.items()}
    return json.dumps({"functions": functions}).encode()


def test_changed_answers_are_listed():
    cloud = encoding.encode(CLOUD[:3])
    before = stored_answers(box=[1.0, [2, None]], mask=cloud, count=7)
    assert changed_answers(before, before) == []
    assert changed_answers(before, stored_answers(box=[1.01, [2, None]], mask=cloud, count=7)) == []
    now = stored_answers(box=[1.2, [2, None]], mask=encoding.encode(CLOUD[:2]), count=8)
    assert changed_answers(before, now) == ["box", "count", "mask"]
    assert changed_answers(before, stored_answers(box=[1.0, 2], mask=None, count=7)) == [
        "box",
        "mask",
    ]
    assert changed_answers(before, stored_answers(count=7)) == ["box", "mask"]
    assert changed_answers(b"{}", before) == ["box", "count", "mask"]
