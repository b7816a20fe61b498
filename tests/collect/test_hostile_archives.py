"""Hostile or damaged archives harm neither the course nor other students."""

import os
import random
import zipfile

import pytest

from grader.classroom import lesson_recognition
from grader.classroom.collect import inspection, zips
from tests.archives import EIGHT, NINE, SEVEN, SIX, make_zip, notebook
from tests.collecting import STAGE, archive, collect, questions, states


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


def test_zip_bombs_are_refused_with_a_reason(course):
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


def test_a_zip_with_a_password_becomes_a_question(course):
    data = bytearray(make_zip([(f"{SIX}.ipynb", notebook())]))
    for signature, place in ((b"PK\3\4", 6), (b"PK\1\2", 8)):
        data[data.find(signature) + place] |= 1
    outcome = collect(course, archive(course, [("ada/homework.zip", bytes(data))]))
    assert "password" in questions(outcome)[f"ada/homework.zip/{SIX}.ipynb"]


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
