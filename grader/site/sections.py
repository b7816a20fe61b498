"""Write a script with the text of all pages by section, which the search page searches."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path

SCRIPT_PATH = "_static/sections.js"
HEADING_TAGS = {"h1", "h2", "h3", "h4"}
SKIPPED_TAGS = {"script", "style", "svg", "form", "nav", "label", "legend"}
SKIPPED_CLASSES = {"headerlink", "admonition-title"}
VOID_TAGS = {"img", "br", "hr", "input", "source", "meta", "link", "wbr"}
LATEX_SYNTAX = re.compile(r"\\[A-Za-z]+|\\.|[{}]")


def write(pages: Path) -> None:
    """Write the script for all pages in a folder and its subfolders."""
    sections = []
    for path in sorted(pages.rglob("*.html")):
        reader = _SectionParser()
        reader.feed(path.read_text("utf-8"))
        name = path.relative_to(pages).as_posix()
        sections += [[name, *section] for section in reader.sections()]
    text = json.dumps(sections, ensure_ascii=False, separators=(",", ":")).replace("],[", "],\n[")
    (pages / SCRIPT_PATH).write_text(f"const SECTIONS = {text};\n", "utf-8")


class _SectionParser(HTMLParser):
    """Parser that collects the text of a page by section."""

    def __init__(self) -> None:
        super().__init__()
        self._open: list[tuple[str, set[str]]] = []
        self._open_sections: list[dict] = []
        self._sections: list[dict] = []

    def sections(self) -> list[tuple[str, str, str, str]]:
        """Return (anchor, title, text, code) of each section that contains text."""
        parts = [
            (
                section["anchor"],
                *(" ".join("".join(section[part]).split()) for part in ("title", "text", "code")),
            )
            for section in self._sections
        ]
        return [section for section in parts if section[2]]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Record an opened element. If it is a section, begin to collect its text."""
        if tag in VOID_TAGS:
            return
        classes = set((dict(attrs).get("class") or "").split())
        self._open.append((tag, classes))
        if tag == "section":
            section = {"anchor": dict(attrs).get("id", ""), "title": [], "text": [], "code": []}
            self._open_sections.append(section)
            self._sections.append(section)

    def handle_endtag(self, tag: str) -> None:
        """Remove a closed element. If it is a section, continue with the enclosing section."""
        while tag in (name for name, _ in self._open):
            closed, _ = self._open.pop()
            if closed == "section":
                self._open_sections.pop()
            if closed == tag:
                break
        if self._open_sections and tag == "dt":
            self._open_sections[-1]["text"].append(": ")
        if self._open_sections and tag in {"p", "div", "td", "li", "pre", "summary"}:
            self._open_sections[-1]["text"].append(" ")
            self._open_sections[-1]["code"].append(" ")

    def handle_data(self, data: str) -> None:
        """Add text to the title, the text or the code of the innermost section."""
        tags = {tag for tag, _ in self._open}
        classes = set().union(*(names for _, names in self._open))
        repeats_titles = {"details", "table"} <= tags  # the minutes of each section
        is_silent = tags & SKIPPED_TAGS or classes & SKIPPED_CLASSES or repeats_titles
        if is_silent or not self._open_sections:
            return
        if "math" in classes:
            data = " ".join(LATEX_SYNTAX.sub(" ", data).split())
        part = "title" if tags & HEADING_TAGS else "code" if "pre" in tags else "text"
        self._open_sections[-1][part].append(data)
