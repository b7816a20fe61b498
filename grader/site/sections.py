"""A script with the text of all pages by section, in which the search page finds matches."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path

PLACE = "_static/sections.js"
HEADINGS = {"h1", "h2", "h3", "h4"}
SILENT = {"script", "style", "svg", "form", "nav", "label", "legend"}
EMPTY = {"img", "br", "hr", "input", "source", "meta", "link", "wbr"}


def write(pages: Path) -> None:
    """Write the script for all pages in a folder and its subfolders."""
    sections = []
    for path in sorted(pages.rglob("*.html")):
        reader = _Reader()
        reader.feed(path.read_text("utf-8"))
        name = path.relative_to(pages).as_posix()
        sections += [[name, *section] for section in reader.sections()]
    text = json.dumps(sections, ensure_ascii=False, separators=(",", ":")).replace("],[", "],\n[")
    (pages / PLACE).write_text(f"const SECTIONS = {text};\n", "utf-8")


class _Reader(HTMLParser):
    """Parser that collects the text of a page by section."""

    def __init__(self) -> None:
        super().__init__()
        self._open: list[str] = []
        self._open_sections: list[dict] = []
        self._sections: list[dict] = []

    def sections(self) -> list[tuple[str, str, str]]:
        """Return (anchor, title, text) of each section that contains text."""
        parts = [
            (
                section["anchor"],
                *(" ".join("".join(section[part]).split()) for part in ("title", "text")),
            )
            for section in self._sections
        ]
        return [(anchor, title.rstrip("#¶ "), text) for anchor, title, text in parts if text]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Remember an open element. If it is a section, begin to collect its text."""
        if tag in EMPTY:
            return
        self._open.append(tag)
        if tag == "section":
            section = {"anchor": dict(attrs).get("id", ""), "title": [], "text": []}
            self._open_sections.append(section)
            self._sections.append(section)

    def handle_endtag(self, tag: str) -> None:
        """Forget a closed element. If it is a section, return to the section around it."""
        while tag in self._open:
            closed = self._open.pop()
            if closed == "section":
                self._open_sections.pop()
            if closed == tag:
                break
        if self._open_sections and tag in {"p", "div", "td", "li", "pre", "summary"}:
            self._open_sections[-1]["text"].append(" ")

    def handle_data(self, data: str) -> None:
        """Add text to the title or the text of the innermost section."""
        if self._open_sections and not SILENT.intersection(self._open):
            heading = HEADINGS.intersection(self._open)
            self._open_sections[-1]["title" if heading else "text"].append(data)
