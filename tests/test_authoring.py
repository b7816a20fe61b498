"""Writing a lesson: the skeleton, and `grader try` with the kept answers."""

import contextlib
import dataclasses
import os
import shutil
import subprocess
import sys

import pytest

from grader import cli
from grader.authoring import skeleton
from grader.authoring.trial import note_mismatches
from grader.course.kept_answers import KeptAnswer
from grader.course.lessons import every_lesson
from grader.course.paths import PROJECT
from grader.judging.verdict import JUDGED, CheckResult, ExerciseResult, Verdict

# ---- notes of kept answers -----------------------------------------------------------------------

RIGHT = KeptAnswer("f", "a loop", True, "", (), "", False, "")
WRONG = KeptAnswer("f", "a slip", False, "", ("sorts", "test_a"), "rows too many", True, "")


def verdict_on(*failed, cause="", score=0.0):
    """Return a verdict with four checks; those in `failed` have the message "2 rows too many"."""
    tests = tuple(
        CheckResult(
            name, name, name not in failed, 0, 1, "2 rows too many" * (name in failed), True
        )
        for name in ("sorts", "keeps", "test_a[1]", "test_b")
    )
    results = (ExerciseResult("f", score, 4.0, tests, cause),)
    return Verdict("01", "ada", JUDGED, score, 4.0, results, (), 0.0, "")


def test_correct_notes_are_not_reported():
    assert note_mismatches(RIGHT, verdict_on(score=4.0)) == []
    assert note_mismatches(WRONG, verdict_on("sorts", "test_a[1]")) == []


@pytest.mark.parametrize(
    ("answer", "verdict", "message"),
    [
        (RIGHT, verdict_on("keeps"), "It fails keeps."),
        (WRONG, verdict_on("sorts"), "It fails sorts, but its notes list sorts, test_a."),
        (
            dataclasses.replace(WRONG, loses=("sorts", "test_a", "test_c")),
            verdict_on("sorts", "test_a[1]"),
            "There is no check test_c. The checks are: sorts, keeps, test_a[1], test_b.",
        ),
        (
            WRONG,
            verdict_on("sorts", "test_a[1]", "keeps"),
            "It fails sorts, keeps, test_a[1], but its notes list sorts, test_a.",
        ),
        (
            dataclasses.replace(WRONG, loses=("sort", "test_a")),
            verdict_on("sorts", "test_a[1]"),
            "There is no check sort. The checks are:",
        ),
        (WRONG, verdict_on("sorts", "test_a[1]", score=4.0), "It is wrong, but earns all points."),
        (
            dataclasses.replace(WRONG, says="Bananas"),
            verdict_on("sorts", "test_a[1]"),
            "No message contains 'Bananas'. The messages are: \n2 rows too many",
        ),
        (
            dataclasses.replace(WRONG, told="rounded"),
            verdict_on("sorts", "test_a[1]"),
            "The student should see the mistake 'rounded', but sees none.",
        ),
        (dataclasses.replace(WRONG, loses=(), loses_only=False), verdict_on("sorts"), "Add a line"),
    ],
)
def test_a_wrong_note_is_reported_in_a_sentence(answer, verdict, message):
    (sentence,) = note_mismatches(answer, verdict)
    assert message in sentence


# ---- the skeleton --------------------------------------------------------------------------------

FREE_NUMBER = 1 + max(int(lesson.number) for lesson in every_lesson())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["other"], "'other' is not a valid lesson name."),
        (["94_Free"], "'94_Free' is not a valid lesson name."),
        (["94_lambda"], "lambda is a keyword of Python"),
        (
            ["06_other"],
            f"06_filter_ground already has the number 06. Use {FREE_NUMBER}, which is free.",
        ),
        (["94_voxel_grid"], "06_filter_ground already has an exercise voxel_grid."),
        (["94_root_of"], "13_compiled_loops already has an exercise root_of."),
        (
            ["94_other", "--stage", "mine"],
            "'mine' is not a valid stage name.",
        ),
    ],
)
def test_an_invalid_new_lesson_gets_a_message(arguments, message, capsys):
    assert cli.main(["new", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_new_lesson_does_not_overwrite_files(tmp_path, monkeypatch):
    monkeypatch.setattr(skeleton, "PROJECT", tmp_path)
    assert len(skeleton.write_skeleton("94_mine")) == 4
    shutil.rmtree(tmp_path / "solutions")
    with pytest.raises(skeleton.UnusableName, match="lesson_94.py already exists"):
        skeleton.write_skeleton("94_mine")
    assert not (tmp_path / "solutions").exists()


@pytest.mark.parametrize("wanted", ["77", "77_mine"])
def test_trying_a_missing_lesson_gets_a_message(wanted, capsys):
    assert cli.main(["try", wanted]) == 2
    assert "python -m grader new 77_NAME" in capsys.readouterr().err


@pytest.fixture(scope="module")
def project_copy(tmp_path_factory):
    """Return a copy of the project in which lessons can be written."""
    root = tmp_path_factory.mktemp("project") / "lab"
    for folder in ("extension", "grader", "utils", "solutions", "notebooks", "data"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PROJECT / folder, root / folder, ignore=ignored)
    shutil.copy(PROJECT / "pyproject.toml", root)
    return root


def run(root, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "grader", *arguments],
        cwd=root,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
    )


@pytest.mark.slow
def test_the_skeleton_of_a_new_lesson_is_complete(project_copy, sandbox):
    written = run(project_copy, "new", "94_free_distance")
    assert written.returncode == 0 and "python -m grader try 94" in written.stdout
    tried = run(project_copy, "try", "94", "--sandbox", sandbox.name)
    assert tried.returncode == 0, tried.stdout + tried.stderr
    assert "94_free_distance is complete." in tried.stdout and "!!" not in tried.stdout
    assert run(project_copy, "build", "--check").returncode == 0


@pytest.mark.proof
def test_missing_parts_of_a_new_lesson_are_reported(project_copy, sandbox):
    run(project_copy, "new", "96_far_distance")
    folder = project_copy / "solutions" / "stage5_own" / "96_far_distance"
    with replace_temporarily(folder / "hidden_tests.py", "", ""):
        tried = run(project_copy, "try", "96", "--sandbox", sandbox.name)
    assert tried.returncode == 1
    assert "far_distance has no hidden test. Write one in 96_far_distance/hidden" in tried.stdout
    assert "The lesson cannot be judged: " in tried.stdout and "2 still to fix." in tried.stdout

    changed = ("# %% right: a loop", "# %% wrong: it"), ("np.linalg", "npp.linalg")
    answers, hidden = folder / "answers" / "far_distance.txt", folder / "hidden_tests.py"
    with replace_temporarily(answers, *changed[0]), replace_temporarily(hidden, *changed[1]):
        tried = run(project_copy, "try", "96", "--sandbox", sandbox.name)
    assert tried.returncode == 1
    assert "far_distance has no right answer. Write one in" in tried.stdout
    assert "96_far_distance/hidden_tests.py, line 21: NameError: name 'npp'" in tried.stdout

    hidden.rename(folder / "away")
    tried = run(project_copy, "try", "96", "--sandbox", sandbox.name)
    (folder / "away").rename(hidden)
    assert "96_far_distance/hidden_tests.py does not exist" in tried.stdout


@pytest.mark.slow
def test_each_fault_of_the_checks_is_reported_once(project_copy, sandbox):
    run(project_copy, "new", "95_mean_square")
    checks = project_copy / "utils" / "checks" / "lesson_95.py"
    with replace_temporarily(checks, "7.505553499465135", "7.6"):
        tried = run(project_copy, "try", "95", "--sandbox", sandbox.name)
    assert (
        "The solution earns " in tried.stdout and "95_mean_square: 1 still to fix." in tried.stdout
    )
    assert (
        "mean_square, “Computes the root mean square of three numbers”: The number is wrong."
        in tried.stdout
    )
    assert "Hint: Square the numbers, take the mean" in tried.stdout

    for old, new, line, reason in (
        ('promise("names")', 'promise("name")', 32, "no promise 'name'. Use one of names,"),
        ("weight=4,", "weight=4", 10, "SyntaxError: "),
    ):
        with replace_temporarily(checks, old, new):
            tried = run(project_copy, "try", "95", "--sandbox", sandbox.name)
        assert f"utils/checks/lesson_95.py, line {line}: " in tried.stdout
        assert reason in tried.stdout and "95_mean_square: 1 still to fix." in tried.stdout


@pytest.mark.proof
def test_a_failing_cell_of_the_notebook_is_reported(project_copy, sandbox):
    run(project_copy, "new", "97_root_square")
    source = project_copy / "solutions" / "stage5_own" / "97_root_square" / "lesson.py"
    cell = "# Look.\n\n# %%\nprint(1 + root_square([3, 4]))\n\n# %% [markdown]\n# ## Summary"
    with replace_temporarily(source, "# ## Summary", cell.replace("print(1", "draw(1")):
        tried = run(project_copy, "try", "97", "--sandbox", sandbox.name)
    assert "cell that begins with `draw(1 + root_square([3, 4]))` raises NameE" in tried.stdout

    # `try` stores the solution's answers, so that the untouched notebook can continue.
    with replace_temporarily(source, "# ## Summary", cell):
        tried = run(project_copy, "try", "97", "--sandbox", sandbox.name)
    assert tried.returncode == 0, tried.stdout
    assert "were stored in utils/lent/lesson_97.json." in tried.stdout


@contextlib.contextmanager
def replace_temporarily(path, old, new):
    """Replace `old` in a file temporarily, or the whole content if `old` is empty."""
    before = path.read_text("utf-8")
    assert old in before
    path.write_text(before.replace(old, new) if old else new, "utf-8")
    yield
    path.write_text(before, "utf-8")
