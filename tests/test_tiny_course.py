"""The grader works with another course, whose exercises use plain lists."""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile

import pytest

from grader.course.paths import PROJECT

STAGE, LESSON = "stage1_numbers", "01_root_mean_square"
CELL = '# %% nbgrader={{"grade": {grade}, "grade_id": "{name}", "locked": {grade}, {points}\
"schema_version": 3, "solution": {solution}, "task": false}}\n'
SECOND = (
    CELL.format(grade="false", name="longest_run", points="", solution="true")
    + '''def longest_run(values):
    """Count how often a value is repeated without a break, at most."""
    # roughly 6 lines
    ### BEGIN SOLUTION
    best = count = 0
    for place, value in enumerate(values):
        count = count + 1 if place and value == values[place - 1] else 1
        best = max(best, count)
    return best
    ### END SOLUTION

'''
    + CELL.format(grade="true", name="test_longest_run", points='"points": 5, ', solution="false")
    + "check(longest_run)\n\n"
)
CHECKS = """

_RUN = Exercise(
    __name__,
    "longest_run",
    {"values": ["a", "b", "b", "b", "a", "a"]},
    3,
    title="Finds a run in the middle",
    why="Runs may be anywhere.",
    hint="Compare each value with the one before it.",
)
_RUN.example(
    "nothing_has_no_run",
    {"values": []},
    0,
    title="Works on an empty list",
    why="The list may be empty.",
    hint="Begin with 0.",
)
_RUN.promise("untouched")
"""
HIDDEN = """

@hidden("longest_run", title="Right on lists that you have not seen", hint="Count again.")
def test_random_values(student, seed):
    values = np.random.default_rng(seed).integers(0, 2, 60).tolist()
    expected = max(len(run) for run in "".join(map(str, values)).replace("01", "0 1")
                   .replace("10", "1 0").split())
    assert_answer(student.longest_run(values), expected)
"""


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Return a folder with the grader, its tools, and a course of one lesson."""
    root = tmp_path_factory.mktemp("course") / "numbers"
    for folder in ("grader", "utils", "data"):
        ignored = shutil.ignore_patterns("__pycache__", "lesson_[0-9]*", "cells.json")
        shutil.copytree(PROJECT / folder, root / folder, ignore=ignored)
    (root / "solutions").mkdir()
    for path in (PROJECT / "solutions").glob("*.*"):
        shutil.copy(path, root / "solutions")
    for path in (*PROJECT.glob("*.toml"), *PROJECT.glob("*.txt"), *PROJECT.glob("nbgrader*.py")):
        shutil.copy(path, root)
    shutil.copy(PROJECT / "LICENSE", root)
    run(root, "new", LESSON, "--stage", STAGE)
    folder = root / "solutions" / STAGE / LESSON
    edit(
        folder / "lesson.py",
        "# %% [markdown]\n# ## Summary",
        SECOND + "# %% [markdown]\n# ## Summary",
    )
    edit(root / "utils" / "checks" / "lesson_01.py", None, CHECKS)
    edit(folder / "hidden_tests.py", None, HIDDEN)
    return root


def edit(path, old, new):
    text = path.read_text("utf-8")
    assert old is None or text.count(old) == 1
    path.write_text(text + new if old is None else text.replace(old, new), "utf-8")


def run(root, *arguments, status=0):
    done = subprocess.run(
        [sys.executable, "-m", "grader", *map(str, arguments)],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_a_course_on_another_subject_is_built_released_judged_and_graded(course, sandbox):
    assert f"wrote notebooks/{STAGE}/{LESSON}.ipynb" in run(course, "build")
    assert "are up to date" in run(course, "build", "--check")

    run(course, "release", STAGE, "--to", course / "released")
    with zipfile.ZipFile(course / "released" / f"{STAGE}.zip") as archive:
        names = [name for name in archive.namelist() if name.endswith(".ipynb")]
        (released,) = (json.loads(archive.read(name)) for name in names)
    assert "best = count = 0" not in json.dumps(released)

    solved = course / "solutions" / STAGE / f"{LESSON}.ipynb"
    judged = json.loads(run(course, "judge", solved, "--json", "--sandbox", sandbox.name))
    assert (judged["score"], judged["max_score"]) == (15, 15)
    assert [exercise["name"] for exercise in judged["exercises"]] == [
        "root_mean_square",
        "longest_run",
    ]
    slipped = course / "submitted" / "bo" / STAGE / solved.name
    right = course / "submitted" / "ada" / STAGE / solved.name
    for path, text in (
        (right, solved.read_text("utf-8")),
        (slipped, solved.read_text("utf-8").replace("best = count = 0", "best = count = 1")),
    ):
        path.parent.mkdir(parents=True)
        path.write_text(text, "utf-8")
    run(course, "grade", "--sandbox", sandbox.name)
    run(course, "export", "--format", "csv", "--to", course / "scores.csv")
    with open(course / "scores.csv", encoding="utf-8-sig", newline="") as file:
        rows = {row["Student"]: row for row in csv.DictReader(file)}
    assert float(rows["ada"][LESSON]) == 15 and 10 < float(rows["bo"][LESSON]) < 15
    assert "Works on an empty list" in (course / "report" / "index.html").read_text("utf-8")


def test_the_grader_does_not_name_the_subject_of_a_course():
    subject = re.compile(
        r"(?<![a-z])(clouds?|lidar|scanners?|simulators?|drives?|obstacles?)(?![a-z])"
    )
    # Allowed: the project's name, examples of stages, a package, and network and disk drives.
    others = re.compile(
        r"lidar[-_ ]obstacle[-_ ]lab|stage\d_\w+|cloudpickle|network drive|drive letter"
    )
    found = [
        f"{path.relative_to(PROJECT)}: {line.strip()}"
        for path in sorted((PROJECT / "grader").rglob("*.*"))
        if path.suffix in (".py", ".css", ".js")
        for line in path.read_text("utf-8").splitlines()
        if subject.search(others.sub("", line.lower()).replace("_", " "))
    ]
    assert found == []
