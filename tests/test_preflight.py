"""What editors, browsers and disks do to notebooks costs nobody a point, and never in silence."""

import base64
import copy
import json
import re

import nbformat
import numpy as np
import pytest
from nbconvert.exporters import HTMLExporter

from grader.course.kept_answers import answers_to, fill_in
from grader.course.lessons import find_lesson
from grader.intake import preflight
from grader.intake.preflight import (
    JudgeInput,
    PreparedNotebook,
    WrittenAnswer,
    prepare,
    prepare_to_show,
)
from grader.intake.submission import SubmittedFiles
from grader.judging.judge import judge_files
from grader.lms.autograded import MISSING_ANSWER_NOTE, build_copy, graded_cells
from tests.students import answers_in
from utils.notebooks.reading import UnreadableNotebook

LESSON = find_lesson("06_filter_ground")
THREE = find_lesson("07_filter_by_distance")
WRITTEN = find_lesson("12_streaming_obstacles")
EXERCISES = ("filter_ground", "voxel_grid")
REPORT = "I widened the region to 18.5 m, because the lorry *stands* at 17 m."


def right(exercise):
    return next(variant.source for variant in answers_to(exercise) if variant.right)


def whole():
    """A notebook of lesson 06 with right answers, as JSON."""
    return json.loads(fill_in(LESSON, {name: right(name) for name in EXERCISES}))


def with_report():
    """A notebook of lesson 12 with a written answer, as JSON."""
    return json.loads(fill_in(WRITTEN, {"write_up": REPORT}))


def cell_of(notebook, grade_id):
    return next(
        cell
        for cell in notebook["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == grade_id
    )


def code(source, **metadata):
    return {
        "cell_type": "code",
        "metadata": metadata,
        "source": source,
        "outputs": [],
        "execution_count": None,
    }


def text(source, **metadata):
    return {"cell_type": "markdown", "metadata": metadata, "source": source}


def changed(change):
    """Bytes of the whole notebook after `change`, which may return another one, text or bytes."""
    notebook = whole()
    made = change(notebook)
    made = notebook if made is None else made
    if isinstance(made, dict):
        made = json.dumps(made)
    return made if isinstance(made, bytes) else made.encode("utf-8", "surrogatepass")


def each_cell(act):
    def change(notebook):
        for cell in notebook["cells"]:
            act(cell)

    return change


def retype(kind):
    def change(notebook):
        for name in EXERCISES:
            cell = cell_of(notebook, name)
            cell["cell_type"] = kind
            del cell["outputs"], cell["execution_count"]

    return change


def split(notebook):
    cells = notebook["cells"]
    place = cells.index(cell_of(notebook, "voxel_grid"))
    cells.insert(place, code("import numpy as np"))
    cells[place + 1]["metadata"] = {}


def merged(notebook):
    first, second = (cell_of(notebook, name) for name in EXERCISES)
    first["source"] = "".join(first["source"]) + "\n\n" + "".join(second["source"])
    notebook["cells"].remove(second)


def old(notebook):
    cells = []
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cells.append(
                {
                    "cell_type": "code",
                    "input": "".join(cell["source"]),
                    "language": "python",
                    "metadata": cell["metadata"],
                    "outputs": [],
                }
            )
        else:
            cells.append({"cell_type": "markdown", "metadata": {}, "source": cell["source"]})
    return {"nbformat": 3, "nbformat_minor": 0, "metadata": {}, "worksheets": [{"cells": cells}]}


def set_all(**entries):
    return lambda notebook: notebook.update(entries)


def big_outputs(notebook):
    junk = {"output_type": "stream", "name": "stdout", "text": "[{" * 2_000_000}
    notebook["cells"][1]["outputs"] = [junk]


# What may happen to a file on its way, and words that the student must then be told; empty
# where nothing was lost and there is nothing to say.
EARNS_EVERYTHING = {
    "nothing at all": (lambda notebook: None, ""),
    "a byte order mark": (lambda notebook: b"\xef\xbb\xbf" + json.dumps(notebook).encode(), ""),
    "UTF-16": (lambda notebook: json.dumps(notebook).encode("utf-16"), ""),
    "Windows' own letters": (
        lambda notebook: json.dumps(
            notebook | {"cells": [*notebook["cells"], text("Größe")]}, ensure_ascii=False
        ).encode("cp1252", "replace"),
        "not UTF-8",
    ),
    "line ends of Windows": (
        lambda notebook: json.dumps(notebook, indent=1).replace("\n", "\r\n"),
        "",
    ),
    "zeros behind it": (lambda notebook: json.dumps(notebook) + "\0" * 4096, ""),
    "text behind it": (lambda notebook: json.dumps(notebook) + "<html>", "stands something else"),
    "a second copy behind it": (lambda notebook: json.dumps(notebook) * 2, "second copy"),
    "cut off after the answers": (
        lambda notebook: json.dumps(notebook)[: int(len(json.dumps(notebook)) * 0.98)],
        "cut off",
    ),
    "metadata missing": (lambda notebook: notebook.pop("metadata") and None, ""),
    "metadata null": (set_all(metadata=None), ""),
    "no cell has metadata": (each_cell(lambda cell: cell.pop("metadata")), ""),
    "metadata of cells null": (each_cell(lambda cell: cell.update(metadata=None)), ""),
    "metadata of cells a list": (each_cell(lambda cell: cell.update(metadata=[])), ""),
    "no ids": (each_cell(lambda cell: cell.pop("id", None)), ""),
    "all ids the same": (each_cell(lambda cell: cell.update(id="a")), ""),
    "ids that are numbers": (each_cell(lambda cell: cell.update(id=7)), ""),
    "ids in an older format": (set_all(nbformat_minor=4), ""),
    "a format from the future": (set_all(nbformat=5), ""),
    "a format of old": (old, ""),
    "outputs in text cells": (each_cell(lambda cell: cell.update(outputs=[])), ""),
    "no outputs at all": (each_cell(lambda cell: cell.pop("outputs", None)), ""),
    "no execution counts": (each_cell(lambda cell: cell.pop("execution_count", None)), ""),
    "tags twice": (each_cell(lambda cell: cell["metadata"].update(tags=["a", "a"])), ""),
    "attachments that are null": (each_cell(lambda cell: cell.update(attachments=None)), ""),
    "widgets without state": (
        lambda notebook: notebook["metadata"].update(widgets={"application/x": {}}),
        "",
    ),
    "Colab's own notes": (
        lambda notebook: notebook["metadata"].update(colab={"provenance": []}, accelerator="GPU"),
        "",
    ),
    "another kernel": (
        lambda notebook: notebook["metadata"].update(kernelspec={"name": "ir"}),
        "",
    ),
    "huge outputs": (big_outputs, ""),
    "answers in text cells": (retype("markdown"), "a text cell"),
    "answers in raw cells": (retype("raw"), "a raw cell"),
    "answers in text cells without metadata": (
        lambda notebook: (
            retype("markdown")(notebook) or each_cell(lambda c: c.pop("metadata"))(notebook)
        ),
        "press Y",
    ),
    "cells in another order": (
        lambda notebook: notebook["cells"].sort(key=lambda cell: cell["cell_type"] != "code"),
        "",
    ),
    "a cell split": (split, ""),
    "two cells merged": (merged, ""),
    "an answer twice": (
        lambda notebook: notebook["cells"].append(copy.deepcopy(cell_of(notebook, "voxel_grid"))),
        "",
    ),
    "an answer twice, the first one wrong": (
        lambda notebook: notebook["cells"].insert(1, code("def voxel_grid(cloud): return 3")),
        "",
    ),
    "the cell as given out, pasted at the end": (
        lambda notebook: notebook["cells"].append(
            cell_of(json.loads(LESSON.released.read_text()), "voxel_grid")
        ),
        "the cell as it was given out",
    ),
    "every cell twice": (
        lambda notebook: notebook["cells"].extend(copy.deepcopy(notebook["cells"])),
        "",
    ),
    "no cells with tests": (
        lambda notebook: notebook.update(
            cells=[c for c in notebook["cells"] if "check(" not in "".join(c["source"])]
        ),
        "",
    ),
    "a cell without source": (lambda n: n["cells"].append({"cell_type": "code"}), ""),
    "a cell whose source is null": (lambda n: n["cells"].append(code(None)), ""),
    "a cell that is a number": (lambda n: n["cells"].append(7), "1 of the cells"),
    "a cell that is null": (lambda n: n["cells"].append(None), "1 of the cells"),
    "the key `cells` twice": (
        lambda notebook: json.dumps({"cells": []})[:-1] + "," + json.dumps(notebook)[1:],
        "",
    ),
}


@pytest.mark.parametrize("change, says", EARNS_EVERYTHING.values(), ids=EARNS_EVERYTHING)
def test_what_a_file_goes_through_costs_nothing(change, says):
    """The code is all there, the copy is whole and valid, and what was mended is said."""
    prepared = prepare(SubmittedFiles("06_filter_ground.ipynb", changed(change)), LESSON)
    answers = answers_in(LESSON, prepared.code)
    cloud = np.array([[0.0, 0, -2, 1], [1, 1, 1, 1], [1.01, 1, 1, 0]])
    assert len(answers["filter_ground"](cloud)) == 2
    assert len(answers["voxel_grid"](cloud, 0.5)) == 2
    notes = " ".join(prepared.notes)
    assert (says in notes) if says else notes == ""
    made = build_copy(prepared)
    nbformat.validate(made)
    names = [cell.metadata.nbgrader.grade_id for cell in graded_cells(made)]
    assert sorted(names) == sorted([*EXERCISES, *(f"test_{name}" for name in EXERCISES)])
    answers = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(made)}
    for name in EXERCISES:
        assert f"def {name}" in answers[name].source or "stands in the cell" in answers[name].source
        assert "NotImplementedError" not in answers[name].source
        assert (
            answers[f"test_{name}"].source.startswith("check(")
            or "check" in answers[f"test_{name}"].source
        )


SOME = ("cut off after the answers", "answers in text cells", "a format of old", "huge outputs")


@pytest.mark.slow
@pytest.mark.parametrize("name", SOME)
def test_and_the_judge_agrees(name, sandbox):
    change, says = EARNS_EVERYTHING[name]
    verdict = judge_files(
        SubmittedFiles("06_filter_ground.ipynb", changed(change)), 1, sandbox, LESSON
    )
    assert verdict.score == 30
    assert says in " ".join(verdict.problems)


@pytest.mark.parametrize(
    "change, says",
    [
        (lambda notebook: b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "it is not text"),
        (lambda notebook: "", "is empty"),
        (lambda notebook: "\0" * 100, "is empty"),
        (lambda notebook: "[]", "no cells"),
        (lambda notebook: '{"cells": 7}', "no cells"),
        (lambda notebook: '{"cells": [{"a": {"b"', "not valid JSON"),
        (lambda notebook: '{"cells": [' + "[]," * 2_100_000 + "[]]}", "Clear its outputs"),
    ],
)
def test_what_cannot_be_read_is_shown_as_released(change, says):
    handed_in = SubmittedFiles("06_filter_ground.ipynb", changed(change))
    with pytest.raises(UnreadableNotebook, match=says):
        prepare(handed_in, LESSON)
    made = build_copy(prepare_to_show(handed_in, LESSON))
    nbformat.validate(made)
    assert len(graded_cells(made)) == 4


@pytest.mark.slow
@pytest.mark.parametrize(
    "notebook, says",
    [
        (
            lambda: json.loads(find_lesson("05_euclidean_clustering").released.read_text()),
            "holds the notebook of 05_euclidean_clustering",
        ),
        (lambda: {"cells": [], "metadata": {}, "nbformat": 4}, "There is no code in"),
        (lambda: {"cells": [text("# my essay")], "nbformat": 4}, "There is no code in"),
    ],
)
def test_nothing_of_this_lesson_is_never_silently_nothing(notebook, says, sandbox):
    data = json.dumps(notebook()).encode()
    verdict = judge_files(SubmittedFiles("06_filter_ground.ipynb", data), 1, sandbox, LESSON)
    assert verdict.score == 0
    assert says in " ".join(verdict.problems)


def test_two_versions_are_told_to_who_loses_points(sandbox):
    notebook = whole()
    notebook["cells"].insert(1, code("def voxel_grid(cloud): return 3"))
    handed_in = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(handed_in, 1, sandbox, LESSON)
    assert verdict.score == 30 and verdict.problems == ()
    notebook["cells"].append(code("def voxel_grid(cloud, size): return 3"))
    handed_in = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(handed_in, 1, sandbox, LESSON)
    assert verdict.score == 10
    said = r"voxel_grid is written 3 times, in code cells 1, \d+ and \d+\. The last one counts"
    assert re.search(said, " ".join(verdict.problems))
    assert "The last one counts" in " ".join(verdict.problems)


def test_a_module_beside_is_said_to_be_used():
    notebook = whole()
    notebook["cells"].insert(0, code("from helpers import mask"))
    modules = {"helpers": "mask = 1", "other": ""}
    handed_in = SubmittedFiles("x.ipynb", json.dumps(notebook).encode(), modules=modules)
    assert (
        "helpers.py, handed in beside the notebook, was used." in prepare(handed_in, LESSON).notes
    )


def test_two_answers_one_of_them_cut_off():
    data = json.dumps(whole())
    begin = data.index("def voxel_grid") + 20
    prepared = prepare(SubmittedFiles("06_filter_ground.ipynb", data[:begin].encode()), LESSON)
    assert "filter_ground" in prepared.graded and "voxel_grid" not in prepared.graded
    assert "cut off" in prepared.notes[0]


# ---- One step at a time --------------------------------------------------------------------


def prepared_of(*cells, lesson=LESSON, modules=None, name="", lesson_name=""):
    """What becomes of some cells."""
    notebook = {"cells": list(cells), "nbformat": 4, "nbformat_minor": 5}
    notebook["metadata"] = {"lidar_obstacle_lab": {"lesson": lesson_name}} if lesson_name else {}
    data = json.dumps(notebook).encode()
    return prepare(
        SubmittedFiles(name or f"{lesson.name}.ipynb", data, modules=modules or {}), lesson
    )


def marked(made, grade_id):
    """The same cell with nbgrader's mark on it."""
    return {**made, "metadata": {"nbgrader": {"grade_id": grade_id}}}


TEXT = ("markdown", "raw")
GROUND = "def filter_ground(cloud):\n    return {}"
VOXELS = "def voxel_grid(cloud):\n    return {}"


def test_what_is_prepared_stays_as_it_is():
    for kind in (WrittenAnswer, PreparedNotebook, JudgeInput):
        assert kind.__dataclass_params__.frozen
    assert WrittenAnswer("a").certain
    assert preflight.given_cells(LESSON) is preflight.given_cells(LESSON)  # read once


@pytest.mark.parametrize(
    ("cells", "kinds"),
    [
        # Text that shows code is text, also where it stands in a cell of ours.
        ([text("```\n" + GROUND + "\n```")], ["markdown"]),
        ([marked(text("Like this:\n```\n" + GROUND + "\n```"), "filter_ground")], ["markdown"]),
        ([text("Above: def filter_ground(cloud)")], ["markdown"]),
        ([text(GROUND), code(VOXELS)], ["code", "code"]),
        # It is written elsewhere as code: then this is an old one.
        ([text(GROUND), code(GROUND)], ["markdown", "code"]),
        ([code(GROUND), text(GROUND)], ["code", "markdown"]),
        ([marked(text(GROUND), "filter_ground"), code(GROUND)], ["markdown", "code"]),
        ([marked(text(GROUND), "voxel_grid"), code(GROUND)], ["markdown", "code"]),
        ([code(GROUND), marked(text(GROUND), "voxel_grid")], ["code", "markdown"]),
        (
            [code(GROUND), marked(text(GROUND), "filter_ground"), code(GROUND)],
            ["code", "markdown", "code"],
        ),
        # In its own cell it is the answer, and what came before was tried.
        ([code(GROUND), marked(text(GROUND), "filter_ground")], ["code", "code"]),
        ([marked(text("My answer."), "filter_ground")], ["markdown"]),
        # Of several the first is the one.
        ([text(GROUND), text(GROUND)], ["code", "markdown"]),
        ([text(GROUND + "\n" + VOXELS), text(VOXELS)], ["code", "markdown"]),
        # What is written nowhere else is not lost.
        ([text(GROUND + "\n" + VOXELS), code(VOXELS)], ["code", "code"]),
    ],
)
def test_which_text_is_code(cells, kinds):
    made = prepared_of(*cells)
    assert [cell.kind for cell in made.cells] == kinds
    assert made.code == tuple(cell.source for cell in made.cells if cell.kind not in TEXT)
    turned = sum(cell["cell_type"] != "code" for cell in cells) - kinds.count("markdown")
    said = [note for note in made.notes if "stood in a text cell" in note]
    assert len(said) == turned and all(note.split()[0] in EXERCISES for note in said)


def defined_last(made, name):
    """What the last code cell that defines a function says it returns."""
    last = next(source for source in reversed(made.code) if f"def {name}" in source)
    return last.split(f"def {name}(cloud):\n    return ")[1].split("\n")[0]


TWO = GROUND.format(1) + "\n" + VOXELS.format(2)


@pytest.mark.parametrize("turned_round", [False, True])
@pytest.mark.parametrize(
    ("cells", "ground", "voxels"),
    [
        # What stands as code ran, and counts, wherever it stands; the rest is not lost.
        ([text(TWO), code(GROUND.format(3))], "3", "2"),
        ([code(GROUND.format(3)), text(TWO)], "3", "2"),
        ([code(GROUND.format(4)), code(GROUND.format(3)), text("Mine."), text(TWO)], "3", "2"),
        ([code(VOXELS.format(3)), text(TWO)], "1", "3"),
        ([text(TWO), code(VOXELS.format(3))], "1", "3"),
        ([code(GROUND.format(3)), marked(text(TWO), "voxel_grid")], "3", "2"),
        # So of two text cells, of which the first was needed.
        ([text(GROUND.format(3)), text(TWO)], "3", "2"),
        ([code(GROUND.format(3)), text(TWO), marked(text(TWO), "voxel_grid")], "3", "2"),
    ],
)
def test_a_text_cell_with_what_stands_elsewhere_too(cells, ground, voxels, turned_round):
    if turned_round:  # the order of definitions within a cell says nothing
        swapped = VOXELS.format(2) + "\n" + GROUND.format(1)
        cells = [{**cell, "source": cell["source"].replace(TWO, swapped)} for cell in cells]
    made = prepared_of(code("import numpy as np"), *cells)
    assert (defined_last(made, "filter_ground"), defined_last(made, "voxel_grid")) == (
        ground,
        voxels,
    )
    # What ran keeps its order.
    ran = [cell["source"] for cell in cells if cell["cell_type"] == "code"]
    assert [source for source in made.code if source in ran] == ran
    said = [note for note in made.notes if "stood in a text cell" in note]
    mine, other = ("voxel_grid", "filter_ground") if voxels == "2" else EXERCISES
    assert said[-1] == (
        f"{mine} stood in a text cell, where Jupyter does not run it. It was judged as code. "
        f"{other} in that cell was not judged, but the one in another cell. In Jupyter, select the "
        f"cell and press Y to make it code again, and delete {other} in it."
    )


@pytest.mark.parametrize(
    ("cells", "order"),
    [
        # It goes down before what counts, and not above what may be needed in it.
        (["x = 1", "y = 2", GROUND, text(TWO)], ["x = 1", "y = 2", TWO, GROUND]),
        # Where it stands before that, it stays: what calls it may stand between them.
        (["x = 1", text(TWO), "voxel_grid(x)", GROUND], ["x = 1", TWO, "voxel_grid(x)", GROUND]),
    ],
)
def test_where_a_text_cell_goes_with_what_stands_elsewhere_too(cells, order):
    made = prepared_of(*(code(cell) if isinstance(cell, str) else cell for cell in cells))
    assert list(made.code) == order


def test_of_a_text_cell_with_two_that_stand_elsewhere_the_third_is_judged():
    """Code counts, and of several texts the first: those with more are moved before them."""

    def cell(number, *names):
        return text("\n".join(f"def {name}(cloud):\n    return {number}" for name in names))

    distance, crop, ego = (exercise.name for exercise in THREE.machine_graded)
    above = code(cell(1, distance)["source"])
    made = prepared_of(above, cell(2, distance, crop), cell(3, crop, ego), lesson=THREE)
    assert [defined_last(made, name) for name in (distance, crop, ego)] == ["1", "2", "3"]
    made = prepared_of(above, cell(2, crop), cell(3, distance, crop, ego), lesson=THREE)
    assert [defined_last(made, name) for name in (distance, crop, ego)] == ["1", "2", "3"]
    assert made.notes[1] == (
        f"{ego} stood in a text cell, where Jupyter does not run it. It was judged as code. "
        f"{distance} and {crop} in that cell were not judged, but others. In Jupyter, select the "
        f"cell and press Y to make it code again, and delete {distance} and {crop} in it."
    )


def test_a_text_cell_with_everything():
    made = prepared_of(text(TWO))
    assert made.code == (TWO,)
    assert made.notes == (
        "filter_ground and voxel_grid stood in a text cell, where Jupyter does not run them. They "
        "were judged as code. In Jupyter, select the cell and press Y to make it code again.",
    )


def test_an_answer_in_text_beside_the_cell_as_it_was_given_out():
    for cells in ([stub_of("filter_ground"), text(TWO)], [text(TWO), stub_of("filter_ground")]):
        made = prepared_of(*cells)
        assert (
            defined_last(made, "filter_ground") == "1" and defined_last(made, "voxel_grid") == "2"
        )
        assert "filter_ground and voxel_grid stood in a text cell" in made.notes[0]


def stub_of(name):
    return code("".join(cell_of(json.loads(LESSON.released.read_text()), name)["source"]))


def test_stubs_are_left_out_behind_an_answer_and_nowhere_else():
    ground, voxels, left = stub_of("filter_ground"), stub_of("voxel_grid"), "# Left out"
    answer, another = code(GROUND.format(1)), code(GROUND.format(2))
    for cells, expected in (
        ([ground], [False]),
        ([ground, ground], [False, False]),
        ([ground, answer], [False, False]),
        ([answer, ground, another], [False, False, False]),
        ([answer, ground, voxels, ground], [False, True, False, True]),
        ([ground, answer, another, ground], [False, False, False, True]),
    ):
        made = prepared_of(*cells)
        assert [cell.source.startswith(left) for cell in made.cells] == expected
        said = [note for note in made.notes if note.startswith("Below your filter_ground stands")]
        assert len(said) == any(expected)
        last = made.cells[made.graded["filter_ground"]].source
        assert not last.startswith(left) and "filter_ground" in last


def test_which_cell_stands_for_an_exercise():
    other = code("x = 1")
    for cells, place in (
        ([code(GROUND), other, code(GROUND), other], 2),
        ([marked(code(GROUND), "filter_ground"), other, code(GROUND)], 0),
        ([marked(other, "filter_ground"), code(GROUND), other], 1),
        ([other, marked(other, "filter_ground"), marked(other, "filter_ground"), other], 2),
        ([marked(code(GROUND), "filter_ground")] * 2 + [other], 1),
        ([other, marked(text("Some text."), "filter_ground")], None),
        ([other, marked(other, "voxel_grid")], None),
    ):
        assert prepared_of(*cells).graded.get("filter_ground") == place


@pytest.mark.parametrize(
    ("source", "written"),
    [
        ("def filter_ground(cloud): pass", True),
        ("x = 1\ndef  filter_ground (cloud): pass", True),
        ("filter_ground = keep", True),
        ("filter_ground= keep", True),
        ("    def filter_ground(cloud): pass", False),
        ("my_filter_ground = keep", False),
        ("def filter_ground_2(cloud): pass", False),
        ("filter_ground(cloud)", False),
    ],
)
def test_what_writes_an_exercise(source, written):
    assert ("filter_ground" in prepared_of(code(source)).graded) == written


def test_of_another_lesson_is_said_where_nothing_of_this_one_is_there():
    other = "07_filter_by_distance"
    here = prepared_of(code("x = 1"), lesson_name=other, name="06_filter_ground (1).ipynb")
    assert here.notes == (
        f"06_filter_ground (1).ipynb holds the notebook of {other}, and nothing of "
        f"{LESSON.name}. Hand in {LESSON.name}.ipynb.",
    )
    earlier = prepared_of(code("x = 1"), lesson_name="05_euclidean_clustering")
    assert "holds the notebook of 05_euclidean_clustering, and nothing of 06" in earlier.notes[0]
    assert prepared_of(code(GROUND), lesson_name=other).notes == ()
    assert prepared_of(code("x = 1"), lesson_name=LESSON.name).notes == ()
    assert prepared_of(code("x = 1")).notes == ()
    empty = prepared_of(code(" \n"), text("Some text."))
    assert [note.partition(".")[0] for note in empty.notes] == [
        "There is no code in 06_filter_ground"
    ]
    long = prepared_of(code("x = 1"), lesson_name="07" * 50)
    assert f"of {'07' * 30}, and" in long.notes[0]


@pytest.mark.parametrize(
    ("source", "used"),
    [
        ("import helpers", "helpers.py, handed in beside the notebook, was used."),
        ("x = 1\n    from\thelpers import mask", "helpers.py, handed in beside the notebook, was"),
        (
            "import helpers\nimport tools",
            "helpers.py, tools.py, handed in beside the notebook, were",
        ),
        ("import helpers2, tools2", None),
        ("# import helpers", None),
        ("reimport helpers", None),
    ],
)
def test_which_modules_are_used(source, used):
    made = prepared_of(code(source), text("import tools"), modules={"helpers": "", "tools": ""})
    assert len(made.notes) == (used is not None)
    assert all(note.startswith(used) for note in made.notes)


def test_of_many_versions_four_are_listed_and_the_last():
    def versions(number):
        cells = [code("x = 1"), text("Some text.")]
        cells += [code(GROUND.format(one)) for one in range(number)]
        return prepared_of(*cells).versions.get("filter_ground", "")

    assert versions(1) == ""
    assert versions(2).startswith("filter_ground is written 2 times, in code cells 2 and 3. The")
    assert "5 times, in code cells 2, 3, 4, 5 and 6. The" in versions(5)
    assert "6 times, in code cells 2, 3, 4, 5, … and 7. The" in versions(6)
    same = prepared_of(code(GROUND), stub_of("filter_ground"), code(GROUND), code(VOXELS))
    assert same.versions == {}


# ---- Written answers -----------------------------------------------------------------------


def moved_below(notebook):
    place = notebook["cells"].index(cell_of(notebook, "write_up"))
    notebook["cells"][place]["source"] = "YOUR ANSWER HERE"
    notebook["cells"].insert(place + 1, text(REPORT))


def in_two_cells(notebook):
    moved_below(notebook)
    place = notebook["cells"].index(cell_of(notebook, "write_up"))
    first, second = REPORT.split(", ")
    notebook["cells"][place + 1 : place + 2] = [text(first + ","), text(second)]


def without_metadata(notebook):
    for cell in notebook["cells"]:
        cell["metadata"] = {}


def own_cell_deleted(notebook):
    moved_below(notebook)
    notebook["cells"].remove(cell_of(notebook, "write_up"))


def as_code_cell(notebook):
    cell = cell_of(notebook, "write_up")
    cell.update(cell_type="code", outputs=[], execution_count=None)


@pytest.mark.parametrize(
    "change",
    [
        lambda notebook: None,
        moved_below,
        in_two_cells,
        without_metadata,
        own_cell_deleted,
        as_code_cell,
        lambda notebook: cell_of(notebook, "write_up").update(cell_type="raw"),
        lambda notebook: cell_of(notebook, "write_up").update(outputs=[]),
        lambda notebook: notebook.update(nbformat_minor=4),
        lambda notebook: notebook["cells"].append(copy.deepcopy(notebook["cells"][0])),
    ],
)
def test_a_written_answer_is_carried_over(change):
    notebook = with_report()
    change(notebook)
    data = json.dumps(notebook).encode()
    made = build_copy(prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN))
    nbformat.validate(made)
    (cell,) = [c for c in graded_cells(made) if c.metadata.nbgrader.grade_id == "write_up"]
    assert cell.cell_type == "markdown"
    assert "".join(cell.source.split()) == "".join(REPORT.split())
    (other,) = [c for c in graded_cells(made) if c.metadata.nbgrader.grade_id == "second_data_set"]
    assert other.source == "YOUR ANSWER HERE"


def test_text_that_may_be_the_answer_is_left_to_a_person():
    notebook = with_report()
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    notebook["cells"] = [*cells, text(REPORT)]
    data = json.dumps(notebook).encode()
    prepared = prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN)
    assert "Somebody will look for it" in " ".join(prepared.notes)
    made = build_copy(prepared)
    (cell,) = [c for c in graded_cells(made) if c.metadata.nbgrader.grade_id == "write_up"]
    assert MISSING_ANSWER_NOTE in cell.source
    assert REPORT in "\n".join(cell.source for cell in made.cells)


def given_text(number):
    """A text cell of lesson 12 as it was given out."""
    cells = json.loads(WRITTEN.released.read_text())["cells"]
    return text("".join(cells[number]["source"]))


def place_of(grade_id):
    cells = json.loads(WRITTEN.released.read_text())["cells"]
    return cells.index(cell_of({"cells": cells}, grade_id))


def written_in(*cells):
    """(the write-up, whether it is certain, sources of all cells, of its own, what is said)."""
    made = prepared_of(code("def match_boxes(a, b, c): return a"), *cells, lesson=WRITTEN)
    answer, place = made.answers["write_up"], made.graded.get("write_up")
    own = None if place is None else made.cells[place].source
    notes = [note for note in made.notes if "write_up" in note]
    return answer.text, answer.certain, [cell.source for cell in made.cells][1:], own, notes


STUB = text("YOUR ANSWER HERE")
OWN = marked(STUB, "write_up")


def prompt():
    """What the write-up is asked for by."""
    return given_text(place_of("write_up") - 1)


def test_an_answer_in_its_own_cell_is_all_of_it():
    answer = marked(text("It finds 14 of 17."), "write_up")
    assert written_in(answer, text("A remark."))[:2] == ("It finds 14 of 17.", True)
    # In two cells of that name, as editors copy them; the empty one says nothing.
    more = marked(text("And 3 more."), "write_up")
    said, certain, cells, own, notes = written_in(OWN, answer, more, text("A remark."))
    assert (said, certain, own) == ("It finds 14 of 17.\n\nAnd 3 more.", True, answer["source"])
    assert cells == ["YOUR ANSWER HERE", "It finds 14 of 17.", "A remark."] and notes == []
    empty = marked(text("  "), "write_up")
    assert written_in(empty)[:2] == ("", True)


@pytest.mark.parametrize(
    ("written", "shown"),
    [
        ("It finds 14 of 17.", "It finds 14 of 17."),
        ("# It finds 14\n\n#of 17.\n## That is all.", "It finds 14\n\nof 17.\nThat is all."),
        ("# Results\nIt finds 14 of 17.", "# Results\nIt finds 14 of 17."),
    ],
)
def test_an_answer_in_a_code_cell_is_text_and_that_is_said(written, shown):
    """Comments are no headings; a heading above a text is one."""
    said, certain, _, own, notes = written_in(code(written, **OWN["metadata"]))
    assert (said, certain, own) == (shown, True, written)
    assert len(notes) == 1 and "write_up stood in a code cell" in notes[0]
    assert written_in(marked(text(written), "write_up"))[::4] == (written, [])
    # A stub that became code says nothing, and nothing is said of it.
    assert written_in(code("YOUR ANSWER HERE", **OWN["metadata"]))[::4] == ("", [])


def test_an_answer_below_its_cell_is_carried_over_up_to_what_is_not_the_students():
    footer = given_text(place_of("write_up") + 1)
    cells = [OWN, text("First."), text(" "), code("x = 1"), text("Second."), footer, text("Third.")]
    said, certain, kept, own, notes = written_in(prompt(), *cells)
    assert (said, certain, own) == ("First.\n\nSecond.", True, "YOUR ANSWER HERE")
    assert kept == [
        *(prompt()["source"], "YOUR ANSWER HERE", " ", "x = 1", footer["source"], "Third.")
    ]
    assert len(notes) == 1 and "but in 2 cells of its own below" in notes[0]
    assert written_in(OWN, text("First."), OWN)[0] == "First."
    stopped = written_in(OWN, text("First."), marked(text("Other."), "test_x"), text("Second."))
    assert stopped[0] == "First." and "in one of its own below" in stopped[4][0]
    assert written_in(OWN, code("x = 1"), text(" "))[:3] == (
        "",
        True,
        ["YOUR ANSWER HERE", "x = 1", " "],
    )


def test_an_answer_whose_cell_was_deleted_is_looked_for_below_its_question():
    said, certain, kept, own, notes = written_in(prompt(), text("First."), text("Second."))
    assert (said, certain, own) == ("First.\n\nSecond.", True, "First.")
    assert kept == [prompt()["source"], "First."] and len(notes) == 1
    assert written_in(prompt(), text("You see 14."), text("And 3."))[0] == "You see 14.\n\nAnd 3."
    # As it was given out, but for its metadata: there is nothing more to look for.
    said, certain, kept, own, notes = written_in(text("A remark."), prompt(), STUB)
    assert (said, certain, own, notes) == ("", True, "YOUR ANSWER HERE", [])
    assert written_in(STUB, prompt())[3] is None  # that is another cell


def test_text_that_may_be_an_answer_is_left_to_a_person_and_nothing_else_is():
    assert written_in(text("A remark."))[:2] == ("", False)
    assert written_in(text("A remark."))[4][0].startswith("The cell for write_up is missing")
    for cells in ([], [text(" ")], [given_text(0)], [code("x = 1")], [prompt()]):
        assert written_in(*cells)[:2] == ("", True)


def test_pictures_of_all_parts_of_an_answer_are_kept():
    parts = [
        {**text(name), "attachments": {f"{name}.png": {"image/png": name}}} for name in ("a", "b")
    ]
    made = prepared_of(code("x = 1"), OWN, *parts, lesson=WRITTEN)
    assert made.answers["write_up"].attachments == {
        "a.png": {"image/png": "a"},
        "b.png": {"image/png": "b"},
    }


def test_where_cells_were_moved_into_an_answer_the_others_are_still_found():
    match = code("def match_boxes(a, b, c): return a")
    made = prepared_of(OWN, text("First."), text("Second."), match, lesson=WRITTEN)
    assert made.cells[made.graded["match_boxes"]].source.startswith("def match_boxes")
    assert len(made.cells) == 2


def test_pictures_stay_and_nothing_else_does():
    notebook = with_report()
    picture = base64.b64encode(b"\x89PNG").decode()
    cell_of(notebook, "write_up").update(
        source="![](attachment:a.png)",
        attachments={
            "a.png": {"image/png": picture, "text/html": "<script>"},
            'b" onerror="alert(1)': {"image/png": picture},
            "c.png": {'image/png" onerror="alert(1)': picture},
            "d.png": {"image/png": '" onerror="alert(1)'},
            "e.svg": {"image/svg+xml": picture},
        },
    )
    data = json.dumps(notebook).encode()
    made = build_copy(prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN))
    (cell,) = [c for c in graded_cells(made) if c.metadata.nbgrader.grade_id == "write_up"]
    assert cell.attachments == {"a.png": {"image/png": picture}}


@pytest.mark.end_to_end
def test_a_picture_that_is_not_there_stops_no_page():
    text_with = "![](attachment:gone.png) [a]: attachment:b%20c.png <x attachment:>"
    notebook = json.loads(fill_in(WRITTEN, {"write_up": text_with}))
    picture = {"b c.png": {"image/png": base64.b64encode(b"png").decode()}}
    notebook["cells"].append({**text(text_with), "attachments": picture})
    data = json.dumps(notebook).encode()
    made = build_copy(prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN))
    page, _ = HTMLExporter().from_notebook_node(made)
    assert "gone.png" in page


def test_what_a_student_changed_in_our_cells_is_shown_beside_them():
    notebook = whole()
    cell_of(notebook, "test_voxel_grid")["source"] = "voxel_grid = print"
    data = json.dumps(notebook).encode()
    made = build_copy(prepare(SubmittedFiles("06_filter_ground.ipynb", data), LESSON))
    sources = [cell.source for cell in made.cells if "nbgrader" not in cell.metadata]
    assert "voxel_grid = print" in sources


def test_a_copy_of_a_copy_is_the_same():
    notebook = with_report()
    notebook["cells"].append(text("<b>x</b> [a](javascript:b) $\\href{x}{y}$"))
    notebook["cells"].append({"cell_type": "raw", "metadata": {}, "source": "```\n<script>"})
    data = json.dumps(notebook).encode()
    once = build_copy(prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN))
    again = SubmittedFiles("12_streaming_obstacles.ipynb", nbformat.writes(once).encode())
    for one, other in zip(build_copy(prepare(again, WRITTEN)).cells, once.cells, strict=True):
        assert one == other
