"""The checks of a notebook: what a student sees, and in which words."""

import numpy as np
import pytest

from utils.checks import CheckFailed, check, checks_of
from utils.checks.core import ChecksFailed
from utils.checks.tips import tip_for
from utils.checks.vocabulary import (
    as_array,
    as_labels,
    assert_partition,
    assert_rows,
    assert_same_set_of_rows,
    assert_untouched,
)

CLOUD = np.array([[1.0, 2.0, -1.5, 0.1], [3.0, 4.0, 0.5, 0.2], [5.0, 6.0, 1.5, 0.3]])
KEEP = np.array([False, True, True])


def filter_ground(cloud, ground_level=-1.2):
    return cloud[cloud[:, 2] >= ground_level]


def test_check_passes_a_right_function(capsys):
    check(filter_ground)
    assert "failed" not in capsys.readouterr().out


def test_check_shows_everything_and_then_raises(capsys):
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
    assert "the same array" in capsys.readouterr().out


def test_check_of_a_stub_says_so(capsys):
    def filter_ground(cloud, ground_level=-1.2):
        raise NotImplementedError

    with pytest.raises(ChecksFailed):
        check(filter_ground)
    assert "Replace that line" in capsys.readouterr().out


def test_check_of_something_else_says_what_can_be_checked():
    with pytest.raises(LookupError, match="one of horizontal_distance, "):
        check(len)
    with pytest.raises(LookupError):
        check("filter_ground!")


def test_failure_is_one_line_in_a_notebook():
    assert ChecksFailed("2 of 5 checks failed.")._render_traceback_() == ["2 of 5 checks failed."]


def test_table_escapes_what_students_write():
    from utils.checks.core import run_check
    from utils.checks.display import as_html

    def filter_ground(cloud, ground_level=-1.2):
        return "<script>alert(1)</script>"

    outcome = run_check(checks_of("filter_ground")[0], filter_ground)
    assert "<script>" not in as_html([outcome])


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
        (KEEP, "columns"),
        ("text", "str"),
        (CLOUD[[1, 2, 2]], "more than once"),
        ([[1, 2], [3]], "list"),
        (CLOUD[KEEP].T, "columns"),
    ],
)
def test_wrong_rows_are_named(answer, words):
    with pytest.raises(CheckFailed, match=words):
        assert_rows(answer, CLOUD, KEEP)


def test_empty_rows():
    nothing = np.zeros(3, dtype=bool)
    assert_rows(np.empty((0, 4)), CLOUD, nothing)
    assert_rows([], CLOUD, nothing)
    with pytest.raises(CheckFailed):
        assert_rows(np.empty((0, 3)), CLOUD, nothing)


def test_sets_of_rows():
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


def test_partitions():
    expected = np.array([1, 1, 2, 3])
    cloud = np.zeros((4, 3))
    for same in ([1, 1, 2, 3], [7, 7, 0, -2], np.array([1.0, 1, 2, 3]), (3, 3, 1, 2)):
        assert_partition(same, expected, cloud)
    for other, words in (
        ([1, 1, 2, 2], "Points of different"),
        ([1, 2, 3, 4], "belong together"),
        ([1, 2, 2, 3], "torn apart"),
        ([1, 1, 2], "one label"),
        ([1.5, 1.5, 2, 3], "whole numbers"),
        (None, "None"),
    ):
        with pytest.raises(CheckFailed, match=words):
            assert_partition(other, expected, cloud)
    assert_partition([], np.empty(0, dtype=int), np.empty((0, 3)))


def test_pictures_of_failures_can_be_drawn():
    for wrong in (CLOUD, CLOUD[:1]):
        with pytest.raises(CheckFailed) as caught:
            assert_rows(wrong, CLOUD, KEEP)
        assert caught.value.draw() is not None
    with pytest.raises(CheckFailed) as caught:
        assert_partition([1, 1, 1], np.array([1, 1, 2]), CLOUD)
    assert caught.value.draw() is not None


def test_untouched():
    assert_untouched(np.array([1.0, np.nan]), np.array([1.0, np.nan]))
    with pytest.raises(CheckFailed, match="changed its input"):
        assert_untouched(CLOUD, CLOUD + 1)


def test_labels_and_arrays_say_what_was_expected():
    with pytest.raises(CheckFailed, match="dict"):
        as_array({1: 2})
    with pytest.raises(CheckFailed, match="one label for each"):
        as_labels(np.zeros((3, 1)), 3)


@pytest.mark.parametrize(
    "provoke, word",
    [
        (lambda: CLOUD[np.ones(2, dtype=bool)], "same array"),
        (lambda: CLOUD[:, :3] - CLOUD[0], "shapes do not fit"),
        (lambda: CLOUD[:, :3][:, 3], "three columns"),
        (lambda: bool(CLOUD > 0), "mask"),
        (lambda: {CLOUD[0]}, "tuple"),
        (lambda: np.empty(0).min(), "empty"),
        (lambda: CLOUD[1.5 * np.ones(2)], "whole number"),
        (lambda: len(filter_ground.__doc__), "return"),
        (lambda: undefined_name, "spelt"),  # noqa: F821
        (lambda: filter_ground(points=CLOUD), "renamed"),
        (lambda: filter_ground(), "parameters"),
    ],
)
def test_tips_fit_what_numpy_and_python_really_say(provoke, word):
    with pytest.raises(Exception) as caught:  # noqa: B017, PT011 (each raises its own)
        provoke()
    assert word in tip_for(type(caught.value).__name__, str(caught.value))


def test_no_tip_is_better_than_a_wrong_one():
    assert tip_for("ZeroDivisionError", "division by zero") == ""


def test_import_is_quick_and_light():
    import subprocess
    import sys

    code = (
        "import utils, sys; heavy = {'matplotlib', 'scipy', 'shapely', 'pyvista', 'pooch', "
        "'nbgrader', 'grader', 'IPython'}; print(sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.strip() == "[]", done.stderr
