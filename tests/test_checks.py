"""The visible checks in a notebook: results, messages and tips."""

import copy
import importlib
import importlib.util
import math
import textwrap
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from scipy.sparse import coo_array

from grader.course.lessons import all_lessons, load_reference
from grader.course.paths import PROJECT
from grader.judging.messages import message_of, shareable_outcome
from grader.judging.runner import run_checks
from grader.sandbox import Limits
from grader.sandbox.inside import wire_format
from grader.sandbox.inside.wire_format import OpaqueValue
from utils.checks import CheckFailed, check, checks_of, core
from utils.checks.assertions import (
    as_array,
    as_labels,
    assert_all_columns,
    assert_empty_table,
    assert_order,
    assert_partition,
    assert_positions,
    assert_rows,
    assert_same_set_of_rows,
    assert_untouched,
    brief_text,
    distinct_texts,
    metres_text,
    points_text,
)
from utils.checks.clusters import assert_clusters
from utils.checks.core import ChecksFailed, run_check
from utils.checks.display import Table, as_html
from utils.checks.lesson_02 import line_through, ransac_line
from utils.checks.lesson_03 import iterations_needed, ransac_plane
from utils.checks.outcomes import Outcome
from utils.checks.summary import failure_texts, summarise
from utils.checks.tips import locate, tip_for

CLOUD = np.array([[1.0, 2.0, -1.5, 0.1], [3.0, 4.0, 0.5, 0.2], [5.0, 6.0, 1.5, 0.3]])
KEEP = np.array([False, True, True])


def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= ground_level]


def test_check_passes_a_right_function(capsys):
    check(filter_ground)
    assert "failed" not in capsys.readouterr().out


def test_check_shows_the_details_of_a_failure_and_then_raises(capsys):
    def filter_ground(cloud, ground_level=-1.2):
        return cloud[cloud[:, 2] < ground_level]

    with pytest.raises(ChecksFailed, match="checks failed"):
        check(filter_ground)
    shown = capsys.readouterr().out
    for word in ("Yours", "Expected", "Why it matters", "Hint", "missing"):
        assert word in shown


def test_check_explains_an_exception(capsys):
    def filter_ground(cloud, ground_level=-1.2):
        return cloud[np.ones(len(cloud) + 1, dtype=bool)]

    with pytest.raises(ChecksFailed):
        check(filter_ground)
    shown = capsys.readouterr().out
    assert "Use a mask only on the array" in shown
    assert "return cloud[np.ones(len(cloud) + 1, dtype=bool)]" in shown, "the line is named"
    assert shown.count("boolean index did not match") == 1, "one cause is explained once"
    assert "Hint" not in shown, "the hints about rows do not apply"


def test_an_exception_in_a_comprehension_is_located_in_its_function():
    def measure(rows):
        return [x + y for x, y in rows]

    with pytest.raises(ValueError) as caught:
        measure([(1, 2, 3)])
    name, place, _ = locate(caught.value, measure)
    assert name == "measure" and place.endswith("of the cell of measure")


def finished(line):
    a, b = line
    return a + b


def under_check(point):
    total = sum(finished([value]) for value in point)
    return total


def test_an_exception_in_a_finished_function_is_located_at_the_call():
    with pytest.raises(ValueError) as caught:
        under_check([1])
    name, place, line = locate(caught.value, under_check)
    own, _, inner = place.partition(", which calls ")
    assert (name, line) == ("finished", "a, b = line")
    assert own.endswith(
        "of the cell of under_check, `total = sum(finished([value]) for value in point)`"
    )
    assert inner.endswith("of the cell of finished")


def test_a_check_of_a_stub_reports_that_it_is_not_started(capsys):
    def filter_ground(cloud, ground_level=-1.2):
        raise NotImplementedError

    with pytest.raises(ChecksFailed):
        check(filter_ground)
    shown = capsys.readouterr().out
    assert shown.count("\n") == 1 and "not started" in shown


def test_checking_a_function_that_is_not_an_exercise_lists_the_exercises():
    with pytest.raises(LookupError, match="it: horizontal_distance, "):
        check(len)
    with pytest.raises(TypeError, match=r"without quotation marks: check\(filter_ground\)"):
        check("filter_ground")


def test_a_failure_is_one_line_in_a_notebook():
    assert ChecksFailed("2 of 5 checks failed.")._render_traceback_() == ["2 of 5 checks failed."]


def test_the_table_escapes_text_from_students():
    def filter_ground(cloud, ground_level=-1.2):
        return "<script>alert(1)</script>"

    outcome = run_check(checks_of("filter_ground")[0], filter_ground)
    assert "<script>" not in as_html(summarise([outcome])) and "script" in as_html(
        summarise([outcome])
    )


@pytest.mark.parametrize(
    "answer",
    [
        CLOUD[KEEP],
        CLOUD[KEEP].astype(np.float32),
        CLOUD[KEEP].tolist(),
        list(CLOUD[KEEP]),
        np.asfortranarray(CLOUD[KEEP]),
    ],
)
def test_rows_in_any_form_are_accepted(answer):
    assert_rows(answer, CLOUD, KEEP)


@pytest.mark.parametrize(
    "answer, words",
    [
        (None, "None"),
        (CLOUD, "too many"),
        (CLOUD[:1], "missing"),
        (CLOUD[KEEP][::-1], "order"),
        (CLOUD[KEEP] + 1, "values changed"),
        (CLOUD[KEEP][:, :3], "columns"),
        (KEEP, "a mask"),
        ("text", "must return"),
        (CLOUD[[1, 2, 2]], "more than once"),
        ([[1, 2], [3]], "must return"),
        (CLOUD[KEEP].T, "columns"),
    ],
)
def test_wrong_rows_are_reported(answer, words):
    with pytest.raises(CheckFailed, match=words):
        assert_rows(answer, CLOUD, KEEP)


def test_messages_use_the_singular_for_one_row():
    with pytest.raises(CheckFailed) as caught:
        assert_rows(CLOUD[:2], CLOUD, np.array([True, False, False]))
    assert (caught.value.yours, caught.value.expected) == ("2 rows", "1 row")


def test_empty_answers_need_the_right_columns():
    nothing = np.zeros(3, dtype=bool)
    assert_rows(np.empty((0, 4)), CLOUD, nothing)
    assert_rows([], CLOUD, nothing)
    with pytest.raises(CheckFailed):
        assert_rows(np.empty((0, 3)), CLOUD, nothing)


@pytest.mark.parametrize(
    "answer, lost",
    [
        (CLOUD[KEEP], ()),
        (CLOUD[KEEP].tolist(), ()),
        (CLOUD[KEEP][::-1], (assert_order,)),
        (CLOUD[KEEP][:, :3], (assert_all_columns,)),
        (CLOUD[KEEP] * [1, 1, 1, 2], (assert_all_columns,)),
        (CLOUD, (assert_positions, assert_order, assert_all_columns)),
        (CLOUD[[1, 1]], (assert_positions, assert_order, assert_all_columns)),
        (KEEP, (assert_positions, assert_order, assert_all_columns)),
    ],
)
def test_positions_order_and_columns_are_checked_separately(answer, lost):
    for look in (assert_positions, assert_order, assert_all_columns):
        if look in lost:
            with pytest.raises(CheckFailed):
                look(answer, CLOUD, KEEP)
        else:
            look(answer, CLOUD, KEEP)


def test_an_empty_answer_still_needs_the_columns_of_the_cloud():
    for nothing in ([], np.empty((0, 4)), np.empty((0, 3))):
        assert_empty_table(nothing, CLOUD, 3)
    for something, words in (
        (CLOUD[:1], "No rows should be left"),
        (np.empty((0, 3)), "columns"),
        (None, "None"),
    ):
        with pytest.raises(CheckFailed, match=words):
            assert_empty_table(something, CLOUD, 4)


def test_excluding_a_point_on_the_limit_gets_only_a_note(capsys):
    def filter_ground(cloud, ground_level=-1.2):
        return cloud[cloud[:, 2] > ground_level]

    def filter_by_distance(cloud, distance=10.0):
        return cloud[np.hypot(cloud[:, 0], cloud[:, 1]) < distance]

    for function, words in ((filter_ground, "at or above"), (filter_by_distance, "<= distance")):
        check(function)
        shown = capsys.readouterr().out
        assert shown.count("[note]") == 1 and words in shown


def test_sets_of_rows_are_compared():
    assert_same_set_of_rows(CLOUD[::-1], CLOUD)
    assert_same_set_of_rows([], np.empty((0, 3)))
    for wrong, words in (
        (CLOUD[:2], "2 rows"),
        (CLOUD + [0, 0, 0, 1], "should not be there"),
        (CLOUD[[0, 0, 1]], "twice"),
        (CLOUD * np.nan, "finite"),
    ):
        with pytest.raises(CheckFailed, match=words):
            assert_same_set_of_rows(wrong, CLOUD)


def test_partitions_are_compared():
    expected = np.array([1, 1, 2, 3])
    cloud = np.zeros((4, 3))
    for same in ([1, 1, 2, 3], [7, 7, 0, -2], np.array([1.0, 1, 2, 3]), (3, 3, 1, 2)):
        assert_partition(same, expected, cloud)
    for wrong, words in (
        ([1, 1, 2, 2], "Points of different"),
        ([1, 2, 3, 4], "belong together"),
        ([1, 2, 2, 3], "split"),
        ([1, 1, 2], "one label"),
        ([1.5, 1.5, 2, 3], "whole numbers"),
        (None, "None"),
    ):
        with pytest.raises(CheckFailed, match=words):
            assert_partition(wrong, expected, cloud)
    assert_partition([], np.empty(0, dtype=int), np.empty((0, 3)))
    # Label 0 means "no cluster", unless it is among the expected labels.
    with pytest.raises(CheckFailed, match="2 of 4 points have the label 0, which means") as caught:
        assert_partition([1, 1, 0, 0], expected, cloud)
    assert "every point" in caught.value.hint
    with pytest.raises(CheckFailed, match="Points of different"):
        assert_partition([1, 1, 0, 0], expected - 1, cloud)


def test_points_without_a_label_are_not_a_cluster():
    cloud = np.outer([0.0, 0.1, 5.0, 5.3], [0.6, 0.0, 0.8])
    with pytest.raises(CheckFailed) as caught:
        assert_clusters([1, 1, 0, 0], np.array([1, 1, 2, 3]), cloud, 0.2)
    assert caught.value.yours == "1 cluster, labels [1, 1, 0, 0]"
    assert "They have the label 0" in caught.value.input_text


def test_failures_can_be_drawn():
    for wrong in (CLOUD, CLOUD[:1]):
        with pytest.raises(CheckFailed) as caught:
            assert_rows(wrong, CLOUD, KEEP)
        assert caught.value.draw() is not None
    with pytest.raises(CheckFailed) as caught:
        assert_partition([1, 1, 1], np.array([1, 1, 2]), CLOUD)
    assert caught.value.draw() is not None


def test_a_changed_input_is_reported():
    assert_untouched(lambda values: None, np.array([1.0, np.nan]))
    with pytest.raises(CheckFailed, match="changed its input"):
        assert_untouched(lambda cloud: cloud.fill(1), CLOUD)
    assert CLOUD[0, 0] == 1.0 and CLOUD[0, 1] == 2.0  # the function changed only a copy


def test_messages_name_the_expected_labels_and_arrays():
    with pytest.raises(CheckFailed, match="must return") as caught:
        as_array(slice(2))
    assert "slice" in caught.value.yours and "slice" not in caught.value.message
    with pytest.raises(CheckFailed, match="one label for each"):
        as_labels(np.zeros((3, 1)), 3)


@pytest.mark.parametrize(
    "provoke, word",
    [
        (lambda: CLOUD[np.ones(2, dtype=bool)], "Use a mask only"),
        (lambda: CLOUD[(CLOUD > 0).all(axis=0)], "axis=1"),
        (lambda: np.arange(5)[np.ones(4, dtype=bool)], "one value for each column"),
        (lambda: linear_sum_assignment(np.full((2, 1), np.inf)), "a huge number"),
        (lambda: CLOUD[CLOUD[0] > 0], "cloud[:, 0]"),
        (lambda: CLOUD[:, CLOUD[:, 0] > 0], "cloud[mask]"),
        (lambda: np.zeros((8, 3)).__setitem__(0, np.ones(4)), "different shapes"),
        (lambda: CLOUD[:2] - CLOUD[0, :3], "intensity"),
        (lambda: CLOUD - np.ones(2), "Compare them from the right"),
        (lambda: CLOUD[:2] / np.ones(2), "counts[:, None]"),
        (lambda: CLOUD - CLOUD[[0, 1]], "extend adds its numbers"),
        (lambda: np.add.at(np.zeros((2, 3)), [0, 1, 0], CLOUD), "a row for each group"),
        (lambda: np.add.at(np.zeros(2), [0, 1, 0], CLOUD), "a row for each group"),
        (lambda: CLOUD[:, 0] > 1 & CLOUD[:, 1] < 2, "parentheses"),
        (lambda: CLOUD[0] ^ 2, "power"),
        (lambda: 1.5 ^ 2, "power"),
        (lambda: math.sqrt(CLOUD[:, 0]), "single number"),
        (lambda: None.point, "is None"),
        (lambda: [*None], "is None"),
        (lambda: (lambda pair: [0 for a, b in [pair]])(None), "cannot be unpacked"),
        (lambda: (lambda nothing: nothing[0])(None), "is None"),
        (lambda: [1.0, 2.0].min(), "np.array"),
        (lambda: [1.0] * 0.5, "np.array"),
        (lambda: [1.0] <= 0.5, "np.array"),
        (lambda: np.random.default_rng(1).choice(2, 3, replace=False), "len(points)"),
        (lambda: np.random.default_rng(1).choice(0, 3, replace=False), "len(points)"),
        (lambda: np.cross(CLOUD[0], CLOUD[1]), "x, y, z"),
        (lambda: CLOUD(0), "square brackets"),
        (lambda: np.linalg.eigh(np.full((3, 3), np.nan)), "NaN"),
        (lambda: np.linalg.svd(np.full((3, 3), np.inf)), "infinite"),
        (lambda: len[0], "round ones"),
        (lambda: range(1.5), "whole number"),
        (lambda: CLOUD[0][:, 0], "fewer dimensions"),
        (lambda: [][0], "past the end"),
        (lambda: deep(0), "ends the recursion"),
        (lambda: (lambda values: [0 for a, b in values])([(1, 2, 3)]), "left-hand side"),
        (lambda: CLOUD[:, :3][:, 3], "three columns"),
        (lambda: bool(CLOUD > 0), "mask"),
        (lambda: {CLOUD[0]}, "tuple"),
        (lambda: np.empty(0).min(), "empty"),
        (lambda: CLOUD[1.5 * np.ones(2)], "whole number"),
        (lambda: CLOUD[:, :3] @ np.ones(4), "the same number of values"),
        (lambda: np.dot(CLOUD[:, :3], np.ones(4)), "the same number of values"),
        (lambda: len(filter_ground.__doc__), "return"),
        (lambda: undefined_name, "run the cell"),  # noqa: F821
        (lambda: (CLOUD, CLOUD) < 0.5, "Unpack the pair"),
        (lambda: coo_array(([True], ([3], [0])), shape=(3, 3)), "count - 1"),
        (lambda: filter_ground(points=CLOUD), "another name"),
        (lambda: filter_ground(), "first line"),
    ],
)
def test_tips_match_the_real_messages_of_numpy_and_python(provoke, word):
    with pytest.raises(Exception) as caught:  # noqa: B017, PT011 (each raises its own)
        provoke()
    assert word in tip_for(type(caught.value).__name__, str(caught.value))


def deep(number):
    return deep(number + 1)


@pytest.mark.parametrize(
    "slip, word",
    [
        (("<= distance_tolerance", "> distance_tolerance"), "Compare with <="),
        (("best_mask, best_line = mask, line", "best_line = line"), "replace the best mask"),
        (
            ("    return best_line, best_mask", "        return best_line, best_mask"),
            "after the loop",
        ),
    ],
)
def test_the_hint_about_a_missed_line_names_the_cause(slip, word):
    right = textwrap.dedent(
        """
        def ransac_line(points, max_iterations, distance_tolerance, rng):
            rng = np.random.default_rng(rng)
            best_line, best_mask = None, np.zeros(len(points), dtype=bool)
            for _ in range(max_iterations):
                p, q = points[rng.choice(len(points), size=2, replace=False)]
                a, b = np.array([p[1] - q[1], q[0] - p[0]]) / np.hypot(*(q - p))
                line = (a, b, -(a * p[0] + b * p[1]))
                mask = np.abs(points @ line[:2] + line[2]) <= distance_tolerance
                if mask.sum() > best_mask.sum():
                    best_mask, best_line = mask, line
            return best_line, best_mask
        """
    )
    space = {"np": np}
    assert right.count(slip[0]) == 1
    exec(right.replace(*slip), space)
    with pytest.raises(CheckFailed) as caught:
        ransac_line.finds_the_line(space["ransac_line"])
    assert word in caught.value.hint


@pytest.mark.parametrize(
    ("where", "exercise", "check_draws", "count", "message"),
    [
        (
            "02_ransac_line",
            "ransac_line",
            ransac_line.draws_from_all_points,
            4,
            "No line goes through two of the four points",
        ),
        (
            "03_ransac_plane",
            "ransac_plane",
            ransac_plane.draws_from_all_rows,
            5,
            "No plane goes through three of the five points",
        ),
    ],
)
def test_models_that_miss_all_points_are_reported(where, exercise, check_draws, count, message):
    right = getattr(load_reference(where), exercise)

    def misses_a_small_cloud(points, *arguments):
        model, inliers = right(points, *arguments)
        if model and len(points) == count:
            model = (*model[:-1], model[-1] + 50)
        return model, inliers

    with pytest.raises(CheckFailed, match=message):
        check_draws(misses_a_small_cloud)


def test_the_hint_depends_on_the_wrong_answer():
    with pytest.raises(CheckFailed) as caught:
        line_through.assert_no_line(lambda p, q: (None, None, None), (1.0, 2.0))
    assert "a single None" in caught.value.hint
    for answer, word in ((20, "do not add 1"), (18, "")):
        with pytest.raises(CheckFailed) as caught:
            iterations_needed.assert_iterations(answer, 19, 0.6, 3, 0.99)
        assert caught.value.hint.endswith(word + "." if word else "")


def test_numbers_in_a_tuple_are_shown_as_plain_numbers():
    assert brief_text((np.float64(1.7), np.int64(2), None)) == "(1.7, 2, None)"
    assert brief_text([np.float64("nan"), (np.True_,)]) == "[nan, (True,)]"


def test_a_tip_may_depend_on_the_line():
    words = "only length-1 arrays can be converted to Python scalars"
    assert "np.sqrt" in tip_for("TypeError", words, "`return math.sqrt(x)`")
    call = "line_through() missing 1 required positional argument: 'q'"
    assert "first line" in tip_for("TypeError", call)
    assert "one argument" in tip_for("TypeError", call, "`line = line_through(points[chosen])`")
    assert "as many rows" in tip_for("TypeError", call, "`line = line_through(*points[chosen])`")
    with pytest.raises(IndexError) as caught:
        np.ones((8, 4))[np.ones((8, 3), dtype=bool)]
    for line, word in (
        ("`return cloud[inside]`", ".all(axis=1)"),
        ("`return cloud[(cloud[:, :3] >= low) & (cloud[:, :3] <= high)]`", ".all(axis=1)"),
        ("`return cloud[:, inside]`", "rows: cloud[mask]"),
    ):
        assert word in tip_for("IndexError", str(caught.value), line)
    truth = "The truth value of an array with more than one element is ambiguous. Use a.any()"
    assert "its own parentheses" in tip_for("ValueError", truth, "`a[x > 1 & x < 2]`")
    assert ".any()" in tip_for("ValueError", truth, "`if a > 1:`")
    assert "logarithm" in tip_for("ValueError", "math domain error", "`n = math.log(0)`")
    with pytest.raises(ValueError, match="expected 3") as caught:
        x, y, z = CLOUD.T  # noqa: RUF059
    assert "intensity" in tip_for("ValueError", str(caught.value), "`x, y, z = cloud.T`")
    assert "left-hand side" in tip_for("ValueError", str(caught.value), "`a, b, c = answer`")
    for line in ("x, y, z = points[i]", "for x, y, z in cloud:", "x, y, z = cloud[near].T"):
        assert "intensity" in tip_for("ValueError", str(caught.value), f"`{line}`")
    # These lines do not unpack a row of a cloud, so the tip must not mention the intensity.
    for line in (
        "a, b, c = plane_through(p, q, r)",
        "a, b, c = fit_plane(points)",
        "i, j, k = rng.choice(len(points), 4, replace=False)",
        "low, high, n = np.unique(cloud)",
    ):
        assert "intensity" not in tip_for("ValueError", str(caught.value), f"`{line}`")
    assert "logarithm" in tip_for("ZeroDivisionError", "float division by zero", "`1 / log(w)`")


def test_a_tree_used_as_a_node_gets_a_tip():
    class KdTree:
        root = None

    with pytest.raises(AttributeError) as caught:
        KdTree().left  # noqa: B018 (it raises)
    assert "tree.root" in tip_for("AttributeError", str(caught.value))


def test_a_picture_that_cannot_be_drawn_does_not_hide_the_table(monkeypatch):
    def draw():
        plt.figure()
        raise TypeError("unhashable type")

    monkeypatch.setattr("utils.checks.display.as_html", lambda story: "")
    monkeypatch.setattr("utils.checks.display.as_text", lambda story: "")
    shown, before = Table([]), plt.get_fignums()
    shown._in_notebook, shown._display = True, lambda *_: None
    shown.finish(SimpleNamespace(first=SimpleNamespace(failure=SimpleNamespace(draw=draw))))
    assert plt.get_fignums() == before


def test_an_ambiguous_error_gets_no_tip():
    assert tip_for("ZeroDivisionError", "division by zero") == ""


def test_importing_utils_loads_no_heavy_packages():
    import subprocess
    import sys

    code = (
        "import utils, sys; heavy = {'matplotlib', 'scipy', 'shapely', 'pyvista', 'pooch', "
        "'nbgrader', 'grader', 'IPython'}; print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr


# ---- titles ------------------------------------------------------------------------------------


def test_checks_of_an_exercise_have_different_titles(lesson):
    """With equal titles, a table would not show which of two checks failed."""
    titles = []

    def record_and_skip(one_check):
        titles.append((one_check.exercise, one_check.title.casefold().rstrip(".")))
        return False

    run_checks(lesson, SimpleNamespace(), 3, record_and_skip)
    assert len(titles) > 10 * len(lesson.machine_graded)
    assert [title for title in {*titles} if titles.count(title) > 1] == []


# ---- functions cannot change the checks ---------------------------------------------------------


def modules_of_checks():
    """Yield every module of checks or hidden tests, which may contain constants."""
    for path in sorted((PROJECT / "utils" / "checks").rglob("*.py")):
        name = ".".join(path.relative_to(PROJECT).with_suffix("").parts)
        yield importlib.import_module(name.removesuffix(".__init__"))
    for lesson in all_lessons():
        spec = importlib.util.spec_from_file_location(lesson.tests.stem, lesson.tests)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module


def arrays_in(value, above=()):
    if isinstance(value, np.ndarray):
        yield value
    elif any(value is container for container in above):
        return
    elif isinstance(value, dict):
        for item in [*value.keys(), *value.values()]:
            yield from arrays_in(item, (*above, value))
    elif isinstance(value, (tuple, list, set, frozenset)):
        for item in value:
            yield from arrays_in(item, (*above, value))


def test_constants_are_read_only(request):
    request.config.addinivalue_line("markers", "judged: what hidden tests are marked with")
    writeable = {
        f"{module.__name__}.{name}"
        for module in modules_of_checks()
        for name, value in vars(module).items()
        if name != "__builtins__"  # shared by all modules
        for array in arrays_in(value)
        if array.flags.writeable or (array.base is not None and array.base.flags.writeable)
    }
    assert writeable == set()


def overwrite_arguments(function, read_only):
    """Wrap a function so that it overwrites all its arguments after the call."""

    def overwrite(*arguments, **keywords):
        given = [*arguments, *keywords.values()]
        result = function(*(copy.deepcopy(value) if is_plain(value) else value for value in given))
        for value in given:
            if isinstance(value, np.ndarray) and not value.flags.writeable:
                read_only.append(function.__name__)
            elif isinstance(value, np.ndarray):
                value[...] = np.array(99).astype(value.dtype)
            elif isinstance(value, list):
                value[:] = [99] * len(value)
        return result

    return overwrite


def is_plain(value):
    return isinstance(value, (np.ndarray, list, tuple, np.random.Generator))


@pytest.mark.slow
def test_a_function_that_overwrites_its_arguments_loses_only_that_check(lesson, monkeypatch):
    reference, read_only = load_reference(lesson.name), []
    names = [exercise.name for exercise in lesson.machine_graded]
    functions = {name: overwrite_arguments(getattr(reference, name), read_only) for name in names}
    if hasattr(reference, "KdTree"):
        # The methods of the lesson's KdTree call the functions of this module.
        for name, function in functions.items():
            monkeypatch.setitem(vars(reference), name, function)
        functions["KdTree"] = reference.KdTree
    student = SimpleNamespace(**functions, exercise="", close=lambda: None)
    faults = {
        test.check.name: f"{type(test.failure).__name__}: {test.failure}"
        for test in run_checks(lesson, student, 3)
        if test.failure and "changed its input" not in str(test.failure)
    }
    assert faults == {}
    # Arguments must be writable, because a right answer may change its copy.
    allowed = {"filter_clusters"}  # a hidden test passes a read-only array on purpose
    assert set(read_only) <= allowed


# ---- huge answers ------------------------------------------------------------------------------


def nested_list(depth):
    value = 1
    for _ in range(depth):
        value = [value]
    return value


# Each answer is created when it is needed, because all of them together take 150 MB.
HUGE_ANSWERS = {
    "boxes": lambda: np.tile(np.mgrid[:2, :2, :2].reshape(3, 8).T.astype(float), (3000, 1, 1)),
    "dimensions": lambda: np.zeros((6,) * 8, dtype=bool),
    "dimensions, after None": lambda: [None, np.zeros((6,) * 8, dtype=bool)],
    "nesting": lambda: nested_list(50),
    "deeply nested lists in a long list": lambda: [nested_list(50)] * 20_000,
    "a long list": lambda: list(range(10**6)),
    "a longer list": lambda: [0.5] * (10**6 + 1),
    "a long list of lists": lambda: [[0.0, 0.0, 0.0]] * 300_000,
    "a long list of empty lists": lambda: [[]] * 900_000,
    "digits": lambda: 10**10_000,
    "many digits": lambda: [10**10_000] * 1000,
    "a long text": lambda: "9" * 10**7,
    "a long text in a list of short ones": lambda: ["9" * 10**7] + ["9"] * 10_000,
    "a set": lambda: set(range(500_000)),
    "a dictionary": lambda: {number: number for number in range(500_000)},
    "a large array": lambda: np.zeros(4 * 10**6),
    "labels": lambda: np.arange(10**6),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", HUGE_ANSWERS)
def test_a_huge_answer_is_refused_quickly(name):
    from time import process_time

    slow, answer = {}, HUGE_ANSWERS[name]()
    for lesson in all_lessons():
        for exercise in lesson.machine_graded:
            for one_check in checks_of(exercise.name):
                start = process_time()
                try:
                    one_check.run(huge_answers(exercise.name, answer))
                    caught = None
                except Exception as error:
                    caught = error
                seconds = process_time() - start
                if seconds > 3 and not is_scene(one_check):
                    slow[exercise.name, one_check.name] = seconds
                assert isinstance(caught, CheckFailed), (exercise.name, one_check.name, caught)
    assert slow == {}


def test_only_a_few_huge_answers_are_checked():
    """The judge stops after five huge answers, because reading each takes several seconds."""
    huge, calls = [0] * 1_100_000, []
    student = SimpleNamespace(
        filter_clusters=lambda *arguments, **keywords: calls.append(1) or huge,
        exercise="",
        close=lambda: None,
    )
    lesson = next(lesson for lesson in all_lessons() if lesson.number == "09")
    outcomes = run_checks(lesson, student, 1)
    not_tried = [outcome for outcome in outcomes if "Not run: 5 answers" in str(outcome.failure)]
    assert len(calls) == 5 and len(not_tried) == len(outcomes) - 5 > 5


def is_scene(one_check):
    """Return whether a check generates a scene when it runs for the first time."""
    return one_check.exercise == "detect_obstacles"


def huge_answers(exercise, answer):
    if exercise not in ("insert", "search"):
        return lambda *arguments, **keywords: answer

    class KdTree:
        root = None

        def insert(self, point, index):
            self.root = SimpleNamespace(point=answer, index=answer, left=None, right=None)

        def search(self, target, tolerance):
            return answer

    return KdTree


def test_messages_name_the_size_limits():
    for claim, words in (
        (HUGE_ANSWERS["dimensions"](), "three dimensions"),
        (nested_list(50), "three dimensions"),
        (HUGE_ANSWERS["a longer list"](), "a million"),
        (HUGE_ANSWERS["digits"](), "nineteen digits"),
    ):
        with pytest.raises(CheckFailed, match=words):
            as_array(claim)


# ---- messages of hidden tests contain no text from the student -----------------------------------

SECRET = "Zebra7351"


class Zebra7351:
    """An answer with a secret in its name, text and attributes."""

    type_name = SECRET

    def __repr__(self):
        return SECRET

    __str__ = __repr__

    def __array__(self, *arguments, **keywords):
        raise ValueError(SECRET)


STRANGE_ANSWERS = {
    "an object": Zebra7351(),
    "its class": Zebra7351,
    "a text": SECRET,
    "a pair": (Zebra7351(), SECRET),
    "a list": [SECRET, SECRET],
    "a dictionary": {SECRET: SECRET},
    "a set": {SECRET},
    "an array of texts": np.array([SECRET] * 3),
    "an array of objects": np.frompyfunc(lambda row: Zebra7351(), 1, 1)(np.arange(3)),
    "a model of that name": ([SECRET], [SECRET]),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", STRANGE_ANSWERS)
def test_messages_of_hidden_tests_contain_no_words_of_the_student(lesson, name):
    names = [exercise.name for exercise in lesson.machine_graded]
    functions = {
        exercise: lambda *arguments, **keywords: STRANGE_ANSWERS[name] for exercise in names
    }
    if "KdTree" in lesson.names:
        functions["KdTree"] = huge_answers("search", STRANGE_ANSWERS[name])
        functions["KdTree"].plant = lambda self, *table: None
    student = SimpleNamespace(**functions, exercise="", close=lambda: None)
    for outcome in run_checks(lesson, student, 3):
        if not outcome.check.is_shown:
            assert isinstance(outcome.failure, CheckFailed), outcome
            assert SECRET not in outcome.failure.message
            assert SECRET not in message_of(shareable_outcome(outcome, is_public=True)).text


# ---- exercises that share a class ----------------------------------------------------------------


def test_exercises_of_one_class_are_checked_separately(monkeypatch, capsys):
    KdTree = load_reference("04_kd_tree").KdTree

    def search(tree, target, tolerance):
        import scipy.spatial  # noqa: F401 (the lesson forbids it)

        return []

    search.__module__ = KdTree.__module__
    space = KdTree.search.__globals__
    monkeypatch.setitem(space, "search", search)
    check(KdTree, exercise="insert")
    with pytest.raises(AssertionError):
        check(KdTree, exercise="search")
    assert "not allowed" in capsys.readouterr().out
    monkeypatch.setitem(space, "search", lambda tree, target, tolerance: [])
    with pytest.raises(AssertionError):
        check(KdTree, exercise="search")
    output = capsys.readouterr().out
    assert "Not found" in output
    assert "Fix this first" not in output


def test_a_changed_number_is_shown_as_a_number():
    def clear_in_place(labels):
        labels[1] = 0
        return labels.copy()

    with pytest.raises(CheckFailed) as failed:
        assert_untouched(clear_in_place, np.array([4, 2, 3]))
    assert failed.value.yours == "after the call, row 1 is 0"
    assert failed.value.expected == "as before the call: 2"


@pytest.mark.parametrize("shape", [(0, 5), (0, 0)])
@pytest.mark.parametrize(
    "source, exercise",
    [
        ("09_filter_clusters", "filter_clusters"),
        ("05_euclidean_clustering", "euclidean_clustering"),
        ("02_ransac_line", "point_line_distance"),
        ("03_ransac_plane", "point_plane_distance"),
    ],
)
def test_empty_answers_of_any_shape_are_accepted(source, exercise, shape):
    right = getattr(load_reference(source), exercise)

    def answer(*arguments, **keywords):
        found = np.asarray(right(*arguments, **keywords))
        return found if found.size else np.empty(shape)

    answer.__name__ = exercise
    outcomes = [run_check(check, answer) for check in checks_of(exercise)]
    assert not [outcome.failure for outcome in outcomes if outcome.failure]


def test_numbers_are_shown_with_enough_digits_to_differ():
    assert distinct_texts(metres_text, 1.0, 2.0) == ("1.00 m", "2.00 m")
    assert distinct_texts(metres_text, 1.41, 1.4142) == ("1.410 m", "1.414 m")
    assert distinct_texts(points_text, np.array([[1, 2, 3.0]]), np.array([[1, 2.0004, 3.0]])) == (
        "(1, 2, 3)",
        "(1, 2.0004, 3)",
    )


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("horizontal_distance", lambda cloud: np.hypot(cloud[:, 0], cloud[:, 1]).round(2)),
        (
            "filter_clusters",
            lambda cluster_labels, min_num_points=100: np.sort(
                load_reference("09_filter_clusters").filter_clusters(cluster_labels, min_num_points)
            ),
        ),
    ],
)
def test_the_texts_of_your_answer_and_the_expected_answer_always_differ(name, wrong):
    failures = [run_check(check_, wrong).failure for check_ in checks_of(name)]
    compared = [failure for failure in failures if failure and failure.expected]
    assert compared
    assert [each.message for each in compared if each.yours == each.expected] == []


def test_answers_with_equal_texts_are_not_shown():
    failure = CheckFailed("Something else is wrong.", yours="1 row", expected="1 row")
    [check_, *_] = checks_of("horizontal_distance")
    labels = [label for label, _ in failure_texts(Outcome(check_, failure))]
    assert "What happened" in labels and not {"Yours", "Expected"} & {*labels}


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ((row for row in CLOUD), "a generator instead of rows. Convert it with list"),
        (map(list, CLOUD), "a map instead of rows. Convert it with list"),
        ((CLOUD[0], 1.5), "must return rows, not a pair"),
        (np.where(KEEP), "row numbers in a tuple, as np.where returns them"),
        (np.flatnonzero(KEEP), "return the rows themselves"),
        (KEEP, "This is a mask"),
        (np.ma.masked_array(CLOUD, CLOUD > 1), "a masked array. It hides values"),
        ({"rows": CLOUD}, r"a dict. Return its values as an array, for example np.array\(list"),
        (OpaqueValue("dict"), "a dict. Return its values as an array"),
        (
            OpaqueValue(wire_format.known_type("Box")),
            "an object of your own class. Return an array",
        ),
        (type("Box", (), {"__module__": "__main__"})(), "an object of your own class"),
    ],
)
def test_the_type_of_a_wrong_answer_is_named(answer, words):
    with pytest.raises(CheckFailed, match=words):
        as_array(answer, columns=4, description="rows")


def test_a_coroutine_gets_a_message_that_suggests_a_fix():
    async def returned():
        return CLOUD

    coroutine = returned()
    with pytest.raises(CheckFailed, match="Delete `async` before `def`"):
        as_array(coroutine, columns=4, description="rows")
    coroutine.close()


def test_a_masked_array_without_masked_values_is_accepted():
    assert np.array_equal(as_array(np.ma.masked_array(CLOUD), columns=4), CLOUD)


def test_a_slow_right_answer_gets_a_note_on_the_time_limit(capsys, monkeypatch):
    clock = iter([0.0, 7.0])
    monkeypatch.setattr(core.time, "process_time", lambda: next(clock, 7.0))
    check(filter_ground)
    shown = capsys.readouterr().out
    assert "The answer is right, but slow" in shown and "took 7 s" in shown
    assert f"waits at most {Limits().call_seconds:.0f} s for each answer" in shown


def test_a_quick_or_wrong_answer_is_not_called_slow(capsys, monkeypatch):
    check(filter_ground)
    clock = iter([0.0, 7.0])
    monkeypatch.setattr(core.time, "process_time", lambda: next(clock, 7.0))
    with pytest.raises(ChecksFailed):
        check(lambda cloud, ground_level=-1.2: cloud, "filter_ground")
    assert "slow" not in capsys.readouterr().out
