"""Each submission gets the right standing (missing, excused, waiting or marked) and lateness."""

import datetime
import shutil

import pytest

from grader.course import paths
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import find_lesson
from grader.course.paths import Course
from grader.course.roster import Person
from grader.lms import gradebook
from grader.lms.distribution import distribution_of
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.instructor_notes import assignment_notes, counted_lesson_notes
from grader.lms.marks_table import marks_table
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    NotebookResult,
    StageResult,
    combined_status,
)
from grader.lms.results_reader import class_results
from tests.gradebooks import (
    DISTANCE,
    GROUND,
    LATE_PLUGIN,
    STAGE,
    ignore_progress,
    make_course,
    submit,
    verdicts,
)

BOXES = find_lesson("08_bounding_boxes")
ROSTER = (
    "id,first_name,last_name,email,section,lms_id\n"
    "bob,Bob,Bell,bob@x.edu,B,7\n"
    "ada,Ada,Ash,,A,8\n"
    "eve,Eve,Elm,,B,\n"
    "fay,Fay,Fir,,,\n"
)
DATES = f"""
timezone = "UTC"
[{STAGE}]
due = 2026-03-01T12:00:00
[{STAGE}.students]
eve = "excused"
fay = 2026-03-04T12:00:00
"""
ZERO = {"ada": {GROUND: (0.0, 0.0), DISTANCE: (11.75, 2.0, 4.5)}, "bob": {DISTANCE: (19.5, 0, 1)}}


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("standing") / "course")
    enter_verdicts(course, verdicts(course, ZERO), [STAGE], ignore_progress)
    return course.root


@pytest.fixture
def course(entered_root, tmp_path):
    """Return a course in which Ada submitted two lessons, one with a score of 0, and Bob one."""
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def standing(course):
    """Return the standing and score of each notebook by student and number of the lesson."""
    results = class_results(course)
    return {
        (notebook.student, notebook.lesson[:2]): (notebook.status, notebook.score)
        for notebook in results.notebooks
    }


def change(course, student, lesson, **values):
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_submission_notebook(lesson.name, STAGE, student)
        for name, value in values.items():
            setattr(notebook.grades[0], name, value)
        book.db.commit()


def test_the_class_consists_of_all_students_who_submitted_if_there_is_no_roster(course):
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_student("ada", first_name="Ada", last_name="Ash", lms_user_id="8")
        book.update_or_create_student("idle", first_name="Ida")
    results = class_results(course)
    assert results.people == (Person("ada", "Ada", "Ash", lms_id="8"), Person("bob"))
    assert standing(course) == {
        ("ada", "06"): (MARKED, 0.0),
        ("ada", "07"): (MARKED, 18.25),
        ("bob", "06"): (MISSING, None),
        ("bob", "07"): (MARKED, 20.5),
    }
    assert results.unlisted == ()


def test_the_class_has_the_students_and_the_order_of_the_roster(course):
    (course.root / "roster.csv").write_text(ROSTER)
    (course.root / "deadlines.toml").write_text(DATES)
    results = class_results(course)
    assert [person.id for person in results.people] == ["bob", "ada", "eve", "fay"]
    assert results.people[0] == Person("bob", "Bob", "Bell", "bob@x.edu", "B", "7")
    assert standing(course) == {
        ("bob", "06"): (MISSING, None),
        ("bob", "07"): (MARKED, 20.5),
        ("ada", "06"): (MARKED, 0.0),
        ("ada", "07"): (MARKED, 18.25),
        ("eve", "06"): (EXCUSED, None),
        ("eve", "07"): (EXCUSED, None),
        ("fay", "06"): (MISSING, None),
        ("fay", "07"): (MISSING, None),
    }
    assert [
        (stage.student, stage.status, stage.score, stage.max_score) for stage in results.stages
    ] == [
        ("bob", MARKED, 20.5, 60),
        ("ada", MARKED, 18.25, 60),
        ("eve", EXCUSED, None, 60),
        ("fay", MISSING, None, 60),
    ]
    assert results.lessons == {GROUND.name: 30, DISTANCE.name: 30}
    assert results.notebook("ada", GROUND.name).score == 0
    assert results.notebook("nobody", GROUND.name) is results.stage("nobody", STAGE) is None


def test_students_missing_from_the_roster_are_listed_separately(course):
    (course.root / "roster.csv").write_text("id\nbob\n")
    results = class_results(course)
    assert results.unlisted == ("ada",)
    assert {notebook.student for notebook in (*results.notebooks, *results.stages)} == {"bob"}


def test_a_submission_that_needs_manual_grading_waits(course):
    change(course, "ada", GROUND, needs_manual_grade=True)
    assert standing(course)["ada", "06"] == (WAITING, 0.0)
    assert class_results(course).stage("ada", STAGE).status == WAITING


def test_a_submission_that_is_not_in_the_gradebook_waits(course):
    submit(course, "bob", GROUND)
    submit(course, "cleo", DISTANCE)
    assert standing(course)["bob", "06"] == (WAITING, None)
    (course.root / "roster.csv").write_text("id\nbob\ncleo\n")
    assert standing(course)["cleo", "06"] == (MISSING, None)
    assert standing(course)["cleo", "07"] == (WAITING, None)
    assert class_results(course).stage("cleo", STAGE).points is None


def test_a_manual_mark_counts_without_a_submission(course):
    change(course, "bob", GROUND, manual_score=0.0)  # after an oral exam, for example
    assert standing(course)["bob", "06"] == (MARKED, 0.0)
    shutil.rmtree(course.autograded)
    shutil.rmtree(course.submitted)
    assert standing(course) == {
        ("ada", "06"): (MISSING, None),
        ("ada", "07"): (MARKED, 18.25),
        ("bob", "06"): (MARKED, 0.0),
        ("bob", "07"): (MARKED, 20.5),
    }
    change(course, "bob", GROUND, manual_score=None)
    change(course, "ada", GROUND, manual_score=0.0)
    assert standing(course)["ada", "06"] == (MARKED, 0.0)
    assert standing(course)["bob", "06"] == (MISSING, None)


def test_a_manual_change_of_points_is_a_mark_and_a_comment_is_not(course):
    shutil.rmtree(course.autograded)
    shutil.rmtree(course.submitted)
    change(course, "bob", GROUND, extra_credit=-0.5)
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_submission_notebook(GROUND.name, STAGE, "ada")
        notebook.comments[0].manual_comment = "Where is it?"
        book.db.commit()
    assert standing(course)["bob", "06"] == (MARKED, -0.5)
    assert standing(course)["ada", "06"] == (MISSING, None)


def test_the_maximum_does_not_depend_on_the_submissions_of_other_students(course):
    """Bob submitted only lesson 07; Ada's lesson 06 must not lower his share."""
    before = class_results(course).stage("bob", STAGE)
    shutil.rmtree(course.submitted / "ada" / STAGE)
    enter_verdicts(course, verdicts(course, ZERO), [STAGE], ignore_progress)
    assert standing(course) == {("bob", "06"): (MISSING, None), ("bob", "07"): (MARKED, 20.5)}
    assert class_results(course).stage("bob", STAGE) == before
    assert before.max_score == 60


def assign(course, numbers):
    (course.root / "deadlines.toml").write_text(f"[{STAGE}]\nlessons = {numbers}\n")


def test_only_assigned_lessons_count(course):
    assign(course, '["07"]')
    results = class_results(course)
    assert results.lessons == {DISTANCE.name: 30}
    assert [(stage.student, stage.score, stage.max_score) for stage in results.stages] == [
        *(("ada", 18.25, 30), ("bob", 20.5, 30)),
    ]
    assert results.unassigned == (("ada", GROUND.name),)
    assign(course, "[]")
    results = class_results(course)
    assert (results.lessons, results.stages) == ({}, ())
    assert len(results.unassigned) == 3


def test_an_assigned_lesson_counts_even_if_no_student_submitted_it(course):
    assign(course, '["09", "06"]')
    results = class_results(course)
    assert results.lessons == {GROUND.name: 30, "09_filter_clusters": 20}
    assert results.stage("ada", STAGE).max_score == 50


def assignment_advice(course, *stages):
    return list(assignment_notes(class_results(course), read_deadlines(course), stages))


def test_lessons_that_may_not_be_assigned_are_listed(course):
    shutil.copy(BOXES.released, course.released / STAGE)
    without_work = f"{STAGE}: no student submitted {BOXES.name}"
    (sentence,) = assignment_advice(course)
    assert sentence.startswith(f"{without_work}. All") and 'lessons = ["06", "07"]' in sentence
    assert assignment_advice(course, STAGE) == [sentence]
    assert assignment_advice(course, "stage1_ransac") == []
    submit(course, "cleo", DISTANCE)
    (sentence,) = assignment_advice(course)
    assert sentence.startswith(f"{without_work}; only ada submitted {GROUND.name}. All")
    assert f'lessons = ["07"] below [{STAGE}] in deadlines.toml' in sentence
    assign(course, '["06", "07", "08"]')
    assert assignment_advice(course) == []
    assign(course, '["07"]')
    (sentence,) = assignment_advice(course)
    assert sentence.startswith(f"{GROUND.name} does not count for ada")
    assert list(counted_lesson_notes(class_results(course)).values()) == [
        f"Lessons that count in {STAGE}: 07 (30 points in total)."
    ]


def test_auditors_are_not_missing_and_do_not_count(course):
    (course.root / "roster.csv").write_text("id,role\nbob,Auditor\nada,student\nidle,auditor\n")
    assert {key: value[0] for key, value in standing(course).items()} == {
        ("bob", "06"): AUDITOR,
        ("bob", "07"): AUDITOR,
        ("ada", "06"): MARKED,
        ("ada", "07"): MARKED,
        ("idle", "06"): AUDITOR,
        ("idle", "07"): AUDITOR,
    }
    results = class_results(course)
    assert {result.student for result in results.notebooks if result.counts} == {"ada"}
    assert results.stage("idle", STAGE).status == AUDITOR
    table = marks_table([GROUND, DISTANCE], results, {})
    assert [[cell.text for cell in (*row.cells, row.total)] for row in table.rows] == [
        ["aud.", "(20.5)", "aud."],
        ["0", "18.3", "18.3 of 60"],
        ["aud.", "aud.", "aud."],
    ]
    distribution = distribution_of(DISTANCE, results, [])
    assert (distribution.count, distribution.mean, distribution.auditors) == (1, 18.25, 2)


def test_excused_work_does_not_count_in_means_and_missing_work_is_not_a_0(course):
    (course.root / "roster.csv").write_text(ROSTER)
    (course.root / "deadlines.toml").write_text(DATES + 'bob = "excused"\n')
    results = class_results(course)
    distribution = distribution_of(DISTANCE, results, [])
    assert (distribution.count, distribution.mean, distribution.excused) == (1, 18.25, 2)
    sums = {row.person.id: row.total.text for row in marks_table([GROUND], results, {}).rows}
    assert sums == {"bob": "exc.", "ada": "0 of 30", "eve": "exc.", "fay": "–"}


def test_a_stage_has_times_and_late_penalties(course):
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    (course.root / "roster.csv").write_text(ROSTER)
    (course.submitted / "ada" / STAGE / "timestamp.txt").write_text("2026-03-02 13:30:00 CET")
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-03-01 12:00:00")
    enter_verdicts(course, verdicts(course, ZERO), [STAGE], ignore_progress)
    stage = class_results(course).stage("ada", STAGE)
    assert stage == StageResult(
        "ada",
        STAGE,
        MARKED,
        score=18.25,
        max_score=60,
        penalty=pytest.approx(3.65),  # 24.5 hours late: two days have begun, with 10 % for each
        submitted_at=datetime.datetime(2026, 3, 2, 12, 30, tzinfo=datetime.UTC),
        due=datetime.datetime(2026, 3, 1, 12, tzinfo=datetime.UTC),
        late=datetime.timedelta(hours=24, minutes=30),
    )
    assert stage.points == pytest.approx(14.6)
    on_time = class_results(course).stage("bob", STAGE)
    assert (on_time.submitted_at, on_time.late, on_time.penalty) == (None, datetime.timedelta(), 0)


def test_a_student_without_a_submission_has_a_due_date(course):
    (course.root / "roster.csv").write_text(ROSTER)
    (course.root / "deadlines.toml").write_text(DATES)
    results = class_results(course)
    assert results.stage("fay", STAGE).due == datetime.datetime(2026, 3, 4, 12, tzinfo=datetime.UTC)
    assert results.stage("fay", STAGE).submitted_at is None


@pytest.mark.parametrize(
    ("standings", "stage"),
    [
        ((MISSING, MISSING), MISSING),
        ((MISSING, MARKED), MARKED),
        ((MARKED, WAITING, MISSING), WAITING),
        ((EXCUSED, EXCUSED), EXCUSED),
    ],
)
def test_the_status_of_a_stage_follows_from_its_lessons(standings, stage):
    lessons = (NotebookResult("a", STAGE, standing, standing, None, 1.0) for standing in standings)
    assert combined_status(lessons) == stage


def test_a_penalty_never_exceeds_the_points():
    assert NotebookResult("a", STAGE, "x", MARKED, 3.0, 30.0, 9.0).points == 0
