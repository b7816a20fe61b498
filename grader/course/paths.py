"""Where things lie: the project itself, and the course that is being graded."""

import functools
from dataclasses import dataclass
from pathlib import Path

from grader.course.nbgrader_settings import course_settings

PROJECT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Course:
    """The folder that holds a class: submissions go in, verdicts and grades come out."""

    root: Path = PROJECT

    @property
    def submitted(self) -> Path:
        """``submitted/<student>/<stage>/<NN_name>.ipynb``, as nbgrader collects them."""
        return self.root / _folder(self.root, "submitted")

    @property
    def autograded(self) -> Path:
        """``autograded/<student>/<stage>/<NN_name>.ipynb``, as nbgrader keeps them."""
        return self.root / _folder(self.root, "autograded")

    @property
    def released(self) -> Path:
        """``notebooks/<stage>/<NN_name>.ipynb``: what students were given."""
        return self.root / "notebooks"

    @property
    def verdicts(self) -> Path:
        """``verdicts/<student>/<stage>/<NN_name>.json``."""
        return self.root / "verdicts"

    @property
    def report(self) -> Path:
        """The report on the whole class."""
        return self.root / "report"

    @property
    def seed_file(self) -> Path:
        """The secret that hidden tests draw their scenes from."""
        return self.root / ".course_seed"


@functools.cache
def _folder(root: Path, kind: str) -> str:
    """What the course's ``nbgrader_config.py`` calls one of nbgrader's folders."""
    settings = course_settings(root).CourseDirectory
    return settings.get(f"{kind}_directory", kind)
