"""The words of the course: a page of their own, to which lessons link."""

from __future__ import annotations

import re

from grader.course.paths import PROJECT

SOURCE = PROJECT / "solutions" / "footer_cell.md"
ROW = re.compile(r"^\| \*\*(.+?)\*\* \| (.+) \|$", re.M)
LINK = re.compile(r"\[([^\[\]]+)\]\(#Words-of-the-course\)")


def definitions() -> dict[tuple[str, ...], str]:
    """What the words mean, by the words that stand for it."""
    rows = ROW.findall(SOURCE.read_text("utf-8"))
    return {tuple(names.split(", ")): meaning for names, meaning in rows}


def page() -> str:
    """The page, as Markdown for MyST."""
    entries = ["\n".join(names) + f"\n  {meaning}" for names, meaning in definitions().items()]
    return "# Words of the course\n\n```{glossary}\n" + "\n\n".join(entries) + "\n```\n"


def linked(markdown: str) -> str:
    """The text of a cell with links to its words on that page."""
    return LINK.sub(_link, markdown)


def _link(found: re.Match) -> str:
    known = {word.lower(): word for names in definitions() for word in names}
    text = found[1].strip("*").lower().removeprefix("our ")
    word = known.get(text) or known.get(text.removesuffix("s"))
    shown = found[1].strip("*")
    return f"{{term}}`{shown} <{word}>`" if word else f"[{found[1]}](../words.md)"
