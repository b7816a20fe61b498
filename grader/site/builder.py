"""Build the website: write the Sphinx sources, run Sphinx, clean up, and check the result."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from grader.course.build import Origin
from grader.course.lessons import Lesson, every_lesson
from grader.course.settings import course_title
from grader.course.standalone import check_no_leaks, make_standalone
from grader.site import front_page, glossary, guides, mathjax, pdf, sections, site_checks
from grader.site.errors import SiteError
from grader.site.html_outputs import TEMPLATES
from grader.site.lesson import links_of, page_of
from grader.site.live.files import FOLDER as LIVE_FOLDER
from grader.site.live.files import LiveFiles
from grader.site.pictures import Pictures
from grader.site.settings import conf_source
from grader.site.sharing import picture, picture_address

STATIC = Path(__file__).parent / "static"
SHARED_PICTURE = "_static/sharing.png"
THEME = Path(__file__).parent / "templates" / "theme"
SITE_MARKER = "searchindex.js"  # a folder that contains this file is recognised as a site
# 1 January 1980, in seconds since 1970. With a fixed date, the site does not depend on the clock.
SOURCE_DATE = "315532800"
REPLACEMENTS = {
    # The icons come from a font, so this 1.5 MB script is not needed.
    re.compile(r' *<script [^>]*src="[^"]*fontawesome\.js[^"]*"></script>\n'): "",
    # These labels differ from the visible text. Without them, screen readers read that text.
    re.compile(r'(<summary) aria-label="Toggle hidden content"'): r"\1",
    re.compile(r'(<button class="btn search-button-field [^>]*?) aria-label="Search"'): r"\1",
    re.compile(r'(<div id="pst-primary-sidebar")'): r'\1 role="region" aria-label="Course"',
}
"""Patterns in the finished pages, and their replacements."""
REQUIRED_PACKAGES = ("sphinx", "myst_nb", "sphinx_book_theme", "sphinx-mathjax-offline")
DELETED_PATTERNS = (
    "*.map",
    "*webpack-macros.html",
    "*.LICENSE.txt",
    "fontawesome.js",
    ".buildinfo",
    "objects.inv",
    "locales",
    "_sources",
)


def write_site(
    folder: Path,
    solved_runs: Mapping[Lesson, bytes],
    origin: Origin,
    live: LiveFiles | None = None,
    browser: str = "",
) -> None:
    """Write the site. The same outputs always give the same bytes, except in a PDF file.

    Parameters
    ----------
    folder : pathlib.Path
        Replaced if it contains a site, and created if it does not exist.
    solved_runs : mapping of Lesson to bytes
        Executed notebooks, from `grader.site.runs.solved_runs`. The page of a missing lesson has
        no outputs.
    origin : grader.course.build.Origin
    live : grader.site.live.files.LiveFiles, optional
        Files with which the lessons run in the browser.
    browser : str, default ""
        Program that prints the lessons into one PDF file, from `grader.site.pdf.find_browser`; ""
        for a site without this file.

    Raises
    ------
    SiteError
        If a package is missing, if `folder` contains anything except a site, if Sphinx or the
        browser fails, or if `grader.site.site_checks` finds a fault.
    """
    check_ready(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".site-", dir=folder.parent) as source_folder:
        source, pages = Path(source_folder) / "source", Path(source_folder) / "pages"
        for name, content in source_files(solved_runs, origin, live, bool(browser)).items():
            path = source / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        _run_sphinx(source, pages)
        _clean_up_pages(pages)
        if browser:
            pdf.print_site(pages, browser)
        if faults := site_checks.find_faults(pages):
            raise SiteError("\n".join(faults))
        if folder.exists():
            shutil.rmtree(folder)
        os.replace(pages, folder)


def check_ready(folder: Path) -> None:
    """Check, before a long build, that the site can be written.

    Raises
    ------
    SiteError
        If a package is missing, or if `folder` contains anything except a site.
    """
    if missing := [name for name in REQUIRED_PACKAGES if not importlib.util.find_spec(name)]:
        raise SiteError(
            f"The website needs packages that are not installed: {', '.join(missing)}. Run: "
            "pip install -r requirements-site.txt (or `make site`, which installs them)."
        )
    if folder.exists() and any(folder.iterdir()) and not (folder / SITE_MARKER).is_file():
        raise SiteError(f"{folder} contains something other than a website. Choose another folder.")


def source_files(
    solved_runs: Mapping[Lesson, bytes], origin: Origin, live: LiveFiles | None, has_pdf: bool
) -> dict[str, bytes]:
    """Return all files that Sphinx reads, by path.

    See `write_site` for the parameters. If `has_pdf`, the front page links to the PDF file.
    """
    pictures, shared = Pictures(), picture()
    files = {
        "conf.py": conf_source(
            live.settings() if live else None,
            picture_address(origin, SHARED_PICTURE) if shared else "",
        ),
        "index.md": front_page.page(origin, pictures, pdf.FILE if has_pdf else ""),
    }
    files |= {f"{name}.md": guides.page(name, origin, pictures) for name in guides.PAGES}
    files["words.md"] = glossary.page()
    sources = {name: text.encode() for name, text in files.items()}
    for lesson in every_lesson():
        links, name = links_of(lesson, origin), f"{lesson.stage}/{lesson.name}.ipynb"
        solved = solved_runs.get(lesson) or lesson.solved.read_bytes()
        sources[name] = page_of(lesson, solved, links, pictures)
        notebook = make_standalone(lesson.released.read_bytes())
        check_no_leaks(lesson, notebook)
        sources[f"extra/notebooks/{lesson.name}.ipynb"] = notebook
    sources |= {f"_static/{path.name}": path.read_bytes() for path in sorted(STATIC.iterdir())}
    sources |= {f"_templates/{path.name}": path.read_bytes() for path in sorted(THEME.iterdir())}
    if live:
        sources |= {f"extra/{LIVE_FOLDER}/{name}": file for name, file in live.files.items()}
    if shared:
        sources[SHARED_PICTURE] = shared
    page = TEMPLATES.get_template("404.html").render(course=course_title(), marker=SITE_MARKER)
    sources["extra/404.html"] = page.encode()  # most servers show it at missing addresses
    # Without this file, GitHub Pages does not serve files whose names begin with `_`.
    sources["extra/.nojekyll"] = b""
    return sources | pictures.files | mathjax.mathjax_files()


def _run_sphinx(source: Path, pages: Path) -> None:
    """Build the pages with Sphinx. Warnings are errors."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    process = subprocess.run(
        [*command, "-d", str(source.parent / "read"), str(source), str(pages)],
        env=os.environ | {"SOURCE_DATE_EPOCH": SOURCE_DATE, "PYTHONHASHSEED": "0"},
        capture_output=True,
        text=True,
    )
    if process.returncode:
        raise SiteError(f"Sphinx ended with {process.returncode}:\n{process.stderr[-3000:]}")


def _clean_up_pages(pages: Path) -> None:
    """Delete files that no page needs, fix details of the theme, and add the search script."""
    for pattern in DELETED_PATTERNS:
        for path in pages.rglob(pattern):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in pages.rglob("*.html"):
        text = path.read_text("utf-8")
        for regex, replacement in REPLACEMENTS.items():
            text = regex.sub(replacement, text)
        path.write_text(text, "utf-8")
    sections.write(pages)
