"""Scores as a table of comma-separated values: a row a student, a column a lesson."""

import csv
import io

from grader.lms.results import WAITING, ClassResults

# A cell that begins with one of these is a formula to a spreadsheet, and a command to some.
FORMULA = ("=", "+", "-", "@", "\t", "\r")


def scores_csv(results: ClassResults) -> str:
    """Write the scores of a class.

    Parameters
    ----------
    results : grader.lms.results.ClassResults

    Returns
    -------
    str
        A heading, a row with the most that can be earned, and a row for each student: the score
        in each lesson (empty where nothing was handed in), points off for lateness, the total,
        and the number of notebooks that wait for a person.
    """
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    lessons = results.lessons
    table.writerow(["Student", *lessons, "Late penalty", "Total", "Waiting for a person"])
    table.writerow(
        [
            "out of",
            *(_number(most) for most in lessons.values()),
            "",
            _number(sum(lessons.values())),
            "",
        ]
    )
    for person in results.people:
        mine = [results.notebook(person.id, lesson) for lesson in lessons]
        scores = [result.score for result in mine if result.score is not None]
        penalty = sum(result.penalty for result in mine)
        table.writerow(
            [
                f"'{person.id}" if person.id.startswith(FORMULA) else person.id,
                *("" if result.score is None else _number(result.score) for result in mine),
                _number(penalty),
                _number(max(0.0, sum(scores) - penalty)),
                sum(result.standing == WAITING for result in mine),
            ]
        )
    return file.getvalue()


def _number(points: float) -> str:
    return f"{points:.2f}".rstrip("0").rstrip(".")
