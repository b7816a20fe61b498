"""Run the solved notebooks for the site, unless cached outputs are still valid.

`python -m grader release --solutions` publishes the same outputs; see `grader.site.solution`.
"""

import ast
import hashlib
import importlib.util
from collections.abc import Callable, Iterable
from pathlib import Path

from grader.course.lessons import Lesson
from grader.course.paths import PROJECT
from grader.course.solutions import executed_notebook, run_all

CACHE = PROJECT / ".site"
"""Cache of the executed notebooks."""
RECORDER = Path(__file__).parent / "widget_states.py"


def solved_runs(
    lessons: Iterable[Lesson], workers: int, progress: Callable[[int, int, object], None]
) -> dict[Lesson, bytes]:
    """Run solved notebooks with the recorder; see `grader.course.solutions.run_all`."""

    def run(lesson: Lesson) -> bytes:
        return executed_notebook(lesson, CACHE, recorder_code())

    return run_all(lessons, workers, progress, run)


def missing_packages(lesson: Lesson) -> list[str]:
    """Return the packages that a lesson imports and that are not installed."""
    packages = set()
    for node in ast.walk(ast.parse(lesson.text)):
        if isinstance(node, ast.Import):
            packages |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            packages.add(node.module.partition(".")[0])
    return sorted(name for name in packages if importlib.util.find_spec(name) is None)


def recorder_code() -> str:
    """Return the code that starts the recorder in a notebook.

    The code does not define any name in the notebook. It contains a digest of the recorder, so that
    a change to the recorder invalidates the cache.
    """
    digest = hashlib.sha256(RECORDER.read_bytes()).hexdigest()[:16]
    return f"__import__('grader.site.widget_states').site.widget_states.record()  # {digest}"
