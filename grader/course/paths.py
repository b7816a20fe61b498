"""The folders of the project, and of the course that is being graded."""

import functools
from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Course:
    """The folder of a class, with its submissions, verdicts and grades."""

    root: Path = PROJECT

    @property
    def submitted(self) -> Path:
        """Folder of the submissions, ``<student>/<stage>/<NN_name>.ipynb``."""
        return self.root / _folder(self.root, "submitted")

    @property
    def autograded(self) -> Path:
        """Folder of the judged copies, ``<student>/<stage>/<NN_name>.ipynb``."""
        return self.root / _folder(self.root, "autograded")

    @property
    def released(self) -> Path:
        """Folder of the released notebooks, ``<stage>/<NN_name>.ipynb``."""
        return self.root / "notebooks"

    @property
    def verdicts(self) -> Path:
        """Folder of the verdicts, ``<student>/<stage>/<NN_name>.json``."""
        return self.root / "verdicts"

    @property
    def report(self) -> Path:
        """Folder of the report on the class."""
        return self.root / "report"

    @property
    def seed_file(self) -> Path:
        """File with the secret from which hidden tests draw their input."""
        return self.root / ".course_seed"


@functools.cache
def _folder(root: Path, kind: str) -> str:
    """Return the name of an nbgrader folder, which ``nbgrader_config.py`` may change."""
    # Importing nbgrader's settings takes time, and `judge` does not need them.
    from grader.course.nbgrader_settings import course_settings

    settings = course_settings(root).CourseDirectory
    return settings.get(f"{kind}_directory", kind)
