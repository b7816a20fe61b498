"""Notebooks match their sources, are reproducible, and do not leak solutions."""

import inspect
import json
import os
import re
import shutil

import jupytext
import nbformat
import numpy as np
import pytest
from nbgrader.apps.api import NbGraderAPI
from nbgrader.converters import GenerateAssignment
from nbgrader.coursedir import CourseDirectory
from traitlets.config import Config

from grader.course import build, durations, earlier_lessons
from grader.course.lessons import all_lessons, find_lesson, load_reference, stages
from grader.course.nbgrader_settings import STUB, configure, make_converter
from grader.course.paths import PROJECT
from utils.checks import checks_of


@pytest.fixture(scope="module")
def built_files():
    return build.build_all()


def cells_of(text):
    return json.loads(text)["cells"]


def source_of(cell):
    return "".join(cell["source"])


@pytest.mark.slow
def test_built_files_are_up_to_date_and_contain_no_solutions():
    assert build.check() == []


@pytest.mark.slow
def test_the_build_is_reproducible(built_files):
    assert build.build_all() == built_files


def test_notebooks_are_valid_and_contain_no_output(built_files, lesson):
    for path in (lesson.solved, lesson.released):
        notebook = nbformat.reads(built_files[path].decode(), as_version=4)
        nbformat.validate(notebook)
        assert all(not cell.get("outputs") for cell in notebook.cells)
        assert len({cell.id for cell in notebook.cells}) == len(notebook.cells)


def test_a_student_notebook_equals_the_solved_notebook_up_to_the_first_stub(built_files, lesson):
    """Student notebooks run up to the first stub, which raises NotImplementedError when called."""
    solved, released = cells_of(built_files[lesson.solved]), cells_of(built_files[lesson.released])
    first = next(
        number
        for number, cell in enumerate(released)
        if cell["metadata"].get("nbgrader", {}).get("solution")
    )
    for ours, theirs in zip(solved[:first], released[:first], strict=True):
        if earlier_lessons.TAG in ours["metadata"].get("tags", ()):
            ours["source"] = earlier_lessons.remove_solution(source_of(ours))
        assert (ours["cell_type"], source_of(ours)) == (theirs["cell_type"], source_of(theirs))
    namespace = {"np": np}
    exec(source_of(released[first]), namespace)  # defines the stub, which raises only when called
    stub = namespace[released[first]["metadata"]["nbgrader"]["grade_id"]]
    with pytest.raises(NotImplementedError):
        stub(*[None] * len(inspect.signature(stub).parameters))


def test_every_stub_raises_and_every_solution_is_gone(built_files, lesson):
    stubs = [
        source_of(cell)
        for cell in cells_of(built_files[lesson.released])
        if cell["metadata"].get("nbgrader", {}).get("solution")
        and not cell["metadata"]["nbgrader"]["grade"]  # without answers that are graded by hand
    ]
    assert stubs
    for stub in stubs:
        assert stub.rstrip().endswith(STUB)
        assert "roughly" in stub and '"""' in stub
    assert "SOLUTION" not in built_files[lesson.released].decode()


def test_every_exercise_has_checks_tests_and_points(lesson):
    assert lesson.tests.is_file()
    for exercise in lesson.exercises:
        assert exercise.points > 0
        if not exercise.by_hand:
            assert len(checks_of(exercise.name)) >= 3
            assert callable(getattr(load_reference(lesson.name), exercise.name))


def test_each_exercise_has_three_hints(built_files, lesson):
    text = "\n".join(source_of(cell) for cell in cells_of(built_files[lesson.released]))
    for number in (1, 2, 3):
        assert text.count(f"<summary>Hint {number}</summary>") >= len(lesson.exercises)


def test_every_picture_is_embedded_and_has_a_description(built_files, lesson):
    for cell in cells_of(built_files[lesson.released]):
        text = source_of(cell)
        assert not re.search(r"\]\((?!attachment:)[^)]*\.(png|gif)\)", text)
        assert "![](" not in text


def test_nbgrader_releases_only_notebooks(tmp_path):
    """Hidden tests, kept answers and sources are in the same folder but are not released."""
    stage = "stage2_clustering"
    shutil.copytree(PROJECT / "solutions" / stage, tmp_path / "solutions" / stage)
    (tmp_path / "solutions" / stage / "04_kd_tree" / "notes.txt").write_text("mine", "utf-8")
    generate = make_converter(GenerateAssignment, tmp_path, stage)
    generate.no_database = True
    generate.preprocessors = generate.preprocessors[:1]
    generate.start()
    released = {path.name for path in (tmp_path / "notebooks" / stage).rglob("*")}
    assert released == {"04_kd_tree.ipynb", "05_euclidean_clustering.ipynb"}


def test_a_planted_leak_is_found(built_files):
    lesson = find_lesson("06_filter_ground")
    notebook = json.loads(built_files[lesson.released])
    line = "stands_above = cloud[:, 2] >= ground_level"
    assert line in built_files[lesson.solved].decode()
    notebook["cells"].append(
        {"cell_type": "markdown", "metadata": {}, "id": "x", "source": f"Try this:\n    {line}\n"}
    )
    found = build.find_leaks(built_files[lesson.solved], json.dumps(notebook).encode())
    assert found == [line]
    notebook["cells"][-1]["source"] = "### BEGIN SOLUTION"
    assert build.find_leaks(built_files[lesson.solved], json.dumps(notebook).encode())


PASTED_FUNCTIONS = """\
# Paste here.
### BEGIN SOLUTION
# from 07_filter_by_distance: crop_region
# from 11_pca_boxes: get_oriented_boxes
### END SOLUTION
"""


def test_functions_of_earlier_lessons_are_inserted_with_their_dependencies():
    namespace = {}
    text = earlier_lessons.insert_functions(PASTED_FUNCTIONS)
    exec(text, namespace)  # including the imports
    cloud = np.arange(12.0).reshape(3, 4)
    assert namespace["crop_region"](cloud, (0, 0, 0), (5, 6, 7)).tolist() == cloud[:2].tolist()
    points = np.random.default_rng(1).random((40, 3))
    box = namespace["get_oriented_boxes"](points, np.ones(40, dtype=int))
    right = load_reference("11_pca_boxes").get_oriented_boxes(points, np.ones(40, dtype=int))
    assert box.tolist() == right.tolist()
    assert text.count("import numpy as np") == 1 and text.count("### ") == 2
    assert "remove_ego_returns" not in text and "plots" not in text
    assert earlier_lessons.remove_solution(text) == "# Paste here.\n"


@pytest.mark.parametrize(
    "line, message",
    [
        ("# from 06_filter_grounds: filter_ground", "no lesson '06_filter_grounds'"),
        ("# from 06_filter_ground: filter_ground, none", "06_filter_ground does not define none"),
    ],
)
def test_a_wrong_name_of_an_earlier_function_raises(line, message):
    with pytest.raises(ValueError, match=message):
        earlier_lessons.insert_functions(line)


def test_students_do_not_get_functions_of_earlier_lessons(built_files):
    """Their cell is released empty, and a line of another lesson's solution counts as a leak."""
    lesson = find_lesson("12_streaming_obstacles")
    (solved,), (released,) = (
        [
            cell
            for cell in cells_of(built_files[path])
            if earlier_lessons.TAG in cell["metadata"].get("tags", ())
        ]
        for path in (lesson.solved, lesson.released)
    )
    assert "def filter_clusters" in source_of(solved)
    assert not any(
        line for line in source_of(released).splitlines() if not line.startswith("# Paste")
    )
    others = [built_files[other.released] for other in all_lessons() if other != lesson]
    notebook = json.loads(built_files[lesson.released])
    theirs = "return cloud[is_somewhere & ~is_origin]"  # an answer in lesson 01
    given = "def turned(points, angle):"  # given in lesson 11
    for line, found in ((theirs, [theirs]), (given, [])):
        assert line in built_files[lesson.solved].decode()
        notebook["cells"][-1]["source"] = f"x = 1\n{line}\n"
        assert (
            build.find_leaks(built_files[lesson.solved], json.dumps(notebook).encode(), others)
            == found
        )


@pytest.mark.slow
def test_stale_files_are_listed(monkeypatch):
    lesson = all_lessons()[0]
    real = build.build_all()
    monkeypatch.setattr(
        build, "build_all", lambda: {**real, lesson.released: b"{}" + real[lesson.released]}
    )
    monkeypatch.setattr(build, "find_leaks", lambda solved, released, others: [])
    assert [fault for fault in build.check() if f"{lesson.name}.ipynb is out of date" in fault]


def test_jupytext_reads_and_writes_a_source_unchanged(lesson):
    text = lesson.source.read_text("utf-8")
    notebook = jupytext.reads(text, fmt="py:percent")
    again = jupytext.reads(jupytext.writes(notebook, fmt="py:percent"), fmt="py:percent")
    assert [cell.source for cell in again.cells] == [cell.source for cell in notebook.cells]


def test_nbgrader_sees_the_stages_and_the_optional_lesson():
    """Each folder of sources is an assignment, including the optional lesson's."""
    config = configure(Config(), PROJECT)
    api = NbGraderAPI(CourseDirectory(config=config), config=config)
    assert api.get_source_assignments() == {*stages(), "optional"}


TOY = """# %% [markdown]
# # 01 · A toy
#
# **You write** `toy` (points), `other` (points).
#
# **Time:** (time).
#
# ## Reading
#
# words words words

# %% tags=["folded"]
# @title What it does
x = 1

# %% nbgrader={"grade": false, "grade_id": "toy", "solution": true}
def toy():
    ### BEGIN SOLUTION
    return 1
    ### END SOLUTION

# %% tags=["folded"]
print(toy() + 1)

# %% nbgrader={"grade": true, "grade_id": "test_toy", "points": 7}
check(toy)

# %%
print(x)

# %% [markdown]
# **Next:** 04 · Trees
#
# **Next:** 99 · Nowhere
"""


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    class Toy(type(all_lessons()[0])):
        folder = tmp_path_factory.mktemp("toy")
        source = folder / "lesson.py"

    Toy.source.write_text(TOY)
    return build.solved_notebook(Toy("01_toy", "stage1_ransac"), build.Origin("", "main"))


def test_folded_cells_are_folded_in_all_programs(toy):
    assert toy.cells[1].metadata["jupyter"] == {"source_hidden": True}
    assert toy.cells[1].metadata["cellView"] == "form"
    assert toy.cells[1].metadata["_kg_hide-input"] is True


def test_run_all_continues_after_failing_answers_and_checks(toy):
    tags = {cell.source: cell.metadata.get("tags", []) for cell in toy.cells}
    assert tags["print(toy() + 1)"] == ["folded", "raises-exception"]
    assert tags["check(toy)"] == ["raises-exception"]
    others = [names for source, names in tags.items() if "toy()" not in source]
    assert sum("raises-exception" in names for names in others) == 1
    assert "raises-exception" not in tags["print(x)"]


def test_the_next_lesson_is_linked_if_it_exists(toy):
    assert "**Next:** [04 · Trees](../stage2_clustering/04_kd_tree.ipynb)" in toy.cells[-1].source
    assert "**Next:** 99 · Nowhere" in toy.cells[-1].source


def test_points_come_from_the_cells_that_nbgrader_reads(toy):
    assert "**You write** `toy` (7 points), `other` (points)." in toy.cells[0].source


def test_minutes_are_estimated_from_the_content_of_cells(toy):
    assert "about 0 minutes" in toy.cells[0].source
    long = "\n".join(["# ## Long", "#", "# " + "word " * 1200])
    cells = jupytext.reads(f"# %% [markdown]\n{long}\n", fmt="py:percent")
    assert durations.total_minutes(cells) == 10
    cells.cells += jupytext.reads("# %%\n# roughly 10 lines\npass\n", fmt="py:percent").cells
    assert durations.section_minutes(cells)["Long"] == pytest.approx(12 + 3 + 18 + 2 / 8, abs=0.05)
    unread = (
        "# %% [markdown]\n# ![what it shows](a.png) [one](https://ab.cd/ef) <details>x</details>\n"
    )
    before = durations.section_minutes(cells)["Long"]
    cells.cells += jupytext.reads(unread, fmt="py:percent").cells
    assert durations.section_minutes(cells)["Long"] == pytest.approx(before + 1 / 100, abs=1e-6)
    pasted = "# %%\n### BEGIN SOLUTION\n# from 01_a: f, g\n# from 02_b: h\n### END SOLUTION\n"
    cells.cells += jupytext.reads(pasted, fmt="py:percent").cells
    assert durations.section_minutes(cells)["Long"] == pytest.approx(33.26 + 2 * 0.5, abs=0.05)
    answer = "for the grader's eyes " * 100
    report = f'# %% [markdown] nbgrader={{"grade": true}}\n# {answer}\n'
    cells.cells += jupytext.reads(report, fmt="py:percent").cells
    assert durations.section_minutes(cells)["Long"] == pytest.approx(34.26 + 15, abs=0.05)


@pytest.mark.parametrize(
    "code, minutes",
    [
        ("level = 0  # change this number", 3 + 1.8),
        ("# Change this line.", 3 + 1.8),
        ("# roughly 1 line", 3 + 1.8),
        ("# the tree to change", 0),
        ("ask_about(search)", 3),
        ("drive_street(1)", 2),
    ],
)
def test_tasks_outside_of_exercises_count(code, minutes):
    cells = jupytext.reads(f"# %%\n{code}\n", fmt="py:percent")
    assert sum(durations.section_minutes(cells).values()) == pytest.approx(minutes + 1 / 8)


def test_common_cells_are_not_read():
    text = '# %% [markdown] tags=["footer"]\n# ## Words\n#\n# ' + "word " * 500
    assert durations.section_minutes(jupytext.reads(text, fmt="py:percent")) == {}


def test_every_lesson_counts_its_two_questions(lesson):
    """Find their section in the table that the lesson shows, and its minutes in the total."""
    head = nbformat.read(lesson.released, as_version=4).cells[0].source
    minutes = dict(re.findall(r"<td>([^<]*)</td><td>(\d+)</td>", head))
    assert int(minutes["Two questions about your code"]) in (3, 4)
    stated = int(re.search(r"about (\d+) minutes", head)[1])
    # Each row, and the total, is rounded.
    assert sum(map(int, minutes.values())) == pytest.approx(stated, abs=6)


def test_a_lesson_may_state_the_minutes_of_readers():
    long = "\n".join(["# ## Long", "#", "# " + "word " * 1000])
    cells = jupytext.reads(f"# %% [markdown]\n# (time: 30)\n#\n{long}\n", fmt="py:percent")
    durations.insert_durations(cells)
    assert "about 30 minutes" in cells.cells[0].source
    assert "<td>Long</td><td>30</td>" in cells.cells[0].source
    assert durations.stated_minutes(cells) == 30


def test_optional_sections_are_listed_but_not_counted():
    long, more = (
        "\n".join([f"# ## {title}", "#", "# " + "word " * 1500])
        for title in ("Long", "If you want more")
    )
    text = f"# %% [markdown]\n# (time)\n#\n{long}\n#\n{more}\n\n# %%\nprint(1)\n"
    cells = jupytext.reads(text, fmt="py:percent")
    assert durations.total_minutes(cells) == 15 and durations.sitting_minutes(cells) == [
        pytest.approx(15, abs=0.05)
    ]
    durations.insert_durations(cells)
    assert "about 15 minutes" in cells.cells[0].source
    assert "<td>If you want more</td>" not in cells.cells[0].source


def test_places_to_stop_are_at_most_ninety_minutes_apart(lesson):
    notebook = nbformat.read(lesson.solved, as_version=4)
    assert max(durations.sitting_minutes(notebook)) <= durations.MAX_MINUTES_WITHOUT_STOP


def test_sittings_take_as_long_as_stated(lesson):
    notebook = nbformat.read(lesson.solved, as_version=4)
    total, estimated = durations.stated_minutes(notebook), durations.sitting_minutes(notebook)
    sentence = re.search(r"in (?:two|three|four) sittings[^.]*", notebook.cells[0].source)
    numbers = re.findall(r"(?<!Part )\b\d+", sentence[0]) if sentence else [total]
    stated = [int(number) for number in numbers]
    assert [total / sum(estimated) * minutes for minutes in estimated] == pytest.approx(
        stated, rel=0.1
    )
    stops = [cell.source for cell in notebook.cells if durations.STOP_MARK in cell.source]
    for stop, minutes in zip(stops, stated[1:], strict=True):  # of the sitting that follows
        assert all(int(number) == minutes for number in re.findall(r"(\d+) minutes", stop))


def test_the_tests_in_this_file_run_in_one_process(request):
    """Fail if pytest-xdist silently ignores test groups, as incompatible versions do."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        assert request.node.nodeid.endswith("@test_build")


def test_a_lesson_that_states_no_duration_gets_an_estimate():
    """`build` states the hours of the course even if an instructor's own lesson does not."""
    text = nbformat.v4.new_markdown_cell("# A lesson\n" + "word " * 2000)
    notebook = nbformat.v4.new_notebook(cells=[text])
    assert durations.stated_minutes(notebook) == 20
    notebook.cells.append(nbformat.v4.new_markdown_cell("This takes about 35 minutes."))
    assert durations.stated_minutes(notebook) == 35
