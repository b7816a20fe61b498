"""Files are written completely or not at all, even if the disk is full."""

import random
import resource
import shutil

import pytest
from nbgrader.exchange.default import ExchangeReleaseAssignment

from grader.course import atomic_files, release, solutions, standalone
from grader.course.atomic_files import write_atomically
from grader.course.lessons import find_lesson
from grader.lms.exchange import ReleaseStandalone
from grader.lms.exporters.destination import write_export
from grader.lms.exporters.protocol import ExportError

LESSON = find_lesson("08_bounding_boxes")


@pytest.fixture
def full_disk():
    """Return a function that prevents files from growing beyond a thousand bytes."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)

    def fill():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))

    yield fill
    resource.setrlimit(resource.RLIMIT_FSIZE, limits)


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_a_failed_write_leaves_no_temporary_file(tmp_path, monkeypatch, error):
    path = tmp_path / "marks.csv"
    path.write_text("before")

    def fail(*about):
        raise error

    monkeypatch.setattr(atomic_files.os, "replace", fail)
    with pytest.raises(type(error)):
        write_atomically("after", path)
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [
        ("marks.csv", "before")
    ]


@pytest.mark.parametrize(("mask", "mode"), [(0o000, 0o666), (0o026, 0o640), (0o077, 0o600)])
def test_the_permissions_of_written_files_follow_the_umask(tmp_path, monkeypatch, mask, mode):
    monkeypatch.setattr(atomic_files, "_UMASK", mask)
    path = tmp_path / "a" / "b" / "c.json"
    write_atomically("a \ud800 word", path)  # a lone surrogate, which is not valid Unicode text
    write_atomically("a word", path)
    assert path.stat().st_mode & 0o777 == mode and path.read_text() == "a word"


def write_solutions(folder):
    content = random.Random(1).randbytes(5000)
    return list(solutions.write_solutions(folder, {LESSON: content}))


@pytest.mark.parametrize(
    "write",
    [
        lambda folder: list(release.write_zips(folder, [LESSON.stage])),
        lambda folder: standalone.write_standalone(folder, [LESSON.stage]),
        write_solutions,
    ],
)
def test_released_files_are_complete_or_unchanged(tmp_path, monkeypatch, full_disk, write):
    content = random.Random(1).randbytes(5000)  # random, so it cannot be compressed
    monkeypatch.setattr(release, "student_files", lambda stage: {"a": content})
    monkeypatch.setattr(standalone, "make_standalone", lambda notebook: content)
    monkeypatch.setattr(standalone, "check_no_leaks", lambda *about: None)
    monkeypatch.setattr(solutions, "render_page", lambda notebook, lesson: notebook)
    write(tmp_path / "there")
    before = {path: path.read_bytes() for path in (tmp_path / "there").iterdir()}
    full_disk()
    for folder in ("there", "new"):
        with pytest.raises(OSError, match="too large"):
            write(tmp_path / folder)
    assert {path: path.read_bytes() for path in (tmp_path / "there").iterdir()} == before
    assert list((tmp_path / "new").iterdir()) == []


def test_a_notebook_released_by_nbgrader_is_complete_or_unchanged(tmp_path, monkeypatch, full_disk):
    (tmp_path / "from").mkdir()
    shutil.copy(LESSON.released, tmp_path / "from")

    def copy(self, source, target, log=None):
        shutil.copytree(source, target)
        full_disk()

    monkeypatch.setattr(ExchangeReleaseAssignment, "do_copy", copy)
    with pytest.raises(OSError, match="too large"):
        ReleaseStandalone.do_copy(ReleaseStandalone(), tmp_path / "from", tmp_path / "to")
    (path,) = (tmp_path / "to").iterdir()
    assert path.read_bytes() == LESSON.released.read_bytes()


def test_an_export_is_complete_or_unchanged(tmp_path, full_disk):
    usual = tmp_path / "scores.csv"
    write_export(b"before", None, usual, None)
    full_disk()
    with pytest.raises(ExportError, match="cannot be written: File too large"):
        write_export(b"now" * 1000, None, usual, None)
    with pytest.raises(ExportError, match="cannot be written: File too large"):
        write_export(b"now" * 1000, tmp_path / "other.csv", usual, None)
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [
        ("scores.csv", b"before")
    ]
