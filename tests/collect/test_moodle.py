"""Submissions from Moodle, with teams, and times from its grading worksheet."""

import subprocess
import sys

import pytest

from grader.classroom.collect import CollectError
from grader.classroom.collect.record import read_record, unknown_time_reason
from grader.course.paths import PROJECT
from tests.archives import EIGHT, SEVEN, SIX, canvas_files, moodle_files, notebook, worksheet
from tests.collecting import (
    STAGE,
    archive,
    collect,
    placed_files,
    questions,
    states,
    write_checkout,
    write_roster,
)


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
    assert [(platform, count) for _, platform, count in outcome.archives] == [
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


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_a_table_of_times_is_read_in_any_form(course, encoding):
    (course.root / "deadlines.toml").write_text('timezone = "UTC"\n')
    table = course.root / "times.csv"
    text = "id\tLast modified (submission)\rada\t2026-10-14 14:14\r"
    table.write_bytes(text.encode(encoding))
    collect(course, archive(course, [(f"ada/{SIX}.ipynb", notebook())]), times=table)
    assert placed_files(course, "ada")["timestamp.txt"] == b"2026-10-14 14:14:00 UTC\n"


def test_a_long_text_in_moodles_worksheet_is_read(course):
    """Online texts in the worksheet may exceed csv's default limit for a cell."""
    table = course.root / "worksheet.csv"
    rows = [(5001, "Ada Lovelace", "x" * 140_000, "ada@x.edu", "14 October 2026, 2:14 PM")]
    table.write_text(worksheet(rows), "utf-8")
    files = moodle_files("Ada Lovelace", 5001, [(f"{SIX}.ipynb", notebook())])
    # The code runs in its own process, where no other test has raised the limit.
    code = "import sys, csv; sys.path.insert(0, '.'); from pathlib import Path; " + (
        "from grader.classroom.collect.submission_table import read_submission_table; "
        f"print(len(read_submission_table(Path({str(table)!r}), None).rows))"
    )
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
