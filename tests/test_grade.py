"""Grading a class, from submissions to nbgrader's gradebook and feedback."""

import csv
import dataclasses
import html
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import pytest

from grader import cli, commands, grading
from grader.classroom import demo, grade
from grader.classroom.demo import make_class
from grader.classroom.submissions import find_submissions
from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import all_lessons, find_lesson, stages
from grader.course.paths import PROJECT, Course
from grader.lms import gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.registration import register_stages
from grader.lms.report import write_report
from tests.gradebooks import ignore_progress
from tests.graded_courses import (
    LESSON,
    SEED,
    answered_notebook,
    entered_scores,
    judge_course,
    make_course,
    run_nbgrader,
)
from tests.prerequisites import PATIENCE

# Code that replaces the file of a submission after the file has been judged.
JUDGE_AND_REPLACE = """
from grader.lms import nbgrader_plugin
right = nbgrader_plugin.current_verdict
def judge_and_replace(course, submission, *about):
    verdict = right(course, submission, *about)
    if submission.student == "half":
        submission.path.write_bytes(submission.path.read_bytes() + b" ")
    return verdict
nbgrader_plugin.current_verdict = judge_and_replace
"""


def four_students():
    return {
        "right": answered_notebook(),
        "half": answered_notebook("filter_ground"),
        "untouched": fill_in(LESSON, {}),
        "broken": answered_notebook()[:5000],
    }


@pytest.fixture
def course(tmp_path, sandbox):
    """Return a new course with four students."""
    return make_course(tmp_path / "course", LESSON, four_students(), sandbox)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory, sandbox):
    """Judge the four students once; copies of the course can use the same verdicts."""
    course = make_course(
        tmp_path_factory.mktemp("judged") / "course", LESSON, four_students(), sandbox
    )
    judge_course(course, sandbox)
    return course.verdicts


@pytest.fixture
def judged_course(course, verdicts):
    """Return the course with its verdicts."""
    shutil.copytree(verdicts, course.verdicts, dirs_exist_ok=True)
    return course


def scores_by_verdict(judged):
    return {
        (submission.student, submission.lesson.stage, submission.lesson.name): verdict.score
        for submission, verdict in judged
    }


@pytest.mark.slow
def test_scores_reach_the_gradebook(judged_course, sandbox):
    judged = judge_course(judged_course, sandbox)
    enter_verdicts(judged_course, judged, [LESSON.stage], ignore_progress)
    expected = scores_by_verdict(judged)
    assert entered_scores(judged_course) == expected
    assert expected["right", LESSON.stage, LESSON.name] == 30
    assert 20 <= expected["half", LESSON.stage, LESSON.name] < 30
    assert expected["untouched", LESSON.stage, LESSON.name] == 0
    assert expected["broken", LESSON.stage, LESSON.name] == 0


@pytest.mark.slow
def test_commands_of_nbgrader_give_the_same_scores_without_hidden_tests(course, sandbox):
    made = run_nbgrader(course, "generate_assignment", LESSON.stage, "--force")
    assert made.returncode == 0, made.stderr
    assert (
        course.root / "notebooks" / LESSON.stage / f"{LESSON.name}.ipynb"
    ).read_bytes().strip() == LESSON.released.read_bytes().strip()
    for name in ("page.HTML", "notes.txt"):
        (course.submitted / "half" / LESSON.stage / name).write_text("<script>alert(1)</script>")
    done = run_nbgrader(course, "autograde", LESSON.stage)
    assert done.returncode == 0, done.stderr
    assert entered_scores(course) == scores_by_verdict(judge_course(course, sandbox))
    copies = {path.name for path in (course.autograded / "half" / LESSON.stage).iterdir()}
    assert copies == {f"{LESSON.name}.ipynb", "notes.txt"}  # Formgrader would serve the page

    feedback = run_nbgrader(course, "generate_feedback", LESSON.stage)
    assert feedback.returncode == 0, feedback.stderr
    page = (course.root / "feedback" / "half" / LESSON.stage / f"{LESSON.name}.html").read_text()
    verdict = json.loads(
        (course.verdicts / "half" / LESSON.stage / f"{LESSON.name}.json").read_text()
    )
    failed = [
        test
        for exercise in verdict["exercises"]
        for test in exercise["tests"]
        if not test["passed"]
    ]
    assert failed
    for test in failed:
        assert test["title"] in html.unescape(page)
    hidden = LESSON.tests.read_text()
    for line in ("expected_mask(", "samples.", "assert_ground_removed("):
        assert line in hidden
        assert line not in page
    broken = course.root / "feedback" / "broken" / LESSON.stage / f"{LESSON.name}.html"
    assert "not valid JSON" in broken.read_text()


@pytest.mark.slow
def test_reports_wait_for_a_person_and_keep_their_marks(tmp_path, sandbox):
    lesson = find_lesson("12_streaming_obstacles")
    report = "I widened the region to 18.5 m.\n\n| before | after |\n|---|---|\n| 0.67 | 1.00 |"
    right = next(variant.source for variant in answers_to("match_boxes") if variant.right)
    course = make_course(
        tmp_path / "course",
        lesson,
        {
            "writer": fill_in(lesson, {"match_boxes": right, "second_data_set": report}),
            "untouched": fill_in(lesson, {}),
        },
        sandbox,
    )
    with gradebook.open_gradebook(course) as book:
        register_stages(course, book, [lesson.stage])

    def autograde():
        done = run_nbgrader(course, "autograde", lesson.stage, "--force")
        assert done.returncode == 0, done.stderr
        assert report in "\n".join(
            "".join(cell["source"])
            for cell in json.loads(
                (
                    course.root / "autograded" / "writer" / lesson.stage / f"{lesson.name}.ipynb"
                ).read_text()
            )["cells"]
        )

    def grades(student):
        with gradebook.open_gradebook(course) as book:
            found = book.find_submission_notebook(lesson.name, lesson.stage, student).grades
            return {
                grade.name: (grade.auto_score, grade.manual_score, grade.needs_manual_grade)
                for grade in found
            }

    autograde()
    assert entered_scores(course) == scores_by_verdict(judge_course(course, sandbox))
    # The writer did not touch `detect_obstacles` and `write_up`.
    assert grades("writer") == {
        "test_detect_obstacles": (0, None, False),
        "test_match_boxes": (5, None, False),
        "second_data_set": (None, None, True),
        "write_up": (0, None, False),
    }
    assert not any(by_hand for _, _, by_hand in grades("untouched").values())

    with gradebook.open_gradebook(course) as book:
        book.find_grade("second_data_set", lesson.name, lesson.stage, "writer").manual_score = 4
        book.db.commit()
    autograde()
    assert grades("writer")["second_data_set"][1] == 4
    assert entered_scores(course)["writer", lesson.stage, lesson.name] == 9


@pytest.mark.slow
def test_a_second_run_judges_only_changed_submissions(judged_course, sandbox):
    judge_course(judged_course, sandbox)
    before = {path: path.stat().st_mtime_ns for path in judged_course.verdicts.rglob("*.json")}
    path = judged_course.submitted / "untouched" / LESSON.stage / f"{LESSON.name}.ipynb"
    path.write_text(answered_notebook(), "utf-8")
    judged = judge_course(judged_course, sandbox)
    changed = {
        path.parent.parent.name for path in before if path.stat().st_mtime_ns != before[path]
    }
    assert changed == {"untouched"}
    assert scores_by_verdict(judged)["untouched", LESSON.stage, LESSON.name] == 30


@pytest.mark.slow
def test_a_verdict_without_a_fingerprint_is_judged_again(judged_course, sandbox):
    """Verdicts from older versions contain no fingerprint of the submission."""
    path = judged_course.verdicts / "half" / LESSON.stage / f"{LESSON.name}.json"
    verdict = json.loads(path.read_text("utf-8"))
    fingerprint = verdict.pop("fingerprint")
    path.write_text(json.dumps(verdict), "utf-8")
    (half,) = [item for item in find_submissions(judged_course) if item.student == "half"]
    assert grade.stored_verdict(judged_course, half, SEED) is None
    judged = {item.student: verdict for item, verdict in judge_course(judged_course, sandbox)}
    assert json.loads(path.read_text("utf-8"))["fingerprint"] == fingerprint
    assert judged["half"] == grade.stored_verdict(judged_course, half, SEED)
    assert not {"fingerprint", "key"} & judged["half"].as_dict().keys()  # not shown to students


@pytest.mark.slow
def test_a_submission_replaced_after_judging_is_not_entered(
    judged_course, sandbox, monkeypatch, capsys
):
    def folder(student):
        return judged_course.submitted / student / LESSON.stage

    def judge_and_replace(*about):
        judged = original(*about)
        (folder("half") / f"{LESSON.name}.ipynb").write_text(answered_notebook(), "utf-8")
        (folder("untouched") / "helper.py").write_text("x = 1", "utf-8")
        (folder("broken") / f"{LESSON.name}.ipynb").unlink()
        return judged

    original = grade.judge_class
    monkeypatch.setattr(grading, "judge_class", judge_and_replace)
    arguments = (judged_course, (), SEED, sandbox, 2)
    assert grading.grade_course(*arguments) == commands.FAULT
    errors = " ".join(capsys.readouterr().err.split())
    for student in ("half", "untouched", "broken"):
        sentence = (
            f"{student}, {LESSON.stage}: {LESSON.name}.ipynb, or a module next to it, was replaced"
        )
        assert f"{sentence} after it was judged" in errors
        assert errors.count(f"{student}, {LESSON.stage}") == 1
    assert [student for student, *_ in entered_scores(judged_course)] == ["right"]
    assert [path.name for path in judged_course.autograded.glob("*/*")] == [LESSON.stage]

    monkeypatch.setattr(grading, "judge_class", original)
    assert grading.grade_course(*arguments) == commands.SUCCESS
    scores = {student: score for (student, *_), score in entered_scores(judged_course).items()}
    assert scores == {"right": 30, "half": 30, "untouched": 0}


@pytest.mark.slow
def test_nbgrader_does_not_enter_a_submission_replaced_after_judging(judged_course):
    with (judged_course.root / "nbgrader_config.py").open("a", encoding="utf-8") as file:
        file.write(JUDGE_AND_REPLACE)
    with gradebook.open_gradebook(judged_course) as book:
        register_stages(judged_course, book, [LESSON.stage])
    done = run_nbgrader(judged_course, "autograde", LESSON.stage)
    assert done.returncode == 1
    assert f"half, {LESSON.stage}: {LESSON.name}.ipynb, or a module" in done.stderr
    scores = {student: score for (student, *_), score in entered_scores(judged_course).items()}
    assert scores["right"] == 30 and not scores.get("half")
    assert not (judged_course.autograded / "half" / LESSON.stage).exists()


@pytest.mark.slow
def test_copies_of_modules_have_the_judged_text(judged_course, sandbox):
    """Copies of modules contain the judged text, in which invalid bytes are replaced."""
    folder = judged_course.submitted / "half" / LESSON.stage
    (folder / "helper.py").write_bytes(b"x = 'J\xfcrgen'\r\n")
    (folder / "seen.txt").write_bytes(b"\xfc")
    enter_verdicts(
        judged_course, judge_course(judged_course, sandbox), [LESSON.stage], ignore_progress
    )
    copies = judged_course.autograded / "half" / LESSON.stage
    assert (copies / "helper.py").read_bytes() == "x = 'J\ufffdrgen'\r\n".encode()
    assert (copies / "seen.txt").read_bytes() == b"\xfc"


@pytest.mark.slow
def test_a_new_submission_changes_the_gradebook(judged_course, sandbox):
    enter_verdicts(
        judged_course, judge_course(judged_course, sandbox), [LESSON.stage], ignore_progress
    )
    path = judged_course.submitted / "untouched" / LESSON.stage / f"{LESSON.name}.ipynb"
    path.write_text(answered_notebook(), "utf-8")
    judged = judge_course(judged_course, sandbox)
    enter_verdicts(judged_course, judged, [LESSON.stage], ignore_progress)
    assert entered_scores(judged_course) == scores_by_verdict(judged)


@pytest.mark.slow
def test_tampered_metadata_and_deleted_test_cells_change_nothing(judged_course, sandbox):
    path = judged_course.submitted / "half" / LESSON.stage / f"{LESSON.name}.ipynb"
    notebook = json.loads(path.read_text())
    for cell in notebook["cells"]:
        grading = cell["metadata"].get("nbgrader", {})
        if grading.get("grade_id") == "test_filter_ground":
            grading.update(points=2000, locked=False, solution=True)
            cell["source"] = "print('all right')"
    notebook["cells"] = [
        cell
        for cell in notebook["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade_id") != "test_voxel_grid"
    ]
    path.write_text(json.dumps(notebook))
    judged = judge_course(judged_course, sandbox)
    enter_verdicts(judged_course, judged, [LESSON.stage], ignore_progress)
    assert entered_scores(judged_course) == scores_by_verdict(judged)


@pytest.mark.death
@pytest.mark.slow
def test_a_run_killed_in_the_middle_loses_nothing(course, sandbox):
    for number in range(8):
        path = course.submitted / f"more{number}" / LESSON.stage / f"{LESSON.name}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(answered_notebook(), "utf-8")
    code = (
        "from pathlib import Path; from grader.classroom import grade;"
        "from grader.classroom.pool import Pool;"
        "from grader.course.paths import Course; from grader.sandbox import SANDBOXES;"
        f"grade.judge_class(Course(Path({str(course.root)!r})), (), {SEED}, "
        f"SANDBOXES[{sandbox.name!r}], Pool, 2, lambda *a: None)"
    )
    running = subprocess.Popen([sys.executable, "-c", code], cwd=PROJECT, start_new_session=True)
    deadline = time.monotonic() + PATIENCE
    while not list(course.verdicts.rglob("*.json")) and time.monotonic() < deadline:
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    kept = {path: path.stat().st_mtime_ns for path in course.verdicts.rglob("*.json")}
    assert kept
    judged = judge_course(course, sandbox)
    assert len(judged) == 12
    assert all(path.stat().st_mtime_ns == mtime for path, mtime in kept.items())


@pytest.mark.slow
def test_plain_nbgrader_still_grades_with_the_visible_checks(course):
    """Without the course's plugin, graded cells are ordinary nbgrader tests."""
    import nbclient
    import nbformat
    from nbgrader.utils import determine_grade

    for text, score in ((answered_notebook(), 10.0), (answered_notebook("filter_ground"), 0.0)):
        notebook = nbformat.reads(text, as_version=4)
        notebook.cells = [
            cell
            for cell in notebook.cells
            if cell.cell_type == "code"
            and (
                cell.source.startswith(("# Run this", "import matplotlib"))
                or cell.metadata.get("nbgrader", {}).get("grade_id")
                in ("filter_ground", "test_filter_ground")
            )
        ]
        nbclient.NotebookClient(
            notebook,
            allow_errors=True,
            timeout=600,
            resources={"metadata": {"path": str(LESSON.released.parent)}},
        ).execute()
        assert determine_grade(notebook.cells[-1]) == (score, 10.0)


def test_submissions_are_found_and_other_files_ignored(course):
    (course.submitted / "right" / LESSON.stage / "notes.ipynb").write_text("{}")
    (course.submitted / "right" / "stage9" / "x.ipynb").parent.mkdir()
    found = grade.find_submissions(course)
    assert [submission.student for submission in found] == ["broken", "half", "right", "untouched"]
    assert grade.find_submissions(course, ["stage1_ransac"]) == []


@pytest.mark.slow
def test_unusual_files_and_names_do_not_stop_grading(judged_course, sandbox, capsys):
    from grader.console import print_class

    stage = judged_course.submitted / "[red]" / LESSON.stage
    (stage / f"{LESSON.name}.ipynb").mkdir(parents=True)
    pipe = judged_course.submitted / "pipe" / LESSON.stage / f"{LESSON.name}.ipynb"
    pipe.parent.mkdir(parents=True)
    os.mkfifo(pipe)
    judged = judge_course(judged_course, sandbox)
    by_student = {submission.student: verdict for submission, verdict in judged}
    assert by_student["right"].score == 30
    for student in ("[red]", "pipe"):
        assert by_student[student].score == 0
        assert by_student[student].problems
    print_class(judged)
    assert "[red]" in capsys.readouterr().out
    write_report(judged_course, judged)


def test_a_failed_verdict_is_judged_again(course, sandbox):
    submission = grade.find_submissions(course)[0]
    verdict = grade.failed_verdict(submission, ValueError("oh"))
    assert "not the student's fault" in verdict.problems[0]
    grade.write_verdict(verdict, submission.verdict_path(course))
    assert grade.stored_verdict(course, submission, SEED) is None


@pytest.mark.slow
def test_a_problem_is_shown_as_text_and_not_as_markup(judged_course, sandbox):
    import nbformat

    from grader.lms.autograded_copy import write_verdict

    notebook = nbformat.reads(LESSON.released.read_text(), as_version=4)
    verdicts_by_student = {
        submission.student: verdict for submission, verdict in judge_course(judged_course, sandbox)
    }
    verdict = verdicts_by_student["right"]
    problem = "![](http://example.org) [a](javascript:alert) <script>"
    write_verdict(notebook, dataclasses.replace(verdict, problems=(problem,)))
    text = notebook.cells[0].source
    assert text.startswith("<div>") and "\n" not in text and "<script>" not in text


@pytest.mark.slow
def test_the_report_escapes_text_of_students(judged_course, sandbox):
    path = judged_course.submitted / "half" / LESSON.stage / f"{LESSON.name}.ipynb"
    path.write_text(
        fill_in(
            LESSON,
            {
                "filter_ground": "def filter_ground(cloud, ground_level=-1.2):\n"
                "    raise ValueError('<script>alert(1)</script>')\n"
            },
        ),
        "utf-8",
    )
    page = write_report(judged_course, judge_course(judged_course, sandbox)).read_text("utf-8")
    assert "<script>" not in page
    assert "&lt;script&gt;alert(1)" in page
    for words in ("4 students", "right", "Hardest checks", "not valid JSON"):
        assert words in page


@pytest.mark.slow
@pytest.mark.parametrize(
    # Twelve students include one of each kind, so the stage with the fewest notebooks has twelve.
    "stage, students",
    [(stage, 12 if stage == "stage2_clustering" else 4) for stage in stages()],
)
def test_the_demo_grades_its_class(stage, students, sandbox, monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "DEMO_FOLDER", tmp_path / "demo")
    options = ["--students", str(students), "--stages", stage]
    assert cli.main(["demo", *options, "--workers", "2"]) == 0
    output = capsys.readouterr().out
    assert "Report: " in output
    course = Course(tmp_path / "demo")
    scores = entered_scores(course)
    most = sum(
        exercise.points
        for lesson in all_lessons()
        if lesson.stage == stage
        for exercise in lesson.exercises
        if not exercise.by_hand
    )
    by_student = {}
    for (student, _, _), score in scores.items():
        by_student[student] = by_student.get(student, 0) + score
    assert by_student["ada"] == most
    assert by_student["not_started"] == 0
    if students == 12:
        assert by_student["cut_off_file"] == 0
        assert sandbox.warning or by_student["attacker"] == 0
    assert len(by_student) == students
    assert 0 < by_student["chioma"] < most
    assert (course.report / "index.html").stat().st_size > 10_000
    sheets = (course.root / "viva" / stage / "sheets.html").read_text("utf-8")
    assert "<b>ada</b>" in sheets and 'class="question"' in sheets
    with (course.root / "scores.csv").open(encoding="utf-8-sig", newline="") as file:
        totals = {row["Student"]: row["Total"] for row in csv.DictReader(file)}
    assert float(totals["ada"]) == most and totals.keys() == {"out of", *by_student}
    for name in (f"viva/{stage}/sheets.html", f"report/similarity_{stage}.html", "scores.csv"):
        assert str(course.root / name) in output


def test_a_demo_of_all_stages_has_every_lesson(monkeypatch, tmp_path):
    graded = []
    monkeypatch.setattr(demo, "DEMO_FOLDER", tmp_path / "demo")
    monkeypatch.setattr(
        grading, "grade_course", lambda course, *_: graded.append(find_submissions(course)) or 0
    )
    assert cli.main(["demo", "--students", "2", "--stages"]) == 0
    assert cli.main(["demo", "--students", "1"]) == 0
    assert cli.main(["demo", "--stages", "stage9_none"]) == 2
    everything, usual = ([submission.lesson for submission in found] for found in graded)
    assert everything == [*all_lessons(), *all_lessons()]
    assert {lesson.stage for lesson in usual} == {"stage3_obstacles"}


def test_the_demo_has_every_kind_of_student(tmp_path, monkeypatch):
    monkeypatch.setattr(demo, "DEMO_FOLDER", tmp_path / "demo")
    course = make_class(13, hostile=True)
    names = {path.name for path in course.submitted.iterdir()}
    assert len(names) == 13
    assert {"ada", "not_started", "cut_off_file", "attacker"} <= names
    assert "attacker" not in {
        path.name for path in make_class(13, hostile=False).submitted.iterdir()
    }
