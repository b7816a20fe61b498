"""The outcome of judging one notebook, and how it is kept on disk."""

import dataclasses
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class TestResult:
    """One check: what it demands, whether it holds, and what to tell the student."""

    name: str
    title: str
    passed: bool
    score: float
    max_score: float
    message: str
    visible: bool


@dataclass(frozen=True)
class ExerciseResult:
    """One exercise with its tests."""

    name: str
    score: float
    max_score: float
    tests: tuple


@dataclass(frozen=True)
class Verdict:
    """One judged notebook.

    Attributes
    ----------
    lesson, student : str
    score, max_score : float
        Points of what a machine grades.
    exercises : tuple of ExerciseResult
    problems : tuple of str
        What is wrong with the notebook as a whole, one sentence each.
    seconds : float
        Wall-clock time that judging took.
    key : str
        Fingerprint of all that the verdict depends on.
    """

    lesson: str
    student: str
    score: float
    max_score: float
    exercises: tuple
    problems: tuple
    seconds: float
    key: str

    def as_dict(self) -> dict:
        """The published form: one JSON object."""
        content = dataclasses.asdict(self)
        del content["key"]
        return content


def write_verdict(verdict: Verdict, path: str | os.PathLike) -> None:
    """Write a verdict so that a reader finds a whole one or none."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(dataclasses.asdict(verdict), indent=1)
    with tempfile.NamedTemporaryFile(
        "w", dir=path.parent, suffix=".part", delete=False, encoding="utf-8"
    ) as file:
        file.write(text)
    os.replace(file.name, path)


def read_verdict(path: str | os.PathLike) -> Verdict | None:
    """The verdict in a file; None where there is none or it is damaged."""
    try:
        content = json.loads(Path(path).read_text("utf-8"))
        exercises = tuple(
            ExerciseResult(
                **{**exercise, "tests": tuple(TestResult(**test) for test in exercise["tests"])}
            )
            for exercise in content["exercises"]
        )
        return Verdict(
            **{**content, "exercises": exercises, "problems": tuple(content["problems"])}
        )
    except (OSError, ValueError, TypeError, KeyError):
        return None
