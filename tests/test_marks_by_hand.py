"""Graders' marks and comments survive the loss of the gradebook, and wrong ones are reported."""

import dataclasses
import json
import shutil

import pytest
from nbgrader.api import Comment, Grade, GradeCell, SolutionCell, SourceCell

from grader.classroom.submissions import find_submissions
from grader.course import paths
from grader.course.kept_answers import fill_in
from grader.course.paths import Course
from grader.lms import gradebook
from grader.lms.exporters import EXPORTERS, ExportOptions
from grader.lms.exporters.assignment_marks import collect_marks
from grader.lms.gradebook_check import check_gradebook
from grader.lms.gradebook_writer import GradebookError, enter_verdicts
from grader.lms.instructor_notes import notes
from grader.lms.mark_history import read_changes
from grader.lms.report import write_report
from grader.lms.results import WAITING
from grader.lms.results_reader import class_results
from tests.gradebooks import LATE_PLUGIN, STREAM, ignore_progress, verdict_on

STAGE, LESSON = STREAM.stage, STREAM.name
MACHINE, *_ = STREAM.machine_graded
POINTS = 1.25


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = Course(tmp_path_factory.mktemp("by_hand") / "course")
    (course.released / STAGE).mkdir(parents=True)
    shutil.copy(STREAM.released, course.released / STAGE)
    paths._folder.cache_clear()
    for student in ("ada", "bob"):
        write_answer(course, student, f"{student} finds 14 of 17 cars.")
    enter_class(course)
    return course.root


@pytest.fixture
def course(entered_root, tmp_path):
    """Return a course whose two students wait for a person to read an answer."""
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def write_answer(course, student, text):
    path = course.submitted / student / STAGE / f"{LESSON}.ipynb"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(fill_in(STREAM, {"write_up": text}), "utf-8")


def enter_class(course, **more):
    """Enter the class, and return the sentences about what was changed."""
    notices = []
    judged = []
    for submission in find_submissions(course):
        verdict = verdict_on(course, submission, [POINTS] * len(STREAM.machine_graded))
        key = f"of {verdict.fingerprint}"
        judged.append((submission, dataclasses.replace(verdict, key=key)))
    enter_verdicts(course, judged, [STAGE], ignore_progress, notify=notices.append, **more)
    return notices


def enter_manual_mark(course, student, cell, points=None, comment=None, extra=None):
    """Enter points and a comment, as Formgrader does."""
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade(cell, LESSON, STAGE, student)
        grade.manual_score, grade.extra_credit, grade.needs_manual_grade = points, extra, False
        if comment is not None:
            cell = cell.removeprefix("test_")
            book.find_comment(cell, LESSON, STAGE, student).manual_comment = comment
        book.db.commit()


def manual_mark(course, student, cell="write_up"):
    """Return the points, whether they wait for a person, and the comment."""
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade(cell, LESSON, STAGE, student)
        comment = book.find_comment(cell.removeprefix("test_"), LESSON, STAGE, student)
        return grade.manual_score, bool(grade.needs_manual_grade), comment.manual_comment


def lose_gradebook(course):
    (course.root / "gradebook.db").unlink()


def wrong_findings(course):
    return [finding.text for finding in check_gradebook(course) if not finding.is_good]


def test_marks_and_comments_of_a_lost_gradebook_are_reported_and_restored(course):
    enter_manual_mark(course, "ada", "write_up", 7.5, "Which 3 cars?\n“Why?”")
    enter_manual_mark(course, "bob", "write_up", 0.0)
    enter_manual_mark(course, "bob", MACHINE.cell, 2.0, "Nearly.", extra=0.5)
    assert enter_class(course) == [] and wrong_findings(course) == []
    lose_gradebook(course)
    message = (
        "marks.jsonl contains 3 marks given by hand and 2 comments that the gradebook "
        f"{course.root / 'gradebook.db'} does not contain: "
        f"write_up in {LESSON} for ada, bob; {MACHINE.name} in {LESSON} for bob. "
    )
    (finding,) = wrong_findings(course)  # also before the next run of `grade`
    assert finding.startswith(message) and "--restore-marks" in finding
    for _ in range(2):  # the sentence does not depend on what the first run logs
        with pytest.raises(GradebookError) as trouble:
            enter_class(course)
        assert str(trouble.value).splitlines()[1].startswith(message)
    assert manual_mark(course, "ada") == (None, True, None)
    (notice,) = enter_class(course, restore=True)
    assert notice.startswith("Restored from marks.jsonl: ")
    assert manual_mark(course, "ada") == (7.5, False, "Which 3 cars?\n“Why?”")
    assert manual_mark(course, "bob") == (0.0, False, None)
    assert manual_mark(course, "bob", MACHINE.cell) == (2.0, False, "Nearly.")
    points = POINTS * len(STREAM.machine_graded)
    scores = {result.student: result.score for result in class_results(course).notebooks}
    assert scores == {"ada": 7.5 + points, "bob": 2.5 - POINTS + points}
    assert enter_class(course, restore=True) == [] and wrong_findings(course) == []


def test_a_restored_mark_of_a_changed_answer_waits_for_a_person(course):
    enter_manual_mark(course, "ada", "write_up", 7.5)
    enter_manual_mark(course, "bob", "write_up", 6.5)
    enter_class(course)
    write_answer(course, "ada", "ada finds 15 of 17 cars.")
    lose_gradebook(course)
    restored, waiting = enter_class(course, restore=True)
    assert waiting.startswith("Review these marks") and waiting.endswith("for ada.")
    assert (manual_mark(course, "ada"), manual_mark(course, "bob")) == (
        (7.5, True, None),
        (6.5, False, None),
    )
    enter_manual_mark(course, "ada", "write_up", 7.5)  # the same points for the new answer
    enter_class(course)
    lose_gradebook(course)
    assert len(enter_class(course, restore=True)) == 1
    assert manual_mark(course, "ada") == (7.5, False, None)


def test_a_mark_logged_without_the_graded_answer_waits_for_a_person(course):
    enter_manual_mark(course, "ada", "write_up", 7.5)
    enter_class(course)
    path = course.root / "marks.jsonl"
    lines = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
    old = [{name: line[name] for name in line if name != "graded"} for line in lines]
    path.write_text("".join(json.dumps(line) + "\n" for line in old))
    lose_gradebook(course)
    assert len(enter_class(course, restore=True)) == 2
    assert manual_mark(course, "ada") == (7.5, True, None)


def test_marks_that_a_person_removed_are_not_restored(course):
    enter_manual_mark(course, "ada", "write_up", 7.5, "Good.")
    enter_class(course)
    enter_manual_mark(course, "ada", "write_up", None, "")
    enter_class(course)
    lose_gradebook(course)
    assert enter_class(course) == [] and wrong_findings(course) == []


def test_restoring_does_not_replace_existing_marks(course):
    enter_manual_mark(course, "ada", "write_up", 7.5, "Good.")
    enter_class(course)
    lose_gradebook(course)
    with pytest.raises(GradebookError):
        enter_class(course)
    enter_manual_mark(course, "ada", "write_up", 3.0)
    with pytest.raises(GradebookError, match="1 comment that the gradebook"):
        enter_class(course)
    enter_class(course, restore=True)
    assert manual_mark(course, "ada") == (3.0, False, "Good.")


def test_a_restored_mark_has_its_late_penalty(course):
    (course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    (course.root / "deadlines.toml").write_text(
        f'timezone = "UTC"\n[{STAGE}]\ndue = 2026-03-01T12:00:00\n'
    )
    (course.submitted / "ada" / STAGE / "timestamp.txt").write_text("2026-03-01 13:00:00 UTC")
    enter_manual_mark(course, "ada", "write_up", 7.5)
    enter_class(course)
    lose_gradebook(course)
    enter_class(course, restore=True)
    (mark,) = [mark for mark in class_results(course).notebooks if mark.student == "ada"]
    assert mark.penalty == pytest.approx((7.5 + POINTS * len(STREAM.machine_graded)) / 10)


def test_comments_are_logged_once(course):
    before = len(list(read_changes(course)))
    enter_manual_mark(course, "ada", "write_up", 7.5, "Good.")
    enter_class(course)
    enter_class(course)
    (change,) = list(read_changes(course))[before:]
    assert (change.exercise, change.after, change.by, change.comment) == (
        *("write_up", 7.5, "a person", "Good."),
    )
    enter_manual_mark(course, "ada", "write_up", 7.5, "Very good.")
    enter_class(course)
    *_, change = read_changes(course)
    assert (change.before, change.after, change.comment) == (7.5, 7.5, "Very good.")


def forget_cells(course, *names):
    """Remove cells from the gradebook, as if the release had not contained them yet."""
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_notebook(LESSON, STAGE)
        for cell in (*notebook._base_cells, *notebook.source_cells):
            if cell.name in names:
                for table in (Grade, Comment):
                    book.db.query(table).filter(table.cell_id == cell.id).delete()
                book.db.delete(cell)
        book.db.commit()


def test_an_exercise_that_is_added_during_the_term_is_entered(course):
    """nbgrader refuses to add cells to a lesson with submissions."""
    enter_manual_mark(course, "ada", "write_up", 7.5, "Good.")
    enter_class(course)
    forget_cells(course, MACHINE.cell, MACHINE.name)
    (notice,) = enter_class(course)
    assert notice.startswith(f"{LESSON}: {MACHINE.name} was added to the gradebook")
    assert manual_mark(course, "ada") == (7.5, False, "Good.")
    points = POINTS * len(STREAM.machine_graded)
    scores = {result.student: result.score for result in class_results(course).notebooks}
    assert scores == {"ada": 7.5 + points, "bob": points}
    assert enter_class(course) == []


def declare_team(course, *ids):
    lines = [json.dumps({"student": id, "stage": STAGE, "label": "a" * 64}) + "\n" for id in ids]
    (course.submitted / ".whose.jsonl").write_text("".join(lines))


def test_a_teams_written_answer_is_graded_once(course):
    for student in ("ada", "bob", "cy"):
        write_answer(course, student, "We find 14 of 17 cars.")
    write_answer(course, "dee", "I find 15 of 17 cars.")
    assert enter_class(course) == []
    declare_team(course, "ada", "bob", "dee")
    enter_manual_mark(course, "ada", "write_up", 7.5, "Which 3 cars?", extra=0.5)
    (notice,) = enter_class(course)
    assert notice == f"Entered a team's mark for its other members: write_up in {LESSON} for bob."
    assert manual_mark(course, "bob") == (7.5, False, "Which 3 cars?")
    assert manual_mark(course, "cy")[:2] == (None, True), "not a member"
    assert manual_mark(course, "dee")[:2] == (None, True), "a member with another answer"
    assert enter_class(course) == []
    enter_manual_mark(course, "bob", "write_up", 6.0)  # a member may have a different mark
    assert enter_class(course) == []
    assert manual_mark(course, "ada")[0] == 7.5 and manual_mark(course, "bob")[0] == 6.0
    scores = {result.student: result.score for result in class_results(course).notebooks}
    points = POINTS * len(STREAM.machine_graded)
    assert scores["ada"] == 8.0 + points and wrong_findings(course) == []


def test_different_marks_of_team_members_are_not_copied(course):
    for student in ("ada", "bob", "cy"):
        write_answer(course, student, "We find 14 of 17 cars.")
    enter_class(course)
    declare_team(course, "ada", "bob", "cy")
    enter_manual_mark(course, "ada", "write_up", 7.5)
    enter_manual_mark(course, "bob", "write_up", 6.0)
    assert enter_class(course) == []
    assert manual_mark(course, "cy")[:2] == (None, True)


def test_a_written_answer_that_is_added_during_the_term_waits_for_a_person(course):
    forget_cells(course, "write_up")
    assert len(enter_class(course)) == 1
    assert {result.status for result in class_results(course).notebooks} == {WAITING}
    assert manual_mark(course, "ada") == manual_mark(course, "bob") == (None, True, None)


def test_a_lesson_that_is_added_during_the_term_is_entered(course):
    with gradebook.open_gradebook(course) as book:
        for submission in book.find_assignment(STAGE).submissions:
            for notebook in submission.notebooks:
                for row in (*notebook.grades, *notebook.comments, notebook):
                    book.db.delete(row)
        book.db.commit()
        book.remove_notebook(LESSON, STAGE)
    enter_class(course)
    assert {result.status for result in class_results(course).notebooks} == {WAITING}


def test_an_exercise_that_is_no_longer_in_the_release_is_removed(course):
    enter_manual_mark(course, "ada", "write_up", 7.5, "Good.")
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_notebook(LESSON, STAGE)
        cells = [
            GradeCell(name="essay", cell_type="markdown", max_score=4.0, notebook=notebook),
            SolutionCell(name="essay", notebook=notebook),
            SourceCell(name="essay", cell_type="markdown", source="", notebook=notebook),
        ]
        book.db.add_all(cells)
        book.db.flush()
        for student in ("ada", "bob"):
            submitted = book.find_submission_notebook(LESSON, STAGE, student)
            book.db.add(Grade(cell_id=cells[0].id, notebook=submitted, manual_score=3.5))
            book.db.add(Comment(cell_id=cells[1].id, notebook=submitted))
        book.db.commit()
    (notice,) = enter_class(course)
    assert "essay is no longer in the release" in notice
    assert "Only marks.jsonl still contains its 2 marks given by hand" in notice
    assert manual_mark(course, "ada") == (7.5, False, "Good.")
    assert [change.after for change in read_changes(course) if change.exercise == "essay"] == [
        *(3.5, 3.5, None, None),
    ]
    assert enter_class(course) == [] and wrong_findings(course) == []


def test_a_changed_maximum_of_an_exercise_with_marks_by_hand_is_reported(course):
    enter_manual_mark(course, "ada", "write_up", 9.5)
    with gradebook.open_gradebook(course) as book:
        book.find_grade_cell("write_up", LESSON, STAGE).max_score = 20.0
        book.db.commit()
    (notice,) = enter_class(course)
    assert (
        "write_up is now worth 10 points instead of 20, but 1 mark given by hand did not" in notice
    )
    assert enter_class(course) == []


def test_marks_above_a_reduced_maximum_are_listed(course):
    enter_manual_mark(course, "ada", "write_up", 9.5)
    # Extra points may exceed the maximum.
    enter_manual_mark(course, "bob", "write_up", 5.0, extra=3.0)
    assert class_results(course).excessive == ()
    with gradebook.open_gradebook(course) as book:
        book.find_grade_cell("write_up", LESSON, STAGE).max_score = 5.0
        book.db.commit()
    results = class_results(course)
    assert results.excessive == (("ada", f"ada, {LESSON}, write_up: 9.5 of 5 points"),)
    (sentence,) = notes(course, results, None)
    assert sentence.endswith("was reduced after a person graded this answer. Grade it again.")
    assert wrong_findings(course) == [sentence]
    for format in ("csv", "exercises"):
        assert sentence in EXPORTERS[format].write(ExportOptions(course, results)).notes
    marks = collect_marks(ExportOptions(course, results, LESSON, provisional=True))
    assert sentence in marks.notes
    assert sentence in write_report(course, [], results).read_text("utf-8")
