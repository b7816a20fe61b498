"""Solutions to release after the due date, as executed notebooks and as HTML pages."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from datetime import datetime
from pathlib import Path

import nbformat
from nbconvert.preprocessors import CoalesceStreamsPreprocessor
from nbformat import NotebookNode

from grader.course.archives import make_zip
from grader.course.atomic_files import write_atomically
from grader.course.deadlines import Deadlines, DueDates
from grader.course.lessons import Lesson, all_lessons
from grader.course.mathml import STYLE, MathPage
from grader.course.notebook_runs import NotebookStopped, run_notebook
from grader.course.paths import PROJECT
from grader.course.release import TOP_FOLDER, course_tools
from grader.course.standalone import ReleaseError

TEMPLATES = Path(__file__).parent / "templates"
SOLUTION_MARKS = re.compile(r"^[ \t]*### (?:BEGIN|END) SOLUTION[ \t]*\n?", re.M)
WIDGET_TYPE = "application/vnd.jupyter.widget-view+json"


def reason_to_withhold(
    deadlines: Deadlines, stage: str, now: datetime, extensions: Mapping[str, datetime]
) -> str:
    """Return why a stage's solutions must not be released yet; empty if they may be.

    Parameters
    ----------
    deadlines : grader.course.deadlines.Deadlines
    stage : str
    now : datetime.datetime
        With a time zone.
    extensions : mapping of str to datetime.datetime
        Further due dates, by student. The key `""` means the whole class.
    """
    names = {**extensions, **_dates_by_name(deadlines.stages.get(stage, DueDates()))}
    own_dates = deadlines.lessons_with_dates(stage)
    for lesson, dates in own_dates.items():
        names |= {
            f"{name} in {lesson}" if name else lesson: due
            for name, due in _dates_by_name(dates).items()
        }
    lessons = {lesson.name for lesson in all_lessons() if lesson.stage == stage}
    if "" not in names and not own_dates.keys() >= lessons:
        return (
            f"{stage} may still be open, because its due date is not known. Add the date to "
            "deadlines.toml."
        )
    open_groups = [
        f"{name or 'everyone'} until {deadlines.to_local_time(due):%d %B %Y, %H:%M %Z}"
        for name, due in names.items()
        if due > now
    ]
    return f"{stage} is still open for {', '.join(open_groups)}." if open_groups else ""


def _dates_by_name(dates: DueDates) -> dict[str, datetime]:
    """Return due dates by section and student; the key `""` means everyone else."""
    whole_class = {"": dates.due} if dates.due else {}
    groups = {f"section {name}": due for name, due in dates.sections.items()}
    return {**whole_class, **groups, **dates.students}


def write_solutions(folder: Path, solutions: Mapping[Lesson, bytes]) -> Iterator[Path]:
    """Write a zip file for each stage, with each lesson as a notebook and as an HTML page.

    Parameters
    ----------
    folder : pathlib.Path
        Created if it does not exist.
    solutions : mapping of Lesson to bytes
        Executed notebooks.

    Yields
    ------
    pathlib.Path
        The path of each zip file, when it is complete.
    """
    for stage in dict.fromkeys(lesson.stage for lesson in solutions):
        files = {}
        for lesson, notebook in solutions.items():
            if lesson.stage == stage:
                name = f"{TOP_FOLDER}/solutions/{stage}/{lesson.name}"
                files[f"{name}.ipynb"] = notebook
                files[f"{name}.html"] = render_page(notebook, lesson)
        path = folder / f"{stage}_solutions.zip"
        write_atomically(make_zip(files), path)
        yield path


def run_all(
    lessons: Iterable[Lesson],
    workers: int,
    progress: Callable[[int, int, object], None],
    run: Callable[[Lesson], bytes],
) -> dict[Lesson, bytes]:
    """Run the notebooks of several lessons in parallel, and return them by lesson.

    Parameters
    ----------
    lessons : iterable of Lesson
    workers : int
        Number of notebooks that run at the same time.
    progress : callable
        Called with (0, total, "") first, and with (done, total, lesson name) after each notebook.
    run : callable
        Runs the notebook of a lesson and returns its bytes.
    """
    lessons, notebooks = tuple(lessons), {}
    progress(0, len(lessons), "")
    with ThreadPoolExecutor(workers) as pool:
        running = {pool.submit(run, lesson): lesson for lesson in lessons}
        try:
            for future in as_completed(running):
                notebooks[running[future]] = future.result()
                progress(len(notebooks), len(lessons), running[future].name)
        finally:
            pool.shutdown(cancel_futures=True)
    return {lesson: notebooks[lesson] for lesson in lessons}


def executed_notebook(lesson: Lesson, cache_folder: Path, additional_code: str) -> bytes:
    """Return a lesson's solved notebook with outputs, from the cache if nothing has changed.

    Parameters
    ----------
    lesson : Lesson
    cache_folder : pathlib.Path
        Folder in which executed notebooks are cached.
    additional_code : str
        Code that runs after the setup cell. The result does not contain it.

    Raises
    ------
    ReleaseError
        If a cell fails.
    """
    path = cache_folder / f"{lesson.name}-{_fingerprint(lesson, additional_code)}.ipynb"
    if not path.is_file():
        text = _run_solved_notebook(lesson, additional_code)
        for old in cache_folder.glob(f"{lesson.name}-*"):
            old.unlink()
        write_atomically(text, path)
    return path.read_bytes()


def render_page(notebook: bytes, lesson: Lesson) -> bytes:
    """Convert an executed notebook to an HTML page that needs no other files and no network."""
    content = nbformat.reads(notebook.decode(), as_version=4)
    exporter = MathPage(template_name="solution", extra_template_basedirs=[str(TEMPLATES)])
    resources = {"metadata": {"name": lesson.name}, "style_of_formulas": STYLE}
    page, _ = exporter.from_notebook_node(content, resources)
    return page.encode()


def _fingerprint(lesson: Lesson, additional_code: str) -> str:
    """Return a digest of everything that affects the outputs of a notebook."""
    digest = hashlib.sha256(lesson.solved.read_bytes() + additional_code.encode())
    for name, content in sorted(course_tools().items()):
        digest.update(name.encode() + b"\0" + content + b"\0")
    digest.update((PROJECT / "constraints.txt").read_bytes())
    return digest.hexdigest()[:16]


def _run_solved_notebook(lesson: Lesson, additional_code: str) -> bytes:
    notebook = nbformat.read(lesson.solved, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.source = SOLUTION_MARKS.sub("", cell.source).rstrip("\n")
    additional_cell = nbformat.v4.new_code_cell(additional_code)
    tags = [cell.metadata.get("tags", ()) for cell in notebook.cells]
    setup_index = next(number for number, names in enumerate(tags) if "setup" in names)
    notebook.cells.insert(setup_index + 1, additional_cell)
    try:
        run_notebook(notebook, lesson.released.parent)
    except NotebookStopped as reason:
        raise ReleaseError(
            f"{lesson.name}: the solution does not run to the end, so nothing was written: {reason}"
        ) from None
    notebook.cells.remove(additional_cell)
    remove_volatile_data(notebook)
    return (nbformat.writes(notebook) + "\n").encode()


def remove_volatile_data(notebook: NotebookNode) -> None:
    """Remove the parts of a notebook's outputs that differ from run to run.

    Timestamps and widgets are removed. Printed text is joined, because the kernel sends a progress
    bar in as many pieces as its flush interval allows, and only the last state of the bar is kept.
    """
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # timestamps
        if cell.cell_type == "code":
            cell.outputs = [
                output for output in cell.outputs if WIDGET_TYPE not in output.get("data", {})
            ]
    CoalesceStreamsPreprocessor().preprocess(notebook, {})
