"""Damage that editors, browsers and disks do to notebooks is repaired and costs no points."""

import base64
import copy
import dataclasses
import gzip
import io
import json
import re
import zipfile

import nbformat
import numpy as np
import pytest
from nbconvert.exporters import HTMLExporter

from grader.classroom import lesson_recognition
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
from grader.judging.verdict import FAILED
from grader.lms.autograded_copy import MISSING_ANSWER_NOTE, build_copy, graded_cells
from tests.students import answers_in
from utils.notebooks.reading import UnreadableNotebook

LESSON = find_lesson("06_filter_ground")
OTHER_LESSON = find_lesson("07_filter_by_distance")
WRITTEN_LESSON = find_lesson("12_streaming_obstacles")
EXERCISES = ("filter_ground", "voxel_grid")
LFS_POINTER = (
    b"version https://git-lfs.github.com/spec/v1\n"
    b"oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\nsize 9\n"
)
REPORT = "I widened the region to 18.5 m, because the lorry *stands* at 17 m."


def right_answer(exercise):
    return next(variant.source for variant in answers_to(exercise) if variant.right)


def right_notebook():
    """Return a notebook of lesson 06 with right answers, as JSON."""
    return json.loads(fill_in(LESSON, {name: right_answer(name) for name in EXERCISES}))


def with_report():
    """Return a notebook of lesson 12 with a written answer, as JSON."""
    return json.loads(fill_in(WRITTEN_LESSON, {"write_up": REPORT}))


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


def changed_notebook(change):
    """Return the bytes of the right notebook after a change.

    `change` may edit the notebook in place, or return another notebook, text or bytes.
    """
    notebook = right_notebook()
    result = change(notebook)
    result = notebook if result is None else result
    if isinstance(result, dict):
        result = json.dumps(result)
    return result if isinstance(result, bytes) else result.encode("utf-8", "surrogatepass")


def change_each_cell(edit):
    def change(notebook):
        for cell in notebook["cells"]:
            edit(cell)

    return change


def retype(kind):
    def change(notebook):
        for name in EXERCISES:
            cell = cell_of(notebook, name)
            cell["cell_type"] = kind
            del cell["outputs"], cell["execution_count"]

    return change


def split_cell(notebook):
    cells = notebook["cells"]
    index = cells.index(cell_of(notebook, "voxel_grid"))
    cells.insert(index, code("import numpy as np"))
    cells[index + 1]["metadata"] = {}


def merge_cells(notebook):
    first, second = (cell_of(notebook, name) for name in EXERCISES)
    first["source"] = "".join(first["source"]) + "\n\n" + "".join(second["source"])
    notebook["cells"].remove(second)


def old_format(notebook):
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


def update_notebook(**entries):
    return lambda notebook: notebook.update(entries)


def conflict(ours, theirs, base=()):
    """Return a change that puts a merge conflict between lines into the first `execution_count`.

    Each argument is one side of the conflict, as a list of lines.
    """

    def change(notebook):
        lines = json.dumps(notebook, indent=1).split("\n")
        place = next(n for n, line in enumerate(lines) if '"execution_count"' in line)
        middle = ["||||||| 12ab", *base] if base else []
        lines[place : place + 1] = [
            *["<<<<<<< HEAD", *ours, *middle],
            *["=======", *theirs, ">>>>>>> origin/main"],
        ]
        return "\n".join(lines)

    return change


def conflict_in_code(notebook):
    cell = cell_of(notebook, "filter_ground")
    source = "".join(cell["source"])
    theirs = source.replace("return", "return None and")
    cell["source"] = f"<<<<<<< local\n{source}\n=======\n{theirs}\n>>>>>>> remote\n"


def zip_of(content, *names):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name in names:
            archive.writestr(name, content)
    return buffer.getvalue()


def nested_output(notebook):
    cell = cell_of(notebook, "voxel_grid")
    cell["outputs"] = [{"output_type": "display_data", "metadata": {}, "data": {"a": "DEEP"}}]
    return json.dumps(notebook).replace('"DEEP"', "[" * 5000 + '"]"' + "]" * 5000)


def lone_surrogates(notebook):
    cell = cell_of(notebook, "voxel_grid")
    cell["source"] = "".join(cell["source"]) + "\n# \ud83d half of \U0001f600"
    notebook["cells"].append(with_grade_id(text("\ude00"), "\ud83d"))
    notebook["metadata"]["lidar_obstacle_lab"] = {"lesson": "\ud83d"}


def big_outputs(notebook):
    junk = {"output_type": "stream", "name": "stdout", "text": "[{" * 2_000_000}
    notebook["cells"][1]["outputs"] = [junk]


# Changes that can happen to a file, by name. Each comes with words that the note to the student
# must contain, or "" if no note is needed.
EARNS_EVERYTHING = {
    "nothing at all": (lambda notebook: None, ""),
    "a byte order mark": (lambda notebook: b"\xef\xbb\xbf" + json.dumps(notebook).encode(), ""),
    "UTF-16": (lambda notebook: json.dumps(notebook).encode("utf-16"), ""),
    "an encoding of Windows": (
        lambda notebook: json.dumps(
            notebook | {"cells": [*notebook["cells"], text("Größe")]}, ensure_ascii=False
        ).encode("cp1252", "replace"),
        "not encoded in UTF-8",
    ),
    "line ends of Windows": (
        lambda notebook: json.dumps(notebook, indent=1).replace("\n", "\r\n"),
        "",
    ),
    "zeros at the end": (lambda notebook: json.dumps(notebook) + "\0" * 4096, ""),
    "text after the end": (
        lambda notebook: json.dumps(notebook) + "<html>",
        "continues after the end",
    ),
    "a second copy after the end": (lambda notebook: json.dumps(notebook) * 2, "second copy"),
    "cut off after the answers": (
        lambda notebook: json.dumps(notebook)[: int(len(json.dumps(notebook)) * 0.98)],
        "cut off",
    ),
    "metadata missing": (lambda notebook: notebook.pop("metadata") and None, ""),
    "metadata null": (update_notebook(metadata=None), ""),
    "no cell has metadata": (change_each_cell(lambda cell: cell.pop("metadata")), ""),
    "metadata of cells null": (change_each_cell(lambda cell: cell.update(metadata=None)), ""),
    "metadata of cells a list": (change_each_cell(lambda cell: cell.update(metadata=[])), ""),
    "no ids": (change_each_cell(lambda cell: cell.pop("id", None)), ""),
    "all ids the same": (change_each_cell(lambda cell: cell.update(id="a")), ""),
    "ids that are numbers": (change_each_cell(lambda cell: cell.update(id=7)), ""),
    "ids in an older format": (update_notebook(nbformat_minor=4), ""),
    "a format from the future": (update_notebook(nbformat=5), ""),
    "an old format": (old_format, ""),
    "outputs in text cells": (change_each_cell(lambda cell: cell.update(outputs=[])), ""),
    "no outputs at all": (change_each_cell(lambda cell: cell.pop("outputs", None)), ""),
    "no execution counts": (change_each_cell(lambda cell: cell.pop("execution_count", None)), ""),
    "tags twice": (change_each_cell(lambda cell: cell["metadata"].update(tags=["a", "a"])), ""),
    "attachments that are null": (change_each_cell(lambda cell: cell.update(attachments=None)), ""),
    "widgets without state": (
        lambda notebook: notebook["metadata"].update(widgets={"application/x": {}}),
        "",
    ),
    "Colab's metadata": (
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
            retype("markdown")(notebook) or change_each_cell(lambda c: c.pop("metadata"))(notebook)
        ),
        "press Y",
    ),
    "cells in another order": (
        lambda notebook: notebook["cells"].sort(key=lambda cell: cell["cell_type"] != "code"),
        "",
    ),
    "a cell split": (split_cell, ""),
    "two cells merged": (merge_cells, ""),
    "an answer twice": (
        lambda notebook: notebook["cells"].append(copy.deepcopy(cell_of(notebook, "voxel_grid"))),
        "",
    ),
    "an answer twice, the first one wrong": (
        lambda notebook: notebook["cells"].insert(1, code("def voxel_grid(cloud): return 3")),
        "",
    ),
    "the released cell, pasted at the end": (
        lambda notebook: notebook["cells"].append(
            cell_of(json.loads(LESSON.released.read_text()), "voxel_grid")
        ),
        "A copy of the released cell",
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
    "a cell that is a number": (lambda n: n["cells"].append(7), "1 entry of"),
    "a cell that is null": (lambda n: n["cells"].append(None), "1 entry of"),
    "a merge conflict in a number": (
        conflict(['   "execution_count": 3,'], ['   "execution_count": 4,']),
        "Your side (HEAD) was judged",
    ),
    "a merge conflict with the version before": (
        conflict(["", '   "execution_count": 3,'], ['   "execution_count": 4,'], ['   "x": 4,']),
        "Your side (HEAD) was judged",
    ),
    "a merge conflict of which one side is valid": (
        conflict(['   "execution_count": 3'], ['   "execution_count": 4,']),
        "The other side (origin/main) was judged",
    ),
    "a merge conflict around the whole file": (
        lambda notebook: (
            f"<<<<<<< HEAD\n{json.dumps(notebook)}\n=======\n" + '{"cells": []}\n>>>>>>> theirs\n'
        ),
        "Your side (HEAD) was judged",
    ),
    "a merge conflict in a code cell": (conflict_in_code, "Your side (local) was judged"),
    "trailing commas": (
        lambda notebook: json.dumps(notebook | {"x": ",]"}, indent=1).replace("]\n", "],\n"),
        "",
    ),
    "a line end in a string": (
        lambda notebook: json.dumps(notebook).replace("\\n", "\n", 1),
        "",
    ),
    "a reply of Jupyter's server": (
        lambda notebook: {"name": "a.ipynb", "type": "notebook", "content": notebook},
        "",
    ),
    "only the list of cells": (lambda notebook: json.dumps(notebook["cells"]), ""),
    "encoded twice": (lambda notebook: json.dumps(json.dumps(notebook)), ""),
    "gzip": (lambda notebook: gzip.compress(json.dumps(notebook).encode()), "is a gzip file"),
    "a zip": (
        lambda notebook: zip_of(json.dumps(notebook), "a.ipynb", "__MACOSX/._a.ipynb"),
        "is a zip file",
    ),
    "UTF-16 without its mark": (lambda notebook: json.dumps(notebook).encode("utf-16-le"), ""),
    "UTF-16, the high byte first": (
        lambda notebook: json.dumps(notebook, indent=1).encode("utf-16-be"),
        "",
    ),
    "a deeply nested output": (nested_output, ""),
    "halves of characters": (lone_surrogates, ""),
    "halves of characters in UTF-8": (
        lambda notebook: lone_surrogates(notebook) or json.dumps(notebook, ensure_ascii=False),
        "",
    ),
    "the key `cells` twice": (
        lambda notebook: json.dumps({"cells": []})[:-1] + "," + json.dumps(notebook)[1:],
        "",
    ),
}


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
    answers = {cell.metadata.nbgrader.grade_id: cell for cell in graded_cells(graded_copy)}
    for name in EXERCISES:
        assert f"def {name}" in answers[name].source or "is in the cell" in answers[name].source
        assert "NotImplementedError" not in answers[name].source
        assert (
            answers[f"test_{name}"].source.startswith("check(")
            or "check" in answers[f"test_{name}"].source
        )


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


def test_a_written_answer_that_may_be_cut_off_waits_for_a_grader():
    data = json.dumps(with_report()).encode()
    cut = SubmittedFiles("12_streaming_obstacles.ipynb", data[: data.index(b"I widened")])
    prepared = prepare(cut, WRITTEN_LESSON)
    assert "Look for the answer in the file" in prepared.answers["write_up"].text
    assert "A grader will look for it." in prepared.notes[-1]


def test_a_file_that_git_has_not_downloaded_gets_no_mark():
    submission = SubmittedFiles("06_filter_ground.ipynb", LFS_POINTER)
    verdict = judge_files(submission, 1, None, LESSON)
    assert verdict.status == FAILED and "Run `git lfs pull`" in verdict.reason


# ---- One step at a time --------------------------------------------------------------------


def from_cells(*cells, lesson=LESSON, modules=None, name="", lesson_name=""):
    """Return the prepared notebook of a submission that consists of these cells."""
    notebook = {"cells": list(cells), "nbformat": 4, "nbformat_minor": 5}
    notebook["metadata"] = {"lidar_obstacle_lab": {"lesson": lesson_name}} if lesson_name else {}
    data = json.dumps(notebook).encode()
    return prepare(
        SubmittedFiles(name or f"{lesson.name}.ipynb", data, modules=modules or {}), lesson
    )


def with_grade_id(cell, grade_id):
    """Return a copy of a cell with an nbgrader grade ID."""
    return {**cell, "metadata": {"nbgrader": {"grade_id": grade_id}}}


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
        # Of several text cells, the first counts.
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


# ---- Written answers -----------------------------------------------------------------------


def write_below_own_cell(notebook):
    index = notebook["cells"].index(cell_of(notebook, "write_up"))
    notebook["cells"][index]["source"] = "YOUR ANSWER HERE"
    notebook["cells"].insert(index + 1, text(REPORT))


def write_in_two_cells(notebook):
    write_below_own_cell(notebook)
    index = notebook["cells"].index(cell_of(notebook, "write_up"))
    first, second = REPORT.split(", ")
    notebook["cells"][index + 1 : index + 2] = [text(first + ","), text(second)]


def remove_metadata(notebook):
    for cell in notebook["cells"]:
        cell["metadata"] = {}


def delete_own_cell(notebook):
    write_below_own_cell(notebook)
    notebook["cells"].remove(cell_of(notebook, "write_up"))


def convert_to_code_cell(notebook):
    cell = cell_of(notebook, "write_up")
    cell.update(cell_type="code", outputs=[], execution_count=None)


@pytest.mark.parametrize(
    "change",
    [
        lambda notebook: None,
        write_below_own_cell,
        write_in_two_cells,
        remove_metadata,
        delete_own_cell,
        convert_to_code_cell,
        lambda notebook: cell_of(notebook, "write_up").update(cell_type="raw"),
        lambda notebook: cell_of(notebook, "write_up").update(outputs=[]),
        lambda notebook: notebook.update(nbformat_minor=4),
        lambda notebook: notebook["cells"].append(copy.deepcopy(notebook["cells"][0])),
    ],
)
def test_a_written_answer_is_copied(change):
    notebook = with_report()
    change(notebook)
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    nbformat.validate(graded_copy)
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert cell.cell_type == "markdown"
    assert "".join(cell.source.split()) == "".join(REPORT.split())
    (other,) = [
        c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "second_data_set"
    ]
    assert other.source == "YOUR ANSWER HERE"


def test_text_that_may_be_the_answer_is_left_to_the_grader():
    notebook = with_report()
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    notebook["cells"] = [*cells, text(REPORT)]
    data = json.dumps(notebook).encode()
    prepared = prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    assert "A grader will look for it" in " ".join(prepared.notes)
    graded_copy = build_copy(prepared)
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert MISSING_ANSWER_NOTE in cell.source
    assert REPORT in "\n".join(cell.source for cell in graded_copy.cells)


def released_text_cell(number):
    """Return a text cell of lesson 12 as it was released."""
    cells = json.loads(WRITTEN_LESSON.released.read_text())["cells"]
    return text("".join(cells[number]["source"]))


def index_of(grade_id):
    cells = json.loads(WRITTEN_LESSON.released.read_text())["cells"]
    return cells.index(cell_of({"cells": cells}, grade_id))


def write_up(*cells):
    """Prepare a notebook with these cells, and return the results for the write-up.

    Returns
    -------
    tuple
        The text, whether it is certain, the sources of all cells after the first, the source of the
        write-up's own cell or None, and the notes about the write-up.
    """
    prepared = from_cells(code("def match_boxes(a, b, c): return a"), *cells, lesson=WRITTEN_LESSON)
    answer, index = prepared.answers["write_up"], prepared.graded.get("write_up")
    own = None if index is None else prepared.cells[index].source
    notes = [note for note in prepared.notes if "write_up" in note]
    return answer.text, answer.is_certain, [cell.source for cell in prepared.cells][1:], own, notes


STUB = text("YOUR ANSWER HERE")
OWN = with_grade_id(STUB, "write_up")


def prompt():
    """Return the cell that contains the write-up's question."""
    return released_text_cell(index_of("write_up") - 1)


def test_an_answer_in_its_own_cell_ignores_text_below():
    answer = with_grade_id(text("It finds 14 of 17."), "write_up")
    assert write_up(answer, text("A remark."))[:2] == ("It finds 14 of 17.", True)
    # An editor may copy the cell with its ID. The copy is appended, unless it is empty.
    more = with_grade_id(text("And 3 more."), "write_up")
    written, certain, cells, own, notes = write_up(OWN, answer, more, text("A remark."))
    assert (written, certain, own) == ("It finds 14 of 17.\n\nAnd 3 more.", True, answer["source"])
    assert cells == ["YOUR ANSWER HERE", "It finds 14 of 17.", "A remark."] and notes == []
    empty = with_grade_id(text("  "), "write_up")
    assert write_up(empty)[:2] == ("", True)


@pytest.mark.parametrize(
    ("source", "shown_text"),
    [
        ("It finds 14 of 17.", "It finds 14 of 17."),
        ("# It finds 14\n\n#of 17.\n## That is all.", "It finds 14\n\nof 17.\nThat is all."),
        ("# Results\nIt finds 14 of 17.", "# Results\nIt finds 14 of 17."),
    ],
)
def test_an_answer_in_a_code_cell_is_read_as_text_with_a_note(source, shown_text):
    """Comment signs are removed from a code cell, but a text cell keeps its heading."""
    answer, certain, _, own, notes = write_up(code(source, **OWN["metadata"]))
    assert (answer, certain, own) == (shown_text, True, source)
    assert len(notes) == 1 and "write_up was in a code cell" in notes[0]
    assert write_up(with_grade_id(text(source), "write_up"))[::4] == (source, [])
    # The released text in a code cell is an empty answer and needs no note.
    assert write_up(code("YOUR ANSWER HERE", **OWN["metadata"]))[::4] == ("", [])


def test_text_from_an_earlier_release_is_not_an_answer():
    """The lesson's text may change after students have downloaded it."""
    old = text("## Write-up, as it was called in the first release") | {"id": "fdc3655c352f"}
    assert write_up(OWN, old, text("Second."))[0] == ""
    assert write_up(prompt(), old)[:2] == ("", True)
    edited = old | {"source": f"{old['source']}. It finds 14 of 17."}
    assert write_up(OWN, edited)[0] == edited["source"]


def test_an_answer_below_its_cell_ends_at_the_next_cell_of_the_course():
    footer = released_text_cell(index_of("write_up") + 1)
    cells = [OWN, text("First."), text(" "), code("x = 1"), text("Second."), footer, text("Third.")]
    written, certain, kept, own, notes = write_up(prompt(), *cells)
    assert (written, certain, own) == ("First.\n\nSecond.", True, "YOUR ANSWER HERE")
    assert kept == [
        *(prompt()["source"], "YOUR ANSWER HERE", " ", "x = 1", footer["source"], "Third.")
    ]
    assert len(notes) == 1 and "was in 2 new cells below the cell" in notes[0]
    assert write_up(OWN, text("First."), OWN)[0] == "First."
    stopped = write_up(
        OWN, text("First."), with_grade_id(text("Other."), "test_x"), text("Second.")
    )
    assert stopped[0] == "First." and "in a new cell below the cell" in stopped[4][0]
    assert write_up(OWN, code("x = 1"), text(" "))[:3] == (
        "",
        True,
        ["YOUR ANSWER HERE", "x = 1", " "],
    )


def test_an_answer_whose_cell_was_deleted_is_found_below_its_question():
    written, certain, kept, own, notes = write_up(prompt(), text("First."), text("Second."))
    assert (written, certain, own) == ("First.\n\nSecond.", True, "First.")
    assert kept == [prompt()["source"], "First."] and len(notes) == 1
    assert write_up(prompt(), text("You see 14."), text("And 3."))[0] == "You see 14.\n\nAnd 3."
    # STUB is the answer's own cell, which lost its metadata, so the remark above is not the answer.
    written, certain, kept, own, notes = write_up(text("A remark."), prompt(), STUB)
    assert (written, certain, own, notes) == ("", True, "YOUR ANSWER HERE", [])
    assert write_up(STUB, prompt())[3] is None  # above the question, STUB is not the answer's cell


def test_an_answer_is_uncertain_only_if_other_text_may_be_the_answer():
    assert write_up(text("A remark."))[:2] == ("", False)
    assert write_up(text("A remark."))[4][0].startswith("The cell for write_up is missing")
    for cells in ([], [text(" ")], [released_text_cell(0)], [code("x = 1")], [prompt()]):
        assert write_up(*cells)[:2] == ("", True)


def test_pictures_of_all_parts_of_an_answer_are_kept():
    """Editors name every pasted picture image.png, so the names of two cells may be the same."""
    pictures = [base64.b64encode(b"\x89PNG" + end).decode() for end in (b"a", b"b")]
    parts = [
        {
            **text("![](attachment:image.png)"),
            "attachments": {"image.png": {"image/png": picture}},
        }
        for picture in pictures
    ]
    answer = from_cells(code("x = 1"), OWN, *parts, lesson=WRITTEN_LESSON).answers["write_up"]
    names = re.findall(r"attachment:(\S+)\)", answer.text)
    assert [answer.attachments[name] for name in names] == [
        {"image/png": picture} for picture in pictures
    ]


def test_cells_are_found_after_an_answer_of_several_cells():
    match = code("def match_boxes(a, b, c): return a")
    prepared = from_cells(OWN, text("First."), text("Second."), match, lesson=WRITTEN_LESSON)
    assert prepared.cells[prepared.graded["match_boxes"]].source.startswith("def match_boxes")
    assert len(prepared.cells) == 2


def test_only_pictures_are_kept_as_attachments():
    notebook = with_report()
    picture = base64.b64encode(b"\x89PNG").decode()
    cell_of(notebook, "write_up").update(
        source="![](attachment:a.png)"
        + "".join(
            f"![](<attachment:{name}>)" for name in ('b" onerror="alert(1)', "d.png", "e.svg")
        ),
        attachments={
            "a.png": {"image/png": picture, "text/html": "<script>"},
            'b" onerror="alert(1)': {"image/png": picture},
            "d.png": {"image/png": '" onerror="alert(1)'},
            "e.svg": {"image/svg+xml": base64.b64encode(b"<svg>").decode()},
        },
    )
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    (cell,) = [c for c in graded_cells(graded_copy) if c.metadata.nbgrader.grade_id == "write_up"]
    assert "a.png" in cell.attachments
    assert list(cell.attachments.values()) == [{"image/png": picture}] * 2


@pytest.mark.end_to_end
def test_a_missing_picture_does_not_prevent_the_feedback_page():
    text_with_pictures = "![](attachment:gone.png) [a]: attachment:b%20c.png <x attachment:>"
    notebook = json.loads(fill_in(WRITTEN_LESSON, {"write_up": text_with_pictures}))
    picture = {"b c.png": {"image/png": base64.b64encode(b"png").decode()}}
    notebook["cells"].append({**text(text_with_pictures), "attachments": picture})
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    page, _ = HTMLExporter().from_notebook_node(graded_copy)
    assert "gone.png" in page


def test_a_students_changes_to_course_cells_are_shown_next_to_them():
    notebook = right_notebook()
    cell_of(notebook, "test_voxel_grid")["source"] = "voxel_grid = print"
    data = json.dumps(notebook).encode()
    graded_copy = build_copy(prepare(SubmittedFiles("06_filter_ground.ipynb", data), LESSON))
    sources = [cell.source for cell in graded_copy.cells if "nbgrader" not in cell.metadata]
    assert "voxel_grid = print" in sources


def test_a_copy_of_a_copy_is_the_same():
    notebook = with_report()
    notebook["cells"].append(text("<b>x</b> [a](javascript:b) $\\href{x}{y}$"))
    notebook["cells"].append({"cell_type": "raw", "metadata": {}, "source": "```\n<script>"})
    data = json.dumps(notebook).encode()
    first = build_copy(
        prepare(SubmittedFiles("12_streaming_obstacles.ipynb", data), WRITTEN_LESSON)
    )
    again = SubmittedFiles("12_streaming_obstacles.ipynb", nbformat.writes(first).encode())
    for copied, cell in zip(
        build_copy(prepare(again, WRITTEN_LESSON)).cells, first.cells, strict=True
    ):
        assert copied == cell
