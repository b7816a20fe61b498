"""Build the glossary page, and redirect links from lessons to it."""

from __future__ import annotations

import re

from grader.course.paths import PROJECT

SOURCE = PROJECT / "solutions" / "footer_cell.md"
ROW = re.compile(r"^\| \*\*(.+?)\*\* \| (.+) \|$", re.M)
LINK = re.compile(r"\[([^\[\]]+)\]\(#Words-of-the-course\)")


def definitions() -> dict[tuple[str, ...], str]:
    """Return the meaning of each glossary entry. The key is the tuple of its names."""
    rows = ROW.findall(SOURCE.read_text("utf-8"))
    return {tuple(names.split(", ")): meaning for names, meaning in rows}


def page() -> str:
    """Return the glossary page as Markdown for MyST."""
    entries = ["\n".join(names) + f"\n  {meaning}" for names, meaning in definitions().items()]
    return "# Words of the course\n\n```{glossary}\n" + "\n\n".join(entries) + "\n```\n"


def link_terms(markdown: str) -> str:
    """Redirect links to the glossary in a notebook's text to the glossary page."""
    return LINK.sub(_link, markdown)


def _link(match: re.Match) -> str:
    terms = {word.lower(): word for names in definitions() for word in names}
    text = match[1].strip("*").lower().removeprefix("our ")
    word = terms.get(text) or terms.get(text.removesuffix("s"))
    shown_text = match[1].strip("*")
    return f"{{term}}`{shown_text} <{word}>`" if word else f"[{match[1]}](../words.md)"
