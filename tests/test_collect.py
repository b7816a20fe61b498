"""Collecting a class's submissions from archives of learning platforms into ``submitted/``."""

import csv
import errno
import json
import os
import random
import re
import struct
import subprocess
import sys
import unicodedata
import zipfile
from datetime import UTC, datetime
from functools import partial

import pytest

from grader import cli, commands
from grader.classroom import lesson_recognition
from grader.classroom.collect import CollectError, inspection, zips
from grader.classroom.collect import collection as module
from grader.classroom.collect.instructor_answers import teams_in
from grader.classroom.collect.owners import safe_folder
from grader.classroom.collect.record import read_record, unknown_time_reason
from grader.classroom.submissions import find_submissions, unaccounted_files
from grader.course.paths import PROJECT, Course
from grader.lms.submission_times import SubmissionTimeUnknown, submission_time
from tests.archives import (
    EIGHT,
    NINE,
    SEVEN,
    SIX,
    STAGE3,
    blackboard_files,
    brightspace_files,
    canvas_files,
    canvas_prefix,
    gradescope_files,
    ilias_files,
    make_zip,
    moodle_files,
    notebook,
    prairielearn_files,
    released_notebook,
    sakai_files,
    worksheet,
)

pytestmark = pytest.mark.usefixtures("reading_without_fork")

STAGE = "stage3_obstacles"
PEOPLE = (
    ("ada", "Ada", "Lovelace", "ada@x.edu", "4001", "ada-l"),
    ("bjorn", "Björn", "Müller", "bm@x.edu", "4002", "bmu"),
    ("cy", "Cy", "O'Neil", "cy@x.edu", "", ""),
)


@pytest.fixture
def course(tmp_path):
    course = Course(tmp_path / "course")
    course.root.mkdir()
    with open(course.root / "roster.csv", "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(["id", "first_name", "last_name", "email", "lms_id", "github"])
        table.writerows(PEOPLE)
    return course


@pytest.fixture
def anonymous_course(course):
    (course.root / "roster.csv").unlink()
    return course


def archive(course, files, name="submissions.zip", **options):
    path = course.root / name
    path.write_bytes(make_zip(files, **options))
    return path


def collect(course, *paths, stages=(STAGE,), times=None, who=None, lessons=None, level=0):
    return module.collect(
        course, paths, stages, times, who or {}, lessons or {}, lambda *progress: None, level
    )


def states(outcome):
    return {
        student: {lesson.number: state for lesson, state in found.items()}
        for student, found in outcome.states.items()
    }


def placed_files(course, student, stage=STAGE):
    """Return the names and contents of the files in a student's folder that are not hidden."""
    folder = course.submitted / student / stage
    return {path.name: path.read_bytes() for path in folder.glob("[!.]*")}


def older_files(course, student, stage=STAGE):
    return sorted(
        path.read_bytes() for path in (course.submitted / student / stage / ".older").glob("*")
    )


def questions(outcome):
    return {question.name: question.text for question in outcome.questions}


def doubts(outcome):
    return {question.name: question.text for question in outcome.doubts}


# ---- Canvas -------------------------------------------------------------------------------------


def test_a_canvas_attempt_has_one_attachment_for_each_lesson(course):
    """Of several attachments for a lesson, the one with the highest ID counts."""
    files = canvas_files(
        "Lovelace, Ada",
        4001,
        [
            (901, f"{SIX}.ipynb", notebook(SIX, "first")),
            (907, f"{SIX}-1.ipynb", notebook(SIX, "second")),
            (905, f"{SIX}-2.ipynb", notebook(SIX, "third name, second number")),
            (902, f"{SEVEN}.ipynb", notebook(SEVEN)),
            (99, f"{EIGHT}.ipynb", notebook(EIGHT, "ninety-nine")),
            (100, f"{EIGHT}.ipynb", notebook(EIGHT, "a hundred")),
        ],
    )
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new", "07": "new", "08": "new"}}
    assert placed_files(course, "ada") == {
        f"{SIX}.ipynb": notebook(SIX, "second"),
        f"{SEVEN}.ipynb": notebook(SEVEN),
        f"{EIGHT}.ipynb": notebook(EIGHT, "a hundred"),
    }
    assert outcome.questions == []
    assert outcome.archives[0][1:] == ("Canvas", 6)


def test_late_work_from_canvas_has_no_time(course):
    files = [
        *canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook())], late=True),
        *canvas_files("Müller, Björn", 4002, [(2, f"{SIX}.ipynb", notebook())]),
    ]
    assert files[0][0] == f"lovelaceada_LATE_4001_1_{SIX}.ipynb"
    outcome = collect(course, archive(course, files))
    assert outcome.late_students == ["ada"]
    assert set(placed_files(course, "ada")) == {f"{SIX}.ipynb"}
    folders = [course.submitted / student / STAGE for student in ("ada", "bjorn")]
    with pytest.raises(SubmissionTimeUnknown, match="marks the work as late"):
        submission_time(folders[:1])
    assert submission_time(folders[1:]) is None
    (folders[0] / "timestamp.txt").write_text("2026-11-22 18:30:00 UTC")
    assert submission_time(folders[:1]) == datetime(2026, 11, 22, 18, 30, tzinfo=UTC)


def test_a_student_is_no_longer_late_if_the_next_archive_says_so(course):
    """The due date in Canvas may move between two downloads."""
    for late, modified in ((True, MONDAY), (False, TUESDAY)):
        files = canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook())], late)
        outcome = collect(course, archive(course, files, when=modified))
        assert outcome.late_students == ["ada"] * late


@pytest.mark.parametrize("form", ["NFC", "NFD"])
@pytest.mark.parametrize("flagged", [True, False], ids=["marked as UTF-8", "not marked"])
def test_students_are_found_by_their_canvas_names(course, form, flagged):
    """Canvas changes "O'Neil, Cy" to "oneilcy"; `cy` has no Canvas ID on the roster."""
    files = canvas_files("O'Neil, Cy", 4711, [(1, f"{SIX}.ipynb", notebook())])
    files += canvas_files("Müller, Björn", 4002, [(2, f"{SEVEN}.ipynb", notebook(SEVEN))])
    path = archive(course, [(unicodedata.normalize(form, name), data) for name, data in files])
    if not flagged:
        clear_utf8_flags(path)
    assert states(collect(course, path)) == {"cy": {"06": "new"}, "bjorn": {"07": "new"}}


def clear_utf8_flags(path):
    """Clear the flags in a zip that mark names as UTF-8, because Canvas does not set them."""
    data = bytearray(path.read_bytes())
    for signature, offset in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        position = data.find(signature)
        while position >= 0:
            flags = struct.unpack_from("<H", data, position + offset)[0]
            struct.pack_into("<H", data, position + offset, flags & ~0x800)
            position = data.find(signature, position + 4)
    path.write_bytes(data)


def test_typed_texts_and_links_in_canvas_become_questions(course):
    files = [
        (canvas_prefix("Lovelace, Ada", 4001) + "_text.html", b"<p>my code</p>"),
        (canvas_prefix("Müller, Björn", 4002, late=True) + "_link.html", b"<a>"),
        *canvas_files("O'Neil, Cy", 4003, [(1, f"{SIX}.ipynb", notebook())]),
    ]
    outcome = collect(course, archive(course, files))
    texts = questions(outcome)
    assert texts["lovelaceada_4001/lovelaceada_4001_text.html"].startswith("was typed")
    assert texts["müllerbjörn_4002/müllerbjörn_LATE_4002_link.html"].startswith("is a link")


def test_anonymous_work_from_canvas_is_collected_under_its_code(course, anonymous_course):
    files = canvas_files("", 1, [(5, f"{SIX}.ipynb", notebook())], late=True, anonymous="aB3x9")
    assert files[0][0] == f"LATE_anon_aB3x9_5_{SIX}.ipynb"
    path = archive(anonymous_course, files)
    outcome = collect(anonymous_course, path)
    assert states(outcome) == {"anon_aB3x9": {"06": "new"}}
    assert outcome.late_students == ["anon_aB3x9"]


def test_the_command_asks_for_the_members_of_a_canvas_group(course):
    files = canvas_files("Team Rot", 4001, [(1, f"{SIX}.ipynb", notebook())])
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome) == {"ada": {"06": "new"}}
    assert "--who teamrot_4001=ada,ID" in doubts(outcome)["teamrot_4001"]
    outcome = collect(course, path, who={"teamrot_4001": "ada,cy"})
    assert states(outcome) == {"ada": {"06": "same"}, "cy": {"06": "new"}}
    assert outcome.questions == outcome.doubts == []


def test_unusual_file_names_are_recognised(course, anonymous_course):
    """Canvas replaces each character that is not allowed in a file name with `_`."""
    name = f'a/b\\c:d*e?"f<g>h|{SIX} (1) Übung.ipynb'
    (made,) = canvas_files("Jr., Cy 2", 77, [(3, name, notebook())])
    assert made[0] == f"jrcy2_77_3_a_b_c_d_e_f_g_h_{SIX} (1) Übung.ipynb"
    outcome = collect(anonymous_course, archive(anonymous_course, [made]))
    assert states(outcome) == {"jrcy2_77": {"06": "new"}}
    assert set(placed_files(anonymous_course, "jrcy2_77")) == {f"{SIX}.ipynb"}


# ---- Moodle -------------------------------------------------------------------------------------


@pytest.mark.parametrize("old", [False, True], ids=["", "before 2022"])
@pytest.mark.parametrize("folders", [True, False], ids=["folders", "flat"])
def test_students_are_found_by_their_moodle_names(course, folders, old):
    files = [
        *moodle_files(
            "Ada Lovelace",
            5001,
            [(f"{SIX}.ipynb", notebook()), (f"{SEVEN}.ipynb", notebook(SEVEN))],
            folders,
            old=old,
        ),
        *moodle_files(
            "Björn Müller", 5002, [(f"{EIGHT}.ipynb", notebook(EIGHT))], folders, old=old
        ),
    ]
    outcome = collect(course, archive(course, files))
    assert outcome.archives[0][1] == "Moodle"
    assert states(outcome) == {"ada": {"06": "new", "07": "new"}, "bjorn": {"08": "new"}}
    record = read_record(course.submitted / "ada" / STAGE)
    assert record.files[f"{SIX}.ipynb"].participant == "5001"


@pytest.mark.parametrize("old", [False, True], ids=["", "before 2022"])
def test_notebooks_in_folders_from_moodle_are_collected(course, old):
    files = moodle_files("Ada Lovelace", 5001, [(f"my work/deep/{SIX}.ipynb", notebook())], old=old)
    assert states(collect(course, archive(course, files))) == {"ada": {"06": "new"}}


@pytest.mark.parametrize("folders", [True, False], ids=["folders", "flat"])
def test_older_versions_of_moodle_put_the_team_before_the_name(course, folders):
    write_roster(course, "ada,Ada,Lovelace,,,", "jl,Jean-Luc,Picard,,,", "luc,Luc,Picard,,,")
    mine = [(f"{SIX}.ipynb", notebook())]
    files = [
        *moodle_files("Ada Lovelace", 5001, mine, folders, old=True, team="Team-Rot"),
        *moodle_files("Jean-Luc Picard", 5002, mine, folders, old=True, team="Default group"),
    ]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}}
    label = "Default group-Jean-Luc Picard_5002"
    assert "may be jl or luc" in questions(outcome)[label], "the hyphen may belong to the team"


def test_a_hyphen_in_a_name_from_moodle_is_not_a_team(course):
    """Luc Picard is not Jean-Luc Picard, who is missing from the roster."""
    write_roster(course, "ada,Ada,Lovelace,,,", "luc,Luc,Picard,,,")
    files = [
        *moodle_files("Ada Lovelace", 5001, [(f"{SIX}.ipynb", notebook())], old=True),
        *moodle_files("Jean-Luc Picard", 5002, [(f"{SIX}.ipynb", notebook())], old=True),
    ]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}}
    assert set(questions(outcome)) == {"Jean-Luc Picard_5002"}


def test_files_that_a_teacher_added_are_assigned_by_their_folders(course):
    """A teacher may add files to the unzipped download before zipping it again."""
    files = [
        *moodle_files("Ada Lovelace", 5001, [(f"{SIX}.ipynb", notebook())], old=True),
        (f"bjorn/{SIX}.ipynb", notebook(text="bjorn")),
        (f"from the mail/{SIX}.ipynb", notebook(text="mail")),
        ("notes.txt", b"two came by mail"),
    ]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    assert [one[1:] for one in outcome.archives] == [
        ("Moodle", 1),
        ("not named as in Moodle", 2),
    ]
    assert set(questions(outcome)) == {"from the mail"}
    assert set(outcome.ignored) == {"notes.txt"}


@pytest.mark.parametrize(
    "forged",
    [
        "Cy O'Neil_5003_assignsubmission_file/{}",
        "O'Neil, Cy(cy)/Submission attachment(s)/{}",
        "12-34 - Cy O'Neil - 12 October, 2026 1110 PM/{}",
        "Lab_cy_attempt_2026-10-12-23-10-00_{}",
        "ONeil_Cy_cy_4711/{}",
        "cy@x.edu_1_lab_1_1_{}",
        "oneilcy_4711_12345_{}",
    ],
)
def test_a_student_cannot_submit_in_another_students_name(course, tmp_path, forged):
    """Ada submits files whose names claim, in the style of some platform, to be Cy's."""
    names = [forged.format(f"{SIX} ({number}).ipynb") for number in range(9)]
    files = [(f"ada/{name}", notebook(text="by ada")) for name in names]
    files += [(f"bjorn/{SIX}.ipynb", notebook(text="bjorn"))]
    assert "cy" not in states(collect(course, archive(course, files)))
    for login in ("ada-l", "bmu"):
        mine = {name.split("/", 1)[1]: data for name, data in files if name.startswith(login[0])}
        write_checkout(tmp_path / "hw", f"hw-3-{login}", mine)
    outcome = collect(course, tmp_path / "hw")
    assert outcome.archives[0][1] == "GitHub Classroom" and "cy" not in states(outcome)


@pytest.mark.parametrize("folders", [True, False], ids=["folders", "flat"])
def test_typed_texts_in_moodle_become_questions(course, folders):
    files = moodle_files(
        "Ada Lovelace", 5001, [("onlinetext.html", b"<p>")], folders, plugin="onlinetext"
    )
    path = archive(course, files)
    ((name, text),) = questions(collect(course, path)).items()
    assert text.startswith("was typed into Moodle")
    for who in ({name: "-"}, {}):
        outcome = collect(course, path, who=who)
        assert outcome.questions == [] and set(outcome.ignored) == {"onlinetext.html"}


TIMES = {
    "en": ("Wednesday, 14 October 2026, 2:14 PM", "Tuesday, October 13, 2026, 12:05 AM"),
    "de": ("Mittwoch, 14. Oktober 2026, 14:14", "Dienstag, 13. Oktober 2026, 00:05"),
}


@pytest.mark.parametrize("language", TIMES)
def test_names_and_times_are_read_from_moodles_worksheet(course, language):
    """The titles and dates of a worksheet are in the teacher's language."""
    (course.root / "deadlines.toml").write_text('timezone = "UTC"\n')
    files = [
        *moodle_files("A. L.", 5001, [(f"{SIX}.ipynb", notebook())]),
        *moodle_files("B. M.", 5002, [(f"{SIX}.ipynb", notebook())]),
    ]
    table = course.root / "worksheet.csv"
    late, early = TIMES[language]
    table.write_text(
        worksheet(
            [(5001, "A. L.", "4711", "ADA@x.edu", late), (5002, "B. M.", "bjorn", "", early)],
            language,
        ),
        "utf-8",
    )
    path = archive(course, files)
    assert set(questions(collect(course, path))) == {"A. L._5001", "B. M._5002"}
    outcome = collect(course, path, times=table)
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    stamps = {
        student: placed_files(course, student)["timestamp.txt"].decode().strip()
        for student in ("ada", "bjorn")
    }
    assert stamps == {"ada": "2026-10-14 14:14:00 UTC", "bjorn": "2026-10-13 00:05:00 UTC"}


@pytest.mark.parametrize(
    "written_time", ["-", "", "10/11/2026 14:14", "yesterday", "14 Oktobre 2026, 3"]
)
def test_an_unreadable_time_leaves_lateness_undecided(course, written_time):
    files = moodle_files("Ada Lovelace", 5001, [(f"{SIX}.ipynb", notebook())])
    table = course.root / "worksheet.csv"
    table.write_text(worksheet([(5001, "Ada Lovelace", "", "ada@x.edu", written_time)]), "utf-8")
    outcome = collect(course, archive(course, files), times=table)
    assert ("no time" if written_time in ("", "-") else repr(written_time)) in outcome.undecided[
        "ada"
    ]
    assert "timestamp.txt" not in placed_files(course, "ada")
    assert unknown_time_reason(course.submitted / "ada" / STAGE) == outcome.undecided["ada"]


def test_times_are_read_from_a_table_by_id(course):
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,2026-10-14 14:14:00 UTC\n")
    files = canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook())], late=True)
    outcome = collect(course, archive(course, files), times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-14 14:14:00 UTC\n"
    assert not outcome.late_students and not outcome.undecided


def test_a_table_of_late_students_is_enough_if_the_platform_marks_late_work(course):
    """Files that Canvas does not mark as late are on time; plain folders have no such marks."""
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,2026-10-14 14:14:00 UTC\n")
    files = [
        *canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook())], late=True),
        *canvas_files("Müller, Björn", 4002, [(2, f"{SIX}.ipynb", notebook())]),
        *canvas_files("O'Neil, Cy", 4003, [(3, f"{SIX}.ipynb", notebook())], late=True),
    ]
    outcome = collect(course, archive(course, files), times=table)
    assert set(outcome.undecided) == {"cy"}
    assert unknown_time_reason(course.submitted / "bjorn" / STAGE) == ""
    files = [(f"{name}/{SEVEN}.ipynb", notebook(SEVEN)) for name in ("ada", "bjorn")]
    outcome = collect(course, archive(course, files, "folders.zip"), times=table)
    assert set(outcome.undecided) == {"bjorn"}


def test_the_error_about_a_table_without_times_lists_its_columns(course):
    table = course.root / "times.csv"
    table.write_text("id,Abgabezeit\nada,2026-10-14 14:14\n")
    with pytest.raises(CollectError, match="The columns are: id, Abgabezeit"):
        collect(course, course.root, times=table)


def test_members_of_moodle_teams_come_from_an_option_or_the_worksheet(course):
    """The members of a team come from an option or from a column of the worksheet.

    The folder of the default group has no number.
    """
    path = archive(
        course,
        [
            *moodle_files("Team_Rot", 77, [(f"{SIX}.ipynb", notebook())]),
            *moodle_files("Default group", "", [(f"{SEVEN}.ipynb", notebook(SEVEN))]),
        ],
    )
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"Team Rot_77", "Default group"}
    outcome = collect(course, path, who={"Team Rot_77": "ada,cy", "Default group": "bjorn"})
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"06": "new"}, "bjorn": {"07": "new"}}
    table = course.root / "worksheet.csv"
    titles = "Identifier,Full name,Email address,Status,Group,Grade,Last modified (submission)"
    rows = (f"Participant {n},{n},{m}@x.edu,x,Team_Rot,,-" for n, m in ((1, "ada"), (2, "cy")))
    table.write_text("\n".join((titles, *rows)))
    outcome = collect(course, path, times=table)
    assert states(outcome) == {"ada": {"06": "same"}, "cy": {"06": "same"}, "bjorn": {"07": "same"}}


@pytest.mark.parametrize(
    ("rows", "times"),
    [
        ("ada,2026-10-14 14:14 UTC", ["14:14"] * 2),
        ("cy,2026-10-14 15:15 UTC", ["15:15"] * 2),
        ("ada,2026-10-14 14:14 UTC\ncy,2026-10-14 15:15 UTC", ["14:14"] * 2),
        ("ada,2026-10-14 14:14 UTC\ncy,-", ["14:14"] * 2),
    ],
)
def test_a_file_of_a_team_has_one_submission_time(course, rows, times):
    """It is the time of the member named in the archive, or else of any other member."""
    table = course.root / "times.csv"
    table.write_text(f"id,Last modified (submission)\n{rows}\n")
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    outcome = collect(course, path, who={"ada": "cy,ada"}, times=table)
    written = [placed_files(course, id)["timestamp.txt"].decode()[11:16] for id in ("ada", "cy")]
    assert (written, outcome.undecided, outcome.students_with_time) == (times, {}, ["ada", "cy"])


# ---- other platforms ----------------------------------------------------------------------------

OLD, NEW = notebook(text="old"), notebook(text="new")
OTHER_PLATFORMS = {
    "Blackboard": [
        *blackboard_files("bjorn", "2026-10-12-23-59-00", [(f"{SIX}.ipynb", OLD)]),
        *blackboard_files("ada", "2026-10-12-23-10-00", [(f"{SIX}.ipynb", NEW)]),
        *blackboard_files("bjorn", "2026-10-13-09-00-00", [(f"{SIX}.ipynb", NEW)]),
    ],
    "Brightspace": [
        ("index.html", b"<html>"),
        *brightspace_files(
            "Björn Müller", 12346, "12 October, 2026 1159 PM", [(f"{SIX}.ipynb", OLD)]
        ),
        *brightspace_files(
            "Ada Lovelace", 12345, "12 October, 2026 1110 PM", [(f"{SIX}.ipynb", NEW)]
        ),
        *brightspace_files("Björn Müller", 12346, "Oct 13, 2026 900 AM", [(f"{SIX}.ipynb", NEW)]),
    ],
    "Gradescope": gradescope_files(
        [
            (
                101,
                [("Ada Lovelace", "'0012345'", "ada@x.edu")],
                "2026-10-12 21:10:00.000000000 Z",
                [(f"work/{SIX}.ipynb", NEW)],
            ),
            (
                102,
                [("Björn Müller", "", "bm@x.edu")],
                "2026-10-12 21:59:00.0 Z",
                [(f"{SIX}.ipynb", NEW)],
            ),
        ]
    ),
    "ILIAS": [
        *ilias_files(
            "Lovelace", "Ada", "ada", 4711, [(f"{SIX}.ipynb", NEW)], "Uebung_zu_Robotik_3"
        ),
        *ilias_files(
            "Mueller", "Bjoern", "bjorn", 4712, [(f"{SIX}.ipynb", NEW)], "Uebung_zu_Robotik_3"
        ),
    ],
    "PrairieLearn": [
        *prairielearn_files("ada@x.edu", 1, [(f"{SIX}.ipynb", NEW)]),
        *prairielearn_files("bm@x.edu", 1, [(f"{SIX}.ipynb", NEW)]),
    ],
    "Sakai": [
        ("Lab (week 3)/grades.csv", b"Lab,Points"),
        *sakai_files("Lovelace, Ada", "al", [(f"{SIX}.ipynb", NEW)]),
        *sakai_files("Müller, Björn", "bjorn", [(f"{SIX}.ipynb", NEW)]),
    ],
}


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_other_platforms_are_recognised(course, platform):
    """The newest attempt counts. Files that the platform adds are not asked about."""
    outcome = collect(course, archive(course, OTHER_PLATFORMS[platform]))
    assert {archive[1] for archive in outcome.archives} == {platform}
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    assert outcome.questions == []
    for student in ("ada", "bjorn"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": NEW}


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_other_platforms_are_recognised_without_a_roster(anonymous_course, platform):
    outcome = collect(anonymous_course, archive(anonymous_course, OTHER_PLATFORMS[platform]))
    assert len(outcome.states) == 2 and outcome.questions == []


@pytest.mark.parametrize("platform", OTHER_PLATFORMS)
def test_downloads_of_a_single_student_are_recognised(course, platform):
    files = [
        (name, data)
        for name, data in OTHER_PLATFORMS[platform]
        if not any(word in name for word in ("bj", "Bj", "Mueller", "bm@", "submission_102"))
    ]
    outcome = collect(course, archive(course, files))
    assert outcome.archives[0][1] == platform
    if platform in ("Blackboard", "ILIAS"):  # the length of the assignment's title is unknown
        assert states(outcome) == {} and len(outcome.questions) == 1
    else:
        assert states(outcome) == {"ada": {"06": "new"}}


@pytest.mark.parametrize("folders", [True, False], ids=["folders", "flat"])
def test_downloads_without_folders_are_recognised(course, folders):
    mine = [(f"{SIX}.ipynb", notebook())]
    path = archive(course, sakai_files("Lovelace, Ada", "ada", mine, folders=folders))
    assert states(collect(course, path)) == {"ada": {"06": "new"}}
    files = brightspace_files("23 Müller", 1, "05 March 2026 612 PM", mine, folders)
    write_roster(course, "23,Björn,Müller,,,", "ada,Ada,Lovelace,,,")
    assert states(collect(course, archive(course, files))) == {"23": {"06": "new"}}


@pytest.mark.parametrize(
    ("label", "attempt", "time"),
    [
        ("LiDAR 20Lab_eve", partial(blackboard_files, "eve"), "2026-10-1{}-09-00-00"),
        ("Eve Evil_77", partial(brightspace_files, "Eve Evil", 77), "1{} October, 2026 900 AM"),
    ],
    ids=["Blackboard", "Brightspace"],
)
def test_an_answer_about_an_attempt_applies_to_the_next_attempt(course, label, attempt, time):
    """The time of the attempt is not a part of the owner's name."""
    for day, who in ((2, {label: "cy"}), (3, {})):
        content = notebook(text=f"day {day}")
        path = archive(course, attempt(time.format(day), [(f"{SIX}.ipynb", content)]))
        outcome = collect(course, path, who=who)
        assert outcome.questions == [] and placed_files(course, "cy") == {f"{SIX}.ipynb": content}


def test_all_members_of_a_team_in_gradescope_are_collected(course):
    team = [("Ada Lovelace", "", "ada@x.edu"), ("Cy ONeil", "", "cy@x.edu")]
    stranger = [("Björn Müller", "", ""), ("Eve Evil", "", "eve@x.edu")]
    time, mine = "2026-10-12 21:10:00 Z", [(f"{SIX}.ipynb", notebook())]
    outcome = collect(
        course,
        archive(course, gradescope_files([(1, team, time, mine), (2, stranger, time, mine)])),
    )
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"06": "new"}}
    assert "write several ids" in questions(outcome)["Björn Müller+eve@x.edu"]
    assert teams_in(course, STAGE) == [frozenset({"ada", "cy"})], "the archive declares the team"
    assert teams_in(course, "stage2_clustering") == []


def test_a_damaged_list_of_submitters_is_refused(course):
    files = gradescope_files([(1, [("Ada", "", "")], "", [(f"{SIX}.ipynb", notebook())])])
    files[-1] = (files[-1][0], b"submission_1: [\n")
    with pytest.raises(CollectError, match="does not list the submitters"):
        collect(course, archive(course, files))


def test_a_student_cannot_name_the_submitters(course):
    files = gradescope_files(
        [(1, [("Cy", "", "cy@x.edu")], "", [(f"{SIX}.ipynb", notebook())])], root="ada/"
    )
    files += [(f"bjorn/{SIX}.ipynb", notebook(text="bjorn"))]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}


def test_a_team_in_ilias_is_asked_about(course):
    files = [
        *ilias_files("Lovelace", "Ada", "ada", 4711, [(f"{SIX}.ipynb", notebook())], team="7"),
        *ilias_files("Mueller", "B", "bjorn", 4712, [(f"{SIX}.ipynb", notebook())], team="8"),
    ]
    path = archive(course, files)
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"Team 7", "Team 8"}
    assert "may be ada" in questions(outcome)["Team 7"]
    outcome = collect(course, path, who={"Team 7": "ada,cy", "Team 8": "bjorn"})
    assert set(states(outcome)) == {"ada", "cy", "bjorn"}


def test_ids_may_look_like_folders_from_ilias(course):
    write_roster(course, "lab_ws_ada_1,Ada,Lovelace,,,", "lab_ws_bo_2,Bo,Bäcker,,,", "ada,A,B,,,")
    files = [(f"lab_ws_{name}/{SIX}.ipynb", notebook(text=name)) for name in ("bo_2", "bo_3")]
    outcome = collect(course, archive(course, files))
    assert set(states(outcome)) == {"lab_ws_bo_2"} and len(outcome.questions) == 1


def test_keys_that_contradict_each_other_become_a_question(course):
    """The login is Ada's ID, but the name is Björn's."""
    files = sakai_files("Müller, Björn", "ada", [(f"{SIX}.ipynb", notebook())])
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {} and "may be ada or bjorn" in questions(outcome)["ada"]


@pytest.fixture(params=["roster", "no roster"])
def course_with_strangers(request, course):
    """Return a course whose roster, if there is one, has no name from the archives."""
    if request.param == "no roster":
        (course.root / "roster.csv").unlink()
    return course


GROUPS = (("A", "x1"), ("A", "x2"), ("B", "x3"))


@pytest.mark.parametrize("layout", ["{}_{}.ipynb", "{1} {0}.ipynb", "{}.zip"])
def test_files_of_several_students_are_never_attributed_to_one(course_with_strangers, layout):
    """The platform is unknown, and its folders are not named after students."""
    course = course_with_strangers
    files = [
        (f"export/group {group}/" + layout.format(person, SIX), notebook(text=person))
        for group, person in GROUPS
    ]
    outcome = collect(course, archive(course, files))
    assert "A" not in "".join(states(outcome))
    text = questions(outcome)["group A"]
    assert "a folder named after the student" in text
    assert ("--who" in text) == (outcome.roster is None)


@pytest.mark.parametrize(
    ("layout", "levels"), [("{}/{}.ipynb", (2, 3)), ("a/{}/more/{}.ipynb", (2, 4))]
)
def test_a_question_is_asked_if_two_levels_of_folders_may_be_named_after_students(
    course_with_strangers, layout, levels
):
    course = course_with_strangers
    path = archive(
        course,
        [
            (f"export/group {group}/" + layout.format(person, SIX), notebook(text=person))
            for group, person in GROUPS
        ],
    )
    outcome = collect(course, path)
    assert questions(outcome) == {
        "submissions.zip": f"Add --folder-level {levels[0]} if the folders group A, group B are "
        f"named after students, or --folder-level {levels[1]} if the folders x1, x2, x3 are"
    }
    assert states(outcome) == {}
    for level, names in zip(levels, ({"group A", "group B"}, {"x1", "x2", "x3"}), strict=True):
        outcome = collect(course, path, level=level)
        assert names == (set(questions(outcome)) if outcome.roster else set(states(outcome)))


LESSONS = {"6": SIX, "7": SEVEN, "8": EIGHT, "10": "10_process_pointclouds"}


def archive_of(course, paths):
    """Return an archive of notebooks; a path such as ``ada/6`` ends with the lesson's number."""
    files = []
    for path in paths:
        folder, _, number = path.rpartition("/")
        if number in LESSONS:
            name = LESSONS[number]
            files.append((f"{folder}/{name}.ipynb", notebook(name, path)))
        else:
            files.append((path, b"x"))
    return archive(course, files)


@pytest.mark.parametrize(
    "paths",
    [
        ("a/x1/6", "a/x2/7", "b/x3/8"),
        ("a/x1/6", "a/x2/more/7", "b/x3/8"),
        ("a/x1/6", "a/x2/6", "b/x3/8"),
        ("hw6/x1/6", "hw6/x2/6", "hw7/x1/7", "hw7/x2/7"),
        ("A/anna/6", "A/bo/6", "A/cy/6", "B/anna/6"),
        ("try/x1/6", "try/x2/6", "new/x1/6", "new/x2/6"),
        ("try/x1/6", "try/x2/6", "try/x3/6", "new/x1/6", "new/x2/6"),
        ("week1/x1/work.ipynb", "week1/x2/work.ipynb", "week2/x1/work.ipynb"),
    ],
)
def test_different_lessons_of_several_students_are_never_attributed_to_one(
    course_with_strangers, paths
):
    path = archive_of(course_with_strangers, paths)
    outcome = collect(course_with_strangers, path)
    assert states(outcome) == {} and "--folder-level 2 if" in questions(outcome)["submissions.zip"]


@pytest.mark.parametrize("names", [("x1 {}", "x2 {}"), ("{}_x1", "{}_x2"), ("x1", "x2")])
@pytest.mark.parametrize("lessons", [(SIX, SEVEN), (SIX, SIX)])
def test_files_without_folders_are_not_attributed_to_one_student(
    course_with_strangers, names, lessons
):
    """Different words in the names, or a repeated lesson, may mean several students."""
    files = [
        (f"{name.format(lesson[:2])}.ipynb", notebook(lesson, text=name))
        for name, lesson in zip(names, lessons, strict=True)
    ]
    outcome = collect(course_with_strangers, archive(course_with_strangers, files))
    text = questions(outcome)["submissions"]
    assert states(outcome) == {} and "a folder named after the student" in text
    assert ("--who" in text) == (outcome.roster is None)


@pytest.mark.parametrize("names", [("{}", "{} (1)"), ("Copy of {}", "{}-Copy2"), ("Untitled", "8")])
def test_files_of_one_student_need_no_folder(anonymous_course, names):
    """Words that a program or one student adds to the names do not name several students."""
    files = [
        (f"{name.format(lesson)}.ipynb", notebook(lesson))
        for name, lesson in zip(names, (SIX, EIGHT), strict=True)
    ]
    outcome = collect(anonymous_course, archive(anonymous_course, files))
    assert states(outcome) == {"submissions": {"06": "new", "08": "new"}}


@pytest.mark.parametrize(
    "paths",
    [
        ("ada/hw6/6", "ada/hw7/7", "bo/hw6/6", "bo/hw7/7"),
        ("ada/try/6", "ada/new/6", "bo/try/6", "bo/new/6", "cy/try/6"),
        ("ada/stage3_obstacles/6", "ada/stage4_realtime/10", "bo/stage3_obstacles/7"),
        ("ada/6", "ada/old/6", "bo/hw/7"),
        ("lab/ada/notebooks/stage3_obstacles/6", "lab/ada/data/a.txt", "lab/bo/7", "lab/index.csv"),
        ("ada/6", "bo/photo.png"),
    ],
)
def test_folders_inside_a_students_folder_need_no_question(anonymous_course, paths):
    """Such folders belong to the course, an attempt or a lesson, or recur for other students."""
    path = archive_of(anonymous_course, paths)
    outcome = collect(anonymous_course, path, stages=(STAGE, "stage4_realtime"))
    assert set(states(outcome)) == {"ada", "bo", "cy"} & set("/".join(paths).split("/"))
    assert not re.search("several|--who|--folder", " ".join(questions(outcome).values()))


def test_an_option_confirms_one_students_folders_if_there_is_no_roster(anonymous_course):
    path = archive_of(anonymous_course, ("ada/6", "bo/mine/6", "bo/more/7"))
    outcome = collect(anonymous_course, path)
    assert states(outcome) == {"ada": {"06": "new"}}
    assert "If one student submitted all of them, add --who bo=bo" in questions(outcome)["bo"]
    outcome = collect(anonymous_course, path, who={"bo": "bo"})
    assert states(outcome)["bo"] == {"06": "new", "07": "new"} and outcome.questions == []


@pytest.mark.parametrize(
    ("ids", "found"),
    [
        (("x1", "x2", "x3"), {"x1", "x2", "x3"}),
        (("x1", "x3"), {"x1", "x3"}),
        (("x3",), set()),
        (("b", "x1", "x2", "x3"), {"b"}),
    ],
)
def test_the_roster_decides_which_folders_belong_to_students(course, ids, found):
    """A student may name a folder after another student, so one known name is not enough."""
    write_roster(course, *(f"{id},,,,," for id in ids))
    outcome = collect(course, archive_of(course, ("a/x1/6", "a/x2/7", "b/x3/8")))
    assert set(states(outcome)) == found and bool(outcome.questions) == (len(found) < 3)


def test_the_roster_decides_even_if_the_students_folders_recur(course):
    """Without the roster, the folders ada and cy look like folders of lessons."""
    paths = ("week1/ada/6", "week1/cy/7", "week2/ada/6", "week2/cy/7")
    assert set(states(collect(course, archive_of(course, paths)))) == {"ada", "cy"}


@pytest.mark.parametrize(
    "paths",
    [
        ("stage3_obstacles/x1/6", "stage3_obstacles/x2/7", "export/marks.csv"),
        ("stage3_obstacles/x1/6", "stage4_realtime/x1/10", "stage3_obstacles/x2/7"),
        ("lab/notebooks/stage3_obstacles/x1/6", "lab/stage3_obstacles/x2/7", "lab/marks.csv"),
    ],
)
def test_students_folders_are_found_inside_folders_of_the_course(course_with_strangers, paths):
    path = archive_of(course_with_strangers, paths)
    outcome = collect(course_with_strangers, path, stages=(STAGE, "stage4_realtime"))
    texts = questions(outcome)
    assert (set(texts) if outcome.roster else set(states(outcome))) == {"x1", "x2"}
    assert "several students" not in "".join(texts.values())


def test_folders_above_the_students_are_not_part_of_file_names(course):
    """An answer about a file also applies to the next archive, whose folder has another name."""
    for folder in ("monday", "tuesday"):
        paths = (f"{folder}/ada/6", f"{folder}/ada/more/essay.pdf", f"{folder}/bjorn/7")
        assert "ada/more/essay.pdf" in questions(collect(course, archive_of(course, paths)))


def test_no_owner_is_suggested_for_a_folder_with_a_repeated_lesson(course):
    files = [
        (f"a/{SIX}.ipynb", notebook()),
        (f"a/{SIX} (1).ipynb", notebook(text="other")),
        (f"b/x3/{EIGHT}.ipynb", notebook(EIGHT)),
    ]
    texts = questions(collect(course, archive(course, files)))
    assert "--who" not in texts["a"] and "a folder named after the student" in texts["a"]
    assert "--who b=ID" in texts["b"], "one folder may be one student's"


@pytest.mark.parametrize("inside", ["{}.ipynb", "{0}/{0}.ipynb", "old/{}.ipynb"])
def test_one_owner_is_suggested_for_one_students_folders(course, inside):
    files = [
        (f"eve/{SIX}.ipynb", notebook()),
        ("eve/" + inside.format(SEVEN), notebook(SEVEN)),
        (f"ada/{SIX}.ipynb", notebook(text="ada")),
    ]
    assert "--who eve=ID" in questions(collect(course, archive(course, files)))["eve"]


@pytest.mark.parametrize("wrapper", ["export", STAGE, f"export/{STAGE}"])
@pytest.mark.parametrize("loose", ["", "readme.txt", "{}/marks.csv"])
def test_students_folders_are_found_below_other_folders(anonymous_course, wrapper, loose):
    """Neither the name of the folder above nor a file next to the folders prevents this."""
    files = [
        (f"{wrapper}/x1/{SIX}.ipynb", notebook()),
        (f"{wrapper}/x2/{SEVEN}.ipynb", notebook(SEVEN)),
        *([(loose.format(wrapper), b"x")] if loose else []),
    ]
    outcome = collect(anonymous_course, archive(anonymous_course, files))
    assert states(outcome) == {"x1": {"06": "new"}, "x2": {"07": "new"}}


# ---- GitHub Classroom, folders ------------------------------------------------------------------


def write_checkout(root, name, files):
    for path, data in {".git/HEAD": b"ref", **files}.items():
        (root / name / path).parent.mkdir(parents=True, exist_ok=True)
        (root / name / path).write_bytes(data)


def test_github_checkouts_are_found_by_login(course, tmp_path):
    root = tmp_path / "stage-3-submissions"
    mine = {f"notebooks/{STAGE}/{SIX}.ipynb": notebook(), "README.md": b"hello"}
    given = {f"notebooks/{STAGE}/{SEVEN}.ipynb": released_notebook(SEVEN)}
    write_checkout(
        root, "stage-3-ada-l", mine | given | {".git/objects/06_filter_ground.ipynb": b"x"}
    )
    write_checkout(root, "stage-3-someone", mine)
    outcome = collect(course, root)
    assert outcome.archives[0][1] == "GitHub Classroom"
    assert states(outcome) == {"ada": {"06": "new"}}, "an untouched notebook is not a submission"
    assert "into column github" in questions(outcome)["stage-3-someone"]
    (root / "classroom_roster.csv").write_text(
        '"identifier","github_username","github_id","name"\n"cy@x.edu","Someone","1",""\n'
    )
    assert states(collect(course, root))["cy"] == {"06": "new"}


CLASSROOM_ROSTER = (
    '"identifier","github_username","github_id","name"\n'
    '"cy@x.edu","Someone","1","Müller, Cy"\n"Dee, Dora","","",""\n'
)


@pytest.mark.parametrize(
    "text",
    [
        CLASSROOM_ROSTER.encode(),
        CLASSROOM_ROSTER.replace("\n", "\r").encode(),
        CLASSROOM_ROSTER.replace(",", ";").replace("\n", "\r\n").encode("utf-8-sig"),
        CLASSROOM_ROSTER.replace(",", "\t").encode("utf-16"),
    ],
    ids=["as downloaded", "old line ends", "semicolons", "tabs and UTF-16"],
)
@pytest.mark.parametrize("place", ["hw", "."], ids=["among the checkouts", "next to them"])
def test_the_roster_of_github_classroom_is_read_in_any_form(course, tmp_path, text, place):
    for login in ("ada-l", "someone"):
        write_checkout(tmp_path / "hw", f"hw-3-{login}", {f"{SIX}.ipynb": notebook(text=login)})
    (tmp_path / place / "classroom_roster.csv").write_bytes(text)
    outcome = collect(course, tmp_path / "hw")
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"06": "new"}}
    assert outcome.questions == [] and outcome.ignored == {}  # the roster was needed


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("identifier,github_username\nMüller,x\n".encode("cp1252"), "it is not in UTF-8"),
        (b"name,login\ncy,someone\n", "must have the columns github_username and identifier"),
    ],
)
def test_an_unreadable_roster_of_github_classroom_is_refused(course, tmp_path, text, message):
    write_checkout(tmp_path / "hw", "hw-3-someone", {f"{SIX}.ipynb": notebook()})
    (tmp_path / "hw" / "classroom_roster.csv").write_bytes(text)
    with pytest.raises(CollectError, match=message):
        collect(course, tmp_path / "hw")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_table_of_times_is_read_in_any_form(course, encoding):
    (course.root / "deadlines.toml").write_text('timezone = "UTC"\n')
    table = course.root / "times.csv"
    text = "id\tLast modified (submission)\rada\t2026-10-14 14:14\r"
    table.write_bytes(text.encode(encoding))
    collect(course, archive(course, [(f"ada/{SIX}.ipynb", notebook())]), times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-14 14:14:00 UTC\n"


def test_a_partly_unreadable_released_notebook_is_collected(course, tmp_path):
    """A merge conflict, or a missing end, may hide the student's work."""
    lines = json.dumps(json.loads(released_notebook()), indent=1).split("\n")
    place = next(n for n, line in enumerate(lines) if '"execution_count"' in line)
    conflict = ["<<<<<<< HEAD", lines[place], "=======", lines[place], ">>>>>>> main"]
    lines[place : place + 1] = conflict
    files = {
        SIX: "\n".join(lines).encode(),
        SEVEN: released_notebook(SEVEN)[:-20],
        EIGHT: released_notebook(EIGHT),
    }
    given = {f"{name}.ipynb": data for name, data in files.items()}
    write_checkout(tmp_path / "hw", "hw-3-ada-l", given)
    write_checkout(tmp_path / "hw", "hw-3-bmu", {f"{SIX}.ipynb": notebook()})
    outcome = collect(course, tmp_path / "hw")
    assert states(outcome) == {"ada": {"06": "new", "07": "new"}, "bjorn": {"06": "new"}}
    conflict, cut_off = (remark.text for remark in outcome.remarks if "damaged" in remark.text)
    assert "A merge conflict was left in" in conflict and "Only these cells were" in cut_off


@pytest.mark.parametrize(
    "layout",
    [
        "{}/06_filter_ground.ipynb",
        "{}/stage3_obstacles/06_filter_ground.ipynb",
        "class/{}/notebooks/stage3_obstacles/06_filter_ground.ipynb",
        "{}_06_filter_ground.ipynb",
        "06_filter_ground_{}.ipynb",
        "{}/Copy of 06_Filter_Ground (2).IPYNB",
        "{}/8.ipynb",
        "{}/06_filter_ground.ipynb.txt",
        "{}/06_filter_ground.json",
    ],
)
def test_one_folder_for_each_student_is_collected(course, layout):
    files = [(layout.format(name), notebook()) for name in ("Ada ", "BJORN")]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    assert set(placed_files(course, "ada")) == {f"{SIX}.ipynb"}


def test_a_folder_of_zips_and_a_single_file_are_collected(course, tmp_path):
    folder = tmp_path / "downloads"
    folder.mkdir()
    (folder / "ada.zip").write_bytes(make_zip([(f"{SIX}.ipynb", notebook())]))
    (folder / "bjorn.zip").write_bytes(make_zip([(f"w/{SIX}.ipynb", notebook(text="b"))]))
    assert states(collect(course, folder)) == {"ada": {"06": "new"}, "bjorn": {"06": "new"}}
    single = tmp_path / "8.ipynb"
    single.write_bytes(notebook(EIGHT))
    assert "--who 8=ID" in questions(collect(course, single))["8"]
    assert states(collect(course, single, who={"8": "cy"})) == {"cy": {"08": "new"}}


def test_folders_have_the_names_in_the_archive_if_there_is_no_roster(anonymous_course):
    path = archive(
        anonymous_course,
        [(f"{name}/{SIX}.ipynb", notebook()) for name in ("mary jane", "aux", "Ærø: Ö")],
    )
    outcome = collect(anonymous_course, path)
    assert set(outcome.states) == {"mary jane", "aux_", "Ærø- Ö"}
    assert outcome.roster is None and outcome.questions == []


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("", "unnamed"),
        ("..", "unnamed"),
        ("CON", "CON_"),
        ("nul.txt", "nul.txt_"),
        ("a/b", "a-b"),
        ("a\0b", "a-b"),
        ("C:x", "C-x"),
        (" yan ", "yan"),
        ("dot.", "dot"),
        ("__x", "x"),
        ("o\u0308", "ö"),
        ("x" * 300, "x" * 80),
    ],
)
def test_folder_names_are_safe_on_every_system(name, folder):
    assert safe_folder(name) == folder


# ---- the lesson of a file -----------------------------------------------------------------------


def test_the_lesson_follows_from_the_content_if_the_file_name_contains_no_lesson(course):
    files = [("ada/8.ipynb", notebook(EIGHT)), ("ada/x/final.ipynb", notebook(NINE))]
    assert states(collect(course, archive(course, files))) == {"ada": {"08": "new", "09": "new"}}


def test_the_lesson_follows_from_the_graded_cells_if_the_metadata_is_missing(course):
    unnamed = released_notebook(EIGHT).replace(b'"lidar_obstacle_lab"', b'"y"')
    path = archive(course, [("ada/x.ipynb", unnamed)])
    assert states(collect(course, path)) == {"ada": {"08": "new"}}


def test_name_and_content_that_disagree_become_a_question(course):
    files = [(f"ada/{SIX}.ipynb", notebook(EIGHT)), (f"ada/{SEVEN}.ipynb", notebook(SEVEN))]
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome)["ada"] == {"06": "?", "07": "new", "08": "?"}
    name = f"ada/{SIX}.ipynb"
    assert f"--lesson {name}=08 or --lesson {name}=06" in questions(outcome)[name]
    assert set(placed_files(course, "ada")) == {f"{SEVEN}.ipynb"}
    outcome = collect(course, path, lessons={name: "06"})
    assert states(outcome)["ada"] == {"06": "new", "07": "same"}
    assert collect(course, path).questions == [], "answered questions are not asked again"


def test_a_file_of_another_stage_is_collected_if_the_stage_is_named(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/01_point_clouds.ipynb", notebook("01_point_clouds")),
    ]
    path = archive(course, files)
    outcome = collect(course, path)
    assert "--stage stage1_ransac" in questions(outcome)["ada/01_point_clouds.ipynb"]
    outcome = collect(course, path, stages=(STAGE, "stage1_ransac"))
    assert states(outcome)["ada"] == {"01": "new", "06": "same"}
    assert set(placed_files(course, "ada", "stage1_ransac")) == {"01_point_clouds.ipynb"}
    assert collect(course, path).questions == []


def test_only_changed_notebooks_of_a_whole_course_count(course):
    """A student may submit a zip of the whole course, with many unchanged notebooks."""
    files = [
        (f"ada/lab/notebooks/{STAGE}/{SIX}.ipynb", notebook()),
        (
            "ada/lab/notebooks/stage1_ransac/01_point_clouds.ipynb",
            released_notebook("01_point_clouds"),
        ),
        ("ada/lab/utils/clouds.py", b"x = 1"),
        ("ada/lab/data/cloud.txt", b"1 2 3"),
        ("ada/__MACOSX/._06_filter_ground.ipynb", b"junk"),
        ("ada/lab/.ipynb_checkpoints/06_filter_ground-checkpoint.ipynb", notebook(text="old")),
    ]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}
    assert outcome.questions == []


def test_modules_next_to_a_notebook_are_collected(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/helper.py", b"x = 1"),
        ("ada/no module.py", b"x"),
        (f"ada/{SEVEN}.py", b"exported"),
        ("ada/elsewhere/other.py", b"y = 2"),
    ]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(), "helper.py": b"x = 1"}
    assert questions(outcome)[f"ada/{SEVEN}.py"] == f"is not a notebook. Ask for {SEVEN}.ipynb"


def test_a_resubmitted_module_gets_its_original_name(course):
    """Canvas adds a number to the name of a resubmitted file, so `import helper` would fail."""
    files = [
        (1, "helper.py", b"x = 1"),
        (2, "helper-1.py", b"x = 2"),
        (3, f"{SIX}-1.ipynb", notebook()),
    ]
    collect(course, archive(course, canvas_files("Lovelace, Ada", 4001, files)))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(), "helper.py": b"x = 2"}


def test_modules_of_another_lesson_are_not_collected(course):
    files = [(f"ada/{lesson}/{lesson}.ipynb", notebook(lesson)) for lesson in (SIX, SEVEN)]
    files += [(f"ada/{lesson}/helper.py", lesson.encode()) for lesson in (SIX, SEVEN)]
    outcome = collect(course, archive(course, files))
    assert placed_files(course, "ada")["helper.py"] == SIX.encode()
    assert (
        "next to another of this student's notebooks"
        in questions(outcome)[f"ada/{SEVEN}/helper.py"]
    )


def test_unclear_files_are_asked_about_only_while_a_lesson_is_missing(course):
    files = [("ada/scratch.ipynb", notebook(named=False)), ("ada/report.pdf", b"%PDF")]
    first = collect(course, archive(course, files))
    assert set(questions(first)) == {"ada/scratch.ipynb", "ada/report.pdf"}
    assert "--lesson ada/scratch.ipynb=NN" in questions(first)["ada/scratch.ipynb"]
    files += [(f"ada/{lesson}.ipynb", notebook(lesson)) for lesson in STAGE3]
    outcome = collect(course, archive(course, files))
    assert outcome.questions == []
    assert {remark.name for remark in outcome.remarks} == {"ada/scratch.ipynb", "ada/report.pdf"}


def test_modules_named_like_a_lesson_are_asked_about_only_if_the_lesson_is_missing(course):
    """If the lesson's notebook was submitted too, the `.py` file is only mentioned."""
    files = [(f"ada/{lesson}.py", b"x = 1") for lesson in (SIX, SEVEN)]
    files += [(f"ada/{SIX}.ipynb", notebook())]
    outcome = collect(course, archive(course, files))
    assert set(questions(outcome)) == {f"ada/{SEVEN}.py"}
    assert [remark.name for remark in outcome.remarks] == [f"ada/{SIX}.py"]


def test_a_student_who_submitted_only_a_picture_is_reported(course):
    outcome = collect(course, archive(course, [("ada/photo.png", b"x"), ("README.md", b"x")]))
    text = "is not a notebook. The student submitted only: photo.png"
    assert questions(outcome) == {"ada/photo.png": text}


def test_two_submitters_are_one_student_only_if_an_option_says_so(course):
    """Otherwise, one student's work could be judged as another's."""
    files = [
        *canvas_files("Lovelace, Ada", 4001, [(1, f"{SIX}.ipynb", notebook(text="ada"))]),
        *canvas_files("Byron, Annabella", 77, [(2, f"{SIX}.ipynb", notebook(text="bella"))]),
    ]
    path = archive(course, files)
    who = {"byronannabella_77": "ada"}
    outcome = collect(course, path, who=who)
    assert states(outcome) == {} and not list(course.submitted.glob("*/*"))
    assert "--who lovelaceada_4001=ada" in questions(outcome)["lovelaceada_4001"]
    collect(course, path, who={**who, "lovelaceada_4001": "ada"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="bella")}


# ---- several copies of a notebook ---------------------------------------------------------------


def test_an_untouched_copy_is_ignored(course):
    """An untouched second download, with "(1)" in its name, does not replace the student's work."""
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"ada/{SIX} (1).ipynb", released_notebook())]
    collect(course, archive(course, files))
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}


def test_an_untouched_notebook_does_not_replace_work_that_was_collected_earlier(course):
    """A student who submits again often attaches notebooks that are only in the last submission."""

    def submission(number, data):
        attachments = [(number, f"{SIX}.ipynb", data)]
        return archive(course, canvas_files("Lovelace, Ada", 4001, attachments))

    collect(course, submission(1, notebook()))
    again = submission(2, released_notebook())
    outcome = collect(course, again)
    assert states(outcome) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook()}
    ((name, text),) = [(remark.name, remark.text) for remark in outcome.remarks]
    assert text.startswith("contains no work")
    collect(course, again, lessons={name: "06"})  # the instructor's answer decides
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": released_notebook()}
    outcome = collect(course, submission(3, notebook(text="x = 2")))
    assert states(outcome) == {"ada": {"06": "newer"}}


def test_a_damaged_file_is_placed_if_there_is_no_other(course):
    broken = notebook()[:60]
    files = moodle_files("Ada Lovelace", 1, [(f"{SIX}.ipynb", broken)])
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": broken}
    (remark,) = outcome.remarks
    assert remark.text.startswith("is not a notebook, because it is not valid JSON. It was ")


def test_a_file_that_git_has_not_downloaded_is_not_placed(course, tmp_path):
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a21\nsize 9\n"
    write_checkout(
        tmp_path / "hw", "hw-3-ada-l", {f"{SIX}.ipynb": pointer, f"{SEVEN}.ipynb": pointer}
    )
    write_checkout(tmp_path / "hw", "hw-3-bmu", {f"{SIX}.ipynb": notebook()})
    outcome = collect(course, tmp_path / "hw")
    assert placed_files(course, "ada") == {}
    assert {name.rpartition("/")[2] for name in questions(outcome)} == {
        f"{SIX}.ipynb",
        f"{SEVEN}.ipynb",
    }
    assert "Run `git lfs pull` in the checkout" in " ".join(questions(outcome).values())


def test_a_copy_that_counts_only_because_of_its_number_is_reported(course):
    """The copy may be a backup, so the instructor can choose the other file afterwards."""
    names = (SIX, f"{SIX}-Copy1")
    pair = [(f"{name}.ipynb", notebook(text=name)) for name in names]
    path = archive(course, moodle_files("Ada Lovelace", 1, pair), when=MONDAY)
    for _ in range(2):
        (remark,) = collect(course, path).remarks
        assert remark.name == f"Ada Lovelace_1/{SIX}-Copy1.ipynb"
        assert f"instead of Ada Lovelace_1/{SIX}.ipynb, because the number" in remark.text
    answer = {f"Ada Lovelace_1/{SIX}.ipynb": "06"}
    outcome = collect(course, path, lessons=answer)
    assert states(outcome) == {"ada": {"06": "newer"}} and not outcome.remarks
    assert placed_files(course, "ada")[f"{SIX}.ipynb"] == notebook(text=SIX)
    outcome = collect(course, path)
    assert states(outcome) == {"ada": {"06": "same"}} and not outcome.remarks, "remembered"


def test_the_copy_with_the_highest_number_or_latest_time_counts(course):
    moodle = moodle_files(
        "Ada Lovelace",
        1,
        [(f"{SIX} ({n}).ipynb", notebook(text=f"copy {n}")) for n in (2, 10, 9)],
    )
    inner = make_zip(
        [
            (f"a/{SEVEN}.ipynb", notebook(SEVEN, "new"), (2026, 10, 2, 8, 0, 0)),
            (f"b/{SEVEN}.ipynb", notebook(SEVEN, "old"), (2026, 10, 1, 8, 0, 0)),
        ]
    )
    moodle += moodle_files("Ada Lovelace", 1, [("homework.zip", inner)])
    collect(course, archive(course, moodle))
    assert placed_files(course, "ada") == {
        f"{SIX}.ipynb": notebook(text="copy 10"),
        f"{SEVEN}.ipynb": notebook(SEVEN, "new"),
    }


def test_copies_without_an_order_become_a_question(course):
    """Times in Moodle's zips do not decide, because they are only the times of the download."""
    names = (f"a/{SIX}.ipynb", f"b/{SIX}.ipynb")
    files = moodle_files("Ada Lovelace", 1, [(name, notebook(text=name)) for name in names])
    files[1] = (*files[1], (2027, 1, 1, 0, 0, 0))
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome) == {"ada": {"06": "?"}}
    collect(course, path, lessons={f"Ada Lovelace_1/b/{SIX}.ipynb": "06"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text=names[1])}


# ---- collecting again ---------------------------------------------------------------------------

MONDAY, TUESDAY = (2026, 10, 12, 9, 0, 0), (2026, 10, 13, 9, 0, 0)


def resubmission(course, first_content, second_content, **options):
    first = archive(course, [(f"ada/{SIX}.ipynb", first_content)], "first.zip", when=MONDAY)
    second = archive(course, [(f"ada/{SIX}.ipynb", second_content)], "second.zip", when=TUESDAY)
    return first, second


def test_an_identical_file_is_not_replaced(course):
    first, second = resubmission(course, notebook(), notebook())
    collect(course, first)
    path = course.submitted / "ada" / STAGE / f"{SIX}.ipynb"
    before = path.stat()
    assert states(collect(course, second)) == {"ada": {"06": "same"}}
    assert (path.stat().st_ino, path.stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_newer_submission_replaces_the_older_one_which_is_kept(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    collect(course, first)
    assert states(collect(course, second)) == {"ada": {"06": "newer"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="second")}
    assert older_files(course, "ada") == [notebook(text="first")]
    assert [submission.path.name for submission in find_submissions(course)] == [f"{SIX}.ipynb"]
    assert find_submissions(course)[0].older == ()
    assert unaccounted_files(course) == []


def test_an_older_archive_does_not_replace_newer_work(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    collect(course, second)
    assert states(collect(course, first)) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="second")}


def test_canvas_numbers_take_precedence_over_the_time_of_the_download(course):
    for number, name, modified in ((9, "new", MONDAY), (8, "old", TUESDAY)):
        files = canvas_files("L, Ada", 4001, [(number, f"{SIX}.ipynb", notebook(text=name))])
        outcome = collect(course, archive(course, files, f"{name}.zip", when=modified))
    assert states(outcome) == {"ada": {"06": "kept"}}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="new")}


@pytest.mark.parametrize("hand", ["changed", "put there"])
def test_manual_changes_are_never_overwritten(course, hand):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    path = course.submitted / "ada" / STAGE / f"{SIX}.ipynb"
    if hand == "changed":
        collect(course, first)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"by hand")
    outcome = collect(course, second)
    assert states(outcome) == {"ada": {"06": "?"}}
    assert f"submitted/ada/{STAGE}/{SIX}.ipynb" in questions(outcome)[f"ada/{SIX}.ipynb"]
    assert path.read_bytes() == b"by hand"
    path.unlink()
    assert states(collect(course, second)) == {"ada": {"06": "new"}}


def test_a_time_belongs_to_the_files_that_it_arrived_with(course):
    first, second = resubmission(course, notebook(text="first"), notebook(text="second"))
    table = course.root / "times.csv"
    head = "id,Last modified (submission)\n"
    table.write_text(head + "ada,2026-10-12 10:00:00 UTC\n")
    collect(course, first, times=table)
    table.write_text(head + "ada,2026-10-19 10:00:00 UTC\n")
    collect(course, first, times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-12 10:00:00 UTC\n"
    outcome = collect(course, second)
    assert "timestamp.txt" not in placed_files(course, "ada"), "this is the time of older work"
    assert outcome.undecided["ada"] == "the work was submitted again, and the time is unknown"
    assert outcome.states and b"2026-10-12 10:00:00 UTC\n" in older_files(course, "ada")
    collect(course, second, times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-19 10:00:00 UTC\n"
    assert read_record(course.submitted / "ada" / STAGE).undecided == ""


# ---- stored decisions ---------------------------------------------------------------------------


def remark_texts(outcome):
    return {remark.name: remark.text for remark in outcome.remarks}


def test_the_owner_is_asked_for_once_per_stage(course):
    """Later archives of the stage reuse the answer; the command asks again for another stage."""
    team = moodle_files("Team Rot", 77, [(f"{SIX}.ipynb", notebook())])
    first = archive(course, team, "first.zip", when=MONDAY)
    collect(course, first, who={"TEAM ROT_77": "ada,cy"})
    team = moodle_files("Team Rot", 77, [(f"{SIX}.ipynb", notebook(text="again"))])
    outcome = collect(course, archive(course, team, "second.zip", when=TUESDAY))
    assert states(outcome) == {"ada": {"06": "newer"}, "cy": {"06": "newer"}}
    assert outcome.questions == []
    assert remark_texts(outcome)["Team Rot_77"].startswith("assigned to ada, cy")
    outcome = collect(course, first, stages=("stage1_ransac",))
    assert "Team Rot_77" in questions(outcome), "members of a team change from stage to stage"


def test_a_second_answer_replaces_the_first(course):
    path = archive(course, [(f"eve/{SIX}.ipynb", notebook())])
    collect(course, path, who={"eve": "ada,bjorn"})
    assert states(collect(course, path, who={"eve": "cy"})) == {"cy": {"06": "new"}}
    assert states(collect(course, path)) == {"cy": {"06": "same"}}


@pytest.mark.parametrize("inside", ["", "hw/", "a/b/"])
def test_an_archive_of_one_student_may_have_any_folders(course, inside):
    """The option suggested by the message about a student's zip works for folders of any depth."""
    packed = course.submitted / "cy" / STAGE / "my homework.zip"
    packed.parent.mkdir(parents=True)
    names = (SIX, SEVEN)
    packed.write_bytes(make_zip([(f"{inside}{name}.ipynb", notebook(name)) for name in names]))
    ((_, reason),) = unaccounted_files(course)
    assert "--who 'my homework=cy'" in reason
    outcome = collect(course, packed, who={"my homework": "cy"})
    assert states(outcome) == {"cy": {"06": "new", "07": "new"}}
    assert outcome.questions == []


def test_an_answer_for_a_loose_file_does_not_affect_other_students(course):
    """The answer names the whole archive, but only its loose file goes to that student."""
    files = [(f"{SIX}.ipynb", notebook()), (f"ada/{SEVEN}.ipynb", notebook(SEVEN))]
    path = archive(course, files)
    assert set(questions(collect(course, path))) == {"submissions"}
    outcome = collect(course, path, who={"submissions": "cy"})
    assert states(outcome) == {"ada": {"07": "same"}, "cy": {"06": "new"}}


def test_an_option_names_the_owner_of_a_zip_if_there_is_no_roster(anonymous_course):
    path = archive(anonymous_course, [(f"hw/{SIX}.ipynb", notebook())], "homework.zip")
    outcome = collect(anonymous_course, path, who={"homework": "cy"})
    assert states(outcome) == {"cy": {"06": "new"}}


def test_the_decision_to_skip_a_submitter_outside_the_course_is_remembered(course):
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"eve/{SIX}.ipynb", notebook(text="eve"))]
    path = archive(course, files)
    assert "To ignore the files, add --who eve=-" in questions(collect(course, path))["eve"]
    for who in ({"eve": "-"}, {}):
        outcome = collect(course, path, who=who)
        assert outcome.questions == []
        assert set(states(outcome)) == {"ada"}
    assert remark_texts(outcome)["eve"].startswith("ignored")


def test_the_owner_is_asked_for_again_after_the_student_left_the_roster(course):
    """Other members of the student's team keep the team's submission."""
    files = [(f"eve/{SIX}.ipynb", notebook()), (f"team/{SIX}.ipynb", notebook(text="team"))]
    path = archive(course, files)
    collect(course, path, who={"eve": "ada", "team": "bjorn,cy"})
    roster = course.root / "roster.csv"
    roster.write_text(
        "".join(line for line in roster.open() if not line.startswith(("ada", "bjorn")))
    )
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"eve"}
    assert states(outcome) == {"cy": {"06": "same"}}


def test_a_team_is_asked_about_if_another_member_submits(course):
    """Canvas names a team's work after the member who submitted."""
    write_roster(course, "tom,Tom,Turm,,40240,", "tina,Tina,Turm,,40247,", "yan,Yan,Yip,,126,")
    first = canvas_files("Turm, Tom", 40240, [(1, f"{SIX}.ipynb", notebook(text="first"))])
    collect(course, archive(course, first), who={"turmtom_40240": "tom,tina"})
    second = canvas_files("Turm, Tina", 40247, [(2, f"{SIX}.ipynb", notebook(text="second"))])
    other = canvas_files("Yip, Yan", 126, [(3, f"{SIX}.ipynb", notebook(text="yan"))])
    path = archive(course, [*second, *other])
    outcome = collect(course, path)
    texts = doubts(outcome)
    assert set(texts) == {"turmtina_40247"} and outcome.questions == []
    assert placed_files(course, "tina") == {f"{SIX}.ipynb": notebook(text="second")}
    assert placed_files(course, "tom") == {f"{SIX}.ipynb": notebook(text="first")}
    assert "tina and tom are a team" in texts["turmtina_40247"]
    assert "--who turmtina_40247=tina,tom" in texts["turmtina_40247"]
    assert collect(course, path, who={"turmtina_40247": "tina,tom"}).doubts == []
    for student in ("tom", "tina"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": notebook(text="second")}
    third = canvas_files("Turm, Tom", 40240, [(4, f"{SIX}.ipynb", notebook(text="third"))])
    assert collect(course, archive(course, third)).doubts == []
    for student in ("tom", "tina"):
        assert placed_files(course, student) == {f"{SIX}.ipynb": notebook(text="third")}


def test_a_member_who_left_a_team_is_collected_alone_after_an_answer(course):
    write_roster(course, "tom,Tom,Turm,,40240,", "tina,Tina,Turm,,40247,")
    first = canvas_files("Turm, Tom", 40240, [(1, f"{SIX}.ipynb", notebook(text="first"))])
    collect(course, archive(course, first), who={"turmtom_40240": "tom,tina"})
    alone = canvas_files("Turm, Tina", 40247, [(2, f"{SIX}.ipynb", notebook(text="tina"))])
    path = archive(course, [*first, *alone])
    outcome = collect(course, path, who={"turmtina_40247": "tina", "turmtom_40240": "tom"})
    assert outcome.questions == []
    assert placed_files(course, "tom") == {f"{SIX}.ipynb": notebook(text="first")}
    assert placed_files(course, "tina") == {f"{SIX}.ipynb": notebook(text="tina")}


def test_the_decision_to_ignore_a_file_is_remembered(course, run_command, capsys):
    broken = make_zip([("x.txt", b"x" * 999)])[:-40]
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("ada/report.pdf", b"%PDF"),
        ("ada/homework.zip", make_zip([("01_point_clouds.ipynb", notebook("01_point_clouds"))])),
        ("bjorn/photo.png", b"x"),
        ("bjorn/notes.txt", b"x"),
        ("cy/homework.zip", broken),
    ]
    path = archive(course, files)
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "To ignore one of these files from now on, add --who 'FILE=-'." in output
    names = [
        "ada/report.pdf",
        "ada/homework.zip/01_point_clouds.ipynb",
        "bjorn/photo.png",
        "cy/homework.zip",
    ]
    assert set(questions(collect(course, path))) == set(names)
    options = [word for name in names for word in ("--who", f"{name}=-")]
    assert run_command(path, *options) == 0
    assert "waiting" not in capsys.readouterr().out
    assert run_command(path) == 0
    assert states(collect(course, path)) == {"ada": {"06": "same"}, "bjorn": {}, "cy": {}}


def test_later_work_with_the_name_of_an_ignored_file_is_collected(course):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook(EIGHT, "wrong name")), ("cy/h.zip", b"")])
    name = f"ada/{SIX}.ipynb"
    outcome = collect(course, path, who={name: "-", "cy/h.zip": "-"})
    assert outcome.questions == [] and states(outcome) == {"ada": {}, "cy": {}}
    assert collect(course, path).questions == []
    later = [(name, notebook()), ("cy/h.zip", make_zip([(f"{SEVEN}.ipynb", notebook(SEVEN))]))]
    outcome = collect(course, archive(course, later))
    assert states(outcome) == {"ada": {"06": "new"}, "cy": {"07": "new"}}


def test_no_question_is_asked_about_an_untouched_repository(course, tmp_path):
    given = {f"notebooks/{STAGE}/{SIX}.ipynb": released_notebook(), "README.md": b"hello"}
    for login in ("ada-l", "bmu"):
        write_checkout(tmp_path / "hw", f"hw-3-{login}", given)
    outcome = collect(course, tmp_path / "hw")
    assert outcome.questions == []
    assert remark_texts(outcome)["hw-3-bmu"] == "contains no notebook that the student changed"


def test_stored_answers_contain_no_names(course):
    """The name of a team's archive may be the name of a student who asks to be deleted."""
    files = [
        ("turmtom_40240/" + f"{SIX}.ipynb", notebook()),
        ("leftlars_40999/" + f"{SIX}.ipynb", notebook()),
        ("bjorn/lars.pdf", b"%PDF"),
    ]
    path = archive(course, files)
    who = {"turmtom_40240": "ada,cy", "leftlars_40999": "-", "bjorn/lars.pdf": "-"}
    assert collect(course, path, who=who).questions == []
    (kept,) = course.submitted.glob(".*")
    text = kept.read_text("utf-8")
    assert "lars" not in text and "turm" not in text
    assert text.count('"student": "ada"') == 1
    assert collect(course, path).questions == []


def test_answers_that_earlier_versions_stored_still_apply(course):
    path = archive(course, [(f"Eve/{SIX}.ipynb", notebook())])
    course.submitted.mkdir()
    line = f'{{"student": "cy", "stage": "{STAGE}", "label": "eve"}}\n'
    (course.submitted / ".whose.jsonl").write_text(line)
    assert states(collect(course, path)) == {"cy": {"06": "new"}}


def test_damaged_stored_answers_do_not_stop_collecting(course):
    path = archive(course, [(f"eve/{SIX}.ipynb", notebook())])
    collect(course, path, who={"eve": "cy"})
    (kept,) = course.submitted.glob(".*")
    kept.write_bytes(b'[]\n{"stage": 1}\n\xff\n' + kept.read_bytes())
    assert set(questions(collect(course, path))) == {"eve"}


def test_the_choice_between_two_copies_is_asked_for_once(course):
    """The question returns only if a third notebook for the lesson arrives."""
    pair = [
        (f"ada/one/{SIX}.ipynb", notebook(text="one"), MONDAY),
        (f"ada/two/{SIX}.ipynb", notebook(text="two"), MONDAY),
        ("bjorn/photo.png", b"x"),
    ]
    path = archive(course, pair)
    assert f"ada/one/{SIX}.ipynb" in questions(collect(course, path))
    collect(course, path, lessons={f"ada/two/{SIX}.ipynb": "06"})
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="two")}
    outcome = collect(course, path)
    assert set(questions(outcome)) == {"bjorn/photo.png"} and states(outcome)["ada"] == {
        "06": "same"
    }
    third = (f"ada/three/{SIX}.ipynb", notebook(text="three"), MONDAY)
    outcome = collect(course, archive(course, [*pair, third], "more.zip"))
    assert f"ada/three/{SIX}.ipynb" in questions(outcome)[f"ada/two/{SIX}.ipynb"]
    assert states(outcome)["ada"] == {"06": "?"}
    assert placed_files(course, "ada") == {f"{SIX}.ipynb": notebook(text="two")}


def test_the_lesson_of_an_unnamed_notebook_is_asked_for_once(course):
    path = archive(course, [("ada/scratch.ipynb", notebook(named=False))])
    collect(course, path, lessons={"ada/scratch.ipynb": "07"})
    outcome = collect(course, path)
    assert outcome.questions == [] and states(outcome) == {"ada": {"07": "same"}}


# ---- hostile archives ---------------------------------------------------------------------------


def files_below(root):
    return {path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    "name",
    [
        f"../../../{SIX}.ipynb",
        f"/etc/{SIX}.ipynb",
        f"C:\\Windows\\{SIX}.ipynb",
        f"..\\..\\{SIX}.ipynb",
        f"{SIX}.ipynb\0.txt",
        f"aux/{SIX}.ipynb",
        f"a/../../../{SIX}.ipynb",
        f"//server/share/{SIX}.ipynb",
    ],
)
@pytest.mark.parametrize("within", ["", "homework.zip"])
def test_names_cannot_lead_outside_the_folder(course, name, within, tmp_path):
    """The notebook is collected into the folder, because old zip programs write such names."""
    data = make_zip([(name, notebook())])
    files = [("ada/homework.zip", data)] if within else [("ada/" + name, notebook())]
    files_before = files_below(tmp_path)
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {"ada": {"06": "new"}}
    created = files_below(tmp_path) - files_before
    folder = f"course/submitted/ada/{STAGE}/"
    assert created == {
        "course/submissions.zip",
        f"{folder}{SIX}.ipynb",
        f"{folder}.collected.json",
    }


def test_a_link_is_not_followed(course, tmp_path):
    secret = tmp_path / f"{SEVEN}.ipynb"
    secret.write_bytes(notebook(SEVEN, "secret"))
    info = zipfile.ZipInfo(f"ada/{SEVEN}.ipynb")
    info.external_attr = 0o120777 << 16
    with zipfile.ZipFile(course.root / "links.zip", "w") as file:
        file.writestr(info, str(secret))
    assert (
        "is a link" in questions(collect(course, course.root / "links.zip"))[f"ada/{SEVEN}.ipynb"]
    )
    folder = tmp_path / "class"
    (folder / "ada").mkdir(parents=True)
    (folder / "ada" / f"{SEVEN}.ipynb").symlink_to(secret)
    (folder / "bjorn").symlink_to(tmp_path)
    os.mkfifo(folder / "ada" / f"{EIGHT}.ipynb")
    outcome = collect(course, folder)
    assert "link" in questions(outcome)[f"ada/{SEVEN}.ipynb"]
    assert "ordinary" in questions(outcome)[f"ada/{EIGHT}.ipynb"]
    assert not course.submitted.exists()


def test_zip_bombs_are_refused_with_a_reason(course, monkeypatch):
    zeros = b'{"cells": [], "x": "' + b"0" * (8 * 2**20) + b'"}'
    deep = notebook(NINE)
    for _ in range(4):
        deep = make_zip([(f"{NINE}.ipynb" if deep[:1] == b"{" else "more.zip", deep)])
    many = make_zip([(f"{n}.txt", b"") for n in range(zips.MAX_FILES_PER_STUDENT + 1)])
    files = [
        (f"ada/{SIX}.ipynb", zeros),
        ("ada/ratio.zip", make_zip([(f"{SEVEN}.ipynb", zeros)])),
        ("ada/many.zip", many),
        ("ada/deep.zip", deep),
        ("ada/broken.zip", make_zip([("x.txt", b"x" * 999)])[:-40]),
        ("bjorn/" + f"{SIX}.ipynb", notebook()),
    ]
    outcome = collect(course, archive(course, files))
    texts = questions(outcome)
    assert "like a zip bomb" in texts[f"ada/{SIX}.ipynb"]
    assert "like a zip bomb" in texts[f"ada/ratio.zip/{SEVEN}.ipynb"]
    assert "contains 5,001 files" in texts["ada/many.zip"]
    assert "other zips, so it was not opened" in texts["ada/deep.zip/more.zip/more.zip/more.zip"]
    assert "cannot be opened as a zip" in texts["ada/broken.zip"]
    assert states(outcome) == {"ada": {}, "bjorn": {"06": "new"}}, "other students are not affected"


def test_too_many_bytes_in_one_zip_are_refused(course, monkeypatch):
    monkeypatch.setattr("grader.classroom.collect.inspection.MAX_BYTES_PER_STUDENT", 2000)
    inner = make_zip([(f"{n}.ipynb", notebook(text=str(n) * 90)) for n in range(20)])
    outcome = collect(course, archive(course, [("ada/homework.zip", inner)]))
    assert "unpacks to more than" in questions(outcome)["ada/homework.zip"]


def test_a_zip_with_a_password_becomes_a_question(course, tmp_path):
    data = bytearray(make_zip([(f"{SIX}.ipynb", notebook())]))
    for signature, place in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        data[data.find(signature) + place] |= 1
    outcome = collect(course, archive(course, [("ada/homework.zip", bytes(data))]))
    assert "password" in questions(outcome)[f"ada/homework.zip/{SIX}.ipynb"]


# ---- the command --------------------------------------------------------------------------------


@pytest.fixture
def run_command(course, monkeypatch):
    monkeypatch.setattr(commands, "Course", lambda: course)

    def run(*words):
        return cli.main(["collect", "--stage", STAGE, *map(str, words)])

    return run


def test_the_exit_status_is_1_while_questions_are_open(course, run_command, capsys):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook()), (f"eve/{SIX}.ipynb", notebook())])
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "until you decide" in output and "--who eve=ID" in output
    assert (
        "Students on the roster without a submission: 2 (bjorn, cy)." in output
        and "xcused" not in output
    )
    assert run_command(path, "--who", "eve=cy") == 0
    assert "waiting" not in capsys.readouterr().out


def test_a_wrong_stage_is_reported_even_if_a_question_is_open(course, run_command, capsys):
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    assert run_command(path) == 0
    capsys.readouterr()
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook()), ("cy/a.txt", b"a")])
    assert cli.main(["collect", "--stage", "stage2_clustering", str(path)]) == 1
    message = (
        "No notebook was collected for stage2_clustering. Decide about the files above, or corr"
    )
    assert message in capsys.readouterr().err


def test_an_open_question_about_collected_files_is_shown_as_such(course, run_command, capsys):
    files = canvas_files("Team Rot", 4001, [(1, f"{SIX}.ipynb", notebook())])
    path = archive(course, files)
    assert run_command(path) == 1
    output = capsys.readouterr().out
    assert "Collected, but the owner is uncertain:" in output and "until you decide" not in output
    assert run_command(path, "--who", "teamrot_4001=ada") == 0


def test_excused_students_are_not_reported_as_missing(course, run_command, capsys):
    (course.root / "deadlines.toml").write_text(
        f'[{STAGE}]\ndue = 2026-11-20 18:00:00\n[{STAGE}.students]\ncy = "excused"\n'
        '[stage1_ransac.students]\nbjorn = "excused"\n'
    )
    roster = "id,role\nada,\nbjorn,\ncy,\nguest,auditor\n"
    (course.root / "roster.csv").write_text(roster)
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 0
    output = " ".join(capsys.readouterr().out.split())
    assert "Students on the roster without a submission: 1 (bjorn)." in output
    assert "Excused students without a submission: cy." in output
    assert "Auditors without a submission: guest." in output


def test_students_in_an_earlier_archive_are_not_reported_as_missing(course, run_command, capsys):
    """Each section may have an archive of its own."""
    for student in ("ada", "bjorn"):
        assert run_command(archive(course, [(f"{student}/{SIX}.ipynb", notebook())])) == 0
    output = capsys.readouterr().out
    assert "without a submission: 2 (bjorn, cy)." in output
    assert "without a submission: 1 (cy)." in output


def test_the_number_of_times_in_the_table_is_reported(course, run_command, capsys):
    files = [(f"ada/{SIX}.ipynb", notebook()), (f"cy/{SIX}.ipynb", notebook())]
    path = archive(course, files)
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,2026-10-14 14:14 UTC\n")
    run_command(path)
    assert "submission times" not in capsys.readouterr().out
    run_command(path, "--timestamps", table)
    output = " ".join(capsys.readouterr().out.split())
    assert "The table contains submission times for 1 of the 2 students with notebooks." in output


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["none.zip"], "does not exist"),
        (["damaged.zip"], "is not a complete zip"),
        (["empty"], " is empty."),
        ([".", "--who", "x=nobody"], "no student on the roster has the id nobody"),
        ([".", "--who", "x=Ada Lovelace"], "Write ada"),
        ([".", "--who", "x/report.pdf=ada"], "can only be ignored, not assigned. Write - instead"),
        ([".", "--lesson", "x=99"], "there is no lesson 99"),
        ([".", "--timestamps", "none.csv"], "cannot be read"),
    ],
)
def test_errors_explain_wrong_options(course, run_command, words, message, capsys, monkeypatch):
    monkeypatch.chdir(course.root)
    (course.root / "damaged.zip").write_bytes(b"")
    (course.root / "empty").mkdir()
    assert run_command(*words) == 2
    assert message in capsys.readouterr().err


def test_students_with_an_undecided_time_are_listed(course, run_command, capsys):
    table = course.root / "times.csv"
    table.write_text("id,Last modified (submission)\nada,10/11/2026 9:00\n")
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    assert run_command(path, "--timestamps", table) == 0
    output = capsys.readouterr().out
    assert "It is unknown whether these students submitted late: ada. Reason: the" in output
    assert "has '10/11/2026 9:00', which is not a time" in output


def test_an_option_cannot_lead_to_another_folder(anonymous_course):
    path = archive(anonymous_course, [(f"ada/{SIX}.ipynb", notebook())])
    with pytest.raises(CollectError, match="no folder can have the name ../../x"):
        collect(anonymous_course, path, who={"ada": "../../x"})


def test_collecting_is_refused_while_the_course_is_graded(course, run_command, capsys):
    from grader.classroom.lock import course_lock

    with course_lock(course):
        assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    assert "Another run is grading" in capsys.readouterr().err


def test_a_stopped_run_is_resumed(course):
    path = archive(course, [(f"{name}/{SIX}.ipynb", notebook()) for name in ("ada", "bjorn", "cy")])

    def stop(done, total, what):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        module.collect(course, [path], [STAGE], None, {}, {}, stop)
    found = states(collect(course, path))
    assert found == {"ada": {"06": "same"}, "bjorn": {"06": "same"}, "cy": {"06": "new"}}


@pytest.mark.parametrize("number", [errno.EACCES, errno.EROFS, errno.EPERM])
def test_the_error_about_a_read_only_folder_names_the_folder(
    course, run_command, monkeypatch, capsys, number
):
    def refuse(*about, dir, **options):
        raise OSError(number, os.strerror(number), str(dir))

    monkeypatch.setattr("tempfile.mkstemp", refuse)
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    errors = capsys.readouterr().err
    assert str(course.submitted / "ada" / STAGE) in errors and "same command again" in errors


def test_the_error_about_a_file_instead_of_a_folder_names_the_file(course, run_command, capsys):
    course.submitted.write_text("")
    assert run_command(archive(course, [(f"ada/{SIX}.ipynb", notebook())])) == 1
    assert str(course.submitted) in capsys.readouterr().err


def test_a_full_disk_leaves_no_partial_files(course, monkeypatch):
    monkeypatch.setattr(os, "replace", lambda *about: (_ for _ in ()).throw(OSError(28, "full")))
    path = archive(course, [(f"ada/{SIX}.ipynb", notebook())])
    with pytest.raises(OSError, match="full"):
        collect(course, path)
    assert [path.name for path in course.submitted.rglob("*") if path.is_file()] == []


# ---- equal names --------------------------------------------------------------------------------


def write_roster(course, *people):
    lines = ["id,first_name,last_name,email,lms_id,github", *people]
    (course.root / "roster.csv").write_text("\n".join(lines) + "\n")


def test_namesakes_have_separate_times(course):
    write_roster(course, "yan,Yan,Yip,,,", "yan2,Yan,Yip,,,")
    files = [
        *moodle_files("Yan Yip", 11, [(f"{SIX}.ipynb", notebook())]),
        *moodle_files("Yan Yip", 12, [(f"{SIX}.ipynb", notebook(text="two"))]),
    ]
    table = course.root / "worksheet.csv"
    times = ("Saturday, 10 October 2026, 10:00 AM", "Tuesday, 20 October 2026, 10:00 AM")
    rows = [(number, "Yan Yip", "", "", time) for number, time in zip((11, 12), times, strict=True)]
    table.write_text(worksheet(rows), "utf-8")
    (course.root / "deadlines.toml").write_text('timezone = "UTC"\n')
    who = {"Yan Yip_11": "yan", "Yan Yip_12": "yan2"}
    collect(course, archive(course, files), times=table, who=who)
    assert placed_files(course, "yan")["timestamp.txt"] == b"2026-10-10 10:00:00 UTC\n"
    assert placed_files(course, "yan2")["timestamp.txt"] == b"2026-10-20 10:00:00 UTC\n"


def test_an_ambiguous_row_is_not_used(course):
    write_roster(course, "yan,Yan,Yip,,,", "yan2,Yan,Yip,,,")
    table = course.root / "times.csv"
    table.write_text("name,Last modified (submission)\nYan Yip,2026-10-20 10:00:00 UTC\n")
    outcome = collect(course, archive(course, [(f"yan/{SIX}.ipynb", notebook())]), times=table)
    reason = "the table of submission times has no row or several rows for this student"
    assert outcome.undecided == {"yan": reason}


@pytest.mark.parametrize(
    ("number", "email", "known"),
    [
        (11, "ada@x.edu", False),  # a second row with her number
        (77, "ada@x.edu", True),  # her own number, 11, decides
        (77, "eve@x.edu", True),
    ],
)
def test_a_students_text_cannot_make_another_student_late(course, number, email, known):
    """A text cannot forge a row, because a quotation mark after a backslash does not end a cell."""
    write_roster(course, "ada,Ada,Lovelace,ada@x.edu,,", "eve,Eve,Evil,eve@x.edu,,")
    table = course.root / "worksheet.csv"
    early, late = "Saturday, 10 October 2026, 10:00 AM", "Tuesday, 20 October 2026, 10:00 AM"
    her_row = f'"Participant 11","Ada Lovelace","ada@x.edu","Submitted","","{early}"\n'
    forged = f'Participant {number},Ada Lovelace,{email},Submitted,,"{late}"\n'
    table.write_text(
        "Identifier,Full name,Email address,Status,Online text,Last modified (submission)\n"
        f'{her_row}"Participant 12","Eve Evil","eve@x.edu","Submitted","C:\\" ,-\n{forged}","-"\n'
    )
    (course.root / "deadlines.toml").write_text('timezone = "UTC"\n')
    files = moodle_files("Ada Lovelace", 11, [(f"{SIX}.ipynb", notebook())])
    outcome = collect(course, archive(course, files), times=table)
    if known:
        assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-10 10:00:00 UTC\n"
    else:
        assert set(outcome.undecided) == {"ada"} and "timestamp.txt" not in placed_files(
            course, "ada"
        )


@pytest.mark.parametrize("folder", ["12345", "012345"])
def test_a_number_that_lost_its_leading_zeros_is_recognised(course, folder):
    write_roster(course, "0012345,Yan,Yip,,,", "12,Ada,Lovelace,,,")
    outcome = collect(course, archive(course, [(f"{folder}/{SIX}.ipynb", notebook())]))
    assert states(outcome) == {}
    text = f"The student may be 0012345. Add --who {folder}=0012345"
    assert text in questions(outcome)[folder]


@pytest.mark.parametrize("page", ["cp850", "cp1252", "gbk"])
def test_names_from_windows_are_recognised(course, page):
    """Zips from Windows do not name the code page of their names."""
    name = "李伟" if page == "gbk" else "Bjørn Ås"
    write_roster(course, "li,伟,李,,,", "ba,Bjørn,Ås,,,", "bo,Bo,Bäcker,,,")
    data = make_zip([(f"{'#' * len(name.encode(page))}/{SIX}.ipynb", notebook())])
    data = data.replace(b"#" * len(name.encode(page)), name.encode(page))
    (course.root / "windows.zip").write_bytes(data)
    outcome = collect(course, course.root / "windows.zip")
    assert states(outcome) == {"li" if page == "gbk" else "ba": {"06": "new"}}


def test_a_virtual_environment_is_not_collected(course):
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        (f"ada/venv/lib/python3.12/site-packages/{SEVEN}.ipynb", notebook(SEVEN)),
        ("ada/venv/pyvenv.cfg", b"home = /usr/bin"),
    ]
    assert states(collect(course, archive(course, files))) == {"ada": {"06": "new"}}
    packed = archive(course, [("cy/h.zip", make_zip([(name[4:], data) for name, data in files]))])
    assert states(collect(course, packed)) == {"cy": {"06": "new"}}


def test_a_namesake_with_another_number_becomes_a_question(course):
    write_roster(course, "yan,Yan,Yip,,126,")
    files = canvas_files("Yip, Yan", 999, [(1, f"{SIX}.ipynb", notebook())])
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome) == {}
    assert "with the number 126 (yan), not 999" in questions(outcome)["yipyan_999"]
    assert states(collect(course, path, who={"yipyan_999": "yan"})) == {"yan": {"06": "new"}}


def test_a_login_is_not_matched_with_the_end_of_another(course, tmp_path):
    write_roster(course, "sam,Sam,Smith,,,smith", "zed,Zed,Zoe,,,zed")
    root = tmp_path / "hw"
    for name in ("hw-3-mary-smith", "hw-3-zed"):
        write_checkout(root, name, {f"{SIX}.ipynb": notebook(text=name)})
    outcome = collect(course, root)
    assert states(outcome) == {"zed": {"06": "new"}}
    assert "into column github" in questions(outcome)["hw-3-mary-smith"]


def test_logins_with_the_same_beginning_are_found(course, tmp_path):
    write_roster(course, "a,,,,,ann-a", "b,,,,,ann-b")
    for name in ("hw-3-ann-a", "hw-3-ann-b"):
        write_checkout(tmp_path / "hw", name, {f"{SIX}.ipynb": notebook(text=name)})
    assert states(collect(course, tmp_path / "hw")) == {"a": {"06": "new"}, "b": {"06": "new"}}


def test_the_question_about_a_single_repository_suggests_a_student(course, tmp_path):
    write_roster(course, "sam,Sam,Smith,,,smith")
    write_checkout(tmp_path / "hw", "hw-3-mary-smith", {f"{SIX}.ipynb": notebook()})
    question = questions(collect(course, tmp_path / "hw"))["hw-3-mary-smith"]
    assert question.count("The student may be sam. Add --who hw-3-mary-smith=sam") == 1


# ---- damage to one student's file ---------------------------------------------------------------


def test_an_empty_name_in_a_zip_does_not_affect_any_student(course):
    homework = make_zip([("\0x", b""), (f"{SIX}.ipynb", notebook(text="bjorn"))])
    files = [
        (f"ada/{SIX}.ipynb", notebook()),
        ("bjorn/h.zip", homework),
        (f"cy/{SIX}.ipynb", notebook(text="cy")),
    ]
    outcome = collect(course, archive(course, files))
    assert states(outcome) == {name: {"06": "new"} for name in ("ada", "bjorn", "cy")}


def test_an_unexpected_error_in_a_zip_does_not_affect_other_students(course, monkeypatch):
    monkeypatch.undo()  # read in another process, which reports the error
    original = inspection._unpack

    def look(data, name):
        if data == b"PK!":
            raise IndexError  # an unforeseen error
        return original(data, name)

    monkeypatch.setattr(inspection, "_unpack", look)
    files = [("ada/h.zip", b"PK!"), (f"cy/{SIX}.ipynb", notebook())]
    outcome = collect(course, archive(course, files))
    assert states(outcome)["cy"] == {"06": "new"}
    assert questions(outcome)["ada/h.zip"].startswith("cannot be opened. Inspect the file")


def test_a_damaged_zip_is_read_or_reported():
    """Most of the randomly changed bytes are in the central directory."""
    whole = make_zip([(f"{SIX}.ipynb", notebook()), ("mine.py", b"x = 1"), ("b/y.txt", b"y" * 50)])
    directory = whole.find(b"PK\1\2")
    lesson_recognition.cache_releases()
    rng = random.Random(1)
    seen = set()
    for _ in range(600):
        data = bytearray(whole)
        for _ in range(rng.choice((1, 1, 2, 4))):
            start = directory if rng.random() < 0.6 else 0
            position = rng.randrange(start, len(data))
            data[position] = rng.choice((0, 1, 0xFF, 0x80, 12, 93, rng.randrange(256)))
        pieces = inspection._unpack(bytes(data), "h.zip")
        seen |= {piece.complaint.partition(":")[0] for piece in pieces}
    assert len(seen) > 3, "some changes caused damage"


def test_too_many_bytes_in_several_zips_are_refused(course, monkeypatch):
    monkeypatch.setattr("grader.classroom.collect.inspection.MAX_BYTES_PER_STUDENT", 2000)
    archives = [
        make_zip([(f"{n}.ipynb", notebook(text=str(n) * 90)) for n in range(k, k + 5)])
        for k in (0, 5, 10)
    ]
    files = [(f"ada/{n}.zip", data) for n, data in enumerate(archives)]
    assert sum(map(len, archives)) < 4000
    texts = questions(collect(course, archive(course, files)))
    assert "brings the student's total to more than" in texts["ada/1.zip"]
    inner = make_zip([(f"{n}.zip", data) for n, data in enumerate(archives)])
    outcome = collect(course, archive(course, [("ada/all.zip", inner)], "inner.zip"))
    assert "unpacks to more than" in questions(outcome)["ada/all.zip"]


def test_a_long_text_in_moodles_worksheet_is_read(course):
    """Online texts in the worksheet may exceed csv's default limit for a cell."""
    table = course.root / "worksheet.csv"
    rows = [(5001, "Ada Lovelace", "x" * 140_000, "ada@x.edu", "14 October 2026, 2:14 PM")]
    table.write_text(worksheet(rows), "utf-8")
    files = moodle_files("Ada Lovelace", 5001, [(f"{SIX}.ipynb", notebook())])
    code = "import sys, csv; sys.path.insert(0, '.'); from pathlib import Path; " + (
        "from grader.classroom.collect.submission_table import read_submission_table; "
        f"print(len(read_submission_table(Path({str(table)!r}), None).rows))"
    )  # in its own process, where no other test has raised the limit
    result = subprocess.run(
        [sys.executable, "-c", code], cwd=PROJECT, capture_output=True, text=True
    )
    assert result.stdout == "1\n", result.stderr
    assert states(collect(course, archive(course, files), times=table)) == {"ada": {"06": "new"}}


def test_a_worksheet_that_is_not_a_table_is_refused(course):
    table = course.root / "worksheet.csv"
    table.write_text("a,b\n" + "x" * 2**25)
    with pytest.raises(CollectError, match="is not valid CSV"):
        collect(course, archive(course, [(f"ada/{SIX}.ipynb", notebook())]), times=table)
