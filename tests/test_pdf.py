"""All lessons and the glossary are printed into one PDF file, in which links lead to lessons."""

import re
import shutil
import tempfile

import pytest

from grader import cli
from grader.course.lessons import every_lesson
from grader.site import builder, pdf
from tests.browser import BROWSER, PDF_TO_TEXT, sheets_of
from tests.prerequisites import PDF_TO_TEXT as NEEDED

LESSONS = [f"{lesson.stage}/{lesson.name}.html" for lesson in every_lesson()]
FIRST, SECOND, FOURTH = LESSONS[0], LESSONS[1], LESSONS[3]
BODY = f"""
<nav class="run"><a href="../notebooks/{every_lesson()[0].name}.ipynb">Download</a></nav>
<p><a href="{SECOND.split("/")[1]}#top">next</a> <a href="../{FOURTH}">later</a>
<a href="../words.html#term-inlier">inlier</a> <a href="#top">up</a>
<a href="../students.html">guide</a> <a href="https://example.org/a">out</a></p>
<p><img src="../_static/dot.png" alt="" loading="lazy" width="3" height="3"></p>
<div><div class="still">a picture</div><iframe class="scene" src="../scene.html"></iframe></div>
<details><summary>Hint 1</summary>Count.<details><summary>Hint 2</summary>Look.</details></details>
<details class="answer" data-question="q"><summary>How many?</summary>Seven</details>
<div class="cell_output"><details><summary>A. (1, 2)</summary>Right.</details></div>
<details class="hide above-input"><summary>Code: Tools</summary>import tools</details>
<form class="guess"><label>How many? <input type="range"></label></form>
<div class="cell_input"><div class="highlight"><pre>{"x" * 99}!</pre></div></div>
"""


def page(title, to_root, body):
    return f"""<head><link href="{to_root}_static/a.css?digest=1" rel="stylesheet" />
    <script>window.MathJax = {{}}</script><script src="{to_root}_static/site.js"></script>
    <script defer="defer" src="{to_root}_static/mathjax/tex.js?v=1"></script></head>
    <h1>{title}</h1><article class="bd-article"><section id="top">
    <h1>{title}<a class="headerlink" href="#top">#</a></h1>{body}</section></article>"""


@pytest.fixture
def site(tmp_path):
    """Return a folder with a short page for each lesson, and with the site's style sheet."""
    for number, name in enumerate(LESSONS, start=1):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(page(f"Lesson {number}", "../", BODY if name == FIRST else ""), "utf-8")
    glossary = page("Words", "", '<dl><dt id="term-inlier">inlier</dt><dd>near</dd></dl>')
    (tmp_path / "words.html").write_text(glossary, "utf-8")
    (tmp_path / "_static").mkdir()
    shutil.copy(builder.STATIC / "site.css", tmp_path / "_static" / "a.css")
    return tmp_path


def test_links_between_lessons_stay_in_the_file(site):
    whole = pdf.whole_course(site)
    names = re.findall(r' id="([^"]*)"', whole)
    assert len(names) == len(set(names)) and set(LESSONS) < set(names)
    links = re.findall(r' href="([^"]*)"', whole.partition("</head>")[2])
    inside = {link.removeprefix("#") for link in links if link.startswith("#")}
    assert inside <= set(names)
    assert inside >= {*LESSONS, f"{FIRST}:top", f"{SECOND}:top", "words.html:term-inlier"}
    assert [link for link in links if not link.startswith("#")] == ["https://example.org/a"]
    assert "<a>guide</a>" in whole, "a page that is not in the file is not linked"


def test_the_page_has_the_styles_and_formulas_and_pictures_of_the_lessons(site):
    head, _, body = pdf.whole_course(site).partition("</head>")
    assert head.count('href="_static/a.css"') == head.count('src="_static/mathjax/tex.js"') == 1
    assert "window.MathJax" in head and "site.js" not in head
    assert 'src="_static/dot.png"' in body and "lazy" not in body and "<iframe" not in body


def test_without_chromium_one_sentence_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert cli.main(["site", "--pdf", "--to", str(tmp_path / "site")]) == 1
    assert capsys.readouterr().err == (
        "`site --pdf` needs Chromium. Run: sudo apt-get install chromium\n"
    )
    assert not (tmp_path / "site").exists()


def test_chromium_gets_a_writable_folder_where_tmp_is_read_only(site, monkeypatch, tmp_path):
    monkeypatch.delenv("TMPDIR", raising=False)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$TMPDIR" > "{site}/course.pdf"\n')
    browser.chmod(0o755)
    assert pdf.print_site(site, str(browser)).read_text() == f"{tmp_path}\n"


@pytest.mark.slow
@pytest.mark.skipif(not BROWSER or not PDF_TO_TEXT, reason=NEEDED)
def test_the_file_has_all_lessons_in_order_on_numbered_sheets(site):
    path = pdf.print_site(site, BROWSER)
    assert path == site / "course.pdf" and not (site / "print.html").exists()
    sheets = sheets_of(path)
    texts = ["\n".join(sheet) for sheet in sheets]
    assert all(f"Lesson {number}\n" in texts[0] for number in range(1, len(LESSONS) + 1))
    firsts = [next(line for line in sheet if line.strip()).strip() for sheet in sheets[1:]]
    assert firsts == [*(f"Lesson {number}" for number in range(1, len(LESSONS) + 1)), "Words"]
    lasts = [[line for line in sheet if line.strip()][-1].strip() for sheet in sheets[1:]]
    assert lasts == [str(number) for number in range(2, len(sheets) + 1)]
    assert "x" * 99 + "!" in texts[1], "a line of 100 characters is not broken"
    assert all(word in texts[1] for word in ("Count.", "Look.", "Seven", "(1, 2)", "a picture"))
    assert not any(word in texts[1] for word in ("import tools", "Right.", "Download"))
    content = path.read_bytes()
    assert b"/Outlines" in content and b"/Dest" in content
