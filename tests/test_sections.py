"""A teaching assistant gets the report, the marks and the feedback of one section only."""

import csv
import shutil

import pytest

from grader import cli, commands, grading
from grader.classroom.folders import UnknownStudent, find_section
from grader.course import paths
from grader.course.paths import Course
from grader.course.roster import section_slug
from grader.judging.verdict import write_verdict
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.results_reader import class_results
from tests.gradebooks import DISTANCE, GROUND, STAGE, ignore_progress, make_course, verdicts
from tests.platforms import Canvas, CanvasStudent

ROSTER = (
    "id,first_name,last_name,section,lms_id\n"
    "ada,Ada,Ash,A/1,1\nbob,Bob,Bell,B,2\nidle,Ida,Ling,a/1,3\neve,Eve,Elm,,4\n"
)


@pytest.fixture(scope="module")
def graded_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("sections") / "course")
    (course.root / "roster.csv").write_text(ROSTER)
    judged = verdicts(course)
    for submission, verdict in judged:
        write_verdict(verdict, submission.verdict_path(course))
    enter_verdicts(course, judged, [STAGE], ignore_progress)
    return course.root


@pytest.fixture
def course(graded_root, tmp_path, monkeypatch):
    """Return a course in which Ada and Ida are in section A/1, and Bob is in section B."""
    shutil.copytree(graded_root, tmp_path / "course")
    paths._folder.cache_clear()
    course = Course(tmp_path / "course")
    monkeypatch.setattr(commands, "Course", lambda: course)
    return course


def run(*options):
    return cli.main([str(option) for option in options])


def test_only_sections_on_the_roster_are_found(course):
    assert [person.id for person in find_section(course, " a/1")] == ["ada", "idle"]
    assert section_slug("A/1 ü.b") == "A_1_ü_b"
    with pytest.raises(UnknownStudent, match="in section 'C'. The sections are: A/1, B, a/1."):
        find_section(course, "C")
    with pytest.raises(UnknownStudent, match="in section ''"):
        find_section(course, "")
    (course.root / "roster.csv").write_text("id\nada\n")
    with pytest.raises(UnknownStudent, match="Add a column section to roster.csv"):
        find_section(course, "B")
    (course.root / "roster.csv").unlink()
    with pytest.raises(UnknownStudent, match="Add a column section to roster.csv"):
        find_section(course, "B")


@pytest.mark.parametrize("command", ["report", "export", "feedback"])
def test_an_unknown_section_is_refused(course, capsys, command):
    assert run(command, "--section", "Z") == commands.USAGE_ERROR
    assert "No student on the roster is in section 'Z'." in capsys.readouterr().err
    written = {"report": course.report, "export": course.root / "scores.Z.csv"}
    assert not written.get(command, course.root / "handed_back").exists()


def test_results_of_a_section_contain_nothing_about_other_sections(course):
    (course.root / "deadlines.toml").write_text(f'[{STAGE}]\nlessons = ["06"]\n')
    whole = class_results(course)
    part = whole.of_people(find_section(course, "B"))
    assert [person.id for person in part.people] == ["bob"]
    assert {result.student for result in (*part.notebooks, *part.stages)} == {"bob"}
    assert part.unassigned == (("bob", DISTANCE.name),)
    assert len(whole.unassigned) == 2
    assert part.notebook("bob", GROUND.name) == whole.notebook("bob", GROUND.name)


def test_the_report_on_a_section_names_only_its_students(course, capsys):
    for folder, name in (("ada", "ada.txt"), ("bob", "bob.txt")):
        (course.submitted / folder / STAGE / name).write_text("x")
    assert run("report") == commands.SUCCESS
    whole = (course.report / "index.html").read_text("utf-8")
    assert run("report", "--section", "a/1") == commands.SUCCESS
    path = course.report / "section_A_1.html"
    assert f"Report: {path}" in capsys.readouterr().out
    page = path.read_text("utf-8")
    assert "<h1>Class report: section A/1</h1>" in page and "2 students, 2 notebooks" in page
    assert "Ada Ash" in page and "Ida Ling" in page and "ada.txt" in page
    for other in ("Bob", "bob", "Eve Elm", "anonymous.html"):
        assert other in whole and other not in page, other
    assert (course.report / "index.html").read_text("utf-8") == whole


def test_the_export_of_a_section_has_its_own_file(course):
    for format, ending in (("csv", "csv"), ("exercises", "exercises.csv")):
        assert run("export", "--format", format, "--section", "a/1") == commands.SUCCESS
        path = course.root / f"scores.A_1.{ending}"
        with path.open(newline="", encoding="utf-8-sig") as file:
            assert [row["Student"] for row in csv.DictReader(file)] == ["out of", "ada", "idle"]
    assert not (course.root / "scores.csv").exists()


def canvas_file(course, *students):
    canvas = Canvas(list(students), {7: [STAGE, 60.0]}, scores={(2, 7): 5.0})
    path = course.root / "given.csv"
    path.write_bytes(canvas.export())
    return canvas, path


def fill_canvas_file(course, given, section):
    call = ("export", "--format", "canvas", "--assignment", STAGE, "--into", given)
    status = run(*call, "--section", section)
    return status, course.root / f"scores.{STAGE}.{section_slug(section)}.canvas.csv"


def test_marks_of_other_sections_on_the_platform_do_not_change(course, capsys):
    students = [
        CanvasStudent(1, "Ash, Ada", "", "ada"),
        CanvasStudent(2, "Bell, Bob", "", "bob"),
        CanvasStudent(3, "Ling, Ida", "", "idle"),
    ]
    canvas, given = canvas_file(course, *students)
    status, path = fill_canvas_file(course, given, "A/1")
    assert status == commands.SUCCESS
    canvas.import_(path.read_bytes())
    assert canvas.scores == {(1, 7): 30.0, (2, 7): 5.0}
    output = capsys.readouterr().out.replace(str(course.root), "")
    assert "No mark, because nothing was submitted: idle (Ida Ling)." in output
    assert "bob" not in output.lower() and "eve" not in output.lower()


def test_a_namesake_in_another_section_gets_no_mark(course, capsys):
    roster = "id,first_name,last_name,section\nada,Ada,Ash,A\nbob,Ada,Ash,B\nidle,Ida,Ling,A\n"
    (course.root / "roster.csv").write_text(roster)
    canvas, given = canvas_file(course, CanvasStudent(2, "Ash, Ada", "", "?"))
    status, path = fill_canvas_file(course, given, "A")
    assert status == commands.FAULT
    canvas.import_(path.read_bytes())
    assert canvas.scores == {(2, 7): 5.0}
    assert "Ash, Ada may be ada or bob" in capsys.readouterr().err


def test_one_autograder_for_gradescope_serves_all_sections(course, capsys):
    call = ("export", "--format", "gradescope", "--assignment", STAGE, "--section", "B")
    assert run(*call) == commands.USAGE_ERROR
    assert "Leave out --section." in capsys.readouterr().err


def test_feedback_is_written_for_a_section(course, capsys):
    assert run("feedback", STAGE, "--section", "A/1") == commands.SUCCESS
    pages = list((course.root / "handed_back" / STAGE).iterdir())
    assert [path.name for path in pages] == ["ada.html"]
    assert "There is no feedback for" not in capsys.readouterr().err
    with pytest.raises(SystemExit):
        run("feedback", STAGE, "--section", "B", "--student", "ada")


def test_grading_one_student_shows_the_whole_term(course, capsys):
    (course.root / "deadlines.toml").write_text("drop_lowest = 1\npass_mark = 60\n")
    results = class_results(course)
    judged = [pair for pair in verdicts(course) if pair[0].student == "ada"]
    grading._print_student(course, "ada", judged[:1], results)
    output = capsys.readouterr().out
    rows = [line.split() for line in output.splitlines()]
    assert [GROUND.name, "11.75", "30", "marked"] in rows
    assert [DISTANCE.name, "18.25", "30", "marked"] in rows
    total = "18.3 of 30 points (60.8 %); without 06_filter_ground; reaches the pass mark of 60 %."
    assert f"Total: {total}" in output
