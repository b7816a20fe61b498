"""Attacks through nbgrader's exchange, in which students own the folders that they submit."""

import getpass
import logging
import os
import pwd

import pytest
from nbgrader.auth import Authenticator
from nbgrader.coursedir import CourseDirectory
from nbgrader.exchange import ExchangeFactory
from traitlets.config import Config

from grader.course.nbgrader_settings import configure
from grader.lms import exchange_collection

STAGE, NOTEBOOK = "stage3_obstacles", "06_filter_ground.ipynb"
try:
    USER = getpass.getuser()
except (KeyError, OSError):  # an account without a name, as in some containers
    USER = f"user {os.getuid()}"
TIME = "2026-01-10 10:00:00.000000 UTC"
LATER = "2026-01-11 10:00:00.000000 UTC"


@pytest.fixture
def inbound(tmp_path):
    """Return the exchange's inbound folder, in which every account may create folders."""
    folder = tmp_path / "exchange" / "lidar_obstacle_lab" / "inbound"
    folder.mkdir(parents=True)
    return folder


@pytest.fixture
def collect(tmp_path, inbound, caplog):
    """Return a function that collects a stage and returns the collected files and the warnings."""
    course = tmp_path / "course"
    course.mkdir()

    def collect(check_owner=True, update=False):
        config = configure(Config(), course)
        config.Exchange.root = str(inbound.parents[1])
        config.CourseDirectory.assignment_id = STAGE
        config.ExchangeCollect.update = update
        config.ExchangeCollect.check_owner = check_owner
        factory = ExchangeFactory(config=config)
        caplog.clear()
        with caplog.at_level(logging.WARNING):
            collector = factory.Collect(
                coursedir=CourseDirectory(config=config), authenticator=Authenticator()
            )
            collector.log = logging.getLogger("exchange")
            collector.start()
        root = course / "submitted"
        files = {
            str(path.relative_to(root)): path.read_text()
            for path in root.rglob("*")
            if path.is_file()
        }
        assert not [path for path in root.rglob("*") if path.is_symlink()]
        return files, [record.getMessage() for record in caplog.records]

    return collect


def submit(inbound, files, student=USER, time=TIME, links=()):
    """Create the folder of a submission and return its path."""
    folder = inbound / f"{student}+{STAGE}+{time}+secret"
    folder.mkdir()
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    for name, target in dict(links).items():
        (folder / name).symlink_to(target)
    return folder


@pytest.fixture
def give_to_mallory(monkeypatch):
    """Return a function that gives a file or folder to another account."""
    if os.geteuid() == 0:
        return lambda path: os.chown(path, pwd.getpwnam("nobody").pw_uid, -1)
    owner, given = exchange_collection.owner_of, set()
    monkeypatch.setattr(
        exchange_collection,
        "owner_of",
        lambda status: "nobody" if status.st_ino in given else owner(status),
    )
    return lambda path: given.add(path.stat().st_ino)


def test_notebooks_and_modules_are_collected_with_their_time(inbound, collect):
    files = {NOTEBOOK: "{}", "helper.py": "x = 1", "timestamp.txt": TIME, "parts/more.py": "y = 2"}
    submit(inbound, {**files, ".ipynb_checkpoints/old.ipynb": "{}"})
    collected, _ = collect()
    assert collected == {f"{USER}/{STAGE}/{name}": text for name, text in files.items()}


def test_links_are_not_followed(inbound, collect, tmp_path):
    """Links to the solution, an endless device, a folder or a missing file are left out."""
    secret = tmp_path / "course" / "solution.ipynb"
    secret.write_text("the solution")
    links = {NOTEBOOK: secret, "a.ipynb": "/nowhere", "b.ipynb": "/dev/zero", "c": secret.parent}
    folder = submit(inbound, {"07_filter_by_distance.ipynb": "{}"}, links=links)
    os.mkfifo(folder / "pipe.ipynb")
    collected, warnings = collect()
    assert sorted(collected) == [
        f"{USER}/{STAGE}/07_filter_by_distance.ipynb",
        f"{USER}/{STAGE}/timestamp.txt",
    ]
    left_out = [text for text in warnings if text.startswith("Left out: ")]
    assert len(left_out) == 4 and any(f"/{NOTEBOOK} is a link" in text for text in left_out)


def test_a_folder_that_is_a_link_is_not_collected(inbound, collect, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / NOTEBOOK).write_text("a neighbour's answer")
    (inbound / f"{USER}+{STAGE}+{TIME}+secret").symlink_to(other)
    collected, warnings = collect()
    assert collected == {} and "Not collected: " in warnings[0]


@pytest.mark.parametrize(
    "name", [f"x+{STAGE}+yesterday", f"+{STAGE}+{TIME}+s", f"a\nb+{STAGE}+{TIME}+s"]
)
def test_a_misnamed_folder_does_not_prevent_collecting_other_folders(
    name, inbound, collect, tmp_path
):
    submit(inbound, {NOTEBOOK: "{}"})
    (inbound / name).mkdir()
    (inbound / name / NOTEBOOK).write_text("{}")
    collected, warnings = collect(check_owner=False)
    assert {path.split("/")[0] for path in collected} == {USER}
    assert [text for text in warnings if text.startswith("Not collected: ")]
    assert all("\n" not in text for text in warnings)
    assert not (tmp_path / "course" / STAGE).exists()


@pytest.mark.parametrize("student", ["..", ".", ".league"])
def test_hidden_names_do_not_lead_to_other_folders(student, inbound, collect, tmp_path):
    """nbgrader skips hidden folders even if it does not check their owners."""
    submit(inbound, {NOTEBOOK: "{}"}, student=student)
    assert collect(check_owner=False)[0] == {}
    assert not (tmp_path / "course" / STAGE).exists()


def test_another_students_name_is_refused(inbound, collect):
    submit(inbound, {NOTEBOOK: "{}"}, student="alice")
    collected, warnings = collect()
    assert collected == {} and f"but the folder belongs to {USER}" in warnings[0]
    collected, _ = collect(check_owner=False)
    assert f"alice/{STAGE}/{NOTEBOOK}" in collected


@pytest.mark.parametrize("kind", ["folder", "link", "file"])
def test_a_forged_newer_folder_does_not_hide_the_students_own(
    kind, inbound, collect, give_to_mallory
):
    """Every account may create folders in the exchange, under any student's name."""
    submit(inbound, {NOTEBOOK: "my answer"})
    forged = inbound / f"{USER}+{STAGE}+2099-01-01 00:00:00.000000 UTC+secret"
    if kind == "link":
        forged.symlink_to("/nowhere")
    elif kind == "file":
        forged.write_text("")
    else:
        forged.mkdir()
        (forged / NOTEBOOK).write_text("another answer")
        give_to_mallory(forged)
    collected, warnings = collect()
    assert collected[f"{USER}/{STAGE}/{NOTEBOOK}"] == "my answer"
    assert [text for text in warnings if text.startswith(f"Not collected: {forged.name} ")]


def test_a_file_of_another_account_is_refused(inbound, collect, give_to_mallory):
    """A hard link leads to a neighbour's file although the student owns the folder."""
    folder = submit(inbound, {NOTEBOOK: "{}", "07_filter_by_distance.ipynb": "a neighbour's"})
    give_to_mallory(folder / "07_filter_by_distance.ipynb")
    collected, warnings = collect()
    assert collected == {}
    assert "but 07_filter_by_distance.ipynb belongs to nobody" in warnings[0]


@pytest.mark.parametrize("name", [".collected.json", ".older/old.ipynb", "parts/.collected.json"])
def test_hidden_files_are_not_collected(name, inbound, collect):
    """The hidden record of `collect` states the owner and time of files, and could be forged."""
    submit(inbound, {NOTEBOOK: "{}", name: '{"files": {}, "others": "no time"}'})
    collected, _ = collect()
    assert sorted(collected) == [f"{USER}/{STAGE}/{NOTEBOOK}", f"{USER}/{STAGE}/timestamp.txt"]


def test_a_submission_time_set_by_the_student_is_reported(inbound, collect):
    """The folder's time replaces the one in `timestamp.txt` and is checked for plausibility."""
    submit(inbound, {NOTEBOOK: "{}", "timestamp.txt": "1999-01-01 00:00:00 UTC"})
    collected, warnings = collect()
    assert collected[f"{USER}/{STAGE}/timestamp.txt"] == TIME
    assert "the time in the name is 2026-01-10 10:00, but the folder was changed at" in warnings[0]


@pytest.mark.parametrize(
    ("stated", "written"),
    [
        ("2026-01-11T00:20:00 NZ", "2026-01-10 11:20:00.000000 UTC"),
        ("2026-01-11 00:20:00 -0200", "2026-01-11 02:20:00.000000 UTC"),
        # `grade` warns about a time without a zone, and asks for a time in an unknown zone.
        ("2026-01-11 00:20:00", "2026-01-11 00:20:00"),
        ("2026-01-11 00:20:00 XYZ", "2026-01-11 00:20:00 XYZ"),
    ],
)
def test_a_stated_time_is_read_as_grade_reads_it(stated, written, inbound, collect):
    """nbgrader ignores some time zones, so a time that it reads may look plausible but be wrong."""
    submit(inbound, {NOTEBOOK: "{}"}, time=stated)
    collected, warnings = collect()
    assert collected[f"{USER}/{STAGE}/timestamp.txt"] == written
    assert f"the time in the name is {written[:16]}, but" in warnings[0]


def test_a_submission_that_is_too_large_does_not_replace_the_earlier_submission(
    inbound, collect, monkeypatch
):
    submit(inbound, {NOTEBOOK: "first"})
    assert collect()[0][f"{USER}/{STAGE}/{NOTEBOOK}"] == "first"
    submit(inbound, {NOTEBOOK: "second" * 100}, time=LATER)
    monkeypatch.setattr(exchange_collection, "MAX_BYTES_PER_STUDENT", 100)
    collected, warnings = collect(update=True)
    assert collected[f"{USER}/{STAGE}/{NOTEBOOK}"] == "first"
    assert any("is larger than the remaining" in text for text in warnings)
    monkeypatch.undo()
    assert collect()[0][f"{USER}/{STAGE}/{NOTEBOOK}"] == "first"
    assert collect(update=True)[0][f"{USER}/{STAGE}/{NOTEBOOK}"] == "second" * 100


def test_only_the_first_entries_of_a_bottomless_folder_are_read(inbound, collect):
    """Walking to the bottom would use up all file descriptors or raise a RecursionError."""
    folder = submit(inbound, {NOTEBOOK: "{}", "parts/more.py": "y = 2"})
    (folder / "/".join("z" * 300)).mkdir(parents=True)
    submit(inbound, {NOTEBOOK: "{}"}, student="zoe")
    collected, warnings = collect(check_owner=False)
    assert {f"{USER}/{STAGE}/{NOTEBOOK}", f"zoe/{STAGE}/{NOTEBOOK}"} <= collected.keys()
    assert f"{USER}/{STAGE}/parts/more.py" in collected
    assert [text for text in warnings if text.endswith("has too many files or folders")]


@pytest.mark.parametrize("content", [None, b"", b"\xff"], ids=["missing", "empty", "not UTF-8"])
def test_a_damaged_secret_does_not_stop_feedback_for_the_class(content, tmp_path, caplog):
    """nbgrader names a feedback page after `submission_secret.txt`, which the student owns."""
    course = tmp_path / "course"
    for student in ("alice", "mallory", "zoe[1]"):
        folder = course / "feedback" / student / STAGE
        folder.mkdir(parents=True)
        (folder / "06_filter_ground.html").write_text(f"feedback for {student}")
        (folder / "timestamp.txt").write_text(TIME)
        (folder / "submission_secret.txt").write_text(f"secret of {student}")
    secret = course / "feedback" / "mallory" / STAGE / "submission_secret.txt"
    secret.unlink() if content is None else secret.write_bytes(content)
    (tmp_path / "exchange").mkdir()
    config = configure(Config(), course)
    config.Exchange.root = str(tmp_path / "exchange")
    config.CourseDirectory.assignment_id = STAGE
    release = ExchangeFactory(config=config).ReleaseFeedback(
        coursedir=CourseDirectory(config=config), authenticator=Authenticator()
    )
    release.log = logging.getLogger("exchange")
    with caplog.at_level(logging.WARNING):
        release.start()
    pages = (tmp_path / "exchange").rglob("*.html")
    assert {page.read_text() for page in pages} == {"feedback for alice", "feedback for zoe[1]"}
    [warning] = [record.getMessage() for record in caplog.records]
    assert (
        warning.startswith("The feedback for mallory was not released")
        and str(secret.parent) in warning
    )
