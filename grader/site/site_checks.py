"""Check a finished site for solutions, requests to other hosts and dead links."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from grader.course.build import lines_of, secret_lines
from grader.course.lessons import every_lesson
from grader.course.paths import PROJECT
from grader.site.guides import PAGES
from grader.site.pictures import FOLDER

CHECKED_SUFFIXES = {".html", ".js", ".css", ".json", ".txt", ".ipynb", ".xml"}
FETCHED_ATTRIBUTES = {"src", "srcset", "poster", "data", "data-scan"}
# The scripts of the course's own panel may compute what students write, in another language. They
# are in this folder, and are compared more strictly.
PANEL_FOLDER = Path(FOLDER).name
NOTATION = re.compile(r"[\s();:]|\b(?:np|math|Math)\.|=(?==)")
OTHER_HOST = re.compile(r"\s*(?:[a-z][a-z0-9+.-]*:)?//", re.I)
STYLE_REFERENCE = re.compile(r"(?:url\(|@import)\s*[\"']?\s*((?:https?:)?//[^\"')\s]*)", re.I)


def find_faults(folder: Path) -> list[str]:
    """Return the faults of a site, one sentence each."""
    pages = {path: ParsedPage.read(path) for path in sorted(folder.rglob("*.html"))}
    sentences = [*_revealed_lines(folder, pages), *_external_requests(folder, pages)]
    for path, page in pages.items():
        name = path.relative_to(folder)
        sentences += [
            f"{name} links to {link}, which does not exist." for link in _dead_links(path, pages)
        ]
        sentences += [
            f"{name} has a picture without a description." for _ in range(page.undescribed)
        ]
    return sentences


@dataclass
class ParsedPage(HTMLParser):
    """The text and links of a page, and the files that the browser fetches for it."""

    text: list[str] = field(default_factory=list)
    links: list[str] = field(default_factory=list)
    fetched: list[str] = field(default_factory=list)
    names: set[str] = field(default_factory=set)
    undescribed: int = 0

    def __post_init__(self) -> None:
        super().__init__()

    @classmethod
    def read(cls, path: Path) -> ParsedPage:
        """Read and parse a file."""
        page = cls()
        page.feed(path.read_text("utf-8"))
        page.close()
        return page

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Record the anchors, fetched files and links of a tag."""
        attributes = {name: value or "" for name, value in attrs}
        self.names |= {attributes[name] for name in ("id", "name") if name in attributes}
        self.fetched += [attributes[name] for name in FETCHED_ATTRIBUTES & attributes.keys()]
        if "href" in attributes:
            (self.links if tag == "a" else self.fetched).append(attributes["href"])
        if tag == "img" and "alt" not in attributes:
            self.undescribed += 1

    def handle_data(self, data: str) -> None:
        """Record text between tags."""
        self.text.append(data)


def _revealed_lines(folder: Path, pages: dict[Path, ParsedPage]) -> Iterator[str]:
    """Yield one sentence for each line of a solution in a file of the site."""
    lessons = every_lesson()
    notebooks = [line for lesson in lessons for line in lines_of(lesson.released.read_bytes())]
    readmes = [(PROJECT / path).read_text("utf-8") for path in PAGES.values()]
    # A page shows a hint such as "return `a`" without backticks, so they are ignored.
    published = re.sub("[`*]", "", "\n".join([*notebooks, *readmes]))
    secret = {
        line: lesson.name
        for lesson in lessons
        for line in secret_lines(lesson.solved.read_bytes())
        if re.sub("[`*]", "", line) not in published
    }
    for path in sorted(folder.rglob("*")):
        if path.suffix not in CHECKED_SUFFIXES or not path.is_file():
            continue
        raw = path.read_text("utf-8")
        text = "".join(pages[path].text) if path in pages else raw.replace('\\"', '"')
        is_of_panel = path.suffix == ".js" and path.parent.name == PANEL_FOLDER
        code = _without_notation(raw) if is_of_panel else ""
        for line, lesson in secret.items():
            if line in text or line in raw or _without_notation(line) in code:
                name = path.relative_to(folder)
                yield f"{name} reveals a line of the solution of {lesson}: {line!r}"


def _without_notation(code: str) -> str:
    """Remove what differs between a line of Python and the same line of JavaScript."""
    return NOTATION.sub("", code)


def _external_requests(folder: Path, pages: dict[Path, ParsedPage]) -> Iterator[str]:
    """Yield one sentence for each file that the browser would fetch from another host."""
    for path, page in pages.items():
        for address in page.fetched:
            if OTHER_HOST.match(address):
                yield f"{path.relative_to(folder)} fetches {address} from another host"
    for path in sorted(folder.rglob("*.css")):
        for address in STYLE_REFERENCE.findall(path.read_text("utf-8")):
            yield f"{path.relative_to(folder)} fetches {address} from another host"


def _dead_links(path: Path, pages: dict[Path, ParsedPage]) -> Iterator[str]:
    """Yield the links and fetched files of a page that lead to missing targets within the site."""
    page = pages[path]
    for link in dict.fromkeys([*page.links, *page.fetched]):
        parts = urlsplit(link)
        if parts.scheme or parts.netloc or link in ("", "#"):
            continue
        target = path
        if parts.path:
            target = (path.parent / PurePosixPath(unquote(parts.path))).resolve()
        name = unquote(parts.fragment)
        if not target.is_file() or (name and target in pages and name not in pages[target].names):
            yield link
