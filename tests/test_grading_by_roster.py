"""What the instructor is shown goes by the roster: table, doctor, and one student again."""

from datetime import timedelta
from pathlib import Path

import pytest

from grader import cli, commands
from grader.classroom import doctor
from grader.classroom import grade as grading
from grader.classroom.folders import UnknownStudent, find_student
from grader.classroom.submissions import Submission, find_submissions
from grader.console import print_class, progress_bar
from grader.course import paths
from grader.course.lessons import find_lesson
from grader.course.roster import Person
from grader.judging.verdict import JUDGED, Verdict, write_verdict
from grader.lms import gradebook
from grader.lms.gradebook_check import check_gradebook
from grader.lms.history import read_changes
from grader.lms.results import MARKED, ClassResults, NotebookResult, StageResult
from grader.lms.standings import class_results
from grader.sandbox import SANDBOXES
from tests.test_faults import Inline
from tests.test_gradebook import EARNED, GROUND, LATE, STAGE, hand_in, make_course, verdicts

ROSTER = (
    "id,first_name,last_name,section\nada,Ada,Ash,A\nbob,Bob,Bell,B\nidle,Ida,Ling,B\n"
    "eve,Eve,Elm,\nyan,Yan,Yip,\n"
)
DATES = (
    f'timezone = "UTC"\n[{STAGE}]\ndue = 2026-03-01T12:00:00\n[{STAGE}.students]\n'
    'eve = "excused"\nidle = 2026-03-02T12:00:00\n'
)
UNWALLED = SANDBOXES["process"]


@pytest.fixture
def course(tmp_path, monkeypatch):
    """Ada and Bob handed in, and a ghost; what is judged of them is said here."""
    made = make_course(tmp_path / "course")
    (made.root / "roster.csv").write_text(ROSTER)
    (made.root / "deadlines.toml").write_text(DATES)
    (made.root / "nbgrader_config.py").write_text(LATE)
    for student in EARNED:
        when = made.submitted / student / STAGE / "timestamp.txt"
        when.write_text("2026-03-02 15:00:00 UTC")
    hand_in(made, "ghost", GROUND)
    earned = EARNED | {"ghost": {GROUND: (1.0, 2.0)}}

    def judge_class(course, stages, seed, sandbox, executor, workers, progress, student=None):
        progress(0, 1, None)
        found = verdicts(course, earned)
        for one, verdict in found:
            write_verdict(verdict, one.verdict_path(course))
        return [(one, verdict) for one, verdict in found if student in (None, one.student)]

    monkeypatch.setattr(grading, "judge_class", judge_class)
    monkeypatch.setattr(cli.commands, "Course", lambda: made)
    paths._folder.cache_clear()
    return made


def grade(course, student=None):
    return commands.grade_course(course, (), 2**64, UNWALLED, 1, student=student)


def cells(shown, student):
    """A line of the table."""
    (line,) = [line.split() for line in shown.splitlines() if line.split()[:1] == [student]]
    return line


@pytest.mark.end_to_end
def test_the_table_has_everybody_on_the_roster_and_tells_four_things_apart(course, capsys):
    assert grade(course) == commands.FAULT
    said = capsys.readouterr()
    assert "'ghost' is not on the roster, so that its marks are not entered." in said.err
    # 27 hours late: of 30 points and of 20.75 a tenth for each of two days.
    assert cells(said.out, "ada")[1:] == ["11.8", "18.2", "1.1", "d", "-6"]
    assert cells(said.out, "bob")[1:] == ["-", "20.8", "1.1", "d", "-4.15"]
    assert cells(said.out, "idle")[1:] == ["-", "-"]
    assert cells(said.out, "eve")[1:] == ["ex", "ex"]
    assert cells(said.out, "ghost")[1:3] == ["3", "-"]
    assert "not on the roster, so not entered" in said.out
    assert "- handed in nothing · ex excused" in said.out and "a person has" not in said.out
    page = (course.report / "index.html").read_text("utf-8")
    on_it = len((course.root / "roster.csv").read_text("utf-8").splitlines()) - 1
    assert f"{on_it} students and 1 who is not on the roster, " in page


def test_a_zero_and_what_waits_are_no_dash(course, capsys, monkeypatch):
    grade(course)
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_submission_notebook(GROUND.name, STAGE, "ada")
        for grade_ in notebook.grades:
            grade_.manual_score = 0.0
        notebook.grades[0].needs_manual_grade = True
        book.db.commit()
    hand_in(course, "yan", GROUND)  # and was not judged
    capsys.readouterr()
    commands._print_all(course, verdicts(course), class_results(course), [])
    shown = capsys.readouterr().out
    assert cells(shown, "ada")[1] == "0*" and cells(shown, "yan")[1:3] == ["?", "-"]
    assert "* a person has still to grade · ? not entered yet" in shown


def test_where_there_are_several_stages_each_lateness_names_its_own(capsys):
    late = {"stage1_ransac": timedelta(hours=30), "stage3_obstacles": timedelta(hours=5)}
    stages = [
        StageResult("ada", stage, MARKED, 10.0, 10.0, 2.0, late=how) for stage, how in late.items()
    ]
    marks = [
        NotebookResult("ada", lesson.stage, lesson.name, MARKED, 10.0, 10.0)
        for lesson in map(find_lesson, ("01_point_clouds", "06_filter_ground"))
    ]
    results = ClassResults((Person("ada"),), tuple(marks), tuple(stages))
    judged = [
        (Submission("ada", lesson, Path("x")), Verdict(name, "ada", JUDGED, 1, 1, (), (), 0, ""))
        for name in (mark.lesson for mark in marks)
        if (lesson := find_lesson(name))
    ]
    print_class(judged, results)
    assert "stage1 1.2 d -2, stage3 5.0 h -2" in capsys.readouterr().out
    print_class(judged[:1], results)
    assert "1.2 d -2" in (shown := capsys.readouterr().out) and "stage" not in shown


@pytest.mark.end_to_end
def test_without_a_roster_the_table_has_who_handed_in(course, capsys):
    for name in ("roster.csv", "deadlines.toml"):
        (course.root / name).unlink()
    assert grade(course) == commands.GOOD
    shown = capsys.readouterr().out
    assert cells(shown, "ghost")[1:3] == ["3", "-"] and "idle" not in shown
    assert "on the roster" not in shown


@pytest.mark.end_to_end
def test_one_student_is_graded_alone_and_told_how_the_marks_came_to_be(course, capsys):
    grade(course)
    (course.root / "roster.csv").write_text(ROSTER + "ghost,,,\n")
    with gradebook.open_gradebook(course) as book:
        book.find_grade("test_voxel_grid", GROUND.name, STAGE, "ada").manual_score = 15.0
        book.db.commit()
    capsys.readouterr()
    assert grade(course, "ada") == commands.GOOD
    shown = capsys.readouterr().out
    assert f"{GROUND.name}: 11.75 of 30 points" in shown
    rows = [line.split() for line in shown.splitlines() if " voxel_grid " in line]
    assert [row[4:8] for row in rows] == [
        ["-", "8.5", "verdict", "of"],
        ["8.5", "15", "a", "person"],
    ]
    assert {change.student for change in read_changes(course)} == {"ada", "bob"}  # and no ghost yet
    with gradebook.open_gradebook(course) as book:
        students = {submission.student.id for submission in book.find_assignment(STAGE).submissions}
    assert students == {"ada", "bob"}
    assert "bob" in (course.report / "index.html").read_text()  # it is of the whole class
    assert grade(course, "ghost") == commands.GOOD
    assert {one.student for one in read_changes(course)} == {"ada", "bob", "ghost"}


@pytest.mark.parametrize(
    ("text", "student"), [("ada", "ada"), ("Bell, Bob", "bob"), ("ADA ", "ada"), ("ghost", "ghost")]
)
def test_whoever_is_named_is_found(course, text, student):
    assert find_student(course, text) == student


def test_who_is_named_by_nobody_or_two_is_asked_about(course, capsys):
    assert cli.main(["grade", "--student", "nobody"]) == commands.WRONG_CALL
    assert (
        "'nobody' is not on the roster, and has no folder in submitted/." in capsys.readouterr().err
    )
    (course.root / "roster.csv").write_text(ROSTER + "ada2,Ada,Ash,\n")
    with pytest.raises(UnknownStudent, match="may be ada .Ada Ash. or ada2 .Ada Ash.: name the id"):
        find_student(course, "Ada Ash")
    (course.root / "roster.csv").unlink()
    with pytest.raises(UnknownStudent, match="^'nobody' has no folder in submitted/"):
        find_student(course, "nobody")


@pytest.mark.end_to_end
def test_one_student_is_judged_again_and_nobody_else(course, monkeypatch):
    monkeypatch.undo()
    judged = []

    def judge_one(handed_in, lesson, student, *about):
        judged.append((student, lesson))
        return next(
            verdict
            for one, verdict in verdicts(course)
            if (one.student, one.lesson.name) == judged[-1]
        )

    stored = verdicts(course)[0][1]
    monkeypatch.setattr(grading, "stored_verdict", lambda *about: stored)
    monkeypatch.setattr(grading, "judge_one", judge_one)
    monkeypatch.setattr(grading.Rehearsals, "passed", lambda *about: True)
    about = (course, (), 2**64, UNWALLED, Inline, 1, lambda *news: None)
    done = grading.judge_class(*about, student="ada")
    assert {one.student for one, _ in done} == {"ada"}
    assert sorted(judged) == [("ada", lesson.name) for lesson in EARNED["ada"]]
    judged.clear()
    assert len(grading.judge_class(*about)) == len(find_submissions(course)) and judged == []


@pytest.mark.parametrize(
    ("file", "text"), [("roster.csv", "name\n"), ("deadlines.toml", "[stage9]\n")]
)
@pytest.mark.parametrize("command", ["grade", "export"])
def test_what_cannot_be_read_is_said_before_anything_is_done(course, capsys, command, file, text):
    (course.root / file).write_text(text)
    assert cli.main([command]) == commands.WRONG_CALL
    assert capsys.readouterr().err.startswith(file)
    assert not course.verdicts.exists()


# ---- the doctor ---------------------------------------------------------------------------------


def findings(course, monkeypatch):
    monkeypatch.setattr(doctor.Rehearsals, "finish", lambda *about: None)
    about_grading = doctor.examine(course, 1, UNWALLED, Inline(1), progress_bar)
    found = [*about_grading, *check_gradebook(course)]
    return [(one.subject, one.good, one.text) for one in found]


def test_the_doctor_goes_by_the_roster(course, monkeypatch):
    hand_in(course, "yan ", GROUND)
    found = findings(course, monkeypatch)
    assert (
        "roster",
        True,
        "5 people, 1 in section A, 2 in section B, 5 without an lms_id",
    ) in found
    assert (STAGE, True, "3 of 5 handed in; missing: idle; excused: eve") in found
    assert ("roster", True, "'yan ' in submitted/ is taken for yan (Yan Yip).") in found
    (stranger,) = [text for subject, good, text in found if subject == "roster" and not good]
    assert stranger.startswith("'ghost' is not on the roster")
    assert ("deadlines", True, f"{STAGE} 2026-03-01 12:00 UTC, 1 later, 1 excused") in found


def test_the_doctor_says_when_a_stage_is_due_for_a_section(course, monkeypatch):
    dates = course.root / "deadlines.toml"
    dates.write_text(f"{dates.read_text()}\n[{STAGE}.sections]\nB = 2026-03-02T09:30:00\n")
    said = {subject: text for subject, _, text in findings(course, monkeypatch)}
    words = f"{STAGE} 2026-03-01 12:00 UTC, section B 2026-03-02 09:30 UTC, 1 later, 1 excused"
    assert said["deadlines"] == words


def test_the_doctor_says_what_is_not_there(course, monkeypatch):
    for name in ("roster.csv", "deadlines.toml"):
        (course.root / name).unlink()
    said = {subject: text for subject, good, text in findings(course, monkeypatch) if good}
    assert said["roster"] == "there is no roster.csv: who has a folder takes the course"
    assert said["deadlines"].startswith("there is no deadlines.toml: the dates are those of the")
    assert said["sandbox process"].startswith("has no walls, and is only used where you say")
    assert said["gradebook"] == f"{course.root / 'gradebook.db'}, with marks of 0 students"


@pytest.mark.parametrize("file", ["roster.csv", "deadlines.toml"])
def test_the_doctor_names_a_file_that_cannot_be_read(course, monkeypatch, file):
    (course.root / file).write_text("?")
    wrong = {subject: text for subject, good, text in findings(course, monkeypatch) if not good}
    assert wrong[file.partition(".")[0]].startswith(file)


def test_the_doctor_names_marks_of_who_is_not_on_the_roster(course, monkeypatch):
    grade(course)
    (course.root / "roster.csv").write_text(ROSTER.replace("bob,", "rob,"))
    wrong = [text for subject, good, text in findings(course, monkeypatch) if not good]
    assert any(text.startswith("'bob' has marks in the gradebook") for text in wrong)


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("postgresql://t:s@127.0.0.1:1/x", "needs the package psycopg2, which is not installed."),
        ("postgresql+pg8000://t:s@127.0.0.1:1/x", "cannot be opened: "),
        ("nonsense", "cannot be opened: "),
    ],
)
def test_a_gradebook_that_cannot_be_opened_is_a_sentence(course, monkeypatch, capsys, url, says):
    with (course.root / "nbgrader_config.py").open("a") as file:
        file.write(f"c.CourseDirectory.db_url = {url!r}\n")
    assert cli.main(["export"]) == commands.WRONG_CALL
    said = capsys.readouterr().err
    assert said.startswith("The gradebook") and says in said and "c.CourseDirectory.db_url" in said
    wrong = {subject: text for subject, good, text in findings(course, monkeypatch) if not good}
    assert says in wrong["gradebook"]
