"""Formulas in names, which a spreadsheet would execute when an instructor opens `scores.csv`."""

import csv
import io

import pytest

from grader.course.paths import Course
from grader.course.roster import Person
from grader.lms.exporters import EXPORTERS
from grader.lms.exporters.protocol import ExportOptions
from grader.lms.results import MARKED, ClassResults, NotebookResult, StageResult
from tests.attacks.attack import with_attacks

STAGE, LESSON = "stage3_obstacles", "06_filter_ground"
FORMULA = "=cmd|' /C calc'!A0"


def scores_of(name):
    """Return `scores.csv` of a class with a student of that name, with that ID and section."""
    person = Person(name, name, name, name, name)
    results = ClassResults(
        (person,),
        (NotebookResult(name, STAGE, LESSON, MARKED, 1.0, 30.0),),
        (StageResult(name, STAGE, MARKED, 1.0, 30.0),),
    )
    return EXPORTERS["csv"].write(ExportOptions(Course(), results)).content.decode("utf-8-sig")


@with_attacks(
    "name",
    {
        "a formula": FORMULA,
        "a formula after spaces": f"  {FORMULA}",
        "a formula after a quotation mark": f'"{FORMULA}"',
        "a formula in a second line": f"Cy\n{FORMULA}\nCy",
        "a formula after a semicolon": f"Cy;{FORMULA};Cy",
        "a formula after a semicolon and spaces": f"Cy; \u00a0{FORMULA};Cy",
        "a formula after a tab": f"Cy\t{FORMULA}\tCy",
        "a formula in quotation marks after a semicolon": f'Cy;"{FORMULA}&";Cy',
        "a formula after several separators": f'Cy;;\t"" {FORMULA}',
        "other signs": "-1;+1;@x;=1",
    },
)
@pytest.mark.parametrize("separator", [",", ";", "\t"], ids=["comma", "semicolon", "tab"])
def test_no_cell_is_a_formula_in_a_spreadsheet_of_any_language(name, separator):
    """A German spreadsheet splits the file at semicolons, so a name can begin another cell."""
    rows = csv.reader(io.StringIO(scores_of(name), newline=""), delimiter=separator)
    cells = [cell.strip().strip('"').strip() for row in rows for cell in row]
    assert [cell for cell in cells if cell.startswith(("=", "+", "-", "@"))] == []


def test_ordinary_names_are_written_unchanged():
    for name in ("O'Neil, Jr", "Müller-Lüdenscheidt", "Anne; Marie", "a=b", "zwei\nZeilen", "x@y"):
        rows = list(csv.reader(io.StringIO(scores_of(name), newline="")))
        assert rows[2][:5] == [name] * 5
