"""Scores as a table of comma-separated values: a row a student, a column a lesson."""

import csv
import io

from grader.lms.results import ClassResults

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
    lessons = sorted({result.lesson for result in results.notebooks})
    most = {result.lesson: result.max_score for result in results.notebooks}
    students: dict[str, list] = {}
    for result in results.notebooks:
        students.setdefault(result.student, []).append(result)
    file = io.StringIO()
    table = csv.writer(file, lineterminator="\n")
    table.writerow(["Student", *lessons, "Late penalty", "Total", "Waiting for a person"])
    table.writerow(
        ["out of", *(_number(most[name]) for name in lessons), "", _number(sum(most.values())), ""]
    )
    for student, mine in students.items():
        scores = {result.lesson: result.score for result in mine}
        penalty = sum(off for (name, _), off in results.penalties.items() if name == student)
        table.writerow(
            [
                f"'{student}" if student.startswith(FORMULA) else student,
                *(_number(scores[name]) if name in scores else "" for name in lessons),
                _number(penalty),
                _number(max(0.0, sum(scores.values()) - penalty)),
                sum(result.waiting for result in mine),
            ]
        )
    return file.getvalue()


def _number(points: float) -> str:
    return f"{points:.2f}".rstrip("0").rstrip(".")
