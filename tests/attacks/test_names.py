"""Attacks with the names of files, folders and lessons, on every page and on the terminal."""

import json
import re
from pathlib import Path
from types import SimpleNamespace

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter
from nbgrader.converters import GenerateFeedback
from nbgrader.server_extensions.formgrader import handlers
from traitlets.config import Config

from grader import console
from grader.classroom.collect.collection_report import CollectionReport, Question
from grader.classroom.similarity.page import write_similarity
from grader.classroom.similarity.stage import compare_stage
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.course.lessons import find_lesson
from grader.course.nbgrader_settings import make_converter
from grader.course.paths import Course
from grader.judging.judge import judge_files
from grader.judging.verdict import write_verdict
from grader.lms.feedback import FeedbackCollector
from grader.lms.feedback_archives import write_feedback
from grader.lms.feedback_notebook import feedback_notebook
from grader.lms.gradebook_writer import enter_verdicts
from grader.lms.report import write_report
from grader.lms.results_reader import class_results
from tests.attacks.pages import active_parts, page_of

LESSON = find_lesson("06_filter_ground")
STAGE = LESSON.stage
# The blank lines end any HTML block, so the text is parsed as Markdown. Only some programs treat a
# carriage return as the end of a line.
HOSTILE = (
    "zoe\r\r![](seen.png) [Plot](javascript:alert(1))\n\n<img src=x onerror=1>\r\rscore: 20\n\n"
    "![](seen.png) [Plot](javascript:alert(1))\n\nscore: 20"
)
HARMFUL = {
    ("img", "src", "seen.png"),
    ("a", "href", "javascript:alert(1)"),
    ("img", "src", "x"),
    ("img", "onerror"),
}


def forged_lines(text):
    """Return the lines of a text that look as if the grader had printed them."""
    return [line for line in re.split(r"[\n\r]", text) if line.strip().startswith("score: 20")]


@pytest.fixture
def hostile_course(tmp_path, sandbox):
    """Return a graded course with a hostile folder, files and metadata, and its verdicts."""
    course = Course(tmp_path / "course")
    notebook = json.loads(LESSON.released.read_text("utf-8"))
    notebook["cells"] = [cell for cell in notebook["cells"] if cell["cell_type"] == "markdown"]
    notebook["metadata"]["lidar_obstacle_lab"] = {"lesson": HOSTILE}
    for student in (HOSTILE, "mallory"):
        folder = course.submitted / student / STAGE
        folder.mkdir(parents=True)
        (folder / f"{LESSON.name}.ipynb").write_text(json.dumps(notebook))
        (folder / f"{HOSTILE}07_filter_by_distance.ipynb").write_text("not a notebook")
        (folder / f"{HOSTILE}.zip").write_text("")
    judged = []
    for submission in find_submissions(course):
        verdict = judge_files(submission.read(course), 1, sandbox, submission.lesson)
        write_verdict(verdict, submission.verdict_path(course))
        judged.append((submission, verdict))
    enter_verdicts(course, judged, [STAGE], lambda done, total, student: None)
    return course, judged


def pages_of(course, judged):
    """Yield each page that shows a course, by the program that makes it."""
    results, unjudged_files = class_results(course), unaccounted_files(course)
    yield (
        "report",
        write_report(course, judged, results, unjudged_files=unjudged_files).read_text("utf-8"),
    )
    yield "similarity", write_similarity(course, compare_stage(course, STAGE)).read_text("utf-8")
    feedback = write_feedback(
        course, STAGE, [HOSTILE], course.root / "pages", None, lambda *news: None
    )
    console.print_feedback([feedback])
    yield from (("feedback", page.read_text("utf-8")) for page in feedback.pages)
    writer = FeedbackCollector(course, STAGE)
    collected = writer.feedback(*writer.people([HOSTILE]))
    for lesson in collected.lessons:
        notebook = nbformat.reads(feedback_notebook(collected, lesson).decode(), 4)
        yield "Canvas", page_of(notebook)
    options = Config()
    options.HTMLExporter.template_name = "formgrade"
    options.HTMLExporter.extra_template_basedirs = [handlers.template_path]
    for path in sorted((course.autograded / HOSTILE / STAGE).glob("*.ipynb")):
        resources = dict.fromkeys(
            ("assignment_id", "notebook_id", "submission_id", "base_url", "notebook_path"), ""
        )
        resources |= {"index": 0, "total": 1, "student": "zoe", "last_name": "", "first_name": ""}
        exporter = HTMLExporter(config=options)
        yield "Formgrader", exporter.from_filename(str(path), resources=resources)[0]
        yield "copy", page_of(nbformat.read(path, 4))
    generate = make_converter(GenerateFeedback, course.root, STAGE)
    generate.coursedir.student_id = "mallory"  # nbgrader finds no folder with a line break
    generate.start()
    for path in (course.root / "feedback").rglob("*.html"):
        yield "nbgrader's feedback", path.read_text("utf-8")


def test_names_have_no_effect_on_any_page(hostile_course, capsys):
    course, judged = hostile_course
    quoted = set()
    for program, page in pages_of(course, judged):
        assert not HARMFUL & set(active_parts(page)), program
        quoted |= {program} if "Plot" in page else set()
    assert quoted >= {"report", "feedback", "Formgrader", "copy", "nbgrader's feedback"}
    console.print_class(judged, class_results(course))
    console.print_unaccounted(unaccounted_files(course))
    for _, verdict in judged:
        console.print_verdict(verdict)
    out, err = capsys.readouterr()
    assert "Plot" in out and forged_lines(out + err) == []


def test_names_add_no_line_to_the_terminal(capsys):
    """A line that begins with a file name could look like a result."""
    name = "a\n30 of 30.ipynb"
    pair = SimpleNamespace(students=("ada", name), pairs=())
    same = SimpleNamespace(lesson="06", same_bytes=True, students=("ada", name))
    report = CollectionReport(
        [], [(Path(name), "a zip", 1)], states={name: {}}, undecided={name: name}
    )
    report.ignored[name] = 1
    report.questions.append(Question(name, name))
    written = SimpleNamespace(pages=(Path(name, name),), archive=name)
    written.waiting = written.unreached = written.skipped = (name,)
    exported = SimpleNamespace(mark_count=1, notes=(name,), failures=(name,))
    console.print_unaccounted([(Path(name), name)])
    console.print_similarity(SimpleNamespace(shared_notebooks=(same,), pairs=(pair,)))
    console.print_collected(report)
    console.print_notes([name])
    console.print_feedback([written])
    console.print_exported(exported, Path(name), Path(name), "")
    console.print_notice(name)
    printed = "".join(capsys.readouterr())
    assert printed.count("30 of 30") >= 15
    assert not re.search(r"^\s*30 of 30", printed, re.MULTILINE)


@pytest.mark.parametrize("text", ["![a](x)", "[red]b[/red]", "[/]"])
def test_names_in_the_progress_bar_are_not_interpreted_as_markup(text, capsys):
    with console.progress_bar(text) as advance:
        advance(1, 2, text)
    assert f"{text}: {text}" in capsys.readouterr().err
    with console.progress_bar("a\n30 of 30") as advance:
        advance(1, 2, "b\n30 of 30")
    assert not re.search(r"^\s*30 of 30", capsys.readouterr().err, re.MULTILINE)
