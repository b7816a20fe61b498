"""League detectors that search for the street's data, or return unexpected boxes."""

import numpy as np
import pytest

from extension.league import drives
from extension.league.drives import DETECTOR, _unpack_answers, drive_in_sandbox, repeat_drive
from extension.league.page import problem_sentences
from extension.league.streets import draw_streets
from grader.course.paths import PROJECT
from grader.sandbox import SANDBOXES, Limits
from grader.sandbox.inside import wire_format
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from tests.attacks.attack import SANDBOX, SHORT, with_attacks
from utils.drive.film import make_film
from utils.simulator.sensor import Sensor, layers

SEED = 2**70 + 1
NARROW_SENSOR = Sensor(layers(2, 0.0, -1.0), np.radians(90), maximum_range=5.0)

SNOOPING = """
import os, sys
import numpy as np

def detect_obstacles(cloud):
    found = []
    try:
        import extension.league.streets
        found.append("the streets")
    except ImportError:
        pass
    found += [name for name in sys.modules if name.startswith("grader.")]
    for path in {paths!r}:
        try:
            found.append(os.listdir(path) if os.path.isdir(path) else open(path, "rb").read(1))
        except OSError:
            pass
    return np.full((1, 8, 3), 100.0 + len(found))
"""


def answers_of(sandbox, source):
    with StudentProxy(Program((source,), (DETECTOR,)), sandbox, Limits(**SHORT)) as student:
        street = draw_streets(SEED)[0]
        driven = drive_in_sandbox(street, student, seconds=0.5, sensor=NARROW_SENSOR)
    assert not driven.stopped and not driven.failed
    return {float(boxes.max()) / 1000 for boxes in _unpack_answers(driven.answers)}


def test_a_detector_finds_no_street_seed_or_other_submission(tmp_path):
    """The sandbox hides these files from a detector, which would find them without a sandbox."""
    for name in (".course_seed", "submitted/ada/notebook.ipynb", "verdicts/ada/street_1.json"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("a secret")
    inside = [str(path) for path in (tmp_path, *sorted(tmp_path.rglob("*")))]
    ours = [str(PROJECT / name) for name in ("grader/classroom", "solutions", "utils/drive")]
    source = SNOOPING.format(paths=[*inside, *ours])
    assert answers_of(SANDBOX, source) == {100.0}
    assert min(answers_of(SANDBOXES["process"], source)) > 103.0


# Code that replaces each answer with a list of empty lists, without taking time to create them.
EMPTY_LISTS = """
import os, struct
LISTS = b'{"list":[' + b",".join([b'{"list":[]}'] * 250_000) + b"]}"
write, calls = os.write, 0

def empty_lists(end, data):
    text = b'{"dict":[["id",%d],["result",%s]]}' % (calls, LISTS)
    message = memoryview(struct.pack(">II", len(text), 0) + text)
    while message:
        message = message[write(end, message):]
    return len(data)

def detect_obstacles(cloud):
    global calls
    calls, os.write = calls + 1, empty_lists
"""


def test_answers_that_take_too_long_to_read_end_the_drive(monkeypatch):
    """Such a list counts as "no boxes", but reading it costs the grader a second."""
    monkeypatch.setattr(drives, "REPLY_SECONDS", 0.1)
    street = draw_streets(SEED)[0]
    with StudentProxy(Program((EMPTY_LISTS,), (DETECTOR,)), SANDBOX, Limits(**SHORT)) as student:
        driven = drive_in_sandbox(street, student, seconds=0.5, sensor=NARROW_SENSOR)
    assert driven.stopped.startswith("The detector's answers were so large")


class DecodedDetector:
    """A detector in this process, whose answers are encoded as between processes."""

    exercise, starved = "", False

    def __init__(self, answer):
        self._answer = answer

    def detect_obstacles(self, cloud):
        message = wire_format.encode(self._answer(cloud))
        tree, blob = wire_format.sizes_in(message[: wire_format.HEADER.size])
        start = wire_format.HEADER.size
        return wire_format.decode(message[start : start + tree], message[start + tree :])


def cuboid(centre, half):
    signs = [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    return np.asarray(centre, dtype=float) + half * np.array(signs)


RANDOM = np.random.default_rng(29)


@with_attacks(
    "boxes",
    {
        "corners in any order": lambda: RANDOM.uniform(-30, 30, (20, 8, 3)),
        "as far away as possible": lambda: RANDOM.choice([-999.9, 999.9], (20, 8, 3)),
        "farther away": lambda: np.full((3, 8, 3), 1e300),
        "points": lambda: np.tile(RANDOM.uniform(-5, 30, (20, 1, 3)), (1, 8, 1)),
        "all at the scanner": lambda: np.zeros((20, 8, 3)),
        "vertical lines ahead": lambda: np.array([[[8.0, 0.0, z] for z in range(8)]] * 3),
        "lines along the bumper": lambda: np.array([[[3.0, y, 0.0] for y in range(8)]] * 3),
        "around the camera of the film": lambda: np.array(
            [cuboid((-13, 0, 8), 0), cuboid((-13, 0, 8), 2)]
        ),
        "ahead, jumping": lambda: cuboid((RANDOM.uniform(6, 9), 0, -1), 1.0)[None],
        "infinite and not numbers": lambda: np.full((3, 8, 3), [np.nan, np.inf, 0.0]),
        "of another type": lambda: np.ones((2, 8, 3), dtype=bool),
        "in another container": lambda: cuboid((9, 0, -1), 1.0)[None].astype(str).tolist(),
    },
)
def test_strange_boxes_do_not_make_the_grader_fail(boxes, tmp_path):
    """If the grader failed, one student could stop the league for the whole class."""
    street = draw_streets(SEED)[0]
    driven = drive_in_sandbox(
        street, DecodedDetector(lambda cloud: boxes()), seconds=0.9, sensor=NARROW_SENSOR
    )
    assert not driven.fault and not driven.stopped
    assert all(sentence.isprintable() for sentence in problem_sentences(driven))
    repeated, report = repeat_drive(driven, street, seconds=0.9, sensor=NARROW_SENSOR)
    assert report.metres == pytest.approx(driven.metres, abs=0.05)
    make_film(repeated, report, tmp_path / "last.png", size=(64, 36), renderer="matplotlib")


def test_results_contain_only_numbers_and_fixed_sentences():
    """A name, a text or a type that the student chose does not reach the page of the league."""
    markup = "<script>alert(1)</script>"
    answers = {
        "a text": lambda: markup,
        "keys": lambda: {markup: markup},
        "nested": lambda: [[[markup] * 3] * 8],
        "a type": lambda: type(markup, (), {})(),
    }
    street = draw_streets(SEED)[0]
    for answer in answers.values():
        detector = DecodedDetector(lambda cloud, answer=answer: answer())
        driven = drive_in_sandbox(street, detector, seconds=0.3, sensor=NARROW_SENSOR)
        assert driven.failed and "script" not in driven.as_json()
