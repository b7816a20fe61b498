"""The whole site: sources for Sphinx, Sphinx itself, what is taken out again, and the proof."""

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
from grader.course.standalone import refuse_to_give_away, standalone
from grader.site import front_page, glossary, guides, mathjax, sections, site_checks
from grader.site.errors import SiteTrouble
from grader.site.lesson import links_of, page_of
from grader.site.live import write_live
from grader.site.pictures import Pictures
from grader.site.settings import conf

OWN = Path(__file__).parent / "static"
THEME = Path(__file__).parent / "templates" / "theme"
MARK = "searchindex.js"  # by which a folder is known as a site
EARLIEST = "315532800"  # 1 January 1980: no clock is to be seen in a site
MENDED = {
    # The icons come from a font; this script of 1.5 MB would draw them a second time.
    re.compile(r' *<script [^>]*src="[^"]*fontawesome\.js[^"]*"></script>\n'): "",
    # What is read aloud is what is seen.
    re.compile(r'(<summary) aria-label="Toggle hidden content"'): r"\1",
    re.compile(r'(<button class="btn search-button-field [^>]*?) aria-label="Search"'): r"\1",
    re.compile(r'(<div id="pst-primary-sidebar")'): r'\1 role="region" aria-label="Course"',
}
"""What a page has by then, and what it gets instead."""
NEEDED = (
    *("sphinx", "myst_nb", "sphinx_book_theme", "sphinx-mathjax-offline"),
    *("jupyterlite_core", "jupyterlite_pyodide_kernel"),
)
LEFT_OUT = (
    "*.map",
    "*webpack-macros.html",
    "*.LICENSE.txt",
    "fontawesome.js",
    ".buildinfo",
    "objects.inv",
    "locales",
)


def write_site(
    folder: Path, ran: Mapping[Lesson, bytes], origin: Origin, live: bool = False
) -> None:
    """Write the site; the same bytes for the same runs.

    Parameters
    ----------
    folder : pathlib.Path
        Replaced, where it holds a site; made, where there is none.
    ran : mapping of Lesson to bytes
        By `grader.site.runs.solved_runs`; the page of one that is missing shows no outputs.
    origin : grader.course.build.Origin
    live : bool
        Whether there is a page for each lesson on which it runs in the browser, too.

    Raises
    ------
    SiteTrouble
        `folder` holds something else, Sphinx has something to say, or a page would give a
        solution away, ask another host, or link to what is not there.
    """
    ready(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".site-", dir=folder.parent) as place:
        source, pages = Path(place) / "source", Path(place) / "pages"
        for name, content in source_files(ran, origin, live).items():
            path = source / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        _run_sphinx(source, pages)
        _finish(pages)
        if live:
            write_live(pages, Path(place) / "live")
        if faults := site_checks.faults(pages):
            raise SiteTrouble("\n".join(faults))
        if folder.exists():
            shutil.rmtree(folder)
        os.replace(pages, folder)


def ready(folder: Path) -> None:
    """Look before long work whether a site can be written; raise `SiteTrouble` where not."""
    if missing := [name for name in NEEDED if not importlib.util.find_spec(name)]:
        raise SiteTrouble(
            f"For a site {', '.join(missing)} must be installed: "
            "pip install -r requirements-site.txt. `make site` does that by itself."
        )
    if folder.exists() and any(folder.iterdir()) and not (folder / MARK).is_file():
        raise SiteTrouble(f"{folder} holds something else than a site. Name another folder.")


def source_files(ran: Mapping[Lesson, bytes], origin: Origin, live: bool) -> dict[str, bytes]:
    """All that Sphinx reads, by name; the parameters are those of `write_site`."""
    pictures = Pictures()
    files = {"conf.py": conf(), "index.md": front_page.page(origin, pictures)}
    files |= {f"{name}.md": guides.page(name, origin, pictures) for name in guides.PAGES}
    files["words.md"] = glossary.page()
    found = {name: text.encode() for name, text in files.items()}
    for lesson in every_lesson():
        links, name = links_of(lesson, origin, live), f"{lesson.stage}/{lesson.name}.ipynb"
        solved = ran.get(lesson) or lesson.solved.read_bytes()
        found[name] = page_of(lesson, solved, links, pictures)
        notebook = standalone(lesson.released.read_bytes())
        refuse_to_give_away(lesson, notebook)
        found[f"beside/notebooks/{lesson.name}.ipynb"] = notebook
    found |= {f"_static/{path.name}": path.read_bytes() for path in sorted(OWN.iterdir())}
    found |= {f"_templates/{path.name}": path.read_bytes() for path in sorted(THEME.iterdir())}
    found["beside/.nojekyll"] = b""  # GitHub Pages would leave out what begins with `_`
    return found | pictures.files | mathjax.files()


def _run_sphinx(source: Path, pages: Path) -> None:
    """Make the pages; what Sphinx warns of is a fault."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html"]
    done = subprocess.run(
        [*command, "-d", str(source.parent / "read"), str(source), str(pages)],
        env=os.environ | {"SOURCE_DATE_EPOCH": EARLIEST, "PYTHONHASHSEED": "0"},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        raise SiteTrouble(f"Sphinx ended with {done.returncode}:\n{done.stderr[-3000:]}")


def _finish(pages: Path) -> None:
    """Take out what no reader needs, and mend what the theme leaves."""
    for pattern in LEFT_OUT:
        for path in pages.rglob(pattern):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
    for path in pages.rglob("*.html"):
        text = path.read_text("utf-8")
        for found, instead in MENDED.items():
            text = found.sub(instead, text)
        path.write_text(text, "utf-8")
    sections.write(pages)
