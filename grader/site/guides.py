"""The project's own READMEs as pages: for students, instructors and authors, and on the data."""

from __future__ import annotations

import posixpath
import re

from grader.course.build import Origin
from grader.course.lessons import every_lesson
from grader.course.paths import PROJECT
from grader.site.pictures import Pictures

PAGES = {
    "students": "notebooks/README.md",
    "instructors": "grader/README.md",
    "authors": "solutions/README.md",
    "data": "data/README.md",
}
"""The README behind each page; in the order of the contents."""
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
CODE = re.compile(r"(^ *```.*?^ *```|`[^`\n]+`)", re.M | re.S)


def page(name: str, origin: Origin, pictures: Pictures) -> str:
    """A guide as Markdown for MyST.

    Parameters
    ----------
    name : str
        One of `PAGES`.
    origin : grader.course.build.Origin
        Where the files are that no page shows; without an address they are named, not linked.
    pictures : Pictures
        Gets what the guide shows.
    """
    path = PROJECT / PAGES[name]
    folder = posixpath.dirname(PAGES[name])

    def link(found: re.Match) -> str:
        mark, text, target = found.groups()
        place, _, fragment = target.partition("#")
        if ":" in target or not place:
            return found[0]
        place = posixpath.normpath(posixpath.join(folder, place))
        if mark:
            kept = pictures.keep((PROJECT / place).read_bytes(), posixpath.splitext(place)[1])
            return f"![{' '.join(text.split())}](/{kept})"
        if place in _pages():
            return f"[{text}]({_pages()[place]}{'#' + fragment if fragment else ''})"
        if origin.repository:
            return f"[{text}]({origin.repository}/blob/{origin.revision}/{place})"
        return text

    parts = CODE.split(path.read_text("utf-8"))
    # In code nothing is a link; a link may have code for its text.
    whole = "".join(part if n % 2 == 0 else f"\0{n}\0" for n, part in enumerate(parts))
    return re.sub("\0(\\d+)\0", lambda found: parts[int(found[1])], LINK.sub(link, whole))


def _pages() -> dict[str, str]:
    """The page, as seen from another guide, of each file that has one."""
    lessons = {
        f"notebooks/{lesson.stage}/{lesson.name}.ipynb": f"{lesson.stage}/{lesson.name}.ipynb"
        for lesson in every_lesson()
    }
    readmes = {path: f"{name}.md" for name, path in PAGES.items()}
    folders = {posixpath.dirname(path): page for path, page in readmes.items()}
    return lessons | folders | readmes | {"README.md": "index.md"}
