"""The export formats for the marks of a class: ``python -m grader export --format NAME``.

To add a format, write a module with a function that turns `ExportOptions` into an `ExportResult`,
and add it to `EXPORTERS`.
"""

from collections.abc import Callable
from dataclasses import dataclass

from grader.lms.exporters.canvas import export_canvas
from grader.lms.exporters.exercises_csv import export_exercises_csv
from grader.lms.exporters.gradescope import export_gradescope
from grader.lms.exporters.moodle import export_moodle
from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult
from grader.lms.exporters.scores_csv import export_scores_csv

__all__ = ["EXPORTERS", "ExportError", "ExportResult", "Exporter", "ExportOptions"]


@dataclass(frozen=True)
class Exporter:
    """An export format.

    Attributes
    ----------
    write : callable
        Accepts `ExportOptions`, returns an `ExportResult`, and raises `ExportError`.
    ending : str
        Ending of the file's name.
    fills : str
        Description of the LMS file that is filled in; empty if the exporter creates a new file.
    next_step : str
        Instructions for uploading the file.
    """

    write: Callable[[ExportOptions], ExportResult]
    ending: str
    fills: str = ""
    next_step: str = ""


EXPORTERS = {
    "csv": Exporter(export_scores_csv, ".csv"),
    "exercises": Exporter(export_exercises_csv, ".exercises.csv"),
    "canvas": Exporter(
        export_canvas,
        ".canvas.csv",
        "the gradebook that Canvas exports",
        "In Canvas: Grades, Import. Canvas shows each change before you save.",
    ),
    "moodle": Exporter(
        export_moodle,
        ".moodle.csv",
        "the offline grading worksheet of the assignment in Moodle",
        "In Moodle: the assignment's Submissions, Actions, Upload grading worksheet. Moodle lists "
        "each change before you confirm. If a mark is not listed, Moodle already has the mark, or "
        "it was changed in Moodle after the download.",
    ),
    "gradescope": Exporter(
        export_gradescope,
        ".gradescope.zip",
        next_step="In Gradescope: Configure Autograder, upload the zip, then Regrade All "
        "Submissions.",
    ),
}
