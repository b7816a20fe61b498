"""One street on one detector.

The car, the street and what is measured are here, the detector is behind walls: a scan goes in,
boxes come out. How long that takes does not count, as long as it keeps to the limits: on machines
that others use, too, tenths of a second would decide about places.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import json
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from grader.classroom.league.streets import streets_of
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import PROJECT
from grader.intake.preflight import prepare_to_judge
from grader.intake.reader_process import ReadingFailed
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import program_for
from grader.judging.key import key_of_files, with_all_they_run
from grader.sandbox import SANDBOXES, Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from utils.drive.clock import on_time
from utils.drive.loop import Drive, drive
from utils.drive.metrics import Report, measure
from utils.drive.streets import SCANNER, Street
from utils.films.film import checked_boxes
from utils.notebooks.reading import UnreadableNotebook
from utils.simulator.sensor import Sensor

DETECTOR = "detect_obstacles"
SECONDS = 20.0
LIMITS = Limits(call_seconds=5.0, total_seconds=120.0)
MOST_BOXES = 300
"""In a scan; who boxes every square metre in front of the car needs fewer."""
MOST_FAILURES = 20
"""Scans without an answer, after which a drive is over."""
FARTHEST = 1000.0
"""Metres beyond which a box is left out; no scanner looks so far."""


@dataclass(frozen=True)
class Driven:
    """What came of a drive, in plain data and in words of ours.

    Attributes
    ----------
    street : int
        Its number.
    metres : float
    collision : str
        A sentence; empty where nothing was hit.
    brakings : tuple of str
        For what the car braked, in order.
    needless : tuple of bool
        Whether each of these was for nothing.
    near_misses : int
    stopped : str
        Why the drive was not driven to its end, where a detector is at fault.
    failed : int
        Scans for which the detector had no boxes to give.
    failure : str
        How it first failed.
    answers : str
        All that the detector answered: what `driven_again` takes.
    starved : bool
        Whether it was stopped without having had its time: this machine was busy.
    fault : str
        What went wrong on our side; then nothing is said about the detector.
    key : str
        Of all that it depends on.
    """

    street: int
    metres: float = 0.0
    collision: str = ""
    brakings: tuple[str, ...] = ()
    needless: tuple[bool, ...] = ()
    near_misses: int = 0
    stopped: str = ""
    failed: int = 0
    failure: str = ""
    answers: str = ""
    starved: bool = False
    fault: str = ""
    key: str = ""

    def as_json(self) -> str:
        """What is kept on disk."""
        return json.dumps(asdict(self))


def from_json(text: str) -> Driven:
    """A drive that was kept; raises ValueError, TypeError or KeyError where it is none."""
    content = json.loads(text)
    lists = {name: tuple(content[name]) for name in ("brakings", "needless")}
    return Driven(**{**content, **lists})


def drive_one(
    handed_in: SubmittedFiles | None, lesson: str, number: int, seed: int, sandbox: str
) -> Driven:
    """Drive one street: plain data in, and out, wherever there is the course's code.

    Parameters
    ----------
    handed_in : grader.intake.submission.SubmittedFiles or None
        None drives on the true boxes.
    lesson : str
        Name of the lesson that was handed in.
    number : int
        Of the street.
    seed : int
        The course's secret.
    sandbox : str
        A name in `grader.sandbox.SANDBOXES`.
    """
    street = streets_of(seed)[number - 1]
    key = key_of(handed_in, street, find_lesson(lesson))
    if handed_in is None:
        return _measured(drive(street), key)
    try:
        to_judge = prepare_to_judge(handed_in, find_lesson(lesson))
    except UnreadableNotebook:  # why, its verdict says: a file's name is a student's word
        return Driven(number, stopped="The notebook cannot be read.", key=key)
    except ReadingFailed as error:
        return Driven(number, fault=str(error))
    program = program_for(find_lesson(lesson), to_judge.code, handed_in.modules)
    with StudentProxy(program, SANDBOXES[sandbox], LIMITS) as student:
        return drive_behind_walls(street, student, key)


def drive_behind_walls(
    street: Street,
    student: StudentProxy,
    key: str = "",
    *,
    seconds: float = SECONDS,
    sensor: Sensor = SCANNER,
) -> Driven:
    """Drive a street on a student's `DETECTOR`; see `drive_one`."""
    student.exercise = DETECTOR
    eyes = _Eyes(student)
    try:
        done = drive(street, eyes, clock=on_time, seconds=seconds, sensor=sensor)
    except StudentStopped as stop:
        about = {"failed": eyes.failed, "failure": eyes.failure, "starved": student.starved}
        return Driven(street.number, stopped=str(stop), key=key, **about)
    return _measured(done, key, eyes)


def _measured(done: Drive, key: str, eyes: _Eyes | None = None) -> Driven:
    report = measure(done)
    return Driven(
        done.street.number,
        round(report.metres, 1),
        report.collision,
        tuple(map(str, report.brakings)),
        tuple(braking.needless for braking in report.brakings),
        report.near_misses,
        failed=eyes.failed if eyes else 0,
        failure=eyes.failure if eyes else "",
        answers=_packed(eyes.answers) if eyes else "",
        key=key,
    )


class _Eyes:
    """A detector behind walls: whatever it answers, what comes out here are a few finite boxes."""

    def __init__(self, student: StudentProxy) -> None:
        self._student = student
        self.answers: list[np.ndarray] = []
        self.failed, self.failure = 0, ""

    def __call__(self, cloud: np.ndarray) -> np.ndarray:
        boxes, failure = self._look(cloud)
        if failure:
            self.failed, self.failure = self.failed + 1, self.failure or failure
        if self.failed >= MOST_FAILURES:
            raise StudentStopped(f"It had no boxes to give for {self.failed} scans. {self.failure}")
        self.answers.append(boxes)
        return boxes / 1000

    def _look(self, cloud: np.ndarray) -> tuple[np.ndarray, str]:
        """Boxes in whole millimetres, as they can be kept; or none, and why."""
        none = np.empty((0, 8, 3), dtype=np.int32)
        try:
            found = getattr(self._student, DETECTOR)(cloud)
        except StudentError as error:
            if error.type_name == "NotImplementedError":
                return none, "A function that it calls is not written yet."
            return none, f"{DETECTOR} raised {error.told_type}."
        try:
            boxes = checked_boxes(found)
        except Exception:  # of a stranger's data NumPy may complain in any way
            return none, f"{DETECTOR} returned something else than boxes (N, 8, 3)."
        if len(boxes) > MOST_BOXES:
            return none, f"{DETECTOR} returned more than {MOST_BOXES} boxes."
        near = (np.abs(boxes) < FARTHEST).all(axis=(1, 2))  # which no NaN is
        return np.round(1000 * boxes[near]).astype(np.int32), ""


def driven_again(
    driven: Driven, street: Street, *, seconds: float = SECONDS, sensor: Sensor = SCANNER
) -> tuple[Drive, Report]:
    """The same drive once more, of what its detector answered then.

    Parameters
    ----------
    driven : Driven
        One that was driven to its end.
    street : utils.drive.Street
        That it was driven in.
    """
    answers = _unpacked(driven.answers)
    done = drive(
        street, lambda cloud: next(answers) / 1000, clock=on_time, seconds=seconds, sensor=sensor
    )
    return done, measure(done)


def _packed(answers: Sequence[np.ndarray]) -> str:
    counts = np.array([len(boxes) for boxes in answers], dtype=np.int32)
    every = np.concatenate(answers) if answers else np.empty(0, dtype=np.int32)
    head = np.array([len(counts)], dtype=np.int32)
    data = b"".join(part.astype("<i4").tobytes() for part in (head, counts, every))
    return base64.b64encode(zlib.compress(data)).decode()


def _unpacked(text: str) -> Iterator[np.ndarray]:
    numbers = np.frombuffer(zlib.decompress(base64.b64decode(text)), "<i4")
    counts = numbers[1 : 1 + numbers[0]]
    boxes = numbers[1 + numbers[0] :].reshape(-1, 8, 3)
    return iter(np.split(boxes, np.cumsum(counts)[:-1]))


def key_of(handed_in: SubmittedFiles | None, street: Street, lesson: Lesson) -> str:
    """Fingerprint of everything that a drive depends on."""
    submission = handed_in.fingerprint() if handed_in else "true boxes"
    about = (str(street.seed), _rules(lesson), submission)
    return hashlib.sha256("\0".join(about).encode(errors="replace")).hexdigest()


@functools.cache
def _rules(lesson: Lesson) -> str:
    entries = (Path(__file__), PROJECT / "grader" / "sandbox" / "fork_server.py")
    # The lesson's header says what a detector may use; the notebooks hold what it is given.
    notebooks = {lesson.source, lesson.solved, lesson.released}
    return key_of_files("league", with_all_they_run(entries) | notebooks)
