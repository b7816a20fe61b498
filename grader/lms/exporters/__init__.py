"""What a class's marks can be written as: ``python -m grader export --format NAME``.

Another format is a module with a function from `Order` to `Exported`, and a line in the table.
"""

from collections.abc import Callable
from dataclasses import dataclass

from grader.lms.exporters.canvas import canvas
from grader.lms.exporters.gradescope import gradescope
from grader.lms.exporters.moodle import moodle
from grader.lms.exporters.protocol import Exported, ExportTrouble, Order
from grader.lms.exporters.scores_csv import scores_csv

__all__ = ["EXPORTERS", "ExportTrouble", "Exported", "Exporter", "Order"]


@dataclass(frozen=True)
class Exporter:
    """One format.

    Attributes
    ----------
    write : callable
        From `Order` to `Exported`; raises `ExportTrouble`.
    ending : str
        Of the file's name.
    fills : str
        What of the platform's it fills in; empty where it makes the file itself.
    next_step : str
        What to do with the file.
    """

    write: Callable[[Order], Exported]
    ending: str
    fills: str = ""
    next_step: str = ""


EXPORTERS = {
    "csv": Exporter(scores_csv, ".csv"),
    "canvas": Exporter(
        canvas,
        ".canvas.csv",
        "the gradebook that Canvas exports",
        "In Canvas: Grades, Import. It shows each change before you save.",
    ),
    "moodle": Exporter(
        moodle,
        ".moodle.csv",
        "the offline grading worksheet that Moodle offers for the assignment",
        "In Moodle: the assignment's Submissions, Actions, Upload grading worksheet. It lists each "
        "change before you confirm; a mark that it does not list is there already, or was changed "
        "there since the download.",
    ),
    "gradescope": Exporter(
        gradescope,
        ".gradescope.zip",
        next_step="In Gradescope: Configure Autograder, upload the zip, then Regrade All "
        "Submissions.",
    ),
}
