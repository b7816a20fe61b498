"""Where things lie: the project itself, and the course that is being graded."""

from dataclasses import dataclass
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[2]


@dataclass(frozen=True)
class Course:
    """The folder that holds a class: submissions go in, verdicts and grades come out."""

    root: Path = PROJECT

    @property
    def submitted(self) -> Path:
        """``submitted/<student>/<stage>/<NN_name>.ipynb``, as nbgrader collects them."""
        return self.root / "submitted"

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
