"""Notebooks in Colab, where each one runs without the course's files and with Colab's packages."""

import io
import json
import re
import subprocess
import sys
import tarfile

import nbformat
import pytest

from grader.course import build
from grader.course.lessons import all_lessons, stages
from grader.course.paths import PROJECT
from grader.course.standalone import make_standalone
from tests.colab import (
    MARK,
    archive_of,
    course_files,
    environment,
    missing_requirement,
    served,
)
from tests.notebook_runs import errors_of, errors_outside_checks, printed_text, run
from utils import colab
from utils.scene3d import opengl

REPOSITORY, REVISION = "owner/lab", "v1.2"
ARCHIVE = f"/{REPOSITORY}/archive/{REVISION}.tar.gz"
# The smallest course that the setup cell accepts.
COURSE = {
    "README.md": b"",
    "utils/__init__.py": b"def begin(number): print('Ready: a course.')",
    "utils/checks/__init__.py": b"",
    "data/cloud.txt": b"1 2 3\n",
    "solutions/x.py": b"",
}

only_like_colab = pytest.mark.skipif(bool(missing_requirement()), reason=missing_requirement())


def setup_cell(address):
    """Return the setup cell of a course that is published at `address`."""
    origin = build.Origin(address and f"{address}/{REPOSITORY}", REVISION)
    return build.common_cell("setup", all_lessons()[0], origin)


def run_setup(folder, address, in_colab=True):
    """Run the setup cell in `folder`; return its output and the last line of the error."""
    program = f"{MARK if in_colab else ''}\n{setup_cell(address)}"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True
    )
    assert done.stderr.count("\n") <= 6  # a message, not a long traceback
    return done.stdout.strip(), (done.stderr.strip().splitlines() or [""])[-1]


def names_in(folder):
    return sorted(path.name for path in folder.iterdir() if not path.name.startswith("."))


@only_like_colab
def test_setup_fetches_the_matching_version_once(tmp_path):
    with served({ARCHIVE: archive_of(COURSE)}) as (address, requests):
        assert run_setup(tmp_path, address) == ("Ready: a course.", "")
        assert run_setup(tmp_path, address) == ("Ready: a course.", "")
    assert requests == [ARCHIVE]
    assert names_in(tmp_path) == ["data", "utils"]
    assert run_setup(tmp_path, address) == ("Ready: a course.", "")  # does not need a connection


@only_like_colab
def test_setup_without_a_connection_suggests_a_fix(tmp_path):
    with served({ARCHIVE: archive_of(COURSE)}) as (address, requests):
        pass
    printed, problem = run_setup(tmp_path, address)
    assert printed == "" and "check the connection and run this cell again" in problem
    assert names_in(tmp_path) == []


@only_like_colab
@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_setup_removes_a_broken_download(tmp_path, share):
    pages = {ARCHIVE: archive_of(COURSE)}
    whole = pages[ARCHIVE]
    with served(pages) as (address, requests):
        pages[ARCHIVE] = whole[: int(share * len(whole))]
        assert "run this cell again" in run_setup(tmp_path, address)[1]
        assert names_in(tmp_path) == []
        pages[ARCHIVE] = whole
        assert run_setup(tmp_path, address) == ("Ready: a course.", "")


@only_like_colab
@pytest.mark.parametrize("path", ["utils/../../../evil.txt", "/../../evil.txt"])
def test_setup_writes_only_to_its_folder(tmp_path, path):
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    with served({ARCHIVE: archive_of(COURSE | {path: b""})}) as (address, requests):
        run_setup(folder, address)
    assert not list(tmp_path.rglob("evil.txt"))


@only_like_colab
def test_setup_does_not_follow_links_out_of_the_folder(tmp_path):
    folder, outside = tmp_path / "content", tmp_path / "outside"
    folder.mkdir()
    outside.mkdir()
    buffer = io.BytesIO()
    with tarfile.open(fileobj=buffer, mode="w:gz") as archive:
        link = tarfile.TarInfo("lab/utils/link")
        link.type, link.linkname = tarfile.SYMTYPE, str(outside)
        archive.addfile(link)
        archive.addfile(tarfile.TarInfo("lab/utils/link/evil.txt"))
    with served({ARCHIVE: buffer.getvalue()}) as (address, requests):
        run_setup(folder, address)
    assert names_in(outside) == []


@pytest.mark.parametrize("in_colab", [True, False])
@pytest.mark.parametrize("published", [True, False])
def test_setup_finds_the_course_in_a_parent_folder(tmp_path, in_colab, published):
    for path, content in COURSE.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_bytes(content)
    folder = tmp_path / "notebooks" / "stage"
    folder.mkdir(parents=True)
    with served({ARCHIVE: archive_of(COURSE)}) as (address, requests):
        result = run_setup(folder, address if published else "", in_colab)
    assert result == ("Ready: a course.", "") and requests == [] and names_in(folder) == []


@pytest.mark.parametrize(("published", "in_colab"), [(False, True), (False, False), (True, False)])
def test_setup_fetches_only_in_colab_and_with_an_address(tmp_path, published, in_colab):
    with served({ARCHIVE: archive_of(COURSE)}) as (address, requests):
        printed, problem = run_setup(tmp_path, address if published else "", in_colab)
    assert printed == "" and "unzip the whole course" in problem.lower()
    assert requests == [] and list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("address", ["", "https://github.com"])
def test_setup_is_short(address):
    assert len(setup_cell(address).splitlines()) <= 8


def test_badges_open_this_notebook_at_this_revision():
    lesson = all_lessons()[0]
    text = build.common_cell("badge", lesson, build.Origin("https://github.com/owner/lab", "v1.2"))
    path = f"notebooks/{lesson.stage}/{lesson.name}.ipynb"
    assert re.findall(r"\]\((https://(?:colab|mybinder)[^)]*)\)(?!\])", text) == [
        f"https://colab.research.google.com/github/owner/lab/blob/v1.2/{path}",
        f"https://mybinder.org/v2/gh/owner/lab/v1.2?urlpath=lab/tree/{path}",
    ]
    without = build.common_cell("badge", lesson, build.Origin("", "v1.2"))
    assert "http" not in without and "Colab" in without


@pytest.mark.parametrize(
    ("repository", "revision"),
    [
        ("github.com/owner/lab", "main"),
        ("https://github.com/owner", "main"),
        ("https://github.com/owner/lab; rm -r x", "main"),
        ("https://github.com/owner/lab", ""),
        ("https://github.com/owner/lab", "main; rm -r x"),
    ],
)
def test_the_error_about_an_invalid_origin_names_the_file(repository, revision):
    with pytest.raises(ValueError, match="pyproject.toml"):
        build.Origin(repository, revision)


def test_binder_and_vs_code_are_configured():
    requirements = PROJECT / ".binder" / "requirements.txt"
    included = requirements.read_text().split()[-1]
    assert (requirements.parent / included).resolve() == PROJECT / "requirements-3d.txt"
    runtime = (PROJECT / ".binder" / "runtime.txt").read_text().strip()
    assert runtime in ("python-3.11", "python-3.12", "python-3.13")
    extensions = json.loads((PROJECT / ".vscode" / "extensions.json").read_text())
    assert {"ms-python.python", "ms-toolsai.jupyter"} <= set(extensions["recommendations"])
    assert json.loads((PROJECT / ".vscode" / "settings.json").read_text())


def test_colab_gets_the_pyvista_of_the_requirements():
    pins = re.findall(r"^(\w+==\S+)", (PROJECT / "requirements-3d.txt").read_text(), re.M)
    assert set(colab.PYVISTA) <= set(pins)


def test_matplotlib_draws_in_colab_if_pyvista_cannot_be_installed(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "google.colab", None)
    monkeypatch.setattr(opengl.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(colab, "PYVISTA", ("pyvista==0.0.0",))
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    problem = opengl.problem.__wrapped__()
    assert problem.startswith("PyVista cannot be installed (ERROR: ")
    assert problem.endswith("), so matplotlib draws the scene.")
    assert "half a minute" in capsys.readouterr().out


@pytest.fixture(scope="session")
def environment_folder(pytestconfig):
    """Return the folder of an environment with Colab's package versions."""
    return environment(pytestconfig.cache.mkdir("colab"))


@pytest.fixture
def colab_kernel(environment_folder, monkeypatch):
    """Register the kernel "colab" with Jupyter, and prevent pip from installing packages.

    The environment is shared, and a notebook must also run without PyVista.
    """
    monkeypatch.setenv("JUPYTER_PATH", str(environment_folder))
    monkeypatch.setenv("PIP_NO_INDEX", "1")


@pytest.fixture(scope="session")
def course():
    """Serve a published course; yield its notebooks by path. They fetch all other files."""
    with served({ARCHIVE: archive_of(course_files())}) as (address, requests):
        yield build.build_all(build.Origin(f"{address}/{REPOSITORY}", REVISION))


def run_alone(text, folder):
    """Execute a notebook in an empty folder with Colab's packages, up to the first error."""
    return run(nbformat.reads(text.decode(), as_version=4), folder, kernel_name="colab")


@only_like_colab
@pytest.mark.colab
@pytest.mark.parametrize("stage", stages())
def test_a_solved_notebook_of_each_stage_fetches_the_course(stage, course, colab_kernel, tmp_path):
    lesson = next(lesson for lesson in all_lessons() if lesson.stage == stage)
    notebook = run_alone(course[lesson.solved], tmp_path)
    assert errors_of(notebook) == []
    assert names_in(tmp_path) == ["data", "utils"]
    assert "Ready:" in printed_text(notebook, "stdout")


# Code that blocks name look-ups and new connections, but not Jupyter's kernel on this machine.
NO_NETWORK = """
import socket
def unreachable(*anything, **more): raise OSError("no network")
socket.getaddrinfo = socket.gethostbyname = socket.create_connection = unreachable
"""


def run_without_network(text, folder):
    notebook = nbformat.reads(text.decode(), as_version=4)
    notebook.cells.insert(0, nbformat.v4.new_code_cell(NO_NETWORK))
    return run(notebook, folder, kernel_name="colab")


@only_like_colab
@pytest.mark.colab
def test_a_standalone_notebook_runs_in_colab_without_a_network(lesson, colab_kernel, tmp_path):
    notebook = run_without_network(make_standalone(lesson.solved.read_bytes()), tmp_path)
    assert errors_of(notebook) == []
    assert printed_text(notebook, "stderr") == ""
    assert "Everything this notebook needs is here." in printed_text(notebook, "stdout")
    assert "NumPy 2.1.3" in printed_text(notebook, "stdout")
    assert names_in(tmp_path) == []


@only_like_colab
@pytest.mark.colab
def test_an_untouched_standalone_notebook_runs_to_the_end(lesson, colab_kernel, tmp_path):
    notebook = run_without_network(make_standalone(lesson.released.read_bytes()), tmp_path)
    assert errors_outside_checks(notebook) == []


@only_like_colab
@pytest.mark.colab
def test_installing_pyvista_changes_no_colab_package(environment_folder, tmp_path):
    def in_colab(program):
        return subprocess.run(
            [environment_folder / "bin" / "python", "-c", program],
            cwd=PROJECT,
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    command = json.loads(
        in_colab(
            "import json; from pathlib import Path; from utils import colab;"
            f"print(json.dumps(colab.pip_command(Path({str(tmp_path)!r}))))"
        )
    )
    report = subprocess.run(
        [*command, "--dry-run", "--report", "-"], capture_output=True, text=True, check=True
    ).stdout
    new = {entry["metadata"]["name"].lower() for entry in json.loads(report)["install"]}
    installed = set(
        in_colab(
            "from importlib import metadata;"
            "print(*(found.name.lower() for found in metadata.distributions()))"
        ).split()
    )
    assert {"pyvista", "vtk"} <= new and {"numpy", "ipython"} <= installed
    assert not new & installed
