"""The outcome of judging one notebook, and how it is kept on disk."""

from __future__ import annotations

import dataclasses
import enum
import functools
import json
import os
from dataclasses import dataclass
from pathlib import Path

from grader.course.atomic_files import write_atomically

LONGEST_LINE = 100
JUDGED, FAILED = "judged", "judge_failed"


class Kind(enum.StrEnum):
    """The kind of a check's message. Layout and folding use it, never the words."""

    OWN = "own"  # says something of its own; also an empty message
    SAME_REASON = "same reason"  # fails for the same reason as another check
    WAITING = "waiting"  # cannot be judged before something more basic is right
    NOT_STARTED = "not started"  # meets a stub
    OUT_OF_TIME = "out of time"  # a call took too long


@dataclass(frozen=True)
class CheckResult:
    """One check: what it demands, whether it holds, and what to tell the student.

    Attributes
    ----------
    name, title : str
    passed : bool
    score, max_score : float
    message : str
        All that there is to read, line by line.
    visible : bool
        Whether students see the check in the notebook.
    kind : Kind
    subject : str
        What the message is about: the function that is not started, the title of the check with
        the same reason, or what has to be right first.
    hint : str
        The line of the message that is a hint.
    """

    name: str
    title: str
    passed: bool
    score: float
    max_score: float
    message: str
    visible: bool
    kind: Kind = Kind.OWN
    subject: str = ""
    hint: str = ""


@dataclass(frozen=True)
class Slip:
    """What alone is wrong in an answer: the edit with which it is right, or a named mistake.

    Attributes
    ----------
    cell, line : int
        Where the edit is in the notebook's code cells; 0 for a mistake.
    before, after : str
        The lines that change, and what they become; empty for a mistake.
    score : float
        Points that the answer keeps for it, beside those of its checks.
    """

    cell: int
    line: int
    before: str
    after: str
    score: float

    @property
    def sentence(self) -> str:
        """What a student may read: where, and not what."""
        kept = (
            " An answer that is wrong in one thing keeps this for the rest." if self.score else ""
        )
        if not self.cell:
            return f"The mistake that is named here explains every answer.{kept}"
        line = self.before.split("\n")[0].strip()[:LONGEST_LINE]
        place = f"code cell {self.cell}, line {self.line} (`{line}`)"
        return f"One change in {place} makes everything here right.{kept}"


@dataclass(frozen=True)
class ExerciseResult:
    """One exercise with its tests.

    Attributes
    ----------
    name : str
    score, max_score : float
    tests : tuple of CheckResult
    cause : str
        What to mend first, line by line; empty where nothing failed.
    first : str
        Name of the check that this is about; empty where none failed or nothing was written.
    slip : Slip or None
        What alone is wrong, where that is proven.
    """

    name: str
    score: float
    max_score: float
    tests: tuple
    cause: str = ""
    first: str = ""
    slip: Slip | None = None


@dataclass(frozen=True)
class Verdict:
    """One judged notebook.

    Attributes
    ----------
    lesson, student : str
    status : {"judged", "judge_failed"}
        Whether the score says anything about the student.
    score, max_score : float
        Points of what a machine grades.
    exercises : tuple of ExerciseResult
    problems : tuple of str
        What is wrong with the notebook as a whole, one sentence each.
    seconds : float
        Wall-clock time that judging took.
    key : str
        Fingerprint of all that the verdict depends on.
    faults : tuple of str
        What went wrong in the judge, with tracebacks, for whoever grades.
    starved : bool
        Whether points were lost, and a time limit reached by code that hardly had a processor.
    fingerprint : str
        Of what was judged; empty where that is not known.
    """

    lesson: str
    student: str
    status: str
    score: float
    max_score: float
    exercises: tuple
    problems: tuple
    seconds: float
    key: str
    faults: tuple = ()
    starved: bool = False
    fingerprint: str = ""

    def as_dict(self) -> dict:
        """The published form: one JSON object."""
        content = dataclasses.asdict(self)
        for private in ("key", "faults", "starved", "fingerprint"):
            del content[private]
        for exercise in content["exercises"]:
            # A summary for reports: the messages of the tests say it all.
            del exercise["cause"], exercise["first"]
            for test in exercise["tests"]:
                del test["kind"], test["subject"], test["hint"]
            if exercise["slip"]:  # what to write there is for the student to find
                del exercise["slip"]["before"], exercise["slip"]["after"]
        return content

    def believed(self) -> Verdict:
        """The same, after it was reached with the machine to itself."""
        return dataclasses.replace(self, starved=False)

    def compact(self) -> Verdict:
        """The same, in little memory: what a class has in common is there once.

        Most checks end alike for most students, and a class may be ten thousand.
        """
        return dataclasses.replace(self, exercises=tuple(map(shared, self.exercises)))


def shared(exercise: ExerciseResult) -> ExerciseResult:
    """The same, made of what is in memory already: most students' results are alike."""
    tests = tuple(map(_the_same, exercise.tests))
    return _the_same(dataclasses.replace(exercise, tests=tests))


@functools.lru_cache(maxsize=2**14)
def _the_same(result: CheckResult | ExerciseResult) -> CheckResult | ExerciseResult:
    """The first one that was equal to this."""
    return result


def write_verdict(verdict: Verdict, path: str | os.PathLike) -> None:
    """Write a verdict so that a reader finds a whole one or none."""
    write_atomically(json.dumps(dataclasses.asdict(verdict), indent=1), Path(path))


def read_verdict(path: str | os.PathLike) -> Verdict | None:
    """The verdict in a file; None where there is none or it is damaged."""
    try:
        content = json.loads(Path(path).read_text("utf-8"))
        exercises = tuple(
            ExerciseResult(
                **{
                    **exercise,
                    "tests": tuple(CheckResult(**test) for test in exercise["tests"]),
                    "slip": exercise["slip"] and Slip(**exercise["slip"]),
                }
            )
            for exercise in content["exercises"]
        )
        return Verdict(
            **{
                **content,
                "exercises": exercises,
                "problems": tuple(content["problems"]),
                "faults": tuple(content["faults"]),
            }
        ).compact()
    except (OSError, ValueError, TypeError, KeyError):
        return None
