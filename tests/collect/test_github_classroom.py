"""Submissions in checkouts of GitHub Classroom, whose names end with a login."""

import json

import pytest

from grader.classroom.collect import CollectError
from tests.archives import EIGHT, SEVEN, SIX, notebook, released_notebook
from tests.collecting import STAGE, collect, questions, states, write_checkout, write_roster


def test_github_checkouts_are_found_by_login(course, tmp_path):
    root = tmp_path / "stage-3-submissions"
    mine = {f"notebooks/{STAGE}/{SIX}.ipynb": notebook(), "README.md": b"hello"}
    given = {f"notebooks/{STAGE}/{SEVEN}.ipynb": released_notebook(SEVEN)}
    write_checkout(
        root, "stage-3-ada-l", mine | given | {".git/objects/06_filter_ground.ipynb": b"x"}
    )
    write_checkout(root, "stage-3-someone", mine)
    outcome = collect(course, root)
    assert outcome.archives[0][1] == "GitHub Classroom"
    assert states(outcome) == {"ada": {"06": "new"}}, "an untouched notebook is not a submission"
    assert "into column github" in questions(outcome)["stage-3-someone"]
    (root / "classroom_roster.csv").write_text(
        '"identifier","github_username","github_id","name"\n"cy@x.edu","Someone","1",""\n'
    )
    assert states(collect(course, root))["cy"] == {"06": "new"}


CLASSROOM_ROSTER = (
    '"identifier","github_username","github_id","name"\n'
    '"cy@x.edu","Someone","1","Müller, Cy"\n"Dee, Dora","","",""\n'
)


@pytest.mark.parametrize(
    "text",
    [
        CLASSROOM_ROSTER.encode(),
        CLASSROOM_ROSTER.replace("\n", "\r").encode(),
        CLASSROOM_ROSTER.replace(",", ";").replace("\n", "\r\n").encode("utf-8-sig"),
        CLASSROOM_ROSTER.replace(",", "\t").encode("utf-16"),
    ],
    ids=["as downloaded", "old line ends", "semicolons", "tabs and UTF-16"],
)
@pytest.mark.parametrize("place", ["hw", "."], ids=["among the checkouts", "next to them"])
def test_the_roster_of_github_classroom_is_read_in_any_form(course, tmp_path, text, place):
    for login in ("ada-l", "someone"):
        write_checkout(tmp_path / "hw", f"hw-3-{login}", {f"{SIX}.ipynb": notebook(text=login)})
    (tmp_path / place / "classroom_roster.csv").write_bytes(text)
    outcome = collect(course, tmp_path / "hw")
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"06": "new"}}
    assert outcome.questions == [] and outcome.ignored == {}  # the roster was needed


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("identifier,github_username\nMüller,x\n".encode("cp1252"), "it is not in UTF-8"),
        (b"name,login\ncy,someone\n", "must have the columns github_username and identifier"),
    ],
)
def test_an_unreadable_roster_of_github_classroom_is_refused(course, tmp_path, text, message):
    write_checkout(tmp_path / "hw", "hw-3-someone", {f"{SIX}.ipynb": notebook()})
    (tmp_path / "hw" / "classroom_roster.csv").write_bytes(text)
    with pytest.raises(CollectError, match=message):
        collect(course, tmp_path / "hw")


def test_a_partly_unreadable_released_notebook_is_collected(course, tmp_path):
    """A merge conflict, or a missing end, may hide the student's work."""
    lines = json.dumps(json.loads(released_notebook()), indent=1).split("\n")
    place = next(n for n, line in enumerate(lines) if '"execution_count"' in line)
    conflict = ["<<<<<<< HEAD", lines[place], "=======", lines[place], ">>>>>>> main"]
    lines[place : place + 1] = conflict
    files = {
        SIX: "\n".join(lines).encode(),
        SEVEN: released_notebook(SEVEN)[:-20],
        EIGHT: released_notebook(EIGHT),
    }
    given = {f"{name}.ipynb": data for name, data in files.items()}
    write_checkout(tmp_path / "hw", "hw-3-ada-l", given)
    write_checkout(tmp_path / "hw", "hw-3-bmu", {f"{SIX}.ipynb": notebook()})
    outcome = collect(course, tmp_path / "hw")
    assert states(outcome) == {"ada": {"06": "new", "07": "new"}, "bjorn": {"06": "new"}}
    conflict, cut_off = (remark.text for remark in outcome.remarks if "damaged" in remark.text)
    assert "A merge conflict was left in" in conflict and "Only these cells were" in cut_off


def test_a_login_is_not_matched_with_the_end_of_another(course, tmp_path):
    write_roster(course, "sam,Sam,Smith,,,smith", "zed,Zed,Zoe,,,zed")
    root = tmp_path / "hw"
    for name in ("hw-3-mary-smith", "hw-3-zed"):
        write_checkout(root, name, {f"{SIX}.ipynb": notebook(text=name)})
    outcome = collect(course, root)
    assert states(outcome) == {"zed": {"06": "new"}}
    assert "into column github" in questions(outcome)["hw-3-mary-smith"]


def test_logins_with_the_same_beginning_are_found(course, tmp_path):
    write_roster(course, "a,,,,,ann-a", "b,,,,,ann-b")
    for name in ("hw-3-ann-a", "hw-3-ann-b"):
        write_checkout(tmp_path / "hw", name, {f"{SIX}.ipynb": notebook(text=name)})
    assert states(collect(course, tmp_path / "hw")) == {"a": {"06": "new"}, "b": {"06": "new"}}


def test_the_question_about_a_single_repository_suggests_a_student(course, tmp_path):
    write_roster(course, "sam,Sam,Smith,,,smith")
    write_checkout(tmp_path / "hw", "hw-3-mary-smith", {f"{SIX}.ipynb": notebook()})
    question = questions(collect(course, tmp_path / "hw"))["hw-3-mary-smith"]
    assert question.count("The student may be sam. Add --who hw-3-mary-smith=sam") == 1
