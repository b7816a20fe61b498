"""The instructor's answers to questions are remembered in the course."""

import pytest

from grader.classroom.submissions import unaccounted_files
from tests.archives import (
    EIGHT,
    SEVEN,
    SIX,
    canvas_files,
    make_zip,
    moodle_files,
    notebook,
    released_notebook,
)
from tests.collecting import (
    MONDAY,
    STAGE,
    TUESDAY,
    archive,
    collect,
    doubts,
    placed_files,
    questions,
    remark_texts,
    states,
    write_checkout,
    write_roster,
)


def test_the_owner_is_asked_for_once_per_stage(course):
    """Later archives of the stage reuse the answer; the command asks again for another stage."""
    team = moodle_files("Team Rot", 77, [(f"{SIX}.ipynb", notebook())])
    first = archive(course, team, "first.zip", when=MONDAY)
    collect(course, first, who={"TEAM ROT_77": "ada,cy"})
    team = moodle_files("Team Rot", 77, [(f"{SIX}.ipynb", notebook(text="again"))])
    outcome = collect(course, archive(course, team, "second.zip", when=TUESDAY))
    assert states(outcome) == {"ada": {"06": "newer"}, "cy": {"06": "newer"}}
    assert outcome.questions == []
    assert remark_texts(outcome)["Team Rot_77"].startswith("assigned to ada, cy")
    outcome = collect(course, first, stages=("stage1_ransac",))
    assert "Team Rot_77" in questions(outcome), "members of a team change from stage to stage"


def test_a_second_answer_replaces_the_first(course):
    path = archive(course, [(f"eve/{SIX}.ipynb", notebook())])
    collect(course, path, who={"eve": "ada,bjorn"})
    assert states(collect(course, path, who={"eve": "cy"})) == {"cy": {"06": "new"}}
    assert states(collect(course, path)) == {"cy": {"06": "same"}}


@pytest.mark.parametrize("inside", ["", "hw/", "a/b/"])
def test_an_archive_of_one_student_may_have_any_folders(course, inside):
    """The option suggested by the message about a student's zip works for folders of any depth."""
    packed = course.submitted / "cy" / STAGE / "my homework.zip"
    packed.parent.mkdir(parents=True)
    names = (SIX, SEVEN)
    packed.write_bytes(make_zip([(f"{inside}{name}.ipynb", notebook(name)) for name in names]))
    ((_, reason),) = unaccounted_files(course)
    assert "--who 'my homework=cy'" in reason
    outcome = collect(course, packed, who={"my homework": "cy"})
    assert states(outcome) == {"cy": {"06": "new", "07": "new"}}
    assert outcome.questions == []


def test_an_answer_for_a_loose_file_does_not_affect_other_students(course):
    """The answer names the whole archive, but only its loose file goes to that student."""
    files = [(f"{SIX}.ipynb", notebook()), (f"ada/{SEVEN}.ipynb", notebook(SEVEN))]
    path = archive(course, files)
    assert set(questions(collect(course, path))) == {"submissions"}
    outcome = collect(course, path, who={"submissions": "cy"})
    assert states(outcome) == {"ada": {"07": "same"}, "cy": {"06": "new"}}


def test_an_option_names_the_owner_of_a_zip_if_there_is_no_roster(course_without_roster):
    path = archive(course_without_roster, [(f"hw/{SIX}.ipynb", notebook())], "homework.zip")
    outcome = collect(course_without_roster, path, who={"homework": "cy"})
    assert states(outcome) == {"cy": {"06": "new"}}


def test_the_decision_to_skip_a_submitter_outside_the_course_is_remembered(course):
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"eve/{SIX}.ipynb", notebook(text="eve"))]
    path = archive(course, files)
    assert "To ignore the files, add --who eve=-" in questions(collect(course, path))["eve"]
    for who in ({"eve": "-"}, {}):
        outcome = collect(course, path, who=who)
        assert outcome.questions == []
        assert set(states(outcome)) == {"ada"}
    assert remark_texts(outcome)["eve"].startswith("ignored")


def test_the_owner_is_asked_for_again_after_the_student_left_the_roster(course):
    """Other members of the student's team keep the team's submission."""
    files = [(f"eve/{SIX}.ipynb", notebook()), (f"team/{SIX}.ipynb", notebook(text="team"))]
    path = archive(course, files)
    collect(course, path, who={"eve": "ada", "team": "bjorn,cy"})
    roster = course.root / "roster.csv"
    roster.write_text(
        "".join(line for line in roster.open() if not line.startswith(("ada", "bjorn")))
    )
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"eve"}
    assert states(outcome) == {"cy": {"06": "same"}}


def test_a_team_is_asked_about_if_another_member_submits(course):
    """Canvas names a team's work after the member who submitted."""
    write_roster(course, "tom,Tom,Turm,,40240,", "tina,Tina,Turm,,40247,", "yan,Yan,Yip,,126,")
    first = canvas_files("Turm, Tom", 40240, [(1, f"{SIX}.ipynb", notebook(text="first"))])
    collect(course, archive(course, first), who={"turmtom_40240": "tom,tina"})
    second = canvas_files("Turm, Tina", 40247, [(2, f"{SIX}.ipynb", notebook(text="second"))])
    other = canvas_files("Yip, Yan", 126, [(3, f"{SIX}.ipynb", notebook(text="yan"))])
    path = archive(course, [*second, *other])
    outcome = collect(course, path)
    texts = doubts(outcome)
    assert set(texts) == {"turmtina_40247"} and outcome.questions == []
    assert placed_files(course, "tina") == {f"{SIX}.ipynb": notebook(text="second")}
    assert placed_files(course, "tom") == {f"{SIX}.ipynb": notebook(text="first")}
    assert "tina and tom are a team" in texts["turmtina_40247"]
    assert "--who turmtina_40247=tina,tom" in texts["turmtina_40247"]
    assert collect(course, path, who={"turmtina_40247": "tina,tom"}).doubts == []
    for student in ("tom", "tina"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": notebook(text="second")}
    third = canvas_files("Turm, Tom", 40240, [(4, f"{SIX}.ipynb", notebook(text="third"))])
    assert collect(course, archive(course, third)).doubts == []
    for student in ("tom", "tina"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": notebook(text="third")}


def test_a_member_who_left_a_team_is_collected_alone_after_an_answer(course):
    write_roster(course, "tom,Tom,Turm,,40240,", "tina,Tina,Turm,,40247,")
    first = canvas_files("Turm, Tom", 40240, [(1, f"{SIX}.ipynb", notebook(text="first"))])
    collect(course, archive(course, first), who={"turmtom_40240": "tom,tina"})
    alone = canvas_files("Turm, Tina", 40247, [(2, f"{SIX}.ipynb", notebook(text="tina"))])
    path = archive(course, [*first, *alone])
    outcome = collect(course, path, who={"turmtina_40247": "tina", "turmtom_40240": "tom"})
    assert outcome.questions == []
    assert placed_files(course, "tom") == {f"{SIX}.ipynb": notebook(text="first")}
    assert placed_files(course, "tina") == {f"{SIX}.ipynb": notebook(text="tina")}


def test_the_decision_to_ignore_a_file_is_remembered(course, run_command, capsys):
    broken = make_zip([("x.txt", b"x" * 999)])[:-40]
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/report.pdf", b"%PDF"),
        ("ada/homework.zip", make_zip([("01_point_clouds.ipynb", notebook("01_point_clouds"))])),
        ("bjorn/photo.png", b"x"),
        ("bjorn/notes.txt", b"x"),
        ("cy/homework.zip", broken),
    ]
    path = archive(course, files)
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "To ignore one of these files from now on, add --who 'FILE=-'." in output
    names = [
        "ada/report.pdf",
        "ada/homework.zip/01_point_clouds.ipynb",
        "bjorn/photo.png",
        "cy/homework.zip",
    ]
    assert set(questions(collect(course, path))) == set(names)
    options = [word for name in names for word in ("--who", f"{name}=-")]
    assert run_command(path, *options) == 0
    assert "waiting" not in capsys.readouterr().out
    assert run_command(path) == 0
    assert states(collect(course, path)) == {"ada": {"06": "same"}, "bjorn": {}, "cy": {}}


def test_later_work_with_the_name_of_an_ignored_file_is_collected(course):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook(EIGHT, "wrong name")), ("cy/h.zip", b"")])
    name = f"ada/{SIX}.ipynb"
    outcome = collect(course, path, who={name: "-", "cy/h.zip": "-"})
    assert outcome.questions == [] and states(outcome) == {"ada": {}, "cy": {}}
    assert collect(course, path).questions == []
    later = [(name, notebook()), ("cy/h.zip", make_zip([(f"{SEVEN}.ipynb", notebook(SEVEN))]))]
    outcome = collect(course, archive(course, later))
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"07": "new"}}


def test_no_question_is_asked_about_an_untouched_repository(course, tmp_path):
    given = {f"notebooks/{STAGE}/{SIX}.ipynb": released_notebook(), "README.md": b"hello"}
    for login in ("ada-l", "bmu"):
        write_checkout(tmp_path / "hw", f"hw-3-{login}", given)
    outcome = collect(course, tmp_path / "hw")
    assert outcome.questions == []
    assert remark_texts(outcome)["hw-3-bmu"] == "contains no notebook that the student changed"


def test_stored_answers_contain_no_names(course):
    """The name of a team's archive may be the name of a student who asks to be deleted."""
    files = [
        ("turmtom_40240/" + f"{SIX}.ipynb", notebook()),
        ("leftlars_40999/" + f"{SIX}.ipynb", notebook()),
        ("bjorn/lars.pdf", b"%PDF"),
    ]
    path = archive(course, files)
    who = {"turmtom_40240": "ada,cy", "leftlars_40999": "-", "bjorn/lars.pdf": "-"}
    assert collect(course, path, who=who).questions == []
    (kept,) = course.submitted.glob(".*")
    text = kept.read_text("utf-8")
    assert "lars" not in text and "turm" not in text
    assert text.count('"student": "ada"') == 1
    assert collect(course, path).questions == []


def test_answers_that_earlier_versions_stored_still_apply(course):
    path = archive(course, [(f"Eve/{SIX}.ipynb", notebook())])
    course.submitted.mkdir()
    line = f'{{"student": "cy", "stage": "{STAGE}", "label": "eve"}}\n'
    (course.submitted / ".whose.jsonl").write_text(line)
    assert states(collect(course, path)) == {"cy": {"06": "new"}}


def test_damaged_stored_answers_do_not_stop_collecting(course):
    path = archive(course, [(f"eve/{SIX}.ipynb", notebook())])
    collect(course, path, who={"eve": "cy"})
    (kept,) = course.submitted.glob(".*")
    kept.write_bytes(b'[]\n{"stage": 1}\n\xff\n' + kept.read_bytes())
    assert set(questions(collect(course, path))) == {"eve"}


def test_the_choice_between_two_copies_is_asked_for_once(course):
    """The question returns only if a third notebook for the lesson arrives."""
    pair = [
        (f"ada/one/{SIX}.ipynb", notebook(text="one"), MONDAY),
        (f"ada/two/{SIX}.ipynb", notebook(text="two"), MONDAY),
        ("bjorn/photo.png", b"x"),
    ]
    path = archive(course, pair)
    assert f"ada/one/{SIX}.ipynb" in questions(collect(course, path))
    collect(course, path, lessons={f"ada/two/{SIX}.ipynb": "06"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="two")}
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"bjorn/photo.png"} and states(outcome)["ada"] == {
        "06": "same"
    }
    third = (f"ada/three/{SIX}.ipynb", notebook(text="three"), MONDAY)
    outcome = collect(course, archive(course, [*pair, third], "more.zip"))
    assert f"ada/three/{SIX}.ipynb" in questions(outcome)[f"ada/two/{SIX}.ipynb"]
    assert states(outcome)["ada"] == {"06": "?"}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="two")}


def test_the_lesson_of_an_unnamed_notebook_is_asked_for_once(course):
    path = archive(course, [("ada/scratch.ipynb", notebook(named=False))])
    collect(course, path, lessons={"ada/scratch.ipynb": "07"})
    outcome = collect(course, path)
    assert outcome.questions == [] and states(outcome) == {"ada": {"07": "same"}}
