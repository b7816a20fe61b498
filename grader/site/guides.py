"""Build the pages for the guides in ``docs/``, the README for students and the data card."""

from __future__ import annotations

import posixpath
import re

from grader.course.build import Origin
from grader.course.lessons import every_lesson
from grader.course.paths import PROJECT
from grader.site.pictures import Pictures

PAGES = {
    "students": "notebooks/README.md",
    "data": "data/README.md",
    "instructors": "docs/instructors.md",
    "teaching": "docs/teaching.md",
    "grading": "docs/grading.md",
    "prices": "docs/prices.md",
    "commands": "docs/commands.md",
    "nbgrader": "docs/platforms/nbgrader.md",
    "canvas_and_moodle": "docs/platforms/canvas_and_moodle.md",
    "gradescope": "docs/platforms/gradescope.md",
    "jupyterhub": "docs/platforms/jupyterhub.md",
    "cluster": "docs/platforms/cluster.md",
    "website": "docs/platforms/website.md",
    "privacy": "docs/privacy.md",
    "security": "docs/security.md",
    "authors": "docs/authors.md",
    "developers": "docs/developers.md",
    "benchmarks": "docs/benchmarks.md",
}
"""The source file of each page, in the order of the table of contents."""
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
CODE = re.compile(r"(^ *```.*?^ *```|`[^`\n]+`)", re.M | re.S)


def page(name: str, origin: Origin, pictures: Pictures) -> str:
    """Return a guide as Markdown for MyST.

    Parameters
    ----------
    name : str
        One of `PAGES`.
    origin : grader.course.build.Origin
        Repository to which links lead if a file has no page. If the repository has no address,
        these links become plain text.
    pictures : Pictures
        Collection to which the pictures of the guide are added.
    """
    path = PROJECT / PAGES[name]
    folder = posixpath.dirname(PAGES[name])

    def replace_link(match: re.Match) -> str:
        mark, text, target = match.groups()
        place, _, fragment = target.partition("#")
        if ":" in target or not place:
            return match[0]
        place = posixpath.normpath(posixpath.join(folder, place))
        if mark:
            picture = pictures.keep((PROJECT / place).read_bytes(), posixpath.splitext(place)[1])
            return f"![{' '.join(text.split())}](/{picture})"
        if place in _pages():
            return f"[{text}]({_pages()[place]}{'#' + fragment if fragment else ''})"
        if origin.repository:
            return f"[{text}]({origin.repository}/blob/{origin.revision}/{place})"
        return text

    parts = CODE.split(path.read_text("utf-8"))
    # Code is masked rather than left out, because it cannot contain links but may be link text.
    masked = "".join(part if n % 2 == 0 else f"\0{n}\0" for n, part in enumerate(parts))
    return re.sub("\0(\\d+)\0", lambda match: parts[int(match[1])], LINK.sub(replace_link, masked))


def _pages() -> dict[str, str]:
    """Return the page of each file that has one. Guides may also link to a README's folder."""
    lessons = {
        f"notebooks/{lesson.stage}/{lesson.name}.ipynb": f"{lesson.stage}/{lesson.name}.ipynb"
        for lesson in every_lesson()
    }
    guides = {path: f"{name}.md" for name, path in PAGES.items()}
    folders = {
        posixpath.dirname(path): page for path, page in guides.items() if path.endswith("README.md")
    }
    return lessons | folders | guides | {"README.md": "index.md"}
