"""Students with equal or similar names, and names from Windows, in archives and tables."""

import pytest

from tests.archives import SIX, canvas_files, make_zip, moodle_files, notebook, worksheet
from tests.collecting import archive, collect, placed_files, questions, states, write_roster


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


def test_a_namesake_with_another_number_becomes_a_question(course):
    write_roster(course, "yan,Yan,Yip,,126,")
    files = canvas_files("Yip, Yan", 999, [(1, f"{SIX}.ipynb", notebook())])
    path = archive(course, files)
    outcome = collect(course, path)
    assert states(outcome) == {}
    assert "with the number 126 (yan), not 999" in questions(outcome)["yipyan_999"]
    assert states(collect(course, path, who={"yipyan_999": "yan"})) == {"yan": {"06": "new"}}
