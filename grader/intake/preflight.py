"""Make of what was handed in what is judged and shown, and say what was mended.

Each step below looks for one way in which a notebook comes back other than it went out. It
returns a sentence for each thing it changed or noticed: what happened, what was done, and what the
student can do. Judge and gradebook use the same result, so nobody is shown other code than was
judged.

Nothing here parses code: that is a stranger's, and is parsed behind the wall.
"""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import itertools
import json
import math
import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field

from grader.course.lessons import Lesson
from grader.intake.reader_process import TooCostly, apart
from grader.intake.submission import HandedIn
from utils.notebooks.reading import Cell, Notebook, UnreadableNotebook


@dataclass(frozen=True)
class WrittenAnswer:
    """What a student wrote where a person grades.

    Attributes
    ----------
    text : str
        Empty where nothing was written.
    certain : bool
        False where text was found that may belong here: then a person has to look.
    attachments : dict
        Pictures in it, as the file has them.
    """

    text: str
    certain: bool = True
    attachments: dict = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Prepared:
    """A notebook, ready to be judged and shown.

    Attributes
    ----------
    lesson : grader.course.lessons.Lesson
    cells : tuple of Cell
        Without the cells that were moved into a written answer.
    graded : dict of str to int
        Place in `cells` of what stands for each graded cell that the student may write in, by
        its ``grade_id``; what is missing was not found.
    answers : dict of str to WrittenAnswer
        Written answers by ``grade_id``.
    notes : tuple of str
        What was mended or noticed, one sentence each.
    versions : dict of str to str
        A sentence on each exercise that is written more than once, for those that lose points.
    """

    lesson: Lesson
    cells: tuple[Cell, ...]
    graded: dict[str, int]
    answers: dict[str, WrittenAnswer]
    notes: tuple[str, ...]
    versions: dict[str, str] = field(default_factory=dict, hash=False)

    @property
    def code(self) -> tuple[str, ...]:
        """Source of each code cell."""
        return tuple(cell.source for cell in self.cells if cell.kind == "code")


@dataclass(frozen=True)
class ToJudge:
    """What the judge wants of a `Prepared` notebook: plain data, which come from another process.

    Attributes
    ----------
    code, notes : tuple of str
    versions : dict of str to str
    is_as_released : bool
        Whether all code but the first cell's is what was handed out: then it need not be asked.
    """

    code: tuple[str, ...]
    notes: tuple[str, ...]
    versions: dict[str, str] = field(hash=False)
    is_as_released: bool


@dataclass
class _Draft:
    """What the steps work on."""

    lesson: Lesson
    handed_in: HandedIn
    notebook: Notebook
    cells: list[Cell]
    graded: dict[str, int] = field(default_factory=dict)
    answers: dict[str, WrittenAnswer] = field(default_factory=dict)


def prepare(handed_in: HandedIn, lesson: Lesson) -> Prepared:
    """Read a notebook of a lesson, whatever became of it.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    """
    notebook = handed_in.notebook()
    draft = _Draft(lesson, handed_in, notebook, list(notebook.cells))
    notes = [sentence for step in STEPS for sentence in step(draft)]
    return Prepared(
        lesson, tuple(draft.cells), draft.graded, draft.answers, tuple(notes), _versions(draft)
    )


def prepare_to_judge(handed_in: HandedIn, lesson: Lesson) -> ToJudge:
    """The same as `prepare`, in a process of its own.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    grader.intake.reader_process.ReadingFailed
    """

    def work() -> tuple:
        prepared = prepare(handed_in, lesson)
        return prepared.code, prepared.notes, prepared.versions

    given_cells(lesson)  # read here, and remembered for the next
    code, notes, versions = apart(handed_in.name, work)
    return ToJudge(tuple(code), tuple(notes), versions, _is_as_released(lesson, code))


def _is_as_released(lesson: Lesson, code: Iterable[str]) -> bool:
    """Whether code cells are those that were released, behind a first one of any kind.

    That one brings the tools, and is another in the form for Colab. Whatever it defines beside
    them, the stubs below undo.
    """
    given = [cell.source.strip() for cell in given_cells(lesson) if cell.kind == "code"]
    return [source.strip() for source in code if source.strip()][1:] == given[1:]


def lesson_name_in(handed_in: HandedIn) -> str:
    """What lesson a notebook says it is, read in a process of its own; see `prepare_to_judge`."""
    return apart(handed_in.name, lambda: handed_in.notebook().lesson_name)


def prepare_to_show(handed_in: HandedIn, lesson: Lesson) -> Prepared:
    """The same as `prepare`; of a file in which nothing can be read, a notebook without answers."""
    try:
        return prepare(handed_in, lesson)
    except UnreadableNotebook as error:
        return _with_answers(lesson, WrittenAnswer(""), error)


def prepare_without(handed_in: HandedIn, lesson: Lesson, error: TooCostly) -> Prepared:
    """A notebook that took too much: nothing of it is shown, and a person looks for answers."""
    file = hashlib.sha256(handed_in.data).hexdigest()[:12]  # a mark is for what was read
    text = f"*This notebook is too much to show. Look for the answer in the file itself ({file}).*"
    return _with_answers(lesson, WrittenAnswer(text), error)


def _with_answers(lesson: Lesson, answer: WrittenAnswer, error: UnreadableNotebook) -> Prepared:
    return Prepared(lesson, (), {}, dict.fromkeys(_by_hand(lesson), answer), (str(error),))


def _reading(draft: _Draft) -> Iterator[str]:
    """The file: its name, its encoding, what stands behind it, where it breaks off."""
    yield from draft.handed_in.notes
    yield from draft.notebook.mended


def _retyped(draft: _Draft) -> Iterator[str]:
    """Solutions in cells that became Markdown or raw by a slip of the keyboard.

    What stands as code ran in the student's notebook, so it counts further on: a text cell that
    holds some of it, too, beside what stands nowhere else, is moved before it.
    """
    names, by_hand = _functions(draft.lesson), _by_hand(draft.lesson)
    orders: list[float] = list(range(len(draft.cells)))  # by which the cells stand in the end
    # The cell in which each function is written last, in that order.
    last = {name: all_of[-1] for name in names if (all_of := _answers_to(draft, name))}
    turned = []
    for place, cell in enumerate(draft.cells):
        if cell.kind == "code" or cell.grade_id in by_hand or "```" in cell.source:
            continue
        holds = [name for name in names if _defines(cell, name)]
        wanted = [
            name
            for name in holds
            if name not in last or (name == cell.grade_id and last[name] < place)
        ]
        if not wanted:
            continue
        counts = [orders[last[name]] for name in holds if name not in wanted]
        just_before = [math.nextafter(order, -math.inf) for order in counts]
        orders[place] = min([orders[place], *just_before])
        for name in holds:
            last[name] = max(place, last.get(name, place), key=orders.__getitem__)
        draft.cells[place] = dataclasses.replace(cell, kind="code")
        turned.append((cell.kind, place, holds))
    in_order = sorted(range(len(orders)), key=orders.__getitem__)
    draft.cells = [draft.cells[place] for place in in_order]
    for kind, place, holds in turned:
        judged = [name for name in holds if last[name] == place]
        if judged:
            yield _on_retyped(kind, judged, [name for name in holds if name not in judged])


def _on_retyped(kind: str, judged: list[str], others: list[str]) -> str:
    """What is said of a text cell with functions that were judged, and others that were not."""
    cell = {"markdown": "a text cell", "raw": "a raw cell"}[kind]
    it, was = ("it", "It was") if len(judged) == 1 else ("them", "They were")
    are, those = ("was", "the one in another cell") if len(others) == 1 else ("were", "others")
    names, more = " and ".join(judged), " and ".join(others)
    return (
        f"{names} stood in {cell}, where Jupyter does not run {it}. {was} judged as code. "
        + (f"{more} in that cell {are} not judged, but {those}. " if others else "")
        + "In Jupyter, select the cell and press Y to make it code again"
        + (f", and delete {more} in it." if others else ".")
    )


def _stubs_behind(draft: _Draft) -> Iterator[str]:
    """The cell as it was given out, pasted again behind the answer: it would undo it."""
    for name in _functions(draft.lesson):
        places, answers = _cells_that_define(draft, name), _answers_to(draft, name)
        if answers and places[-1] > answers[-1]:
            for place in (place for place in places if place > answers[-1]):
                draft.cells[place] = Cell("code", "# Left out: the cell as it was given out.")
            yield (
                f"Below your {name} stands the cell as it was given out, which undoes it when the "
                f"notebook runs. Your {name} was judged, and that cell left out. Delete it."
            )


def _graded_cells(draft: _Draft) -> Iterator[str]:
    """Which cell stands for each graded one: copied, moved, split, or without its metadata."""
    for name in _functions(draft.lesson):
        marked = {
            place: cell
            for place, cell in enumerate(draft.cells)
            if cell.kind == "code" and cell.grade_id == name
        }
        written = _cells_that_define(draft, name)
        both = [place for place in written if place in marked]
        found = both or written or [*marked]
        if found:
            draft.graded[name] = found[-1]
    return ()


def _another_lesson(draft: _Draft) -> Iterator[str]:
    """The notebook of another lesson under this one's name, or one without any code."""
    lesson = draft.lesson
    if any(_cells_that_define(draft, name) for name in _functions(lesson)):
        return
    claimed = draft.notebook.lesson_name
    if claimed and claimed != lesson.name:
        yield (
            f"{draft.handed_in.name} holds the notebook of {claimed[:60]}, and nothing of "
            f"{lesson.name}. Hand in {lesson.name}.ipynb."
        )
    elif not any(cell.kind == "code" and cell.source.strip() for cell in draft.cells):
        yield (
            f"There is no code in {draft.handed_in.name}. Open the notebook you worked in, save "
            "it, and hand that file in."
        )


def _modules(draft: _Draft) -> Iterator[str]:
    """Modules handed in beside the notebook, of which it imports some."""
    text = "\n".join(cell.source for cell in draft.cells if cell.kind == "code")
    used = [
        name
        for name in draft.handed_in.modules
        if re.search(rf"^[ \t]*(?:import|from)[ \t]+{name}\b", text, re.MULTILINE)
    ]
    if used:
        files = ", ".join(f"{name}.py" for name in used)
        yield f"{files}, handed in beside the notebook, {'was' if len(used) == 1 else 'were'} used."


def _written_answers(draft: _Draft) -> Iterator[str]:
    """What was written for a person to read: in its cell, or in a new one below it."""
    released = [cell.source.split() for cell in given_cells(draft.lesson)]
    moved = set()
    for name in _by_hand(draft.lesson):
        stub = _given(draft.lesson)[name]
        own = [place for place, cell in enumerate(draft.cells) if cell.grade_id == name]
        before = _place_before(draft, name)
        if not own and before is not None and _is_like(draft, before + 1, stub):
            own = [before + 1]  # as it was given out, but for its metadata
        filled = [
            place
            for place in own
            if draft.cells[place].source.split() not in ([], stub.source.split())
        ]
        if filled:
            draft.graded[name] = filled[0]
            texts = [_as_text(draft.cells[place]) for place in filled]
            moved.update(filled[1:])
            if any(draft.cells[place].kind == "code" for place in filled):
                yield (
                    f"The answer for {name} stood in a code cell. It was taken for text. In "
                    "Jupyter, select the cell and press M to make it text again."
                )
        else:
            begin = own[0] if own else before
            below = [] if begin is None else list(_new_text(draft, begin, released))
            texts = [draft.cells[place] for place in below]
            if own:
                draft.graded[name] = own[0]
                moved.update(below)
            elif below:
                draft.graded[name] = below[0]
                moved.update(below[1:])
            if texts:
                yield (
                    f"The answer for {name} was not in its own cell but in "
                    f"{'one' if len(texts) == 1 else f'{len(texts)} cells'} of its own below. It "
                    "was carried over."
                )
        text = "\n\n".join(cell.source for cell in texts)
        pictures = {key: value for cell in texts for key, value in cell.attachments.items()}
        certain = bool(text) or bool(own) or not _stray_text(draft, released)
        if not certain:
            yield (
                f"The cell for {name} is missing, and there is text elsewhere that may be the "
                "answer. Somebody will look for it."
            )
        draft.answers[name] = WrittenAnswer(text, certain, pictures)
    _drop(draft, moved)


def _as_text(cell: Cell) -> Cell:
    """What was written in a cell; comments of code would be headings in a text."""
    lines = [line for line in cell.source.splitlines() if line.strip()]
    if cell.kind != "code" or not all(line.startswith("#") for line in lines):
        return cell
    text = re.sub(r"^#+ ?", "", cell.source, flags=re.MULTILINE)
    return dataclasses.replace(cell, source=text)


# What a notebook goes through. The order matters: what is code is known before answers are
# looked for.
STEPS: tuple[Callable[[_Draft], Iterable[str]], ...] = (
    _reading,
    _retyped,
    _stubs_behind,
    _another_lesson,
    _modules,
    _graded_cells,
    _written_answers,
)


def _versions(draft: _Draft) -> dict[str, str]:
    """A sentence on each exercise of which there are several versions."""
    found = {}
    numbers = list(itertools.accumulate(int(cell.kind == "code") for cell in draft.cells))
    for name in _functions(draft.lesson):
        places = _cells_that_define(draft, name)
        stub = _given(draft.lesson).get(name)
        texts = {draft.cells[place].source for place in places}
        if stub is not None:
            texts.discard(stub.source)
        if len(texts) > 1:
            *some, last = (numbers[place] for place in places)
            listed = ", ".join(map(str, some[:4])) + (", …" if len(some) > 4 else "")
            found[name] = (
                f"{name} is written {len(places)} times, in code cells {listed} and {last}. The "
                "last one counts, as it does when the notebook runs from top to bottom. Keep one."
            )
    return found


def _new_text(draft: _Draft, begin: int, released: list[list[str]]) -> Iterator[int]:
    """Places of the text cells of the student's own from a place to the next released cell."""
    for place in range(begin + 1, len(draft.cells)):
        cell = draft.cells[place]
        if cell.grade_id or (cell.source.split() in released and cell.source.strip()):
            return
        if cell.kind != "code" and cell.source.strip():
            yield place


def _place_before(draft: _Draft, name: str) -> int | None:
    """Where the released cell before a graded one stands in the student's notebook."""
    given = given_cells(draft.lesson)
    at = next(place for place, cell in enumerate(given) if cell.grade_id == name)
    prompt = given[at - 1].source.split() if at else None
    places = [place for place, cell in enumerate(draft.cells) if cell.source.split() == prompt]
    return places[-1] if places else None


def _is_like(draft: _Draft, place: int, cell: Cell) -> bool:
    return place < len(draft.cells) and draft.cells[place].source.split() == cell.source.split()


def _stray_text(draft: _Draft, released: list[list[str]]) -> bool:
    return any(
        cell.kind != "code" and cell.source.split() not in [[], *released] for cell in draft.cells
    )


def _drop(draft: _Draft, places: set[int]) -> None:
    """Take cells out, and keep count of where the others stand."""
    kept = [place for place in range(len(draft.cells)) if place not in places]
    draft.cells = [draft.cells[place] for place in kept]
    new = {old: place for place, old in enumerate(kept)}
    draft.graded = {name: new[place] for name, place in draft.graded.items()}


def _defines(cell: Cell, name: str) -> bool:
    """Whether a cell binds a name at its left margin."""
    if name not in cell.source:
        return False
    pattern = rf"^(?:def[ \t]+{name}[ \t]*\(|{name}[ \t]*=)"
    return bool(re.search(pattern, cell.source, re.MULTILINE))


def _cells_that_define(draft: _Draft, name: str) -> list[int]:
    return [
        place
        for place, cell in enumerate(draft.cells)
        if cell.kind == "code" and _defines(cell, name)
    ]


def _answers_to(draft: _Draft, name: str) -> list[int]:
    """Cells that define a function, but for those as they were given out."""
    given = _given(draft.lesson).get(name)
    stub = given.source.split() if given else None
    places = _cells_that_define(draft, name)
    return [place for place in places if draft.cells[place].source.split() != stub]


def _functions(lesson: Lesson) -> list[str]:
    return [exercise.name for exercise in lesson.machine_graded]


def _by_hand(lesson: Lesson) -> list[str]:
    return [exercise.cell for exercise in lesson.exercises if exercise.by_hand]


@functools.cache
def given_cells(lesson: Lesson) -> tuple[Cell, ...]:
    """The cells of a lesson as it was released."""
    return tuple(
        Cell(
            cell["cell_type"],
            "".join(cell["source"]),
            cell["metadata"].get("nbgrader", {}).get("grade_id", ""),
        )
        for cell in json.loads(lesson.released.read_text("utf-8"))["cells"]
    )


def _given(lesson: Lesson) -> dict[str, Cell]:
    return {cell.grade_id: cell for cell in given_cells(lesson) if cell.grade_id}
