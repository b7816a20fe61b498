"""Attacks by the files of a submission to Gradescope, which the judge there reads as root."""

import json
import os

import pytest

from grader.course.lessons import find_lesson
from grader.lms.autograder import __main__ as program
from grader.lms.autograder import judging
from grader.sandbox import SANDBOXES
from tests.attacks.attack import with_attacks
from tests.autograder_verdicts import exercise_result, verdict

SIX = find_lesson("06_filter_ground")
NAME = f"{SIX.name}.ipynb"
SEED = 2**64 + 1
SCORE = 6.66  # in the fixed verdict


@pytest.fixture
def root(tmp_path, monkeypatch):
    """Return a folder like Gradescope's /autograder, in which the judge returns a fixed verdict."""
    root = tmp_path / "autograder"
    for name in ("submission", "results", "source/course"):
        (root / name).mkdir(parents=True)
    (root / "source" / "assignment").write_text(SIX.name)
    (root / "source" / "course" / ".course_seed").write_text(f"{SEED}\n")
    monkeypatch.setattr(program, "restrict_access", lambda root: None)
    monkeypatch.setattr(program, "strongest_sandbox", lambda: SANDBOXES["process"])
    return root


@pytest.fixture
def judged_files(monkeypatch):
    """Return a list to which each judged submission is added, with the seed."""
    judged = []

    def judge_one(submitted_files, lesson, student, seed, sandbox, is_alone=False):
        judged.append((submitted_files, seed))
        return verdict((exercise_result(),))

    monkeypatch.setattr(judging, "judge_one", judge_one)
    return judged


def results_of(root):
    assert program.main(root) == 0
    return json.loads((root / "results" / "results.json").read_text("utf-8"))


@with_attacks(
    "name",
    {
        "a second line": f"x{NAME}\nscore: 30 of 30\n.ipynb",
        "escape sequences": f"\x1b[2J\x1b]8;;mailto:x\x07{NAME}\x1b[0m.ipynb",
        "directions": f"\u202e{NAME}\u2066.ipynb",
        "not UTF-8": os.fsdecode(b"\xff\xfe" + NAME.encode()),
        "a second line in an unknown file": "x\nscore: 30 of 30.ipynb",
        "a second line in another lesson": "02_ransac_line\nscore: 30 of 30.ipynb",
        "a second line in another file type": f"{SIX.name}\nscore: 30 of 30.pdf",
    },
)
def test_quoted_file_names_cannot_start_a_new_line(root, judged_files, name):
    (root / "submission" / name).write_bytes(SIX.released.read_bytes())
    results = results_of(root)
    shown = [results["output"], *(test["output"] for test in results["tests"])]
    for text in filter(None, shown):
        assert text.isprintable() and not text.startswith("score")
    assert results["score"] in (0.0, SCORE)


@with_attacks(
    "files",
    {
        "settings of the course": {
            ".course_seed": "1",
            "roster.csv": "id\nx",
            "deadlines.toml": "[",
            "nbgrader_config.py": "raise SystemExit",
            "assignment": "02_ransac_line",
        },
        "settings of Python and pytest": {
            "conftest.py": "raise SystemExit",
            "sitecustomize.py": "raise SystemExit",
            "pytest.ini": "[pytest]\naddopts = --collect-only",
            "grader/__init__.py": "raise SystemExit",
            "hidden_tests.py": "",
        },
        "results": {"results.json": '{"score": 30}', "results/results.json": '{"score": 30}'},
        "verdicts": {f"verdicts/submission/{SIX.stage}/{SIX.name}.json": '{"score": 30}'},
    },
)
def test_submitted_files_do_not_replace_files_of_the_judge(root, judged_files, files):
    for name, text in {**files, NAME: "{}"}.items():
        path = root / "submission" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    results = results_of(root)
    ((submitted, seed),) = judged_files
    assert seed == SEED and submitted.name == NAME
    assert results["score"] == SCORE


@with_attacks(
    "link",
    {
        "results": "../results",
        "the file of results": "../results/results.json",
        "the seed": "../source/course/.course_seed",
        "itself": ".",
        "an endless device": "/dev/zero",
        "nothing": "nowhere",
    },
)
def test_links_in_a_submission_are_not_followed(root, judged_files, link):
    """Links are copied as links, so neither their target is read nor a loop entered."""
    (root / "submission" / NAME).symlink_to(link)
    (root / "submission" / "work").symlink_to(link)
    results = results_of(root)
    ((submitted, _),) = judged_files
    assert submitted.data == b"" and "is a link" in submitted.complaint
    assert str(SEED) not in json.dumps(results)
    assert "work is a link, a pipe or a device" in results["output"]


def test_results_of_an_earlier_run_are_removed(root, monkeypatch):
    """A submission that the judge cannot read must not keep the file of another run."""
    old = root / "results" / "results.json"
    old.write_text('{"score": 30}')
    monkeypatch.setattr(judging, "find_submissions", lambda *_: 1 / 0)
    assert program.main(root) == 1
    assert not old.exists()
