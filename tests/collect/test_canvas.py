"""Submissions from Canvas, with groups, late work and renamed attachments."""

import struct
import unicodedata
from datetime import UTC, datetime

import pytest

from grader.lms.submission_times import SubmissionTimeUnknown, submission_time
from tests.archives import EIGHT, SEVEN, SIX, canvas_files, canvas_prefix, notebook
from tests.collecting import (
    MONDAY,
    STAGE,
    TUESDAY,
    archive,
    collect,
    doubts,
    placed_files,
    questions,
    states,
)


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


def test_anonymous_work_from_canvas_is_collected_under_its_code(course, course_without_roster):
    files = canvas_files("", 1, [(5, f"{SIX}.ipynb", notebook())], late=True, anonymous="aB3x9")
    assert files[0][0] == f"LATE_anon_aB3x9_5_{SIX}.ipynb"
    path = archive(course_without_roster, files)
    outcome = collect(course_without_roster, path)
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


def test_unusual_file_names_are_recognised(course, course_without_roster):
    """Canvas replaces each character that is not allowed in a file name with `_`."""
    name = f'a/b\\c:d*e?"f<g>h|{SIX} (1) Übung.ipynb'
    (made,) = canvas_files("Jr., Cy 2", 77, [(3, name, notebook())])
    assert made[0] == f"jrcy2_77_3_a_b_c_d_e_f_g_h_{SIX} (1) Übung.ipynb"
    outcome = collect(course_without_roster, archive(course_without_roster, [made]))
    assert states(outcome) == {"jrcy2_77": {"06": "new"}}
    assert set(placed_files(course_without_roster, "jrcy2_77")) == {f"{SIX}.ipynb"}
