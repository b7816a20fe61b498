"""Solutions to hand out when all have handed in: run, with what they show, and as pages."""

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
    """Why a stage may still be handed in, in a sentence; empty where nobody may.

    Parameters
    ----------
    deadlines : grader.course.deadlines.Deadlines
    stage : str
    now : datetime.datetime
        Aware.
    granted : mapping of str to datetime.datetime
        What is known elsewhere: until when a student may hand in, and everybody (`""`).
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
        Made where there is none.
    solutions : mapping of Lesson to bytes
        Notebooks that were run.

    Yields
    ------
    pathlib.Path
        As soon as the zip is there.
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


def all_shown(
    lessons: Iterable[Lesson],
    workers: int,
    progress: Callable[[int, int, object], None],
    show: Callable[[Lesson], bytes],
) -> dict[Lesson, bytes]:
    """What several notebooks show.

    Parameters
    ----------
    lessons : iterable of Lesson
    workers : int
        Notebooks run at a time.
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


def shown(lesson: Lesson, kept: Path, before: str) -> bytes:
    """The solved notebook of a lesson with all that it shows; run only if something is new.

    Parameters
    ----------
    lesson : Lesson
    kept : pathlib.Path
        Folder for what was run.
    before : str
        Code that runs after the setup, in a cell that is not kept.

    Raises
    ------
    NotReleased
        A cell fails.
    """
    path = kept / f"{lesson.name}-{_fingerprint(lesson, before)}.ipynb"
    if not path.is_file():
        text = _run(lesson, before)
        for old in kept.glob(f"{lesson.name}-*"):
            old.unlink()
        write_atomically(text, path)
    return path.read_bytes()


def as_page(notebook: bytes, lesson: Lesson) -> bytes:
    """A notebook that was run as a page that needs nothing beside it, and no network."""
    content = nbformat.reads(notebook.decode(), as_version=4)
    exporter = MathPage(template_name="solution", extra_template_basedirs=[str(TEMPLATES)])
    resources = {"metadata": {"name": lesson.name}, "style_of_formulas": STYLE}
    page, _ = exporter.from_notebook_node(content, resources)
    return page.encode()


def _fingerprint(lesson: Lesson, before: str) -> str:
    """Of all that a run depends on."""
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
        force_raise_errors=True,  # its cells' tags say that a student's go on
        extra_arguments=["--log-level=ERROR"],  # what kernels remark upon would cross the bar
    )
    client.comm_open_handlers.clear()  # what a widget shows stays in its cell
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
    """Take out what differs from run to run and tells nobody anything."""
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # times of day
        if cell.cell_type == "code":
            cell.outputs = [
                output for output in cell.outputs if WIDGET not in output.get("data", {})
            ]
