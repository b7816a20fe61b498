"""Pictures in written answers are shown to graders and students, or named in a sentence."""

import base64
import html
import json
import re

import nbformat
import pytest
from nbconvert.exporters import HTMLExporter

from grader.course.kept_answers import fill_in
from grader.course.lessons import find_lesson
from grader.course.mathml import markdown_page
from grader.intake.pictures import MAX_PICTURE_BYTES, illustrate
from grader.intake.preflight import prepare
from grader.intake.submission import SubmittedFiles
from grader.lms.answer_fingerprints import fingerprints
from grader.lms.autograded_copy import build_copy, graded_cells
from utils.notebooks.reading import Cell

LESSON = find_lesson("12_streaming_obstacles")
# A red PNG of 1 by 1 pixel; the first bytes decide what a file is.
PNG = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC"
JPEG, GIF, WEBP, SVG = (
    base64.b64encode(content).decode()
    for content in (b"\xff\xd8\xff\xe0", b"GIF89a", b"RIFF\x01\x02\x03\x04WEBPVP8 ", b"<svg/>")
)


def attachment(name, data=PNG, mime_type="image/png"):
    return {name: {mime_type: data}}


SHOWN = {
    "a plain name": ("![a](attachment:a.png)", attachment("a.png")),
    "a title": ('![a](attachment:a.png "title")', attachment("a.png")),
    "a picture in a link": ("[![a](attachment:a.png)](https://x.org)", attachment("a.png")),
    "an umlaut": ("![a](attachment:Übung.png)", attachment("Übung.png")),
    "the data of Colab": (f"![image.png](data:image/png;base64,{PNG})", {}),
    "data in angle brackets": (f"![](<data:image/png;base64,{PNG}>)", {}),
    "a space that is encoded in the link": ("![](attachment:a%20b.png)", attachment("a b.png")),
    "a name that is encoded twice": ("![](attachment:a%20b.png)", attachment("a%20b.png")),
    "a space in angle brackets": ("![](<attachment:a b.png>)", attachment("a b.png")),
    "a space": ("![](attachment:a b.png)", attachment("a b.png")),
    "brackets in the name": ("![](attachment:a%20(1).png)", attachment("a (1).png")),
    "a quote in the name": ("![](attachment:Bo's.png 'title')", attachment("Bo's.png")),
    "brackets in the words": ("![[1] a](attachment:a.png)", attachment("a.png")),
    "a reference": ("![a][Fig 1]\n\n[fig  1]: attachment:a.png", attachment("a.png")),
    "a short reference": (f"![a]\n\n[a]: data:image/png;base64,{PNG}", {}),
    "an empty reference": ("![a][]\n\n[a]: <attachment:a.png>", attachment("a.png")),
    "a tag": ('<img src="attachment:a.png" width="200">', attachment("a.png")),
    "a tag with data": (f"<IMG width=9 src='data:image/png;base64,{PNG}' />", {}),
    "a tag without quotes": ("<img src=attachment:a.png>", attachment("a.png")),
    "an entity": ("![](attachment:a&amp;b.png)", attachment("a&b.png")),
    "data in lines": ("![](attachment:a.png)", attachment("a.png", [PNG[:40] + "\n", PNG[40:]])),
    "a wrong type": ("![](attachment:a.jpg)", attachment("a.jpg", JPEG, "image/jpg")),
    "GIF": ("![](attachment:a.gif)", attachment("a.gif", GIF, "image/gif")),
    "WebP": ("![](attachment:a.webp)", attachment("a.webp", WEBP, "image/webp")),
}
NOT_SHOWN = {
    "a file next to the notebook": ("![](figure.png)", {}, "figure.png is not inside the notebook"),
    "a file as a tag": ("<img src='b/c.png'>", {}, "b/c.png is not inside the notebook"),
    "an address": (
        "![plot](https://x.org/a.png)",
        {},
        "https://x.org/a.png is on another site",
    ),
    "an address without a scheme": ("![](//x.org/a.png)", {}, "//x.org/a.png is on another site"),
    "an address by reference": (
        "![a][1]\n\n[1]: https://x.org/a.png",
        {},
        "https://x.org/a.png is on another site",
    ),
    "an attachment that is gone": (
        "![](attachment:a.png)",
        attachment("b.png"),
        "a.png is missing from the notebook",
    ),
    "an attachment of another kind": (
        "![](attachment:a.svg)",
        attachment("a.svg", SVG, "image/svg+xml"),
        "a.svg is not a PNG, JPEG, GIF or WebP picture",
    ),
    "a page that claims to be a picture": (
        f"![a](data:image/png;base64,{SVG})",
        {},
        "a is not a PNG, JPEG, GIF or WebP picture",
    ),
    "data that is not Base64": (
        "![a](data:image/svg+xml;utf8,abc)",
        {},
        "a is not a PNG, JPEG, GIF or WebP picture",
    ),
    "an attachment without data": (
        "![](attachment:a.png)",
        {"a.png": None},
        "a.png is missing from the notebook",
    ),
    "a large picture": (
        "![](attachment:a.png)",
        attachment("a.png", "A" * (MAX_PICTURE_BYTES * 3 // 2)),
        "a.png is larger than 5 MB",
    ),
}


def illustrate_cell(source, attachments):
    return illustrate([Cell("markdown", source, "", attachments)])


def copy_of(source, attachments):
    """Return the copy for graders of a notebook whose write-up has this source, and its notes."""
    notebook = json.loads(fill_in(LESSON, {"write_up": source}))
    for cell in notebook["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == "write_up":
            cell["attachments"] = attachments
    prepared = prepare(
        SubmittedFiles(f"{LESSON.name}.ipynb", json.dumps(notebook).encode()), LESSON
    )
    return build_copy(prepared), prepared.notes


def write_up(copy):
    (cell,) = [cell for cell in graded_cells(copy) if cell.metadata.nbgrader.grade_id == "write_up"]
    return cell


def shown_pictures(page):
    """Return the data of each picture on a page."""
    sources = re.findall(r"<img[^>]* src=\"([^\"]*)\"", page)
    return [html.unescape(source) for source in sources]


@pytest.mark.parametrize(("source", "attachments"), SHOWN.values(), ids=SHOWN)
def test_a_picture_is_shown_in_the_grading_page_and_in_feedback(source, attachments):
    copy, notes = copy_of(f"Before.\n\n{source}\n\nAfter.", attachments)
    nbformat.validate(copy)
    cell = write_up(copy)
    assert [note for note in notes if "picture" in note] == []
    ((mime_type, data),) = next(iter(cell.attachments.values())).items()
    expected = [f"data:{mime_type};base64,{data}"]
    answer = nbformat.v4.new_notebook(cells=[cell])
    formgrader, _ = HTMLExporter(template_name="basic").from_notebook_node(answer)
    for page in (formgrader, markdown_page(cell.source, cell.attachments)):
        assert shown_pictures(page) == expected
        assert "Before." in page and "After." in page and data not in re.sub("<[^>]+>", "", page)


@pytest.mark.parametrize(("source", "attachments", "reason"), NOT_SHOWN.values(), ids=NOT_SHOWN)
def test_a_picture_that_cannot_be_shown_is_named_in_the_answer_and_in_a_note(
    source, attachments, reason
):
    copy, notes = copy_of(f"Before.\n\n{source}\n\nAfter.", attachments)
    cell = write_up(copy)
    (note,) = [note for note in notes if "picture" in note]
    assert reason in note and "write_up" in note and "Drag" in note
    name, why = reason.split(" ", 1)
    assert f"(Picture not shown: `{name}` {why}.)" in cell.source.replace("\u200b", "")
    assert shown_pictures(markdown_page(cell.source, cell.get("attachments", {}))) == []


def test_a_note_on_many_pictures_names_five_and_counts_the_rest():
    _, notes = copy_of("".join(f"![](p{number}.png)" for number in range(30)), {})
    (note,) = [note for note in notes if "picture" in note]
    assert "p4.png" in note and "p5.png" not in note and "and 25 more" in note


def test_an_answer_with_plain_names_is_unchanged():
    """Otherwise, a person would have to grade such answers again."""
    text = "A ![plot](attachment:plot_1.png), [a link](b.md) and ![a word] in `![x]`.\n[b]: c"
    shown = illustrate_cell(text, attachment("plot_1.png"))
    assert (shown.text, list(shown.attachments), shown.not_shown) == (text, ["plot_1.png"], ())


def test_a_picture_is_part_of_the_answer_that_was_graded():
    answers = [f"![](data:image/png;base64,{data})" for data in (PNG, JPEG)]
    first, second = (fingerprints(copy_of(answer, {})[0]) for answer in answers)
    assert first["write_up"] != second["write_up"]


def test_a_picture_in_another_text_cell_is_shown():
    notebook = json.loads(fill_in(LESSON, {"write_up": "Text."}))
    source = f"My notes ![](data:image/png;base64,{PNG}) ![](gone.png)"
    notebook["cells"].append({"cell_type": "markdown", "metadata": {}, "source": source})
    data = json.dumps(notebook).encode()
    copy = build_copy(prepare(SubmittedFiles(f"{LESSON.name}.ipynb", data), LESSON))
    (cell,) = [cell for cell in copy.cells if cell.source.startswith("My notes")]
    assert list(cell.attachments.values()) == [{"image/png": PNG}]
    assert "`gone.png` is not inside the notebook" in cell.source
