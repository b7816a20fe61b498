"""Print the lessons and the glossary of a finished site into one PDF file, with Chromium.

One page of HTML contains everything, so all links between lessons work in the file, and Chromium
numbers its sheets.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from urllib.parse import urljoin, urlsplit

from grader.course.lessons import every_lesson
from grader.course.settings import course_title, version
from grader.site.errors import SiteError
from grader.site.front_page import stage_titles
from grader.site.html_outputs import TEMPLATES

FILE = "course.pdf"
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
GLOSSARY = "words.html"
ARTICLE = re.compile(r'<article class="bd-article">(.*?)</article>', re.S)
TITLE = re.compile(r"<h1>(.*?)</h1>", re.S)
# Pages have a picture of each scene for paper.
FOR_SCREENS = re.compile(
    r'<a class="headerlink".*?</a>|<iframe class="scene".*?</iframe>| loading="lazy"', re.S
)
TAG = re.compile(r"<[a-zA-Z][^>]*>")
ADDRESS = re.compile(r' (id|href|src|poster)="([^"]*)"')
STYLE = re.compile(r'<link (?=[^>]*rel="stylesheet")[^>]*>')
# Formulas need their script. The other scripts of a page serve readers on a screen.
FORMULAS = re.compile(r"<script>window\.MathJax.*?</script>|<script [^>]*mathjax[^>]*></script>")
# Milliseconds of virtual time for the scripts of the page. It passes while the page waits, but not
# while it computes.
TIME_BUDGET = 100_000


def find_browser() -> str:
    """Return the path of Chromium.

    Raises
    ------
    SiteError
        If Chromium is not installed.
    """
    for name in BROWSERS:
        if path := shutil.which(name):
            return path
    raise SiteError("`site --pdf` needs Chromium. Run: sudo apt-get install chromium")


def print_site(folder: Path, browser: str) -> Path:
    """Print the lessons of the site in `folder`, and return the path of the file.

    Raises
    ------
    SiteError
        If Chromium fails.
    """
    source, path = folder / "print.html", folder / FILE
    source.write_text(whole_course(folder), "utf-8")
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser,
            # The page comes from this course, and containers rarely allow Chromium's own sandbox.
            *("--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"),
            *("--disable-background-networking", "--no-first-run", f"--user-data-dir={profile}"),
            *("--no-pdf-header-footer", "--generate-pdf-document-outline"),
            *(f"--virtual-time-budget={TIME_BUDGET}", f"--print-to-pdf={path}", source.as_uri()),
        ]
        # Chromium's lock is in TMPDIR, or in /tmp, which may be read-only.
        env = {**os.environ, "TMPDIR": tempfile.gettempdir()}
        process = subprocess.run(command, env=env, capture_output=True, text=True)
    source.unlink()
    if process.returncode or not path.is_file():
        raise SiteError(f"Chromium did not print the lessons: {process.stderr[-1000:]}")
    return path


def whole_course(folder: Path) -> str:
    """Return one page of HTML with all lessons and the glossary of the site in `folder`."""
    names = {f"{lesson.stage}/{lesson.name}.html": lesson.stage for lesson in every_lesson()}
    pages = {name: (folder / name).read_text("utf-8") for name in (*names, GLOSSARY)}
    heads = [
        _moved(tag, name, pages)
        for name, page in pages.items()
        for tag in (*STYLE.findall(page), *FORMULAS.findall(page))
    ]
    articles = {name: FOR_SCREENS.sub("", ARTICLE.search(page)[1]) for name, page in pages.items()}
    stages = {
        title: [name for name in names if names[name] == stage] for stage, title in stage_titles()
    }
    return TEMPLATES.get_template("print.html").render(
        course=course_title(),
        version=version(),
        head=[*dict.fromkeys(heads)],
        stages=stages,
        glossary=GLOSSARY,
        titles={name: TITLE.search(article)[1] for name, article in articles.items()},
        articles={name: _moved(article, name, pages) for name, article in articles.items()},
    )


def _moved(html: str, name: str, pages: dict[str, str]) -> str:
    """Adapt the addresses in a part of the page `name` to a page that contains all `pages`."""

    def adapt(match: re.Match) -> str:
        kind, address = match.groups()
        if kind == "id":
            return f' id="{name}:{address}"'
        parts = urlsplit(address)
        if parts.scheme:
            return match[0]
        path = urljoin(name, parts.path)
        if kind != "href" or path.endswith(".css"):
            return f' {kind}="{path}"'
        if path not in pages:
            return ""  # other pages of the site are not in the file
        return f' href="#{path}:{parts.fragment}"' if parts.fragment else f' href="#{path}"'

    return TAG.sub(lambda tag: ADDRESS.sub(adapt, tag[0]), html)
