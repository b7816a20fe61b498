"""MathJax and its fonts, from the package that brings them."""

from importlib import metadata

PACKAGE = "sphinx-mathjax-offline"
WANTED = ("tex-chtml.js", ".woff")


def files() -> dict[str, bytes]:
    """What a page with formulas loads, by its place in the site."""
    found = {}
    for path in metadata.files(PACKAGE):
        place = path.as_posix().partition("static/mathjax/")[2]
        if place and (place == WANTED[0] or place.endswith(WANTED[1])):
            found[f"_static/mathjax/{place}"] = path.locate().read_bytes()
    return found
