"""Feedback for students: pages, and zips from which learning platforms return the files."""

import csv
import dataclasses
import html
import io
import json
import re
import zipfile
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

import nbformat
import pytest
from nbgrader.converters import GenerateFeedback

from grader import cli, commands
from grader.classroom.collect import collection
from grader.classroom.submissions import find_submissions
from grader.course import paths
from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.course.nbgrader_settings import make_converter
from grader.course.paths import Course
from grader.course.roster import Person
from grader.judging.verdict import (
    JUDGED,
    CheckResult,
    ExerciseResult,
    MessageKind,
    Slip,
    Verdict,
    write_verdict,
)
from grader.lms.cell_marks import CellMark
from grader.lms.check_summary import summarise_checks
from grader.lms.feedback import ExerciseFeedback, Feedback, LessonFeedback, lateness_sentences
from grader.lms.feedback_page import feedback_page
from grader.lms.gradebook import open_gradebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.results import EXCUSED, MARKED, NotebookResult, StageResult
from tests import browser
from tests.archives import canvas_files, make_zip, moodle_files
from tests.prerequisites import CHROMIUM

pytestmark = pytest.mark.usefixtures("reading_without_fork")

STAGE = "stage4_realtime"
TEN, TWELVE = find_lesson("10_accelerated_clustering"), find_lesson("12_streaming_obstacles")
PEOPLE = (
    ("ada", "Ada", "Lovelace", "ada@x.edu", "4001"),
    ("bjorn", "Björn", "Müller", "bm@x.edu", "4002"),
    ("cy", "Cy", "O'Neil", "cy@x.edu", "4003"),
    ("noshow", "No", "Show", "", ""),
)
HOSTILE = (
    "I saw $F_1 = \\frac{1}{2}$.\n\n<script>alert('me')</script> ![x](http://example.org/a.png)"
)
MISTAKE = (
    "Points of different clusters have the same label.\n3 rows too many.\nHint: Compare <cells>.\n"
    "The check in the notebook shows your answer next to the right one."
)


def check(name, message="", visible=True, title="", kind=MessageKind.OWN, subject=""):
    passed, hint = not message, next((m for m in message.split("\n") if "Hint:" in m), "")
    title = title or f"It {name}"
    fields = (kind, subject, hint)
    return CheckResult(name, title, passed, float(passed), 1.0, message, visible, *fields)


WRONG = ExerciseResult(
    "euclidean_clustering_accelerated",
    6.25,
    30.0,
    (
        check("joins"),
        check("parts", MISTAKE),
        check("keeps", "Fails for the same reason as “It parts”.", kind=MessageKind.SAME_REASON),
        *(
            check(f"waits {n}", "Later: parts are apart.", kind=MessageKind.WAITING)
            for n in range(12)
        ),
        check("hidden[1]", "… rows too many.", False, "Is correct elsewhere"),
        check("hidden[2]", "… rows too many.", False, "Is correct elsewhere"),
        check("hastens", "It took `1` minute.", False),
    ),
    cause=MISTAKE,
    first="parts",
    slip=Slip(3, 7, "    return a < b", "    return a <= b", 2.5),
)
RIGHT = ExerciseResult(WRONG.name, 30.0, 30.0, (check("joins"), check("parts")))


# ---- summaries of checks ------------------------------------------------------------------------


def test_the_first_failure_is_shown_and_the_rest_are_folded():
    folded = summarise_checks(WRONG)
    assert folded.first.name == "parts"
    assert [test.name for test in folded.others] == ["hastens"]
    assert {fold.text: fold.count for fold in folded.groups} == {
        "1 more fails for the same reason.": 1,
        "12 more cannot be tested until this is right.": 12,
        "2 more fail in the same way.": 2,
    }
    assert folded.groups[-1].titles == ("Is correct elsewhere (2 times)",)
    assert folded.description == "1 of the 18 checks passed" and folded.is_started


def test_every_check_is_counted_once():
    folded = summarise_checks(WRONG)
    count = 1 + len(folded.others) + len(folded.passed) + sum(fold.count for fold in folded.groups)
    assert count == len(WRONG.tests)


def test_different_messages_are_not_folded_together():
    tests = (check("a", "One.\n2 rows."), check("b", "4 metres."), check("c", "5 metres."))
    folded = summarise_checks(ExerciseResult("f", 0.0, 3.0, tests, "One.", "a"))
    assert (folded.others, [fold.text for fold in folded.groups]) == (
        (),
        ["2 more fail: … metres."],
    )
    folded = summarise_checks(ExerciseResult("f", 0.0, 3.0, tests[:2], "One.", "a"))
    assert (folded.others, folded.groups) == ((tests[1],), ())
    alike = tuple(
        check(name, f"{number} of 5 rows.") for name, number in zip("bcd", "122", strict=True)
    )
    for failed, message in (
        (alike, "3 more fail: … of 5 rows."),
        (alike[1:], "2 more fail: 2 of 5 rows."),
    ):
        folded = summarise_checks(ExerciseResult("f", 0.0, 3.0, (tests[0], *failed), "One.", "a"))
        assert [fold.text for fold in folded.groups] == [message]


@pytest.mark.parametrize(
    ("tests", "first", "words", "started"),
    [
        ((), "", "nothing could be checked", True),
        ((check("a"), check("b")), "", "all 2 checks passed", True),
        ((check("a", "Begin.", kind=MessageKind.NOT_STARTED),), "", "the only check failed", False),
    ],
)
def test_the_number_of_passed_checks_is_stated_in_words(tests, first, words, started):
    folded = summarise_checks(ExerciseResult("f", 0.0, 1.0, tests, "", first))
    assert (folded.description, folded.is_started) == (words, started)


@pytest.mark.parametrize(
    ("stub", "message"), [("f", "f is not started."), ("g", "f calls g. Write g first.")]
)
def test_a_stub_is_named(stub, message):
    tests = (check("a", "f calls g. Write g first.", kind=MessageKind.NOT_STARTED, subject=stub),)
    assert summarise_checks(ExerciseResult("f", 0.0, 1.0, tests)).not_started_sentence == message


# ---- lateness -----------------------------------------------------------------------------------

DAY = timedelta(days=1)
DUE = datetime(2026, 11, 20, 12, tzinfo=UTC)


def sentences(late=timedelta(), **more):
    fields = {"submitted_at": DUE + late, "due": DUE, "late": max(late, timedelta())} | more
    return list(lateness_sentences(StageResult("ada", STAGE, MARKED, 90.0, 100.0, **fields)))


def test_times_are_in_the_time_zone_of_the_course():
    """Times on either side of the end of summer time have different zone names."""
    due = datetime(2026, 10, 24, 21, 59, tzinfo=UTC)
    late = StageResult("ada", STAGE, MARKED, 1.0, 1.0, 0.0, due + DAY, due, DAY)
    (sentence,) = lateness_sentences(late, ZoneInfo("Europe/Berlin"))
    assert sentence == (
        "Submitted 1 day late, on 25 October 2026 at 22:59 CET. It was due on 24 October 2026 at "
        "23:59 CEST."
    )


def test_lateness_and_penalty_are_stated_in_words():
    (sentence,) = sentences(-timedelta(hours=1))
    assert sentence.startswith("Submitted on time, on 20 November 2026 at ")
    late, penalty = sentences(timedelta(days=2, hours=3, minutes=20), penalty=12.5)
    assert late.startswith("Submitted 2 days and 3 hours late, on 22 November 2026 at ")
    assert "It was due on 20 November 2026 at " in late
    assert penalty == "Points subtracted for lateness: 12.5."
    assert sentences(timedelta(seconds=5))[0].startswith("Submitted 1 minute late, ")
    assert sentences(timedelta(hours=1))[0].startswith("Submitted 1 hour late, ")
    assert sentences(submitted_at=None) == sentences(due=None) == []


@pytest.mark.parametrize(
    "why",
    [
        "timestamp.txt is empty",
        "the learning platform marks the work as late, but gives no time",
        "the table of submission times has no row for this student",
    ],
)
def test_undecided_lateness_has_the_same_sentence_for_every_reason(why):
    (sentence,) = sentences(submitted_at=None, undecided=why)
    assert "so your instructor has to decide whether it is late" in sentence


def test_an_excuse_comes_first_and_without_a_penalty():
    """The page of an excused student mentions only the excuse, even after a late submission."""
    result = StageResult("ada", STAGE, EXCUSED, 90.0, 100.0, 9.0, DUE + DAY, DUE, DAY)
    (sentence,) = Feedback(Person("ada"), result, ()).sentences
    assert sentence.startswith("You are excused from this stage")


# ---- pages --------------------------------------------------------------------------------------


def verdict(lesson, student, exercises):
    return Verdict(
        lesson=lesson.name,
        student=student,
        status=JUDGED,
        score=sum(exercise.score for exercise in exercises),
        max_score=sum(exercise.max_score for exercise in exercises),
        exercises=exercises,
        problems=("The last cell <b>breaks</b> off.",) if student == "bjorn" else (),
        seconds=0.0,
        key=f"of {student}",
    )


def invented_verdict(lesson, student):
    """Return a verdict on a student's notebook; only bjorn has a wrong answer."""
    if lesson == TEN:
        return verdict(lesson, student, (WRONG if student == "bjorn" else RIGHT,))
    exercises = tuple(
        ExerciseResult(exercise.name, exercise.points, exercise.points, (check("runs"),))
        for exercise in lesson.machine_graded
    )
    return verdict(lesson, student, exercises)


def grade(course):
    """Write and enter invented verdicts on all submissions of a course."""
    entered = []
    for submission in find_submissions(course):
        content = invented_verdict(submission.lesson, submission.student)
        fingerprint = submission.read(course).fingerprint()
        content = dataclasses.replace(content, fingerprint=fingerprint)
        write_verdict(content, submission.verdict_path(course))
        entered.append((submission, content))
    enter_verdicts(course, entered, [STAGE], lambda done, total, student: None)


def notebook(lesson, write_up=""):
    """Return a student's notebook, with the written answer `write_up`."""
    content = json.loads(fill_in(lesson, {}))
    for cell in content["cells"]:
        if write_up and cell["metadata"].get("nbgrader", {}).get("grade_id") == "write_up":
            cell["source"] = write_up
    return json.dumps(content).encode()


def attachments(lessons_of):
    """Return each student's Canvas attachments as (number, name, content)."""
    return {
        student: [
            (7000 + 10 * number + int(lesson.number), f"{lesson.name}.ipynb", data)
            for lesson, data in lessons
        ]
        for number, (student, lessons) in enumerate(lessons_of.items())
    }


WORK = {
    "ada": [(TEN, notebook(TEN)), (TWELVE, notebook(TWELVE, "It works."))],
    "bjorn": [(TEN, notebook(TEN)), (TWELVE, notebook(TWELVE, HOSTILE))],
    "cy": [(TWELVE, notebook(TWELVE))],
}


def make_course(root, *archives, decisions=None):
    """Return a graded course whose submissions were collected from zips."""
    course = Course(root)
    root.mkdir()
    with open(root / "roster.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["id", "first_name", "last_name", "email", "lms_id"])
        table.writerows(PEOPLE)
    numbers = [lesson.number for lesson in (TEN, TWELVE)]
    (root / "deadlines.toml").write_text(f"[{STAGE}]\nlessons = {json.dumps(numbers)}\n")
    paths._folder.cache_clear()
    for files in archives:
        (root / "submissions.zip").write_bytes(make_zip(files))
        collection.collect(
            course,
            [root / "submissions.zip"],
            [STAGE],
            None,
            decisions or {},
            {},
            lambda *news: None,
        )
    grade(course)
    return course


@pytest.fixture(scope="module")
def canvas_course(tmp_path_factory):
    files = []
    for (student, first, last, _, number), (_, given) in zip(
        PEOPLE, attachments(WORK).items(), strict=False
    ):
        files += canvas_files(f"{last}, {first}", number, given, late=student == "ada")
    course = make_course(tmp_path_factory.mktemp("canvas") / "course", files)
    with open_gradebook(course) as book:
        keys = (TWELVE.name, STAGE, "bjorn")
        mark, comment = (book.find_grade("write_up", *keys), book.find_comment("write_up", *keys))
        mark.manual_score, mark.needs_manual_grade = 7.5, False
        comment.manual_comment = "Mind the *unit*: $m$. <i>No</i>"
        machine = book.find_grade("test_match_boxes", *keys)
        machine.manual_score = 2.25
        book.db.commit()
    return course


def run_feedback(course, monkeypatch, *options):
    monkeypatch.setattr(commands, "Course", lambda: course)
    paths._folder.cache_clear()
    return cli.main(["feedback", STAGE, *options])


@pytest.fixture
def pages(canvas_course, tmp_path, monkeypatch):
    assert run_feedback(canvas_course, monkeypatch, "--to", str(tmp_path)) == 0
    return {path.stem: path.read_text("utf-8") for path in (tmp_path / STAGE).iterdir()}


def page_text(page):
    """Return the text of a page on one line, without tags."""
    body = page.partition("<body>")[2]
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", body)))


@pytest.mark.end_to_end
def test_each_student_who_submitted_gets_a_page(pages):
    assert sorted(pages) == ["ada", "bjorn", "cy"]


STUB = ExerciseResult(
    "insert", 0.0, 15.0, (check("keeps", "Begin.", kind=MessageKind.NOT_STARTED, subject="insert"),)
)


def feedback_on(*exercises, score=0.0, problems=()):
    """Return feedback on a stage with one lesson, given (result, points) of its exercises."""
    lesson = find_lesson("04_kd_tree")
    parts = tuple(
        ExerciseFeedback(
            exercise,
            CellMark(points, False, False),
            judged,
            summarise_checks(judged) if judged else None,
            None,
            None,
        )
        for exercise, (judged, points) in zip(lesson.exercises, exercises, strict=False)
    )
    notebook = NotebookResult("ada", lesson.stage, lesson.name, MARKED, score, 60.0)
    stage = StageResult("ada", lesson.stage, MARKED, score, 60.0)
    return Feedback(
        Person("ada"), stage, (LessonFeedback(lesson, "04 · Trees", notebook, problems, parts),)
    )


def test_feedback_on_an_unstarted_stage_names_the_next_step_once():
    page = page_text(feedback_page(feedback_on((STUB, 0.0), (STUB, 0.0))))
    assert page.count("did not start") == 1
    assert "If you can still submit, replace raise NotImplementedError with your code" in page
    text = feedback_page(feedback_on((STUB, 0.0), problems=("It is cut off.",)))
    assert "exercise in this stage" not in page_text(text)
    assert "It is cut off." in text and 'href="#04_kd_tree"' in text and 'id="04_kd_tree"' in text
    assert 'href="#test_insert"' not in text


@pytest.mark.parametrize("other", [(WRONG, 6.25), (STUB, 2.0)])
def test_a_stage_with_an_answer_or_a_manual_mark_counts_as_started(other):
    page = page_text(feedback_page(feedback_on((STUB, 0.0), other)))
    assert "No exercise in this stage" not in page and "insert is not started." in page


def test_points_for_a_single_slip_are_explained():
    text = page_text(feedback_page(feedback_on((WRONG, 6.25))))
    kept = (
        "1 of the 18 checks passed. You still get 6.25 of 30 points, because a single slip "
        "explains every"
    )
    assert kept in text and "(+" not in text
    feedback = feedback_on((WRONG, 6.25))
    (exercise,) = feedback.lessons[0].exercises
    by_hand = dataclasses.replace(exercise, mark=CellMark(9.0, True, False))
    lesson = dataclasses.replace(feedback.lessons[0], exercises=(by_hand,))
    page = page_text(feedback_page(dataclasses.replace(feedback, lessons=(lesson,))))
    assert "You still get" not in page and "A grader entered these points." in page
    off = dataclasses.replace(exercise, counts=False)
    lesson = dataclasses.replace(feedback.lessons[0], exercises=(off,))
    page = page_text(feedback_page(dataclasses.replace(feedback, lessons=(lesson,))))
    assert "1 of the 18 checks passed." in page and "You still get" not in page


def test_each_score_names_its_function(pages):
    text = page_text(pages["bjorn"])
    assert "euclidean_clustering_accelerated 6.25 of 30" in text
    assert "match_boxes 2.25 of 5" in text
    assert "A grader entered these points. The score from the checks alone is 5." in text
    assert "Björn Müller: 36 of 70 points" in text  # 6.25 + 20 + 2.25 + 7.5


def test_a_page_shows_the_first_failure_in_full_and_the_rest_in_lines(pages):
    text = page_text(pages["bjorn"])
    assert "✗ Fix this first: It parts" in text
    assert "Hint: Compare <cells>." in text
    assert "12 more cannot be tested until this is right." in text
    assert text.count("This check waits") == 0
    assert "code cell 3, line 7 ( return a < b )" in text and "return a <= b" not in text
    assert "The last cell <b>breaks</b> off." in text


@pytest.mark.end_to_end
def test_written_answers_have_a_mark_and_a_comment(pages):
    page = pages["bjorn"]
    assert "write up 7.5 of 10" in page_text(page)
    assert "<em>unit</em>" in page and page.count("<math ") == 2
    assert "not graded yet, of 10" in page_text(pages["ada"])
    assert "Some answers still have to be graded by hand" in page_text(pages["ada"])
    assert "This answer is empty." in page_text(pages["cy"])


def test_missing_notebooks_are_shown_as_missing_and_not_as_0(pages):
    assert "10 · Clustering in real time missing, of 30" in page_text(pages["cy"])
    assert "Nothing was submitted." in page_text(pages["cy"])


def test_untrusted_text_is_escaped_and_nothing_is_fetched(pages):
    page = pages["bjorn"]
    assert "<script" not in page and "<i>" not in page and "<b>breaks" not in page
    assert 'src="' not in page and "url(" not in page
    assert set(re.findall(r'href="([^"]{,4})', page)) - {"http"} <= {
        link[:4] for link in ("#10_", "#12_", "#test_", "#second", "#write")
    }
    assert "default-src 'none'" in page


@pytest.mark.end_to_end
def test_pages_are_reproducible(canvas_course, pages, tmp_path, monkeypatch):
    run_feedback(canvas_course, monkeypatch, "--student", "bjorn", "--to", str(tmp_path / "again"))
    (path,) = (tmp_path / "again" / STAGE).iterdir()
    assert path.read_text("utf-8") == pages["bjorn"]


def test_students_are_found_by_name_and_missing_ones_are_reported(
    canvas_course, tmp_path, monkeypatch, capsys
):
    options = ("--student", "Björn Müller", "--student", "ADA")
    assert run_feedback(canvas_course, monkeypatch, *options, "--to", str(tmp_path)) == 0
    assert sorted(path.stem for path in (tmp_path / STAGE).iterdir()) == ["ada", "bjorn"]
    capsys.readouterr()
    options = ("--student", "cy", "--student", "noshow")
    assert run_feedback(canvas_course, monkeypatch, *options, "--to", str(tmp_path)) == 1
    assert "There is no feedback for noshow." in capsys.readouterr().err
    options = ("--student", "ada", "--student", "adda")
    assert run_feedback(canvas_course, monkeypatch, *options, "--to", str(tmp_path / "none")) == 2
    error = capsys.readouterr().err
    assert "'adda' is not on the roster" in error and "grader grade" not in error
    assert not (tmp_path / "none").exists()


@pytest.mark.slow
@pytest.mark.skipif(not browser.BROWSER, reason=CHROMIUM)
def test_a_browser_fetches_nothing_for_a_page_and_draws_its_formulas(pages, tmp_path):
    shown, requests = browser.rendered_page(pages["bjorn"], tmp_path, "example.org")
    assert requests == []
    assert "alert(" in shown and "<script" not in shown and "<mfrac>" in shown


def test_feedback_waits_until_the_verdict_is_entered(canvas_course, tmp_path, monkeypatch, capsys):
    path = canvas_course.verdicts / "ada" / STAGE / f"{TEN.name}.json"
    before = path.read_text("utf-8")
    try:
        path.write_text(before.replace("of ada", "of ada, again"), "utf-8")
        assert run_feedback(canvas_course, monkeypatch, "--to", str(tmp_path)) == 1
    finally:
        path.write_text(before, "utf-8")
    assert sorted(path.stem for path in (tmp_path / STAGE).iterdir()) == ["bjorn", "cy"]
    assert f"ada, {TEN.name}: the latest verdict is not in" in capsys.readouterr().err


def test_feedback_names_the_reason_if_a_notebook_was_not_judged(
    canvas_course, tmp_path, monkeypatch, capsys
):
    path = canvas_course.verdicts / "ada" / STAGE / f"{TEN.name}.json"
    before = path.read_text("utf-8")
    try:
        unjudged = {"status": "judge_failed", "problems": ["Code cell 7 needs Python 3.14."]}
        path.write_text(json.dumps(json.loads(before) | unjudged), "utf-8")
        assert run_feedback(canvas_course, monkeypatch, "--to", str(tmp_path)) == 1
    finally:
        path.write_text(before, "utf-8")
    assert f"ada, {TEN.name}: Code cell 7 needs Python 3.14." in capsys.readouterr().err


def test_a_course_without_grades_is_reported(tmp_path, monkeypatch, capsys):
    assert run_feedback(Course(tmp_path), monkeypatch, "--to", str(tmp_path / "out")) == 2
    assert "There is no feedback to write yet" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


# ---- nbgrader -----------------------------------------------------------------------------------


@pytest.mark.end_to_end
def test_pages_of_nbgrader_name_the_function_of_each_score(canvas_course):
    generate = make_converter(GenerateFeedback, canvas_course.root, STAGE)
    generate.coursedir.student_id = "bjorn"
    generate.start()
    page = (canvas_course.root / "feedback" / "bjorn" / STAGE / f"{TWELVE.name}.html").read_text()
    head = page_text(page.partition('<div class="panel-body">')[0])
    assert "match_boxes (Score: 2.25 / 5.0)" in head and "write_up (Score: 7.5 / 10.0)" in head
    assert "Test cell" not in page and "Written response" not in page
    assert "img { max-width: 100%" in page
    assert "<mfrac>" in page and "12 more cannot be tested" not in page
    ten = (canvas_course.root / "feedback" / "bjorn" / STAGE / f"{TEN.name}.html").read_text()
    assert "12 more cannot be tested until this is right." in ten


# ---- Canvas -------------------------------------------------------------------------------------


def parse_canvas(name):
    """Return (user, attachment) from a file name, as in Canvas's ``abstract_assignment.rb``."""
    parts = [part for part in name.split("_") if part != "LATE"]
    user, attachment = [part for part in parts if re.fullmatch(r"\d+", part)][:2]
    return user, int(attachment)


def archive(path):
    with zipfile.ZipFile(path) as opened:
        return {name: opened.read(name) for name in opened.namelist()}


def test_the_canvas_zip_contains_feedback_on_each_attachment(canvas_course, tmp_path, monkeypatch):
    assert run_feedback(canvas_course, monkeypatch, "--for", "canvas", "--to", str(tmp_path)) == 0
    files = archive(tmp_path / f"{STAGE}_canvas.zip")
    answered = {parse_canvas(name): name for name in files}
    numbers = {student: number for student, *_, number in PEOPLE}
    assert answered.keys() == {
        (numbers[student], attachment)
        for student, given in attachments(WORK).items()
        for attachment, _, _ in given
    }
    for name, content in files.items():
        lesson = find_lesson(name)
        notebook = nbformat.reads(content.decode(), as_version=4)
        nbformat.validate(notebook)
        head = html.unescape(notebook.cells[0].source)
        assert head.startswith("<div>") and f"<h1>{lesson.number} · " in head
    (name,) = [name for (user, _), name in answered.items() if user == "4002" and "12_" in name]
    text = "\n".join(cell.source for cell in nbformat.reads(files[name].decode(), 4).cells)
    assert "7.5 of 10" in text and "Mind the *unit*: $m$." in text
    assert "<script" not in text and "<i>" not in text


def test_html_in_a_notebook_is_a_single_markdown_block(canvas_course, tmp_path, monkeypatch):
    run_feedback(canvas_course, monkeypatch, "--for", "canvas", "--to", str(tmp_path))
    for content in archive(tmp_path / f"{STAGE}_canvas.zip").values():
        for cell in nbformat.reads(content.decode(), as_version=4).cells:
            if cell.source.startswith("<div>"):
                assert "\n\n" not in cell.source and "$" not in cell.source


def test_the_zip_is_reproducible(canvas_course, tmp_path, monkeypatch):
    for folder in ("one", "two"):
        run_feedback(canvas_course, monkeypatch, "--for", "canvas", "--to", str(tmp_path / folder))
    name = f"{STAGE}_canvas.zip"
    assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_student_who_submitted_a_zip_gets_a_zip(tmp_path, monkeypatch):
    inner = io.BytesIO(make_zip([(f"{lesson.name}.ipynb", data) for lesson, data in WORK["ada"]]))
    files = canvas_files("Lovelace, Ada", "4001", [(8123, "my work.zip", inner.getvalue())])
    course = make_course(tmp_path / "course", files)
    assert run_feedback(course, monkeypatch, "--for", "canvas", "--to", str(tmp_path)) == 0
    ((name, content),) = archive(tmp_path / f"{STAGE}_canvas.zip").items()
    assert parse_canvas(name) == ("4001", 8123) and name.endswith("_my work.zip")
    with zipfile.ZipFile(io.BytesIO(content)) as opened:
        assert opened.namelist() == [f"{STAGE}_feedback.html"]


@pytest.mark.end_to_end
def test_a_team_in_canvas_is_listed_without_an_error(tmp_path, monkeypatch, capsys):
    """Each member gets a page, but the zip for Canvas cannot contain it."""
    given = attachments(WORK)
    files = canvas_files("Team Red", "77", given["ada"])
    files += canvas_files("Yang, Cy", "4003", given["cy"])
    who = {"teamred_77": "ada,bjorn"}
    course = make_course(tmp_path / "course", files, decisions=who)
    assert run_feedback(course, monkeypatch, "--for", "canvas", "--to", str(tmp_path)) == 0
    printed = capsys.readouterr()
    assert "Not in the zip." in printed.out and "ada: submitted as teamred_77" in printed.out
    assert sorted(path.stem for path in (tmp_path / STAGE).iterdir()) == ["ada", "bjorn", "cy"]
    assert {parse_canvas(name)[0] for name in archive(tmp_path / f"{STAGE}_canvas.zip")} == {"4003"}


@pytest.mark.end_to_end
def test_a_class_of_teams_only_in_canvas_is_not_an_error(tmp_path, monkeypatch, capsys):
    files = canvas_files("Team Red", "77", attachments(WORK)["ada"])
    course = make_course(tmp_path / "course", files, decisions={"teamred_77": "ada,bjorn"})
    assert run_feedback(course, monkeypatch, "--for", "canvas", "--to", str(tmp_path)) == 0
    assert "ada: submitted as teamred_77" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.glob("*.zip")) == []


# ---- Moodle -------------------------------------------------------------------------------------


def parse_moodle(name):
    """Return (participant, file) from a file name, as in Moodle's ``importziplib.php``."""
    full_name, number, kind, plugin, file = name.split("_", 4)
    assert (kind, plugin) == ("assignsubmission", "file") and full_name
    return number, file


def moodle_course(root, teams=(), decisions=None):
    files, teams = [], dict(teams)
    for number, (student, first, last, *_) in enumerate(PEOPLE[:3], start=51):
        given = [(f"{lesson.name}.ipynb", data) for lesson, data in WORK[student]]
        if student not in list(teams)[1:]:  # a team has only one submission
            files += moodle_files(*teams.get(student, (f"{first} {last}", number)), given)
    return make_course(root, files, decisions=decisions)


@pytest.mark.end_to_end
def test_the_moodle_zip_contains_a_page_for_each_student(tmp_path, monkeypatch, capsys):
    course = moodle_course(tmp_path / "course")
    assert run_feedback(course, monkeypatch, "--for", "moodle", "--to", str(tmp_path)) == 0
    files = archive(tmp_path / f"{STAGE}_moodle.zip")
    assert {parse_moodle(name) for name in files} == {
        (str(number), f"{STAGE}_feedback.html") for number in (51, 52, 53)
    }
    (page,) = [content for name, content in files.items() if parse_moodle(name)[0] == "52"]
    assert page == (tmp_path / STAGE / "bjorn.html").read_bytes()
    assert "Upload multiple feedback files in a zip" in capsys.readouterr().out


@pytest.mark.end_to_end
@pytest.mark.parametrize("is_team", [False, True])
def test_a_student_with_two_moodle_assignments_gets_a_page_in_each(
    tmp_path, monkeypatch, capsys, is_team
):
    files = {TEN: [], TWELVE: []}
    for place, (student, first, last, *_) in enumerate(PEOPLE[:3]):
        for lesson, data in WORK[student]:
            owner = (f"{first} {last}", {TEN: 21, TWELVE: 31}[lesson] + place)
            if is_team and student == "ada" and lesson == TEN:
                owner = ("Team Red", 21)
            files[lesson] += moodle_files(*owner, [(f"{lesson.name}.ipynb", data)])
    who = {"Team Red_21": "ada"} if is_team else None
    course = make_course(tmp_path / "course", files[TEN], files[TWELVE], decisions=who)
    assert run_feedback(course, monkeypatch, "--for", "moodle", "--to", str(tmp_path)) == 0
    numbers = {parse_moodle(name)[0] for name in archive(tmp_path / f"{STAGE}_moodle.zip")}
    given = {
        str({TEN: 21, TWELVE: 31}[lesson] + place)
        for place, (student, *_) in enumerate(PEOPLE[:3])
        for lesson, _ in WORK[student]
    }
    assert len(given) > 3 and numbers == given - ({"21"} if is_team else set())
    assert ("ada: submitted as Team Red" in capsys.readouterr().out) == is_team


def test_students_not_collected_from_moodle_are_listed(
    canvas_course, tmp_path, monkeypatch, capsys
):
    assert run_feedback(canvas_course, monkeypatch, "--for", "moodle", "--to", str(tmp_path)) == 1
    # Canvas's numbers must not be taken for Moodle's.
    assert not (tmp_path / f"{STAGE}_moodle.zip").exists()
    assert "bjorn: the work was not collected from a Moodle zip" in capsys.readouterr().out


@pytest.mark.end_to_end
def test_a_team_is_not_taken_for_a_participant(tmp_path, monkeypatch, capsys):
    answers = {"Team Red_53": "ada,bjorn"}
    teams = {"ada": ("Team Red", 53), "bjorn": ("Team Red", 53)}
    course = moodle_course(tmp_path / "course", teams, answers)
    assert run_feedback(course, monkeypatch, "--for", "moodle", "--to", str(tmp_path)) == 0
    assert [parse_moodle(name)[0] for name in archive(tmp_path / f"{STAGE}_moodle.zip")] == ["53"]
    printed = capsys.readouterr()
    assert "bjorn: submitted as Team Red, which may be a team" in printed.out
    assert printed.err.count("No feedback was written") == 0
    waiting = f"still have to be graded by hand:\n  {TWELVE.name} for ada, bjorn\n"
    assert waiting in printed.out
    assert sorted(path.stem for path in (tmp_path / STAGE).iterdir()) == ["ada", "bjorn", "cy"]
