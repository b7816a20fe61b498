"""Releases for students: zips, notebooks through nbgrader, and solutions."""

import dataclasses
import io
import json
import re
import stat
import subprocess
import sys
import zipfile
from datetime import UTC, datetime, timedelta
from pathlib import Path
from zoneinfo import ZoneInfo

import nbclient
import nbformat
import pytest
from nbgrader.auth import Authenticator
from nbgrader.coursedir import CourseDirectory
from nbgrader.exchange import ExchangeFactory
from traitlets.config import Config

from grader import cli, commands
from grader.course import release, solutions, standalone
from grader.course.archives import make_zip
from grader.course.deadlines import Deadlines, DueDates
from grader.course.lessons import all_lessons, find_lesson, stages
from grader.course.nbgrader_settings import configure
from grader.course.paths import PROJECT, Course
from grader.lms.gradebook import open_gradebook
from grader.site import runs, widget_states
from grader.site.solution import as_notebook
from tests.notebook_runs import errors_of, run
from tests.required_packages import distributions, normal, own_pins, third_party_imports

pytestmark = pytest.mark.slow

STAGE = "stage3_obstacles"
LESSON = find_lesson("08_bounding_boxes")
NOW = datetime(2026, 10, 12, 12, tzinfo=UTC)
HOUR = timedelta(hours=1)


@pytest.fixture(scope="module")
def zips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("released")
    assert cli.main(["release", "--to", str(folder)]) == 0
    return folder


def names_in(path):
    with zipfile.ZipFile(path) as archive:
        return archive.namelist()


# ---- zips ---------------------------------------------------------------------------------------


def test_a_zip_does_not_depend_on_the_order_of_files():
    files = {"b/two.txt": b"2" * 999, "a.txt": b"1", "b/one.txt": b""}
    packed = make_zip(files)
    assert packed == make_zip(dict(reversed(files.items())))
    with zipfile.ZipFile(io.BytesIO(packed)) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["a.txt", "b/one.txt", "b/two.txt"]
        assert {name: archive.read(name) for name in files} == files
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert stat.S_IMODE(entry.external_attr >> 16) == 0o644


def test_each_stage_has_a_zip_with_its_notebooks(zips):
    assert sorted(path.name for path in zips.iterdir()) == [f"{stage}.zip" for stage in stages()]
    for stage in stages():
        names = [lesson.name for lesson in all_lessons() if lesson.stage == stage]
        notebooks = [name for name in names_in(zips / f"{stage}.zip") if name.endswith(".ipynb")]
        assert notebooks == [f"lidar_obstacle_lab/notebooks/{stage}/{name}.ipynb" for name in names]


def test_a_zip_has_the_same_bytes_when_written_again(zips, tmp_path):
    assert cli.main(["release", STAGE, "--to", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == [f"{STAGE}.zip"]
    again = (tmp_path / f"{STAGE}.zip").read_bytes()
    assert again == (zips / f"{STAGE}.zip").read_bytes()


def test_a_zip_contains_only_files_that_students_need(zips):
    names = [name.split("/", 1) for name in names_in(zips / f"{STAGE}.zip")]
    assert {first for first, _ in names} == {"lidar_obstacle_lab"}
    assert {rest.split("/")[0] for _, rest in names} == {
        "LICENSE", "README.md", "constraints.txt", "data", "notebooks", "requirements.txt", "utils",
    }  # fmt: skip
    inside = {rest for _, rest in names}
    assert {"data/cloud.txt", "data/cloud_truth.npz", "utils/lent/lesson_08.json"} <= inside
    code = {
        path.relative_to(PROJECT).as_posix()
        for path in (PROJECT / "utils").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert code == {name for name in inside if name.startswith("utils/")}


def test_student_requirements_cover_all_imports_of_the_notebooks():
    text = release.student_requirements()
    pins = dict(re.findall(r"^([\w.-]+)==(\S+)$", text, re.M))
    assert pins.items() <= own_pins("requirements.txt").items()
    needed = {
        normal(distributions()[package][0])
        for file, packages in third_party_imports().items()
        if file.startswith("utils/")
        for package in packages
        if package in distributions()
    }
    # Packages for films, for windows with 3D scenes and for more formats are optional.
    extra = {"vtk", *own_pins("requirements-3d.txt"), *own_pins("requirements-formats.txt")}
    assert needed - extra <= pins.keys()
    assert {"jupyterlab", "ipykernel"} <= pins.keys()


def test_a_notebook_that_reveals_a_solution_is_not_released(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(standalone, "find_leaks", lambda *texts: ["answer = 42"])
    assert cli.main(["release", STAGE, "--to", str(tmp_path)]) == 1
    assert "reveals a line of the solution: 'answer = 42'" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def first_cells(path, count):
    """Return a notebook that contains only its first code cells."""
    notebook = nbformat.read(path, as_version=4)
    notebook.cells = [cell for cell in notebook.cells if cell.cell_type == "code"][:count]
    return notebook


def test_a_zip_runs_in_any_folder(zips, tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    with zipfile.ZipFile(zips / f"{STAGE}.zip") as archive:
        archive.extractall(tmp_path)
    path = tmp_path / "lidar_obstacle_lab" / "notebooks" / STAGE / f"{LESSON.name}.ipynb"
    notebook = run(first_cells(path, 2), path.parent)
    assert errors_of(notebook) == []
    assert notebook.cells[0].outputs[0].text.startswith("Ready: ")


# ---- nbgrader -----------------------------------------------------------------------------------


def exchange(root, folder):
    """Return nbgrader's exchange factory, and its arguments for a course's or student's folder."""
    config = configure(Config(), folder)
    config.Exchange.root = str(root)
    config.CourseDirectory.assignment_id = STAGE
    parts = {"coursedir": CourseDirectory(config=config), "authenticator": Authenticator()}
    return ExchangeFactory(config=config), parts


@pytest.fixture
def fetched_stage(tmp_path, monkeypatch):
    """Return the folder of a fetched stage, to which the instructor has added a notebook."""
    course, student = tmp_path / "course", tmp_path / "student"
    source = course / "notebooks" / STAGE
    source.mkdir(parents=True)
    student.mkdir()
    source.joinpath(LESSON.released.name).write_bytes(LESSON.released.read_bytes())
    nbformat.write(nbformat.v4.new_notebook(), source / "survey.ipynb")
    for folder, app in ((course, "ReleaseAssignment"), (student, "FetchAssignment")):
        monkeypatch.chdir(folder)
        factory, parts = exchange(tmp_path / "exchange", folder)
        getattr(factory, app)(**parts).start()
    return student / STAGE


def test_a_fetched_notebook_needs_no_other_files(fetched_stage):
    assert sorted(path.name for path in fetched_stage.iterdir()) == [
        LESSON.released.name, "survey.ipynb",
    ]  # fmt: skip
    cell = first_cells(fetched_stage / LESSON.released.name, 1).cells[0].source
    done = subprocess.run(
        [sys.executable, "-"], input=cell, cwd=fetched_stage, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "Everything this notebook needs is here." in done.stdout


def test_only_badge_and_setup_cells_differ_from_the_released_notebook(fetched_stage):
    fetched_cells = json.loads((fetched_stage / LESSON.released.name).read_text("utf-8"))["cells"]
    released = json.loads(LESSON.released.read_text("utf-8"))["cells"]
    changed = [
        cell["metadata"].get("tags", [])
        for cell, before in zip(fetched_cells, released, strict=True)
        if re.sub(r"\]\([./\w]*?(\w+\.ipynb)\)", r"](\1)", "".join(before["source"]))
        != "".join(cell["source"])
    ]
    assert changed == [["badge"], ["setup"]]
    survey = nbformat.read(fetched_stage / "survey.ipynb", as_version=4)
    assert survey.cells == []


# ---- solutions ----------------------------------------------------------------------------------


def deadlines(**dates):
    return Deadlines({STAGE: DueDates(**dates)}, zone=ZoneInfo("Europe/Berlin"))


def test_the_message_lists_the_students_who_may_still_submit():
    late, over = NOW + HOUR, NOW - HOUR
    assert solutions.reason_to_withhold(deadlines(due=over), STAGE, NOW, {}) == ""
    message = solutions.reason_to_withhold(
        deadlines(due=over, sections={"A": over, "B": late}, students={"anna": late, "bo": over}),
        STAGE,
        NOW,
        {"": late, "bo": late},  # dates in the file take precedence over these
    )
    assert message == (
        "stage3_obstacles is still open for section B until 12 October 2026, 15:00 CEST, "
        "anna until 12 October 2026, 15:00 CEST."
    )
    assert "for everyone until" in solutions.reason_to_withhold(deadlines(due=late), STAGE, NOW, {})
    granted = solutions.reason_to_withhold(
        deadlines(due=over), STAGE, NOW, {"cy": late, "dee": over}
    )
    assert granted == "stage3_obstacles is still open for cy until 12 October 2026, 15:00 CEST."


def test_solutions_wait_for_lessons_that_are_due_later_than_their_stage():
    late, over = NOW + HOUR, NOW - HOUR
    lessons = [lesson.name for lesson in all_lessons() if lesson.stage == STAGE]
    own = {lessons[0]: DueDates(over), lessons[-1]: DueDates(late, {"B": late}, {"bo": over})}
    dates = dataclasses.replace(deadlines(due=over), lessons=own)
    assert solutions.reason_to_withhold(dates, STAGE, NOW, {}) == (
        f"stage3_obstacles is still open for {lessons[-1]} until 12 October 2026, 15:00 CEST, "
        f"section B in {lessons[-1]} until 12 October 2026, 15:00 CEST."
    )
    own = dict.fromkeys(lessons, DueDates(over))
    assert solutions.reason_to_withhold(Deadlines({}, lessons=own), STAGE, NOW, {}) == ""
    del own[lessons[1]]
    message = solutions.reason_to_withhold(Deadlines({}, lessons=own), STAGE, NOW, {})
    assert "its due date is not known" in message


def test_a_stage_without_a_due_date_may_still_be_open():
    late, over = NOW + HOUR, NOW - HOUR
    for dates in (Deadlines({}), deadlines(excused=frozenset({"anna"}))):
        assert "its due date is not known" in solutions.reason_to_withhold(dates, STAGE, NOW, {})
        assert solutions.reason_to_withhold(dates, STAGE, NOW, {"": over, "anna": over}) == ""
        assert "for everyone until" in solutions.reason_to_withhold(dates, STAGE, NOW, {"": late})
        assert "for anna until" in solutions.reason_to_withhold(
            dates, STAGE, NOW, {"": over, "anna": late}
        )


@pytest.fixture
def course(tmp_path, monkeypatch):
    """Return the folder of an empty course; solutions are not run and pages are not rendered."""
    monkeypatch.setattr(
        runs, "executed_notebook", lambda lesson, folder, extra: lesson.solved.read_bytes()
    )
    monkeypatch.setattr(solutions, "render_page", lambda notebook, lesson: b"page")
    monkeypatch.setattr(commands, "Course", lambda: Course(tmp_path))
    return tmp_path


def write_extension(folder, until):
    (folder / "deadlines.toml").write_text(
        f"[{STAGE}]\ndue = 2026-01-31T12:00:00\n[{STAGE}.students]\nanna = {until}\n", "utf-8"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", ""),
        (
            'lessons = ["06"]\n',
            "but do not count according to deadlines.toml: 07_filter_by_distance, 08_bound",
        ),
        ('lessons = ["06", "07", "08", "09"]\n', ""),
    ],
)
def test_released_lessons_that_do_not_count_are_listed(course, capsys, text, message):
    (course / "deadlines.toml").write_text(f"[{STAGE}]\n{text}", "utf-8")
    assert cli.main(["release", STAGE, "--to", str(course / "out")]) == 0
    output = capsys.readouterr().out
    assert message in output and ("deadlines" in output) == bool(message)


def test_solutions_wait_for_an_extension_unless_forced(course, capsys):
    write_extension(course, "2999-01-31T12:00:00")
    call = ["release", "--solutions", STAGE, "--to", str(course / "out")]
    assert cli.main(call) == 1
    message = capsys.readouterr().err
    assert "anna until 31 January 2999, 12:00" in message and "--anyway" in message
    assert not (course / "out").exists()
    assert cli.main([*call, "--anyway"]) == 0
    assert [path.name for path in (course / "out").iterdir()] == [f"{STAGE}_solutions.zip"]


def test_solutions_are_released_as_notebooks_and_pages_after_the_last_extension(course):
    write_extension(course, "2026-02-07T12:00:00")
    assert cli.main(["release", "--solutions", STAGE, "--to", str(course / "out")]) == 0
    names = names_in(course / "out" / f"{STAGE}_solutions.zip")
    lessons = [lesson.name for lesson in all_lessons() if lesson.stage == STAGE]
    folder = f"lidar_obstacle_lab/solutions/{STAGE}"
    assert names == [f"{folder}/{name}.{kind}" for name in lessons for kind in ("html", "ipynb")]


@pytest.mark.parametrize("dates", ["", f'[{STAGE}.students]\nanna = "excused"\n'])
def test_solutions_without_a_due_date_wait_unless_forced(course, capsys, dates):
    (course / "deadlines.toml").write_text(dates, "utf-8")
    call = ["release", "--solutions", STAGE, "--to", str(course / "out")]
    assert cli.main(call) == 1
    message = capsys.readouterr().err
    assert "stage3_obstacles may still be open, because its due date is not known" in message
    assert not (course / "out").exists() and not (course / "gradebook.db").exists()
    assert cli.main([*call, "--anyway"]) == 0


def test_due_dates_in_the_gradebook_also_count_for_solutions(course, capsys):
    call = ["release", "--solutions", STAGE, "--to", str(course / "out")]
    with open_gradebook(Course(course)) as book:
        book.add_assignment(STAGE, duedate="2999-01-31 12:00:00 UTC")
        book.add_student("anna")
        book.add_submission(STAGE, "anna")
    assert cli.main(call) == 1
    assert "for everyone until 31 January 2999" in capsys.readouterr().err
    (course / "deadlines.toml").write_text(f"[{STAGE}]\ndue = 2026-01-31T12:00:00Z\n", "utf-8")
    assert cli.main(call) == 0  # the file takes precedence over the gradebook
    capsys.readouterr()
    with open_gradebook(Course(course)) as book:
        book.grant_extension(STAGE, "anna", weeks=52_000)
    assert cli.main(call) == 1
    assert "is still open for anna until" in capsys.readouterr().err
    write_extension(course, "2026-02-07T12:00:00")  # now the file also has Anna's date
    assert cli.main(call) == 0


def test_a_solution_page_loads_no_other_files():
    lesson = find_lesson("02_ransac_line")
    page = solutions.render_page(lesson.solved.read_bytes(), lesson).decode()
    assert "<script" not in page and "<link" not in page and "@import" not in page
    assert set(re.findall(r'src="([a-z]+):', page)) == {"data"}
    without_code = re.sub(r"<(style|pre)\b.*?</\1>", "", page, flags=re.S)
    assert page.count("<math ") >= 5 and "$" not in without_code


def tiny_lesson(tmp_path, monkeypatch, source):
    """Return a lesson whose solution has a setup cell and one other cell."""
    setup = nbformat.v4.new_code_cell("", metadata={"tags": ["setup"]})
    notebook = nbformat.v4.new_notebook(cells=[setup, nbformat.v4.new_code_cell(source)])
    path = tmp_path / "tiny.ipynb"
    nbformat.write(notebook, path)
    monkeypatch.setattr(solutions, "course_tools", lambda: {"utils/one.py": b"1"})

    class Tiny:
        name, solved, released = "tiny", path, path

    return Tiny


def test_a_solution_is_run_once_and_shows_its_output(tmp_path, monkeypatch):
    marked = "### BEGIN SOLUTION\nprint(6 * 7)\n### END SOLUTION"
    lesson = tiny_lesson(tmp_path, monkeypatch, marked)
    first = solutions.executed_notebook(lesson, tmp_path / "kept", "")
    _, cell = nbformat.reads(first.decode(), as_version=4).cells
    assert (cell.source, cell.outputs[0].text) == ("print(6 * 7)", "42\n")
    monkeypatch.setattr(solutions, "_run_solved_notebook", lambda lesson, before: b"run again")
    assert solutions.executed_notebook(lesson, tmp_path / "kept", "") == first
    monkeypatch.setattr(solutions, "course_tools", lambda: {"utils/one.py": b"2"})
    assert solutions.executed_notebook(lesson, tmp_path / "kept", "") == b"run again"
    assert len(list((tmp_path / "kept").iterdir())) == 1  # the outdated result is deleted


def test_the_site_runs_solutions_and_keeps_them(tmp_path, monkeypatch):
    lesson = tiny_lesson(tmp_path, monkeypatch, "6 * 7")
    monkeypatch.setattr(runs, "CACHE", tmp_path / "kept")
    monkeypatch.setattr(runs, "recorder_code", lambda: "")
    (ran,) = runs.solved_runs([lesson], 1, lambda *_: None).values()
    (output,) = nbformat.reads(ran.decode(), as_version=4).cells[-1].outputs
    assert output.data["text/plain"] == "42"
    assert len(list((tmp_path / "kept").iterdir())) == 1


def test_a_solution_that_fails_is_reported(tmp_path, monkeypatch):
    lesson = tiny_lesson(tmp_path, monkeypatch, "1 / 0")
    with pytest.raises(standalone.ReleaseError, match=r"(?s)tiny: .*ZeroDivisionError"):
        solutions.executed_notebook(lesson, tmp_path / "kept", "")
    assert not (tmp_path / "kept").exists()


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (nbclient.exceptions.CellTimeoutError("slow"), r"tiny: .* more than 300 seconds"),
        (nbclient.exceptions.DeadKernelError("gone"), r"tiny: .* Python ended"),
    ],
)
def test_a_solution_that_hangs_or_dies_is_reported(tmp_path, monkeypatch, error, message):
    def execute(client):
        raise error

    monkeypatch.setattr(nbclient.NotebookClient, "execute", execute)
    with pytest.raises(standalone.ReleaseError, match=message):
        solutions.executed_notebook(tiny_lesson(tmp_path, monkeypatch, "1"), tmp_path / "kept", "")
    assert not (tmp_path / "kept").exists()


def test_solutions_run_for_the_site_become_portable_notebooks():
    def output(kind, content):
        data = {kind: content, "text/plain": "for a page"}
        return nbformat.v4.new_output("display_data", data=data)

    def picture(content):
        return nbformat.v4.new_output("display_data", data={"image/png": content})

    answer = {"question": "How many?", "answer": "7 <m>", "why": "Because."}
    cells = [
        [output(widget_states.QUESTION_TYPE, {"question": "How many?"})],
        [nbformat.v4.new_output("stream", text="said"), output(widget_states.ANSWER_TYPE, answer)],
        [
            *(output(widget_states.POSITION_TYPE, {"all": [["height", "3"]]}), picture("one")),
            *(
                output(widget_states.POSITION_TYPE, {"slider": "height", "value": "4"}),
                picture("two"),
            ),
        ],
    ]
    notebook = nbformat.v4.new_notebook(
        cells=[nbformat.v4.new_code_cell("1", outputs=outputs) for outputs in cells]
    )
    converted = nbformat.reads(as_notebook(nbformat.writes(notebook).encode()), as_version=4)
    question, (printed, comparison), (figure,) = (cell.outputs for cell in converted.cells)
    assert question == [] and printed.text == "said" and figure.data == {"image/png": "one"}
    assert comparison.data["text/plain"] == "How many?\nAnswer: 7 <m>\nBecause."
    assert "Answer: <b>7 &lt;m&gt;</b>" in comparison.data["text/html"]


def test_the_student_readme_names_only_released_files(zips):
    text = Path(PROJECT / "solutions" / "student_readme.md").read_text("utf-8")
    named = set(re.findall(r"`([\w/]+(?:\.\w+)?/?)`", text))
    inside = {name.removeprefix("lidar_obstacle_lab/") for name in names_in(zips / f"{STAGE}.zip")}
    folders = {f"{name.split('/')[0]}/" for name in inside if "/" in name}
    files = {name for name in named if name.endswith("/") or "." in name or name.isupper()}
    assert files and files <= inside | folders
