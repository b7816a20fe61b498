"""Convert Markdown to HTML with formulas in MathML, which browsers show without a network.

By default, nbconvert uses MathJax, which a page has to download. This module uses latex2mathml
instead.
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
MAX_FORMULA_LENGTH = 2_000  # characters; longer formulas are not converted
_ELEMENTS = """
math mrow mi mn mo mtext mspace mfrac msqrt mroot mstyle mpadded mphantom menclose msub msup msubsup
munder mover munderover mmultiscripts mprescripts none mtable mtr mtd
"""
# These attributes are safe, because their values cannot be an address, a style or a script.
_ATTRIBUTES = """
display accent align columnalign columnlines rowlines columnspacing rowspacing depth displaystyle
fence form frame height largeop linethickness lspace mathvariant maxsize minsize movablelimits
notation rspace scriptlevel separator stretchy symmetric voffset width
"""
ELEMENTS = frozenset(f"{{{NAMESPACE}}}{name}" for name in _ELEMENTS.split())
ATTRIBUTES = frozenset(_ATTRIBUTES.split())
# Environments of MathJax, and the environments with which latex2mathml draws them.
ENVIRONMENT_ALIASES = {"aligned": "split", "gathered": "matrix"}
STYLE = """math { font-size: 1.08em; } math[display="block"] { margin: .8em 0; }
mtd[columnalign="left"] { text-align: left; } mtd[columnalign="right"] { text-align: right; }"""
"""Style sheet for a page with formulas."""


def markdown_page(markdown: str, attachments: dict | None = None) -> str:
    """Convert the Markdown of a cell to HTML.

    Parameters
    ----------
    markdown : str
        May contain HTML, which is kept. Untrusted text must first go through
        `grader.lms.sanitizer`.
    attachments : dict, optional
        Pictures in the cell, in the format of nbformat.
    """
    renderer = Renderer(escape=False, attachments=attachments or {}, exclude_anchor_links=True)
    return MarkdownWithMath(renderer=renderer).render(markdown)


def convert_formula(latex: str, is_block: bool) -> str:
    """Convert a formula to MathML, or return it as code if it cannot be converted.

    Parameters
    ----------
    latex : str
        May be untrusted.
    is_block : bool
        Whether the formula is on a separate line.
    """
    if len(latex) <= MAX_FORMULA_LENGTH:
        translated = re.sub(r"(?<=\\begin\{)\w+|(?<=\\end\{)\w+", _replace_alias, latex)
        try:
            element = ElementTree.fromstring(
                convert(translated, display="block" if is_block else "inline")
            )
        except Exception:  # latex2mathml raises various exceptions, even RecursionError
            element = None
        if element is not None and _is_mathematics(element):
            ElementTree.register_namespace("", NAMESPACE)
            return ElementTree.tostring(element, encoding="unicode")
    mark = "$$" if is_block else "$"
    return f"<code>{escape(f'{mark}{latex}{mark}')}</code>"


def _replace_alias(environment: re.Match) -> str:
    return ENVIRONMENT_ALIASES.get(environment[0], environment[0])


def _is_mathematics(drawn: ElementTree.Element) -> bool:
    """Return whether a drawn formula contains only allowed elements and attributes."""
    return all(
        element.tag in ELEMENTS and ATTRIBUTES.issuperset(element.attrib)
        for element in drawn.iter()
    )


class Renderer(IPythonRenderer):
    """nbconvert's renderer, with formulas in MathML."""

    def block_math(self, body: str) -> str:
        """Convert a formula on a separate line."""
        return convert_formula(body, is_block=True)

    def inline_math(self, body: str) -> str:
        """Convert a formula within a line."""
        return convert_formula(body, is_block=False)

    def latex_environment(self, name: str, body: str) -> str:
        r"""Convert an environment, from ``\begin`` to ``\end``."""
        return convert_formula(rf"\begin{{{name}}}{body}\end{{{name}}}", is_block=True)


class MathPage(HTMLExporter):
    """nbconvert's HTML exporter, with formulas that do not need a script."""

    @jinja2.pass_context
    def markdown2html(self, context: jinja2.runtime.Context, source: str) -> str:
        """Convert the Markdown of a cell to HTML."""
        return markdown_page(source, context.get("cell", {}).get("attachments"))
