"""The gradebook agrees with the verdicts after marks are entered, corrected or withdrawn."""

import dataclasses
import datetime
import functools
import json
import math
import os
import shutil
import sqlite3
from types import SimpleNamespace

import pytest
from nbconvert.exporters import NotebookExporter
from nbgrader.api import GradeCell, MissingEntry, SolutionCell, SourceCell
from nbgrader.converters import Autograde

from grader.classroom.submissions import find_submissions
from grader.course import paths
from grader.course.deadlines import Deadlines
from grader.course.kept_answers import fill_in
from grader.course.nbgrader_settings import make_converter
from grader.course.paths import Course
from grader.judging.verdict import FAILED
from grader.lms import gradebook, gradebook_writer, registration
from grader.lms.differences import differences
from grader.lms.feedback import FeedbackCollector
from grader.lms.gradebook_check import check_gradebook
from grader.lms.gradebook_rows import GradebookRow
from grader.lms.gradebook_writer import GradebookError, enter_verdicts
from grader.lms.nbgrader_plugin import LatePenalties
from grader.lms.penalties import load_late_penalties
from grader.lms.registration import register_stages
from grader.lms.results import MARKED, MISSING, WAITING, GradebookUnavailable
from grader.lms.results_reader import class_results
from grader.lms.stage_entries import StageEntry
from tests.gradebooks import (
    DISTANCE,
    EARNED,
    GROUND,
    LATE_PLUGIN,
    STAGE,
    STREAM,
    ignore_progress,
    inode,
    make_course,
    marks,
    penalties,
    set_due,
    submit,
    verdict_on,
    verdicts,
)

pytestmark = pytest.mark.usefixtures("reading_without_fork")


@pytest.fixture
def course(tmp_path):
    return make_course(tmp_path / "course")


@pytest.fixture(scope="module")
def entered_root(tmp_path_factory):
    course = make_course(tmp_path_factory.mktemp("entered") / "course")
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    return course.root


@pytest.fixture
def entered_course(entered_root, tmp_path):
    """Return a copy of the course whose two students are in the gradebook."""
    shutil.copytree(entered_root, tmp_path / "course")
    paths._folder.cache_clear()
    return Course(tmp_path / "course")


def expected_marks(earned=EARNED):
    """Return the marks that result from the verdicts, with 0 for missing notebooks."""
    return {
        (student, exercise.cell): (score, exercise.points)
        for student, lessons in earned.items()
        for lesson in (GROUND, DISTANCE)
        for exercise, score in zip(
            lesson.machine_graded,
            lessons.get(lesson, [0.0] * len(lesson.machine_graded)),
            strict=True,
        )
    }


# ---- entering -----------------------------------------------------------------------------------


def test_entered_marks_agree_with_the_verdicts(course):
    events = []
    enter_verdicts(course, verdicts(course), [STAGE], lambda *news: events.append(news))
    assert marks(course) == expected_marks()
    assert events == [(1, 2, "ada"), (2, 2, "bob")]
    results = class_results(course)
    assert [
        (notebook.student, notebook.lesson, notebook.score) for notebook in results.notebooks
    ] == [
        ("ada", GROUND.name, 11.75),
        ("ada", DISTANCE.name, 18.25),
        ("bob", GROUND.name, None),  # missing
        ("bob", DISTANCE.name, 20.75),
    ]
    assert {(result.stage, result.max_score) for result in results.notebooks} == {(STAGE, 30.0)}
    assert [result.status for result in results.notebooks] == [MARKED, MARKED, MISSING, MARKED]
    assert penalties(course) == {}


def test_unchanged_marks_are_not_written_again(entered_course):
    before = [inode(entered_course, student) for student in EARNED]
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert [inode(entered_course, student) for student in EARNED] == before


def test_a_new_verdict_replaces_the_marks(entered_course):
    before = inode(entered_course, "bob")
    submit(entered_course, "ada", GROUND, " ")
    earned = EARNED | {"ada": {GROUND: (10.0, 0.25), DISTANCE: (11.75, 2.0, 4.5)}}
    enter_verdicts(entered_course, verdicts(entered_course, earned), [STAGE], ignore_progress)
    assert marks(entered_course) == expected_marks(earned)
    assert inode(entered_course, "bob") == before


def test_failed_verdicts_are_not_entered_and_old_marks_stay(entered_course):
    judged = verdicts(entered_course)
    failed = dataclasses.replace(judged[0][1], status=FAILED, score=0.0)
    submit(entered_course, "bob", DISTANCE, " ")
    earned = EARNED | {"bob": {DISTANCE: (7.0, 1.0, 2.0)}}
    judged = [(judged[0][0], failed), *verdicts(entered_course, earned)[1:]]
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(entered_course, judged, [STAGE], ignore_progress)
    (sentence,) = str(trouble.value).splitlines()[1:]
    path = entered_course.verdicts / "ada" / STAGE / f"{GROUND.name}.json"
    assert sentence == (
        f"ada, {STAGE}: not entered, because the judge failed on {GROUND.name}. "
        f"For the reason, see {path}"
    )
    assert marks(entered_course) == expected_marks(earned)


def test_a_submission_that_this_machine_cannot_judge_is_reported_with_the_reason(entered_course):
    judged = verdicts(entered_course)
    problems = ("Code cell 7 needs Python 3.14 or later.",)
    failed = dataclasses.replace(judged[0][1], status=FAILED, problems=problems)
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(
            entered_course, [(judged[0][0], failed), *judged[1:]], [STAGE], ignore_progress
        )
    (sentence,) = str(trouble.value).splitlines()[1:]
    assert sentence == (
        f"ada, {STAGE}: not entered, because {GROUND.name} was not judged. {problems[0]}"
    )


def test_lone_surrogates_do_not_prevent_entering(course):
    cell = {"cell_type": "code", "source": "x = 1  # \ud83d half", "metadata": {}}
    notebook = {"cells": [cell], "metadata": {"lidar_obstacle_lab": {"lesson": "\ud83d"}}}
    path = course.submitted / "ada" / STAGE / f"{GROUND.name}.ipynb"
    path.write_text(json.dumps(notebook))
    path.rename(path.with_name(f"{GROUND.name} \udce4.ipynb"))
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert marks(course) == expected_marks()
    (copy,) = course.autograded.glob(f"ada/{STAGE}/{GROUND.name}.ipynb")
    assert "\ufffd half" in copy.read_text("utf-8")


def test_a_folder_whose_name_is_not_text_does_not_stop_the_class(course):
    folder = course.submitted / "zo\udce9"
    shutil.copytree(course.submitted / "ada", folder)
    earned = EARNED | {folder.name: EARNED["ada"]}
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(course, verdicts(course, earned), [STAGE], ignore_progress)
    sentences = str(trouble.value).splitlines()[1:]
    assert sentences == [
        f"zo?, {STAGE}: not entered, because the name of the folder in submitted/ is not valid "
        "UTF-8. Rename the folder."
    ]
    assert marks(course) == expected_marks()


def test_a_submission_replaced_after_judging_is_not_entered(entered_course):
    earned = EARNED | {"ada": {GROUND: (0.0, 0.0), DISTANCE: (0.0, 0.0, 0.0)}}
    judged = verdicts(entered_course, earned)
    submit(entered_course, "ada", GROUND, " ")
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(entered_course, judged, [STAGE], ignore_progress)
    (sentence,) = str(trouble.value).splitlines()[1:]
    assert "was replaced after it was judged" in sentence
    assert marks(entered_course) == expected_marks()


def test_an_error_for_one_student_does_not_stop_others_or_leave_partial_marks(course, monkeypatch):
    original, tries = gradebook_writer._save, []

    def fail(notebook, *about):
        original(notebook, *about)
        tries.append(notebook)
        if len(tries) == 2:  # after the first of Ada's two notebooks
            raise ValueError("no")

    monkeypatch.setattr(gradebook_writer, "_save", fail)
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert str(trouble.value).splitlines() == [
        "The gradebook is not complete:",
        f"ada, {STAGE}: ValueError: no",
        f"ada, {STAGE}: not in the gradebook",
    ]
    assert {student for student, _ in marks(course)} == {"bob"}
    assert not (course.autograded / "ada" / STAGE).exists()
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert marks(course) == expected_marks()


def test_ctrl_c_leaves_no_partial_marks(course, monkeypatch):
    def kill(*about):
        raise KeyboardInterrupt

    monkeypatch.setattr(gradebook_writer, "_save", kill)
    with pytest.raises(KeyboardInterrupt):
        enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    assert marks(course) == {}


# ---- differences --------------------------------------------------------------------------------


def differences_in(course, entry=None):
    """Return how the gradebook differs from `entry`, by default from the verdicts on Ada."""
    entry = entry or StageEntry("ada", STAGE, tuple(verdicts(course)[:2]))
    plugin = load_late_penalties(course)
    with gradebook.open_gradebook(course) as book:
        return differences(course, book, entry, plugin, Deadlines({}))


def alter(course, change):
    """Change Ada's submission in the gradebook, as nbgrader or an instructor might."""
    with gradebook.open_gradebook(course) as book:
        change(book.find_submission(STAGE, "ada"))
        book.db.commit()


def grade_of(submission, exercise):
    return next(
        grade
        for notebook in submission.notebooks
        for grade in notebook.grades
        if grade.name == f"test_{exercise}"
    )


def change_score(difference):
    def change(submission):
        grade_of(submission, "voxel_grid").auto_score += difference

    return change


def change_maximum(difference):
    def change(submission):
        grade_of(submission, "voxel_grid").cell.max_score += difference

    return change


def set_penalty(penalty):
    def change(submission):
        (notebook,) = (book for book in submission.notebooks if book.name == GROUND.name)
        notebook.late_submission_penalty = penalty

    return change


def set_time(submission):
    submission.timestamp = datetime.datetime(2026, 3, 1, 12)


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda submission: None, None),
        (change_score(1.0), f"{GROUND.name}: test_voxel_grid has 9.5 points instead of 8.5"),
        (change_score(-0.01), "test_voxel_grid has 8.49 points instead of 8.5"),
        (change_score(1e-9), None),
        (change_maximum(0.01), "test_voxel_grid is worth 20.01 points, not 20.0"),
        (change_maximum(-5), "test_voxel_grid is worth 15.0 points, not 20.0"),
        (
            set_penalty(0.01),
            f"ada, {STAGE}, {GROUND.name}: the gradebook has a different late penalty",
        ),
        (set_penalty(0.0), None),
        (set_time, f"ada, {STAGE}: the gradebook has a different submission time"),
    ],
)
def test_every_difference_is_reported_and_corrected(entered_course, change, message):
    alter(entered_course, change)
    found = differences_in(entered_course)
    assert len(found) == (message is not None)
    assert all(sentence.endswith(message) for sentence in found)
    before = inode(entered_course)
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert differences_in(entered_course) == []
    assert marks(entered_course) == {
        cell: (pytest.approx(score, abs=1e-8), most)
        for cell, (score, most) in expected_marks().items()
    }
    # The maximum of a cell is corrected from the release, without entering students again.
    assert (inode(entered_course) == before) == (message is None or "is worth" in message)


def test_points_for_a_missing_notebook_are_a_difference(entered_course):
    entry = StageEntry("bob", STAGE, tuple(verdicts(entered_course)[2:]))
    assert differences_in(entered_course, entry) == []
    with gradebook.open_gradebook(entered_course) as book:
        grade_of(book.find_submission(STAGE, "bob"), "filter_ground").auto_score = 0.5
        book.db.commit()
    (sentence,) = differences_in(entered_course, entry)
    assert sentence.endswith("test_filter_ground has 0.5 points instead of 0.0")


def test_students_who_are_not_in_the_gradebook_are_listed(entered_course):
    entry = StageEntry("eve", STAGE, ())
    assert differences_in(entered_course, entry) == [f"eve, {STAGE}: not in the gradebook"]
    (submission, verdict), _ = verdicts(entered_course)[:2]
    later = dataclasses.replace(submission, lesson=STREAM)
    other = dataclasses.replace(verdict, lesson=STREAM.name)
    judged = (*verdicts(entered_course)[:2], (later, other))
    assert differences_in(entered_course, StageEntry("ada", STAGE, judged)) == [
        f"ada, {STAGE}, {STREAM.name}: not in the gradebook"
    ]


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    "content", [None, "{", "[]", "{}", '{"metadata": 7}', '{"metadata": {"verdict_key": "x"}}']
)
def test_a_copy_of_another_verdict_is_replaced(entered_course, content):
    path = entered_course.autograded / "ada" / STAGE / f"{DISTANCE.name}.ipynb"
    path.unlink()
    if content is not None:
        path.write_text(content)
    (sentence,) = differences_in(entered_course)
    assert (
        sentence == f"ada, {STAGE}, {DISTANCE.name}: the autograded copy belongs to another verdict"
    )
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert differences_in(entered_course) == []
    assert json.loads(path.read_text())["metadata"]["verdict_key"]


# ---- the release --------------------------------------------------------------------------------


def register(course):
    with gradebook.open_gradebook(course) as book:
        notices = []
        register_stages(course, book, [STAGE], notices.append)
        return notices, {notebook.name for notebook in book.find_assignment(STAGE).notebooks}


def test_only_released_lessons_are_registered(course):
    assert register(course) == ([], {GROUND.name, DISTANCE.name})
    shutil.rmtree(course.released)  # without a release, all lessons of the stage are registered
    _, names = register(course)
    assert len(names) == 4 and "08_bounding_boxes" in names
    assert not (course.root / "notebooks").exists()  # registering does not create a release


def test_a_registered_stage_does_not_prevent_registering_another(course):
    register(course)
    with gradebook.open_gradebook(course) as book:
        register_stages(course, book, [STAGE, "stage1_ransac"])
        assert len(book.find_assignment("stage1_ransac").notebooks) == 3


# Cells that are not in the release, by kind.
EXTRA_CELLS = {
    "source": functools.partial(SourceCell, name="of_old", cell_type="code", source=""),
    "points": functools.partial(GradeCell, name="of_old", cell_type="code", max_score=0.0),
    "solution": functools.partial(SolutionCell, name="of_old"),
}


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    "what",
    [
        *("points", "checksum", "name"),
        *("no source", "no points", "no solution"),
        *("one more source", "one more points", "one more solution"),
    ],
)
def test_only_lessons_that_differ_from_the_release_are_registered_again(course, monkeypatch, what):
    register(course)
    saved = []
    original = registration.SaveCells.preprocess

    def save(self, notebook, about):
        saved.append(about["nbgrader"]["notebook"])
        return original(self, notebook, about)

    monkeypatch.setattr(registration.SaveCells, "preprocess", save)
    assert register(course)[0] == saved == []
    with gradebook.open_gradebook(course) as book:
        notebook = book.find_notebook(GROUND.name, STAGE)
        cells = {
            "source": notebook.source_cells,
            "points": notebook.grade_cells,
            "solution": notebook.solution_cells,
        }
        *words, kind = what.split()
        if what == "checksum":
            notebook.source_cells[1].checksum = "another"
        elif what == "name":
            notebook.grade_cells[0].name = "test_another"
        elif words == ["no"]:
            book.db.delete(cells[kind][0])
        elif words:
            book.db.add(EXTRA_CELLS[kind](notebook=notebook))
        else:
            notebook.grade_cells[0].max_score += 1
        book.db.commit()
    assert register(course)[0] == [] and GROUND.name in saved
    saved.clear()
    assert register(course)[0] == saved == []


# ---- withdrawn ----------------------------------------------------------------------------------


def test_only_withdrawn_work_is_removed(entered_course):
    judged = verdicts(entered_course)
    enter_verdicts(entered_course, judged, ["stage1_ransac"], ignore_progress)  # another stage
    enter_verdicts(entered_course, judged[:2], [STAGE], ignore_progress)
    assert {student for student, _ in marks(entered_course)} == {"ada"}
    assert not (entered_course.autograded / "bob" / STAGE).exists()
    assert (entered_course.autograded / "ada" / STAGE).is_dir()
    enter_verdicts(entered_course, [], [], ignore_progress)  # no exercise was graded by hand
    assert {student for student, _ in marks(entered_course)} == {"ada"}


def test_withdrawn_work_is_removed_even_if_its_copies_are_gone(entered_course):
    shutil.rmtree(entered_course.autograded)
    enter_verdicts(entered_course, verdicts(entered_course)[2:], [STAGE], ignore_progress)
    assert {student for student, _ in marks(entered_course)} == {"bob"}


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    "manual", [{"manual_score": 0.0}, {"extra_credit": 5.0}, {"extra_credit": -1.5}, "Well seen."]
)
def test_manual_marks_and_comments_are_never_removed(entered_course, manual):
    with gradebook.open_gradebook(entered_course) as book:
        for student in EARNED:  # left behind when Formgrader removes a mark
            for notebook in book.find_submission(STAGE, student).notebooks:
                notebook.grades[0].extra_credit, notebook.comments[0].manual_comment = 0.0, ""
        notebook = book.find_submission_notebook(DISTANCE.name, STAGE, "ada")
        if isinstance(manual, str):
            notebook.comments[0].manual_comment = manual
        else:
            for name, points in manual.items():
                setattr(notebook.grades[-1], name, points)
        book.db.commit()
    with pytest.raises(GradebookError) as trouble:
        enter_verdicts(entered_course, [], ["stage1_ransac", STAGE], ignore_progress)
    (sentence,) = str(trouble.value).splitlines()[1:]
    assert sentence.startswith(f"ada, {STAGE}: the submission is gone")
    assert f"Gradebook.remove_submission('{STAGE}', 'ada')" in sentence
    remaining = {student for student, _ in marks(entered_course)}
    assert remaining == {"ada"}, "Bob's submission is removed"
    assert (entered_course.autograded / "ada" / STAGE).is_dir()


# ---- time ---------------------------------------------------------------------------------------


@pytest.mark.end_to_end
@pytest.mark.parametrize(
    ("seconds", "lost"),
    [(-1, {}), (0, {}), (1, {"ada": pytest.approx(3.0)}), (2400, {"ada": pytest.approx(3.0)})],
)
def test_late_students_lose_the_penalty_of_the_course(entered_course, seconds, lost):
    (entered_course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    path = entered_course.submitted / "ada" / STAGE / "timestamp.txt"
    submitted_at = datetime.datetime(2026, 3, 1, 12) + datetime.timedelta(seconds=seconds)
    path.write_text(f"{submitted_at + datetime.timedelta(hours=1)} CET\n")
    set_due(entered_course, "12")
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert penalties(entered_course) == lost
    with gradebook.open_gradebook(entered_course) as book:
        assert book.find_submission(STAGE, "ada").timestamp == submitted_at
        assert book.find_submission(STAGE, "bob").timestamp is None
    assert differences_in(entered_course) == []
    set_due(entered_course, "14")  # the due date changes
    assert len(differences_in(entered_course)) == 2 * len(lost)
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert penalties(entered_course) == {}


@pytest.mark.end_to_end
@pytest.mark.parametrize(("hour", "lost"), [("14", {}), ("12", {}), ("11", {"ada": 30.0})])
def test_a_penalty_without_time_applies_to_late_students(entered_course, hour, lost):
    (entered_course.root / "nbgrader_config.py").write_text(
        "c = get_config()\nc.LateSubmissionPlugin.penalty_method = 'zero'\n"
    )
    (entered_course.submitted / "ada" / STAGE / "timestamp.txt").write_text(
        "2026-03-01 12:00:00 UTC"
    )
    set_due(entered_course, hour)
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert penalties(entered_course) == lost


@pytest.mark.parametrize(
    ("due", "submitted", "lost"),
    [  # Berlin's clocks go back on 25 October 2026, and forward on 28 March 2027
        ("2026-10-24T20:00", "2026-10-25 19:30 Europe/Berlin", 3.0),  # 24.5 hours
        ("2026-10-24T20:00", "2026-10-25 20:30 Europe/Berlin", 6.0),
        ("2027-03-27T20:00", "2027-03-28 19:30 Europe/Berlin", 3.0),
        ("2027-03-27T20:00", "2027-03-28 20:30 Europe/Berlin", 6.0),  # 23.5 hours
    ],
)
def test_penalties_count_days_of_local_time(entered_course, due, submitted, lost):
    (entered_course.root / "nbgrader_config.py").write_text(LATE_PLUGIN)
    dates = f'timezone = "Europe/Berlin"\n[{STAGE}]\ndue = {due}:00\n'
    (entered_course.root / "deadlines.toml").write_text(dates)
    (entered_course.submitted / "ada" / STAGE / "timestamp.txt").write_text(submitted)
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert penalties(entered_course) == {"ada": pytest.approx(lost)}
    (stage,) = [stage for stage in class_results(entered_course).stages if stage.student == "ada"]
    assert math.ceil(stage.late / datetime.timedelta(days=1)) == lost / 3
    with gradebook.open_gradebook(entered_course) as book:
        for notebook in book.find_submission(STAGE, "ada").notebooks:
            notebook.late_submission_penalty = None
        book.db.commit()
    plugin = {"plugin_class": "grader.lms.late.PercentPerDay"}  # now with nbgrader's own command
    converter = make_converter(Autograde, entered_course.root, STAGE, AssignLatePenalties=plugin)
    exporter = NotebookExporter(parent=converter, config=converter.config)
    step = LatePenalties(parent=exporter)
    names = {"assignment": STAGE, "student": "ada", "db_url": converter.coursedir.db_url}
    for lesson in (GROUND, DISTANCE):
        step.preprocess(None, {"nbgrader": {**names, "notebook": lesson.name}})
    assert penalties(entered_course) == {"ada": pytest.approx(lost)}


def test_late_students_lose_no_points_without_a_penalty_plugin(entered_course):
    (entered_course.submitted / "ada" / STAGE / "timestamp.txt").write_text(
        "2026-03-01 13:00:00 UTC"
    )
    set_due(entered_course, "11")
    enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert penalties(entered_course) == {}


@pytest.mark.end_to_end
@pytest.mark.parametrize("text", [b"yesterday", b"\xff\xfe", b"9" * 400, b"", b" \n"])
def test_lateness_of_an_unreadable_time_is_undecided(entered_course, text):
    path = entered_course.submitted / "ada" / STAGE / "timestamp.txt"
    path.write_bytes(text)

    def undecided():
        enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
        stages = class_results(entered_course).stages
        return [stage.student for stage in stages if stage.undecided]

    assert undecided() == []  # there is no due date
    set_due(entered_course, "11")
    assert undecided() == ["ada"]
    assert marks(entered_course) == expected_marks() and penalties(entered_course) == {}
    path.unlink()  # without the file, a time is not required
    assert undecided() == []
    assert differences_in(entered_course) == []


# ---- files --------------------------------------------------------------------------------------


@pytest.mark.end_to_end
def test_files_next_to_a_notebook_are_copied(course):
    folder = course.submitted / "ada" / STAGE
    (folder / "figures" / "first").mkdir(parents=True)
    (folder / "figures" / "first" / "street.txt").write_text("a picture")
    (folder / "helper.py").write_bytes(b"x = 1  # caf\xe9")
    (folder / "README").write_text("read me")
    (folder / "distances.csv").write_text("1,2")
    for page in ("page.html", "PAGE.HTM", "drawing.svg", "page.xhtml", "feed.xml"):
        (folder / "figures" / page).write_text("<script>alert(1)</script>")
    for hidden in (".ipynb_checkpoints", "__pycache__"):
        (folder / hidden).mkdir()
        (folder / hidden / "old.txt").write_text("old")
    (folder / ".hidden").write_text("hidden")
    (folder / "essay.ipynb").write_text("{}")
    (course.root / "secret.txt").write_text("secret")
    (folder / "link.txt").symlink_to(course.root / "secret.txt")
    os.mkfifo(folder / "pipe.txt")
    enter_verdicts(course, verdicts(course), [STAGE], ignore_progress)
    copies = course.autograded / "ada" / STAGE
    files = {str(path.relative_to(copies)): path for path in copies.rglob("*") if path.is_file()}
    assert set(files) == {
        *(f"{GROUND.name}.ipynb", f"{DISTANCE.name}.ipynb"),
        *("helper.py", "README", "distances.csv", os.path.join("figures", "first", "street.txt")),
    }
    assert {path.stat().st_mode & 0o777 for path in files.values()} == {0o444}
    assert files["helper.py"].read_text("utf-8") == "x = 1  # caf\ufffd"  # as judged
    assert {path.name for path in copies.parent.iterdir()} == {STAGE}  # no temporary folders
    (folder / "helper.py").unlink()
    enter_verdicts(course, verdicts(course, key="another"), [STAGE], ignore_progress)
    assert not files["helper.py"].exists() and files[f"{GROUND.name}.ipynb"].exists()


def test_folders_of_a_killed_run_are_removed(entered_course):
    for name in (f".{STAGE}.part", f".{STAGE}.old"):
        (entered_course.autograded / "ada" / name).mkdir()
        (entered_course.autograded / "ada" / name / "stray.txt").write_text("stray")
    enter_verdicts(
        entered_course, verdicts(entered_course, key="another"), [STAGE], ignore_progress
    )
    assert [path.name for path in (entered_course.autograded / "ada").iterdir()] == [STAGE]
    assert not (entered_course.autograded / "ada" / STAGE / "stray.txt").exists()


# ---- one transaction ----------------------------------------------------------------------------


class Session(SimpleNamespace):
    """A database session that records calls."""

    def __init__(self):
        super().__init__(calls=[])

    def flush(self):
        self.calls.append("flush")

    def rollback(self):
        self.calls.append("rollback")

    def commit(self):
        self.calls.append("commit")


def test_commits_of_nbgrader_are_delayed_to_the_end():
    session = Session()
    with gradebook_writer._one_transaction(SimpleNamespace(db=lambda: session)):
        session.commit()
        session.commit()
        assert session.calls == ["flush", "flush"]
    session.commit()
    assert session.calls == ["flush", "flush", "commit", "commit"]


@pytest.mark.parametrize("error", [ValueError("no"), KeyboardInterrupt()])
def test_an_error_rolls_the_transaction_back(error):
    session = Session()
    with (
        pytest.raises(type(error)),
        gradebook_writer._one_transaction(SimpleNamespace(db=lambda: session)),
    ):
        session.commit()
        raise error
    session.commit()
    assert session.calls == ["flush", "rollback", "commit"]


# ---- written answers ----------------------------------------------------------------------------


@pytest.fixture
def course_with_answer(tmp_path):
    """Return a course of lesson 12 and a function that enters a written answer."""
    course = Course(tmp_path / "course")
    (course.released / STREAM.stage).mkdir(parents=True)
    shutil.copy(STREAM.released, course.released / STREAM.stage)
    path = course.submitted / "ada" / STREAM.stage / f"{STREAM.name}.ipynb"
    path.parent.mkdir(parents=True)
    paths._folder.cache_clear()

    def enter_answer(text):
        path.write_text(fill_in(STREAM, {"write_up": text} if text else {}), "utf-8")
        (submission,) = find_submissions(course)
        earned = [1.25] * len(STREAM.machine_graded)
        verdict = verdict_on(course, submission, earned)
        verdict = dataclasses.replace(verdict, key=f"of {text}")
        enter_verdicts(course, [(submission, verdict)], [STREAM.stage], ignore_progress)

    return course, enter_answer


def mark_on_answer(course, manual_score=None):
    """Return the manual mark, whether the answer waits for grading, and the comment on it.

    If `manual_score` is given, enter it first.
    """
    with gradebook.open_gradebook(course) as book:
        grade = book.find_grade("write_up", STREAM.name, STREAM.stage, "ada")
        comment = book.find_comment("write_up", STREAM.name, STREAM.stage, "ada")
        if manual_score is not None:
            grade.manual_score, grade.needs_manual_grade = manual_score, False
            book.db.commit()
        return grade.manual_score, grade.needs_manual_grade, comment.auto_comment


def test_a_changed_answer_must_be_graded_again(course_with_answer):
    course, enter_answer = course_with_answer
    enter_answer("It finds 14 of 17 cars.")
    assert mark_on_answer(course) == (None, True, None)
    assert class_results(course).notebooks[0].status == WAITING
    mark_on_answer(course, 7.5)
    (course.autograded / "ada" / STREAM.stage / f"{STREAM.name}.ipynb").unlink()
    enter_answer("It finds 14 of 17 cars.")  # the same answer again
    assert mark_on_answer(course) == (7.5, False, None)
    enter_answer("It finds 15 of 17 cars.")
    assert mark_on_answer(course) == (7.5, True, None)


@pytest.mark.end_to_end
def test_only_a_missing_answer_gets_a_comment(course_with_answer):
    course, enter_answer = course_with_answer
    enter_answer("")
    assert mark_on_answer(course)[2] == "No response."
    assert class_results(course).notebooks[0].score == 1.25 * len(STREAM.machine_graded)
    for found in range(8):  # several texts, because the order of their checksums must not matter
        enter_answer(f"It finds {found} of 17 cars.")
        assert mark_on_answer(course)[2] is None


# ---- location -----------------------------------------------------------------------------------


def test_the_location_of_the_gradebook_hides_the_password(course):
    assert gradebook.gradebook_location(course) == str(course.root / "gradebook.db")
    assert not gradebook.gradebook_exists(course)
    with gradebook.open_gradebook(course):
        assert gradebook.gradebook_exists(course)
    (course.root / "gradebook.db").unlink()
    (course.root / "nbgrader_config.py").write_text(
        "c = get_config()\n"
        "c.CourseDirectory.db_url = 'postgresql+pg8000://teacher:secret@host/grades'\n"
    )
    assert gradebook.gradebook_location(course) == "postgresql+pg8000://teacher:***@host/grades"
    assert gradebook.gradebook_exists(course)  # assumed, because only the server could tell


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("sqlite:///nowhere/gradebook.db", "cannot be opened: (sqlite3.OperationalError) unable"),
        ("postgresql+nobody://host/grades", "cannot be opened: "),
        ("postgresql+psycopg2cffi://host/grades", "needs the package psycopg2cffi, which is not"),
    ],
)
def test_the_error_about_a_gradebook_that_does_not_open_names_the_setting(course, url, message):
    (course.root / "nbgrader_config.py").write_text(
        f"c = get_config()\nc.CourseDirectory.db_url = {url!r}\n"
    )
    with pytest.raises(GradebookUnavailable) as caught, gradebook.open_gradebook(course):
        pass
    assert message in str(caught.value) and "\n" not in str(caught.value)
    assert "c.CourseDirectory.db_url" in str(caught.value)
    assert ".. c.Course" not in str(caught.value)


def use_database(course, address):
    (course.root / "nbgrader_config.py").write_text(
        f"c = get_config()\nc.CourseDirectory.db_url = {address!r}\n"
    )


def test_the_error_about_a_gradebook_of_an_older_nbgrader_suggests_a_fix(entered_course):
    connection = sqlite3.connect(entered_course.root / "gradebook.db")
    connection.execute("ALTER TABLE grade DROP COLUMN extra_credit")
    connection.close()
    for use in (
        lambda: enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress),
        lambda: class_results(entered_course),
        lambda: FeedbackCollector(entered_course, STAGE),
    ):
        with pytest.raises(GradebookUnavailable, match="older .* Run: nbgrader db upgrade"):
            use()
    (finding,) = check_gradebook(entered_course)
    assert not finding.is_good and finding.text.endswith("Run: nbgrader db upgrade")


@pytest.mark.parametrize("lock", ["EXCLUSIVE", "IMMEDIATE"])
def test_a_locked_gradebook_is_reported_in_one_sentence(entered_course, lock, caplog):
    path = entered_course.root / "gradebook.db"
    use_database(entered_course, f"sqlite:///{path}?timeout=0.01")
    connection = sqlite3.connect(path, isolation_level=None)
    connection.execute(f"BEGIN {lock}")
    earned = EARNED | {"bob": {DISTANCE: (7.0, 1.0, 2.0)}}
    with pytest.raises(GradebookUnavailable, match="locked, .* same command again in a minute"):
        enter_verdicts(entered_course, verdicts(entered_course, earned), [STAGE], ignore_progress)
    (entered_course.root / "roster.csv").write_text("id\nada\nbob\nzoe\n")  # nbgrader adds Zoe
    with pytest.raises(GradebookUnavailable, match="locked, .* same command again in a minute"):
        enter_verdicts(entered_course, verdicts(entered_course), [STAGE], ignore_progress)
    assert caplog.records == []  # nbgrader logs a traceback
    connection.close()
    enter_verdicts(entered_course, verdicts(entered_course, earned), [STAGE], ignore_progress)
    assert marks(entered_course) == expected_marks(earned)


@pytest.mark.parametrize("kind", [StageEntry, GradebookRow])
def test_entries_and_rows_are_frozen(kind):
    assert kind.__dataclass_params__.frozen


def test_a_student_without_work_is_not_in_the_gradebook(entered_course):
    with gradebook.open_gradebook(entered_course) as book, pytest.raises(MissingEntry):
        book.find_submission(STAGE, "eve")
