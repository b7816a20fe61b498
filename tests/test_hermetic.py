"""Nothing but submission, rules and seed decides a verdict; and tests that demand a wall fail."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT
from tests.prerequisites import without_bubblewrap

SEED = 20_170_405
JUDGE = """
import json, sys
from pathlib import Path
from grader.judging.judge import judge
from grader.sandbox import SANDBOXES
verdict = judge(Path(sys.argv[1]), int(sys.argv[2]), SANDBOXES[sys.argv[3]])
print(json.dumps(verdict.as_dict()))
"""


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """A notebook of lesson 06 that earns some points and loses others."""
    lesson = find_lesson("06_filter_ground")
    wrong = next(variant.source for variant in answers_to("filter_ground") if not variant.right)
    right = next(variant.source for variant in answers_to("voxel_grid") if variant.right)
    path = tmp_path_factory.mktemp("course") / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, {"filter_ground": wrong, "voxel_grid": right}), "utf-8")
    return path


def judged(path, sandbox, folder=PROJECT, python=sys.executable, **environment):
    """The verdict that a process of its own reaches, less the time it took."""
    done = subprocess.run(
        [python, "-c", JUDGE, str(path), str(SEED), sandbox.name],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(PROJECT), **environment},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    verdict = json.loads(done.stdout)
    del verdict["seconds"]
    return verdict


@pytest.fixture(scope="module")
def plain(half, sandbox):
    """The verdict where nothing is odd."""
    verdict = judged(half, sandbox)
    assert 0 < verdict["score"] < verdict["max_score"]
    return verdict


@pytest.mark.slow
@pytest.mark.parametrize(
    "environment",
    [
        {"PYTEST_ADDOPTS": "-k visible"},
        {"PYTEST_ADDOPTS": "-x --deselect nothing"},
        {"PYTEST_ADDOPTS": "--collect-only"},
        {"PYTEST_PLUGINS": "no_such_plugin"},
        {"PYTEST_DEBUG": "1", "PY_COLORS": "1", "FORCE_COLOR": "1"},
        {"LANG": "tr_TR.UTF-8", "LC_ALL": "tr_TR.UTF-8"},
        {"LANG": "C", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        {"TZ": "Pacific/Kiritimati"},
        {"PYTHONHASHSEED": "7", "PYTHONOPTIMIZE": "2"},
        {"PYTHONWARNINGS": "error"},
        {"OMP_NUM_THREADS": "7", "MPLBACKEND": "TkAgg", "PYTHONSTARTUP": "/no/such/file"},
        {"HOME": "/no/such/folder", "TMPDIR": "/tmp", "COLUMNS": "1"},
    ],
    ids=lambda environment: " ".join(f"{name}={text}" for name, text in environment.items()),
)
def test_no_variable_changes_a_verdict(environment, half, plain, sandbox):
    assert judged(half, sandbox, **environment) == plain


@pytest.mark.slow
def test_no_conftest_and_no_settings_above_the_course_change_a_verdict(
    half, plain, sandbox, tmp_path
):
    """A file that pytest would read, in the folder of the course, of the notebook, or above."""
    course = tmp_path / "above" / "course"
    course.mkdir(parents=True)
    for folder in (tmp_path, course.parent, course):
        (folder / "conftest.py").write_text("raise SystemExit('read')")
        (folder / "pytest.ini").write_text("[pytest]\naddopts = -k visible\n")
        (folder / "sitecustomize.py").write_text("raise SystemExit('read')")
        (folder / "pytest.py").write_text("raise SystemExit('read')")
    there = course / half.name
    there.write_bytes(half.read_bytes())
    assert "raise" in (course / "conftest.py").read_text()
    # `-c` puts the working folder on the path of modules, so the judge is started from elsewhere.
    assert judged(there, sandbox) == plain


@pytest.mark.slow
def test_python_may_be_called_by_a_relative_path(half, plain, sandbox, tmp_path):
    """And from a folder from which it is far up and down again."""
    python = os.path.relpath(sys.executable, tmp_path)
    assert not os.path.isabs(python)
    assert judged(half, sandbox, folder=tmp_path, python=python) == plain


@pytest.mark.slow
def test_the_folder_of_the_grader_decides_nothing(half, plain, sandbox, tmp_path):
    odd = tmp_path / "ein Ordner mit \N{LATIN SMALL LETTER U WITH DIAERESIS} [red] $(x) %s"
    odd.mkdir()
    there = odd / half.name
    there.write_bytes(half.read_bytes())
    assert judged(there, sandbox, folder=odd) == plain


# ---- Tests that can fail ----------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("required, outcome", [("1", "error"), ("", "skipped")])
def test_attacks_without_a_wall_fail_where_it_is_required(required, outcome, tmp_path):
    attacks = Path(__file__).parent / "attacks" / "test_visibility.py"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n0", "-p", "no:cacheprovider", str(attacks)],
        cwd=PROJECT,
        env={**os.environ, **without_bubblewrap(tmp_path), "REQUIRE_SANDBOX": required},
        capture_output=True,
        text=True,
    )
    assert re.search(rf"^\d+ .*{outcome}.* in ", done.stdout, re.M), done.stdout
    assert "passed" not in done.stdout
    assert (done.returncode != 0) == bool(required)


@pytest.mark.slow
def test_there_are_at_least_a_hundred_attacks_and_each_says_what_it_tries():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n0", "--collect-only", "-m", ""]
        + [str(Path(__file__).parent / "attacks")],
        cwd=PROJECT,
        capture_output=True,
        text=True,
    )
    attacks = [line for line in done.stdout.splitlines() if "::test_" in line]
    assert len(attacks) >= 100
