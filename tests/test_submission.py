"""Reading submissions, and computing their fingerprints."""

import dataclasses
import errno
import itertools
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from grader.intake.notebook import read_file, read_notebook
from grader.intake.submission import (
    MAX_MODULE_BYTES,
    MAX_MODULES,
    SubmittedFiles,
    read_submitted_files,
)
from utils.notebooks.reading import UnreadableNotebook


def submitted_files(**parts):
    return SubmittedFiles(**{"name": "06_filter_ground.ipynb", "data": b"{}"} | parts)


def test_a_module_cannot_continue_a_notebook():
    with_module = submitted_files(modules={"helper": "x = 1"})
    with_cell = submitted_files(data=b"{}\0helper\0x = 1")
    assert with_module.fingerprint() != with_cell.fingerprint()


# Short texts of few letters, so different fields often join to the same text.
TEXTS = st.text("a\0 1", max_size=2)
SUBMISSIONS = st.builds(
    SubmittedFiles,
    TEXTS,
    TEXTS.map(str.encode),
    TEXTS,
    st.dictionaries(TEXTS, TEXTS, max_size=2),
    st.lists(TEXTS, max_size=2).map(tuple),
)


@given(SUBMISSIONS, SUBMISSIONS)
def test_different_submissions_have_different_fingerprints(first, second):
    assert (first.fingerprint() == second.fingerprint()) == (first == second)


@given(TEXTS, TEXTS, TEXTS, TEXTS)
def test_parts_of_different_kinds_are_distinguished(a, b, c, d):
    ways = (
        submitted_files(notes=(a, b, c, d)),
        submitted_files(notes=(a, b), modules={c: d}),
        submitted_files(modules={a: b, c: d}),
        submitted_files(complaint=a, notes=(b, c, d)),
        submitted_files(complaint=a, notes=(b,), modules={c: d}),
        submitted_files(name=a, notes=(b,), modules={c: d}),
        submitted_files(data=a.encode(), notes=(b,), modules={c: d}),
    )
    for first, other in itertools.combinations(ways, 2):
        assert (first.fingerprint() == other.fingerprint()) == (first == other)


def test_a_file_name_that_is_not_text_has_a_fingerprint():
    names = [os.fsdecode(name) for name in (b"J\xfcrgen", b"J\xe4rgen", b"J?rgen")]
    assert len({submitted_files(notes=(name,)).fingerprint() for name in names}) == 3


# ---- reading ------------------------------------------------------------------------------------


def test_a_notebook_is_read_with_its_neighbouring_modules(tmp_path):
    path = tmp_path / "06_filter_ground.ipynb"
    path.write_bytes(b'{"cells": []}')
    (tmp_path / "zebra.py").write_text("z = 'ö'", "utf-8")
    (tmp_path / "helper.py").write_bytes(b"x = '\xff'")
    (tmp_path / "3d.py").write_text("cannot be imported")
    (tmp_path / "notes.txt").write_text("no module")
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "other.py").write_text("elsewhere")
    (tmp_path / "link.py").symlink_to(tmp_path / "zebra.py")
    made = read_submitted_files(path)
    assert made == SubmittedFiles(path.name, b'{"cells": []}', "", made.modules, ())
    assert made.modules == {"helper": "x = '\ufffd'", "zebra": "z = 'ö'"}
    assert made.notebook().cells == ()
    with pytest.raises(dataclasses.FrozenInstanceError):
        made.data = b""
    missing = read_submitted_files(tmp_path / "none.ipynb")
    assert missing.data == b"" and missing.modules == made.modules
    assert missing.complaint == "none.ipynb cannot be opened: No such file or directory."
    with pytest.raises(UnreadableNotebook, match="none.ipynb cannot be opened"):
        missing.notebook()


def test_modules_are_limited_in_number_and_size(tmp_path):
    assert MAX_MODULE_BYTES == 2**20
    for number in range(MAX_MODULES + 3):
        (tmp_path / f"module_{number:02}.py").write_bytes(b"")
    (tmp_path / "module_00.py").write_bytes(b"#" * MAX_MODULE_BYTES)
    (tmp_path / "module_01.py").write_bytes(b"#" * (MAX_MODULE_BYTES + 1))
    modules = read_submitted_files(tmp_path / "06.ipynb").modules
    assert MAX_MODULES == 20
    assert list(modules) == ["module_00", *(f"module_{number:02}" for number in range(2, 20))]
    assert len(modules["module_00"]) == MAX_MODULE_BYTES


def refusal(path):
    with pytest.raises(UnreadableNotebook) as refused:
        read_file(path)
    return str(refused.value)


def test_a_file_may_have_at_most_64_megabytes(tmp_path):
    path = tmp_path / "06.ipynb"
    with open(path, "wb") as file:
        file.truncate(64 * 2**20)
    assert len(read_file(path)) == 64 * 2**20
    os.truncate(path, 64 * 2**20 + 1)
    assert refusal(path).startswith("06.ipynb is larger than 64 MB. Clear its outputs")


def test_only_a_regular_file_is_opened(tmp_path):
    path = tmp_path / "06.ipynb"
    path.write_bytes(b'{"cells": []}')
    assert read_notebook(path).cells == ()
    (tmp_path / "link.ipynb").symlink_to(path)
    link = "link.ipynb cannot be opened: it is a link to another file."
    assert refusal(tmp_path / "link.ipynb") == link
    os.mkfifo(tmp_path / "pipe.ipynb")  # reading a pipe would block forever
    message = "is not an ordinary file. Submit the .ipynb file itself."
    assert refusal(tmp_path / "pipe.ipynb") == f"pipe.ipynb {message}"
    (tmp_path / "folder.ipynb").mkdir()
    folder = "folder.ipynb cannot be opened: Is a directory."
    assert refusal(tmp_path / "folder.ipynb") == folder


@pytest.mark.parametrize("number", [errno.EACCES, errno.ESTALE])
def test_the_reason_for_an_unreadable_file_comes_from_the_system(tmp_path, monkeypatch, number):
    def fail(*about):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "open", fail)
    message = f"06.ipynb cannot be opened: {os.strerror(number)}."
    assert refusal(tmp_path / "06.ipynb") == message
