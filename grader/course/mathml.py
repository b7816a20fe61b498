"""Markdown as HTML in which formulas are MathML: browsers show that without a network.

nbconvert leaves formulas to MathJax, which a page fetches. Here latex2mathml turns them round.
"""

from __future__ import annotations

import re
from html import escape
from xml.etree import ElementTree

import jinja2
from latex2mathml.converter import convert
from nbconvert.exporters import HTMLExporter
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath

NAMESPACE = "http://www.w3.org/1998/Math/MathML"
LONGEST = 2_000  # characters; what is longer is no formula that somebody reads
_ELEMENTS = """
math mrow mi mn mo mtext mspace mfrac msqrt mroot mstyle mpadded mphantom menclose msub msup msubsup
munder mover munderover mmultiscripts mprescripts none mtable mtr mtd
"""
# None of them holds an address, a style or a script.
_ATTRIBUTES = """
display accent align columnalign columnlines rowlines columnspacing rowspacing depth displaystyle
fence form frame height largeop linethickness lspace mathvariant maxsize minsize movablelimits
notation rspace scriptlevel separator stretchy symmetric voffset width
"""
ELEMENTS = frozenset(f"{{{NAMESPACE}}}{name}" for name in _ELEMENTS.split())
ATTRIBUTES = frozenset(_ATTRIBUTES.split())
# What latex2mathml does not know by the name that MathJax and the lessons use.
SAME_AS = {"aligned": "split", "gathered": "matrix"}
STYLE = """math { font-size: 1.08em; } math[display="block"] { margin: .8em 0; }
mtd[columnalign="left"] { text-align: left; } mtd[columnalign="right"] { text-align: right; }"""
"""For a page with formulas: what the standard leaves to style sheets."""


def markdown_page(markdown: str, attachments: dict | None = None) -> str:
    """Markdown of a cell as HTML.

    Parameters
    ----------
    markdown : str
        What is HTML in it stays so: text of a stranger goes through `grader.lms.sanitizer` first.
    attachments : dict, optional
        Pictures of the cell, as nbformat has them.
    """
    renderer = Renderer(escape=False, attachments=attachments or {}, exclude_anchor_links=True)
    return MarkdownWithMath(renderer=renderer).render(markdown)


def formula(latex: str, display: bool) -> str:
    """A formula as MathML; as code where it is none that can be drawn.

    Parameters
    ----------
    latex : str
        May be a stranger's.
    display : bool
        Whether it stands in a line of its own.
    """
    if len(latex) <= LONGEST:
        known = re.sub(r"(?<=\\begin\{)\w+|(?<=\\end\{)\w+", _same_as, latex)
        try:
            drawn = ElementTree.fromstring(convert(known, display="block" if display else "inline"))
        except Exception:  # of many kinds, RecursionError among them
            drawn = None
        if drawn is not None and _is_mathematics(drawn):
            ElementTree.register_namespace("", NAMESPACE)
            return ElementTree.tostring(drawn, encoding="unicode")
    mark = "$$" if display else "$"
    return f"<code>{escape(f'{mark}{latex}{mark}')}</code>"


def _same_as(environment: re.Match) -> str:
    return SAME_AS.get(environment[0], environment[0])


def _is_mathematics(drawn: ElementTree.Element) -> bool:
    """Whether all of it is on the lists; what latex2mathml does not know, it may let through."""
    return all(
        element.tag in ELEMENTS and ATTRIBUTES.issuperset(element.attrib)
        for element in drawn.iter()
    )


class Renderer(IPythonRenderer):
    """nbconvert's renderer, which draws the formulas itself."""

    def block_math(self, body: str) -> str:
        """Draw a formula in a line of its own."""
        return formula(body, display=True)

    def inline_math(self, body: str) -> str:
        """Draw a formula within a line."""
        return formula(body, display=False)

    def latex_environment(self, name: str, body: str) -> str:
        """Draw what stands between ``begin`` and ``end``."""
        return formula(rf"\begin{{{name}}}{body}\end{{{name}}}", display=True)


class MathPage(HTMLExporter):
    """nbconvert's pages, with formulas that no script has to draw."""

    @jinja2.pass_context
    def markdown2html(self, context: jinja2.runtime.Context, source: str) -> str:
        """The text of a cell as HTML."""
        return markdown_page(source, context.get("cell", {}).get("attachments"))
