"""Build the two notebooks of a lesson from its source.

jupytext turns ``solutions/<stage>/<NN_name>/lesson.py`` into the instructor's notebook, next to
that folder. nbgrader's GenerateAssignment turns this into the student's notebook in ``notebooks/``.
The same source always gives the same bytes.
"""

from __future__ import annotations

import base64
import functools
import json
import re
import tempfile
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from grader.course import durations, earlier_lessons
from grader.course.lessons import Lesson, all_lessons, every_lesson, registry_faults
from grader.course.paths import PROJECT
from grader.course.settings import course_settings
from grader.errors import FAULT, UserError
from utils.notebooks.reading import id_of_text

if TYPE_CHECKING:
    from nbformat import NotebookNode

# Files of the cells that every lesson contains, by the tag that marks their place. A file may
# contain two versions of a cell, separated by a line `---`. The first version is used if the course
# has a public address.
COMMON_CELLS = {
    "setup": "setup_cell.py",
    "badge": "badge_cell.md",
    "questions": "questions_cell.md",
    "footer": "footer_cell.md",
}
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
FORBIDDEN_FILE = PROJECT / "utils" / "checks" / "forbidden.json"
CELL_KEYS_FILE = PROJECT / "utils" / "lent" / "cells.json"
# Minimum length of a line that could reveal a solution, in characters. Lines that match
# `HARMLESS_LINE` do not reveal anything either.
LEAK_LENGTH = 12
# Cell metadata that folds the code in JupyterLab, Colab and Kaggle.
HIDDEN_METADATA = {"jupyter": {"source_hidden": True}, "cellView": "form", "_kg_hide-input": True}
# Unusual characters are refused, because the address and the revision are inserted into links and
# a shell command.
ADDRESS = re.compile(r"https?://[\w.:-]+/([\w.-]+/[\w.-]+?)")
REVISION = re.compile(r"\w[\w./-]*")
# Placeholder for the points of an exercise, such as `` `insert` (points)``.
POINTS_MARK = re.compile(r"`(?P<exercise>\w+)` \(points\)")
NEXT_LINE = re.compile(r"\*\*Next:\*\* (?P<title>(?P<number>\d\d) · [^\n]*)")
HARMLESS_LINE = re.compile(r"(return|continue|break|pass|else:|try:|if|import|from)\b[\w ,.]*$")


class RegistryFault(UserError):
    """Some lessons are ignored or conflict; the message has one sentence for each fault."""

    exit_status = FAULT
    is_multiline = True


def build() -> list[tuple[str, Path]]:
    """Write every generated file and remove notebooks that have no source.

    Returns
    -------
    list of (str, pathlib.Path)
        Each change, "wrote" or "removed", and the file.

    Raises
    ------
    RegistryFault
        If the folder of a lesson is ignored, or if two lessons share a number or an exercise.
    """
    if faults := registry_faults():
        raise RegistryFault("\n".join(faults))
    changes = []
    for path, text in build_all().items():
        if not path.exists() or path.read_bytes() != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(text)
            changes.append(("wrote", path))
    for path in _stray_notebooks():
        path.unlink()
        changes.append(("removed", path))
    return changes


def check() -> list[str]:
    """Compare the generated files with their sources.

    Returns
    -------
    list of str
        A sentence for each fault; empty if there are none.
    """
    if faults := registry_faults():
        return faults
    generated = build_all()
    faults = [
        f"{path.relative_to(PROJECT)} is out of date. Run: python -m grader build"
        for path, text in generated.items()
        if not path.exists() or path.read_bytes() != text
    ]
    faults += [
        f"{path.relative_to(PROJECT)} does not belong to any lesson. Run: python -m grader build"
        for path in _stray_notebooks()
    ]
    for lesson in every_lesson():
        others = [generated[other.released] for other in every_lesson() if other != lesson]
        if b"](pictures/" in generated[lesson.solved]:
            faults.append(
                f"{lesson.name} refers to a picture that does not exist. Run: make pictures"
            )
        faults += [
            f"{lesson.released.relative_to(PROJECT)} gives away a line of the solution: {line!r}"
            for line in find_leaks(generated[lesson.solved], generated[lesson.released], others)
        ]
    return faults


def build_all(origin: Origin | None = None) -> dict[Path, bytes]:
    """Return the content of each generated file by path. `origin` defaults to `read_origin()`."""
    origin = origin or read_origin()
    solved = {lesson.solved: to_bytes(solved_notebook(lesson, origin)) for lesson in every_lesson()}
    released = _released_notebooks(solved)
    return {
        **solved,
        **released,
        FORBIDDEN_FILE: _forbidden_modules(),
        CELL_KEYS_FILE: _cell_keys(released),
    }


def _forbidden_modules() -> bytes:
    """Return the forbidden modules of each lesson as JSON, because students lack the headers."""
    rules = {f"lesson_{lesson.number}": lesson.header.forbidden for lesson in all_lessons()}
    return (json.dumps(rules, indent=1) + "\n").encode()


def _cell_keys(released: dict[Path, bytes]) -> bytes:
    """Return fingerprints of the code cells in each student notebook, as JSON."""
    from utils.lent.rerun_plan import key_of_cell

    keys = {
        lesson.number: [
            key_of_cell(_join_source(cell["source"]))
            for cell in json.loads(released[lesson.released])["cells"]
            if cell["cell_type"] == "code"
        ]
        for lesson in all_lessons()
    }
    return (json.dumps(keys, indent=0, separators=(",", ":")) + "\n").encode()


def solved_notebook(lesson: Lesson, origin: Origin) -> NotebookNode:
    """Return the instructor's notebook of a lesson, as nbformat's NotebookNode."""
    import jupytext

    notebook = jupytext.read(lesson.source)
    notebook.metadata = {
        "kernelspec": KERNEL,
        "language_info": {"name": "python"},
        "lidar_obstacle_lab": {"lesson": lesson.name, "stage": lesson.stage},
    }
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    id_counts = {}
    _insert_points(notebook)
    for cell in notebook.cells:
        for tag in COMMON_CELLS.keys() & set(cell.metadata.get("tags", ())):
            cell.source = common_cell(tag, lesson, origin)
    durations.insert_durations(notebook)
    for cell in notebook.cells:
        if earlier_lessons.TAG in cell.metadata.get("tags", ()):
            cell.source = earlier_lessons.insert_functions(cell.source)
        if cell.cell_type == "markdown":
            cell.source = NEXT_LINE.sub(functools.partial(_next_lesson_link, lesson), cell.source)
            _attach_pictures(cell, lesson.folder)
        else:
            _fold_tagged_cell(cell)
        cell.id = _stable_id(cell, id_counts)
    _allow_errors_after_answers(notebook)
    return notebook


def to_bytes(notebook: NotebookNode) -> bytes:
    """Validate a notebook and return it as the bytes of a file."""
    import nbformat

    nbformat.validate(notebook)
    return (nbformat.writes(notebook).rstrip("\n") + "\n").encode()


def find_leaks(solved: bytes, released: bytes, others: Collection[bytes] = ()) -> list[str]:
    """Return the lines of a student's notebook that are in the solution or mark one.

    Parameters
    ----------
    solved, released : bytes
        The two notebooks.
    others : collection of bytes
        The student notebooks of the other lessons. Code that students get in another lesson is
        not secret.
    """
    shown = lines_of(released)
    return sorted(
        secret_lines(solved, others) & shown | {line for line in shown if "SOLUTION" in line}
    )


def secret_lines(solved: bytes, others: Collection[bytes] = ()) -> set[str]:
    """Return the lines that would reveal a solution; see `find_leaks` for the parameters."""
    secret = set()
    for cell in json.loads(solved)["cells"]:
        from_earlier = earlier_lessons.TAG in cell["metadata"].get("tags", ())
        for region in re.findall(
            r"### BEGIN SOLUTION\n(.*?)### END SOLUTION", _join_source(cell["source"]), re.S
        ):
            lines = {line.strip() for line in region.splitlines()}
            secret |= lines.difference(*map(lines_of, others)) if from_earlier else lines
    return {line for line in secret if len(line) >= LEAK_LENGTH and not HARMLESS_LINE.match(line)}


def lines_of(notebook: bytes) -> set[str]:
    """Return all lines of a notebook's cells, stripped."""
    return {
        line.strip()
        for cell in json.loads(notebook)["cells"]
        for line in _join_source(cell["source"]).splitlines()
    }


@dataclass(frozen=True)
class Origin:
    """The public address of the course, and the revision that the notebooks belong to.

    Attributes
    ----------
    repository : str
        Address such as ``https://github.com/OWNER/NAME``; empty if there is none.
    revision : str
        Branch, tag or commit.

    Raises
    ------
    ValueError
        If the address or the revision has an invalid form.
    """

    repository: str
    revision: str

    def __post_init__(self) -> None:
        if self.repository and not ADDRESS.fullmatch(self.repository):
            raise ValueError(
                f"`repository` in pyproject.toml is {self.repository!r}. It should "
                'look like "https://github.com/OWNER/NAME", or be empty.'
            )
        if not REVISION.fullmatch(self.revision):
            raise ValueError(
                f"`revision` in pyproject.toml is {self.revision!r}. It should be "
                "the name of a branch or tag, or a commit."
            )

    @property
    def owner_and_name(self) -> str:
        """The end of the address, ``OWNER/NAME``."""
        return ADDRESS.fullmatch(self.repository)[1]


def read_origin() -> Origin:
    """Return the `Origin` in pyproject.toml.

    The git remote is ignored, so that every clone builds the same bytes.
    """
    settings = course_settings()
    repository = settings["repository"].removesuffix("/").removesuffix(".git")
    return Origin(repository, settings["revision"])


def _released_notebooks(solved: dict[Path, bytes]) -> dict[Path, bytes]:
    """Return the student notebooks, which nbgrader generates in a temporary folder."""
    from nbgrader.converters import GenerateAssignment

    from grader.course.nbgrader_settings import make_converter

    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder).resolve()
        for path, text in solved.items():
            copy = root / path.relative_to(PROJECT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(text)
        for stage in dict.fromkeys(lesson.stage for lesson in every_lesson()):
            generate = make_converter(GenerateAssignment, root, stage)
            generate.no_database = True
            generate.preprocessors = [
                step for step in generate.preprocessors if not step.endswith(".SaveCells")
            ]
            generate.start()
        return {
            lesson.released: (root / lesson.released.relative_to(PROJECT))
            .read_bytes()
            .rstrip(b"\n")
            + b"\n"
            for lesson in every_lesson()
        }


def _stray_notebooks() -> list[Path]:
    known = {path for lesson in every_lesson() for path in (lesson.solved, lesson.released)}
    found = [*(PROJECT / "solutions").glob("*/*.ipynb"), *(PROJECT / "notebooks").glob("*/*.ipynb")]
    return sorted(set(found) - known)


def common_cell(tag: str, lesson: Lesson, origin: Origin) -> str:
    """Return the text of a cell that every lesson contains.

    Parameters
    ----------
    tag : str
        One of `COMMON_CELLS`.
    lesson : Lesson
    origin : Origin
    """
    text = (PROJECT / "solutions" / COMMON_CELLS[tag]).read_text("utf-8")
    variants = re.split(r"\n(?:# )?---\n", text)
    if not origin.repository:
        return variants[-1].replace("NUMBER", lesson.number).strip()
    notebook = lesson.released.relative_to(PROJECT).as_posix()
    return (
        variants[0]
        .replace("ADDRESS", origin.repository)
        .replace("OWNER_NAME", origin.owner_and_name)
        .replace("REVISION", origin.revision)
        .replace("NOTEBOOK", notebook)
        .replace("NUMBER", lesson.number)
        .strip()
    )


def _next_lesson_link(lesson: Lesson, match: re.Match) -> str:
    """Return the line that names the next lesson, with a link if that lesson exists."""
    lessons = {lesson.number: lesson for lesson in every_lesson()}
    following = lessons.get(match["number"])
    if following is None:
        return match[0]
    folder = "" if following.stage == lesson.stage else f"../{following.stage}/"
    return f"**Next:** [{match['title']}]({folder}{following.name}.ipynb)"


def _insert_points(notebook: NotebookNode) -> None:
    """Replace each `POINTS_MARK` with the points in the exercise's nbgrader metadata."""
    grading = [cell.metadata.get("nbgrader", {}) for cell in notebook.cells]
    points = {
        cell["grade_id"].removeprefix("test_"): f"{cell['points']:g}"
        for cell in grading
        if cell.get("grade")
    }

    def insert_points_at(mark: re.Match) -> str:
        number = points.get(mark["exercise"])
        unit = "point" if number == "1" else "points"
        return f"`{mark['exercise']}` ({number} {unit})" if number else mark[0]

    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            cell.source = POINTS_MARK.sub(insert_points_at, cell.source)


def _fold_tagged_cell(cell: NotebookNode) -> None:
    """Fold a code cell with the tag `folded`."""
    if "folded" in cell.metadata.get("tags", ()):
        cell.metadata.update(HIDDEN_METADATA)


def _allow_errors_after_answers(notebook: NotebookNode) -> None:
    """Let Run All continue after an answer that raises, because the check explains the error."""
    cells_since_answer = None
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        if cell.metadata.get("nbgrader", {}).get("solution"):
            cells_since_answer = []
        elif cells_since_answer is not None:
            cells_since_answer.append(cell)
            if cell.source.startswith("check("):
                for later_cell in cells_since_answer:
                    tags = {*later_cell.metadata.get("tags", ()), "raises-exception"}
                    later_cell.metadata["tags"] = sorted(tags)
                cells_since_answer = None


def _attach_pictures(cell: NotebookNode, folder: Path) -> None:
    """Embed the pictures that a cell shows, so that the notebook needs no other file."""
    for name in dict.fromkeys(re.findall(r"\]\(([\w.-]+\.png)\)", cell.source)):
        if not (folder / name).exists():
            continue  # the preview of a new lesson can be drawn only after the first build
        data = base64.b64encode((folder / name).read_bytes()).decode()
        cell.setdefault("attachments", {})[name] = {"image/png": data}
        cell.source = cell.source.replace(f"({name})", f"(attachment:{name})")


def _stable_id(cell: NotebookNode, id_counts: dict[str, int]) -> str:
    """Return a cell's ID: its nbgrader ID, or a digest of its text, numbered if it is repeated."""
    grade_id = cell.metadata.get("nbgrader", {}).get("grade_id")
    name = grade_id or id_of_text(cell.source)
    id_counts[name] = id_counts.get(name, 0) + 1
    return name if id_counts[name] == 1 else f"{name}-{id_counts[name]}"


def _join_source(source: str | list[str]) -> str:
    return source if isinstance(source, str) else "".join(source)
