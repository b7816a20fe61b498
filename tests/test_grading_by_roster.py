"""The class table, `grader doctor` and `grade --student` use the roster."""

from datetime import timedelta
from pathlib import Path

import pytest

from grader import cli, commands, grading
from grader.classroom import doctor
from grader.classroom import grade as judging_a_class
from grader.classroom.folders import UnknownStudent, find_student
from grader.classroom.submissions import Submission, find_submissions
from grader.console import print_class, progress_bar
from grader.course import paths
from grader.course.lessons import find_lesson
from grader.course.roster import Person
from grader.judging.verdict import JUDGED, Verdict, write_verdict
from grader.lms import gradebook
from grader.lms.gradebook_check import check_gradebook
from grader.lms.mark_history import read_changes
from grader.lms.results import MARKED, ClassResults, NotebookResult, StageResult
from grader.lms.results_reader import class_results
from grader.sandbox import SANDBOXES
from tests.executors import InlineExecutor
from tests.gradebooks import EARNED, GROUND, LATE_PLUGIN, STAGE, make_course, submit, verdicts

ROSTER = (
    "id,first_name,last_name,section\nada,Ada,Ash,A\nbob,Bob,Bell,B\nidle,Ida,Ling,B\n"
    "eve,Eve,Elm,\nyan,Yan,Yip,\n"
)
DATES = (
    f'timezone = "UTC"\n[{STAGE}]\ndue = 2026-03-01T12:00:00\n[{STAGE}.students]\n'
    'eve = "excused"\nidle = 2026-03-02T12:00:00\n'
)
WITHOUT_SANDBOX = SANDBOXES["process"]


@pytest.fixture
def course(tmp_path, monkeypatch):
    """Return a course with submissions of Ada, Bob and a ghost, and with a fake judge."""
    made = make_course(tmp_path / "course")
    (made.root / "roster.csv").write_text(ROSTER)
    (made.root / "deadlines.toml").write_text(DATES)
    (made.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    for student in EARNED:
        path = made.submitted / student / STAGE / "timestamp.txt"
        path.write_text("2026-03-02 15:00:00 UTC")
    submit(made, "ghost", GROUND)
    earned = EARNED | {"ghost": {GROUND: (1.0, 2.0)}}

    def judge_class(course, stages, seed, sandbox, executor, workers, progress, student=None):
        progress(0, 1, None)
        found = verdicts(course, earned)
        for submission, verdict in found:
            write_verdict(verdict, submission.verdict_path(course))
        return [
            (submission, verdict)
            for submission, verdict in found
            if student in (None, submission.student)
        ]

    monkeypatch.setattr(grading, "judge_class", judge_class)
    monkeypatch.setattr(cli.commands, "Course", lambda: made)
    paths._folder.cache_clear()
    return made


def grade(course, student=None):
    return grading.grade_course(course, (), 2**64, WITHOUT_SANDBOX, 1, student=student)


def cells(output, student):
    """Return the cells in a student's row of the table."""
    (line,) = [line.split() for line in output.splitlines() if line.split()[:1] == [student]]
    return line


@pytest.mark.end_to_end
def test_the_table_distinguishes_marks_missing_excused_and_unknown_students(course, capsys):
    assert grade(course) == commands.FAULT
    output = capsys.readouterr()
    assert "'ghost' is not on the roster, so its scores are not entered." in output.err
    # Ada and Bob are 27 hours late, so they lose two tenths of 30 and of 20.75 points.
    assert cells(output.out, "ada")[1:] == ["11.8", "18.3", "1", "d", "3", "h", "-6"]
    assert cells(output.out, "bob")[1:] == ["-", "20.8", "1", "d", "3", "h", "-4.2"]
    assert cells(output.out, "idle")[1:] == ["-", "-"]
    assert cells(output.out, "eve")[1:] == ["ex", "ex"]
    assert cells(output.out, "ghost")[1:3] == ["3", "-"]
    assert "not on the roster, so no mark was entered" in output.out
    assert "- nothing submitted · ex excused" in output.out and "a person has" not in output.out
    page = (course.report / "index.html").read_text("utf-8")
    people = len((course.root / "roster.csv").read_text("utf-8").splitlines()) - 1
    assert f"{people} students and 1 not on the roster, " in page


def test_zeros_and_waiting_marks_are_not_shown_as_dashes(course, capsys):
    grade(course)
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_submission_notebook(GROUND.name, STAGE, "ada")
        for row in notebook.grades:
            row.manual_score = 0.0
        notebook.grades[0].needs_manual_grade = True
        book.db.commit()
    submit(course, "yan", GROUND)  # submitted, but not judged
    capsys.readouterr()
    grading._print_class(course, verdicts(course), class_results(course), [])
    output = capsys.readouterr().out
    assert cells(output, "ada")[1] == "0*" and cells(output, "yan")[1:3] == ["?", "-"]
    assert "* waiting for a grader · ? not entered yet" in output


def test_long_ids_are_printed_in_full(capsys):
    """Moodle's anonymous participants differ only in the last characters."""
    ids = [f"Participant_{number}" for number in (501, 502)]
    lesson = find_lesson("06_filter_ground")
    verdict = Verdict(lesson.name, "", JUDGED, 1, 1, (), (), 0, "")
    print_class([(Submission(id, lesson, Path("x")), verdict) for id in ids])
    output = capsys.readouterr().out
    assert all(id in output for id in ids)


def test_lateness_is_shown_with_its_stage_if_there_are_several_stages(capsys):
    late = {"stage1_ransac": timedelta(hours=30), "stage3_obstacles": timedelta(hours=5)}
    stages = [
        StageResult("ada", stage, MARKED, 10.0, 10.0, 2.0, late=lateness)
        for stage, lateness in late.items()
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
    assert "stage1 1 d 6 h -2, stage3 5 h -2" in capsys.readouterr().out
    print_class(judged[:1], results)
    assert "1 d 6 h -2" in (output := capsys.readouterr().out) and "stage" not in output


@pytest.mark.end_to_end
def test_the_table_has_the_students_who_submitted_if_there_is_no_roster(course, capsys):
    for name in ("roster.csv", "deadlines.toml"):
        (course.root / name).unlink()
    assert grade(course) == commands.SUCCESS
    output = capsys.readouterr().out
    assert cells(output, "ghost")[1:3] == ["3", "-"] and "idle" not in output
    assert "on the roster" not in output


@pytest.mark.end_to_end
def test_grading_one_student_shows_the_history_of_the_marks(course, capsys):
    grade(course)
    (course.root / "roster.csv").write_text(ROSTER + "ghost,,,\n")
    with gradebook.open_gradebook(course) as book:
        book.find_grade("test_voxel_grid", GROUND.name, STAGE, "ada").manual_score = 15.0
        book.db.commit()
    capsys.readouterr()
    assert grade(course, "ada") == commands.SUCCESS
    output = capsys.readouterr().out
    assert f"{GROUND.name}: 11.75 of 30 points" in output
    rows = [line.split() for line in output.splitlines() if " voxel_grid " in line]
    assert [row[4:8] for row in rows] == [
        ["-", "8.5", "verdict", "of"],
        ["8.5", "15", "a", "person"],
    ]
    # The ghost's submission is not entered yet.
    assert {change.student for change in read_changes(course)} == {"ada", "bob"}
    with gradebook.open_gradebook(course) as book:
        students = {submission.student.id for submission in book.find_assignment(STAGE).submissions}
    assert students == {"ada", "bob"}
    assert "bob" in (course.report / "index.html").read_text()  # the report covers the whole class
    assert grade(course, "ghost") == commands.SUCCESS
    assert {change.student for change in read_changes(course)} == {"ada", "bob", "ghost"}


@pytest.mark.parametrize(
    ("text", "student"), [("ada", "ada"), ("Bell, Bob", "bob"), ("ADA ", "ada"), ("ghost", "ghost")]
)
def test_students_are_found_by_id_or_name(course, text, student):
    assert find_student(course, text) == student


def test_unknown_and_ambiguous_students_are_reported(course, capsys):
    assert cli.main(["grade", "--student", "nobody"]) == commands.USAGE_ERROR
    assert (
        "'nobody' is not on the roster, and has no folder in submitted/." in capsys.readouterr().err
    )
    with pytest.raises(UnknownStudent, match="Did you mean bob .Bob Bell.. Use the student's id"):
        find_student(course, "B'ell")
    many = "".join(f"a{number},Anna,No{number},\n" for number in range(4))
    (course.root / "roster.csv").write_text(ROSTER + many)
    with pytest.raises(UnknownStudent, match="has no folder in submitted/. Correct the name."):
        find_student(course, "nna")
    (course.root / "roster.csv").write_text(ROSTER + "ada2,Ada,Ash,\n")
    with pytest.raises(
        UnknownStudent, match="may be ada .Ada Ash. or ada2 .Ada Ash.. Use the student's id"
    ):
        find_student(course, "Ada Ash")
    (course.root / "roster.csv").unlink()
    with pytest.raises(UnknownStudent, match="^'nobody' has no folder in submitted/"):
        find_student(course, "nobody")


@pytest.mark.end_to_end
def test_only_the_named_student_is_judged_again(course, monkeypatch):
    monkeypatch.undo()
    judged = []

    def judge_one(submitted_files, lesson, student, *arguments):
        judged.append((student, lesson))
        return next(
            verdict
            for submission, verdict in verdicts(course)
            if (submission.student, submission.lesson.name) == judged[-1]
        )

    stored = verdicts(course)[0][1]
    monkeypatch.setattr(judging_a_class, "stored_verdict", lambda *arguments: stored)
    monkeypatch.setattr(judging_a_class, "judge_one", judge_one)
    monkeypatch.setattr(judging_a_class.Rehearsals, "has_passed", lambda *arguments: True)
    arguments = (course, (), 2**64, WITHOUT_SANDBOX, InlineExecutor, 1, lambda *news: None)
    done = judging_a_class.judge_class(*arguments, student="ada")
    assert {submission.student for submission, _ in done} == {"ada"}
    assert sorted(judged) == [("ada", lesson.name) for lesson in EARNED["ada"]]
    judged.clear()
    assert (
        len(judging_a_class.judge_class(*arguments)) == len(find_submissions(course))
        and judged == []
    )


@pytest.mark.parametrize(
    ("file", "text"), [("roster.csv", "name\n"), ("deadlines.toml", "[stage9]\n")]
)
@pytest.mark.parametrize("command", ["grade", "export"])
def test_unreadable_settings_are_reported_before_judging(course, capsys, command, file, text):
    (course.root / file).write_text(text)
    assert cli.main([command]) == commands.USAGE_ERROR
    assert capsys.readouterr().err.startswith(file)
    assert not course.verdicts.exists()


# ---- the doctor ---------------------------------------------------------------------------------


def findings(course, monkeypatch):
    monkeypatch.setattr(doctor.Rehearsals, "finish", lambda *about: None)
    about_grading = doctor.examine(course, 1, WITHOUT_SANDBOX, InlineExecutor(1), progress_bar)
    found = [*about_grading, *check_gradebook(course)]
    return [(finding.subject, finding.is_good, finding.text) for finding in found]


def test_the_doctor_uses_the_roster(course, monkeypatch):
    submit(course, "yan ", GROUND)
    found = findings(course, monkeypatch)
    assert (
        "roster",
        True,
        "5 people, 1 in section A, 2 in section B, 5 without an lms_id",
    ) in found
    assert (STAGE, True, "3 of 5 submitted; missing: idle; excused: eve") in found
    assert ("roster", True, "'yan ' in submitted/ belongs to yan (Yan Yip).") in found
    (unknown,) = [text for subject, good, text in found if subject == "roster" and not good]
    assert unknown.startswith("'ghost' is not on the roster")
    assert (
        "deadlines",
        True,
        f"{STAGE} due 2026-03-01 12:00 UTC, 1 with an extension, 1 excused",
    ) in found


def test_the_doctor_shows_due_dates_of_sections(course, monkeypatch):
    dates = course.root / "deadlines.toml"
    dates.write_text(f"{dates.read_text()}\n[{STAGE}.sections]\nB = 2026-03-02T09:30:00\n")
    texts = {subject: text for subject, _, text in findings(course, monkeypatch)}
    shown = (
        "2026-03-01 12:00 UTC, section B due 2026-03-02 09:30 UTC, 1 with an extension, 1 excused"
    )
    assert texts["deadlines"] == f"{STAGE} due {shown}"


def test_the_doctor_reports_missing_files(course, monkeypatch):
    for name in ("roster.csv", "deadlines.toml"):
        (course.root / name).unlink()
    texts = {subject: text for subject, good, text in findings(course, monkeypatch) if good}
    assert (
        texts["roster"]
        == "there is no roster.csv, so every folder in submitted/ counts as a student"
    )
    assert texts["deadlines"].startswith(
        "there is no deadlines.toml, so the dates in the gradebook"
    )
    assert texts["sandbox process"].startswith("protects less than bubblewrap; used only")
    assert texts["gradebook"] == f"{course.root / 'gradebook.db'}, with marks for 0 students"


@pytest.mark.parametrize("file", ["roster.csv", "deadlines.toml"])
def test_the_doctor_names_an_unreadable_file(course, monkeypatch, file):
    (course.root / file).write_text("?")
    wrong = {subject: text for subject, good, text in findings(course, monkeypatch) if not good}
    assert wrong[file.partition(".")[0]].startswith(file)
    unchecked = {subject for subject, text in wrong.items() if text.startswith("not checked")}
    assert unchecked == {"gradebook"} | ({"submitted"} if file == "roster.csv" else set())


def test_the_doctor_lists_marks_of_students_who_are_not_on_the_roster(course, monkeypatch):
    grade(course)
    (course.root / "roster.csv").write_text(ROSTER.replace("bob,", "rob,"))
    wrong = [text for subject, good, text in findings(course, monkeypatch) if not good]
    assert any(text.startswith("'bob' has marks in the gradebook") for text in wrong)


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("postgresql://t:s@127.0.0.1:1/x", "needs the package psycopg2, which is not installed."),
        ("postgresql+pg8000://t:s@127.0.0.1:1/x", "cannot be opened: "),
        ("nonsense", "cannot be opened: "),
    ],
)
def test_a_gradebook_that_cannot_be_opened_is_reported(course, monkeypatch, capsys, url, message):
    with (course.root / "nbgrader_config.py").open("a") as file:
        file.write(f"c.CourseDirectory.db_url = {url!r}\n")
    assert cli.main(["export"]) == commands.USAGE_ERROR
    text = capsys.readouterr().err
    assert (
        text.startswith("The gradebook") and message in text and "c.CourseDirectory.db_url" in text
    )
    wrong = {subject: text for subject, good, text in findings(course, monkeypatch) if not good}
    assert message in wrong["gradebook"]
