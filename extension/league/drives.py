"""Drive one street with one detector.

This process simulates the car and the street, and measures the drive. The detector runs in a
sandbox, receives scans and returns boxes. Its computing time does not affect the result if it is
within the limits. Otherwise, tenths of a second on a shared machine would decide the ranking.
"""

from __future__ import annotations

import base64
import functools
import hashlib
import json
import time
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from extension.league.streets import draw_streets
from grader.course.lessons import Lesson, find_lesson
from grader.course.paths import PROJECT
from grader.intake.preflight import prepare_to_judge
from grader.intake.reader_process import ReadingFailed
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import program_for
from grader.judging.verdict_key import add_imports, key_of_files
from grader.sandbox import SANDBOXES, Limits
from grader.sandbox.failures import StudentError, StudentStopped
from grader.sandbox.student import StudentProxy
from utils.drive.clock import on_time
from utils.drive.loop import Drive, drive
from utils.drive.metrics import Report, measure
from utils.drive.streets import SCANNER, Street
from utils.films.film import as_boxes
from utils.notebooks.reading import UnreadableNotebook
from utils.simulator.sensor import Sensor

DETECTOR = "detect_obstacles"
DRIVE_SECONDS = 20.0
LIMITS = Limits(call_seconds=5.0, total_seconds=120.0)
MAX_BOXES = 300
"""Maximum number of boxes in a scan: more than one per square metre in front of the car."""
MAX_FAILURES = 20
"""Number of scans without an answer after which a drive ends."""
REPLY_SECONDS = 30.0
"""Processor seconds that this process may use to read a drive's answers; usually it needs 1 s."""
MAX_DISTANCE = 1000.0
"""Distance in metres beyond which a box is dropped; no scanner has such a range."""


@dataclass(frozen=True)
class DriveResult:
    """The result of a drive. Its sentences contain no text that the student chose.

    Attributes
    ----------
    street : int
        Number of the street.
    metres : float
        Distance driven.
    collision : str
        A sentence about the collision; empty if there was none.
    brakings : tuple of str
        The cause of each braking event, in order.
    needless : tuple of bool
        Whether each of these events was unnecessary.
    near_misses : int
        Number of near misses.
    stopped : str
        Why the drive ended early, if the detector is at fault.
    failed : int
        Number of scans for which the detector failed to return boxes.
    failure : str
        A sentence about the detector's first failure.
    answers : str
        All answers of the detector, packed for `repeat_drive`.
    starved : bool
        Whether the detector was stopped before it had used up its time, because this machine was
        busy.
    fault : str
        A failure of the grader, which makes the result meaningless; empty if there was none.
    key : str
        Fingerprint of everything the drive depends on.
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
        """Return the text that is stored on disk."""
        return json.dumps(asdict(self))


def from_json(text: str) -> DriveResult:
    """Read a stored drive; raise ValueError, TypeError or KeyError if the text is not one."""
    content = json.loads(text)
    lists = {name: tuple(content[name]) for name in ("brakings", "needless")}
    return DriveResult(**{**content, **lists})


def drive_submission(
    submitted_files: SubmittedFiles | None, lesson: str, street_number: int, seed: int, sandbox: str
) -> DriveResult:
    """Drive one street and return the result.

    Arguments and result are plain data, so any machine with the course can run this function.

    Parameters
    ----------
    submitted_files : grader.intake.submission.SubmittedFiles or None
        The submission, or None to drive with the true boxes.
    lesson : str
        Name of the submission's lesson.
    street_number : int
        Number of the street.
    seed : int
        The course's secret.
    sandbox : str
        A name in `grader.sandbox.SANDBOXES`.
    """
    street = draw_streets(seed)[street_number - 1]
    key = drive_key(submitted_files, street, find_lesson(lesson))
    if submitted_files is None:
        return _summarise_drive(drive(street), key)
    try:
        judge_input = prepare_to_judge(submitted_files, find_lesson(lesson))
    except UnreadableNotebook:
        # Only the verdict states the reason, which may contain a file name that the student chose.
        return DriveResult(street_number, stopped="The notebook cannot be read.", key=key)
    except ReadingFailed as error:
        return DriveResult(street_number, fault=str(error))
    program = program_for(find_lesson(lesson), judge_input.code, judge_input.modules)
    with StudentProxy(program, SANDBOXES[sandbox], LIMITS) as student:
        return drive_in_sandbox(street, student, key)


def drive_in_sandbox(
    street: Street,
    student: StudentProxy,
    key: str = "",
    *,
    seconds: float = DRIVE_SECONDS,
    sensor: Sensor = SCANNER,
) -> DriveResult:
    """Drive a street with a student's `DETECTOR`; see `drive_submission`."""
    student.exercise = DETECTOR
    detector = _SandboxedDetector(student)
    try:
        finished = drive(street, detector, clock=on_time, seconds=seconds, sensor=sensor)
    except StudentStopped as stop:
        failures = {
            "failed": detector.failed,
            "failure": detector.failure,
            "starved": student.starved,
        }
        return DriveResult(street.number, stopped=str(stop), key=key, **failures)
    return _summarise_drive(finished, key, detector)


def _summarise_drive(
    finished_drive: Drive, key: str, detector: _SandboxedDetector | None = None
) -> DriveResult:
    report = measure(finished_drive)
    return DriveResult(
        finished_drive.street.number,
        round(report.metres, 1),
        report.collision,
        tuple(map(str, report.brakings)),
        tuple(braking.needless for braking in report.brakings),
        report.near_misses,
        failed=detector.failed if detector else 0,
        failure=detector.failure if detector else "",
        answers=_pack_answers(detector.answers) if detector else "",
        key=key,
    )


class _SandboxedDetector:
    """A detector in a sandbox that returns at most `MAX_BOXES` finite boxes for a scan."""

    def __init__(self, student: StudentProxy) -> None:
        self._student = student
        self.answers: list[np.ndarray] = []
        self.failed, self.failure = 0, ""
        self._seconds = 0.0

    def __call__(self, cloud: np.ndarray) -> np.ndarray:
        before = time.process_time()
        boxes, failure = self._detect(cloud)
        # An answer of 250,000 empty lists contains no boxes, but reading it takes seconds.
        self._seconds += time.process_time() - before
        if self._seconds > REPLY_SECONDS:
            raise StudentStopped(
                f"The detector's answers were so large that reading them took {REPLY_SECONDS:g} "
                "seconds."
            )
        if failure:
            self.failed, self.failure = self.failed + 1, self.failure or failure
        if self.failed >= MAX_FAILURES:
            raise StudentStopped(
                f"The detector returned no boxes for {self.failed} scans. {self.failure}"
            )
        self.answers.append(boxes)
        return boxes / 1000

    def _detect(self, cloud: np.ndarray) -> tuple[np.ndarray, str]:
        """Return boxes in whole millimetres and an empty text, or no boxes and the reason."""
        no_boxes = np.empty((0, 8, 3), dtype=np.int32)
        try:
            returned = getattr(self._student, DETECTOR)(cloud)
        except StudentError as error:
            if error.type_name == "NotImplementedError":
                return no_boxes, "It calls a function that the student has not written."
            return no_boxes, f"{DETECTOR} raised {error.shown_type}."
        try:
            boxes = as_boxes(returned)
        except Exception:  # NumPy may raise any exception on untrusted data
            return no_boxes, f"{DETECTOR} did not return boxes of shape (N, 8, 3)."
        if len(boxes) > MAX_BOXES:
            return no_boxes, f"{DETECTOR} returned more than {MAX_BOXES} boxes."
        is_near = (np.abs(boxes) < MAX_DISTANCE).all(axis=(1, 2))  # False for NaN
        return np.round(1000 * boxes[is_near]).astype(np.int32), ""


def repeat_drive(
    result: DriveResult, street: Street, *, seconds: float = DRIVE_SECONDS, sensor: Sensor = SCANNER
) -> tuple[Drive, Report]:
    """Repeat a drive with the stored answers of its detector.

    Parameters
    ----------
    result : DriveResult
        The result of a drive that was not stopped.
    street : utils.drive.Street
        The street of that drive.
    seconds, sensor
        As for `utils.drive.loop.drive`.
    """
    answers = _unpack_answers(result.answers)
    repeated_drive = drive(
        street, lambda cloud: next(answers) / 1000, clock=on_time, seconds=seconds, sensor=sensor
    )
    return repeated_drive, measure(repeated_drive)


def _pack_answers(answers: Sequence[np.ndarray]) -> str:
    counts = np.array([len(boxes) for boxes in answers], dtype=np.int32)
    all_boxes = np.concatenate(answers) if answers else np.empty(0, dtype=np.int32)
    header = np.array([len(counts)], dtype=np.int32)
    data = b"".join(part.astype("<i4").tobytes() for part in (header, counts, all_boxes))
    return base64.b64encode(zlib.compress(data)).decode()


def _unpack_answers(text: str) -> Iterator[np.ndarray]:
    numbers = np.frombuffer(zlib.decompress(base64.b64decode(text)), "<i4")
    counts = numbers[1 : 1 + numbers[0]]
    boxes = numbers[1 + numbers[0] :].reshape(-1, 8, 3)
    return iter(np.split(boxes, np.cumsum(counts)[:-1]))


def drive_key(submitted_files: SubmittedFiles | None, street: Street, lesson: Lesson) -> str:
    """Return a fingerprint of everything that a drive depends on."""
    submission = submitted_files.fingerprint() if submitted_files else "true boxes"
    parts = (str(street.seed), _rules_fingerprint(lesson), submission)
    return hashlib.sha256("\0".join(parts).encode(errors="replace")).hexdigest()


@functools.cache
def _rules_fingerprint(lesson: Lesson) -> str:
    entries = (Path(__file__), PROJECT / "grader" / "sandbox" / "fork_server.py")
    # The header of the lesson's source lists forbidden modules; the notebooks contain given code.
    notebooks = {lesson.source, lesson.solved, lesson.released}
    return key_of_files("league", add_imports(entries) | notebooks)
