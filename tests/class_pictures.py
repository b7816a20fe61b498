"""Grade the sample class, and draw what students and instructors see into `docs/pictures/`.

``python -m tests.class_pictures``, which `make pictures` runs, takes a few minutes and needs
Chromium. The pictures show a failed check in a notebook, and the pages that `make demo` writes.
"""

import csv
import html
import re
import sys
from dataclasses import dataclass

from nbconvert.exporters import HTMLExporter
from nbformat.v4 import new_code_cell, new_notebook
from PIL import Image, ImageOps

from grader import cli
from grader.classroom.demo import DEMO_FOLDER, STAGE
from grader.course.paths import PROJECT
from grader.course.previews import reduce_colours
from tests.browser import BROWSER, save_screenshot
from tests.notebook_runs import run

FOLDER = PROJECT / "docs" / "pictures"
STUDENT = "chioma"  # the first sample student with wrong answers
MARKS = "marks.html"
WIDTH = 720  # CSS pixels; the README shows two pictures next to each other
BORDER, LINE = 2, "#c4cad3"  # so that readers see where a picture begins
STYLE = PROJECT / "grader" / "classroom" / "templates" / "style.css"


@dataclass(frozen=True)
class Picture:
    """A picture of a page in `demo/`, or of one section, with its height in CSS pixels."""

    name: str
    page: str
    height: int
    section: str = ""


PICTURES = (
    Picture("report", "report/index.html", 1010),
    Picture("feedback", f"handed_back/{STAGE}/{STUDENT}.html", 1010),
    Picture("questions", f"viva/{STAGE}/sheets.html", 580),
    Picture("similarity", f"report/similarity_{STAGE}.html", 620, section="pair-1"),
    Picture("marks", MARKS, 580),
)
CHECK = Picture("check", "check.html", 745)
WRONG_ANSWER = """\
import numpy as np
from utils import check

def get_bounding_boxes(cloud, cluster_labels):
    boxes = []
    for label in np.unique(cluster_labels[cluster_labels > 0]):
        points = cloud[cluster_labels == label, :3]
        low, high = points.min(axis=0), points.mean(axis=0)
        boxes.append([np.where([k & 1, k & 2, k & 4], high, low) for k in range(8)])
    return np.array(boxes).reshape(-1, 8, 3)
"""


def section_of(page: str, name: str) -> str:
    """Return a page with only one of its sections."""
    head, _, body = page.partition("<body>")
    section = re.search(f'<section id="{name}">.*?</section>', body, re.S)
    return f"{head}<body>{section[0]}"


def check_page() -> str:
    """Return a page with a check in a notebook that fails, because the boxes end at the means."""
    cells = [new_code_cell(WRONG_ANSWER), new_code_cell("check(get_bounding_boxes)")]
    notebook = run(new_notebook(cells=cells), PROJECT)
    notebook.cells = notebook.cells[1:]
    exporter = HTMLExporter(exclude_input_prompt=True, exclude_output_prompt=True)
    return exporter.from_notebook_node(notebook)[0]


def marks_page(text: str) -> str:
    """Return a page with a CSV file as a table, without the columns that are empty."""
    rows = list(csv.reader(text.splitlines()))
    filled = [column for column in zip(*rows, strict=True) if any(column[1:])]
    titles, *others = zip(*filled, strict=True)
    # A long title such as 06_filter_ground breaks after an underscore.
    cells = ["".join(f"<th>{html.escape(text)}</th>" for text in titles).replace("_", "_<wbr>")]
    cells += ["".join(f"<td>{html.escape(text)}</td>" for text in row) for row in others]
    table = "".join(f"<tr>{row}</tr>" for row in cells)
    style = STYLE.read_text("utf-8") + "td, th { padding: .35rem; font-size: .85rem; }"
    return f"<!DOCTYPE html><meta charset=utf-8><style>{style}</style><table>{table}"


def main() -> int:
    """Draw all pictures, and return the exit status."""
    if BROWSER is None:
        print("Chromium is missing. Run: sudo apt-get install chromium", file=sys.stderr)
        return 1
    if status := cli.main(["demo"]):
        return status
    marks = (DEMO_FOLDER / "scores.csv").read_text("utf-8-sig")
    (DEMO_FOLDER / MARKS).write_text(marks_page(marks), "utf-8")
    (DEMO_FOLDER / CHECK.page).write_text(check_page(), "utf-8")
    for picture in (CHECK, *PICTURES):
        page, path = DEMO_FOLDER / picture.page, FOLDER / f"{picture.name}.png"
        if picture.section:
            section = section_of(page.read_text("utf-8"), picture.section)
            page = page.with_name("section.html")
            page.write_text(section, "utf-8")
        save_screenshot(page.as_uri(), path, WIDTH, picture.height)
        with Image.open(path) as drawn:
            ImageOps.expand(drawn.convert("RGB"), BORDER, LINE).save(path)
        reduce_colours(path)
        print(f"drew {path.relative_to(PROJECT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
