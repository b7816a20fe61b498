"""The preflight repairs damaged notebooks without loss of points, and notes each repair."""

import dataclasses
import gzip
import json
import re

import nbformat
import numpy as np
import pytest

from grader.classroom import lesson_recognition
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
from grader.judging.verdict import FAILED
from grader.lms.autograded_copy import build_copy, graded_cells
from tests.damaged_notebooks import EARNS_EVERYTHING, changed_notebook, merge_cells, zip_of
from tests.notebook_cells import (
    EXERCISES,
    LESSON,
    cell_of,
    code,
    from_cells,
    right_answer,
    right_notebook,
    text,
    with_grade_id,
)
from tests.students import answers_in
from utils.notebooks.reading import UnreadableNotebook

OTHER_LESSON = find_lesson("07_filter_by_distance")
LFS_POINTER = (
    b"version https://git-lfs.github.com/spec/v1\n"
    b"oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 9\n"
)


@pytest.mark.parametrize("change, message", EARNS_EVERYTHING.values(), ids=EARNS_EVERYTHING)
def test_damage_to_a_file_costs_no_points(change, message):
    """All code is found, the graded copy is complete and valid, and a note reports each repair."""
    prepared = prepare(SubmittedFiles("06_filter_ground.ipynb", changed_notebook(change)), LESSON)
    answers = answers_in(LESSON, prepared.code)
    cloud = np.array([[0.0, 0, -2, 1], [1, 1, 1, 1], [1.01, 1, 1, 0]])
    assert len(answers["filter_ground"](cloud)) == 2
    assert len(answers["voxel_grid"](cloud, 0.5)) == 2
    notes = " ".join(prepared.notes)
    assert (message in notes) if message else notes == ""
    json.dumps(dataclasses.asdict(prepared), default=str, ensure_ascii=False).encode()
    graded_copy = build_copy(prepared)
    nbformat.validate(graded_copy)
    names = [cell.metadata.nbgrader.grade_id for cell in graded_cells(graded_copy)]
    assert sorted(names) == sorted([*EXERCISES, *(f"test_{name}" for name in EXERCISES)])
    copied = {cell.metadata.nbgrader.grade_id: cell.source for cell in graded_cells(graded_copy)}
    merged = ["filter_ground"] if change is merge_cells else []
    for name in EXERCISES:
        if name in merged:
            assert copied[name] == f"# {name} is in the cell of another exercise."
        else:
            assert f"def {name}" in copied[name]
        assert "NotImplementedError" not in copied[name]
        assert copied[f"test_{name}"] == f"check({name})"


SELECTED_CHANGES = (
    "cut off after the answers",
    "answers in text cells",
    "an old format",
    "huge outputs",
)


@pytest.mark.slow
@pytest.mark.parametrize("name", SELECTED_CHANGES)
def test_the_judge_gives_full_marks_to_a_damaged_file_with_right_answers(name, sandbox):
    change, message = EARNS_EVERYTHING[name]
    verdict = judge_files(
        SubmittedFiles("06_filter_ground.ipynb", changed_notebook(change)), 1, sandbox, LESSON
    )
    assert verdict.score == 30
    assert message in " ".join(verdict.problems)


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda notebook: b"\x89PNG\r\n\x1a\n\x00\xff\xfe", "it is not text"),
        (lambda notebook: "", "is empty"),
        (lambda notebook: "\0" * 100, "is empty"),
        (lambda notebook: "[]", "no cells"),
        (lambda notebook: '{"cells": 7}', "no cells"),
        (lambda notebook: '{"cells": [{"a": {"b"', "not valid JSON"),
        (lambda notebook: '{"cells": [' + "[]," * 2_100_000 + "[]]}", "Clear its outputs"),
        (lambda notebook: json.dumps("[]," * 2_100_000), "Clear its outputs"),
        (lambda notebook: "\n<!DOCTYPE html>\n<html>{}</html>", "is a web page"),
        (lambda notebook: b"\xef\xbb\xbf<html>", "is a web page"),
        (lambda notebook: b"\x00\x05\x16\x07" + bytes(400), "attributes of a file on a Mac"),
        (lambda notebook: b"%PDF-1.7 \xff", "is a PDF"),
        (lambda notebook: LFS_POINTER, "is a Git LFS pointer"),
        (
            lambda notebook: zip_of("{}", "a.ipynb", "b.ipynb"),
            "is a zip file with 2 notebooks in it",
        ),
        (lambda notebook: zip_of("{}", "word.xml"), "is a zip file with no notebook in it"),
        (lambda notebook: zip_of("{}", "a.ipynb")[:-9], "is a zip file that cannot be unpacked"),
        (lambda notebook: gzip.compress(b"{}")[:4] + b"\xff" * 9, "is a gzip file that cannot"),
        (lambda notebook: gzip.compress(bytes(65 * 2**20)), "unpacks to more than 64 MB"),
    ],
)
def test_an_unreadable_file_is_shown_as_released(change, message):
    submission = SubmittedFiles("06_filter_ground.ipynb", changed_notebook(change))
    with pytest.raises(UnreadableNotebook, match=message):
        prepare(submission, LESSON)
    graded_copy = build_copy(prepare_to_show(submission, LESSON))
    nbformat.validate(graded_copy)
    assert len(graded_cells(graded_copy)) == 4


@pytest.mark.slow
@pytest.mark.parametrize(
    "notebook, message",
    [
        (
            lambda: json.loads(find_lesson("05_euclidean_clustering").released.read_text()),
            "contains the notebook of 05_euclidean_clustering",
        ),
        (lambda: {"cells": [], "metadata": {}, "nbformat": 4}, " contains no code."),
        (lambda: {"cells": [text("# my essay")], "nbformat": 4}, " contains no code."),
    ],
)
def test_a_submission_without_code_of_this_lesson_gets_a_message(notebook, message, sandbox):
    data = json.dumps(notebook()).encode()
    verdict = judge_files(SubmittedFiles("06_filter_ground.ipynb", data), 1, sandbox, LESSON)
    assert verdict.score == 0
    assert message in " ".join(verdict.problems)


def test_several_versions_are_reported_only_if_points_are_lost(sandbox):
    notebook = right_notebook()
    notebook["cells"].insert(1, code("def voxel_grid(cloud): return 3"))
    submission = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(submission, 1, sandbox, LESSON)
    assert verdict.score == 30 and verdict.problems == ()
    notebook["cells"].append(code("def voxel_grid(cloud, size): return 3"))
    submission = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(submission, 1, sandbox, LESSON)
    assert verdict.score == 10
    message = r"voxel_grid is defined 3 times, in code cells 1, \d+ and \d+\. The last definition"
    assert re.search(message, " ".join(verdict.problems))
    assert "The last definition counts" in " ".join(verdict.problems)


def test_a_note_names_the_submitted_module_that_was_used():
    notebook = right_notebook()
    notebook["cells"].insert(0, code("from helpers import mask"))
    modules = {"helpers": "mask = 1", "other": ""}
    submission = SubmittedFiles("x.ipynb", json.dumps(notebook).encode(), modules=modules)
    assert (
        "The judge used helpers.py, which you submitted with the notebook."
        in prepare(submission, LESSON).notes
    )


def test_a_module_that_a_cell_writes_can_be_imported(sandbox):
    notebook = right_notebook()
    written = (
        "%%writefile helpers.py\ndef keep(cloud, level):\n    return cloud[cloud[:, 2] >= level]\n"
    )
    answer = (
        "from helpers import keep\n"
        "def filter_ground(cloud, ground_level=-1.2):\n    return keep(cloud, ground_level)"
    )
    notebook["cells"] += [code(written), code(answer)]
    submission = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(submission, 1, sandbox, LESSON)
    assert verdict.score == 30
    assert verdict.problems[0] == "The judge used helpers.py, which a cell in the notebook writes."


def test_too_much_code_is_refused_with_a_sentence():
    notebook = right_notebook()
    notebook["cells"].append(code(f"TABLE = '{'7' * 17 * 2**20}'"))
    submission = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    (problem,) = judge_files(submission, 1, None, LESSON).problems
    assert (
        "the code cells contain 17 MB, but the judge reads at most 15 MB. Delete the cells"
        in problem
    )


@pytest.mark.parametrize("written", [0, 8])
def test_too_many_modules_are_refused_with_a_sentence(written):
    """Modules are part of the message to the sandbox, and so is the cell that writes one."""
    notebook = right_notebook()
    notebook["cells"].append(code(f"%%writefile m.py\nTABLE = '{'7' * written * 2**20}'"))
    modules = {} if written else {f"m{number}": "7" * 2**20 for number in range(16)}
    data = json.dumps(notebook).encode()
    submission = SubmittedFiles("06_filter_ground.ipynb", data, modules=modules)
    (problem,) = judge_files(submission, 1, None, LESSON).problems
    assert "the code cells and modules contain 16 MB, but the judge reads at most 15 MB." in problem


def test_an_async_answer_takes_precedence_over_a_copy_of_the_stub_below_it(sandbox):
    notebook = right_notebook()
    own = cell_of(notebook, "filter_ground")
    own["source"] = (
        "async " + right_answer("filter_ground")[right_answer("filter_ground").index("def ") :]
    )
    notebook["cells"].append(stub_of("filter_ground"))
    submission = SubmittedFiles("06_filter_ground.ipynb", json.dumps(notebook).encode())
    verdict = judge_files(submission, 1, sandbox, LESSON)
    assert "Delete `async` before `def`." in verdict.exercises[0].tests[0].message
    assert "A copy of the released cell is below your filter_ground" in verdict.problems[0]


def test_a_cut_off_file_keeps_the_complete_answer():
    data = json.dumps(right_notebook())
    end = data.index("def voxel_grid") + 20
    prepared = prepare(SubmittedFiles("06_filter_ground.ipynb", data[:end].encode()), LESSON)
    assert "filter_ground" in prepared.graded and "voxel_grid" not in prepared.graded
    assert "cut off" in prepared.notes[0]


def test_an_incomplete_file_never_counts_as_untouched():
    released = LESSON.released.read_bytes()
    assert lesson_recognition.content_of(released, "a.ipynb").untouched
    assert not lesson_recognition.content_of(released[:-9], "a.ipynb").untouched
    with_odd_cell = json.loads(released)
    with_odd_cell["cells"].append(7)
    assert not lesson_recognition.content_of(
        json.dumps(with_odd_cell).encode(), "a.ipynb"
    ).untouched

    whole = SubmittedFiles("06_filter_ground.ipynb", released)
    assert preflight.prepare_to_judge(whole, LESSON).is_as_released
    whole = SubmittedFiles("06_filter_ground.ipynb", json.dumps(with_odd_cell).encode())
    assert not preflight.prepare_to_judge(whole, LESSON).is_as_released

    only_text = json.dumps({"cells": [text("a"), text("b")]})
    for data, message in ((only_text, "contains no code"), (only_text[:-9], "cut off after 1")):
        (note,) = prepare(SubmittedFiles("06_filter_ground.ipynb", data.encode()), LESSON).notes
        assert message in note


def test_a_file_that_git_has_not_downloaded_gets_no_mark():
    submission = SubmittedFiles("06_filter_ground.ipynb", LFS_POINTER)
    verdict = judge_files(submission, 1, None, LESSON)
    assert verdict.status == FAILED and "Run `git lfs pull`" in verdict.reason


# ---- One step at a time --------------------------------------------------------------------


TEXT = ("markdown", "raw")
GROUND = "def filter_ground(cloud):\n    return {}"
VOXELS = "def voxel_grid(cloud):\n    return {}"


def test_prepared_notebooks_are_immutable():
    for kind in (WrittenAnswer, PreparedNotebook, JudgeInput):
        assert kind.__dataclass_params__.frozen
    assert WrittenAnswer("a").is_certain
    assert preflight.cells_as_released(LESSON) is preflight.cells_as_released(LESSON)  # read once


@pytest.mark.parametrize(
    ("cells", "kinds"),
    [
        # A text cell that quotes code remains text, even if it is an exercise's cell.
        ([text("```\n" + GROUND + "\n```")], ["markdown"]),
        (
            [with_grade_id(text("Like this:\n```\n" + GROUND + "\n```"), "filter_ground")],
            ["markdown"],
        ),
        ([text("Above: def filter_ground(cloud)")], ["markdown"]),
        ([text(GROUND), code(VOXELS)], ["code", "code"]),
        # If a code cell also defines the function, the text cell is taken for an old version.
        ([text(GROUND), code(GROUND)], ["markdown", "code"]),
        ([code(GROUND), text(GROUND)], ["code", "markdown"]),
        ([with_grade_id(text(GROUND), "filter_ground"), code(GROUND)], ["markdown", "code"]),
        ([with_grade_id(text(GROUND), "voxel_grid"), code(GROUND)], ["markdown", "code"]),
        ([code(GROUND), with_grade_id(text(GROUND), "voxel_grid")], ["code", "markdown"]),
        (
            [code(GROUND), with_grade_id(text(GROUND), "filter_ground"), code(GROUND)],
            ["code", "markdown", "code"],
        ),
        # A text cell with the exercise's ID is the answer, and code above it was an attempt.
        ([code(GROUND), with_grade_id(text(GROUND), "filter_ground")], ["code", "code"]),
        ([with_grade_id(text("My answer."), "filter_ground")], ["markdown"]),
        # The first of several text cells counts.
        ([text(GROUND), text(GROUND)], ["code", "markdown"]),
        ([text(GROUND + "\n" + VOXELS), text(VOXELS)], ["code", "markdown"]),
        # A function that no other cell defines is not lost.
        ([text(GROUND + "\n" + VOXELS), code(VOXELS)], ["code", "code"]),
    ],
)
def test_only_text_cells_with_needed_answers_are_treated_as_code(cells, kinds):
    prepared = from_cells(*cells)
    assert [cell.kind for cell in prepared.cells] == kinds
    assert prepared.code == tuple(cell.source for cell in prepared.cells if cell.kind not in TEXT)
    converted = sum(cell["cell_type"] != "code" for cell in cells) - kinds.count("markdown")
    notes = [note for note in prepared.notes if "in a text cell, which Jupyter" in note]
    assert len(notes) == converted and all(note.split()[0] in EXERCISES for note in notes)


def returned_text(prepared, name):
    """Return the text after `return` in the last code cell that defines a function."""
    last = next(source for source in reversed(prepared.code) if f"def {name}" in source)
    return last.split(f"def {name}(cloud):\n    return ")[1].split("\n")[0]


BOTH_FUNCTIONS = GROUND.format(1) + "\n" + VOXELS.format(2)


@pytest.mark.parametrize("is_reversed", [False, True])
@pytest.mark.parametrize(
    ("cells", "ground", "voxels"),
    [
        # Functions in code cells take precedence at any position; the text cell adds the others.
        ([text(BOTH_FUNCTIONS), code(GROUND.format(3))], "3", "2"),
        ([code(GROUND.format(3)), text(BOTH_FUNCTIONS)], "3", "2"),
        (
            [code(GROUND.format(4)), code(GROUND.format(3)), text("Mine."), text(BOTH_FUNCTIONS)],
            "3",
            "2",
        ),
        ([code(VOXELS.format(3)), text(BOTH_FUNCTIONS)], "1", "3"),
        ([text(BOTH_FUNCTIONS), code(VOXELS.format(3))], "1", "3"),
        ([code(GROUND.format(3)), with_grade_id(text(BOTH_FUNCTIONS), "voxel_grid")], "3", "2"),
        # The first of two text cells also takes precedence over the second.
        ([text(GROUND.format(3)), text(BOTH_FUNCTIONS)], "3", "2"),
        (
            [
                code(GROUND.format(3)),
                text(BOTH_FUNCTIONS),
                with_grade_id(text(BOTH_FUNCTIONS), "voxel_grid"),
            ],
            "3",
            "2",
        ),
    ],
)
def test_a_definition_in_another_cell_takes_precedence_over_a_text_cell(
    cells, ground, voxels, is_reversed
):
    if is_reversed:  # the order of definitions within a cell does not matter
        swapped = VOXELS.format(2) + "\n" + GROUND.format(1)
        cells = [
            {**cell, "source": cell["source"].replace(BOTH_FUNCTIONS, swapped)} for cell in cells
        ]
    made = from_cells(code("import numpy as np"), *cells)
    assert (returned_text(made, "filter_ground"), returned_text(made, "voxel_grid")) == (
        ground,
        voxels,
    )
    # Code that ran in Jupyter keeps its order.
    ran = [cell["source"] for cell in cells if cell["cell_type"] == "code"]
    assert [source for source in made.code if source in ran] == ran
    notes = [note for note in made.notes if "in a text cell, which Jupyter" in note]
    judged, other = ("voxel_grid", "filter_ground") if voxels == "2" else EXERCISES
    assert notes[-1] == (
        f"{judged} was in a text cell, which Jupyter does not run. The grader judged it as code. "
        f"For {other}, it judged the code in another cell. In Jupyter, select the cell and press Y "
        f"to make it a code cell again, and delete {other} from it."
    )


@pytest.mark.parametrize(
    ("cells", "order"),
    [
        # The text cell moves to just above the code that counts, below cells that it may need.
        (
            ["x = 1", "y = 2", GROUND, text(BOTH_FUNCTIONS)],
            ["x = 1", "y = 2", BOTH_FUNCTIONS, GROUND],
        ),
        # A text cell that is already above the code stays, because cells in between may call it.
        (
            ["x = 1", text(BOTH_FUNCTIONS), "voxel_grid(x)", GROUND],
            ["x = 1", BOTH_FUNCTIONS, "voxel_grid(x)", GROUND],
        ),
    ],
)
def test_a_text_cell_is_moved_above_the_code_that_defines_its_function(cells, order):
    prepared = from_cells(*(code(cell) if isinstance(cell, str) else cell for cell in cells))
    assert list(prepared.code) == order


def test_a_text_cell_is_judged_for_the_only_function_not_defined_elsewhere():
    """Code takes precedence over text, and the first text cell over later ones.

    A text cell that also defines other functions moves above the cells that count for them.
    """

    def cell(number, *names):
        return text("\n".join(f"def {name}(cloud):\n    return {number}" for name in names))

    distance, crop, ego = (exercise.name for exercise in OTHER_LESSON.machine_graded)
    above = code(cell(1, distance)["source"])
    prepared = from_cells(above, cell(2, distance, crop), cell(3, crop, ego), lesson=OTHER_LESSON)
    assert [returned_text(prepared, name) for name in (distance, crop, ego)] == ["1", "2", "3"]
    prepared = from_cells(above, cell(2, crop), cell(3, distance, crop, ego), lesson=OTHER_LESSON)
    assert [returned_text(prepared, name) for name in (distance, crop, ego)] == ["1", "2", "3"]
    assert prepared.notes[1] == (
        f"{ego} was in a text cell, which Jupyter does not run. The grader judged it as code. "
        f"For {distance} and {crop}, it judged the code in another cell. In Jupyter, select the "
        "cell and press Y to make it a code cell again, and delete "
        f"{distance} and {crop} from it."
    )


def test_a_text_cell_with_all_functions_is_judged_as_code():
    prepared = from_cells(text(BOTH_FUNCTIONS))
    assert prepared.code == (BOTH_FUNCTIONS,)
    assert prepared.notes == (
        "filter_ground and voxel_grid were in a text cell, which Jupyter does not run. The grader "
        "judged them as code. In Jupyter, select the cell and press Y to make it a code cell "
        "again.",
    )


def test_an_answer_in_a_text_cell_takes_precedence_over_the_stub():
    for cells in (
        [stub_of("filter_ground"), text(BOTH_FUNCTIONS)],
        [text(BOTH_FUNCTIONS), stub_of("filter_ground")],
    ):
        prepared = from_cells(*cells)
        assert (
            returned_text(prepared, "filter_ground") == "1"
            and returned_text(prepared, "voxel_grid") == "2"
        )
        assert "filter_ground and voxel_grid were in a text cell" in prepared.notes[0]


def stub_of(name):
    return code("".join(cell_of(json.loads(LESSON.released.read_text()), name)["source"]))


def test_stubs_are_omitted_only_below_an_answer():
    ground, voxels, left = stub_of("filter_ground"), stub_of("voxel_grid"), "# Left out"
    answer, second_answer = code(GROUND.format(1)), code(GROUND.format(2))
    for cells, expected in (
        ([ground], [False]),
        ([ground, ground], [False, False]),
        ([ground, answer], [False, False]),
        ([answer, ground, second_answer], [False, False, False]),
        ([answer, ground, voxels, ground], [False, True, False, True]),
        ([ground, answer, second_answer, ground], [False, False, False, True]),
    ):
        made = from_cells(*cells)
        assert [cell.source.startswith(left) for cell in made.cells] == expected
        notes = [
            note
            for note in made.notes
            if note.startswith("A copy of the released cell is below your filter_ground")
        ]
        assert len(notes) == any(expected)
        last = made.cells[made.graded["filter_ground"]].source
        assert not last.startswith(left) and "filter_ground" in last


def test_one_cell_is_chosen_as_the_answer_to_an_exercise():
    other = code("x = 1")
    for cells, index in (
        ([code(GROUND), other, code(GROUND), other], 2),
        ([with_grade_id(code(GROUND), "filter_ground"), other, code(GROUND)], 0),
        ([with_grade_id(other, "filter_ground"), code(GROUND), other], 1),
        (
            [
                other,
                with_grade_id(other, "filter_ground"),
                with_grade_id(other, "filter_ground"),
                other,
            ],
            2,
        ),
        ([with_grade_id(code(GROUND), "filter_ground")] * 2 + [other], 1),
        ([other, with_grade_id(text("Some text."), "filter_ground")], None),
        ([other, with_grade_id(other, "voxel_grid")], None),
    ):
        assert from_cells(*cells).graded.get("filter_ground") == index


@pytest.mark.parametrize(
    ("source", "is_written"),
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
def test_only_a_top_level_definition_of_its_name_answers_an_exercise(source, is_written):
    assert ("filter_ground" in from_cells(code(source)).graded) == is_written


def test_another_lessons_notebook_is_reported_if_this_lesson_is_missing():
    other = "07_filter_by_distance"
    submitted = from_cells(code("x = 1"), lesson_name=other, name="06_filter_ground (1).ipynb")
    assert submitted.notes == (
        f"06_filter_ground (1).ipynb contains the notebook of {other} instead of "
        f"{LESSON.name}. Submit {LESSON.name}.ipynb.",
    )
    earlier = from_cells(code("x = 1"), lesson_name="05_euclidean_clustering")
    assert "contains the notebook of 05_euclidean_clustering instead of 06" in earlier.notes[0]
    assert from_cells(code(GROUND), lesson_name=other).notes == ()
    assert from_cells(code("x = 1"), lesson_name=LESSON.name).notes == ()
    assert from_cells(code("x = 1")).notes == ()
    empty = from_cells(code(" \n"), text("Some text."))
    assert [note.partition(". ")[0] for note in empty.notes] == [
        "06_filter_ground.ipynb contains no code"
    ]
    functions = "def filter_by_distance(c): pass\ndef crop_region(c, a, b): pass"
    submitted = from_cells(code(functions), lesson_name=LESSON.name)
    assert submitted.notes == (
        "06_filter_ground.ipynb contains filter_by_distance and crop_region from "
        "07_filter_by_distance, and none of the functions from 06_filter_ground. Submit "
        "06_filter_ground.ipynb.",
    )
    assert from_cells(code(f"{functions}\n{GROUND}")).notes == ()
    long = from_cells(code("x = 1"), lesson_name="07" * 50)
    assert f"of {'07' * 30} instead" in long.notes[0]


@pytest.mark.parametrize(
    ("source", "used"),
    [
        ("import helpers", "The judge used helpers.py, which you submitted with the notebook."),
        ("x = 1\n    from\thelpers import mask", "The judge used helpers.py, which"),
        (
            "import helpers\nimport tools",
            "The judge used helpers.py, tools.py, which",
        ),
        ("import helpers2, tools2", None),
        ("# import helpers", None),
        ("reimport helpers", None),
    ],
)
def test_notes_name_the_modules_that_are_used(source, used):
    made = from_cells(code(source), text("import tools"), modules={"helpers": "", "tools": ""})
    assert len(made.notes) == (used is not None)
    assert all(note.startswith(used) for note in made.notes)


@pytest.mark.parametrize(
    ("command", "name"),
    [
        ("%%writefile helpers.py", "helpers"),
        ('  %%file "helpers.py"', "helpers"),
        ("%%writefile ./helpers.py", "helpers"),
        ("%%writefile -a helpers.py", "helpers"),
        ("%%writefile --append ./helpers.py", "helpers"),
        ("%%writefile helpers.txt", None),
        ("%%timeit", None),
    ],
)
def test_only_cells_that_write_a_python_file_create_a_module(command, name):
    written = code(f"{command}\nx = 1"), text("%%writefile no.py\nx = 1")
    made = from_cells(*written, code("import helpers"))
    assert made.modules == ({name: "x = 1"} if name else {})
    used = f"The judge used {name}.py, which a cell in the notebook writes."
    assert made.notes == ((used,) if name else ())
    assert from_cells(*written).notes == (), "no module was used"


def test_a_cell_can_append_to_a_module():
    append = code("%%writefile -a helpers.py\ny = 2")
    made = from_cells(code("%%writefile helpers.py\nx = 1"), append)
    assert made.modules == {"helpers": "x = 1\ny = 2"}
    made = from_cells(append, append, modules={"helpers": "x = 1"})
    assert made.modules == {"helpers": "x = 1\ny = 2\ny = 2"}


@pytest.mark.parametrize("path", ["../helpers.py", '"/content/helpers.py"', "{folder}/helpers.py"])
def test_an_imported_file_that_is_written_elsewhere_is_named(path):
    cells = [text("Some text."), code("x = 1"), code(f"%%writefile {path}\nx = 1")]
    made = from_cells(*cells, code("from helpers import x"))
    assert made.modules == {} and made.notes == (
        "Code cell 2 writes helpers.py to a place that the judge does not have. Submit helpers.py "
        "next to the notebook.",
    )
    assert from_cells(*cells, code("import other")).notes == (), "no module was used"
    submitted = from_cells(*cells, code("import helpers"), modules={"helpers": "x = 1"})
    assert submitted.notes == ("The judge used helpers.py, which you submitted with the notebook.",)


def test_a_notebook_may_write_twenty_modules():
    made = from_cells(*(code(f"%%writefile m{number}.py\nx = 1") for number in range(30)))
    assert [*made.modules] == [f"m{number}" for number in range(20)]


def test_the_first_four_versions_and_the_last_are_listed():
    def versions(number):
        cells = [code("x = 1"), text("Some text.")]
        cells += [code(GROUND.format(version)) for version in range(number)]
        return from_cells(*cells).versions.get("filter_ground", "")

    assert versions(1) == ""
    assert versions(2).startswith("filter_ground is defined 2 times, in code cells 2 and 3. The")
    assert "5 times, in code cells 2, 3, 4, 5 and 6. The" in versions(5)
    assert "6 times, in code cells 2, 3, 4, 5, … and 7. The" in versions(6)
    same = from_cells(code(GROUND), stub_of("filter_ground"), code(GROUND), code(VOXELS))
    assert same.versions == {}


def test_a_students_changes_to_course_cells_are_shown_next_to_them():
    notebook = right_notebook()
    cell_of(notebook, "test_voxel_grid")["source"] = "voxel_grid = print"
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(prepare(SubmittedFiles("06_filter_ground.ipynb", data), LESSON))
    sources = [cell.source for cell in graded_copy.cells if "nbgrader" not in cell.metadata]
    assert "voxel_grid = print" in sources
