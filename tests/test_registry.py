"""Lessons are found by their file names, headers and cells."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
import sys

import jupytext
import pytest

from grader import cli, commands
from grader.course import build, lessons
from grader.course.header import LessonHeader, read_header
from grader.course.kept_answers import answers_to
from grader.course.lessons import all_lessons, find_lesson, lesson_of
from grader.course.paths import PROJECT
from utils.checks import checks_of, core

HEAD = """\
# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
{settings}# ---

# %% [markdown]
# # A lesson
"""

SOLUTION = {
    "grade": False,
    "grade_id": "highest",
    "locked": False,
    "schema_version": 3,
    "solution": True,
    "task": False,
}
TEST = {
    **SOLUTION,
    "grade": True,
    "grade_id": "test_highest",
    "locked": True,
    "points": 7,
    "solution": False,
}
# A lesson as in the author guide: a folder and a module of checks. No list names it.
TOY = {
    "solutions/stage4_realtime/14_toy/lesson.py": """\
# ---
# jupyter:
#   kernelspec:
#     display_name: Python 3 (ipykernel)
#     language: python
#     name: python3
#   lidar_obstacle_lab:
#     forbidden: [statistics]
#     given: [Highest]
# ---

# %% [markdown]
# # 14 · The highest point
#
# ![Two points, the higher one circled.](14_preview.png)

# %% [markdown] tags=["badge"]
# (where to run this notebook)

# %% tags=["setup"]
# (setup)

# %%
from utils import check


class Highest:
    def __init__(self):
        self.z = None

    def see(self, cloud):
        self.z = highest(cloud)


# %% nbgrader={SOLUTION}
def highest(cloud):
    \"\"\"Height of the highest point.\"\"\"
    # Take the largest z.
    # roughly 1 line
    ### BEGIN SOLUTION
    return max(z for _, _, z, *_ in cloud)
    ### END SOLUTION

# %% nbgrader={TEST}
check(highest)

# %% [markdown] tags=["footer"]
# (footer)
""",
    "utils/checks/lesson_14.py": """\
from utils.checks.core import visible_check
from utils.checks.assertions import CheckFailed


@visible_check("highest", title="Finds it", why="Bridges are low.", hint="Look at z.")
def finds_it(highest):
    if highest([[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]) != 3.0:
        raise CheckFailed("That is not the highest.")
""",
    "solutions/stage4_realtime/14_toy/hidden_tests.py": """\
from grader.judging.hidden_tests import hidden


@hidden("highest", title="An object sees the same", hint="Read `Highest`.")
def test_object(student):
    one = student.Highest()
    one.see([[0.0, 0.0, -2.0], [0.0, 0.0, -1.0]])
    assert one.z == -1.0
""",
    "solutions/stage4_realtime/14_toy/answers/highest.txt": """\
# %% right: a loop
def highest(cloud):
    z = cloud[0][2]
    for row in cloud:
        z = max(z, row[2])
    return z

# %% wrong: the lowest
# loses: finds_it
# says: not the highest
def highest(cloud):
    return min(row[2] for row in cloud)

# %% wrong: a library
# loses: finds_it
# says: not allowed
def highest(cloud):
    import statistics
    return statistics.quantiles([row[2] for row in cloud])[-1]
""",
    "solutions/stage4_realtime/14_toy/preview.py": """\
import matplotlib.pyplot as plt


def draw():
    figure, axes = plt.subplots(figsize=(2, 1))
    axes.plot([0, 1], "o")
    return figure
""",
}


JUDGE_ANSWERS = """
import json, sys
from pathlib import Path
from grader.course.lessons import find_lesson
from grader.course.kept_answers import fill_in, answers_to
from grader.judging.judge import judge
from grader.sandbox import SANDBOXES
lesson, path = find_lesson("14_toy"), Path("14_toy.ipynb")
for variant in answers_to("highest"):
    path.write_text(fill_in(lesson, {"highest": variant.source}), "utf-8")
    print(json.dumps(judge(path, 1, SANDBOXES[sys.argv[1]]).as_dict()))
"""


@pytest.fixture(scope="module")
def project_copy(tmp_path_factory):
    """Return the path of a copy of the project with an additional lesson 14."""
    root = tmp_path_factory.mktemp("project") / "lab"
    for folder in ("extension", "grader", "utils", "solutions", "notebooks", "data"):
        shutil.copytree(
            PROJECT / folder, root / folder, ignore=shutil.ignore_patterns("__pycache__")
        )
    shutil.copy(PROJECT / "pyproject.toml", root)
    for path, text in TOY.items():
        assert not (root / path).exists()
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(
            text.replace("{SOLUTION}", json.dumps(SOLUTION)).replace("{TEST}", json.dumps(TEST)),
            "utf-8",
        )
    return root


def run(root, *arguments):
    done = subprocess.run(
        [sys.executable, "-m", *map(str, arguments)],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.slow
def test_adding_a_lesson_takes_only_a_folder_and_a_module_of_checks(project_copy, sandbox):
    guide = (PROJECT / "docs" / "authors.md").read_text("utf-8")
    listed_paths = {
        path.replace("stage4_realtime", "<stage>")
        .replace("14_toy", "<NN_name>")
        .replace("lesson_14", "lesson_<NN>")
        .replace("highest", "<exercise>")
        for path in TOY
    }
    assert all(f"| `{path}` |" in guide for path in listed_paths)

    assert "14_preview.png" in run(project_copy, "grader.course.previews", 14)
    output_lines = run(project_copy, "grader", "build").splitlines()
    assert sorted(output_lines) == [
        "wrote notebooks/stage4_realtime/14_toy.ipynb",
        "wrote solutions/stage4_realtime/14_toy.ipynb",
        "wrote utils/checks/forbidden.json",
        "wrote utils/lent/cells.json",
    ]
    assert "are up to date" in run(project_copy, "grader", "build", "--check")

    def judge(path):
        options = ("--json", "--seed", 2**64 + 1, "--sandbox", sandbox.name)
        verdict = json.loads(run(project_copy, "grader", "judge", path, *options))
        return verdict["score"], verdict["max_score"], verdict

    assert judge("solutions/stage4_realtime/14_toy.ipynb")[:2] == (7, 7)
    assert judge("notebooks/stage4_realtime/14_toy.ipynb")[:2] == (0, 7)
    done = subprocess.run(
        [sys.executable, "-c", JUDGE_ANSWERS, sandbox.name],
        cwd=project_copy,
        env={**os.environ, "PYTHONPATH": str(project_copy)},
        capture_output=True,
        text=True,
        check=True,
    )
    right, lowest_point, library = map(json.loads, done.stdout.splitlines())
    assert right["score"] == 7
    for verdict, message in ((lowest_point, "not the highest"), (library, "not allowed")):
        tests = verdict["exercises"][0]["tests"]
        assert verdict["score"] < 7 and message in " ".join(test["message"] for test in tests)
        assert "finds_it" in {test["name"] for test in tests if not test["passed"]}


@pytest.fixture
def registry(tmp_path, monkeypatch):
    """Return a function that writes lessons (text by path) and returns the registry's faults."""

    def make(sources):
        for path, text in sources.items():
            source = tmp_path / "solutions" / path
            source.parent.mkdir(parents=True, exist_ok=True)
            source.write_text(HEAD.format(settings="") + text, "utf-8")
        monkeypatch.setattr(lessons, "PROJECT", tmp_path)
        monkeypatch.setattr(lessons, "all_lessons", lessons.all_lessons.__wrapped__)
        monkeypatch.setattr(lessons, "optional_lessons", lessons.optional_lessons.__wrapped__)
        return lessons.registry_faults()

    return make


GRADED = f"# %% nbgrader={json.dumps(TEST)}\ncheck(highest)\n"


def test_a_valid_course_has_no_faults(registry):
    assert registry({"stage1_a/01_one/lesson.py": GRADED, "optional/02_two/lesson.py": ""}) == []
    assert lessons.every_lesson()[0].name == "01_one"


@pytest.mark.parametrize(
    ("sources", "message"),
    [
        (
            {"extra/14_toy/lesson.py": ""},
            "solutions/extra/14_toy/lesson.py is ignored. Move it to solutions/STAGE/NN_NAME/",
        ),
        (
            {"stage1_a/14_toy.py": ""},
            "solutions/stage1_a/14_toy.py is ignored. Move it to "
            "solutions/stage1_a/14_toy/lesson.py.",
        ),
        (
            {"stage1_a/01_one/lesson.py": "", "stage2_b/01_two/lesson.py": ""},
            "01_one and 01_two have the same number. Renumber one of them",
        ),
        (
            {"stage1_a/01_one/lesson.py": GRADED, "stage1_a/02_two/lesson.py": GRADED},
            "01_one and 02_two both have an exercise highest. Rename one of the two.",
        ),
    ],
)
def test_ignored_and_colliding_lessons_are_reported(registry, sources, message):
    (fault,) = registry(sources)
    assert message in fault


def test_a_course_with_faults_is_not_built(monkeypatch, capsys):
    monkeypatch.setattr(build, "registry_faults", lambda: ["14_toy is ignored."])
    monkeypatch.setattr(build, "build_all", lambda: pytest.fail("it is built"))
    assert cli.main(["build"]) == commands.FAULT
    assert capsys.readouterr().err == "14_toy is ignored.\n"
    assert cli.main(["build", "--check"]) == commands.FAULT


def test_two_lessons_cannot_declare_checks_for_the_same_exercise(monkeypatch):
    """One process judges many lessons, so the checks of one would also count in the other."""
    monkeypatch.setattr(core, "_CHECKS", {})

    def declare(lesson, exercise):
        def finds_it(function):
            """Accept every answer; `__module__` is set below."""

        finds_it.__module__ = f"utils.checks.{lesson}"
        core.visible_check(exercise, title="Finds it", why="", hint="")(finds_it)

    declare("lesson_06", "filter_ground")
    declare("lesson_06.more", "filter_ground")
    declare("lesson_15", "another")
    with pytest.raises(ValueError, match="lesson_15 and lesson_06 both have an exercise"):
        declare("lesson_15", "filter_ground")
    assert len(core.checks_of("filter_ground")) == 2


def test_kept_answers_name_only_existing_checks(lesson):
    """Otherwise, a misspelt check in an answer's claims would be noticed only during judging."""
    hidden = set(re.findall(r"^def (test_\w+)", lesson.tests.read_text("utf-8"), re.M))
    for exercise in lesson.machine_graded:
        known = hidden | {check.name for check in checks_of(exercise.name)}
        for answer in answers_to(exercise.name):
            for claim in answer.loses:  # the first part of a name, perhaps with a parameter
                prefix = claim.partition("[")[0]
                assert any(name.startswith(prefix) for name in known), f"{answer.name}: {claim}"


def test_every_lesson_has_its_files(lesson):
    assert lesson.tests.is_file()
    checks = PROJECT / "utils" / "checks" / f"lesson_{lesson.number}"
    assert checks.with_suffix(".py").is_file() != checks.is_dir()
    assert (lesson.folder / "preview.py").is_file()
    for exercise in lesson.machine_graded:
        assert (lesson.folder / "answers" / f"{exercise.name}.txt").is_file()
        assert checks_of(exercise.name)
        assert lesson_of(exercise.name) == lesson


def test_grader_and_utils_contain_no_lesson_names():
    """No other file of `grader` and `utils` contains a lesson's name as a string."""
    names = {lesson.name for lesson in all_lessons()}
    own = ("lesson_", "test_0", "test_1")
    for path in [*(PROJECT / "grader").rglob("*.py"), *(PROJECT / "utils").rglob("*.py")]:
        if path.name.startswith(own):
            continue
        code = path.read_text("utf-8")
        listed = {name for name in names if f'"{name}"' in code}
        assert not listed, path


def test_the_header_contains_the_lessons_rules():
    assert find_lesson("04_kd_tree").header == LessonHeader(
        forbidden=("scipy.spatial", "sklearn"),
        given=("Node", "KdTree"),
        lent=("grow", "trace", "levels", "cost_of", "measure", "search_the_scan"),
    )
    assert dataclasses.replace(find_lesson("06_filter_ground").header, lent=()) == LessonHeader()


def test_jupyterlab_keeps_the_header(tmp_path):
    """The header survives when JupyterLab opens and saves a lesson's source through jupytext."""
    source = find_lesson("04_kd_tree").source
    shutil.copy(PROJECT / "pyproject.toml", tmp_path)
    saved = tmp_path / source.name
    jupytext.write(jupytext.read(source), saved, fmt="py:percent")
    assert read_header(saved) == read_header(source)


@pytest.mark.parametrize(
    "settings",
    [
        "#   lidar_obstacle_lab:\n#     forbiden: [scipy]\n",
        "#   lidar_obstacle_lab:\n#     forbidden: scipy\n",
    ],
)
def test_a_typo_in_the_header_is_reported(tmp_path, settings):
    path = tmp_path / "14_slip.py"
    path.write_text(HEAD.format(settings=settings), "utf-8")
    with pytest.raises(ValueError, match="14_slip.py: the header contains `forb"):
        read_header(path)


def test_a_lesson_without_a_header_is_reported(tmp_path):
    path = tmp_path / "14_slip.py"
    path.write_text("# %%\n1\n", "utf-8")
    with pytest.raises(ValueError, match="docs/authors.md"):
        read_header(path)
    path.write_text(HEAD.format(settings=""), "utf-8")
    assert read_header(path) == LessonHeader()
    names = {field.name for field in dataclasses.fields(LessonHeader)}
    assert names == {"forbidden", "given", "lent"}
