"""A written answer is found in any cell, and copied with its pictures for a grader."""

import base64
import copy
import json
import re

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter

from grader.course.kept_answers import fill_in
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles
from grader.lms.autograded_copy import MISSING_ANSWER_NOTE, build_copy, graded_cells
from tests.notebook_cells import (
    REPORT,
    WRITTEN_LESSON,
    cell_of,
    code,
    from_cells,
    text,
    with_grade_id,
    with_report,
)


def write_below_own_cell(notebook):
    index = notebook["cells"].index(cell_of(notebook, "write_up"))
    notebook["cells"][index]["source"] = "YOUR ANSWER HERE"
    notebook["cells"].insert(index + 1, text(REPORT))


def write_in_two_cells(notebook):
    write_below_own_cell(notebook)
    index = notebook["cells"].index(cell_of(notebook, "write_up"))
    first, second = REPORT.split(", ")
    notebook["cells"][index + 1 : index + 2] = [text(first + ","), text(second)]


def remove_metadata(notebook):
    for cell in notebook["cells"]:
        cell["metadata"] = {}


def delete_own_cell(notebook):
    write_below_own_cell(notebook)
    notebook["cells"].remove(cell_of(notebook, "write_up"))


def convert_to_code_cell(notebook):
    cell = cell_of(notebook, "write_up")
    cell.update(cell_type="code", outputs=[], execution_count=None)


@pytest.mark.parametrize(
    "change",
    [
        lambda notebook: None,
        write_below_own_cell,
        write_in_two_cells,
        remove_metadata,
        delete_own_cell,
        convert_to_code_cell,
        lambda notebook: cell_of(notebook, "write_up").update(cell_type="raw"),
        lambda notebook: cell_of(notebook, "write_up").update(outputs=[]),
        lambda notebook: notebook.update(nbformat_minor=4),
        lambda notebook: notebook["cells"].append(copy.deepcopy(notebook["cells"][0])),
    ],
)
def test_a_written_answer_is_copied(change):
    notebook = with_report()
    change(notebook)
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    nbformat.validate(graded_copy)
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert cell.cell_type == "markdown"
    assert "".join(cell.source.split()) == "".join(REPORT.split())
    (other,) = [
        c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "second_data_set"
    ]
    assert other.source == "YOUR ANSWER HERE"


def test_text_that_may_be_the_answer_is_left_to_the_grader():
    notebook = with_report()
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    notebook["cells"] = [*cells, text(REPORT)]
    data = json.dumps(notebook).encode()
    prepared = prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    assert "A grader will look for it" in " ".join(prepared.notes)
    graded_copy = build_copy(prepared)
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert MISSING_ANSWER_NOTE in cell.source
    assert REPORT in "\n".join(cell.source for cell in graded_copy.cells)


def released_text_cell(number):
    """Return a text cell of lesson 12 as it was released."""
    cells = json.loads(WRITTEN_LESSON.released.read_text())["cells"]
    return text("".join(cells[number]["source"]))


def index_of(grade_id):
    cells = json.loads(WRITTEN_LESSON.released.read_text())["cells"]
    return cells.index(cell_of({"cells": cells}, grade_id))


def write_up(*cells):
    """Prepare a notebook with these cells, and return the results for the write-up.

    Returns
    -------
    tuple
        The text, whether it is certain, the sources of all cells after the first, the source of the
        write-up's own cell or None, and the notes about the write-up.
    """
    prepared = from_cells(code("def match_boxes(a, b, c): return a"), *cells, lesson=WRITTEN_LESSON)
    answer, index = prepared.answers["write_up"], prepared.graded.get("write_up")
    own = None if index is None else prepared.cells[index].source
    notes = [note for note in prepared.notes if "write_up" in note]
    return answer.text, answer.is_certain, [cell.source for cell in prepared.cells][1:], own, notes


STUB = text("YOUR ANSWER HERE")
OWN = with_grade_id(STUB, "write_up")


def prompt():
    """Return the cell that contains the write-up's question."""
    return released_text_cell(index_of("write_up") - 1)


def test_an_answer_in_its_own_cell_ignores_text_below():
    answer = with_grade_id(text("It finds 14 of 17."), "write_up")
    assert write_up(answer, text("A remark."))[:2] == ("It finds 14 of 17.", True)
    # An editor may copy the cell with its ID. The copy is appended, unless it is empty.
    more = with_grade_id(text("And 3 more."), "write_up")
    written, certain, cells, own, notes = write_up(OWN, answer, more, text("A remark."))
    assert (written, certain, own) == ("It finds 14 of 17.\n\nAnd 3 more.", True, answer["source"])
    assert cells == ["YOUR ANSWER HERE", "It finds 14 of 17.", "A remark."] and notes == []
    empty = with_grade_id(text("  "), "write_up")
    assert write_up(empty)[:2] == ("", True)


@pytest.mark.parametrize(
    ("source", "shown_text"),
    [
        ("It finds 14 of 17.", "It finds 14 of 17."),
        ("# It finds 14\n\n#of 17.\n## That is all.", "It finds 14\n\nof 17.\nThat is all."),
        ("# Results\nIt finds 14 of 17.", "# Results\nIt finds 14 of 17."),
    ],
)
def test_an_answer_in_a_code_cell_is_read_as_text_with_a_note(source, shown_text):
    """Comment signs are removed from a code cell, but a text cell keeps its heading."""
    answer, certain, _, own, notes = write_up(code(source, **OWN["metadata"]))
    assert (answer, certain, own) == (shown_text, True, source)
    assert len(notes) == 1 and "write_up was in a code cell" in notes[0]
    assert write_up(with_grade_id(text(source), "write_up"))[::4] == (source, [])
    # The released text in a code cell is an empty answer and needs no note.
    assert write_up(code("YOUR ANSWER HERE", **OWN["metadata"]))[::4] == ("", [])


def test_text_from_an_earlier_release_is_not_an_answer():
    """The lesson's text may change after students have downloaded it."""
    old = text("## Write-up, as it was called in the first release") | {"id": "fdc3655c352f"}
    assert write_up(OWN, old, text("Second."))[0] == ""
    assert write_up(prompt(), old)[:2] == ("", True)
    edited = old | {"source": f"{old['source']}. It finds 14 of 17."}
    assert write_up(OWN, edited)[0] == edited["source"]


def test_an_answer_below_its_cell_ends_at_the_next_cell_of_the_course():
    footer = released_text_cell(index_of("write_up") + 1)
    cells = [OWN, text("First."), text(" "), code("x = 1"), text("Second."), footer, text("Third.")]
    written, certain, kept, own, notes = write_up(prompt(), *cells)
    assert (written, certain, own) == ("First.\n\nSecond.", True, "YOUR ANSWER HERE")
    assert kept == [
        *(prompt()["source"], "YOUR ANSWER HERE", " ", "x = 1", footer["source"], "Third.")
    ]
    assert len(notes) == 1 and "was in 2 new cells below the cell" in notes[0]
    assert write_up(OWN, text("First."), OWN)[0] == "First."
    stopped = write_up(
        OWN, text("First."), with_grade_id(text("Other."), "test_x"), text("Second.")
    )
    assert stopped[0] == "First." and "in a new cell below the cell" in stopped[4][0]
    assert write_up(OWN, code("x = 1"), text(" "))[:3] == (
        "",
        True,
        ["YOUR ANSWER HERE", "x = 1", " "],
    )


def test_an_answer_whose_cell_was_deleted_is_found_below_its_question():
    written, certain, kept, own, notes = write_up(prompt(), text("First."), text("Second."))
    assert (written, certain, own) == ("First.\n\nSecond.", True, "First.")
    assert kept == [prompt()["source"], "First."] and len(notes) == 1
    assert write_up(prompt(), text("You see 14."), text("And 3."))[0] == "You see 14.\n\nAnd 3."
    # STUB is the answer's own cell, which lost its metadata, so the remark above is not the answer.
    written, certain, kept, own, notes = write_up(text("A remark."), prompt(), STUB)
    assert (written, certain, own, notes) == ("", True, "YOUR ANSWER HERE", [])
    assert write_up(STUB, prompt())[3] is None  # above the question, STUB is not the answer's cell


def test_an_answer_is_uncertain_only_if_other_text_may_be_the_answer():
    assert write_up(text("A remark."))[:2] == ("", False)
    assert write_up(text("A remark."))[4][0].startswith("The cell for write_up is missing")
    for cells in ([], [text(" ")], [released_text_cell(0)], [code("x = 1")], [prompt()]):
        assert write_up(*cells)[:2] == ("", True)


def test_pictures_of_all_parts_of_an_answer_are_kept():
    """Editors name every pasted picture image.png, so the names of two cells may be the same."""
    pictures = [base64.b64encode(b"\x89PNG" + end).decode() for end in (b"a", b"b")]
    parts = [
        {
            **text("![](attachment:image.png)"),
            "attachments": {"image.png": {"image/png": picture}},
        }
        for picture in pictures
    ]
    answer = from_cells(code("x = 1"), OWN, *parts, lesson=WRITTEN_LESSON).answers["write_up"]
    names = re.findall(r"attachment:(\S+)\)", answer.text)
    assert [answer.attachments[name] for name in names] == [
        {"image/png": picture} for picture in pictures
    ]


def test_cells_are_found_after_an_answer_of_several_cells():
    match = code("def match_boxes(a, b, c): return a")
    prepared = from_cells(OWN, text("First."), text("Second."), match, lesson=WRITTEN_LESSON)
    assert prepared.cells[prepared.graded["match_boxes"]].source.startswith("def match_boxes")
    assert len(prepared.cells) == 2


def test_only_pictures_are_kept_as_attachments():
    notebook = with_report()
    picture = base64.b64encode(b"\x89PNG").decode()
    cell_of(notebook, "write_up").update(
        source="![](attachment:a.png)"
        + "".join(
            f"![](<attachment:{name}>)" for name in ('b" onerror="alert(1)', "d.png", "e.svg")
        ),
        attachments={
            "a.png": {"image/png": picture, "text/html": "<script>"},
            'b" onerror="alert(1)': {"image/png": picture},
            "d.png": {"image/png": '" onerror="alert(1)'},
            "e.svg": {"image/svg+xml": base64.b64encode(b"<svg>").decode()},
        },
    )
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert "a.png" in cell.attachments
    assert list(cell.attachments.values()) == [{"image/png": picture}] * 2


@pytest.mark.end_to_end
def test_a_missing_picture_does_not_prevent_the_feedback_page():
    text_with_pictures = "![](attachment:gone.png) [a]: attachment:b%20c.png <x attachment:>"
    notebook = json.loads(fill_in(WRITTEN_LESSON, {"write_up": text_with_pictures}))
    picture = {"b c.png": {"image/png": base64.b64encode(b"png").decode()}}
    notebook["cells"].append({**text(text_with_pictures), "attachments": picture})
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    page, _ = HTMLExporter().from_notebook_node(graded_copy)
    assert "gone.png" in page


def test_a_copy_of_a_copy_is_the_same():
    notebook = with_report()
    notebook["cells"].append(text("<b>x</b> [a](javascript:b) $\\href{x}{y}$"))
    notebook["cells"].append({"cell_type": "raw", "metadata": {}, "source": "```\n<script>"})
    data = json.dumps(notebook).encode()
    first = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    again = SubmittedFiles("12_streaming_obstacles.ipynb", nbformat.writes(first).encode())
    for copied, cell in zip(
        build_copy(prepare(again, WRITTEN_LESSON)).cells, first.cells, strict=True
    ):
        assert copied == cell


def test_a_written_answer_that_may_be_cut_off_waits_for_a_grader():
    data = json.dumps(with_report()).encode()
    cut = SubmittedFiles("12_streaming_obstacles.ipynb", data[: data.index(b"I widened")])
    prepared = prepare(cut, WRITTEN_LESSON)
    assert "Look for the answer in the file" in prepared.answers["write_up"].text
    assert "A grader will look for it." in prepared.notes[-1]
