"""MathJax and its fonts, from the package `sphinx-mathjax-offline`."""

from importlib import metadata

PACKAGE = "sphinx-mathjax-offline"
WANTED = ("tex-chtml.js", ".woff")


def files() -> dict[str, bytes]:
    """Return the content of each file that pages with formulas load, by path in the site."""
    contents = {}
    for path in metadata.files(PACKAGE):
        place = path.as_posix().partition("static/mathjax/")[2]
        if place and (place == WANTED[0] or place.endswith(WANTED[1])):
            contents[f"_static/mathjax/{place}"] = path.locate().read_bytes()
    return contents
