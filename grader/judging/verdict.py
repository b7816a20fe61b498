"""The verdict on one notebook, and its file."""

from __future__ import annotations

import dataclasses
import enum
import functools
import json
import os
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from grader.course.atomic_files import write_atomically

MAX_LINE_LENGTH = 100
JUDGED, FAILED = "judged", "judge_failed"


class MessageKind(enum.StrEnum):
    """The kind of a check's message. Feedback pages use the kind instead of parsing the text."""

    OWN = "own"  # the message explains this check; also used if there is no message
    SAME_REASON = "same reason"  # the check fails for the same reason as another check
    WAITING = "waiting"  # the check cannot be judged before a more basic one passes
    NOT_STARTED = "not started"  # the function is still a stub
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
        The full message, which may have several lines; empty if the check passed.
    visible : bool
        Whether students see the check in the notebook.
    kind : MessageKind
    subject : str
        Subject of the message: the function that is not started, the title of the check that
        failed for the same reason, or the property that has to be right first.
    hint : str
        The line of the message that contains the hint.
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
    """The only error in an answer: either an edit that corrects it, or a named mistake.

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
        """The sentence for the student, which also mentions points kept for a single slip."""
        points = f"{self.score:g} more point{'s' * (self.score != 1)}"
        kept = f" Because this is the only mistake, the exercise keeps {points}."
        return f"{self.place}{kept if self.score else ''}"

    @property
    def place(self) -> str:
        """The sentence that says where the slip is, but not how to correct it."""
        if not self.cell:
            return "The mistake named above explains every wrong answer."
        line = self.before.split("\n")[0].strip()[:MAX_LINE_LENGTH]
        where = f"code cell {self.cell}, line {self.line} (`{line}`)"
        return f"One change in {where} would correct this exercise."


@dataclass(frozen=True)
class Gain:
    """The points that an exercise gains with the lesson's helpers.

    Attributes
    ----------
    exercise : str
    max_score : float
        Points of the exercise.
    helpers : tuple of str
        The functions that were replaced, because they are wrong or got a note.
    wrong : tuple of str
        Those of the helpers that are wrong.
    before, after : float
        Points of the exercise's checks with the student's helpers, and with the lesson's.
    """

    exercise: str
    max_score: float
    helpers: tuple[str, ...]
    wrong: tuple[str, ...]
    before: float
    after: float

    @property
    def reason(self) -> str:
        """The sentences that say what is wrong with the helpers."""
        name, verb = self.exercise, "is" if len(self.wrong) == 1 else "are"
        wrong = [f"{' and '.join(self.wrong)}, which {name} calls, {verb} wrong."]
        others = [
            f"{helper}, which {name} calls, is right, but {name} needs its result in another form."
            for helper in self.helpers
            if helper not in self.wrong
        ]
        return " ".join([*(wrong if self.wrong else []), *others])

    @property
    def sentence(self) -> str:
        """The reason and the points, for the student."""
        return (
            f"{self.reason} With the lesson's {' and '.join(self.helpers)} instead, the checks of "
            f"{self.exercise} earn {self.after:g} of {self.max_score:g} points, "
            f"not {self.before:g}."
        )


@dataclass(frozen=True)
class ExerciseResult:
    """The result of one exercise, with its checks.

    Attributes
    ----------
    name : str
    score, max_score : float
    tests : tuple of CheckResult
    cause : str
        Message about the first problem to fix; empty if no check failed.
    first : str
        Name of the check with this problem; empty if no check failed or nothing was written.
    slip : Slip or None
        The proven slip, if there is one.
    gain : Gain or None
        The points gained with the lesson's helpers, if there are any.
    """

    name: str
    score: float
    max_score: float
    tests: tuple
    cause: str = ""
    first: str = ""
    slip: Slip | None = None
    gain: Gain | None = None


@dataclass(frozen=True)
class Verdict:
    """The verdict on one notebook.

    Attributes
    ----------
    lesson, student : str
    status : {"judged", "judge_failed"}
        Whether judging succeeded. If it failed, the score is meaningless.
    score, max_score : float
        Points of the machine-graded exercises.
    exercises : tuple of ExerciseResult
    problems : tuple of str
        One sentence for each problem with the notebook as a whole.
    seconds : float
        Wall-clock time that judging took.
    key : str
        Fingerprint of everything that the verdict depends on.
    faults : tuple of str
        Failures of the judge itself, with tracebacks, for the instructor.
    starved : bool
        Whether points were lost, and the machine was too busy or had too little memory.
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

    @property
    def reason(self) -> str:
        """Why there is no score; meaningful only if judging failed."""
        return self.problems[0] if self.problems else ""

    @property
    def findings(self) -> tuple[str, ...]:
        """The problems without the sentences about helpers, which are ordinary mistakes."""
        gains = {exercise.gain.sentence for exercise in self.exercises if exercise.gain}
        return tuple(problem for problem in self.problems if problem not in gains)

    def points_without(self, excluded: Collection[str]) -> tuple[float, float]:
        """Return the score and the maximum score without the exercises that are switched off."""
        counted = [exercise for exercise in self.exercises if exercise.name not in excluded]
        return (
            sum(exercise.score for exercise in counted),
            sum(exercise.max_score for exercise in counted),
        )

    def as_dict(self) -> dict:
        """Return the published form of the verdict, as a JSON object."""
        content = dataclasses.asdict(self)
        for private in ("key", "faults", "starved", "fingerprint"):
            del content[private]
        for exercise in content["exercises"]:
            # Only reports need these fields, which repeat the checks' messages.
            del exercise["cause"], exercise["first"], exercise["gain"]
            for test in exercise["tests"]:
                del test["kind"], test["subject"], test["hint"]
            if exercise["slip"]:  # students have to find the correction themselves
                del exercise["slip"]["before"], exercise["slip"]["after"]
        return content

    def without_starved_flag(self) -> Verdict:
        """Return the verdict with `starved` set to False, after a run on an idle machine."""
        return dataclasses.replace(self, starved=False)

    def compact(self) -> Verdict:
        """Return an equal verdict that shares equal parts with other verdicts, to save memory.

        Most checks end the same way for most students, and a class may have ten thousand.
        """
        return dataclasses.replace(self, exercises=tuple(map(with_shared_parts, self.exercises)))


def with_shared_parts(exercise: ExerciseResult) -> ExerciseResult:
    """Return an equal result that shares its parts with equal results of other students."""
    tests = tuple(map(_intern, exercise.tests))
    return _intern(dataclasses.replace(exercise, tests=tests))


@functools.lru_cache(maxsize=2**14)
def _intern(result: CheckResult | ExerciseResult) -> CheckResult | ExerciseResult:
    """Return the earliest result that is equal to this one."""
    return result


def write_verdict(verdict: Verdict, path: str | os.PathLike) -> None:
    """Write a verdict atomically, so that readers find either a complete file or none."""
    write_atomically(json.dumps(dataclasses.asdict(verdict), indent=1), Path(path))


def _read_gain(content: dict) -> Gain:
    lists = {name: tuple(content[name]) for name in ("helpers", "wrong")}
    return Gain(**{**content, **lists})


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
                    "gain": exercise.get("gain") and _read_gain(exercise["gain"]),
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
