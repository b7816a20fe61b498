"""A verdict's key covers all that decided it, and nothing else."""

import ast
import contextlib
import functools
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import PROJECT
from grader.course.variants import fill_in, variants_of
from grader.judging.key import files_that_decide

# Judges notebooks in a process of its own; prints what was opened and started meanwhile.
LISTENER = """
import os, sys
heard = set()

def listen(event, arguments):
    if event == "open":
        names = arguments[:1]
    elif event == "subprocess.Popen":
        # What is run, and what is shown to it; bubblewrap makes a folder for the latter to lie in.
        command = arguments[1]
        names = [name for name, before in zip(command, ["", *command]) if before != "--dir"]
    else:
        return
    for name in names:
        if isinstance(name, str | bytes | os.PathLike):
            heard.add(os.path.abspath(os.fsdecode(name)))

sys.addaudithook(listen)

import json
from pathlib import Path
from grader.judging import judge
from grader.sandbox import SANDBOXES

judge.verdict_key = lambda *about: ""  # it reads all that it covers, which says nothing
sandbox, *notebooks = sys.argv[1:]
verdicts = [judge.judge(Path(path), 20170405, SANDBOXES[sandbox]) for path in notebooks]
faults = [fault for verdict in verdicts for fault in verdict.faults]
print(json.dumps({"heard": sorted(heard), "faults": faults}))
"""


def solved(lesson):
    """The lesson's own answers, which all tests are asked of to the end."""
    return lesson.solved.read_text("utf-8")


def mistaken(lesson):
    """A mistake in every answer, told by its name where there is one that is."""
    answers = {
        one.name: max(
            (variant for variant in variants_of(one.name) if not variant.right),
            key=lambda variant: bool(variant.told),
        ).source
        for one in lesson.machine_graded
    }
    return fill_in(lesson, answers)


def entangled(lesson):
    """Each answer uses all before it and is wrong: it is judged again with right ones."""
    names = [one.name for one in lesson.machine_graded]
    answers = {
        name: f"def {name}(*arguments, **named):\n    return [{', '.join(names[:number])}]\n"
        for number, name in enumerate(names)
    }
    return fill_in(lesson, answers)


def read_while_judging(lesson, notebooks, folder, sandbox):
    """Files of this project that are opened, run or shown while notebooks are judged."""
    paths = []
    for notebook in notebooks:
        path = folder / notebook.__name__ / f"{lesson.name}.ipynb"
        path.parent.mkdir()
        path.write_text(notebook(lesson), "utf-8")
        paths.append(path)
    done = subprocess.run(
        [sys.executable, "-c", LISTENER, sandbox.name, *map(str, paths)],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout.splitlines()[-1])
    assert said["faults"] == []
    return {file for name in said["heard"] for file in files_of_project(Path(name))}


def files_of_project(path):
    """What is meant by a path that was heard of: a file, or all files of a folder."""
    if not path.is_relative_to(PROJECT) or path.is_relative_to(sys.prefix):
        return
    within = path.relative_to(PROJECT).parts
    if not within or within[0].startswith("."):
        return
    if path.is_dir():
        yield from path.rglob("*.py")
    elif path.suffix == ".pyc":
        name = path.name.partition(".")[0]
        yield path.parents[1] / f"{name}.py"
    elif path.is_file():
        yield path


def assert_covered(lesson, notebooks, folder, sandbox):
    read = read_while_judging(lesson, notebooks, folder, sandbox)
    missing = sorted(str(file.relative_to(PROJECT)) for file in read - files_that_decide(lesson))
    assert not missing, f"{', '.join(missing)}: read while judging, and not in the key"
    # It does listen, also to where right helpers come from.
    assert {lesson.source, lesson.released, lesson.tests} <= read
    assert (lesson.solved in read) == (len(lesson.machine_graded) > 1)


@pytest.mark.slow
def test_every_file_that_is_read_while_judging_is_in_the_key(lesson, sandbox, tmp_path):
    assert_covered(lesson, (solved, mistaken, entangled), tmp_path, sandbox)


def test_every_file_that_a_right_helper_comes_from_is_in_the_key(sandbox, tmp_path):
    """In the lesson that takes least time; the test above tries them all."""
    assert_covered(find_lesson("01_point_clouds"), (entangled,), tmp_path, sandbox)


@pytest.mark.slow
def test_what_is_imported_in_the_code_is_in_the_key(lesson):
    """Also where no notebook of ours gets to; asked of Python's own parser."""
    covered = files_that_decide(lesson)
    modules = set().union(*(modules_of(file) for file in covered if file.suffix == ".py"))
    imported = {file for module in modules for file in files_of(module)}
    shows = {
        file for file in imported if re.search("utils/(plots|scene3d|checks/display)", str(file))
    }
    assert len(imported) > 40 and imported - shows <= covered


@functools.cache
def modules_of(file):
    """Dotted names that a file imports something by, or from; a lesson's source is a notebook."""
    if file.is_relative_to(PROJECT / "solutions"):
        return frozenset()
    names = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(names)


def files_of(module):
    """Files of this project that are run when a module is imported."""
    parts = module.split(".")
    for end in range(1, len(parts) + 1):
        path = PROJECT.joinpath(*parts[:end])
        yield from (
            file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()
        )


KEYS = """
import json
from grader.course.lessons import all_lessons
from grader.judging.key import rules_key
print(json.dumps({lesson.number: rules_key(lesson) for lesson in all_lessons()}))
"""
ALL = tuple(lesson.number for lesson in all_lessons())


@pytest.fixture(scope="module")
def copy(tmp_path_factory):
    """The project, and its keys."""
    root = tmp_path_factory.mktemp("project") / "lab"
    for folder in ("grader", "utils", "solutions", "notebooks", "data"):
        without = shutil.ignore_patterns("__pycache__", "pictures")
        shutil.copytree(PROJECT / folder, root / folder, ignore=without)
    return root, keys_in(root)


def keys_in(root):
    """What decides in each lesson, as a fresh process sees it."""
    done = subprocess.run(
        [sys.executable, "-c", KEYS], cwd=root, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


@contextlib.contextmanager
def changed(path):
    """A remark at the end of a file, for a while."""
    content = path.read_bytes()
    path.write_bytes(content + b"\n# A remark.\n")
    yield
    path.write_bytes(content)


@pytest.mark.slow
def test_a_comment_in_a_plotting_module_judges_nobody_again(copy):
    root, before = copy
    elsewhere = (
        "utils/plots/__init__.py",
        "utils/plots/style.py",
        "utils/scene3d/scene.py",
        "utils/checks/display.py",
        "utils/lent/lesson_06.json",
        "grader/classroom/grade.py",
        "grader/course/build.py",
        "grader/lms/gradebook.py",
        "solutions/footer_cell.md",
    )
    with contextlib.ExitStack() as stack:
        for name in elsewhere:
            stack.enter_context(changed(root / name))
        assert keys_in(root) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "lessons"),
    [
        ("grader/sandbox/inside/worker.py", ALL),
        ("data/cloud.txt", ALL),
        ("grader/tests/test_06_filter_ground.py", ("06",)),
        ("solutions/stage2_clustering/05_euclidean_clustering.py", ("05",)),  # what is forbidden
        ("solutions/stage1_ransac/03_ransac_plane.ipynb", ("03",)),  # right helpers
        ("utils/checks/clusters.py", ("05", "10")),
    ],
)
def test_a_change_judges_those_again_whom_it_concerns(copy, name, lessons):
    root, before = copy
    with changed(root / name):
        after = keys_in(root)
    assert tuple(number for number in ALL if after[number] != before[number]) == lessons
