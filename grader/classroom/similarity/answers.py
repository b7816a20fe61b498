"""Extract the functions that students wrote from their submissions."""

from __future__ import annotations

import ast
import dataclasses
import functools
import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from grader.classroom.similarity.normal_form import NormalStatement, steps_of
from grader.course.kept_answers import ANOTHER_CELL, answers_to
from grader.course.lessons import Lesson, all_lessons
from grader.intake.preflight import prepare
from grader.intake.reader_process import run_in_child
from grader.intake.submission import SubmittedFiles
from utils.notebooks import slicing

# Real answers are far below both limits. Longer answers could not be compared by eye.
MAX_STEPS = 1000
MAX_CHARACTERS = 50_000


@dataclass(frozen=True)
class ComparedAnswer:
    """A student's function, with the other statements that it needs.

    Attributes
    ----------
    text : str
        The source of these statements, as in the notebook.
    steps : tuple of NormalStatement
        The statements in normal form, with their lines in `text`.
    code : str
        A digest of the code without comments and layout.
    """

    text: str
    steps: tuple[NormalStatement, ...]
    code: str


@dataclass(frozen=True)
class NotebookParts:
    """The parts of a notebook that are compared.

    Attributes
    ----------
    answers : dict of str to ComparedAnswer
        The student's answers, by exercise.
    cells : str
        A digest of the text in the cells; empty for an unchanged notebook.
    own_cells, all_cells : int
        The number of cells that differ from the release, and the total number of cells.
    problems : tuple of str
        One sentence for each exercise that cannot be compared.
    """

    answers: dict[str, ComparedAnswer] = dataclasses.field(hash=False)
    cells: str
    own_cells: int
    all_cells: int
    problems: tuple[str, ...]


def read_notebook_parts(submitted_files: SubmittedFiles, lesson: Lesson) -> NotebookParts:
    """Read a submission in a separate process, without running its code.

    Raises
    ------
    utils.notebooks.reading.UnreadableNotebook
    grader.intake.reader_process.ReadingFailed
    """
    _released_statements(lesson)  # cached here, so that child processes inherit the result

    def work() -> dict:
        # The compared code is the judged code, after repairs. The digest covers the submitted
        # cells, because repairs could make equal notebooks differ.
        prepared = prepare(submitted_files, lesson)
        modules = {**submitted_files.modules, **prepared.modules}
        cells = [(cell.kind, cell.source.rstrip()) for cell in submitted_files.notebook().cells]
        own = Counter(cells) - Counter(released_cells(lesson))
        answers, problems = answers_in([*modules.values(), *prepared.code], lesson)
        return {
            "answers": {name: dataclasses.asdict(answer) for name, answer in answers.items()},
            "cells": _digest(json.dumps(cells)) if own else "",
            "own_cells": own.total(),
            "all_cells": len(cells),
            "problems": problems,
        }

    read = run_in_child(submitted_files.name, work)
    answers = {name: _from_json(answer) for name, answer in read["answers"].items()}
    return NotebookParts(**{**read, "answers": answers, "problems": tuple(read["problems"])})


def _from_json(answer: dict) -> ComparedAnswer:
    steps = (
        NormalStatement(tuple(step["words"]), step["first"], step["last"])
        for step in answer["steps"]
    )
    return ComparedAnswer(answer["text"], tuple(steps), answer["code"])


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogatepass")).hexdigest()


def answers_in(code: Iterable[str], lesson: Lesson) -> tuple[dict[str, ComparedAnswer], list[str]]:
    """Return the answers in code cells, and a sentence about each that cannot be compared."""
    released_sources = {source for _, source in released_cells(lesson)}
    code = [source for source in code if source.rstrip() not in released_sources]
    released, imported = _released_statements(lesson)
    own_statements = [
        part for part in slicing.parse_notebook(code)[0] if _dump(part.node) not in released
    ]
    known_names = {**imported, **_imported_names(own_statements), **_given_names(lesson)}
    answers, problems = {}, []
    for name in (exercise.name for exercise in lesson.machine_graded):
        try:
            answer = _extract_answer(name, own_statements, code, known_names, lesson)
        except RecursionError:
            problems.append(f"{name} is nested too deeply to be compared.")
            continue
        if len(answer.steps) > MAX_STEPS or len(answer.text) > MAX_CHARACTERS:
            problems.append(f"{name} is too long to be compared.")
        elif answer.steps:
            answers[name] = answer
    return answers, problems


def _extract_answer(
    name: str,
    needed_statements: list,
    code: list[str],
    known_names: Mapping[str, str],
    lesson: Lesson,
) -> ComparedAnswer:
    # If the student has rewritten the given class, the answer is in the student's class.
    names = (
        [name]
        if any(name in part.binds for part in needed_statements)
        else list(lesson.header.given)
    )
    others = _exercise_names() - {name}
    lines, steps, nodes = [], [], []
    for statement in slicing.slice_for(names, needed_statements):
        node = statement.node
        if statement.binds & others or isinstance(node, (ast.Import, ast.ImportFrom)):
            continue
        decorators = getattr(node, "decorator_list", [])
        first = min([node.lineno, *(decorator.lineno for decorator in decorators)])
        offset = len(lines) + 1 - first
        lines += [*code[statement.cell - 1].split("\n")[first - 1 : node.end_lineno], ""]
        is_exercise = getattr(node, "name", "") == name and hasattr(node, "args")
        parameters = (
            [argument.arg for argument in node.args.posonlyargs + node.args.args]
            if is_exercise
            else []
        )
        steps += [
            dataclasses.replace(step, first=step.first + offset, last=step.last + offset)
            for step in steps_of(node, known_names, parameters)
        ]
        nodes.append(ast.dump(node))
    return ComparedAnswer("\n".join(lines).rstrip(), tuple(steps), _digest("\n".join(nodes)))


def _dump(node: ast.AST) -> str:
    try:
        return ast.dump(node)
    except RecursionError:
        return ""


def _imported_names(statements: Iterable[slicing.Statement]) -> dict[str, str]:
    """Return the qualified name of each name that a notebook imports."""
    qualified_names = {}
    for statement in statements:
        for node in ast.walk(statement.node):
            if isinstance(node, ast.Import):
                for alias in node.names:
                    module = alias.name if alias.asname else alias.name.split(".")[0]
                    qualified_names[alias.asname or module] = module
            elif isinstance(node, ast.ImportFrom):
                for alias in node.names:
                    qualified_names[alias.asname or alias.name] = (
                        f"{node.module or ''}.{alias.name}"
                    )
    return qualified_names


@functools.cache
def _exercise_names() -> frozenset[str]:
    return frozenset(exercise.name for lesson in all_lessons() for exercise in lesson.exercises)


def _given_names(lesson: Lesson) -> dict[str, str]:
    """Return the names of exercises and given functions, which the student did not choose."""
    return {name: name for name in (*_exercise_names(), *lesson.header.given)}


@functools.cache
def released_cells(lesson: Lesson) -> tuple[tuple[str, str], ...]:
    """Return the kind and the source of each released cell."""
    cells = json.loads(lesson.released.read_text("utf-8"))["cells"]
    return tuple((cell["cell_type"], "".join(cell["source"]).rstrip()) for cell in cells)


@functools.cache
def _released_statements(lesson: Lesson) -> tuple[frozenset[str], dict[str, str]]:
    """Return the released statements, and the qualified names of their imports."""
    code = [source for kind, source in released_cells(lesson) if kind == "code"]
    statements, _ = slicing.parse_notebook(code)
    return frozenset(_dump(statement.node) for statement in statements), _imported_names(statements)


@functools.cache
def kept_answers(lesson: Lesson) -> dict[str, tuple[ComparedAnswer, ...]]:
    """Return the course's right answers by exercise. Each counts as the work of another author."""
    return {
        exercise.name: tuple(
            answer
            for variant in answers_to(exercise.name)
            if variant.right
            for answer in [_kept_answer(lesson, exercise.name, variant.source)]
            if answer
        )
        for exercise in lesson.machine_graded
    }


@functools.cache
def suggested_answers(lesson: Lesson) -> dict[str, tuple[ComparedAnswer, ...]]:
    """Return the answers that the lesson's solution and hints suggest, by exercise."""
    solved, _ = answers_in([lesson.text], lesson)
    suggestions = {}
    for exercise in lesson.machine_graded:
        hints = [
            _kept_answer(lesson, exercise.name, variant.source)
            for variant in answers_to(exercise.name)
            if variant.follows_hints
        ]
        suggestions[exercise.name] = tuple(filter(None, [solved.get(exercise.name), *hints]))
    return suggestions


def _kept_answer(lesson: Lesson, exercise: str, source: str) -> ComparedAnswer | None:
    answers, _ = answers_in(source.split(ANOTHER_CELL), lesson)
    return answers.get(exercise)
