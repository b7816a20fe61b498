"""Exercises that are switched off, and due dates of lessons, from the gradebook to the tables."""

import csv
import io
import shutil
from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from nbconvert.exporters import NotebookExporter
from nbgrader.converters import Autograde

from grader.classroom.collect.record import FileOrigin, Record, file_time, write_record
from grader.course import paths
from grader.course.deadlines_file import read_deadlines
from grader.course.lessons import find_lesson
from grader.course.nbgrader_settings import make_converter
from grader.course.paths import Course
from grader.grading import _print_student
from grader.judging.verdict import CheckResult, write_verdict
from grader.lms import gradebook
from grader.lms.distribution import distribution_of
from grader.lms.exporters import EXPORTERS, ExportOptions
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.feedback import FeedbackCollector
from grader.lms.feedback_page import feedback_page
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.instructor_notes import counted_lesson_notes, excessive_mark_notes, notes
from grader.lms.nbgrader_plugin import LatePenalties
from grader.lms.report import write_report
from grader.lms.results import AUDITOR, EXCUSED, MARKED, MISSING, WAITING
from grader.lms.results_reader import class_results
from tests.gradebooks import (
    DISTANCE,
    GROUND,
    LATE_PLUGIN,
    STAGE,
    STREAM,
    ignore_progress,
    make_course,
    penalties,
    submit,
    verdicts,
)

pytestmark = pytest.mark.usefixtures("reading_without_fork")

# Ada earns 11.75 and 18.25 points, and Bob 20.75 points in lesson 07.
ROSTER = "id,section,role,Matriculation\nada,A,,007\nbob,B,,=8\nidle,B,,9\naud,A,auditor,10\n"
DUE = f"[{STAGE}]\ndue = 2026-03-01T12:00:00\n"
UTC_DUE = f'timezone = "UTC"\n{DUE}'
SWITCHED_OFF = 'without = ["voxel_grid"]\n'  # 20 of the 30 points of lesson 06


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("rules") / "course")
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)  # 10 % for each day
    (course.root / "roster.csv").write_text(ROSTER)
    grade(course)
    return course.root


@pytest.fixture
def course(entered_root, tmp_path):
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def settings(course, text):
    (course.root / "deadlines.toml").write_text(text)


def grade(course, text=None):
    if text is not None:
        settings(course, text)
    judged = verdicts(course)
    for submission, verdict in judged:
        write_verdict(verdict, submission.verdict_path(course))
    enter_verdicts(course, judged, [STAGE], ignore_progress)


def result(course, student, lesson=GROUND):
    return class_results(course).notebook(student, lesson.name)


def change(course, student, lesson, exercise, **values):
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade(f"test_{exercise}", lesson.name, STAGE, student)
        for name, value in values.items():
            setattr(grade, name, value)
        book.db.commit()


def table(course, format="exercises", assignment=None, **options):
    results = class_results(course)
    exported = EXPORTERS[format].write(ExportOptions(course, results, assignment, **options))
    rows = list(csv.DictReader(io.StringIO(exported.content.decode("utf-8-sig"))))
    return {row.pop("Student"): row for row in rows}


# ---- exercises that are switched off ------------------------------------------------------------


def test_an_exercise_that_is_switched_off_counts_in_neither_scores_nor_maxima(course):
    before = class_results(course)
    settings(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    after = class_results(course)
    assert [
        (mark.score, mark.max_score) for mark in (result(course, "ada"), result(course, "bob"))
    ] == [
        (3.25, 10.0),
        (None, 10.0),
    ]
    assert result(course, "bob").status == MISSING
    assert after.stage("ada", STAGE).max_score == before.stage("ada", STAGE).max_score - 20 == 40
    assert after.stage("ada", STAGE).score == 3.25 + 18.25
    assert result(course, "ada", DISTANCE) == before.notebook("ada", DISTANCE.name)
    assert list(counted_lesson_notes(after).values()) == [
        f"Lessons that count in {STAGE}: 06, 07 (40 points in total, without voxel_grid)."
    ]
    assert distribution_of(GROUND, after, []).max_score == 10
    settings(course, f"[{STAGE}]\n")
    assert class_results(course) == before


def test_switching_off_an_exercise_changes_nothing_in_the_gradebook(course):
    change(course, "ada", GROUND, "voxel_grid", manual_score=20.0)
    marks = (course.root / "marks.jsonl").read_text()
    grade(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    with gradebook.open_gradebook(course) as book:
        row = book.find_grade("test_voxel_grid", GROUND.name, STAGE, "ada")
        assert (row.manual_score, row.score, row.max_score) == (20.0, 20.0, 20.0)
    settings(course, "")
    assert result(course, "ada").score == 23.25
    assert (course.root / "marks.jsonl").read_text().startswith(marks)


def test_marks_by_hand_and_waiting_answers_do_not_count_in_an_exercise_that_is_off(course):
    change(course, "ada", GROUND, "voxel_grid", manual_score=25.0, needs_manual_grade=True)
    assert result(course, "ada").status == WAITING
    assert len(list(excessive_mark_notes(class_results(course)))) == 1
    settings(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    assert (result(course, "ada").status, result(course, "ada").score) == (MARKED, 3.25)
    assert list(excessive_mark_notes(class_results(course))) == []
    change(course, "ada", GROUND, "filter_ground", manual_score=9.0, needs_manual_grade=True)
    assert (result(course, "ada").status, result(course, "ada").score) == (WAITING, 9.0)


def test_a_mark_by_hand_for_an_exercise_that_is_off_is_not_a_mark_for_missing_work(course):
    change(course, "bob", GROUND, "voxel_grid", manual_score=12.0)
    assert result(course, "bob").status == MARKED
    settings(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    assert (result(course, "bob").status, result(course, "bob").score) == (MISSING, None)


def test_late_penalties_ignore_exercises_that_are_off(course):
    for student in ("ada", "bob"):
        path = course.submitted / student / STAGE / "timestamp.txt"
        path.write_text("2026-03-01 13:00:00 UTC")
    grade(course, UTC_DUE)
    assert penalties(course) == {"ada": pytest.approx(3.0), "bob": pytest.approx(2.075)}
    grade(course, UTC_DUE + SWITCHED_OFF)
    assert penalties(course) == {"ada": pytest.approx(0.325 + 1.825), "bob": pytest.approx(2.075)}
    marks = collect_marks(ExportOptions(course, class_results(course), GROUND.name)).marks
    assert [(mark.person.id, mark.points) for mark in marks] == [("ada", pytest.approx(2.925))]
    grade(course, UTC_DUE)
    assert penalties(course) == {"ada": pytest.approx(3.0), "bob": pytest.approx(2.075)}


def test_a_penalty_is_never_more_than_the_points_that_count(course):
    everything = LATE_PLUGIN.replace("percent = 10", "percent = 100")
    assert everything != LATE_PLUGIN
    (course.root / "nbgrader_config.py").write_text(everything)
    (course.submitted / "ada" / STAGE / "timestamp.txt").write_text("2026-03-01 13:00:00 UTC")
    grade(course, UTC_DUE + SWITCHED_OFF)
    assert result(course, "ada").penalty == 3.25 and result(course, "ada").points == 0


def test_excused_students_and_auditors_keep_their_status(course):
    submit(course, "aud", GROUND)
    settings(course, f'[{STAGE}]\n{SWITCHED_OFF}[{STAGE}.students]\nada = "excused"\n')
    assert [result(course, id).status for id in ("ada", "bob", "idle", "aud")] == [
        EXCUSED,
        MISSING,
        MISSING,
        AUDITOR,
    ]


def test_feedback_says_that_an_exercise_does_not_count(course):
    settings(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    writer = FeedbackCollector(course, STAGE)
    (ada,) = writer.people(["ada"])
    page = feedback_page(writer.feedback(ada))
    assert "21.5 of 40 points" in page and "3.25 of 10" in page
    assert page.count("does not count") == 2  # in the overview and in the heading
    assert "8.5 of 20" not in page


def test_the_report_shows_the_settings_in_its_head(course):
    text = f"drop_lowest = 1\npass_mark = 40\n{UTC_DUE}"
    settings(course, text.replace('timezone = "UTC"\n', "") + SWITCHED_OFF)
    page = write_report(course, verdicts(course), class_results(course)).read_text("utf-8")
    head = page[: page.index("<table")]
    for phrase in (
        "06, 07 (40 points in total, without voxel_grid)",
        "totals leave out each student&#39;s lowest lesson; pass mark 40 %",
        "<b>Pass mark:</b> 40 % of the possible points; reached by 2 of 3 students.",
        f"{STAGE} due 2026-03-01 12:00",
        "for 2 students with a mark. 1 auditor does not count.",
    ):
        assert phrase in head, phrase
    assert "Total: 18.25 of 30 points" not in page and "18.3 of 30 points (60.8 %)" in page


def test_the_judges_points_leave_out_an_exercise_that_is_switched_off(course, capsys):
    """Ada earns 8.5 of 20 points in `voxel_grid`, and 3.25 of the other 10 points."""
    settings(course, f"[{STAGE}]\n{SWITCHED_OFF}")
    judged, results = verdicts(course), class_results(course)
    check = CheckResult("a", "Keeps all points", True, 8.5, 20.0, "", False)
    judged = [
        (
            submission,
            replace(
                verdict, exercises=tuple(replace(e, tests=(check,)) for e in verdict.exercises)
            ),
        )
        for submission, verdict in judged
    ]
    page = write_report(course, judged, results).read_text("utf-8")
    assert f"{GROUND.name}: 3.3 of 10 points from the judge" in page
    assert "(voxel_grid, hidden, does not count)" in page and "(voxel_grid, hidden)" not in page
    _print_student(course, "ada", [pair for pair in judged if pair[0].student == "ada"], results)
    output = " ".join(capsys.readouterr().out.split())
    assert "voxel_grid: 8.5 of 20 points (switched off: does not count)" in output
    assert f"{GROUND.name}: 3.25 of 10 points" in output


# ---- marks by exercise --------------------------------------------------------------------------


def test_marks_by_exercise_have_one_row_for_each_student_and_one_column_for_each_exercise(course):
    change(course, "ada", GROUND, "voxel_grid", manual_score=19.5)
    change(course, "ada", DISTANCE, "crop_region", needs_manual_grade=True)
    rows = table(course)
    columns = ["06 filter_ground", "06 voxel_grid", "07 filter_by_distance", "07 crop_region"]
    columns += ["07 remove_ego_returns"]
    assert list(rows["ada"])[-5:] == columns
    values = {id: [row[column] for column in columns] for id, row in rows.items()}
    assert values == {
        "out of": ["10", "20", "20", "5", "5"],
        "ada": ["3.25", "19.5", "11.75", "", "4.5"],  # crop_region waits for a grader
        "bob": ["", "", "19.5", "0", "1.25"],
        "idle": [""] * 5,
        "aud": [""] * 5,
    }
    assert [rows[id]["Matriculation"] for id in ("ada", "bob")] == ["007", "'=8"]


def test_marks_by_exercise_omit_lessons_and_exercises_that_do_not_count(course):
    submit(course, "aud", GROUND)
    settings(
        course, f'[{STAGE}]\nlessons = ["06"]\n{SWITCHED_OFF}[{STAGE}.students]\nbob = "excused"\n'
    )
    rows = table(course)
    assert [list(row)[-1] for row in rows.values()] == ["06 filter_ground"] * 5
    assert not any("07" in title or "voxel" in title for title in rows["ada"])
    assert [row["06 filter_ground"] for row in rows.values()] == ["10", "3.25", "", "", ""]
    settings(course, "")
    assert list(table(course, assignment=GROUND.name)["ada"])[-1] == "06 voxel_grid"


def test_additional_roster_columns_pass_through_to_scores_csv(course):
    rows = table(course, "csv")
    assert [row["Matriculation"] for row in rows.values()] == ["", "007", "'=8", "9", "10"]
    titles = list(rows["ada"])
    assert titles[titles.index("Section") + 1] == "Matriculation" and titles[-1] == "Out of"


# ---- due dates of lessons -----------------------------------------------------------------------

LESSON_DATE = f"[{GROUND.name}]\ndue = 2026-02-22T12:00:00\n"


def submitted_at(course, student, by_hand="", **times):
    """Record when a student's lessons were collected, as `collect` does."""
    folder = course.submitted / student / STAGE
    names = {"ground": GROUND.name, "distance": DISTANCE.name}
    files = {
        f"{names[lesson]}.ipynb": FileOrigin("0", "a.zip: ada/x", "", when=f"{time}+00:00")
        for lesson, time in times.items()
    }
    latest = max(datetime.fromisoformat(origin.when) for origin in files.values())
    write_record(Record(files, written=latest.isoformat()), folder)
    text = by_hand or f"{latest:%Y-%m-%d %H:%M:%S} UTC"
    (folder / "timestamp.txt").write_text(text)


def lost_percentages(course, text):
    """Grade with the settings, and return the share that each lesson loses, in per cent."""
    grade(course, text)
    return {
        (notebook.student, notebook.lesson[:2]): round(100 * notebook.penalty / notebook.score, 6)
        for notebook in class_results(course).notebooks
        if notebook.penalty
    }


def test_each_lesson_is_late_by_its_own_date_and_time(course):
    submitted_at(course, "ada", ground="2026-02-22T11:00:00", distance="2026-03-02T13:00:00")
    submitted_at(course, "bob", distance="2026-03-01T11:00:00")
    assert lost_percentages(course, UTC_DUE) == {("ada", "06"): 20, ("ada", "07"): 20}
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {("ada", "07"): 20}
    stage = class_results(course).stage("ada", STAGE)
    assert (stage.late, stage.penalty) == (timedelta(hours=25), pytest.approx(3.65))
    assert result(course, "ada").submitted_at == datetime(2026, 2, 22, 11, tzinfo=UTC)
    assert result(course, "ada").due == datetime(2026, 2, 22, 12, tzinfo=UTC)
    submitted_at(course, "ada", ground="2026-02-22T12:00:01", distance="2026-02-28T13:00:00")
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {("ada", "06"): 10}
    assert class_results(course).stage("ada", STAGE).late == timedelta(seconds=1)
    assert list(notes(course, class_results(course), read_deadlines(course))) == []


def test_a_lesson_with_a_later_date_does_not_make_the_others_late(course):
    submitted_at(course, "ada", ground="2026-03-08T11:00:00", distance="2026-02-28T13:00:00")
    later = LESSON_DATE.replace("2026-02-22", "2026-03-08")
    assert lost_percentages(course, UTC_DUE) == {("ada", "06"): 70, ("ada", "07"): 70}
    assert lost_percentages(course, UTC_DUE + later) == {}


def test_a_lesson_may_be_due_in_a_stage_without_a_date(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-03-02T13:00:00")
    assert lost_percentages(course, f'timezone = "UTC"\n{LESSON_DATE}') == {("ada", "06"): 10}
    assert lost_percentages(course, "") == {}


def test_an_extension_also_applies_to_lessons(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-02-24T13:00:00")
    extension = f"[{STAGE}.students]\nada = 2026-03-03T12:00:00\n"
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {("ada", "06"): 10}
    assert lost_percentages(course, UTC_DUE + extension + LESSON_DATE) == {}
    own = f"[{GROUND.name}.students]\nada = 2026-02-23T11:00:00\n"
    assert lost_percentages(course, UTC_DUE + LESSON_DATE + own) == {}
    section = f"[{GROUND.name}.sections]\nA = 2026-02-23T10:00:00\n"
    assert lost_percentages(course, UTC_DUE + LESSON_DATE + section) == {("ada", "06"): 10}
    with gradebook.open_gradebook(course) as book:
        book.grant_extension(STAGE, "ada", days=1)
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {}


def test_an_extension_of_a_date_that_is_only_in_the_gradebook_applies_to_lessons(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-02-24T13:00:00")
    with gradebook.open_gradebook(course) as book:
        book.update_or_create_assignment(STAGE, duedate="2026-02-22 12:00:00")
    own = f'timezone = "UTC"\n{LESSON_DATE}'
    assert lost_percentages(course, own) == {("ada", "06"): 10, ("ada", "07"): 30}
    with gradebook.open_gradebook(course) as book:
        book.grant_extension(STAGE, "ada", days=3)
    assert lost_percentages(course, own) == {}
    assert result(course, "ada").due == datetime(2026, 2, 25, 12, tzinfo=UTC)


def test_a_time_written_by_hand_applies_to_all_lessons_and_is_reported(course):
    submitted_at(
        course,
        "ada",
        by_hand="2026-02-25 12:00:00 UTC",
        ground="2026-02-22T11:00:00",
        distance="2026-02-28T13:00:00",
    )
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {("ada", "06"): 30}
    (note,) = notes(course, class_results(course), read_deadlines(course))
    assert note.startswith(f"{STAGE}: lessons have their own due dates, but only the time of the")
    assert "known for ada, so" in note
    assert file_time(course.submitted / "ada" / STAGE / f"{GROUND.name}.ipynb") is None


def test_an_unknown_time_costs_no_points(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-03-02T13:00:00")
    (course.submitted / "ada" / STAGE / "timestamp.txt").write_text("Tuesday")
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {}
    assert "Tuesday" in class_results(course).stage("ada", STAGE).undecided
    grade(course, f'timezone = "UTC"\n{LESSON_DATE}')
    assert "Tuesday" in class_results(course).stage("ada", STAGE).undecided


def test_a_missing_lesson_and_an_excused_student_are_not_late(course):
    submitted_at(course, "bob", distance="2026-02-28T13:00:00")
    assert lost_percentages(course, UTC_DUE + LESSON_DATE) == {}
    assert (
        result(course, "bob").late == timedelta() == class_results(course).stage("bob", STAGE).late
    )
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-02-23T11:00:00")
    excused = f'[{STAGE}.students]\nada = "excused"\n'
    grade(course, UTC_DUE + excused + LESSON_DATE)
    assert not result(course, "ada").counts


def test_feedback_names_the_date_of_each_lesson(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-02-28T13:00:00")
    grade(course, UTC_DUE + LESSON_DATE)
    writer = FeedbackCollector(course, STAGE)
    page = feedback_page(writer.feedback(writer.people(["ada"])[0]))
    assert (
        f"{GROUND.name}: Submitted 23 hours late, on 23 February 2026 at 11:00 UTC. It was due on "
        "22 February 2026 at 12:00 UTC." in page
    )
    assert f"{DISTANCE.name}: Submitted on time, on 28 February 2026 at 13:00 UTC." in page


def test_nbgrader_subtracts_the_same_penalty(course):
    submitted_at(course, "ada", ground="2026-02-23T11:00:00", distance="2026-03-02T13:00:00")
    assert lost_percentages(course, UTC_DUE + SWITCHED_OFF + LESSON_DATE) == {
        ("ada", "06"): 10,
        ("ada", "07"): 20,
    }
    before = penalties(course)
    with gradebook.open_gradebook(course) as book:
        for lesson in (GROUND, DISTANCE):
            notebook = book.find_submission_notebook(lesson.name, STAGE, "ada")
            notebook.late_submission_penalty = None
        book.db.commit()
    assert penalties(course) == {}
    plugin = {"plugin_class": "grader.lms.late.PercentPerDay"}
    converter = make_converter(Autograde, course.root, STAGE, AssignLatePenalties=plugin)
    step = LatePenalties(parent=NotebookExporter(parent=converter, config=converter.config))
    names = {"assignment": STAGE, "student": "ada", "db_url": converter.coursedir.db_url}
    for lesson in (GROUND, DISTANCE):
        step.preprocess(None, {"nbgrader": {**names, "notebook": lesson.name}})
    assert penalties(course) == {id: pytest.approx(points) for id, points in before.items()}


def test_a_lesson_that_is_released_later_has_a_date_but_no_effect_yet(course):
    text = UTC_DUE + f"[{STREAM.name}]\ndue = 2026-05-01T12:00:00\n[08_bounding_boxes]\n"
    settings(course, text + "due = 2026-04-01T12:00:00\n")
    results = class_results(course)
    assert find_lesson("08_bounding_boxes").name not in results.lessons
    assert STREAM.name not in results.lessons
    assert results.stage("ada", STAGE).max_score == 60
