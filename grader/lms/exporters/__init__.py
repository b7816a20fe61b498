"""What a class's results can be written as: ``python -m grader export --format NAME``.

Another format is a module with a function from `ClassResults` to the text of a file, and a line
in the table.
"""

from collections.abc import Callable

from grader.lms.exporters.scores_csv import scores_csv
from grader.lms.results import ClassResults

__all__ = ["EXPORTERS", "ClassResults"]

EXPORTERS: dict[str, Callable[[ClassResults], str]] = {"csv": scores_csv}
