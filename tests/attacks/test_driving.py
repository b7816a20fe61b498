"""League detectors that search for the street's data instead of detecting obstacles."""

import numpy as np

from extension.league.drives import DETECTOR, _unpack, drive_in_sandbox
from extension.league.streets import streets_of
from grader.course.paths import PROJECT
from grader.sandbox import SANDBOXES, Limits
from grader.sandbox.program import Program
from grader.sandbox.student import StudentProxy
from tests.attacks.attack import SANDBOX, SHORT
from utils.simulator.sensor import Sensor, layers

SEED = 2**70 + 1
BLINKERED = Sensor(layers(2, 0.0, -1.0), np.radians(90), maximum_range=5.0)

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
        street = streets_of(SEED)[0]
        driven = drive_in_sandbox(street, student, seconds=0.5, sensor=BLINKERED)
    assert not driven.stopped and not driven.failed
    return {float(boxes.max()) / 1000 for boxes in _unpack(driven.answers)}


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
