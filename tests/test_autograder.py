"""The autograder for Gradescope: its zip, isolation, judging and results."""

import dataclasses
import io
import json
import os
import stat
import zipfile
from pathlib import Path

import pytest

from grader import cli, commands
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.judging.judge import judge
from grader.judging.verdict import FAILED, ExerciseResult, Slip
from grader.lms.autograder import __main__ as program
from grader.lms.autograder import isolation, judging, results
from grader.lms.autograder.judging import JudgedLesson, JudgedSubmission
from grader.lms.autograder.package import build_autograder_zip
from grader.sandbox import SANDBOXES, SandboxUnavailable
from tests.autograder_verdicts import SEED, SIX, STAGE, exercise_result, verdict
from tests.prerequisites import ROOT

# Values and keys of gradescope-autograders.readthedocs.io/en/latest/specs/.
VISIBILITIES = {"hidden", "after_due_date", "after_published", "visible"}
TEST_KEYS = {
    *("score", "max_score", "status", "name", "name_format", "number", "output", "output_format"),
    *("tags", "visibility", "extra_data"),
}
RESULT_KEYS = {
    *("score", "execution_time", "output", "output_format", "test_output_format"),
    *("test_name_format", "visibility", "stdout_visibility", "extra_data", "tests", "leaderboard"),
}


def results_for(*lessons, leftovers=()):
    return results.build_results(JudgedSubmission(lessons, tuple(leftovers)))


# ---- Results -------------------------------------------------------------------------------


def test_results_have_gradescopes_format_and_add_up():
    found = results_for(
        JudgedLesson(
            SIX, verdict((exercise_result(),), problems=("A cell moved.",)), ("A cell moved.",)
        ),
        JudgedLesson(find_lesson("07_filter_by_distance")),
        leftovers=["x.ipynb: what is this?"],
    )
    assert set(found) <= RESULT_KEYS and json.loads(json.dumps(found)) == found
    assert found["score"] == 6.66 == round(sum(t.get("score", 0) for t in found["tests"]), 2)
    assert found["output"] == "x.ipynb: what is this?"
    for test in found["tests"]:
        assert set(test) <= TEST_KEYS and test["visibility"] in VISIBILITIES
    assert found["output_format"] == found["test_output_format"] == "text"
    # The results exclude exercises that a person grades.
    scored = [test["max_score"] for test in found["tests"] if "max_score" in test]
    assert sum(scored) == 20.0 + 30.0


def test_hidden_tests_are_shown_after_the_due_date():
    slip = Slip(3, 2, "a > b", "a >= b", 5.34)
    lesson = JudgedLesson(
        SIX,
        verdict((exercise_result(slip),), problems=("A cell moved.", "By a helper.")),
        ("A cell moved.",),
    )
    tests = results_for(lesson)["tests"]
    visibilities = {(test["name"], test["output"]): test["visibility"] for test in tests}
    assert visibilities == {
        ("About 06_filter_ground", "A cell moved."): "visible",
        ("About 06_filter_ground", "By a helper."): "after_published",
        ("filter_ground: A road is ground", "Yours: 1 <b>"): "visible",
        ("filter_ground: A hidden road", "A wall is not a road."): "after_published",
        ("filter_ground: Nothing changes", ""): "after_published",
        ("filter_ground: one slip", slip.sentence): "after_published",
    }
    assert "a >= b" not in json.dumps(tests)


def test_results_of_a_lesson_that_cannot_be_judged_begin_with_the_reason():
    nothing = (ExerciseResult("filter_ground", 0.0, 20.0, ()),)
    why = "06_filter_ground.ipynb breaks off."
    tests = results_for(JudgedLesson(SIX, verdict(nothing, problems=(why,)), (why,)))["tests"]
    assert [test["output"] for test in tests][0] == why
    assert [test.get("score") for test in tests] == [None, 0.0]
    assert {test["visibility"] for test in tests} == {"visible"}


def test_points_that_do_not_add_up_raise_an_error():
    wrong = verdict((exercise_result(),))
    wrong = dataclasses.replace(wrong, score=7.0)
    with pytest.raises(ArithmeticError):
        results_for(JudgedLesson(SIX, wrong))


# ---- Judging -------------------------------------------------------------------------------


@pytest.fixture
def root(tmp_path):
    """Return a folder like Gradescope's /autograder, for one stage of this course."""
    root = tmp_path / "autograder"
    for name in ("submission", "results", "source/course"):
        (root / name).mkdir(parents=True)
    (root / "source" / "assignment").write_text(STAGE)
    (root / "source" / "course" / ".course_seed").write_text(f"{SEED}\n")
    return root


@pytest.fixture
def judged_calls(monkeypatch):
    """Replace the judge with a fixed verdict; return a list to which each call is added."""
    asked = []

    def judge_one(submitted_files, lesson, student, seed, sandbox, is_alone=False):
        asked.append((submitted_files.name, lesson, student, seed, submitted_files.complaint))
        return verdict((exercise_result(),))

    monkeypatch.setattr(judging, "judge_one", judge_one)
    return asked


def judge_root(root):
    return judging.judge_submission(root / "submission", root / "source", SANDBOXES["process"])


def test_a_notebook_is_found_in_any_folder_of_the_submission(root, judged_calls):
    below = root / "submission" / "my work" / "06_filter_ground (1).ipynb"
    below.parent.mkdir()
    below.write_bytes(SIX.released.read_bytes())
    found = judge_root(root)
    assert judged_calls == [(below.name, SIX.name, "", SEED, "")]
    assert [lesson.lesson.name[:2] for lesson in found.lessons if lesson.verdict] == ["06"]
    assert [lesson.lesson.name[:2] for lesson in found.lessons] == ["06", "07", "08", "09"]
    assert "was recognised as 06_filter_ground.ipynb" in str(found.lessons[0].notes)


def test_each_file_that_is_not_judged_is_listed(root, judged_calls):
    folder = root / "submission"
    for name in ("Untitled.ipynb", "07_filter_by_distance.py", "02_ransac_line.ipynb", "notes.txt"):
        (folder / name).write_text("{}")
    os.mkfifo(folder / "pipe.ipynb")
    (folder / "work").symlink_to(".")
    (folder / ".hidden").symlink_to(".")
    assert judge_root(root).unjudged_notes == (
        "pipe.ipynb is a link, a pipe or a device, so the judge did not open it. Submit the file "
        "itself.",
        "work is a link, a pipe or a device, so the judge did not open it. Submit the file itself.",
        "02_ransac_line.ipynb is lesson 02_ransac_line, which is not part of this assignment.",
        "07_filter_by_distance.py is not a notebook. Submit 07_filter_by_distance.ipynb, as "
        "Jupyter saves it.",
        "Untitled.ipynb cannot be matched with a lesson. Give the file the name under which it was "
        "released, such as 06_filter_ground.ipynb.",
    )
    assert not judged_calls


@pytest.mark.parametrize("target", ["the file", "its folder"])
def test_a_link_to_the_solution_is_not_an_answer(root, judged_calls, target):
    """The autograder runs as root, but reads only the submission and does not follow links."""
    if target == "the file":
        (root / "submission" / f"{SIX.name}.ipynb").symlink_to(SIX.solved)
    else:
        (root / "submission" / "work").symlink_to(SIX.solved.parent)
    judge_root(root)
    assert all("link" in complaint for *_, complaint in judged_calls)
    assert len(judged_calls) == (target == "the file")


def test_an_assignment_may_consist_of_one_lesson(root, judged_calls):
    (root / "source" / "assignment").write_text(f"{SIX.name}\n")
    assert [lesson.lesson for lesson in judge_root(root).lessons] == [SIX]


def test_a_starved_notebook_is_judged_again(root, monkeypatch):
    (root / "submission" / f"{SIX.name}.ipynb").write_bytes(SIX.released.read_bytes())
    tries = []

    def judge_one(*about, is_alone=False):
        tries.append(is_alone)
        return dataclasses.replace(verdict((exercise_result(),)), starved=not is_alone)

    monkeypatch.setattr(judging, "judge_one", judge_one)
    assert not judge_root(root).lessons[0].verdict.starved
    assert tries == [False, True]


# ---- Faults --------------------------------------------------------------------------------


@pytest.fixture
def without_sandbox(monkeypatch):
    """Replace the parts that need root or a sandbox, which the tests below do not need."""
    monkeypatch.setattr(program, "restrict_access", lambda root: None)
    monkeypatch.setattr(program, "strongest_sandbox", lambda: SANDBOXES["process"])


def test_a_fault_of_the_grader_leaves_no_results(root, without_sandbox, monkeypatch, capsys):
    (root / "submission" / f"{SIX.name}.ipynb").write_bytes(SIX.released.read_bytes())
    path = root / "results" / "results.json"
    for fault in (verdict(status=FAILED, faults=("an oracle broke",)), OSError("no memory left")):
        path.write_text('{"score": 100}')  # an earlier file, which may be forged

        def judge_one(*about, result=fault, **more):
            if isinstance(result, Exception):
                raise result
            return result

        monkeypatch.setattr(judging, "judge_one", judge_one)
        assert program.main(root) == 1
        assert not path.exists()
        output = capsys.readouterr().out
        assert output.count("no student gets a mark from this run") == 1
        assert ("an oracle broke" in output) != ("no memory left" in output)


def test_nothing_runs_without_a_sandbox(root, monkeypatch, capsys):
    def unavailable(self):
        raise SandboxUnavailable("It is a drill.", "Add: --sandbox process")

    monkeypatch.setattr(program, "restrict_access", lambda root: None)
    for name in isolation.PREFERRED_SANDBOXES:
        monkeypatch.setattr(type(SANDBOXES[name]), "check_available", unavailable)
    assert program.main(root) == 1
    output = capsys.readouterr().out
    assert "bubblewrap: It is a drill.\nchroot: It is a drill.\n" in output
    assert "export --format gradescope" in output and "--sandbox process" not in output
    assert not (root / "results" / "results.json").exists()


def test_a_sandbox_without_protection_is_never_chosen():
    assert (
        set(isolation.PREFERRED_SANDBOXES) < set(SANDBOXES)
        and "process" not in isolation.PREFERRED_SANDBOXES
    )


needs_root = pytest.mark.skipif(os.geteuid() != 0, reason=ROOT)


@needs_root
def test_other_users_cannot_read_tests_and_seed(root):
    (root / "submission_metadata.json").write_text("{}")
    (root / "results").chmod(0o777)
    (root / "source").chmod(0o755)
    os.chown(root / "results", 31_415, 31_415)
    isolation.restrict_access(root)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in root.iterdir()}
    assert modes["source"] == modes["submission"] == 0o700
    assert modes["submission_metadata.json"] & 0o077 == 0
    assert modes["results"] == 0o755 and (root / "results").stat().st_uid == 0


@needs_root
def test_a_folder_that_cannot_be_restricted_is_refused(root, tmp_path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (root / "submission").rmdir()
    (root / "submission").symlink_to(elsewhere)
    with pytest.raises(isolation.IsolationFailed, match="submission"):
        isolation.restrict_access(root)


def test_an_ordinary_user_is_refused(root, monkeypatch):
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(isolation.IsolationFailed, match="must run as root"):
        isolation.restrict_access(root)


@needs_root
@pytest.mark.slow
@pytest.mark.parametrize("right", [True, False])
def test_the_score_is_the_same_as_on_the_command_line(root, sandbox, right, capsys):
    answer = next(answer for answer in answers_to("filter_ground") if answer.right == right)
    voxels = next(answer for answer in answers_to("voxel_grid") if answer.right)
    path = root / "submission" / f"{SIX.name}.ipynb"
    path.write_text(
        fill_in(SIX, {"filter_ground": answer.source, "voxel_grid": voxels.source}), "utf-8"
    )
    assert program.main(root) == 0
    found = json.loads((root / "results" / "results.json").read_text())
    at_home = judge(path, SEED, sandbox)
    assert found["score"] == at_home.score and (found["score"] == 30.0) == right
    scores = {test["name"]: test["score"] for test in found["tests"] if "score" in test}
    for exercise in at_home.exercises:
        for check in exercise.tests:
            assert scores[f"{exercise.name}: {check.title}"] == check.score
    assert "Sandbox: " in capsys.readouterr().out


# ---- The zip -------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def packed_zip():
    return build_autograder_zip(STAGE, SEED)


@pytest.mark.slow
def test_the_same_course_gives_the_same_zip(packed_zip):
    assert packed_zip == build_autograder_zip(STAGE, SEED) != build_autograder_zip(STAGE, SEED + 1)


def test_the_zip_contains_files_for_judging_but_no_data_about_the_class(packed_zip):
    archive = zipfile.ZipFile(io.BytesIO(packed_zip))
    names = set(archive.namelist())
    assert {
        "setup.sh",
        "run_autograder",
        "course/solutions/stage3_obstacles/06_filter_ground/hidden_tests.py",
    } <= names
    for name in ("setup.sh", "run_autograder"):
        assert archive.getinfo(name).external_attr >> 16 & stat.S_IXUSR
        assert archive.read(name).startswith(b"#!/bin/sh\n") and b"\r" not in archive.read(name)
    assert archive.read("course/.course_seed") == f"{SEED}\n".encode()
    assert archive.read("assignment") == f"{STAGE}\n".encode()
    class_files = ("roster", "deadlines", "gradebook", "submitted", "verdicts", "marks.jsonl")
    assert not [n for n in names if n.split("/")[1:2] and n.split("/")[1].startswith(class_files)]


def test_requirements_include_packages_for_judging_but_not_jupyter(packed_zip):
    archive = zipfile.ZipFile(io.BytesIO(packed_zip))
    listed = archive.read("requirements.txt").decode()
    assert listed.startswith("-c constraints.txt\n")
    for name in ("numpy", "scipy", "shapely", "scikit-learn", "pytest", "pyyaml", "ipython"):
        assert f"\n{name}==" in listed
    assert "jupyterlab" not in listed and "nbgrader" not in listed


@pytest.fixture
def without_rehearsals(monkeypatch):
    """Skip the rehearsals, because other tests show that the course's solutions are right."""
    from grader.classroom import rehearsals

    monkeypatch.setattr(rehearsals.Rehearsals, "finish", lambda self, executor: None)


def test_the_command_writes_a_zip_that_only_its_owner_can_read(
    tmp_path, without_rehearsals, capsys
):
    path = tmp_path / "auto.zip"
    assert cli.main(["autograder", "stage4_realtime", "--to", str(path)]) == commands.SUCCESS
    assert zipfile.is_zipfile(path) and stat.S_IMODE(path.stat().st_mode) == 0o600
    output = capsys.readouterr().out
    assert "Autograder Points: 85" in output and "write_up (10 points)" in output
    assert "this is Python 3.12. Code that needs a newer Python gets no mark." in output


def test_the_command_lists_lessons_and_exercises_that_do_not_count(
    tmp_path, without_rehearsals, monkeypatch, capsys
):
    text = '[stage3_obstacles]\nlessons = ["06", "07", "08"]\nwithout = ["voxel_grid"]\n'
    (tmp_path / "deadlines.toml").write_text(text, "utf-8")
    monkeypatch.setattr(commands, "Course", lambda: Course(tmp_path))
    call = ["autograder", "stage3_obstacles", "--to", str(tmp_path / "auto.zip")]
    assert cli.main(call) == commands.SUCCESS
    sentence = "do not count according to deadlines.toml: 09_filter_clusters, voxel_grid."
    assert sentence in capsys.readouterr().out


def test_the_error_about_an_unknown_assignment_lists_the_known_ones(capsys, tmp_path):
    path = tmp_path / "auto.zip"
    assert cli.main(["autograder", "stage9", "--to", str(path)]) == commands.USAGE_ERROR
    assert "stage3_obstacles" in capsys.readouterr().err and not path.exists()


def test_no_autograder_is_written_if_a_rehearsal_fails(tmp_path, monkeypatch, capsys):
    from grader.classroom import rehearsals

    def finish(self, executor):
        raise rehearsals.RehearsalFailed("No student was graded: a test is wrong.")

    monkeypatch.setattr(rehearsals.Rehearsals, "finish", finish)
    path = Path(tmp_path / "auto.zip")
    assert cli.main(["autograder", SIX.name, "--to", str(path)]) == commands.FAULT
    assert "a test is wrong" in capsys.readouterr().err and not path.exists()
