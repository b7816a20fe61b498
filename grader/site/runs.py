"""The solved notebooks, run for the site; again only if something that they depend on is new.

Who hands solutions out gets what they showed, too; see `grader.site.solution`.
"""

import ast
import functools
import hashlib
import importlib.util
from collections.abc import Callable, Iterable
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT
from grader.course.solutions import all_shown, shown

KEPT = PROJECT / ".site"
"""What was run, by what it depends on."""
RECORDING = Path(__file__).parent / "widget_states.py"


def solved_runs(
    lessons: Iterable[Lesson], workers: int, progress: Callable[[int, int, object], None]
) -> dict[Lesson, bytes]:
    """Solved notebooks with what a page shows of them; `grader.course.solutions` says the rest."""
    show = functools.partial(shown, kept=KEPT, before=first_code())
    return all_shown(lessons, workers, progress, show)


def not_installed(lesson: Lesson) -> list[str]:
    """Packages that a lesson imports, at its top or within a function, and that are not there."""
    named = set()
    for node in ast.walk(ast.parse(lesson.text)):
        if isinstance(node, ast.Import):
            named |= {one.name.partition(".")[0] for one in node.names}
        elif isinstance(node, ast.ImportFrom):
            named.add(node.module.partition(".")[0])
    return sorted(name for name in named if importlib.util.find_spec(name) is None)


def first_code() -> str:
    """What runs before a lesson: it leaves no name in the notebook, and changes as we do."""
    digest = hashlib.sha256(RECORDING.read_bytes()).hexdigest()[:16]
    return f"__import__('grader.site.widget_states').site.widget_states.record()  # {digest}"
