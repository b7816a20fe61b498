"""Build a lesson's page: the student's notebook with the outputs of the solved notebook."""

from __future__ import annotations

import base64
import json
import re

import nbformat
from nbformat import NotebookNode
from nbformat.v4 import new_markdown_cell

from grader.course import earlier_lessons
from grader.course.build import Origin
from grader.course.lessons import Lesson
from grader.site import glossary
from grader.site.errors import SiteError
from grader.site.films import LessonFilm, film_of
from grader.site.html_outputs import PATH_TO_ROOT, page_outputs
from grader.site.pictures import Pictures
from grader.site.widget_states import POSITION_TYPE, QUESTION_TYPE

FOLDED_TAGS = {"folded", "setup"}
TITLE = re.compile(r"# @title (.*?)(?: \(you need not read this\))?(?: \{.*\})?\n")
SETUP_TITLE = "Loads the course's tools"
ASKING_TITLE = "Asks for your guess"


def page_of(lesson: Lesson, solved_run: bytes, links: str, pictures: Pictures) -> bytes:
    """Build the notebook that Sphinx converts to the lesson's page.

    Parameters
    ----------
    lesson : Lesson
    solved_run : bytes
        Solved notebook with outputs, from `grader.site.runs.solved_runs`.
    links : str
        Links below the title, from `links_of`.
    pictures : Pictures
        Collection to which the pictures of the page are added.

    Raises
    ------
    SiteError
        If the solved notebook does not contain a cell of the student's notebook, or if the lesson
        has no place for its film.
    """
    notebook = nbformat.read(lesson.released, as_version=4)
    solved = {cell["id"]: cell for cell in nbformat.reads(solved_run.decode(), as_version=4).cells}
    cells = []
    for cell in notebook.cells:
        tags = set(cell.metadata.get("tags", ()))
        if cell.id not in solved:
            raise SiteError(
                f"{lesson.name}: cell {cell.id} is not in the solved notebook. "
                "Run: python -m grader build"
            )
        if "footer" in tags:
            continue  # the glossary has a separate page
        if cell.cell_type == "code":
            cell.outputs = (
                [] if "setup" in tags else page_outputs(solved[cell.id].outputs, pictures)
            )
            if is_exercise(cell):
                cell.metadata["tags"] = sorted({*tags, f"exercise-{cell.id}"})
            elif _has_sliders_to_move(solved[cell.id]):
                cell.metadata["tags"] = sorted({*tags, f"sliders-{cell.id}"})
            if FOLDED_TAGS & tags:
                _fold(cell, _title(cell))
            elif _has_only_questions(solved[cell.id]):
                _fold(cell, ASKING_TITLE)
        elif "badge" in tags:
            cell.source = links
        else:
            cell.source = glossary.link_terms(cell.source)
            _extract_pictures(cell, pictures)
        cells.append(cell)
    if film := film_of(lesson):
        _insert_film(cells, film, pictures)
    notebook.cells = cells
    notebook.metadata.pop("kernelspec", None)
    return nbformat.writes(notebook).encode()


def _insert_film(cells: list[NotebookNode], film: LessonFilm, pictures: Pictures) -> None:
    """Insert a film below the first code cell of its section."""
    heading = re.compile(rf"^## {re.escape(film.below)}$", re.M)
    in_section = False
    for number, cell in enumerate(cells):
        if cell.cell_type == "markdown" and heading.search(cell.source):
            in_section = True
        elif cell.cell_type == "code" and in_section:
            html = film.html(pictures, PATH_TO_ROOT)
            cells.insert(number + 1, new_markdown_cell(html, id="film"))
            return
    raise SiteError(
        f"{film.lesson.name}: there is no code below the heading {film.below!r}. Correct film.toml."
    )


def is_exercise(cell: NotebookNode) -> bool:
    """Return whether students write code in this cell."""
    is_graded = cell.metadata.get("nbgrader", {}).get("solution", False)
    is_pasted = earlier_lessons.TAG in cell.metadata.get("tags", ())
    return cell.cell_type == "code" and (is_graded or is_pasted)


def _has_sliders_to_move(cell: NotebookNode) -> bool:
    """Return whether a cell has sliders whose function the browser can call in a live site."""
    return any(
        "call" in output.get("data", {}).get(POSITION_TYPE, {})
        for output in cell.get("outputs", ())
    )


def _title(cell: NotebookNode) -> str:
    match = TITLE.match(cell.source)
    return match[1] if match else SETUP_TITLE


def _has_only_questions(cell: NotebookNode) -> bool:
    """Return whether all outputs of a cell are questions, which the page shows as forms."""
    return bool(cell.outputs) and all(
        QUESTION_TYPE in output.get("data", {}) for output in cell.outputs
    )


def _fold(cell: NotebookNode, title: str) -> None:
    cell.metadata["tags"] = sorted({*cell.metadata.get("tags", ()), "hide-input"})
    prompt = f"Code: {title}"
    cell.metadata["mystnb"] = {"code_prompt_show": prompt, "code_prompt_hide": prompt}


def _extract_pictures(cell: NotebookNode, pictures: Pictures) -> None:
    """Move the pictures attached to a cell to files next to the page."""
    for name, kinds in cell.pop("attachments", {}).items():
        place = pictures.keep(base64.b64decode(kinds["image/png"]), ".png")
        cell.source = cell.source.replace(f"(attachment:{name})", f"(/{place})")


def links_of(lesson: Lesson, origin: Origin) -> str:
    """Return links to download or run the lesson and to report a mistake, as HTML."""
    links = [f'<a href="../notebooks/{lesson.name}.ipynb" download>Download the notebook</a>']
    if origin.repository:
        notebook = f"notebooks/{lesson.stage}/{lesson.name}.ipynb"
        colab = "https://colab.research.google.com/github"
        binder = "https://mybinder.org/v2/gh"
        links += [
            f'<a href="{colab}/{origin.owner_and_name}/blob/{origin.revision}/{notebook}">'
            "Open in Colab</a>",
            f'<a href="{binder}/{origin.owner_and_name}/{origin.revision}'
            f'?urlpath=lab/tree/{notebook}">Open in Binder</a>',
            f'<a class="report" href="{origin.repository}/issues/new?title=Lesson+{lesson.number}">'
            "Report a mistake</a>",
        ]
    return f'<nav class="run" aria-label="This lesson">{"".join(links)}</nav>'


def title_of(lesson: Lesson) -> str:
    """Return the title of a lesson without its number."""
    cells = json.loads(lesson.released.read_text("utf-8"))["cells"]
    return re.match(r"# (?:\d\d · )?(.*)", "".join(cells[0]["source"]))[1].strip()
