"""A verdict depends only on the submission, the rules and the seed; CI can require a sandbox."""

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
JUDGE_PROGRAM = """
import json, sys
from pathlib import Path
from grader.judging.judge import judge
from grader.sandbox import SANDBOXES
verdict = judge(Path(sys.argv[1]), int(sys.argv[2]), SANDBOXES[sys.argv[3]])
print(json.dumps(verdict.as_dict()))
"""


@pytest.fixture(scope="module")
def half_right_notebook(tmp_path_factory):
    """Return a notebook of lesson 06 that earns some points and loses others."""
    lesson = find_lesson("06_filter_ground")
    wrong = next(variant.source for variant in answers_to("filter_ground") if not variant.right)
    right = next(variant.source for variant in answers_to("voxel_grid") if variant.right)
    path = tmp_path_factory.mktemp("course") / f"{lesson.name}.ipynb"
    path.write_text(fill_in(lesson, {"filter_ground": wrong, "voxel_grid": right}), "utf-8")
    return path


def verdict_of(path, sandbox, folder=PROJECT, python=sys.executable, **environment):
    """Judge in a new process; return the verdict without its run time."""
    done = subprocess.run(
        [python, "-c", JUDGE_PROGRAM, str(path), str(SEED), sandbox.name],
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
def plain_verdict(half_right_notebook, sandbox):
    """Return the verdict that the judge reaches in an ordinary environment."""
    verdict = verdict_of(half_right_notebook, sandbox)
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
def test_no_environment_variable_changes_a_verdict(
    environment, half_right_notebook, plain_verdict, sandbox
):
    assert verdict_of(half_right_notebook, sandbox, **environment) == plain_verdict


@pytest.mark.slow
def test_files_of_pytest_do_not_change_a_verdict(
    half_right_notebook, plain_verdict, sandbox, tmp_path
):
    """The judge ignores pytest's files in the notebook's folder and in the folders above it."""
    course = tmp_path / "above" / "course"
    course.mkdir(parents=True)
    for folder in (tmp_path, course.parent, course):
        (folder / "conftest.py").write_text("raise SystemExit('read')")
        (folder / "pytest.ini").write_text("[pytest]\naddopts = -k visible\n")
        (folder / "sitecustomize.py").write_text("raise SystemExit('read')")
        (folder / "pytest.py").write_text("raise SystemExit('read')")
    copy = course / half_right_notebook.name
    copy.write_bytes(half_right_notebook.read_bytes())
    # With `-c`, Python imports from the working folder, so the judge starts in another folder.
    assert verdict_of(copy, sandbox) == plain_verdict


@pytest.mark.slow
def test_python_may_be_started_by_a_relative_path(
    half_right_notebook, plain_verdict, sandbox, tmp_path
):
    """The relative path goes up several folders before it goes down again."""
    python = os.path.relpath(sys.executable, tmp_path)
    assert not os.path.isabs(python)
    assert verdict_of(half_right_notebook, sandbox, folder=tmp_path, python=python) == plain_verdict


@pytest.mark.slow
def test_the_working_folder_does_not_change_a_verdict(
    half_right_notebook, plain_verdict, sandbox, tmp_path
):
    folder = tmp_path / "ein Ordner mit \N{LATIN SMALL LETTER U WITH DIAERESIS} [red] $(x) %s"
    folder.mkdir()
    copy = folder / half_right_notebook.name
    copy.write_bytes(half_right_notebook.read_bytes())
    assert verdict_of(copy, sandbox, folder=folder) == plain_verdict


# ---- Tests that require a sandbox -------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("required, outcome", [("1", "error"), ("", "skipped")])
def test_attacks_fail_without_a_required_sandbox(required, outcome, tmp_path):
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
def test_at_least_a_hundred_attacks_exist():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n0", "--collect-only", "-m", ""]
        + [str(Path(__file__).parent / "attacks")],
        cwd=PROJECT,
        capture_output=True,
        text=True,
    )
    attacks = [line for line in done.stdout.splitlines() if "::test_" in line]
    assert len(attacks) >= 100
