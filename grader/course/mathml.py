"""Convert Markdown to HTML with formulas as MathML, which browsers show without a network.

By default, nbconvert relies on MathJax, which a page would have to fetch. This module uses
latex2mathml instead.
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
LONGEST_FORMULA = 2_000  # characters; longer formulas are not converted
_ELEMENTS = """
math mrow mi mn mo mtext mspace mfrac msqrt mroot mstyle mpadded mphantom menclose msub msup msubsup
munder mover munderover mmultiscripts mprescripts none mtable mtr mtd
"""
# The value of such an attribute cannot be an address, a style or a script.
_ATTRIBUTES = """
display accent align columnalign columnlines rowlines columnspacing rowspacing depth displaystyle
fence form frame height largeop linethickness lspace mathvariant maxsize minsize movablelimits
notation rspace scriptlevel separator stretchy symmetric voffset width
"""
ELEMENTS = frozenset(f"{{{NAMESPACE}}}{name}" for name in _ELEMENTS.split())
ATTRIBUTES = frozenset(_ATTRIBUTES.split())
# Environments that MathJax and latex2mathml know by different names.
ENVIRONMENT_ALIASES = {"aligned": "split", "gathered": "matrix"}
STYLE = """math { font-size: 1.08em; } math[display="block"] { margin: .8em 0; }
mtd[columnalign="left"] { text-align: left; } mtd[columnalign="right"] { text-align: right; }"""
"""Style sheet for a page with formulas."""


def markdown_page(markdown: str, attachments: dict | None = None) -> str:
    """Return the Markdown of a cell as HTML.

    Parameters
    ----------
    markdown : str
        May contain HTML, which is kept. Untrusted text must first be cleaned by
        `grader.lms.sanitizer`.
    attachments : dict, optional
        Pictures in the cell, in the format of nbformat.
    """
    renderer = Renderer(escape=False, attachments=attachments or {}, exclude_anchor_links=True)
    return MarkdownWithMath(renderer=renderer).render(markdown)


def formula(latex: str, display: bool) -> str:
    """Return a formula as MathML, or as code if it cannot be converted.

    Parameters
    ----------
    latex : str
        May be untrusted.
    display : bool
        Whether the formula is on a separate line.
    """
    if len(latex) <= LONGEST_FORMULA:
        translated = re.sub(r"(?<=\\begin\{)\w+|(?<=\\end\{)\w+", _known_environment, latex)
        try:
            element = ElementTree.fromstring(
                convert(translated, display="block" if display else "inline")
            )
        except Exception:  # latex2mathml raises many types, including RecursionError
            element = None
        if element is not None and _is_mathematics(element):
            ElementTree.register_namespace("", NAMESPACE)
            return ElementTree.tostring(element, encoding="unicode")
    mark = "$$" if display else "$"
    return f"<code>{escape(f'{mark}{latex}{mark}')}</code>"


def _known_environment(environment: re.Match) -> str:
    return ENVIRONMENT_ALIASES.get(environment[0], environment[0])


def _is_mathematics(drawn: ElementTree.Element) -> bool:
    """Return whether all elements and attributes are allowed, as latex2mathml may add others."""
    return all(
        element.tag in ELEMENTS and ATTRIBUTES.issuperset(element.attrib)
        for element in drawn.iter()
    )


class Renderer(IPythonRenderer):
    """nbconvert's renderer with formulas as MathML."""

    def block_math(self, body: str) -> str:
        """Convert a formula on a separate line."""
        return formula(body, display=True)

    def inline_math(self, body: str) -> str:
        """Convert a formula within a line."""
        return formula(body, display=False)

    def latex_environment(self, name: str, body: str) -> str:
        """Convert an environment from ``begin`` to ``end``."""
        return formula(rf"\begin{{{name}}}{body}\end{{{name}}}", display=True)


class MathPage(HTMLExporter):
    """nbconvert's HTML exporter with formulas that do not need a script."""

    @jinja2.pass_context
    def markdown2html(self, context: jinja2.runtime.Context, source: str) -> str:
        """Return the text of a cell as HTML."""
        return markdown_page(source, context.get("cell", {}).get("attachments"))
