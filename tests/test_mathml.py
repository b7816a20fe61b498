"""Formulas become MathML, which browsers show without a network, even if the LaTeX is hostile."""

import json
import re
from xml.etree import ElementTree

import pytest

from grader.course.lessons import all_lessons
from grader.course.mathml import MAX_FORMULA_LENGTH, convert_formula, markdown_page

NAME = "{http://www.w3.org/1998/Math/MathML}"


def tree(latex, display=False):
    return ElementTree.fromstring(convert_formula(latex, display))


def test_a_fraction_has_two_parts():
    drawn = tree(r"\frac{2 p}{q}", display=True)
    assert drawn.get("display") == "block"
    (fraction,) = drawn.iter(f"{NAME}mfrac")
    assert ["".join(part.itertext()) for part in fraction] == ["2p", "q"]


def test_aligned_lines_are_rows():
    drawn = tree(r"\begin{aligned} a &\le b \\ c &= d \end{aligned}", display=True)
    assert len(list(drawn.iter(f"{NAME}mtr"))) == 2


def test_every_formula_of_the_course_is_drawn():
    found = [
        block or inline
        for lesson in all_lessons()
        for cell in json.loads(lesson.solved.read_text("utf-8"))["cells"]
        if cell["cell_type"] == "markdown"
        for block, inline in re.findall(
            r"\$\$(.+?)\$\$|\$([^$\n]+?)\$", "".join(cell["source"]), re.S
        )
    ]
    assert len(found) > 100
    assert [latex for latex in found if not convert_formula(latex, True).startswith("<math")] == []


@pytest.mark.parametrize(
    "latex",
    [
        r"\text{<script>alert(1)</script>}",
        r"\text{<img src=x onerror=alert(1)>}",
        r"\text{</mtext></math><b onclick='x'>b</b>}",
        r"\href{javascript:alert(1)}{x}",
        r"\style{background:url(http://example.org)}{x}",
        r"\class{a}{x}",
        "{" * 1500,
        r"\frac" * 300,
        r"\left(" * 300,
        "x" * (MAX_FORMULA_LENGTH + 1),
    ],
)
def test_invalid_formulas_are_shown_as_code(latex):
    shown = convert_formula(latex, False)
    assert shown.startswith("<code>$") and shown.endswith("$</code>")
    assert "<" not in shown[6:-7] and ">" not in shown[6:-7]


def test_formulas_in_text_are_drawn_but_not_in_code():
    page = markdown_page("One $x^2$ and\n\n$$y$$\n\nand `$z$`.")
    assert page.count("<math ") == 2
    assert "<code>$z$</code>" in page
