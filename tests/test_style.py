"""Comments and docstrings avoid constructions that read as translated."""

import ast
import io
import re
import tokenize

import pytest

from grader.course.paths import PROJECT

PLAIN = (
    "conftest.py",
    "extension",
    "grader",
    "solutions/*.py",
    "solutions/*/*/*.py",
    "tests",
    "utils",
)
FORBIDDEN = {
    "who and what without a noun": r"\b(whoever|(for|of|to|by|from|with) who)\b|(^|[.:;] )whom\b",
    "nobody in particular": r"\b(nobody|somebody|everybody)\b",
    "an old word": r"\b(anew|befall\w*|reckon\w*|mend(s|ed|ing)?|beside|besides|shall|for ever)\b",
    "an old phrase": r"\b(but for|for want of|without more ado|be it|as ever)\b",
    "too at the end": r", too[.;:,)]",
    "no and a noun": r"(?<!there )\b(is|are|was|were) no (?!longer|more|less|further|farther)[a-z]",
}


def files():
    for pattern in PLAIN:
        for path in sorted(PROJECT.glob(pattern)):
            yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


def prose_of(source):
    """Yield each docstring and each block of comments, with a line number.

    The number is the line of the definition with the docstring, or the last line of the block.
    """
    for node in ast.walk(ast.parse(source)):
        documented = isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef))
        if documented and (text := ast.get_docstring(node)):
            yield getattr(node, "lineno", 1), text
    block, last = [], -1
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            if block and token.start[0] != last + 1:
                yield last, " ".join(block)
                block = []
            block.append(token.string.lstrip("# "))
            last = token.start[0]
    if block:
        yield last, " ".join(block)


def constructions_in(text):
    """Return the forbidden constructions in a text, without code between backticks."""
    text = " ".join(re.sub(r"``?[^`]*``?", "x", text).split())
    return {
        name: found[0]
        for name, pattern in FORBIDDEN.items()
        if (found := re.search(pattern, text, re.IGNORECASE))
    }


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("Whoever is late loses points.", 1),
        ("A page for who forks it, and for nobody else.", 2),
        ("Whom it does not reach is named; a student whom it reaches is not.", 1),
        ("It is no answer, too.", 2),
        ("Mend it anew, but for the last.", 2),
        ("There is no file any more; 5 is no more than 6.", 0),
        ("The name `nobody` belongs to a user.", 0),
        ("It may also be empty. Add two, too many.", 0),
    ],
)
def test_forbidden_constructions_are_found(text, count):
    assert len(constructions_in(text)) == count


def test_comments_and_docstrings_are_plain():
    read = list(files())
    assert len(read) > 30
    found = {
        f"{path.relative_to(PROJECT)}:{line}": constructions
        for path in read
        for line, text in prose_of(path.read_text("utf-8"))
        if (constructions := constructions_in(text))
    }
    assert found == {}
