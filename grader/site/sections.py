"""The sections of all pages as a script, in which the search page looks for lines to show."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

PLACE = "_static/sections.js"
HEADINGS = {"h1", "h2", "h3", "h4"}
SILENT = {"script", "style", "svg", "form", "nav", "label", "legend"}
EMPTY = {"img", "br", "hr", "input", "source", "meta", "link", "wbr"}


def write(pages: Path) -> None:
    """Write the script for all pages below a folder."""
    found = []
    for path in sorted(pages.rglob("*.html")):
        reader = _Reader()
        reader.feed(path.read_text("utf-8"))
        name = path.relative_to(pages).as_posix()
        found += [[name, *section] for section in reader.sections()]
    text = json.dumps(found, ensure_ascii=False, separators=(",", ":")).replace("],[", "],\n[")
    (pages / PLACE).write_text(f"const SECTIONS = {text};\n", "utf-8")


class _Reader(HTMLParser):
    """Collects the text of an article by section: (anchor, title, text)."""

    def __init__(self) -> None:
        super().__init__()
        self._open: list[str] = []
        self._within: list[dict] = []
        self._all: list[dict] = []

    def sections(self) -> list[tuple[str, str, str]]:
        """Those that say something."""
        said = [
            (one["anchor"], *(" ".join("".join(one[part]).split()) for part in ("title", "text")))
            for one in self._all
        ]
        return [(anchor, title.rstrip("#¶ "), text) for anchor, title, text in said if text]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Open a section, or step into what is inside one."""
        if tag in EMPTY:
            return
        self._open.append(tag)
        if tag == "section":
            one = {"anchor": dict(attrs).get("id", ""), "title": [], "text": []}
            self._within.append(one)
            self._all.append(one)

    def handle_endtag(self, tag: str) -> None:
        """Step out again."""
        while tag in self._open:
            closed = self._open.pop()
            if closed == "section":
                self._within.pop()
            if closed == tag:
                break
        if self._within and tag in {"p", "div", "td", "li", "pre", "summary"}:
            self._within[-1]["text"].append(" ")

    def handle_data(self, data: str) -> None:
        """Keep text of the innermost section, and its title apart."""
        if self._within and not SILENT.intersection(self._open):
            heading = HEADINGS.intersection(self._open)
            self._within[-1]["title" if heading else "text"].append(data)
