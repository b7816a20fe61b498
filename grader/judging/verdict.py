"""The verdict on one notebook, and its file."""

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


class MessageKind(enum.StrEnum):
    """The kind of a check's message. Layout and folding use it, never the words."""

    OWN = "own"  # says something of its own; also an empty message
    SAME_REASON = "same reason"  # fails for the same reason as another check
    WAITING = "waiting"  # cannot be judged before something more basic is right
    NOT_STARTED = "not started"  # meets a stub
    OUT_OF_TIME = "out of time"  # a call took too long


@dataclass(frozen=True)
class CheckResult:
    """The result of one check, with the message for the student.

    Attributes
    ----------
    name, title : str
    passed : bool
    score, max_score : float
    message : str
        The whole message, line by line; empty if the check passed.
    visible : bool
        Whether students see the check in the notebook.
    kind : MessageKind
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
    kind: MessageKind = MessageKind.OWN
    subject: str = ""
    hint: str = ""


@dataclass(frozen=True)
class Slip:
    """The one thing that is wrong in an answer: an edit that makes it right, or a named mistake.

    Attributes
    ----------
    cell, line : int
        Code cell and line of the edit in the notebook; 0 for a mistake.
    before, after : str
        The lines that change, and their new text; empty for a mistake.
    score : float
        Points that the answer keeps in addition to those of its checks.
    """

    cell: int
    line: int
    before: str
    after: str
    score: float

    @property
    def sentence(self) -> str:
        """The sentence for the student, with the rule that keeps points if there is one slip."""
        kept = " An exercise with a single slip keeps these points." if self.score else ""
        return f"{self.place}{kept}"

    @property
    def place(self) -> str:
        """The sentence that says where the slip is, but not what it is."""
        if not self.cell:
            return "The mistake named here explains every wrong answer."
        line = self.before.split("\n")[0].strip()[:LONGEST_LINE]
        where = f"code cell {self.cell}, line {self.line} (`{line}`)"
        return f"One change in {where} makes everything here right."


@dataclass(frozen=True)
class ExerciseResult:
    """The result of one exercise, with its checks.

    Attributes
    ----------
    name : str
    score, max_score : float
    tests : tuple of CheckResult
    cause : str
        Message on the first thing to fix, line by line; empty if no check failed.
    first : str
        Name of the check that it is about; empty if none failed or nothing was written.
    slip : Slip or None
        The proven slip, if there is one.
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
    """The verdict on one notebook.

    Attributes
    ----------
    lesson, student : str
    status : {"judged", "judge_failed"}
        Whether the score says anything about the student.
    score, max_score : float
        Points of the machine-graded exercises.
    exercises : tuple of ExerciseResult
    problems : tuple of str
        One sentence for each thing that is wrong with the notebook as a whole.
    seconds : float
        Wall-clock time that judging took.
    key : str
        Fingerprint of everything that the verdict depends on.
    faults : tuple of str
        Failures of the judge itself, with tracebacks, for the instructor.
    starved : bool
        Whether points were lost while code reached a time limit because it hardly got a processor.
    fingerprint : str
        Fingerprint of the submission; empty if it is not known.
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
        """Return the published form: one JSON object."""
        content = dataclasses.asdict(self)
        for private in ("key", "faults", "starved", "fingerprint"):
            del content[private]
        for exercise in content["exercises"]:
            # Both summarize the messages of the checks, for reports.
            del exercise["cause"], exercise["first"]
            for test in exercise["tests"]:
                del test["kind"], test["subject"], test["hint"]
            if exercise["slip"]:  # students have to find the correction themselves
                del exercise["slip"]["before"], exercise["slip"]["after"]
        return content

    def without_starved(self) -> Verdict:
        """Return the same verdict without the mark `starved`, after a run on an idle machine."""
        return dataclasses.replace(self, starved=False)

    def compact(self) -> Verdict:
        """Return an equal verdict that shares equal parts with others, to save memory.

        Most checks end the same way for most students, and a class may have ten thousand.
        """
        return dataclasses.replace(self, exercises=tuple(map(with_shared_parts, self.exercises)))


def with_shared_parts(exercise: ExerciseResult) -> ExerciseResult:
    """Return an equal result whose parts are shared with equal results of other students."""
    tests = tuple(map(_interned, exercise.tests))
    return _interned(dataclasses.replace(exercise, tests=tests))


@functools.lru_cache(maxsize=2**14)
def _interned(result: CheckResult | ExerciseResult) -> CheckResult | ExerciseResult:
    """Return the first object that was equal to this one."""
    return result


def write_verdict(verdict: Verdict, path: str | os.PathLike) -> None:
    """Write a verdict atomically, so that a reader finds a complete file or none."""
    write_atomically(json.dumps(dataclasses.asdict(verdict), indent=1), Path(path))


def read_verdict(path: str | os.PathLike) -> Verdict | None:
    """Return the verdict in a file, or None if the file is missing or damaged."""
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
