"""The key of a verdict covers everything that the verdict depends on, and nothing else."""

import ast
import contextlib
import functools
import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import PROJECT
from grader.intake.submission import SubmittedFiles
from grader.judging import verdict_key
from grader.judging.verdict_key import verdict_dependencies

# A script for a separate process. It judges notebooks, and prints the paths that were opened or
# passed to new processes.
LISTENER = """
import os, sys
heard = set()

def listen(event, arguments):
    if event == "open":
        names = arguments[:1]
    elif event == "subprocess.Popen":
        # The program and the paths that it may see; bubblewrap only creates folders after --dir.
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

judge.verdict_key = lambda *about: ""  # it reads all files that it covers, used or not
sandbox, *notebooks = sys.argv[1:]
verdicts = [judge.judge(Path(path), 20170405, SANDBOXES[sandbox]) for path in notebooks]
faults = [fault for verdict in verdicts for fault in verdict.faults]
print(json.dumps({"heard": sorted(heard), "faults": faults}))
"""


def solved_notebook(lesson):
    """Return a notebook with the lesson's own answers, so that all checks run."""
    return lesson.solved.read_text("utf-8")


def mistaken_notebook(lesson):
    """Return a notebook with a mistake in every answer, if possible a known mistake."""
    answers = {
        exercise.name: max(
            (variant for variant in answers_to(exercise.name) if not variant.right),
            key=lambda variant: bool(variant.told),
        ).source
        for exercise in lesson.machine_graded
    }
    return fill_in(lesson, answers)


def entangled_notebook(lesson):
    """Return a notebook in which each answer is wrong and uses all earlier answers."""
    names = [exercise.name for exercise in lesson.machine_graded]
    answers = {
        name: f"def {name}(*arguments, **named):\n    return [{', '.join(names[:number])}]\n"
        for number, name in enumerate(names)
    }
    return fill_in(lesson, answers)


def read_while_judging(lesson, notebooks, folder, sandbox):
    """Return the project files that judging opens or passes to new processes."""
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
    result = json.loads(done.stdout.splitlines()[-1])
    assert result["faults"] == []
    return {file for name in result["heard"] for file in files_of_project(Path(name))}


def files_of_project(path):
    """Yield the project's source files at a path.

    A folder stands for all its modules, and a compiled module for its source.
    """
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
    missing = sorted(str(file.relative_to(PROJECT)) for file in read - verdict_dependencies(lesson))
    assert not missing, f"{', '.join(missing)}: read while judging, and not in the key"
    # The judge always reads these files. If one is missing, the audit hook does not work.
    assert {lesson.source, lesson.released, lesson.tests} <= read
    if len(lesson.machine_graded) > 1:  # the solved notebook provides right helpers
        assert lesson.solved in read


@pytest.mark.slow
def test_every_file_that_is_read_while_judging_is_in_the_key(lesson, sandbox, tmp_path):
    assert_covered(
        lesson, (solved_notebook, mistaken_notebook, entangled_notebook), tmp_path, sandbox
    )


@pytest.mark.slow
def test_every_source_of_right_helpers_is_in_the_key(sandbox, tmp_path):
    """Judge only the fastest lesson; the test above covers all lessons."""
    assert_covered(find_lesson("01_point_clouds"), (entangled_notebook,), tmp_path, sandbox)


@pytest.mark.slow
def test_every_imported_module_is_in_the_key(lesson):
    """Parsing the source also finds imports that no notebook in these tests reaches."""
    covered = verdict_dependencies(lesson)
    modules = set().union(*(modules_of(file) for file in covered if file.suffix == ".py"))
    imported = {file for module in modules for file in files_of(module)}
    shows = {
        file for file in imported if re.search("utils/(plots|scene3d|checks/display)", str(file))
    }
    assert len(imported) > 40 and imported - shows <= covered


@functools.cache
def modules_of(file):
    """Return the dotted names that a file imports; none for `lesson.py`, which is a notebook."""
    if file.name == "lesson.py":
        return frozenset()
    names = set()
    for node in ast.walk(ast.parse(file.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return frozenset(names)


def files_of(module):
    """Return the project files that run when a module is imported."""
    parts = module.split(".")
    for end in range(1, len(parts) + 1):
        path = PROJECT.joinpath(*parts[:end])
        yield from (
            file for file in (path.with_suffix(".py"), path / "__init__.py") if file.exists()
        )


# ---- an artificial project --------------------------------------------------------------

FILES = {
    "grader/__init__.py": "",
    "grader/judging/__init__.py": "",
    "grader/judging/judge.py": """
import json, grader.intake.files
from grader.judging import (
    points,
    verdict as kept,
)
from utils.checks.core import check  # and what it imports in turn
from numpy import linalg
def later():
    from utils import plots, clouds
    import utils.scene3d.scene, utils.sliders as sliders
""",
    "grader/judging/points.py": "x = 1",
    "grader/judging/verdict.py": "from grader.judging.points import x",
    "grader/judging/never.py": "import grader.judging.judge",
    "grader/intake/__init__.py": "",
    "grader/intake/files.py": "from grader.judging import judge  # in a circle",
    "grader/sandbox/fork_server.py": "import os",
    "utils/__init__.py": "",
    "utils/clouds.py": "",
    "utils/sliders/__init__.py": "",
    "utils/sliders/other.py": "",
    "utils/plots/__init__.py": "import utils.never",
    "utils/scene3d/scene.py": "",
    "utils/never.py": "",
    "utils/checks/__init__.py": "",
    "utils/checks/core.py": "from utils.checks.display import Table\nimport utils.plotted",
    "utils/checks/display.py": "",
    "utils/checks/lesson_06.py": "",
    "utils/plotted.py": "",
    "inside/worker.py": "",
    "inside/deep/wire.py": "",
    "inside/notes.txt": "",
    "data/cloud.txt": "1 2 3",
    "data/truth.npz": "4",
    "data/frames.npz": "5",
    "solutions/06/lesson.py": "a",
    "solutions/06.ipynb": "b",
    "notebooks/06.ipynb": "c",
    "tests/test_06.py": "import utils.clouds",
}
DECIDING_FILES = {
    *("grader/__init__.py", "grader/judging/__init__.py", "grader/intake/__init__.py"),
    *("grader/judging/judge.py", "grader/judging/points.py", "grader/judging/verdict.py"),
    *("grader/intake/files.py", "grader/sandbox/fork_server.py"),
    *("utils/__init__.py", "utils/clouds.py", "utils/sliders/__init__.py", "utils/plotted.py"),
    *("utils/checks/__init__.py", "utils/checks/core.py", "utils/checks/lesson_06.py"),
    *("inside/worker.py", "inside/deep/wire.py", "data/cloud.txt", "data/truth.npz"),
    *("solutions/06/lesson.py", "solutions/06.ipynb", "notebooks/06.ipynb", "tests/test_06.py"),
}


@dataclass(frozen=True)
class ArtificialLesson:
    """A lesson of the artificial project."""

    root: Path
    name: str = "06"
    number = "06"
    source = property(lambda self: self.root / "solutions" / "06" / "lesson.py")
    solved = property(lambda self: self.root / "solutions" / "06.ipynb")
    released = property(lambda self: self.root / "notebooks" / "06.ipynb")
    tests = property(lambda self: self.root / "tests" / "test_06.py")


def clear_caches():
    for remembered in (
        verdict_key._imported_files,
        verdict_key._find_module_file,
        verdict_key._digest_of,
        verdict_key.rules_key,
    ):
        remembered.cache_clear()


@pytest.fixture
def artificial_lesson(tmp_path, monkeypatch):
    """Create an artificial project in its own folder, and return its lesson."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    entries = ("grader/judging/judge.py", "grader/sandbox/fork_server.py")
    monkeypatch.setattr(verdict_key, "PROJECT", tmp_path)
    monkeypatch.setattr(verdict_key, "ENTRY_MODULES", tuple(tmp_path / name for name in entries))
    monkeypatch.setattr(verdict_key, "ARRAY_FILES", (tmp_path / "data" / "truth.npz",))
    monkeypatch.setattr(
        verdict_key, "SHOWN_PATHS", (tmp_path / "inside", tmp_path / "data" / "cloud.txt")
    )
    clear_caches()
    yield ArtificialLesson(tmp_path)
    clear_caches()


def test_the_files_that_decide_are_the_files_that_the_entries_import(artificial_lesson):
    found = verdict_key.verdict_dependencies(artificial_lesson)
    assert {file.relative_to(artificial_lesson.root).as_posix() for file in found} == DECIDING_FILES


def test_the_key_changes_only_with_files_that_decide(artificial_lesson):
    right = verdict_key.rules_key(artificial_lesson)
    for name, text in FILES.items():
        (artificial_lesson.root / name).write_text(f"{text}\n# A remark.\n")
        clear_caches()
        assert (verdict_key.rules_key(artificial_lesson) != right) == (name in DECIDING_FILES), name
        (artificial_lesson.root / name).write_text(text)
    clear_caches()
    assert verdict_key.rules_key(artificial_lesson) == right


def test_the_key_changes_with_the_names_of_files_and_lesson_and_with_versions(
    artificial_lesson, monkeypatch
):
    right = verdict_key.rules_key(artificial_lesson)
    assert verdict_key.rules_key(ArtificialLesson(artificial_lesson.root, "07")) != right
    folder = artificial_lesson.root / "inside"
    (folder / "worker.py").rename(folder / "walker.py")
    clear_caches()
    assert verdict_key.rules_key(artificial_lesson) != right
    (folder / "walker.py").rename(folder / "worker.py")
    versions = verdict_key.versions()
    for name in versions:
        monkeypatch.setattr(verdict_key, "versions", lambda name=name: versions | {name: "0.1"})
        clear_caches()
        assert verdict_key.rules_key(artificial_lesson) != right
    monkeypatch.setattr(verdict_key, "versions", lambda: dict(versions))
    clear_caches()
    assert verdict_key.rules_key(artificial_lesson) == right


def test_the_key_has_the_versions_of_libraries_that_decide():
    versions = verdict_key.versions()
    assert versions["Python"] == f"{sys.version_info.major}.{sys.version_info.minor}"
    assert versions["numpy"] == np.__version__ and versions["pytest"] == pytest.__version__
    assert set(versions) == {"Python", "numpy", "scipy", "scikit-learn", "shapely", "pytest"}


def test_the_entries_of_judging_exist():
    entries = {path.relative_to(PROJECT).as_posix() for path in verdict_key.ENTRY_MODULES}
    assert entries == {"grader/judging/judge.py", "grader/sandbox/fork_server.py"}
    assert all(path.is_file() for path in verdict_key.ENTRY_MODULES)


def test_the_key_depends_on_student_submission_and_seed():
    lesson, notebook = find_lesson("06_filter_ground"), SubmittedFiles("06.ipynb", b"{}")
    keys = [
        verdict_key.verdict_key(notebook, lesson, 17),
        verdict_key.verdict_key(notebook, lesson, 17, "ada"),
        verdict_key.verdict_key(notebook, lesson, 18, "ada"),
        verdict_key.verdict_key(notebook, find_lesson("07_filter_by_distance"), 17, "ada"),
        verdict_key.verdict_key(SubmittedFiles("06.ipynb", b"{} "), lesson, 17, "ada"),
    ]
    assert len(set(keys)) == 5 and all(re.fullmatch("[0-9a-f]{64}", key) for key in keys)
    assert verdict_key.verdict_key(notebook, lesson, 17, "") == keys[0]
    # A name that is not valid UTF-8 must not raise an exception.
    verdict_key.verdict_key(notebook, lesson, 17, os.fsdecode(b"J\xfcrgen"))


KEYS = """
import json
from grader.course.lessons import all_lessons
from grader.judging.verdict_key import rules_key
print(json.dumps({lesson.number: rules_key(lesson) for lesson in all_lessons()}))
"""
ALL = tuple(lesson.number for lesson in all_lessons())


@pytest.fixture(scope="module")
def project_copy(tmp_path_factory):
    """Return a copy of the project, and its keys."""
    root = tmp_path_factory.mktemp("project") / "lab"
    for folder in ("grader", "utils", "solutions", "notebooks", "data"):
        without = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PROJECT / folder, root / folder, ignore=without)
    return root, keys_in(root)


def keys_in(root):
    """Return the key of each lesson's rules, computed in a new process."""
    done = subprocess.run(
        [sys.executable, "-c", KEYS], cwd=root, capture_output=True, text=True, check=True
    )
    return json.loads(done.stdout)


@contextlib.contextmanager
def change_temporarily(path):
    """Append a comment to a file, and restore the file at the end of the context."""
    content = path.read_bytes()
    path.write_bytes(content + b"\n# A remark.\n")
    yield
    path.write_bytes(content)


@pytest.mark.slow
def test_a_comment_in_a_plotting_module_keeps_all_verdicts_valid(project_copy):
    root, before = project_copy
    elsewhere = (
        "utils/plots/__init__.py",
        "utils/plots/style.py",
        "utils/scene3d/scene.py",
        "utils/checks/display.py",
        "utils/lent/lesson_06.json",
        "grader/classroom/grade.py",
        "grader/course/build.py",
        "grader/lms/gradebook_writer.py",
        "solutions/footer_cell.md",
        "solutions/stage3_obstacles/06_filter_ground/slips.py",
        "solutions/stage3_obstacles/06_filter_ground/answers/voxel_grid.txt",
    )
    with contextlib.ExitStack() as stack:
        for name in elsewhere:
            stack.enter_context(change_temporarily(root / name))
        assert keys_in(root) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "lessons"),
    [
        ("grader/sandbox/inside/worker.py", ALL),
        ("data/cloud.txt", ALL),
        ("solutions/stage3_obstacles/06_filter_ground/hidden_tests.py", ("06",)),
        # This file contains the list of forbidden modules.
        ("solutions/stage2_clustering/05_euclidean_clustering/lesson.py", ("05",)),
        ("solutions/stage1_ransac/03_ransac_plane.ipynb", ("03",)),  # contains the right helpers
        ("utils/checks/clusters.py", ("05", "10")),
    ],
)
def test_a_change_invalidates_only_the_verdicts_that_depend_on_it(project_copy, name, lessons):
    root, before = project_copy
    with change_temporarily(root / name):
        after = keys_in(root)
    assert tuple(number for number in ALL if after[number] != before[number]) == lessons
