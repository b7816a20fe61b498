"""`show_table` displays HTML in a notebook, and prints aligned text elsewhere."""

import pytest

from utils import show_table

HEADINGS = ("", "points", "a < b & c")


def test_columns_are_aligned_in_plain_python(capsys):
    show_table(HEADINGS, [("a wall", 7, "1,000"), ("us", "12,345", 0.5)])
    assert capsys.readouterr().out.splitlines() == [
        "        points  a < b & c",
        "a wall       7      1,000",
        "us      12,345        0.5",
    ]


def test_a_notebook_gets_an_html_table(monkeypatch):
    shown = []
    monkeypatch.setattr("utils.display.shell", object)
    monkeypatch.setattr("IPython.display.display", lambda data, raw: shown.append(data))
    show_table(HEADINGS, [("a wall", 7, "<b>")])
    (data,) = shown
    page = data["text/html"]
    assert [page.count(tag) for tag in ("<tr>", "<th ", "<td ")] == [2, 2, 4]
    assert "></th>" not in page, "an empty heading is not a heading cell"
    assert "a &lt; b &amp; c" in page and "&lt;b&gt;" in page and "<b>" not in page
    assert "a wall       7" in data["text/plain"]


@pytest.mark.parametrize("row", [("a wall",), ("a wall", 7, 8, 9)])
def test_a_row_of_another_length_is_refused(row):
    with pytest.raises(ValueError, match="zip"):
        show_table(HEADINGS, [row])
