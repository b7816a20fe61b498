"""The website's pages show outputs, do not reveal solutions, and load nothing from other hosts."""

import base64
import dataclasses
import html
import io
import json
import re
import struct
from types import SimpleNamespace

import ipywidgets
import matplotlib.pyplot as plt
import nbformat
import numpy as np
import pytest
from nbformat.v4 import new_code_cell, new_output
from PIL import Image

from docs.front_page import panel as playground
from grader import cli
from grader.course.build import Origin, read_origin
from grader.course.lessons import all_lessons, every_lesson, optional_lessons
from grader.course.paths import PROJECT
from grader.course.solutions import remove_volatile_data
from grader.site import (
    builder,
    front_page,
    glossary,
    guides,
    runs,
    sections,
    sharing,
    site_checks,
    widget_states,
)
from grader.site.errors import SiteError
from grader.site.films import film_of
from grader.site.html_outputs import html_of, key_of, page_outputs
from grader.site.lesson import links_of, page_of
from grader.site.pictures import Pictures
from tests import class_pictures
from tests.notebook_runs import errors_of, run
from tests.site_notebooks import (
    ANSWER,
    CALL,
    LESSON,
    QUESTION,
    displayed_output,
    positions,
    scene,
    secrets,
    solved_notebooks,
)
from utils.scene3d import CAMERAS, Scene, viewer

PUBLIC = Origin("https://github.com/anna/lidar", "v1")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site") / "pages"
    builder.write_site(folder, solved_notebooks(), PUBLIC)
    return folder


def text_of(path):
    """Return the text of a page without tags, independently of the parser in `site_checks`."""
    plain = re.sub(r"<(script|style)\b.*?</\1>", "", path.read_text("utf-8"), flags=re.S)
    return html.unescape(re.sub(r"<[^>]+>", "", plain))


# ---- outputs of cells ---------------------------------------------------------------------------


def test_a_slider_becomes_pictures_at_some_positions_with_labels():
    pictures = Pictures()
    (output,) = page_outputs([*positions()], pictures)
    page = output.data["text/html"]
    assert [*map(float, re.findall(r"<label [^>]*>(\S+)</label>", page))] == [-2.2, -1.2, 0.6]
    assert re.findall(r'class="at-(\d)" checked', page) == ["0"], (
        "the lesson's value is shown first"
    )
    assert len(pictures.files) == 3
    assert page.count('class="position ') == 3
    assert "<pre>at 0.6 &lt;m&gt;\n</pre>" in page
    assert 'alt="In "red""' in html.unescape(page) and 'width="30" height="20"' in page


def test_a_page_knows_how_to_call_the_function_of_a_slider():
    notebook = nbformat.reads(
        page_of(LESSON, solved_notebooks()[LESSON], "", Pictures()).decode(), as_version=4
    )
    moved = [
        (cell.id, re.findall("data-call='(.*?)'", output.data["text/html"]))
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if "fieldset" in output.get("data", {}).get("text/html", "")
    ]
    ((name, (call,)),) = moved
    assert json.loads(html.unescape(call)) == CALL
    tagged = [
        cell.id for cell in notebook.cells if f"sliders-{name}" in cell.metadata.get("tags", ())
    ]
    assert tagged == [name], "the script finds the cell by its tag"


def test_only_a_function_of_the_notebook_can_be_called(monkeypatch):
    shown = []
    monkeypatch.setattr(widget_states, "_display", lambda kind, about, text: shown.append(about))

    def draw(rounds, level):
        pass

    for module in ("utils.replays.player", "__main__"):
        draw.__module__ = module
        widget_states.interact(
            rounds=ipywidgets.SelectionSlider(options=[10, 20, 500], value=20),
            level=ipywidgets.FloatSlider(value=1, min=0.9, max=1.2, step=0.1, description="z (m)"),
        )(draw)
    ours, theirs = shown[: len(shown) // 2], shown[len(shown) // 2 :]
    assert not any("call" in about for about in ours)
    assert theirs[0].pop("call") == {
        "name": "draw",
        "parameters": [
            {"name": "rounds", "title": "rounds", "values": ["10", "20", "500"], "start": 1},
            {"name": "level", "title": "z (m)", "values": ["0.9", "1.0", "1.1", "1.2"], "start": 1},
        ],
    }
    assert ours == theirs, "the positions are the same"


def test_several_sliders_share_one_choice():
    own = {widget_states.POSITION_TYPE: {"all": [["beams", "32"], ["step", "0.8"]]}}
    moved = [
        {widget_states.POSITION_TYPE: {"slider": title, "value": value}}
        for title, value in (("beams", "4"), ("step", "2.4"), ("step", "6"))
    ]
    (output,) = page_outputs([displayed_output(data) for data in (own, *moved)], Pictures())
    page = output.data["text/html"]
    assert re.findall(r"<label [^>]*>(.+?)</label>", page) == ["as in this lesson", "4", "2.4", "6"]
    assert len(set(re.findall(r'name="(\w+)"', page))) == 1
    ids = re.findall(r'id="([\w-]+)"', page)
    assert len(ids) == len(set(ids)) == 4


def test_a_question_becomes_a_field_with_a_folded_answer():
    question = html_of(displayed_output({widget_states.QUESTION_TYPE: QUESTION}), Pictures())
    answer = html_of(displayed_output({widget_states.ANSWER_TYPE: ANSWER}), Pictures())
    assert '<input type="range" min="0" max="10" step="1"' in question
    key = f'data-question="{key_of("How many?")}"'
    assert key in question and key in answer, "the page can connect the guess with the answer"
    assert answer.startswith("<details") and " open" not in answer.partition(">")[0]
    assert "Because 3 &lt; 4." in answer
    choices = QUESTION | {"choices": ["a < b", "b < a"]}
    radio = html_of(displayed_output({widget_states.QUESTION_TYPE: choices}), Pictures())
    assert radio.count('type="radio"') == 2 and "a &lt; b" in radio


def test_a_scene_becomes_a_separate_page_that_loads_lazily():
    pictures = Pictures()
    page = html_of(displayed_output(scene()), pictures)
    assert "srcdoc" not in page and "base64" not in page
    assert re.search(r'<iframe class="scene" src="\.\./_static/shown/\w+\.html" title="A ', page)
    assert 'loading="lazy"' in page
    (view,) = (file for place, file in pictures.files.items() if place.endswith(".html"))
    assert view.lstrip().lower().startswith(b"<!doctype html>")
    instead = html.unescape(page.partition("<iframe")[0])
    assert instead.startswith('<div><div class="still"><img ')
    assert page.endswith("</iframe></div>"), "a scene hides the element that follows it"
    assert 'alt="A "corner" in space"' in instead, "on paper, a picture is shown"


def test_a_scene_on_a_page_has_every_point_of_the_scan(monkeypatch):
    monkeypatch.setattr(viewer, "MAX_POINTS", widget_states.MAX_POINTS)
    scan = np.loadtxt(PROJECT / "data" / "cloud.txt")
    page = viewer.page(Scene().add_cloud(scan, colour="#0072B2"), CAMERAS["XY"], "")
    content = json.loads(re.search('id="scene">(.*?)</script>', page)[1])
    (part,) = content["points"]
    steps = np.array([*struct.iter_unpack("<3H", base64.b64decode(part["xyz"]))])
    points = part["low"] + steps * part["step"]
    assert points.shape == (len(scan), 3)
    assert np.abs(points - scan[:, :3]).max() < 0.005
    assert content["note"] == "" and len(page) < 1_500_000


def test_text_that_a_progress_bar_overwrote_is_not_shown():
    (output,) = page_outputs(
        [new_output("stream", name="stdout", text="a\n1/2\r2/2\nb\r\n")], Pictures()
    )
    assert output.text == "a\n2/2\nb\r\n"


# ---- widgets and figures ------------------------------------------------------------------------


def values_of(sliders):
    return [values for _, values in widget_states.positions(sliders)]


def test_positions_are_values_of_the_slider_with_its_initial_value_first():
    slider = ipywidgets.FloatSlider(value=0.5, min=0.1, max=2.5, step=0.1)
    threshold = [values["threshold"] for values in values_of({"threshold": slider})]
    assert threshold[0] == 0.5 and threshold[1] == 0.1 and threshold[-1] == 2.5
    assert len(set(threshold)) == 5
    assert all(value * 10 == pytest.approx(round(value * 10)) for value in threshold)


def test_only_one_slider_moves_at_a_time():
    sliders = {
        "rounds": ipywidgets.SelectionSlider(options=[10, 20, 500], value=20),
        "seed": ipywidgets.IntSlider(value=0, min=0, max=9),
        "level": ipywidgets.FloatSlider(value=1, min=0, max=2, step=0.5),
    }
    found = values_of(sliders)
    own = {"rounds": 20, "seed": 0, "level": 1.0}
    assert found[0] == own
    moved = [{name: v for name, v in values.items() if v != own[name]} for values in found[1:]]
    assert [len(values) for values in moved] == [1] * 6
    assert [values["rounds"] for values in moved if "rounds" in values] == [10, 500]
    assert all(isinstance(values["seed"], int) for values in found)


def test_the_description_of_a_figure_has_its_titles_axes_and_legend():
    figure, axes = plt.subplots()
    axes.plot([1, 2], label="n²: $n^2$")
    axes.set_title("Left", loc="left")
    axes.set_xlabel("x, forward (m)")
    axes.legend()
    message = widget_states.describe_figure(figure)
    plt.close(figure)
    assert all(word in message for word in ("Left", "x, forward (m)", "n²: n^2"))
    assert "$" not in message


@pytest.mark.slow
def test_a_recorded_notebook_shows_data_instead_of_widgets():
    setup = f"import sys; sys.path.insert(0, {str(PROJECT)!r})"
    lesson = """
from ipywidgets import IntSlider, interact
from utils import predict
import matplotlib.pyplot as plt
guess = predict("How many?", between=(0, 10), unit="m")
@interact(n=IntSlider(value=3, min=1, max=9, description="count"))
def show(n):
    plt.figure().suptitle(f"{n} things")
    plt.plot([n])
    plt.show()
guess.compare(7, "So it is.")
from utils.by_hand import Drawing, drag_points
drag_points(lambda points: Drawing("Two points"), [[0, 0], [1, 1]], limits=(0, 1, 0, 1))
from utils.scene3d import viewer
print(viewer.MAX_POINTS)
print(sorted(name for name in globals() if "record" in name or name == "np"))
"""
    sources = (setup, runs.recorder_code(), lesson)
    notebook = nbformat.v4.new_notebook(cells=[*map(new_code_cell, sources)])
    run(notebook, PROJECT)
    assert not errors_of(notebook)
    outputs = notebook.cells[2].outputs
    kinds = [max(output.get("data", {}).keys() - {"text/plain"}, default="") for output in outputs]
    question, *between, answer, drawing, note, _ = kinds
    assert (question, answer) == (widget_states.QUESTION_TYPE, widget_states.ANSWER_TYPE)
    assert between == [widget_states.POSITION_TYPE, "image/png"] * 5
    assert (drawing, note) == ("image/png", "text/html"), "points do not move on a page"
    assert "Two points" in outputs[-3].metadata["image/png"]["alt"]
    assert outputs[-4].data[widget_states.ANSWER_TYPE] == {
        "question": "How many?",
        "answer": "7 m",
        "why": "So it is.",
    }
    assert outputs[2].metadata["image/png"]["alt"] == "Figure. 3 things."
    assert outputs[1].data[widget_states.POSITION_TYPE]["call"]["name"] == "show"
    most, names = outputs[-1].text.split("\n", 1)
    assert int(most) == widget_states.MAX_POINTS, "a scene on a page has all points"
    assert names == "[]\n", "the notebook has no additional names"


# ---- pages --------------------------------------------------------------------------------------


def test_every_glossary_link_of_a_lesson_has_an_entry():
    for lesson in all_lessons():
        linked = glossary.link_terms(lesson.released.read_text("utf-8"))
        assert "{term}" in linked and "(../words.md)" not in linked, lesson.name


FILMED = [lesson for lesson in all_lessons() if (lesson.folder / "film.toml").exists()]


def test_each_stage_with_a_drive_has_a_film_on_a_page():
    assert {lesson.stage for lesson in FILMED} == {
        "stage2_clustering",
        "stage3_obstacles",
        "stage4_realtime",
    }


@pytest.mark.parametrize("filmed", FILMED, ids=lambda lesson: lesson.name)
def test_a_film_loads_only_when_a_reader_plays_it(filmed):
    pictures = Pictures()
    page = nbformat.reads(page_of(filmed, filmed.solved.read_bytes(), "", pictures), as_version=4)
    (number,) = (n for n, cell in enumerate(page.cells) if "<video" in cell.source)
    assert page.cells[number - 1].cell_type == "code"
    (video,) = re.findall(r"<video (.+?)></video>", page.cells[number].source)
    assert "controls" in video and 'preload="none"' in video and "autoplay" not in video
    attributes = dict(re.findall(r'([\w-]+)="(.*?)"', video))
    film, poster = (pictures.files[attributes[name][3:]] for name in ("src", "poster"))
    assert len(film) + len(poster) < 1_500_000 and film[4:8] == b"ftyp"
    with Image.open(io.BytesIO(poster)) as still:
        assert still.size == (int(attributes["width"]), int(attributes["height"]))
    assert len(attributes["aria-label"]) > 60


def test_a_film_without_its_section_stops_the_build(monkeypatch):
    wrong = dataclasses.replace(film_of(FILMED[0]), below="No such section")
    monkeypatch.setattr("grader.site.lesson.film_of", lambda lesson: wrong)
    with pytest.raises(SiteError, match="No such section"):
        page_of(FILMED[0], FILMED[0].solved.read_bytes(), "", Pictures())


def test_a_cell_without_a_counterpart_stops_the_build():
    notebook = nbformat.read(LESSON.solved, as_version=4)
    lost = notebook.cells.pop(5).id
    with pytest.raises(SiteError, match=lost):
        page_of(LESSON, nbformat.writes(notebook).encode(), "", Pictures())


def test_a_page_links_to_colab_if_the_repository_is_public():
    assert links_of(LESSON, Origin("", "main")).count("<a ") == 1
    there = links_of(LESSON, PUBLIC)
    assert f"/github/anna/lidar/blob/v1/notebooks/{LESSON.stage}/{LESSON.name}.ipynb" in there
    assert "https://github.com/anna/lidar/issues/new" in there


def test_the_page_for_instructors_shows_each_drawn_picture():
    text = (PROJECT / "docs" / "instructors.md").read_text("utf-8")
    shown = re.findall(r"!\[(.{40,}?)\]\(pictures/(\w+)\.png\)", text)
    assert [name for _, name in shown] == [picture.name for picture in class_pictures.PICTURES]
    for picture in class_pictures.PICTURES:
        with Image.open(class_pictures.FOLDER / f"{picture.name}.png") as drawn:
            width, height = (length - 2 * class_pictures.BORDER for length in drawn.size)
            assert width / height == pytest.approx(class_pictures.WIDTH / picture.height, rel=0.01)
    assert len(re.findall("^## .+\n\n`python -m grader ", text, re.M)) == len(shown)


def test_a_picture_of_marks_has_no_empty_column():
    page = class_pictures.marks_page("Student,E-mail,06_ground,Total\nada,,<3,30\n")
    assert re.findall("<th>(.*?)</th>", page) == ["Student", "06_<wbr>ground", "Total"]
    assert re.findall("<td>(.*?)</td>", page) == ["ada", "&lt;3", "30"]


def test_a_guide_links_to_pages_and_if_possible_to_files():
    here = guides.page("nbgrader", Origin("", "main"), Pictures())
    there = guides.page("nbgrader", PUBLIC, Pictures())
    assert "(canvas_and_moodle.md)" in here
    assert "[late.py](" not in here and "late.py" in here
    assert "[late.py](https://github.com/anna/lidar/blob/v1/grader/lms/late.py)" in there
    assert "](name.png)" in guides.page("authors", PUBLIC, Pictures()), "code is not changed"


@pytest.mark.slow
def test_the_front_page_has_every_lesson():
    page = front_page.page(read_origin(), Pictures())
    assert re.findall(r'class="lesson-card" href="(\w+/\w+)\.html"', page) == [
        f"{lesson.stage}/{lesson.name}" for lesson in every_lesson()
    ]
    _, film = page.split("</figure>", 1)
    assert re.match(r'\s*<script defer src="_static/shown/\w+\.js"></script>', film)
    assert re.search(r'<noscript class="film"><figure class="film">.*\.webp.*</noscript>', film)
    _, optional = page.split("### Optional")
    assert "13 · Compiled loops" in optional and "<code>snuggest_turn</code>" in optional


def test_the_front_page_links_to_the_pdf_file_only_if_there_is_one():
    pages = [front_page.page(read_origin(), Pictures(), name) for name in ("", "all.pdf")]
    assert ["one PDF file" in page for page in pages] == [False, True]
    assert '<a href="all.pdf">' in pages[1]


# ---- the playground ------------------------------------------------------------------------------


def decoded(script):
    """Return the points in the playground's script in metres."""
    scan = json.loads(script.decode().removeprefix("const SCAN = ").removesuffix(";\n"))
    steps = struct.iter_unpack("<3h", base64.b64decode(scan["xyz"]))
    return np.array([*steps]) * scan["step"]


def test_the_playground_has_every_point_of_the_scan():
    pictures = Pictures()
    panel = playground.panel(pictures.keep)
    name = re.search('data-scan="(.+?)"', panel)[1]
    script = pictures.files[name]
    lines = (PROJECT / "data" / "cloud.txt").read_text().splitlines()
    scan = np.array([[float(number) for number in line.split()[:3]] for line in lines])
    points = decoded(script)
    assert points.shape == scan.shape
    assert np.abs(points - scan).max() <= 0.0011, "the caption promises at most 1 mm"
    assert f"All {len(lines):,} points" in panel and "at most 1 mm" in panel
    assert "<canvas" in panel
    again = Pictures()
    assert playground.panel(again.keep) == panel and again.files == pictures.files


def test_the_styles_of_the_playground_come_with_it():
    pictures = Pictures()
    name = re.search('<link rel="stylesheet" href="(.+?)">', playground.panel(pictures.keep))[1]
    assert b"figure.playground canvas {" in pictures.files[name]
    assert "playground" not in (builder.STATIC / "site.css").read_text("utf-8")


def test_the_playground_refuses_a_scan_that_does_not_fit():
    edge = np.array([[81.9, -81.9, 0.0]])
    assert decoded(playground.scan_script(edge)) == pytest.approx(edge)
    with pytest.raises(ValueError, match="within 81.9 m"):
        playground.scan_script(np.array([[0.0, 83.0, 0.0]]))


def test_every_slider_of_the_playground_has_a_label_and_a_valid_value():
    panel = playground.panel(Pictures().keep)
    sliders = re.findall(r"<label>[^<]+<b></b>[^<]*<input type=\"range\" ([^>]+)></label>", panel)
    assert len(sliders) == panel.count('type="range"') == 4
    for slider in sliders:
        about = dict(re.findall(r'([\w-]+)="([^"]*)"', slider))
        least, most, step, value = (float(about[name]) for name in ("min", "max", "step", "value"))
        assert least < value < most
        assert (value - least) / step == pytest.approx(round((value - least) / step))


def test_a_line_of_a_solution_is_found_in_the_playground_in_the_notation_of_javascript(tmp_path):
    script = tmp_path / "shown" / "playground.js"
    script.parent.mkdir()
    script.write_bytes((playground.HERE / "playground.js").read_bytes())
    assert site_checks.find_faults(tmp_path) == []
    line = "while parent[cell] != cell:"
    assert line in set(secrets())
    translated = script.read_text("utf-8") + "while (parent[cell] !== cell) { climb(); }\n"
    script.write_text(translated, "utf-8")
    (fault,) = site_checks.find_faults(tmp_path)
    assert repr(line) in fault and "13_compiled_loops" in fault


def test_a_missing_scan_is_found(tmp_path):
    (tmp_path / "index.html").write_text('<figure data-scan="lost.js"></figure>', "utf-8")
    (fault,) = site_checks.find_faults(tmp_path)
    assert fault == "index.html links to lost.js, which does not exist."


# ---- lessons that cannot run ---------------------------------------------------------------------


def test_missing_packages_are_found_in_import_statements():
    text = """
import json, no_such_compiler.jit as jit
try:
    from another_one.that_is_missing import njit
except ImportError:
    from numpy.linalg import norm
"""
    missing = runs.missing_packages(SimpleNamespace(text=text))
    assert missing == ["another_one", "no_such_compiler"]
    assert not [lesson.name for lesson in all_lessons() if runs.missing_packages(lesson)]


@pytest.mark.parametrize("missing", [[], ["numba"]])
def test_an_optional_lesson_runs_if_its_packages_are_installed(
    monkeypatch, tmp_path, capsys, missing
):
    run_lessons = []
    monkeypatch.setattr(runs, "missing_packages", lambda lesson: missing)
    monkeypatch.setattr(runs, "solved_runs", lambda lessons, *_: run_lessons.extend(lessons) or {})
    monkeypatch.setattr(builder, "write_site", lambda *_: None)
    assert cli.main(["site", "--to", str(tmp_path)]) == 0
    assert tuple(run_lessons) == (all_lessons() if missing else every_lesson())
    message = "The page for 13_compiled_loops shows no outputs. To add outputs, install numba"
    assert (message in capsys.readouterr().out) == bool(missing)


# ---- secrets and links ---------------------------------------------------------------------------


def test_the_search_index_separates_titles_text_and_code(tmp_path):
    (tmp_path / "_static").mkdir()
    (tmp_path / "page.html").write_text(
        """<section id="top"><h1>Title<a class="headerlink" href="#top">#</a></h1>
        <details><table><tr><td>Other section</td></tr></table></details>
        <p>Points in <span class="math">\\(\\mathbf{R}^3\\)</span>.</p><pre>np.unique(a)</pre>
        <dl><dt>inlier</dt><dd>close to the model</dd></dl></section>"""
    )
    sections.write(tmp_path)
    text = (tmp_path / sections.SCRIPT_PATH).read_text().removeprefix("const SECTIONS = ")
    assert json.loads(text.rstrip(";\n")) == [
        [
            "page.html",
            "top",
            "Title",
            "Points in R ^3. inlier: close to the model",
            "np.unique(a)",
        ]
    ]


def test_a_progress_bar_in_pieces_is_one_line():
    """The kernel sends a progress bar in as many pieces as its flush interval allows."""
    first, second, third = (
        new_output("stream", name="stdout", text=text) for text in ("\r1/2", "\r2/2\n", "done\n")
    )
    warning = new_output("stream", name="stderr", text="warning\n")
    cell = new_code_cell(outputs=[first, second, warning, third])
    remove_volatile_data(nbformat.v4.new_notebook(cells=[cell]))
    printed = [(output.name, output.text) for output in cell.outputs]
    assert printed == [("stdout", "2/2\n"), ("stderr", "warning\n"), ("stdout", "done\n")]


@pytest.mark.parametrize("suffix", [".html", ".js", ".ipynb"])
def test_a_line_of_a_solution_is_found_in_any_notation(tmp_path, suffix):
    line = "newcomers = np.flatnonzero((distance < threshold) & (labels == 0))"
    assert line in set(secrets())
    text = {
        ".html": "".join(f"<span>{html.escape(part)}</span>" for part in re.split("( )", line)),
        ".js": f"index({json.dumps({'text': line})})",
        ".ipynb": json.dumps({"source": [line]}),
    }
    (tmp_path / f"file{suffix}").write_text(text[suffix], "utf-8")
    (fault,) = site_checks.find_faults(tmp_path)
    assert "reveals a line" in fault and LESSON.name in fault


@pytest.mark.parametrize(
    ("page", "message"),
    [
        ('<script src="https://cdn.example.org/a.js"></script>', "from another host"),
        ('<link rel="stylesheet" href="//fonts.example.org/a.css">', "from another host"),
        ('<img alt="" src="HTTP://example.org/a.png">', "from another host"),
        ('<a href="lost.html">there</a>', "links to lost.html"),
        ('<a href="#lost">there</a>', "links to #lost"),
        ('<img src="page.html">', "without a description"),
        ('<a href="https://example.org/">out</a> <a id="x" href="page.html#x">here</a>', ""),
    ],
)
def test_broken_links_and_requests_to_other_hosts_are_found(tmp_path, page, message):
    (tmp_path / "page.html").write_text(page, "utf-8")
    found = site_checks.find_faults(tmp_path)
    assert [message in fault for fault in found] == [True] * bool(message)


def test_styles_that_load_from_another_host_are_found(tmp_path):
    style = "@import 'https://example.org/a.css'; a {background: url(img.png)}"
    (tmp_path / "a.css").write_text(style, "utf-8")
    assert len(site_checks.find_faults(tmp_path)) == 1


def test_a_folder_with_other_files_is_not_overwritten(tmp_path):
    (tmp_path / "thesis.txt").write_text("mine", "utf-8")
    with pytest.raises(SiteError, match="contains something other than a website"):
        builder.check_ready(tmp_path)
    assert cli.main(["site", "--to", str(tmp_path)]) == 1
    assert (tmp_path / "thesis.txt").read_text("utf-8") == "mine"


# ---- the whole site ------------------------------------------------------------------------------


@pytest.mark.slow
def test_no_line_of_a_solution_is_in_the_site(site):
    lines = set(secrets())
    assert len(lines) > 200
    read = [path for path in site.rglob("*") if path.suffix in (".html", ".js", ".ipynb", ".json")]
    assert len(read) > 40
    for path in read:
        raw = path.read_text("utf-8")
        texts = (raw, text_of(path), raw.replace('\\"', '"').replace("\\n", "\n"))
        assert not [line for line in lines if any(line in text for text in texts)], path.name


@pytest.mark.slow
def test_a_page_has_the_stub_and_the_outputs(site):
    page = text_of(site / LESSON.stage / f"{LESSON.name}.html")
    assert "raise NotImplementedError" in page and "def euclidean_clustering" in page
    assert "2 of 2" in page and "1 of 2" not in page
    assert "this machine" not in page


@pytest.mark.slow
def test_every_page_says_what_search_engines_and_messengers_show(site):
    pages = [path for path in site.rglob("*.html") if "_static" not in path.parts]
    described = [path for path in pages if path.name not in ("search.html", "404.html")]
    texts = {path: path.read_text("utf-8") for path in described}
    found = [re.findall('<meta name="description" content="(.+?)">', texts[path]) for path in texts]
    assert {len(matches) for matches in found} == {1} and len(found) > 30
    assert len({matches[0] for matches in found}) == len(found), "each page has its own description"
    place = "https://anna.github.io/lidar/_static/sharing.png"
    assert all(f'property="og:image" content="{place}"' in text for text in texts.values())
    with Image.open(site / "_static" / "sharing.png") as shown:
        assert shown.width == pytest.approx(1.91 * shown.height, rel=0.01)
    assert (
        sharing.picture_address(Origin("https://code.example.org/anna/lidar", "v1"), "a.png") == ""
    )


@pytest.mark.slow
def test_a_lesson_that_did_not_run_has_a_page_without_outputs(site):
    (lesson,) = optional_lessons()
    page = (site / lesson.stage / f"{lesson.name}.html").read_text("utf-8")
    assert "def snuggest_turn" in text_of(site / lesson.stage / f"{lesson.name}.html")
    assert "cell_input" in page and "cell_output" not in page
    front_page = (site / "index.html").read_text("utf-8")
    assert front_page.count(f'href="{lesson.stage}/{lesson.name}.html"') >= 2, (
        "a card and an entry in the contents"
    )


@pytest.mark.slow
def test_search_finds_words_of_titles_and_of_text(site):
    index = (site / "searchindex.js").read_text("utf-8")
    assert index.startswith("Search.setIndex({"), "a script, which pages can also load from a disk"
    index = json.loads(index.removeprefix("Search.setIndex(").rstrip().removesuffix(")"))
    lesson = index["docnames"].index(f"{LESSON.stage}/{LESSON.name}")
    (found,) = (pages for title, pages in index["alltitles"].items() if "The queue" in title)
    assert [page for page, _ in found] == [lesson]
    assert lesson in index["terms"]["lorri"], "`lorry` is only in the text"


@pytest.mark.slow
def test_every_file_that_a_page_loads_is_in_the_site(site):
    assert (site / "_static" / "mathjax" / "tex-chtml.js").is_file()
    assert len([*(site / "_static" / "mathjax").rglob("*.woff")]) > 10
    assert not [*site.rglob("*.map"), *site.rglob("fontawesome.js"), *site.glob("_sources")]
    for lesson in every_lesson():
        notebook = json.loads((site / "notebooks" / f"{lesson.name}.ipynb").read_text("utf-8"))
        assert notebook["metadata"]["lidar_obstacle_lab"]["standalone"]


@pytest.mark.proof
def test_two_builds_have_the_same_bytes(site, tmp_path, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    monkeypatch.setenv("PYTHONHASHSEED", "7")
    again = tmp_path / "elsewhere" / "deeper"
    builder.write_site(again, solved_notebooks(), PUBLIC)
    files = {path.relative_to(site) for path in site.rglob("*") if path.is_file()}
    assert files == {path.relative_to(again) for path in again.rglob("*") if path.is_file()}
    assert len(files) > 80
    for name in files:
        assert (site / name).read_bytes() == (again / name).read_bytes(), name
