"""Standalone notebooks do not need any other files."""

import base64
import hashlib
import io
import json
import lzma
import re
import subprocess
import sys
import tarfile

import nbformat
import pytest

from grader import cli
from grader.course import standalone
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson
from grader.course.paths import PROJECT
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.lms.autograded_copy import build_copy, graded_cells

pytestmark = pytest.mark.slow

LESSON = find_lesson("06_filter_ground")


@pytest.fixture(scope="module")
def written_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("standalone")
    assert cli.main(["release", "--standalone", "--to", str(folder)]) == 0
    return folder


def unpacked_files(notebook):
    """Return the files in the setup cell of a notebook, by name."""
    (cell,) = [
        "".join(cell["source"])
        for cell in json.loads(notebook)["cells"]
        if "".join(cell["source"]).startswith(standalone.TITLE)
    ]
    data = base64.b85decode(re.search(r'^packed = "(.*)"$', cell, re.M)[1])
    with tarfile.open(fileobj=io.BytesIO(lzma.decompress(data))) as archive:
        return {
            entry.name: archive.extractfile(entry).read() for entry in archive if entry.isfile()
        }


def test_each_lesson_has_one_small_notebook(written_folder):
    assert [path.stem for path in sorted(written_folder.iterdir())] == [
        lesson.name for lesson in all_lessons()
    ]
    for path in written_folder.iterdir():
        assert path.stat().st_size < 490_000
        nbformat.validate(nbformat.read(path, as_version=4))


def test_notebooks_written_again_have_the_same_bytes(written_folder, tmp_path):
    standalone.setup_cell.cache_clear()
    standalone.write_standalone(tmp_path, [LESSON.stage])
    paths = list(tmp_path.iterdir())
    assert paths
    for path in paths:
        assert path.read_bytes() == (written_folder / path.name).read_bytes()


def test_each_notebook_has_the_checks_and_rules_of_its_lesson(written_folder):
    for path in written_folder.iterdir():
        names = unpacked_files(path.read_bytes())
        mine = {name for name in names if name.startswith("utils/checks/lesson_")}
        own = (PROJECT / "utils" / "checks").rglob("*.py")
        own = {path.relative_to(PROJECT).as_posix() for path in own}
        assert mine and mine == {name for name in own if f"/lesson_{path.name[:2]}" in name}
        assert "utils/checks/forbidden.json" in names
        cases = {name for name in names if name.startswith("utils/questions/lesson_")}
        assert cases == {f"utils/questions/lesson_{path.name[:2]}.py"}


def test_only_lessons_with_drawings_to_change_by_hand_contain_their_script(written_folder):
    for path in written_folder.iterdir():
        drawn = "utils/by_hand/by_hand.js" in unpacked_files(path.read_bytes())
        assert drawn == (path.name[:2] in ("02", "04", "05", "09")), path.name


def test_a_notebook_contains_no_solution_and_no_part_of_the_grader(written_folder):
    found = unpacked_files((written_folder / "06_filter_ground.ipynb").read_bytes())
    keys = json.loads((PROJECT / "utils/lent/cells.json").read_text())
    assert json.loads(found.pop("utils/lent/cells.json")) == {"06": keys["06"]}
    assert found["utils/__init__.py"] == (PROJECT / "utils" / "__init__.py").read_bytes()
    for name, content in found.items():
        assert name.startswith("utils/") and "test" not in name.split("/")[-1]
        assert content == (PROJECT / name).read_bytes()
        assert b"import grader" not in content and b"from grader" not in content


def test_a_notebook_that_gives_a_solution_away_is_not_written(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(standalone, "find_leaks", lambda *texts: ["answer = 42"])
    call = ["release", "--standalone", LESSON.stage, "--to", str(tmp_path)]
    assert cli.main(call) == 1
    assert "reveals a line of the solution: 'answer = 42'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def run_setup(folder, cell):
    program = f"{cell}\nprint(folder)\nimport utils\nprint(utils.__file__)\n"
    program += "print(hashlib.sha256((folder / 'data' / 'cloud.txt').read_bytes()).hexdigest())"
    return run_python(folder, program)


def run_python(folder, program):
    """Run a program from standard input, because it is too long for a command line."""
    return subprocess.run(
        [sys.executable, "-"], input=program, cwd=folder, capture_output=True, text=True
    )


def test_the_setup_cell_needs_no_other_file_and_makes_the_same_cloud(tmp_path):
    done = run_setup(tmp_path, standalone.setup_cell(LESSON.name))
    assert done.returncode == 0, done.stderr
    message, ready, folder, place, digest = done.stdout.strip().splitlines()
    assert message == "Everything this notebook needs is here." and ready.startswith("Ready: ")
    assert place.startswith(folder)
    assert digest == hashlib.sha256((PROJECT / "data" / "cloud.txt").read_bytes()).hexdigest()
    assert list(tmp_path.iterdir()) == []


def test_the_setup_cell_repairs_a_missing_or_foreign_package(tmp_path):
    """Some systems delete temporary files while a kernel runs, and PyPI has another `utils`."""
    cell = standalone.setup_cell(LESSON.name)
    (tmp_path / "cell.py").write_text(cell, encoding="utf-8")
    (tmp_path / "utils.py").write_text("")
    program = """if True:
        import shutil, sys, utils
        from pathlib import Path
        cell = Path("cell.py").read_text(encoding="utf-8")
        assert not hasattr(utils, "begin")
        exec(cell)
        shutil.rmtree(Path(sys.modules["utils"].__file__).parents[1])
        exec(cell)
        from utils import plots, load_cloud
        print(len(load_cloud()))
    """
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "115451"


def test_a_damaged_setup_cell_is_reported(tmp_path):
    cell = standalone.setup_cell(LESSON.name)
    place = cell.index('packed = "') + 5000
    other = "0" if cell[place] != "0" else "1"
    done = run_setup(tmp_path, cell[:place] + other + cell[place + 1 :])
    assert "This cell is damaged. Download the notebook again." in done.stderr


def test_a_standalone_submission_is_judged_like_any_other(sandbox):
    notebook = json.loads(standalone.make_standalone(LESSON.released.read_bytes()))
    answers = {
        name: next(answer.source for answer in answers_to(name) if answer.right)
        for name in ("filter_ground", "voxel_grid")
    }
    filled = json.loads(fill_in(LESSON, answers))
    solved = {cell["id"]: cell["source"] for cell in filled["cells"]}
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("solution"):
            cell["source"] = solved[cell["id"]]
    submitted_files = SubmittedFiles("my work.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(submitted_files, 1, sandbox)
    assert (verdict.lesson, verdict.score, verdict.problems) == (LESSON.name, 30, ())
    copy = build_copy(prepare(submitted_files, LESSON))
    assert len(graded_cells(copy)) == 4
    assert max(len(cell.source) for cell in copy.cells) < 10_000  # without the packed tools


@pytest.mark.parametrize(
    "hidden",
    [
        lambda setup: f"{standalone.TITLE}\n# (The packed tools of the course.)",
        lambda setup: setup + "\n",
        lambda setup: setup.replace("packed = ", "packed  = "),
        lambda setup: standalone.setup_cell("07_filter_by_distance"),
    ],
)
def test_judged_code_is_always_shown_to_the_instructor(hidden):
    """The instructor's copy omits only an exact copy of the course's tools."""
    setup = standalone.setup_cell(LESSON.name)
    source = hidden(setup) + "\ndef filter_ground(cloud): return 'code that nobody sees'"
    notebook = json.loads(standalone.make_standalone(LESSON.released.read_bytes()))
    cell = {"cell_type": "code", "metadata": {}, "source": source, "outputs": []}
    notebook["cells"].append(cell | {"execution_count": None})
    prepared = prepare(SubmittedFiles("my work.ipynb", json.dumps(notebook).encode()), LESSON)
    assert source in prepared.code and setup in prepared.code
    shown = [cell.source for cell in build_copy(prepared).cells]
    assert source in shown and setup not in shown


def test_functions_of_a_neighbouring_standalone_notebook_load(tmp_path):
    here = tmp_path / "downloads"
    here.mkdir()
    notebook = standalone.make_standalone(LESSON.solved.read_bytes())
    (here / "06_filter_ground.ipynb").write_bytes(notebook)
    program = standalone.setup_cell(LESSON.name) + (
        "\nfrom utils import load_my_functions"
        "\nprint(load_my_functions('06_filter_ground.ipynb').filter_ground.__name__)"
        "\ntry: load_my_functions('07_filter_by_distance.ipynb')"
        "\nexcept FileNotFoundError as error: print(error)"
    )
    done = run_python(here, program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[2] == "filter_ground"
    assert "Upload your 07_filter_by_distance.ipynb next to this notebook" in done.stdout


def test_a_notebook_begins_with_the_lesson(written_folder):
    for path in written_folder.iterdir():
        cells = json.loads(path.read_text())["cells"]
        assert cells[0]["cell_type"] == "markdown"
        (setup,) = [c for c in cells if "".join(c["source"]).startswith(standalone.TITLE)]
        assert setup["metadata"]["jupyter"]["source_hidden"]
        assert setup["metadata"]["cellView"] == "form"
        assert setup["metadata"]["_kg_hide-input"]
        assert not [c for c in cells if "upload the folders" in "".join(c["source"])]


def test_the_error_names_an_unknown_stage(tmp_path, capsys):
    assert cli.main(["release", "--standalone", "stage9", "--to", str(tmp_path)]) == 2
    assert "There is no stage stage9" in capsys.readouterr().err
