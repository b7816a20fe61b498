"""MathJax and its fonts, from the package `sphinx-mathjax-offline`."""

from importlib import metadata

PACKAGE = "sphinx-mathjax-offline"
FILE_ENDINGS = ("tex-chtml.js", ".woff")


def mathjax_files() -> dict[str, bytes]:
    """Return the content of each file that pages with formulas load, by path in the site."""
    contents = {}
    for path in metadata.files(PACKAGE):
        place = path.as_posix().partition("static/mathjax/")[2]
        if place and (place == FILE_ENDINGS[0] or place.endswith(FILE_ENDINGS[1])):
            contents[f"_static/mathjax/{place}"] = path.locate().read_bytes()
    return contents
