"""Turn a submission into the notebook that is judged and shown, and report all repairs.

Each of the `STEPS` looks for one kind of damage, and yields a sentence for each change or problem:
what happened, how the grader treated it, and what the student can do. The judge and the gradebook
use the same result, so a grader sees exactly the code that was judged.

Code is untrusted. The judge therefore parses it only in the sandbox. Here it is searched as text.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import itertools
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from grader.course.lessons import Lesson, all_lessons
from grader.intake.pictures import illustrate
from grader.intake.reader_process import TooCostly, run_in_child
from grader.intake.submission import MAX_MODULES, SubmittedFiles
from utils.notebooks.reading import Cell, Notebook, UnreadableNotebook

MAX_CODE_BYTES = 15 * 2**20
"""Maximum size of code cells and modules as JSON; a message to the sandbox may be 1 MB larger."""
MAX_NAMES = 5
"""Maximum number of pictures that a sentence names."""
_WRITES_FILE = re.compile(r"%%(?:writefile|file)[ \t]")
_WRITES_MODULE = re.compile(
    r"%%(?:writefile|file)[ \t]+(?P<append>(?:-a|--append)[ \t]+)?"
    r"\"?(?:\./)?(?P<name>[A-Za-z_]\w{0,99})\.py\"?"
)
_MODULE_AT_END = re.compile(r"([A-Za-z_]\w{0,99})\.py\"?$")


@dataclass(frozen=True)
class WrittenAnswer:
    """A written answer, which a person grades.

    Attributes
    ----------
    text : str
        The answer; empty if the student wrote nothing.
    is_certain : bool
        False if other text in the notebook may be the answer, so a person has to look for it.
    attachments : dict
        Valid pictures in the answer, in the format of the notebook file.
    """

    text: str
    is_certain: bool = True
    attachments: dict = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class PreparedNotebook:
    """A notebook that is ready to be judged and shown.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    cells : tuple of Cell
        All cells except those that became part of a written answer.
    graded : dict of str to int
        Index in `cells` of each graded cell that students may edit, by its ``grade_id``. Missing
        cells are left out.
    answers : dict of str to WrittenAnswer
        Written answers by ``grade_id``.
    notes : tuple of str
        One sentence for each repair or problem.
    versions : dict of str to str
        A sentence about each exercise that the notebook defines more than once. The sentence is
        shown if the exercise loses points.
    modules : dict of str to str
        Source of each module that a cell writes with ``%%writefile``, by the name of the module.
    python : tuple of int
        The version of Python that ran the notebook; empty if it is unknown.
    is_complete : bool
        Whether the whole file was read, so that nothing that a student wrote can be missing.
    """

    lesson: Lesson
    cells: tuple[Cell, ...]
    graded: dict[str, int]
    answers: dict[str, WrittenAnswer]
    notes: tuple[str, ...]
    versions: dict[str, str] = field(default_factory=dict, hash=False)
    modules: dict[str, str] = field(default_factory=dict, hash=False)
    python: tuple[int, ...] = ()
    is_complete: bool = True

    @property
    def code(self) -> tuple[str, ...]:
        """Source of each code cell."""
        return tuple(cell.source for cell in self.cells if cell.kind == "code")


@dataclass(frozen=True)
class JudgeInput:
    """The part of a `PreparedNotebook` that the judge needs.

    Attributes
    ----------
    code, notes : tuple of str
    versions : dict of str to str
    is_as_released : bool
        Whether all code after the first code cell is unchanged, so judging can be skipped.
    modules : dict of str to str
        Source by name of the submitted modules, and of those that the notebook writes.
    python : tuple of int
        The version of Python that ran the notebook; empty if it is unknown.
    """

    code: tuple[str, ...]
    notes: tuple[str, ...]
    versions: dict[str, str] = field(hash=False)
    is_as_released: bool
    modules: dict[str, str] = field(default_factory=dict, hash=False)
    python: tuple[int, ...] = ()


@dataclass
class _Draft:
    """A notebook that the steps are changing."""

    lesson: Lesson
    submitted_files: SubmittedFiles
    notebook: Notebook
    cells: list[Cell]
    graded: dict[str, int] = field(default_factory=dict)
    answers: dict[str, WrittenAnswer] = field(default_factory=dict)
    modules: dict[str, str] = field(default_factory=dict)


def prepare(submitted_files: SubmittedFiles, lesson: Lesson) -> PreparedNotebook:
    """Read a notebook of a lesson, and repair it if it is damaged.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
        If the file cannot be read, or is not a notebook.
    """
    notebook = submitted_files.notebook()
    draft = _Draft(lesson, submitted_files, notebook, list(notebook.cells))
    notes = [sentence for step in STEPS for sentence in step(draft)]
    return PreparedNotebook(
        lesson,
        tuple(draft.cells),
        draft.graded,
        draft.answers,
        tuple(notes),
        _duplicate_sentences(draft),
        draft.modules,
        notebook.python,
        not notebook.repairs,
    )


def prepare_to_judge(submitted_files: SubmittedFiles, lesson: Lesson) -> JudgeInput:
    """Prepare a notebook for the judge, in a separate process; see `prepare`.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
        If the notebook cannot be read, or is too large.
    grader.intake.reader_process.ReadingFailed
        If the grader or this machine is at fault.
    """

    def work() -> tuple:
        prepared = prepare(submitted_files, lesson)
        modules = {**submitted_files.modules, **prepared.modules}
        size = len(json.dumps([prepared.code, modules]))
        if size > MAX_CODE_BYTES:
            parts = "cells and modules" if modules else "cells"
            raise UnreadableNotebook(
                f"In {submitted_files.name}, the code {parts} contain {size / 2**20:.0f} MB, but "
                f"the judge reads at most {MAX_CODE_BYTES // 2**20} MB. Delete the {parts} that "
                "contain large tables, read the tables from a file, and submit the notebook again."
            )
        untouched = prepared.is_complete and _is_as_released(lesson, prepared.code)
        return (
            prepared.code,
            prepared.notes,
            prepared.versions,
            prepared.modules,
            prepared.python,
            untouched,
        )

    cells_as_released(lesson)  # fill the cache before forking, so that every child inherits it
    code, notes, versions, written, python, untouched = run_in_child(submitted_files.name, work)
    modules = {**submitted_files.modules, **written}
    untouched = untouched and not modules
    return JudgeInput(tuple(code), tuple(notes), versions, untouched, modules, tuple(python))


def _is_as_released(lesson: Lesson, code: Iterable[str]) -> bool:
    """Return whether all code cells after the first are as released.

    The first cell loads the tools, and differs in standalone notebooks. A definition of an exercise
    in that cell has no effect, because the stub below overwrites it.
    """
    released_sources = [
        cell.source.strip() for cell in cells_as_released(lesson) if cell.kind == "code"
    ]
    return [source.strip() for source in code if source.strip()][1:] == released_sources[1:]


def lesson_name_in(submitted_files: SubmittedFiles) -> str:
    """Return the lesson name in a notebook's metadata. Read the file in a separate process."""
    return run_in_child(submitted_files.name, lambda: submitted_files.notebook().lesson_name)


def prepare_to_show(submitted_files: SubmittedFiles, lesson: Lesson) -> PreparedNotebook:
    """Prepare a notebook for display. An unreadable file becomes a notebook without answers."""
    try:
        return prepare(submitted_files, lesson)
    except UnreadableNotebook as error:
        return _notebook_with_answers(lesson, WrittenAnswer(""), error)


def prepare_substitute(
    submitted_files: SubmittedFiles, lesson: Lesson, error: TooCostly
) -> PreparedNotebook:
    """Return a substitute for a notebook that takes too much time or memory to read.

    Its written answers tell the grader to look in the file.
    """
    text = _unreadable_answer_text(submitted_files, "is too large to show")
    return _notebook_with_answers(lesson, WrittenAnswer(text), error)


def _unreadable_answer_text(submitted_files: SubmittedFiles, reason: str) -> str:
    """Return a text for a grader in place of a written answer."""
    # The text contains a digest, so that it changes when a student submits another file.
    digest = hashlib.sha256(submitted_files.data).hexdigest()[:12]
    return f"*This notebook {reason}. Look for the answer in the file ({digest}).*"


def _notebook_with_answers(
    lesson: Lesson, answer: WrittenAnswer, error: UnreadableNotebook
) -> PreparedNotebook:
    return PreparedNotebook(
        lesson, (), {}, dict.fromkeys(_hand_graded_cells(lesson), answer), (str(error),)
    )


def _report_file_problems(draft: _Draft) -> Iterator[str]:
    """Report problems of the file, such as a wrong name or encoding, or a missing end."""
    yield from draft.submitted_files.notes
    yield from draft.notebook.repairs


def _restore_code_cells(draft: _Draft) -> Iterator[str]:
    """Restore code cells that became Markdown or raw cells by accident.

    Functions in code cells take precedence, because these cells ran in the student's notebook. A
    text cell may define such a function together with one that the code cells lack. It is then
    moved above the code cells, which overwrite its version of the function.
    """
    names, hand_graded = _exercise_names(draft.lesson), _hand_graded_cells(draft.lesson)
    sort_keys: list[float] = list(range(len(draft.cells)))  # keys for the new order of the cells
    # Index of the last cell that defines each function.
    last = {name: found_cells[-1] for name in names if (found_cells := _answer_cells(draft, name))}
    restored = []
    for index, cell in enumerate(draft.cells):
        if cell.kind == "code" or cell.grade_id in hand_graded or "```" in cell.source:
            continue
        names_in_cell = [name for name in names if _defines(cell, name)]
        names_to_judge = [
            name
            for name in names_in_cell
            if name not in last or (name == cell.grade_id and last[name] < index)
        ]
        if not names_to_judge:
            continue
        other_keys = [sort_keys[last[name]] for name in names_in_cell if name not in names_to_judge]
        just_before = [math.nextafter(key, -math.inf) for key in other_keys]
        sort_keys[index] = min([sort_keys[index], *just_before])
        for name in names_in_cell:
            last[name] = max(index, last.get(name, index), key=sort_keys.__getitem__)
        draft.cells[index] = dataclasses.replace(cell, kind="code")
        restored.append((cell.kind, index, names_in_cell))
    in_order = sorted(range(len(sort_keys)), key=sort_keys.__getitem__)
    draft.cells = [draft.cells[index] for index in in_order]
    for kind, index, names_in_cell in restored:
        judged = [name for name in names_in_cell if last[name] == index]
        if judged:
            yield _restored_sentence(
                kind, judged, [name for name in names_in_cell if name not in judged]
            )


def _restored_sentence(cell_kind: str, judged_names: list[str], other_names: list[str]) -> str:
    """Return the note on a restored cell. Other cells define the functions in `other_names`."""
    cell = {"markdown": "a text cell", "raw": "a raw cell"}[cell_kind]
    was, it = ("was", "it") if len(judged_names) == 1 else ("were", "them")
    names, more = " and ".join(judged_names), " and ".join(other_names)
    return (
        f"{names} {was} in {cell}, which Jupyter does not run. The grader judged {it} as code. "
        + (f"For {more}, it judged the code in another cell. " if other_names else "")
        + "In Jupyter, select the cell and press Y to make it a code cell again"
        + (f", and delete {more} from it." if other_names else ".")
    )


def _remove_later_stubs(draft: _Draft) -> Iterator[str]:
    """Blank released cells that were pasted below the answer, because they would overwrite it."""
    for name in _exercise_names(draft.lesson):
        indices, answers = _cells_that_define(draft, name), _answer_cells(draft, name)
        if answers and indices[-1] > answers[-1]:
            for index in (index for index in indices if index > answers[-1]):
                draft.cells[index] = Cell("code", "# Left out: the cell as it was released.")
            yield (
                f"A copy of the released cell is below your {name}, and overwrites your answer "
                "when the notebook runs. The grader judged your answer and ignored the copy. "
                "Delete the copy."
            )


def _find_graded_cells(draft: _Draft) -> Iterator[str]:
    """Find each graded cell, even if it was copied, moved or split, or if it lost its metadata."""
    for name in _exercise_names(draft.lesson):
        marked = {
            index: cell
            for index, cell in enumerate(draft.cells)
            if cell.kind == "code" and cell.grade_id == name
        }
        written = _cells_that_define(draft, name)
        both = [index for index in written if index in marked]
        indices = both or written or [*marked]
        if indices:
            draft.graded[name] = indices[-1]
    return ()


def _report_other_lesson(draft: _Draft) -> Iterator[str]:
    """Report a notebook that belongs to another lesson or contains no code."""
    lesson = draft.lesson
    if any(_cells_that_define(draft, name) for name in _exercise_names(lesson)):
        return
    claimed = draft.notebook.lesson_name
    if claimed and claimed != lesson.name:
        yield (
            f"{draft.submitted_files.name} contains the notebook of {claimed[:60]} instead of "
            f"{lesson.name}. Submit {lesson.name}.ipynb."
        )
    elif draft.notebook.repairs:
        return  # the code may be in the part that could not be read
    elif others := _functions_of_another_lesson(draft):
        names, other = others
        yield (
            f"{draft.submitted_files.name} contains {names} from {other.name}, and none of the "
            f"functions from {lesson.name}. Submit {lesson.name}.ipynb."
        )
    elif not any(cell.kind == "code" and cell.source.strip() for cell in draft.cells):
        yield (
            f"{draft.submitted_files.name} contains no code. Open the notebook in which you "
            "worked, save it, and submit that file."
        )


def _functions_of_another_lesson(draft: _Draft) -> tuple[str, Lesson] | None:
    """List the exercises of the lesson that this notebook matches best; also return the lesson."""
    functions_by_lesson = {
        other: [name for name in _exercise_names(other) if _cells_that_define(draft, name)]
        for other in all_lessons()
    }
    other = max(functions_by_lesson, key=lambda lesson: len(functions_by_lesson[lesson]))
    *some, last = functions_by_lesson[other] or [""]
    return (f"{', '.join(some)} and {last}" if some else last, other) if last else None


def _find_written_modules(draft: _Draft) -> Iterator[str]:
    """Collect the modules that cells write, and report those that the notebook imports."""
    submitted = draft.submitted_files.modules
    parts: dict[str, list[str]] = {}  # joined once, because a notebook may contain many parts
    elsewhere: dict[str, int] = {}
    code_cells = (cell for cell in draft.cells if cell.kind == "code")
    for number, cell in enumerate(code_cells, 1):
        command, _, body = cell.source.lstrip().partition("\n")
        command = command.strip()
        module = _WRITES_MODULE.fullmatch(command)
        if module and (module["name"] in parts or len(parts) < MAX_MODULES):
            name = module["name"]
            if not module["append"]:
                parts[name] = []
            elif name not in parts:
                parts[name] = [submitted[name]] if name in submitted else []
            parts[name].append(body)
        elif _WRITES_FILE.match(command):
            file = _MODULE_AT_END.search(command[-200:])
            if file and len(elsewhere) < MAX_MODULES:
                elsewhere[file[1]] = number
    draft.modules = {name: "\n".join(bodies) for name, bodies in parts.items()}
    if used := _list_imported_files(draft, draft.modules):
        yield f"The judge used {used}, which a cell in the notebook writes."
    for name, number in elsewhere.items():
        is_known = name in draft.modules.keys() | submitted.keys()
        if not is_known and _list_imported_files(draft, [name]):
            yield (
                f"Code cell {number} writes {name}.py to a place that the judge does not have. "
                f"Submit {name}.py next to the notebook."
            )


def _report_modules(draft: _Draft) -> Iterator[str]:
    """Report submitted modules that the notebook imports."""
    submitted = draft.submitted_files.modules.keys() - draft.modules.keys()
    if used := _list_imported_files(draft, sorted(submitted)):
        yield f"The judge used {used}, which you submitted with the notebook."


def _list_imported_files(draft: _Draft, modules: Iterable[str]) -> str:
    """List the files of the modules that a code cell imports, separated by commas."""
    text = "\n".join(cell.source for cell in draft.cells if cell.kind == "code")
    return ", ".join(
        f"{name}.py"
        for name in modules
        if re.search(rf"^[ \t]*(?:import|from)[ \t]+{name}\b", text, re.MULTILINE)
    )


def _collect_written_answers(draft: _Draft) -> Iterator[str]:
    """Collect the written answers, from their own cells or from new cells below them."""
    released = [cell.source.split() for cell in cells_as_released(draft.lesson)]
    moved = set()
    for name in _hand_graded_cells(draft.lesson):
        stub = _released_cells_by_id(draft.lesson)[name]
        own_cells = [index for index, cell in enumerate(draft.cells) if cell.grade_id == name]
        index_before = _index_before(draft, name)
        if (
            not own_cells
            and index_before is not None
            and _has_same_source(draft, index_before + 1, stub)
        ):
            own_cells = [index_before + 1]  # this cell only lost its metadata
        filled_cells = [
            index
            for index in own_cells
            if draft.cells[index].source.split() not in ([], stub.source.split())
        ]
        if filled_cells:
            draft.graded[name] = filled_cells[0]
            texts = [_as_text_cell(draft.cells[index]) for index in filled_cells]
            moved.update(filled_cells[1:])
            if any(draft.cells[index].kind == "code" for index in filled_cells):
                yield (
                    f"The answer to {name} was in a code cell. The grader treats it as text. In "
                    "Jupyter, select the cell and press M to make it a text cell again."
                )
        else:
            index_above = own_cells[0] if own_cells else index_before
            below = []
            if index_above is not None:
                below = list(_new_text_cells(draft, index_above, released))
            texts = [draft.cells[index] for index in below]
            if own_cells:
                draft.graded[name] = own_cells[0]
                moved.update(below)
            elif below:
                draft.graded[name] = below[0]
                moved.update(below[1:])
            if texts:
                yield (
                    f"The answer to {name} was in "
                    f"{'a new cell' if len(texts) == 1 else f'{len(texts)} new cells'} below the "
                    "cell for it. The grader moved the answer into the right cell."
                )
        answer = illustrate(texts)
        text = answer.text
        if answer.not_shown:
            yield _not_shown_sentence(name, answer.not_shown)
        is_certain = bool(text) or bool(own_cells) or not _has_stray_text(draft, released)
        if not is_certain:
            yield (
                f"The cell for {name} is missing, and other text in the notebook may be the "
                "answer. A grader will look for it."
            )
        elif not text and draft.notebook.repairs:
            text = _unreadable_answer_text(draft.submitted_files, "is damaged")
            yield (
                f"The part of the file that could be read contains no answer to {name}. A grader "
                "will look for it."
            )
        draft.answers[name] = WrittenAnswer(text, is_certain, answer.attachments)
    _remove_cells(draft, moved)


def _not_shown_sentence(name: str, pictures: Sequence[str]) -> str:
    """Return a sentence about the pictures of an answer that a grader cannot see."""
    named = list(pictures[:MAX_NAMES])
    if len(pictures) > MAX_NAMES:
        named.append(f"and {len(pictures) - MAX_NAMES} more")
    return (
        f"A grader cannot see every picture in the answer for {name}: {', '.join(named)}. Drag "
        "these pictures into the text cell in JupyterLab, and submit the notebook again."
    )


def _as_text_cell(cell: Cell) -> Cell:
    """Uncomment a code cell that has only comments, because # begins a heading in Markdown."""
    lines = [line for line in cell.source.splitlines() if line.strip()]
    if cell.kind != "code" or not all(line.startswith("#") for line in lines):
        return cell
    text = re.sub(r"^#+ ?", "", cell.source, flags=re.MULTILINE)
    return dataclasses.replace(cell, source=text)


# The order matters: code cells must be restored before written answers are collected.
STEPS: tuple[Callable[[_Draft], Iterable[str]], ...] = (
    _report_file_problems,
    _restore_code_cells,
    _remove_later_stubs,
    _report_other_lesson,
    _find_written_modules,
    _report_modules,
    _find_graded_cells,
    _collect_written_answers,
)


def _duplicate_sentences(draft: _Draft) -> dict[str, str]:
    """Return a sentence about each exercise that the notebook defines more than once."""
    sentences = {}
    numbers = list(itertools.accumulate(int(cell.kind == "code") for cell in draft.cells))
    for name in _exercise_names(draft.lesson):
        indices = _cells_that_define(draft, name)
        stub = _released_cells_by_id(draft.lesson).get(name)
        texts = {draft.cells[index].source for index in indices}
        if stub is not None:
            texts.discard(stub.source)
        if len(texts) > 1:
            *some, last = (numbers[index] for index in indices)
            listed = ", ".join(map(str, some[:4])) + (", …" if len(some) > 4 else "")
            sentences[name] = (
                f"{name} is defined {len(indices)} times, in code cells {listed} and {last}. The "
                "last definition counts, as when the notebook runs from top to bottom. Delete the "
                "others."
            )
    return sentences


def _new_text_cells(draft: _Draft, index_above: int, released: list[list[str]]) -> Iterator[int]:
    """Yield the indices of the student's own text cells below a cell, up to a released cell."""
    for index in range(index_above + 1, len(draft.cells)):
        cell = draft.cells[index]
        if cell.grade_id or (cell.source.strip() and _is_released_text(cell, released)):
            return
        if cell.kind != "code" and cell.source.strip():
            yield index


def _index_before(draft: _Draft, name: str) -> int | None:
    """Return the index of the cell that precedes a graded cell in the released notebook."""
    released_cells = cells_as_released(draft.lesson)
    position = next(index for index, cell in enumerate(released_cells) if cell.grade_id == name)
    prompt = released_cells[position - 1].source.split() if position else None
    indices = [index for index, cell in enumerate(draft.cells) if cell.source.split() == prompt]
    return indices[-1] if indices else None


def _has_same_source(draft: _Draft, index: int, cell: Cell) -> bool:
    return index < len(draft.cells) and draft.cells[index].source.split() == cell.source.split()


def _has_stray_text(draft: _Draft, released: list[list[str]]) -> bool:
    return any(
        cell.kind != "code" and cell.source.strip() and not _is_released_text(cell, released)
        for cell in draft.cells
    )


def _is_released_text(cell: Cell, released: list[list[str]]) -> bool:
    """Return whether a cell is part of this release, or of an earlier one, and is unchanged."""
    return cell.source.split() in released or cell.has_id_of_text


def _remove_cells(draft: _Draft, indices: set[int]) -> None:
    """Remove cells, and update the indices of the graded cells."""
    kept_indices = [index for index in range(len(draft.cells)) if index not in indices]
    draft.cells = [draft.cells[index] for index in kept_indices]
    new = {old: index for index, old in enumerate(kept_indices)}
    draft.graded = {name: new[index] for name, index in draft.graded.items()}


def _defines(cell: Cell, name: str) -> bool:
    """Return whether a cell defines a name in an unindented line."""
    if name not in cell.source:
        return False
    pattern = rf"^(?:(?:async[ \t]+)?def[ \t]+{name}[ \t]*\(|{name}[ \t]*=)"
    return bool(re.search(pattern, cell.source, re.MULTILINE))


def _cells_that_define(draft: _Draft, name: str) -> list[int]:
    return [
        index
        for index, cell in enumerate(draft.cells)
        if cell.kind == "code" and _defines(cell, name)
    ]


def _answer_cells(draft: _Draft, name: str) -> list[int]:
    """Return the indices of the cells that define a function, without unchanged stubs."""
    given = _released_cells_by_id(draft.lesson).get(name)
    stub = given.source.split() if given else None
    indices = _cells_that_define(draft, name)
    return [index for index in indices if draft.cells[index].source.split() != stub]


def _exercise_names(lesson: Lesson) -> list[str]:
    return [exercise.name for exercise in lesson.machine_graded]


def _hand_graded_cells(lesson: Lesson) -> list[str]:
    return [exercise.cell for exercise in lesson.exercises if exercise.by_hand]


@functools.cache
def cells_as_released(lesson: Lesson) -> tuple[Cell, ...]:
    """Return the cells of a lesson's released notebook."""
    return tuple(
        Cell(
            cell["cell_type"],
            "".join(cell["source"]),
            cell["metadata"].get("nbgrader", {}).get("grade_id", ""),
        )
        for cell in json.loads(lesson.released.read_text("utf-8"))["cells"]
    )


def _released_cells_by_id(lesson: Lesson) -> dict[str, Cell]:
    return {cell.grade_id: cell for cell in cells_as_released(lesson) if cell.grade_id}
