"""Exports to Canvas and Moodle lose no marks and change no other marks."""

import dataclasses
import re

import pytest

from grader.classroom.collect.owners import safe_folder
from grader.classroom.collect.record import FileOrigin, Record, write_record
from grader.course import paths
from grader.course.deadlines import TermRules
from grader.course.paths import Course
from grader.course.roster import Person
from grader.lms.exporters.canvas import export_canvas
from grader.lms.exporters.moodle import export_moodle
from grader.lms.exporters.protocol import ExportError, ExportOptions
from grader.lms.results import EXCUSED, MARKED, MISSING, ClassResults, NotebookResult, StageResult
from tests.archives import canvas_prefix
from tests.platforms import ENGLISH, GERMAN, Canvas, CanvasStudent, Moodle, MoodleStudent

STAGE, LESSON = "stage3_obstacles", "06_filter_ground"
ANNA = Person("anna", "Anna", "Schmidt", "as@x.edu", "A", "9001")
BJÖRN = Person("björn", "Björn", "Müller", "bm@x.edu", "A", "9002")
MARY = Person("mary jane", "Mary Jane", "O'Neil, Jr", "mj@x.edu", "B", "9003")
FORMULA = Person("cmd", "", "=cmd|' /C calc'!A0", "c@x.edu", "B", "9004")
NOSHOW = Person("noshow", "Noah", "Show", "ns@x.edu", "B", "9005")
EXCUSED_PERSON = Person("ill", "Ilse", "Krank", "ik@x.edu", "B", "9006")
PEOPLE = (ANNA, BJÖRN, MARY, FORMULA, NOSHOW, EXCUSED_PERSON)
POINTS = {"anna": 8.5, "björn": 31.25, "mary jane": 100.0, "cmd": 0.0}


def marks(points=POINTS, people=PEOPLE, most=100.0, excused=(EXCUSED_PERSON,)):
    """Return the results of a class in a stage that consists of one lesson."""
    notebooks, stages = [], []
    for person in people:
        score = points.get(person.id)
        status = MISSING if score is None else MARKED
        status = EXCUSED if person in excused else status
        notebooks.append(NotebookResult(person.id, STAGE, LESSON, status, score, most))
        stages.append(StageResult(person.id, STAGE, status, score, most))
    return ClassResults(tuple(people), tuple(notebooks), tuple(stages))


@pytest.fixture
def fill_file(tmp_path):
    """Return a function that enters results in a platform's file."""

    def fill_in(platform, results, **options):
        path = tmp_path / "downloaded.csv"
        path.write_bytes(platform.export())
        write = export_canvas if isinstance(platform, Canvas) else export_moodle
        return write(ExportOptions(Course(tmp_path), results, STAGE, into=path, **options))

    return fill_in


# ---- Canvas --------------------------------------------------------------------------------------


def canvas_course(**settings):
    students = [
        CanvasStudent(9004, FORMULA.last_name, "sis4", "c@x.edu"),
        CanvasStudent(9006, "Krank, Ilse", "sis6", "ill"),
        CanvasStudent(9002, "Müller, Björn", "sis2", "björn"),
        CanvasStudent(9003, "O'Neil, Jr, Mary Jane", "sis3", "mary jane", "A and B"),
        CanvasStudent(9001, "Schmidt, Anna", "sis1", "anna"),
        CanvasStudent(9005, "Show, Noah", "sis5", "noshow"),
        CanvasStudent(9100, "Student, Test", "", "a7f3"),
    ]
    assignments = {41: ["Essay; with a pen", 20.0], 42: ["Stage 3: Obstacles", 100.0]}
    scores = {(9001, 41): 17.5, (9005, 42): 44.0, (9002, 42): 12.0, (9100, 42): 3.0}
    return Canvas(students, assignments, scores, notes={9001: "=1+1"}, **settings)


SETTINGS = [
    {},
    {"separator": ";", "decimal_mark": ",", "marked": True},
    {"separator": ",", "decimal_mark": ",", "sis": False},
    {"first_and_last": True, "manual": True},
    {"separator": ";", "manual": True, "sis": False},
]


@pytest.mark.parametrize("settings", SETTINGS)
def test_canvas_gets_each_mark_and_no_other_mark_changes(fill_file, settings):
    course = canvas_course(**settings)
    if settings.get("first_and_last"):
        course.students[0].name = "=cmd, Cid"
    exported = fill_file(course, marks())
    # After the download, other marks and the points of the essay change in Canvas.
    course.scores |= {(9001, 41): 19.0, (9002, 41): 11.0, (9005, 42): 60.0}
    course.assignments[41][1] = 25.0
    course.notes[9001] = "was ill"
    course.import_(exported.content)
    assert course.scores == {
        (9001, 41): 19.0,
        (9002, 41): 11.0,
        (9001, 42): 8.5,
        (9002, 42): 31.25,
        (9003, 42): 100.0,
        (9004, 42): 0.0,
        (9005, 42): 60.0,
        (9006, 42): "EX",
        (9100, 42): 3.0,
    }
    assert course.assignments == {
        41: ["Essay; with a pen", 25.0],
        42: ["Stage 3: Obstacles", 100.0],
    }
    assert course.notes == {9001: "was ill"}
    assert (exported.mark_count, exported.failures) == (4, ())


def test_a_file_for_canvas_has_the_format_of_the_site(fill_file):
    course = canvas_course(separator=";", decimal_mark=",", marked=True)
    text = fill_file(course, marks()).content.decode()
    assert text.startswith(
        "\ufeffStudent;ID;SIS User ID;SIS Login ID;Section;Stage 3: Obstacles (42)\n"
    )
    assert "\n    Points Possible;;;;;100,00\n" in text
    assert "\nSchmidt, Anna;9001;sis1;anna;A;8,5\n" in text
    assert '\n"=""=cmd|\' /C calc\'!A0""";9004;' in text  # as in Canvas's file
    assert "Noah" not in text and "Test" not in text


@pytest.mark.parametrize("roster", ["lms_id", "login", "email", "sis"])
def test_canvas_rows_are_found_by_any_key_of_the_roster(fill_file, roster):
    course = canvas_course()
    people = [
        dataclasses.replace(person, lms_id="", first_name="", last_name="") for person in PEOPLE
    ]
    if roster == "lms_id":
        people = [
            dataclasses.replace(person, id=f"s{person.lms_id}", lms_id=person.lms_id)
            for person in PEOPLE
        ]
    elif roster == "email":
        for student, person in zip(
            course.students, (FORMULA, EXCUSED_PERSON, BJÖRN, MARY, ANNA, NOSHOW), strict=False
        ):
            student.login = person.email.upper()
        people = [
            dataclasses.replace(person, id=f"s{number}") for number, person in enumerate(people)
        ]
    elif roster == "sis":
        people = [
            dataclasses.replace(person, lms_id=f"sis{number}", email="")
            for number, person in enumerate(people, start=1)
        ]
        for student in course.students:
            student.login = f"login{student.id}"
    points = dict(zip([person.id for person in people], POINTS.values(), strict=False))
    exported = fill_file(course, marks(points, people, excused=()))
    course.import_(exported.content)
    scores = {id: score for (id, assignment), score in course.scores.items() if assignment == 42}
    if roster == "login":  # the student called cmd has another login
        assert scores.pop(9004, 0.0) == 0.0
    else:
        assert not exported.failures and scores.pop(9004) == 0.0
    assert scores == {9001: 8.5, 9002: 31.25, 9003: 100.0, 9005: 44.0, 9100: 3.0}


def test_canvas_rows_found_only_by_name_are_noted(fill_file):
    course = canvas_course()
    people = [
        dataclasses.replace(person, lms_id="", email="", id=f"s{person.lms_id}")
        for person in PEOPLE
    ]
    points = dict(zip([person.id for person in people], POINTS.values(), strict=False))
    exported = fill_file(course, marks(points, people, excused=()))
    course.import_(exported.content)
    assert (exported.failures, course.scores[9002, 42]) == ((), 31.25)
    assert any(
        note.startswith("Matched only by name: ") and "Müller, Björn" in note
        for note in exported.notes
    )


def test_ambiguous_students_are_reported_and_get_no_mark(fill_file):
    course = canvas_course()
    course.students.append(CanvasStudent(9200, "Schmidt, Anna", "sis9", "as9"))
    other = Person("anna2", "Anna", "Schmidt")
    without_number = dataclasses.replace(ANNA, lms_id="", id="as", email="")
    given = marks({"as": 5.0, "anna2": 6.0}, (without_number, other), excused=())
    exported = fill_file(course, given)
    assert exported.mark_count == 0
    assert exported.failures == (
        "as (Anna Schmidt), 5 points: Schmidt, Anna or Schmidt, Anna may be anna2 or as.",
        "anna2 (Anna Schmidt), 6 points: Schmidt, Anna or Schmidt, Anna may be anna2 or as.",
    )


def test_a_row_that_matches_two_people_gets_no_mark(fill_file):
    course = canvas_course()
    other = Person("sis1", "Thea", "Dieb")  # Thea's ID equals Anna's SIS ID
    exported = fill_file(course, marks({"anna": 8.5, "sis1": 1.0}, (ANNA, other), excused=()))
    assert exported.mark_count == 0 and len(exported.failures) == 2
    assert "Schmidt, Anna may be anna or sis1" in exported.failures[0]


def test_a_canvas_number_takes_precedence_over_an_equal_id(fill_file):
    course = canvas_course()
    other = Person("9001", "Zoe", "", "z@x.edu", "A", "9100")
    exported = fill_file(course, marks({"anna": 8.5, "9001": 1.0}, (ANNA, other), excused=()))
    course.import_(exported.content)
    assert course.scores[9001, 42] == 8.5


def test_an_id_that_equals_a_canvas_number_needs_the_same_name(fill_file):
    """IDs may be Canvas's numbers, but such a match does not count if the names differ."""
    course = canvas_course(sis=False)
    same, other = Person("9001", "Anna", "Schmidt"), Person("9002", "Zoe", "Zahn")
    nameless = Person("9003")
    points = {"9001": 1.0, "9002": 2.0, "9003": 3.0}
    exported = fill_file(course, marks(points, (same, other, nameless), excused=()))
    course.import_(exported.content)
    assert (course.scores[9001, 42], course.scores[9003, 42]) == (1.0, 3.0)
    assert course.scores[9002, 42] == 12.0
    assert exported.failures == (
        "9002 (Zoe Zahn), 2 points: the file has no row for this student.",
    )


def test_another_name_with_the_same_number_is_noted(fill_file):
    course = canvas_course()
    course.students[4].name = "Schmidt-Meier, Anna"
    exported = fill_file(course, marks())
    assert exported.failures == ()
    note = "Under another name in the file: Schmidt-Meier, Anna for anna (Anna Schmidt)."
    assert note in exported.notes
    assert not any("another name" in note for note in fill_file(canvas_course(), marks()).notes)


def test_no_mark_is_entered_if_two_systems_give_a_number_to_different_people(fill_file):
    """The ID of each student is the other student's SIS ID, and the names fit the IDs."""
    course = canvas_course()
    course.students = [
        CanvasStudent(100, "Ash, Anna", "200", "aash"),
        CanvasStudent(200, "Bäcker, Bo", "100", "bbo"),
    ]
    people = (Person("100", "Anna", "Ash"), Person("200", "Bo", "Bäcker"))
    exported = fill_file(course, marks({"100": 12.5, "200": 31.25}, people, excused=()))
    assert (exported.mark_count, b"12.5" in exported.content) == (0, False)
    assert exported.failures == (
        "100 (Anna Ash), 12.5 points: Ash, Anna or Bäcker, Bo may be 100 or 200.",
        "200 (Bo Bäcker), 31.25 points: Ash, Anna or Bäcker, Bo may be 100 or 200.",
    )
    nameless = tuple(Person(person.id) for person in people)
    exported = fill_file(course, marks({"100": 12.5, "200": 31.25}, nameless, excused=()))
    assert (exported.mark_count, len(exported.failures)) == (0, 2)


@pytest.mark.parametrize("platform", ["canvas", "moodle"])
def test_no_mark_is_entered_if_key_and_name_belong_to_different_students(fill_file, platform):
    if platform == "canvas":
        course = canvas_course()
        course.students[2].name, course.students[4].name = "Schmidt, Anna", "Müller, Björn"
    else:
        course = moodle_course()
        course.students[1].name, course.students[0].name = "Anna Schmidt", "Björn Müller"
    exported = fill_file(course, marks())
    assert exported.mark_count == 2
    assert [sentence.partition(",")[0] for sentence in exported.failures] == [
        "anna (Anna Schmidt)",
        "björn (Björn Müller)",
    ]
    assert all("may be anna or björn" in sentence for sentence in exported.failures)


def test_a_namesake_with_another_number_gets_no_mark(fill_file):
    course = canvas_course()
    anna = next(student for student in course.students if student.id == 9001)
    anna.id, anna.sis_id, anna.login = 7777, "sis7", "a.schmidt"
    exported = fill_file(course, marks())
    course.import_(exported.content)
    assert (7777, 42) not in course.scores
    assert exported.failures == (
        "anna (Anna Schmidt), 8.5 points: Schmidt, Anna has the number 7777 instead of 9001.",
    )
    assert not any("by name" in note for note in exported.notes)
    # If the file contains both rows, Anna's row gets the mark.
    course.students.append(CanvasStudent(9001, "Schmidt, Anna", "sis1", "anna"))
    exported = fill_file(course, marks())
    course.import_(exported.content)
    assert (course.scores.get((7777, 42)), course.scores[9001, 42]) == (None, 8.5)
    assert exported.failures == ()
    assert "In the file, but not among your students: Schmidt, Anna." in exported.notes


def folders_without_a_roster(course):
    """Return the ids that `collect` gives to the students in an archive, without a roster."""
    names = ("Anna", "Björn", "Jane", "Ilse")
    students = [student for student in course.students if any(n in student.name for n in names)]
    if isinstance(course, Canvas):
        return [canvas_prefix(student.name, student.id) for student in students]
    return [safe_folder(f"{student.name}_{student.number}") for student in students]


@pytest.mark.parametrize("make_course", [canvas_course, lambda: moodle_course()])
def test_students_are_found_by_the_names_of_their_folders_without_a_roster(fill_file, make_course):
    course = make_course()
    ids = folders_without_a_roster(course)
    points = {id: float(number) for number, id in enumerate(ids, 1)}
    namesake = re.sub(r"\d+$", "7", ids[0])
    results = marks(points | {namesake: 50.0}, [*map(Person, ids), Person(namesake)], excused=())
    exported = fill_file(course, results)
    assert (exported.mark_count, len(exported.failures)) == (4, 1)
    assert exported.failures[0].startswith(namesake)
    assert not any("name in the file" in note for note in exported.notes)


def test_an_lms_id_from_another_platform_is_ignored(fill_file):
    people = [
        dataclasses.replace(person, id=f"x{n}", email="", lms_id=f"M{n}")
        for n, person in enumerate(PEOPLE)
    ]
    exported = fill_file(canvas_course(), marks({"x0": 8.5}, people, excused=()))
    assert (exported.mark_count, exported.failures) == (1, ())


@pytest.mark.parametrize(
    ("existing", "changes"),
    [
        (85.0, "björn (Björn Müller) from 12.00 to 31.25; ill (Ilse Krank) from 85.00 to EX"),
        (0.0, "björn (Björn Müller) from 12.00 to 31.25; ill (Ilse Krank) from 0.00 to EX"),
        ("EX", "björn (Björn Müller) from 12.00 to 31.25"),
        (None, "björn (Björn Müller) from 12.00 to 31.25"),
    ],
)
def test_a_mark_that_an_excuse_replaces_is_reported(fill_file, existing, changes):
    course = canvas_course()
    if existing is not None:
        course.scores[9006, 42] = existing
    exported = fill_file(course, marks())
    course.import_(exported.content)
    assert course.scores[9006, 42] == "EX"
    assert f"Marks changed in the file: {changes}." in exported.notes


def test_an_excuse_that_a_mark_replaces_is_reported(fill_file):
    course = canvas_course()
    course.scores[9001, 42] = "EX"
    replaced = "anna (Anna Schmidt) from EX to 8.5; björn (Björn Müller) from 12.00 to 31.25"
    exported = fill_file(course, marks())
    assert f"Marks changed in the file: {replaced}." in exported.notes


def test_excused_students_without_the_assignment_are_listed(fill_file):
    exported = fill_file(canvas_course(assigned={42: {9001, 9002, 9003, 9004}}), marks())
    assert (exported.mark_count, exported.failures) == (4, ())
    assert b"EX" not in exported.content
    (note,) = [note for note in exported.notes if note.startswith("Excused, but not marked")]
    assert "ill (Ilse Krank): Canvas would ignore the mark" in note and "(N/A)" in note


def test_a_mark_for_an_unassigned_student_is_reported(fill_file):
    course = canvas_course(assigned={42: {9002, 9003, 9004}})
    exported = fill_file(course, marks())
    assert exported.mark_count == 3
    (lost,) = exported.failures
    assert lost.startswith("anna (Anna Schmidt), 8.5 points: Canvas would ignore the mark")


def test_students_missing_from_the_file_or_the_roster_are_listed(fill_file):
    course = canvas_course()
    course.students = [student for student in course.students if student.id not in (9001, 9005)]
    course.students.append(CanvasStudent(9300, "Gast, Gerd", "sis8", "gg"))
    exported = fill_file(course, marks())
    assert exported.failures == (
        "anna (Anna Schmidt), 8.5 points: the file has no row for this student.",
    )
    assert "In the file, but not among your students: Gast, Gerd." in exported.notes
    absent = "Among your students, but not in the file: noshow (Noah Show)."
    assert absent in exported.notes


def test_another_maximum_is_refused_or_scaled(fill_file):
    course = canvas_course()
    course.assignments[42][1] = 10.0
    with pytest.raises(
        ExportError,
        match=r"\(06_filter_ground 100\), but 'Stage 3: Obstacles \(42\)' is worth 10 on",
    ):
        fill_file(course, marks())
    rules = TermRules(frozenset({"voxel_grid", "search"}))
    with pytest.raises(ExportError, match="Exercises that do not count: voxel_grid. Change the"):
        fill_file(course, dataclasses.replace(marks(), rules=rules))
    course.import_(fill_file(course, marks(), scale=True).content)
    assert course.scores[9001, 42] == 0.85 and course.scores[9003, 42] == 10.0
    assert course.assignments[42][1] == 10.0
    course.assignments[42][1] = 0.0
    with pytest.raises(ExportError, match="Set 100 points there"):
        fill_file(course, marks(), scale=True)


def test_the_error_about_another_maximum_suggests_listing_the_lessons_of_a_stage(fill_file):
    results, course = marks(most=60.0), canvas_course()
    more = [
        dataclasses.replace(result, lesson="07_filter_by_distance") for result in results.notebooks
    ]
    results = dataclasses.replace(results, notebooks=(*results.notebooks, *more))
    course.assignments[42][1] = 60.0
    with pytest.raises(ExportError, match=r'below \[stage3_obstacles\] .* lessons = \["06", …\]'):
        fill_file(course, results)


def test_an_ambiguous_column_must_be_named(fill_file):
    course = canvas_course()
    course.assignments = {42: ["Obstacles", 100.0], 43: ["Essay", 100.0]}
    with pytest.raises(
        ExportError, match=r"has no column .* --column; the columns are: 'Obstacles \(42\)', 'Essay"
    ):
        fill_file(course, marks())
    for title in ("Obstacles", "Obstacles (42)"):
        other = canvas_course()
        other.assignments = dict(course.assignments)
        other.import_(fill_file(other, marks(), column=title).content)
        assert other.scores[9001, 42] == 8.5
    course.assignments = {
        42: ["Stage 3 (obstacles)", 100.0],
        43: ["Stage 3: Obstacles, again", 1.0],
    }
    with pytest.raises(ExportError, match="more than one column"):
        fill_file(course, marks())
    with pytest.raises(ExportError, match="has no column 'Final Score'"):
        fill_file(course, marks(), column="Final Score")


def test_a_title_that_canvas_never_imports_is_reported(fill_file):
    course = canvas_course()
    course.assignments = {42: ["Stage 3 obstacles: Final Score", 100.0]}
    remedy = r"never imports 'Stage 3 obstacles: Final Score \(42\)', .* Rename the assignment"
    for column in (None, "Stage 3 obstacles: Final Score"):
        with pytest.raises(ExportError, match=remedy):
            fill_file(course, marks(), column=column)
    course.assignments[43] = ["Stage 3 obstacles", 100.0]
    course.import_(fill_file(course, marks()).content)
    assert course.scores[9001, 43] == 8.5


# ---- Moodle --------------------------------------------------------------------------------------


def moodle_course(**settings):
    students = [
        MoodleStudent(311, "Anna Schmidt", "as@x.edu", "anna"),
        MoodleStudent(312, "Björn Müller", "bm@x.edu", "björn"),
        MoodleStudent(313, "Mary Jane O'Neil, Jr", "mj@x.edu", "mary jane"),
        MoodleStudent(314, FORMULA.last_name, "c@x.edu", "cmd"),
        MoodleStudent(315, "Noah Show", "ns@x.edu", "noshow", "No submission"),
        MoodleStudent(316, "Ilse Krank", "ik@x.edu", "ill", "No submission"),
    ]
    grades, graded = {312: 12.0, 315: 44.0}, {312: 5, 315: 5}
    comments = {312: "<p>So, so;\nfine</p>", 315: "none"}
    return Moodle(students, 100.0, grades, comments, graded, **settings)


@pytest.mark.parametrize(
    "settings",
    [{}, {"words": GERMAN, "decimal_mark": ","}, {"workflow": True}],
)
def test_moodle_gets_each_mark_and_no_other_mark_changes(fill_file, settings):
    course = moodle_course(**settings)
    exported = fill_file(course, marks())
    # Noah is graded again after the download. The upload may overwrite such newer records.
    course.grades[315], course.graded_at[315], course.comments[315] = 60.0, 90, "graded again"
    course.import_(exported.content, ignore_modified=True)
    assert course.grades == {311: 8.5, 312: 31.25, 313: 100.0, 314: 0.0, 315: 60.0}
    assert course.comments[312] == "<p>So, so;\nfine</p>" and course.comments[315] == "graded again"
    assert (exported.mark_count, exported.failures, course.skipped) == (4, (), [])
    mark = settings.get("decimal_mark", ".")
    replaced = f"björn (Björn Müller) from 12{mark}00 to 31{mark}25"
    assert f"Marks changed in the file: {replaced}." in exported.notes


def test_a_worksheet_keeps_its_format(fill_file):
    course = moodle_course(words=GERMAN, decimal_mark=",")
    text = fill_file(course, marks()).content.decode()
    assert text.startswith("\ufeffID,Vollständiger Name,E-Mail-Adresse,ID-Nummer,Status,Bewertung,")
    assert (
        '\nTeilnehmer/in311,Anna Schmidt,as@x.edu,anna,Submitted for grading,"8,5","100,00",Ja,'
        in text
    )
    assert "=cmd|' /C calc'!A0" in text  # not escaped, because Moodle compares names with its own


def test_marks_that_moodle_would_skip_are_listed(fill_file):
    course = moodle_course(locked={311}, words=GERMAN, decimal_mark=",")
    exported = fill_file(course, marks({**POINTS, "mary jane": 101.0}))
    assert exported.mark_count == 2
    locked, above = exported.failures
    assert locked.startswith("anna (Anna Schmidt), 8.5 points: the grade is locked in Moodle")
    assert above.startswith(
        "mary jane (Mary Jane O'Neil, Jr), 101 points: Moodle silently ignores marks above 100"
    )
    course.import_(exported.content)
    assert not course.skipped


def test_a_lock_is_found_with_the_marking_workflow(fill_file):
    exported = fill_file(moodle_course(locked={312}, workflow=True), marks())
    assert exported.mark_count == 3 and exported.failures[0].startswith("björn")


def test_a_blind_worksheet_is_matched_by_number_only(fill_file):
    course = moodle_course(blind=True)
    people = [
        dataclasses.replace(person, lms_id=f"Participant {311 + n}")
        for n, person in enumerate(PEOPLE)
    ]
    exported = fill_file(course, marks(people=people, excused=people[5:]))
    course.import_(exported.content)
    assert exported.failures == () and course.grades[311] == 8.5 and course.grades[314] == 0.0
    plain = fill_file(moodle_course(blind=True), marks())
    assert plain.mark_count == 0 and len(plain.failures) == 4


def collect_from(course, student, owner, number):
    """Record a notebook of a student as collected from a Moodle archive."""
    folder = course.submitted / student / STAGE
    folder.mkdir(parents=True)
    name = f"{LESSON}.ipynb"
    (folder / name).write_text("{}")
    origin = FileOrigin("", f"all.zip: {owner}/{name}", "2026-10-12T18:00:00", participant=number)
    write_record(Record({name: origin}), folder)


@pytest.mark.parametrize("words", [ENGLISH, GERMAN])
def test_anonymous_submissions_are_joined_by_their_label(fill_file, words):
    """The archive has Participant_312, and the worksheet Participant 312 and no names."""
    moodle_site = moodle_course(blind=True, words=words)
    word = words["hiddenuser"].strip().replace("/", "")
    ids = [f"{word}_{number}" for number in (311, 312, 313)]
    exported = fill_file(
        moodle_site,
        marks(dict(zip(ids, (8.5, 31.25, 0.0), strict=True)), tuple(map(Person, ids)), excused=()),
    )
    moodle_site.import_(exported.content, ignore_modified=True)
    assert exported.failures == ()
    assert moodle_site.grades == {311: 8.5, 312: 31.25, 313: 0.0, 315: 44.0}


def test_anonymous_submissions_of_the_roster_are_joined_by_the_archive(fill_file, tmp_path):
    course = Course(tmp_path)
    paths._folder.cache_clear()
    collect_from(course, "anna", "Participant_312", "312")
    collect_from(course, "björn", "Participant_311", "311")
    # A team of two: its number, 313, is not the participant number of either student.
    for student in ("mary jane", "cmd"):
        collect_from(course, student, "Participant_313", "313")
    moodle_site = moodle_course(blind=True)
    exported = fill_file(moodle_site, marks())
    moodle_site.import_(exported.content, ignore_modified=True)
    assert moodle_site.grades == {311: 31.25, 312: 8.5, 315: 44.0}
    assert [sentence.partition(" (")[0] for sentence in exported.failures] == ["mary jane", "cmd"]


def test_a_participant_number_is_not_taken_for_an_lms_id(fill_file):
    """Participant numbers differ between assignments, so an lms_id may match one by chance."""
    other = Person("x", "Xaver", "Unbekannt", lms_id="311")
    exported = fill_file(moodle_course(), marks({"x": 50.0}, (other,), excused=()))
    assert exported.mark_count == 0
    assert exported.failures == (
        "x (Xaver Unbekannt), 50 points: the file has no row for this student.",
    )


def test_the_maximum_grade_of_moodle_is_kept(fill_file):
    course = moodle_course()
    course.most, course.grades = 10.0, {}
    with pytest.raises(ExportError, match="'Grade' is worth 10 on the platform"):
        fill_file(course, marks())
    course.import_(fill_file(course, marks(), scale=True).content)
    assert course.grades == {311: 0.85, 312: 3.12, 313: 10.0, 314: 0.0}


def test_an_ambiguous_grade_column_must_be_named(fill_file):
    """If no status is set and all grades are equal, the grades look like a column of maxima."""
    course = moodle_course()
    course.grades = dict.fromkeys(range(311, 317), 10.0)
    for student in course.students:
        student.status = ""
    with pytest.raises(ExportError, match="with --column; the columns are: 'Status', 'Grade'"):
        fill_file(course, marks())
    course.import_(fill_file(course, marks(), column="Grade").content, ignore_modified=True)
    assert course.grades == {311: 8.5, 312: 31.25, 313: 100.0, 314: 0.0, 315: 10.0, 316: 10.0}


def test_a_site_that_shows_whole_numbers_still_imports_fractions(fill_file):
    course = moodle_course(words=GERMAN, decimal_mark=",")
    course.grades = {}
    course.number = lambda value: "" if value is None else f"{value:.0f}"
    course.import_(fill_file(course, marks()).content)
    assert course.grades[311] == 8.5


# ---- files of other kinds ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "does not contain a table of students"),
        (b"PK\x03\x04\xff\xfe", "is not a CSV file in UTF-8"),
        ("Student,ID\nMüller,1\n".encode("cp1252"), "as CSV UTF-8"),
        (b"a,b\nc,d\n", "is not "),
        (b"Student,ID,SIS Login ID,Section,T (1)\nAnna,1,anna,A,1\n", "no row 'Points Possible'"),
        (b"Student,ID,Section,T (1)\n    Points Possible,,,1\n,,,,,,,5\n", "has 8 cells"),
    ],
)
def test_a_file_of_another_kind_is_refused_with_a_suggestion(tmp_path, content, message):
    path = tmp_path / "x.csv"
    path.write_bytes(content)
    options = ExportOptions(Course(tmp_path), marks(), STAGE, into=path, column="T")
    with pytest.raises(ExportError, match=message):
        export_canvas(options)
    if message == "is not ":
        with pytest.raises(ExportError, match="not an offline grading worksheet"):
            export_moodle(options)


def test_a_long_text_in_a_worksheet_is_read(fill_file):
    course = moodle_course()
    course.comments[311] = "x" * 200_000
    exported = fill_file(course, marks())
    course.import_(exported.content)
    assert len(course.comments[311]) == 200_000
