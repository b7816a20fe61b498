"""Every lesson runs to the end if another scan takes the place of the course's.

Lessons that need the truth say so, and go on with the course's scan.
"""

import shutil

import nbformat
import numpy as np
import pytest

from grader.course.paths import PROJECT
from tests.notebook_runs import errors_of, printed_text, run
from utils.clouds import write_cloud


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """Return a copy of the course in which a room takes the place of the street."""
    folder = tmp_path_factory.mktemp("course")
    for name in ("utils", "data", "notebooks"):
        shutil.copytree(PROJECT / name, folder / name)
    write_cloud(folder / "data" / "cloud.txt", room())
    return folder


def room() -> np.ndarray:
    """Return the scan of a room of 6 x 5 x 2.6 m with a table, without intensities."""
    rng = np.random.default_rng(5)
    half = np.array([3, 2.5, 1.3])
    points = rng.uniform(-half, half, (30_000, 3))
    axis, side = rng.integers(0, 3, len(points)), rng.choice([-1, 1], len(points))
    points[np.arange(len(points)), axis] = side * half[axis]
    table = rng.uniform((0.8, -0.5, -0.6), (2.2, 0.5, -0.58), (3000, 3))
    return np.vstack([points, table]).round(3)


@pytest.mark.proof
def test_a_lesson_runs_to_the_end_with_the_scan_of_a_room(lesson, course):
    notebook = nbformat.read(lesson.solved, as_version=4)
    run(notebook, course / lesson.released.parent.relative_to(PROJECT))
    assert errors_of(notebook) == []
    said = printed_text(notebook, "stdout").count("data/cloud.txt is not the course's scan.")
    # `load_street` also returns what each beam hit, which only the course's scan has.
    assert said == ("load_street()" in lesson.source.read_text("utf-8"))
