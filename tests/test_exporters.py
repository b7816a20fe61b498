"""Exports of marks: the class table, the marks of one assignment, and the names of the files."""

import csv
import dataclasses
import io
import os
from datetime import UTC, datetime, timedelta

import pytest

from grader import cli, commands
from grader.course.paths import Course
from grader.course.roster import Person
from grader.lms import results_reader
from grader.lms.exporters import EXPORTERS, ExportError, ExportOptions
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.exporters.destination import write_export
from grader.lms.results import (
    AUDITOR,
    EXCUSED,
    MARKED,
    MISSING,
    WAITING,
    ClassResults,
    NotebookResult,
    StageResult,
    combined_status,
)
from tests.platforms import Canvas, CanvasStudent

THREE, FOUR = "stage3_obstacles", "stage4_realtime"
SIX, SEVEN, TWELVE = "06_filter_ground", "07_filter_by_distance", "12_streaming_obstacles"
LESSONS = {SIX: (THREE, 30.0), SEVEN: (THREE, 20.0), TWELVE: (FOUR, 40.0)}
ADA = Person("ada", "Ada", "Lovelace", "ada@x.edu", "A")
BO = Person("bo", "Bo", "Bäcker, Jr", "bo@x.edu", "B")
CY, DEE = Person("cy"), Person("dee", "Dee", "")
DUE = datetime(2026, 10, 12, 22, 0, tzinfo=UTC)


def results_of(person, scores, late=None, excused=(), penalty=0.0):
    """Return the notebook and stage results of a student.

    `scores` contains the points, or a status and the points, of each submitted lesson.
    """
    notebooks = []
    for lesson, (stage, most) in LESSONS.items():
        score = scores.get(lesson)
        status = MISSING if score is None else MARKED
        if isinstance(score, tuple):
            status, score = score
        status = EXCUSED if stage in excused else status
        deduction = penalty if status == MARKED else 0.0
        notebooks.append(NotebookResult(person.id, stage, lesson, status, score, most, deduction))
    stages = []
    for stage in (THREE, FOUR):
        in_stage = [notebook for notebook in notebooks if notebook.stage == stage]
        known = [notebook.score for notebook in in_stage if notebook.score is not None]
        submitted = DUE + late if late is not None and known else None
        stages.append(
            StageResult(
                person.id,
                stage,
                combined_status(in_stage),
                sum(known) if known else None,
                sum(notebook.max_score for notebook in in_stage),
                sum(notebook.penalty for notebook in in_stage),
                submitted,
                DUE,
                max(timedelta(), late) if submitted else timedelta(),
            )
        )
    return notebooks, stages


def class_of(*results, people=(ADA, BO, CY, DEE), unlisted=()):
    notebooks, stages = zip(*results, strict=True)
    return ClassResults(tuple(people), sum(notebooks, []), sum(stages, []), tuple(unlisted))


CLASS = class_of(
    results_of(ADA, {SIX: 30.0, SEVEN: 12.345678, TWELVE: (WAITING, 25.0)}, timedelta(hours=-1)),
    results_of(BO, {SIX: 0.0}, timedelta(hours=36), penalty=2.5),
    results_of(CY, {}),
    results_of(DEE, {SEVEN: 8.0}, timedelta(0), excused=(FOUR,)),
)


def table(results, assignment=None):
    exported = EXPORTERS["csv"].write(ExportOptions(Course(), results, assignment))
    return exported, list(csv.reader(io.StringIO(exported.content.decode("utf-8-sig"))))


def test_the_table_contains_names_scores_times_penalties_statuses_and_totals():
    exported, rows = table(CLASS)
    assert rows[0] == [
        *("Student", "Last name", "First name", "E-mail", "Section", SIX, SEVEN),
        *(f"{THREE}: submitted", f"{THREE}: days late"),
        *(f"{THREE}: late penalty", f"{THREE}: status", TWELVE),
        *(f"{FOUR}: submitted", f"{FOUR}: days late"),
        *(f"{FOUR}: late penalty", f"{FOUR}: status", "Total", "Out of"),
    ]
    assert rows[1] == ["out of", *[""] * 4, "30", "20", *[""] * 4, "40", *[""] * 4, "90", "90"]
    early = "2026-10-12 21:00:00 UTC"
    assert rows[2:] == [
        [*("ada", "Lovelace", "Ada", "ada@x.edu", "A", "30", "12.35", early, "0", "0", "marked")]
        + ["25", early, "0", "0", f"waiting: {TWELVE}", "67.35", "90"],
        [*("bo", "Bäcker, Jr", "Bo", "bo@x.edu", "B", "0", "", "2026-10-14 10:00:00 UTC", "1.5")]
        + ["2.5", f"marked; missing: {SEVEN}", "", "", "", "0", "missing", "0", "90"],
        [*("cy", "", "", "", "", "", "", "", "", "0", "missing", "", "", "", "0", "missing")]
        + ["", ""],
        [*("dee", "", "Dee", "", "", "", "8", "2026-10-12 22:00:00 UTC", "0", "0")]
        + [f"marked; missing: {SIX}", "", "", "", "0", "excused", "8", "50"],
    ]
    assert (exported.mark_count, exported.failures) == (3, ())
    by_hand = "Provisional, because some work still has to be graded by hand"
    assert exported.notes == (f"{by_hand}: {TWELVE} for ada.",)


@pytest.mark.parametrize("format", ["csv", "exercises"])
def test_tables_name_work_that_is_not_in_the_gradebook(tmp_path, format):
    results = class_of(results_of(ADA, {SIX: (WAITING, None), SEVEN: 20.0}), people=(ADA,))
    exported = EXPORTERS[format].write(ExportOptions(Course(tmp_path), results))
    assert exported.notes == (f"Submitted, but not in the gradebook yet: {SIX} for ada.",)


def test_the_table_of_a_lesson_contains_only_that_lesson():
    _, rows = table(CLASS, SEVEN)
    assert rows[0][5:7] == [SEVEN, f"{THREE}: submitted"]
    assert [row[-2:] for row in rows[1:]] == [["20", "20"], ["12.35", "20"], ["", ""]] + [
        ["", ""],
        ["8", "20"],
    ]
    column = rows[0].index(f"{THREE}: status")
    assert [row[column] for row in rows[2:]] == ["marked", "missing", "missing", "marked"]
    with pytest.raises(ExportError, match="No student has submitted anything for stage1_ransac"):
        table(CLASS, "stage1_ransac")


def test_totals_of_missing_excused_and_auditing_students_are_empty():
    """In a spreadsheet, a 0 would count in the mean."""
    auditor = dataclasses.replace(CY, role="auditor")
    audited = [
        dataclasses.replace(result, status=AUDITOR)
        for result in results_of(auditor, {SIX: 30.0, SEVEN: 20.0, TWELVE: 40.0})[0]
    ]
    stages = [
        dataclasses.replace(result, status=AUDITOR)
        for result in results_of(auditor, {SIX: 30.0})[1]
    ]
    results = class_of(
        results_of(ADA, {SIX: 0.0}),
        results_of(BO, {SIX: 12.0}, excused=(THREE, FOUR)),
        (audited, stages),
        results_of(DEE, {}),
    )
    rows = table(results)[1]
    assert [row[-2:] for row in rows[2:]] == [["0", "90"], ["", ""], ["", ""], ["", ""]]
    assert rows[0][10] == f"{THREE}: status"
    assert [row[10] for row in rows[2:]] == ["marked; missing: " + SEVEN, EXCUSED, AUDITOR, MISSING]
    found, points = exported_marks(SIX, results)
    assert points == {"ada": 0.0}
    assert "No mark for auditors: cy." in found.notes


def test_a_lesson_has_a_mark_while_another_lesson_of_its_stage_waits():
    results = class_of(results_of(ADA, {SIX: 30.0, SEVEN: (WAITING, 5.0)}), people=(ADA,))
    for lesson, status in ((SIX, "marked"), (SEVEN, f"waiting: {SEVEN}")):
        rows = table(results, lesson)[1]
        assert rows[2][rows[0].index(f"{THREE}: status")] == status


def test_unusual_names_do_not_shift_columns_or_become_formulas():
    names = ["O'Neil, Jr", 'the "quoted"', "=cmd|' /C calc'!A0", "+1", "-1", "@x", "zwei\nZeilen"]
    people = [Person(name, name, name, name, name) for name in names]
    results = class_of(*(results_of(person, {SIX: 1.0}) for person in people), people=people)
    rows = table(results)[1][2:]
    assert [row[5] for row in rows] == ["1"] * len(names)
    for row, name in zip(rows, names, strict=True):
        assert [cell.removeprefix("'") for cell in row[:5]] == [name] * 5
        assert not any(cell.startswith(("=", "+", "-", "@")) for cell in row)


def test_tables_begin_with_a_byte_order_mark_for_excel():
    assert table(CLASS)[0].content.startswith("\ufeffStudent,".encode())


def test_marks_of_students_who_are_not_on_the_roster_are_reported():
    results = class_of(results_of(ADA, {SIX: 1.0}), people=(ADA,), unlisted=("ghost",))
    (note,) = table(results)[0].failures
    (other_note,) = collect_marks(ExportOptions(Course(), results, SIX)).failures
    for sentence in (note, other_note):
        assert sentence.startswith("'ghost' has marks in the gradebook but is not on the roster")


# ---- marks of one assignment ---------------------------------------------------------------------


def exported_marks(assignment, results=CLASS, **options):
    export = collect_marks(ExportOptions(Course(), results, assignment, **options))
    return export, {mark.person.id: mark.points for mark in export.marks}


def test_marks_of_a_stage_are_sums_minus_penalties():
    found, points = exported_marks(THREE)
    assert points == {"ada": pytest.approx(42.345678), "bo": 0.0, "dee": 8.0}
    assert found.max_points == 50.0
    assert "No mark, because nothing was submitted: cy." in found.notes
    zeros = f"Counted as 0, because nothing was submitted: {SIX} for dee; {SEVEN} for bo."
    assert zeros in found.notes


def test_marks_of_a_lesson_are_points_minus_penalties():
    assert exported_marks(SEVEN)[1] == {"ada": pytest.approx(12.345678), "dee": 8.0}
    assert exported_marks(SIX)[1] == {"ada": 30.0, "bo": 0.0}
    penalised = class_of(results_of(BO, {SIX: 10.0}, penalty=2.5), people=(BO,))
    assert exported_marks(SIX, penalised)[1] == {"bo": 7.5}


def test_waiting_marks_are_refused_unless_provisional():
    with pytest.raises(ExportError, match=f"^Not fully graded: {TWELVE} for ada. .*--provisional"):
        exported_marks(FOUR)
    found, points = exported_marks(FOUR, provisional=True)
    assert points == {"ada": 25.0}
    assert (
        f"Provisional, because some work still has to be graded by hand: {TWELVE} for ada."
        in found.notes
    )
    assert "No mark for excused students: dee (Dee)." in found.notes


def test_notebooks_that_are_not_entered_have_no_mark_even_if_provisional():
    results = class_of(results_of(ADA, {SIX: (WAITING, None)}), people=(ADA,))
    with pytest.raises(ExportError) as refused:
        exported_marks(THREE, results)
    assert str(refused.value).startswith(f"Not in the gradebook yet: {SIX} for ada. Run")
    assert "written answers" not in str(refused.value)  # no written answer is waiting
    found, points = exported_marks(THREE, results, provisional=True)
    assert points == {}
    assert "No mark, because the submission is not in the gradebook yet: ada (Ada Lovelace)." in (
        found.notes
    )


def test_marks_with_undecided_lateness_are_listed():
    notebooks, stages = results_of(ADA, {SIX: 1.0})
    why = {THREE: "timestamp.txt is empty"}
    stages = [dataclasses.replace(stage, undecided=why.get(stage.stage, "")) for stage in stages]
    results = ClassResults((ADA,), tuple(notebooks), tuple(stages))
    note = "No penalty subtracted, because the submission time is unknown: ada."
    assert (
        note in exported_marks(THREE, results)[0].notes
        and note in exported_marks(SIX, results)[0].notes
    )
    assert ",unknown," in table(results)[0].content.decode()
    assert note not in exported_marks(THREE)[0].notes


@pytest.mark.parametrize("name", [None, "stage9", ""])
def test_the_error_about_an_unknown_assignment_lists_all(name):
    with pytest.raises(ExportError, match=f"--assignment.*{SIX}, {SEVEN}, .*{THREE}, {FOUR}"):
        exported_marks(name)


# ---- paths of files ------------------------------------------------------------------------------


def test_an_old_export_is_renamed_but_other_files_are_not_overwritten(tmp_path):
    usual = tmp_path / "scores.csv"
    assert write_export(b"1", None, usual, None) == (usual, None)
    assert write_export(b"1", None, usual, None) == (usual, None)
    os.utime(usual, (0, 10_000_000))
    path, before = write_export(b"2", None, usual, None)
    assert path.read_bytes() == b"2" and before.read_bytes() == b"1"
    os.utime(usual, (0, 10_000_000))
    _, third = write_export(b"3", None, usual, None)
    assert third != before and third.read_bytes() == b"2"
    other = tmp_path / "mine.csv"
    other.write_bytes(b"mine")
    with pytest.raises(ExportError, match="already exists"):
        write_export(b"3", other, usual, None)
    with pytest.raises(ExportError, match="is the file named by --into"):
        write_export(b"3", tmp_path / "." / "mine.csv", usual, other)
    assert other.read_bytes() == b"mine"
    folder = tmp_path / "folder"
    folder.mkdir()
    assert write_export(b"3", folder, usual, None)[0] == folder / "scores.csv"
    assert write_export(b"3", tmp_path / "new" / "x.csv", usual, None)[0].read_bytes() == b"3"
    with pytest.raises(ExportError, match="cannot be written"):
        write_export(b"3", other / "x.csv", usual, None)
    assert not list(tmp_path.rglob("*.part"))


# ---- the command ---------------------------------------------------------------------------------


@pytest.fixture
def export(tmp_path, monkeypatch):
    """Return a function that runs the command in an empty course with the class above."""
    monkeypatch.setattr(commands, "Course", lambda: Course(tmp_path))

    def run(*options, results=CLASS):
        monkeypatch.setattr(results_reader, "class_results", lambda course: results)
        return cli.main(["export", *map(str, options)])

    return run


def test_the_command_fills_in_a_gradebook_and_reports_missing_students(export, tmp_path, capsys):
    students = [
        CanvasStudent(1, "Bäcker, Jr, Bo", "", "bo"),
        CanvasStudent(2, "Who, Else", "", "x"),
    ]
    canvas = Canvas(students, {7: ["Stage 3 obstacles", 50.0]})
    given = tmp_path / "given.csv"
    given.write_bytes(canvas.export())
    before = given.read_bytes()
    call = ("--format", "canvas", "--assignment", THREE, "--into", given)
    assert export(*call) == commands.FAULT
    out, err = capsys.readouterr()
    path = tmp_path / f"scores.{THREE}.canvas.csv"
    assert f"{path} contains marks for 1 student." in out and "In Canvas: Grades, Import." in out
    assert (
        "Marks that could not be exported: 2\n"
        "  ada (Ada Lovelace), 42.35 points: the file has no row" in err
    )
    assert given.read_bytes() == before
    canvas.import_(path.read_bytes())
    assert canvas.scores == {(1, 7): 0.0}
    assert export(*call, "--to", given) == commands.USAGE_ERROR
    assert given.read_bytes() == before
    results = class_of(results_of(BO, {SIX: 3.0}), people=(BO,))
    assert export(*call, results=results) == commands.SUCCESS
    assert len(list(tmp_path.glob("scores.*"))) == 2


def test_errors_of_the_command_suggest_a_fix(export, tmp_path, capsys):
    assert export("--format", "moodle", "--assignment", THREE) == commands.USAGE_ERROR
    assert "worksheet of the assignment in Moodle. Name this file" in capsys.readouterr().err
    assert export("--into", tmp_path) == commands.USAGE_ERROR
    assert "Leave out --into" in capsys.readouterr().err
    call = ("--format", "canvas", "--into", tmp_path / "none.csv", "--assignment", THREE)
    assert export(*call) == commands.USAGE_ERROR
    assert "none.csv cannot be read: No such file" in capsys.readouterr().err
    assert export(*call[:4]) == commands.USAGE_ERROR
    assert "--assignment" in capsys.readouterr().err
    lost_gradebook = class_of(results_of(ADA, {SIX: (WAITING, None)}), people=(ADA,))
    for results in (ClassResults((), (), ()), lost_gradebook):
        assert export(results=results) == commands.USAGE_ERROR
        assert "gradebook contains no marks. Run: python -m grader grade" in capsys.readouterr().err


def test_the_table_is_exported_by_default(export, tmp_path):
    assert export() == commands.SUCCESS
    with (tmp_path / "scores.csv").open(newline="", encoding="utf-8-sig") as file:
        totals = {row["Student"]: row["Total"] for row in csv.DictReader(file)}
    assert totals == {"out of": "90", "ada": "67.35", "bo": "0", "cy": "", "dee": "8"}
    assert export("--assignment", SIX) == commands.SUCCESS
    assert (tmp_path / f"scores.{SIX}.csv").is_file()
