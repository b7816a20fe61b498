"""The export formats for the marks of a class: ``python -m grader export --format NAME``.

To add a format, write a module ``NAME`` with a function ``export_NAME`` that turns `ExportOptions`
into an `ExportResult`, and add it to `EXPORTERS`.
"""

import importlib
from dataclasses import dataclass

from grader.lms.exporters.protocol import ExportError, ExportOptions, ExportResult

__all__ = ["EXPORTERS", "ExportError", "ExportResult", "Exporter", "ExportOptions"]


@dataclass(frozen=True)
class Exporter:
    """An export format.

    Attributes
    ----------
    module : str
        Name of the module in this folder.
    ending : str
        Ending of the file's name.
    fills : str
        Description of the LMS file that is filled in; empty if the exporter creates a new file.
    next_step : str
        Instructions for uploading the file.
    """

    module: str
    ending: str
    fills: str = ""
    next_step: str = ""

    def write(self, options: ExportOptions) -> ExportResult:
        """Export the marks of a class.

        Raises
        ------
        ExportError
        """
        # Every command reads the table of formats, but only `export` needs their modules.
        module = importlib.import_module(f"{__name__}.{self.module}")
        return getattr(module, f"export_{self.module}")(options)


EXPORTERS = {
    "csv": Exporter("scores_csv", ".csv"),
    "exercises": Exporter("exercises_csv", ".exercises.csv"),
    "canvas": Exporter(
        "canvas",
        ".canvas.csv",
        "the gradebook that Canvas exports",
        "In Canvas: Grades, Import. Canvas shows each change before you save.",
    ),
    "moodle": Exporter(
        "moodle",
        ".moodle.csv",
        "the offline grading worksheet of the assignment in Moodle",
        "In Moodle: the assignment's Submissions, Actions, Upload grading worksheet. Moodle lists "
        "each change before you confirm. If a mark is not listed, Moodle already has the mark, or "
        "it was changed in Moodle after the download.",
    ),
    "gradescope": Exporter(
        "gradescope",
        ".gradescope.zip",
        next_step="In Gradescope: Configure Autograder, upload the zip, then Regrade All "
        "Submissions.",
    ),
}
