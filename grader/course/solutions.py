"""Solutions to release after the due date: executed notebooks, and the same as pages."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from datetime import datetime
from pathlib import Path

import nbclient
import nbformat
from nbformat import NotebookNode

from grader.course.archives import zipped
from grader.course.atomic_files import write_atomically
from grader.course.deadlines import Dates, Deadlines
from grader.course.lessons import Lesson
from grader.course.mathml import STYLE, MathPage
from grader.course.paths import PROJECT
from grader.course.release import FOLDER, course_tools
from grader.course.standalone import NotReleased

TEMPLATES = Path(__file__).parent / "templates"
LONGEST_CELL = 300  # seconds, on a machine with other work
MARKS = re.compile(r"^[ \t]*### (?:BEGIN|END) SOLUTION[ \t]*\n?", re.M)
WIDGET = "application/vnd.jupyter.widget-view+json"


def still_open(
    deadlines: Deadlines, stage: str, now: datetime, granted: Mapping[str, datetime]
) -> str:
    """Return a sentence on why a stage may still be submitted; empty if it may not.

    Parameters
    ----------
    deadlines : grader.course.deadlines.Deadlines
    stage : str
    now : datetime.datetime
        With a time zone.
    granted : mapping of str to datetime.datetime
        Further due dates, by student; the key `""` is for the whole class.
    """
    dates = deadlines.stages.get(stage, Dates())
    groups = {f"section {name}": due for name, due in dates.sections.items()}
    everybody = {"": dates.due} if dates.due else {}
    names = {**granted, **everybody, **groups, **dates.students}
    if "" not in names:
        return f"{stage} may be open: nothing says when it is due. deadlines.toml can."
    late = [
        f"{name or 'everybody'} until {deadlines.local(due):%d %B %Y, %H:%M %Z}"
        for name, due in names.items()
        if due > now
    ]
    return f"{stage} is open: for {', '.join(late)}." if late else ""


def write_solutions(folder: Path, solutions: Mapping[Lesson, bytes]) -> Iterator[Path]:
    """Write a zip for each stage, with each lesson as a notebook and as a page.

    Parameters
    ----------
    folder : pathlib.Path
        Created if it does not exist.
    solutions : mapping of Lesson to bytes
        Executed notebooks.

    Yields
    ------
    pathlib.Path
        Path of each zip, when it is complete.
    """
    for stage in dict.fromkeys(lesson.stage for lesson in solutions):
        files = {}
        for lesson, notebook in solutions.items():
            if lesson.stage == stage:
                name = f"{FOLDER}/solutions/{stage}/{lesson.name}"
                files[f"{name}.ipynb"] = notebook
                files[f"{name}.html"] = as_page(notebook, lesson)
        path = folder / f"{stage}_solutions.zip"
        write_atomically(zipped(files), path)
        yield path


def all_executed(
    lessons: Iterable[Lesson],
    workers: int,
    progress: Callable[[int, int, object], None],
    show: Callable[[Lesson], bytes],
) -> dict[Lesson, bytes]:
    """Return several executed notebooks.

    Parameters
    ----------
    lessons : iterable of Lesson
    workers : int
        Number of notebooks that run at a time.
    progress : callable
        Called with (done, total, lesson) after each notebook.
    show : callable
        Runs the notebook of a lesson.
    """
    lessons, ran = tuple(lessons), {}
    progress(0, len(lessons), "")
    with ThreadPoolExecutor(workers) as pool:
        running = {pool.submit(show, lesson): lesson for lesson in lessons}
        try:
            for future in as_completed(running):
                ran[running[future]] = future.result()
                progress(len(ran), len(lessons), running[future].name)
        finally:
            pool.shutdown(cancel_futures=True)
    return {lesson: ran[lesson] for lesson in lessons}


def executed_notebook(lesson: Lesson, kept: Path, before: str) -> bytes:
    """Return the executed solved notebook of a lesson; run it only if something has changed.

    Parameters
    ----------
    lesson : Lesson
    kept : pathlib.Path
        Folder of executed notebooks.
    before : str
        Code that runs after the setup cell and is not part of the result.

    Raises
    ------
    NotReleased
        If a cell fails.
    """
    path = kept / f"{lesson.name}-{_fingerprint(lesson, before)}.ipynb"
    if not path.is_file():
        text = _run(lesson, before)
        for old in kept.glob(f"{lesson.name}-*"):
            old.unlink()
        write_atomically(text, path)
    return path.read_bytes()


def as_page(notebook: bytes, lesson: Lesson) -> bytes:
    """Return an executed notebook as a page that needs no other file and no network."""
    content = nbformat.reads(notebook.decode(), as_version=4)
    exporter = MathPage(template_name="solution", extra_template_basedirs=[str(TEMPLATES)])
    resources = {"metadata": {"name": lesson.name}, "style_of_formulas": STYLE}
    page, _ = exporter.from_notebook_node(content, resources)
    return page.encode()


def _fingerprint(lesson: Lesson, before: str) -> str:
    """Return the fingerprint of everything that a run depends on."""
    digest = hashlib.sha256(lesson.solved.read_bytes() + before.encode())
    for name, content in sorted(course_tools().items()):
        digest.update(name.encode() + b"\0" + content + b"\0")
    digest.update((PROJECT / "constraints.txt").read_bytes())
    return digest.hexdigest()[:16]


def _run(lesson: Lesson, before: str) -> bytes:
    notebook = nbformat.read(lesson.solved, as_version=4)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.source = MARKS.sub("", cell.source).rstrip("\n")
    extra = nbformat.v4.new_code_cell(before)
    tags = [cell.metadata.get("tags", ()) for cell in notebook.cells]
    setup = next(number for number, names in enumerate(tags) if "setup" in names)
    notebook.cells.insert(setup + 1, extra)
    client = nbclient.NotebookClient(
        notebook,
        timeout=LONGEST_CELL,
        resources={"metadata": {"path": str(lesson.released.parent)}},
        store_widget_state=False,
        force_raise_errors=True,  # although tags let a student's notebook go on after an error
        extra_arguments=["--log-level=ERROR"],  # messages of kernels would spoil the progress bar
    )
    client.comm_open_handlers.clear()  # so that the output of a widget stays in its cell
    try:
        client.execute()
    except nbclient.exceptions.CellExecutionError as error:
        raise NotReleased(
            f"{lesson.name}: its solution does not run to its end, so nothing was written. "
            f"{str(error)[-1000:]}"
        ) from None
    except nbclient.exceptions.CellTimeoutError:
        raise NotReleased(
            f"{lesson.name}: a cell of its solution took more than {LONGEST_CELL} seconds, so "
            "nothing was written. Is the machine busy? The same command tries again."
        ) from None
    except nbclient.exceptions.DeadKernelError:
        raise NotReleased(
            f"{lesson.name}: Python ended while its solution ran, so nothing was written. Is "
            "there memory left? The same command tries again."
        ) from None
    notebook.cells.remove(extra)
    _settle(notebook)
    return (nbformat.writes(notebook) + "\n").encode()


def _settle(notebook: NotebookNode) -> None:
    """Remove data that differ from run to run and carry no information."""
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # contains times of day
        if cell.cell_type == "code":
            cell.outputs = [
                output for output in cell.outputs if WIDGET not in output.get("data", {})
            ]
