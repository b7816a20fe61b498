"""Damage that editors, browsers and disks do to notebooks, and that should not cost points."""

import copy
import gzip
import io
import json
import zipfile

from tests.notebook_cells import (
    EXERCISES,
    LESSON,
    cell_of,
    code,
    right_notebook,
    text,
    with_grade_id,
)


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
