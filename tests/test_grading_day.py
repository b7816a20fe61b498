"""A day of grading with commands only, from the zips of two platforms to the marks in both."""

import csv
import re
import shutil
import zipfile

import pytest

from grader import cli, commands
from grader.course import paths
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.course.paths import PROJECT, Course
from tests.archives import canvas_files, make_zip, moodle_files, worksheet
from tests.gradebooks import LATE_PLUGIN
from tests.graded_courses import (
    CONFIGURATION,
    REPORT,
    SEED,
    answered_notebook,
    enter_manual_mark,
    with_report,
)
from tests.platforms import Canvas, CanvasStudent, Moodle, MoodleStudent

SIX, TWELVE = find_lesson("06_filter_ground"), find_lesson("12_streaming_obstacles")
PEOPLE = (  # ID, first and last name, section, number in Canvas, number in Moodle
    ("ada", "Ada", "Ash", "A", 4001, 51),
    ("bjorn", "Björn", "Müller", "A", 4002, 52),
    ("cy", "Cy", "O'Neil, Jr", "B", 4003, 53),
    ("dan", "Dan", "Dorn", "B", 4004, 54),
    ("eve", "Eve", "Elm", "A", 4005, 55),
    ("finn", "Finn", "Fell", "B", 4006, 56),
    ("gus", "Gus", "Gray", "A", 4007, 57),
)
DATES = f"""
timezone = "Europe/Berlin"
[{SIX.stage}]
due = 2026-10-12T23:59:00
[{SIX.stage}.students]
eve = "excused"
gus = 2999-01-01T12:00:00
[{TWELVE.stage}]
due = 2026-10-12T23:59:00
"""
LATE_TIMES = "id,Last modified (submission)\nbjorn,2026-10-14 08:00\ngus,2026-10-20 08:00\n"


@pytest.fixture
def course(tmp_path, sandbox, monkeypatch):
    """Return a course with a roster, dates and a penalty, but without submissions."""
    course = Course(tmp_path / "course")
    for kind, lesson in ((f, item) for f in ("solutions", "notebooks") for item in (SIX, TWELVE)):
        folder = course.root / kind / lesson.stage
        folder.mkdir(parents=True)
        shutil.copy(PROJECT / kind / lesson.stage / f"{lesson.name}.ipynb", folder)
    values = {"project": str(PROJECT), "root": str(course.root), "seed": SEED}
    settings = CONFIGURATION.format(**values, sandbox=sandbox.name) + LATE_PLUGIN
    (course.root / "nbgrader_config.py").write_text(settings)
    with open(course.root / "roster.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["id", "first_name", "last_name", "section", "lms_id", "email"])
        for id, first, last, section, number, _ in PEOPLE:
            table.writerow([id, first, last, section, number, f"{id}@x.edu"])
    (course.root / "deadlines.toml").write_text(DATES)
    monkeypatch.setattr(commands, "Course", lambda: course)
    paths._folder.cache_clear()
    return course


def half_right():
    """Return a lesson 06 notebook with a correct filter_ground and an untouched voxel_grid."""
    (right, *_) = (answer.source for answer in answers_to("filter_ground") if answer.right)
    return fill_in(SIX, {"filter_ground": right}).encode()


def from_canvas(again=False):
    """Return Canvas's zip for stage 3, with unusual file names and a student who has left."""
    right = answered_notebook().encode()
    work = {
        "ada": [(f"{SIX.name}.ipynb", half_right())],
        "bjorn": [(f"Übung {SIX.name}.ipynb", right if again else half_right())],
        "cy": [("homework.zip", make_zip([(f"hw/{SIX.name}.ipynb", right)]))],
        "dan": [("6.ipynb", right)],
        "gus": [(f"{SIX.name}.ipynb", half_right())],
    }
    files = canvas_files("Ghost, Gil", 9999, [(99, f"{SIX.name}.ipynb", right)])
    for place, (id, first, last, _, number, _) in enumerate(PEOPLE):
        given = [(100 * (1 + again) + place, *attachment) for attachment in work.get(id, ())]
        files += canvas_files(f"{last}, {first}", number, given, late=id in ("bjorn", "gus"))
    return make_zip(files)


def from_moodle():
    """Return Moodle's zip for stage 4, with the write-ups of a student and of a team."""
    data = with_report(REPORT).encode()
    files = moodle_files("Ada Ash", 51, [(f"{TWELVE.name}.ipynb", data)])
    return make_zip(files + moodle_files("Team Red", 7, [(f"{TWELVE.name}.ipynb", data)]))


@pytest.mark.proof
def test_two_zips_become_marks_on_two_platforms(course, tmp_path, capsys):
    def run(*words):
        capsys.readouterr()
        status = cli.main([str(word) for word in words])
        return status, capsys.readouterr().out

    def file(name, content):
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return tmp_path / name

    # Release the stage and collect it twice.
    assert run("release", SIX.stage, "--to", tmp_path / "out")[0] == 0
    first, again = (file(f"canvas{n}.zip", from_canvas(bool(n))) for n in (0, 1))
    status, output = run("collect", first, "--stage", SIX.stage)
    assert status == 1 and "--who ghostgil_9999=ID" in output
    assert run("collect", first, "--stage", SIX.stage, "--who", "ghostgil_9999=-")[0] == 0
    times = ("--timestamps", file("times.csv", LATE_TIMES))
    status, output = run("collect", again, "--stage", SIX.stage, *times)
    assert status == 0 and "1 newer than the previous version" in output and "--who" not in output
    rows = [(n, f"{a} {b}", "", f"{i}@x.edu", "-") for i, a, b, _, _, n in PEOPLE]
    rows = [(*row[:4], "12 October 2026, 10:00 AM") for row in rows]
    moodle = ("collect", file("moodle.zip", from_moodle()), "--stage", TWELVE.stage)
    moodle += ("--timestamps", file("worksheet.csv", worksheet(rows)))
    assert run(*moodle, "--who", "Team Red_7=bjorn,cy")[0] == 0

    # Judge the class, and enter marks by hand.
    status, output = run("grade")
    assert status == 0 and "8 notebooks: 8 judged" in output
    for student, mark in (("ada", 8.0), ("bjorn", 9.0), ("cy", 9.0)):
        enter_manual_mark(course, student, mark)
    assert "0 judged" in run("grade")[1]

    # Export to Canvas, where a mark has changed in the meantime. Bjorn loses 20 % of 30 points, and
    # Gus is on time because of his extension.
    site = Canvas(
        [CanvasStudent(number, f"{last}, {first}") for _, first, last, _, number, _ in PEOPLE],
        {501: ["Quiz", 10.0], 502: ["Stage 3 Obstacles", 30.0]},
        {(4006, 502): 3.0},
    )
    given = file("gradebook.csv", site.export())
    site.scores[4001, 501] = 9.0
    export = ("export", "--to", tmp_path / "marks.csv", "--into", given, "--assignment", SIX.stage)
    status, output = run(*export, "--format", "canvas")
    assert status == 0 and "nothing was submitted: finn" in output
    site.import_((tmp_path / "marks.csv").read_bytes())
    marks = {number: score for (number, place), score in site.scores.items() if place == 502}
    expected = {4001: 10.0, 4002: 24.0, 4003: 30.0, 4004: 30.0, 4005: "EX", 4006: 3.0}
    assert marks == expected | {4007: 10.0}
    assert site.scores[4001, 501] == 9.0

    # Export to Moodle: 5 points of match_boxes and the manual mark.
    site = Moodle([MoodleStudent(n, f"{a} {b}", f"{i}@x.edu") for i, a, b, _, _, n in PEOPLE], 40)
    given = file("grading.csv", site.export())
    export = ("export", "--to", tmp_path / "marks2.csv", "--into", given)
    export += ("--assignment", TWELVE.name, "--format", "moodle")
    assert run(*export)[0] == 0
    site.import_((tmp_path / "marks2.csv").read_bytes())
    assert site.grades == {51: 13.0, 52: 14.0, 53: 14.0} and not site.skipped

    # Write feedback, explain a mark and compare answers. Solutions are not released before Gus's
    # extension ends.
    assert run("feedback", SIX.stage, "--for", "canvas", "--to", tmp_path / "back")[0] == 0
    with zipfile.ZipFile(tmp_path / "back" / f"{SIX.stage}_canvas.zip") as archive:
        assert len(archive.namelist()) == 5
    page = (tmp_path / "back" / SIX.stage / "bjorn.html").read_text()
    assert "Björn Müller: 24 of 30 points" in page and "14 October 2026 at 08:00 CEST" in page
    status, output = run("grade", "--student", "Björn Müller", SIX.stage)
    assert status == 0 and re.search(r"voxel_grid +- +20 +verdict", output)
    status, output = run("similarity", SIX.stage)
    same = r"identical files: bjorn \(Björn Müller\), cy \(.+?\), dan \(.+?\)"
    assert status == 0 and re.search(same, output)
    assert run("release", "--solutions", SIX.stage)[0] == 1
