"""Results as files for other programs."""

import csv
import io

from grader.course.roster import Person
from grader.lms.exporters import EXPORTERS
from grader.lms.results import MARKED, MISSING, WAITING, ClassResults, NotebookResult

SIX, SEVEN = "06_filter_ground", "07_filter_by_distance"


def rows(*notebooks):
    people = tuple(Person(student) for student in dict.fromkeys(one.student for one in notebooks))
    results = ClassResults(people, notebooks, ())
    return list(csv.reader(io.StringIO(EXPORTERS["csv"](results))))


def notebook(student, lesson, score, standing=MARKED, penalty=0.0):
    return NotebookResult(student, "stage3_obstacles", lesson, standing, score, 30.0, penalty)


def test_a_row_for_each_student_and_a_column_for_each_lesson():
    found = rows(
        notebook("ada", SIX, 30.0),
        notebook("ada", SEVEN, 12.345678, WAITING, penalty=2.5),
        notebook("bo", SIX, None, MISSING),
        notebook("bo", SEVEN, 0.0),
    )
    assert found == [
        ["Student", SIX, SEVEN, "Late penalty", "Total", "Waiting for a person"],
        ["out of", "30", "30", "", "60", ""],
        ["ada", "30", "12.35", "2.5", "39.85", "1"],
        ["bo", "", "0", "0", "0", "0"],
    ]


def test_names_shift_no_column_and_run_no_formula():
    names = ["O'Neil, Jr", 'the "quoted"', "=cmd|' /C calc'!A0", "+1", "-1", "@x", "zwei\nZeilen"]
    found = rows(*(notebook(name, SIX, 1.0) for name in names))[2:]
    assert [row[1:] for row in found] == [["1", "0", "1", "0"]] * len(names)
    assert [row[0].lstrip("'") for row in found] == names
    assert not [row[0] for row in found if row[0].startswith(("=", "+", "-", "@"))]


def test_penalties_take_no_more_than_there_is():
    (_, _, row) = rows(notebook("a", SIX, 3.0, penalty=9.0))
    assert row[-2] == "0"
