"""What search engines and messengers show about a page: a description and a picture."""

from __future__ import annotations

import re
import textwrap

from grader.course.build import Origin
from grader.course.films import POSTER
from grader.course.lessons import all_lessons, every_lesson
from grader.course.paths import PROJECT
from grader.course.settings import course_title
from grader.site.guides import PAGES

README = PROJECT / "README.md"
GITHUB = "https://github.com/"
MAX_LENGTH = 250  # letters of a description; search engines show fewer
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")


def descriptions() -> dict[str, str]:
    """Return a description of each page, by the page's name."""
    found = {"index": re.search(r"^\*\*(.+)\*\*$", README.read_text("utf-8"), re.M)[1]}
    for lesson in every_lesson():
        names = [exercise.name for exercise in lesson.machine_graded] or list(lesson.steps)
        found[f"{lesson.stage}/{lesson.name}"] = (
            f"Lesson {lesson.number} of {course_title()}. You write {', '.join(names)} in Python, "
            "from scratch."
        )
    found["words"] = "The terms of the course and their meanings."
    for name, path in PAGES.items():
        blocks = (PROJECT / path).read_text("utf-8").split("\n\n")
        paragraph = next(block for block in blocks if re.match(r"`?[\w[]", block))
        plain = re.sub("[`*]", "", LINK.sub(r"\1", paragraph))
        found[name] = textwrap.shorten(plain, MAX_LENGTH, placeholder=" …")
    return found


def picture() -> bytes:
    """Return the picture of the last film in the course, as PNG; empty if there is no film."""
    posters = [lesson.folder / POSTER for lesson in all_lessons()]
    return next((path.read_bytes() for path in reversed(posters) if path.exists()), b"")


def picture_address(origin: Origin, path: str) -> str:
    """Return the address of a file of the site; empty if GitHub does not publish the site.

    Messengers show a picture only if the page contains its whole address.
    """
    if not origin.repository.startswith(GITHUB):
        return ""
    owner, name = origin.owner_and_name.split("/")
    return f"https://{owner.lower()}.github.io/{name}/{path}"
